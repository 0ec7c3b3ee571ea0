"""Energy, stress and stiffness of a solid body at its points, by its law of rubber.

What a law has more than neo-Hooke's at points in three dimensions: energy, stress and tangent, by the
principal stretches. In units of the shear modulus; laws are in skincad/laws. With C = F^T F of eigenvalues L
and x = xi(C) - p ln J (laws/rubber.py), xi's slope by C is f(C) / 2 of f(L) = sum of m_k (2 / a_k) L^(a_k / 2
- 1), and p = f(1). Second derivatives of f(C) are its divided differences in C's eigenvectors: Ogden, Non-
linear Elastic Deformations, 1984, sec. 6.1.4.

All elements have neo-Hooke's law; those with another law add its excess.

Pressures of order - 2 along y (prisms.py) do not see the volume change of some waves along y. Under a
pressure of about G such waves grow without resistance (plain-ridges: from 1.5 N on, ends clamped or free; in
plane strain not up to 6 N). So a part `pointwise_bulk` of the bulk modulus acts on the volume change itself,
point by point, and the rest by the pressure: the same law, and with functions fine enough the same solution.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.laws.rubber import Rubber
from skincad.mechanics.bodies.plane_body import dilatation, strain_energy

# Relative distance of two eigenvalues below which a divided difference is its series, exact to 5e-11 for
# powers from -14 to 14; the quotient above loses 3 digits at most
CLOSE = 1e-3
CHUNK = 32  # elements at a time: their strains take six times a basis's memory, and then fit into the cache
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))


@dataclass(frozen=True)
class Excess:
    """A law's excess at the points `(e, g)` of the elements numbered `elements` `(e,)`: at F `deformed`
    `(e, g, 3, 3)` with J - 1 `swell` `(e, g)`."""

    law: Rubber
    elements: Index
    deformed: Array
    swell: Array

    @cached_property
    def _eigen(self) -> tuple[Array, Array]:
        """C's eigenvalues `(e, g, 3)`, and its eigenvectors as columns `(e, g, 3, 3)`."""
        square, axes = np.linalg.eigh(np.swapaxes(self.deformed, -1, -2) @ self.deformed)
        return square, axes

    @cached_property
    def _slopes(self) -> tuple[Array, Array]:
        """f'(x) and f''(x) `(e, g)`."""
        return self.law.slopes(_measure(self.law, self._eigen[0], self.swell))

    @cached_property
    def _moved(self) -> Array:
        """C's axes times F `(e, g, component, axis)`."""
        return self.deformed @ self._eigen[1]

    @cached_property
    def _pulls(self) -> Array:
        """f(L) `(e, g, 3)`."""
        return _pull(self.law, self._eigen[0])

    @property
    def volume(self) -> Array:
        """Factor of ln J in the excess, to first order: 1 - p f'(x)."""
        return np.asarray(1 - _pull(self.law, np.ones(1))[0] * self._slopes[0])

    def stress(self) -> Array:
        """Return the nominal stress `(e, g, component, axis)`, that of ln J apart."""
        return self._drawn(self._slopes[0][..., None] * self._pulls - 1)

    def _drawn(self, by_axis: Array) -> Array:
        """F times what has the eigenvalues `by_axis` `(e, g, 3)` on C's axes."""
        return np.asarray((self._moved * by_axis[..., None, :]) @ np.swapaxes(self._eigen[1], -1, -2))

    def stiffness(self, cofactor: Array, basis: Array, weight: Array) -> Array:
        """Return the elements' stiffness `(e, 3 b, 3 b)`, ln J's apart, at points of `weight` `(e, g)`."""
        size = 3 * basis.shape[-1]
        blocks = np.empty((len(self.elements), size, size))
        for first in range(0, len(self.elements), CHUNK):
            some = slice(first, first + CHUNK)
            blocks[some] = self._stiffness(some, cofactor[some], basis[some], weight[some])
        return blocks

    def _stiffness(self, some: slice, cofactor: Array, basis: Array, weight: Array) -> Array:
        count, points, _, b = basis.shape
        moved, slope, pull = self._moved[some], self._slopes[0][some], self._pulls[some]
        axes = np.swapaxes(self._eigen[1][some], -1, -2)
        along = axes @ basis  # the functions' gradients by C's axes
        rows = np.empty((count, points, len(PAIRS) + 1, 3, b))
        factor = np.empty((count, points, len(PAIRS) + 1))
        for place, (i, j) in enumerate(PAIRS):
            rows[:, :, place] = moved[..., i, None] * along[:, :, None, j]
            rows[:, :, place] += moved[..., j, None] * along[:, :, None, i]
            # rows are twice the strain; off the diagonal it counts twice
            factor[:, :, place] = slope * self._divided(some, i, j) / (2 if i == j else 1)
        ends = _pull(self.law, np.ones(1))[0] / (1 + self.swell[some])
        by_gradient = (moved * pull[..., None, :]) @ axes - ends[..., None, None] * cofactor
        rows[:, :, -1] = by_gradient @ basis
        factor[:, :, -1] = self._slopes[1][some]
        flat = rows.reshape(count, -1, 3 * b)
        weighted = flat * (factor * weight[..., None]).reshape(count, -1, 1)
        product = np.swapaxes(weighted, 1, 2) @ flat
        turning = along * ((slope[..., None] * pull - 1) * weight[..., None])[..., None]
        block = np.swapaxes(turning.reshape(count, -1, b), 1, 2) @ along.reshape(count, -1, b)
        for k in range(3):
            product[:, k * b : (k + 1) * b, k * b : (k + 1) * b] += block
        return np.asarray(product)

    def _divided(self, some: slice, i: int, j: int) -> Array:
        """(f(Li) - f(Lj)) / (Li - Lj), and its limit."""
        one, other = self._eigen[0][some, :, i], self._eigen[0][some, :, j]
        middle, difference = (one + other) / 2, one - other
        near = np.abs(difference) < CLOSE * middle
        series = _pull(self.law, middle, 1) + _pull(self.law, middle, 3) * difference**2 / 24
        exact = (self._pulls[some, :, i] - self._pulls[some, :, j]) / np.where(near, 1.0, difference)
        return np.where(near, series, exact)


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


