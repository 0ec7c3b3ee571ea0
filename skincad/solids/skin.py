"""The skin: its section swept along y, straight or turned about an axis along x."""

from __future__ import annotations

from typing import TYPE_CHECKING

from skincad.inputs.design import Design
from skincad.shape.curves import Loop, flipped
from skincad.shape.skin import Section, section
from skincad.solids.body import Prism, RevolvedBody
from skincad.solids.plan import Part
from skincad.solids.roles import PartRole

if TYPE_CHECKING:
    import cadquery as cq


def skin_part(design: Design) -> Part:
    """Return the skin as designed: back at z = 0, ridges up, -length/2 to length/2 along y.

    With a second curvature the section is the one at y = 0, its ends are planes through the axis.
    """
    shape = section(design)
    slots = tuple(s.loop() for s in shape.slots)
    return Part("skin", PartRole.SKIN, along_skin(design, shape.outline, slots))


def cast_skin(design: Design, shape: Section | None = None) -> Part:
    """Return the skin as it lies in its mold, ridges down; of this section where it is given."""
    shape = shape or section(design)
    slots = tuple(flipped(s.loop()) for s in shape.slots)
    return Part("skin", PartRole.SKIN, along_skin(design, flipped(shape.outline), slots, -1.0))


def along_skin(
    design: Design, outline: Loop, holes: tuple[Loop, ...], up: float = 1.0
) -> Prism | RevolvedBody:
    """Return a loop swept along the skin's length, `up` = -1 where the ridges point down.

    A doubly curved skin turns about the axis curvature_radius_y below the base circle's summit; `length` is
    the arc of that summit.
    """
    skin, half = design.skin, design.skin.length / 2
    radius = skin.curvature_radius_y
    if radius is None:
        return Prism(outline, "y", -half, half, holes)
    return RevolvedBody(outline, up * (skin.thickness - radius), -half / radius, half / radius, holes)


def skin_solid(design: Design) -> cq.Workplane:
    """Return the skin's exact solid, mm, in the design's frame; arcs are cylinders, or tori and spheres.

    Raises InputError for a section that is not valid, KernelError when the CAD kernel's solid is not valid
    or its volume is not the section's area times its centroid's path.
    """
    from skincad.solids.occ import workplane

    return workplane(skin_part(design))
