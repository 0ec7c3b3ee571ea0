"""Where a hole's tag finds room beside it: not on other words and circles, and on few lines."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from skincad.base.arrays import Array
from skincad.pictures.marks import Box, Dimension, Words, diameter, overlap
from skincad.solids.projection import Place, Polyline, Stroke

ANGLES = tuple(math.radians(a) for a in (45, 135, -45, -135, 20, 160, -20, -160, 70, 110, -70, -110))
REACHES = (3.2, 4.5, 6.5, 9.0, 12.0, 16.0)  # mm, from a circle's rim to its tag's foot: past the arrow
LINE, FAR, WORD = 1.0, 0.25, 40.0  # assumption: cost of a crossed line, a millimetre further, a covered word
CLEAR = 0.6  # mm, of a tag from lines and other words
LEADER = 6  # points of a leader that are tested for collisions


class Room:
    """Occupied places of a sheet: boxes of words and circles, and strokes; grows as words are placed."""

    def __init__(self, limits: Box) -> None:
        self.limits = limits
        self.blocked: list[Box] = []
        self._lines: list[tuple[float, float, float, float, float]] = []

    def block(self, box: Box) -> None:
        """Add a rectangle that words must not cover, mm."""
        self.blocked.append(box)

    def cross(self, stroke: Stroke, weight: float = 1.0) -> None:
        """Add a stroke that words should not cross; `weight` is its cost."""
        points = (
            stroke.points if isinstance(stroke, Polyline) else tuple(stroke.at(i / 12) for i in range(13))
        )
        for (x, y), (u, v) in pairwise(points):
            self._lines.append((min(x, u), min(y, v), max(x, u), max(y, v), weight))

    def settle(self) -> None:
        """Prepare the strokes for `cost`."""
        self._boxes: Array = np.array(self._lines or [(0.0, 0.0, -1.0, -1.0, 0.0)])

    def cost(self, box: Box) -> float:
        """Return the cost of words in a rectangle."""
        left, low, right, high = self.limits
        if box[0] < left or box[1] < low or box[2] > right or box[3] > high:
            return 10 * WORD
        b = self._boxes
        crossed = (b[:, 0] < box[2]) & (b[:, 2] > box[0]) & (b[:, 1] < box[3]) & (b[:, 3] > box[1])
        return LINE * min(30.0, float(b[crossed, 4].sum())) + WORD * self.covered(box)

    def covered(self, box: Box) -> int:
        """Return how many blocked rectangles share more than an edge with this one."""
        return sum(overlap(box, other) for other in self.blocked)

    def pierced(self, points: list[Place], centre: Place) -> int:
        """Return how many blocked rectangles hold one of these points, without those that hold `centre`."""
        return sum(
            any(_inside(box, point) for point in points) for box in self.blocked if not _inside(box, centre)
        )


def _inside(box: Box, point: Place) -> bool:
    return box[0] < point[0] < box[2] and box[1] < point[1] < box[3]


def tagged(
    centre: Place, radius: float, text: str, measured: tuple[float, float], height: float, room: Room
) -> Dimension:
    """Return a circle's diameter with its tag where it costs least. `measured`: the part's diameter, mm, and
    the view's scale."""
    best: tuple[float, float, Words] | None = None
    for reach in REACHES:
        for angle in ANGLES:
            c, s = math.cos(angle), math.sin(angle)
            x, y = centre[0] + (radius + reach) * c, centre[1] + (radius + reach) * s
            words = Words(text, (x, y + 0.4), height, "DIMENSIONS", "start" if c > 0 else "end")
            left, low, right, high = words.box()
            cost = room.cost((left - CLEAR, low - CLEAR, right + CLEAR, high + CLEAR)) + FAR * reach
            leader = [radius + reach * i / LEADER for i in range(1, LEADER + 1)]
            cost += WORD * room.pierced([(centre[0] + r * c, centre[1] + r * s) for r in leader], centre)
            if best is None or cost < best[0] - 1e-9:
                best = cost, angle, words
        if best and best[0] < LINE + FAR * reach:
            break
    if best is None:
        raise ValueError("there are angles and reaches to choose from")
    _, angle, words = best
    room.block(words.box())
    return replace(diameter(centre, radius, angle, measured[1], words), measured=measured[0])
