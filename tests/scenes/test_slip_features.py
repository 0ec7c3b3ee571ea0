"""What a slip shows in: the same to either side, in any unit, in any pieces; bounded, and by hand."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.scenes.slip_features import MOST, SPANS, at_rest, beside, bounded, features, means, of_others

WINDOW, NOISE = 12, 1e-3
DRAWN = np.random.default_rng(1).normal(size=(300, 3, 2)).cumsum(axis=0) / 30


def feature_values(outputs: np.ndarray, noise: float = NOISE) -> np.ndarray:
    return features(WINDOW, noise, outputs, at_rest(outputs.shape[1]))[0]


def test_a_mean_by_hand() -> None:
    values = means(WINDOW, DRAWN, at_rest(3))[0]
    pair = DRAWN[:, :, 0] - DRAWN[:, :, 1]
    for k, span in enumerate(SPANS, 1):
        mean, share = np.zeros(3), 1 / (1 + span * WINDOW)
        for value in pair:
            mean = mean + share * (value - mean)
        np.testing.assert_allclose(values["pair"][k][-1], mean, rtol=1e-9)  # rounding of 300 steps
    np.testing.assert_array_equal(values["pair sum"][0], pair * DRAWN.sum(axis=2))


def test_they_are_the_same_to_either_side() -> None:
    """A mirror exchanges S1 with S2 and the order of ridges."""
    mirrored = DRAWN[:, ::-1, ::-1]
    np.testing.assert_allclose(
        feature_values(mirrored)[:, ::-1], feature_values(DRAWN), atol=1e-9
    )  # sums in another order


@pytest.mark.parametrize("unit", [1e-6, 1e3])
def test_they_have_no_unit(unit: float) -> None:
    np.testing.assert_allclose(feature_values(unit * DRAWN, unit * NOISE), feature_values(DRAWN), atol=1e-9)


def test_they_stay_finite_and_bounded_at_rest_and_when_loud() -> None:
    for size in (0.0, 1.0, 1e9):
        values = feature_values(size * DRAWN)
        assert np.isfinite(values).all()
        assert np.abs(values).max() < 16  # logarithms of up to 1e12 noise rms, by 4


def test_others_are_the_mean_of_the_others() -> None:
    values = np.array([[1.0, 2.0, 6.0]])
    np.testing.assert_array_equal(of_others(values), [[4.0, 3.5, 1.5]])
    np.testing.assert_array_equal(of_others(values[:, :1]), [[0.0]])


def test_beside_is_the_next_told_ridge_where_it_is_pulled_to() -> None:
    values, right = np.array([[1.0, 2.0, 6.0]]), np.ones((1, 3))
    np.testing.assert_array_equal(beside(values, right, True), [[2.0, 6.0, 0.0]])
    np.testing.assert_array_equal(beside(values, right, False), [[0.0, 1.0, 2.0]])
    np.testing.assert_array_equal(beside(values, -right, True), [[0.0, 1.0, 2.0]])


def test_bounded_is_itself_where_small() -> None:
    assert bounded(np.array(0.01)) == pytest.approx(0.01, rel=1e-5)
    assert abs(bounded(np.array(-1e6))) <= MOST


def test_noise_rms_of_the_last_window() -> None:
    """White noise of 3 rms of a pair's: its running power is within what 300 samples of it scatter."""
    noise = np.random.default_rng(2).normal(0, 3 * NOISE / np.sqrt(2), (3000, 2, 2))
    loud = features(WINDOW, NOISE, noise, at_rest(2))[1]
    assert np.median(loud[500:]) == pytest.approx(3, rel=0.1)
