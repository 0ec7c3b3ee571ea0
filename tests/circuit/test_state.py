"""The response in time against the frequency response, SPICE, and itself at other steps."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from skincad.base import InputError, RefusedError
from skincad.circuit import Network, Stepper, circuit_network, constants, load_circuit, run, stepper
from skincad.circuit.network import element_lines, network
from skincad.circuit.response import response
from tests.circuit.paper import exact_response
from tests.circuit.sets import output, random_sets, state_response
from tests.circuit.spice import needs_ngspice, vectors

PAPER = "yamada-2002"
OTHERS = ("yamada-2002-motional", "transimpedance", "charge-amplifier", "voltage-follower")
NAMES = (PAPER, *OTHERS)


@pytest.fixture(params=NAMES)
def c(request: pytest.FixtureRequest) -> Network:
    return circuit_network(load_circuit(request.param))


def pulse(time: np.ndarray, c: Network) -> np.ndarray:
    """Charge of 1 N that rises smoothly, then falls."""
    return c.charge * np.sin(np.pi * np.clip(time / 2e-3, 0.0, 1.0)) ** 2


def test_state_equations_have_the_frequency_response_on_200_random_sets() -> None:
    """Solved at jw: rows differ by up to 1e16, hence 1e-6 and not 1e-12."""
    band = np.geomspace(10.0, 20_000.0, 13)
    for c in random_sets(200):
        states = state_response(network(c), c.d33, band)
        np.testing.assert_allclose(states, exact_response(c, band), rtol=1e-6)


def sine_gain(c: Network, frequency: float, per_period: int) -> complex:
    """The response to a sampled sine over the frequency response; the window keeps slow transients out."""
    rate, periods, seen = frequency * per_period, 60, 20 * per_period
    time = np.arange(per_period * periods) / rate
    voltage = output(c, c.charge * np.sin(2 * np.pi * frequency * time), rate)[-seen:]
    window = 1 - np.cos(2 * np.pi * np.arange(seen) / seen)
    size = 2j * np.mean(window * voltage * np.exp(-2j * np.pi * frequency * time[-seen:]))
    return complex(size / response(c, np.array([frequency]))[0])


def images(c: Network, frequency: float, per_period: int, count: int = 3000) -> complex:
    """The same ratio by Poisson's sum: straight lines between samples hold every image of the sine."""
    order = np.arange(-count, count + 1)
    f = frequency * (1 + order * per_period)
    gain = response(c, np.abs(f))
    gain = np.where(f < 0, gain.conj(), gain)
    weight = (np.sin(np.pi / per_period) / (np.pi * f / (frequency * per_period))) ** 2
    return complex((weight * gain).sum() / gain[count])


@pytest.mark.parametrize("per_period", [1000, 4000])
@pytest.mark.parametrize("frequency", [200.0, 1200.0, 7000.0])
def test_a_steady_sine_has_the_frequency_response_with_its_images(
    c: Network, frequency: float, per_period: int
) -> None:
    # 2e-6: what the sum leaves out beyond 3000 images
    assert abs(sine_gain(c, frequency, per_period) / images(c, frequency, per_period) - 1) < 2e-6


def test_at_fine_steps_it_is_the_frequency_response(c: Network) -> None:
    """The images vanish as the step's square: 16 times less at a quarter of the step, from 1e-3 on."""
    sizes = [abs(abs(sine_gain(c, 1200.0, n)) - 1) for n in (300, 1200)]
    assert sizes[0] < 1e-3
    # a charge amplifier's images are 1e-5 to begin with; 3e-6 is what the window leaves of slow transients
    assert sizes[1] < max(sizes[0] / 10, 3e-6)


def test_it_is_late_by_half_a_sample_where_the_output_follows_the_rate() -> None:
    """A straight line's rate is that of the sample before: the lag halves with the step, and is w dt / 2.

    At 20 Hz, where a sample is a hundred times the amplifier's own time.
    """
    c = circuit_network(load_circuit("transimpedance"))
    coarse, fine = (np.angle(sine_gain(c, 20.0, n)) for n in (500, 1000))
    assert coarse == pytest.approx(-np.pi / 500, rel=0.02)  # the amplifier's own time
    assert fine == pytest.approx(coarse / 2, rel=0.02)


@needs_ngspice
def test_time_response_and_spices_transient_agree(tmp_path: Path, c: Network) -> None:
    time = np.arange(2501) * 1e-6
    charge = pulse(time, c)
    points = " ".join(f"{t!r} {q / c.charge!r}" for t, q in zip(time.tolist(), charge.tolist(), strict=True))
    lines = [
        f"Vload load 0 PWL({points})", *element_lines(c),
        ".options method=trap",
    ]  # fmt: skip
    spice = vectors(tmp_path, lines, "tran 1e-6 2.5e-3 0 2e-7", ["v(vout)"])
    assert spice["time"][-1] >= time[-1]  # it went to the end
    ours = output(c, charge, 1e6)
    theirs = np.interp(time, spice["time"], spice["v(vout)"])
    assert np.abs(ours - theirs).max() < 1e-4 * np.abs(ours).max()


