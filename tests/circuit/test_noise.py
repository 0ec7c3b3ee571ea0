"""Noise at the output: each source's way through the network, by hand, by SPICE and as samples."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.constants import Boltzmann

from skincad.base import InputError
from skincad.circuit import (
    Network,
    circuit_network,
    constants,
    load_circuit,
    noise_samples,
    total_density,
)
from skincad.circuit.network import Capacitor, NoiseSources, Resistor, Source, network
from skincad.circuit.response import noise_density, response
from skincad.inputs import template_names
from tests.circuit.spice import LOAD, element_lines, needs_ngspice, vectors

BAND = np.geomspace(10.0, 20_000.0, 33)
CIRCUITS = {name: load_circuit(name) for name in template_names("circuits")}
FOLLOWER = constants(CIRCUITS["voltage-follower"])
AMPLIFIER = NoiseSources(293.0, 1e-8, 1e-15, 0.02, 1e-11)
TOPOLOGIES = ("inverting", "follower")


def of(name: str, n: NoiseSources, **changes: float) -> Network:
    """A shipped circuit with other noise."""
    circuit = CIRCUITS[name]
    return network(replace(constants(circuit), **changes), n, circuit.amplifier.topology)


@needs_ngspice
@pytest.mark.parametrize("name", CIRCUITS)
def test_the_resistors_noise_is_spices(tmp_path: Path, name: str) -> None:
    """Of a poor amplifier too: its output's resistance is heard only there."""
    poor = {"output_resistance": constants(CIRCUITS[name]).feedback_resistance / 2, "gain": 5.0}
    for changes in ({}, poor):
        quiet = of(name, NoiseSources(293.15), **changes)
        lines = [LOAD, *element_lines(quiet), ".options temp=20"]
        spice = vectors(tmp_path, lines, "noise v(vout) Vload dec 10 10 20000", ["onoise_spectrum"])
        ours = total_density(quiet, spice["frequency"])
        # SPICE's spectrum is V/sqrt(Hz); its Boltzmann constant differs from CODATA's in the sixth digit
        np.testing.assert_allclose(np.sqrt(ours), spice["onoise_spectrum"], rtol=2e-5)
        (tmp_path / "out.raw").unlink()


@needs_ngspice
@pytest.mark.parametrize("name", [name for name in CIRCUITS if name != "voltage-follower"])
def test_amplifier_noise_takes_the_way_that_spice_finds(tmp_path: Path, name: str) -> None:
    """A source of 1 V before the amplifier, and one of 1 A into its input, by an AC analysis each."""
    loud = of(name, NoiseSources(293.0, 1.0, 1.0))
    elements, amplifier = element_lines(loud), constants(CIRCUITS[name]).gain
    body = [line for line in elements if not line.startswith("Eamp")]
    volt = ["Vload load 0 DC 0", *body, "Vn seen in AC 1", f"Eamp amp 0 seen 0 {-amplifier!r}"]
    ampere = ["Vload load 0 DC 0", *elements, "In 0 in AC 1"]
    for lines, source in ((volt, "Eamp voltage"), (ampere, "Eamp current into in")):
        spice = vectors(tmp_path, lines, "ac dec 10 10 20000", ["v(vout)"])
        ours = noise_density(loud, spice["frequency"].real)[source]
        np.testing.assert_allclose(np.sqrt(ours), np.abs(spice["v(vout)"]), rtol=1e-6)
        (tmp_path / "out.raw").unlink()


def way(network: Network, node: str) -> np.ndarray:
    """The output by 1 A into a node: a load of 1 through a resistance next to which all others are none."""
    huge = Resistor("Rhuge", "load", node, 1e25)
    silent = [replace(e, value=0.0) if e.name == "Epv" else e for e in network.elements]
    return response(Network((*silent, huge), 1.0), BAND) * huge.value


@pytest.mark.parametrize("topology", TOPOLOGIES)
@pytest.mark.parametrize("gain", [5.0, 1e5])
def test_each_noise_source_goes_the_way_of_a_current_in_its_place(topology: str, gain: float) -> None:
    c = replace(FOLLOWER, gain=gain, output_resistance=5e3, feedback_capacitance=1e-11)
    quiet = network(c, topology=topology)
    densities = noise_density(network(c, AMPLIFIER, topology), BAND)
    nodes, thermal = {e.a for e in quiet.elements if isinstance(e, Source)}, 4 * Boltzmann * 293.0
    exact = {}
    for e in quiet.elements:
        if isinstance(e, Resistor | Capacitor):
            a, b = (way(quiet, node) if node not in {*nodes, "0"} else 0.0 for node in (e.a, e.b))
            loss = 2 * np.pi * BAND * 1e-11 * 0.02
            density = 1 / e.value if isinstance(e, Resistor) else loss
            exact[e.name] = thermal * density * np.abs(a - b) ** 2
    eamp = next(e for e in quiet.elements if isinstance(e, Source) and e.name == "Eamp")
    for node in {eamp.plus, eamp.minus} - {"0"}:
        exact[f"Eamp current into {node}"] = 1e-30 * np.abs(way(quiet, node)) ** 2
    # 1 V more at the input, and no load elsewhere
    shifted = [replace(e, value=0.0) if e.name == "Epv" else e for e in quiet.elements if e is not eamp]
    seen = (Source("Eneg", "neg", "load", "0", -1.0), Source("Eseen", "seen", eamp.plus, "neg", 1.0))
    loud = response(Network((*shifted, *seen, replace(eamp, plus="seen")), 1.0), BAND)
    exact["Eamp voltage"] = 1e-16 * np.abs(loud) ** 2
    for name, density in densities.items():
        # 1e-9: what a node of 1e9 ohm leaves beside 1e25
        np.testing.assert_allclose(density, exact[name.removesuffix(" loss")], rtol=1e-9, err_msg=name)
    assert len(densities) == sum(isinstance(e, Resistor) for e in quiet.elements) + 3 + (
        topology == "follower"
    )


