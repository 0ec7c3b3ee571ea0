"""Bodies of parts and of their cuts: a prism, a bore or what turns about an axis. Plain data, no CAD kernel.

Any prism or bore can be turned as a rigid body about an axis along x, as a doubly curved mold's ends are.
Lengths are mm, in the mold's frame: x across the ridges, y along them, z up while pouring; the skin's back is
at z = 0 and its ridges point down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from skincad.base.arrays import Array
from skincad.shape import curves
from skincad.shape.curves import Loop
from skincad.solids.grid import Grid
from skincad.solids.roles import CutRole

Axis = Literal["x", "y", "z"]
Heading = tuple[float, float]  # (x, z), of length 1
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Prism:
    """A loop swept along an axis: (x, z) along y, (x, y) along z or (y, z) along x, from `low` to `high` mm.

    With a `grid`, arcs of a loop in (y, z) are parts of the back, z = 0, turned about the grid's axis.
    """

    outline: Loop
    axis: Axis
    low: float
    high: float
    holes: tuple[Loop, ...] = ()
    grid: Grid | None = None
    role: CutRole | None = None  # where it is a cut

    @property
    def volume(self) -> float:
        """Area of the outline less its holes, times the length, mm3."""
        net = curves.area(self.outline) - math.fsum(curves.area(h) for h in self.holes)
        return net * (self.high - self.low)


_GAUSS, _TURN = np.polynomial.legendre.leggauss(16), 32  # of the quadrature below: the integrand is smooth


@dataclass(frozen=True)
class Bore:
    """A straight round hole or pin from `start` along +axis, mm; conical where `end_radius` is given."""

    start: Vector
    axis: Axis
    length: float
    radius: float
    end_radius: float | None = None
    within: tuple[float, float] | None = None  # see below
    role: CutRole | None = None

    # A bore along z into a cylinder about an axis along x, (z, radius) mm, as a carrier's lower face is one:
    # it begins outside, so that its whole rim is cut, and only what lies inside counts as its volume.

    @property
    def far_radius(self) -> float:
        """Radius at its end, mm."""
        return self.radius if self.end_radius is None else self.end_radius

    def circle(self, tolerance: float, multiple: int = 1) -> int:
        """Return how many chords within `tolerance` mm, 12 at least, stand for its circle."""
        widest = max(self.radius, self.far_radius)
        count = math.pi / math.acos(1 - min(0.5, tolerance / widest)) / multiple
        return max(12, math.ceil(count) * multiple)

    @property
    def volume(self) -> float:
        """Volume of the cylinder or frustum, mm3; inside `within` by a quadrature that rounding limits."""
        a, b = self.radius, self.far_radius
        if self.within:
            return self._inside(a, b - a, *self.within)
        return math.pi * self.length * (a * a + a * b + b * b) / 3

    def _inside(self, radius: float, widens: float, centre: float, limit: float) -> float:
        """Each straight line of the cone, at the share u of its radius, enters the cylinder at a share s of
        its length: the smaller root of a quadratic. What follows is summed over u and the turn."""
        nodes, weights = _GAUSS
        turn = 2 * math.pi * np.arange(_TURN) / _TURN
        u, weight = (nodes + 1) / 2, weights / 2 * (nodes + 1) / 2
        m = np.outer(u, np.sin(turn))
        begin, slope = self.start[1] + m * radius, m * widens  # y of the line is begin + slope s
        under, rise = centre - self.start[2], self.length
        a, b = slope**2 + rise**2, begin * slope - under * rise
        c = begin**2 + (under - limit) * (under + limit)
        s = c / (np.sqrt(b * b - a * c) - b)

        def filled(s: Array) -> Array:
            return radius**2 * s + radius * widens * s**2 + widens**2 * s**3 / 3

        rest = rise * (filled(np.ones_like(s)) - filled(s))
        return float(weight @ rest.sum(axis=1)) * 2 * math.pi / _TURN


@dataclass(frozen=True)
class RevolvedBody:
    """A loop (x, z) turned about the axis along x at z = `centre` mm, from angle `low` to `high` rad.

    Angles count from the section's own plane, y = 0, towards +y. The loop keeps to one side of the axis.
    All terms avoid cancellation against a far axis.
    """

    outline: Loop
    centre: float
    low: float
    high: float
    holes: tuple[Loop, ...] = ()
    grid: Grid | None = None
    role: CutRole | None = None  # where it is a cut
    axis: ClassVar[Literal["turn"]] = "turn"

    @property
    def volume(self) -> float:
        """Moment of the area about the axis times the angle, mm3: Pappus's second theorem."""
        moment = self._moment(self.outline) - math.fsum(self._moment(h) for h in self.holes)
        return abs(moment) * (self.high - self.low)

    def _moment(self, outline: Loop) -> float:
        area, _, first = curves.moments(outline)
        return first - self.centre * area

    def placed(self, points: Array, angle: float) -> Array:
        """Return section points `(n, 2)` mm turned by an angle in rad, `(n, 3)` mm."""
        arm = points[:, 1] - self.centre
        level = points[:, 1] - 2 * arm * math.sin(angle / 2) ** 2
        return np.column_stack([points[:, 0], np.abs(arm) * math.sin(angle), level])

    def straightened(self, points: Array) -> Array:
        """Return turned points `(n, 3)` mm at their place in the section: x, z, and y the angle's arc about
        the axis at z = 0. `placed` takes them back."""
        arm = points[:, 2] - self.centre
        angle = np.arctan2(points[:, 1], np.abs(arm))
        level = points[:, 2] + np.sign(arm) * np.abs(points[:, 1]) * np.tan(np.abs(angle) / 2)
        return np.column_stack([points[:, 0], angle * abs(self.centre), level])


