"""Optimise: the design that does something best, and keeps what must hold.

Cheap models propose, a better one judges. By as much as the judge differed on the last design that it was
asked of, every number of a cheap model is taken larger or smaller: so the closed form, a thousandth of the
time, is searched and judged first, MAPPED times; then the model that searches, in ROUNDS.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.estimate import Estimate
from skincad.base.progress import Tick
from skincad.inputs.design import Design
from skincad.scenes.scene import Scene
from skincad.studies.optimisers import Optimiser, Outcome, minimise, optuna_search, pareto_front
from skincad.studies.query import GUIDE, Evaluation, Query, first_able, meant, question_of, worded
from skincad.studies.running import Log, Run, Values, Workers, log_in
from skincad.studies.running import workers as working
from skincad.studies.searches import combinations, search
from skincad.studies.study import Member, Model, Optimisation, Results, RobustObjective, Study
from skincad.studies.subject import SKIN, DesignVariable, Subject, Value, knobs, values_at
from skincad.studies.sweeping import RANKED_BY, SweepResult, ranking

MAPPED, ROUNDS = 5, 3  # searches of the closed form, and parts of the model's, each judged at its end
COARSE = 600  # evaluations of the closed form in a search
SAME = 0.01  # of the cube: a place this near to the last one is not judged again
JUDGED = 6  # designs of a front that are judged, spread along it


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
    log, weighing, model = log_in(folder, fresh=fresh), RobustObjective(study), study.model
    if isinstance(subject, Design) and model is None:
        model = first_able(RANKED_BY, subject)
    if isinstance(subject, Scene) and "check" in weighing.others():
        model = None  # it is that of the checks beside
    hunt = _Hunt(
        study, subject, question_of(subject, model=model, hold=study.hold), varied, log, tick, weighing
    )
    with working(workers, dask) as who:
        start = hunt.judged({}, who)
        hunt.correct(start, who)
        place, members = hunt.coarse(who)
        for number in range(ROUNDS):
            front = hunt.searched(place, (number + 1) * study.evaluations // ROUNDS, who)
            chosen = front if hunt.judges_free else _spread(front, JUDGED)
            judged = [hunt.judged(values_at(varied, chosen_member.place), who) for chosen_member in chosen]
            there = [member for member in judged if member is not None]
            members += [other for other in there if other.values not in [m.values for m in members]]
            hunt.correct(next(iter(there), None), who)  # also where the judge says that a limit is broken
    log.close()
    ordered = weighing.ordered(members)
    best_members = tuple(weighing.pareto_front([member for member in ordered if member.allowed]))
    count = combinations(varied)
    asked = [run for question, run in hunt.runs.items() if not hunt.is_guide(question)]
    return Optimisation(
        study=study,
        subject=subject,
        front=best_members,
        closest=None if best_members else next(iter(ordered), None),
        start=start,
        rows=hunt.rows(),
        judged=len(members),
        untried=None if count is None else count - len(hunt.known["search"]),
        evaluations=sum(run.evaluated for run in asked),
        reused=sum(run.reused for run in asked),
        seconds=perf_counter() - began,
    )


def _spread(front: Sequence[Outcome], most: int) -> list[Outcome]:
    """Some of a front, its ends among them."""
    placed = sorted(front, key=lambda each: float(each.losses[0]))
    if len(placed) <= most:
        return placed
    return [placed[round(i)] for i in np.linspace(0, len(placed) - 1, most)]


# a place, a model's answer there, and all numbers of the design; None where one of them is refused
Known = tuple[Array, Evaluation, Results | None]


@dataclass
class _Hunt:
    """One optimisation under way: its runs by question, and by model all that it knows, by the values."""

    study: Study
    subject: Subject
    question: Query
    knobs: tuple[DesignVariable, ...]
    log: Log
    tick: Tick | None
    weighing: RobustObjective
    runs: dict[Query, Run] = field(default_factory=dict)
    known: dict[Model, dict[tuple[Value, ...], Known]] = field(
        default_factory=lambda: {"guide": {}, "search": {}}
    )
    asking: Optimiser | None = None
    best: float | None = None  # the first objective's least loss that keeps all limits, by its worse end
    aims: dict[Any, Any] = field(default_factory=dict)

    def place(self, values: Values) -> Array:
        """Return a place of the unit cube with these values."""
        return np.array([knob.share(values.get(knob.key, knob.start)) for knob in self.knobs])

    def coarse(self, who: Workers) -> tuple[Array, list[Member]]:
        """Return the best place by the closed form, or the subject's own, and what was judged on the way."""
        place, members = self.place({}), list[Member]()
        held = self.question.hold is not None  # of which the closed form knows nothing
        if self.question.kind != "check" or self.question.model == GUIDE or held:
            return place, members
        for _ in range(MAPPED):
            evaluations = self._minimised("guide", self._search(place, COARSE), COARSE, Workers())
            best = pareto_front(evaluations)[0]
            if not best.there or (members and float(np.abs(best.place - place).max()) < SAME):
                break
            place, member = best.place, self.judged(values_at(self.knobs, best.place), who)
            if member is None:
                break
            members.append(member)
            self.correct(member, who)
        best_member = next(iter(self.weighing.ordered(members)), None)
        return (self.place(best_member.values) if best_member else place), members

    def searched(self, start: Array, most: int, who: Workers) -> list[Outcome]:
        """Return the front of all that the searching model was asked, in about `most` evaluations of this
        study so far.

        One objective is searched anew from its best place where the judge has moved it, since CMA-ES has
        settled by then; `start` is where the first search begins.
        """
        aims, budget = dict(self.weighing.differs), self.study.evaluations
        count = combinations(self.knobs)
        if count is not None and count <= budget:
            most = count
        elif not self.judges_free:
            budget = max(budget // ROUNDS, 1)  # of a search, which begins again as the judge moves it
        if self.asking is None or (len(self.study.objectives) == 1 and aims != self.aims):
            front = self._front()
            self.asking = self._search(front[0].place if front and front[0].there else start, budget)
        self.aims, self.best = aims, _better(None, self._front())
        self._minimised("search", self.asking, most - len(self.known["search"]), who)
        if count is not None and len(self.known["search"]) < min(most, count):
            objectives, known = len(self.study.objectives), self._evaluations()
            self.asking = optuna_search("tpe", self.knobs, objectives, self.study.seed, start, budget, known)
            self._minimised("search", self.asking, most - len(self.known["search"]), who)
        return self._front()

    def _front(self) -> list[Outcome]:
        return pareto_front(self._evaluations())

    def _evaluations(self) -> list[Outcome]:
        return [
            self.weighing.told(place, results, "search")
            for place, _, results in self.known["search"].values()
        ]

    @property
    def judges_free(self) -> bool:
        """Whether the judge is the model that searches, so that its word costs nothing."""
        return self._questions("judge") == self._questions("search")

    def judged(self, values: Values, who: Workers) -> Member | None:
        """Return what the judge says of some values, of none the subject's own; None where it refuses."""
        values = values or {k.key: k.start for k in self.knobs if k.start is not None}
        ((evaluation, results),) = self._told([values], "judge", who)
        return None if results is None else self.weighing.member(values, results, evaluation.model)

    def correct(self, member: Member | None, who: Workers) -> None:
        """Take from a judged design how the judge differs from the cheaper models."""
        if member is None:
            return
        guided = self.question.kind == "check" and self.question.hold is None
        models: list[Model] = ["search", "guide"] if guided else ["search"]
        for model in models:
            ((_, results),) = self._told([member.values], model, who)
            if results is not None:
                self.weighing.correct(member, results, model)

    def rows(self) -> SweepResult:
        """Return what the searching model was asked, as the rows of a sweep."""
        unique = dict[str, Evaluation]()
        for _, answer, results in self.known["search"].values():
            own = {**answer.results, **answer.values}
            beside = {key: estimate for key, estimate in (results or {}).items() if key not in own}
            aims = {key: beside[key] for aim in self.study.aims if (key := meant(aim, beside))}
            unique[answer.key] = replace(answer, results={**answer.results, **aims})
        rows = tuple(unique.values())
        known = {key for row in rows for key in row.results}
        wanted = [(meant(objective.key, known), objective.goal) for objective in self.study.objectives]
        ranked = tuple(ranking(rows, key, goal) for key, goal in wanted if key)
        return SweepResult(
            subject=self.subject,
            question=self.question,
            knobs=self.knobs,
            rows=rows,
            rankings=ranked,
            next_model=None,
            evaluations=0,
            reused=0,
            seconds=0.0,
        )

    def _search(self, start: Array, budget: int) -> Optimiser:
        study, known = self.study, self._evaluations()
        seed = study.seed + len(known)
        return search(study.optimiser, self.knobs, len(study.objectives), budget, seed, start, known)

    def _minimised(self, model: Model, optimiser: Optimiser, most: int, who: Workers) -> list[Outcome]:
        known = self.known[model]

        def design(place: Array) -> tuple[Value, ...]:
            return tuple(values_at(self.knobs, place).values())

        def function(places: list[Array]) -> list[Outcome]:
            fresh = {design(place): place for place in places if design(place) not in known}
            answers = self._told([values_at(self.knobs, place) for place in fresh.values()], model, who)
            for (values, place), answer in zip(fresh.items(), answers, strict=True):
                known[values] = (place, *answer)
            evaluations = [self.weighing.told(place, known[design(place)][2], model) for place in places]
            if model == "search" and self.tick is not None:
                self.best = _better(self.best, evaluations)
                objective = self.study.objectives[0]
                best = (self.best or 0.0) * (1 if objective.goal == "min" else -1)
                so_far = "none allowed so far" if self.best is None else f"best {worded(objective.key, best)}"
                self.tick(so_far, len(known))
            return evaluations

        return minimise(function, optimiser, most, design, tuple(known) if model == "search" else ())

    def _told(
        self, points: list[Values], model: Model, who: Workers
    ) -> list[tuple[Evaluation, Results | None]]:
        """A model's answers, and all numbers of each design: the answer's, the varied keys', and those of
        other results, whose name stands before their keys; None where one of them is refused."""
        answers, results = list[Evaluation](), list[dict[str, Estimate] | None]([{} for _ in points])
        for before, question in self._questions(model).items():
            there = [i for i, row in enumerate(results) if row is not None]
            values = [self._of_design(points[i]) if before else points[i] for i in there]
            rows = self._run(question).at(values, who)
            answers = answers or rows
            for i, row in zip(there, rows, strict=True):
                named = {f"{before}{key}": estimate for key, estimate in row.results.items()}
                own = {} if before else self._own(points[i])
                results[i] = None if row.refused else {**(results[i] or {}), **named, **own}
        return list(zip(answers, results, strict=True))

    def _questions(self, model: Model) -> dict[str, Query]:
        """What a model is asked of a design, by what stands before the keys of the results."""
        question, judge = self.question, self.study.judge
        if question.kind == "check" and model != "search":
            question = replace(question, model=GUIDE if model == "guide" else judge)
        questions = {"": question}
        for kind in self.weighing.others() if model != "guide" else ():
            model_of_kind = None
            if kind == "check":
                design = self.subject.design if isinstance(self.subject, Scene) else self.subject
                cheap = self.study.model or first_able(RANKED_BY, design)  # type: ignore[arg-type]
                model_of_kind = judge if model == "judge" else cheap
            questions[f"{kind}."] = Query(kind, model_of_kind)
        return questions

    def _run(self, question: Query) -> Run:
        if question not in self.runs:
            same_kind = question.kind == self.question.kind or not isinstance(self.subject, Scene)
            subject = self.subject if same_kind else self.subject.design  # type: ignore[union-attr]
            self.runs[question] = Run(subject, question, Log() if self.is_guide(question) else self.log)
        return self.runs[question]

    def is_guide(self, question: Query) -> bool:
        """Whether a question is the closed form's, by which a search starts: it costs next to nothing."""
        return question.model == GUIDE and GUIDE not in (self.study.model, self.study.judge)

    def _of_design(self, values: Values) -> Values:
        """What is varied of the skin, by the design's own keys."""
        if not isinstance(self.subject, Scene):
            return values
        return {key.removeprefix(SKIN): value for key, value in values.items() if key.startswith(SKIN)}

    def _own(self, values: Values) -> dict[str, Estimate]:
        """The varied numbers themselves, which an objective or a limit may be about."""
        units = {knob.key: knob.unit for knob in self.knobs}
        return {
            key: Estimate(float(value), 0.0, units[key])
            for key, value in values.items()
            if not isinstance(value, str)
        }


def _better(best: float | None, evaluations: Sequence[Outcome]) -> float | None:
    """The least first loss of what breaks no limit, and of what was the least before."""
    allowed = [float(evaluation.losses[0]) for evaluation in evaluations if evaluation.broken <= 0]
    return min(allowed if best is None else [best, *allowed], default=None)
