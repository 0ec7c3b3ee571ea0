"""Sweeps: many designs side by side, and their ranking.

Which of many designs is better, and how surely. Two designs that one model has judged share most of what that
model leaves out: an effect that makes one's force 7 % larger makes a like one's about as much larger. So of
the two models' errors only their difference counts in full, and of each a part that is its own; the errors of
meshes are independent.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

from skincad.base.errors import InputError, require_number
from skincad.base.progress import Tick
from skincad.base.result import Result, data_frame, item, record, reported, reported_from
from skincad.inputs.design import Design
from skincad.mechanics.models.table import MODELS, unsupported_reason, whole_price
from skincad.mechanics.verdict import NextModel
from skincad.studies.query import (
    Evaluation,
    Query,
    first_able,
    meant,
    question_of,
    ranges,
    resolved,
    total_seconds,
    worded,
)
from skincad.studies.running import Run, Values, log_in
from skincad.studies.running import workers as working
from skincad.studies.subject import DesignVariable, RangeText, Subject, knobs, values_at

Goal = Literal["min", "max"]
# of a model's error, what two designs do not share: bench/ranks.py found 0.06 at most on seeds 0 to 24, on
# which this is set; it is judged on seeds from 100 on
OWN = 0.1
MODEL = {"all_touch_force_N": "model_error_N"}  # which number tells how much of an error is the model's
_SHARES = {"approach_mm": "approach"}  # under which name `left_out` tells a relative error


@dataclass(frozen=True)
class Rank:
    """A row's place: `row` counts from 1 in the sweep's order, `wins` the rows that it surely beats."""

    row: int
    wins: int


@dataclass(frozen=True)
class Ranking:
    """Rows by a result, the best first; `ties` are groups, in that order, whose first member is not surely
    better than any other of them."""

    key: str
    goal: Goal
    ranks: tuple[Rank, ...]
    ties: tuple[tuple[int, ...], ...]


def require_goal(goal: str) -> None:
    """Raise InputError for a word that is no goal."""
    if goal not in ("min", "max"):
        raise InputError("rank", "must be KEY=min or KEY=max", goal)


def ranking(rows: Sequence[Evaluation], key: str, goal: Goal) -> Ranking:
    """Return the ranking of all rows that have this result; refused rows have no rank.

    Raises InputError for a key that no row has.
    """
    require_goal(goal)
    known = {name: None for row in rows for name in row.results}
    key = resolved(key, known, what="rank") if known else key
    placed = [
        (number, row)
        for number, row in enumerate(rows, 1)
        if not row.refused and key in row.results and row.results[key].value is not None
    ]
    sign = 1.0 if goal == "min" else -1.0
    placed.sort(key=lambda each: sign * float(each[1].results[key]))
    better = [[surely_less(a, b, key, sign) for _, b in placed] for _, a in placed]
    ranks = tuple(Rank(number, sum(better[i])) for i, (number, _) in enumerate(placed))
    ties, i = [], 0
    while i < len(placed):
        group = [placed[i][0]]
        while i + len(group) < len(placed) and not better[i][i + len(group)]:
            group.append(placed[i + len(group)][0])
        ties.append(tuple(group))
        i += len(group)
    return Ranking(key, goal, ranks, tuple(tie for tie in ties if len(tie) > 1))


def surely_less(a: Evaluation, b: Evaluation, key: str, sign: float = 1.0) -> bool:
    """Return whether `a`'s result lies below `b`'s, `sign` -1: above, beyond the error of their difference.

    An error that nobody knows makes nothing sure.
    """
    one, other = a.results[key], b.results[key]
    if one.value is None or other.value is None:
        return False
    error = difference_error(a, b, key)
    return error is not None and sign * (other.value - one.value) > error


def difference_error(a: Evaluation, b: Evaluation, key: str) -> float | None:
    """Return the error of the difference of two results; None where one's is not known."""
    one, other = a.results[key], b.results[key]
    if one.error is None or other.error is None:
        return None
    if a.model != b.model or not a.model:
        return math.hypot(one.error, other.error)
    shared = model_error(a, key), model_error(b, key)
    own_errors = [max(e - m, 0.0) for e, m in zip((one.error, other.error), shared, strict=True)]
    return math.hypot(*own_errors) + abs(shared[0] - shared[1]) + OWN * math.hypot(*shared)


