"""What a study asks of each of its designs, and the numbers that it gets.

The numbers are those of the result by their keys (`Record.numbers`). A key may leave its unit out:
`all_touch_force`, `ridge_force.3`.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from time import perf_counter
from typing import Any, Literal

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import ExhaustedError, InputError, RefusedError, did_you_mean, require_goals
from skincad.base.estimate import Estimate
from skincad.base.interrupt import safe_point
from skincad.base.progress import Progress
from skincad.base.result import Result, bare_key, reported, unit_of_key
from skincad.base.version import __version__
from skincad.inputs.design import Design
from skincad.mechanics.check import require_force
from skincad.mechanics.models.table import model_named, unsupported_reason
from skincad.scenes.scene import Scene
from skincad.studies.holding import asked_lifts, check
from skincad.studies.subject import Subject, Value, changed, fingerprint


def meant(key: str, known: Iterable[str]) -> str | None:
    """Return the known key that `key` means, its unit left out or not; None where it means none of them."""
    names = list(known)
    matches = [key] if key in names else [name for name in names if bare_key(name) == key]
    return matches[0] if len(matches) == 1 else None


def resolved(key: str, known: Iterable[str], *, what: str = "target") -> str:
    """Return the known key that `key` means, its unit left out or not; raises InputError for none."""
    names = list(known)
    if (name := meant(key, names)) is not None:
        return name
    bare = {bare_key(name) for name in names if "seconds" not in name}
    remedy = did_you_mean(key, bare)
    if remedy.startswith("known"):  # all entries of all lists would be no help
        remedy = did_you_mean(key, {name.partition(".")[0] for name in bare})
    raise InputError(f"{what} {key}", "no such number in the result", remedy=remedy)


def worded(key: str, value: Estimate | float) -> str:
    """Return a result in words: `all_touch_force 3 N`, or with its error."""
    estimate = value if isinstance(value, Estimate) else Estimate(value, None, unit_of_key(key))
    return f"{bare_key(key)} {estimate}".rstrip()


def slack(estimate: Estimate) -> float:
    """Return an estimate's error, 0 where nobody knows it."""
    return 0.0 if estimate.error is None or not math.isfinite(estimate.error) else estimate.error


# what the JSON of several studies' results has
@reported(meaning="wall time, s", key="seconds")
def total_seconds(result: Any) -> dict[str, float]:
    """The wall time, s."""
    return {"total": result.seconds}


@reported(meaning="keys and their ranges or choices", key="vary")
def ranges(result: Any) -> dict[str, list[Value]]:
    """What was varied."""
    return {knob.key: knob.range for knob in result.knobs}


ECHOED = (
    "force_N",
    "friction",
    "holding.mass_g",
    "holding.rate_Hz",
)  # what a check was asked: no results that could be wanted
Kind = Literal["check", "make", "simulate", "circuit"]


