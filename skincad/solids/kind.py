"""The three kinds of mold, and what differs by them: straight, doubly curved and round.

A straight mold's trough is open at both ends, which end plates close. A doubly curved one's end plates lean
inward over it. A round one's trough is closed all round: carrier and seal are discs in its block.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from skincad.inputs.design import Design
from skincad.solids.plan import Prism, box, disc


class Kind(NamedTuple):
    """A kind of mold: whether end plates close its trough, and whether they lean over it."""

    ends: bool
    leans: bool = False

    def plate(self, x: float, y: float, low: float, high: float) -> Prism:
        """Return a lid's body between two levels: of these half sizes, or a disc of the first, mm."""
        return box(x, (-y, y), (low, high)) if self.ends else disc(x, low, high)

    def apart(self, x: float, y: float) -> tuple[float, float]:
        """Return how far a place is from the middle, by which it nears the edges, mm: along x and y, or round
        the middle for both."""
        return (x, y) if self.ends else (math.hypot(x, y), math.hypot(x, y))

    def along_edge(self, x: float, y: float) -> tuple[float, float]:
        """Return the place that is y along the edge from (x, 0), mm."""
        return (x, y) if self.ends else (x * math.cos(y / x), x * math.sin(y / x))

    @property
    def corner(self) -> float:
        """Where corners stand, as a share of the half sizes: a disc's are on its diagonals."""
        return 1.0 if self.ends else math.sqrt(0.5)


STRAIGHT, BENT, ROUND = Kind(ends=True), Kind(ends=True, leans=True), Kind(ends=False)


def kind_of(design: Design) -> Kind:
    """Return the kind of a design's mold."""
    if design.skin.round:
        return ROUND
    return STRAIGHT if math.isinf(design.skin.radius_y) else BENT
