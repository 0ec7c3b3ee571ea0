"""Output of studies: of `solve` what reaches the target, of `sweep` the best rows, of `optimise` the front.

All that was tried is a table, pictures and a page.
"""

from __future__ import annotations

import json
import re
import shlex
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from html import escape
from importlib.util import find_spec
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

from skincad.base.errors import InputError
from skincad.base.progress import about
from skincad.base.reading import csv_text
from skincad.base.result import Writer
from skincad.outputs.delivery import Presentation, picture, text
from skincad.outputs.tomls import write_copy
from skincad.studies.query import Evaluation, short, slack, worded
from skincad.studies.searches import combinations
from skincad.studies.solving import Solution, SolutionPoint
from skincad.studies.study import Member, Optimisation
from skincad.studies.subject import DesignVariable, Value, changed, owner
from skincad.studies.sweeping import Ranking, SweepResult

if TYPE_CHECKING:
    from skincad.outputs.figures.canvas import Picture


NEXT_COMMANDS = {  # by what was asked: the command that goes on, and what it does
    "check": ("check", "judges it by more accurate models"),
    "make": ("make", "makes its mold"),
    "simulate": ("simulate", "runs it with all signals and pictures"),
    "circuit": ("circuit", "shows its gain"),
}
MAX_SHOWN = 5  # solutions, in words
PAGE = "study.html"
MAX_BEST_ROWS, MAX_REASONS = 5, 3  # best rows, and reasons of refusals, in words
NUMBER = re.compile(r"\d[\d.e+-]*")
MOST_KEYS = 12  # of a result, that are named
MAX_TIED_ROWS = 12  # rows of a tie that are listed by number
FRONT_TABLE, FRONT_PAGE = "optimise.csv", "optimise.html"
SHOWN = 6  # members of the front, in words and as designs


def solution_lines(solution: Solution) -> list[str]:
    """Return the value that gives the target, how surely it does, and what to know of the search."""
    return [
        f"{solution.name}: {_found(solution)}.",
        *(_reached_lines(solution, solution.solutions[0]) if solution.solutions else []),
        f"  searched       {_effort(solution)}",
        *(f"  note           {note}" for note in solution.notes),
    ]


def _found(solution: Solution) -> str:
    if not solution.solutions:
        return _none(solution)
    # with choices alone, a solution only has the target within its error
    gives = "may give" if all(knob.choices or knob.whole for knob in solution.knobs) else "gives"
    others = len(solution.solutions) - 1
    also = f"; {others} other{'s' if others > 1 else ''} too" if others else ""
    return f"{_solved_values(solution, solution.solutions[0])} {gives} {_targets(solution)}{also}"


def _effort(solution: Solution) -> str:
    count, model = len(solution.evaluations), solution.question.model
    whole = "the whole range" if solution.complete else "a part of the range"
    effort = f"{count} evaluation{'s' if count != 1 else ''}" + (f" by {model}" if model else "")
    refused = f", {solution.refused} of them refused" if solution.refused else ""
    return f"{whole}: {effort}, {solution.seconds:.3g} s{refused}"


def solution_step(solution: Solution) -> str:
    """Return what to do next: check the solution, or look elsewhere."""
    if not solution.solutions:
        return "look further: widen a range of --vary, or vary another key."
    return _next_command(solution.question.kind, solution.solutions[0].values, "`-o FILE` writes the design.")


def _next_command(kind: str, values: Mapping[str, Value], where: str) -> str:
    """Return the command that goes on with a design, scene or circuit of these values; `where` these are
    instead, if `--set` can't give them."""
    if any(key.rpartition(".")[2].isdigit() for key in values):
        return where
    command, does = NEXT_COMMANDS[kind]
    settings = " ".join(f"--set {shlex.quote(f'{key}={_typed(value)}')}" for key, value in values.items())
    return f"`skincad {command} {{design}} {settings}` {does}."


def _typed(value: Value) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def solution_details(solution: Solution) -> list[str]:
    """Return the other solutions, and the first refusal."""
    _, *others = solution.solutions or (None,)
    rows = []
    for candidate in others[: MAX_SHOWN - 1]:
        rows.append(f"  also           {_solved_values(solution, candidate)}")
        rows += _reached_lines(solution, candidate)
    if len(others) >= MAX_SHOWN:
        rows.append(f"  and            {len(others) + 1 - MAX_SHOWN} more")
    refused = [evaluation.refused for evaluation in solution.evaluations if evaluation.refused]
    return [*rows, *([f"  refused        {len(refused)}; the first: {refused[0]}"] if refused else [])]


