"""The skin's exact cross-section: one closed outline of lines and arcs, and the slots in it.

In the plane (x, z), mm: flat back at z = 0, ridges up, the material on the left of every segment.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal, NamedTuple

import numpy as np
import shapely

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.shape.curves import Kind, Loop, Point, Segment, area, loop, moments, polygon

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
    half = _half_ridge(design)
    slots = tuple(_slots(design))
    result = Section(tuple(_outline(design, half)), slots)
    _guard(result, design)
    return result


class _HalfRidge(NamedTuple):
    """The ridge's side at +t in its own frame, from base circle to axis: (t, n) mm and radii."""

    base: tuple[float, float]
    flank_low: tuple[float, float]
    flank_high: tuple[float, float]
    crown: tuple[float, float]


def _half_ridge(design: Design) -> _HalfRidge:
    """Corners of half a ridge with its fillets.

    A fillet's centre lies at its radius from the flank's line, and on a circle concentric with the base
    (or crown) circle; written with the circle's curvature, the quadratic stays exact for a flat one.
    """
    ridge, radius = design.ridge, design.skin.curvature_radius
    sag = 2 * radius * math.sin(math.asin(ridge.root_width / (2 * radius)) / 2) ** 2
    root = np.array([ridge.root_width / 2, -sag])
    edge = np.array([ridge.tip_width / 2, ridge.height - ridge.crown])
    flank = edge - root
    size = float(np.hypot(*flank))
    along = flank / size
    out = np.array([along[1], -along[0]])
    summit = np.array([0.0, ridge.height])
    crown_curvature = 2 * ridge.crown / (ridge.tip_width**2 / 4 + ridge.crown**2)
    _check_flank(design, _rise(root, along, 1 / radius), _rise(edge - summit, along, crown_curvature))
    r = ridge.root_fillet
    u = concentric_hit(root + r * out, along, 1 / radius, r + r * r / (2 * radius))
    if u is None:
        raise InputError("ridge.root_fillet", "does not fit between flank and base circle", r, "reduce it")
    low, centre = root + u * along, root + r * out + u * along
    base = centre * radius / (radius + r) - [0.0, r * radius / (radius + r)]
    r, curvature = ridge.tip_fillet, crown_curvature
    if curvature * r >= 1:
        raise InputError(
            "ridge.tip_fillet", f"must be less than {1 / curvature:.4g} mm (the crown's radius)", r
        )
    v = concentric_hit(edge - r * out - summit, along, curvature, curvature * r * r / 2 - r)
    if v is None:
        raise InputError("ridge.tip_fillet", "does not fit between flank and crown", r, "reduce it")
    high, inner = edge + v * along, edge - r * out + v * along - summit
    crown = (inner + np.array([0.0, r])) / (1 - curvature * r) + summit
    if u > size + v:
        raise InputError(
            "ridge.root_fillet",
            f"root and tip fillet need {u - v:.4g} mm of a flank of {size:.4g} mm",
            ridge.root_fillet,
            "take smaller fillets or a higher ridge",
        )
    if crown[0] < 0:
        raise InputError(
            "ridge.tip_fillet", "the two tip fillets overlap on the axis", r, "take a smaller one"
        )
    if base[0] > ridge.pitch / 2:
        raise InputError(
            "ridge.root_fillet",
            f"neighbouring root fillets overlap by {2 * base[0] - ridge.pitch:.4g} mm",
            ridge.root_fillet,
            "take a smaller fillet or a larger pitch",
        )
    # without a fillet its two ends are one corner: 1e-17 mm between them would be an edge that crosses others
    base, low = (base, low) if ridge.root_fillet else (root, root)
    high, crown = (high, crown) if ridge.tip_fillet else (edge, edge)
    pairs = [(float(p[0]), float(p[1])) for p in (base, low, high, crown)]
    return _HalfRidge(*pairs)


