"""The amplifiers as lists of elements: each by every way, the follower by hand, and what cannot be."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.constants import Boltzmann

from skincad.base import InputError, RefusedError
from skincad.circuit import (
    Constants,
    Network,
    circuit_network,
    constants,
    gain,
    load_circuit,
    state_space,
    total_density,
)
from skincad.circuit.network import (
    TOPOLOGIES,
    Capacitor,
    NoiseSources,
    Resistor,
    Source,
    element_lines,
    network,
)
from skincad.circuit.response import noise_density, response
from tests.circuit.paper import angular, motional_impedance
from tests.circuit.sets import output, random_sets, state_response
from tests.circuit.spice import LOAD, needs_ngspice, spice_gain_error, vectors

BAND = np.geomspace(10.0, 20_000.0, 33)
CIRCUIT = load_circuit("voltage-follower")
C = constants(CIRCUIT)
AMPLIFIER = NoiseSources(293.0, 1e-8, 1e-15, 0.02, 1e-11)


def follower_response(c: Constants, frequency: np.ndarray) -> np.ndarray:
    """Solved by hand: the input's divider, and a gain of A / (1 + A)."""
    jw = angular(frequency)
    film = jw * c.capacitance + 1 / motional_impedance(c, jw)
    node = jw * c.input_capacitance + 1 / c.input_resistance
    return np.asarray(jw * c.d33 / (film + node + film * node * c.series_resistance) * c.gain / (1 + c.gain))


def test_the_follower_is_its_closed_form_on_200_random_sets() -> None:
    for c in random_sets(200):
        gains = response(network(c, topology="follower"), BAND)
        # 1e-12: some ten factors a product
        np.testing.assert_allclose(gains, follower_response(c, BAND), rtol=1e-12)


@pytest.mark.parametrize("topology", TOPOLOGIES)
def test_state_equations_have_the_response_of_the_elements(topology: str) -> None:
    """Solved at jw: rows differ by up to 1e16, hence 1e-5 and not 1e-12."""
    for c in random_sets(50):
        for capacitance in (0.0, 1e-11):
            elements = network(replace(c, feedback_capacitance=capacitance), topology=topology)
            states = state_response(elements, c.d33, BAND)
            np.testing.assert_allclose(states, response(elements, BAND), rtol=1e-5)


def way(network: Network, node: str) -> np.ndarray:
    """The output by 1 A into a node: a load of 1 through a resistance next to which all others are none."""
    huge = Resistor("Rhuge", "load", node, 1e25)
    silent = [replace(e, value=0.0) if e.name == "Epv" else e for e in network.elements]
    return response(Network((*silent, huge), 1.0), BAND) * huge.value


@pytest.mark.parametrize("topology", TOPOLOGIES)
@pytest.mark.parametrize("gain", [5.0, 1e5])
def test_each_noise_source_goes_the_way_of_a_current_in_its_place(topology: str, gain: float) -> None:
    c = replace(C, gain=gain, output_resistance=5e3, feedback_capacitance=1e-11)
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


def test_an_amplifier_of_finite_bandwidth_is_four_elements() -> None:
    """The closed form with A / (1 + jf A / bandwidth) for A, at each frequency; the 1 ohm is not heard."""
    bandwidth = 1e6
    slow = []
    for e in network(C, AMPLIFIER).elements:
        if e.name == "Eamp":
            pole = Capacitor("Cpole", "pole", "0", C.gain / (2 * np.pi * bandwidth))
            slow += [replace(e, a="fast"), Resistor("Rpole", "fast", "pole", 1.0), pole]
            slow.append(Source("Eslow", "amp", "pole", "0", 1.0))
        else:
            slow.append(e)
    transfer = response(Network(tuple(slow), C.d33), BAND)
    gains = C.gain / (1 + 1j * BAND * C.gain / bandwidth)
    jw = angular(BAND)
    film, behind = (
        jw * C.capacitance + 1 / motional_impedance(C, jw),
        C.feedback_resistance + C.output_resistance,
    )
    node = jw * C.input_capacitance + 1 / C.input_resistance + (1 + gains) / behind
    vd = jw * C.d33 / (film + node + film * node * C.series_resistance)
    exact = vd * (gains * C.feedback_resistance - C.output_resistance) / behind
    np.testing.assert_allclose(transfer, exact, rtol=1e-12)
    noise = noise_density(Network(tuple(slow), C.d33), BAND)
    assert (noise["Rpole"] < 1e-6 * noise["Eamp voltage"]).all()


