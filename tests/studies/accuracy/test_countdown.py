"""The seconds left: expected ones, scaled by what the stages done took."""

from __future__ import annotations

import pytest

from skincad.studies.accuracy.ladder import PRIOR, Countdown

PRICES = {"a": 10.0, "b": 20.0, "c": 5.0}


class Clock:
    """A clock that is set by hand, and what the countdown told at each time."""

    def __init__(self) -> None:
        self.now = 0.0
        self.told: list[tuple[str, float | None]] = []
        self.countdown = Countdown(PRICES, self.tell, lambda: self.now)

    def tell(self, stage: str, left: float | None = None, /) -> None:
        self.told.append((stage, left))

    def at(self, now: float, stage: str) -> float | None:
        self.now = now
        self.countdown(stage)
        return self.told[-1][1]


def test_at_first_it_is_the_sum_of_what_is_expected() -> None:
    assert Clock().at(0.0, "a") == pytest.approx(35.0)


def test_a_machine_twice_as_slow_takes_twice_as_long() -> None:
    clock = Clock()
    clock.at(0.0, "a")
    slower = (PRIOR + 20.0) / (PRIOR + 10.0)
    assert clock.at(20.0, "b") == pytest.approx(slower * 25.0)
    both = (PRIOR + 60.0) / (PRIOR + 30.0)
    assert clock.at(60.0, "c") == pytest.approx(both * 5.0)


def test_a_stage_that_is_left_out_is_passed_over() -> None:
    clock = Clock()
    clock.at(0.0, "a")
    assert clock.at(10.0, "c") == pytest.approx(5.0)


def test_a_stage_that_is_not_known_says_no_time() -> None:
    clock = Clock()
    clock.at(0.0, "a")
    assert clock.at(10.0, "x") is None
    assert clock.at(1000.0, "b") == pytest.approx(25.0)  # what the unknown one took says nothing
