"""Solve: which values of some keys give a result that is wanted."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from skincad.base.arguments import require_number
from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.inputs.silicone import silicones
from skincad.studies.asking import GUIDE, Evaluator, scaled, short
from skincad.studies.knobs import DesignVariable, Outcome, knobs, nearest_silicone
from skincad.studies.least_change import least_change
from skincad.studies.measures import slack
from skincad.studies.question import Evaluation, first_able, question_of
from skincad.studies.roots import STEP, Search, search
from skincad.studies.solution import Solution, SolutionPoint
from skincad.studies.subject import Subject, Value, owner

TOL = 5e-3  # of the wanted value; what a mesh's error is by default
ONE, SEVERAL = 40, 100  # evaluations at most, of one number and of several
CHEAP = 200  # evaluations of one number at most, where they take milliseconds
FINE = 1 / 32  # of the range: how far cuts places may be before there is no value, where they are cheap
MOST_CHOICES = 256  # combinations of choices, each solved by itself
TIERS = ("corrected", "linear", "winkler")  # the first that takes the design: one for all its evaluations
Values = dict[str, Value]


def solve(
    subject: Subject,
    target: Mapping[str, float],
    vary: Mapping[str, Outcome],
    *,
    tier: str | None = None,
    tol: float = TOL,
    force: float | None = None,
    evaluations: int | None = None,
    progress: Progress | None = None,
) -> Solution:
    """Return the values of the `vary` keys for which a result's numbers are the `target`, by its JSON keys.

    `subject` is a design (its check is asked), a scene (its simulation) or a circuit (its gain); keys of
    `vary` have dots, as `skin.curvature_radius`, and a range (low, high), a list of choices or "all". One
    number: the values in its range that the search meets, or none after a search of the whole range. Several:
    those with the least change from the start, as parts of their ranges. Choices are tried one by one. Every
    check is by one `tier`, the best for small strains if None or "auto": the numbers of two models differ by
    more than `tol`, which is relative to what is wanted. Raises InputError for keys, ranges and tolerances
    that can't be used.
    """
    began = perf_counter()
    varied = _varied(subject, target, vary, tol, evaluations)
    stepped = [knob for knob in varied if knob.choices or knob.whole]
    smooth = tuple(knob for knob in varied if knob not in stepped)
    lists = [knob.values() for knob in stepped]
    question = question_of(subject, tier=tier, force=force)
    if isinstance(subject, Design) and tier in (None, "auto"):
        question = replace(question, tier=first_able(TIERS, subject))
    evaluator = Evaluator(subject, question, target, progress)
    if evaluator.guided:
        try:
            evaluator.guide({})
        except InputError:  # a dearer model's result may have more numbers: its first answer names them
            evaluator.unlike = True
    notes: list[str] = []
    step = FINE if question.kind == "circuit" or question.tier == GUIDE else STEP
    most = evaluations or (SEVERAL if len(smooth) > 1 else CHEAP if step == FINE else ONE)
    solved: list[SolutionPoint] = []
    complete = True
    for combination in itertools.product(*lists):
        fixed = {knob.key: value for knob, value in zip(stepped, combination, strict=True)}
        if not smooth:
            solved += _chosen(evaluator, fixed, tol)
        elif len(smooth) == 1:
            roots, whole = _crossings(evaluator, fixed, smooth[0], tol, most, notes, step)
            solved, complete = solved + roots, complete and whole
        else:
            solved += _least_changed(evaluator, fixed, smooth, tol, most, notes)
            complete = False  # it walks from the start, and looks at no more than its way
    return _told(evaluator, varied, solved, complete, notes, perf_counter() - began)


def _varied(
    subject: Subject,
    target: Mapping[str, float],
    vary: Mapping[str, Outcome],
    tol: float,
    evaluations: int | None,
) -> tuple[DesignVariable, ...]:
    """The knobs of what is asked; raises InputError for what can't be."""
    require_number("tol", tol, lambda value: 0 < value < 1, "must be between 0 and 1 (relative)", "try 0.005")
    if evaluations is not None:
        require_number("evaluations", evaluations, lambda value: value >= 1, "must be at least 1")
    if not target:
        raise InputError("target", "names no number", remedy="as in all_touch_force=3")
    for key, wanted in target.items():
        require_number(f"target {key}", wanted, lambda _: True, "must be finite")
    varied = knobs(subject, vary)
    stepped = [knob for knob in varied if knob.choices or knob.whole]
    smooth = len(varied) - len(stepped)
    if smooth and len(target) > smooth:
        rule = f"must name at most as many numbers as keys are varied ({smooth})"
        raise InputError("target", rule, len(target), "vary another key, or drop a target")
    if len(varied) == 1 and len(varied[0].choices) == 1:
        rule, remedy = "names one value", "write LOW:HIGH, or several choices"
        raise InputError(varied[0].key, rule, varied[0].choices[0], remedy)
    if math.prod(len(knob.values()) for knob in stepped) > MOST_CHOICES:
        rule = f"must have at most {MOST_CHOICES} combinations of choices"
        raise InputError("vary", rule, remedy="vary less")
    return varied