def _reached_lines(solution: Solution, candidate: SolutionPoint) -> list[str]:
    """Return what a solution reaches, and how far its values may be off."""
    rows = [f"  reached        {worded(key, value)}" for key, value in candidate.reached.items()]
    for key, (low, high) in candidate.interval.items():
        knob = next(knob for knob in solution.knobs if knob.key == key)
        ends = f"{short(low)} to {short(high)}{_unit(knob)}"
        rows.append(f"  may be         {key} anywhere from {ends}, since the result has that error")
    return rows + [
        f"  nearest        {key} = {name}"
        for key, name in candidate.nearest.items()
        if key not in candidate.values
    ]


def _solved_values(solution: Solution, solved: SolutionPoint) -> str:
    units = {knob.key: _unit(knob) for knob in solution.knobs}
    return ", ".join(f"{key} {short(value)}{units[key]}" for key, value in solved.values.items())


def _unit(knob: DesignVariable) -> str:
    return f" {knob.unit}" if knob.unit else ""


def _none(solution: Solution) -> str:
    ranges, count = ", ".join(_range(knob) for knob in solution.knobs), len(solution.evaluations)
    sentence = f"no {ranges} gives {_targets(solution)}"
    if not solution.complete:
        many = f"{count} evaluation{'s' if count != 1 else ''}"
        sentence = f"none found in {many} of {ranges} that gives {_targets(solution)}"
    if solution.closest is None:
        return sentence
    near = solution.closest.reached
    reached = ", ".join(worded(key, value) for key, value in near.items())
    within = all(
        abs(float(near[key]) - wanted) <= slack(near[key]) for key, wanted in solution.target.items()
    )
    may = "; the target lies within its error" if within else ""
    return f"{sentence}. The nearest is {reached}, at {_solved_values(solution, solution.closest)}{may}"


def _targets(solution: Solution) -> str:
    sides = {"<=": " at most ", ">=": " at least "}
    bounds = solution.bounds or {}
    words = (
        (worded(key, wanted), sides.get(bounds.get(key, ""), " ")) for key, wanted in solution.target.items()
    )
    return ", ".join(side.join(text.split(" ", 1)) for text, side in words)


def _range(knob: DesignVariable) -> str:
    if knob.choices:
        many = len(knob.choices) > MAX_SHOWN
        return f"{knob.key} among {len(knob.choices) if many else ' and '.join(map(str, knob.choices))}"
    return f"{knob.key} from {knob.low:g} to {knob.high:g}{_unit(knob)}"


def solution_figures(solution: Solution) -> dict[str, Callable[[], Picture]]:
    """Return the result against the one number that is varied; nothing for several."""
    if len(solution.knobs) != 1 or solution.knobs[0].choices:
        return {}
    from skincad.outputs.figures.studies import solution_figure

    return {"solve.png": partial(solution_figure, solution)}


def solution_files(solution: Solution) -> dict[str, Writer]:
    """Return the writers of the first solution's design, and of the figure."""
    designs = {"solved.toml": text(solution.solved.to_toml)} if solution.solutions else {}
    return {**designs, **{name: picture(draw) for name, draw in solution_figures(solution).items()}}


def write_solution(solution: Solution, path: Path, source: str) -> None:
    """Write the first solution as a copy of the file it began from, its comments kept.

    Raises InputError for a file that is there already or cannot be written.
    """
    values = solution.solutions[0].values
    comments = {
        key: f"solved for {_targets(solution)}" for key in values if not key.rpartition(".")[2].isdigit()
    }
    if any(owner(solution.subject, key)[0] is not solution.subject for key in values):
        comments = {}  # a skin's or a circuit's own tables come in place of its name
    write_copy(path, source, solution.solved, comments)


def sweep_names() -> list[str]:
    """Return the names of what may be written."""
    return ["sweep.csv", "sweep.parquet", "effects.png", "pairs.png", "front.png", PAGE]


def sweep_lines(sweep: SweepResult) -> list[str]:
    """Return the best row, how surely it is the best, and how many rows there are."""
    count, model = len(sweep.rows), sweep.question.model
    spent = f"{sweep.evaluations} evaluations, {sweep.reused} reused, {sweep.seconds:.3g} s"
    return [
        f"{sweep.name}: {_best(sweep)}.",
        *([f"  how sure       {_surely(sweep.rankings[0])}"] if _ranked(sweep) else []),
        f"  rows           {count}{f' by {model}' if model else ''}: {_verdicts(sweep)}; {spent}",
        *(_refusals([row for row in sweep.rows if row.refused]) if sweep.refused == count else []),
    ]