def _check_flank(design: Design, at_root: float, at_tip: float) -> None:
    """Raise InputError where a flank doesn't rise from the base circle, or not out of the crown's: by the
    sines of its angles with them, which no fillet changes."""
    ridge = design.ridge
    if at_root <= 0:
        rule = "is so wide and the ridge so low that its flanks begin inside the base circle"
        remedy = "make the ridge higher or less crowned, its root narrower, or curvature_radius larger"
        raise InputError("ridge.root_width", rule, ridge.root_width, remedy)
    if at_tip <= 0:
        rule = "makes the crown's edges as steep as the flanks or steeper"
        raise InputError("ridge.crown", rule, ridge.crown, "reduce it, or make the flanks steeper")


def _rise(start: Array, along: Array, curvature: float) -> float:
    """Sine of the angle by which a line rises from the circle of a curvature through its start, as below."""
    return float(along[1] + curvature * (start @ along))


def concentric_hit(start: Array, along: Array, curvature: float, level: float) -> float | None:
    """Solve n + curvature (t^2 + n^2) / 2 = level for u on the line start + u along, near u = 0.

    With curvature 1/R and level h + h^2 / (2 R) that is the circle of radius R + h about (0, -R), written so
    that a flat one loses no digits. None where the line misses it or does not rise through it.
    """
    a, b = curvature / 2, _rise(start, along, curvature)
    c = float(start[1] + curvature * (start @ start) / 2 - level)
    inside = b * b - 4 * a * c
    if inside < 0 or b <= 0:
        return None
    return -2 * c / (b + math.sqrt(inside))


def _fillet_bulge(p: tuple[float, float], q: tuple[float, float], radius: float) -> float:
    chord = math.hypot(p[0] - q[0], p[1] - q[1])
    return math.tan(math.asin(min(1.0, chord / (2 * radius))) / 2) if radius else 0.0


def _outline(design: Design, half: _HalfRidge) -> Iterator[Segment]:
    """Outline from the back's left corner, counterclockwise; segments without length are left out."""
    skin, count = design.skin, design.ridge.count
    radius, x = skin.curvature_radius, skin.width / 2
    side = math.asin(x / radius)
    shoulder = skin.thickness - 2 * radius * math.sin(side / 2) ** 2
    yield Segment(Point(-x, 0.0), Point(x, 0.0), kind="back")
    yield Segment(Point(x, 0.0), Point(x, shoulder), kind="side")
    reach = math.atan2(half.base[0], radius + half.base[1])
    here, angle = Point(x, shoulder), side
    for ridge in range(count, 0, -1):
        lean, at = design.lean(ridge), frame(design, ridge).at
        there = at(*half.base)
        yield from _real(Segment(here, there, math.tan((angle - lean - reach) / 4), "base"))
        yield from _ridge(design, half, ridge)
        here, angle = at(-half.base[0], half.base[1]), lean - reach
    yield from _real(Segment(here, Point(-x, shoulder), math.tan((angle + side) / 4), "base"))
    yield Segment(Point(-x, shoulder), Point(-x, 0.0), kind="side")


def _ridge(design: Design, half: _HalfRidge, ridge: int) -> Iterator[Segment]:
    at, shape = frame(design, ridge).at, design.ridge
    right = [at(*p) for p in half]
    left = [at(-t, n) for t, n in half]
    foot = _fillet_bulge(half.base, half.flank_low, shape.root_fillet)
    shoulder = _fillet_bulge(half.flank_high, half.crown, shape.tip_fillet)
    summit = (shape.height - half.crown[1]) / half.crown[0] if half.crown[0] > 0 else 0.0
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
    wall = min(float(body.exterior.distance(shape)) for shape in slots)
    tree = shapely.STRtree(slots)
    pairs = tree.query(slots, predicate="dwithin", distance=MOLDABLE_WALL)
    close = pairs[:, pairs[0] < pairs[1]].T
    web = min((float(slots[i].distance(slots[j])) for i, j in close), default=math.inf)
    for what, size in (("wall to the outline", wall), ("web between slots", web)):
        if size < MOLDABLE_WALL:
            raise InputError(
                "slot.offset",
                f"leaves a {what} of {max(size, 0.0):.4g} mm; silicone needs {MOLDABLE_WALL:g} mm",
                design.slot and design.slot.offset,
                "move, turn or shorten the slots",
            )
