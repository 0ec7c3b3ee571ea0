"""The ladder of contact models.

Contact: models, meshes and orders, judged by F9, the force from which all ridges touch, and the approach. Two
errors that are never mixed. The mesh's: each physical model against its own finest setting. The whole: every
trial against the best model that can judge the design. A model's time includes all that it builds on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

from skincad.base.errors import InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.inputs.design import Design
from skincad.mechanics.bodies.mesh import meshed_piece, plane_piece
from skincad.mechanics.models import finite_strain, linear, solid
from skincad.mechanics.models.correction import LevelAnswer
from skincad.mechanics.models.linear import LevelSolver
from skincad.mechanics.models.solid import Layers, coarse_sizes, forms_of, solve_level
from skincad.mechanics.models.table import MODELS, run, unsupported_reason
from skincad.mechanics.problem import NEGLIGIBLE, Answer, Request, pad_of, solid_pad_of
from skincad.mechanics.validity import refuse_crushed
from skincad.studies.accuracy.ladder import ErrorMeasure, Ladder, Measurement, timed

AIM = {  # the model whose finest setting another's mesh and method aim at
    **{name: name for name in ("linear", "finite-strain", "solid", "solid-finite-strain")},
    "corrected": "solid",
}
QUANTITIES = {"F9": "all-touch force", "approach": "approach"}
MESH = 5e-3  # relative; what `check` asks of a model's mesh
BEST = ("solid-finite-strain", "corrected-finite-strain", "solid", "corrected", "linear")
ALONE = ("winkler", "corrected")  # short enough to be solved again from nothing
# fineness and order of each level, the last the reference
LEVELS: dict[str, tuple[tuple[float, int], ...]] = {
    "linear": ((0.5, 2), (0.5, 3), (1.0, 2), (1.0, 3), (1.0, 4), (2.0, 3), (2.0, 4), (2.0, 5)),
    "finite-strain": ((0.5, 2), (0.5, 3), (1.0, 2), (1.0, 3), (1.0, 4)),
}
SOLVERS: dict[str, LevelSolver] = {"linear": linear.level, "finite-strain": finite_strain.level}
# in which models are tried: the known ones as the next builds on the last, then any other of the table
ORDER = tuple(dict.fromkeys(("winkler", *LEVELS, "solid", "corrected", *BEST[1::-1], *MODELS)))


@dataclass(frozen=True)
class ContactAnswer:
    """A model's answer at a setting: F9 in N (None where there is none), approach in mm.

    A model's finest setting is a truth: its relative errors of F9 and approach, and `words` on them.
    """

    model: str
    setting: str
    unknowns: int
    runs: tuple[float, ...]
    force: float | None
    approach: float
    own_errors: tuple[float, float] = (math.nan, math.nan)
    words: str = ""


def ladder(design: Design, repeats: int, tell: Callable[[str], None]) -> Ladder:
    """Return every model that can judge the design at its own force; the plane ones mesh by mesh."""
    request = Request(design.contact.force, MESH)
    force, height = request.force, design.skin.thickness
    answers: list[ContactAnswer] = []
    skipped: dict[str, str] = {}
    known: dict[str, Answer] = {}
    for name in ORDER:
        reason = unsupported_reason(name, design, measured=False)
        try:
            if not reason and name in LEVELS:
                answers += plane_levels(name, design, force, repeats, tell)
            elif not reason:
                if name == "solid":
                    answers += solid_levels(design, force, repeats, tell)
                tell(name)
                answers.append(whole_model(name, design, request, repeats, known))
        except (InputError, RefusedError) as refusal:
            reason = str(refusal)
        if reason:
            skipped[name] = reason
    truths = {answer.model: answer for answer in answers if answer.words}
    best = next((name for name in BEST if name in truths), "")
    trials = [
        Measurement(a.model, a.setting, a.unknowns, a.runs, errors_of(a, truths, best, force, height))
        for a in answers
        if not (a.words and a.model in LEVELS)  # a reference, whose time is not asked
    ]
    title = f"contact of {design.name} at {force:g} N"
    return Ladder("contact", title, tuple(trials), measures_of(truths, best), skipped=skipped)


def plane_levels(
    name: str, design: Design, force: float, repeats: int, tell: Callable[[str], None]
) -> list[ContactAnswer]:
    """Return a plane model's answers, the last its truth."""
    pad, answers = pad_of(design), list[ContactAnswer]()
    for fineness, order in LEVELS[name]:
        setting = f"fineness {fineness:g}, order {order}"
        tell(f"{name}, {setting}")

        def solved(fineness: float = fineness, order: int = order) -> linear.PlaneSolution:
            return SOLVERS[name](plane_piece(pad, fineness), order, force, (), None)

        last = (fineness, order) == LEVELS[name][-1]
        level, runs = timed(solved, 1 if last else repeats)
        refuse_crushed(design, force, name, level.approach)
        numbers = level.all_touch_force, level.approach
        answers.append(ContactAnswer(name, setting, level.unknowns, runs, *numbers))
    *others, finest = answers
    errors = apart(finest, others[-1], force, pad.top)
    words = f"{finest.setting}; {others[-1].setting} differs by {errors[0]:.0e}, approach {errors[1]:.0e}"
    return [*others, replace(finest, own_errors=errors, words=words)]


