"""What a work-precision diagram is read for: the Pareto front, the slope, and a law of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


def front(seconds: Sequence[float], errors: Sequence[float]) -> list[int]:
    """Return the indices, by time, of the points that no other beats in both time and error."""
    indices: list[int] = []
    for i in sorted(range(len(seconds)), key=lambda i: (seconds[i], errors[i])):
        if not indices or errors[i] < errors[indices[-1]]:
            indices.append(i)
    return indices


def slope(seconds: Sequence[float], errors: Sequence[float]) -> float | None:
    """Return p of error ~ seconds^p by least squares of the logarithms; None for fewer than two times.

    -1 says: ten times the time, a tenth of the error. Errors of 0 have no logarithm and are left out.
    """
    points = [(s, e) for s, e in zip(seconds, errors, strict=True) if e > 0]
    if len({s for s, _ in points}) < 2:
        return None
    x, y = np.log(np.array(points)).T
    return float(np.polyfit(x, y, 1)[0])


@dataclass(frozen=True)
class PowerLaw:
    """seconds = factor x unknowns^exponent; `scatter` is the rms of the fit's ratio, 1 where it is exact."""

    factor: float
    exponent: float
    scatter: float

    def seconds(self, unknowns: float) -> float:
        """Return the expected time, s."""
        return float(self.factor * unknowns**self.exponent)


def power_law(unknowns: Sequence[float], seconds: Sequence[float]) -> PowerLaw | None:
    """Return the law through measured trials by least squares of the logarithms; None below two sizes."""
    if len(set(unknowns)) < 2:
        return None
    x, y = np.log(np.array(unknowns, float)), np.log(np.array(seconds, float))
    exponent, level = np.polyfit(x, y, 1)
    off = y - (exponent * x + level)
    return PowerLaw(float(np.exp(level)), float(exponent), float(np.exp(np.sqrt(np.mean(off**2)))))
