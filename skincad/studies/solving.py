"""Solving for the values that give a wanted result: the question, and what was found (roots.py searches)."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError, require_number
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress
from skincad.base.result import Record, Result, columns_of, item, record, reported, reported_from
from skincad.inputs.design import Design
from skincad.inputs.silicone import silicones
from skincad.studies.query import (
    GUIDE,
    Evaluation,
    Evaluator,
    Query,
    first_able,
    question_of,
    ranges,
    scaled,
    short,
    slack,
    total_seconds,
)
from skincad.studies.roots import STEP, least_change, search
from skincad.studies.subject import (
    DesignVariable,
    RangeText,
    Subject,
    Value,
    changed,
    knobs,
    nearest_silicone,
    owner,
    values_at,
)


@record()
class SolutionPoint(Record):
    """A place that gives what is wanted, or comes nearest to it."""

    values: Mapping[str, Value] = item(meaning="of the varied keys")
    reached: Mapping[str, Estimate] = item(meaning="the wanted results there")
    interval: Mapping[str, tuple[float, float]] = item(
        meaning="what the results' errors leave open of the one number that is varied; empty for several"
    )
    nearest: Mapping[str, str] = item(meaning="the catalogue's choice that comes nearest to a number")
    passed: bool | None = item(meaning="whether all ridges touch there")


@record()
class Solution(Result):
    """What was found; `evaluations` are all of them in their order. `complete` says that there are no other
    solutions: the model that judges was asked at both ends of the range and at enough places between."""

    shown_by = "skincad.outputs.studies:SOLUTION"
    subject: Subject
    question: Query
    target: Mapping[str, float] = item(meaning="what is wanted, by the result's keys")
    knobs: tuple[DesignVariable, ...]
    solutions: tuple[SolutionPoint, ...] = item(meaning="all that were found, the least change first")
    closest: SolutionPoint | None = item(meaning="where there is none")
    evaluations: tuple[Evaluation, ...]
    notes: tuple[str, ...] = item(meaning="what else is to be known of the search")
    seconds: float  # wall time
    bounds: Mapping[str, str] | None = item(
        meaning="<= or >= by the keys of targets that are limits; null without one", default=None
    )
    complete: bool = False

    name = reported_from("subject.name", meaning="of the subject")

    _vary = ranges

    model = reported_from("question.model", meaning="the model of all checks", key="tier")

    @reported(meaning="how many there were", key="evaluations")
    def _evaluations(self) -> int:
        return len(self.evaluations)

    @reported(meaning="how many of them were refused")
    def refused(self) -> int:
        """How many evaluations were refused."""
        return sum(bool(entry.refused) for entry in self.evaluations)

    @reported(meaning="complete where there are no other solutions, else partial")
    def searched(self) -> str:
        """How far the range was searched."""
        return "complete" if self.complete else "partial"

    _seconds = total_seconds

    @reported(meaning="whether there is a solution")
    def feasible(self) -> bool:
        """Whether there is a solution."""
        return bool(self.solutions)

    def columns(self) -> dict[str, Any]:
        """Return a row for each solution: the values of the varied keys, with their units, and what they
        reach."""
        return columns_of(
            {
                **{knob.column: solution.values.get(knob.key) for knob in self.knobs},
                **solution.reached,
                "passed": solution.passed,
            }
            for solution in self.solutions
        )

    @property
    def solved(self) -> Subject:
        """The design, scene or circuit of the first solution; RefusedError where there is none."""
        if not self.solutions:
            raise RefusedError(f"{self.name}: no value gives what is wanted, so there is nothing to write")
        return changed(self.subject, self.solutions[0].values)

    @property
    def exit_status(self) -> int:
        """0 where a solution was found, else 1."""
        return 0 if self.feasible else 1


TOL = 5e-3  # of the wanted value; what a mesh's error is by default
ONE, SEVERAL = 40, 100  # evaluations at most, of one number and of several
CHEAP = 200  # evaluations of one number at most, where they take milliseconds
FINE = STEP / 8  # of the range: how far apart places may be where they are cheap, or none has a value
MOST_CHOICES = 256  # combinations of choices, each solved by itself
# the first that takes the design: one for all its evaluations
MODELS = "corrected", "linear", "winkler", "reduced"
Values = dict[str, Value]
BOUND = re.compile(r"\s*([<>]=)?\s*(.*)", re.DOTALL)


def solve(
    subject: Subject,
    target: Mapping[str, float | str],
    vary: Mapping[str, RangeText],
    *,
    model: str | None = None,
    tol: float = TOL,
    force: float | None = None,
    hold: str | float | None = None,
    evaluations: int | None = None,
    progress: Progress | None = None,
) -> Solution:
    """Return the values of the `vary` keys for which a result's numbers are the `target`, by its JSON keys.

    A target is a number, or a limit as text: "<=0.25" or ">=0.25", which the start may keep as it is.
    `subject` is a design (its check is asked), a scene (its simulation) or a circuit (its gain); keys of
    `vary` have dots, as `skin.curvature_radius`, and a range (low, high), a list of choices or "all". One
    number: the values in its range that the search meets, or none after a search of the whole range. Several:
    those with the least change from the start, as parts of their ranges. Choices are tried one by one. Every
    check is by one `model`, the best for small strains if None or "auto": the numbers of two models differ by
    more than `tol`, which is relative to what is wanted. With `hold`, a mass as "0.3kg", each check of a
    design says too which lifts of such an object the mount's gripper holds: a target is `holding.share`, and
    each value takes some 20 s. Raises InputError for keys, ranges and tolerances that can't be used.
    """
    began = perf_counter()
    require_number("tol", tol, lambda value: 0 < value < 1, "must be between 0 and 1 (relative)", "try 0.005")
    if evaluations is not None:
        require_number("evaluations", evaluations, lambda value: value >= 1, "must be at least 1")
    wished, bounds = _wished(target)
    varied = knobs(subject, vary)
    stepped = [knob for knob in varied if knob.choices or knob.whole]
    smooth = [knob for knob in varied if knob not in stepped]
    _require_solvable(varied, len(wished) - len(bounds), len(smooth))
    question = question_of(subject, model=model, force=force, hold=hold)
    if isinstance(subject, Design) and model in (None, "auto"):
        question = replace(question, model=first_able(MODELS, subject))
    evaluator = Evaluator(subject, question, wished, progress, bounds)
    if evaluator.guided:
        try:
            evaluator.guide({})
        except InputError:  # a better model's result may have more numbers: its first answer names them
            evaluator.unlike = True
    notes: list[str] = []
    points: list[SolutionPoint] = []
    complete = True
    for combination in itertools.product(*(knob.values() for knob in stepped)):
        fixed = {knob.key: value for knob, value in zip(stepped, combination, strict=True)}
        if len(smooth) == 1 == len(wished):
            more, whole, notes_of_search = _crossings(evaluator, fixed, smooth[0], tol, evaluations)
        elif smooth:
            more, notes_of_search = _least_changed(evaluator, fixed, smooth, tol, evaluations or SEVERAL)
            whole = False  # it walks from the start, and looks at no more than its way
        else:
            more, whole, notes_of_search = _chosen(evaluator, fixed, tol), True, []
        points, complete, notes = points + more, complete and whole, notes + notes_of_search
    answers = tuple(evaluator.evaluations.values())
    refused = [evaluation.refused for evaluation in answers if evaluation.refused]
    if len(refused) == len(answers):
        notes.append(f"every value is refused, the first since {refused[0]}")
    for key in [] if refused else evaluator.target:
        rows = [evaluation.results[key] for evaluation in answers if key in evaluation.results]
        if all(row.value is None for row in rows):
            notes.append(f"the result has no {key} at any value that was tried")
    notes += [_uncast(subject, *entry) for point in points for entry in point.values.items()]

    def order(point: SolutionPoint) -> tuple[float, float]:
        """The least change first; of choices the one that comes nearest, of those that keep a limit too."""
        off = 0.0 if smooth else evaluator.off(evaluator.ask(dict(point.values)))
        return off, _change(varied, point.values)

    closest = min(answers, key=evaluator.off)
    return Solution(
        subject=subject,
        question=question,
        target=evaluator.target or wished,
        bounds=evaluator.bounds or None,
        knobs=varied,
        solutions=tuple(sorted(points, key=order)),
        closest=None if points or evaluator.off(closest) == math.inf else _point(evaluator, closest),
        evaluations=answers,
        notes=tuple(note for note in dict.fromkeys(notes) if note),
        seconds=perf_counter() - began,
        complete=complete,
    )


def _wished(target: Mapping[str, float | str]) -> tuple[dict[str, float], dict[str, str]]:
    """What is wanted, and which of it are limits; raises InputError for what is neither."""
    if not target:
        raise InputError("target", "names no number", remedy="as in all_touch_force=3")
    wished, bounds = dict[str, float](), dict[str, str]()
    for key, wanted in target.items():
        side, number = BOUND.fullmatch(str(wanted)).groups()  # type: ignore[union-attr]  # it matches any text
        try:
            wished[key] = float(number)
        except ValueError:
            rule = "must be a number, or a limit as <=0.25"
            raise InputError(f"target {key}", rule, wanted) from None
        require_number(f"target {key}", wished[key], lambda _: True, "must be finite")
        if side:
            bounds[key] = side
    return wished, bounds


def _require_solvable(varied: Sequence[DesignVariable], exact: int, smooth: int) -> None:
    """Raise InputError for more `exact` numbers than `smooth` keys, or for too few or too many choices."""
    if smooth and exact > smooth:
        rule = f"must name at most as many numbers as keys are varied ({smooth})"
        remedy = "vary another key, drop a target, or make one a limit as KEY<=VALUE"
        raise InputError("target", rule, exact, remedy)
    if len(varied) == 1 and len(varied[0].choices) == 1:
        rule, remedy = "names one value", "write LOW:HIGH, or several choices"
        raise InputError(varied[0].key, rule, varied[0].choices[0], remedy)
    if math.prod(len(knob.values()) for knob in varied if knob.choices or knob.whole) > MOST_CHOICES:
        rule = f"must have at most {MOST_CHOICES} combinations of choices"
        raise InputError("vary", rule, remedy="vary less")


def _change(varied: Sequence[DesignVariable], values: Mapping[str, Value]) -> float:
    """How far values are from the start's, in parts of their ranges; another choice is one whole range."""
    total = 0.0
    for knob in varied:
        value = values[knob.key]
        if knob.choices or isinstance(value, str) or not isinstance(knob.start, int | float):
            total += value != knob.start
        else:
            total += (knob.share(value) - knob.share(knob.start)) ** 2
    return math.sqrt(total)