def _told(
    evaluator: Evaluator,
    varied: tuple[DesignVariable, ...],
    solved: list[SolutionPoint],
    complete: bool,
    notes: list[str],
    seconds: float,
) -> Solution:
    evaluations = tuple(evaluator.evaluations.values())
    refused = [evaluation.refused for evaluation in evaluations if evaluation.refused]
    if refused and len(refused) == len(evaluations):
        notes = [*notes, f"every value is refused, the first since {refused[0]}"]
    for key in evaluator.target:
        if (
            not refused
            and evaluations
            and all(evaluation.results[key].value is None for evaluation in evaluations)
        ):
            notes = [*notes, f"the result has no {key} at any value that was tried"]
    for evaluation in solved:
        notes = [
            *notes,
            *filter(None, (_uncast(evaluator.subject, *item) for item in evaluation.values.items())),
        ]
    closest = min(evaluations, key=evaluator.off, default=None)
    near = None
    if closest is not None and not solved and evaluator.off(closest) < math.inf:
        near = _solved(evaluator, closest, {})
    return Solution(
        evaluator.subject,
        evaluator.question,
        evaluator.target or dict(evaluator.wished),
        varied,
        tuple(sorted(solved, key=lambda evaluation: _order(evaluator, varied, evaluation))),
        near,
        evaluations,
        tuple(dict.fromkeys(notes)),
        seconds,
        complete,
    )


def _order(evaluator: Evaluator, varied: tuple[DesignVariable, ...], solved: SolutionPoint) -> float:
    """The least change first; of choices alone the one that comes nearest."""
    if not all(knob.choices or knob.whole for knob in varied):
        return _change(varied, solved.values)
    return max(
        abs(float(estimate) - wanted) / (abs(wanted) or 1.0)
        for estimate, wanted in zip(solved.reached.values(), evaluator.target.values(), strict=True)
    )


def _change(varied: tuple[DesignVariable, ...], values: Mapping[str, Value]) -> float:
    """How far values are from the start's, in parts of their ranges; another choice is one whole range."""
    total = 0.0
    for knob in varied:
        value = values[knob.key]
        if knob.choices or isinstance(value, str) or not isinstance(knob.start, int | float):
            total += value != knob.start
        else:
            total += (knob.share(value) - knob.share(min(max(knob.start, knob.low), knob.high))) ** 2
    return math.sqrt(total)


def _solved(
    evaluator: Evaluator, evaluation: Evaluation, interval: Mapping[str, tuple[float, float]]
) -> SolutionPoint:
    values = evaluation.values
    near = {key: nearest_silicone(evaluator.subject, key, value) for key, value in values.items()}
    named = {key.replace("young_modulus", "name"): name for key, name in near.items() if name}
    named |= {key: value for key, value in values.items() if isinstance(value, str)}
    reached = {key: evaluation.results[key] for key in evaluator.target}
    return SolutionPoint(dict(values), reached, interval, named, evaluation.passed)


def _uncast(subject: Subject, key: str, value: Value) -> str:
    """Return that no silicone of the catalogue is as soft or as stiff as a modulus, "" where one is."""
    if (nearest := nearest_silicone(subject, key, value)) is None or isinstance(value, str):
        return ""
    known = silicones(getattr(owner(subject, key)[0], "silicones", None))
    moduli = [material.young_modulus for material in known.values()]
    if value < min(modulus.low for modulus in moduli):
        which, most = "soft", "softest"
    elif value > max(modulus.high for modulus in moduli):
        which, most = "stiff", "stiffest"
    else:
        return ""
    end = known[nearest].young_modulus
    return (
        f"no silicone is as {which} as {key} {short(value)} MPa: the {most} is {nearest} with "
        f"{end.low:g} to {end.high:g} MPa"
    )


