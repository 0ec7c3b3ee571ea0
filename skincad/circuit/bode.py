"""Gain against frequency: of the circuit as it is, on its rig, and against a measured curve.

The rig of a frequency test: what is told of a load is not what the film feels. The paper's film lies between
a vibrator's indenter and the probe of a force sensor. A sensor is a mass on a spring: it reads by the spring,
and the film feels the mass's inertia too, a double zero in output by told load (an amplifier behind the
sensor that passes as much does the same). Range: one mass each, in the film's direction. None of it acts in
use: scenes, noise and netlist are without it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skincad.base.columns import read_columns
from skincad.base.errors import InputError
from skincad.base.progress import Progress, Stopwatch
from skincad.base.result import Record, Result, item, record, reported
from skincad.circuit.calibrate import ANY_RATIO, Calibration, calibrate
from skincad.circuit.model import Circuit, ForceSensor, Indenter, constants, noise_sources
from skincad.circuit.network import Complex, Constants, Network, Real, network
from skincad.circuit.response import Slopes, decibels, fit_slopes, response


def has_rig(circuit: Circuit) -> bool:
    """Return whether a circuit's gain is by a measured load."""
    return bool(circuit.indenter or circuit.force_sensor)


def without_rig(circuit: Circuit) -> Circuit:
    """Return the circuit as it is in use."""
    return circuit.model_copy(update={"indenter": None, "force_sensor": None})


def film_load(circuit: Circuit, frequency: Real) -> Complex:
    """Return the load on the film by the measured load, `(n,)` at `(n,)` Hz; 1 without a rig."""
    ratio = np.ones(np.shape(frequency), complex)
    if circuit.indenter:
        ratio = ratio / pressed(circuit.indenter, frequency)
    if circuit.force_sensor:
        ratio = ratio * pressed(circuit.force_sensor, frequency)
    return ratio


def pressed(part: Indenter | ForceSensor, frequency: Real) -> Complex:
    """Return the load on a mass by that in the damped spring behind it, `(n,)`: 1 + 2 zeta s + s^2."""
    ratio = frequency / part.resonance
    return np.asarray(1 - ratio**2 + 2j * part.damping * ratio)


def told_rig(circuit: Circuit) -> str:
    """Return the rig in words."""
    named = {"indenter": circuit.indenter, "force sensor": circuit.force_sensor}
    return " and ".join(f"the {name} at {part.resonance:g} Hz" for name, part in named.items() if part)


COLUMNS = ("frequency_Hz", "gain_dB")


@dataclass(frozen=True)
class MeasuredCurve:
    """A measured curve `(n,)` Hz, rising, and `(n,)` dB, its corner and the constants calibrated to it."""

    frequency: Real
    gain: Real
    slopes: Slopes
    calibration: Calibration
    notes: tuple[str, ...]  # how its file was read


@record()
class OwnSignal(Record):
    """The gain by the load that the film feels, without the rig."""

    gain: Real = item("dB", "`(n,)`, re 1 V/N")
    slopes: Slopes = item(inline=True)


@record()
class CircuitGain(Result):
    """The gain `(n,)` in dB re 1 V/N at `(n,)` Hz, of the circuit, or of the constants calibrated to data.

    Of a circuit with a rig it is that by the measured load; `own` is the film's, as in use.
    """

    shown_by = "skincad.outputs.simulations:GAIN"
    circuit: Circuit
    constants: Constants = item(meaning="of the network")
    frequency: Real = item("Hz", "`(n,)`, rising")
    gain: Real = item("dB", "`(n,)`, re 1 V/N")
    slopes: Slopes = item(inline=True)
    measured: MeasuredCurve | None
    own: OwnSignal | None = item(meaning="as in use, without the rig", key="own_signal", optional=True)
    warnings: tuple[str, ...] = item(meaning="what to know of the numbers")
    seconds: dict[str, float] = item(meaning="wall time by stage, s")

    @reported(meaning="of the circuit")
    def name(self) -> str:
        """The circuit's name."""
        return self.circuit.name

    def columns(self) -> dict[str, Any]:
        """Return a row for each frequency: the gain, and with a rig the film's own."""
        own = {"own_gain_dB": self.own.gain} if self.own else {}
        return {"frequency_Hz": self.frequency, "gain_dB": self.gain, **own}

    @property
    def mid_band(self) -> tuple[float, float]:
        """The logarithmic middle of the flatter side of the cut-off, Hz, and the gain there, dB."""
        slopes, ends = self.slopes, [float(self.frequency[0]), self.circuit.sweep.fit_high]
        if slopes.cutoff.value is not None:
            below, above = (abs(slope.value or 0.0) for slope in (slopes.below, slopes.above))
            ends[1 if below <= above else 0] = slopes.cutoff.value
        middle = float(np.sqrt(ends[0] * ends[1]))
        return middle, float(np.interp(np.log(middle), np.log(self.frequency), self.gain))

    @reported(meaning="what 0 dB is")
    def gain_reference(self) -> str:
        """What 0 dB is."""
        return "1 V/N"

    @reported("Hz", "the logarithmic middle of the flatter side of the cut-off", key="mid_band_Hz")
    def _middle(self) -> float:
        return self.mid_band[0]

    @reported("dB", "the gain there")
    def mid_band_gain(self) -> float:
        """The gain at the middle of the band, dB."""
        return self.mid_band[1]

    @reported(meaning="misfit to a measured curve, and what it leaves open", optional=True)
    def calibration(self) -> Calibration | None:
        """The calibration to a measured curve, None without one."""
        return self.measured.calibration if self.measured else None

    @property
    def network(self) -> Network:
        """The elements whose gain it is."""
        return network(self.constants, noise_sources(self.circuit), self.circuit.amplifier.topology)