# The part of the bulk modulus that acts without the pressure: in G, so that Lame's constant there is G
# instead of -2 G/3, but at most half of it, so that nu = 0 has a pressure too. Measured on plain-ridges: it
# reaches 11 N (plane strain 12 N); with 4 or 10 finite strain's change of the all-touch force and of the
# approach differs by 5e-4
POINTWISE_BULK = 5 / 3
NEXT = ((0, 1, 2), (1, 2, 0), (2, 0, 1))  # axes in cyclic order


@dataclass(frozen=True)
class Elements:
    """e elements with g points of `weight` `(e, g)` in volume, b functions of displacements, q of pressure.

    `basis` `(e, g, 3, b)` are the functions' gradients by the three axes, `test` `(e, g, q)` the pressure
    functions; moduli are `(e, 1)`. `laws` are laws with the numbers of the elements that have them; all
    others are neo-Hookean.
    """

    weight: Array
    basis: Array
    test: Array
    shear: Array
    whole_bulk: Array
    laws: tuple[tuple[Rubber, Index], ...] = ()

    @cached_property
    def pointwise_bulk(self) -> Array:
        """The part of the bulk modulus that acts without the pressure."""
        return np.minimum(POINTWISE_BULK * self.shear, self.whole_bulk / 2)

    @cached_property
    def bulk(self) -> Array:
        """The rest of the bulk modulus."""
        return self.whole_bulk - self.pointwise_bulk

    @cached_property
    def stretch(self) -> Array:
        """The stiffness of G F:F / 2 `(e, b, b)`."""
        pulled = _flat(self.basis) * np.repeat(self.weight * self.shear, 3, axis=1)[:, :, None]
        return np.swapaxes(pulled, 1, 2) @ _flat(self.basis)

    @cached_property
    def softening(self) -> Array:
        """The inverse of the pressures' part `(e, q, q)`."""
        terms = np.swapaxes(self.test * (self.weight / self.bulk)[:, :, None], 1, 2) @ self.test
        return np.linalg.inv(terms).astype(np.float64)


@dataclass(frozen=True)
class Points:
    """Elements at a state, at their points `(e, g)`: F `(e, g, component, axis)`, its cofactors dJ/dF, J - 1
    and the pressure; `excess` is what laws have more than neo-Hooke's."""

    of: Elements
    deformed: Array
    cofactor: Array
    swell: Array
    pressure: Array
    excess: tuple[Excess, ...] = ()

    @property
    def volume_stress(self) -> Array:
        """Derivative of the energy by J `(e, g)`: what multiplies the cofactors in the stress."""
        of = self.of
        stress = (
            self.pressure - of.shear / (1 + self.swell) + (of.pointwise_bulk - 2 / 3 * of.shear) * self.swell
        )
        for more in self.excess:
            stress[more.elements] += of.shear[more.elements] * more.volume / (1 + more.swell)
        return stress


def points(of: Elements, displacement: Array, pressure: Array) -> Points:
    """Return the points at nodal displacements `(e, 3, b)` and pressures `(e, q)`."""
    gradient, at_points = _gradient(of, displacement), _pressure(of, pressure)
    deformed = gradient + np.eye(3)
    cofactor = np.stack([np.cross(deformed[:, :, j], deformed[:, :, k]) for _, j, k in NEXT], axis=2)
    swell = _swelling(gradient)
    excess = tuple(Excess(law, numbers, deformed[numbers], swell[numbers]) for law, numbers in of.laws)
    return Points(of, deformed, cofactor, swell, at_points, excess)


