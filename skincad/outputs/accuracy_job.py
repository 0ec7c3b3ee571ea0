"""The job of `skincad accuracy`: ladders climbed on one design, their table and diagrams in one folder."""

from __future__ import annotations

import csv
import io
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from skincad.base.errors import InputError
from skincad.base.outfolder import checked_folder, replaced
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.ladders.countdown import Countdown
from skincad.ladders.ladder import LADDERS, Ladder, ladder_of
from skincad.ladders.machine import machine

MOST_REPEATS = 100
TABLE = "accuracy.csv"
COLUMNS = ("ladder", "model", "setting", "unknowns", "seconds", "spread_s", "repeats")


@dataclass(frozen=True)
class Accuracy:
    """The ladders of a design, on what machine, and the seconds of the whole."""

    name: str
    ladders: tuple[Ladder, ...]
    machine: dict[str, Any]
    repeats: int
    seconds: float

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
            "machine": self.machine,
            "repeats": self.repeats,
            "seconds": {"total": self.seconds},
        }


def accuracy(
    design: Design, names: tuple[str, ...] = (), *, repeats: int = 3, progress: Progress | None = None
) -> Accuracy:
    """Return the ladders of these names (all if none) climbed on a design, each rung timed `repeats` times.

    Raises InputError for an unknown ladder and for repeats out of range.
    """
    if not 1 <= repeats <= MOST_REPEATS:
        raise InputError("--repeats", f"must be from 1 to {MOST_REPEATS}", repeats)
    began = perf_counter()
    climbs = [ladder_of(name) for name in dict.fromkeys(names or LADDERS)]
    if progress:
        prices = {stage: s for climb in climbs for stage, s in climb.prices(design, repeats).items()}
        progress = Countdown(prices, progress)
    found = tuple(climb.ladder(design, repeats, progress) for climb in climbs)
    return Accuracy(design.name, found, machine(), repeats, perf_counter() - began)


def accuracy_job(
    design: Design,
    names: tuple[str, ...] = (),
    folder: Path | str | None = None,
    *,
    repeats: int = 3,
    progress: Progress | None = None,
) -> tuple[Accuracy, list[dict[str, str | int]]]:
    """Return the ladders of a design and the files written into `folder` (default out/<name>).

    accuracy.csv and a diagram a ladder, whole or not at all. Raises InputError for bad input.
    """
    target = Path("out") / design.name if folder is None else Path(folder)
    checked_folder(target, "accuracy", [TABLE, *map(_picture, names or LADDERS)])
    found = accuracy(design, names, repeats=repeats, progress=progress)
    from skincad.pictures.ladder_figures import diagram

    with replaced(target, "accuracy", found.as_json()) as staging:
        (staging / TABLE).write_text(table(found), encoding="utf-8")
        for ladder in found.ladders:
            diagram(ladder, found.machine, staging / _picture(ladder.name))
        sizes = {path.name: path.stat().st_size for path in sorted(staging.iterdir())}
    return found, [{"path": str(target / name), "bytes": size} for name, size in sizes.items()]


def _picture(ladder: str) -> str:
    return f"accuracy-{ladder}.png"


def table(found: Accuracy) -> str:
    """Return all rows as CSV; a measure is a column, empty where a rung is not judged by it."""
    measures = [f"{ladder.name}: {m.name}" for ladder in found.ladders for m in ladder.measures]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*COLUMNS, *measures])
    for ladder in found.ladders:
        for row in ladder.rows():
            errors = {f"{ladder.name}: {name}": f"{error:.4g}" for name, error in row["errors"].items()}
            cells = [row[c] if not isinstance(row[c], float) else f"{row[c]:.6g}" for c in COLUMNS]
            writer.writerow([*cells, *(errors.get(m, "") for m in measures)])
    return text.getvalue()
