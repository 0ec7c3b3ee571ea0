"""Parts as plain data: roles, bodies and bores on an exact grid.

Bodies of parts and of their cuts: a prism, a bore or what turns about an axis. Plain data, no CAD kernel. Any
prism or bore can be turned as a rigid body about an axis along x, as a doubly curved mold's ends are. Lengths
are mm, in the mold's frame: x across the ridges, y along them, z up while pouring; the skin's back is at z =
0 and its ridges point down.

One plan feeds the exact solid (`occ.py`), the print mesh (`fabrication/meshes.py`) and the volume formula,
so each can be held against the others.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum, auto
from typing import ClassVar, Literal, TypeVar

import numpy as np

from skincad.base.arrays import Array
from skincad.shape import curves
from skincad.shape.curves import Loop, Point

MadeBy = Literal["cast", "made", "bought"]
End = Literal["a", "b"]  # of the mold along y: b is up while it is poured
ENDS: tuple[End, ...] = ("a", "b")


_GREY, _STONE, _DARK = (0.75, 0.77, 0.80), (0.66, 0.69, 0.74), (0.45, 0.50, 0.58)
_GREEN, _GLASS, _ROSE = (0.55, 0.75, 0.60), (0.70, 0.85, 0.95), (0.93, 0.72, 0.62)
_STEEL, _SILVER = (0.62, 0.65, 0.70), (0.80, 0.80, 0.74)


class PartRole(Enum):
    """What a part of a mold is, and what follows: how findings call it, how one comes by it, its colour."""

    SKIN = "the skin", "skin", "cast", _ROSE
    CAVITY = "a cavity in one piece", "cavity", "made", _GREY
    BLOCK = "block in whose seat the cavity lies", "block", "made", _STONE
    BASE = "base of a split cavity", "cavity", "made", _GREY
    LEFT = "outer piece of a split cavity, at -x", "cavity", "made", _STONE
    BETWEEN = "piece of a split cavity, between two splits", "cavity", "made", _STONE
    RIGHT = "outer piece of a split cavity, at +x", "cavity", "made", _STONE
    END_PLATE = "an end plate in one piece", "end plates", "made", _DARK
    COMB = "lower part of an end plate", "end plates' combs", "made", _DARK
    KEEPER = "upper part of an end plate", "end plates' keepers", "made", _GREEN
    CARRIER = "the skin's rigid backing", "carrier", "made", _GLASS
    COVER = "the lid", "cover", "made", _GLASS
    SEAL = "foam between the cover and what it closes", "seal", "bought", _DARK
    SHIM = "what keeps a slot free", "shim", "bought", _STEEL
    STRIP = "a film that is cast in", "strip", "bought", _SILVER
    END_PIN = "dowel between cavity and end plate", "pin", "bought", _STEEL
    COVER_PIN = "dowel between cavity and cover", "pin", "bought", _STEEL
    BONE = "what the skin is cast on, the user's own", "bone", "bought", _STEEL
    PLUG = "what keeps the room of a layer that is poured later", "plug", "made", _GREEN
    CORE_PIN = "what keeps a pocket free", "core pin", "bought", _STEEL
    BONE_SCREW = "what holds the bone under its carrier", "screw", "bought", _STEEL
    BASE_PIN = "dowel between the base and a piece of a split cavity", "pin", "bought", _STEEL

    def __init__(self, what: str, label: str, made: MadeBy, colour: tuple[float, float, float]) -> None:
        self.what, self.label, self.made, self.colour = what, label, made, colour


class CutRole(Enum):
    """What a cut of a part is for."""

    TROUGH = auto()  # the skin's negative
    SEAT = auto()  # the carrier's
    END_BOLT = auto()  # clearance hole of a screw through an end plate
    END_THREAD = auto()  # in which such a screw ends
    NUT = auto()  # its pocket
    END_PIN = auto()
    COVER_BOLT = auto()
    COVER_THREAD = auto()
    COVER_PIN = auto()
    BASE_PIN = auto()
    GATE = auto()
    VENT = auto()
    RIVET = auto()  # a carrier's hole that holds the skin
    PULL = auto()  # a carrier's blind thread, to lift the skin by
    MOUNT = auto()  # a carrier's blind thread, by which a robot holds it
    MOUNT_PIN = auto()  # a hole for the pin that says where
    FIDUCIAL = auto()  # a dimple that a camera finds
    RESERVOIR = auto()
    BLEED = auto()
    PRY = auto()  # notch for a screwdriver
    MARK = auto()  # nick that tells the ends apart, or dimple that lines up with another part's
    BEVEL = auto()  # of a leaning end plate
    FEATURE = auto()  # the negative of a pin
    POCKET = auto()  # a skin's, for what it senses by
    EJECT = auto()  # a block's hole, to push the cavity out through
    WINDOW = auto()  # a lid's, through which a bone reaches
    CORE = auto()  # a carrier's hole for the pin that keeps a pocket free
    BONE_SCREW = auto()  # and for a screw into a bone
    ACCESS = auto()  # a lid's hole round what stands out of the carrier: a core pin, or such a screw's head


CAVITIES = frozenset({PartRole.CAVITY, PartRole.BASE, PartRole.LEFT, PartRole.BETWEEN, PartRole.RIGHT})
END_PLATES = frozenset({PartRole.END_PLATE, PartRole.COMB, PartRole.KEEPER})
PINS = frozenset({PartRole.END_PIN, PartRole.COVER_PIN, PartRole.BASE_PIN})


_SAME = 1e-9  # of a step: an end this near to an angle of the grid is that angle


@dataclass(frozen=True)
class Grid:
    """The angles at which a mesh divides all bodies that turn about one axis along x, so that their facets
    touch as the bodies do. Evenly from -half to half rad, and on with the same step; z of the axis and
    `reach`, the largest distance from it that counts, in mm.

    Between two of these angles everything is taken as straight. A prism's arc that ends between them ends on
    a chord; what turns itself should end on one of them, or where nothing touches it.
    """

    centre: float
    half: float
    reach: float

    def angles(self, low: float, high: float, tolerance: float) -> Array:
        """Return the grid's angles from `low` to `high` rad and these two, ascending; a turn between two of
        them rises by less than half of `tolerance` mm over its chord."""
        steps = self._steps(tolerance)
        first = math.floor((low / self.half + 1) * steps / 2) - 1
        last = math.ceil((high / self.half + 1) * steps / 2) + 1
        inner = self.half * (2 * np.arange(first, last + 1) / steps - 1)
        step = 2 * self.half / steps
        return np.array([low, *inner[(inner > low + _SAME * step) & (inner < high - _SAME * step)], high])

    def shrunk(self, angle: float, tolerance: float) -> float:
        """Return by which share an arm is shorter at this angle than on the grid: 1 less a chord's rise."""
        step = 2 * self.half / self._steps(tolerance)
        past = math.remainder(angle - self.half, step)
        if abs(past) < _SAME * step:
            return 0.0
        beside = step / 2 - abs(past)  # from the middle of the chord
        return 1 - math.cos(step / 2) / math.cos(beside)

    def arc(self, low: float, high: float, tolerance: float) -> Array:
        """Return the back, z = 0 at y = 0, from `low` to `high` rad as chords, `(n, 2)` mm of y and z."""
        angles = self.angles(low, high, tolerance)
        rise = self.centre * np.array([self.shrunk(float(angle), tolerance) for angle in angles])
        arm = self.centre - rise
        return np.column_stack([arm * np.sin(angles), rise + 2 * arm * np.sin(angles / 2) ** 2])

    def _steps(self, tolerance: float) -> int:
        return turn_steps(2 * self.half, self.reach, tolerance / 2)


