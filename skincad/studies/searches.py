"""Searches for studies that CMA-ES and NSGA-II don't suit: one key, and choices or whole numbers.

If all combinations fit, they are all evaluated. Of one number its valleys and the edges of the allowed range
are refined. Of more combinations than fit, a surrogate of the results proposes the next ones. Choices beside
numbers share the evaluations out by successive halving.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import InitVar, dataclass, field
from itertools import pairwise

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.optimize import brentq, minimize_scalar
from scipy.spatial.distance import cdist
from scipy.stats import rankdata

from skincad.base.arrays import Array
from skincad.studies.optimisers import (
    NEAR,
    OPTIMISERS,
    Archive,
    Cma,
    Optimiser,
    OptimiserName,
    Outcome,
    levels,
    optimiser,
)
from skincad.studies.subject import DesignVariable, Value

MAX_SCAN = 33  # places of the first scan of a number
BATCH = 8  # places at once, so that several workers have something to do
TASKS = 3  # edges or valleys that are refined at once, the most promising first
RESOLUTION = 1e-5  # of the range, to which an edge of the allowed range is refined; values have 5 digits
VALLEY = 1e-4  # of the range, to which a minimum is refined: its loss is then right to the square of that
FRONT_GAP = 1e-3  # of the front's extent in a loss, from which a gap in it is filled
PER_CHOICE = 6  # evaluations of each combination of choices for each number, from which all have a search
REFINED = 20  # evaluations that refine a number
EXPLOIT = 0.75  # of a batch, which has the best predictions
MAX_CANDIDATES = 4000  # combinations of which the surrogate chooses; of more at random
MAX_FITTED = 400  # evaluations that the surrogate interpolates, the best and others
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
    from. Raises InputError for a package that is not installed.
    """
    count = combinations(knobs)
    discrete = [knob for knob in knobs if levels(knob)]
    share = budget / (combinations(discrete) or 1)  # evaluations for each combination of the discrete keys
    if count is not None and count <= budget:
        return Combinations(knobs)
    if name is not None and OPTIMISERS[name].any_keys:
        return optimiser(name, knobs, losses, seed, start)
    if len(knobs) == 1 and not knobs[0].choices:
        return LineSearch(knobs[0], losses, budget, start, known)
    if count is not None:
        return Surrogate(knobs, losses, budget, seed, start, known)
    fits = share >= PER_CHOICE * (len(knobs) - len(discrete))
    if losses == 1 and discrete and name is None and (fits or budget <= MAX_FITTED):
        return HalvingSearch(knobs, budget, seed, start, fits, known)
    return optimiser("cma" if losses == 1 else "nsga2", knobs, losses, seed, start)


@dataclass
class Combinations:
    """All combinations, once."""

    knobs: tuple[DesignVariable, ...]

    def __post_init__(self) -> None:
        self._rest = _places(self.knobs)

    def ask(self) -> list[Array]:
        """Return all places the first time, and none after that."""
        places, self._rest = self._rest, []
        return places

    def tell(self, evaluations: Sequence[Outcome]) -> None:
        """Take no note."""


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
        self.tell(known)

    def ask(self) -> list[Array]:
        """Return the next places; none if there is no value left that is not evaluated."""
        missing = self._missing(self._first)
        while not missing and self._plan():
            missing = self._missing([x for task in self._tasks if (x := self._next(*task)) is not None])
        return [np.array([x]) for x in missing]

    def tell(self, evaluations: Sequence[Outcome]) -> None:
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
        front = Archive(list(self._known.values())).front
        members = {id(member) for member in front}
        losses = np.array([member.losses for member in front])
        spread = np.maximum(np.ptp(losses, axis=0), 1e-12)  # not 0 for a front of one

        def order(gap: Task) -> tuple[bool, float]:
            ends = [self._at(x) for x in gap[1:]]
            known = all(end.there for end in ends) and any(id(end) in members for end in ends)
            wide = float(np.max(np.abs(ends[0].losses - ends[1].losses) / spread)) if known else 0.0
            return (wide < FRONT_GAP, -wide if wide >= FRONT_GAP else gap[1] - gap[2])

        return sorted((("gap", low, high) for low, high in pairs), key=order)


