"""Rate and jerk apart from one output: exact where they are constant, and near the truth elsewhere."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from skincad.base.errors import InputError
from skincad.circuit.low_pass import Limited, band_limited
from skincad.circuit.model import constants, load_circuit, noise_sources
from skincad.circuit.network import Constants
from skincad.circuit.noise import noise_rms, noise_samples
from skincad.circuit.separate import crossover, separated, separator
from skincad.circuit.state import output

NAMES = ("yamada-2002", "transimpedance", "charge-amplifier")
RATE, FINE, WIDTH = 1e5, 20, 3000.0


@pytest.fixture(params=NAMES)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def felt(c: Constants, charge: np.ndarray) -> np.ndarray:
    """The output at RATE of a charge at FINE times that."""
    return output(c, charge, FINE * RATE)[::FINE]


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def slip(size: float = 1e-12) -> tuple[Limited, np.ndarray]:
    """A charge that rises ever faster and falls back, as a ridge that slips; 1 pC in 4 ms."""
    time = np.arange(int(6e-3 * RATE * FINE)) / (RATE * FINE)
    straight = np.interp(time, [0, 1e-3, 2e-3, 3e-3, 3.6e-3, 6e-3], [0, 0, 0.2, 1.0, 0.7, 0.7])
    found = band_limited(time, size * straight, WIDTH)
    return Limited(*(part[::FINE] for part in (found.value, found.rate, found.jerk))), found.value


def test_a_constant_jerk_is_found_with_its_rate(name: str) -> None:
    c = constants(load_circuit(name))
    time = np.arange(int(0.02 * RATE * FINE)) / (RATE * FINE)
    s = separator(c, RATE, 1e-6, 1e-6, WIDTH)
    rate, jerk, _ = separated(s, felt(c, 0.5e-6 * time**2))
    # a straight piece is half a fine sample late: 0.25 us of 20 ms; the rest is what the start leaves
    assert jerk[-1] == pytest.approx(1e-6, rel=1e-3)
    assert rate[-1] == pytest.approx(1e-6 * 0.02, rel=1e-3)


def test_near_the_truth_where_the_crossover_is_not(name: str) -> None:
    """Without noise: the rate within 2 % of its rms, the jerk, which jumps within a sample, within 40 %."""
    c = constants(load_circuit(name))
    true, charge = slip()
    seen = felt(c, charge)
    s = separator(c, RATE, 1e-4 * rms(seen), rms(true.jerk), WIDTH)
    rate, jerk, _ = separated(s, seen)
    assert rms(rate - true.rate) < 0.02 * rms(true.rate)
    assert rms(jerk - true.jerk) < 0.4 * rms(true.jerk)
    for part, truth, found in zip(
        crossover(seen, RATE, 1200.0), (true.rate, true.jerk), (rate, jerk), strict=True
    ):
        scaled = part * (part @ truth) / (part @ part)  # the best that any scale can do
        assert rms(scaled - truth) > 2 * rms(found - truth)


def test_with_its_own_noise(name: str) -> None:
    """200 pC, so that even the paper's amplifier has a signal: 5 % of the rate's rms."""
    circuit = load_circuit(name)
    c, sources = constants(circuit), noise_sources(circuit)
    true, charge = slip(2e-10)
    size = noise_rms(c, sources, 10.0, RATE / 2)
    seen = felt(c, charge) + noise_samples(c, sources, RATE, true.value.size, seed=1)
    rate, _, _ = separated(separator(c, RATE, size, rms(true.jerk), WIDTH), seen)
    assert rms(rate - true.rate) < 0.05 * rms(true.rate)


def test_more_noise_makes_it_slower_and_smoother(name: str) -> None:
    c = constants(load_circuit(name))
    true, charge = slip()
    seen = felt(c, charge)
    found = [
        separated(separator(c, RATE, noise * rms(seen), rms(true.jerk), WIDTH), seen)[1]
        for noise in (1e-4, 1.0)
    ]
    assert rms(np.diff(found[1])) < 0.5 * rms(np.diff(found[0]))


def test_one_sample_at_a_time_as_at_once_and_nothing_of_what_comes_later(name: str) -> None:
    c = constants(load_circuit(name))
    seen = felt(c, slip()[1])
    s = separator(c, RATE, 1e-3 * rms(seen), 1e-6, WIDTH)
    rate, jerk, last = separated(s, seen)
    state, parts = None, []
    for a, b in pairwise([*range(0, 50), 300, seen.size]):
        *part, state = separated(s, seen[a:b], state)
        parts.append(part)
    for whole, pieces in zip((rate, jerk), zip(*parts, strict=True), strict=True):
        np.testing.assert_allclose(np.concatenate(pieces), whole, rtol=0, atol=1e-12 * np.abs(whole).max())
    np.testing.assert_allclose(state, last, rtol=1e-9, atol=1e-12 * np.abs(last).max())  # type: ignore[arg-type]
    other = seen.copy()
    other[301:] = 1.0
    np.testing.assert_array_equal(separated(s, other)[0][:301], rate[:301])


def test_the_crossover_adds_up() -> None:
    seen = np.random.default_rng(1).normal(size=1000)
    below, above = crossover(seen, RATE, 1200.0)
    np.testing.assert_allclose(below + above, seen, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("key", ["rate", "noise", "jerk", "bandwidth"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_a_bad_value_is_told(key: str, value: float) -> None:
    good = {"rate": RATE, "noise": 1e-3, "jerk": 1e-6, "bandwidth": WIDTH}
    with pytest.raises(InputError, match=f"{key}: must be above 0"):
        separator(constants(load_circuit("transimpedance")), **{**good, key: value})
