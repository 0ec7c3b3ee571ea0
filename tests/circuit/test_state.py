"""The response in time against the frequency response, SPICE and itself; low-pass and recording."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from skincad.base import RefusedError
from skincad.circuit import (
    Network,
    band_limited,
    circuit_network,
    constants,
    corner,
    delay,
    load_circuit,
    recorded,
    run,
    stepper,
)
from skincad.circuit.network import Element, network
from skincad.circuit.response import response
from skincad.inputs import template_names
from tests.circuit.networks import element_lines, needs_ngspice, output, random_sets, vectors
from tests.refusals import refused_by

PAPER = "yamada-2002"
NAMES = template_names("circuits")


@pytest.fixture(params=NAMES)
def c(request: pytest.FixtureRequest) -> Network:
    return circuit_network(load_circuit(request.param))


def pulse(time: np.ndarray, c: Network) -> np.ndarray:
    """Charge of 1 N that rises smoothly, then falls."""
    return c.charge * np.sin(np.pi * np.clip(time / 2e-3, 0.0, 1.0)) ** 2


def sine_gain(c: Network, frequency: float, per_period: int, bandwidth: float | None = None) -> complex:
    """The response to a sampled sine over the frequency response; the window keeps slow transients out."""
    rate, periods, seen = frequency * per_period, 60, 20 * per_period
    time = np.arange(per_period * periods) / rate
    charge = c.charge * np.sin(2 * np.pi * frequency * time)
    voltage = run(stepper(c, rate, bandwidth), charge)[0][-seen:]
    window = 1 - np.cos(2 * np.pi * np.arange(seen) / seen)
    size = 2j * np.mean(window * voltage * np.exp(-2j * np.pi * frequency * time[-seen:]))
    return complex(size / response(c, np.array([frequency]))[0])


def images(
    c: Network, frequency: float, per_period: int, bandwidth: float = math.inf, count: int = 3000
) -> complex:
    """The same ratio by Poisson's sum: straight lines between samples hold every image of the sine."""
    order = np.arange(-count, count + 1)
    f = frequency * (1 + order * per_period)
    gain = response(c, np.abs(f))
    gain = np.where(f < 0, gain.conj(), gain)
    weight = (np.sin(np.pi / per_period) / (np.pi * f / (frequency * per_period))) ** 2
    passed = (1 + 2j * np.pi * f / corner(bandwidth)) ** -2
    return complex((weight * gain * passed).sum() / gain[count])


@pytest.mark.parametrize("frequency", [200.0, 1200.0, 7000.0])
def test_a_steady_sine_has_the_frequency_response_with_its_images(c: Network, frequency: float) -> None:
    # 2e-6: what the sum leaves out beyond 3000 images
    assert abs(sine_gain(c, frequency, 1000) / images(c, frequency, 1000) - 1) < 2e-6


@pytest.mark.parametrize("frequency", [60.0, 700.0])
def test_a_step_behind_the_low_pass_has_both_frequency_responses(c: Network, frequency: float) -> None:
    """At the few samples a period that a recorder has. 2e-6 is what the window leaves of slow transients."""
    ratio = sine_gain(c, frequency, 7, 800.0) / images(c, frequency, 7, 800.0)
    assert abs(ratio - 1) < 2e-6


@pytest.mark.parametrize("leaks", [False, True])
def test_a_step_behind_the_low_pass_is_the_low_pass_and_then_the_network(c: Network, leaks: bool) -> None:
    """A recorder's 2 kHz against both on a grid 50 and 400 times finer, where a signal that follows the rate
    comes half a sample late: less by 8 times or more, 14 to 300 as measured. The step itself is exact: ten of
    a tenth are one, to rounding by the network's stiffness. A charge that stands leaves an output where a
    film leaks."""
    rate, band = 2000.0, 800.0
    if leaks:
        c = replace(c, elements=(*c.elements, Element("Rleak", ("pv", "film"), 1e8)))
    charge = c.charge * np.cumsum(np.random.default_rng(3).normal(size=60))
    whole = run(stepper(c, rate, band), charge)[0]

    def straight(fine: int) -> np.ndarray:
        at = np.arange(59 * fine + 1) / fine
        return np.interp(at, np.arange(60), charge)

    errors = []
    for fine in (50, 400):
        values = straight(fine)
        behind = band_limited(np.arange(values.size) / (rate * fine), values, band).value
        errors.append(np.abs(output(c, behind, rate * fine)[::fine] - whole).max() / np.abs(whole).max())
    assert errors[0] < 0.01
    assert errors[1] < errors[0] / 8
    ten = run(stepper(c, 10 * rate, band), straight(10))[0][::10]
    assert np.abs(ten - whole).max() < 1e-11 * np.abs(whole).max()


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