@dataclass
class Surrogate:
    """Choices and whole numbers of which not all fit, with or without other numbers.

    Radial basis functions (Regis and Shoemaker 2007) interpolate the losses and limits. Of a batch some have
    the best predictions, the others are far from all that is evaluated. No design is asked twice.
    """

    knobs: tuple[DesignVariable, ...]
    losses: int
    budget: int
    seed: int
    start: Array | None = None
    known: InitVar[Sequence[Outcome]] = ()
    _told: dict[tuple[float, ...], Outcome] = field(default_factory=dict)

    def __post_init__(self, known: Sequence[Outcome]) -> None:
        self._random = np.random.default_rng(self.seed)
        names = [len(knob.choices) for knob in self.knobs if any(isinstance(c, str) for c in knob.choices)]
        # nothing is predicted of a name that was not evaluated
        self._spread = max(2 * len(self.knobs), min(max(names, default=0), self.budget // 2))
        count = combinations(self.knobs)
        self._all = np.array(_places(self.knobs)) if count and count <= MAX_CANDIDATES else None
        self._sizes = np.array([levels(knob) for knob in self.knobs])
        self.tell(known)

    def ask(self) -> list[Array]:
        """Return the next places; none if there is no design left."""
        candidates = self._candidates()
        if not len(candidates):
            return []
        features = self._features(candidates)
        known = np.array([evaluation.place for evaluation in self._told.values()])
        first = self.start if self.start is not None else np.full(len(self.knobs), 0.5)
        gaps = cdist(features, self._features(known if len(known) else np.array([first]))).min(axis=1)
        merit = self._predicted(features) if len(known) > self._spread else None
        # each batch fits the surrogate anew: small ones use more of what is known, large ones cost less
        size = max(1, min(BATCH, self.budget // BATCH), len(known) // 20)
        chosen = [] if len(known) else [int(np.argmin(gaps))]
        while len(chosen) < min(size, len(candidates)):
            gaps[chosen] = -1.0
            if merit is not None and len(chosen) < EXPLOIT * size:
                weights = self._random.dirichlet(np.ones(self.losses))
                order = merit @ np.array([*weights, 1.0])
                order[chosen] = math.inf
                pick = int(np.argmin(order))
            else:
                pick = int(np.argmax(gaps))
            chosen.append(pick)
            gaps = np.minimum(gaps, np.linalg.norm(features - features[pick], axis=1))
        return [candidates[i] for i in chosen]

    def tell(self, evaluations: Sequence[Outcome]) -> None:
        """Take the losses and limits of the places."""
        self._told |= {self._key(evaluation.place): evaluation for evaluation in evaluations}

    def _key(self, place: Array) -> tuple[float, ...]:
        """The steps of choices and whole numbers, and the places of others."""
        steps = np.minimum(np.floor(place * self._sizes), self._sizes - 1)
        return tuple(np.where(self._sizes, steps, place).tolist())

    def _candidates(self) -> Array:
        """Designs that are not evaluated `(n, keys)`: all, or random ones and changes of the best ones."""
        if self._all is not None:
            places = self._all
        else:
            size, random = (MAX_CANDIDATES // 2, len(self.knobs)), self._random
            places = random.random(size)
            if self._told:
                best = np.array(
                    [evaluation.place for evaluation in sorted(self._told.values(), key=_loss)[:BATCH]]
                )
                parents = best[random.integers(len(best), size=size[0])]
                changed = random.random(size) < 1.0 / size[1]
                changed[np.arange(size[0]), random.integers(size[1], size=size[0])] = True
                wide = 0.5 ** random.integers(0, 8, (size[0], 1))
                near = np.clip(parents + wide * random.normal(size=size), 0.0, 1.0)
                drawn = np.where([bool(knob.choices) for knob in self.knobs], random.random(size), near)
                places = np.vstack([places, np.where(changed, drawn, parents)])
            steps = np.minimum(np.floor(places * self._sizes), self._sizes - 1) + 0.5
            places = np.unique(np.where(self._sizes, steps / np.maximum(self._sizes, 1), places), axis=0)
        return places[[self._key(place) not in self._told for place in places]]

    def _features(self, places: Array) -> Array:
        """Numbers as shares of their ranges; of choices that are names one number for each."""
        parts = list[Array]()
        for knob, x, count in zip(self.knobs, places.T, self._sizes, strict=True):
            step = np.minimum((x * count).astype(int), count - 1)
            numbers = np.array([value for value in knob.choices if not isinstance(value, str)], dtype=float)
            if count and len(numbers) == count:
                wide = np.ptp(numbers) or 1.0
                parts.append(((numbers[step] - numbers.min()) / wide)[:, None])
            elif knob.choices:
                parts.append(np.eye(count)[step] / math.sqrt(2))  # two choices are 1 apart
            else:
                parts.append((step / max(count - 1, 1) if count else x)[:, None])
        return np.hstack(parts)

    def _predicted(self, features: Array) -> Array:
        """Losses as shares of their ranks `(n, losses)`, and behind them by how much limits are broken."""
        evaluations = sorted(self._told.values(), key=_loss)
        evaluations = evaluations[: MAX_FITTED // 2] + evaluations[MAX_FITTED // 2 :][-MAX_FITTED // 2 :]
        there = [evaluation for evaluation in evaluations if evaluation.there]
        refused = self._fit(
            evaluations, np.array([[float(not evaluation.there)] for evaluation in evaluations]), features
        )
        predicted = np.zeros((len(features), self.losses + 1))
        if there:
            ranks = rankdata([evaluation.losses for evaluation in there], axis=0) / len(there)
            limits = np.array([evaluation.limits for evaluation in there])
            limits = np.sign(limits) * np.log1p(np.abs(limits))  # a limit far away counts little
            predicted[:, :-1] = self._fit(there, ranks, features)
            if limits.size:
                broken = np.maximum(self._fit(there, limits, features), 0.0).sum(axis=1)
                predicted[:, -1] = np.where(broken > 0, 10.0 + broken, 0.0)
        predicted[:, -1] += np.where(refused[:, 0] > 0.5, 20.0, 0.0)
        return predicted

    def _fit(self, evaluations: Sequence[Outcome], numbers: Array, features: Array) -> Array:
        places = self._features(np.array([evaluation.place for evaluation in evaluations]))
        ones, straight = np.ones((len(places), 1)), np.ones((len(features), 1))
        trend = np.linalg.lstsq(np.hstack([ones, places]), numbers, rcond=1e-6)[0]
        # a straight kernel needs no more than one evaluation, but has its least at one: the trend goes on
        rest = RBFInterpolator(places, numbers - np.hstack([ones, places]) @ trend, kernel="linear", degree=0)
        return np.asarray(np.hstack([straight, features]) @ trend + rest(features))


@dataclass
class HalvingSearch:
    """Choices beside numbers: a search of the numbers for each combination of the choices.

    The worse half of them ends in each round (successive halving, Jamieson and Talwalkar 2016). If they don't
    all fit, a surrogate has the first half of the budget or more, and its best combination has the rest.
    """

    knobs: tuple[DesignVariable, ...]
    budget: int
    seed: int
    start: Array | None
    fits: bool
    known: InitVar[Sequence[Outcome]] = ()

    def __post_init__(self, known: Sequence[Outcome]) -> None:
        self._whole = np.array([bool(levels(knob)) for knob in self.knobs])
        self._spent = 0
        numbers = len(self.knobs) - int(self._whole.sum())
        # what one number takes to be refined, but not more than half
        self._coarse = self.budget - min(self.budget // 2, REFINED * numbers)
        self._surrogate = Surrogate(self.knobs, 1, self._coarse, self.seed, self.start, known)
        self._told = list(known)
        if self.fits:
            fixed = _places([knob for knob in self.knobs if levels(knob)])
            self._begin(fixed, None if self.start is None else self.start[~self._whole])

    def _begin(self, fixed: list[Array], start: Array | None) -> None:
        numbers = tuple(knob for knob in self.knobs if not levels(knob))
        known = [
            self._inside(evaluation)
            for evaluation in self._told
            if np.array_equal(evaluation.place[self._whole], fixed[0])
        ]
        share = (self.budget - self._spent) // len(fixed)
        self._fixed = fixed
        self._inner: list[Optimiser] = [
            LineSearch(numbers[0], 1, share, None if len(fixed) > 1 else start, known)
            if len(numbers) == 1
            else Cma(numbers, self.seed + i, start)
            for i in range(len(fixed))
        ]
        self._best = [math.inf] * len(fixed)
        self._alive = list(range(len(fixed)))
        self._round, self._rounds = 1, 1 + math.ceil(math.log2(len(fixed)))

    def _inside(self, evaluation: Outcome) -> Outcome:
        return Outcome(evaluation.place[~self._whole], evaluation.losses, evaluation.limits)

    def ask(self) -> list[Array]:
        """Return the next places of all combinations that are left."""
        if not self.fits and self._spent < self._coarse:
            return self._surrogate.ask()
        if not self.fits:
            self.fits, best = True, min(self._told, key=_loss).place
            self._begin([best[self._whole]], best[~self._whole])
        self._asked = [(i, place) for i in self._alive for place in self._inner[i].ask()]
        return [self._place(self._fixed[i], place) for i, place in self._asked]

    def _place(self, fixed: Array, numbers: Array) -> Array:
        place = np.empty(len(self.knobs))
        place[self._whole], place[~self._whole] = fixed, numbers
        return place

    def tell(self, evaluations: Sequence[Outcome]) -> None:
        """Take the losses and limits, and end the worse half where a round is over."""
        self._spent += len(evaluations)
        if not self.fits:
            self._surrogate.tell(evaluations)
            self._told += evaluations
            return
        for i in self._alive:
            inner = [
                self._inside(evaluation)
                for (j, _), evaluation in zip(self._asked, evaluations, strict=True)
                if j == i
            ]
            if inner:
                self._inner[i].tell(inner)
                self._best[i] = min(self._best[i], *map(_loss, inner))
        while self._round < self._rounds and self._spent >= self._round * self.budget / self._rounds:
            self._alive = sorted(self._alive, key=lambda i: self._best[i])[: math.ceil(len(self._alive) / 2)]
            self._round += 1


def _places(knobs: Sequence[DesignVariable]) -> list[Array]:
    """All combinations as places on the unit cube, each in the middle of its step."""
    sizes = tuple(levels(knob) for knob in knobs)
    return [(np.array(index) + 0.5) / np.array(sizes) for index in np.ndindex(*sizes)]


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
