"""What a law has more than neo-Hooke's at points in three dimensions: energy, stress and tangent, by the
principal stretches. In units of the shear modulus; laws are in skincad/laws.

With C = F^T F of eigenvalues L and x = xi(C) - p ln J (laws/rubber.py), xi's slope by C is f(C) / 2 of
f(L) = sum of m_k (2 / a_k) L^(a_k / 2 - 1), and p = f(1). Second derivatives of f(C) are its divided
differences in C's eigenvectors: Ogden, Non-linear Elastic Deformations, 1984, sec. 6.1.4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.laws.rubber import Rubber

# Relative distance of two eigenvalues below which a divided difference is its series, exact to 5e-11 for
# powers from -14 to 14; the quotient above loses 3 digits at most
CLOSE = 1e-3
CHUNK = 32  # elements at a time: their strains take six times a basis's memory
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))


@dataclass(frozen=True)
class Excess:
    """A law's excess at the points `(e, g)` of the elements `own` `(e,)`.

    `slope` and `bend` are f'(x) and f''(x); `square` `(e, g, 3)` C's eigenvalues, `axes` `(e, g, 3, 3)` its
    eigenvectors as columns, `moved` `(e, g, component, axis)` the axes times F, and `pull` `(e, g, 3)` is
    f(L); `swell` is J - 1.
    """

    law: Rubber
    own: Index
    slope: Array
    bend: Array
    square: Array
    axes: Array
    moved: Array
    pull: Array
    swell: Array

    @property
    def volume(self) -> Array:
        """Factor of ln J in the excess, to first order: 1 - p f'(x)."""
        return np.asarray(1 - _pull(self.law, np.ones(1))[0] * self.slope)

    def stress(self) -> Array:
        """Return the nominal stress `(e, g, component, axis)`, that of ln J apart."""
        return self._drawn(self.slope[..., None] * self.pull - 1)

    def _drawn(self, by_axis: Array) -> Array:
        """F times what has the eigenvalues `by_axis` `(e, g, 3)` on C's axes."""
        return np.asarray((self.moved * by_axis[..., None, :]) @ np.swapaxes(self.axes, -1, -2))

    def stiffness(self, cofactor: Array, basis: Array, weight: Array) -> Array:
        """Return the elements' stiffness `(e, 3 b, 3 b)`, ln J's apart, at points of `weight` `(e, g)`."""
        size = 3 * basis.shape[-1]
        blocks = np.empty((len(self.own), size, size))
        for first in range(0, len(self.own), CHUNK):
            some = slice(first, first + CHUNK)
            blocks[some] = self._stiffness(some, cofactor[some], basis[some], weight[some])
        return blocks

    def _stiffness(self, some: slice, cofactor: Array, basis: Array, weight: Array) -> Array:
        count, points, _, b = basis.shape
        moved, slope = self.moved[some], self.slope[some]
        along = np.swapaxes(self.axes[some], -1, -2) @ basis  # the functions' gradients by C's axes
        rows = np.empty((count, points, len(PAIRS) + 1, 3, b))
        factor = np.empty((count, points, len(PAIRS) + 1))
        for place, (i, j) in enumerate(PAIRS):
            rows[:, :, place] = moved[..., i, None] * along[:, :, None, j]
            rows[:, :, place] += moved[..., j, None] * along[:, :, None, i]
            # rows are twice the strain; off the diagonal it counts twice
            factor[:, :, place] = slope * self._divided(some, i, j) / (2 if i == j else 1)
        ends = _pull(self.law, np.ones(1))[0] / (1 + self.swell[some])
        by_gradient = self._drawn(self.pull)[some] - ends[..., None, None] * cofactor
        rows[:, :, -1] = by_gradient @ basis
        factor[:, :, -1] = self.bend[some]
        flat = rows.reshape(count, -1, 3 * b)
        weighted = flat * (factor * weight[..., None]).reshape(count, -1, 1)
        product = np.swapaxes(weighted, 1, 2) @ flat
        turning = along * ((slope[..., None] * self.pull[some] - 1) * weight[..., None])[..., None]
        block = np.swapaxes(turning.reshape(count, -1, b), 1, 2) @ along.reshape(count, -1, b)
        for k in range(3):
            product[:, k * b : (k + 1) * b, k * b : (k + 1) * b] += block
        return np.asarray(product)

    def _divided(self, some: slice, i: int, j: int) -> Array:
        """(f(Li) - f(Lj)) / (Li - Lj), and its limit."""
        one, other = self.square[some, :, i], self.square[some, :, j]
        middle, difference = (one + other) / 2, one - other
        near = np.abs(difference) < CLOSE * middle
        series = _pull(self.law, middle, 1) + _pull(self.law, middle, 3) * difference**2 / 24
        exact = (self.pull[some, :, i] - self.pull[some, :, j]) / np.where(near, 1.0, difference)
        return np.where(near, series, exact)


def excess_at(law: Rubber, points: Index, deformed: Array, swell: Array) -> Excess:
    """Return a law's excess at F `(e, g, 3, 3)` with J - 1 `(e, g)`."""
    square, axes = np.linalg.eigh(np.swapaxes(deformed, -1, -2) @ deformed)
    slope, bend = law.slopes(_measure(law, square, swell))
    return Excess(law, points, slope, bend, square, axes, deformed @ axes, _pull(law, square), swell)


def excess_density(law: Rubber, deformed: Array, swell: Array) -> Array:
    """Return the energy beyond neo-Hooke's `(e, g)`; infinite where the law has ended."""
    right = np.swapaxes(deformed, -1, -2) @ deformed
    plain = (np.trace(right, axis1=-2, axis2=-1) - 3) / 2 - np.log1p(swell)
    with np.errstate(all="ignore"):
        energy = (
            law.energy(_measure(law, np.asarray(np.linalg.eigvalsh(right), np.float64), swell), np) - plain
        )
    return np.where(np.isfinite(energy), energy, np.inf)


def _measure(law: Rubber, square: Array, swell: Array) -> Array:
    """The strain's measure x by C's eigenvalues `(e, g, 3)`."""
    strain = np.zeros_like(swell)
    for share, power in law.powers:
        both = (square ** (power / 2)).sum(axis=-1) - 3
        strain = strain + share * (2 / power**2 * both - 2 / power * np.log1p(swell))
    return strain


def _pull(law: Rubber, square: Array, times: int = 0) -> Array:
    """The slope f at C's eigenvalues, derived so many times."""
    pull = np.zeros_like(square)
    for share, power in law.powers:
        factor, exponent = share * 2 / power, power / 2 - 1
        for _ in range(times):
            factor, exponent = factor * exponent, exponent - 1
        pull += factor * square**exponent
    return pull
