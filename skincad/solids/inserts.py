"""What lies in the mold while it is poured and is no part of it: shims, and the pins that locate it."""

from __future__ import annotations

from skincad.curves import flipped
from skincad.design import Design
from skincad.section import section
from skincad.solids.plan import Bore, Part, Prism, Vector

STEEL = (0.62, 0.65, 0.70)
PIN_RADIUS = 1.0  # mm, source: ISO 2338 dowel pin, 2 mm
GRIP = 6.0  # mm, assumption: what pliers hold of a shim beyond the end plates


def shims(design: Design) -> list[Part]:
    """Return a shim for every slot: the slot's rectangle, through both end plates, with a grip at +y."""
    half = design.skin.length / 2 + design.mold.end_plate
    return [
        Part(
            f"shim-{slot.ridge}-{slot.side}",
            STEEL,
            "bought",
            Prism(flipped(slot.loop()), "y", -half, half + GRIP),
        )
        for slot in section(design).slots
    ]


def pin(name: str, start: Vector, axis: str, length: float) -> Part:
    """Return a dowel pin from `start` along +axis."""
    return Part(name, STEEL, "bought", Bore(start, "y" if axis == "y" else "z", length, PIN_RADIUS))
