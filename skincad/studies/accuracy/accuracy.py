"""The accuracy study of a design: all ladders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from importlib import import_module
from time import perf_counter
from typing import Any

from skincad.base.errors import InputError, did_you_mean, require_number
from skincad.base.machine import machine
from skincad.base.progress import Progress
from skincad.base.result import Result, columns_of, item, record, reported
from skincad.inputs.design import Design
from skincad.shape.skin import skin_of
from skincad.studies.accuracy.ladder import Ladder
from skincad.studies.query import total_seconds

# each a module beside this one; s that it takes on a skin of RIDGES: once, and for each repeat; measured
LADDERS = {
    "tessellation": (5.0, 0.0),
    "contact": (42.0, 10.0),
    "circuit": (0.1, 0.1),
    "slip": (40.0, 8.5),
    "effects": (125.0, 0.0),
}
RIDGES = 9
PRIOR = 2.0  # s that were as expected before anything is measured: one short ladder says little of a machine
MOST_REPEATS = 100


@record()
class Accuracy(Result):
    """The ladders of a design, on what machine, and the seconds of the whole."""

    shown_by = "skincad.outputs.studies:ACCURACY"
    name: str = item(meaning="of the design")
    ladders: tuple[Ladder, ...]
    machine: dict[str, Any] = item(meaning="on which times were taken")
    repeats: int = item(meaning="of each timed run")
    seconds: float  # wall time of the whole

    @reported(meaning="a model or mesh each: unknowns, seconds, errors")
    def rows(self) -> list[dict[str, Any]]:
        """Rows of all ladders."""
        return [row for ladder in self.ladders for row in ladder.rows()]

    def columns(self) -> dict[str, Any]:
        """Return a row for each trial; `errors.NAME` is the error by this measure, in its unit of
        `reference`."""
        return columns_of(self.rows)

    @reported(meaning="what errors are against, by ladder")
    def reference(self) -> dict[str, Any]:
        """What errors are against, by ladder."""
        return {ladder.name: ladder.reference() for ladder in self.ladders}

    @reported(meaning="seconds as a power of the unknowns, by ladder and model")
    def time_laws(self) -> dict[str, Any]:
        """Seconds as a power of the unknowns, by ladder and model."""
        return {ladder.name: ladder.laws() for ladder in self.ladders}

    _seconds = total_seconds


def accuracy(
    design: Design, ladders: Sequence[str] = (), *, repeats: int = 3, progress: Progress | None = None
) -> Accuracy:
    """Return ladders (all if none is named) of a design, each trial timed `repeats` times.

    Raises InputError for an unknown ladder and for repeats out of range.
    """
    rule = f"must be from 1 to {MOST_REPEATS}"
    require_number("repeats", repeats, lambda value: 1 <= value <= MOST_REPEATS, rule)
    names = list(dict.fromkeys(ladders or LADDERS))
    for name in names:
        if name not in LADDERS:
            raise InputError("ladders", "unknown ladder", name, did_you_mean(name, LADDERS))
    began, results = perf_counter(), list[Ladder]()
    modules = [import_module(f"skincad.studies.accuracy.{name}") for name in names]
    size = skin_of(design).count / RIDGES
    prices = [size * (once + repeats * again) for once, again in map(LADDERS.__getitem__, names)]
    since = [perf_counter()]  # at which each ladder began

    def tell(stage: str) -> None:
        """Say what is done, and the s to the end of all: slower or faster than expected, as it was so far."""
        spent, prices_left = math.fsum(prices[: len(results)]), math.fsum(prices[len(results) :])
        left = (PRIOR + since[-1] - since[0]) / (PRIOR + spent) * prices_left - (perf_counter() - since[-1])
        if progress:
            progress(f"{names[len(results)]}: {stage}", max(left, 0.0))

    for module in modules:
        results.append(module.ladder(design, repeats, tell))
        since.append(perf_counter())
    seconds = perf_counter() - began
    return Accuracy(
        name=design.name, ladders=tuple(results), machine=machine(), repeats=repeats, seconds=seconds
    )
