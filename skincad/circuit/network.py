"""The paper's equivalent circuit: loop equations (2) to (9) as one linear system at each frequency.

The film is a current source beside its static capacitance and a series R-L-C (motional) branch. It feeds an
inverting amplifier through R1 + R2; R3 + R4 lead back from the output. Beyond the paper a capacitor may lie
beside R3 + R4: a charge amplifier, whose output follows the stress itself.
Source: Yamada et al. 2002, equations (1) to (9) and Figs 5 and 6. Everything in SI.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields

import numpy as np
from numpy.typing import NDArray

from skincad.base.errors import InputError

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Constants:
    """The constants of the network, each finite and above 0; `d33` may have either sign, not 0.

    `capacitance` is the paper's Cpvd with the cable's in parallel; `feedback_capacitance` may be 0:
    none. Raises InputError for any other value.
    """

    d33: float  # C/N
    capacitance: float  # F, Cpvd
    motional_resistance: float  # ohm
    motional_inductance: float  # H
    motional_capacitance: float  # F
    series_resistance: float  # ohm, R1 + R2
    input_resistance: float  # ohm, Ropi
    input_capacitance: float  # F, Copi
    feedback_resistance: float  # ohm, R3 + R4
    output_resistance: float  # ohm, Ropo
    gain: float  # A
    feedback_capacitance: float = 0.0  # F, beside R3 + R4; none in the paper

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not math.isfinite(value):
                raise InputError(field.name, "must be a finite number", value)
            if field.name == "d33" and value == 0:
                raise InputError(field.name, "must not be 0", value)
            if field.name == "feedback_capacitance" and value < 0:
                raise InputError(field.name, "must not be below 0", value)
            if field.name not in ("d33", "feedback_capacitance") and value <= 0:
                raise InputError(field.name, "must be above 0", value)

    def as_json(self) -> dict[str, float]:
        """Return the constants by name, the unit as suffix."""
        return {f"{name}{_SUFFIX[name]}": value for name, value in asdict(self).items()}


_OHM, _FARAD = "_ohm", "_F"
_SUFFIX = {
    "d33": "_C_per_N",
    "capacitance": _FARAD,
    "motional_resistance": _OHM,
    "motional_inductance": "_H",
    "motional_capacitance": _FARAD,
    "series_resistance": _OHM,
    "input_resistance": _OHM,
    "input_capacitance": _FARAD,
    "feedback_resistance": _OHM,
    "output_resistance": _OHM,
    "gain": "",
    "feedback_capacitance": _FARAD,
}


def checked_frequencies(frequency: Real) -> Real:
    """Return the frequencies as an array, Hz; raises InputError unless all are finite and above 0."""
    array = np.atleast_1d(np.asarray(frequency, float))
    bad = array[~(np.isfinite(array) & (array > 0))]
    if bad.size:
        raise InputError("frequency", "must be above 0 Hz and finite", float(bad[0]))
    return array


def angular(frequency: Real) -> Complex:
    """Return jw, rad/s; raises InputError unless all frequencies are finite and above 0 Hz."""
    return np.asarray(2j * np.pi * checked_frequencies(frequency), np.complex128)


def response(c: Constants, frequency: Real) -> Complex:
    """Return vout / lo by the loop equations, `(n,)` V/N, at frequencies `(n,)` Hz.

    Unknowns are i1, i2, vd, i4; i3 = i2 - vd / Ropi by (8), because i2 - i3 loses all its digits at a large
    Ropi. Raises InputError for a frequency that is not above 0.
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


def decibels(ratio: Complex) -> Real:
    """Return 20 log10 of the magnitude (1)."""
    return np.asarray(20 * np.log10(np.abs(ratio)))
