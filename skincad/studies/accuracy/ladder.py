"""Work-precision studies: models at ever finer settings, their errors and their time."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from time import perf_counter
from typing import Any, Protocol, TypeVar, cast

import numpy as np

from skincad.base.errors import InputError, did_you_mean
from skincad.base.interrupt import safe_point
from skincad.base.progress import Progress
from skincad.inputs.design import Design

PRIOR = 2.0  # s that were as expected before anything is measured: one short stage says little of a machine


class Countdown:
    """A Progress that adds to each stage the seconds left to the end of all.

    `prices` are s by stage in the order in which they come; a stage that is left out is passed over, one that
    is not known costs nothing. Expected times are scaled by those of the stages done.
    """

    def __init__(
        self, prices: Mapping[str, float], progress: Progress, now: Callable[[], float] = perf_counter
    ) -> None:
        self._stages, self._prices = list(prices), list(prices.values())
        self._progress, self._now = progress, now
        self._at: int | None = None
        self._began = self._spent = self._done = 0.0

    def __call__(self, stage: str, left: float | None = None, /) -> None:
        """Tell the stage and the seconds from its begin to the end of all."""
        now = self._now()
        if self._at is not None:
            self._spent += now - self._began
            self._done += self._prices[self._at]
        self._at, self._began = (self._stages.index(stage) if stage in self._stages else None), now
        if self._at is None:
            self._progress(stage, left)
            return
        slower = (PRIOR + self._spent) / (PRIOR + self._done)
        self._progress(stage, slower * math.fsum(self._prices[self._at :]))


def front(seconds: Sequence[float], errors: Sequence[float]) -> list[int]:
    """Return the indices, by time, of the points that no other beats in both time and error."""
    indices: list[int] = []
    for i in sorted(range(len(seconds)), key=lambda i: (seconds[i], errors[i])):
        if not indices or errors[i] < errors[indices[-1]]:
            indices.append(i)
    return indices


def slope(seconds: Sequence[float], errors: Sequence[float]) -> float | None:
    """Return p of error ~ seconds^p by least squares of the logarithms; None for fewer than two times.

    -1 says: ten times the time, a tenth of the error. Errors of 0 have no logarithm and are left out.
    """
    points = [(s, e) for s, e in zip(seconds, errors, strict=True) if e > 0]
    if len({s for s, _ in points}) < 2:
        return None
    x, y = np.log(np.array(points)).T
    return float(np.polyfit(x, y, 1)[0])


@dataclass(frozen=True)
class PowerLaw:
    """seconds = factor x unknowns^exponent; `scatter` is the rms of the fit's ratio, 1 where it is exact."""

    factor: float
    exponent: float
    scatter: float

    def seconds(self, unknowns: float) -> float:
        """Return the expected time, s."""
        return float(self.factor * unknowns**self.exponent)


def power_law(unknowns: Sequence[float], seconds: Sequence[float]) -> PowerLaw | None:
    """Return the law through measured trials by least squares of the logarithms; None below two sizes."""
    if len(set(unknowns)) < 2:
        return None
    x, y = np.log(np.array(unknowns, float)), np.log(np.array(seconds, float))
    exponent, level = np.polyfit(x, y, 1)
    off = y - (exponent * x + level)
    return PowerLaw(float(np.exp(level)), float(exponent), float(np.exp(np.sqrt(np.mean(off**2)))))


Value = TypeVar("Value")
LONG = 2.0  # s; what takes longer is run once, or the whole would take a coffee break
SHORT = 0.5  # s; what takes less is run once more before, for its first run fills caches
MOST_DIGITS = 13  # beyond are rounding's
FEWEST = 3  # sizes that a law of time is drawn through
_ROOM = "skincad.studies.accuracy."
LADDERS = {
    "tessellation": f"{_ROOM}tessellation",
    "contact": f"{_ROOM}contact",
    "circuit": f"{_ROOM}circuit",
    "slip": f"{_ROOM}slip",
    "effects": f"{_ROOM}effects",
}


@dataclass(frozen=True)
class ErrorMeasure:
    """An error that every trial is judged by: `what` in `unit` ("1" is relative), `reference` is held to be
    true, `checked` says how that is known.

    `compares` says whether all trials aim at one reference, so that their times may be compared at equal
    error; where each model aims at its own, only trials of one model may. `floor` is the reference's own
    error, below which differences say nothing. `name` is the measure's key; `label` is shown, if given.
    """

    name: str
    what: str
    unit: str
    reference: str
    checked: str
    compares: bool = True
    floor: float = 0.0
    label: str = ""

    @property
    def shown(self) -> str:
        """What a reader sees of its name."""
        return self.label or self.name


@dataclass(frozen=True)
class Measurement:
    """One model at one setting: unknowns, the wall time of each repeat in s, and its errors by measure.

    `instead` are the repeats of what does not make these errors, where that is what a diagram should show.
    """

    model: str
    setting: str
    unknowns: int
    runs: tuple[float, ...]
    errors: dict[str, float]
    instead: tuple[float, ...] = ()

    @property
    def seconds(self) -> float:
        """The median of the repeats, s."""
        return statistics.median(self.runs)

    @property
    def spread(self) -> float:
        """The longest repeat less the shortest, s."""
        return max(self.runs) - min(self.runs)


