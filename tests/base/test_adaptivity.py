"""The climb over made-up levels: where it begins, where it ends, and what it does with a level that
refuses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import Any

import pytest

from skincad.base import Refinement, adaptivity, by_price, refine


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


def test_a_budget_is_not_overrun_by_what_the_next_level_is_expected_to_take(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stairs = Stairs(monkeypatch)
    for budget, count in ((0.5, 1), (2.9, 1), (3.0, 2), (6.9, 2), (7.0, 3)):
        assert len(stairs.climbed(0.0, budget).levels) == count
    # what was spent before the climb counts too
    assert len(stairs.climbed(0.0, 3.0, began=stairs.now - 0.1).levels) == 1
    assert len(stairs.climbed(0.0, price=lambda _, level: inf if level is LEVELS[2] else 0.0).levels) == 2


def test_a_level_that_refuses_leaves_the_one_before_or_gives_way_to_a_cheaper(
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
