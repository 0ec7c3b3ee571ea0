"""The skin: its section swept along y, straight or turned; and a body's way as it moves."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np
import shapely

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.shape import curves
from skincad.shape.curves import Loop, Point, flipped
from skincad.shape.skin import Section, section
from skincad.solids.bone import cut_of, lifted
from skincad.solids.kind import kind_of
from skincad.solids.pins import SUNK, cast, pins, pocket_cuts
from skincad.solids.plan import (
    Axis,
    Body,
    Bore,
    CutRole,
    ExtendedCut,
    GivenBody,
    Heading,
    Part,
    PartRole,
    Prism,
    RevolvedBody,
    RotatedBody,
    TurnedBody,
    corners,
    plain,
    turned,
    unturned,
)

if TYPE_CHECKING:
    import cadquery as cq


def skin_part(design: Design) -> Part:
    """Return the skin as designed: back at z = 0, ridges up, -length/2 to length/2 along y, or round.

    With a second curvature the section is the one at y = 0, its ends are planes through the axis.
    """
    shape = section(design)
    slots = tuple(s.loop() for s in shape.slots)
    body = along_skin(design, shape.outline, slots)
    cuts: tuple[Body, ...] = (*pocket_cuts(design), *cut_of(design))
    return Part("skin", PartRole.SKIN, body, cuts, adds=pins(design, shape))


def cast_skin(design: Design, shape: Section | None = None) -> Part:
    """Return the skin as it lies in its mold, features down; of this section where it is given."""
    shape = shape or section(design)
    slots = tuple(flipped(s.loop()) for s in shape.slots)
    body = along_skin(design, flipped(shape.outline), slots, -1.0)
    adds = tuple(cast(pin) for pin in pins(design, shape))
    cuts: tuple[Body, ...] = (*pocket_cuts(design, -1.0), *cut_of(design, -1.0))
    return Part("skin", PartRole.SKIN, body, cuts, adds=adds)


def along_skin(
    design: Design, outline: Loop, holes: tuple[Loop, ...], up: float = 1.0
) -> Prism | RevolvedBody | TurnedBody:
    """Return the section's loop swept along the skin's length, `up` = -1 where the ridges point down; of a
    round skin turned about z.

    A doubly curved skin turns about the axis that lies its radius below the base circle's summit; `length` is
    the arc of that summit.
    """
    skin, half, kind = design.skin, design.skin.length / 2, kind_of(design)
    if not kind.ends:
        return TurnedBody(curves.right_half(outline), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    if not kind.leans:
        return Prism(outline, "y", -half, half, holes)
    radius = skin.radius_y
    return RevolvedBody(outline, up * (skin.thickness - radius), -half / radius, half / radius, holes)


def skin_solid(design: Design) -> cq.Workplane:
    """Return the skin's exact solid, mm, in the design's frame; arcs are cylinders, or tori and spheres.

    Raises InputError for a section that is not valid, KernelError when the CAD kernel's solid is not valid
    or its volume is not the section's area times its centroid's path.
    """
    from skincad.solids.occ import workplane

    return workplane(skin_part(design))


Way = Axis | Heading | Literal["turn"]


def swept(part: Part, axis: Way, travel: float, tolerance: float) -> Part:
    """Return a part that covers everything that `part` passes through on `travel` mm that way; rad where it
    turns about its own axis along x ("turn"). A turned part's y is its own.

    Exact (arcs within `tolerance` mm) for a part whose cuts all run through it along the axis, for a bare
    prism moved across its own axis, and for what turns about z and moves along it; elsewhere cuts are left
    out, so the swept part is never too small. Of a body that turns about x and is moved up, what counts is
    its silhouette along x. A drafted cup stays free on the way along its axis, and a core pin's hole of a
    plug. What is added to a skin follows it out of its cavity, and is left out.
    """
    body = part.body
    if isinstance(body, GivenBody) and axis == "z":
        return lifted(part, travel)
    if isinstance(body, RotatedBody):
        path = swept(unturned(part), axis, travel, tolerance)
        return turned(path, body.centre, body.angle, body.base)
    if isinstance(body, TurnedBody) and axis == "z" and body.direction[:2] == (0.0, 0.0):
        rise = 0.0, travel * body.direction[2]
        shadow = _shadow(curves.polygon(body.outline, tolerance), rise)
        return replace(part, body=replace(body, outline=shadow, buried=0.0), cuts=(), adds=())
    if body.axis == axis:
        cuts = tuple(_stretched(c, travel) for c in part.cuts if _through(c, body))
        cuts = (*cuts, *_past_pins(part, axis, _ends(body), travel))
        return replace(part, body=_stretched(body, travel), cuts=cuts, adds=())
    heading = {"z": (0.0, 1.0)}.get(axis) if isinstance(axis, str) else axis
    flat = _as_prism(body, tolerance)
    if flat is None or flat.axis == "z" or heading is None or (flat.axis == "x" and axis != "z"):
        rule = "a pin moves along its axis only, a prism along it or up, down or aside; a pin along y as well"
        raise ValueError(f"{part.name}: {rule}")
    way = heading[0] * travel, heading[1] * travel
    shadow = _shadow(corners(flat, flat.outline, tolerance), way)
    cups = tuple(cut for cut in part.cuts if axis == "z" and _frees(cut, travel))
    heights = [point.z for segment in shadow for point in (segment.start, segment.end)]
    cups = (*cups, *_past_pins(part, axis, (min(heights), max(heights)), 0.0))
    return replace(part, body=replace(flat, outline=shadow, holes=()), cuts=cups, adds=())


def _past_pins(part: Part, axis: Way, ends: tuple[float, float], travel: float) -> Iterator[Bore]:
    """The holes of a plug that slide over core pins as it moves along z, through all that it passes."""
    low, high = min(ends[0], ends[0] + travel) - SUNK, max(ends[1], ends[1] + travel) + SUNK
    for cut in part.cuts if axis == "z" and part.role is PartRole.PLUG else ():
        if cut.role is CutRole.CORE and isinstance(bore := plain(cut), Bore):
            yield replace(bore, start=(*bore.start[:2], low), length=high - low)


def _as_prism(body: Body, tolerance: float) -> Prism | None:
    """A round pin along y as a prism, and what turns as its silhouette; None where a body is no prism."""
    if isinstance(body, Bore) and body.axis == "y" and body.end_radius is None:
        (x, low, z) = body.start
        return Prism(curves.circle(x, z, body.radius), "y", low, low + body.length)
    if isinstance(body, RevolvedBody) and body.grid:
        points = curves.polygon(body.outline, tolerance / 2)
        (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
        angles = body.grid.angles(body.low, body.high, tolerance)
        arcs = [[body.placed(np.array([[0.0, z]]), a)[0, 1:] for a in angles] for z in (low, high)]
        ring = curves.loop([Point(y, z) for y, z in (*arcs[0], *arcs[1][::-1])])
        return Prism(ring, "x", left, right)
    return body if isinstance(body, Prism) else None


def _through(cut: Body, body: Body) -> bool:
    """Whether a cut keeps its section all through a body: what a blind one leaves open, the rest covers."""
    if cut.axis != body.axis or (isinstance(cut, Bore) and cut.end_radius):
        return False
    return _ends(cut) == _ends(body)


def _frees(cut: Body, travel: float) -> bool:
    """Whether a cut is a cup along z, nowhere wider than nearer its mouth, that moves off by `travel` mm."""
    return (
        isinstance(cut, TurnedBody)
        and travel * cut.direction[2] > 0
        and cut.direction[:2] == (0.0, 0.0)
        and all(s.end.x <= s.start.x for s in cut.outline if s.end.z > s.start.z)
    )


def _ends(body: Body) -> tuple[float, float]:
    """Where a body begins and ends along its axis, mm."""
    own_body = plain(body)
    if isinstance(own_body, Bore):
        low = own_body.start[1 if own_body.axis == "y" else 2]
        return low, low + own_body.length
    if isinstance(own_body, TurnedBody | GivenBody):
        return -math.inf, math.inf
    return own_body.low, own_body.high


def _stretched(body: Body, travel: float) -> Body:
    if isinstance(body, RotatedBody | ExtendedCut | TurnedBody | GivenBody):
        raise ValueError("a turned body is moved in its own frame")
    if isinstance(body, Prism | RevolvedBody):
        return replace(body, low=body.low + min(travel, 0.0), high=body.high + max(travel, 0.0))
    x, y, z = body.start
    back = min(travel, 0.0)
    start = (x, y + back, z) if body.axis == "y" else (x, y, z + back)
    return replace(body, start=start, length=body.length + abs(travel))


def _shadow(points: Array, way: Heading) -> Loop:
    """Outline of everything that a polygon `(n, 2)` mm covers while it moves by `way` mm."""
    quads = [
        shapely.Polygon([a, b, b + way, a + way])
        for a, b in zip(points, np.roll(points, -1, axis=0), strict=True)
        if (b[0] - a[0]) * way[1] != (b[1] - a[1]) * way[0]
    ]
    covered = shapely.orient_polygons(shapely.union_all([shapely.Polygon(points), *quads]))
    return curves.loop([Point(x, z) for x, z in covered.exterior.coords[:-1]])
