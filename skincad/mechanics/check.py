"""The check: models from the cheapest to the best, until the verdict is clear or nothing better fits."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter

from skincad.base.adaptivity import overrun
from skincad.base.errors import (
    ExhaustedError,
    InputError,
    RefusedError,
    require_goals,
    require_number,
    resource_guard,
)
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress, about
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.process import processes
from skincad.mechanics.fits import unlike
from skincad.mechanics.left_out import POCKETS, LeftOut, left_out, unknown_pockets
from skincad.mechanics.magnetics import magnet_signal
from skincad.mechanics.models.table import (
    AUTO,
    AUTO_IF,
    MODELS,
    expected_seconds,
    is_small_strain,
    left_out_by,
    load,
    model_named,
    prerequisites,
    run,
    unsupported_reason,
)
from skincad.mechanics.plate_friction import PlateFriction, has_ends
from skincad.mechanics.problem import (
    Answer,
    ContactError,
    LateError,
    Request,
    SizeError,
    Spread,
    Yield,
    no_yield,
)
from skincad.mechanics.validity import (
    bone_warnings,
    exceeds_small_strain,
    limits,
    material_warnings,
    refuse_crushed,
    slope_warnings,
    small_strain_violation,
    strain_warnings,
    tipping,
)
from skincad.mechanics.verdict import (
    ContactCheck,
    ModelRun,
    NextModel,
    before_refusal,
    fails_by_far,
    is_decided,
    is_undecidable,
    relative_error,
    wiring_order,
    with_model_error,
    with_open_friction,
    with_shortfall,
    without_mesh_tolerance,
)
from skincad.shape.crests import crest_drops, shift_warnings
from skincad.shape.skin import skin_of

LARGEST_FORCE = 1e6  # N, as contact.force
FOUR_CHANNELS = 2  # ridges of two strips: with no more there is nothing to choose


def require_force(force: float) -> None:
    """Raise InputError unless a normal force, N, is one that can be asked for."""
    rule = f"must be above 0 N and at most {LARGEST_FORCE:g} N"
    require_number("force", force, lambda value: 0 < value <= LARGEST_FORCE, rule)


def check(
    design: Design,
    *,
    force: float | None = None,
    tol: float | None = None,
    budget: float | None = None,
    model: str = "auto",
    measured: Path | str | None = None,
    progress: Progress | None = None,
    on_verdict: OnVerdict | None = None,
) -> ContactCheck:
    """Return whether all ridges touch a rigid plate at `force` N (the design's own if None).

    The arguments are those of `skincad.check` (studies/holding.py), which adds a gripper. Raises InputError
    for a force, tolerance, budget or model out of range.
    """
    if not isinstance(design, Design):
        raise InputError("design", "must be a Design", design, "skincad.load(...) gives one")
    load = design.contact.force if force is None else force
    require_force(load)
    require_goals(tol, budget, "0.05")
    if measured is not None and not _models_for(design, measured=True):
        raise InputError("measured", "judges skins that are straight along y", measured, "leave it out")
    crest_offsets, notes = ((), ()) if measured is None else crest_drops(measured, design)
    notes = (*notes, *slope_warnings(design), *shift_warnings(crest_offsets, design))
    notes = (*notes, *material_warnings(design), *bone_warnings(design))
    solutions = Solutions(design, load, crest_offsets, notes, progress, on_verdict)
    if model == "auto":
        if not solutions.models:
            rule = "must be 'flat' for pins and for a round skin"
            raise InputError(
                "contact.plate.shape", rule, design.contact.plate.shape, "leave [contact.plate] out"
            )
        return _auto(solutions, tol, budget)
    model_named(model)
    if reason := unsupported_reason(model, design, bool(crest_offsets)):
        raise InputError("model", reason, model, "leave it out")
    request = replace(solutions.request, tol=tol, budget=budget)
    verdict = solutions.with_yield(solutions.verdict(model, request))
    return with_shortfall(verdict, tol, verdict.model_error)


MIN_BUDGET = 1e-3  # s; stands for a used-up budget: only the coarsest mesh is solved
# The mesh's share of a requested tolerance: of models that leave effects out, and of complete ones
MESH_SHARE, FULL_MODEL_MESH_SHARE = 0.3, 0.5
FINEST_TOLERANCE = 5e-3  # relative; `auto` asks no finer mesh where the model's error dominates
SOLID_TOLERANCE = 0.02  # the same of a solid, whose next mesh takes five times as long
# s; without a tolerance or a budget, no model is started that would end later
DEFAULT_BUDGET = 30.0
# Without a tolerance or a budget: a clear verdict still gets a model that leaves less out and ends within
# SHARP_SECONDS, as long as the relative error that better models remove is above SHARP
SHARP, SHARP_SECONDS = 0.03, 15.0
REDUCED_SECONDS = 20.0  # s, at most, of the reduced model with any number of features
# Of the linear model's time: the yield's sample; friction on a section, a ridge, and on a solid
YIELD_PRICE, FRICTION_PRICE, SOLID_FRICTION_PRICE = 0.5, 0.03, 2.0
OnVerdict = Callable[[ContactCheck], object]  # called with each model's verdict as soon as it is known


def _models_for(design: Design, measured: bool = False) -> list[str]:
    """Return the models that `auto` may take of a design, or of a `measured` part, the cheapest first."""
    return [
        name
        for name in AUTO
        if name not in AUTO_IF or AUTO_IF[name](design)
        if not unsupported_reason(name, design, measured)
    ]


def better_models(name: str, design: Design, models: Sequence[str]) -> list[str]:
    """Return those of the `models` that come after one, each leaving out no more than the one before; after
    the closed form any."""
    order, plan = list(MODELS), [name]
    for other in models:
        fewer = len(left_out_by(other, design)) <= len(left_out_by(plan[-1], design))
        if order.index(other) > order.index(name) and (plan[-1] == "winkler" or fewer):
            plan.append(other)
    return plan[1:]


def _auto(solutions: Solutions, tol: float | None, budget: float | None) -> ContactCheck:
    """The verdict by a plan of models: solved one after the other until the tolerance is met, the verdict is
    clear or the budget is used."""
    design, models, request = solutions.design, solutions.models, solutions.request
    first, limit = _first_model(solutions, tol), budget if tol or budget else DEFAULT_BUDGET
    untimed = first == "winkler" or (first == "reduced" and (budget or 0.0) > REDUCED_SECONDS)
    if timed := budget is not None and not untimed:
        first = "linear" if "linear" in models else models[0]
        load(first)  # the library's import is no part of the budget
        solutions.began, request = perf_counter(), replace(request, must_fit=models[0] == "winkler")
    plan, check = [first, *better_models(first, design, models)], None
    while plan:
        name, *plan = plan
        if timed and budget is not None:
            remaining = max(budget - solutions.spent - solutions.yield_seconds, MIN_BUDGET)
            request = replace(request, budget=remaining)
        try:
            check = solutions.verdict(name, replace(request, tol=mesh_tolerance(name, tol)))
        except LateError as late:
            return _closed_form(solutions, name, late.seconds, tol, budget)
        except (InputError, RefusedError) as refusal:
            check = check or _best_solved(solutions, request, refusal)
            if check is None:
                raise
            later = models[models.index(name) + 1 :]
            by_force = isinstance(refusal, InputError) and refusal.key == "force"
            if later and budget is None and by_force and solutions.ends_within(limit, later[0]):
                # a plane model's limit need not be the solid's
                plan = [later[0], *better_models(later[0], design, models)]
                continue
            check = before_refusal(check, name, refusal)
            break
        if _is_enough(solutions, check, tol, limit, sharpen=budget is None):
            break
        request = replace(request, must_fit=False)
    assert check is not None
    check = without_mesh_tolerance(solutions.with_yield(check))
    check = replace(check, warnings=(*check.warnings, *overrun("", solutions.spent, budget)))
    return with_shortfall(check, tol, 0.0) if tol is not None else with_open_friction(check)


def _first_model(solutions: Solutions, tol: float | None) -> str:
    """The first model that may meet the tolerance, judged by Winkler's strains.

    Without a tolerance it is the linear model, of many features the reduced one, of a doubly curved skin the
    solid.
    """
    models, friction = solutions.models, solutions.friction
    if tol is None or solutions.crest_offsets or models[0] != "winkler":
        return next((name for name in ("reduced", "linear", "solid") if name in models), models[0])
    rough = run("winkler", solutions.design, Request(solutions.force), {}, None)
    for name in models:
        bounds = solutions.bounds(name, rough)
        value = rough.all_touch_force if name == "winkler" else Estimate(1.0, 0.0, "1")
        relative = (value.error or 0.0) / (value.value or 1.0) + math.fsum(b.threshold for b in bounds)
        if relative - _irreducible(friction, name, bounds, tol) <= tol:
            return name
    return models[-1]


def _irreducible(friction: PlateFriction, model: str, bounds: tuple[LeftOut, ...], tol: float) -> float:
    """The relative error that no model removes, if it alone exceeds the tolerance, else 0.

    The rest of the error must then meet the tolerance.
    """
    part = friction.lasting_error(model, bounds)
    return part if part > tol - FINEST_TOLERANCE else 0.0


def _is_enough(
    solutions: Solutions, check: ContactCheck, tol: float | None, limit: float | None, sharpen: bool
) -> bool:
    """Whether the check ends with this verdict: it is as good as was asked for, or nothing better ends
    within `limit` s. `sharpen`: a clear verdict is enough once it is sharp too; else any time is used."""
    friction, needed, until = solutions.friction, check.all_touch_force.value or 0.0, limit
    if tol is not None:
        spared = _irreducible(friction, check.model, check.left_out, tol) * needed
        enough = relative_error(check, spared) <= tol
    elif fails_by_far(check):
        return True
    else:  # clear, or kept open by an error that no model removes
        lasting = friction.lasting_error(check.model, check.left_out)
        enough = sharpen and (is_decided(check) or is_undecidable(check, lasting))
        if enough and is_decided(check) and _may_be_sharper(solutions, check):
            enough, until = False, SHARP_SECONDS
    if check.next_model is None:
        return True
    if exceeds_model(solutions.design, check):
        until = limit
    elif check.out_of_range or enough:
        return True
    return until is not None and solutions.spent + check.next_model.seconds > until


def _may_be_sharper(solutions: Solutions, check: ContactCheck) -> bool:
    """Whether more than SHARP of the all-touch force, of a flat skin of the approach, is an error that the
    next model does not have."""
    design, bounds = solutions.design, check.left_out
    if check.next_model is None:
        return False
    if len(left_out_by(check.next_model.model, design)) >= len(left_out_by(check.model, design)):
        return False
    if skin_of(design).bare:
        lasting = solutions.friction.lasting_error(check.model, bounds, "approach")
        return (check.approach.error or 0.0) / (check.approach.value or 1.0) - lasting > SHARP
    lasting = solutions.friction.lasting_error(check.model, bounds)
    return relative_error(check, lasting * (check.all_touch_force.value or 0.0)) > SHARP


def _closed_form(
    solutions: Solutions, late: str, seconds: float, tol: float | None, budget: float | None
) -> ContactCheck:
    """The closed form's verdict, where the first model is too late for the budget."""
    check = solutions.verdict("winkler", replace(solutions.request, tol=FINEST_TOLERANCE, budget=budget))
    words = f"the linear model would take about {about(seconds)} of the budget of {budget:g} s"
    check = replace(check, warnings=(*check.warnings, words), next_model=NextModel(late, seconds))
    return with_shortfall(check, tol, 0.0)


def _best_solved(solutions: Solutions, request: Request, refusal: Exception) -> ContactCheck | None:
    """The verdict of the best model solved before one refused; of a pad too large for any mesh the closed
    form's."""
    solved = [name for name in solutions.models if name in solutions.answers]
    if not solved and isinstance(refusal, SizeError) and solutions.models[0] == "winkler":
        solved = ["winkler"]
    return solutions.verdict(solved[-1], replace(request, must_fit=False)) if solved else None


class Solutions:
    """What one check has solved: the models' answers, and the verdict of each."""

    def __init__(
        self,
        design: Design,
        force: float,
        crest_offsets: tuple[float, ...],
        notes: tuple[str, ...],
        progress: Progress | None,
        on_verdict: OnVerdict | None = None,
    ) -> None:
        self.design, self.force, self.crest_offsets, self.notes = design, force, crest_offsets, notes
        self.progress, self.on_verdict = progress, on_verdict
        self.began, self.sampling_seconds = perf_counter(), 0.0
        self.answers: dict[str, Answer] = {}
        self.with_model_errors: dict[str, Answer] = {}  # with friction and what the model leaves out
        self.runs: list[ModelRun] = []
        self.models = _models_for(design, bool(crest_offsets))
        self.friction = PlateFriction(design, force, crest_offsets)

    @property
    def request(self) -> Request:
        """What a model is asked, without tolerance and budget."""
        drops, at = self.crest_offsets, [placed.area for placed in skin_of(self.design).placed]
        limit = limits(self.design).largest * (max(at) / at[0])
        return Request(self.force, None, None, drops, ridge_model=not drops, ridge_limit=limit)

    @property
    def spent(self) -> float:
        """Seconds since the check began."""
        return perf_counter() - self.began

    def seconds_of(self, name: str) -> float:
        """Expected seconds of a model from here, by the last one's, with the yield."""
        return expected_seconds(name, self.design, self.answers) + self.yield_seconds

    def ends_within(self, limit: float | None, name: str) -> bool:
        """Whether a model that is begun now ends within `limit` s of the check, None for any."""
        return limit is None or self.spent + self.seconds_of(name) <= limit

    @property
    def yield_seconds(self) -> float:
        """Seconds of the yield: measured, or expected by the linear model's."""
        if self.crest_offsets:
            return 0.0
        return self.sampling_seconds or YIELD_PRICE * linear_seconds(self.answers)

    def bounds(self, name: str, answer: Answer) -> tuple[LeftOut, ...]:
        """Error bounds of the effects that a model neglects."""
        effects = (*left_out_by(name, self.design), *self.friction.left_out(name))
        effects += (POCKETS,) if unknown_pockets(self.design) else ()
        bounds = left_out(effects, self.design, answer, self.force, self.crest_offsets)
        return (*bounds, *self.friction.unknown.get(name, ()))

    def verdict(self, name: str, request: Request) -> ContactCheck:
        """The verdict by one model, without its yield; models solved before are reused."""
        started = self.spent
        for model in (*prerequisites(name), name):
            if self.progress and model not in (*self.answers, "winkler"):
                self.progress(f"{model} model", self.seconds_of(name))
            answer = run(model, self.design, request, self.answers, self.progress)
        refuse_crushed(self.design, self.force, name, answer.approach.value or 0.0)
        remaining = None if request.budget is None else request.budget - (self.spent - started)
        section = FRICTION_PRICE * skin_of(self.design).count
        price = linear_seconds(self.answers) * (SOLID_FRICTION_PRICE if has_ends(name) else section)
        answer = self.friction.applied_to(name, answer, remaining, price).consistent(self.force)
        bounds = self.bounds(name, answer)
        self.with_model_errors[name] = known = with_model_error(answer, bounds, self.force)
        verdict = self._verdict(name, known, bounds)
        self.runs.append(ModelRun(name, verdict.all_touch_force, self.spent - started, answer.unknowns))
        if self.on_verdict:
            self.on_verdict(verdict)
        return verdict

    def _verdict(self, name: str, answer: Answer, bounds: tuple[LeftOut, ...]) -> ContactCheck:
        design, force, small = self.design, self.force, is_small_strain(name)
        beyond_reason = (small and small_strain_violation(design, force, answer)) or self._fault(name, answer)
        warnings = (*answer.warnings, *self.notes, *(strain_warnings(design, answer) if small else ()))
        if numbers := unlike(design, model=name):
            words = f"no design on which the {name} model's errors were set is like this one: {numbers}"
            warnings = (*warnings, words)
        after = better_models(name, design, self.models)
        return ContactCheck(
            name=design.name,
            force=force,
            family=skin_of(design).family,
            ridges=skin_of(design).count,
            touching=answer.touching,
            all_touch_force=answer.all_touch_force,
            approach=answer.approach,
            ridge_force=answer.ridge_force,
            model=name,
            unknowns=answer.unknowns,
            residual=answer.residual,
            seconds={"total": self.spent, **answer.seconds},
            warnings=warnings,
            left_out=bounds,
            models_tried=tuple(self.runs),
            next_model=NextModel(after[0], self.seconds_of(after[0])) if after else None,
            plate=design.contact.plate.shape,
            out_of_range=beyond_reason,
            tipping=tipping(design, answer),
            friction=design.contact.friction,
            contact_width=answer.contact_width and answer.contact_width.within(0.0, design.skin.width),
            wire_first=wiring_order(answer.ridge_force) if has_films(design) else (),
            magnet=magnet_signal(design, answer.ridge_force),
        )

    def _fault(self, name: str, answer: Answer) -> str:
        """Undetected contact of the skin with itself or the plate.

        The solid checks the crowns only, so the plane model's finding counts too.
        """
        plane = self.answers.get("linear", answer)
        fault = answer.fault or (plane.fault if is_small_strain(name) else "")
        return fault and f"at {self.force:g} N {fault}, which the model does not cover"

    def with_yield(self, check: ContactCheck) -> ContactCheck:
        """A verdict with its yield; earlier ones get none."""
        known, result, reserved = self.with_model_errors[check.model], None, self.yield_seconds
        warnings, seconds = check.warnings, dict(check.seconds)
        scatters = known.ridge_model is not None or MODELS[check.model].meshed
        if scatters and not (self.crest_offsets or check.out_of_range):
            try:
                with resource_guard("the yield"):
                    result = self._manufacture(known)
            except (ContactError, ExhaustedError) as failure:  # the verdict does not need the yield
                warnings = (*warnings, no_yield(failure))
        # the solid's yield solves the plane model, whose fault counts
        beyond_reason = check.out_of_range or self._fault(check.model, known)
        if self.sampling_seconds:  # of the ridge model, which the linear model built, and of the sample
            seconds["yield"] = known.seconds.get("yield", 0.0) + self.sampling_seconds
        plane, after = self.answers.get("linear"), check.next_model
        return replace(
            check,
            out_of_range=beyond_reason,
            deformed=plane.deformed if plane else (),
            self_contact=plane.self_contact if plane else None,
            manufacture=None if beyond_reason else result,
            seconds={**seconds, "total": self.spent},
            warnings=warnings,
            next_model=after and replace(after, seconds=after.seconds + self.yield_seconds - reserved),
        )

    def _manufacture(self, answer: Answer) -> Yield | None:
        """Yield and sensitivities of the design; the ridge model's force is scaled to the model's."""
        from skincad.mechanics.manufacture import face_yield, manufacture

        threshold, parts, spread = answer.all_touch_force.value, answer.ridge_model, spread_of(self.design)
        width, started = answer.contact_width, perf_counter()
        if width is not None:
            result = face_yield(self.design, answer.approach, width, self.force, spread)
            self.sampling_seconds = perf_counter() - started
            return result
        if threshold is None or skin_of(self.design).count == 1:
            if skin_of(self.design).bare:
                raise ContactError(
                    "a face's errors are drawn on its section, and this one curves along y too"
                )
            return None
        if parts is None and "linear" in self.models:  # its coarsest mesh is enough, as the force is scaled
            rough = Request(self.force, FINEST_TOLERANCE, ridge_model=True)
            parts = run("linear", self.design, rough, self.answers, self.progress).ridge_model
        if parts is None:
            return None
        started, uncertainty = perf_counter(), answer.all_touch_force.error or 0.0
        soft = (answer.approach.error or 0.0) / (answer.approach.value or 1.0)
        result = manufacture(parts, self.force, threshold, spread, uncertainty, soft)
        self.sampling_seconds = perf_counter() - started
        return result


def has_films(design: Design) -> bool:
    """Return whether a design has films to choose from: those of more than two ridges."""
    skin = skin_of(design)
    return skin.slot is not None and design.film is not None and skin.count > FOUR_CHANNELS


def linear_seconds(answers: Mapping[str, Answer]) -> float:
    """Seconds that the linear model took; 0 until it is solved."""
    plane = answers.get("linear")
    return plane.own_seconds if plane else 0.0


def exceeds_model(design: Design, check: ContactCheck) -> bool:
    """Whether a small-strain model found large strains, so that a better model must judge."""
    return is_small_strain(check.model) and (bool(check.out_of_range) or exceeds_small_strain(design, check))


def mesh_tolerance(name: str, tol: float | None) -> float:
    """Return the mesh tolerance, relative, that `auto` sets for a tolerance `tol` of the whole."""
    share = MESH_SHARE if MODELS[name].leaves_out else FULL_MODEL_MESH_SHARE
    finest = SOLID_TOLERANCE if name == "solid" else FINEST_TOLERANCE
    return finest if tol is None else min(finest, share * tol)


def spread_of(design: Design) -> Spread:
    """Return how parts of a design differ: by its mold's process and its material's range."""
    process, modulus = design.mold.process, silicone(design).young_modulus
    sigma = processes(design.printer)[process].crest_sigma
    return Spread(process, sigma, (modulus.low, modulus.value, modulus.high))
