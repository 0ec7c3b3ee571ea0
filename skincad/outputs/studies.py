"""Output of studies: a design for a wish, what reaches the target of `solve`, the rows of `sweep`, the front
of `optimise`, and the ladders of `accuracy`.

All that was tried is a table, pictures and a page.
"""

from __future__ import annotations

import json
import re
import shlex
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tomlkit

from skincad.base.errors import InputError
from skincad.base.progress import about
from skincad.base.reading import Cell, csv_text
from skincad.base.result import Writer
from skincad.outputs import checks
from skincad.outputs.delivery import Presentation, drawn, text
from skincad.outputs.tomls import commented_toml, document_name, write_copy, write_with_schema
from skincad.studies.accuracy.accuracy import Accuracy
from skincad.studies.query import Evaluation, short, slack, worded
from skincad.studies.searches import combinations
from skincad.studies.solving import Solution
from skincad.studies.study import Optimisation
from skincad.studies.subject import Value, changed, owner
from skincad.studies.sweeping import SweepResult

if TYPE_CHECKING:
    from skincad.outputs.figures.canvas import Picture
    from skincad.studies.wish import WishResult


PAGE = "study.html"
NUMBER = re.compile(r"\d[\d.e+-]*")
FRONT_TABLE, FRONT_PAGE = "optimise.csv", "optimise.html"
ACCURACY_FILES = ("accuracy.csv", "accuracy.png")
COLUMNS = ("ladder", "model", "setting", "unknowns", "seconds", "spread_s", "repeats")
SHOWN = 6  # members of the front, in words and as designs


def solution_figures(solution: Solution) -> dict[str, Callable[[], Picture]]:
    """Return the result against the one number that is varied; nothing for several."""
    if len(solution.knobs) != 1 or solution.knobs[0].choices:
        return {}
    from skincad.outputs.figures.studies import solution_figure

    return {"solve.png": partial(solution_figure, solution)}


def write_solution(solution: Solution, path: Path, source: str) -> None:
    """Write the first solution as a copy of the file it began from, its comments kept.

    Raises InputError for a file that is there already or cannot be written.
    """
    values, targets = solution.solutions[0].values, SOLUTION.said("targets", solution)
    comments = {key: f"solved for {targets}" for key in values if not key.rpartition(".")[2].isdigit()}
    if any(owner(solution.subject, key)[0] is not solution.subject for key in values):
        comments = {}  # a skin's or a circuit's own tables come in place of its name
    write_copy(path, source, solution.solved, comments)


def sweep_names() -> list[str]:
    """Return the names of what may be written."""
    return ["sweep.csv", "sweep.parquet", "effects.png", "pairs.png", "front.png", PAGE]


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
        rows.append([number, *values, row.passed, row.refused or None, row.model, *map(cells.get, columns)])
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
    from skincad.outputs.pages import HERE, document, html

    head, rows = table(sweep)
    first = ["row", *(knob.key for knob in sweep.knobs), *(aims or (rank.key for rank in sweep.rankings))]
    shown = [name for name in dict.fromkeys([*first, *head]) if name in head and not name.endswith(".error")]
    shown = [name for name in shown if any(row[head.index(name)] not in (None, "") for row in rows)]
    plotted = [name for name in first[1:] if name in shown]
    data = {
        "head": shown,
        "rows": [[row[head.index(name)] for name in shown] for row in rows],
        "refused": [bool(row.refused) for row in sweep.rows],
        "designs": [_row_toml(sweep, row) for row in sweep.rows],
        "x": shown.index(sweep.knobs[0].key),
        "y": shown.index(plotted[min(len(sweep.knobs), len(plotted) - 1)]),
    }
    title = f"{title or sweep.name}: {len(sweep.rows)} rows"
    shown_words = "\n".join(words or [*SWEEP.lines(sweep), *SWEEP.details(sweep)])
    script = (HERE / "study.js").read_text("utf-8")
    island = json.dumps(data, allow_nan=False).replace("<", "\\u003c")
    body = html("study.html", "page", title, shown_words, island, script)
    return document(title, body, "study.css")


def _row_toml(sweep: SweepResult, row: Evaluation) -> str:
    """A row's design as TOML, or why there is none."""
    try:
        return changed(sweep.subject, row.values).to_toml()
    except InputError as refused:
        return f"# {refused}"


def sweep_figures(sweep: SweepResult) -> dict[str, Callable[[], Picture]]:
    """Return main effects and pairs of the first ranking's result, and the front of the first two."""
    if not sweep.rankings or len(sweep.rankings[0].ranks) < 2:
        return {}
    from skincad.outputs.figures.studies import effects_figure, front_figure, pairs_figure

    drawings: dict[str, Callable[[], Picture]] = {"effects.png": partial(effects_figure, sweep)}
    if len(sweep.knobs) > 1:
        drawings["pairs.png"] = partial(pairs_figure, sweep)
    if len(sweep.rankings) > 1:
        drawings["front.png"] = partial(front_figure, sweep)
    return drawings


def sweep_files(sweep: SweepResult) -> dict[str, Writer]:
    """Return the writer of each file; Parquet where pyarrow is installed."""
    writers: dict[str, Writer] = {"sweep.csv": text(lambda: sweep_csv(sweep))}
    if find_spec("pyarrow") is not None:
        writers["sweep.parquet"] = partial(_write_parquet, sweep)
    return {**writers, PAGE: text(lambda: sweep_page(sweep))}


def front_names() -> list[str]:
    """Return the names of what may be written."""
    designs = [f"front-{number}.toml" for number in range(1, SHOWN + 1)]
    return [*designs, FRONT_TABLE, FRONT_PAGE, "effects.png", "pairs.png", "front.png"]