def _chosen(evaluator: Evaluator, fixed: Values, tol: float) -> Iterator[SolutionPoint]:
    """What choices alone give: a solution where the wish lies within the result's error."""
    evaluation = evaluator.ask(fixed)
    values = evaluator.told(evaluation)
    if values is not None and all(
        abs(x - y) <= max(tol * abs(y), slack(evaluation.results[key]))
        for x, (key, y) in zip(values, evaluator.target.items(), strict=True)
    ):
        yield _solved(evaluator, evaluation, {})


def crossings(
    evaluator: Evaluator, fixed: Values, knob: DesignVariable, tol: float, most: int, notes: list[str]
) -> Iterator[SolutionPoint]:
    """Yield the solutions for one number that few evaluations tell of; notes on the search go to `notes`."""
    yield from _crossings(evaluator, fixed, knob, tol, most, notes, None)[0]


def _crossings(
    evaluator: Evaluator,
    fixed: Values,
    knob: DesignVariable,
    tol: float,
    most: int,
    notes: list[str],
    step: float | None,
) -> tuple[list[SolutionPoint], bool]:
    """The solutions for one number, and whether the range has no others."""

    def values(share: float) -> Values:
        return {**fixed, knob.key: knob.at(share)}

    def first(values_at: Callable[[Values], list[float] | None]) -> Callable[[float], float | None]:
        def function(share: float) -> float | None:
            reached = values_at(values(share))
            return None if reached is None else reached[0]

        return function

    function, guide = first(lambda each: evaluator.told(evaluator.ask(each))), first(evaluator.guide)
    (wanted,) = evaluator.wished.values()
    allowed = tol * (abs(wanted) or 1.0)
    zeros = search(
        function,
        wanted,
        allowed,
        most,
        guide if evaluator.guided else None,
        _start(knob),
        step=step,
        cuts=[end for end, value in ((0.0, knob.low), (1.0, knob.high)) if value == 0],
    )
    if not zeros.exact:
        notes.append(f"the search ended after {most} evaluations and may have missed some: --evaluations")
    notes += [f"at {knob.key} {short(knob.at(x))} the result jumps past what is wanted" for x in zeros.jumps]
    roots = []
    for share in zeros.roots:
        answer = evaluator.ask(values(share))
        roots.append(_solved(evaluator, answer, _interval(evaluator, knob, share, zeros, answer)))
    return roots, zeros.complete


def _interval(
    evaluator: Evaluator, knob: DesignVariable, share: float, roots: Search, answer: Evaluation
) -> dict[str, tuple[float, float]]:
    """Which values the result's error leaves open, cut at the range's ends."""
    error = answer.results[next(iter(evaluator.target))].error
    if error is None:
        return {}
    low, high = roots.within(share, error)
    return {knob.key: (float(knob.at(low)), float(knob.at(high)))}


def _least_changed(
    evaluator: Evaluator,
    fixed: Values,
    smooth: tuple[DesignVariable, ...],
    tol: float,
    most: int,
    notes: list[str],
) -> Iterator[SolutionPoint]:
    """The least change of several numbers."""
    wanted = np.array(list(evaluator.wished.values()), dtype=float)

    def values(place: Array) -> Values:
        return {**fixed, **{knob.key: knob.at(float(x)) for knob, x in zip(smooth, place, strict=True)}}

    def function(place: Array) -> Array | None:
        reached = evaluator.told(evaluator.ask(values(place)))
        return None if reached is None else scaled(np.array(reached), wanted)

    tols = np.where(wanted > 0, tol, tol * np.where(wanted == 0, 1.0, np.abs(wanted)))
    path = least_change(function, np.array([_start(k) for k in smooth]), scaled(wanted, wanted), tols, most)
    if path.best is not None:
        yield _solved(evaluator, evaluator.ask(values(path.best)), {})
    elif len(path.seen) >= most:
        notes.append(f"the search ended after {most} evaluations: --evaluations allows more")


def _start(knob: DesignVariable) -> float:
    """The share of the range at which the design's own value lies, or the nearest end; else the middle."""
    known: Any = knob.start
    return knob.share(min(max(known, knob.low), knob.high)) if isinstance(known, int | float) else 0.5
