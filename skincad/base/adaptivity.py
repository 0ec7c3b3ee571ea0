"""Adaptive refinement: one level after the other, until the error is as asked or the time is used up.

The caller supplies the levels, cheapest first, what solves one and what estimates its error. That is all that
checks, films' stress and scenes differ by.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf
from time import perf_counter
from typing import Any, Generic, TypeVar

SolverLevel = TypeVar("SolverLevel")
Answer = TypeVar("Answer")
Assessment = TypeVar("Assessment")


@dataclass(frozen=True)
class Refinement(Generic[SolverLevel, Answer, Assessment]):
    """How far a refinement has come in `spent` s: the `answer` on the last of its `levels`, its `assessment`
    and its relative `error`, inf where unknown; `ended` is why a finer level does not count."""

    answer: Answer
    assessment: Assessment
    error: float
    levels: tuple[SolverLevel, ...]
    spent: float
    ended: BaseException | None = None


def by_price(before: Refinement[Any, Any, Any], following: Any) -> float:
    """Return the seconds that a level will take, by what those before took: a level's `price` is its time on
    top of them, in any unit that all share."""
    return float(before.spent * following.price / sum(level.price for level in before.levels))


def refine(
    solve: Callable[[SolverLevel, Refinement[SolverLevel, Answer, Assessment] | None], Answer],
    levels: Sequence[SolverLevel],
    estimate: Callable[[SolverLevel, Answer, Answer | None], tuple[Assessment, float]],
    tol: float,
    budget: float | None = None,
    *,
    began: float,
    ends: tuple[type[BaseException], ...],
    price: Callable[[Refinement[SolverLevel, Answer, Assessment], SolverLevel], float] = lambda *_: 0.0,
    first: int = 0,
) -> Refinement[SolverLevel, Answer, Assessment]:
    """Return how far levels were refined from the `first` on: to a relative error of `tol`, or until the next
    one would overrun `budget` s from `began` by its `price`, s; one of an endless price is not solved.

    `solve` is given a level and what was reached before it, `estimate` a level and the answers on it and on
    the one before. A level that raises one of `ends` leaves the one before as the last; without any before,
    it gives way to the next cheaper, and the cheapest one's refusal stands."""
    reached: Refinement[SolverLevel, Answer, Assessment] | None = None
    at = first
    while True:
        try:
            answer = solve(levels[at], reached)
        except ends as refusal:
            if reached is not None:
                return replace(reached, spent=perf_counter() - began, ended=refusal)
            if at == 0:
                raise
            at -= 1
            continue
        before, solved = (reached.answer, reached.levels) if reached is not None else (None, ())
        estimated, error = estimate(levels[at], answer, before)
        reached = Refinement(answer, estimated, error, (*solved, levels[at]), perf_counter() - began)
        at += 1
        if error <= tol or at == len(levels):
            return reached
        whole = reached.spent + price(reached, levels[at])
        if whole == inf or (budget is not None and whole > budget):
            return reached


def unmet(error: str, reached: float, tol: float) -> tuple[str, ...]:
    """Return the warning that a tolerance is not met, none where it is or is 0; `error` says which error."""
    return (f"{error}: the tolerance {tol:.1e} is not met",) if reached > tol > 0 else ()


def overrun(what: str, spent: float, budget: float | None) -> tuple[str, ...]:
    """Return the warning that a budget is not kept, none where it is; `what` took the seconds."""
    if budget is None or spent <= budget:
        return ()
    return (f"{what}took {spent:.2g} s, more than the budget of {budget:g} s",)
