"""The search that suits a study's keys, and a search for one number.

If all combinations of choices and whole numbers fit, they are all evaluated. Of one number its valleys and
the edges of the allowed range are refined. TPE proposes choices and whole numbers, with numbers or without;
CMA-ES proposes numbers alone, and NSGA-II those of several losses. `python -m bench.searches` compares them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import InitVar, dataclass, field, replace
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from skincad.base.arrays import Array
from skincad.studies.optimisers import (
    NEAR,
    SEVERAL,
    Optimiser,
    OptimiserName,
    Outcome,
    fixed_places,
    levels,
    optimiser,
    optuna_search,
    pareto_front,
)
from skincad.studies.subject import DesignVariable, Value

MAX_SCAN = 33  # places of the first scan of a number
BATCH = 8  # places at once, so that several workers have something to do
TASKS = 3  # edges or valleys that are refined at once, the most promising first
RESOLUTION = 1e-5  # of the range, to which an edge of the allowed range is refined; values have 5 digits
VALLEY = 1e-4  # of the range, to which a minimum is refined: its loss is then right to the square of that
FRONT_GAP = 1e-3  # of the front's extent in a loss, from which a gap in it is filled
REFINED = 20  # evaluations that refine a number beside choices
TPE_MOST = 400  # evaluations, above which CMA-ES is as good and takes no time
BROKEN, REFUSED = 1e30, 1e60  # above each loss: where a limit is broken, and where there is no result
Task = tuple[str, float, float]  # of a line: edge, valley or gap, and between which places


def combinations(knobs: Sequence[DesignVariable]) -> int | None:
    """Return how many designs there are; None if a key has a continuous range."""
    counts = [levels(knob) for knob in knobs]
    return math.prod(counts) if all(counts) else None


def search(
    name: OptimiserName | None,
    knobs: tuple[DesignVariable, ...],
    losses: int,
    budget: int,
    seed: int,
    start: Array | None,
    known: Sequence[Outcome] = (),
) -> Optimiser:
    """Return the search that suits the keys and `budget` evaluations; `name` is the study's optimiser.

    All combinations are evaluated if they fit. `known` are earlier evaluations, which some searches go on
    from.
    """
    count = combinations(knobs)
    if count is not None and count <= budget:
        sizes = tuple(levels(knob) for knob in knobs)  # each in the middle of its step
        return fixed_places([[(np.array(i) + 0.5) / np.array(sizes) for i in np.ndindex(*sizes)]])
    if name in SEVERAL:
        return optimiser(name, knobs, losses, seed, start)
    if len(knobs) == 1 and not knobs[0].choices:
        return LineSearch(knobs[0], losses, budget, start, known).batches()
    numbers = sum(not levels(knob) for knob in knobs)
    mixed = numbers < len(knobs) and losses == 1
    tpe = name is None and budget <= TPE_MOST and (numbers == 0 or mixed)
    if tpe or len(knobs) == 1:  # CMA-ES takes two keys or more
        if losses == numbers == 1:
            return choices_and_number(knobs, budget, seed, start, known)
        return optuna_search("tpe", knobs, losses, seed, start, budget, known)
    return optimiser("cma" if losses == 1 else "nsga2", knobs, losses, seed, start)


class _UnknownError(Exception):
    """A method of SciPy needs the value of a place that is not evaluated yet."""

    def __init__(self, place: float) -> None:
        self.place = place


@dataclass
class LineSearch:
    """One number: an even scan, the edges of the allowed range (Brent 1973, zero), the valleys (Brent 1973,
    bounded minimum), then a finer scan, its gaps beside the best designs first.

    The methods are SciPy's. They are run again from their beginning each time, with all values so far: the
    first one that they lack is asked next. Several losses have no valleys, but gaps in their front.
    """

    knob: DesignVariable
    losses: int
    budget: int
    start: Array | None = None
    known: InitVar[Sequence[Outcome]] = ()
    _known: dict[Value, Outcome] = field(default_factory=dict)
    _tasks: list[Task] = field(default_factory=list)
    _done: set[Task] = field(default_factory=set)

    def __post_init__(self, known: Sequence[Outcome]) -> None:
        count = levels(self.knob)
        self._finest = 0.5 / count if count else RESOLUTION
        even = np.linspace(0.0, 1.0, min(MAX_SCAN, max(2, self.budget // 2)))
        near = [] if self.start is None else [float(self.start[0]) + step for step in (0.0, -NEAR, NEAR)]
        self._first = sorted({float(x) for x in even} | {min(max(x, 0.0), 1.0) for x in near})
        self._places = list[float]()
        self._batch = max(1, min(BATCH, self.budget // BATCH))
        self._take(known)

    def batches(self) -> Optimiser:
        """Yield the next places, until there is no value left that is not evaluated."""
        while True:
            missing = self._missing(self._first)
            while not missing and self._plan():
                missing = self._missing([x for task in self._tasks if (x := self._next(*task)) is not None])
            if not missing:
                return
            self._take((yield [np.array([x]) for x in missing]))
            yield []

    def _take(self, evaluations: Sequence[Outcome]) -> None:
        """Take the losses and limits of the places."""
        places = [float(evaluation.place[0]) for evaluation in evaluations]
        self._known |= {
            self.knob.at(x): evaluation for x, evaluation in zip(places, evaluations, strict=True)
        }
        self._places = sorted({*self._places, *places})

    def _missing(self, places: Sequence[float]) -> list[float]:
        values = {self.knob.at(x): x for x in reversed(places)}
        return sorted(x for value, x in values.items() if value not in self._known)

    def _plan(self) -> bool:
        """Choose what to refine next, if the last tasks are finished; False if nothing is left."""
        self._tasks = [task for task in self._tasks if self._next(*task) is not None]
        for tasks, most in ((self._edges, TASKS), (self._valleys, TASKS), (self._gaps, self._batch)):
            if not self._tasks:
                self._tasks = [task for task in tasks() if task not in self._done][:most]
                self._done |= set(self._tasks)
        return bool(self._tasks)

    def _next(self, kind: str, low: float, high: float) -> float | None:
        """The place that a task needs next, None if it is finished."""
        try:
            if kind == "edge":
                brentq(lambda x: _limit(self._at(x)), low, high, xtol=self._finest)
            elif kind == "valley":
                options = {"xatol": max(VALLEY, self._finest)}
                minimize_scalar(
                    lambda x: _loss(self._at(x)), bounds=(low, high), method="bounded", options=options
                )
            else:
                self._at((low + high) / 2)
        except _UnknownError as unknown:
            return unknown.place
        return None

    def _at(self, x: float) -> Outcome:
        evaluation = self._known.get(self.knob.at(x))
        if evaluation is None:
            raise _UnknownError(float(x))
        return evaluation

    def _edges(self) -> list[Task]:
        """Where what is allowed ends, if a better design may be there."""
        best = min(_loss(evaluation) for evaluation in self._known.values())
        tasks = []
        for low, high in pairwise(self._places):
            one, other = self._at(low), self._at(high)
            if (one.broken <= 0) == (other.broken <= 0) or high - low <= self._finest:
                continue
            known = [float(side.losses[0]) for side in (one, other) if side.there]
            hope = min(known) - (max(known) - min(known)) if len(known) == 2 else -math.inf
            if self.losses > 1 or hope <= best:
                tasks.append((min(_loss(one), _loss(other)), ("edge", low, high)))
        return [task for _, task in sorted(tasks)]

    def _valleys(self) -> list[Task]:
        """Where a place is lower than its neighbours, if a better design may be there; ends come last."""
        if self.losses > 1:
            return []
        places = self._places
        losses = [_loss(self._at(x)) for x in places]
        tasks = []
        for i, loss in enumerate(losses):
            beside = [j for j in (i - 1, i + 1) if 0 <= j < len(places)]
            rises = [losses[j] - loss for j in beside]
            low, high = places[max(i - 1, 0)], places[min(i + 1, len(places) - 1)]
            if min(rises) < 0 or max(rises) == 0 or high - low <= 6 * max(VALLEY, self._finest):
                continue
            inner = len(beside) == 2 and max(rises) < BROKEN / 2
            if loss - max(rises) <= min(losses):
                tasks.append((not inner, loss, ("valley", low, high)))
        return [task for *_, task in sorted(tasks)]

    def _gaps(self) -> list[Task]:
        """Gaps between the places, the widest first, and of like ones those beside the best designs.

        Of several losses the gaps in their front come first, the widest in their losses.
        """
        pairs = [(low, high) for low, high in pairwise(self._places) if high - low > self._finest]
        if self.losses > 1:
            return self._front_gaps(pairs)
        return sorted(
            (("gap", low, high) for low, high in pairs),
            key=lambda gap: (
                -round(math.log2(gap[2] - gap[1])),
                min(_loss(self._at(gap[1])), _loss(self._at(gap[2]))),
            ),
        )

    def _front_gaps(self, pairs: Sequence[tuple[float, float]]) -> list[Task]:
        front = pareto_front([*self._known.values()])
        members = {id(member) for member in front}
        losses = np.array([member.losses for member in front])
        spread = np.maximum(np.ptp(losses, axis=0), 1e-12)  # not 0 for a front of one

        def order(gap: Task) -> tuple[bool, float]:
            ends = [self._at(x) for x in gap[1:]]
            known = all(end.there for end in ends) and any(id(end) in members for end in ends)
            wide = float(np.max(np.abs(ends[0].losses - ends[1].losses) / spread)) if known else 0.0
            return (wide < FRONT_GAP, -wide if wide >= FRONT_GAP else gap[1] - gap[2])

        return sorted((("gap", low, high) for low, high in pairs), key=order)


def choices_and_number(
    knobs: tuple[DesignVariable, ...], budget: int, seed: int, start: Array | None, known: Sequence[Outcome]
) -> Optimiser:
    """Search choices beside one number by TPE, and at the end with the best choices along a line."""
    number = next(i for i, knob in enumerate(knobs) if not levels(knob))
    tpe = optuna_search("tpe", knobs, 1, seed, start, budget, known)
    evaluations, left = list(known), budget - min(budget // 2, REFINED)
    while left > 0:
        outcomes = yield next(tpe)
        tpe.send(outcomes)
        left -= len(outcomes)
        evaluations += outcomes
        yield []

    def alone(evaluation: Outcome) -> Outcome:
        return replace(evaluation, place=evaluation.place[[number]])

    best = min(evaluations, key=_loss).place
    others = np.delete(best, number)
    alike = [alone(e) for e in evaluations if np.array_equal(np.delete(e.place, number), others)]
    line = LineSearch(knobs[number], 1, min(budget // 2, REFINED), best[[number]], alike).batches()
    for places in line:
        outcomes = yield [np.insert(others, number, place) for place in places]
        line.send([*map(alone, outcomes)])
        yield []


def _loss(evaluation: Outcome) -> float:
    """The first loss; above all losses where limits are broken, and above that where there is no result."""
    if not evaluation.there:
        return REFUSED
    return float(evaluation.losses[0]) if evaluation.broken <= 0 else BROKEN * (1.0 + evaluation.broken)


def _limit(evaluation: Outcome) -> float:
    """The limit that is broken most: at most 0 where the design is allowed, 1 where there is no result."""
    if not evaluation.there:
        return 1.0
    if not evaluation.limits.size:
        return -1.0
    return float(np.max(evaluation.limits)) or -1.0  # 0 is allowed, and no root
