"""What a sweep says and leaves: its best rows, a table as CSV and Parquet, pictures, and a page."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skincad.base.errors import InputError
from skincad.base.plain import csv_text
from skincad.base.result import Writer
from skincad.outputs.delivery import picture, text
from skincad.studies.asking import short
from skincad.studies.measures import worded
from skincad.studies.question import Evaluation
from skincad.studies.ranking import Ranking
from skincad.studies.subject import changed
from skincad.studies.sweeping import SweepResult

if TYPE_CHECKING:
    from skincad.pictures.canvas import Picture

COMMAND = "sweep"
PAGE = "study.html"
SHOWN, REASONS = 5, 3  # best rows, and reasons of refusals, in words
NUMBER = re.compile(r"\d[\d.e+-]*")
MANY = 12  # rows of a tie that are told by their numbers


def names() -> list[str]:
    """Return the names of what may be written."""
    return ["sweep.csv", "sweep.parquet", "effects.png", "pairs.png", "front.png", PAGE]


def lines(found: SweepResult) -> list[str]:
    """Return what `sweep` prints."""
    count, model = len(found.rows), found.question.tier
    told = [f"{found.name}: {count} rows{f' by {model}' if model else ''}, {_verdicts(found)}."]
    for ranking in found.rankings:
        told += _ranking_lines(found, ranking)
    if found.next_tier:
        tier, seconds = found.next_tier
        rows = f"its {len(found.rankings[0].ties[0])} rows take about {seconds:.2g} s"
        told.append(f"  finer          --tier {tier} may settle the first tie: {rows}")
    told += _refusals([row for row in found.rows if row.refused])
    told.append(
        f"  tried          {found.evaluations} evaluations, {found.reused} reused, {found.seconds:.3g} s"
    )
    return told


def _verdicts(found: SweepResult) -> str:
    parts = [f"{sum(bool(row.passed) for row in found.rows if not row.refused)} pass"]
    if all(row.passed is None for row in found.rows):
        parts = [f"{len(found.rows) - found.refused} answered"]
    return ", ".join([*parts, f"{found.refused} refused"])


def _ranking_lines(found: SweepResult, ranking: Ranking) -> list[str]:
    word = "smallest" if ranking.goal == "min" else "largest"
    if not ranking.ranks:
        return [f"  best           no row has {ranking.key}"]
    told = []
    for place, rank in enumerate(ranking.ranks[:SHOWN], 1):
        row = found.rows[rank.row - 1]
        values = ", ".join(f"{key} {short(value)}" for key, value in row.values.items())
        head = f"{word} {place}".ljust(14)
        told.append(
            f"  {head} {worded(ranking.key, row.results[ranking.key])}: {values} (row {rank.row}, "
            f"surely better than {rank.wins})"
        )
    if ranking.ties and ranking.ranks[0].row in ranking.ties[0]:
        tie = ranking.ties[0]
        others = f"rows {', '.join(map(str, tie[1:]))}" if len(tie) <= MANY else f"the next {len(tie) - 1}"
        others = f"row {tie[1]}" if len(tie) == 2 else others
        told.append(f"  tie            row {tie[0]} is not surely better than {others}")
    return told


def _refusals(refused: list[Evaluation]) -> list[str]:
    """Return the most frequent reasons, in the words of their first row: others' numbers may differ."""
    first: dict[str, str] = {}
    kinds = [NUMBER.sub("", row.refused.partition(", got ")[0]) for row in refused]
    for kind, row in zip(kinds, refused, strict=True):
        first.setdefault(kind, row.refused)
    return [
        f"  refused        {count}{'; the first' if count > 1 else ''}: {first[kind]}"
        for kind, count in Counter(kinds).most_common(REASONS)
    ]


