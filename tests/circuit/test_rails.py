"""An amplifier that one can buy: SPICE with the maker's figures, rails, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from skincad.circuit import (
    Circuit,
    at_rails,
    circuit_network,
    constants,
    decibels,
    load_circuit,
    output_offset,
    output_swing,
    total_density,
)
from skincad.circuit.response import noise_density, response
from tests.circuit.networks import bought, needs_ngspice, output, vectors
from tests.refusals import refused_by

NAMES = ("single-supply", "charge-amplifier", "voltage-follower")
FIGURES = [f"amplifier.{key}" for key in ("gain_bandwidth=10e6", "gain=3.2e6")]


def circuit_of(name: str, *settings: str) -> Circuit:
    """A template's circuit, with the bought amplifier's speed, 1/f noise and bias current."""
    more = (
        []
        if name == NAMES[0]
        else [*FIGURES, "noise.voltage_corner=2100.0", "amplifier.input_bias_current=5e-13"]
    )
    return load_circuit(name, [*more, *settings])


@needs_ngspice
@pytest.mark.evidence(subject="circuit: bought amplifier {name}")
@pytest.mark.parametrize("name", NAMES)
def test_gain_noise_and_rest_are_those_of_spice_with_the_makers_figures(tmp_path: Path, name: str) -> None:
    """1 dB is what is promised; the second pole, 57 dB above the band, leaves a hundredth of it."""
    circuit = circuit_of(name)
    whole = circuit_network(circuit)
    lines = bought(circuit, "Vload load 0 DC 0 AC 1")
    spice = vectors(tmp_path, lines, "ac dec 20 1 20000", ["v(vout)"])
    ours = decibels(response(whole, spice["frequency"].real) / spice["v(vout)"])
    assert np.abs(ours).max() < 0.01
    (tmp_path / "out.raw").unlink()
    spice = vectors(tmp_path, lines, "noise v(vout) Vload dec 20 1 20000", ["onoise_spectrum"])
    # without the film's loss, which SPICE's capacitor has not; 0.02: its Boltzmann constant, and the diodes
    quiet = circuit_network(circuit.with_(film={"loss_tangent": 0.0}))
    ours = 10 * np.log10(total_density(quiet, spice["frequency"])) - decibels(spice["onoise_spectrum"])
    assert np.abs(ours).max() < 0.02
    (tmp_path / "out.raw").unlink()
    spice = vectors(tmp_path, lines, "op", ["v(out)"])
    offset = spice["v(out)"][0] - circuit.amplifier.reference
    assert output_offset(circuit.amplifier, whole) == pytest.approx(offset, rel=2e-3, abs=1e-6)


STEP = 2e-6  # s, as long as a scene's at a low-pass of 5 kHz


def limited(circuit: Circuit, charge: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The output `(n,)` V of a charge every STEP, from rest, without rails and with them."""
    whole = circuit_network(circuit)
    linear = output(whole, charge, 1 / STEP)
    return linear, linear + at_rails(whole, linear, STEP, *output_swing(circuit.amplifier, whole))[0]


@needs_ngspice
@pytest.mark.evidence(subject="circuit: bought amplifier {name}")
@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("single-supply", []),
        ("single-supply", ["amplifier.feedback_capacitance=3e-13"]),
        ("single-supply", ["amplifier.reference=1.0", "amplifier.input_bias_current=5e-9"]),
        ("charge-amplifier", ["amplifier.rail_low=-0.05", "amplifier.rail_high=0.2"]),
        ("voltage-follower", ["amplifier.rail_low=-0.2", "amplifier.rail_high=0.6"]),
    ],
)
def test_an_output_at_a_rail_is_spices(tmp_path: Path, name: str, settings: list[str]) -> None:
    """A load put on within 0.4 ms, held, taken off, put on slowly: both rails and what comes after them."""
    circuit = circuit_of(name, *settings)
    corners = [(0.0, 0.0), (1e-4, 0.0), (5e-4, 0.7), (1.5e-3, 0.7), (1.8e-3, 0.1), (4e-3, 0.5), (8e-3, 0.5)]
    time = np.arange(0.0, 8e-3, STEP)  # s
    linear, ours = limited(circuit, constants(circuit).d33 * np.interp(time, *np.array(corners).T))
    whole = circuit_network(circuit)
    low, high = output_swing(circuit.amplifier, whole)
    points = " ".join(f"{t!r} {load!r}" for t, load in corners)
    spice = vectors(tmp_path, bought(circuit, f"Vload load 0 PWL({points})"), "tran 1u 8m 0 1u", ["v(vout)"])
    there = np.interp(time, spice["time"], spice["v(vout)"])
    there -= there[0]
    # 1.5 % of the swing: the input's charge to first order. Where it leaves a rail, up to two steps sooner or
    # later: behind 0.3 pF it falls by a volt within ten
    slack = 0.015 * (high - low)
    near = np.array([np.roll(there, shift) for shift in range(-2, 3)])[:, 2:-2]
    assert (ours[2:-2] > near.min(axis=0) - slack).all()
    assert (ours[2:-2] < near.max(axis=0) + slack).all()
    assert np.abs(linear - there).max() > 9 * slack  # without the rails it is another signal
    for limit in (low, high):
        at_limit = [np.isclose(values, limit, atol=1e-3).mean() for values in (ours, there)]
        assert at_limit[0] == pytest.approx(at_limit[1], abs=0.005)  # of 8 ms


