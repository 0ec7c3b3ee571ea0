"""The paper's loop equations (4) to (9) solved in fractions: no digit is lost, whatever the constants."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from skincad.circuit import Constants

# a + bi is the matrix a ONE + b J, whose sums, products and inverses are those of complex numbers
ONE, J = (
    np.array([[Fraction(n) for n in row] for row in rows]) for rows in ([[1, 0], [0, 1]], [[0, -1], [1, 0]])
)
NONE = 0 * ONE


def size(z: Any) -> Fraction:
    return z[0, 0] ** 2 + z[1, 0] ** 2  # type: ignore[no-any-return]


def inverse(z: Any) -> Any:
    return z.T / size(z)


def solved(matrix: list[list[Any]], side: list[Any]) -> list[Any]:
    """Gauss elimination; any pivot that is not 0 will do."""
    rows = np.hstack([np.block(matrix), np.vstack(side)])
    n = len(rows)
    for k in range(n):
        pivot = next(i for i in range(k, n) if rows[i, k])
        rows[[k, pivot]] = rows[[pivot, k]]
        rows[k] /= rows[k, k]
        for i in range(n):
            if i != k:
                rows[i] -= rows[i, k] * rows[k]
    return [rows[i : i + 2, n:] for i in range(0, n, 2)]


def gain(c: Constants, frequency: float) -> float:
    """Return 20 log10 |vout / lo|, dB, at a frequency in Hz; minus infinity where it is 0."""
    jw = Fraction(2 * math.pi * frequency) * J
    film, shunt = (inverse(jw * Fraction(value)) for value in (c.capacitance, c.input_capacitance))
    motional = Fraction(c.motional_resistance) * ONE + Fraction(c.motional_inductance) * jw
    motional += inverse(Fraction(c.motional_capacitance) * jw)
    leak, a, out = shunt / Fraction(c.input_resistance), Fraction(c.gain) * ONE, Fraction(c.output_resistance)
    if c.gain_bandwidth:
        a = a @ inverse(ONE + jw @ a / Fraction(2 * math.pi * c.gain_bandwidth))
    rows = [  # i1, i2, vd, i4
        [film + motional, -motional, NONE, NONE],
        [-motional, motional + Fraction(c.series_resistance) * ONE, ONE, NONE],
        [NONE, shunt, -ONE - leak, -shunt],
        [NONE, -shunt, leak - a, shunt + (Fraction(c.feedback_resistance) + out) * ONE],
    ]
    _, _, vd, i4 = solved(rows, [film @ jw * Fraction(c.d33), NONE, NONE, NONE])
    squared = size(a @ vd - out * i4)
    if squared == 0:
        return -math.inf
    return 10 * (math.log10(squared.numerator) - math.log10(squared.denominator))