@dataclass(frozen=True)
class RotatedBody:
    """A prism or bore turned as a rigid body about the axis along x at z = `centre` mm by `angle` rad, +y
    towards +z; before that it is moved along y so that its y = `base` mm comes to y = 0.

    A part of such bodies is designed, judged and laid on a print bed in its own frame, before it is turned.
    """

    body: Prism | Bore
    centre: float
    angle: float
    base: float
    axis: ClassVar[Literal["turned"]] = "turned"

    @property
    def volume(self) -> float:
        """Volume, mm3: turning keeps it."""
        return self.body.volume

    @property
    def role(self) -> CutRole | None:
        """What it is cut for."""
        return self.body.role

    def placement(self) -> tuple[Array, Array]:
        """Return rotation `(3, 3)` and shift `(3,)` mm, from the own frame to the mold's, without
        cancellation against a far axis."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        turn = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        fall = 2 * self.centre * math.sin(self.angle / 2) ** 2
        return turn, np.array([0.0, self.centre * s - self.base * c, fall - self.base * s])

    def placed(self, points: Array) -> Array:
        """Return points `(n, 3)` mm of the own frame in the mold's."""
        turn, shift = self.placement()
        return points @ turn.T + shift

    def returned(self, points: Array) -> Array:
        """Return points `(n, 3)` mm of the mold's frame in the own one."""
        turn, shift = self.placement()
        return (points - shift) @ turn


@dataclass(frozen=True)
class ExtendedCut:
    """A cut that is built further than what it takes away: out of the part, or into what is cut besides it.
    So it ends on no slanting face, on which a film of rounding would stay. `counts` is what it takes away.
    """

    counts: Prism | RevolvedBody | Bore | RotatedBody
    built: Prism | RevolvedBody | Bore | RotatedBody
    axis: ClassVar[Literal["reaching"]] = "reaching"

    @property
    def volume(self) -> float:
        """Volume of what it takes away, mm3."""
        return self.counts.volume

    @property
    def role(self) -> CutRole | None:
        """What it is cut for."""
        return self.counts.role


Body = Prism | RevolvedBody | Bore | RotatedBody | ExtendedCut


def plain(cut: Body) -> Prism | RevolvedBody | Bore:
    """Return what a cut takes away, in its own frame."""
    counts = cut.counts if isinstance(cut, ExtendedCut) else cut
    return counts.body if isinstance(counts, RotatedBody) else counts


def corners(body: Prism | RevolvedBody, outline: Loop, tolerance: float) -> Array:
    """Return a loop of a body as its mesh has it, arcs as chords within `tolerance` mm, `(n, 2)` mm."""
    if not (isinstance(body, Prism) and body.axis == "x" and body.grid):
        return curves.polygon(outline, tolerance)
    rows = []
    for before, segment in zip((outline[-1], *outline[:-1]), outline, strict=True):
        if segment.bulge != 0.0:
            low, high = (math.atan2(p.x, body.grid.centre - p.z) for p in (segment.start, segment.end))
            arc = body.grid.arc(min(low, high), max(low, high), tolerance)
            rows.append(arc if low < high else arc[::-1])
        elif before.bulge == 0.0:  # else the arc's own end stands there
            rows.append(np.array([segment.start]))
    return np.vstack(rows)
