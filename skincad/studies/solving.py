"""Solving for the values that give a wanted result.

Several numbers so that several results have wanted values, with the least change from the start. Sequential:
the results are taken as linear near where one is, by secants that every evaluation betters (Broyden 1965);
the least change that gives the wanted values then is looked up within the ranges and a trust region, and
evaluated.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np
from scipy.optimize import lsq_linear, minimize

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError, require_number
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress
from skincad.base.result import Record, Result, columns_of, item, record, reported
from skincad.inputs.design import Design
from skincad.inputs.silicone import silicones
from skincad.studies.query import (
    GUIDE,
    Evaluation,
    Evaluator,
    Query,
    first_able,
    question_of,
    scaled,
    short,
    slack,
)
from skincad.studies.roots import STEP, Search, search
from skincad.studies.subject import (
    DesignVariable,
    RangeText,
    Subject,
    Value,
    changed,
    knobs,
    nearest_silicone,
    owner,
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

    def as_json(self) -> dict[str, Any]:
        """Return one entry of `solutions`."""
        return {
            "values": dict(self.values),
            "reached": {key: estimate.as_json() for key, estimate in self.reached.items()},
            "interval": {key: list(ends) for key, ends in self.interval.items()},
            "nearest": dict(self.nearest),
            "passed": self.passed,
        }


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

    @reported(meaning="of the subject")
    def name(self) -> str:
        """The subject's name."""
        return self.subject.name

    @reported(meaning="keys and their ranges or choices", key="vary")
    def _vary(self) -> dict[str, list[Value]]:
        return {knob.key: knob.range for knob in self.knobs}

    @reported(meaning="the model of all checks", key="tier")
    def model(self) -> str | None:
        """The model of all checks."""
        return self.question.model

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

    @reported(meaning="wall time, s", key="seconds")
    def _seconds(self) -> dict[str, float]:
        return {"total": self.seconds}

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


Function = Callable[[Array], Array | None]  # (n,) on [0, 1] -> (m,), None where there is no value
PROBE = 0.04  # of a range: the step of the first slopes
TRUST, SMALLEST = 0.5, 1e-4  # of a range: how far a step goes at first, and where it is given up
STILL = 0.01  # of a range: a better place this near is not worth an evaluation
STARTS = 8  # places that are tried where the start has no values


@dataclass
class Walk:
    """What was evaluated, `(n,)` and `(m,)` or None, and the best of it within tolerance, None if none is."""

    seen: list[tuple[Array, Array | None]] = field(default_factory=list)
    best: Array | None = None
    closest: Array | None = None


def least_change(function: Function, start: Array, wanted: Array, tol: Array, most: int) -> Walk:
    """Return the place on the unit cube nearest to `start` `(n,)` with `function` within `tol` `(m,)` of
    `wanted` `(m,)`, as far as `most` evaluations tell."""
    path = Walk()

    def ask(at: Array) -> Array | None:
        for place, values in path.seen:
            if np.array_equal(place, at):
                return values
        if len(path.seen) >= most:
            return None
        path.seen.append((at, function(at)))
        return path.seen[-1][1]

    at, reached = _first(ask, start)
    if reached is None:
        return path
    scale = tol
    slopes = _slopes(ask, at, reached)
    trust, evaluated = TRUST, -1
    while len(path.seen) < most and trust > SMALLEST and len(path.seen) != evaluated:
        evaluated = len(path.seen)
        good = bool(np.all(np.abs(reached - wanted) <= tol))
        candidate = _nearest(start, at, reached - wanted, slopes, trust, scale)
        if good and np.linalg.norm(candidate - at) < STILL:
            break
        new = ask(candidate)
        if new is None:
            trust /= 4
            continue
        step = candidate - at
        slopes = slopes + np.outer(new - reached - slopes @ step, step) / (float(step @ step) or 1.0)
        if _merit(new, wanted, scale) < max(_merit(reached, wanted, scale), 1.0) and not (
            good and np.linalg.norm(candidate - start) > np.linalg.norm(at - start)
        ):
            at, reached = candidate, new
            trust = min(2 * trust, 1.0)
        else:
            trust = min(trust, float(np.abs(step).max())) / 3
    known = [(place, known_values) for place, known_values in path.seen if known_values is not None]
    path.closest = min(known, key=lambda one: _merit(one[1], wanted, scale))[0]
    within = [place for place, known_values in known if np.all(np.abs(known_values - wanted) <= tol)]
    path.best = min(within, key=lambda place: float(np.linalg.norm(place - start)), default=None)
    return path


