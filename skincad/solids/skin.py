"""The skin: its section swept along y."""

from __future__ import annotations

from typing import TYPE_CHECKING

from skincad.curves import flipped
from skincad.design import Design
from skincad.section import section
from skincad.solids.plan import Part, Prism

if TYPE_CHECKING:
    import cadquery as cq

COLOUR = (0.93, 0.72, 0.62)


def skin_part(design: Design) -> Part:
    """Return the skin as designed: back at z = 0, ridges up, -length/2 to length/2 along y."""
    shape, half = section(design), design.skin.length / 2
    slots = tuple(s.loop() for s in shape.slots)
    return Part("skin", COLOUR, "cast", Prism(shape.outline, "y", -half, half, slots))


def cast_skin(design: Design) -> Part:
    """Return the skin as it lies in its mold, ridges down."""
    shape, half = section(design), design.skin.length / 2
    slots = tuple(flipped(s.loop()) for s in shape.slots)
    return Part("skin", COLOUR, "cast", Prism(flipped(shape.outline), "y", -half, half, slots))


def skin_solid(design: Design) -> cq.Workplane:
    """Return the skin's exact solid, mm, in the design's frame; arcs are cylinders.

    Raises InputError for a section that is not valid, KernelError when the CAD kernel's solid is not valid
    or its volume is not the section's area times the length.
    """
    from skincad.solids.occ import workplane

    return workplane(skin_part(design))