def turn_steps(angle: float, arm: float, tolerance: float) -> int:
    """Return how many even steps of a turn by `angle` rad keep an arm's chords within a tolerance, mm."""
    widest = 4 * math.asin(min(1.0, math.sqrt(tolerance / (2 * (arm + tolerance)))))
    return max(1, math.ceil(angle / widest))


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
    buried: float = 0.0  # mm3 of it, in the body that it is added to: they don't count
    axis: ClassVar[Literal["turn"]] = "turn"

    @property
    def volume(self) -> float:
        """Moment of the area about the axis times the angle, less what is buried, mm3: Pappus's second
        theorem."""
        moment = self._moment(self.outline) - math.fsum(self._moment(h) for h in self.holes)
        return abs(moment) * (self.high - self.low) - self.buried

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
class TurnedBody:
    """A loop (t, n) at t >= 0 turned fully about the axis through `origin` mm along the unit vector
    `direction`: t is the distance from the axis, n the height along it. A solid one closes along t = 0.

    `buried` mm3 of it don't count: what lies in the body that it is added to, or in what is cut besides it.
    A cut may be a `piece_of` one that another part has the rest of.
    """

    outline: Loop
    origin: Vector
    direction: Vector
    buried: float = 0.0
    role: CutRole | None = None  # where it is a cut
    piece_of: TurnedBody | None = None
    axis: ClassVar[Literal["full"]] = "full"

    @property
    def volume(self) -> float:
        """First moment of the loop about the axis, times a whole turn, less what is buried, mm3: Pappus."""
        return 2 * math.pi * curves.moments(self.outline)[1] - self.buried

    def frame(self) -> Array:
        """Return the rotation `(3, 3)` from (t, across, n) to the mold's frame; at the turn 0 t has no y."""
        x, _, z = self.direction
        flat = math.hypot(x, z)
        first = np.array([z, 0.0, -x]) / flat if flat > 0 else np.array([1.0, 0.0, 0.0])
        across = np.cross(self.direction, first)
        return np.column_stack([first, across, self.direction])

    def placed(self, points: Array) -> Array:
        """Return points `(n, 3)` mm of the own frame in the mold's."""
        return points @ self.frame().T + self.origin


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


