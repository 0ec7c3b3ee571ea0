"""Optimisers that ask for places on the unit cube and are told what is there.

CMA-ES is the package cma's, TPE and NSGA-II are Optuna's, Sobol points SciPy's. Every optimiser asks for the
same places again if it is told the same: what a log has of an interrupted study is gone through again, and
nothing needs to be kept of an optimiser itself.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Callable, Collection, Hashable, Iterator, Sequence
from dataclasses import InitVar, dataclass
from typing import Any, Literal, Protocol, get_args

import numpy as np
from scipy.stats import qmc

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.studies.subject import DesignVariable

OptimiserName = Literal["cma", "nsga2", "sobol"]
OPTIMISERS: tuple[OptimiserName, ...] = get_args(OptimiserName)
SEVERAL: tuple[OptimiserName, ...] = "nsga2", "sobol"  # those that take several losses
# of the cube: CMA's first standard deviation, from the middle and from a known start
SPREAD, NEAR = 0.3, 0.12
POPULATION, TPE_BATCH, SOBOL_BATCH = 40, 4, 16  # places at once
WORST = 1e30  # the loss and the broken limit of a place without a result
MAX_IDLE = 500  # places without a new design between them, after which a search ends
BEYOND = 0.03  # of the cube: how far outside TPE may look, so that it asks for the ends of a range too
MUTATED = 0.1  # of the cube: the standard deviation of the places that NSGA-II begins with around a start


@dataclass(frozen=True)
class Outcome:
    """What is at a place: `losses` `(m,)`, smaller is better, and `limits` `(k,)`, which must be 0 at most.

    Both are NaN where there is no result.
    """

    place: Array
    losses: Array
    limits: Array

    @property
    def there(self) -> bool:
        """Whether there is a result."""
        return bool(np.all(np.isfinite(self.losses)) and np.all(np.isfinite(self.limits)))

    @property
    def broken(self) -> float:
        """By how much limits are broken in all, 0 if none is; infinite where there is no result."""
        return float(np.maximum(self.limits, 0.0).sum()) if self.there else math.inf


class Optimiser(Protocol):
    """Asks for places `(n,)` on the unit cube, all of a batch at once, and is told of each."""

    def ask(self) -> list[Array]:
        """Return the next places."""

    def tell(self, evaluations: Sequence[Outcome]) -> None:
        """Take note of what was at the places asked for last, in their order."""


@dataclass
class Cma:
    """CMA-ES (Hansen 2016) on one loss, begun anew with twice the batch where it has converged; limits by an
    augmented Lagrangian (Atamna and others 2017)."""

    knobs: tuple[DesignVariable, ...]
    seed: int
    start: Array | None = None
    _inner: Any = None
    _runs: int = 0

    def __post_init__(self) -> None:
        # a step of a choice or a whole number is one unit, so that CMA's own handling of integers knows it
        self._levels = np.array([levels(knob) or 1 for knob in self.knobs], dtype=float)
        self._begin()

    def _begin(self) -> None:
        import cma

        known = self.start is not None and self._runs == 0
        middle = self.start if known and self.start is not None else np.full(len(self.knobs), 0.5)
        whole = [i for i, knob in enumerate(self.knobs) if levels(knob)]
        size = 4 + int(3 * math.log(len(self.knobs)))
        options = {
            "bounds": [np.zeros(len(self.knobs)), self._levels],
            "CMA_stds": self._levels,
            "integer_variables": whole,
            "popsize": size * 2**self._runs,
            "seed": self.seed + 1000 * self._runs + 1,
            "verbose": -9,
            "tolx": 1e-6,
        }
        self._inner = cma.CMAEvolutionStrategy(middle * self._levels, NEAR if known else SPREAD, options)
        # the library's own way to let it write no logs into the working directory
        cma.constraints_handler._Logger = cma.logger.LoggerDummy
        self._lagrangian = cma.ConstrainedFitnessAL(
            lambda x: self._at(x)[0], lambda x: self._at(x)[1], archives=()
        )
        self._runs += 1

    def ask(self) -> list[Array]:
        """Return one generation."""
        if self._inner.stop():
            self._begin()
        self._asked = self._inner.ask()
        return [np.clip(place / self._levels, 0.0, 1.0) for place in self._asked]

    def tell(self, evaluations: Sequence[Outcome]) -> None:
        """Take the generation's losses and limits; a place without a result is worse than all others."""
        self._told = {tuple(x): evaluation for x, evaluation in zip(self._asked, evaluations, strict=True)}
        limited = bool(evaluations[0].limits.size)
        fitness = [
            math.nan
            if not evaluation.there
            else self._lagrangian(x)
            if limited
            else float(evaluation.losses[0])
            for x, evaluation in zip(self._asked, evaluations, strict=True)
        ]
        worst = max((value for value in fitness if math.isfinite(value)), default=0.0)
        filled = [value if math.isfinite(value) else worst + 1.0 + abs(worst) for value in fitness]
        self._inner.tell(self._asked, filled)
        if limited and any(evaluation.there for evaluation in evaluations):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # of a limit that is the same everywhere
                self._lagrangian.update(self._inner)

    def _at(self, x: Any) -> tuple[float, list[float]]:
        evaluation = self._told[tuple(x)]
        return float(evaluation.losses[0]), evaluation.limits.tolist()


