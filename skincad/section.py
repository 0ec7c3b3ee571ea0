"""The exact cross-section: closed loops of straight lines and circular arcs, in the plane (x, z), mm.

A segment is two end points and a bulge, the tangent of a quarter of its sweep (as in DXF): a line is an
arc of bulge 0, and an arc of 1e8 mm radius loses no digits, because no centre is ever formed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from skincad.design import MOLDABLE_WALL, Design
from skincad.errors import InputError

Kind = Literal["back", "side", "base", "root_fillet", "flank", "tip_fillet", "crown", "slot", "other"]
CONTACT_KINDS: tuple[Kind, ...] = ("tip_fillet", "crown")
GUARD_TOLERANCE = 1e-5  # mm, chord tolerance of the polygons that the guards judge
_GAUSS = np.polynomial.legendre.leggauss(16)  # exact to rounding for sweeps below a half turn


class Point(NamedTuple):
    """A point of the section, mm."""

    x: float
    z: float


@dataclass(frozen=True, slots=True)
class Segment:
    """A line or arc from `start` to `end`, the material on its left.

    `bulge` is tan(sweep / 4), positive when it turns counterclockwise; `ridge` counts from 1.
    """

    start: Point
    end: Point
    bulge: float = 0.0
    kind: Kind = "other"
    ridge: int | None = None

    @property
    def sweep(self) -> float:
        """Angle turned through from start to end, rad, positive counterclockwise."""
        return 4 * math.atan(self.bulge)

    @property
    def chord(self) -> float:
        """Distance from start to end, mm."""
        return math.hypot(self.end.x - self.start.x, self.end.z - self.start.z)

    @property
    def radius(self) -> float:
        """Radius of the arc, mm; infinite for a line."""
        if self.bulge == 0.0:
            return math.inf
        return self.chord * (1 + self.bulge**2) / (4 * abs(self.bulge))

    @property
    def length(self) -> float:
        """Arc length, mm."""
        half = self.sweep / 2
        return self.chord if half == 0.0 else self.chord * half / math.sin(half)

    def points(self, fractions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the points at these fractions of the length, `(n, 2)` mm."""
        start, end = np.array(self.start), np.array(self.end)
        middle, half = (start + end) / 2, (end - start) / 2
        right = np.array([half[1], -half[0]])
        u = np.asarray(fractions, dtype=float)
        if self.bulge == 0.0:
            along, aside = 2 * u - 1, np.zeros_like(u)
        else:
            turn = (u - 0.5) * self.sweep
            size = math.sin(self.sweep / 2)
            along, aside = np.sin(turn) / size, self.bulge - 2 * np.sin(turn / 2) ** 2 / size
        points: NDArray[np.float64] = middle + np.outer(along, half) + np.outer(aside, right)
        return points

    def point(self, fraction: float) -> Point:
        """Return the point at this fraction of the length."""
        x, z = self.points(np.array([fraction]))[0]
        return Point(float(x), float(z))

    def reversed(self) -> Segment:
        """Return the same curve run the other way."""
        return replace(self, start=self.end, end=self.start, bulge=-self.bulge)

    def pieces(self, tolerance: float) -> int:
        """Return how many chords keep within `tolerance` mm of the curve."""
        if self.bulge == 0.0:
            return 1
        widest = 4 * math.asin(min(1.0, math.sqrt(tolerance / (2 * self.radius))))
        return max(1, math.ceil(abs(self.sweep) / widest))


Loop = tuple[Segment, ...]


def loop(points: list[Point], kind: Kind = "other", ridge: int | None = None) -> Loop:
    """Return the closed polygon through these points as a loop of lines."""
    return tuple(
        Segment(a, b, kind=kind, ridge=ridge) for a, b in zip(points, [*points[1:], points[0]], strict=True)
    )


def rectangle(x_min: float, x_max: float, z_min: float, z_max: float) -> Loop:
    """Return an axis-parallel rectangle, counterclockwise."""
    return loop([Point(x_min, z_min), Point(x_max, z_min), Point(x_max, z_max), Point(x_min, z_max)])


def shifted(outline: Loop, dx: float, dz: float) -> Loop:
    """Return the loop moved by (dx, dz) mm."""
    return tuple(
        replace(s, start=Point(s.start.x + dx, s.start.z + dz), end=Point(s.end.x + dx, s.end.z + dz))
        for s in outline
    )


def flipped(outline: Loop) -> Loop:
    """Return the loop turned upside down (z to -z), still with the material on its left."""
    return tuple(
        replace(s, start=Point(s.end.x, -s.end.z), end=Point(s.start.x, -s.start.z))
        for s in reversed(outline)
    )


def moments(outline: Loop) -> tuple[float, float, float]:
    """Return (area mm2, first moments of area about z and x, mm3) by Green's theorem.

    Exact to rounding: the chord polygon plus every arc's circular segment, in the chord's own frame.
    """
    origin = outline[0].start
    total = np.zeros(3)
    for segment in outline:
        a = np.array([segment.start.x - origin.x, segment.start.z - origin.z])
        b = np.array([segment.end.x - origin.x, segment.end.z - origin.z])
        area = (a[0] * b[1] - a[1] * b[0]) / 2
        total += [area, *(area * (a + b) / 3)]
        if segment.bulge:
            total += _circular_segment((a + b) / 2, (b - a) / 2, segment)
    area, mx, mz = total
    return float(area), float(mx + area * origin.x), float(mz + area * origin.z)


