"""What a part is made of: a prism, a revolved loop or a bore, less such bodies. Plain data, no CAD kernel.

One plan feeds the exact solid (`occ.py`), the print mesh (`fabrication/meshes.py`) and the volume formula,
so each can be held against the others. Lengths are mm, in the mold's frame: x across the ridges, y along
them, z up while pouring; the skin's back is at z = 0 and its ridges point down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray

from skincad import curves
from skincad.curves import Loop, Point, Segment

Axis = Literal["y", "z"]
Heading = tuple[float, float]  # (x, z), of length 1
Vector = tuple[float, float, float]
MadeBy = Literal["cast", "made", "bought"]


@dataclass(frozen=True)
class Prism:
    """A loop swept along an axis: (x, z) along y, or (x, y) along z, from `low` to `high` mm."""

    outline: Loop
    axis: Axis
    low: float
    high: float
    holes: tuple[Loop, ...] = ()

    @property
    def volume(self) -> float:
        """Area of the outline less its holes, times the length, mm3."""
        net = curves.area(self.outline) - math.fsum(curves.area(h) for h in self.holes)
        return net * (self.high - self.low)


@dataclass(frozen=True)
class Bore:
    """A straight round hole or pin from `start` along +axis, mm; conical where `end_radius` is given."""

    start: Vector
    axis: Axis
    length: float
    radius: float
    end_radius: float | None = None

    @property
    def volume(self) -> float:
        """Volume of the cylinder or frustum, mm3."""
        a, b = self.radius, self.radius if self.end_radius is None else self.end_radius
        return math.pi * self.length * (a * a + a * b + b * b) / 3


@dataclass(frozen=True)
class Revolved:
    """A loop (x, z) turned about the axis along x at z = `centre` mm, from angle `low` to `high` rad.

    Angles count from the section's own plane, y = 0, towards +y. The loop keeps to one side of the axis.
    Nothing is formed that would lose digits to a far axis.
    """

    outline: Loop
    centre: float
    low: float
    high: float
    holes: tuple[Loop, ...] = ()
    axis: ClassVar[Literal["x"]] = "x"

    @property
    def volume(self) -> float:
        """Moment of the area about the axis times the angle, mm3: Pappus's second theorem."""
        moment = self._moment(self.outline) - math.fsum(self._moment(h) for h in self.holes)
        return abs(moment) * (self.high - self.low)

    def _moment(self, outline: Loop) -> float:
        area, _, first = curves.moments(outline)
        return first - self.centre * area

    def placed(self, points: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
        """Return section points `(n, 2)` mm turned by an angle in rad, `(n, 3)` mm."""
        arm = points[:, 1] - self.centre
        level = points[:, 1] - 2 * arm * math.sin(angle / 2) ** 2
        return np.column_stack([points[:, 0], np.abs(arm) * math.sin(angle), level])

    def straightened(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return turned points `(n, 3)` mm at their place in the section: x, z, and y the angle's arc about
        the axis at z = 0. `placed` takes them back."""
        arm = points[:, 2] - self.centre
        angle = np.arctan2(points[:, 1], np.abs(arm))
        level = points[:, 2] + np.sign(arm) * np.abs(points[:, 1]) * np.tan(np.abs(angle) / 2)
        return np.column_stack([points[:, 0], angle * abs(self.centre), level])


Body = Prism | Revolved | Bore


@dataclass(frozen=True)
class Part:
    """A part: its body less its cuts. Cuts lie inside the body and do not meet each other."""

    name: str
    colour: tuple[float, float, float]
    made: MadeBy
    body: Body
    cuts: tuple[Body, ...] = ()
    lies_on_end: bool = False  # printed with its y face on the bed

    @property
    def volume(self) -> float:
        """Volume by formula, mm3: body less cuts."""
        return self.body.volume - math.fsum(cut.volume for cut in self.cuts)


def box(x: float, y: tuple[float, float], z: tuple[float, float], axis: Axis = "z") -> Prism:
    """Return a block from -x to x with these y and z ranges, mm."""
    if axis == "z":
        return Prism(curves.rectangle(-x, x, *y), "z", *z)
    return Prism(curves.rectangle(-x, x, *z), "y", *y)


_Body = TypeVar("_Body", bound=Body)


def moved(body: _Body, x: float) -> _Body:
    """Return a body moved by `x` mm along x."""
    if not isinstance(body, Bore):
        holes = tuple(shifted(hole, x) for hole in body.holes)
        return replace(body, outline=shifted(body.outline, x), holes=holes)
    return replace(body, start=(body.start[0] + x, *body.start[1:]))


def shifted(segments: Loop, x: float) -> Loop:
    """Return segments moved by `x` mm along x."""
    return tuple(
        replace(s, start=Point(s.start.x + x, s.start.z), end=Point(s.end.x + x, s.end.z)) for s in segments
    )


def swept(part: Part, axis: Axis | Heading, travel: float, tolerance: float) -> Part:
    """Return a part that covers everything that `part` passes through on `travel` mm that way.

    Exact (arcs within `tolerance` mm) for a part whose cuts all run through it along the axis, and for a bare
    prism moved across its own axis; elsewhere cuts are left out, so the swept part is never too small.
    """
    if part.body.axis == axis:
        cuts = tuple(_stretched(c, travel) for c in part.cuts if _through(c, part.body))
        return replace(part, body=_stretched(part.body, travel), cuts=cuts)
    heading = {"y": None, "z": (0.0, 1.0)}[axis] if isinstance(axis, str) else axis
    body = _as_prism(part.body)
    if body is None or body.axis != "y" or heading is None:
        rule = "a pin moves along its axis only, a prism along it or up, down or aside; a pin along y as well"
        raise ValueError(f"{part.name}: {rule}")
    shadow = _shadow(body.outline, (heading[0] * travel, heading[1] * travel), tolerance)
    return replace(part, body=replace(body, outline=shadow, holes=()), cuts=())


def _as_prism(body: Body) -> Prism | None:
    """A round pin along y as a prism; None where a body is no prism."""
    if isinstance(body, Bore) and body.axis == "y" and body.end_radius is None:
        (x, low, z), r = body.start, body.radius
        ends = Point(x - r, z), Point(x + r, z)
        circle = Segment(ends[0], ends[1], 1.0), Segment(ends[1], ends[0], 1.0)  # half turns
        return Prism(circle, "y", low, low + body.length)
    return body if isinstance(body, Prism) else None


def _through(cut: Body, body: Body) -> bool:
    """Whether a cut keeps its section all through a body: what a blind one leaves open, the rest covers."""
    if cut.axis != body.axis or (isinstance(cut, Bore) and cut.end_radius):
        return False
    return _ends(cut) == _ends(body)


def _ends(body: Body) -> tuple[float, float]:
    """Where a body begins and ends along its axis, mm."""
    if isinstance(body, Bore):
        low = body.start[1 if body.axis == "y" else 2]
        return low, low + body.length
    return body.low, body.high


def _stretched(body: Body, travel: float) -> Body:
    if isinstance(body, Revolved):
        raise ValueError("a revolved body runs along no straight axis")
    if isinstance(body, Prism):
        return replace(body, low=body.low + min(travel, 0.0), high=body.high + max(travel, 0.0))
    x, y, z = body.start
    back = min(travel, 0.0)
    start = (x, y + back, z) if body.axis == "y" else (x, y, z + back)
    return replace(body, start=start, length=body.length + abs(travel))


def _shadow(outline: Loop, way: Heading, tolerance: float) -> Loop:
    """Outline of everything that a loop's chord polygon covers while it moves by `way` mm."""
    points = curves.polygon(outline, tolerance)
    quads = [
        shapely.Polygon([a, b, b + way, a + way])
        for a, b in zip(points, np.roll(points, -1, axis=0), strict=True)
        if (b[0] - a[0]) * way[1] != (b[1] - a[1]) * way[0]
    ]
    covered = shapely.orient_polygons(shapely.union_all([shapely.Polygon(points), *quads]))
    return curves.loop([Point(x, z) for x, z in covered.exterior.coords[:-1]])
