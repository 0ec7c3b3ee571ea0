"""Optimise: the design that does something best, and keeps what must hold.

Cheap models propose, a better one judges. By as much as the judge differed on the last design that it was
asked of, every number of a cheap model is taken larger or smaller: so the closed form, a thousandth of the
time, is searched and judged first, MAPPED times; then the model that searches, in ROUNDS.
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
from skincad.base.estimate import Estimate
from skincad.base.stopwatch import Tick
from skincad.inputs.design import Design
from skincad.scenes.scene import Scene
from skincad.studies.asking import GUIDE
from skincad.studies.knobs import Knob, knobs
from skincad.studies.log import Log
from skincad.studies.measures import resolved, slack
from skincad.studies.optimisation import Member, Optimisation
from skincad.studies.optimisers import Told, Tried, levels, minimise, optimiser
from skincad.studies.question import Evaluation, Question, first_able, question_of
from skincad.studies.ranking import ranking
from skincad.studies.running import Run, Values, Workers
from skincad.studies.running import workers as working
from skincad.studies.study import Limit, Objective, Study
from skincad.studies.subject import SKIN, Subject
from skincad.studies.sweeping import RANKED_BY, SweepResult, log_in

MAPPED, ROUNDS = 3, 2  # searches of the closed form and of the model, each judged
COARSE = 600  # evaluations of the closed form in a search
SAME = 0.01  # of the cube: a place this near to the last one is not judged again
DIFFERENCES = ("margin_N",)  # numbers that may be 0: two models of them differ by so much, not by a factor
JUDGED = 6  # designs of a front that are judged, spread along it
OTHERS = {"make", "check"}  # results beside the searching one's, before whose keys their name stands
JUDGE = ""  # in the place of a tier: numbers that are taken as they are


def optimise(
    study: Study,
    *,
    folder: Path | str | None = None,
    fresh: bool = False,
    workers: int = 1,
    dask: Any = None,
    tick: Tick | None = None,
) -> Optimisation:
    """Return the best designs of a study, each judged by the model that it names.

    With a `folder` each finished evaluation goes into its log at once; asked again, an interrupted study goes
    on where it was, unless `fresh`. `workers` and `dask` are those of `sweep`. Raises InputError for keys and
    ranges that can't be used.
    """
    began = perf_counter()
    subject = study.subject()
    varied = knobs(subject, dict(study.vary))
    question = _searching(subject, study.tier)
    log = log_in(folder, fresh=fresh)
    hunt = _Hunt(study, subject, varied, log, tick)
    with working(workers, dask) as who:
        start = hunt.judged({}, question, who)
        hunt.correct(start, question, who)
        place, members = hunt.coarse(question, who)
        for number in range(ROUNDS):
            tried = hunt.searched(question, place, (number + 1) * study.evaluations // ROUNDS, who)
            for told in _spread(tried.front, JUDGED):
                values = hunt.values(told.place)
                member = hunt.judged(values, question, who)
                if member is not None and member.values not in [each.values for each in members]:
                    members.append(member)
            best = hunt.ordered(members)
            place = hunt.place(best[0].values) if best else place
            hunt.correct(next(iter(best), None), question, who)
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
        tier = first_able(RANKED_BY, subject)
    return question_of(subject, tier=tier)


def _spread(front: Sequence[Told], most: int) -> list[Told]:
    """Some of a front, its ends among them."""
    placed = sorted(front, key=lambda each: float(each.losses[0]))
    if len(placed) <= most:
        return placed
    return [placed[round(i)] for i in np.linspace(0, len(placed) - 1, most)]


def _sign(of: Objective | str) -> float:
    """1 where larger is worse, -1 where smaller is."""
    return 1.0 if of == "at_most" or (isinstance(of, Objective) and of.goal == "min") else -1.0


@dataclass
class _Hunt:
    """One optimisation under way: its runs by question, and by tier, key and which end the factor and the
    difference of the judge's worse end from a model's value."""

    study: Study
    subject: Subject
    knobs: tuple[Knob, ...]
    log: Log | None
    tick: Tick | None
    runs: dict[Question, Run] = field(default_factory=dict)
    differs: dict[tuple[str, str, float], tuple[float, float]] = field(default_factory=dict)
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

    def coarse(self, question: Question, who: Workers) -> tuple[Array, list[Member]]:
        """Return the best place by the closed form, or the subject's own, and what was judged on the way."""
        place, members = self.place({}), list[Member]()
        if question.kind != "check" or question.tier == GUIDE:
            return place, members
        rough = replace(question, tier=GUIDE)
        for _ in range(MAPPED):
            tried = self._minimised(rough, place, COARSE, Workers(), rough=True)
            best = tried.front[0]
            if not best.there or (members and float(np.abs(best.place - place).max()) < SAME):
                break
            place, member = best.place, self.judged(self.values(best.place), question, who)
            if member is None:
                break
            members.append(member)
            self.correct(member, question, who)
        best_member = next(iter(self.ordered(members)), None)
        return (self.place(best_member.values) if best_member else place), members

    def searched(self, question: Question, start: Array | None, most: int, who: Workers) -> Tried:
        """Return the front of the searching model, in about `most` evaluations of this study so far."""
        return self._minimised(question, start, max(most - len(self.seen), 1), who)

    def _minimised(
        self, question: Question, start: Array | None, most: int, who: Workers, *, rough: bool = False
    ) -> Tried:
        def function(places: list[Array]) -> list[Told]:
            values = [self.values(place) for place in places]
            found = self._run(question).at(values, who)
            if rough:
                return [self._told(place, each, {}, rough) for place, each in zip(places, found, strict=True)]
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
            cheap = question.tier == GUIDE and GUIDE not in (self.study.tier, self.study.judge)
            self.runs[question] = Run(subject, question, None if cheap else self.log)
        return self.runs[question]

    def _others(self, values: Values, who: Workers) -> dict[str, Estimate]:
        """Numbers of other results than the searching one's, the result's name before their keys."""
        told: dict[str, Estimate] = {}
        for kind in {key.partition(".")[0] for key in self._keys()} & OTHERS:
            if kind == "check" and isinstance(self.subject, Design):
                continue
            own = {k.removeprefix(SKIN): v for k, v in values.items() if k.startswith(SKIN)}
            question = Question(kind, tier=self.study.tier or "linear" if kind == "check" else None)  # type: ignore[arg-type]
            (found,) = self._run(question).at([own if isinstance(self.subject, Scene) else values], who)
            if not found.refused:
                told |= {f"{kind}.{key}": each for key, each in found.results.items()}
        return told

    def _own(self, values: Values) -> dict[str, Estimate]:
        """The varied numbers themselves, which an objective or a limit may be about."""
        units = {knob.key: knob.unit for knob in self.knobs}
        return {
            key: Estimate(float(value), 0.0, units[key])
            for key, value in values.items()
            if not isinstance(value, str)
        }

    def _keys(self) -> list[str]:
        study = self.study
        return [each.key for each in study.objectives] + [each.key for each in study.constraints]

    def _told(
        self, place: Array, found: Evaluation, more: Mapping[str, Estimate], rough: bool = False
    ) -> Told:
        """Losses and limits at a place, by what the judge would say; `rough`: limits of numbers that the
        model does not tell are taken as kept."""
        results = {**found.results, **more, **self._own(found.values)}
        if found.refused or not found.results:
            shape = np.full(len(self.study.objectives), np.nan), np.full(len(self._limits()), np.nan)
            return Told(place, *shape)
        losses = [self._loss(each, results, found.tier) for each in self.study.objectives]
        limits = [self._excess(limit, results, side, found.tier) for limit, side in self._limits()]
        kept = np.nan_to_num(limits, nan=-1.0) if rough else np.array(limits)
        return Told(place, np.array(losses), kept)

    def _limits(self) -> list[tuple[Limit, str]]:
        return [
            (limit, side)
            for limit in self.study.constraints
            for side in ("at_least", "at_most")
            if getattr(limit, side) is not None
        ]

    def _loss(self, objective: Objective, results: Mapping[str, Estimate], tier: str) -> float:
        sign = _sign(objective)
        return sign * self._worse(objective.key, results, sign, tier)

    def _excess(self, limit: Limit, results: Mapping[str, Estimate], side: str, tier: str) -> float:
        """By how much a limit is broken, as a part of it; below 0 where it is kept."""
        bound: float = getattr(limit, side)
        sign = _sign(side)
        return sign * (self._worse(limit.key, results, sign, tier) - bound) / (abs(bound) or 1.0)

    def _worse(self, key: str, results: Mapping[str, Estimate], sign: float, tier: str) -> float:
        """A number's worse end, as the judge would have it where that is known; NaN where there is none."""
        kind = key.partition(".")[0]
        if kind in OTHERS and not any(each.startswith(f"{kind}.") for each in results):
            return math.nan
        name = resolved(key, results, what="key")
        found = results[name]
        if found.value is None:
            return math.nan
        factor, more = self.differs.get((tier, name, sign), (1.0, sign * self._slack(found)))
        return found.value * factor + more

    def _slack(self, found: Estimate) -> float:
        return slack(found) if self.study.robust else 0.0

    def judged(self, values: Values, question: Question, who: Workers) -> Member | None:
        """Return what the judge says of some values; None where it refuses them."""
        asked = replace(question, tier=self.study.judge) if question.kind == "check" else question
        values = values or {k.key: k.start for k in self.knobs if k.start is not None}
        (found,) = self._run(asked).at([values], who)
        if found.refused or not found.results:
            return None
        results = {**found.results, **self._others(values, who), **self._own(values)}
        kept: dict[str, bool] = {}
        for limit, side in self._limits():
            key = resolved(limit.key, results, what="key")
            kept[key] = kept.get(key, True) and self._excess(limit, results, side, JUDGE) <= 0
        wanted = [resolved(each.key, results, what="key") for each in self.study.objectives]
        return Member(
            dict(values),
            {key: results[key] for key in wanted},
            {key: (results[key], good) for key, good in kept.items()},
            found.tier,
        )

    def correct(self, member: Member | None, question: Question, who: Workers) -> None:
        """Take from a judged design how the judge's worse ends differ from what the cheaper models say."""
        if member is None:
            return
        told = {**member.objectives, **{key: each for key, (each, _) in member.constraints.items()}}
        wanted = [(each.key, _sign(each)) for each in self.study.objectives]
        wanted += [(limit.key, _sign(side)) for limit, side in self._limits()]
        models = [question] + [replace(question, tier=GUIDE)] * (question.kind == "check")
        for model in models:
            (found,) = self._run(model).at([member.values], who)
            if found.tier == member.tier:
                continue  # its own errors are known everywhere
            for key, sign in wanted:
                name = resolved(key, told, what="key")
                mine, each = found.results.get(name), told[name]
                if mine is None or mine.value is None or each.value is None:
                    continue
                worse = each.value + sign * self._slack(each)
                by_factor = name not in DIFFERENCES and worse * mine.value > 0
                self.differs[found.tier, name, sign] = (
                    (worse / mine.value, 0.0) if by_factor else (1.0, worse - mine.value)
                )

    def ordered(self, members: Sequence[Member]) -> list[Member]:
        """Return members, those that keep all constraints first, the best of the first objective first."""
        return sorted(members, key=lambda each: (not each.allowed, self._losses(each)[0]))

    def unbeaten(self, members: Sequence[Member]) -> list[Member]:
        """Return the members that no other one beats in all objectives; of one objective the first alone."""
        if len(self.study.objectives) == 1:
            return list(members[:1])
        told = [Told(np.zeros(0), np.array(self._losses(each)), np.zeros(0)) for each in members]
        best = Tried(told).front if told else []
        return [
            member for member, each in zip(members, told, strict=True) if any(each is one for one in best)
        ]

    def _losses(self, member: Member) -> list[float]:
        return [self._loss(each, member.objectives, JUDGE) for each in self.study.objectives]

    def rows(self, question: Question) -> SweepResult:
        """Return what the searching model was asked, as the rows of a sweep."""
        unique = {each.key: each for each in self.seen}
        rows = tuple(unique.values())
        ranked = tuple(
            ranking(rows, each.key, each.goal) for each in self.study.objectives if "." not in each.key
        )
        return SweepResult(self.subject, question, self.knobs, rows, ranked, None, 0, 0, 0.0)
