"""Output of a sweep: its best rows, a table as CSV and Parquet, pictures, and a page."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skincad.base.errors import InputError
from skincad.base.reading import csv_text
from skincad.base.result import Writer
from skincad.outputs.delivery import picture, text
from skincad.studies.query import Evaluation, short, worded
from skincad.studies.subject import changed
from skincad.studies.sweeping import Ranking, SweepResult

if TYPE_CHECKING:
    from skincad.pictures.canvas import Picture

COMMAND = "sweep"
PAGE = "study.html"
MAX_BEST_ROWS, MAX_REASONS = 5, 3  # best rows, and reasons of refusals, in words
NUMBER = re.compile(r"\d[\d.e+-]*")
MAX_TIED_ROWS = 12  # rows of a tie that are listed by number


def names() -> list[str]:
    """Return the names of what may be written."""
    return ["sweep.csv", "sweep.parquet", "effects.png", "pairs.png", "front.png", PAGE]


def lines(sweep: SweepResult) -> list[str]:
    """Return what `sweep` prints."""
    count, model = len(sweep.rows), sweep.question.tier
    rows = [f"{sweep.name}: {count} rows{f' by {model}' if model else ''}, {_verdicts(sweep)}."]
    for ranking in sweep.rankings:
        rows += _ranking_lines(sweep, ranking)
    if sweep.next_tier:
        tier, seconds = sweep.next_tier
        cost = f"its {len(sweep.rankings[0].ties[0])} rows take about {seconds:.2g} s"
        rows.append(f"  finer          --tier {tier} may settle the first tie: {cost}")
    rows += _refusals([row for row in sweep.rows if row.refused])
    rows.append(
        f"  tried          {sweep.evaluations} evaluations, {sweep.reused} reused, {sweep.seconds:.3g} s"
    )
    return rows


def _verdicts(sweep: SweepResult) -> str:
    parts = [f"{sum(bool(row.passed) for row in sweep.rows if not row.refused)} pass"]
    if all(row.passed is None for row in sweep.rows):
        parts = [f"{len(sweep.rows) - sweep.refused} answered"]
    return ", ".join([*parts, f"{sweep.refused} refused"])


def _ranking_lines(sweep: SweepResult, ranking: Ranking) -> list[str]:
    word = "smallest" if ranking.goal == "min" else "largest"
    if not ranking.ranks:
        return [f"  best           no row has {ranking.key}"]
    rows = []
    for place, rank in enumerate(ranking.ranks[:MAX_BEST_ROWS], 1):
        row = sweep.rows[rank.row - 1]
        values = ", ".join(f"{key} {short(value)}" for key, value in row.values.items())
        head = f"{word} {place}".ljust(14)
        rows.append(
            f"  {head} {worded(ranking.key, row.results[ranking.key])}: {values} (row {rank.row}, "
            f"surely better than {rank.wins})"
        )
    if ranking.ties and ranking.ranks[0].row in ranking.ties[0]:
        tie = ranking.ties[0]
        others = (
            f"rows {', '.join(map(str, tie[1:]))}"
            if len(tie) <= MAX_TIED_ROWS
            else f"the next {len(tie) - 1}"
        )
        others = f"row {tie[1]}" if len(tie) == 2 else others
        rows.append(f"  tie            row {tie[0]} is not surely better than {others}")
    return rows


def _refusals(refused: list[Evaluation]) -> list[str]:
    """Return the most frequent reasons, in the words of their first row: others' numbers may differ."""
    first: dict[str, str] = {}
    kinds = [NUMBER.sub("", row.refused.partition(", got ")[0]) for row in refused]
    for kind, row in zip(kinds, refused, strict=True):
        first.setdefault(kind, row.refused)
    return [
        f"  refused        {count}{'; the first' if count > 1 else ''}: {first[kind]}"
        for kind, count in Counter(kinds).most_common(MAX_REASONS)
    ]