def _ranked(sweep: SweepResult) -> bool:
    return bool(sweep.rankings and sweep.rankings[0].ranks)


def _best(sweep: SweepResult) -> str:
    if not sweep.rankings:
        return f"{len(sweep.rows)} rows, ranked by nothing"
    ranking = sweep.rankings[0]
    word = "smallest" if ranking.goal == "min" else "largest"
    if not ranking.ranks:
        return f"no row has {ranking.key}"
    row, number = sweep.best(), ranking.ranks[0].row
    return f"row {number} has the {word} {worded(ranking.key, row.results[ranking.key])}: {_row_values(row)}"


def _surely(ranking: Ranking) -> str:
    """How many rows the best one surely beats."""
    first, others = ranking.ranks[0], len(ranking.ranks) - 1
    if not others:
        return "no other row has this result"
    beaten = "all other rows" if first.wins == others else f"{first.wins} of the other {others} rows"
    tied = ranking.ties and first.row in ranking.ties[0]
    return f"surely better than {beaten}" + (f"; {_tie(ranking)}" if tied else "")


def _tie(ranking: Ranking) -> str:
    """Which rows the best one may not beat."""
    tie = ranking.ties[0]
    others = (
        f"rows {', '.join(map(str, tie[1:]))}" if len(tie) <= MAX_TIED_ROWS else f"the next {len(tie) - 1}"
    )
    return f"not surely better than {f'row {tie[1]}' if len(tie) == 2 else others}"


def sweep_step(sweep: SweepResult) -> str:
    """Return what to do next: ask a better model that tells the first rows apart, or check the best row."""
    if not _ranked(sweep):
        answered = [row for row in sweep.rows if not row.refused]
        if not answered:
            return "change the ranges of --vary: no row has an answer."
        keys = [key for key in answered[0].results if answered[0].results[key].value is not None]
        return f"rank the rows: --rank KEY=max, KEY one of {', '.join(keys[:MOST_KEYS])}; `--json` has all."
    if sweep.next_model:
        name, seconds = sweep.next_model.model, sweep.next_model.seconds
        count = len(sweep.rankings[0].ties[0])
        return (
            f"the same sweep with `--model {name}` may tell the first {count} rows apart; these alone take "
            f"about {about(seconds)}."
        )
    return _next_command(sweep.question.kind, sweep.best().values, f"{PAGE} has the design of each row.")


def sweep_details(sweep: SweepResult) -> list[str]:
    """Return the best rows of each ranking, and why rows are refused."""
    rows = [row for ranking in sweep.rankings for row in _ranking_lines(sweep, ranking)]
    refused = [row for row in sweep.rows if row.refused]
    return [*rows, *(_refusals(refused) if len(refused) < len(sweep.rows) else [])]


def _row_values(row: Evaluation) -> str:
    return ", ".join(f"{key} {short(value)}" for key, value in row.values.items())


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
        head = f"{word} {place}".ljust(14)
        rows.append(
            f"  {head} {worded(ranking.key, row.results[ranking.key])}: {_row_values(row)} (row {rank.row}, "
            f"surely better than {rank.wins})"
        )
    if ranking is not sweep.rankings[0] and ranking.ties and ranking.ranks[0].row in ranking.ties[0]:
        rows.append(f"  tie            row {ranking.ranks[0].row} is {_tie(ranking)}")
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
    from skincad.outputs.pages import HERE, document

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
        "designs": [_row_toml(sweep, row) for row in sweep.rows],
        "x": shown.index(sweep.knobs[0].key),
        "y": shown.index(plotted[min(len(sweep.knobs), len(plotted) - 1)]),
    }
    title = f"{title or sweep.name}: {len(sweep.rows)} rows"
    body = Template((HERE / "study_body.html").read_text("utf-8")).substitute(
        title=escape(title),
        words=escape("\n".join(words or [*sweep_lines(sweep), *sweep_details(sweep)])),
        data=json.dumps(data, allow_nan=False).replace("<", "\\u003c"),
        script=(HERE / "study.js").read_text("utf-8"),
    )
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
    writers[PAGE] = text(lambda: sweep_page(sweep))
    return {**writers, **{name: picture(draw) for name, draw in sweep_figures(sweep).items()}}