def gain(
    circuit: Circuit, measured: Path | str | None = None, progress: Progress | None = None
) -> CircuitGain:
    """Return a circuit's gain over its sweep, with cut-off and slopes.

    With a CSV of columns frequency_Hz and gain_dB the network is calibrated to it first, less what the rig
    makes of it; the film's d33 stays, since the level is free. Raises InputError for unusable input.
    """
    watch, sweep, amplifier = Stopwatch(progress), circuit.sweep, circuit.amplifier
    measurement, own_signal = None, None
    if measured is not None:
        wanted = {"topology": "inverting", "feedback_capacitance": "0 F", "gain_bandwidth": "0 Hz"}
        for key, reached in wanted.items():
            if (value := getattr(amplifier, key)) not in (reached, 0.0):
                rule = f"must be {reached} where constants are calibrated to a measured curve"
                raise InputError(f"amplifier.{key}", rule, value, "take the paper's network")
        with watch.stage("calibrating"):
            measurement = _measured(circuit, measured)
    c = measurement.calibration.constants if measurement else constants(circuit)
    with watch.stage("sweeping"):
        frequency = np.geomspace(sweep.low, sweep.high, sweep.points)
        with np.errstate(all="ignore"):  # constants so far apart that they overflow are refused below
            ratio = response(network(c, topology=amplifier.topology), frequency)
            felt = film_load(circuit, frequency)
        level = _level(circuit, ratio * felt)
        slopes = fit_slopes(frequency, level, sweep.low, sweep.fit_high)
        if has_rig(circuit):
            alone = _level(circuit, ratio)
            own_signal = OwnSignal(gain=alone, slopes=fit_slopes(frequency, alone, sweep.low, sweep.fit_high))
    warnings = (*(measurement.notes if measurement else ()), *_warnings(circuit, c, slopes))
    return CircuitGain(
        circuit=circuit,
        constants=c,
        frequency=frequency,
        gain=level,
        slopes=slopes,
        measured=measurement,
        own=own_signal,
        warnings=warnings,
        seconds=watch.seconds(),
    )


def _level(circuit: Circuit, ratio: Complex) -> Real:
    """Return a gain in dB; raises InputError where there is none."""
    if not (np.isfinite(ratio).all() and np.abs(ratio).min() > 0):
        raise InputError(
            circuit.name,
            "gives no finite gain at some frequency",
            remedy="bring the constants closer together",
        )
    return decibels(ratio)


def _measured(circuit: Circuit, file: Path | str) -> MeasuredCurve:
    columns = read_columns(file, COLUMNS)
    order = np.argsort(columns["frequency_Hz"], kind="stable")
    frequency, gain = (columns[name][order] for name in COLUMNS)
    if (np.diff(frequency) <= 0).any() or frequency[0] <= 0:
        raise InputError(f"{file}, column 'frequency_Hz'", "must be above 0 Hz, each frequency once")
    high = min(circuit.sweep.fit_high, float(frequency[-1]))
    inside = frequency <= high
    slopes = fit_slopes(frequency, gain, float(frequency[0]), high, str(file))
    d33 = constants(circuit).d33
    film = gain[inside] - decibels(film_load(circuit, frequency[inside]))
    calibration = calibrate(frequency[inside], film, d33=d33, largest_ratio=ANY_RATIO)
    return MeasuredCurve(frequency, gain, slopes, calibration, columns.notes)


def _warnings(circuit: Circuit, c: Constants, slopes: Slopes) -> list[str]:
    warnings = []
    ratio = c.motional_capacitance / c.capacitance
    if ratio > 1:
        warnings.append(
            f"the motional capacitance is {ratio:.3g} times the static one; a PVDF film's own is at most 0.1 "
            "times: this branch stands for more than the film"
        )
    if circuit.sampling:
        from skincad.circuit.state import PASS  # its filters take a second to load

        seen = PASS * circuit.sampling.rate / 2
        cutoff = slopes.cutoff.value
        if cutoff is not None and cutoff > seen:
            warnings.append(
                f"sampled at {circuit.sampling.rate:g} Hz, the output is true up to {seen:.4g} Hz; "
                f"the cut-off at {cutoff:.4g} Hz and everything above it are not seen"
            )
    return warnings
