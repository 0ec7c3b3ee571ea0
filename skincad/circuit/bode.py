"""Gain against frequency: of the circuit as it is, on its rig, and against a measured curve.

The rig of a frequency test: what is told of a load is not what the film feels. The paper's film lies between
a vibrator's indenter and the probe of a force sensor. A sensor is a mass on a spring: it reads by the spring,
and the film feels the mass's inertia too, a double zero in output by told load (an amplifier behind the
sensor that passes as much does the same). Range: one mass each, in the film's direction. None of it acts in
use: scenes, noise and netlist are without it.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from skincad.base.columns import read_columns
from skincad.base.errors import InputError
from skincad.base.progress import Progress, Stopwatch
from skincad.base.result import Record, Result, item, record, reported, reported_from
from skincad.circuit.calibrate import Calibration, calibrate
from skincad.circuit.model import (
    Circuit,
    ForceSensor,
    Indenter,
    circuit_network,
    constants,
    output_offset,
    output_swing,
)
from skincad.circuit.network import Complex, Constants, Network, Real
from skincad.circuit.response import Slopes, decibels, fit_slopes, response, total_density


def without_rig(circuit: Circuit) -> Circuit:
    """Return the circuit as it is in use."""
    return circuit.model_copy(update={"indenter": None, "force_sensor": None})


def film_load(circuit: Circuit, frequency: Real) -> Complex:
    """Return the load on the film by the measured load, `(n,)` at `(n,)` Hz; 1 without a rig."""

    def pressed(part: Indenter | ForceSensor | None) -> Complex:
        """The load on a mass by that in the damped spring behind it: 1 + 2 zeta s + s^2."""
        ratio = frequency / part.resonance if part else np.zeros(np.shape(frequency))
        return np.asarray(1 - ratio**2 + 2j * (part.damping if part else 0.0) * ratio)

    return 1 / pressed(circuit.indenter) * pressed(circuit.force_sensor)


def told_rig(circuit: Circuit) -> str:
    """Return the rig in words."""
    named = {"indenter": circuit.indenter, "force sensor": circuit.force_sensor}
    return " and ".join(f"the {name} at {part.resonance:g} Hz" for name, part in named.items() if part)


COLUMNS = ("frequency_Hz", "gain_dB")
NOISE_POINTS = 4000  # of a band's noise, evenly in log f: a resonance of quality 60 is some 5 of them wide


@record()
class Curve(Record):
    """A gain over frequency `(n,)` Hz, rising, with its corner."""

    frequency: Real
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
    measured: Curve | None
    calibration: Calibration | None = item(
        meaning="misfit to a measured curve, and what it leaves open", optional=True
    )
    own: Curve | None = item(meaning="as in use, without the rig", key="own_signal", optional=True)
    warnings: tuple[str, ...] = item(meaning="what to know of the numbers")
    seconds: dict[str, float] = item(meaning="wall time by stage, s")

    name = reported_from("circuit.name", meaning="of the circuit")

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

    @reported("Hz", "from the sweep's low to its high, or half the recorder's rate")
    def noise_band(self) -> tuple[float, float]:
        """The band of `output_noise`, Hz."""
        sampling = self.circuit.sampling
        high = float(self.frequency[-1])
        return float(self.frequency[0]), min(high, sampling.rate / 2) if sampling else high

    @reported("V", "rms, of film and amplifier in the noise band", key="output_noise_V_rms")
    def output_noise(self) -> float:
        """The noise at the output in the noise band, V rms."""
        frequency = np.geomspace(*self.noise_band, NOISE_POINTS)
        return math.sqrt(float(np.trapezoid(total_density(self.network, frequency), frequency)))

    @reported("V", "of the amplifier's own output from its reference, by its input bias current")
    def output_offset(self) -> float:
        """How far the amplifier's own output rests above its reference, V."""
        return output_offset(self.circuit.amplifier, self.network)

    @reported("V", "how far the output goes from rest; null where no rail stops it")
    def output_swing(self) -> tuple[float | None, float | None]:
        """How far `vout` goes from rest, V below and above 0."""
        low, high = output_swing(self.circuit.amplifier, self.network)
        return (low if math.isfinite(low) else None), (high if math.isfinite(high) else None)

    @property
    def network(self) -> Network:
        """The elements whose gain it is."""
        return circuit_network(self.circuit, self.constants)