def front_names() -> list[str]:
    """Return the names of what may be written."""
    designs = [f"front-{number}.toml" for number in range(1, SHOWN + 1)]
    return [*designs, FRONT_TABLE, FRONT_PAGE, "effects.png", "pairs.png", "front.png"]


def front_lines(optimisation: Optimisation) -> list[str]:
    """Return what `optimise` prints."""
    rows = [_first(optimisation)]
    for number, member in enumerate(optimisation.front[:SHOWN], 1):
        rows.append(f"  {f'front {number}':14} {_values(member)}")
        rows += _member_lines(member)
    if len(optimisation.front) > SHOWN:
        rows.append(f"  {'more':14} {len(optimisation.front) - SHOWN} designs of the front, in optimise.json")
    if optimisation.closest is not None:
        rows += [f"  {'nearest':14} {_values(optimisation.closest)}", *_member_lines(optimisation.closest)]
    if optimisation.start is not None:
        rows += [
            f"  {'start':14} {', '.join(worded(k, e) for k, e in optimisation.start.objectives.items())}"
        ]
    model = optimisation.rows.question.model
    designs = f"{len(optimisation.rows.rows)} designs{f' by {model}' if model else ''}"
    by = f"{designs}, {optimisation.judged} judged"
    spent = (
        f"{optimisation.evaluations} evaluations, {optimisation.reused} reused, {optimisation.seconds:.3g} s"
    )
    rows.append(f"  tried          {by}; {spent}")
    if optimisation.untried:
        count = combinations(optimisation.rows.knobs)
        untried = f"{optimisation.untried} of {count} combinations"
        rows.append(f"  not tried      {untried}; `evaluations = {count}` tries all")
    return rows


def _first(optimisation: Optimisation) -> str:
    goals = ", ".join(
        f"{o.key} {'small' if o.goal == 'min' else 'large'}" for o in optimisation.study.objectives
    )
    if not optimisation.front:
        return f"{optimisation.name}: no design that was judged keeps all constraints ({goals})."
    several = len(optimisation.study.objectives) > 1
    what = f"a front of {len(optimisation.front)} designs" if several else "the best design that was found"
    return f"{optimisation.name}: {what} for {goals}."


def _values(member: Member) -> str:
    return ", ".join(f"{key} {short(value)}" for key, value in member.values.items())


def _member_lines(member: Member) -> list[str]:
    by = f" ({member.model})" if member.model else ""
    rows = [f"    {'objective':12} {worded(key, value)}{by}" for key, value in member.objectives.items()]
    return rows + [
        f"    {'constraint' if satisfied else 'BROKEN':12} {worded(key, value)}"
        for key, (value, satisfied) in member.constraints.items()
    ]


def front_figures(optimisation: Optimisation) -> dict[str, Callable[[], Picture]]:
    """Return the pictures of all that was tried."""
    return dict(sweep_figures(optimisation.rows))


def front_files(optimisation: Optimisation) -> dict[str, Writer]:
    """Return the writers of the front's designs, the table, the page and the pictures."""
    count = min(SHOWN, len(optimisation.front))
    designs = {f"front-{n}.toml": text(optimisation.design(n).to_toml) for n in range(1, count + 1)}
    aims = optimisation.aims
    page = text(
        lambda: sweep_page(optimisation.rows, front_lines(optimisation), title=optimisation.name, aims=aims)
    )
    pictures = {name: picture(draw) for name, draw in front_figures(optimisation).items()}
    return {**designs, FRONT_TABLE: text(lambda: sweep_csv(optimisation.rows)), FRONT_PAGE: page, **pictures}


SOLUTION = Presentation(
    COMMAND="solve",
    lines=solution_lines,
    next_step=solution_step,
    details=solution_details,
    files=solution_files,
    figures=solution_figures,
    manifest=lambda solution: {"name": solution.name, "target": dict(solution.target)},
)
SWEEP = Presentation(
    COMMAND="sweep",
    lines=sweep_lines,
    next_step=sweep_step,
    details=sweep_details,
    files=sweep_files,
    figures=sweep_figures,
    manifest=lambda sweep: {key: value for key, value in sweep.as_json().items() if key != "rows"},
)
OPTIMISATION = Presentation(COMMAND="optimise", lines=front_lines, files=front_files, figures=front_figures)