def _point(
    evaluator: Evaluator, evaluation: Evaluation, interval: Mapping[str, tuple[float, float]] | None = None
) -> SolutionPoint:
    """What an evaluation reached."""
    values = dict(evaluation.values)
    near = {key: nearest_silicone(evaluator.subject, key, value) for key, value in values.items()}
    named = {key.replace("young_modulus", "name"): name for key, name in near.items() if name}
    named |= {key: value for key, value in values.items() if isinstance(value, str)}
    reached = {key: evaluation.results[key] for key in evaluator.target}
    return SolutionPoint(
        values=values, reached=reached, interval=interval or {}, nearest=named, passed=evaluation.passed
    )


def _uncast(subject: Subject, key: str, value: Value) -> str:
    """Return that no silicone of the catalogue is as soft or as stiff as a modulus, "" where one is."""
    nearest = nearest_silicone(subject, key, value)
    if nearest is None or isinstance(value, str):
        return ""
    known = silicones(getattr(owner(subject, key)[0], "silicones", None))
    moduli, end = [row.young_modulus for row in known.values()], known[nearest].young_modulus
    softer, stiffer = value < min(m.low for m in moduli), value > max(m.high for m in moduli)
    which, most = ("soft", "softest") if softer else ("stiff", "stiffest")
    words = f"no silicone is as {which} as {key} {short(value)} MPa: the {most} is {nearest} with "
    return f"{words}{end.low:g} to {end.high:g} MPa" if softer or stiffer else ""


