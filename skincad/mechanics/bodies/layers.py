"""Elements along y: the half length from the middle, y = 0, to the pad's end, graded towards the end."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre

from skincad.base.arrays import Array
from skincad.mechanics.bodies.elements import lobatto


@dataclass(frozen=True)
class AlongY:
    """Integrals over y of n displacement functions w and q pressure functions r.

    `at` `(n,)` are the functions' points, `weight` `(n,)` what length each stands for. `mass` is w_i w_j,
    `slope` w_i w_j', `stiff` w_i' w_j', all `(n, n)`; `mean` r_i w_j, `rise` r_i w_j', both `(q, n)`;
    `inverse` `(q, q)` is the inverse of r_i r_j. `fine` `(f, n)` samples the functions evenly.
    """

    at: Array
    weight: Array
    mass: Array
    slope: Array
    stiff: Array
    mean: Array
    rise: Array
    inverse: Array
    fine: Array


@dataclass(frozen=True)
class Inside:
    """A layer of thickness 1 at its Gauss points `(g,)` of these weights: displacement functions `value`,
    their `slope`, both `(g, order + 1)`, and the pressure functions `test` `(g, order - 1)`."""

    weight: Array
    value: Array
    slope: Array
    test: Array


def inside(order: int) -> Inside:
    """Return a layer's functions; exact for what `line` integrates."""
    gauss, weight = legendre.leggauss(order + 1)
    value, slope = _lagrange(lobatto(order)[0], (gauss + 1) / 2)
    test: Array = legendre.legvander(gauss, order - 2).astype(np.float64)
    return Inside(weight / 2, value, slope, test)


def constant() -> AlongY:
    """Return the line of plane strain: one function, 1, over a length of 1."""
    one, zero = np.ones((1, 1)), np.zeros((1, 1))
    return AlongY(np.zeros(1), np.ones(1), one, zero, zero, one, zero, one, one)


def graded(half: float, last: float, growth: float) -> Array:
    """Return the borders `(layers + 1,)` of layers from 0 to `half`; the last is about `last` thick, each
    one before it thicker by the factor `growth`; two layers at least."""
    count = max(2, round(np.log1p(half / last * (growth - 1)) / np.log(growth)))
    sizes = growth ** np.arange(count)[::-1]
    return np.concatenate([[0.0], np.cumsum(sizes) * half / sizes.sum()])


def line(borders: Array, order: int, samples: int = 4) -> AlongY:
    """Return Lagrange elements of order 2 or more on the layers' Gauss-Lobatto points.

    The pressure is discontinuous and of order - 2: tested with displacements along the section alone, which
    a bubble in each layer controls, it is stable times whatever pair is stable in the section (a product
    of order - 1 is not; Bernardi and Maday, Handbook of Numerical Analysis 5, 1997, sec. 24).
    """
    points, weights = lobatto(order)
    count = (borders.size - 1) * order + 1
    pressures = order - 1
    total = (borders.size - 1) * pressures
    at, weight = np.zeros(count), np.zeros(count)
    mass, slope, stiff = (np.zeros((count, count)) for _ in range(3))
    mean, rise, inverse = np.zeros((total, count)), np.zeros((total, count)), np.zeros((total, total))
    fine = []
    layer = inside(order)
    w, value, derivative, test = layer.weight, layer.value, layer.slope, layer.test
    for i, (low, high) in enumerate(pairwise(borders.tolist())):
        size = high - low
        here = slice(i * order, i * order + order + 1)
        there = slice(i * pressures, (i + 1) * pressures)
        at[here] = low + size * points
        weight[here] += size * weights
        mass[here, here] += size * (value.T * w) @ value
        slope[here, here] += (value.T * w) @ derivative
        stiff[here, here] += (derivative.T * w) @ derivative / size
        mean[there, here] = size * (test.T * w) @ value
        rise[there, here] = (test.T * w) @ derivative
        inverse[there, there] = np.linalg.inv(size * (test.T * w) @ test)
        row = np.zeros((samples, count))
        row[:, here] = _lagrange(points, np.arange(samples) / samples)[0]
        fine.append(row)
    end = np.zeros((1, count))
    end[0, -1] = 1.0
    return AlongY(at, weight, mass, slope, stiff, mean, rise, inverse, np.vstack([*fine, end]))


def _lagrange(points: Array, at: Array) -> tuple[Array, Array]:
    """Values and derivatives `(at, points)` of the Lagrange polynomials on `points` in (0, 1)."""
    degree = points.size - 1
    coefficients = np.linalg.inv(legendre.legvander(2 * points - 1, degree))
    derived = 2 * legendre.legder(coefficients, axis=0)
    value = legendre.legvander(2 * at - 1, degree) @ coefficients
    slope = legendre.legvander(2 * at - 1, max(degree - 1, 0)) @ derived
    return value, slope