@dataclass(frozen=True)
class GivenBody:
    """A solid from a user's STEP file, placed: `pose` is rotation and shift, `(3, 4)` by rows, mm. `volume`
    is what counts of it, mm3: of a cut what it takes away. `stamp` is what a changed file is known by."""

    file: str
    pose: tuple[float, ...]
    volume: float
    stamp: tuple[int, int] = (0, 0)
    role: CutRole | None = None
    axis: ClassVar[Literal["given"]] = "given"


Body = Prism | RevolvedBody | Bore | RotatedBody | ExtendedCut | TurnedBody | GivenBody


def plain(cut: Body) -> Prism | RevolvedBody | Bore | TurnedBody | GivenBody:
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


@dataclass(frozen=True)
class Part:
    """A part: its body and what is added to it, less its cuts. Cuts lie inside the body and do not meet each
    other; neither do the bodies that are added."""

    name: str  # of its files and in messages; what it is, its role says
    role: PartRole
    body: Body
    cuts: tuple[Body, ...] = ()
    end: End | None = None  # that it belongs to
    straight: Part | None = None  # whose section along y rules judge, where the part itself is bent
    adds: tuple[TurnedBody | RevolvedBody, ...] = ()

    @property
    def made(self) -> MadeBy:
        """How one comes by it."""
        return self.role.made

    @property
    def what(self) -> str:
        """What it is, in words."""
        plate = self.role is PartRole.CAVITY and any(
            isinstance(cut, TurnedBody) and cut.piece_of for cut in self.cuts
        )
        return "plate of through holes, on the base" if plate else self.role.what

    @property
    def colour(self) -> tuple[float, float, float]:
        """Red, green and blue, 0 to 1."""
        return self.role.colour

    @property
    def volume(self) -> float:
        """Volume by formula, mm3: body and what is added, less cuts."""
        added = math.fsum(body.volume for body in self.adds)
        return self.body.volume + added - math.fsum(cut.volume for cut in self.cuts)


