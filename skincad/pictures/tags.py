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
REACHES = (2.0, 3.5, 5.5, 8.5, 12.0, 16.0)  # mm, from a circle's rim to its tag's foot
LINE, FAR, WORD = (
    1.0,
    0.25,
    40.0,
)  # assumption: what a crossed line, a millimetre further, a covered word cost


class Room:
    """What is taken on a sheet: boxes of words and circles, and strokes; grows as words are placed."""

    def __init__(self, limits: Box) -> None:
        self.limits = limits
        self.taken: list[Box] = []
        self._lines: list[tuple[float, float, float, float, float]] = []

    def block(self, box: Box) -> None:
        """Take a rectangle, mm."""
        self.taken.append(box)

    def cross(self, stroke: Stroke, weight: float = 1.0) -> None:
        """Take a stroke, which words rather don't cross: the less, the more it weighs."""
        points = (
            stroke.points if isinstance(stroke, Polyline) else tuple(stroke.at(i / 12) for i in range(13))
        )
        for (x, y), (u, v) in pairwise(points):
            self._lines.append((min(x, u), min(y, v), max(x, u), max(y, v), weight))

    def settle(self) -> None:
        """Make the strokes ready to be asked for."""
        self._boxes: Array = np.array(self._lines or [(0.0, 0.0, -1.0, -1.0, 0.0)])

    def cost(self, box: Box) -> float:
        """Return what it costs to put words into a rectangle."""
        left, low, right, high = self.limits
        if box[0] < left or box[1] < low or box[2] > right or box[3] > high:
            return 10 * WORD
        b = self._boxes
        crossed = (b[:, 0] < box[2]) & (b[:, 2] > box[0]) & (b[:, 1] < box[3]) & (b[:, 3] > box[1])
        return LINE * min(12.0, float(b[crossed, 4].sum())) + WORD * sum(
            overlap(box, other) for other in self.taken
        )


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
            foot = y if s > 0 else y - height
            words = Words(text, (x, foot + 0.4), height, "DIMENSIONS", "start" if c > 0 else "end")
            cost = room.cost(words.box()) + FAR * reach
            if best is None or cost < best[0] - 1e-9:
                best = cost, angle, words
        if best and best[0] < LINE + FAR * reach:
            break
    if best is None:
        raise ValueError("there are angles and reaches to choose from")
    _, angle, words = best
    room.block(words.box())
    return replace(diameter(centre, radius, angle, measured[1], words), measured=measured[0])