@pytest.mark.slow
@needs_ngspice
def test_time_response_and_spices_transient_agree(tmp_path: Path, c: Network) -> None:
    time = np.arange(2501) * 1e-6
    charge = pulse(time, c)
    points = " ".join(f"{t!r} {q / c.charge!r}" for t, q in zip(time.tolist(), charge.tolist(), strict=True))
    lines = [f"Vload load 0 PWL({points})", *element_lines(c), ".options method=trap"]
    spice = vectors(tmp_path, lines, "tran 1e-6 2.5e-3 0 2e-7", ["v(vout)"])
    assert spice["time"][-1] >= time[-1]  # it went to the end
    ours = output(c, charge, 1e6)
    theirs = np.interp(time, spice["time"], spice["v(vout)"])
    assert np.abs(ours - theirs).max() < 1e-4 * np.abs(ours).max()


def test_steps_are_exact_in_pieces_too_and_nothing_comes_at_rest(c: Network) -> None:
    charge = pulse(np.arange(1000) * 4e-6, c) + 1e-12
    s = stepper(c, 2.5e5)
    whole, last = run(s, charge)
    head, state = run(s, charge[:400])
    tail, end = run(s, charge[399:], state)
    joined = np.concatenate([head, tail[1:]])
    np.testing.assert_allclose(joined, whole, rtol=0, atol=1e-14 * np.abs(whole).max())  # sums' order
    np.testing.assert_array_equal(end, last)
    # The step is exact: ten steps of a tenth are one step, to rounding by the network's stiffness
    coarse = pulse(np.arange(41) * 1e-4, c)
    fine = np.interp(np.arange(401), np.arange(0, 401, 10), coarse)
    one, ten = output(c, coarse, 1e4), output(c, fine, 1e5)[::10]
    assert np.abs(one - ten).max() < 1e-8 * np.abs(one).max()
    moving = output(c, pulse(np.arange(1000) * 1e-5, c), 1e5)
    still = output(c, np.full(1000, c.charge), 1e5)
    assert np.abs(still).max() < 1e-9 * np.abs(moving).max()  # rounding of the film's 1 / Cpvd


def test_one_sample_at_a_time_as_at_once(c: Network) -> None:
    """To rounding: the states' parts of the output do not cancel, though PAPER's small R1 + R2 would let the
    capacitors' voltages."""
    s, charge = stepper(c, 1e5), pulse(np.arange(50) * 1e-5, c)
    whole, end = run(s, charge)
    (first,), state = run(s, charge[:1])
    seen = [first]
    for pair in pairwise(charge.tolist()):
        values, state = run(s, np.array(pair), state)
        seen.append(values[1])
    assert np.abs(s.out * end).sum() < 10 * abs(whole[-1])
    np.testing.assert_allclose(seen, whole, rtol=0, atol=1e-14 * np.abs(whole).max())


@pytest.mark.parametrize("rate", [10.0, 650.0, 1e5, 1e8])
def test_stiff_constants_stay_stable_at_any_step(rate: float) -> None:
    """A step of charge dies out: the last tenth of a long record is below the first."""
    for c in random_sets(4):
        s = stepper(network(c), rate)
        assert np.abs(np.diag(s.step)).max() <= 1.0 + 1e-12
        voltage, _ = run(s, np.r_[0.0, np.full(2000, c.d33)])
        assert np.isfinite(voltage).all()
        assert np.abs(voltage[-200:]).max() <= np.abs(voltage).max()


def test_what_no_double_can_hold_and_a_bad_rate_or_charge_are_refused() -> None:
    c = constants(load_circuit("yamada-2002"))
    for capacitance, words in ((1e-200, "too long"), (1e-300, "too far apart")):
        with pytest.raises(RefusedError, match=words):
            stepper(network(replace(c, input_capacitance=capacitance)), 1e5)
    paper = circuit_network(load_circuit(PAPER))
    for rate in (0.0, -1.0, np.nan, np.inf):
        with refused_by("rate: must be above 0 Hz"):
            stepper(paper, rate)
    for charge in ([], [0.0, np.nan], [[0.0]]):
        with refused_by("charge: must be a row"):
            output(paper, np.array(charge), 1e5)


WIDTH = 300.0
AT = np.linspace(0.0, 0.02, 401)


