"""The tensile bar of ISO 37: its sizes and its outline with true arcs."""

from __future__ import annotations

import math
from typing import NamedTuple

from skincad.shape.curves import Loop, Point, Segment


class TensileBar(NamedTuple):
    """A dumb-bell test piece, mm: two wide ends, a narrow part, and arcs between that are tangent to both."""

    length: float
    end_width: float
    narrow_length: float
    width: float
    outer_radius: float
    inner_radius: float
    thickness: float
    gauge_length: float

    @property
    def area(self) -> float:
        """Cross-section of the narrow part, mm2."""
        return self.width * self.thickness


# source: ISO 37, dumb-bells, type 2, which is DIN 53504's S2
BAR = TensileBar(75.0, 12.5, 25.0, 4.0, 8.0, 12.5, 2.0, 20.0)
BARS = 3  # source: ISO 37 asks for at least three test pieces


def bar_outline(by: float = 1.0) -> Loop:
    """Return the bar's outline in (x, y), mm, its length along y, all sizes times `by`.

    From the narrow part an arc of the inner radius turns outward, and one of the outer radius back, both by
    the same angle, so that together they rise by what the end is wider.
    """
    both = BAR.inner_radius + BAR.outer_radius
    turn = math.acos(1 - (BAR.end_width - BAR.width) / 2 / both)
    narrow, wide = BAR.width / 2, BAR.end_width / 2
    start, end, bulge = BAR.narrow_length / 2, BAR.length / 2, math.tan(turn / 4)
    x = narrow + BAR.inner_radius * (1 - math.cos(turn))  # where the arcs meet
    y, shoulder = start + BAR.inner_radius * math.sin(turn), start + both * math.sin(turn)
    right = [  # from the lower end upward: a corner, and the bulge of what begins there
        (wide, -end, 0.0),
        (wide, -shoulder, bulge),
        (x, -y, -bulge),
        (narrow, -start, 0.0),
        (narrow, start, -bulge),
        (x, y, bulge),
        (wide, shoulder, 0.0),
        (wide, end, 0.0),
    ]
    whole = [*right, *((-x, -y, bulge) for x, y, bulge in right)]
    corners = [Point(by * x, by * y) for x, y, _ in whole]
    onward = [*corners[1:], corners[0]]
    return tuple(Segment(a, b, bulge) for a, b, (*_, bulge) in zip(corners, onward, whole, strict=True))
