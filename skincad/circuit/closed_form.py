"""The loop equations solved by hand: with every source term, and as the paper prints it, (10) to (14).

Source: Yamada et al. 2002. (12) to (14) leave out what the source drives in (6) and (7), so (10) is not the
solution of (4) to (9); `departure` says by how much.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skincad.circuit.network import (
    Complex,
    Constants,
    Real,
    angular,
    decibels,
    feedback_impedance,
    motional_impedance,
)


@dataclass(frozen=True)
class _Terms:
    jw: Complex
    a2: Complex
    a3: Complex
    a4: Complex


def _terms(c: Constants, frequency: Real) -> _Terms:
    """A2 to A4 by (11) to (14), `(n,)` each, and jw."""
    jw = angular(frequency)
    ymot = 1 / motional_impedance(c, jw)
    copi, ropi = c.input_capacitance, c.input_resistance
    # 1 - A1 by (14), written out so that no digits cancel
    rest = ymot / (ymot + jw * c.capacitance)
    a2 = ymot * ropi / (rest + ymot * (c.series_resistance + ropi))  # (11)
    # 1 - A2, in the same way
    leak = (rest + ymot * c.series_resistance) / (rest + ymot * (c.series_resistance + ropi))
    a3 = 1 / (1 + jw * copi * ropi * leak)  # (12)
    behind = feedback_impedance(c, jw) + c.output_resistance
    a4 = jw * copi / (jw * copi * ropi * leak * a3 + jw * copi * behind)  # (13), 1 - A3 written out
    return _Terms(jw, a2, a3, a4)


def printed_response(c: Constants, frequency: Real) -> Complex:
    """Return (1/A4 - Ropo) d33 jw / (A2 A3), `(n,)` V/N: formula (10) as it is read from the scan."""
    t = _terms(c, frequency)
    return np.asarray((1 / t.a4 - c.output_resistance) * c.d33 * t.jw / (t.a2 * t.a3))


def exact_response(c: Constants, frequency: Real) -> Complex:
    """Return vout / lo `(n,)` V/N by the two node equations that (4) to (9) reduce to, no term left out."""
    jw = angular(frequency)
    film = jw * c.capacitance + 1 / motional_impedance(c, jw)  # S, at the film
    behind = feedback_impedance(c, jw) + c.output_resistance
    node = jw * c.input_capacitance + 1 / c.input_resistance + (1 + c.gain) / behind  # S, at the input
    vd = jw * c.d33 / (film + node + film * node * c.series_resistance)
    return np.asarray(vd * output_factor(c, jw))


def output_factor(c: Constants, jw: Complex) -> Complex:
    """Return vout / vd `(n,)`: (9) with i4 = (1 + A) vd / (R3 + R4 + Ropo), the sum of (6) and (7)."""
    back = feedback_impedance(c, jw)
    return np.asarray((c.gain * back - c.output_resistance) / (back + c.output_resistance))


def departure(c: Constants, frequency: Real) -> Real:
    """Return by how many dB the printed formula lies above the loop equations' solution, `(n,)`."""
    return np.asarray(decibels(printed_response(c, frequency)) - decibels(exact_response(c, frequency)))
