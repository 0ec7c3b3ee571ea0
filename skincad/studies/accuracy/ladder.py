"""Work-precision studies: models at ever finer settings, their errors and their time."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, TypeVar

import numpy as np

from skincad.base.interrupt import safe_point

Value = TypeVar("Value")
LONG = 2.0  # s; what takes longer is run once, or the whole would take a coffee break
SHORT = 0.5  # s; what takes less is run once more before, for its first run fills caches
MOST_DIGITS = 13  # beyond are rounding's
FEWEST = 3  # sizes that a law of time is drawn through


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


@dataclass(frozen=True)
class PowerLaw:
    """seconds = factor x unknowns^exponent; `scatter` is the rms of the fit's ratio, 1 where it is exact."""

    factor: float
    exponent: float
    scatter: float


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
        """Return the trials, by time, that no other beats in both time and this error: of all trials, or of
        its own model where each aims at its own truth; none where no line joins them."""
        judged = [trial for trial in self.trials if measure.name in trial.errors and self.lines]
        fastest: dict[str, list[Measurement]] = {}
        for trial in sorted(judged, key=lambda trial: (trial.seconds, trial.errors[measure.name])):
            group = fastest.setdefault("" if measure.compares else trial.model, [])
            if not group or trial.errors[measure.name] < group[-1].errors[measure.name]:
                group.append(trial)
        order = [""] if measure.compares else dict.fromkeys(trial.model for trial in judged)
        return [trial for model in order for trial in fastest.get(model, ())]

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
            for trial in sorted(self.trials, key=lambda trial: trial.seconds):
                if trial.errors.get(measure.name, math.inf) <= error and error > measure.floor:
                    cheapest.setdefault(trial.model, trial)
            group = list(cheapest.values())
            if len(group) > 1 and group not in rows.values():
                rows[error] = group
        return rows

    def laws(self) -> dict[str, PowerLaw]:
        """Return time against unknowns by model, where it has three trials of different size: least squares
        of the logarithms."""
        by_model: dict[str, list[tuple[int, float]]] = {}
        for trial in self.trials if self.lines else ():
            by_model.setdefault(trial.model, []).append((trial.unknowns, trial.seconds))
        laws = {}
        for model, points in by_model.items():
            if len({unknowns for unknowns, _ in points}) >= FEWEST:
                x, y = np.log(np.array(points, float)).T
                exponent, level = np.polyfit(x, y, 1)
                off = y - (exponent * x + level)
                scatter = np.exp(np.sqrt(np.mean(off**2)))
                laws[model] = PowerLaw(float(np.exp(level)), float(exponent), float(scatter))
        return laws

    def rows(self) -> list[dict[str, Any]]:
        """Return the ladder's rows of `--json`."""
        first = self.measures[0].name
        return [
            {
                "ladder": self.name,
                **{key: getattr(trial, key) for key in ("model", "setting", "unknowns", "seconds")},
                "error": trial.errors.get(first),
                "errors": trial.errors,
                "spread_s": max(trial.runs) - min(trial.runs),
                "repeats": len(trial.runs),
            }
            for trial in self.trials
        ]

    def reference(self) -> dict[str, Any]:
        """Return what the trials are held against, by measure, and what was skipped."""
        measures, matched = dict[str, Any](), dict[str, Any]()
        for m in self.measures:
            facts = {"error": m.what, "unit": m.unit, "reference": m.reference, "checked": m.checked}
            measures[m.name] = {**facts, "own_error": m.floor, "times_compare_between_models": m.compares}
            matched[m.name] = [
                {"error": error, "seconds": {trial.model: trial.seconds for trial in trials}}
                for error, trials in self.matched(m).items()
            ]
        return {**measures, "skipped": self.skipped, "at_matched_error": matched}
