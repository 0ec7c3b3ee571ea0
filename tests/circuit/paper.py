"""Both amplifiers solved by hand, to test the package's general solution by, and the paper's statements.

Source: Yamada et al. 2002: the loop equations (2) to (9), their solution with every source term, and as the
paper prints it, (10) to (14). (12) to (14) leave out what the source drives in (6) and (7), so (10) is not
the solution of (4) to (9) (docs/evidence/circuit.md). A capacitor beside R3 + R4, a falling gain and the
follower are not in the paper.
"""

from __future__ import annotations

import numpy as np

from skincad.circuit import (
    PAPER_ABOVE,
    PAPER_BELOW,
    PAPER_CUTOFF,
    PAPER_HIGH,
    PAPER_LOW,
    Complex,
    Constants,
    Real,
)


def paper_target(points: int = 117) -> tuple[Real, Real]:
    """Return frequencies, Hz, and gain, dB, 0 at 1.2 kHz: 20 dB/dec up to there and 60 above (paper)."""
    frequency = np.geomspace(PAPER_LOW, PAPER_HIGH, points)
    slope = np.where(frequency < PAPER_CUTOFF, PAPER_BELOW, PAPER_ABOVE)
    return frequency, np.asarray(slope * np.log10(frequency / PAPER_CUTOFF))


def angular(frequency: Real) -> Complex:
    """Return jw, rad/s."""
    return np.asarray(2j * np.pi * np.asarray(frequency, float))


def loop_response(c: Constants, frequency: Real) -> Complex:
    """Return vout / lo by the loop equations, `(n,)` V/N, at frequencies `(n,)` Hz.

    Unknowns are i1, i2, vd, i4; i3 = i2 - vd / Ropi by (8), because i2 - i3 loses all its digits at a large
    Ropi.
    """
    jw = angular(frequency)
    film, motional = 1 / (jw * c.capacitance), motional_impedance(c, jw)
    shunt = 1 / (jw * c.input_capacitance)
    matrix = np.zeros((jw.size, 4, 4), complex)
    matrix[:, 0, 0], matrix[:, 0, 1] = film + motional, -motional  # (4)
    matrix[:, 1, 0], matrix[:, 1, 1] = -motional, motional + c.series_resistance  # (5)
    matrix[:, 1, 2] = 1.0
    matrix[:, 2, 1], matrix[:, 2, 3] = shunt, -shunt  # (6)
    matrix[:, 2, 2] = -1.0 - shunt / c.input_resistance
    matrix[:, 3, 1], matrix[:, 3, 2] = -shunt, shunt / c.input_resistance - c.gain  # (7)
    matrix[:, 3, 3] = shunt + feedback_impedance(c, jw) + c.output_resistance
    source = np.zeros((jw.size, 4, 1), complex)
    source[:, 0, 0] = film * jw * c.d33  # (2), (3): ipv = jw d33 lo
    current = np.linalg.solve(matrix, source)[:, :, 0]
    return np.asarray(c.gain * current[:, 2] - c.output_resistance * current[:, 3])  # (9)


def motional_impedance(c: Constants, jw: Complex) -> Complex:
    """Return 1 / Ymot, ohm, at jw in rad/s."""
    return np.asarray(c.motional_resistance + jw * c.motional_inductance + 1 / (jw * c.motional_capacitance))


def feedback_impedance(c: Constants, jw: Complex) -> Complex:
    """Return that of R3 + R4 with the capacitor beside them, ohm, at jw in rad/s."""
    return np.asarray(c.feedback_resistance / (1 + jw * c.feedback_capacitance * c.feedback_resistance))


def open_loop(c: Constants, jw: Complex) -> Complex:
    """Return the amplifier's gain, `(n,)`: a finite bandwidth is one pole."""
    return np.asarray(c.gain / (1 + jw * c.gain / (2 * np.pi * c.gain_bandwidth) if c.gain_bandwidth else 1))


def exact_response(c: Constants, frequency: Real) -> Complex:
    """Return vout / lo `(n,)` V/N by the two node equations that (4) to (9) reduce to, no term left out."""
    jw = angular(frequency)
    film = jw * c.capacitance + 1 / motional_impedance(c, jw)  # S, at the film
    back = feedback_impedance(c, jw)
    behind = back + c.output_resistance
    gain = open_loop(c, jw)
    node = jw * c.input_capacitance + 1 / c.input_resistance + (1 + gain) / behind  # S, at the input
    vd = jw * c.d33 / (film + node + film * node * c.series_resistance)
    return np.asarray(vd * (gain * back - c.output_resistance) / behind)  # (9), i4 by (6) and (7)


def follower_response(c: Constants, frequency: Real) -> Complex:
    """Return vout / lo `(n,)` V/N of the follower: the input's divider, and a gain of A / (1 + A)."""
    jw = angular(frequency)
    film = jw * c.capacitance + 1 / motional_impedance(c, jw)
    node = jw * c.input_capacitance + 1 / c.input_resistance
    gain = open_loop(c, jw)
    return np.asarray(jw * c.d33 / (film + node + film * node * c.series_resistance) * gain / (1 + gain))


def printed_response(c: Constants, frequency: Real) -> Complex:
    """Return (1/A4 - Ropo) d33 jw / (A2 A3), `(n,)` V/N: formula (10) as it is read from the scan."""
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
    return np.asarray((1 / a4 - c.output_resistance) * c.d33 * jw / (a2 * a3))
