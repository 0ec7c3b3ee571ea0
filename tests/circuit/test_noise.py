"""Noise at the output: each source's way through the network, its samples, and the ratio to a signal."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.constants import Boltzmann

from skincad.base import InputError
from skincad.circuit import Constants, constants, load_circuit, noise_samples, total_density
from skincad.circuit.model import noise_sources
from skincad.circuit.network import NoiseSources, element_lines, network
from skincad.circuit.response import noise_density
from tests.circuit.spice import needs_ngspice, vectors

NAMES = ("yamada-2002", "yamada-2002-motional", "transimpedance", "charge-amplifier")
SPICE_KELVIN = 293.15
QUIET = NoiseSources(SPICE_KELVIN, 0.0, 0.0, 0.0, 0.0)


@pytest.fixture(params=NAMES)
def c(request: pytest.FixtureRequest) -> Constants:
    return constants(load_circuit(request.param))


@needs_ngspice
def test_the_resistors_noise_is_spices(tmp_path: Path, c: Constants) -> None:
    # a poor amplifier too: its output's resistance is heard only there
    for case in (c, replace(c, output_resistance=c.feedback_resistance / 2, gain=5.0)):
        lines = ["Vload load 0 DC 0 AC 1", *element_lines(network(case)), ".options temp=20"]
        saved = ["onoise_spectrum"]
        spice = vectors(tmp_path, lines, "noise v(vout) Vload dec 10 10 20000", saved)
        ours = total_density(network(case, QUIET), spice["frequency"])
        # SPICE's spectrum is V/sqrt(Hz); its Boltzmann constant differs from CODATA's in the sixth digit
        np.testing.assert_allclose(np.sqrt(ours), spice["onoise_spectrum"], rtol=2e-5)
        (tmp_path / "out.raw").unlink()


@needs_ngspice
def test_amplifier_noise_takes_the_way_that_spice_finds(tmp_path: Path, c: Constants) -> None:
    """A source of 1 V before the amplifier, and one of 1 A into its input, by an AC analysis each."""
    body = [line for line in element_lines(network(c)) if not line.startswith("Eamp")]
    volt = ["Vload load 0 DC 0", *body, "Vn seen in AC 1", f"Eamp amp 0 seen 0 {-c.gain!r}"]
    ampere = ["Vload load 0 DC 0", *element_lines(network(c)), "In 0 in AC 1"]
    n = NoiseSources(293.0, 1.0, 1.0, 0.0, 0.0)
    for lines, name in ((volt, "Eamp voltage"), (ampere, "Eamp current into in")):
        spice = vectors(tmp_path, lines, "ac dec 10 10 20000", ["v(vout)"])
        ours = noise_density(network(c, n), spice["frequency"].real)[name]
        np.testing.assert_allclose(np.sqrt(ours), np.abs(spice["v(vout)"]), rtol=1e-6)
        (tmp_path / "out.raw").unlink()


def test_a_lossy_films_noise_is_that_of_its_loss_current() -> None:
    """At one frequency a conductance w C tan(delta) at the film: as the input's, at the film's node."""
    c = constants(load_circuit("transimpedance", ["amplifier.series_resistance=1e-3"]))
    frequency = np.array([1000.0])
    conductance = 2 * np.pi * 1000.0 * 11e-12 * 0.02
    lossy = noise_density(network(c, NoiseSources(293.0, 0.0, 1.0, 0.02, 11e-12)), frequency)
    thermal = 4 * Boltzmann * 293.0 * conductance
    # with R1 + R2 next to nothing, film and input are one node
    assert lossy["Cpvd loss"][0] == pytest.approx(thermal * lossy["Eamp current into in"][0], rel=1e-6)


def test_samples_have_the_density_and_the_seed_is_the_noise(c: Constants) -> None:
    n = network(c, NoiseSources(293.0, 1e-8, 1e-15, 0.02, 1e-11))
    rate, count = 40_000.0, 40_000
    one = noise_samples(n, rate, count, seed=1)
    np.testing.assert_array_equal(one, noise_samples(n, rate, count, seed=1))
    lines = [np.abs(np.fft.rfft(noise_samples(n, rate, count, seed)))[100:] for seed in range(20)]
    many = 2 * np.mean([np.sum((line / count) ** 2) for line in lines])
    # from 100 Hz on, where a line of 1 Hz is narrow against the density's own slope; a chi-square over some
    # 100 000 lines, most of them where the gain peaks, a charge amplifier's at the low end: 5 %
    frequency = np.geomspace(100.0, rate / 2, 1000)
    assert many == pytest.approx(np.trapezoid(total_density(n, frequency), frequency), rel=0.05)


def test_the_circuits_own_sources() -> None:
    circuit = load_circuit("yamada-2002", ["noise.temperature=300.0"])
    n = noise_sources(circuit)
    assert (n.temperature, n.voltage_density, n.current_density) == (300.0, 10e-9, 1e-15)
    assert n.film_capacitance + circuit.cable.capacitance == pytest.approx(constants(circuit).capacitance)


@pytest.mark.parametrize(("rate", "count"), [(0.0, 8), (-1.0, 8), (math.inf, 8), (math.nan, 8), (1e3, 1)])
def test_a_rate_that_is_none_and_a_single_sample_are_refused(rate: float, count: int) -> None:
    with pytest.raises(InputError, match="rate: must be above 0 Hz, with at least two samples"):
        noise_samples(network(constants(load_circuit("transimpedance"))), rate, count, 1)
