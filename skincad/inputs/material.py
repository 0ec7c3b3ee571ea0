"""The silicone that a design means."""

from __future__ import annotations

import math

from skincad.base.tables import Ranged
from skincad.inputs.design import Design
from skincad.inputs.silicone import Silicone, silicones


def silicone(design: Design) -> Silicone:
    """Return the silicone that a design's `[material]` means: the named one, with the design's own values on
    top. Without a name all that `[material]` does not say is an assumption or, as mix and cure, unknown."""
    material = design.material
    found = silicones(design.silicones)[material.name] if material.name else Silicone(name="own silicone")
    own = ("young_modulus", "poisson_ratio", "density")
    given = {key: getattr(material, key) for key in own if getattr(material, key) is not None}
    return found.model_copy(update=given)


def foreign_modulus(design: Design) -> tuple[Silicone, Ranged, str] | None:
    """Return the silicone that `[material]` names, the modulus beside it, and what would cure it, where that
    modulus is not the named silicone's: their ranges do not meet."""
    name, given = design.material.name, design.material.young_modulus
    if name is None or given is None:
        return None
    known = silicones(design.silicones)
    if _meet(known[name].young_modulus, given):
        return None
    fits = {
        n: abs(math.log(s.young_modulus.value / given.value))
        for n, s in known.items()
        if _meet(s.young_modulus, given)
    }
    drop = "drop material.young_modulus or, if you measured it, drop the name"
    return (
        known[name],
        given,
        f"use the name {min(fits, key=fits.__getitem__)}, which it fits; or {drop}" if fits else drop,
    )


def _meet(one: Ranged, other: Ranged) -> bool:
    return one.low <= other.high and other.low <= one.high