def drilled(
    role: CutRole,
    axis: Literal["y", "z"],
    places: Iterable[tuple[float, float]],
    low: float,
    length: float,
    radius: float,
    end_radius: float | None = None,
) -> list[Bore]:
    """Return equal bores along y or z from `low` mm, at these places (x, z) or (x, y) mm."""
    starts = [(x, low, v) if axis == "y" else (x, v, low) for x, v in places]
    return [Bore(start, axis, length, radius, end_radius, role=role) for start in starts]


def box(x: float, y: tuple[float, float], z: tuple[float, float], axis: Axis = "z") -> Prism:
    """Return a block from -x to x with these y and z ranges, mm."""
    if axis == "z":
        return Prism(curves.rectangle(-x, x, *y), "z", *z)
    return Prism(curves.rectangle(-x, x, *z), "y", *y)


def disc(radius: float, low: float, high: float) -> Prism:
    """Return a disc about z between two levels, mm."""
    return Prism(curves.circle(0.0, 0.0, radius), "z", low, high)


_Body = TypeVar("_Body", bound=Body)


def moved(body: _Body, x: float) -> _Body:
    """Return a body moved by `x` mm along x."""
    if isinstance(body, RotatedBody):
        if x == 0.0:
            return body
        raise ValueError("a bent mold has one skin and nothing to move aside")
    if isinstance(body, GivenBody):
        shift = body.pose[3] + x
        return replace(body, pose=(*body.pose[:3], shift, *body.pose[4:]))
    if isinstance(body, ExtendedCut):
        return replace(body, counts=moved(body.counts, x), built=moved(body.built, x))
    if isinstance(body, TurnedBody):
        return replace(body, origin=(body.origin[0] + x, *body.origin[1:]))
    if not isinstance(body, Bore):
        holes = tuple(shifted(hole, x) for hole in body.holes)
        return replace(body, outline=shifted(body.outline, x), holes=holes)
    return replace(body, start=(body.start[0] + x, *body.start[1:]))


def shifted(segments: Loop, x: float, z: float = 0.0) -> Loop:
    """Return segments moved by `x` and `z` mm."""

    def moved_on(point: Point) -> Point:
        return Point(point.x + x, point.z + z)

    return tuple(replace(s, start=moved_on(s.start), end=moved_on(s.end)) for s in segments)


def mirrored(outline: Loop) -> Loop:
    """Return a loop with its first coordinate's sign changed, still counterclockwise."""
    return tuple(
        replace(s, start=Point(-s.end.x, s.end.z), end=Point(-s.start.x, s.start.z))
        for s in reversed(outline)
    )


def unturned(part: Part) -> Part:
    """Return a turned part as it is before it is turned, any other as it is."""
    if not isinstance(part.body, RotatedBody):
        return part
    cuts = tuple(cut.body if isinstance(cut, RotatedBody) else cut for cut in part.cuts)
    return replace(part, body=part.body.body, cuts=cuts)


def bores(part: Part, *roles: CutRole) -> list[Bore]:
    """Return the bores of a part, all or those of these roles, each in its own frame."""
    cuts = [plain(cut) for cut in part.cuts if not roles or cut.role in roles]
    return [cut for cut in cuts if isinstance(cut, Bore)]


def turned(part: Part, centre: float, angle: float, base: float) -> Part:
    """Return a part of prisms and bores turned as a rigid body; `unturned` takes it back."""

    def placed(body: Body) -> RotatedBody:
        if not isinstance(body, Prism | Bore):
            raise ValueError(f"{part.name}: prisms and bores are turned, once")
        return RotatedBody(body, centre, angle, base)

    return replace(part, body=placed(part.body), cuts=tuple(placed(cut) for cut in part.cuts))
