"""The recording at 650 Hz: what passes, what does not fold back, and what is said of the rest."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.circuit import recorded
from tests.refusals import refused_by

RATE, WANTED = 1e5, 650.0
TIME = np.arange(100_000) / RATE


def middle(values: np.ndarray) -> np.ndarray:
    """Without the ends, where the filter sees the held last value."""
    return values[65:-65]


def test_a_sine_in_the_passband_is_sampled_as_it_is() -> None:
    recording = recorded(np.sin(2 * np.pi * 200.0 * TIME), RATE, WANTED)
    exact = np.sin(2 * np.pi * 200.0 * np.arange(recording.values.size) / WANTED)
    # the ripple of an 80 dB window, and its phases
    assert np.abs(middle(recording.values - exact)).max() < 1e-3
    assert recording.warnings == ()
    assert recording.passband == pytest.approx(260.0)


def test_a_sine_above_nyquist_does_not_fold_back() -> None:
    recording = recorded(np.sin(2 * np.pi * 500.0 * TIME), RATE, WANTED)
    assert np.abs(middle(recording.values)).max() < 2e-4  # 80 dB, over both phases of the interpolation
    assert recording.lost > 0.99
    assert "100% of the signal's power lies above 260 Hz" in recording.warnings[0]


def test_a_constant_stays() -> None:
    recording = recorded(np.full(50_000, 3.0), RATE, WANTED)
    np.testing.assert_allclose(recording.values, 3.0, rtol=1e-3)  # ripple between the filter's phases


def test_the_filter_has_no_delay() -> None:
    signal = np.exp(-(((TIME - 0.4) / 0.01) ** 2))
    recording = recorded(signal, RATE, WANTED)
    exact = np.exp(-(((np.arange(recording.values.size) / WANTED - 0.4) / 0.01) ** 2))
    assert np.abs(recording.values - exact).max() < 2e-3


def test_the_same_rate_is_the_same_signal() -> None:
    np.testing.assert_array_equal(recorded(np.sin(TIME), RATE, RATE).values, np.sin(TIME))


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        (2e5, "sampling.rate: must be at most 100000 Hz"),
        (0.0, "sampling.rate: must be above 0 Hz"),
        (np.nan, "sampling.rate: must be above 0 Hz"),
        (650.0123456789, "sampling.rate: must be a ratio of whole numbers"),
    ],
)
def test_a_rate_that_cannot_be_is_told(wanted: float, words: str) -> None:
    with refused_by(words):
        recorded(TIME, RATE, wanted)
