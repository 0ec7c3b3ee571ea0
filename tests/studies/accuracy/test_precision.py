"""Pareto front, slope and law of time on numbers whose answer is known."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from skincad.studies import ErrorMeasure, Ladder, Measurement, slope
from skincad.studies.accuracy.ladder import front, power_law, timed


def test_the_front_holds_what_nothing_beats_in_both() -> None:
    seconds = [4.0, 1.0, 2.0, 3.0, 1.0]
    errors = [0.1, 1.0, 0.5, 0.6, 2.0]
    assert front(seconds, errors) == [1, 2, 0]  # by time; the trials of 3 s, and of 1 s and 2.0, are beaten


def test_of_two_equal_trials_one_is_on_the_front() -> None:
    assert front([1.0, 1.0], [0.5, 0.5]) == [0]
    assert front([1.0, 2.0], [0.5, 0.5]) == [0]


def test_every_trial_is_on_or_behind_the_front() -> None:
    random = np.random.default_rng(1)
    seconds, errors = random.random((2, 50)).tolist()
    best = front(seconds, errors)
    assert all(errors[b] < errors[a] for a, b in pairwise(best))
    for s, e in zip(seconds, errors, strict=True):
        assert any(seconds[i] <= s and errors[i] <= e for i in best)


def test_slope_is_the_exponent() -> None:
    seconds = [0.1, 1.0, 10.0]
    assert slope(seconds, [3 * s**-1.5 for s in seconds]) == pytest.approx(-1.5)  # rounding
    assert slope(seconds, [0.0, 1.0, 1.0]) == pytest.approx(0.0, abs=1e-12)  # 0 has no logarithm
    assert slope([1.0, 1.0], [1.0, 2.0]) is None


def test_a_law_of_time_is_found_again() -> None:
    sizes = [1e3, 5e3, 2e4]
    law = power_law(sizes, [2e-6 * n**1.3 for n in sizes])
    assert law is not None
    assert (law.factor, law.exponent) == pytest.approx((2e-6, 1.3))
    assert law.seconds(1e4) == pytest.approx(2e-6 * 1e4**1.3)
    assert law.scatter == pytest.approx(1.0)
    assert power_law([1e3, 1e3], [1.0, 2.0]) is None


def test_scatter_tells_how_far_times_lie_off_the_law() -> None:
    law = power_law([1.0, 10.0, 100.0, 1000.0], [2.0, 0.5, 2.0, 0.5])
    assert law is not None
    assert 1.5 < law.scatter < 2.0  # ratios of 2 about a law that the fit tilts a little


MINE = ErrorMeasure("own", "error", "1", "own finest", "", compares=False)
ALL = ErrorMeasure("all", "error", "1", "the truth", "")


def test_times_of_different_models_compare_at_one_truth_alone() -> None:
    """A fast model that is exact in its own terms must not push a better model off its front."""
    quick = Measurement("quick", "a", 1, (1.0,), {"own": 0.01, "all": 0.5})
    slow = Measurement("slow", "a", 1, (2.0,), {"own": 0.02, "all": 0.6})
    slower = Measurement("slow", "b", 1, (3.0,), {"own": 0.03, "all": 0.1})
    ladder = Ladder("x", "x", (quick, slow, slower), (MINE, ALL))
    assert ladder.best(MINE) == [quick, slow]
    assert ladder.best(ALL) == [quick, slower]
    assert Ladder("x", "x", (quick, slow), (MINE, ALL), lines=False).best(ALL) == []


def test_times_compare_at_matched_error() -> None:
    """By the cheapest trial that is good enough; not below the reference's own error, not of one model."""
    rough, fine = (
        Measurement("a", s, 1, (t,), {"all": e}) for s, t, e in (("r", 1.0, 0.05), ("f", 3.0, 5e-4))
    )
    other = Measurement("b", "", 1, (2.0,), {"all": 0.009})
    ladder = Ladder("x", "x", (rough, fine, other), (MINE, ALL))
    assert ladder.matched(ALL) == {0.1: [rough, other], 0.01: [other, fine]}
    assert ladder.matched(replace(ALL, floor=0.01)) == {0.1: [rough, other]}
    assert ladder.matched(MINE) == {}
    assert replace(ladder, lines=False).matched(ALL) == {}
    assert ladder.reference()["at_matched_error"]["all"][1] == {
        "error": 0.01,
        "seconds": {"b": 2.0, "a": 3.0},
    }


def test_rows_carry_median_spread_and_the_first_measure() -> None:
    trial = Measurement("quick", "a", 7, (1.0, 5.0, 2.0), {"all": 0.5})
    row = Ladder("x", "x", (trial,), (MINE, ALL)).rows()[0]
    assert (row["seconds"], row["spread_s"], row["repeats"]) == (2.0, 4.0, 3)
    assert row["error"] is None
    assert row["errors"] == {"all": 0.5}


def test_a_law_needs_three_sizes() -> None:
    three = tuple(Measurement("a", "", n, (1e-6 * n**1.2,), {}) for n in (1000, 2000, 4000))
    two = tuple(Measurement("b", "", n, (1.0,), {}) for n in (1000, 2000))
    laws = Ladder("x", "x", three + two, (ALL,)).laws()
    assert set(laws) == {"a"}
    assert laws["a"].exponent == pytest.approx(1.2)


def test_short_work_is_warmed_up_and_repeated() -> None:
    calls: list[int] = []

    def work() -> int:
        calls.append(1)
        return len(calls)

    found, runs = timed(work, 3)
    assert (found, len(runs)) == (4, 3)
