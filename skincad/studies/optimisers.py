"""Optimisers that ask for places on the unit cube and are told what is there: CMA-ES, NSGA-II, Sobol points.

Every optimiser asks for the same places again if it is told the same: what a log has of an interrupted study
is gone through again, and nothing needs to be kept of an optimiser itself.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Collection, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from scipy.stats import qmc

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.studies.subject import DesignVariable

OptimiserName = Literal["cma", "nsga2", "sobol"]
SPREAD, NEAR = (
    0.3,
    0.12,
)  # of the cube: CMA's first standard deviation, from the middle and from a known start
WORST = 1e30  # the loss and the broken limit of a place without a result
MAX_IDLE = 500  # places without a new design between them, after which a search ends
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
class Nsga2:
    """NSGA-II (Deb 2002) of optuna, for several losses; a limit that is broken comes before all losses."""

    knobs: tuple[DesignVariable, ...]
    seed: int
    losses: int
    start: Array | None = None
    population: int = 40

    def __post_init__(self) -> None:
        try:
            import optuna
        except ImportError:
            rule = "needs the package optuna for several objectives"
            raise InputError("optimiser", rule, remedy="pip install 'skincad[optuna]'") from None
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        # Deb's own operators: on ZDT1 the library's defaults need several times the evaluations
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)  # interfaces may change
            sampler = optuna.samplers.NSGAIISampler(
                population_size=self.population,
                seed=self.seed,
                crossover=optuna.samplers.nsgaii.SBXCrossover(eta=10),
                mutation=optuna.samplers.nsgaii.PolynomialMutation(),
            )
        self._optuna = optuna
        self._study = optuna.create_study(directions=["minimize"] * self.losses, sampler=sampler)
        self._names = [f"x{i}" for i in range(len(self.knobs))]
        for place in self._first():
            self._study.enqueue_trial(dict(zip(self._names, place.tolist(), strict=True)))

    def _first(self) -> Array:
        """A generation around a start, or over the cube."""
        places: Array = np.asarray(qmc.Sobol(len(self.knobs), rng=self.seed).random(64)[: self.population])
        if self.start is None:
            return places
        around = np.random.default_rng(self.seed).normal(self.start, MUTATED, places.shape)
        return np.where(np.arange(len(places))[:, None] % 2, places, np.clip(around, 0.0, 1.0))

    def ask(self) -> list[Array]:
        """Return one generation."""
        whole = self._optuna.distributions.FloatDistribution(0.0, 1.0)
        self._trials = [self._study.ask(dict.fromkeys(self._names, whole)) for _ in range(self.population)]
        return [np.array([suggestion.params[name] for name in self._names]) for suggestion in self._trials]

    def tell(self, evaluations: Sequence[Outcome]) -> None:
        """Take the generation's losses and limits."""
        for suggestion, evaluation in zip(self._trials, evaluations, strict=True):
            suggestion.set_constraint("limits", min(evaluation.broken, WORST))
            self._study.tell(suggestion, np.nan_to_num(evaluation.losses, nan=WORST).tolist())


@dataclass
class Sobol:
    """Points that fill the cube evenly, whatever is there."""

    knobs: tuple[DesignVariable, ...]
    seed: int
    batch: int = 16

    def __post_init__(self) -> None:
        self._points = qmc.Sobol(len(self.knobs), rng=self.seed)

    def ask(self) -> list[Array]:
        """Return the next points."""
        return list(self._points.random(self.batch))

    def tell(self, evaluations: Sequence[Outcome]) -> None:
        """Take no note."""


class OptimiserRow(NamedTuple):
    """How an optimiser is made of keys, how many losses, seed and start; whether it takes `several` losses;
    and whether it takes `any_keys`, in the place of what suits one key, and choices or whole numbers."""

    make: Callable[[tuple[DesignVariable, ...], int, int, Array | None], Optimiser]
    several: bool = True
    any_keys: bool = True


OPTIMISERS: dict[OptimiserName, OptimiserRow] = {
    "cma": OptimiserRow(lambda knobs, _, seed, start: Cma(knobs, seed, start), several=False, any_keys=False),
    "nsga2": OptimiserRow(lambda knobs, losses, seed, start: Nsga2(knobs, seed, losses, start)),
    "sobol": OptimiserRow(lambda knobs, _losses, seed, _start: Sobol(knobs, seed)),
}


def either(names: Sequence[str]) -> str:
    """Return names of optimisers as words, "a, b or c"."""
    return " or ".join(part for part in (", ".join(names[:-1]), names[-1]) if part)


def check_losses(name: OptimiserName, losses: int) -> None:
    """Raise InputError for several losses where an optimiser takes only one."""
    if losses > 1 and not OPTIMISERS[name].several:
        able = either([other for other, row in OPTIMISERS.items() if row.several])
        raise InputError("optimiser", f"must be {able} for several objectives", name)


def optimiser(
    name: OptimiserName, knobs: tuple[DesignVariable, ...], losses: int, seed: int, start: Array | None
) -> Optimiser:
    """Return an optimiser by its name, begun at `start` where one is known.

    Raises InputError for CMA-ES with several losses, and for a package that is not installed.
    """
    check_losses(name, losses)
    return OPTIMISERS[name].make(knobs, losses, seed, start)


def levels(knob: DesignVariable) -> int:
    """Return how many values a knob of choices or whole numbers has; 0 for any other."""
    if knob.choices:
        return len(knob.choices)
    return int(knob.high) - int(knob.low) + 1 if knob.whole else 0


@dataclass
class Archive:
    """What was found so far: all that breaks no limit and is not beaten by another, in all losses."""

    evaluations: list[Outcome] = field(default_factory=list)

    @property
    def front(self) -> list[Outcome]:
        """The front; of what breaks limits the one that breaks them least, if there is nothing else."""
        allowed = [
            evaluation for evaluation in self.evaluations if evaluation.there and evaluation.broken <= 0
        ]
        if not allowed:
            return sorted(self.evaluations, key=lambda evaluation: evaluation.broken)[:1]
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
) -> Archive:
    """Return the front of a function that tells of a batch of places, in about `most` evaluations: a batch
    that was begun is ended.

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
    return Archive(list(archive.values()))
