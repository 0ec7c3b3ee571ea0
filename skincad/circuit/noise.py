"""Noise of film and amplifier at the output.

Thermal noise of each resistor and of the film's dielectric loss (Johnson 1928, Nyquist 1928), the
amplifier's input voltage and current noise, white. Each source goes through the network alone; their powers
add. The network itself is without the film's loss.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.constants import Boltzmann

from skincad.base.errors import InputError
from skincad.circuit.elements import GROUND, LOAD, Capacitor, Network, Real, Resistor, Source
from skincad.circuit.response import Drive, transfers


def noise_density(network: Network, frequency: Real) -> dict[str, Real]:
    """Return the one-sided power density at the output by source, `(n,)` V2/Hz each, at `(n,)` Hz."""
    frequency = np.asarray(frequency, float)
    sources = list(_sources(network, frequency))
    ways = transfers(network, [drive for _, drive, _ in sources], frequency)
    terms = zip(sources, ways, strict=True)
    return {name: np.asarray(power * np.abs(way) ** 2, float) for (name, _, power), way in terms}


def _sources(network: Network, frequency: Real) -> Iterator[tuple[str, Drive, Real | float]]:
    """Each noise source: its name, where it drives the network, and its own density, V2/Hz or A2/Hz."""
    fixed = {GROUND, LOAD, *(e.a for e in network.elements if isinstance(e, Source))}
    thermal = 4 * Boltzmann * network.temperature
    for i, e in enumerate(network.elements):
        if isinstance(e, Source):
            if e.voltage_density:
                yield f"{e.name} voltage", ((e.a, 1 << i, 1),), e.voltage_density**2
            for node in sorted({e.plus, e.minus} - fixed) if e.current_density else ():
                yield f"{e.name} current into {node}", ((node, 0, 1),), e.current_density**2
            continue
        both = [(node, sign) for node, sign in ((e.a, 1), (e.b, -1)) if node not in fixed]
        if isinstance(e, Resistor):
            yield e.name, tuple((node, 1 << i, sign) for node, sign in both), thermal * e.value
        elif isinstance(e, Capacitor) and e.loss:
            conductance = 2 * np.pi * frequency * e.loss
            yield f"{e.name} loss", tuple((node, 0, sign) for node, sign in both), thermal * conductance


def total_density(network: Network, frequency: Real) -> Real:
    """Return the one-sided power density at the output of all sources, `(n,)` V2/Hz."""
    return np.asarray(sum(noise_density(network, frequency).values()))


def noise_samples(network: Network, rate: float, count: int, seed: int | tuple[int, ...]) -> Real:
    """Return noise at the output, `(count,)` V at `rate` Hz, normal, with the density up to rate / 2.

    Periodic over `count`, without a mean; the same seed gives the same noise.
    """
    if count < 2 or not (np.isfinite(rate) and rate > 0):
        raise InputError("rate", "must be above 0 Hz, with at least two samples", rate)
    frequency = np.asarray(np.fft.rfftfreq(count, 1 / rate), float)
    draw = np.random.default_rng(seed)
    parts = draw.standard_normal((2, frequency.size))
    amplitude = np.zeros(frequency.size)
    amplitude[1:] = np.sqrt(total_density(network, frequency[1:]) * rate * count / 4)
    spectrum = amplitude * (parts[0] + 1j * parts[1])
    if count % 2 == 0:
        spectrum[-1] = np.sqrt(2) * amplitude[-1] * parts[0, -1]
    return np.asarray(np.fft.irfft(spectrum, count))
