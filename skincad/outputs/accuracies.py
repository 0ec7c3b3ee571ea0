"""Output of the accuracy ladders: words, accuracy.csv, and a diagram of each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING

from skincad.base.reading import Cell, csv_text
from skincad.base.result import Writer
from skincad.outputs.delivery import Presentation, picture, text
from skincad.studies.accuracy.accuracy import Accuracy
from skincad.studies.accuracy.ladder import LADDERS, Ladder

if TYPE_CHECKING:
    from skincad.outputs.figures.canvas import Picture

COMMAND = "accuracy"
TABLE = "accuracy.csv"
COLUMNS = ("ladder", "model", "setting", "unknowns", "seconds", "spread_s", "repeats")


def names(ladders: Iterable[str]) -> list[str]:
    """Return the names of what will be written of these ladders, of all if there are none."""
    return [TABLE, *(f"accuracy-{name}.png" for name in list(ladders) or LADDERS)]


def figures(accuracy: Accuracy) -> dict[str, Callable[[], Picture]]:
    """Return the diagram of error against time of each ladder."""
    from skincad.outputs.figures.studies import diagram

    return {
        f"accuracy-{ladder.name}.png": partial(diagram, ladder, accuracy.machine)
        for ladder in accuracy.ladders
    }


def files(accuracy: Accuracy) -> dict[str, Writer]:
    """Return the writer of each file."""
    return {TABLE: text(lambda: table(accuracy))} | {
        n: picture(draw) for n, draw in figures(accuracy).items()
    }


def table(accuracy: Accuracy) -> str:
    """Return all rows as CSV; a measure is a column, empty where a trial does not have it."""
    measures = [f"{ladder.name}: {m.name}" for ladder in accuracy.ladders for m in ladder.measures]
    rows: list[list[Cell]] = [[*COLUMNS, *measures]]
    for ladder in accuracy.ladders:
        for row in ladder.rows():
            errors = {f"{ladder.name}: {name}": f"{error:.4g}" for name, error in row["errors"].items()}
            cells = [row[c] if not isinstance(row[c], float) else f"{row[c]:.6g}" for c in COLUMNS]
            rows.append([*cells, *map(errors.get, measures)])
    return csv_text(rows)


def _trial_table(ladder: Ladder) -> Iterator[str]:
    """A row a trial; a star marks the trials of the Pareto front in time and the first error."""
    measures = ladder.measures
    models = max((len(r.model) for r in ladder.trials), default=0)
    settings = max((len(r.setting) for r in ladder.trials), default=0)
    widths = {m.name: max(15, len(m.shown) + 2) for m in measures}
    heads = "".join(f"{m.shown:>{widths[m.name]}}" for m in measures)
    yield f"  {'model':{models}}  {'setting':{settings}} {'unknowns':>9} {'time, s':>9} {'±':>8} {heads}"
    best = {measure.name: ladder.best(measure) for measure in measures}
    for point in ladder.trials:
        cells = "".join(
            f"{point.errors[m.name]:>{widths[m.name] - 1}.2g}{'*' if point in best[m.name] else ' '}"
            if m.name in point.errors
            else " " * widths[m.name]
            for m in measures
        )
        yield (
            f"  {point.model:{models}}  {point.setting:{settings}} {point.unknowns:9d} {point.seconds:9.3g} "
            f"{point.spread / 2:8.1g} {cells}".rstrip()
        )


ACCURACY = Presentation(
    COMMAND=COMMAND, words="accuracy.txt", facts={"trial_table": _trial_table}, files=files, figures=figures
)
