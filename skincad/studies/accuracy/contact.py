"""The ladder of contact models.

Contact: models, meshes and orders, judged by F9, the force from which all ridges touch, and the approach. Two
errors that are never mixed. The mesh's: each physical model against its own finest setting. The whole: every
trial against the best model that can judge the design. A model's time includes all that it builds on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from skincad.base.errors import InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.mechanics.bodies.mesh import meshed_piece, plane_piece
from skincad.mechanics.models import finite_strain, linear, solid
from skincad.mechanics.models.correction import LevelAnswer
from skincad.mechanics.models.linear import LevelSolver
from skincad.mechanics.models.solid import Layers, coarse_sizes, forms_of, solve_level
from skincad.mechanics.models.table import (
    MODELS,
    run,
    unsupported_reason,
)
from skincad.mechanics.problem import NEGLIGIBLE, Answer, Request, pad_of, solid_pad_of
from skincad.mechanics.validity import refuse_crushed
from skincad.shape.skin import skin_of
from skincad.studies.accuracy.ladder import ErrorMeasure, Ladder, Measurement, repeated, timed

AIM = {  # the model whose finest setting another's mesh and method aim at
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


MESH = 5e-3  # relative; what `check` asks of a model's mesh
BEST = ("solid-finite-strain", "corrected-finite-strain", "solid", "corrected", "linear")
OWN = "as check takes it"
ALONE = ("winkler", "corrected")  # short enough to be solved again from nothing
# fineness and order of each level, the last the reference
LEVELS: dict[str, tuple[tuple[float, int], ...]] = {
    "linear": ((0.5, 2), (0.5, 3), (1.0, 2), (1.0, 3), (1.0, 4), (2.0, 3), (2.0, 4), (2.0, 5)),
    "finite-strain": ((0.5, 2), (0.5, 3), (1.0, 2), (1.0, 3), (1.0, 4)),
}
SOLVERS: dict[str, LevelSolver] = {"linear": linear.level, "finite-strain": finite_strain.level}


# in which models are tried: the known ones as the next builds on the last, then any other of the table
ORDER = tuple(dict.fromkeys(("winkler", *LEVELS, "solid", "corrected", *BEST[1::-1], *MODELS)))
SOLID_LEVELS = {"coarse": 0.15, "fine": 0.3}  # layers, and their time in that of the solid model
# Expected times, s: of the linear model on yamada-2002; of a level in that of its model, which grows with
# (order - 0.65) times this
LINEAR, OF_LEVEL, BY_FINENESS = 0.9, 0.5, {0.5: 0.425, 1.0: 0.457, 2.0: 0.605}
RIDGES = 9  # yamada-2002's


def ladder(design: Design, repeats: int, progress: Progress | None) -> Ladder:
    """Return every model that can judge the design at its own force; the plane ones mesh by mesh."""
    runs = _ContactRuns(design, repeats, progress)
    for name in ORDER:
        runs.attempt(name)
    best = next((name for name in BEST if name in runs.truth), "")
    force, height = runs.request.force, design.skin.thickness
    trials = tuple(trial_of(answer, runs.truth, best, force, height) for answer in runs.found)
    title = f"contact of {design.name} at {force:g} N"
    return Ladder("contact", title, trials, measures_of(runs.truth, best), skipped=runs.skipped)


def prices(design: Design, repeats: int) -> dict[str, float]:
    """Return the stages and their expected seconds, by the models' prices and the number of ridges."""
    seconds: dict[str, float] = {}
    linear_seconds = LINEAR * skin_of(design).count / RIDGES
    for name in (name for name in ORDER if not unsupported_reason(name, design, measured=False)):
        alone, price = repeats if name in ALONE else 1, linear_seconds * MODELS[name].price
        for level in LEVELS.get(name, ()):
            part = OF_LEVEL * (level[1] - 0.65) * BY_FINENESS[level[0]]
            last = level == LEVELS[name][-1]
            seconds[_level(name, *level)] = repeated(part * price, 1 if last else repeats)
        if name in LEVELS:
            continue
        if name == "solid":
            seconds |= {
                _layers(solid_level): repeated(s * price, repeats) for solid_level, s in SOLID_LEVELS.items()
            }
        seconds[_stage(name)] = repeated(price, alone)
    return seconds


