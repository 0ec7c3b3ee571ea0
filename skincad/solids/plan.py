"""What a part is made of: a prism or a bore, less prisms and bores. Plain data, no CAD kernel.

One plan feeds the exact solid (`occ.py`), the print mesh (`fabrication/meshes.py`) and the volume formula,
so each can be held against the others. Lengths are mm, in the mold's frame: x across the ridges, y along
them, z up while pouring; the skin's back is at z = 0 and its ridges point down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely

from skincad import curves
from skincad.curves import Loop, Point

Axis = Literal["y", "z"]
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


Body = Prism | Bore


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


def swept(part: Part, axis: Axis, travel: float, tolerance: float) -> Part:
    """Return a part that covers everything that `part` passes through on `travel` mm along an axis.

    Exact (arcs within `tolerance` mm) for a part whose cuts all run along the axis, and for a bare prism
    moved up across its own axis; elsewhere cuts are left out, so the swept part is never too small.
    """
    if part.body.axis == axis:
        along = [c for c in part.cuts if c.axis == axis and not (isinstance(c, Bore) and c.end_radius)]
        cuts = tuple(_stretched(c, travel) for c in along)
        return replace(part, body=_stretched(part.body, travel), cuts=cuts)
    if isinstance(part.body, Bore) or travel < 0:
        raise ValueError(f"{part.name}: a pin moves along its axis only, a prism along it or up")
    shadow = _shadow(part.body.outline, travel, tolerance)
    return replace(part, body=replace(part.body, outline=shadow, holes=()), cuts=())


def _stretched(body: Body, travel: float) -> Body:
    if isinstance(body, Prism):
        return replace(body, low=body.low + min(travel, 0.0), high=body.high + max(travel, 0.0))
    x, y, z = body.start
    back = min(travel, 0.0)
    start = (x, y + back, z) if body.axis == "y" else (x, y, z + back)
    return replace(body, start=start, length=body.length + abs(travel))


def _shadow(outline: Loop, travel: float, tolerance: float) -> Loop:
    """Outline of everything that a loop's chord polygon covers while it rises by `travel` mm."""
    points = curves.polygon(outline, tolerance)
    quads = [
        shapely.Polygon([a, b, (b[0], b[1] + travel), (a[0], a[1] + travel)])
        for a, b in zip(points, np.roll(points, -1, axis=0), strict=True)
        if a[0] != b[0]
    ]
    covered = shapely.orient_polygons(shapely.union_all([shapely.Polygon(points), *quads]))
    return curves.loop([Point(x, z) for x, z in covered.exterior.coords[:-1]])