@dataclass(frozen=True)
class Ladder:
    """Rungs with the measures that judge them, the first being the `error` of the contract.

    `lines` says whether trials of a model are steps of one method; `skipped` why a trial is not there.
    """

    name: str
    title: str
    trials: tuple[Measurement, ...]
    measures: tuple[ErrorMeasure, ...]
    lines: bool = True
    skipped: dict[str, str] = field(default_factory=dict)

    def best(self, measure: ErrorMeasure) -> list[Measurement]:
        """Return the trials that no other beats in both time and this error: of all trials, or of its own
        model where each aims at its own truth; none where no line joins them."""
        judged = (
            [measurement for measurement in self.trials if measure.name in measurement.errors]
            if self.lines
            else []
        )
        models = dict.fromkeys(measurement.model for measurement in judged)
        groups = [judged] if measure.compares else [[r for r in judged if r.model == m] for m in models]
        fastest: list[Measurement] = []
        for group in groups:
            errors = [measurement.errors[measure.name] for measurement in group]
            fastest += [group[i] for i in front([measurement.seconds for measurement in group], errors)]
        return fastest

    def matched(self, measure: ErrorMeasure) -> dict[float, list[Measurement]]:
        """Return the cheapest trial of each model that reaches an error, by error, cheapest first.

        Errors are powers of ten above the reference's own; those that fewer than two models reach, or that
        all reach by the same trials as ten times the error, tell nothing and are left out.
        """
        rows: dict[float, list[Measurement]] = {}
        if not (self.lines and measure.compares):
            return rows
        for error in (10.0**-n for n in range(1, MOST_DIGITS)):
            cheapest: dict[str, Measurement] = {}
            for measurement in sorted(self.trials, key=lambda measurement: measurement.seconds):
                if measurement.errors.get(measure.name, math.inf) <= error and error > measure.floor:
                    cheapest.setdefault(measurement.model, measurement)
            group = list(cheapest.values())
            if len(group) > 1 and group not in rows.values():
                rows[error] = group
        return rows

    def laws(self) -> dict[str, PowerLaw]:
        """Return time against unknowns by model, where it has three trials of different size."""
        by_model = {}
        for model in dict.fromkeys(measurement.model for measurement in self.trials) if self.lines else ():
            mine = [measurement for measurement in self.trials if measurement.model == model]
            law = power_law(
                [measurement.unknowns for measurement in mine], [measurement.seconds for measurement in mine]
            )
            if law and len({measurement.unknowns for measurement in mine}) >= FEWEST:
                by_model[model] = law
        return by_model

    def rows(self) -> list[dict[str, Any]]:
        """Return the ladder's rows of `--json`."""
        first = self.measures[0].name
        return [
            {
                "ladder": self.name,
                "model": measurement.model,
                "setting": measurement.setting,
                "unknowns": measurement.unknowns,
                "seconds": measurement.seconds,
                "error": measurement.errors.get(first),
                "errors": measurement.errors,
                "spread_s": measurement.spread,
                "repeats": len(measurement.runs),
            }
            for measurement in self.trials
        ]

    def reference(self) -> dict[str, Any]:
        """Return what the trials are held against, by measure, and what was skipped."""
        measures = {
            m.name: {
                "error": m.what,
                "unit": m.unit,
                "reference": m.reference,
                "checked": m.checked,
                "own_error": m.floor,
                "times_compare_between_models": m.compares,
            }
            for m in self.measures
        }
        matched = {
            m.name: [
                {
                    "error": error,
                    "seconds": {measurement.model: measurement.seconds for measurement in trials},
                }
                for error, trials in self.matched(m).items()
            ]
            for m in self.measures
        }
        return {**measures, "skipped": self.skipped, "at_matched_error": matched}


class LadderModule(Protocol):
    """A ladder's module."""

    def ladder(self, design: Design, repeats: int, progress: Progress | None) -> Ladder:
        """Return the ladder of a design, each trial timed `repeats` times."""

    def prices(self, design: Design, repeats: int) -> dict[str, float]:
        """Return what is told as progress and about how many s it takes, in the order in which it comes."""


def ladder_of(name: str) -> LadderModule:
    """Import and return a ladder by name; raises InputError for an unknown one."""
    if name not in LADDERS:
        raise InputError("ladders", "unknown ladder", name, did_you_mean(name, LADDERS))
    return cast(LadderModule, import_module(LADDERS[name]))


def repeated(seconds: float, repeats: int) -> float:
    """Return how long `timed` takes for work of these seconds."""
    return seconds if seconds > LONG else seconds * (repeats + (seconds < SHORT))


def timed(work: Callable[[], Value], repeats: int) -> tuple[Value, tuple[float, ...]]:
    """Return what `work` gives and the wall time of each run, s; what takes longer than LONG runs once."""
    runs: list[float] = []
    warm = False
    while True:
        safe_point()
        began = perf_counter()
        result = work()
        runs.append(perf_counter() - began)
        if not warm and runs[0] < SHORT:
            runs.clear()
        elif len(runs) >= repeats or runs[0] > LONG:
            return result, tuple(runs)
        warm = True