def table(found: SweepResult) -> tuple[list[str], list[list[Any]]]:
    """Return the head and rows of the table: number, values, verdict, results with their errors."""
    head = ["row", *(knob.key for knob in found.knobs), "passed", "refused", "tier"]
    errors = {key for key in found.keys if any(_error(row, key) is not None for row in found.rows)}
    columns = [name for key in found.keys for name in ([key, f"{key}.error"] if key in errors else [key])]
    rows = []
    for number, row in enumerate(found.rows, 1):
        told = {key: row.results[key].value for key in found.keys if key in row.results}
        told |= {f"{key}.error": _error(row, key) for key in errors}
        values = [row.values[knob.key] for knob in found.knobs]
        rows.append([number, *values, row.passed, row.refused or None, row.tier, *map(told.get, columns)])
    return [*head, *columns], rows


def _error(row: Evaluation, key: str) -> float | None:
    found = row.results.get(key)
    return None if found is None else found.error


def sweep_csv(found: SweepResult) -> str:
    """Return the table as CSV; what a row has not is empty."""
    head, rows = table(found)
    return csv_text([head, *rows])


def _write_parquet(found: SweepResult, path: Path) -> None:
    import pyarrow
    from pyarrow import parquet

    head, rows = table(found)
    columns = {name: [row[i] for row in rows] for i, name in enumerate(head)}
    parquet.write_table(pyarrow.table(columns), path)


def sweep_page(
    found: SweepResult, words: list[str] | None = None, *, title: str = "", aims: Sequence[str] = ()
) -> str:
    """Return the page of all rows, with each one's design to copy, under `words`, the sweep's if None.

    Columns of what is varied come first, then of `aims`, of a sweep what it is ranked by; columns without
    anything are left out.
    """
    from skincad.pictures.study_page import page

    head, rows = table(found)
    first = ["row", *(knob.key for knob in found.knobs), *(aims or [each.key for each in found.rankings])]
    shown = [name for name in dict.fromkeys([*first, *head]) if name in head and not name.endswith(".error")]
    shown = [name for name in shown if any(row[head.index(name)] not in (None, "") for row in rows)]
    plotted = [name for name in first[1:] if name in shown]
    data = {
        "head": shown,
        "rows": [[row[head.index(name)] for name in shown] for row in rows],
        "refused": [bool(row.refused) for row in found.rows],
        "designs": [_design(found, row) for row in found.rows],
        "x": shown.index(found.knobs[0].key),
        "y": shown.index(plotted[min(len(found.knobs), len(plotted) - 1)]),
    }
    title = f"{title or found.name}: {len(found.rows)} rows"
    return page(title, "\n".join(words or lines(found)), data)


def _design(found: SweepResult, row: Evaluation) -> str:
    """A row's design as TOML, or why there is none."""
    try:
        return changed(found.subject, row.values).to_toml()
    except InputError as refused:
        return f"# {refused}"


def manifest(found: SweepResult) -> dict[str, Any]:
    """Return what the manifest says of the result: all but its rows, which the table has."""
    return {key: value for key, value in found.as_json().items() if key != "rows"}


def figures(found: SweepResult) -> dict[str, Callable[[], Picture]]:
    """Return main effects and pairs of the first ranking's result, and the front of the first two."""
    if not found.rankings or len(found.rankings[0].ranks) < 2:
        return {}
    from skincad.pictures.study_figures import effects_figure, front_figure, pairs_figure

    drawn: dict[str, Callable[[], Picture]] = {"effects.png": partial(effects_figure, found)}
    if len(found.knobs) > 1:
        drawn["pairs.png"] = partial(pairs_figure, found)
    if len(found.rankings) > 1:
        drawn["front.png"] = partial(front_figure, found)
    return drawn


def files(found: SweepResult) -> dict[str, Writer]:
    """Return the writer of each file; Parquet where pyarrow is installed."""
    written: dict[str, Writer] = {"sweep.csv": text(lambda: sweep_csv(found))}
    if find_spec("pyarrow") is not None:
        written["sweep.parquet"] = partial(_write_parquet, found)
    written[PAGE] = text(lambda: sweep_page(found))
    return {**written, **{name: picture(draw) for name, draw in figures(found).items()}}