SUPPLY = load_circuit("single-supply")


def limited_by(circuit: Circuit, current: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`limited` of a current A every STEP, straight charge between."""
    return limited(circuit, np.cumsum(current) * STEP)


def test_a_pulse_beyond_the_rail_leaves_when_its_charge_is_gone() -> None:
    """A current i for T behind Rf alone, C at the input, tau = Rf C: the input moves by (i Rf - V)
    (1 - exp(-T / tau)) and comes back within tau ln(1 + move / V)."""
    circuit = SUPPLY.with_(amplifier={"feedback_capacitance": 0.0, "gain_bandwidth": 0.0})
    c = constants(circuit)
    high = output_swing(circuit.amplifier, circuit_network(circuit))[1]
    current = np.zeros(5000)
    current[:500] = 5 * high / c.feedback_resistance
    linear, ours = limited_by(circuit, current)
    tau = c.feedback_resistance * (c.capacitance + c.motional_capacitance + c.input_capacitance)
    move = 4 * high * -math.expm1(-500 * STEP / tau)
    wanted = 500 * STEP + tau * math.log1p(move / high)
    at_rail = STEP * np.isclose(ours, high).sum()
    assert at_rail == pytest.approx(wanted, abs=3 * STEP)
    assert linear.max() == pytest.approx(5 * high, rel=5e-3)  # the film's resonance rings


def test_an_output_within_its_rails_is_not_touched_and_a_followers_is_cut_off() -> None:
    current = 1.5e-8 * np.sin(2 * np.pi * 300.0 * np.arange(5000) * STEP)
    linear, ours = limited_by(SUPPLY, current)
    np.testing.assert_array_equal(linear, ours)
    follower = load_circuit("voltage-follower", ["amplifier.rail_high=0.3", "amplifier.rail_low=-0.1"])
    linear, ours = limited_by(follower, current)
    assert linear.max() > 0.4
    np.testing.assert_allclose(ours, np.clip(linear, -0.1, 0.3), atol=1e-4)  # a gain of 1e5
    one_sided = load_circuit("voltage-follower", ["amplifier.rail_high=0.3"])
    linear, ours = limited_by(one_sided, current)
    np.testing.assert_allclose(ours, np.minimum(linear, 0.3), atol=1e-4)


def test_the_rest_and_the_swing_by_hand() -> None:
    """A current into the input comes through the feedback's resistor, the output rises; a follower's comes
    through the bias resistor, it falls. The paper's sign turns an inverting amplifier's rails round."""
    for name, rests, swing in (
        ("single-supply", 5e-9 * 1e8, (1.65 + 0.5 - 3.28, 1.65 + 0.5 - 0.02)),
        ("voltage-follower", -5e-10 * 1e9, (0.02 - 1.65 + 0.5, 3.28 - 1.65 + 0.5)),
    ):
        bias = 5e-9 if name == "single-supply" else 5e-10
        supply = {"reference": 1.65, "rail_low": 0.02, "rail_high": 3.28, "input_bias_current": bias}
        circuit = load_circuit(name).with_(amplifier=supply)
        whole = circuit_network(circuit)
        # 2e-3: the amplifier's own 1e12 ohm, gain and the follower's feedback beside 1e9
        assert output_offset(circuit.amplifier, whole) == pytest.approx(rests, rel=2e-3)
        assert output_swing(circuit.amplifier, whole) == pytest.approx(swing, abs=2e-3)
    plain = load_circuit("transimpedance")
    assert output_swing(plain.amplifier, circuit_network(plain)) == (-math.inf, math.inf)
    assert output_offset(plain.amplifier, circuit_network(plain)) == 0.0


def test_below_its_corner_the_voltage_noise_rises_as_one_over_f() -> None:
    """10 nV at 10 kHz and 16 at 1 kHz are the maker's."""
    noise = SUPPLY.noise
    at = {f: noise.voltage_density * math.sqrt(1 + noise.voltage_corner / f) for f in (1e3, 1e4)}
    assert at == pytest.approx({1e3: 16e-9, 1e4: 10e-9}, rel=0.01)
    frequency = np.array([1.0, 2100.0, 1e4])
    white = SUPPLY.with_(noise={"voltage_corner": 0.0})
    ours, plain = (noise_density(circuit_network(c), frequency)["Eamp voltage"] for c in (SUPPLY, white))
    np.testing.assert_allclose(ours / plain, 1 + 2100.0 / frequency, rtol=1e-12)


BIAS = "amplifier.input_bias_current: must let the output rest between its rails, but it rests"


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["rail_low=5.0"], "amplifier.rail_high: must be above 5 V (rail_low), got 3.28"),
        (["reference=0.0"], "amplifier.reference: must be above 0.02 V (rail_low) and below 3.28 V"),
        (["rail_low=none", "reference=4.0"], "amplifier.reference: must be below 3.28 V (rail_high), got 4"),
        (["input_bias_current=2e-8"], f"{BIAS} at 3.65 V, got 2e-08; take a smaller feedback_resistance"),
        (["input_bias_current=-2e-8"], f"{BIAS} at -0.35 V"),
    ],
)  # fmt: skip
def test_bad_supplies_are_refused(settings: list[str], words: str) -> None:
    with refused_by(words):
        load_circuit("single-supply", [f"amplifier.{setting}" for setting in settings])