def model_error(evaluation: Evaluation, key: str) -> float:
    """Return how much of a result's error is what its model leaves out; 0 where that is not told."""
    stated = evaluation.results.get(MODEL.get(key, ""))
    if stated is not None and stated.value is not None:
        return stated.value
    ending = _SHARES.get(key)
    value = abs(evaluation.results[key].value or 0.0)
    parts = [
        estimate.value or 0.0
        for name, estimate in evaluation.results.items()
        if ending and name.startswith("left_out.") and name.endswith(f".{ending}")
    ]
    return value * math.fsum(parts)


MOST_ROWS = 100_000
# if no ranking is asked, as far as rows have these results
DEFAULT: dict[str, dict[str, Goal]] = {
    "check": {"all_touch_force": "min"},
    "simulate": {"warned_share": "max", "warning_lead_time_s": "max"},
}
# the first that takes the design: ranks mean something by one model
RANKED_BY = "linear", "winkler", "reduced"
INPUTS = ("passed", "ridges")  # said of a row elsewhere, or by its values
UNTOLD = ("seconds.", "next_tier.", "climbed.")  # numbers of a run, not of a design


@record()
class SweepResult(Result):
    """All `rows`, in the order of the values, refused ones with their reason; `rankings` the asked orders.

    `evaluations` is how many were computed now, `reused` how many a log or another row had; `next_model` the
    model that may tell the first tie apart, and its seconds; `seconds` the wall time of this run.
    """

    shown_by = "skincad.outputs.studies:SWEEP"
    subject: Subject
    question: Query
    knobs: tuple[DesignVariable, ...]
    rows: tuple[Evaluation, ...]
    rankings: tuple[Ranking, ...]
    next_model: NextModel | None = item(meaning="may tell the first tie apart", key="next_tier")
    evaluations: int = item(meaning="computed now")
    reused: int = item(meaning="that a log or another row had")
    seconds: float  # wall time of this run

    name = reported_from("subject.name", meaning="of the subject")

    @property
    def refused(self) -> int:
        """How many rows are refused."""
        return sum(bool(row.refused) for row in self.rows)

    @property
    def keys(self) -> tuple[str, ...]:
        """The results that some row has a value of, without those of the run."""
        names = dict.fromkeys(
            key for row in self.rows for key, estimate in row.results.items() if estimate.value is not None
        )
        return tuple(
            key
            for key in names
            if key not in INPUTS
            and not key.startswith(UNTOLD)
            and not (key.endswith((".min", ".max", ".last")) and f"{key.rpartition('.')[0]}.1" in names)
        )

    def best(self, number: int = 1) -> Evaluation:
        """Return the row at this place of the first ranking; InputError where there is none."""
        ranks = self.rankings[0].ranks if self.rankings else ()
        if not 1 <= number <= len(ranks):
            raise InputError("number", f"must be from 1 to {len(ranks)}", number)
        return self.rows[ranks[number - 1].row - 1]

    @property
    def exit_status(self) -> int:
        """0 where a row has an answer, else 1."""
        return 0 if self.refused < len(self.rows) else 1

    _vary = ranges

    @reported(meaning="in the order of the values; a refused one says why", key="rows")
    def _rows(self) -> list[dict[str, Any]]:
        return [
            {
                "values": row.values,
                "results": {key: row.results[key] for key in self.keys if key in row.results},
                "passed": row.passed,
                "refused": row.refused or None,
                "tier": row.model or None,
            }
            for row in self.rows
        ]

    @reported(meaning="by what rows are ranked")
    def ranked_by(self) -> list[dict[str, str]]:
        """Keys and goals of the rankings, the one that counts first."""
        return [{"key": ranking.key, "goal": ranking.goal} for ranking in self.rankings]

    @reported(meaning="rows of the first ranking, the best first; they count from 1")
    def ranking(self) -> tuple[Rank, ...]:
        """Ranks of the first ranking."""
        return self.rankings[0].ranks if self.rankings else ()

    @reported(meaning="groups of its rows that are not surely apart")
    def ties(self) -> tuple[tuple[int, ...], ...]:
        """Ties of the first ranking."""
        return self.rankings[0].ties if self.rankings else ()

    model = reported_from("question.model", meaning="the model of all checks", key="tier")

    _seconds = total_seconds

    def arrays(self) -> dict[str, Any]:
        """Return a numpy array `(rows,)` by key: values, results, and errors as `KEY.error`; NaN where a row
        has none."""
        import numpy as np

        columns: dict[str, Any] = {
            knob.key: np.array([row.values[knob.key] for row in self.rows]) for knob in self.knobs
        }
        for key in self.keys:
            estimates = [row.results.get(key) for row in self.rows]
            for name, part in ((key, "value"), (f"{key}.error", "error")):
                numbers = [None if estimate is None else getattr(estimate, part) for estimate in estimates]
                if part == "value" or any(number is not None for number in numbers):
                    columns[name] = np.array([math.nan if n is None else n for n in numbers])
        return columns

    def columns(self) -> dict[str, Any]:
        """Return a row for each design: the values of the varied keys, with their units, and the results."""
        names = {knob.key: knob.column for knob in self.knobs}
        return {names.get(key, key): column for key, column in self._table().items()}

    def frame(self) -> Any:
        """Return what `to_frame` does, the varied keys without units in their names."""
        return data_frame(self._table())

    def _table(self) -> dict[str, Any]:
        extra = {"passed": [row.passed for row in self.rows], "refused": [row.refused for row in self.rows]}
        return {**self.arrays(), **extra}


