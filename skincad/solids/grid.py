"""Angles at which meshes divide what turns about an axis along x: one grid for all parts of a mold."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array

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
