"""A capacitor in the feedback: the output is the stress itself, and fades on a hold."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from skincad.base import InputError
from skincad.circuit import (
    Constants,
    circuit_network,
    constants,
    decibels,
    gain,
    load_circuit,
    run,
    state_space,
    stepper,
)
from skincad.circuit.network import element_lines, network
from skincad.circuit.response import response
from tests.circuit.paper import exact_response, loop_response
from tests.circuit.sets import output, random_sets, state_response
from tests.circuit.spice import needs_ngspice, spice_gain_error

BAND = np.geomspace(10.0, 20_000.0, 33)
CIRCUIT = load_circuit("charge-amplifier")
C = constants(CIRCUIT)
NETWORK = circuit_network(CIRCUIT)
TAU = C.feedback_resistance * C.feedback_capacitance


def sets_with_capacitor(count: int) -> list[Constants]:
    drawn = np.exp(np.random.default_rng(5).uniform(*np.log([1e-12, 1e-8]), count))
    return [replace(c, feedback_capacitance=f) for c, f in zip(random_sets(count), drawn, strict=True)]


def test_loop_node_and_state_equations_agree_on_200_random_sets() -> None:
    """Loops against nodes nearly as without the capacitor; states are solved at jw, rows up to 1e16 apart."""
    for c in sets_with_capacitor(200):
        exact = exact_response(c, BAND)
        assert np.abs(decibels(loop_response(c, BAND) / exact)).max() < 1e-7
        np.testing.assert_allclose(response(network(c), BAND), exact, rtol=1e-12)
        np.testing.assert_allclose(state_response(network(c), c.d33, BAND), exact, rtol=1e-5)


@needs_ngspice
def test_spices_gain(tmp_path: Path) -> None:
    """Its transient is test_state's, as every circuit's."""
    assert spice_gain_error(tmp_path, NETWORK, element_lines(NETWORK), "dec 10 0.01 20000") < 1e-7  # 1e-6 dB


def test_a_step_of_charge_is_held_and_fades_with_the_feedbacks_time() -> None:
    charge = np.r_[0.0, np.full(20_000, 1e-12)]
    time = np.arange(charge.size) * 1e-4
    voltage, _ = run(stepper(NETWORK, 1e4), charge)
    exact = 1e-12 / C.feedback_capacitance * np.exp(-time / TAU)
    # 1e-3: the film's own branch and the amplifier's gain of 1e5 take a share; half a step of 1e-4 s of 1 s
    assert np.abs(voltage[10:] - exact[10:]).max() < 1e-3 * exact[0]


@pytest.mark.parametrize("resistance", [1e9, 1e10, 1e11])
def test_the_drift_on_a_hold_is_what_the_feedbacks_time_says(resistance: float) -> None:
    """Of a load put on in 10 ms and held for 0.4 s, as in the scene `hold`."""
    c = replace(C, feedback_resistance=resistance)
    time = np.arange(0.0, 0.41, 1e-3)
    voltage = output(network(c), 1e-12 * np.clip(time / 0.01, 0.0, 1.0), 1e3)
    tau = resistance * c.feedback_capacitance
    # the charge came evenly over 0.01 s; 1e-4: a gain of 1e5 and an input of 1e12 ohm
    exact = 1e-12 / c.feedback_capacitance * tau / 0.01 * -math.expm1(-0.01 / tau) * math.exp(-0.4 / tau)
    assert voltage[-1] == pytest.approx(exact, abs=1e-3 * voltage.max())


def test_it_follows_the_stress_where_the_transimpedance_follows_its_rate() -> None:
    time = np.arange(0.0, 0.02, 1e-5)
    stress = np.sin(2 * np.pi * 100.0 * time) ** 2
    voltage = output(NETWORK, stress * C.d33, 1e5)
    rate = output(circuit_network(load_circuit("transimpedance")), stress * C.d33, 1e5)
    assert np.corrcoef(voltage, stress)[0, 1] < -0.999  # d33 is below 0
    # the half period has as many rises as falls
    assert abs(np.corrcoef(rate, stress)[0, 1]) < 0.2


def test_its_low_cut_off_is_found() -> None:
    slopes = gain(CIRCUIT).slopes
    assert slopes.cutoff.value == pytest.approx(1 / (2 * math.pi * TAU), abs=slopes.cutoff.error)
    assert slopes.above.value == pytest.approx(0.0, abs=slopes.above.error or 0.0)
    # 17.6 of 20: the corner is round, and two decades of slope do not outweigh it
    assert slopes.below.value == pytest.approx(20.0, abs=3.0)
    level = 20 * math.log10(abs(C.d33) / C.feedback_capacitance)
    assert gain(CIRCUIT).gain[300] == pytest.approx(level, abs=0.01)


def test_without_the_capacitor_it_is_the_paper_s_network() -> None:
    plain = constants(load_circuit("charge-amplifier", ["amplifier.feedback_capacitance=0.0"]))
    assert state_space(network(plain)).a.shape == (4, 4)
    nearly = replace(plain, feedback_capacitance=1e-18)  # 1e10 ohm and 1e-18 F: 16 MHz
    ratio = response(network(nearly), BAND) / response(network(plain), BAND)
    assert np.abs(ratio - 1).max() < 2e-3


def test_what_cannot_be_is_told() -> None:
    with pytest.raises(InputError, match="feedback_capacitance: must not be below 0"):
        replace(C, feedback_capacitance=-1e-12)
    with pytest.raises(
        InputError, match=r"amplifier.feedback_capacitance: must be greater than or equal to 0"
    ):
        load_circuit("charge-amplifier", ["amplifier.feedback_capacitance=-1e-12"])
    with pytest.raises(InputError, match=r"amplifier.feedback_capacitance: must be 0 F where"):
        gain(CIRCUIT, "measured.csv")
