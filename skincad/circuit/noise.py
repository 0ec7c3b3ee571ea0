"""Noise of film and amplifier at the output, and the ratio of a signal to it.

Thermal noise of each resistor and of the film's dielectric loss (Johnson 1928, Nyquist 1928), the
amplifier's input voltage and current noise, white. Each source goes through the network alone; their powers
add. The network itself is without the film's loss.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.constants import Boltzmann

from skincad.base.errors import InputError
from skincad.circuit.closed_form import output_factor
from skincad.circuit.network import Constants, Real, angular, feedback_impedance, motional_impedance


@dataclass(frozen=True)
class NoiseSources:
    """Temperature, K; amplifier's input noise, V/sqrt(Hz) and A/sqrt(Hz); the film's own part of Cpvd, F."""

    temperature: float
    voltage_density: float
    current_density: float
    loss_tangent: float
    film_capacitance: float


def noise_density(c: Constants, n: NoiseSources, frequency: Real) -> dict[str, Real]:
    """Return the one-sided power density at the output by source, `(n,)` V2/Hz each, at `(n,)` Hz."""
    jw = angular(frequency)
    motional, r12 = motional_impedance(c, jw), c.series_resistance
    feedback = feedback_impedance(c, jw)
    behind = feedback + c.output_resistance
    film = jw * c.capacitance + 1 / motional
    node = jw * c.input_capacitance + 1 / c.input_resistance + (1 + c.gain) / behind
    # vd by 1 A into the film's node, into the input node, and by 1 V in series with R1 + R2
    below = film + node + film * node * r12
    from_film, from_input, from_series = 1 / below, (1 + film * r12) / below, film / below
    thermal = 4 * Boltzmann * n.temperature
    factor = output_factor(c, jw)
    # the amplifier's own voltage e: i4 = (vn + A (vn + e)) / behind, vout = A (vn + e) - Ropo i4
    direct = c.gain * feedback / behind
    # a voltage e in series with feedback (or Ropo): i4 = ((1 + A) vn + e) / behind; with Ropo also in vout
    back = -from_input / behind
    loss = thermal * 2 * np.pi * frequency * n.film_capacitance * n.loss_tangent
    size = {
        "film loss": loss * np.abs(factor * from_film) ** 2,
        "motional resistance": thermal * c.motional_resistance * np.abs(factor * from_film / motional) ** 2,
        "series resistance": thermal * r12 * np.abs(factor * from_series) ** 2,
        "input resistance": thermal / c.input_resistance * np.abs(factor * from_input) ** 2,
        "feedback resistance": thermal
        * c.feedback_resistance
        * np.abs(feedback / c.feedback_resistance * (factor * back - c.output_resistance / behind)) ** 2,
        "output resistance": thermal * c.output_resistance * np.abs(factor * back + feedback / behind) ** 2,
        "amplifier voltage": n.voltage_density**2 * np.abs(direct + c.gain * factor * back) ** 2,
        "amplifier current": n.current_density**2 * np.abs(factor * from_input) ** 2,
    }
    return {name: np.asarray(power, float) for name, power in size.items()}


def total_density(c: Constants, n: NoiseSources, frequency: Real) -> Real:
    """Return the one-sided power density at the output of all sources, `(n,)` V2/Hz."""
    return np.asarray(sum(noise_density(c, n, frequency).values()))


def noise_rms(c: Constants, n: NoiseSources, low: float, high: float) -> float:
    """Return the output's noise from `low` to `high` Hz, V rms; trapezoids over 400 points a decade."""
    if not 0 < low < high < math.inf:
        raise InputError("band", "must be from above 0 Hz to a higher frequency", (low, high))
    points = max(50, int(400 * math.log10(high / low)))
    frequency = np.geomspace(low, high, points)
    return math.sqrt(float(np.trapezoid(total_density(c, n, frequency), frequency)))


def noise_samples(
    c: Constants, n: NoiseSources, rate: float, count: int, seed: int | tuple[int, ...]
) -> Real:
    """Return noise at the output, `(count,)` V at `rate` Hz, normal, with the density up to rate / 2.

    Periodic over `count`, without a mean; the same seed gives the same noise.
    """
    if count < 2 or not (np.isfinite(rate) and rate > 0):
        raise InputError("rate", "must be above 0 Hz, with two samples at least", rate)
    frequency = np.asarray(np.fft.rfftfreq(count, 1 / rate), float)
    draw = np.random.default_rng(seed)
    parts = draw.standard_normal((2, frequency.size))
    amplitude = np.zeros(frequency.size)
    amplitude[1:] = np.sqrt(total_density(c, n, frequency[1:]) * rate * count / 4)
    spectrum = amplitude * (parts[0] + 1j * parts[1])
    if count % 2 == 0:
        spectrum[-1] = math.sqrt(2) * amplitude[-1] * parts[0, -1]
    return np.asarray(np.fft.irfft(spectrum, count))


def signal_to_noise(signal: Real, c: Constants, n: NoiseSources, low: float, high: float) -> float:
    """Return the ratio, dB, of a noiseless output's rms, its mean left out, to the noise in a band, Hz."""
    signal = np.asarray(signal, float)
    noise, size = noise_rms(c, n, low, high), float(np.std(signal))
    if size == 0 or noise == 0:
        raise InputError("signal", "and noise must not be 0 for a ratio", (size, noise))
    return 20 * math.log10(size / noise)
