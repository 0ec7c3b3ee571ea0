"""Ringing of a mass on a spring about its quasi-static response: closed form.

Under a load f(t) of straight lines, x'' + 2 z w x' + w^2 x = w^2 f, x follows f, less what damping makes it
lag, and rings: a corner, where the slope changes by s, adds x'' = s w^2 / w_d exp(-z w t) sin(w_d t) with
w_d = w sqrt(1 - z^2). Clough and Penzien, Dynamics of Structures, sec. 5.3 and 6.1. Reference: the equation
of motion integrated in time (tests/mechanics/dynamics/test_ringing.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array

RETARDATION = 2.4e-5  # s; assumption, docs/facts.md#friction-and-motion
MOST_DAMPED = 0.99  # of critical damping; beyond it nothing rings
SAMPLES_PER_CORNER = 65  # at two periods of ringing after each corner


@dataclass(frozen=True)
class Ringer:
    """An angular frequency w, 1/s, and its damping z, relative to the critical one, below 1."""

    frequency: float
    damping: float

    @property
    def period(self) -> float:
        """Time from one swing to the next, s."""
        return 2 * math.pi / (self.frequency * math.sqrt(1 - self.damping**2))

    def rings(self, corners: Array, values: Array, times: Array) -> Array:
        """Return -x'' / w^2, how far x is from a load less its lag, at `times` `(m, k)` s.

        The load is `values` `(n,)` at `corners` `(n,)` s, m at most n, straight in between and constant after
        the last, x at rest until the first. Times of row i follow corner i, and the next one follows them. In
        the unit of `values`.
        """
        slopes = np.diff(values) / np.diff(corners)
        turns = np.diff(slopes, prepend=0.0, append=0.0)[: len(times)]
        swing = self.frequency * complex(-self.damping, math.sqrt(1 - self.damping**2))
        states, now, last = np.zeros(len(times), dtype=complex), 0j, corners[0]
        for i, turn in enumerate(turns):
            now = now * np.exp(swing * (corners[i] - last)) - turn / swing.imag
            states[i], last = now, corners[i]
        return np.asarray((states[:, None] * np.exp(swing * (times - corners[: len(times), None]))).imag)


def ringer(stiffness: float, mass: float) -> Ringer:
    """Return how `mass`, tonne, swings on a spring of silicone, `stiffness` N/mm, damped by the assumed
    retardation time."""
    frequency = math.sqrt(stiffness / mass)
    return Ringer(frequency, min(frequency * RETARDATION / 2, MOST_DAMPED))