def _circular_segment(middle: NDArray[np.float64], half: NDArray[np.float64], arc: Segment) -> list[float]:
    """Area and moments between an arc and its chord, by Gauss integration over the angle."""
    nodes, weights = _GAUSS
    turn, size = nodes * arc.sweep / 2, math.sin(arc.sweep / 2)
    aside = arc.bulge - 2 * np.sin(turn / 2) ** 2 / size  # height over the chord, in half chords
    weight = weights * np.cos(turn) / size * arc.sweep / 2 * aside
    area, first = float(weight.sum()), float((weight * aside).sum()) / 2
    square = float(half @ half)
    right = np.array([half[1], -half[0]])
    return [area * square, *(square * (area * middle + first * right))]


def area(outline: Loop) -> float:
    """Return the enclosed area, mm2, positive for a counterclockwise loop."""
    return moments(outline)[0]


def length(outline: Loop) -> float:
    """Return the perimeter, mm."""
    return math.fsum(s.length for s in outline)


def polygon(outline: Loop, tolerance: float) -> NDArray[np.float64]:
    """Return the loop's corners with arcs as chords within `tolerance` mm, `(n, 2)` mm, not closed."""
    rows = [s.points(np.arange(n) / n) for s in outline for n in [s.pieces(tolerance)]]
    return np.vstack(rows)


def offset(outline: Loop, distance: float, tolerance: float) -> list[NDArray[np.float64]]:
    """Return the outline moved outward by `distance` mm (inward if negative) as polygons within
    `tolerance` mm; round at the corners, so opening and closing with it are those of a round tool."""
    grown = shapely.Polygon(polygon(outline, tolerance / 2)).buffer(
        distance, quad_segs=max(4, math.ceil(math.pi / 4 / math.sqrt(tolerance / max(abs(distance), tolerance))))
    )
    parts = getattr(grown, "geoms", [grown])
    return [np.asarray(p.exterior.coords)[:-1] for p in parts if not p.is_empty]


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
    """One slot of the section: `direction` is the unit vector along its depth, outward."""

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
    def ridges(self) -> int:
        """Number of ridges on the outline."""
        return len({s.ridge for s in self.outline if s.ridge is not None})

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
        """Largest z of the outline, mm."""
        return float(polygon(self.outline, GUARD_TOLERANCE)[:, 1].max())


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
    r = ridge.root_fillet
    u = concentric_hit(root + r * out, along, 1 / radius, r + r * r / (2 * radius))
    low, centre = root + u * along, root + r * out + u * along
    base = centre * radius / (radius + r) - [0.0, r * radius / (radius + r)]
    r, curvature = ridge.tip_fillet, 2 * ridge.crown / (ridge.tip_width**2 / 4 + ridge.crown**2)
    if curvature * r >= 1:
        raise InputError(
            "ridge.tip_fillet", f"must be less than {1 / curvature:.4g} mm (the crown's radius)", r
        )
    v = concentric_hit(edge - r * out - summit, along, curvature, curvature * r * r / 2 - r)
    high, inner = edge + v * along, edge - r * out + v * along - summit
    crown = (inner + [0.0, r]) / (1 - curvature * r) + summit
    if u > size + v:
        raise InputError(
            "ridge.root_fillet",
            f"root and tip fillet need {u - v:.4g} mm of a flank of {size:.4g} mm",
            ridge.root_fillet,
            "take smaller fillets or a higher ridge",
        )
    if crown[0] < 0:
        raise InputError("ridge.tip_fillet", "the two tip fillets overlap on the axis", r, "take a smaller one")
    if base[0] > ridge.pitch / 2:
        raise InputError(
            "ridge.root_fillet",
            f"neighbouring root fillets overlap by {2 * base[0] - ridge.pitch:.4g} mm",
            ridge.root_fillet,
            "take a smaller fillet or a larger pitch",
        )
    pairs = [(float(p[0]), float(p[1])) for p in (base, low, high, crown)]
    return _HalfRidge(*pairs)


def concentric_hit(
    start: NDArray[np.float64], along: NDArray[np.float64], curvature: float, level: float
) -> float:
    """Solve n + curvature (t^2 + n^2) / 2 = level for u on the line start + u along, near u = 0.

    With curvature 1/R and level h + h^2 / (2 R) that is the circle of radius R + h about (0, -R), written so
    that a flat one loses no digits. Raises InputError when the line misses it.
    """
    a = curvature / 2
    b = float(along[1] + curvature * (start @ along))
    c = float(start[1] + curvature * (start @ start) / 2 - level)
    inside = b * b - 4 * a * c
    if inside < 0 or b <= 0:
        raise InputError("ridge", "a fillet finds no place between flank and circle", remedy="reduce it")
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
                slot.thickness,
            )


def _guard(result: Section, design: Design) -> None:
    """Judge the whole section on its polygons: simple, slots inside, walls and webs thick enough."""
    body = shapely.Polygon(polygon(result.outline, GUARD_TOLERANCE))
    if not body.is_valid:
        raise InputError(
            "ridge", f"the outline crosses itself ({shapely.is_valid_reason(body)})", remedy="move ridges apart"
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
