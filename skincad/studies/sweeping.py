"""Sweep: one question of many designs, side by side, and which of them is the best."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

from skincad.base.arguments import require_number
from skincad.base.errors import InputError
from skincad.base.result import Result
from skincad.base.stopwatch import Tick
from skincad.inputs.design import Design
from skincad.mechanics.tiers.table import TIERS, able, expected
from skincad.studies.knobs import Knob, Told, knobs
from skincad.studies.log import Log
from skincad.studies.measures import resolved, worded
from skincad.studies.question import Evaluation, Question, first_able, question_of
from skincad.studies.ranking import Goal, Ranking, ranking, require_goal
from skincad.studies.running import Run, Values
from skincad.studies.running import workers as working
from skincad.studies.subject import Subject

MOST_ROWS = 100_000
DEFAULT: dict[str, dict[str, Goal]] = {"check": {"all_touch_force": "min"}}  # if no ranking is asked
RANKED_BY = ("linear", "winkler")  # the first that takes the design: ranks mean something by one model
INPUTS = ("passed", "ridges")  # said of a row elsewhere, or by its values
UNTOLD = ("seconds.", "next_tier.", "climbed.")  # numbers of a run, not of a design


@dataclass(frozen=True, repr=False)
class SweepResult(Result):
    """All `rows`, in the order of the values, refused ones with their reason; `rankings` the asked orders.

    `evaluations` is how many were computed now, `reused` how many a log or another row had; `next_tier` the
    model that may tell the first tie apart, and its seconds; `seconds` the wall time of this run.
    """

    shown_by = "skincad.outputs.studies:SWEEP"
    subject: Subject
    question: Question
    knobs: tuple[Knob, ...]
    rows: tuple[Evaluation, ...]
    rankings: tuple[Ranking, ...]
    next_tier: tuple[str, float] | None
    evaluations: int
    reused: int
    seconds: float

    @property
    def name(self) -> str:
        """The subject's name."""
        return self.subject.name

    @property
    def refused(self) -> int:
        """How many rows are refused."""
        return sum(bool(row.refused) for row in self.rows)

    @property
    def keys(self) -> tuple[str, ...]:
        """The results that some row has a value of, without those of the run."""
        found = dict.fromkeys(
            key for row in self.rows for key, told in row.results.items() if told.value is not None
        )
        return tuple(
            key
            for key in found
            if key not in INPUTS
            and not key.startswith(UNTOLD)
            and not (key.endswith((".min", ".max", ".last")) and f"{key.rpartition('.')[0]}.1" in found)
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

    def as_json(self) -> dict[str, Any]:
        """Return the result under the contract's keys; rows count from 1."""
        first = self.rankings[0] if self.rankings else None
        return {
            "name": self.name,
            "vary": {knob.key: list(knob.choices) or [knob.low, knob.high] for knob in self.knobs},
            "rows": [self._row(row) for row in self.rows],
            "ranked_by": [{"key": each.key, "goal": each.goal} for each in self.rankings],
            "ranking": [{"row": rank.row, "wins": rank.wins} for rank in first.ranks] if first else [],
            "ties": [list(tie) for tie in first.ties] if first else [],
            "next_tier": self.next_tier and {"tier": self.next_tier[0], "seconds": self.next_tier[1]},
            "tier": self.question.tier,
            "evaluations": self.evaluations,
            "reused": self.reused,
            "seconds": {"total": self.seconds},
        }

    def _row(self, row: Evaluation) -> dict[str, Any]:
        told = {key: row.results[key].as_json() for key in self.keys if key in row.results}
        return {
            "values": dict(row.values),
            "results": told,
            "passed": row.passed,
            "refused": row.refused or None,
            "tier": row.tier or None,
        }

    def arrays(self) -> dict[str, Any]:
        """Return a numpy array `(rows,)` by key: values, results, and errors as `KEY.error`; NaN where a row
        has none."""
        import numpy as np

        told: dict[str, Any] = {
            knob.key: np.array([row.values[knob.key] for row in self.rows]) for knob in self.knobs
        }
        for key in self.keys:
            found = [row.results.get(key) for row in self.rows]
            for name, part in ((key, "value"), (f"{key}.error", "error")):
                numbers = [None if each is None else getattr(each, part) for each in found]
                if part == "value" or any(number is not None for number in numbers):
                    told[name] = np.array([math.nan if n is None else n for n in numbers])
        return told

    def frame(self) -> Any:
        """Return the rows as a pandas DataFrame; InputError where pandas is not installed."""
        try:
            import pandas
        except ImportError:
            raise InputError("frame", "needs the package pandas", remedy="pip install pandas") from None
        extra = {"passed": [row.passed for row in self.rows], "refused": [row.refused for row in self.rows]}
        return pandas.DataFrame({**self.arrays(), **extra})


def sweep(
    subject: Subject,
    vary: Mapping[str, Told],
    *,
    sample: int | None = None,
    rank: Mapping[str, Goal] | None = None,
    tier: str | None = None,
    tol: float | None = None,
    force: float | None = None,
    folder: Path | str | None = None,
    fresh: bool = False,
    workers: int = 1,
    dask: Any = None,
    tick: Tick | None = None,
) -> SweepResult:
    """Return the answers of a design's check, a scene's simulation or a circuit's gain at many values.

    `vary` is by key: (low, high, count), a list of choices or "all"; their grid is taken, or with `sample`
    that many Sobol points of the ranges. Checks are by one `tier`, `linear` if None, and ranked by `rank`,
    a result's key and "min" or "max", if nothing is said by the smallest all-touch force. With a `folder`
    each finished evaluation goes into its log at once, and what that has already is not asked again, unless
    `fresh`. Rows
    come from `workers` processes of this machine (a script that asks for more than one needs the usual
    `if __name__ == "__main__":`), or from the `dask` cluster of an address or a client. Raises InputError for
    keys, ranges and options that can't be used; rows that are refused say why.
    """
    began = perf_counter()
    varied = knobs(subject, vary)
    points = points_of(subject, vary, sample)
    question = question_of(subject, tier=tier, tol=tol, force=force)
    if isinstance(subject, Design) and tier is None:
        question = replace(question, tier=first_able(RANKED_BY, subject))
    run = Run(subject, question, log_in(folder, fresh=fresh))
    wanted: dict[str, Goal] = dict(rank) if rank else dict(DEFAULT.get(question.kind, {}))
    for goal in wanted.values():
        require_goal(goal)
    done: list[Evaluation] = []

    def told(found: Evaluation, count: int, _: int) -> None:
        if found.results and not any(row.results for row in done):
            for key in wanted:
                resolved(key, found.results, what="rank")  # a misspelt one costs one row, not all
        done.append(found)
        if tick is not None:
            tick(_best(done, wanted), count)

    with working(workers, dask) as who:
        rows = run.at(points, who, told)
    if run.log is not None:
        run.log.close()
    rankings = tuple(ranking(rows, key, goal) for key, goal in wanted.items())
    following = _next_tier(subject, question, rankings[0]) if rankings else None
    seconds = perf_counter() - began
    return SweepResult(
        subject, question, varied, tuple(rows), rankings, following, run.asked, run.reused, seconds
    )


def _best(done: Sequence[Evaluation], wanted: Mapping[str, Goal]) -> str:
    """What the bar says: the best of the first ranking so far."""
    for key, goal in wanted.items():
        found = [row.results for row in done if not row.refused]
        known = [resolved(key, results) for results in found[:1]]
        values = [
            each.value for results in found if (each := results.get(known[0])) and each.value is not None
        ]
        if values:
            return f"best {worded(known[0], min(values) if goal == 'min' else max(values))}"
    return "evaluating"


def log_in(folder: Path | str | None, *, fresh: bool) -> Log | None:
    """Return the log of a study's folder, to be gone on with, or with `fresh` from its end; None without."""
    if folder is None:
        return None
    log = Log(Path(folder))
    if fresh:
        log.skip()
    return log


def points_of(subject: Subject, vary: Mapping[str, Told], sample: int | None = None) -> list[Values]:
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
            dict(zip(keys, each, strict=True)) for each in itertools.product(*(k.values() for k in varied))
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
    return [{knob.key: knob.at(float(x)) for knob, x in zip(varied, place, strict=True)} for place in places]


def _next_tier(subject: Subject, question: Question, found: Ranking) -> tuple[str, float] | None:
    """The next model that leaves less out, and its seconds for the rows that tie for the first place."""
    if question.kind != "check" or not found.ties or not found.ranks or not isinstance(subject, Design):
        return None
    first = found.ties[0]
    if found.ranks[0].row not in first or question.tier not in TIERS:
        return None
    # the closed form's error is not told by what it leaves out
    names, rough = list(TIERS), question.tier == "winkler"
    least = math.inf if rough else len(TIERS[question.tier].leaves_out)
    for name in names[names.index(question.tier) + 1 :]:
        if not able(name, subject, False) and len(TIERS[name].leaves_out) <= least:
            return name, len(first) * expected(name, subject, set())
    return None
