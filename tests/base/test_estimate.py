"""Numbers as data: an estimate never says more than its error allows, levels are refined to a
tolerance."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np
import pytest

from skincad.base import (
    Estimate,
    Refinement,
    UnclearError,
    adaptivity,
    by_price,
    refine,
)

FORCE = Estimate(2.5, 0.25, "N")  # all of it is exact in binary
NONE = Estimate(None, None, "N")


def test_its_float_ends_and_text() -> None:
    assert float(FORCE) == FORCE.value
    assert math.sqrt(Estimate(4.0, None, "N")) == 2.0
    with pytest.raises(ValueError, match="has no value"):
        float(NONE)
    assert (FORCE.lower, FORCE.upper) == (2.25, 2.75)
    for unknown in (NONE, Estimate(2.5, None, "N")):
        assert (unknown.lower, unknown.upper) == (None, None)
    assert str(Estimate(2.6412, 0.217, "N")) == "2.64 ± 0.22 N"
    assert str(Estimate(2.6412, None, "N")) == "2.641 N"
    assert str(NONE) == "none"


# a number, and what <, <=, >, >= say: True, False, or None for unclear
COMPARED = [
    (2.0, (False, False, True, True)),
    (2.25, (False, None, None, True)),
    (2.5, (None, None, None, None)),
    (2.75, (None, True, False, None)),
    (3, (True, True, False, False)),
    (math.inf, (True, True, False, False)),
    (math.nan, (None, None, None, None)),
]
OPERATORS = (operator.lt, operator.le, operator.gt, operator.ge)
REFLECTED = (operator.gt, operator.ge, operator.lt, operator.le)


def said(compare: object, *sides: object) -> bool | None:
    try:
        return compare(*sides)
    except UnclearError:
        return None


@pytest.mark.parametrize(("number", "answers"), COMPARED)
def test_a_comparison_holds_all_over_the_interval_or_is_unclear(number: float, answers: tuple) -> None:
    assert tuple(said(compare, FORCE, number) for compare in OPERATORS) == answers
    assert tuple(said(compare, number, FORCE) for compare in REFLECTED) == answers
    assert tuple(said(compare, FORCE, np.float64(number)) for compare in OPERATORS) == answers
    assert tuple(said(compare, np.float64(number), FORCE) for compare in REFLECTED) == answers


def test_a_comparison_is_exact_or_unclear() -> None:
    exact = Estimate(2.5, 0.0, "N")
    assert tuple(said(compare, exact, 2.5) for compare in OPERATORS) == (False, True, False, True)
    for unknown in (NONE, Estimate(2.5, None, "N")):
        assert {said(compare, unknown, 4.0) for compare in OPERATORS} == {None}
    with pytest.raises(UnclearError, match=r"whether 2\.50 ± 0\.25 N is above or below 2\.6 N is unclear"):
        operator.lt(FORCE, 2.6)
    for other in (FORCE, "4", None):
        with pytest.raises(TypeError, match=f"not with {type(other).__name__}"):
            operator.lt(FORCE, other)
    same, other = Estimate(2.5, 0.25, "N"), Estimate(2.5, 0.25, "mm")
    assert (same == FORCE, other == FORCE) == (True, False)


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        (479.0, 411.0, "70 to 890 EUR"),
        (40.0, 90.0, "0 to 130 EUR"),
        (12.3, 1.0, "12.3 ± 1.0 EUR"),
        (0.5, 0.4, "0.10 to 0.90 EUR"),
        (0.0, 0.0, "0 EUR"),
    ],
)
def test_a_rough_number_is_read_as_a_range(value: float, error: float, words: str) -> None:
    assert Estimate(value, error, "EUR").span() == words


@pytest.mark.parametrize(
    ("value", "error", "ends"),
    [
        (22.0, 13.0, (9.0, 20.0)),
        (5.0, 8.0, (0.0, 13.0)),
        (19.0, 0.5, (18.5, 19.5)),
        (25.0, 1.0, (19.0, 20.0)),
    ],
)
def test_an_interval_is_cut_to_a_range(value: float, error: float, ends: tuple[float, float]) -> None:
    cut = Estimate(value, error, "mm").within(0.0, 20.0)
    assert (cut.lower, cut.upper) == pytest.approx(ends)
    unknown = Estimate(22.0, None, "mm")
    assert unknown.within(0.0, 20.0) is unknown


@dataclass(frozen=True)
class SolverLevel:
    error: float
    price: float


LEVELS = (SolverLevel(0.3, 1.0), SolverLevel(0.1, 2.0), SolverLevel(0.03, 4.0))


class Stairs:
    """Rungs that take their price in s; those of `refused` raise that instead."""

    def __init__(
        self, patch: pytest.MonkeyPatch, refused: dict[SolverLevel, BaseException] | None = None
    ) -> None:
        self.now, self.refused, self.tried = 50.0, refused or {}, list[SolverLevel]()
        patch.setattr(adaptivity, "perf_counter", lambda: self.now)

    def solve(
        self, level: SolverLevel, before: Refinement[SolverLevel, SolverLevel, str] | None
    ) -> SolverLevel:
        self.tried.append(level)
        assert before is None or before.levels == tuple(r for r in self.tried[:-1] if r not in self.refused)
        if level in self.refused:
            raise self.refused[level]
        self.now += level.price
        return level

    def climbed(
        self, tol: float = 0.0, budget: float | None = None, **more: Any
    ) -> Refinement[SolverLevel, SolverLevel, str]:
        self.tried.clear()
        options = {"began": self.now, "ends": (ValueError,), "price": by_price, **more}
        return refine(
            self.solve, LEVELS, lambda level, _, old: (f"{old}", level.error), tol, budget, **options
        )


def test_levels_are_climbed_to_the_tolerance_and_not_beyond_the_last(monkeypatch: pytest.MonkeyPatch) -> None:
    stairs = Stairs(monkeypatch)
    for tol, count in ((0.3, 1), (0.29, 2), (0.1, 2), (0.0, 3)):
        ascent = stairs.climbed(tol)
        assert (ascent.levels, ascent.answer) == (LEVELS[:count], LEVELS[count - 1])
        assert (ascent.error, ascent.ended) == (LEVELS[count - 1].error, None)
        assert ascent.spent == sum(r.price for r in LEVELS[:count])
        assert ascent.assessment == (f"{LEVELS[count - 2]}" if count > 1 else "None")
    assert stairs.climbed(0.1, first=2).levels == LEVELS[2:]


def test_a_budget_is_not_overrun_by_the_next_level(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stairs = Stairs(monkeypatch)
    for budget, count in ((0.5, 1), (2.9, 1), (3.0, 2), (6.9, 2), (7.0, 3)):
        assert len(stairs.climbed(0.0, budget).levels) == count
    # what was spent before the climb counts too
    assert len(stairs.climbed(0.0, 3.0, began=stairs.now - 0.1).levels) == 1
    assert len(stairs.climbed(0.0, price=lambda _, level: inf if level is LEVELS[2] else 0.0).levels) == 2


def test_a_level_that_refuses_leaves_another(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    too_large = ValueError("too large")
    stairs = Stairs(monkeypatch, {LEVELS[2]: too_large})
    ascent = stairs.climbed()
    assert (ascent.levels, ascent.error, ascent.ended) == (LEVELS[:2], 0.1, too_large)
    last = stairs.climbed(first=2)
    assert (last.levels, last.ended) == (LEVELS[1:2], too_large)
    assert stairs.tried == [LEVELS[2], LEVELS[1], LEVELS[2]]
    with pytest.raises(ValueError, match="too large"):
        Stairs(monkeypatch, dict.fromkeys(LEVELS, too_large)).climbed(first=1)
    with pytest.raises(KeyboardInterrupt):  # what is not named ends all
        Stairs(monkeypatch, {LEVELS[1]: KeyboardInterrupt()}).climbed()
    ended = Stairs(monkeypatch, {LEVELS[1]: KeyboardInterrupt()}).climbed(ends=(KeyboardInterrupt,))
    assert (ended.levels, type(ended.ended)) == (LEVELS[:1], KeyboardInterrupt)
    assert replace(ended, ended=None) == Stairs(monkeypatch).climbed(0.3)
