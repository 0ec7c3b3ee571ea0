"""The paper's loop equations (4) to (9) solved in fractions: no digit is lost, whatever the constants."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from skincad.circuit import Constants


@dataclass(frozen=True)
class Complex:
    """A complex number of two fractions."""

    real: Fraction
    imag: Fraction = Fraction(0)

    def __add__(self, other: Complex) -> Complex:
        return Complex(self.real + other.real, self.imag + other.imag)

    def __sub__(self, other: Complex) -> Complex:
        return Complex(self.real - other.real, self.imag - other.imag)

    def __mul__(self, other: Complex) -> Complex:
        real = self.real * other.real - self.imag * other.imag
        return Complex(real, self.real * other.imag + self.imag * other.real)

    def __truediv__(self, other: Complex) -> Complex:
        size = other.real**2 + other.imag**2
        return self * Complex(other.real / size, -other.imag / size)


NONE, ONE = Complex(Fraction(0)), Complex(Fraction(1))


def solved(matrix: list[list[Complex]], side: list[Complex]) -> list[Complex]:
    """Gauss elimination; any pivot that is not 0 will do."""
    rows = [[*row, value] for row, value in zip(matrix, side, strict=True)]
    n = len(rows)
    for k in range(n):
        pivot = next(i for i in range(k, n) if rows[i][k] != NONE)
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [value / rows[k][k] for value in rows[k]]
        for i in range(n):
            if i != k and rows[i][k] != NONE:
                rows[i] = [a - rows[i][k] * b for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[-1] for row in rows]


def gain(c: Constants, frequency: float) -> float:
    """Return 20 log10 |vout / lo|, dB, at a frequency in Hz; minus infinity where it is 0."""
    jw = Complex(Fraction(0), Fraction(2 * math.pi * frequency))

    def real(value: float) -> Complex:
        return Complex(Fraction(value))

    film, shunt = ONE / (jw * real(c.capacitance)), ONE / (jw * real(c.input_capacitance))
    motional = real(c.motional_resistance) + jw * real(c.motional_inductance)
    motional += ONE / (jw * real(c.motional_capacitance))
    leak, a, out = shunt / real(c.input_resistance), real(c.gain), real(c.output_resistance)
    if c.gain_bandwidth:
        a /= ONE + jw * a / real(2 * math.pi * c.gain_bandwidth)
    rows = [  # i1, i2, vd, i4
        [film + motional, NONE - motional, NONE, NONE],
        [NONE - motional, motional + real(c.series_resistance), ONE, NONE],
        [NONE, shunt, NONE - ONE - leak, NONE - shunt],
        [NONE, NONE - shunt, leak - a, shunt + real(c.feedback_resistance) + out],
    ]
    _, _, vd, i4 = solved(rows, [film * jw * real(c.d33), NONE, NONE, NONE])
    vout = a * vd - out * i4
    size = vout.real**2 + vout.imag**2
    if size == 0:
        return -math.inf
    return 10 * (math.log10(size.numerator) - math.log10(size.denominator))