def sweep(
    subject: Subject,
    vary: Mapping[str, RangeText],
    *,
    sample: int | None = None,
    rank: Mapping[str, Goal] | None = None,
    model: str | None = None,
    tol: float | None = None,
    force: float | None = None,
    hold: str | float | None = None,
    folder: Path | str | None = None,
    fresh: bool = False,
    workers: int = 1,
    dask: Any = None,
    tick: Tick | None = None,
) -> SweepResult:
    """Return the answers of a design's check, a scene's simulation or a circuit's gain at many values.

    `vary` is by key: (low, high, count), a list of choices or "all"; their grid is taken, or with `sample`
    that many Sobol points of the ranges. Checks are by one `model`, `linear` if None, and ranked by `rank`,
    a result's key and "min" or "max", if nothing is said by the smallest all-touch force. With `hold`, a mass
    as "0.3kg", each check of a design says too which lifts of such an object the mount's gripper holds
    (`holding.share`), which takes some 20 s. With a `folder`
    each finished evaluation goes into its log at once, and what that has already is not asked again, unless
    `fresh`. Rows
    come from `workers` processes of this machine (a script that asks for more than one needs the usual
    `if __name__ == "__main__":`), or from the `dask` cluster of an address or a client. Raises InputError for
    keys, ranges and options that can't be used; rows that are refused say why.
    """
    began = perf_counter()
    varied = knobs(subject, vary)
    points = points_of(subject, vary, sample)
    question = question_of(subject, model=model, tol=tol, force=force, hold=hold)
    if isinstance(subject, Design) and model is None:
        question = replace(question, model=first_able(RANKED_BY, subject))
    run = Run(subject, question, log_in(folder, fresh=fresh))
    asked: dict[str, Goal] = dict(rank or {})
    wanted = asked or DEFAULT.get(question.kind, {})
    for goal in wanted.values():
        require_goal(goal)
    evaluations: list[Evaluation] = []

    def told(evaluation: Evaluation, count: int, _: int) -> None:
        if evaluation.results and not any(row.results for row in evaluations):
            for key in asked:
                resolved(key, evaluation.results, what="rank")  # a misspelt one costs one row, not all
        evaluations.append(evaluation)
        if tick is not None:
            tick(_best(evaluations, wanted), count)

    with working(workers, dask) as who:
        rows = run.at(points, who, told)
    run.log.close()
    wanted = {k: goal for k, goal in wanted.items() if asked or any(meant(k, row.results) for row in rows)}
    rankings = tuple(ranking(rows, key, goal) for key, goal in wanted.items())
    seconds = perf_counter() - began
    of_row = seconds * workers / max(run.evaluated, 1)
    following = _next_model(subject, question, rankings[0], of_row) if rankings else None
    return SweepResult(
        subject=subject,
        question=question,
        knobs=varied,
        rows=tuple(rows),
        rankings=rankings,
        next_model=following,
        evaluations=run.evaluated,
        reused=run.reused,
        seconds=seconds,
    )


