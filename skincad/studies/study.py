"""A study as a person writes it, what it aims at, and its result.

What a study's objectives and limits make of results: losses, and by how much each limit is broken. By as much
as the judge's numbers differed from a model's on the last design that both saw, the model's are taken larger
or smaller everywhere; before that, by their own error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.base.result import Record, Result, columns_of, item, record, reported, reported_from
from skincad.base.tables import Document, Table
from skincad.inputs.catalog import read_table, setting_key
from skincad.mechanics.models.table import model_named
from skincad.studies.optimisers import OPTIMISERS, OptimiserName, Outcome, check_losses, either, pareto_front
from skincad.studies.query import Kind, resolved, slack, total_seconds
from skincad.studies.subject import Subject, Value, changed, load_subject
from skincad.studies.sweeping import SweepResult

KEY = "the result's key in --json, another result's after make. or check., or a varied key"
FORM = 1  # of the file; a later skincad that reads it otherwise counts on


def _flat(data: Any) -> Any:
    """Keys with dots, whether they were written in quotes or as tables in each other."""
    if not isinstance(data, dict):
        return data
    flat: dict[str, Any] = {}
    for key, value in data.items():
        if isinstance(value, dict):
            flat |= {f"{key}.{inner}": inner_value for inner, inner_value in _flat(value).items()}
        else:
            flat[str(key)] = value
    return flat


class Objective(Table):
    """A number of the result that is to be small or large."""

    key: str = Field(description=KEY)
    goal: Literal["min", "max"] = Field(default="min", description="min or max")


class Limit(Table):
    """A number of the result that must lie within limits, with its error."""

    key: str = Field(description=KEY)
    at_least: float | None = Field(default=None, description="the least that it may be")
    at_most: float | None = Field(default=None, description="the most that it may be")

    @model_validator(mode="after")
    def _some(self) -> Self:
        if self.at_least is None and self.at_most is None:
            raise InputError("", "needs at_least or at_most", self.key, "give one of them")
        return self


class Study(Document):
    """A search for the best design, scene or circuit: frozen, as its file says.

    Raises InputError for the rules that are broken.
    """

    form: int = Field(default=FORM, description="of this file; leave it as it is")
    about: str = Field(
        description="the design, scene or circuit that it starts from: a template or a TOML file"
    )
    settings: tuple[str, ...] = Field(
        default=(), strict=False, description="overrides of that, as after --set: ridge.count=7"
    )
    vary: Annotated[dict[str, str | list[Any]], BeforeValidator(_flat)] = Field(
        description="keys and what they may be: LOW:HIGH, all, or a list"
    )
    objectives: tuple[Objective, ...] = Field(strict=False, description="what is to be small or large")
    constraints: tuple[Limit, ...] = Field(default=(), strict=False, description="what must hold")
    optimiser: OptimiserName | None = Field(
        default=None,
        description=f"{either(OPTIMISERS)}; if not given, the one that suits the keys and objectives",
    )
    evaluations: int = Field(default=200, ge=1, le=1_000_000, description="of the model that searches, about")
    model: str | None = Field(default=None, description="the model that searches; linear if not given")
    judge: str = Field(default="auto", description="the model that has the last word on what is found")
    hold: str | float | None = Field(
        default=None,
        description="an object's mass, 0.3kg or 300 g: checks of a design say what the mount's gripper holds",
    )
    robust: bool = Field(default=True, description="judge by the worse end of each error, not by the value")
    seed: int = Field(default=1, ge=0, le=2**31, description="of the optimiser; the same seed asks the same")

    @model_validator(mode="before")
    @classmethod
    def _second_name(cls, data: dict[str, Any]) -> dict[str, Any]:
        """`model` was called `tier` before; with both, `tier` is an unknown key."""
        names = {} if "model" in data else {"tier": "model"}
        return {names.get(key, key): value for key, value in data.items()}

    @model_validator(mode="after")
    def _rules(self) -> Self:
        if self.form != FORM:
            rule = f"must be {FORM}: this skincad reads no other form of study"
            raise InputError("form", rule, self.form, "write the study anew after a template")
        if not self.vary:
            raise InputError("vary", "names no key", remedy='as in "ridge.height" = "0.4:0.6"')
        if not self.objectives:
            raise InputError("objectives", "names none", remedy="add [[objectives]]")
        for key, model in (("model", self.model), ("judge", self.judge)):
            if model not in (None, "auto"):
                try:
                    model_named(str(model))
                except InputError as failure:
                    raise InputError(key, failure.rule, model, failure.remedy) from None
        if self.model == "auto":
            raise InputError("model", "must be one model, for all to be compared by", "auto", "try linear")
        if self.optimiser is not None:
            check_losses(self.optimiser, len(self.objectives))
        return self

    @property
    def aims(self) -> list[str]:
        """The keys of objectives and constraints."""
        return [aim.key for aim in self.objectives] + [aim.key for aim in self.constraints]

    def subject(self) -> Subject:
        """Return what the study starts from."""
        return load_subject(self.about, list(self.settings))


def load_study(source: str | Path, settings: list[str] | tuple[str, ...] = ()) -> Study:
    """Return the study of a template's name or of a TOML file, with more `settings` of what it is about.

    A path in the file counts from the file. Raises InputError with key, rule, value and remedy.
    """
    data = dict(read_table(source, "studies"))
    about = data.get("about")
    if isinstance(about, str) and about.endswith(".toml") and Path(source).suffix == ".toml":
        data["about"] = str((Path(source).parent / about).absolute())
    written = data.get("settings", [])
    if settings and isinstance(written, list):
        changed = {setting_key(text) for text in settings}
        data["settings"] = [*(text for text in written if setting_key(str(text)) not in changed), *settings]
    return Study(**data)


OTHERS: tuple[Kind, ...] = (
    "make",
    "check",
)  # results beside the searching one's, before whose keys their name stands
DIFFERENCES = ("margin_N",)  # numbers that may be 0: two models of them differ by so much, not by a factor
Results = Mapping[str, Estimate]
Model = Literal[
    "guide", "search", "judge"
]  # the closed form, the one that searches, and who has the last word


def _sign(of: Objective | str) -> float:
    """1 where larger is worse, -1 where smaller is."""
    return 1.0 if of == "at_most" or (isinstance(of, Objective) and of.goal == "min") else -1.0


@dataclass
class RobustObjective:
    """A study's aims, and by model, key and which end is worse the factor and the difference of the judge's
    worse end from the model's value."""

    study: Study
    differs: dict[tuple[Model, str, float], tuple[float, float]] = field(default_factory=dict)

    def others(self) -> list[Kind]:
        """Return the names of the other results that objectives and limits are about."""
        return [kind for kind in OTHERS if any(key.startswith(f"{kind}.") for key in self.study.aims)]

    def told(self, place: Array, results: Results | None, model: Model) -> Outcome:
        """Return losses and limits at a place by what the judge would say; limits of numbers that the closed
        form does not tell are taken as kept."""
        if not results:
            return Outcome(
                place, np.full(len(self.study.objectives), np.nan), np.full(len(self._limits()), np.nan)
            )
        limits = np.array([self._excess(limit, results, side, model) for limit, side in self._limits()])
        margins = np.nan_to_num(limits, nan=-1.0) if model == "guide" else limits
        return Outcome(place, np.array(self._losses(results, model)), margins)

    def member(self, values: Mapping[str, float | int | str], results: Results, model: str) -> Member:
        """Return what the judge's results make of a design."""
        met: dict[str, bool] = {}
        for limit, side in self._limits():
            key = resolved(limit.key, results, what="key")
            met[key] = met.get(key, True) and self._excess(limit, results, side, "judge") <= 0
        wanted = [resolved(objective.key, results, what="key") for objective in self.study.objectives]
        return Member(
            values=dict(values),
            objectives={key: results[key] for key in wanted},
            constraints={key: (results[key], good) for key, good in met.items()},
            model=model,
        )

    def correct(self, member: Member, results: Results, model: Model) -> None:
        """Take from a judged design how the judge's worse ends differ from what a model says of it."""
        judged = {**member.objectives, **{key: estimate for key, (estimate, _) in member.constraints.items()}}
        wanted = [(estimate.key, _sign(estimate)) for estimate in self.study.objectives]
        wanted += [(limit.key, _sign(side)) for limit, side in self._limits()]
        for key, sign in wanted:
            name = resolved(key, judged, what="key")
            mine, estimate = results.get(name), judged[name]
            if mine is None or mine.value is None or estimate.value is None or mine == estimate:
                continue  # what both say alike, each design has with its own error
            worse = estimate.value + sign * self._slack(estimate)
            by_factor = name.rpartition(".")[2] not in DIFFERENCES and worse * mine.value > 0
            self.differs[model, name, sign] = (
                (worse / mine.value, 0.0) if by_factor else (1.0, worse - mine.value)
            )

    def ordered(self, members: Sequence[Member]) -> list[Member]:
        """Return members, those that keep all constraints first, the best of the first objective first."""
        return sorted(members, key=lambda each: (not each.allowed, self._losses(each.objectives, "judge")[0]))

    def pareto_front(self, members: Sequence[Member]) -> list[Member]:
        """Return the members that no other one beats in all objectives; of one objective the first alone.

        The first few cover the front: each is the one that is farthest from those before it.
        """
        if len(self.study.objectives) == 1:
            return list(members[:1])
        rows = [np.array(self._losses(member.objectives, "judge")) for member in members]
        outcomes = [Outcome(np.array([i]), row, np.zeros(0)) for i, row in enumerate(rows)]
        chosen = pareto_front(outcomes)
        front = [members[int(outcome.place[0])] for outcome in chosen]
        losses = np.array([outcome.losses for outcome in chosen])
        order = list(range(len(front)))
        for i in range(1, len(front)):
            gaps = np.abs(losses[order[i:], None] - losses[order[:i]]) / (np.ptp(losses, axis=0) + 1e-300)
            farthest = i + int(np.argmax(gaps.max(axis=2).min(axis=1)))
            order[i], order[farthest] = order[farthest], order[i]
        return [front[i] for i in order]

    def _limits(self) -> list[tuple[Limit, str]]:
        return [
            (limit, side)
            for limit in self.study.constraints
            for side in ("at_least", "at_most")
            if getattr(limit, side) is not None
        ]

    def _losses(self, results: Results, model: Model) -> list[float]:
        return [
            _sign(objective) * self._worse(objective.key, results, _sign(objective), model)
            for objective in self.study.objectives
        ]

    def _excess(self, limit: Limit, results: Results, side: str, model: Model) -> float:
        """By how much a limit is broken, as a part of it; below 0 where it is kept."""
        bound: float = getattr(limit, side)
        sign = _sign(side)
        return sign * (self._worse(limit.key, results, sign, model) - bound) / (abs(bound) or 1.0)

    def _worse(self, key: str, results: Results, sign: float, model: Model) -> float:
        """A number's worse end, as the judge would have it where that is known; NaN where there is none."""
        kind = key.partition(".")[0]
        if kind in OTHERS and not any(result.startswith(f"{kind}.") for result in results):
            return math.nan
        name = resolved(key, results, what="key")
        estimate = results[name]
        if estimate.value is None:
            return math.nan
        factor, more = self.differs.get((model, name, sign), (1.0, sign * self._slack(estimate)))
        return estimate.value * factor + more

    def _slack(self, estimate: Estimate) -> float:
        return slack(estimate) if self.study.robust else 0.0


