"""An amplifier of finite gain-bandwidth: by hand, by states, by SPICE, and where a large feedback rings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from skincad.base import InputError
from skincad.circuit import Constants, circuit_network, constants, decibels, gain, load_circuit, total_density
from skincad.circuit.network import TOPOLOGIES, NoiseSources, element_lines, network
from skincad.circuit.response import noise_density, response
from tests.circuit.paper import angular, exact_response
from tests.circuit.sets import random_sets, state_response
from tests.circuit.spice import needs_ngspice, spice_gain_error

BAND = np.geomspace(10.0, 20_000.0, 33)
TRANSIMPEDANCE = constants(load_circuit("transimpedance"))


def slow_sets(count: int) -> list[Constants]:
    """Constants with gain-bandwidths from 10 kHz to 100 MHz."""
    drawn = np.exp(np.random.default_rng(9).uniform(*np.log([1e4, 1e8]), count))
    return [replace(c, gain_bandwidth=float(f)) for c, f in zip(random_sets(count), drawn, strict=True)]


def by_hand(c: Constants, frequency: float) -> complex:
    """The paper's equations with A at this frequency in A's place: it is complex there."""
    open_loop = c.gain / (1 + angular(np.array([frequency]))[0] * c.gain / (2 * np.pi * c.gain_bandwidth))
    there = replace(c, gain=1.0, gain_bandwidth=0.0)
    object.__setattr__(there, "gain", open_loop)  # Constants are real otherwise
    return complex(exact_response(there, np.array([frequency]))[0])


def test_it_is_the_papers_network_with_a_falling_gain_on_200_random_sets() -> None:
    for c in slow_sets(200):
        hand = [by_hand(c, float(f)) for f in BAND[::4]]
        # 1e-10: the hand's own sum of rows where A Ropo is near Rf
        np.testing.assert_allclose(response(network(c), BAND[::4]), hand, rtol=1e-10)


@pytest.mark.parametrize("topology", TOPOLOGIES)
def test_state_equations_have_the_response_of_the_elements(topology: str) -> None:
    """Solved at jw: rows differ by up to 1e16, hence 1e-5, as without the pole."""
    for c in slow_sets(50):
        elements = network(c, topology=topology)
        states = state_response(elements, c.d33, BAND)
        np.testing.assert_allclose(states, response(elements, BAND), rtol=1e-5)


@needs_ngspice
@pytest.mark.parametrize("name", ["transimpedance", "charge-amplifier", "voltage-follower"])
def test_spices_gain(tmp_path: Path, name: str) -> None:
    slow = circuit_network(load_circuit(name, ["amplifier.gain_bandwidth=1e6"]))
    # its own digits, at a resonance of quality 60
    assert spice_gain_error(tmp_path, slow, element_lines(slow), "dec 50 10 20000") < 1e-6


def test_a_large_bandwidth_is_no_limit() -> None:
    """The change falls as 1 / bandwidth."""
    whole = response(network(TRANSIMPEDANCE), BAND)
    sizes = [
        np.abs(response(network(replace(TRANSIMPEDANCE, gain_bandwidth=b)), BAND) / whole - 1).max()
        for b in (1e12, 1e13)
    ]
    assert sizes[0] < 1e-4
    assert sizes[1] == pytest.approx(sizes[0] / 10, rel=0.01)


def test_film_and_feedback_ring_at_the_mean_of_their_corner_and_the_bandwidth() -> None:
    """Behind R_f the falling gain is an inductance, R_f / (2 pi B): it rings with what lies at the input at
    sqrt(B / (2 pi R_f C)) (Graeme, Photodiode Amplifiers, 1996, chapter 3); C_f = sqrt(2) / (2 pi R_f f)
    calms it, as flat as two poles can be.
    """
    c = replace(TRANSIMPEDANCE, gain_bandwidth=1e6)
    # the motional branch, far below its resonance, is a capacitor too
    whole = c.capacitance + c.motional_capacitance + c.input_capacitance
    wanted = np.sqrt(c.gain_bandwidth / (2 * np.pi * c.feedback_resistance * whole))
    frequency = np.geomspace(1e3, 20_000.0, 4001)
    plain = response(network(TRANSIMPEDANCE), frequency)
    rise = decibels(response(network(c), frequency) / plain)
    assert frequency[rise.argmax()] == pytest.approx(wanted, rel=0.01)
    assert rise.max() > 30.0
    calm = replace(c, feedback_capacitance=np.sqrt(2) / (2 * np.pi * c.feedback_resistance * wanted))
    assert decibels(response(network(calm), frequency) / plain).max() < 0.1


def test_the_papers_slopes_hardly_feel_a_common_amplifiers_bandwidth() -> None:
    """1 MHz, the least of common ones: below the drop at 9 kHz 0.5 dB, at the cut-off a hundredth."""
    common, none = (
        gain(load_circuit("yamada-2002", [f"amplifier.gain_bandwidth={b}"])) for b in ("1e6", "0.0")
    )
    change = common.gain - none.gain
    assert np.abs(change[none.frequency <= 1200.0]).max() < 0.01
    assert 0.3 < np.abs(change[none.frequency <= 9000.0]).max() < 0.6
    assert common.slopes.above.value == pytest.approx(60.0, abs=0.5)


def test_its_pole_adds_no_noise() -> None:
    """A resistor of 1 ohm, 0.13 nV/sqrt(Hz), where the input's 10 nV/sqrt(Hz) are 1e5 times as loud at a low
    frequency, and still 50 times at 20 kHz."""
    n = NoiseSources(293.0, 1e-8, 1e-15)
    slow = network(replace(TRANSIMPEDANCE, gain_bandwidth=1e6), n)
    share = noise_density(slow, BAND)["Rpole"] / total_density(slow, BAND)
    assert share.max() < 1e-6


def test_one_below_0_is_told() -> None:
    with pytest.raises(InputError, match=r"amplifier\.gain_bandwidth: must be greater than or equal to 0"):
        load_circuit("transimpedance", ["amplifier.gain_bandwidth=-1.0"])
    with pytest.raises(InputError, match="gain_bandwidth: must not be below 0"):
        replace(TRANSIMPEDANCE, gain_bandwidth=-1.0)
    with pytest.raises(InputError, match=r"amplifier\.gain_bandwidth: must be 0 Hz where constants"):
        gain(load_circuit("transimpedance", ["amplifier.gain_bandwidth=1e6"]), "measured.csv")
