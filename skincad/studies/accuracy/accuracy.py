"""The accuracy study of a design: all ladders."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter
from typing import Any

from skincad.base.errors import require_number
from skincad.base.machine import machine
from skincad.base.progress import Progress
from skincad.base.result import Result, columns_of, item, record, reported
from skincad.inputs.design import Design
from skincad.studies.accuracy.ladder import LADDERS, Countdown, Ladder, ladder_of

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

    @reported(meaning="wall time, s", key="seconds")
    def _seconds(self) -> dict[str, float]:
        return {"total": self.seconds}


def accuracy(
    design: Design, ladders: Sequence[str] = (), *, repeats: int = 3, progress: Progress | None = None
) -> Accuracy:
    """Return ladders (all if none is named) of a design, each trial timed `repeats` times.

    Raises InputError for an unknown ladder and for repeats out of range.
    """
    rule = f"must be from 1 to {MOST_REPEATS}"
    require_number("repeats", repeats, lambda value: 1 <= value <= MOST_REPEATS, rule)
    began = perf_counter()
    modules = [ladder_of(name) for name in dict.fromkeys(ladders or LADDERS)]
    if progress:
        prices = {stage: s for module in modules for stage, s in module.prices(design, repeats).items()}
        progress = Countdown(prices, progress)
    results = tuple(module.ladder(design, repeats, progress) for module in modules)
    return Accuracy(
        name=design.name, ladders=results, machine=machine(), repeats=repeats, seconds=perf_counter() - began
    )
