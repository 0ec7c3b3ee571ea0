"""The frequency test: gain against frequency, its corner and slopes, with or without measured data."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skincad.base.columns import read_columns
from skincad.base.errors import InputError
from skincad.base.result import Result
from skincad.base.stopwatch import Progress, Stopwatch
from skincad.circuit.calibrate import ANY_RATIO, Calibration, calibrate
from skincad.circuit.constants import Constants
from skincad.circuit.elements import Complex, Network, Real
from skincad.circuit.model import Circuit, Indenter, constants, noise_sources
from skincad.circuit.resample import PASS
from skincad.circuit.response import decibels, response
from skincad.circuit.slopes import Slopes, fit_slopes
from skincad.circuit.topologies import network

COLUMNS = ("frequency_Hz", "gain_dB")


@dataclass(frozen=True)
class Measured:
    """A measured curve `(n,)` Hz, rising, and `(n,)` dB, its corner and the constants calibrated to it."""

    frequency: Real
    gain: Real
    slopes: Slopes
    calibration: Calibration


@dataclass(frozen=True, repr=False)
class CircuitGain(Result):
    """The gain `(n,)` in dB re 1 V/N at `(n,)` Hz, of the circuit, or of the constants calibrated to data."""

    shown_by = "skincad.outputs.gains"
    circuit: Circuit
    constants: Constants
    frequency: Real
    gain: Real
    slopes: Slopes
    measured: Measured | None
    warnings: tuple[str, ...]
    seconds: dict[str, float]

    @property
    def name(self) -> str:
        """The circuit's name."""
        return self.circuit.name

    @property
    def mid_band(self) -> tuple[float, float]:
        """The logarithmic middle of the flatter side of the cut-off, Hz, and the gain there, dB."""
        slopes, ends = self.slopes, [float(self.frequency[0]), self.circuit.sweep.fit_high]
        if slopes.cutoff.value is not None:
            below, above = (abs(slope.value or 0.0) for slope in (slopes.below, slopes.above))
            ends[1 if below <= above else 0] = slopes.cutoff.value
        middle = float(np.sqrt(ends[0] * ends[1]))
        return middle, float(np.interp(np.log(middle), np.log(self.frequency), self.gain))

    @property
    def network(self) -> Network:
        """The elements whose gain it is."""
        return network(self.constants, noise_sources(self.circuit), self.circuit.amplifier.topology)

    def as_json(self) -> dict[str, Any]:
        """Return the contract's keys; with measured data also `calibration`."""
        found: dict[str, Any] = {
            "name": self.name,
            "constants": self.constants.as_json(),
            "frequency_Hz": self.frequency.tolist(),
            "gain_dB": self.gain.tolist(),
            "gain_reference": "1 V/N",
            "mid_band_Hz": self.mid_band[0],
            "mid_band_gain_dB": self.mid_band[1],
            "cutoff_Hz": self.slopes.cutoff.as_json(),
            "slope_below_dB_per_dec": self.slopes.below.as_json(),
            "slope_above_dB_per_dec": self.slopes.above.as_json(),
            "seconds": self.seconds,
            "warnings": list(self.warnings),
        }
        if self.measured:
            found["calibration"] = self.measured.calibration.as_json()
        return found


def gain(
    circuit: Circuit, measured: Path | str | None = None, progress: Progress | None = None
) -> CircuitGain:
    """Return a circuit's gain over its sweep, with cut-off and slopes.

    With a CSV of columns frequency_Hz and gain_dB the network is calibrated to it first; the film's d33
    stays, since the level is free. Raises InputError for unusable input.
    """
    watch, sweep, amplifier = Stopwatch(progress), circuit.sweep, circuit.amplifier
    given = None
    if measured is not None:
        for key, wanted in (("topology", "inverting"), ("feedback_capacitance", 0.0)):
            if (value := getattr(amplifier, key)) != wanted:
                rule = f"must be {wanted or '0 F'} where constants are calibrated to a measured curve"
                raise InputError(f"amplifier.{key}", rule, value, "take the paper's network")
        with watch.stage("calibrating"):
            given = _measured(circuit, measured)
    c = given.calibration.constants if given else constants(circuit)
    with watch.stage("sweeping"):
        frequency = np.geomspace(sweep.low, sweep.high, sweep.points)
        with np.errstate(all="ignore"):  # constants so far apart that they overflow are refused below
            ratio = response(network(c, topology=amplifier.topology), frequency)
        if circuit.indenter:
            ratio = ratio * indenter_response(circuit.indenter, frequency)
        if not (np.isfinite(ratio).all() and np.abs(ratio).min() > 0):
            raise InputError(
                circuit.name,
                "gives no finite gain at some frequency",
                remedy="bring the constants closer together",
            )
        level = decibels(ratio)
        slopes = fit_slopes(frequency, level, sweep.low, sweep.fit_high)
    return CircuitGain(
        circuit, c, frequency, level, slopes, given, tuple(_warnings(circuit, c, slopes)), watch.seconds()
    )


def indenter_response(indenter: Indenter, frequency: Real) -> Complex:
    """Return the share of the load that reaches the film, `(n,)`: a driven mass on a damped spring."""
    ratio = frequency / indenter.resonance
    return np.asarray(1 / (1 - ratio**2 + 2j * indenter.damping * ratio))


def _measured(circuit: Circuit, file: Path | str) -> Measured:
    columns = read_columns(file, COLUMNS)
    if set(columns) != set(COLUMNS):
        raise InputError(str(file), "must have the columns frequency_Hz and gain_dB")
    order = np.argsort(columns["frequency_Hz"], kind="stable")
    frequency, gain = (columns[name][order] for name in COLUMNS)
    if (np.diff(frequency) <= 0).any() or frequency[0] <= 0:
        raise InputError(f"{file}, column 'frequency_Hz'", "must be above 0 Hz, each frequency once")
    high = min(circuit.sweep.fit_high, float(frequency[-1]))
    inside = frequency <= high
    slopes = fit_slopes(frequency, gain, float(frequency[0]), high, str(file))
    d33 = constants(circuit).d33
    found = calibrate(frequency[inside], gain[inside], d33=d33, largest_ratio=ANY_RATIO)
    return Measured(frequency, gain, slopes, found)


def _warnings(circuit: Circuit, c: Constants, slopes: Slopes) -> list[str]:
    found = []
    ratio = c.motional_capacitance / c.capacitance
    if ratio > 1:
        found.append(
            f"the motional capacitance is {ratio:.3g} times the static one; a PVDF film's own is at most 0.1 "
            "times: this branch stands for more than the film"
        )
    if circuit.sampling:
        seen = PASS * circuit.sampling.rate / 2
        cutoff = slopes.cutoff.value
        if cutoff is not None and cutoff > seen:
            found.append(
                f"sampled at {circuit.sampling.rate:g} Hz, the output is true up to {seen:.4g} Hz; "
                f"the cut-off at {cutoff:.4g} Hz and everything above it are not seen"
            )
    return found