class _ContactRuns:
    """What is found so far."""

    def __init__(self, design: Design, repeats: int, progress: Progress | None) -> None:
        self.design, self.repeats, self.progress = design, repeats, progress
        self.request = Request(design.contact.force, MESH)
        self.found: list[ContactAnswer] = []
        self.truth: dict[str, Truth] = {}
        self.skipped: dict[str, str] = {}
        self.done: dict[str, Answer] = {}

    def attempt(self, name: str) -> None:
        """Try a model; one that cannot judge the design is skipped with its reason."""
        reason = unsupported_reason(name, self.design, measured=False)
        try:
            if not reason and name in LEVELS:
                self._levels(name)
            elif not reason:
                self._model(name)
        except (InputError, RefusedError) as refusal:
            reason = str(refusal)
        if reason:
            self.skipped[name] = reason

    def _levels(self, name: str) -> None:
        pad, force = pad_of(self.design), self.request.force
        errors = []
        for fineness, order in LEVELS[name]:
            setting = f"fineness {fineness:g}, order {order}"
            self._tell(_level(name, fineness, order))

            def solved(fineness: float = fineness, order: int = order) -> linear.PlaneSolution:
                return SOLVERS[name](plane_piece(pad, fineness), order, force, (), None)

            last = (fineness, order) == LEVELS[name][-1]  # the reference: its time is not asked
            level, runs = timed(solved, 1 if last else self.repeats)
            refuse_crushed(self.design, force, name, level.approach)
            numbers = level.all_touch_force, level.approach
            errors.append(ContactAnswer(name, setting, level.unknowns, runs, *numbers))
        finest, before = errors[-1], errors[-2]
        own_errors = apart(finest, before, force, pad.top)
        words = (
            f"{finest.setting}; {before.setting} differs by {own_errors[0]:.0e}, approach {own_errors[1]:.0e}"
        )
        self.truth[name] = Truth(finest, own_errors, words)
        self.found += errors[:-1]

    def _model(self, name: str) -> None:
        if name == "solid":
            self._solid_levels()
        self._tell(_stage(name))
        alone, answers = name in ALONE, self.done

        def work() -> Answer:
            nonlocal answers
            answers = {} if alone else self.done
            return run(name, self.design, self.request, answers, None)

        answer, runs = timed(work, self.repeats if alone else 1)
        refuse_crushed(self.design, self.request.force, name, answer.approach.value or 0.0)
        self.done |= answers
        if not alone:
            runs = (math.fsum(answer.seconds.values()),)
        setting = "closed form" if name == "winkler" else OWN
        force, approach = answer.all_touch_force, answer.approach
        row = ContactAnswer(name, setting, answer.unknowns, runs, force.value, approach.value or 0.0)
        self.found.append(row)
        if name != "winkler":
            own_errors = (stated(force, NEGLIGIBLE * self.request.force), stated(approach, 0.0))
            words = f"model {name}; its stated error, {own_errors[0]:.1e} of the all-touch force and "
            words += f"{own_errors[1]:.1e} of the approach, is "
            self.truth[name] = Truth(
                row, own_errors, words + "checked against finer meshes in tests/mechanics"
            )

    def _solid_levels(self) -> None:
        """The solid's coarsest levels, which its model adds up."""
        pad, first_level = solid_pad_of(self.design), solid.REFINEMENTS[0]
        for layers, label in zip(solid.LAYERS[first_level.fineness], SOLID_LEVELS, strict=True):
            setting = f"order {first_level.order - 1}, {label} layers"
            self._tell(_layers(label))

            def solved(layers: Layers = layers) -> LevelAnswer:
                meshed = meshed_piece(pad, coarse_sizes(pad, first_level.fineness))
                forms = forms_of(meshed, first_level.order - 1)
                return solve_level(meshed, forms, layers, self.request.force, {})

            level, runs = timed(solved, self.repeats)
            numbers = level.all_touch_force, level.approach
            self.found.append(ContactAnswer("solid", setting, level.unknowns, runs, *numbers))

    def _tell(self, what: str) -> None:
        if self.progress:
            self.progress(what)


def _stage(name: str) -> str:
    return f"contact: {name}"


def _level(name: str, fineness: float, order: int) -> str:
    return f"contact: {name}, fineness {fineness:g}, order {order}"


def _layers(level: str) -> str:
    return f"contact: solid, {level} layers"
