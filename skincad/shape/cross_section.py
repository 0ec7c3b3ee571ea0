"""The skin's exact cross-section: one closed outline of lines and arcs, and the slots in it.

In the plane (x, z), mm: flat back at z = 0, ridges up, the material on the left of every segment.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Literal

import numpy as np
import shapely

from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.shape.curves import Kind, Loop, Point, Segment, area, loop, moments, polygon
from skincad.shape.half_ridge import HalfRidge, half_ridge

CONTACT_KINDS: tuple[Kind, ...] = ("tip_fillet", "crown")
MOLDABLE_WALL = 0.04  # mm, assumption: a thinner silicone membrane tears when the shim is drawn
GUARD_TOLERANCE = 1e-5  # mm, chord tolerance of the polygons that the guards judge


@dataclass(frozen=True)
class Frame:
    """A ridge's own frame: t along the base circle towards +x, n outward."""

    origin: Point
    tangent: Point
    normal: Point

    def at(self, t: float, n: float) -> Point:
        """Return the section's point at (t, n) mm."""
        return Point(
            self.origin.x + t * self.tangent.x + n * self.normal.x,
            self.origin.z + t * self.tangent.z + n * self.normal.z,
        )


@dataclass(frozen=True)
class SlotPlace:
    """One slot of the section, as wide as what is drawn out of it or cast into it: `direction` is the unit
    vector along its depth, outward."""

    ridge: int
    side: Literal["S1", "S2"]
    centre: Point
    direction: Point
    depth: float
    thickness: float

    @property
    def across(self) -> Point:
        """Unit vector across the slot, which is the film's normal, towards +x for an upright slot."""
        return Point(self.direction.z, -self.direction.x)

    def at(self, across: float, along: float) -> Point:
        """Return the section's point at these distances from the slot's centre, mm."""
        return Point(
            self.centre.x + across * self.across.x + along * self.direction.x,
            self.centre.z + across * self.across.z + along * self.direction.z,
        )

    def loop(self, thickness: float | None = None, grown: float = 0.0) -> Loop:
        """Return the slot's outline, counterclockwise; or a strip of `thickness` mm in its middle, or
        either `grown` by a clearance a side."""
        a, b = (thickness or self.thickness) / 2 + grown, self.depth / 2 + grown
        return loop([self.at(-a, -b), self.at(a, -b), self.at(a, b), self.at(-a, b)], "slot", self.ridge)


@dataclass(frozen=True)
class Section:
    """The skin's section: outline counterclockwise, and the slots in it."""

    outline: Loop
    slots: tuple[SlotPlace, ...] = ()

    @cached_property
    def area(self) -> float:
        """Area of the material, mm2: outline less slots."""
        return area(self.outline) - math.fsum(area(s.loop()) for s in self.slots)

    @cached_property
    def centroid(self) -> Point:
        """Centroid of the material, mm."""
        rows = np.array([moments(self.outline), *([-m for m in moments(s.loop())] for s in self.slots)])
        total = rows.sum(axis=0)
        return Point(float(total[1] / total[0]), float(total[2] / total[0]))

    @cached_property
    def top(self) -> float:
        """Largest z of the outline, mm, exact."""
        return max(segment.top for segment in self.outline)


def frame(design: Design, ridge: int) -> Frame:
    """Return the frame of a ridge, counted from 1 at the smallest x."""
    lean, radius = design.lean(ridge), design.skin.curvature_radius
    sine, cosine = math.sin(lean), math.cos(lean)
    origin = Point(radius * sine, design.skin.thickness - 2 * radius * math.sin(lean / 2) ** 2)
    return Frame(origin, Point(cosine, -sine), Point(sine, cosine))


@lru_cache(maxsize=32)
def section(design: Design) -> Section:
    """Return the design's section, guarded.

    Raises InputError when fillets do not fit, when the outline is not simple, or when a slot leaves it
    or leaves too thin a wall. Valid for curvature radii up to 1e8 mm.
    """
    halves = _halves(design)
    slots = tuple(_slots(design))
    result = Section(tuple(_outline(design, halves)), slots)
    _guard(result, design)
    return result


def _halves(design: Design) -> tuple[HalfRidge, ...]:
    """Half of each ridge, ridge 1 first; InputError where one has no shape, or neighbours no room."""
    known: dict[float, HalfRidge] = {}
    for ridge, height in enumerate(design.heights, 1):
        if height not in known:
            try:
                known[height] = half_ridge(design, height)
            except InputError as broken:
                if not design.uneven:
                    raise
                where = f"ridge {ridge}, {height:g} mm high: {broken.rule}"
                raise InputError(broken.key, where, broken.value, broken.remedy) from None
    halves = tuple(known[height] for height in design.heights)
    pitch, fillet = design.ridge.spacing, design.ridge.root_fillet
    for ridge, (left, right) in enumerate(pairwise(halves) if halves[1:] else [halves * 2], 1):
        if left.base[0] + right.base[0] > pitch:
            where = f" at ridges {ridge} and {ridge + 1}" if design.uneven else ""
            rule = (
                f"neighbouring root fillets overlap by {left.base[0] + right.base[0] - pitch:.4g} mm{where}"
            )
            raise InputError("ridge.root_fillet", rule, fillet, "take a smaller fillet or a larger pitch")
    return halves


