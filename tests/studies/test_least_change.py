"""The least change that gives wanted values, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.base import Array
from skincad.studies.solving import STARTS, least_change

NORMAL: Array = np.array([1.0, 2.0, 0.5])


def line(place: Array) -> Array:
    return np.array([place @ NORMAL])


def test_one_line_is_met_at_its_nearest_point() -> None:
    start = np.full(3, 0.2)
    answer = least_change(line, start, np.array([2.0]), np.array([1e-3]), 60)
    assert answer.best is not None
    by_hand = start + NORMAL * (2.0 - line(start)) / (NORMAL @ NORMAL)
    assert answer.best == pytest.approx(by_hand, abs=1e-3)  # the tolerance over the slope
    assert len(answer.seen) <= 6


def test_two_curves_are_met_at_once() -> None:
    def function(place: Array) -> Array:
        return np.array([place[0] * place[1], place[1] + place[2] ** 2])

    wanted, start = np.array([0.5, 1.2]), np.full(3, 0.5)
    answer = least_change(function, start, wanted, np.full(2, 1e-3), 60)
    assert answer.best is not None
    assert function(answer.best) == pytest.approx(wanted, abs=1e-3)
    # no point of both curves, looked up finely, is nearer than by what STILL leaves
    y = np.linspace(0.5, 1.0, 5001)
    z = np.sqrt(np.maximum(1.2 - y, 0.0))
    distance = np.sqrt((0.5 / y - 0.5) ** 2 + (y - 0.5) ** 2 + (z - 0.5) ** 2)[(z <= 1) & (0.5 / y <= 1)]
    assert np.linalg.norm(answer.best - start) <= distance.min() + 0.01


def test_a_steep_one_stays_in_the_box() -> None:
    def function(place: Array) -> Array:
        return np.array([np.exp(5 * place[0] - 3 * place[1] + place[2])])

    answer = least_change(function, np.full(3, 0.2), np.array([20.0]), np.array([0.1]), 60)
    assert answer.best is not None
    assert np.all((answer.best >= 0) & (answer.best <= 1))
    assert function(answer.best)[0] == pytest.approx(20.0, abs=0.1)


def test_out_of_reach_gives_the_closest() -> None:
    answer = least_change(line, np.full(3, 0.2), np.array([9.0]), np.array([1e-3]), 60)
    assert answer.best is None
    assert answer.closest == pytest.approx([1.0, 1.0, 1.0], abs=1e-6)


def test_a_start_without_values_is_left_for_one_with() -> None:
    def function(place: Array) -> Array | None:
        return None if place[0] < 0.4 else line(place)

    answer = least_change(function, np.full(3, 0.2), np.array([2.0]), np.array([1e-3]), 60)
    assert answer.best is not None
    assert answer.best[0] >= 0.4


def test_no_values_at_all_end_soon() -> None:
    answer = least_change(lambda _: None, np.full(3, 0.2), np.array([2.0]), np.array([1e-3]), 60)
    assert (answer.best, answer.closest, len(answer.seen)) == (None, None, 1 + STARTS)


def test_no_more_is_evaluated_than_allowed() -> None:
    answer = least_change(line, np.full(3, 0.2), np.array([2.0]), np.array([1e-3]), 3)
    assert len(answer.seen) == 3
