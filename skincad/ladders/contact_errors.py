"""How contact's trials are judged: the mesh's error against a model's finest setting, the whole against the
best model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from skincad.base.estimate import Estimate
from skincad.ladders.ladder import ErrorMeasure, Measurement
from skincad.mechanics.problem import NEGLIGIBLE

AIM = {  # the tier whose finest setting another's mesh and method aim at
    **{name: name for name in ("linear", "finite-strain", "solid", "solid-finite-strain")},
    "corrected": "solid",
}


@dataclass(frozen=True)
class ContactAnswer:
    """What a trial found: F9 in N (None where there is none), approach in mm."""

    model: str
    setting: str
    unknowns: int
    runs: tuple[float, ...]
    force: float | None
    approach: float


@dataclass(frozen=True)
class Truth:
    """A model's finest setting; `own` its relative errors of F9 and approach, `words` how they are known."""

    answer: ContactAnswer
    own_errors: tuple[float, float]
    words: str


def apart(answer: ContactAnswer, truth: ContactAnswer, force: float, height: float) -> tuple[float, float]:
    """Return the relative differences of F9 and approach; nan where there is no F9."""
    by_force, by_approach = math.nan, abs(answer.approach - truth.approach)
    if answer.force is not None and truth.force is not None:
        by_force = abs(answer.force - truth.force) / max(truth.force, NEGLIGIBLE * force)
    return by_force, by_approach / max(truth.approach, 1e-9 * height)


def stated(estimate: Estimate, least: float) -> float:
    """Return the relative error that an estimate states, of `least` at least; nan without a value."""
    value = estimate.value
    return math.nan if value is None else (estimate.error or 0.0) / max(value, least)


def trial_of(
    answer: ContactAnswer, truths: Mapping[str, Truth], best: str, force: float, height: float
) -> Measurement:
    """Return a trial with its errors; the best model has its own stated error as whole one."""
    errors: dict[str, float] = {}
    for kind, name in (("mesh", AIM.get(answer.model, "")), ("whole", best)):
        truth = truths.get(name)
        itself = truth is not None and answer is truth.answer
        if truth is None or (itself and kind == "mesh"):
            continue
        values = truth.own_errors if itself else apart(answer, truth.answer, force, height)
        named = zip(("F9", "approach"), values, strict=True)
        errors |= {f"{kind} {q}": error for q, error in named if not math.isnan(error)}
    return Measurement(answer.model, answer.setting, answer.unknowns, answer.runs, errors)


def measures_of(truths: Mapping[str, Truth], best: str) -> tuple[ErrorMeasure, ...]:
    """Return what contact's trials are judged by; `best` is the best model that judged the design, or ""."""
    own_words = "; ".join(f"{name}: {truth.words}" for name, truth in truths.items() if name in AIM.values())
    measures = []
    for quantity, what in enumerate(("F9", "approach")):
        floor = truths[best].own_errors[quantity] if best else 0.0
        named = {"F9": "all-touch force", "approach": "approach"}[what]
        measures.append(
            ErrorMeasure(
                f"mesh {what}",
                f"error of mesh and method in {named}, relative",
                "1",
                "each model's own finest setting",
                own_words,
                compares=False,
                label=f"mesh {named}",
            )
        )
        measures.append(
            ErrorMeasure(
                f"whole {what}",
                f"error of model and mesh in {named}, relative",
                "1",
                f"{best or 'none'}: the best model that can judge this design",
                truths[best].words if best else "nothing",
                floor=0.0 if math.isnan(floor) else floor,
                label=f"whole {named}",
            )
        )
    return tuple(measures)