@dataclass
class OptunaSearch:
    """A sampler of Optuna, `tpe` or `nsga2`: a limit that is broken comes before all losses.

    TPE (Bergstra and others 2011) is for choices and whole numbers, with numbers or without, NSGA-II (Deb
    2002) for several losses. TPE asks no design twice, and goes on from `known`, earlier evaluations.
    """

    sampler: Literal["tpe", "nsga2"]
    knobs: tuple[DesignVariable, ...]
    losses: int
    seed: int
    start: Array | None = None
    budget: int = 200
    known: InitVar[Sequence[Outcome]] = ()

    def __post_init__(self, known: Sequence[Outcome]) -> None:
        import optuna

        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self._optuna, self._random = optuna, np.random.default_rng(self.seed)
        # of each knob the steps by their values: choices need not stand in the order of their numbers
        self._steps = [_steps(knob) for knob in self.knobs]
        self._space = {f"x{i}": self._distribution(i) for i in range(len(self.knobs))}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)  # interfaces may change
            sampler, self._batch, first = self._sampler(optuna.samplers)
        self._study = optuna.create_study(directions=["minimize"] * self.losses, sampler=sampler)
        self._asked = set[tuple[float, ...]]()
        for evaluation in known:
            parameters, (broken, losses) = self._parameters(evaluation.place), _finite(evaluation)
            self._asked.add(tuple(parameters.values()))
            self._study.add_trial(
                optuna.trial.create_trial(
                    params=parameters,
                    distributions=self._space,
                    values=losses,
                    constraints={"limits": broken},
                )
            )
        for place in first:
            self._study.enqueue_trial(self._parameters(place))

    def _distribution(self, number: int) -> Any:
        kinds, steps = self._optuna.distributions, self._steps[number]
        if any(isinstance(choice, str) for choice in self.knobs[number].choices):
            return kinds.CategoricalDistribution(steps)
        margin = BEYOND if self.sampler == "tpe" else 0.0
        return (
            kinds.IntDistribution(0, len(steps) - 1)
            if steps
            else kinds.FloatDistribution(-margin, 1 + margin)
        )

    def _sampler(self, samplers: Any) -> tuple[Any, int, Sequence[Array]]:
        """The sampler, how many places it asks for at once, and with which it begins."""
        if self.sampler == "tpe":
            first = min(10, self.budget // 4)  # at random; the library's own 10 are many of a few evaluations
            tpe = samplers.TPESampler(seed=self.seed, multivariate=True, n_startup_trials=first)
            return tpe, TPE_BATCH, [] if self.start is None else [self.start]
        # Deb's own operators: on ZDT1 the library's defaults need several times the evaluations
        nsga2 = samplers.NSGAIISampler(
            population_size=POPULATION,
            seed=self.seed,
            crossover=samplers.nsgaii.SBXCrossover(eta=10),
            mutation=samplers.nsgaii.PolynomialMutation(),
        )
        points: Array = np.asarray(qmc.Sobol(len(self.knobs), rng=self.seed).random(64)[:POPULATION])
        if self.start is not None:  # every second place lies around it
            around = np.clip(self._random.normal(self.start, MUTATED, points.shape), 0.0, 1.0)
            points = np.where(np.arange(len(points))[:, None] % 2, points, around)
        return nsga2, POPULATION, list(points)

    def ask(self) -> list[Array]:
        """Return the next places."""
        self._trials = [self._trial() for _ in range(self._batch)]
        return [self._place(self._row(trial)) for trial in self._trials]

    def _place(self, row: tuple[float, ...]) -> Array:
        columns = zip(self._steps, row, strict=True)
        return np.array([(steps[int(x)] + 0.5) / len(steps) if steps else x for steps, x in columns])

    def _trial(self) -> Any:
        """The sampler's next design, of TPE a random one in the place of one that was asked."""
        trial = self._study.ask(self._space)
        if self.sampler == "tpe" and self._row(trial) in self._asked:
            self._study.tell(trial, state=self._optuna.trial.TrialState.FAIL)
            rows = (self._parameters(self._random.random(len(self.knobs))) for _ in range(MAX_IDLE))
            new = (row for row in rows if tuple(row.values()) not in self._asked)
            self._study.enqueue_trial(next(new, trial.params))
            trial = self._study.ask(self._space)
        self._asked.add(self._row(trial))
        return trial

    def _row(self, trial: Any) -> tuple[float, ...]:
        rows = zip(self._space, self._steps, strict=True)
        return tuple(
            trial.params[name] if steps else min(max(trial.params[name], 0.0), 1.0) for name, steps in rows
        )

    def _parameters(self, place: Array) -> dict[str, float]:
        """The place as Optuna has it: of choices and whole numbers which step it is."""
        rows = zip(self._space, self._steps, place, strict=True)
        return {
            name: steps.index(min(int(x * len(steps)), len(steps) - 1)) if steps else float(x)
            for name, steps, x in rows
        }

    def tell(self, evaluations: Sequence[Outcome]) -> None:
        """Take the losses and limits."""
        for trial, evaluation in zip(self._trials, evaluations, strict=True):
            broken, losses = _finite(evaluation)
            trial.set_constraint("limits", broken)
            self._study.tell(trial, losses)


def _steps(knob: DesignVariable) -> list[int]:
    """The steps of a knob of choices or whole numbers, numbers by their size; none for any other."""
    steps, numbers = list(range(levels(knob))), [c for c in knob.choices if not isinstance(c, str)]
    return sorted(steps, key=lambda step: numbers[step]) if len(numbers) == len(steps) else steps


def _finite(evaluation: Outcome) -> tuple[float, list[float]]:
    """By how much limits are broken, and the losses; WORST where there is no result."""
    return min(evaluation.broken, WORST), np.nan_to_num(evaluation.losses, nan=WORST).tolist()


@dataclass
class FixedPlaces:
    """Places that are known beforehand, a batch at a time, whatever is there."""

    batches: Iterator[list[Array]]

    def ask(self) -> list[Array]:
        """Return the next places; none behind the last ones."""
        return next(self.batches, [])

    def tell(self, evaluations: Sequence[Outcome]) -> None:
        """Take no note."""


def sobol(knobs: Sequence[DesignVariable], seed: int) -> FixedPlaces:
    """Return points that fill the cube evenly."""
    points = qmc.Sobol(len(knobs), rng=seed)
    return FixedPlaces(list(points.random(SOBOL_BATCH)) for _ in itertools.count())


def either(names: Sequence[str]) -> str:
    """Return names of optimisers as words, "a, b or c"."""
    return " or ".join(part for part in (", ".join(names[:-1]), names[-1]) if part)


def check_losses(name: OptimiserName, losses: int) -> None:
    """Raise InputError for several losses where an optimiser takes only one."""
    if losses > 1 and name not in SEVERAL:
        raise InputError("optimiser", f"must be {either(SEVERAL)} for several objectives", name)


def optimiser(
    name: OptimiserName, knobs: tuple[DesignVariable, ...], losses: int, seed: int, start: Array | None
) -> Optimiser:
    """Return an optimiser by its name, begun at `start` where one is known.

    Raises InputError for CMA-ES with several losses.
    """
    check_losses(name, losses)
    if name == "sobol":
        return sobol(knobs, seed)
    return Cma(knobs, seed, start) if name == "cma" else OptunaSearch(name, knobs, losses, seed, start)


def levels(knob: DesignVariable) -> int:
    """Return how many values a knob of choices or whole numbers has; 0 for any other."""
    if knob.choices:
        return len(knob.choices)
    return int(knob.high) - int(knob.low) + 1 if knob.whole else 0


def pareto_front(evaluations: Sequence[Outcome]) -> list[Outcome]:
    """Return all that breaks no limit and is not beaten by another, in all losses.

    Of what breaks limits the one that breaks them least, if there is nothing else.
    """
    allowed = [evaluation for evaluation in evaluations if evaluation.there and evaluation.broken <= 0]
    if not allowed:
        return sorted(evaluations, key=lambda evaluation: evaluation.broken)[:1]
    losses = np.array([evaluation.losses for evaluation in allowed])
    return [
        evaluation
        for evaluation, mine in zip(allowed, losses, strict=True)
        if not np.any(np.all(losses <= mine, axis=1) & np.any(losses < mine, axis=1))
    ]


def minimise(
    function: Callable[[list[Array]], list[Outcome]],
    optimiser: Optimiser,
    most: int,
    design: Callable[[Array], Hashable] = bytes,
    known: Collection[Hashable] = (),
) -> list[Outcome]:
    """Return what a function told of places, a batch at a time, in about `most` evaluations: a batch that was
    begun is ended.

    Places of one `design` count once, those of a `known` one don't count. The search also ends if the
    optimiser has no more places, or has had no new design for long.
    """
    archive: dict[Hashable, Outcome] = {}
    before, new, idle = frozenset(known), 0, 0
    while new < most and idle < MAX_IDLE and (places := optimiser.ask()):
        evaluations = function(places)
        optimiser.tell(evaluations)
        batch = {design(place): evaluation for place, evaluation in zip(places, evaluations, strict=True)}
        fresh = len(batch.keys() - archive.keys() - before)
        new, idle = new + fresh, 0 if fresh else idle + len(places)
        archive = batch | archive
    return list(archive.values())
