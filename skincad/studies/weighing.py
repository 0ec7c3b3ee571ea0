"""What a study's objectives and limits make of results: losses, and by how much each limit is broken.

By as much as the judge's numbers differed from a model's on the last design that both saw, the model's are
taken larger or smaller everywhere; before that, by their own error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from skincad.base.arrays import Array
from skincad.base.estimate import Estimate
from skincad.studies.measures import resolved, slack
from skincad.studies.optimisation import Member
from skincad.studies.optimisers import Archive, Outcome
from skincad.studies.question import Kind
from skincad.studies.study import Limit, Objective, Study

OTHERS: tuple[Kind, ...] = (
    "make",
    "check",
)  # results beside the searching one's, before whose keys their name stands
DIFFERENCES = ("margin_N",)  # numbers that may be 0: two models of them differ by so much, not by a factor
Results = Mapping[str, Estimate]
Model = Literal[
    "guide", "search", "judge"
]  # the closed form, the one that searches, and who has the last word


def _sign(of: Objective | str) -> float:
    """1 where larger is worse, -1 where smaller is."""
    return 1.0 if of == "at_most" or (isinstance(of, Objective) and of.goal == "min") else -1.0


@dataclass
class RobustObjective:
    """A study's aims, and by model, key and which end is worse the factor and the difference of the judge's
    worse end from the model's value."""

    study: Study
    differs: dict[tuple[Model, str, float], tuple[float, float]] = field(default_factory=dict)

    def others(self) -> list[Kind]:
        """Return the names of the other results that objectives and limits are about."""
        return [kind for kind in OTHERS if any(key.startswith(f"{kind}.") for key in self.study.aims)]

    def told(self, place: Array, results: Results | None, model: Model) -> Outcome:
        """Return losses and limits at a place by what the judge would say; limits of numbers that the closed
        form does not tell are taken as kept."""
        if not results:
            return Outcome(
                place, np.full(len(self.study.objectives), np.nan), np.full(len(self._limits()), np.nan)
            )
        limits = np.array([self._excess(limit, results, side, model) for limit, side in self._limits()])
        margins = np.nan_to_num(limits, nan=-1.0) if model == "guide" else limits
        return Outcome(place, np.array(self._losses(results, model)), margins)

    def member(self, values: Mapping[str, float | int | str], results: Results, tier: str) -> Member:
        """Return what the judge's results make of a design."""
        met: dict[str, bool] = {}
        for limit, side in self._limits():
            key = resolved(limit.key, results, what="key")
            met[key] = met.get(key, True) and self._excess(limit, results, side, "judge") <= 0
        wanted = [resolved(objective.key, results, what="key") for objective in self.study.objectives]
        return Member(
            dict(values),
            {key: results[key] for key in wanted},
            {key: (results[key], good) for key, good in met.items()},
            tier,
        )

    def correct(self, member: Member, results: Results, model: Model) -> None:
        """Take from a judged design how the judge's worse ends differ from what a model says of it."""
        judged = {**member.objectives, **{key: estimate for key, (estimate, _) in member.constraints.items()}}
        wanted = [(estimate.key, _sign(estimate)) for estimate in self.study.objectives]
        wanted += [(limit.key, _sign(side)) for limit, side in self._limits()]
        for key, sign in wanted:
            name = resolved(key, judged, what="key")
            mine, estimate = results.get(name), judged[name]
            if mine is None or mine.value is None or estimate.value is None or mine == estimate:
                continue  # what both say alike, each design has with its own error
            worse = estimate.value + sign * self._slack(estimate)
            by_factor = name.rpartition(".")[2] not in DIFFERENCES and worse * mine.value > 0
            self.differs[model, name, sign] = (
                (worse / mine.value, 0.0) if by_factor else (1.0, worse - mine.value)
            )

    def ordered(self, members: Sequence[Member]) -> list[Member]:
        """Return members, those that keep all constraints first, the best of the first objective first."""
        return sorted(members, key=lambda each: (not each.allowed, self._losses(each.objectives, "judge")[0]))

    def pareto_front(self, members: Sequence[Member]) -> list[Member]:
        """Return the members that no other one beats in all objectives; of one objective the first alone.

        The first few cover the front: each is the one that is farthest from those before it.
        """
        if len(self.study.objectives) == 1:
            return list(members[:1])
        evaluations = [
            Outcome(np.zeros(0), np.array(self._losses(m.objectives, "judge")), np.zeros(0)) for m in members
        ]
        best = {id(evaluation) for evaluation in (Archive(evaluations).front if evaluations else [])}
        front = [
            member for member, evaluation in zip(members, evaluations, strict=True) if id(evaluation) in best
        ]
        losses = np.array([evaluation.losses for evaluation in evaluations if id(evaluation) in best])
        order = list(range(len(front)))
        for i in range(1, len(front)):
            gaps = np.abs(losses[order[i:], None] - losses[order[:i]]) / (np.ptp(losses, axis=0) + 1e-300)
            farthest = i + int(np.argmax(gaps.max(axis=2).min(axis=1)))
            order[i], order[farthest] = order[farthest], order[i]
        return [front[i] for i in order]

    def _limits(self) -> list[tuple[Limit, str]]:
        return [
            (limit, side)
            for limit in self.study.constraints
            for side in ("at_least", "at_most")
            if getattr(limit, side) is not None
        ]

    def _losses(self, results: Results, model: Model) -> list[float]:
        return [
            _sign(objective) * self._worse(objective.key, results, _sign(objective), model)
            for objective in self.study.objectives
        ]

    def _excess(self, limit: Limit, results: Results, side: str, model: Model) -> float:
        """By how much a limit is broken, as a part of it; below 0 where it is kept."""
        bound: float = getattr(limit, side)
        sign = _sign(side)
        return sign * (self._worse(limit.key, results, sign, model) - bound) / (abs(bound) or 1.0)

    def _worse(self, key: str, results: Results, sign: float, model: Model) -> float:
        """A number's worse end, as the judge would have it where that is known; NaN where there is none."""
        kind = key.partition(".")[0]
        if kind in OTHERS and not any(result.startswith(f"{kind}.") for result in results):
            return math.nan
        name = resolved(key, results, what="key")
        estimate = results[name]
        if estimate.value is None:
            return math.nan
        factor, more = self.differs.get((model, name, sign), (1.0, sign * self._slack(estimate)))
        return estimate.value * factor + more

    def _slack(self, estimate: Estimate) -> float:
        return slack(estimate) if self.study.robust else 0.0