def _fillet_bulge(p: tuple[float, float], q: tuple[float, float], radius: float) -> float:
    chord = math.hypot(p[0] - q[0], p[1] - q[1])
    return math.tan(math.asin(min(1.0, chord / (2 * radius))) / 2) if radius else 0.0


def _outline(design: Design, halves: tuple[HalfRidge, ...]) -> Iterator[Segment]:
    """Outline from the back's left corner, counterclockwise; segments without length are left out."""
    skin, count = design.skin, design.ridge.count
    radius, x = skin.curvature_radius, skin.width / 2
    side = math.asin(x / radius)
    shoulder = skin.thickness - 2 * radius * math.sin(side / 2) ** 2
    yield Segment(Point(-x, 0.0), Point(x, 0.0), kind="back")
    yield Segment(Point(x, 0.0), Point(x, shoulder), kind="side")
    here, angle = Point(x, shoulder), side
    for ridge in range(count, 0, -1):
        half, lean, at = halves[ridge - 1], design.lean(ridge), frame(design, ridge).at
        reach = math.atan2(half.base[0], radius + half.base[1])
        there = at(*half.base)
        yield from _real(Segment(here, there, math.tan((angle - lean - reach) / 4), "base"))
        yield from _ridge(design, half, ridge)
        here, angle = at(-half.base[0], half.base[1]), lean - reach
    yield from _real(Segment(here, Point(-x, shoulder), math.tan((angle + side) / 4), "base"))
    yield Segment(Point(-x, shoulder), Point(-x, 0.0), kind="side")


def _ridge(design: Design, half: HalfRidge, ridge: int) -> Iterator[Segment]:
    at, shape = frame(design, ridge).at, design.ridge
    right = [at(*p) for p in half]
    left = [at(-t, n) for t, n in half]
    foot = _fillet_bulge(half.base, half.flank_low, shape.root_fillet)
    shoulder = _fillet_bulge(half.flank_high, half.crown, shape.tip_fillet)
    summit = (design.heights[ridge - 1] - half.crown[1]) / half.crown[0] if half.crown[0] > 0 else 0.0
    yield from _real(Segment(right[0], right[1], -foot, "root_fillet", ridge))
    yield from _real(Segment(right[1], right[2], 0.0, "flank", ridge))
    yield from _real(Segment(right[2], right[3], shoulder, "tip_fillet", ridge))
    yield from _real(Segment(right[3], left[3], summit, "crown", ridge))
    yield from _real(Segment(left[3], left[2], shoulder, "tip_fillet", ridge))
    yield from _real(Segment(left[2], left[1], 0.0, "flank", ridge))
    yield from _real(Segment(left[1], left[0], -foot, "root_fillet", ridge))


def _real(segment: Segment) -> Iterator[Segment]:
    if segment.chord > 0.0:
        yield segment


def _slots(design: Design) -> Iterator[SlotPlace]:
    if design.slot is None:
        return
    slot, tilt = design.slot, math.radians(design.slot.tilt)
    for ridge in range(1, design.ridge.count + 1):
        place = frame(design, ridge)
        for side, sign in (("S1", -1), ("S2", 1)):
            t, n = -sign * math.sin(tilt), math.cos(tilt)
            tip, origin = place.at(t, n), place.origin
            yield SlotPlace(
                ridge,
                "S1" if side == "S1" else "S2",
                place.at(sign * slot.offset, slot.elevation),
                Point(tip.x - origin.x, tip.z - origin.z),
                slot.depth,
                design.core_thickness,
            )


def _guard(result: Section, design: Design) -> None:
    """Judge the whole section on its polygons: simple, slots inside, walls and webs thick enough."""
    body = shapely.Polygon(polygon(result.outline, GUARD_TOLERANCE))
    if not body.is_valid:
        raise InputError(
            "ridge",
            f"the outline crosses itself ({shapely.is_valid_reason(body)})",
            remedy="move ridges apart",
        )
    if not result.slots:
        return
    slots = [shapely.Polygon(polygon(s.loop(), GUARD_TOLERANCE)) for s in result.slots]
    outside = [s for s, shape in zip(result.slots, slots, strict=True) if not body.contains(shape)]
    if outside:
        raise InputError(
            "slot",
            f"must lie inside the outline; {outside[0].side} of ridge {outside[0].ridge} crosses it",
            design.slot and f"offset {design.slot.offset:g}, elevation {design.slot.elevation:g} mm",
            "reduce offset, depth or elevation",
        )
    walls = [float(body.exterior.distance(shape)) for shape in slots]
    wall = min(walls)
    thinnest = result.slots[walls.index(wall)]
    where = f" at {thinnest.side} of ridge {thinnest.ridge}" if design.uneven else ""
    tree = shapely.STRtree(slots)
    pairs = tree.query(slots, predicate="dwithin", distance=MOLDABLE_WALL)
    close = pairs[:, pairs[0] < pairs[1]].T
    web = min((float(slots[i].distance(slots[j])) for i, j in close), default=math.inf)
    for what, size in ((f"wall to the outline{where}", wall), ("web between slots", web)):
        if size < MOLDABLE_WALL:
            raise InputError(
                "slot.offset",
                f"leaves a {what} of {max(size, 0.0):.4g} mm; silicone needs {MOLDABLE_WALL:g} mm",
                design.slot and design.slot.offset,
                "move, turn or shorten the slots",
            )
