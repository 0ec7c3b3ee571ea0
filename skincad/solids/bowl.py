"""The bowl of a doubly curved mold in the plane (y, z): the back's arc, the ends' planes, what is between.

The axis lies at y = 0 above; heights count from the back's middle, z = 0; angles from y = 0 towards +y.
"""

from __future__ import annotations

import math
from dataclasses import replace

from skincad.shape.curves import Loop, Point, Segment
from skincad.solids.body import Prism
from skincad.solids.grid import Grid
from skincad.solids.plan import mirrored
from skincad.solids.split import path


def height(grid: Grid, angle: float) -> float:
    """Return the height of the skin's back at an angle, mm."""
    return 2 * grid.centre * math.sin(angle / 2) ** 2


def half_length(grid: Grid, z: float, inside: float = 0.0) -> float:
    """Return the half length at the height z between the ends' planes, or planes `inside` them, mm."""
    return ((grid.centre - z) * math.sin(grid.half) - inside) / math.cos(grid.half)


def rise(grid: Grid, y: float) -> float:
    """Return the height of the back at y, mm."""
    return y * y / (grid.centre + math.sqrt(grid.centre**2 - y * y))


def seat(grid: Grid, half: float, top: float, inside: float = 0.0) -> Loop:
    """Return the outline (y, z) from the back's arc, -half to half rad, up to a flat top."""
    low, high = (Point(grid.centre * math.sin(a), height(grid, a)) for a in (-half, half))
    wide = half_length(grid, top, inside)
    return (Segment(low, high, math.tan(half / 2)), *path([high, Point(wide, top), Point(-wide, top), low]))


def gap_beside(carrier: Prism, gap: float) -> list[Prism]:
    """Return the gap round a carrier of this mold, down to its ledge: along both sides, and at both ends."""
    grid, top = carrier.grid, max(s.start.z for s in carrier.outline)
    if grid is None:
        raise ValueError("a straight carrier's gap is a frame")
    arc = carrier.outline[0]
    corner = Point(half_length(grid, top, gap), top)
    high = Point(grid.centre * math.sin(grid.half), height(grid, grid.half))
    rest = grid.half - math.asin(arc.end.x / grid.centre)
    turn = math.tan(rest / 4)
    end = (Segment(arc.end, high, turn), *path([high, Point(half_length(grid, top), top), corner, arc.end]))
    whole = seat(grid, grid.half, top)
    return [
        replace(carrier, outline=whole, low=carrier.high, high=carrier.high + gap),
        replace(carrier, outline=whole, low=carrier.low - gap, high=carrier.low),
        replace(carrier, outline=end),
        replace(carrier, outline=mirrored(end)),
    ]