def test_coarse_and_fine_steps_of_the_same_piecewise_linear_charge_agree(c: Network) -> None:
    """The step is exact: ten steps of a tenth are one step, to rounding by the network's stiffness."""
    coarse = pulse(np.arange(41) * 1e-4, c)
    fine = np.interp(np.arange(401), np.arange(0, 401, 10), coarse)
    one, ten = output(c, coarse, 1e4), output(c, fine, 1e5)[::10]
    assert np.abs(one - ten).max() < 1e-8 * np.abs(one).max()


def test_in_pieces_as_at_once(c: Network) -> None:
    charge = pulse(np.arange(1000) * 4e-6, c) + 1e-12
    s = stepper(c, 2.5e5)
    whole, last = run(s, charge)
    head, state = run(s, charge[:400])
    tail, end = run(s, charge[399:], state)
    joined = np.concatenate([head, tail[1:]])
    np.testing.assert_allclose(joined, whole, rtol=0, atol=1e-14 * np.abs(whole).max())  # sums' order
    np.testing.assert_array_equal(end, last)


@pytest.mark.parametrize("c", OTHERS, indirect=True)
def test_one_sample_at_a_time_as_at_once(c: Network) -> None:
    whole, seen = both_ways(stepper(c, 1e5), pulse(np.arange(50) * 1e-5, c))
    np.testing.assert_allclose(seen, whole, rtol=0, atol=1e-14 * np.abs(whole).max())


@pytest.mark.parametrize("c", [PAPER], indirect=True)
def test_one_sample_at_a_time_where_nearly_all_cancels(c: Network) -> None:
    """Behind a small R1 + R2 the states' parts of the output are 470 times what they add up to."""
    s, charge = stepper(c, 1e5), pulse(np.arange(50) * 1e-5, c)
    whole, seen = both_ways(s, charge)
    parts = np.abs(s.out * run(s, charge)[1]).sum()
    assert 400 < parts / abs(whole[-1]) < 500
    np.testing.assert_allclose(seen, whole, rtol=0, atol=1e-15 * parts)  # as many digits of these


def both_ways(s: Stepper, charge: np.ndarray) -> tuple[np.ndarray, list[float]]:
    """The output to a charge at once, and sample by sample."""
    whole, _ = run(s, charge)
    (first,), state = run(s, charge[:1])
    seen = [first]
    for pair in pairwise(charge.tolist()):
        values, state = run(s, np.array(pair), state)
        seen.append(values[1])
    return whole, seen


def test_at_rest_under_a_constant_charge_nothing_comes_out(c: Network) -> None:
    moving = output(c, pulse(np.arange(1000) * 1e-5, c), 1e5)
    still = output(c, np.full(1000, c.charge), 1e5)
    assert np.abs(still).max() < 1e-9 * np.abs(moving).max()  # rounding of the film's 1 / Cpvd


@pytest.mark.parametrize("rate", [10.0, 650.0, 1e5, 1e8])
def test_stiff_constants_stay_stable_at_any_step(rate: float) -> None:
    """A step of charge dies out: the last tenth of a long record is below the first."""
    for c in random_sets(10):
        s = stepper(network(c), rate)
        assert np.abs(np.diag(s.step)).max() <= 1.0 + 1e-12
        voltage, _ = run(s, np.r_[0.0, np.full(2000, c.d33)])
        assert np.isfinite(voltage).all()
        assert np.abs(voltage[-200:]).max() <= np.abs(voltage).max()


def test_what_no_double_can_hold_is_refused() -> None:
    c = replace(constants(load_circuit("yamada-2002")), input_capacitance=1e-300)
    with pytest.raises(RefusedError, match="too long"):
        stepper(network(c), 1e5)


@pytest.mark.parametrize("rate", [0.0, -1.0, np.nan, np.inf])
def test_a_bad_rate_is_told(c: Network, rate: float) -> None:
    with pytest.raises(InputError, match="rate: must be above 0 Hz"):
        stepper(c, rate)


@pytest.mark.parametrize("charge", [[], [0.0, np.nan], [[0.0]]])
def test_a_bad_charge_is_told(c: Network, charge: list[float]) -> None:
    with pytest.raises(InputError, match="charge: must be a row"):
        output(c, np.array(charge), 1e5)
