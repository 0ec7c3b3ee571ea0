"""Optimisers that ask for places on the unit cube and are told what is there.

CMA-ES is the package cma's, TPE and NSGA-II are Optuna's, Sobol points SciPy's. Every optimiser asks for the
same places again if it is told the same: what a log has of an interrupted study is gone through again, and
nothing needs to be kept of an optimiser itself.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Callable, Collection, Generator, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np

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


# yields the next batch of places `(n,)` on the unit cube; it is sent the outcomes there, in their order,
# which it answers by an empty batch, and waits until the next batch is wanted
Optimiser = Generator[list[Array], Sequence[Outcome], None]


def cma_es(knobs: Sequence[DesignVariable], seed: int, start: Array | None = None) -> Optimiser:
    """Search one loss by CMA-ES (Hansen 2016), begun anew with twice the batch where it has converged; limits
    by an augmented Lagrangian (Atamna and others 2017)."""
    import cma

    # the library's own way to let it write no logs into the working directory
    cma.constraints_handler._Logger = cma.logger.LoggerDummy
    # a step of a choice or a whole number is one unit, so that CMA's own handling of integers knows it
    units = np.array([levels(knob) or 1 for knob in knobs], dtype=float)
    options = {
        "bounds": [np.zeros(len(knobs)), units],
        "CMA_stds": units,
        "integer_variables": [i for i, knob in enumerate(knobs) if levels(knob)],
        "verbose": -9,
        "tolx": 1e-6,
    }
    size, middle = 4 + int(3 * math.log(len(knobs))), np.full(len(knobs), 0.5)
    last: dict[tuple[float, ...], Outcome] = {}  # batch, by its places in units
    for run in itertools.count():
        at, wide = (middle, SPREAD) if run or start is None else (start, NEAR)
        own = {"popsize": size * 2**run, "seed": seed + 1000 * run + 1}
        strategy = cma.CMAEvolutionStrategy(at * units, wide, {**options, **own})
        lagrangian = cma.ConstrainedFitnessAL(
            lambda x: float(last[tuple(x)].losses[0]), lambda x: last[tuple(x)].limits.tolist(), archives=()
        )
        while not strategy.stop():
            asked = strategy.ask()
            outcomes = yield [np.clip(place / units, 0.0, 1.0) for place in asked]
            last.clear()
            last.update(zip(map(tuple, asked), outcomes, strict=True))
            limited = bool(outcomes[0].limits.size)
            # a place without a result is worse than all others
            fitness = [
                math.nan if not outcome.there else lagrangian(x) if limited else float(outcome.losses[0])
                for x, outcome in zip(asked, outcomes, strict=True)
            ]
            worst = max((value for value in fitness if math.isfinite(value)), default=0.0)
            filled = [value if math.isfinite(value) else worst + 1.0 + abs(worst) for value in fitness]
            strategy.tell(asked, filled)
            if limited and any(outcome.there for outcome in outcomes):
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", UserWarning)  # of a limit that is the same everywhere
                    lagrangian.update(strategy)
            yield []


def optuna_search(
    name: Literal["tpe", "nsga2"],
    knobs: Sequence[DesignVariable],
    losses: int,
    seed: int,
    start: Array | None = None,
    budget: int = 200,
    known: Sequence[Outcome] = (),
) -> Optimiser:
    """Search by a sampler of Optuna: a limit that is broken comes before all losses.

    TPE (Bergstra and others 2011) is for choices and whole numbers, with numbers or without, NSGA-II (Deb
    2002) for several losses. TPE asks no design twice, and goes on from `known`, earlier evaluations.
    """
    import optuna

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    random = np.random.default_rng(seed)
    # of each knob the steps by their values: choices need not stand in the order of their numbers
    steps = {f"x{i}": _steps(knob) for i, knob in enumerate(knobs)}
    margin, kinds = BEYOND if name == "tpe" else 0.0, optuna.distributions
    named = [any(isinstance(choice, str) for choice in knob.choices) for knob in knobs]
    space = {
        key: kinds.CategoricalDistribution(own)
        if text
        else kinds.IntDistribution(0, len(own) - 1)
        if own
        else kinds.FloatDistribution(-margin, 1 + margin)
        for (key, own), text in zip(steps.items(), named, strict=True)
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)  # interfaces may change
        if name == "tpe":
            at_random = min(10, budget // 4)  # the library's own 10 are many of a few evaluations
            sampler = optuna.samplers.TPESampler(seed=seed, multivariate=True, n_startup_trials=at_random)
            batch, first = TPE_BATCH, [] if start is None else [start]
        else:
            sampler, first = _nsga2(len(knobs), seed, start, random)
            batch = POPULATION
    study = optuna.create_study(directions=["minimize"] * losses, sampler=sampler)

    def parameters(place: Array) -> dict[str, float]:
        """The place as Optuna has it: of choices and whole numbers which step it is."""
        return {
            key: own.index(min(int(x * len(own)), len(own) - 1)) if own else float(x)
            for (key, own), x in zip(steps.items(), place, strict=True)
        }

    def row(trial: Any) -> tuple[float, ...]:
        numbers = ((own, trial.params[key]) for key, own in steps.items())
        return tuple(x if own else min(max(x, 0.0), 1.0) for own, x in numbers)

    asked = set[tuple[float, ...]]()
    for outcome in known:
        (broken, values), there = _finite(outcome), parameters(outcome.place)
        asked.add(tuple(there.values()))
        study.add_trial(
            optuna.trial.create_trial(
                params=there, distributions=space, values=values, constraints={"limits": broken}
            )
        )
    for place in first:
        study.enqueue_trial(parameters(place))
    while True:
        trials, rows = [], []
        for _ in range(batch):
            trial = study.ask(space)
            if name == "tpe" and row(trial) in asked:  # a random one in its place
                study.tell(trial, state=optuna.trial.TrialState.FAIL)
                drawn = (parameters(random.random(len(knobs))) for _ in range(MAX_IDLE))
                new = (other for other in drawn if tuple(other.values()) not in asked)
                study.enqueue_trial(next(new, trial.params))
                trial = study.ask(space)
            trials.append(trial)
            rows.append(row(trial))
            asked.add(rows[-1])
        columns = list(steps.values())
        outcomes = yield [
            np.array([(o[int(x)] + 0.5) / len(o) if o else x for o, x in zip(columns, values, strict=True)])
            for values in rows
        ]
        for trial, outcome in zip(trials, outcomes, strict=True):
            broken, values = _finite(outcome)
            trial.set_constraint("limits", broken)
            study.tell(trial, values)
        yield []


def _nsga2(size: int, seed: int, start: Array | None, random: np.random.Generator) -> tuple[Any, list[Array]]:
    """NSGA-II with Deb's own operators, and the places that it begins with: on ZDT1 the library's defaults
    need several times the evaluations."""
    from optuna.samplers import NSGAIISampler, nsgaii

    sampler = NSGAIISampler(
        population_size=POPULATION,
        seed=seed,
        crossover=nsgaii.SBXCrossover(eta=10),
        mutation=nsgaii.PolynomialMutation(),
    )
    from scipy.stats import qmc  # half a second, which most commands need not wait for

    points: Array = np.asarray(qmc.Sobol(size, rng=seed).random(64)[:POPULATION])
    if start is not None:  # every second place lies around it
        around = np.clip(random.normal(start, MUTATED, points.shape), 0.0, 1.0)
        points = np.where(np.arange(len(points))[:, None] % 2, points, around)
    return sampler, list(points)


def _steps(knob: DesignVariable) -> list[int]:
    """The steps of a knob of choices or whole numbers, numbers by their size; none for any other."""
    steps, numbers = list(range(levels(knob))), [c for c in knob.choices if not isinstance(c, str)]
    return sorted(steps, key=lambda step: numbers[step]) if len(numbers) == len(steps) else steps


def _finite(evaluation: Outcome) -> tuple[float, list[float]]:
    """By how much limits are broken, and the losses; WORST where there is no result."""
    return min(evaluation.broken, WORST), np.nan_to_num(evaluation.losses, nan=WORST).tolist()


def fixed_places(batches: Iterable[list[Array]]) -> Optimiser:
    """Go through places that are known beforehand, a batch at a time, whatever is there."""
    for places in batches:
        yield places
        yield []


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
        from scipy.stats import qmc

        points = qmc.Sobol(len(knobs), rng=seed)  # they fill the cube evenly
        return fixed_places(list(points.random(SOBOL_BATCH)) for _ in itertools.count())
    return cma_es(knobs, seed, start) if name == "cma" else optuna_search(name, knobs, losses, seed, start)


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
    while new < most and idle < MAX_IDLE and (places := next(optimiser, [])):
        evaluations = function(places)
        optimiser.send(evaluations)
        batch = {design(place): evaluation for place, evaluation in zip(places, evaluations, strict=True)}
        fresh = len(batch.keys() - archive.keys() - before)
        new, idle = new + fresh, 0 if fresh else idle + len(places)
        archive = batch | archive
    return list(archive.values())