def _chosen(evaluator: Evaluator, fixed: Values, tol: float) -> list[SolutionPoint]:
    """What choices alone give: a solution where the wish lies within the tolerance or the result's error."""
    evaluation = evaluator.ask(fixed)
    missed = evaluator.missed(evaluation)
    if missed is None:
        return []
    off = zip(missed, evaluator.target.items(), strict=True)
    met = all(abs(d) <= max(tol * abs(y), slack(evaluation.results[key])) for d, (key, y) in off)
    return [_point(evaluator, evaluation)] if met else []


def _crossings(
    evaluator: Evaluator, fixed: Values, knob: DesignVariable, tol: float, evaluations: int | None
) -> tuple[list[SolutionPoint], bool, list[str]]:
    """The solutions for one number, whether the range has no others, and notes on the search."""

    def values(share: float) -> Values:
        return {**fixed, knob.key: knob.at(share)}

    def only(reached: list[float] | None) -> float | None:
        return reached[0] if reached else None

    start = knob.share(knob.start)
    if evaluator.bounds and evaluator.off(evaluation := evaluator.ask(values(start))) == 0:
        return [_point(evaluator, evaluation)], False, []
    (wanted,) = evaluator.wished.values()
    cheap = evaluator.question.kind == "circuit" or evaluator.question.model == GUIDE
    most = evaluations or (CHEAP if cheap else ONE)
    zeros = search(
        lambda share: only(evaluator.told(evaluator.ask(values(share)))),
        wanted,
        tol * (abs(wanted) or 1.0),
        most,
        (lambda share: only(evaluator.guide(values(share)))) if evaluator.guided else None,
        start,
        step=FINE if cheap else STEP,
        nowhere=STEP / 2 if evaluator.guided else FINE,
        cuts=[end for end, value in ((0.0, knob.low), (1.0, knob.high)) if value == 0],
    )
    notes = [f"at {knob.key} {short(knob.at(x))} the result jumps past what is wanted" for x in zeros.jumps]
    if not zeros.exact:
        used_up = f"the search ended after {most} evaluation{'s' * (most > 1)} and may have missed some"
        notes.insert(0, f"{used_up}: --evaluations")
    points = []
    for share in zeros.roots:
        evaluation = evaluator.ask(values(share))
        error = next(evaluation.results[key].error for key in evaluator.target)
        interval = {}
        if error is not None:
            low, high = zeros.within(share, error)
            interval[knob.key] = float(knob.at(low)), float(knob.at(high))
        points.append(_point(evaluator, evaluation, interval))
    if evaluator.bounds and not points:  # it is kept beyond a jump, or beyond what is refused
        of_these = [e for e in evaluator.evaluations.values() if fixed.items() <= e.values.items()]
        kept = [_point(evaluator, e) for e in of_these if evaluator.off(e) == 0]
        points = sorted(kept, key=lambda point: _change([knob], point.values))[:1]
    return points, zeros.complete and not evaluator.bounds, notes


def _least_changed(
    evaluator: Evaluator, fixed: Values, smooth: list[DesignVariable], tol: float, most: int
) -> tuple[list[SolutionPoint], list[str]]:
    """The least change of several numbers, and a note where the evaluations were used up."""
    wanted = np.array(list(evaluator.wished.values()), dtype=float)

    def values(place: Array) -> Values:
        return {**fixed, **values_at(smooth, place)}

    def function(place: Array) -> Array | None:
        missed = evaluator.missed(evaluator.ask(values(place)))
        return None if missed is None else scaled(wanted + missed, wanted)

    tols = np.where(wanted > 0, tol, tol * np.where(wanted == 0, 1.0, np.abs(wanted)))
    start = np.array([knob.share(knob.start) for knob in smooth])
    place, seen = least_change(function, start, scaled(wanted, wanted), tols, most)
    if place is not None:
        return [_point(evaluator, evaluator.ask(values(place)))], []
    used_up = f"the search ended after {most} evaluations: --evaluations allows more"
    return [], [used_up] if len(seen) >= most else []
