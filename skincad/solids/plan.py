"""What a part is: its role, its body and its cuts. Plain data, no CAD kernel.

One plan feeds the exact solid (`occ.py`), the print mesh (`fabrication/meshes.py`) and the volume formula,
so each can be held against the others.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, TypeVar

from skincad.shape import curves
from skincad.shape.curves import Loop, Point
from skincad.solids.body import Axis, Body, Bore, ExtendedCut, Prism, RotatedBody, plain
from skincad.solids.roles import CutRole, End, MadeBy, PartRole


@dataclass(frozen=True)
class Part:
    """A part: its body less its cuts. Cuts lie inside the body and do not meet each other."""

    name: str  # of its files and in messages; what it is, its role says
    role: PartRole
    body: Body
    cuts: tuple[Body, ...] = ()
    end: End | None = None  # that it belongs to
    straight: Part | None = None  # whose section along y rules judge, where the part itself is bent

    @property
    def made(self) -> MadeBy:
        """How one comes by it."""
        return self.role.made

    @property
    def colour(self) -> tuple[float, float, float]:
        """Red, green and blue, 0 to 1."""
        return self.role.colour

    @property
    def volume(self) -> float:
        """Volume by formula, mm3: body less cuts."""
        return self.body.volume - math.fsum(cut.volume for cut in self.cuts)


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


_Body = TypeVar("_Body", bound=Body)


def moved(body: _Body, x: float) -> _Body:
    """Return a body moved by `x` mm along x."""
    if isinstance(body, RotatedBody | ExtendedCut):
        raise ValueError("a bent mold has one skin and nothing to move aside")
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
