"""The silicone that a design means."""

from __future__ import annotations

import math

from skincad.base.errors import InputError
from skincad.base.tables import NumberWithRange
from skincad.inputs.design import Design
from skincad.inputs.silicone import Silicone, silicone_of, silicones


def silicone(design: Design) -> Silicone:
    """Return the silicone that a design's `[material]` means: the named one, with the design's own values on
    top, to which the modulus of a law belongs. Without a name all that `[material]` does not say is an
    assumption or, as mix and cure, unknown."""
    material = design.material
    return silicone_of(material.name, material.given, design.silicones)


def layers(design: Design) -> tuple[Silicone, ...]:
    """Return the silicones of a design's shots, from the back; the skin's own, before them, is not in it."""
    return tuple(silicone_of(shot.name, shot.given, design.silicones) for shot in design.shot or ())


def refuse_layers(design: Design, what: str) -> None:
    """Raise InputError where `what` takes a skin of one silicone and the design has shots."""
    if design.shot:
        rule = f"must not be given: {what} takes a skin of one silicone"
        raise InputError(
            "shot", rule, len(design.shot), "drop [[shot]]; check, simulate, make and package take it"
        )


def foreign_modulus(design: Design) -> tuple[Silicone, NumberWithRange, str] | None:
    """Return the silicone that `[material]` names, the modulus beside it, and what would cure it, where that
    modulus is not the named silicone's: their ranges do not meet."""
    name, material = design.material.name, design.material
    if name is None or (material.young_modulus is None and material.law is None):
        return None
    modulus = silicone(design).young_modulus
    known = silicones(design.silicones)
    if _ranges_meet(known[name].young_modulus, modulus):
        return None
    fits = {
        n: abs(math.log(s.young_modulus.value / modulus.value))
        for n, s in known.items()
        if _ranges_meet(s.young_modulus, modulus)
    }
    drop = "drop material.young_modulus or, if you measured it, drop the name"
    return (
        known[name],
        modulus,
        f"use the name {min(fits, key=fits.__getitem__)}, which it fits; or {drop}" if fits else drop,
    )


def _ranges_meet(one: NumberWithRange, other: NumberWithRange) -> bool:
    return one.low <= other.high and other.low <= one.high