def gain(
    circuit: Circuit, measured: Path | str | None = None, progress: Progress | None = None
) -> CircuitGain:
    """Return a circuit's gain over its sweep, with cut-off and slopes.

    With a CSV of columns frequency_Hz and gain_dB the network is calibrated to it first, less what the rig
    makes of it; the film's d33 stays, since the level is free. Raises InputError for unusable input.
    """
    watch, sweep, amplifier = Stopwatch(progress), circuit.sweep, circuit.amplifier
    c, curve, calibration = constants(circuit), None, None
    notes: tuple[str, ...] = ()
    if measured is not None:
        wanted = {"topology": "inverting", "feedback_capacitance": "0 F", "gain_bandwidth": "0 Hz"}
        for key, reached in wanted.items():
            if (value := getattr(amplifier, key)) not in (reached, 0.0):
                rule = f"must be {reached} where constants are calibrated to a measured curve"
                raise InputError(f"amplifier.{key}", rule, value, "take the paper's network")
        with watch.stage("calibrating"):
            curve, notes = _measured(circuit, measured)
            inside = curve.frequency <= sweep.fit_high
            frequency = curve.frequency[inside]
            film = curve.gain[inside] - decibels(film_load(circuit, frequency))
            calibration = calibrate(frequency, film, d33=c.d33)
            c = calibration.constants
    with watch.stage("sweeping"):
        frequency = np.geomspace(sweep.low, sweep.high, sweep.points)
        with np.errstate(all="ignore"):  # constants so far apart that they overflow are refused below
            ratio = response(circuit_network(circuit, c), frequency)
            felt = film_load(circuit, frequency)
        as_measured = _curve(circuit, frequency, ratio * felt)
        has_rig = circuit.indenter or circuit.force_sensor
        own = _curve(circuit, frequency, ratio) if has_rig else None
    return CircuitGain(
        circuit=circuit,
        constants=c,
        frequency=frequency,
        gain=as_measured.gain,
        slopes=as_measured.slopes,
        measured=curve,
        calibration=calibration,
        own=own,
        warnings=(*notes, *_warnings(circuit, c, as_measured.slopes)),
        seconds=watch.seconds(),
    )


def _curve(circuit: Circuit, frequency: Real, ratio: Complex) -> Curve:
    """Return a gain with its corner; raises InputError where there is none."""
    if not (np.isfinite(ratio).all() and np.abs(ratio).min() > 0):
        rule, remedy = "gives no finite gain at some frequency", "bring the constants closer together"
        raise InputError(circuit.name, rule, remedy=remedy)
    level, sweep = decibels(ratio), circuit.sweep
    slopes = fit_slopes(frequency, level, sweep.low, sweep.fit_high)
    return Curve(frequency=frequency, gain=level, slopes=slopes)


def _measured(circuit: Circuit, file: Path | str) -> tuple[Curve, tuple[str, ...]]:
    """Return a file's curve, its corner up to the sweep's fit, and how the file was read."""
    columns = read_columns(file, COLUMNS)
    order = np.argsort(columns["frequency_Hz"], kind="stable")
    frequency, gain = (columns[name][order] for name in COLUMNS)
    if (np.diff(frequency) <= 0).any() or frequency[0] <= 0:
        raise InputError(f"{file}, column 'frequency_Hz'", "must be above 0 Hz, each frequency once")
    high = min(circuit.sweep.fit_high, float(frequency[-1]))
    slopes = fit_slopes(frequency, gain, float(frequency[0]), high, str(file))
    return Curve(frequency=frequency, gain=gain, slopes=slopes), columns.notes


def _warnings(circuit: Circuit, c: Constants, slopes: Slopes) -> list[str]:
    warnings = []
    ratio = c.motional_capacitance / c.capacitance
    if ratio > 1:
        warnings.append(
            f"the motional capacitance is {ratio:.3g} times the static one; a PVDF film's own is at most 0.1 "
            "times: this branch stands for more than the film"
        )
    if circuit.sampling and slopes.cutoff.value is not None:
        from skincad.circuit.state import PASS  # its filters take a second to load

        seen, cutoff = PASS * circuit.sampling.rate / 2, slopes.cutoff.value
        if cutoff > seen:
            warnings.append(
                f"sampled at {circuit.sampling.rate:g} Hz, the output is true up to {seen:.4g} Hz; "
                f"the cut-off at {cutoff:.4g} Hz and everything above it are not seen"
            )
    return warnings
