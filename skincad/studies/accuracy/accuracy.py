"""The accuracy study of a design: all ladders, and the cost model from what was timed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from time import perf_counter
from typing import Any

from skincad.base.errors import require_number
from skincad.base.machine import machine
from skincad.base.progress import Progress
from skincad.base.result import Result
from skincad.inputs.design import Design
from skincad.mechanics.models.table import ModelTiming, save_timings, without_home
from skincad.studies.accuracy.ladder import LADDERS, Countdown, Ladder, ladder_of

MOST_REPEATS = 100


@dataclass(frozen=True, repr=False)
class Accuracy(Result):
    """The ladders of a design, on what machine, and the seconds of the whole."""

    shown_by = "skincad.outputs.accuracies"
    name: str
    ladders: tuple[Ladder, ...]
    machine: dict[str, Any]
    repeats: int
    seconds: float
    cache_note: str = ""  # in words, where what the models took is kept

    @property
    def taken(self) -> dict[str, ModelTiming]:
        """What each model's own part took."""
        return {model: one for ladder in self.ladders for model, one in ladder.timings.items()}

    def keep(self) -> Accuracy:
        """Keep what the models took in the user's cache folder, for the laws of time that `check` chooses by;
        return the result that says where, or why not. Nothing where no model was timed."""
        if not self.taken:
            return self
        try:
            path = save_timings(self.name, self.taken)
        except (OSError, RuntimeError) as failure:
            # without the path, which may tell a user's name
            why = getattr(failure, "strerror", None) or failure
            return replace(self, cache_note=f"the cost law is not kept: {why}")
        load, cores = self.machine["load"], self.machine["cores"]
        busy = f"; with a load of {load} on {cores} cores it is too slow, run it again at rest"
        note = f"cost law kept in {without_home(path)}; delete it to forget it"
        return replace(self, cache_note=note + (busy if load and load > 1.5 * cores else ""))

    def as_json(self) -> dict[str, Any]:
        """Return the result under the contract's keys."""
        return {
            "name": self.name,
            "rows": [row for ladder in self.ladders for row in ladder.rows()],
            "reference": {ladder.name: ladder.reference() for ladder in self.ladders},
            "time_laws": {
                ladder.name: {model: asdict(law) for model, law in ladder.laws().items()}
                for ladder in self.ladders
            },
            "cost_law": {
                "taken": {model: one.model_dump() for model, one in self.taken.items()},
                "kept": self.cache_note,
            },
            "machine": self.machine,
            "repeats": self.repeats,
            "seconds": {"total": self.seconds},
        }


def accuracy(
    design: Design, ladders: Sequence[str] = (), *, repeats: int = 3, progress: Progress | None = None
) -> Accuracy:
    """Return ladders (all if none is named) climbed on a design, each trial timed `repeats` times.

    Raises InputError for an unknown ladder and for repeats out of range.
    """
    rule = f"must be from 1 to {MOST_REPEATS}"
    require_number("repeats", repeats, lambda value: 1 <= value <= MOST_REPEATS, rule)
    began = perf_counter()
    climbs = [ladder_of(name) for name in dict.fromkeys(ladders or LADDERS)]
    if progress:
        prices = {stage: s for climb in climbs for stage, s in climb.prices(design, repeats).items()}
        progress = Countdown(prices, progress)
    results = tuple(climb.ladder(design, repeats, progress) for climb in climbs)
    return Accuracy(design.name, results, machine(), repeats, perf_counter() - began)