def _best(rows: Sequence[Evaluation], wanted: Mapping[str, Goal]) -> str:
    """What the bar says: the best of the first ranking so far."""
    for key, goal in wanted.items():
        results = [row.results for row in rows if not row.refused]
        name = meant(key, results[0]) if results else None
        estimates = [row[name] for row in results if name is not None and name in row]
        values = [estimate.value for estimate in estimates if estimate.value is not None]
        if name and values:
            return f"best {worded(name, min(values) if goal == 'min' else max(values))}"
    return "evaluating"


def points_of(subject: Subject, vary: Mapping[str, RangeText], sample: int | None = None) -> list[Values]:
    """Return the values of all rows: the grid, or with `sample` that many Sobol points.

    Raises InputError for keys and ranges that can't be used, and for too many.
    """
    varied = knobs(subject, vary)
    if sample is None:
        count = math.prod(len(knob.values()) for knob in varied)
        if count > MOST_ROWS:
            raise InputError(
                "vary", f"must make at most {MOST_ROWS} rows", count, "take fewer values, or a sample"
            )
        keys = [knob.key for knob in varied]
        return [
            dict(zip(keys, combination, strict=True))
            for combination in itertools.product(*(k.values() for k in varied))
        ]
    rule = f"must be from 1 to {MOST_ROWS}"
    require_number("sample", sample, lambda value: 1 <= value <= MOST_ROWS and value == int(value), rule)
    for knob in varied:
        if knob.count is not None:
            rule = "must have no number of values beside a sample, which takes its own"
            raise InputError(knob.key, rule, knob.count, f"write {knob}, or leave the sample out")
    size = math.ceil(math.log2(max(sample, 2)))
    from scipy.stats import qmc  # half a second, which most commands need not wait for

    places = qmc.Sobol(len(varied), scramble=False).random_base2(size)[:sample]
    return [values_at(varied, place) for place in places]


def _next_model(
    subject: Subject, question: Query, ranking: Ranking, seconds_of_row: float
) -> NextModel | None:
    """The next model that leaves less out, and its seconds for the rows that tie for the first place, by what
    a row took."""
    if question.kind != "check" or not ranking.ties or not ranking.ranks or not isinstance(subject, Design):
        return None
    first = ranking.ties[0]
    if ranking.ranks[0].row not in first or question.model not in MODELS:
        return None
    # the closed form's error is not told by what it leaves out
    names, rough = list(MODELS), question.model == "winkler"
    least = math.inf if rough else len(MODELS[question.model].leaves_out)
    for name in names[names.index(question.model) + 1 :]:
        if not unsupported_reason(name, subject, False) and len(MODELS[name].leaves_out) <= least:
            dearer = whole_price(name) / whole_price(question.model)
            return NextModel(name, len(first) * seconds_of_row * dearer)
    return None