def front_files(optimisation: Optimisation) -> dict[str, Writer]:
    """Return the writers of the front's designs, the table, the page and the pictures."""
    count = min(SHOWN, len(optimisation.front))
    designs = {f"front-{n}.toml": text(optimisation.design(n).to_toml) for n in range(1, count + 1)}
    rows, title, aims = optimisation.rows, optimisation.name, optimisation.aims
    page = text(lambda: sweep_page(rows, OPTIMISATION.lines(optimisation), title=title, aims=aims))
    return {**designs, FRONT_TABLE: text(lambda: sweep_csv(rows)), FRONT_PAGE: page}


def short_toml(wish: WishResult, name: str, schema: str = "") -> str:
    """Return the design's TOML without what is at its default, each choice with its rule above it."""
    design = wish.design.with_(name=name)
    document = tomlkit.parse(tomlkit.dumps(design.model_dump(exclude_defaults=True, exclude_none=True)))
    rules = {choice.key: choice.why for choice in wish.choices}
    rows = [f"#:schema ./{schema}", ""] if schema else []
    table = ""
    for row in [*WISH.rows("head", wish), *tomlkit.dumps(document).splitlines()]:
        if row.startswith("["):
            table = row.strip("[]")
        rule = rules.get(f"{table}.{row.partition(' = ')[0]}") or (row.startswith("[") and rules.get(table))
        rows += [f"# {rule}"] if rule else []
        rows.append(row)
    return "\n".join(rows) + "\n"


def write_wish(path: Path, wish: WishResult, full: bool = False) -> list[Path]:
    """Write the design of a wish, short or with every key explained, and its schema beside it; return both
    paths. Raises InputError for a file that is there already or cannot be written."""
    name = document_name(path.stem)

    def written(schema: str) -> str:
        short = short_toml(wish, name, schema)
        return commented_toml("designs", short, path.stem, schema) if full else short

    return write_with_schema(path, "designs", written, wish.design.features.family)


def accuracy_csv(accuracy: Accuracy) -> str:
    """Return all rows as CSV; a measure is a column, empty where a trial does not have it."""
    measures = [f"{ladder.name}: {m.name}" for ladder in accuracy.ladders for m in ladder.measures]
    rows: list[list[Cell]] = [[*COLUMNS, *measures]]
    for ladder in accuracy.ladders:
        for row in ladder.rows():
            errors = {f"{ladder.name}: {name}": f"{error:.4g}" for name, error in row["errors"].items()}
            cells = [row[c] if not isinstance(row[c], float) else f"{row[c]:.6g}" for c in COLUMNS]
            rows.append([*cells, *map(errors.get, measures)])
    return csv_text(rows)


def _unit_of(solution: Solution, key: str) -> str:
    unit = next(knob.unit for knob in solution.knobs if knob.key == key)
    return f" {unit}" if unit else ""


def _within_error(solution: Solution) -> bool:
    """Whether the nearest result may be the target."""
    assert solution.closest is not None
    near = solution.closest.reached
    return all(abs(float(near[key]) - wanted) <= slack(near[key]) for key, wanted in solution.target.items())


def _settings(values: Mapping[str, Value]) -> str:
    """The options of a command that give these values."""
    typed = (f"{k}={v:.10g}" if isinstance(v, float) else f"{k}={v}" for k, v in values.items())
    return " ".join(f"--set {shlex.quote(setting)}" for setting in typed)


def _reasons(sweep: SweepResult) -> list[tuple[str, int]]:
    """Why rows are refused, in the words of the first of each kind, and how many are; the usual first."""
    first: dict[str, str] = {}
    refused = [row.refused for row in sweep.rows if row.refused]
    kinds = [NUMBER.sub("", reason.partition(", got ")[0]) for reason in refused]
    for kind, reason in zip(kinds, refused, strict=True):
        first.setdefault(kind, reason)
    return [(first[kind], count) for kind, count in Counter(kinds).most_common()]


FACTS = {
    "about": about,
    "can_be_set": lambda values: not any(key.rpartition(".")[2].isdigit() for key in values),
    "combinations": combinations,
    "has_range": lambda solution: not all(knob.choices or knob.whole for knob in solution.knobs),
    "reasons": _reasons,
    "settings": _settings,
    "short": short,
    "unit_of": _unit_of,
    "within_error": _within_error,
    "worded": worded,
    "PAGE": PAGE,
    "SHOWN": SHOWN,
}
SOLUTION = Presentation(
    COMMAND="solve",
    words="solve.txt",
    facts=FACTS,
    writers=lambda solution: {"solved.toml": text(solution.solved.to_toml)} if solution.solutions else {},
    figures=solution_figures,
    manifest=lambda solution: {"name": solution.name, "target": dict(solution.target)},
)
SWEEP = Presentation(
    COMMAND="sweep",
    words="sweep.txt",
    facts=FACTS,
    writers=sweep_files,
    figures=sweep_figures,
    manifest=lambda sweep: {key: value for key, value in sweep.as_json().items() if key != "rows"},
)
OPTIMISATION = Presentation(
    COMMAND="optimise",
    words="optimise.txt",
    facts=FACTS,
    writers=front_files,
    figures=lambda optimisation: sweep_figures(optimisation.rows),
)
WISH = Presentation(
    COMMAND="new",
    words="new.txt",
    facts=checks.CHECK.facts,
    writers=lambda wish: {f"{wish.name}.toml": text(lambda: short_toml(wish, wish.name))},
    figures=lambda wish: checks.CHECK.figures(wish.check),
)
ACCURACY = Presentation(
    COMMAND="accuracy",
    words="accuracy.txt",
    writers=lambda accuracy: {ACCURACY_FILES[0]: text(lambda: accuracy_csv(accuracy))},
    figures=drawn("accuracy.png", "studies:accuracy_figure"),
)
