"""What is seen of a solid from one side: lines and arcs in the view's plane, plain data, mm."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from skincad.shape.curves import Loop
from skincad.solids.plan import Vector

Place = tuple[float, float]  # (right, up) mm, in a view
SAME = 6  # decimals of a millimetre within which two edges of a view are one


@dataclass(frozen=True)
class View:
    """Where a solid is looked at from: directions that lie to the right and up in the view, of length 1 and
    square to each other, and the point, mm, that is its (0, 0)."""

    right: Vector
    up: Vector
    origin: Vector = (0.0, 0.0, 0.0)

    @property
    def towards(self) -> Vector:
        """Direction from the solid to who looks at it."""
        (a, b, c), (u, v, w) = self.right, self.up
        return (b * w - c * v, c * u - a * w, a * v - b * u)

    def at(self, point: Vector) -> Place:
        """Return where a point, mm, lies in the view."""
        arm = [p - o for p, o in zip(point, self.origin, strict=True)]
        right, up = (math.fsum(a * w for a, w in zip(arm, way, strict=True)) for way in (self.right, self.up))
        return right, up


@dataclass(frozen=True)
class Polyline:
    """A line through these points, mm."""

    points: tuple[Place, ...]

    def straightened(self, tolerance: float) -> Polyline:
        """Return the line from end to end where all points lie within `tolerance` mm of it and between."""
        (x, y), (u, v) = self.points[0], self.points[-1]
        long = math.hypot(u - x, v - y)
        if len(self.points) == 2 or long == 0.0:
            return self
        off_line = max(abs((q - y) * (u - x) - (p - x) * (v - y)) / long for p, q in self.points)
        along = [((p - x) * (u - x) + (q - y) * (v - y)) / long for p, q in self.points]
        if off_line > tolerance or min(along) < -tolerance or max(along) > long + tolerance:
            return self
        return Polyline((self.points[0], self.points[-1]))

    def key(self) -> tuple[Place, ...]:
        """Return what is the same for the same line in either direction."""
        ends = tuple((round(x, SAME) + 0.0, round(y, SAME) + 0.0) for x, y in self.points)
        return min(ends, ends[::-1])

    def box(self) -> tuple[Place, Place]:
        """Return its lower left and its upper right corner, mm."""
        x, y = zip(*self.points, strict=True)
        return (min(x), min(y)), (max(x), max(y))


@dataclass(frozen=True)
class Arc:
    """An arc of a circle, mm, from the angle `start`, rad, counterclockwise by `sweep`, rad."""

    centre: Place
    radius: float
    start: float
    sweep: float

    @property
    def whole(self) -> bool:
        """Whether it is a full circle."""
        return self.sweep > 2 * math.pi - 1e-6

    def key(self) -> tuple[float, ...]:
        """Return what is the same for the same arc."""
        turn = (0.0,) if self.whole else (math.cos(self.start), math.sin(self.start), self.sweep)
        return tuple(round(v, SAME) + 0.0 for v in (*self.centre, self.radius, *turn))

    def at(self, share: float) -> Place:
        """Return the point at a share of its sweep, mm."""
        angle = self.start + share * self.sweep
        x, y = self.centre
        return x + self.radius * math.cos(angle), y + self.radius * math.sin(angle)

    def box(self) -> tuple[Place, Place]:
        """Return its lower left and its upper right corner, mm."""
        quarters = range(
            math.ceil(self.start * 2 / math.pi), math.floor((self.start + self.sweep) * 2 / math.pi) + 1
        )
        points = [self.at((q * math.pi / 2 - self.start) / self.sweep) for q in quarters]
        return Polyline((self.at(0.0), self.at(1.0), *points)).box()


Stroke = Polyline | Arc


@dataclass(frozen=True)
class Projection:
    """The edges that are seen, and those that what is in front hides."""

    visible: tuple[Stroke, ...]
    hidden: tuple[Stroke, ...]

    def box(self) -> tuple[Place, Place]:
        """Return lower left and upper right corner of what is seen, mm."""
        return extent(self.visible)


def outlined(outline: Loop) -> tuple[Stroke, ...]:
    """Return a loop of a section as strokes."""
    strokes: list[Stroke] = []
    for segment in outline:
        if segment.bulge == 0.0 or not math.isfinite(segment.radius):
            strokes.append(Polyline(((segment.start.x, segment.start.z), (segment.end.x, segment.end.z))))
            continue
        way = math.copysign(1.0, segment.bulge)
        lean = math.atan2(segment.end.z - segment.start.z, segment.end.x - segment.start.x)
        turned = lean - segment.sweep / 2 - way * math.pi / 2  # from the centre to the start
        x = segment.start.x - segment.radius * math.cos(turned)
        z = segment.start.z - segment.radius * math.sin(turned)
        first = turned if way > 0 else turned + segment.sweep
        strokes.append(Arc((x, z), segment.radius, first, abs(segment.sweep)))
    return tuple(strokes)


def extent(strokes: Iterable[Stroke]) -> tuple[Place, Place]:
    """Return lower left and upper right corner of all these strokes, mm."""
    return Polyline(tuple(corner for stroke in strokes for corner in stroke.box())).box()


def distinct(strokes: Iterable[Stroke]) -> list[Stroke]:
    """Return each stroke once: where two edges lie behind one another a view has both."""
    return list({stroke.key(): stroke for stroke in strokes}.values())
