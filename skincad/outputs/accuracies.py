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


def lines(accuracy: Accuracy) -> list[str]:
    """Return the table of each ladder, the references, and the machine."""
    machine, versions = accuracy.machine, accuracy.machine["versions"]
    rows = [line for ladder in accuracy.ladders for line in ladder_lines(ladder)]
    load = "" if machine["load"] is None else f", load {machine['load']:g}"
    return [
        *rows,
        f"On {machine['processor']}, {machine['cores']} cores{load}, Python {machine['python']}, "
        + ", ".join(f"{name} {version}" for name, version in versions.items()),
        f"Times are medians of {accuracy.repeats} runs, ± half from the shortest to the longest; trials "
        f"that take long run once. The whole took {accuracy.seconds:.0f} s.",
    ]


def ladder_lines(ladder: Ladder) -> Iterator[str]:
    """A row a trial; a star marks the trials of the Pareto front in time and the first error."""
    measures = ladder.measures
    models = max((len(r.model) for r in ladder.trials), default=0)
    settings = max((len(r.setting) for r in ladder.trials), default=0)
    yield f"{ladder.name}: {ladder.title}"
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
    for m in measures:
        unit = "" if m.unit == "1" else f", {m.unit}"
        yield f"  {m.shown}: {m.what}{unit}; against {m.reference} ({m.checked})"
    yield from _matched_lines(ladder)
    for model, law in ladder.laws().items():
        off = f"within a factor of {law.scatter:.2f}"
        yield f"  time of {model}: {law.factor:.2g} s x unknowns^{law.exponent:.2f}, {off}"
    yield from (f"  not {name}: {why}" for name, why in ladder.skipped.items())
    if ladder.lines:
        yield "  * no other trial is both faster and better (of its model, where each has its own reference)"
    yield ""


def _matched_lines(ladder: Ladder) -> Iterator[str]:
    """Times of the models at equal errors, by the first measure that compares them; more is in the JSON."""
    measures = [measure for measure in ladder.measures if measure.compares]
    for measure, error, trials in ((m, *match) for m in measures[:1] for match in ladder.matched(m).items()):
        first, *others = trials
        more = (f"{r.model} {r.seconds:.2g} s ({r.seconds / first.seconds:.2g} times)" for r in others)
        aim = f"{measure.shown} {error:.0e}" + ("" if measure.unit == "1" else f" {measure.unit}")
        yield f"  {aim} takes {first.model} {first.seconds:.2g} s, {', '.join(more)}"


ACCURACY = Presentation(COMMAND=COMMAND, lines=lines, files=files, figures=figures)