@dataclass(frozen=True)
class Query:
    """What is asked: a check at `force` N (the design's own if None) by a model, its mesh to `tol`, with the
    lifts of an object of `hold` g by the mount's gripper where that is given; a make, with that check; a
    scene's simulation to `tol`; or a circuit's gain."""

    kind: Kind
    model: str | None = None
    tol: float | None = None
    force: float | None = None
    hold: float | None = None

    def key(self, subject: Subject) -> str:
        """Return what tells this question of this subject from any other."""
        asked = asdict(self)
        if self.hold is None:  # as it was before anybody could ask that: old logs stay good
            del asked["hold"]
        text = json.dumps([fingerprint(subject), asked], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Evaluation:
    """What a question's result said, or why it was refused; `seconds` of wall time, `when` it began (UTC).

    `results` holds every number of the result's JSON by its key (`query.py`). What lies beyond the range
    of its model is refused too, with its numbers.
    """

    key: str
    values: Mapping[str, Value]
    results: Mapping[str, Estimate] = field(default_factory=dict)
    passed: bool | None = None
    refused: str = ""
    model: str = ""
    seconds: float = 0.0
    when: str = ""
    version: str = __version__


def question_of(
    subject: Subject,
    *,
    model: str | None = None,
    tol: float | None = None,
    force: float | None = None,
    hold: str | float | None = None,
) -> Query:
    """Return what is asked of a subject: a design's check, a scene's simulation, a circuit's gain.

    Raises InputError for a model, tolerance, force or mass that there is none of, or where there is none.
    """
    require_goals(tol, None, "0.05")
    if isinstance(subject, Design):
        if force is not None:
            require_force(force)
        if model not in (None, "auto"):
            model_named(model)
        return Query("check", model, tol, force, None if hold is None else asked_lifts(subject, hold)[0])
    for name, value in (("model", model), ("force", force), ("hold", hold)):
        if value is not None:
            what = "a scene" if isinstance(subject, Scene) else "a circuit"
            raise InputError(name, f"is for a design, and {subject.name} is {what}", value, "leave it out")
    return Query("simulate", tol=tol) if isinstance(subject, Scene) else Query("circuit")


def first_able(models: Sequence[str], design: Design) -> str:
    """Return the first of these models that can judge a design; the last ones of all lists take any."""
    return next(name for name in models if not unsupported_reason(name, design, False))


def evaluate(subject: Subject, values: Mapping[str, Value], question: Query) -> Evaluation:
    """Return the answer for a subject with these values, which its own rules may refuse, or the model."""
    safe_point()
    began, when = perf_counter(), datetime.now(UTC).isoformat(timespec="seconds")
    key, refused, result = "", "", None
    try:
        one = changed(subject, values)
        key = question.key(one)
        result = _ASKED[question.kind](one, question)
    except ExhaustedError:
        raise  # says nothing of the design
    except (InputError, RefusedError) as failure:
        refused = str(failure)
    numbers = {} if result is None else result.numbers()
    return Evaluation(
        key=key or _unmade(subject, values, question),
        values=dict(values),
        results={name: estimate for name, estimate in numbers.items() if name not in ECHOED},
        passed=getattr(result, "passed", None),
        refused=refused or getattr(result, "out_of_range", ""),
        model=getattr(result, "model", ""),
        seconds=perf_counter() - began,
        when=when,
    )


def key_of(subject: Subject, values: Mapping[str, Value], question: Query) -> str:
    """Return the key of what `evaluate` would answer, without asking."""
    try:
        return question.key(changed(subject, values))
    except InputError:
        return _unmade(subject, values, question)


def _unmade(subject: Subject, values: Mapping[str, Value], question: Query) -> str:
    """The key of a design that its own rules refuse: the start's, and what was changed."""
    text = json.dumps([question.key(subject), sorted(values.items())])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _check(subject: Any, question: Query) -> Result:
    model = question.model or "auto"
    return check(subject, force=question.force, model=model, tol=question.tol, hold=question.hold)


def _make(subject: Any, _: Query) -> Result:
    from skincad.fabrication.making import make

    return make(subject)


def _simulate(subject: Any, question: Query) -> Result:
    from skincad.scenes.lift import lift
    from skincad.scenes.simulation import marched, marching, read_out

    if subject.grip is not None:
        return lift(subject)
    key = question.key(marching(subject))
    if key not in _LAST:  # a search over an amplifier alone marches once
        run = marched(subject, tol=question.tol)
        _LAST.clear()
        _LAST[key] = run
    return read_out(subject, _LAST[key])


def _gain(subject: Any, _: Query) -> Result:
    from skincad.circuit.bode import gain

    return gain(subject)


_LAST: dict[str, Any] = {}  # of the scene that was simulated last, its march

_ASKED: dict[str, Callable[[Any, Query], Result]] = {
    "check": _check,
    "make": _make,
    "simulate": _simulate,
    "circuit": _gain,
}


GUIDE = "winkler"  # the closed form: a thousandth of the time, and the right slope


@dataclass
class Evaluator:
    """A question of a subject, its evaluations so far by key, and the numbers `wished` of them.

    `target` is what is wished by the result's own keys, empty until the first answer tells them. `bounds`
    says of which wishes the number is a limit, "<=" or ">=", by the same keys; one that is kept is met.
    """

    subject: Subject
    question: Query
    wished: Mapping[str, float]
    progress: Progress | None = None
    bounds: dict[str, str] = field(default_factory=dict)
    target: dict[str, float] = field(default_factory=dict)
    evaluations: dict[str, Evaluation] = field(default_factory=dict)
    unlike: bool = False  # whether the closed form's result lacks a number that is wished

    def ask(self, values: Mapping[str, Value]) -> Evaluation:
        """Return the answer for some values. Raises InputError for a wish that no result's key is."""
        key = key_of(self.subject, values, self.question)
        if key not in self.evaluations:
            if self.progress:
                self.progress(
                    ", ".join(f"{name.rpartition('.')[2]} {short(v)}" for name, v in values.items())
                )
            self.evaluations[key] = evaluation = evaluate(self.subject, values, self.question)
            self.name(evaluation)
        return self.evaluations[key]

    def name(self, evaluation: Evaluation) -> None:
        """Take the wishes' keys from a first answer."""
        if evaluation.results and not self.target:
            names = {key: resolved(key, evaluation.results) for key in self.wished}
            self.target = {names[key]: value for key, value in self.wished.items()}
            self.bounds = {names[key]: side for key, side in self.bounds.items()}

    def told(self, evaluation: Evaluation) -> list[float] | None:
        """Return the wished results' values; None where one has none or the design is refused."""
        if evaluation.refused or not evaluation.results:
            return None
        known = evaluation.results
        values = [known[key].value if key in known else None for key in self.target]
        return [value for value in values if value is not None] if None not in values else None

    def missed(self, evaluation: Evaluation) -> list[float] | None:
        """Return by how much each wish is missed, value less what is wished: 0 where a bound is kept."""
        values = self.told(evaluation)
        if values is None:
            return None
        off = {key: value - self.target[key] for key, value in zip(self.target, values, strict=True)}
        kept = {"<=": max, ">=": min}
        return [kept[self.bounds[key]](d, 0.0) if key in self.bounds else d for key, d in off.items()]

    def guide(self, values: Mapping[str, Value]) -> list[float] | None:
        """Return what the closed form says, without counting it as an evaluation; None where it does not."""
        evaluation = evaluate(self.subject, values, replace(self.question, model=GUIDE))
        self.name(evaluation)
        return self.told(evaluation)

    @property
    def guided(self) -> bool:
        """Whether there is a closed form that is cheaper than what is asked."""
        closed = self.question.kind == "check" and self.question.hold is None
        return closed and self.question.model != GUIDE and not self.unlike

    def off(self, evaluation: Evaluation) -> float:
        """Return how far an answer is from the wishes, in parts of them; infinite where it has no values."""
        missed = self.missed(evaluation)
        if missed is None:
            return math.inf
        return max(abs(d) / (abs(y) or 1.0) for d, y in zip(missed, self.target.values(), strict=True))


def short(value: Value) -> str:
    """Return a value as it is shown."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def scaled(value: Array, wanted: Array) -> Array:
    """Return results as logarithms where they are wanted above 0: powers of sizes are lines then."""
    above = wanted > 0
    logs = np.log(np.maximum(value, 1e-9 * np.abs(wanted)), where=above, out=np.zeros(len(wanted)))
    return np.where(above, logs, value)