def test_the_followers_noise_by_hand_in_its_band() -> None:
    """Its own voltage noise and that of the feedback's resistor come out as they are."""
    densities = noise_density(network(FOLLOWER, AMPLIFIER, "follower"), np.array([1000.0]))
    # 1e-4: a gain of 1e5
    assert densities["Eamp voltage"][0] == pytest.approx(1e-16, rel=1e-4)
    assert densities["R34"][0] == pytest.approx(
        4 * Boltzmann * 293.0 * FOLLOWER.feedback_resistance, rel=1e-4
    )


def test_a_poles_resistor_adds_no_noise() -> None:
    """A resistor of 1 ohm, 0.13 nV/sqrt(Hz), where the input's 10 nV/sqrt(Hz) are 1e5 times as loud at a low
    frequency, and still 50 times at 20 kHz."""
    slow = of("transimpedance", NoiseSources(293.0, 1e-8, 1e-15), gain_bandwidth=1e6)
    share = noise_density(slow, BAND)["Rpole"] / total_density(slow, BAND)
    assert share.max() < 1e-6


def test_a_lossy_films_noise_is_that_of_its_loss_current() -> None:
    """At one frequency a conductance w C tan(delta) at the film: as the input's, at the film's node."""
    c = constants(load_circuit("transimpedance", ["amplifier.series_resistance=1e-3"]))
    frequency = np.array([1000.0])
    conductance = 2 * np.pi * 1000.0 * 11e-12 * 0.02
    lossy = noise_density(network(c, NoiseSources(293.0, 0.0, 1.0, 0.02, 11e-12)), frequency)
    thermal = 4 * Boltzmann * 293.0 * conductance
    # with R1 + R2 next to nothing, film and input are one node
    assert lossy["Cpvd loss"][0] == pytest.approx(thermal * lossy["Eamp current into in"][0], rel=1e-6)


@pytest.mark.parametrize("name", [name for name in CIRCUITS if name != "voltage-follower"])
def test_samples_have_the_density_and_the_seed_is_the_noise(name: str) -> None:
    n, rate, count = of(name, AMPLIFIER), 40_000.0, 40_000
    one = noise_samples(n, rate, count, seed=1)
    np.testing.assert_array_equal(one, noise_samples(n, rate, count, seed=1))
    lines = [np.abs(np.fft.rfft(noise_samples(n, rate, count, seed)))[100:] for seed in range(20)]
    many = 2 * np.mean([np.sum((line / count) ** 2) for line in lines])
    # from 100 Hz on, where a line of 1 Hz is narrow against the density's own slope; a chi-square over some
    # 100 000 lines, most of them where the gain peaks, a charge amplifier's at the low end: 5 %
    frequency = np.geomspace(100.0, rate / 2, 1000)
    assert many == pytest.approx(np.trapezoid(total_density(n, frequency), frequency), rel=0.05)


def test_a_circuits_own_sources() -> None:
    """Only the film loses: its lead, in parallel, adds capacitance alone."""
    circuit = load_circuit("yamada-2002", ["noise.temperature=300.0", "cable.capacitance=3e-10"])
    c, whole = constants(circuit), circuit_network(circuit)
    film = constants(load_circuit("yamada-2002", ["cable.capacitance=0"])).capacitance
    # eps0 eps A / d: 8.8542e-12 F/m x 12 x 11.95 mm2 / 0.028 mm
    assert film == pytest.approx(8.8542e-12 * 12 * 11.95e-6 / 0.028e-3, rel=1e-4)
    assert c.capacitance - film == pytest.approx(3e-10, rel=1e-9)
    assert whole == network(c, NoiseSources(300.0, 10e-9, 1e-15, circuit.film.loss_tangent, film))


@pytest.mark.parametrize(("rate", "count"), [(0.0, 8), (-1.0, 8), (math.inf, 8), (math.nan, 8), (1e3, 1)])
def test_a_rate_that_is_none_and_a_single_sample_are_refused(rate: float, count: int) -> None:
    with pytest.raises(InputError, match="rate: must be above 0 Hz, with at least two samples"):
        noise_samples(network(constants(load_circuit("transimpedance"))), rate, count, 1)