def energy(of: Elements, displacement: Array, pressure: Array) -> float:
    """Return the energy; infinite where a point is turned inside out."""
    gradient = _gradient(of, displacement)
    swell = _swelling(gradient)
    if (swell <= -1).any():
        return np.inf
    h = np.moveaxis(gradient, (2, 3), (0, 1))
    density = strain_energy(h, _pressure(of, pressure), of.shear, of.bulk, np.log)
    for law, numbers in of.laws:
        density[numbers] += of.shear[numbers] * excess_density(
            law, gradient[numbers] + np.eye(3), swell[numbers]
        )
    return float((of.weight * (density + of.pointwise_bulk / 2 * swell * swell)).sum())


def forces(at: Points) -> tuple[Array, Array]:
    """Return the energy's derivatives by displacements `(e, 3, b)` and by pressures `(e, q)`."""
    of = at.of
    stress = of.shear[:, :, None, None] * at.deformed + at.volume_stress[:, :, None, None] * at.cofactor
    for more in at.excess:
        stress[more.elements] += of.shear[more.elements][:, :, None, None] * more.stress()
    by_axis = _flat(np.swapaxes(stress * of.weight[:, :, None, None], 2, 3))
    tested = (at.swell - at.pressure / of.bulk) * of.weight
    return np.swapaxes(by_axis, 1, 2) @ _flat(of.basis), (tested[:, None] @ of.test)[:, 0]


def coupling(at: Points) -> Array:
    """Return the second derivative by pressures and displacements `(e, q, 3 b)`."""
    weighted = at.of.test * at.of.weight[:, :, None]
    return np.asarray(np.swapaxes(weighted, 1, 2) @ _rows(at.cofactor, at.of.basis))


def stiffness(at: Points, coupled: Array) -> Array:
    """Return each element's stiffness `(e, 3 b, 3 b)`, its pressures condensed; `coupled` is `coupling`."""
    of = at.of
    bend = ((1 / (1 + at.swell) ** 2 - 2 / 3) * of.shear + of.pointwise_bulk) * of.weight
    for more in at.excess:
        numbers = more.elements
        bend[numbers] -= of.shear[numbers] * more.volume / (1 + more.swell) ** 2 * of.weight[numbers]
    turn = at.deformed * (at.volume_stress * of.weight)[:, :, None, None]
    count, _, _, b = of.basis.shape
    matrix = np.empty((count, 3 * b, 3 * b))
    for first in range(0, count, CHUNK):  # what stays in the processor's cache takes half the time
        some = slice(first, first + CHUNK)
        matrix[some] = _stiffness(of.basis[some], at.cofactor[some], bend[some], turn[some])
        matrix[some] += np.swapaxes(coupled[some], 1, 2) @ (of.softening[some] @ coupled[some])
    blocks = matrix.reshape(count, 3, b, 3, b)
    for k in range(3):
        blocks[:, k, :, k] += of.stretch
    for more in at.excess:
        numbers = more.elements
        matrix[numbers] += more.stiffness(
            at.cofactor[numbers], of.basis[numbers], of.shear[numbers] * of.weight[numbers]
        )
    return matrix


def _stiffness(basis: Array, cofactor: Array, bend: Array, turn: Array) -> Array:
    """Return what the energy's second derivative by J, `bend` `(e, g)`, and J's own add to the stiffness;
    `turn` `(e, g, 3, 3)` is F times the derivative by J."""
    count, points, _, b = basis.shape
    rows, flat = _rows(cofactor, basis), np.swapaxes(_flat(basis), 1, 2)
    matrix = np.swapaxes(rows * bend[:, :, None], 1, 2) @ rows
    blocks, crossed = matrix.reshape(count, 3, b, 3, b), np.empty((count, points, 3, b))
    for k, i, j in NEXT:  # the second derivative of J couples components i and j by the third's row of F
        for axis, m, n in NEXT:
            np.multiply(basis[:, :, m], turn[:, :, k, n, None], out=crossed[:, :, axis])
            crossed[:, :, axis] -= basis[:, :, n] * turn[:, :, k, m, None]
        block = flat @ _flat(crossed)
        blocks[:, i, :, j] += block
        blocks[:, j, :, i] -= block
    return np.asarray(matrix)


def _rows(cofactor: Array, basis: Array) -> Array:
    """How each displacement of an element changes J at its points, `(e, g, 3 b)`."""
    rows = cofactor @ basis
    return np.asarray(rows.reshape(*rows.shape[:2], -1))


def _gradient(of: Elements, displacement: Array) -> Array:
    """Displacement gradient `(e, g, component, axis)`."""
    count, points, axes, _ = of.basis.shape
    gradient = _flat(of.basis) @ np.swapaxes(displacement, 1, 2)
    return np.asarray(np.swapaxes(gradient.reshape(count, points, axes, 3), 2, 3))


def _swelling(gradient: Array) -> Array:
    return np.asarray(dilatation(np.moveaxis(gradient, (2, 3), (0, 1))))


def _pressure(of: Elements, pressure: Array) -> Array:
    return np.asarray((of.test @ pressure[:, :, None])[:, :, 0])


def _flat(points: Array) -> Array:
    """Points and axes of each element, `(e, g, 3, ...)`, as one axis."""
    return points.reshape(points.shape[0], -1, points.shape[-1])
