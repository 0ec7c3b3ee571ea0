"""Plane curves: closed loops of straight lines and circular arcs, in the plane (x, z), mm.

A segment is two end points and a bulge, the tangent of a quarter of its sweep (as in DXF): a line is an
arc of bulge 0. An arc of 1e8 mm radius is computed without cancellation, because no centre is ever formed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
import shapely

from skincad.base.arrays import Array

Kind = Literal["back", "side", "base", "root_fillet", "flank", "tip_fillet", "crown", "slot", "cut", "other"]
_GAUSS = np.polynomial.legendre.leggauss(16)  # exact to rounding for sweeps below a half turn


class Point(NamedTuple):
    """A point of the section, mm."""

    x: float
    z: float


@dataclass(frozen=True, slots=True)
class Segment:
    """A line or arc from `start` to `end`, the material on its left.

    `bulge` is tan(sweep / 4), positive when it turns counterclockwise. `feature` is the number of the one
    that it belongs to; `touches` says whether it may meet a plate.
    """

    start: Point
    end: Point
    bulge: float = 0.0
    kind: Kind = "other"
    feature: int | None = None
    touches: bool = False

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

    def points(self, fractions: Array) -> Array:
        """Return the points at these fractions of the length, `(n, 2)` mm."""
        start, end = np.array(self.start), np.array(self.end)
        middle, half = (start + end) / 2, (end - start) / 2
        right = np.array([half[1], -half[0]])
        u = np.asarray(fractions, dtype=float)
        if self.bulge == 0.0:
            along, rise = 2 * u - 1, np.zeros_like(u)
        else:
            turn = (u - 0.5) * self.sweep
            size = math.sin(self.sweep / 2)
            along, rise = np.sin(turn) / size, self.bulge - 2 * np.sin(turn / 2) ** 2 / size
        points: Array = middle + np.outer(along, half) + np.outer(rise, right)
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

    @property
    def summit(self) -> float | None:
        """Fraction of the length at which the arc is highest inside, None where an end is the highest.

        The segment has its material on the left, so at a summit it heads to -x.
        """
        if self.bulge <= 0.0:
            return None
        heading = math.atan2(self.end.z - self.start.z, self.end.x - self.start.x)
        turn = math.remainder(math.pi - (heading - self.sweep / 2), 2 * math.pi)
        fraction = turn / self.sweep
        return fraction if 0 < fraction < 1 else None

    @property
    def top(self) -> float:
        """Largest z, mm, exact."""
        ends = max(self.start.z, self.end.z)
        return ends if self.summit is None else max(ends, self.point(self.summit).z)


Loop = tuple[Segment, ...]


def loop(points: list[Point], kind: Kind = "other", feature: int | None = None) -> Loop:
    """Return the closed polygon through these points as a loop of lines."""
    return tuple(
        Segment(a, b, kind=kind, feature=feature)
        for a, b in zip(points, [*points[1:], points[0]], strict=True)
    )


def rectangle(x_min: float, x_max: float, z_min: float, z_max: float) -> Loop:
    """Return an axis-parallel rectangle, counterclockwise."""
    return loop([Point(x_min, z_min), Point(x_max, z_min), Point(x_max, z_max), Point(x_min, z_max)])


def circle(x: float, z: float, radius: float) -> Loop:
    """Return the circle about (x, z), mm, as two half turns."""
    left, right = Point(x - radius, z), Point(x + radius, z)
    return Segment(left, right, 1.0), Segment(right, left, 1.0)


def right_half(outline: Loop) -> Loop:
    """Return what of a loop lies at x >= 0, closed along x = 0: of one that is its own mirror image there and
    begins to the left of it, or that lies there as a whole."""
    half: list[Segment] = []
    for whole in outline:
        side = whole
        if min(whole.start.x, whole.end.x) < 0.0 < max(whole.start.x, whole.end.x):
            side = replace(whole, bulge=math.tan(whole.sweep / 8))
            middle = Point(0.0, whole.point(0.5).z)
            side = replace(side, start=middle) if whole.end.x > 0.0 else replace(side, end=middle)
        if min(side.start.x, side.end.x) >= 0.0:
            half.append(side)
    closing = Segment(half[-1].end, half[0].start)
    return (*half, closing) if closing.chord > 0.0 else tuple(half)


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


def _circular_segment(middle: Array, half: Array, arc: Segment) -> list[float]:
    """Area and moments between an arc and its chord, by Gauss integration over the angle."""
    nodes, weights = _GAUSS
    turn, size = nodes * arc.sweep / 2, math.sin(arc.sweep / 2)
    rise = arc.bulge - 2 * np.sin(turn / 2) ** 2 / size  # height over the chord, in half chords
    weight = weights * np.cos(turn) / size * arc.sweep / 2 * rise
    area, first = float(weight.sum()), float((weight * rise).sum()) / 2
    square = float(half @ half)
    right = np.array([half[1], -half[0]])
    return [area * square, *(square * (area * middle + first * right))]


def area(outline: Loop) -> float:
    """Return the enclosed area, mm2, positive for a counterclockwise loop."""
    return moments(outline)[0]


def length(outline: Loop) -> float:
    """Return the perimeter, mm."""
    return math.fsum(s.length for s in outline)


def polygon(outline: Loop, tolerance: float) -> Array:
    """Return the loop's corners with arcs as chords within `tolerance` mm, `(n, 2)` mm, not closed."""
    rows = []
    for segment in outline:
        n = segment.pieces(tolerance)
        row = segment.points(np.arange(n) / n) if n > 1 else np.empty((1, 2))
        row[0] = segment.start  # to the last digit: a face 1e-15 mm above a bore's end closes it with a film
        rows.append(row)
    return np.vstack(rows)


def offset(outline: Loop, distance: float, tolerance: float) -> list[Array]:
    """Return the outline moved outward by `distance` mm (inward if negative) as polygons within
    `tolerance` mm; round at the corners, so opening and closing with it are those of a round tool."""
    quarter = math.ceil(math.pi / 4 / math.sqrt(tolerance / max(abs(distance), tolerance)))  # its chords
    grown = shapely.Polygon(polygon(outline, tolerance / 2)).buffer(distance, quad_segs=max(4, quarter))
    parts = getattr(grown, "geoms", [grown])
    return [np.asarray(p.exterior.coords)[:-1] for p in parts if not p.is_empty]


def concentric_hit(start: Array, along: Array, curvature: float, level: float) -> float | None:
    """Solve n + curvature (t^2 + n^2) / 2 = level for u on the line start + u along, near u = 0.

    With curvature 1/R and level h + h^2 / (2 R) that is the circle of radius R + h about (0, -R), written so
    that a flat one loses no digits. None where the line misses it or does not rise through it.
    """
    a, b = curvature / 2, rise(start, along, curvature)
    c = float(start[1] + curvature * (start @ start) / 2 - level)
    inside = b * b - 4 * a * c
    if inside < 0 or b <= 0:
        return None
    return -2 * c / (b + math.sqrt(inside))


def rise(start: Array, along: Array, curvature: float) -> float:
    """Return the sine of the angle by which a line rises from the circle of a curvature through its start, as
    in `concentric_hit`."""
    return float(along[1] + curvature * (start @ along))