@record()
class Member(Record):
    """A design of the front: its values, and by the judge its objectives, and its constraints' numbers with
    whether each is kept."""

    values: Mapping[str, Value] = item(meaning="of the varied keys")
    objectives: Mapping[str, Estimate] = item(meaning="by the judge")
    constraints: Mapping[str, tuple[Estimate, bool]]
    model: str = item(meaning="of the judge", key="tier", null=True)

    @reported(meaning="by the judge, and whether each is kept", key="constraints")
    def _constraints(self) -> dict[str, dict[str, Any]]:
        return {key: {**number.as_json(), "kept": met} for key, (number, met) in self.constraints.items()}

    @property
    def allowed(self) -> bool:
        """Whether all constraints are kept."""
        return all(met for _, met in self.constraints.values())


@record()
class Optimisation(Result):
    """The judged `front` of a study; `rows` are all evaluations of the searching model."""

    shown_by = "skincad.outputs.studies:OPTIMISATION"
    study: Study
    subject: Subject
    front: tuple[Member, ...] = item(meaning="the best of the first objective first")
    closest: Member | None = item(meaning="where the front is empty, the one that misses least")
    start: Member | None = item(meaning="the subject as the study has it, judged")
    rows: SweepResult
    judged: int = item(meaning="how many the judge was asked of")
    untried: int | None = item(meaning="combinations not tried; null if a key has a continuous range")
    evaluations: int = item(meaning="computed now")
    reused: int = item(meaning="that a log had")
    seconds: float  # wall time of this run

    name = reported_from("study.name", meaning="of the study")

    about = reported_from("subject.name", meaning="what it starts from")

    model = reported_from("rows.question.model", meaning="the model that searched", key="tier")

    judge = reported_from("study.judge", meaning="the model that has the last word")

    _seconds = total_seconds

    @reported(meaning="whether a design keeps all constraints")
    def feasible(self) -> bool:
        """Whether a design keeps all constraints."""
        return bool(self.front)

    def columns(self) -> dict[str, Any]:
        """Return a row for each member of the front: the values of the varied keys, with their units,
        objectives, and the numbers of the constraints."""
        return columns_of(
            {
                **{knob.column: member.values.get(knob.key) for knob in self.rows.knobs},
                **member.objectives,
                **{key: number for key, (number, _) in member.constraints.items()},
                "model": member.model,
            }
            for member in self.front
        )

    @property
    def aims(self) -> list[str]:
        """The keys of objectives and constraints, as results have them."""
        member = next(iter([*self.front, *filter(None, [self.closest, self.start])]), None)
        return [] if member is None else [*member.objectives, *member.constraints]

    def design(self, number: int = 1) -> Subject:
        """Return a member of the front as a design, scene or circuit; InputError where there is none."""
        if not 1 <= number <= len(self.front):
            raise InputError("number", f"must be from 1 to {len(self.front)}", number)
        return changed(self.subject, self.front[number - 1].values)

    @property
    def exit_status(self) -> int:
        """0 where a design keeps all limits, else 1."""
        return 0 if self.feasible else 1
