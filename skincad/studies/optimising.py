"""Optimise: the design that does something best, and keeps what must hold.

Cheap models propose, better ones judge. The closed form is searched first, for a start; then the model that
searches, in ROUNDS; after each, what it found is asked of the judge, and by as much as that differs the next
round takes every number of the searching model.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.base.result import Result
from skincad.base.stopwatch import Tick
from skincad.inputs.design import Design
from skincad.mechanics.tiers.table import able
from skincad.scenes.scene import Scene
from skincad.studies.knobs import Knob, knobs
from skincad.studies.log import Log
from skincad.studies.measures import resolved, slack
from skincad.studies.optimisers import Front, Told, levels, minimise, optimiser
from skincad.studies.question import Evaluation, Question, question_of
from skincad.studies.ranking import ranking
from skincad.studies.running import Run, Values, Workers
from skincad.studies.running import workers as working
from skincad.studies.study import Limit, Objective, Study
from skincad.studies.subject import SKIN, Subject, Value, changed
from skincad.studies.sweeping import Sweep

ROUNDS = 2  # of searching and judging
COARSE = 600  # evaluations of the closed form
JUDGED = 6  # designs of a front that are judged, spread along it
SEARCHING = ("linear", "winkler")  # the first that takes the design


@dataclass(frozen=True)
class Member:
    """A design of the front: its values, and by the judge its objectives, and its constraints' numbers with
    whether each is kept."""

    values: Mapping[str, Value]
    objectives: Mapping[str, Estimate]
    constraints: Mapping[str, tuple[Estimate, bool]]
    tier: str

    @property
    def allowed(self) -> bool:
        """Whether all constraints are kept."""
        return all(kept for _, kept in self.constraints.values())

    def as_json(self) -> dict[str, Any]:
        """Return one entry of `front`."""
        return {
            "values": dict(self.values),
            "objectives": {key: found.as_json() for key, found in self.objectives.items()},
            "constraints": {
                key: {**found.as_json(), "kept": kept} for key, (found, kept) in self.constraints.items()
            },
            "tier": self.tier or None,
        }


@dataclass(frozen=True, repr=False)
class Optimisation(Result):
    """The judged `front` of a study, the best of the first objective first; where it is empty, the `closest`.

    `rows` are all evaluations of the searching model; `start` is the subject as the study has it, judged.
    """

    shown_by = "skincad.outputs.optimisations"
    study: Study
    subject: Subject
    front: tuple[Member, ...]
    closest: Member | None
    start: Member | None
    rows: Sweep
    judged: int
    evaluations: int
    reused: int
    seconds: float

    @property
    def name(self) -> str:
        """The study's name."""
        return self.study.name

    @property
    def feasible(self) -> bool:
        """Whether a design keeps all constraints."""
        return bool(self.front)

    def design(self, number: int = 1) -> Subject:
        """Return a member of the front as a design, scene or circuit; InputError where there is none."""
        if not 1 <= number <= len(self.front):
            raise InputError("number", f"must be from 1 to {len(self.front)}", number)
        return changed(self.subject, self.front[number - 1].values)

    def as_json(self) -> dict[str, Any]:
        """Return the result under the contract's keys."""
        return {
            "name": self.name,
            "about": self.subject.name,
            "front": [member.as_json() for member in self.front],
            "closest": self.closest and self.closest.as_json(),
            "start": self.start and self.start.as_json(),
            "tier": self.rows.question.tier,
            "judge": self.study.judge,
            "judged": self.judged,
            "evaluations": self.evaluations,
            "reused": self.reused,
            "feasible": self.feasible,
            "seconds": {"total": self.seconds},
        }


