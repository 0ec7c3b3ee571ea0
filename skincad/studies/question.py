"""What a study asks of each of its designs, and one answer."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from time import perf_counter
from typing import Any, Literal

from skincad.base.arguments import require_goals
from skincad.base.errors import ExhaustedError, InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.base.interrupt import safe_point
from skincad.base.version import __version__
from skincad.inputs.design import Design
from skincad.mechanics.check import check, require_force
from skincad.mechanics.models.table import tier_of, unsupported_reason
from skincad.scenes.scene import Scene
from skincad.studies.measures import measures
from skincad.studies.subject import Subject, Value, changed, fingerprint

ECHOED = ("force_N", "friction")  # what a check was asked: no results that could be wanted
Kind = Literal["check", "make", "simulate", "circuit"]


@dataclass(frozen=True)
class Query:
    """What is asked: a check at `force` N (the design's own if None) by a tier, its mesh to `tol`; a make,
    with that check; a scene's simulation to `tol`; or a circuit's gain."""

    kind: Kind
    tier: str | None = None
    tol: float | None = None
    force: float | None = None

    def key(self, subject: Subject) -> str:
        """Return what tells this question of this subject from any other."""
        text = json.dumps([fingerprint(subject), asdict(self)], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Evaluation:
    """What a question's result said, or why it was refused; `seconds` of wall time, `when` it began (UTC).

    `results` holds every number of the result's JSON by its key (`measures.py`). What lies beyond the range
    of its model is refused too, with its numbers.
    """

    key: str
    values: Mapping[str, Value]
    results: Mapping[str, Estimate] = field(default_factory=dict)
    passed: bool | None = None
    refused: str = ""
    tier: str = ""
    seconds: float = 0.0
    when: str = ""
    version: str = __version__


def question_of(
    subject: Subject, *, tier: str | None = None, tol: float | None = None, force: float | None = None
) -> Query:
    """Return what is asked of a subject: a design's check, a scene's simulation, a circuit's gain.

    Raises InputError for a tier, tolerance or force that there is none of, or where there is none.
    """
    require_goals(tol, None, "0.05")
    if isinstance(subject, Design):
        if force is not None:
            require_force(force)
        if tier not in (None, "auto"):
            tier_of(tier)
        return Query("check", tier, tol, force)
    for name, value in (("tier", tier), ("force", force)):
        if value is not None:
            what = "a scene" if isinstance(subject, Scene) else "a circuit"
            raise InputError(name, f"is for a design, and {subject.name} is {what}", value, "leave it out")
    return Query("simulate", tol=tol) if isinstance(subject, Scene) else Query("circuit")


def first_able(tiers: Sequence[str], design: Design) -> str:
    """Return the first of these tiers that can judge a design; the last ones of all lists take any."""
    return next(name for name in tiers if not unsupported_reason(name, design, False))


def evaluate(subject: Subject, values: Mapping[str, Value], question: Query) -> Evaluation:
    """Return the answer for a subject with these values, which its own rules may refuse, or the model."""
    safe_point()
    began, when = perf_counter(), datetime.now(UTC).isoformat(timespec="seconds")
    key, data, refused = "", dict[str, Any](), ""
    try:
        one = changed(subject, values)
        key = question.key(one)
        data = _ASKED[question.kind](one, question).as_json()
    except ExhaustedError:
        raise  # says nothing of the design
    except (InputError, RefusedError) as failure:
        refused = str(failure)
    seconds = perf_counter() - began
    return told_by(data, key or _unmade(subject, values, question), values, refused, seconds, when)


def told_by(
    data: Mapping[str, Any],
    key: str,
    values: Mapping[str, Value],
    refused: str = "",
    seconds: float = 0.0,
    when: str = "",
) -> Evaluation:
    """Return the evaluation that a result's JSON tells."""
    refused = refused or data.get("beyond_range") or ""
    tier = data.get("tier", "")
    results = {name: estimate for name, estimate in measures(data).items() if name not in ECHOED}
    return Evaluation(key, dict(values), results, data.get("passed"), refused, tier, seconds, when)


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


def _check(subject: Any, question: Query) -> Any:
    return check(subject, force=question.force, tier=question.tier or "auto", tol=question.tol)


def _make(subject: Any, _: Query) -> Any:
    from skincad.fabrication.making import make

    return make(subject)


def _simulate(subject: Any, question: Query) -> Any:
    from skincad.scenes.simulation import marched, marching, read_out

    key = question.key(marching(subject))
    if key not in _LAST:  # a search over an amplifier alone marches once
        run = marched(subject, tol=question.tol)
        _LAST.clear()
        _LAST[key] = run
    return read_out(subject, _LAST[key])


def _gain(subject: Any, _: Query) -> Any:
    from skincad.circuit.bode import gain

    return gain(subject)


_LAST: dict[str, Any] = {}  # of the scene that was simulated last, its march

_ASKED: dict[str, Callable[[Any, Query], Any]] = {
    "check": _check,
    "make": _make,
    "simulate": _simulate,
    "circuit": _gain,
}
