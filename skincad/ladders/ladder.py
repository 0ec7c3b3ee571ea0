"""Ladders: rungs with their price and error, what they are held against, and the table of all there are."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from time import perf_counter
from typing import Any, Protocol, TypeVar, cast

from skincad.base.errors import InputError, did_you_mean
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.ladders.precision import PowerLaw, front, power_law

Found = TypeVar("Found")
LONG = 2.0  # s; what takes longer is run once, or the whole would take a coffee break
SHORT = 0.5  # s; what takes less is run once more before, for its first run fills caches
MOST_DIGITS = 13  # beyond are rounding's
FEWEST = 3  # sizes that a law of time is drawn through
_ROOM = "skincad.ladders."
LADDERS = {
    "tessellation": f"{_ROOM}tessellation",
    "contact": f"{_ROOM}contact",
    "circuit": f"{_ROOM}circuit",
    "slip": f"{_ROOM}slip",
    "effects": f"{_ROOM}effects",
}


@dataclass(frozen=True)
class Measure:
    """An error that every rung is judged by: `what` in `unit` ("1" is relative), `reference` is held to be
    true, `checked` says how that is known.

    `compares` says whether all rungs aim at one reference, so that their times may be compared at equal
    error; where each model aims at its own, only rungs of one model may. `floor` is the reference's own
    error, below which differences say nothing.
    """

    name: str
    what: str
    unit: str
    reference: str
    checked: str
    compares: bool = True
    floor: float = 0.0


@dataclass(frozen=True)
class Rung:
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

    `lines` says whether rungs of a model are steps of one method; `skipped` why a rung is not there.
    """

    name: str
    title: str
    rungs: tuple[Rung, ...]
    measures: tuple[Measure, ...]
    lines: bool = True
    skipped: dict[str, str] = field(default_factory=dict)

    def best(self, measure: Measure) -> list[Rung]:
        """Return the rungs that no other beats in both time and this error: of all rungs, or of its own model
        where each aims at its own truth; none where no line joins them."""
        judged = [rung for rung in self.rungs if measure.name in rung.errors] if self.lines else []
        models = dict.fromkeys(rung.model for rung in judged)
        groups = [judged] if measure.compares else [[r for r in judged if r.model == m] for m in models]
        found: list[Rung] = []
        for group in groups:
            errors = [rung.errors[measure.name] for rung in group]
            found += [group[i] for i in front([rung.seconds for rung in group], errors)]
        return found

    def matched(self, measure: Measure) -> dict[float, list[Rung]]:
        """Return the cheapest rung of each model that reaches an error, by error, cheapest first.

        Errors are powers of ten above the reference's own; those that fewer than two models reach, or that
        all reach by the same rungs as ten times the error, tell nothing and are left out.
        """
        told: dict[float, list[Rung]] = {}
        if not (self.lines and measure.compares):
            return told
        for error in (10.0**-n for n in range(1, MOST_DIGITS)):
            cheapest: dict[str, Rung] = {}
            for rung in sorted(self.rungs, key=lambda rung: rung.seconds):
                if rung.errors.get(measure.name, math.inf) <= error and error > measure.floor:
                    cheapest.setdefault(rung.model, rung)
            found = list(cheapest.values())
            if len(found) > 1 and found not in told.values():
                told[error] = found
        return told

    def laws(self) -> dict[str, PowerLaw]:
        """Return time against unknowns by model, where it has three rungs of different size."""
        found = {}
        for model in dict.fromkeys(rung.model for rung in self.rungs) if self.lines else ():
            mine = [rung for rung in self.rungs if rung.model == model]
            law = power_law([rung.unknowns for rung in mine], [rung.seconds for rung in mine])
            if law and len({rung.unknowns for rung in mine}) >= FEWEST:
                found[model] = law
        return found

    def rows(self) -> list[dict[str, Any]]:
        """Return the ladder's rows of `--json`."""
        first = self.measures[0].name
        return [
            {
                "ladder": self.name,
                "model": rung.model,
                "setting": rung.setting,
                "unknowns": rung.unknowns,
                "seconds": rung.seconds,
                "error": rung.errors.get(first),
                "errors": rung.errors,
                "spread_s": rung.spread,
                "repeats": len(rung.runs),
            }
            for rung in self.rungs
        ]

    def reference(self) -> dict[str, Any]:
        """Return what the rungs are held against, by measure, and what was skipped."""
        told = {
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
                {"error": error, "seconds": {rung.model: rung.seconds for rung in rungs}}
                for error, rungs in self.matched(m).items()
            ]
            for m in self.measures
        }
        return {**told, "skipped": self.skipped, "at_matched_error": matched}


class Climb(Protocol):
    """A ladder's module."""

    def ladder(self, design: Design, repeats: int, progress: Progress | None) -> Ladder:
        """Return the ladder climbed on a design, each rung timed `repeats` times."""

    def prices(self, design: Design, repeats: int) -> dict[str, float]:
        """Return what is told as progress and about how many s it takes, in the order in which it comes."""


def ladder_of(name: str) -> Climb:
    """Import and return a ladder by name; raises InputError for an unknown one."""
    if name not in LADDERS:
        raise InputError("ladders", "unknown ladder", name, did_you_mean(name, LADDERS))
    return cast(Climb, import_module(LADDERS[name]))


def repeated(seconds: float, repeats: int) -> float:
    """Return how long `timed` takes for work of these seconds."""
    return seconds if seconds > LONG else seconds * (repeats + (seconds < SHORT))


def timed(work: Callable[[], Found], repeats: int) -> tuple[Found, tuple[float, ...]]:
    """Return what `work` gives and the wall time of each run, s; what takes longer than LONG runs once."""
    runs: list[float] = []
    warm = False
    while True:
        began = perf_counter()
        found = work()
        runs.append(perf_counter() - began)
        if not warm and runs[0] < SHORT:
            runs.clear()
        elif len(runs) >= repeats or runs[0] > LONG:
            return found, tuple(runs)
        warm = True
