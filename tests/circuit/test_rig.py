"""The frequency test's rig: what it makes of the load, and that none of it is in use."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.circuit import circuit_network, film_load, gain, load_circuit, netlist, told_rig, without_rig
from skincad.circuit.bode import has_rig
from skincad.inputs import retyped

FREQUENCY = np.geomspace(1.0, 1e5, 51)
INDENTER, SENSOR = "indenter={resonance=9000.0,damping=0.5}", "force_sensor={resonance=1000.0,damping=0.25}"


def test_without_a_rig_the_film_feels_what_is_measured() -> None:
    circuit = load_circuit("transimpedance")
    assert not has_rig(circuit)
    np.testing.assert_array_equal(film_load(circuit, FREQUENCY), np.ones(51))
    assert gain(circuit).own is None
    assert "own_signal" not in gain(circuit).as_json()


def test_an_indenter_keeps_load_from_the_film_and_a_sensor_from_the_reading() -> None:
    """Far above either resonance, the square of the ratio, by mass alone; both below, all of the load."""
    with_indenter, with_sensor = (load_circuit("transimpedance", [part]) for part in (INDENTER, SENSOR))
    both = load_circuit("transimpedance", [INDENTER, SENSOR])
    far, low = np.array([1e7]), np.array([1.0])
    assert np.abs(film_load(with_indenter, far)) == pytest.approx((9000.0 / 1e7) ** 2, rel=1e-3)
    assert np.abs(film_load(with_sensor, far)) == pytest.approx((1e7 / 1000.0) ** 2, rel=1e-3)
    product = film_load(with_indenter, FREQUENCY) * film_load(with_sensor, FREQUENCY)
    np.testing.assert_allclose(film_load(both, FREQUENCY), product, rtol=1e-12)
    assert np.abs(film_load(both, low)) == pytest.approx(1.0, abs=2e-6)  # (1 / 1000)^2


def test_the_circuit_in_use_is_the_same_film_and_amplifier() -> None:
    circuit = load_circuit("yamada-2002")
    used = without_rig(circuit)
    whole, alone = gain(circuit), gain(used)
    assert whole.own is not None
    np.testing.assert_array_equal(alone.gain, whole.own.gain)
    assert alone.own is None
    assert circuit_network(used) == circuit_network(circuit)
    assert netlist(alone.network, "x") == netlist(whole.network, "x")


def test_the_circuit_in_use_is_typed_again_in_one_line() -> None:
    words = retyped(without_rig(load_circuit("yamada-2002")), "circuits", load_circuit)
    assert words == "yamada-2002 --set indenter=none --set force_sensor=none"


def test_a_rig_is_told_by_its_parts() -> None:
    texts = [
        told_rig(load_circuit("transimpedance", list(s))) for s in ([INDENTER], [SENSOR], [INDENTER, SENSOR])
    ]
    assert texts == [
        "the indenter at 9000 Hz",
        "the force sensor at 1000 Hz",
        "the indenter at 9000 Hz and the force sensor at 1000 Hz",
    ]