def _merit(values: Array, wanted: Array, scale: Array) -> float:
    """How far off, in tolerances."""
    return float(np.abs((values - wanted) / scale).max())


def _first(ask: Function, start: Array) -> tuple[Array, Array | None]:
    """The start, or the nearest of some places that has values."""
    if (values := ask(start)) is not None:
        return start, values
    from scipy.stats import qmc  # half a second, which most commands need not wait for

    places = qmc.Sobol(len(start), scramble=False).random(STARTS)
    for place in sorted(places, key=lambda each: float(np.linalg.norm(each - start))):
        if (values := ask(place)) is not None:
            return place, values
    return start, None


def _slopes(ask: Function, at: Array, values: Array) -> Array:
    """Slopes `(m, n)` by a step in each number, away from the nearer end; 0 where there is no value."""
    slopes = np.zeros((len(values), len(at)))
    for i in range(len(at)):
        for sign in (1.0, -1.0) if at[i] < 0.5 else (-1.0, 1.0):
            step = at.copy()
            step[i] += sign * PROBE
            if 0 <= step[i] <= 1 and (there := ask(step)) is not None:
                slopes[:, i] = (there - values) / (sign * PROBE)
                break
    return slopes


def _nearest(start: Array, at: Array, off: Array, slopes: Array, trust: float, scale: Array) -> Array:
    """Return the place nearest to the start that gives the wanted values if slopes are right; where none in
    reach does, the one that comes nearest to them."""
    low, high = np.maximum(0.0, at - trust), np.minimum(1.0, at + trust)
    scaled = slopes / scale[:, None]

    def clipped(place: Array) -> Array:
        inside: Array = np.clip(place, low, high)
        return inside

    reach = lsq_linear(scaled, -off / scale, (low - at - 1e-12, high - at + 1e-12))
    if np.abs(scaled @ reach.x + off / scale).max() > 1.0:
        return clipped(at + reach.x)
    minimum = minimize(
        lambda place: float((place - start) @ (place - start)),
        clipped(at + reach.x),
        jac=lambda place: 2 * (place - start),
        bounds=list(zip(low, high, strict=True)),
        constraints={
            "type": "eq",
            "fun": lambda place: scaled @ (place - at) + off / scale,
            "jac": lambda _: scaled,
        },
        method="SLSQP",
    )
    return clipped(minimum.x)


