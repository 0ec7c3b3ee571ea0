"""The response of the elements against the paper's equations by hand, its printed formula and SPICE."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.campaign import rational
from skincad.base import InputError
from skincad.circuit import Constants, constants, decibels, load_circuit, netlist
from skincad.circuit.network import element_lines, network
from skincad.circuit.response import response
from tests.circuit.paper import departure, exact_response, loop_response, printed_response
from tests.circuit.sets import random_sets
from tests.circuit.spice import needs_ngspice, vectors

BAND = np.geomspace(10.0, 20_000.0, 67)


def test_loop_equations_and_node_equations_agree_on_200_random_sets() -> None:
    # 1e-8 dB is 1e-9 relative: pivots of 1e16 times double precision, with a margin of 100
    sets = random_sets(200)
    worst = max(np.abs(decibels(loop_response(c, BAND) / exact_response(c, BAND))).max() for c in sets)
    assert worst < 1e-8


def test_the_elements_and_the_node_equations_agree_in_phase_too_on_200_random_sets() -> None:
    for c in random_sets(200):
        # 1e-12: some ten factors a product, and the motional branch's resonance in the node equations
        np.testing.assert_allclose(response(network(c), BAND), exact_response(c, BAND), rtol=1e-12)


def test_no_digit_is_lost_where_the_output_cancels() -> None:
    """A of Ropo / Rf but for 1e-9, where the loop equations keep no digit: against fractions."""
    for c in random_sets(20):
        near = replace(c, gain=c.output_resistance / c.feedback_resistance * (1 + 1e-9))
        gains = decibels(response(network(near), BAND[::22]))
        exact = [rational.gain(near, float(f)) for f in BAND[::22]]
        # 1e-5: where the machine has no extended precision, ten roundings over 1e-9
        np.testing.assert_allclose(gains, exact, rtol=0, atol=1e-5)


@needs_ngspice
def test_elements_and_spice_agree_to_a_millionth_of_a_decibel(tmp_path: Path) -> None:
    sets, nodes = random_sets(200), ("pv", "film", "m1", "m2", "in", "out", "amp", "vout")
    lines = ["Vload load 0 DC 0 AC 1"]
    for i, c in enumerate(sets):
        for line in element_lines(network(c)):
            name, *rest = line.split()
            lines.append(" ".join([f"{name}_{i}", *(f"{w}_{i}" if w in nodes else w for w in rest)]))
    spice = vectors(tmp_path, lines, "ac dec 20 10 20000", [f"v(vout_{i})" for i in range(len(sets))])
    frequency = spice["frequency"].real
    assert frequency[0] == 10.0
    assert frequency[-1] > 19_000.0
    ours = [response(network(c), frequency) for c in sets]
    worst = max(np.abs(decibels(x / spice[f"v(vout_{i})"])).max() for i, x in enumerate(ours))
    assert worst < 1e-6  # what is asked: 1e-7 relative


@needs_ngspice
def test_the_exported_netlist_is_a_deck_that_spice_runs(tmp_path: Path) -> None:
    c = constants(load_circuit("yamada-2002"))
    body = netlist(network(c), "x").splitlines()
    lines = [line for line in body[1:] if line and not line.startswith(".")]
    spice = vectors(tmp_path, lines, body[-3].lstrip("."), ["v(vout)"])
    ratio = response(network(c), spice["frequency"].real) / spice["v(vout)"]
    assert np.abs(ratio - 1).max() < 1e-7  # sign and phase too


def test_the_printed_closed_form_departs_and_by_how_much() -> None:
    """(12) to (14) leave the source's terms out, and (10) takes i2 for ipv: level and shape both differ."""
    yamada, textbook = (constants(load_circuit(name)) for name in ("yamada-2002-motional", "transimpedance"))
    frequency = np.array([10.0, 100.0, 1200.0, 8000.0])
    # measured once, to 0.1 dB: a change of either form would show
    np.testing.assert_allclose(departure(yamada, frequency), [49.5, 50.9, 45.2, 23.6], atol=0.1)
    np.testing.assert_allclose(departure(textbook, frequency), [17.2, 4.1, 3.2, 3.2], atol=0.1)
    real = constants(load_circuit("yamada-2002"))
    np.testing.assert_allclose(departure(real, frequency), [43.7, 23.7, 4.5, 1.0], atol=0.1)


def test_the_printed_closed_form_knows_no_gain_of_the_amplifier() -> None:
    """It is no virtual ground: so it is the input's capacitance that moves its corner, as the paper says of
    it, while behind a gain of 1e5 that changes nothing."""
    c = constants(load_circuit("yamada-2002-motional"))
    np.testing.assert_array_equal(printed_response(replace(c, gain=7.0), BAND), printed_response(c, BAND))
    larger = replace(c, input_capacitance=2 * c.input_capacitance)
    moved, ours = (decibels(way(larger, BAND) / way(c, BAND)) for way in (printed_response, exact_response))
    assert np.abs(moved).max() > 3.0
    assert np.abs(ours).max() < 1e-3


def test_a_large_input_resistance_loses_no_digits() -> None:
    """The paper's i2 - i3 would keep none of them at 1e16 ohm."""
    c = replace(constants(load_circuit("yamada-2002")), input_resistance=1e16)
    assert np.abs(decibels(response(network(c), BAND) / exact_response(c, BAND))).max() < 1e-8


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"capacitance": 0.0}, "capacitance: must be above 0"),
        ({"motional_resistance": -1.0}, "motional_resistance: must be above 0"),
        ({"gain": 0.0}, "gain: must be above 0"),
        ({"output_resistance": float("nan")}, "output_resistance: must be a finite number"),
        ({"d33": 0.0}, "d33: must not be 0"),
    ],
)
def test_bad_constants_are_told_by_name(change: dict[str, float], words: str) -> None:
    good = constants(load_circuit("yamada-2002"))
    with pytest.raises(InputError, match=re.escape(words)):
        replace(good, **change)


@pytest.mark.parametrize("frequency", [0.0, -1.0, np.nan, np.inf])
def test_a_bad_frequency_is_told(frequency: float) -> None:
    with pytest.raises(InputError, match="frequency: must be above 0 Hz"):
        response(network(constants(load_circuit("yamada-2002"))), np.array([10.0, frequency]))


def test_constants_say_their_units() -> None:
    names = constants(load_circuit("yamada-2002")).as_json()
    assert {"d33_C_per_N", "capacitance_F", "motional_inductance_H", "gain"} <= set(names)
    assert len(names) == len(Constants.__dataclass_fields__)