def solid_levels(
    design: Design, force: float, repeats: int, tell: Callable[[str], None]
) -> Iterator[ContactAnswer]:
    """Yield the answers of the solid's coarsest levels, which its model adds up."""
    pad, first = solid_pad_of(design), solid.REFINEMENTS[0]

    def solved(layers: Layers) -> LevelAnswer:
        meshed = meshed_piece(pad, coarse_sizes(pad, first.fineness))
        return solve_level(meshed, forms_of(meshed, first.order - 1), layers, force, {})

    for layers, label in zip(solid.LAYERS[first.fineness], ("coarse", "fine"), strict=True):
        tell(f"solid, {label} layers")
        level, runs = timed(partial(solved, layers), repeats)
        numbers = level.all_touch_force, level.approach
        setting = f"order {first.order - 1}, {label} layers"
        yield ContactAnswer("solid", setting, level.unknowns, runs, *numbers)


def whole_model(
    name: str, design: Design, request: Request, repeats: int, known: dict[str, Answer]
) -> ContactAnswer:
    """Return a model's answer as `check` takes it; what it builds on is taken from `done` and added there."""
    alone, answers = name in ALONE, known

    def work() -> Answer:
        nonlocal answers
        answers = {} if alone else known
        return run(name, design, request, answers, None)

    answer, runs = timed(work, repeats if alone else 1)
    force, approach = answer.all_touch_force, answer.approach
    refuse_crushed(design, request.force, name, approach.value or 0.0)
    known |= answers
    if not alone:
        runs = (math.fsum(answer.seconds.values()),)

    def stated(estimate: Estimate, least: float) -> float:
        return math.nan if estimate.value is None else (estimate.error or 0.0) / max(estimate.value, least)

    errors, words = (stated(force, NEGLIGIBLE * request.force), stated(approach, 0.0)), ""
    if name != "winkler":
        words = f"model {name}; its stated error, {errors[0]:.1e} of the all-touch force and "
        words += f"{errors[1]:.1e} of the approach, is checked against finer meshes in tests/mechanics"
    setting = "as check takes it" if words else "closed form"
    numbers = answer.unknowns, runs, force.value, approach.value or 0.0
    return ContactAnswer(name, setting, *numbers, own_errors=errors, words=words)


def errors_of(
    answer: ContactAnswer, truths: Mapping[str, ContactAnswer], best: str, force: float, height: float
) -> dict[str, float]:
    """Return an answer's errors by measure; the best model has its own stated error as whole one."""
    errors: dict[str, float] = {}
    for kind, name in (("mesh", AIM.get(answer.model, "")), ("whole", best)):
        truth = truths.get(name)
        if truth is None or (answer is truth and kind == "mesh"):
            continue
        values = truth.own_errors if answer is truth else apart(answer, truth, force, height)
        named = zip(QUANTITIES, values, strict=True)
        errors |= {f"{kind} {quantity}": error for quantity, error in named if not math.isnan(error)}
    return errors


def apart(answer: ContactAnswer, truth: ContactAnswer, force: float, height: float) -> tuple[float, float]:
    """Return the relative differences of F9 and approach; nan where there is no F9."""
    by_force, by_approach = math.nan, abs(answer.approach - truth.approach)
    if answer.force is not None and truth.force is not None:
        by_force = abs(answer.force - truth.force) / max(truth.force, NEGLIGIBLE * force)
    return by_force, by_approach / max(truth.approach, 1e-9 * height)


def measures_of(truths: Mapping[str, ContactAnswer], best: str) -> tuple[ErrorMeasure, ...]:
    """Return what contact's trials are judged by; `best` is the best model that judged the design, or ""."""
    own_words = "; ".join(f"{name}: {truth.words}" for name, truth in truths.items() if name in AIM.values())
    against = f"{best or 'none'}: the best model that can judge this design"
    measures = []
    for (key, quantity), errors in zip(
        QUANTITIES.items(), truths[best].own_errors if best else (0.0, 0.0), strict=True
    ):
        floor = 0.0 if math.isnan(errors) else errors
        mesh, whole = (
            f"error of {of} in {quantity}, relative" for of in ("mesh and method", "model and mesh")
        )
        finest, words = "each model's own finest setting", truths[best].words if best else "nothing"
        labels = f"mesh {quantity}", f"whole {quantity}"
        measures += [
            ErrorMeasure(f"mesh {key}", mesh, "1", finest, own_words, compares=False, label=labels[0]),
            ErrorMeasure(f"whole {key}", whole, "1", against, words, floor=floor, label=labels[1]),
        ]
    return tuple(measures)
