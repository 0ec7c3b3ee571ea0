"""The response of a network by frequency: node equations, solved as ratios of sums of products.

Node by node, currents add up to 0 and each source holds its own node (modified nodal analysis: Ho, Ruehli,
Brennan 1975). Determinants are expanded once a topology, in the elements' names: products of which an element
appears twice cancel there and not in floating point, and every term that is left has its own set of elements.
What digits are lost are those that the elements' own values leave open, also where a system of numbers has
none left (an amplifier's gain near Ropo / Rf).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from skincad.base.errors import InputError
from skincad.circuit.elements import (
    LOAD,
    OUT,
    Capacitor,
    Complex,
    Inductor,
    Network,
    Real,
    Resistor,
    Source,
    Wiring,
    equations,
)

Products = dict[int, int]  # elements, as bits of a number, to how often their product counts
Drive = tuple[tuple[str, int, int], ...]  # to which nodes' equations what product is added, how often


@dataclass(frozen=True)
class _Sum:
    """Products of what is `taken`, `(elements, m)`, by how often each counts at a power of s, `(k, m)`."""

    chosen: np.ndarray
    of_power: Real


def checked_frequencies(frequency: Real) -> Real:
    """Return the frequencies as an array, Hz; raises InputError unless all are finite and above 0."""
    array = np.atleast_1d(np.asarray(frequency, float))
    bad = array[~(np.isfinite(array) & (array > 0))]
    if bad.size:
        raise InputError("frequency", "must be above 0 Hz and finite", float(bad[0]))
    return array


def decibels(ratio: Complex) -> Real:
    """Return 20 log10 of the magnitude (1)."""
    return np.asarray(20 * np.log10(np.abs(ratio)))


def response(network: Network, frequency: Real) -> Complex:
    """Return the output by the load, `(n,)` V/N, at frequencies `(n,)` Hz.

    Raises InputError for a frequency that is not above 0.
    """
    return transfers(network, [((LOAD, 0, 1),)], frequency)[0]


def transfers(network: Network, drives: Sequence[Drive], frequency: Real) -> list[Complex]:
    """Return the output `(n,)` V by each drive of 1 A, or of 1 V in series with an element, at `(n,)` Hz."""
    s = np.asarray(2j * np.pi * checked_frequencies(frequency), np.complex128)
    wiring = network.wiring
    mantissa, exponent = np.frexp([e.value for e in network.elements])
    whole, size = _value(_determinant(wiring, None), mantissa, exponent, s)
    parts = (_value(_determinant(wiring, drive), mantissa, exponent, s) for drive in drives)
    return [part / whole * np.exp2(float(other - size)) for part, other in parts]


def _value(terms: _Sum, mantissa: Real, exponent: np.ndarray, s: Complex) -> tuple[Complex, int]:
    """A sum of products at s, and the power of two that it is to be multiplied by: no product overflows."""
    if not terms.chosen.size:
        return np.zeros_like(s), 0
    # in extended precision, where the machine has it: near a null two products leave their rounding
    size = np.where(terms.chosen, mantissa[:, None].astype(np.longdouble), 1.0).prod(axis=0)
    twos = np.where(terms.chosen, exponent[:, None], 0).sum(axis=0)
    by_power = (terms.of_power * np.ldexp(size, twos - twos.max())).sum(axis=1).astype(float)
    return np.asarray(np.polynomial.polynomial.polyval(s, by_power)), int(twos.max())


@cache
def _determinant(wiring: Wiring, drive: Drive | None) -> _Sum:
    """The determinant of the node equations, with a drive in the output's column by Cramer's rule.

    All is multiplied by every resistance and inductance, so that no value is divided by.
    """
    equations_of = equations(wiring)
    rows: list[list[Products]] = [[{} for _ in equations_of.nodes] for _ in equations_of.nodes]
    for i in np.flatnonzero(equations_of.fixed):
        rows[i][i][0] = 1
    for k, (kind, ends) in enumerate(wiring):
        part = equations_of.part(k, ends[0] if kind is Source else None)
        for i, j in np.argwhere(part):
            rows[i][j][1 << k] = int(part[i, j])
    if drive is not None:
        driven = {node: {product: times} for node, product, times in drive}
        for node, row in zip(equations_of.nodes, rows, strict=True):
            row[equations_of.nodes.index(OUT)] = driven.get(node, {})
    products = _expanded(rows)
    kinds = [kind for kind, _ in wiring]
    chosen = np.array([[bool(product >> i & 1) for product in products] for i in range(len(kinds))], bool)
    chosen[[kind in (Resistor, Inductor) for kind in kinds]] ^= True
    power = chosen[[kind in (Capacitor, Inductor) for kind in kinds]].sum(axis=0)
    of_power = np.array([(power == k) * list(products.values()) for k in range(power.max(initial=0) + 1)])
    return _Sum(chosen, of_power.astype(float))


def _expanded(rows: list[list[Products]]) -> Products:
    """Laplace's expansion, row by row, each minor once."""
    count = len(rows)

    @cache
    def minor(columns: int) -> Products:
        if not columns:
            return {0: 1}
        row, terms = rows[count - columns.bit_count()], dict[int, int]()
        for place, j in enumerate(j for j in range(count) if columns >> j & 1):
            for one, times in row[j].items():
                for other, more in minor(columns ^ 1 << j).items():
                    if not one & other:  # an element's square: it cancels in the whole
                        terms[one | other] = terms.get(one | other, 0) + (-1) ** place * times * more
        return {product: times for product, times in terms.items() if times}

    return minor((1 << count) - 1)
