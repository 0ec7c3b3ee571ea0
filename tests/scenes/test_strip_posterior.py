"""All channels together: against the whole normal distribution, and strips that only a difference tells."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from skincad.scenes.strip_assignment import PRIOR, SCATTER, SWAP_PRIOR, SignalModel
from skincad.scenes.strip_posterior import OWN_FLOOR, posterior

RANK, NOISE, GAIN = 6, 0.01, 0.8
HUM = np.zeros((RANK, 1))


def model(mean: np.ndarray, shared: np.ndarray) -> SignalModel:
    """Two strips of one ridge, without offset or drift, whose own spread is none."""
    zero = np.zeros((2, RANK, RANK))
    edges = np.linspace(0.0, 1.0, RANK + 1)
    return SignalModel(edges, np.eye(RANK), np.zeros((RANK, 2)), mean, zero, shared)


def nearly_alike() -> tuple[np.ndarray, np.ndarray]:
    draw = np.random.default_rng(3)
    common = draw.normal(0.0, 1.0, RANK)
    mean = np.stack([common, common + draw.normal(0.0, 0.05, RANK)])
    moved = draw.normal(0.0, 0.2, RANK)
    return mean, np.stack([np.stack([moved, 1.02 * moved])])


def log_density(parts: np.ndarray, order: list[int], mean: np.ndarray, shared: np.ndarray) -> float:
    """Of both channels at once, by their whole covariance `(2 rank, 2 rank)`."""
    way = GAIN * shared[:, order].reshape(len(shared), -1)
    covariance = way.T @ way
    for c, strip in enumerate(order):
        at = slice(c * RANK, (c + 1) * RANK)
        own = (NOISE**2 + OWN_FLOOR**2 / RANK * (parts[c] @ parts[c])) * np.eye(RANK)
        covariance[at, at] += own + (GAIN * SCATTER) ** 2 * np.outer(mean[strip], mean[strip])
    return float(multivariate_normal.logpdf(parts.ravel(), GAIN * mean[order].ravel(), covariance))


def test_the_odds_of_a_swap_are_those_of_the_whole_normal_distribution() -> None:
    mean, shared = nearly_alike()
    parts = GAIN * (mean + 0.4 * (mean[::-1] - mean))  # nearer to works
    found = posterior(model(mean, shared), parts, np.full(2, NOISE), HUM, GAIN, np.array([0, 1]))
    chances = dict(zip(found.channels[0].states, found.channels[0].probabilities, strict=True))
    odds = chances["works", None, 1] / chances["swapped", 1, 1]
    expected = log_density(parts, [0, 1], mean, shared) - log_density(parts, [1, 0], mean, shared)
    # one pair of strips: all swaps are of it, but half of their prior goes to pairs of other ridges
    expected += 2 * np.log(PRIOR["works"]) - np.log(SWAP_PRIOR / 2)
    # 1e-3: assignments with a strip that is weak or reversed count in both chances, by less
    assert np.log(odds) == pytest.approx(expected, abs=1e-3)


def test_strips_that_move_together_are_told_by_their_difference() -> None:
    mean, shared = nearly_alike()
    moved = GAIN * (
        mean + shared[0]
    )  # one standard deviation of the common factor off, four of the difference
    straight = posterior(model(mean, shared), moved, np.full(2, NOISE), HUM, GAIN, np.array([0, 1]))
    crossed = posterior(model(mean, shared), moved[::-1], np.full(2, NOISE), HUM, GAIN, np.array([0, 1]))
    assert [channel.states[0] for channel in straight.channels] == [("works", None, 1)] * 2
    assert [channel.states[0] for channel in crossed.channels] == [("swapped", 1, 1), ("swapped", 0, 1)]
    assert straight.channels[0].probabilities[0] > 0.99
    assert straight.alike == ()


def test_strips_that_nothing_tells_apart_are_alike() -> None:
    mean, shared = nearly_alike()
    same = np.stack([mean[0], mean[0]])
    found = posterior(model(same, shared), GAIN * same, np.full(2, NOISE), HUM, GAIN, np.array([0, 1]))
    assert found.alike == ((0, 1),)
    assert found.channels[0].states[0] == ("works", None, 1)


def test_a_start_without_a_strip_is_left_where_the_strip_shows() -> None:
    mean, shared = nearly_alike()
    found = posterior(model(mean, shared), GAIN * mean, np.full(2, NOISE), HUM, GAIN, np.array([2, 5]))
    assert [channel.states[0][0] for channel in found.channels] == ["works", "works"]