TOL = 5e-3  # of the wanted value; what a mesh's error is by default
ONE, SEVERAL = 40, 100  # evaluations at most, of one number and of several
CHEAP = 200  # evaluations of one number at most, where they take milliseconds
FINE = 1 / 32  # of the range: how far cuts places may be before there is no value, where they are cheap
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
    more than `tol`, which is relative to what is wanted. Raises InputError for keys, ranges and tolerances
    that can't be used.
    """
    began = perf_counter()
    wished, bounds = _wished(target)
    varied = _varied(subject, wished, bounds, vary, tol, evaluations)
    stepped = [knob for knob in varied if knob.choices or knob.whole]
    smooth = tuple(knob for knob in varied if knob not in stepped)
    lists = [knob.values() for knob in stepped]
    question = question_of(subject, model=model, force=force)
    if isinstance(subject, Design) and model in (None, "auto"):
        question = replace(question, model=first_able(MODELS, subject))
    evaluator = Evaluator(subject, question, wished, progress, bounds)
    if evaluator.guided:
        try:
            evaluator.guide({})
        except (
            InputError
        ):  # a more expensive model's result may have more numbers: its first answer names them
            evaluator.unlike = True
    notes: list[str] = []
    step = FINE if question.kind == "circuit" or question.model == GUIDE else STEP
    most = evaluations or (SEVERAL if len(smooth) > 1 else CHEAP if step == FINE else ONE)
    solved: list[SolutionPoint] = []
    complete = True
    for combination in itertools.product(*lists):
        fixed = {knob.key: value for knob, value in zip(stepped, combination, strict=True)}
        if not smooth:
            solved += _chosen(evaluator, fixed, tol)
        elif len(smooth) == 1 == len(wished):
            roots, whole = _crossings(evaluator, fixed, smooth[0], tol, most, notes, step)
            solved, complete = solved + roots, complete and whole
        else:
            solved += _least_changed(evaluator, fixed, smooth, tol, most, notes)
            complete = False  # it walks from the start, and looks at no more than its way
    return _told(evaluator, varied, solved, complete, notes, perf_counter() - began)


def _wished(target: Mapping[str, float | str]) -> tuple[dict[str, float], dict[str, str]]:
    """What is wanted, and which of it are limits; raises InputError for a text that is neither."""
    wished, bounds = dict[str, float](), dict[str, str]()
    for key, wanted in target.items():
        if isinstance(wanted, str):
            side, number = BOUND.fullmatch(wanted).groups()  # type: ignore[union-attr]  # it matches any text
            try:
                wished[key] = float(number)
            except ValueError:
                rule = "must be a number, or a limit as <=0.25"
                raise InputError(f"target {key}", rule, wanted) from None
            bounds |= {key: side} if side else {}
        else:
            wished[key] = wanted
    return wished, bounds


def _varied(
    subject: Subject,
    target: Mapping[str, float],
    bounds: Mapping[str, str],
    vary: Mapping[str, RangeText],
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
    if smooth and (exact := len(target) - len(bounds)) > smooth:
        rule = f"must name at most as many numbers as keys are varied ({smooth})"
        remedy = "vary another key, drop a target, or make one a limit as KEY<=VALUE"
        raise InputError("target", rule, exact, remedy)
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
        subject=evaluator.subject,
        question=evaluator.question,
        target=evaluator.target or dict(evaluator.wished),
        bounds=evaluator.bounds or None,
        knobs=varied,
        solutions=tuple(sorted(solved, key=lambda evaluation: _order(evaluator, varied, evaluation))),
        closest=near,
        evaluations=evaluations,
        notes=tuple(dict.fromkeys(notes)),
        seconds=seconds,
        complete=complete,
    )


def _order(
    evaluator: Evaluator, varied: tuple[DesignVariable, ...], solved: SolutionPoint
) -> tuple[float, float]:
    """The least change first; of choices alone the one that comes nearest, of those that keep a limit too."""
    alone = all(knob.choices or knob.whole for knob in varied)
    off = evaluator.off(evaluator.ask(dict(solved.values))) if alone else 0.0
    return off, _change(varied, solved.values)


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
    return SolutionPoint(
        values=dict(values), reached=reached, interval=interval, nearest=named, passed=evaluation.passed
    )


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
    missed = evaluator.missed(evaluation)
    if missed is not None and all(
        abs(d) <= max(tol * abs(y), slack(evaluation.results[key]))
        for d, (key, y) in zip(missed, evaluator.target.items(), strict=True)
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
    if evaluator.bounds and evaluator.off(evaluation := evaluator.ask(values(_start(knob)))) == 0:
        return [_solved(evaluator, evaluation, {})], False
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
    if evaluator.bounds and not roots:  # it is kept beyond a jump, or beyond what is refused
        of_these = [e for e in evaluator.evaluations.values() if fixed.items() <= e.values.items()]
        kept = [_solved(evaluator, e, {}) for e in of_these if evaluator.off(e) == 0]
        roots = sorted(kept, key=lambda solved: _change((knob,), solved.values))[:1]
    return roots, zeros.complete and not evaluator.bounds


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
        missed = evaluator.missed(evaluator.ask(values(place)))
        return None if missed is None else scaled(wanted + missed, wanted)

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