def table(sweep: SweepResult) -> tuple[list[str], list[list[Any]]]:
    """Return the head and rows of the table: number, values, verdict, results with their errors."""
    head = ["row", *(knob.key for knob in sweep.knobs), "passed", "refused", "tier"]
    errors = {key for key in sweep.keys if any(_error(row, key) is not None for row in sweep.rows)}
    columns = [name for key in sweep.keys for name in ([key, f"{key}.error"] if key in errors else [key])]
    rows = []
    for number, row in enumerate(sweep.rows, 1):
        cells = {key: row.results[key].value for key in sweep.keys if key in row.results}
        cells |= {f"{key}.error": _error(row, key) for key in errors}
        values = [row.values[knob.key] for knob in sweep.knobs]
        rows.append([number, *values, row.passed, row.refused or None, row.tier, *map(cells.get, columns)])
    return [*head, *columns], rows


def _error(row: Evaluation, key: str) -> float | None:
    estimate = row.results.get(key)
    return None if estimate is None else estimate.error


def sweep_csv(sweep: SweepResult) -> str:
    """Return the table as CSV; a missing value is empty."""
    head, rows = table(sweep)
    return csv_text([head, *rows])


def _write_parquet(sweep: SweepResult, path: Path) -> None:
    import pyarrow
    from pyarrow import parquet

    head, rows = table(sweep)
    columns = {name: [row[i] for row in rows] for i, name in enumerate(head)}
    parquet.write_table(pyarrow.table(columns), path)


def sweep_page(
    sweep: SweepResult, words: list[str] | None = None, *, title: str = "", aims: Sequence[str] = ()
) -> str:
    """Return the page of all rows, with each one's design to copy, under `words`, the sweep's if None.

    Columns of what is varied come first, then of `aims`, of a sweep what it is ranked by; columns without
    anything are left out.
    """
    from skincad.pictures.study_page import page

    head, rows = table(sweep)
    first = [
        "row",
        *(knob.key for knob in sweep.knobs),
        *(aims or [ranking.key for ranking in sweep.rankings]),
    ]
    shown = [name for name in dict.fromkeys([*first, *head]) if name in head and not name.endswith(".error")]
    shown = [name for name in shown if any(row[head.index(name)] not in (None, "") for row in rows)]
    plotted = [name for name in first[1:] if name in shown]
    data = {
        "head": shown,
        "rows": [[row[head.index(name)] for name in shown] for row in rows],
        "refused": [bool(row.refused) for row in sweep.rows],
        "designs": [_design(sweep, row) for row in sweep.rows],
        "x": shown.index(sweep.knobs[0].key),
        "y": shown.index(plotted[min(len(sweep.knobs), len(plotted) - 1)]),
    }
    title = f"{title or sweep.name}: {len(sweep.rows)} rows"
    return page(title, "\n".join(words or lines(sweep)), data)


def _design(sweep: SweepResult, row: Evaluation) -> str:
    """A row's design as TOML, or why there is none."""
    try:
        return changed(sweep.subject, row.values).to_toml()
    except InputError as refused:
        return f"# {refused}"


def manifest(sweep: SweepResult) -> dict[str, Any]:
    """Return what the manifest says of the result: all but its rows, which the table has."""
    return {key: value for key, value in sweep.as_json().items() if key != "rows"}


def figures(sweep: SweepResult) -> dict[str, Callable[[], Picture]]:
    """Return main effects and pairs of the first ranking's result, and the front of the first two."""
    if not sweep.rankings or len(sweep.rankings[0].ranks) < 2:
        return {}
    from skincad.pictures.study_figures import effects_figure, front_figure, pairs_figure

    drawings: dict[str, Callable[[], Picture]] = {"effects.png": partial(effects_figure, sweep)}
    if len(sweep.knobs) > 1:
        drawings["pairs.png"] = partial(pairs_figure, sweep)
    if len(sweep.rankings) > 1:
        drawings["front.png"] = partial(front_figure, sweep)
    return drawings


def files(sweep: SweepResult) -> dict[str, Writer]:
    """Return the writer of each file; Parquet where pyarrow is installed."""
    writers: dict[str, Writer] = {"sweep.csv": text(lambda: sweep_csv(sweep))}
    if find_spec("pyarrow") is not None:
        writers["sweep.parquet"] = partial(_write_parquet, sweep)
    writers[PAGE] = text(lambda: sweep_page(sweep))
    return {**writers, **{name: picture(draw) for name, draw in figures(sweep).items()}}
