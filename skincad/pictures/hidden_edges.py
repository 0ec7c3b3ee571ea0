"""Hidden edges on paper: of edges that would run together, only one is drawn."""

from __future__ import annotations

import math
from collections.abc import Iterable

from skincad.solids.projection import Polyline, Stroke

MIN_SPACING = 0.6  # mm, assumption: parallel hidden edges nearer than this are one on paper


def thinned(hidden: Iterable[Stroke], visible: Iterable[Stroke]) -> list[Stroke]:
    """Return hidden edges without those that would run together on paper: nearer than `MIN_SPACING` mm to
    a parallel one that is drawn, all along."""
    strokes: list[Stroke] = []
    lines: list[tuple[float, float, float, float, float]] = []  # direction, offset, from, to

    def covered(chain: Polyline) -> bool:
        angle, offset, low, high = _straight(chain)
        for other, at, start, end in ((t[0], t[1], t[2], t[3]) for t in lines):
            turn = abs((angle - other + math.pi / 2) % math.pi - math.pi / 2)
            if (
                turn < 0.05
                and abs(at - offset) < MIN_SPACING
                and start - MIN_SPACING < low
                and high < end + MIN_SPACING
            ):
                return True
        return False

    def take(chain: Polyline) -> None:
        lines.append((*_straight(chain), 0.0))

    for stroke in visible:
        if isinstance(stroke, Polyline) and len(stroke.points) == 2:
            take(stroke)
    for stroke in sorted(hidden, key=_long, reverse=True):
        if isinstance(stroke, Polyline) and len(stroke.points) == 2:
            if covered(stroke):
                continue
            take(stroke)
        elif isinstance(stroke, Polyline) and _long(stroke) < MIN_SPACING:
            continue
        strokes.append(stroke)
    return strokes


def _straight(chain: Polyline) -> tuple[float, float, float, float]:
    """A line's direction, rad, its distance from the sheet's corner and its ends along it, mm."""
    (x, y), (u, v) = chain.points[0], chain.points[-1]
    angle = math.atan2(v - y, u - x) % math.pi
    if math.pi - angle < 1e-6:
        angle = 0.0
    c, s = math.cos(angle), math.sin(angle)
    ends = sorted((x * c + y * s, u * c + v * s))
    return angle, y * c - x * s, ends[0], ends[1]


def _long(stroke: Stroke) -> float:
    (left, low), (right, high) = stroke.box()
    return math.hypot(right - left, high - low)