def optimise(
    study: Study,
    *,
    folder: Path | str | None = None,
    workers: int = 1,
    dask: Any = None,
    tick: Tick | None = None,
) -> Optimisation:
    """Return the best designs of a study, each judged by the model that it names.

    With a `folder` each finished evaluation goes into its log at once; asked again, an interrupted study goes
    on where it was. `workers` and `dask` are those of `sweep`. Raises InputError for keys and ranges that
    can't be used.
    """
    began = perf_counter()
    subject = study.subject()
    varied = knobs(subject, dict(study.vary))
    question = _searching(subject, study.tier)
    log = None if folder is None else Log(Path(folder))
    hunt = _Hunt(study, subject, varied, log, tick)
    with working(workers, dask) as who:
        start = hunt.judged({}, question, who)
        place = hunt.coarse(question)
        members: list[Member] = []
        for number in range(ROUNDS):
            front = hunt.searched(question, place, (number + 1) * study.evaluations // ROUNDS, who)
            for told in _spread(front.best, JUDGED):
                values = hunt.values(told.place)
                member = hunt.judged(values, question, who)
                if member is not None and member.values not in [each.values for each in members]:
                    members.append(member)
            best = hunt.ordered(members)
            place = hunt.place(best[0].values) if best else place
            hunt.correct(best[:1], question, who)
    if log is not None:
        log.close()
    allowed = [each for each in hunt.ordered(members) if each.allowed]
    found = tuple(hunt.unbeaten(allowed))
    closest = None if found else next(iter(hunt.ordered(members)), None)
    rows = hunt.rows(question)
    asked, reused = (
        sum(run.asked for run in hunt.runs.values()),
        sum(run.reused for run in hunt.runs.values()),
    )
    seconds = perf_counter() - began
    return Optimisation(study, subject, found, closest, start, rows, len(members), asked, reused, seconds)


def _searching(subject: Subject, tier: str | None) -> Question:
    if isinstance(subject, Design) and tier is None:
        tier = next(name for name in SEARCHING if not able(name, subject, False))
    return question_of(subject, tier=tier)


def _spread(front: Sequence[Told], most: int) -> list[Told]:
    """Some of a front, its ends among them."""
    placed = sorted(front, key=lambda each: float(each.losses[0]))
    if len(placed) <= most:
        return placed
    return [placed[round(i)] for i in np.linspace(0, len(placed) - 1, most)]


@dataclass
class _Hunt:
    """One optimisation under way: its runs by question, and by how much the judge's worse end
    differs, by key and which end."""

    study: Study
    subject: Subject
    knobs: tuple[Knob, ...]
    log: Log | None
    tick: Tick | None
    runs: dict[Question, Run] = field(default_factory=dict)
    factors: dict[tuple[str, float], float] = field(default_factory=dict)
    seen: list[Evaluation] = field(default_factory=list)

    def values(self, place: Array) -> Values:
        """Return the values at a place of the unit cube."""
        return {knob.key: knob.at(float(x)) for knob, x in zip(self.knobs, place, strict=True)}

    def place(self, values: Values) -> Array:
        """Return a place of the unit cube with these values."""
        found = []
        for knob in self.knobs:
            value, count = values.get(knob.key, knob.start), levels(knob)
            if value is None:
                found.append(0.5)
            elif count:
                names = list(knob.values())
                found.append((names.index(value) + 0.5) / count if value in names else 0.5)
            else:
                found.append(knob.share(min(max(float(value), knob.low), knob.high)))
        return np.array(found)

    def coarse(self, question: Question) -> Array | None:
        """Return the best place by the closed form, or the subject's own; None where that is unknown."""
        if question.kind != "check" or question.tier == "winkler":
            return self.place({})
        rough = replace(question, tier="winkler")
        run = Run(self.subject, rough)
        front = self._minimised(run, rough, self.place({}), COARSE, Workers())
        return front.best[0].place if front.best else self.place({})

    def searched(self, question: Question, start: Array | None, most: int, who: Workers) -> Front:
        """Return the front of the searching model, in about `most` evaluations of this study so far."""
        return self._minimised(self._run(question), question, start, max(most - len(self.seen), 1), who)

    def _minimised(self, run: Run, question: Question, start: Array | None, most: int, who: Workers) -> Front:
        def function(places: list[Array]) -> list[Told]:
            values = [self.values(place) for place in places]
            found = run.at(values, who)
            if question.tier != "winkler" or question.kind != "check" or run in self.runs.values():
                self.seen += found
                if self.tick is not None:
                    self.tick("searching", len(self.seen))
            more = [self._others(each, who) for each in values]
            return [self._told(*each) for each in zip(places, found, more, strict=True)]

        study = self.study
        name = study.optimiser or ("cma" if len(study.objectives) == 1 else "nsga2")
        asking = optimiser(name, self.knobs, len(study.objectives), study.seed, start)
        return minimise(function, asking, most)

    def _run(self, question: Question) -> Run:
        if question not in self.runs:
            subject = self.subject
            if question.kind in ("check", "make") and isinstance(subject, Scene):
                subject = subject.design
            self.runs[question] = Run(subject, question, self.log)
        return self.runs[question]

    def _others(self, values: Values, who: Workers) -> dict[str, Estimate]:
        """Numbers of other results than the searching one's, the result's name before their keys."""
        told: dict[str, Estimate] = {}
        for kind in {key.partition(".")[0] for key in self._keys()} & {"make", "check"}:
            if kind == "check" and isinstance(self.subject, Design):
                continue
            own = {k.removeprefix(SKIN): v for k, v in values.items() if k.startswith(SKIN)}
            question = Question(kind, tier=self.study.tier or "linear" if kind == "check" else None)  # type: ignore[arg-type]
            (found,) = self._run(question).at([own if isinstance(self.subject, Scene) else values], who)
            if not found.refused:
                told |= {f"{kind}.{key}": each for key, each in found.results.items()}
        return told

    def _keys(self) -> list[str]:
        study = self.study
        return [each.key for each in study.objectives] + [each.key for each in study.constraints]

    def _told(self, place: Array, found: Evaluation, more: Mapping[str, Estimate]) -> Told:
        """Losses and limits at a place, by what the judge would say."""
        results = {**found.results, **more}
        if found.refused or not results:
            shape = np.full(len(self.study.objectives), np.nan), np.full(len(self._limits()), np.nan)
            return Told(place, *shape)
        losses = [self._loss(each, results) for each in self.study.objectives]
        limits = [self._excess(limit, results, side) for limit, side in self._limits()]
        return Told(place, np.array(losses), np.array(limits))

    def _limits(self) -> list[tuple[Limit, str]]:
        return [
            (limit, side)
            for limit in self.study.constraints
            for side in ("at_least", "at_most")
            if getattr(limit, side) is not None
        ]

    def _loss(self, objective: Objective, results: Mapping[str, Estimate]) -> float:
        sign = 1.0 if objective.goal == "min" else -1.0
        return sign * self._worse(objective.key, results, sign)

    def _excess(self, limit: Limit, results: Mapping[str, Estimate], side: str) -> float:
        """By how much a limit is broken, as a part of it; below 0 where it is kept."""
        bound: float = getattr(limit, side)
        sign = 1.0 if side == "at_most" else -1.0
        return sign * (self._worse(limit.key, results, sign) - bound) / (abs(bound) or 1.0)

    def _worse(self, key: str, results: Mapping[str, Estimate], sign: float) -> float:
        """A number's worse end, or as the judge was off where that is known; NaN where there is none."""
        name = resolved(key, results, what="key")
        found = results[name]
        if found.value is None:
            return math.nan
        if (name, sign) in self.factors:
            return found.value * self.factors[name, sign]
        return found.value + (sign * slack(found) if self.study.robust else 0.0)

    def judged(self, values: Values, question: Question, who: Workers) -> Member | None:
        """Return what the judge says of some values; None where it refuses them."""
        asked = replace(question, tier=self.study.judge) if question.kind == "check" else question
        (found,) = self._run(asked).at([values], who)
        if found.refused or not found.results:
            return None
        results = {**found.results, **self._others(values, who)}
        factors, self.factors = self.factors, {}  # the judge's own numbers, as they are
        kept = {
            resolved(limit.key, results, what="key"): self._excess(limit, results, side) <= 0
            for limit, side in self._limits()
        }
        self.factors = factors
        wanted = [resolved(each.key, results, what="key") for each in self.study.objectives]
        return Member(
            dict(values),
            {key: results[key] for key in wanted},
            {key: (results[key], good) for key, good in kept.items()},
            found.tier,
        )

    def correct(self, best: Sequence[Member], question: Question, who: Workers) -> None:
        """Take from the best member how the judge differs from the searching model, by key."""
        for member in best:
            (found,) = self._run(question).at([member.values], who)
            told = {**member.objectives, **{key: each for key, (each, _) in member.constraints.items()}}
            wanted = [(o.key, 1.0 if o.goal == "min" else -1.0) for o in self.study.objectives]
            wanted += [(limit.key, 1.0 if side == "at_most" else -1.0) for limit, side in self._limits()]
            for key, sign in wanted:
                name = resolved(key, told, what="key")
                mine, each = found.results.get(name), told[name]
                if mine is None or not mine.value or each.value is None:
                    continue
                worse = each.value + (sign * slack(each) if self.study.robust else 0.0)
                if worse / mine.value > 0:
                    self.factors[name, sign] = worse / mine.value

    def ordered(self, members: Sequence[Member]) -> list[Member]:
        """Return members, those that keep all constraints first, the best of the first objective first."""
        return sorted(members, key=lambda each: (not each.allowed, self._losses(each)[0]))

    def unbeaten(self, members: Sequence[Member]) -> list[Member]:
        """Return the members that no other one beats in all objectives."""
        told = [Told(np.zeros(0), np.array(self._losses(each)), np.zeros(0)) for each in members]
        best = Front(told).best if told else []
        return [
            member for member, each in zip(members, told, strict=True) if any(each is one for one in best)
        ]

    def _losses(self, member: Member) -> list[float]:
        factors, self.factors = self.factors, {}
        found = [self._loss(each, member.objectives) for each in self.study.objectives]
        self.factors = factors
        return found

    def rows(self, question: Question) -> Sweep:
        """Return what the searching model was asked, as the rows of a sweep."""
        unique = {each.key: each for each in self.seen}
        rows = tuple(unique.values())
        ranked = tuple(
            ranking(rows, each.key, each.goal) for each in self.study.objectives if "." not in each.key
        )
        return Sweep(self.subject, question, self.knobs, rows, ranked, None, 0, 0, 0.0)
