"""Which of many designs is better, and how surely.

Two designs that one model has judged share most of what that model leaves out: an effect that makes one's
force 7 % larger makes a like one's about as much larger. So of the two models' errors only their difference
counts in full, and of each a part that is its own; the errors of meshes are independent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from skincad.base.errors import InputError
from skincad.studies.measures import resolved
from skincad.studies.question import Evaluation

Goal = Literal["min", "max"]
# of a model's error, what two designs do not share: bench/ranks.py found 0.06 at most on seeds 0 to 24, on
# which this is set; it is judged on seeds from 100 on
OWN = 0.1
MODEL = {"all_touch_force_N": "model_error_N"}  # which number tells how much of an error is the model's
_SHARES = {"approach_mm": "approach"}  # under which name `left_out` tells a relative error


@dataclass(frozen=True)
class Rank:
    """A row's place: `row` counts from 1 in the sweep's order, `wins` the rows that it surely beats."""

    row: int
    wins: int


@dataclass(frozen=True)
class Ranking:
    """Rows by a result, the best first; `ties` are groups, in that order, whose first member is not surely
    better than any other of them."""

    key: str
    goal: Goal
    ranks: tuple[Rank, ...]
    ties: tuple[tuple[int, ...], ...]


def require_goal(goal: str) -> None:
    """Raise InputError for a word that is no goal."""
    if goal not in ("min", "max"):
        raise InputError("rank", "must be KEY=min or KEY=max", goal)


def ranking(rows: Sequence[Evaluation], key: str, goal: Goal) -> Ranking:
    """Return the ranking of all rows that have this result; refused rows have no rank.

    Raises InputError for a key that no row has.
    """
    require_goal(goal)
    known = {name: None for row in rows for name in row.results}
    key = resolved(key, known, what="rank") if known else key
    placed = [
        (number, row)
        for number, row in enumerate(rows, 1)
        if not row.refused and key in row.results and row.results[key].value is not None
    ]
    sign = 1.0 if goal == "min" else -1.0
    placed.sort(key=lambda each: sign * float(each[1].results[key]))
    better = [[surely_less(a, b, key, sign) for _, b in placed] for _, a in placed]
    ranks = tuple(Rank(number, sum(better[i])) for i, (number, _) in enumerate(placed))
    ties, i = [], 0
    while i < len(placed):
        group = [placed[i][0]]
        while i + len(group) < len(placed) and not better[i][i + len(group)]:
            group.append(placed[i + len(group)][0])
        ties.append(tuple(group))
        i += len(group)
    return Ranking(key, goal, ranks, tuple(tie for tie in ties if len(tie) > 1))


def surely_less(a: Evaluation, b: Evaluation, key: str, sign: float = 1.0) -> bool:
    """Return whether `a`'s result lies below `b`'s, `sign` -1: above, beyond the error of their difference.

    An error that nobody knows makes nothing sure.
    """
    one, other = a.results[key], b.results[key]
    if one.value is None or other.value is None:
        return False
    error = difference_error(a, b, key)
    return error is not None and sign * (other.value - one.value) > error


def difference_error(a: Evaluation, b: Evaluation, key: str) -> float | None:
    """Return the error of the difference of two results; None where one's is not known."""
    one, other = a.results[key], b.results[key]
    if one.error is None or other.error is None:
        return None
    if a.tier != b.tier or not a.tier:
        return math.hypot(one.error, other.error)
    shared = model_error(a, key), model_error(b, key)
    own_errors = [max(e - m, 0.0) for e, m in zip((one.error, other.error), shared, strict=True)]
    return math.hypot(*own_errors) + abs(shared[0] - shared[1]) + OWN * math.hypot(*shared)


def model_error(evaluation: Evaluation, key: str) -> float:
    """Return how much of a result's error is what its model leaves out; 0 where that is not told."""
    stated = evaluation.results.get(MODEL.get(key, ""))
    if stated is not None and stated.value is not None:
        return stated.value
    ending = _SHARES.get(key)
    value = abs(evaluation.results[key].value or 0.0)
    parts = [
        estimate.value or 0.0
        for name, estimate in evaluation.results.items()
        if ending and name.startswith("left_out.") and name.endswith(f".{ending}")
    ]
    return value * math.fsum(parts)