def test_a_ramp_by_the_closed_form_and_its_lag() -> None:
    """y = t - 2/w + exp(-w t) (t + 2/w): a ramp is straight between samples, so only rounding is left."""
    w, signal = corner(WIDTH), band_limited(AT, 5.0 + AT, WIDTH)
    fade = np.exp(-w * AT)
    assert signal.value == pytest.approx(5.0 + AT - 2 / w + fade * (AT + 2 / w), abs=1e-13)
    assert signal.rate == pytest.approx(1 - fade * (1 + w * AT), abs=1e-11)
    assert signal.jerk == pytest.approx(w * w * AT * fade, abs=1e-11 * w)
    # after 40 delays the start has faded to e^-80
    lag = AT[-1] - band_limited(AT, AT, 5e3).value[-1]
    assert lag == pytest.approx(delay(5e3), rel=1e-9)
    # one sample alone stands still
    signal = band_limited(np.zeros(1), np.array([5.0]), WIDTH)
    assert [values.tolist() for values in (signal.value, signal.rate, signal.jerk)] == [[5.0], [0.0], [0.0]]


def test_a_sine_at_the_bandwidth_is_down_by_3_db() -> None:
    time = np.linspace(0.0, 0.1, 40_001)
    out = band_limited(time, np.sin(2 * math.pi * WIDTH * time), WIDTH).value[-4000:]
    # 1e-4: straight lines between 1300 samples a period, and the start's rest
    assert out.max() == pytest.approx(math.sqrt(0.5), rel=1e-4)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_signals_hang_on_the_band_not_on_the_step(factor: float) -> None:
    """A kink's jerk: raw it is 1 / dt; behind the low-pass it is the same whatever dt."""
    fine = np.linspace(0.0, 0.02, int(400 * factor) + 1)
    one, other = (band_limited(t, np.maximum(t - 0.01, 0.0), WIDTH).jerk.max() for t in (AT, fine))
    # the peak falls between samples: (w dt)^2 / 8
    assert one == pytest.approx(other, rel=(corner(WIDTH) * 1e-4) ** 2 / 4)


@pytest.mark.parametrize("seed", range(20))
def test_the_low_pass_is_the_same_by_unequal_steps(seed: int) -> None:
    """Lines between 30 points at multiples of a 4000th: by all 4000 equal steps, and from point to point."""
    draw = np.random.default_rng((36, seed))
    time = np.linspace(0.0, 0.02, 4001)
    at = np.array([0, *np.sort(draw.choice(np.arange(1, 4000), 30, replace=False)), 4000])
    values, band = draw.normal(size=at.size), float(10 ** draw.uniform(1, 4))
    one = band_limited(time, np.interp(time, time[at], values), band)
    other = band_limited(time[at], values, band)
    for name in ("value", "rate", "jerk"):
        wanted = getattr(one, name)
        # both are exact for straight lines: only rounding is left
        np.testing.assert_allclose(getattr(other, name), wanted[at], atol=1e-11 * np.abs(wanted).max())


RATE, WANTED = 1e5, 650.0
TIME = np.arange(100_000) / RATE


def middle(values: np.ndarray) -> np.ndarray:
    """Without the ends, where the filter sees the held last value."""
    return values[65:-65]


def test_a_sine_in_the_passband_is_sampled_as_it_is_and_none_above_folds_back() -> None:
    recording = recorded(np.sin(2 * np.pi * 200.0 * TIME), RATE, WANTED)
    exact = np.sin(2 * np.pi * 200.0 * np.arange(recording.values.size) / WANTED)
    # the ripple of an 80 dB window, and its phases
    assert np.abs(middle(recording.values - exact)).max() < 1e-3
    assert recording.warnings == ()
    assert recording.passband == pytest.approx(260.0)
    recording = recorded(np.sin(2 * np.pi * 500.0 * TIME), RATE, WANTED)
    assert np.abs(middle(recording.values)).max() < 2e-4  # 80 dB, over both phases of the interpolation
    assert recording.lost > 0.99
    assert "100% of the signal's power lies above 260 Hz" in recording.warnings[0]


def test_the_filter_keeps_a_constant_without_delay() -> None:
    signal = np.exp(-(((TIME - 0.4) / 0.01) ** 2))
    recording = recorded(signal, RATE, WANTED)
    exact = np.exp(-(((np.arange(recording.values.size) / WANTED - 0.4) / 0.01) ** 2))
    assert np.abs(recording.values - exact).max() < 2e-3
    recording = recorded(np.full(50_000, 3.0), RATE, WANTED)
    np.testing.assert_allclose(recording.values, 3.0, rtol=1e-3)  # ripple between the filter's phases
    np.testing.assert_array_equal(recorded(np.sin(TIME), RATE, RATE).values, np.sin(TIME))


def test_a_rate_that_cannot_be_is_told() -> None:
    most, ratio = "must be at most 100000 Hz", "must be a ratio of whole numbers"
    zero = "must be above 0 Hz"
    for wanted, words in ((2e5, most), (0.0, zero), (np.nan, zero), (650.0123456789, ratio)):
        with refused_by(f"sampling.rate: {words}"):
            recorded(TIME, RATE, wanted)
