"""How fast pad and plate ring, and what a history of straight lines makes them ring.

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
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.silicone import Silicone
from skincad.mechanics.validity import through_base
from skincad.shape.skin import skin_of


def shear_frequency(shear: float, density: float, height: float) -> float:
    """Return the lowest frequency, Hz, of a layer bonded below and free above, sqrt(G / rho) / (4 h).

    `shear` MPa, `density` kg/m3, `height` mm.
    """
    return math.sqrt(shear / (1e-12 * density)) / (4 * height)


def layer_period(design: Design) -> float:
    """Return the slowest period of a skin as a layer of its thickness and of its mean height, s; ridges
    count with the share of the base that they cover, layers with the time in which a wave runs through."""
    skin, own = skin_of(design), silicone(design)
    ridges = float(np.mean(skin.heights)) * skin.profile.mean_width / skin.pitch

    def part(thickness: float, stuff: Silicone) -> float:
        shear = stuff.young_modulus.value / (2 * (1 + stuff.poisson_ratio))
        return 1 / shear_frequency(shear, stuff.density, thickness) if thickness else 0.0

    return part(ridges, own) + sum(part(*layer) for layer in through_base(design))


RETARDATION = 2.4e-5  # s; assumption, docs/evidence/facts.md#friction-and-motion
MOST_DAMPED = 0.99  # of critical damping; beyond it nothing rings


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


FREE_TOP = 4 / math.pi**2  # of a layer's mass, at its top, gives its quarter wave: sqrt(G / rho) / (4 h)


def skin_mass(design: Design) -> float:
    """Return the mass of a skin, g, taken as a flat block, or a disc, with features of their mean widths."""
    features = math.fsum(placed.area * placed.feature.height for placed in skin_of(design).placed)
    return 1e-6 * silicone(design).density * (design.skin.area * design.skin.thickness + features)