def test_the_followers_noise_by_hand_in_its_band() -> None:
    """Its own voltage noise and that of the feedback's resistor come out as they are."""
    densities = noise_density(network(C, AMPLIFIER, "follower"), np.array([1000.0]))
    # 1e-4: a gain of 1e5
    assert densities["Eamp voltage"][0] == pytest.approx(1e-16, rel=1e-4)
    assert densities["R34"][0] == pytest.approx(4 * Boltzmann * 293.0 * C.feedback_resistance, rel=1e-4)


@needs_ngspice
def test_the_followers_gain_and_noise_are_spices(tmp_path: Path) -> None:
    """Its transient is test_state's, as every circuit's."""
    elements = network(C, NoiseSources(293.15), "follower")
    lines = [*element_lines(elements), ".options temp=20 method=trap"]
    assert spice_gain_error(tmp_path, elements, lines, "dec 10 0.05 20000") < 1e-7  # 1e-6 dB
    (tmp_path / "out.raw").unlink()
    spice = vectors(tmp_path, [LOAD, *lines], "noise v(vout) Vload dec 10 10 20000", ["onoise_spectrum"])
    ours = np.sqrt(total_density(elements, spice["frequency"]))
    # SPICE's Boltzmann constant differs from CODATA's in the sixth digit
    np.testing.assert_allclose(ours, spice["onoise_spectrum"], rtol=2e-5)


def test_the_followers_low_cut_off_and_level() -> None:
    curve = gain(CIRCUIT)
    # the motional branch is a capacitor too, far below its resonance
    whole = C.capacitance + C.motional_capacitance + C.input_capacitance
    corner = 1 / (2 * math.pi * C.input_resistance * whole)
    assert curve.slopes.cutoff.value == pytest.approx(corner, abs=curve.slopes.cutoff.error)
    middle = int(np.argmin(np.abs(curve.frequency - 500.0)))
    # 1e-3: one hundredth of the corner's frequency squared, and a gain of 1e5
    assert curve.gain[middle] == pytest.approx(20 * math.log10(abs(C.d33) / whole), abs=1e-3)


def test_a_step_of_charge_is_the_capacitors_voltage_and_fades_by_the_bias_resistor() -> None:
    whole = C.capacitance + C.motional_capacitance + C.input_capacitance
    voltage = output(circuit_network(CIRCUIT), np.r_[0.0, np.full(2000, 1e-12)], 1e5)
    exact = 1e-12 / whole * np.exp(-np.arange(2001) * 1e-5 / (C.input_resistance * whole))
    # 1e-3: half a step of 1e-5 s of 33 ms, the branch's ringing, a gain of 1e5
    assert np.abs(voltage[1500:] - exact[1500:]).max() < 1e-3 * exact[0]


def test_what_an_output_follows_at_once_goes_through() -> None:
    """A divider of two resistors: no state but the film's, and the charge's share comes without delay."""
    divider = Network(
        (
            Source("Epv", "pv", "load", "0", 2.0),
            Capacitor("C", "pv", "film", 1e-9),
            Resistor("R", "film", "0", 1e6),
            Source("Evout", "vout", "film", "0", 1.0),
        ),
        1.0,
    )
    s = state_space(divider)
    assert (s.a.item(), s.b.item(), s.c.item(), s.d) == pytest.approx((-1e3, 2e3, -1.0, 2.0))
    assert s.rest.item() == pytest.approx(2.0)
    voltage = output(divider, np.r_[np.zeros(1), np.ones(50)], 1e5)
    assert voltage[-1] == pytest.approx(2.0 * 100 * -math.expm1(-1e-2) * math.exp(-49e-2), rel=1e-9)


def test_a_loop_of_capacitors_and_sources_is_refused() -> None:
    loop = (Source("Epv", "pv", "load", "0", 1.0), Capacitor("C", "pv", "vout", 1e-9))
    with pytest.raises(RefusedError, match="a loop of capacitors"):
        state_space(Network((*loop, Capacitor("D", "vout", "0", 1e-9)), 1.0))


def test_an_unknown_topology_is_told_with_the_nearest() -> None:
    with pytest.raises(InputError, match=r"amplifier.topology: no such topology.*did you mean 'follower'"):
        load_circuit("transimpedance", ["amplifier.topology=folower"])


def test_a_follower_is_not_calibrated_to_a_curve() -> None:
    with pytest.raises(InputError, match=r"amplifier.topology: must be inverting where constants"):
        gain(CIRCUIT, "measured.csv")
