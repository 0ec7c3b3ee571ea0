"""The check: models from the cheapest to the best, until the verdict is clear or nothing better fits."""

from __future__ import annotations

import math
from collections.abc import Callable
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
from skincad.mechanics.left_out import POCKETS, LeftOut, left_out
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
    areas,
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
    with_model_error,
    with_open_friction,
    with_shortfall,
    without_mesh_tolerance,
)
from skincad.shape.crests import crest_drops, shift_warnings
from skincad.shape.skin import skin_of

LARGEST_FORCE = 1e6  # N, as contact.force


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

    `model` names a model; `auto` starts with the cheapest that may do and takes better ones until the whole
    relative error of the all-touch force is `tol`; without `tol` until the verdict is clear and the error
    that a better model removes is 3 %, if that ends within 15 s, but no further where the force is less than
    half of what is needed; with a `budget` in seconds, no further than it may last. If a model refuses, the
    verdict of the one before stands. With a model named, `tol` and `budget` are asked of its mesh. `measured`
    is a CSV of a cast part's crest heights (columns ridge, crest_mm), to judge that part. `on_verdict` is
    called with each model's verdict as soon as it is known. Passed means: all touch, and the all-touch force
    with its error still lies at or below the force. Raises InputError for a force, tolerance, budget or model
    out of range.
    """
    if not isinstance(design, Design):
        raise InputError("design", "must be a Design", design, "skincad.load(...) gives one")
    load = design.contact.force if force is None else force
    require_force(load)
    require_goals(tol, budget, "0.05")
    if measured is not None and design.skin.curvature_radius_y is not None:
        raise InputError("measured", "judges skins that are straight along y", measured, "leave it out")
    crest_offsets, notes = ((), ()) if measured is None else crest_drops(measured, design)
    notes = (
        *notes,
        *slope_warnings(design),
        *shift_warnings(crest_offsets, design),
        *material_warnings(design),
    )
    notes = (*notes, *bone_warnings(design), *_scatter_warnings(design))
    selection = ModelSelection(design, load, crest_offsets, notes, progress, on_verdict)
    if model == "auto":
        return selection.auto(tol, budget)
    model_named(model)
    if reason := unsupported_reason(model, design, bool(crest_offsets)):
        raise InputError("model", reason, model, "leave it out")
    verdict = selection.verdict_of(model, selection.request(tol, budget))
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


class ModelSelection:
    """One check: the models solved so far, and the verdict of each."""

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
        self.started, self.sampling_seconds = perf_counter(), 0.0
        self.solved: dict[str, Answer] = {}
        self.with_model_errors: dict[str, Answer] = {}  # with friction and what the model leaves out
        self.runs: list[ModelRun] = []
        self.models = [
            name
            for name in AUTO
            if name not in AUTO_IF or AUTO_IF[name](design)
            if not unsupported_reason(name, design, bool(crest_offsets))
        ]
        self.friction = PlateFriction(design, force, crest_offsets)

    def request(self, tol: float | None, budget: float | None) -> Request:
        """Return what a model is asked."""
        drops, at = self.crest_offsets, areas(self.design)
        limit = limits(self.design).largest * (max(at) / at[0])
        return Request(self.force, tol, budget, drops, ridge_model=not drops, ridge_limit=limit)

    def auto(self, tol: float | None, budget: float | None) -> ContactCheck:
        """Try better models until the tolerance is met, the verdict is clear or the budget is used."""
        request = self.request(None, None)
        name = self.models[self._first_index(tol)]
        if name == "reduced" and (budget is None or budget > REDUCED_SECONDS):
            return self._select_from(name, request, tol, budget)
        if name != "winkler" and budget is not None:
            return self._within_budget(request, tol, budget)
        return self._select_from(name, request, tol, budget)

    def _within_budget(self, request: Request, tol: float | None, limit: float) -> ContactCheck:
        """Start with the linear model if it fits into the budget, else use the closed form."""
        least = self.models[0] == "winkler"
        name = "linear" if "linear" in self.models else self.models[0]
        load(name)  # the library's import is no part of the budget
        self.started = perf_counter()
        try:
            return self._select_from(name, replace(request, must_fit=least, budget=limit), tol, limit)
        except LateError as late:
            check = self._model("winkler", replace(request, tol=FINEST_TOLERANCE))
            words = f"the linear model would take about {about(late.seconds)} of the budget of {limit:g} s"
            check = replace(
                check, warnings=(*check.warnings, words), next_model=NextModel(name, late.seconds)
            )
            return with_shortfall(check, tol, 0.0)

    def _select_from(
        self, name: str, request: Request, tol: float | None, budget: float | None
    ) -> ContactCheck:
        check: ContactCheck | None = None
        limit = budget if budget is not None or tol is not None else DEFAULT_BUDGET
        while True:
            timed = limit is not None and request.budget is not None  # by a budget, or as the pad is large
            remaining = (
                max(limit - self._spent() - self._yield_seconds(), MIN_BUDGET) if limit and timed else None
            )
            try:
                check = self._model(name, replace(request, tol=mesh_tolerance(name, tol), budget=remaining))
            except (InputError, RefusedError) as refusal:
                check = check or self._best_solved(request, refusal)
                if check is None:
                    raise
                later = self.models[self.models.index(name) + 1 :]
                by_force = isinstance(refusal, InputError) and refusal.key == "force"
                if (
                    later
                    and budget is None
                    and by_force
                    and self._seconds_until_end(later[0]) <= (limit or math.inf)
                ):
                    name = later[0]  # a plane model's limit need not be the solid's
                    continue
                check = before_refusal(check, name, refusal)
                break
            satisfied, until = budget is None and self._is_settled(check), limit
            if tol is not None:
                satisfied = self._meets_tolerance(check, tol)
            elif fails_by_far(check):
                break
            elif satisfied and is_decided(check) and self._may_be_sharper(check):
                satisfied, until = False, SHARP_SECONDS
            if check.next_model is None:
                break
            if exceeds_model(self.design, check):
                until = limit
            elif check.out_of_range or satisfied:
                break
            if until is not None and self._spent() + check.next_model.seconds > until:
                break
            name, request = check.next_model.model, replace(request, must_fit=False)
        check = without_mesh_tolerance(self._with_yield(check))
        check = replace(check, warnings=(*check.warnings, *overrun("", self._spent(), budget)))
        return with_shortfall(check, tol, 0.0) if tol is not None else with_open_friction(check)

    def _best_solved(self, request: Request, refusal: Exception) -> ContactCheck | None:
        """The verdict of the best model solved before one refused.

        For a pad too large for any mesh it is the closed form's.
        """
        solved = [name for name in self.models if name in self.solved]
        if not solved and isinstance(refusal, SizeError) and self.models[0] == "winkler":
            solved = ["winkler"]
        return self._model(solved[-1], replace(request, must_fit=False)) if solved else None

    def _first_index(self, tol: float | None) -> int:
        """Index of the first model that may meet the tolerance, judged by Winkler's strains.

        Without a tolerance it is the linear model, of many features the reduced one, of a doubly curved skin
        the solid.
        """
        plain = [name for name in ("reduced", "linear", "solid") if name in self.models]
        first = self.models.index(plain[0]) if plain else 0
        if tol is None or self.crest_offsets or self.models[0] != "winkler":
            return first
        rough = run("winkler", self.design, Request(self.force), {}, None)
        for i, name in enumerate(self.models):
            bounds = self._bounds(name, rough)
            value = rough.all_touch_force if name == "winkler" else Estimate(1.0, 0.0, "1")
            relative = (value.error or 0.0) / (value.value or 1.0) + math.fsum(b.threshold for b in bounds)
            if relative - self._irreducible(name, bounds, tol) <= tol:
                return i
        return len(self.models) - 1

    def _bounds(self, name: str, answer: Answer) -> tuple[LeftOut, ...]:
        """Error bounds of the effects that a model neglects."""
        effects = (*left_out_by(name, self.design), *self.friction.left_out(name))
        effects += (POCKETS,) if self.design.features.pocket else ()
        bounds = left_out(effects, self.design, answer, self.force)
        return (*bounds, *self.friction.unknown.get(name, ()))

    def _irreducible(self, model: str, bounds: tuple[LeftOut, ...], tol: float) -> float:
        """The relative error that no model removes, if it alone exceeds the tolerance, else 0.

        The rest of the error must then meet the tolerance.
        """
        part = self.friction.lasting_error(model, bounds)
        return part if part > tol - FINEST_TOLERANCE else 0.0

    def _meets_tolerance(self, check: ContactCheck, tol: float) -> bool:
        """Whether the tolerance is met, as far as any model can."""
        spared = self._irreducible(check.model, check.left_out, tol) * (check.all_touch_force.value or 0.0)
        return relative_error(check, spared) <= tol

    def _is_settled(self, check: ContactCheck) -> bool:
        """Whether the verdict is clear, or an error that no model removes keeps it open."""
        return is_decided(check) or is_undecidable(check, self._lasting(check))

    def _may_be_sharper(self, check: ContactCheck) -> bool:
        """Whether more than SHARP of the all-touch force is an error that the next model does not have."""
        if check.next_model is None:
            return False
        left, later = (left_out_by(name, self.design) for name in (check.model, check.next_model.model))
        if len(later) >= len(left):
            return False
        if skin_of(self.design).symmetry == "none":  # of which the approach is asked
            lasting = self.friction.lasting_error(check.model, check.left_out, "approach")
            return (check.approach.error or 0.0) / (check.approach.value or 1.0) - lasting > SHARP
        return relative_error(check, self._lasting(check) * (check.all_touch_force.value or 0.0)) > SHARP

    def _lasting(self, check: ContactCheck) -> float:
        """The relative error of the all-touch force that no better model removes."""
        return self.friction.lasting_error(check.model, check.left_out)

    def _seconds_until_end(self, name: str) -> float:
        """Seconds from the start of the check to the end of a model started now."""
        return self._spent() + self._seconds(name)

    def _spent(self) -> float:
        return perf_counter() - self.started

    def verdict_of(self, name: str, request: Request) -> ContactCheck:
        """Return the verdict by one model, with its yield."""
        return self._with_yield(self._model(name, request))

    def _model(self, name: str, request: Request) -> ContactCheck:
        """The verdict by one model; models solved before are reused."""
        started = self._spent()
        for model in (*prerequisites(name), name):
            if self.progress and model not in (*self.solved, "winkler"):
                self.progress(f"{model} model", self._seconds(name))
            answer = run(model, self.design, request, self.solved, self.progress)
        refuse_crushed(self.design, self.force, name, answer.approach.value or 0.0)
        remaining = None if request.budget is None else request.budget - (self._spent() - started)
        answer = self.friction.applied_to(name, answer, remaining, self._friction_seconds(name))
        answer = answer.consistent(self.force)
        bounds = self._bounds(name, answer)
        self.with_model_errors[name] = known = with_model_error(answer, bounds, self.force)
        verdict = self._verdict(name, known, bounds)
        self.runs.append(ModelRun(name, verdict.all_touch_force, self._spent() - started, answer.unknowns))
        if self.on_verdict:
            self.on_verdict(verdict)
        return verdict

    def _with_yield(self, check: ContactCheck) -> ContactCheck:
        """The last verdict with its yield. Earlier verdicts get no yield."""
        known, result, reserved = self.with_model_errors[check.model], None, self._yield_seconds()
        failed: tuple[str, ...] = ()
        if not (self.crest_offsets or check.out_of_range or not MODELS[check.model].meshed):
            try:
                with resource_guard("the yield"):
                    result = self._manufacture(known)
            except (ContactError, ExhaustedError) as failure:  # the verdict does not need the yield
                failed = (no_yield(failure),)
        # the solid's yield solves the plane model, whose fault counts
        beyond_reason = check.out_of_range or self._fault(check.model, known)
        following = check.next_model
        return replace(
            check,
            out_of_range=beyond_reason,
            deformed=self.solved["linear"].deformed if "linear" in self.solved else (),
            self_contact=self.solved["linear"].self_contact if "linear" in self.solved else None,
            manufacture=None if beyond_reason else result,
            seconds={**check.seconds, "total": self._spent(), **self._yield_times(known)},
            warnings=(*check.warnings, *failed),
            next_model=following
            and replace(following, seconds=following.seconds + self._yield_seconds() - reserved),
        )

    def _manufacture(self, answer: Answer) -> Yield | None:
        """Yield and sensitivities of the design; the ridge model's force is scaled to the model's."""
        threshold, parts = answer.all_touch_force.value, answer.ridge_model
        if threshold is None or skin_of(self.design).count == 1:
            return None
        if parts is None and "linear" in self.models:  # its coarsest mesh is enough, as the force is scaled
            rough = Request(self.force, FINEST_TOLERANCE, ridge_model=True)
            parts = run("linear", self.design, rough, self.solved, self.progress).ridge_model
        if parts is None:
            return None
        from skincad.mechanics.manufacture import manufacture

        started = perf_counter()
        uncertainty = answer.all_touch_force.error or 0.0
        result = manufacture(parts, self.force, threshold, spread_of(self.design), uncertainty)
        self.sampling_seconds = perf_counter() - started
        return result

    def _verdict(self, name: str, answer: Answer, bounds: tuple[LeftOut, ...]) -> ContactCheck:
        design, force, small = self.design, self.force, is_small_strain(name)
        beyond_reason = (small and small_strain_violation(design, force, answer)) or self._fault(name, answer)
        warnings = (*answer.warnings, *self.notes, *(strain_warnings(design, answer) if small else ()))
        if numbers := unlike(design, model=name):
            words = f"no design on which the {name} model's errors were set is like this one: {numbers}"
            warnings = (*warnings, words)
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
            seconds={"total": self._spent(), **answer.seconds},
            warnings=warnings,
            left_out=bounds,
            models_tried=tuple(self.runs),
            next_model=self._next(name),
            plate=design.contact.plate.shape,
            out_of_range=beyond_reason,
            tipping=tipping(design, answer),
            friction=design.contact.friction,
            contact_width=answer.contact_width,
        )

    def _fault(self, name: str, answer: Answer) -> str:
        """Undetected contact of the skin with itself or the plate.

        The solid checks the crowns only, so the plane model's finding counts too.
        """
        plane = self.solved.get("linear", answer)
        fault = answer.fault or (plane.fault if is_small_strain(name) else "")
        return fault and f"at {self.force:g} N {fault}, which the model does not cover"

    def _yield_seconds(self) -> float:
        """Seconds of the yield: measured, or expected by the linear model's."""
        if self.crest_offsets:
            return 0.0
        return self.sampling_seconds or YIELD_PRICE * self._linear_seconds()

    def _friction_seconds(self, name: str) -> float:
        """Expected seconds of the plate's friction on a solid, or on a section."""
        section = FRICTION_PRICE * skin_of(self.design).count
        return self._linear_seconds() * (SOLID_FRICTION_PRICE if has_ends(name) else section)

    def _linear_seconds(self) -> float:
        """Seconds of the linear model; 0 until it is solved."""
        plane = self.solved.get("linear")
        return plane.own_seconds if plane else 0.0

    def _yield_times(self, answer: Answer) -> dict[str, float]:
        """Time of the yield: of its ridge model, which the linear model built, and of the sample of parts."""
        return (
            {"yield": answer.seconds.get("yield", 0.0) + self.sampling_seconds}
            if self.sampling_seconds
            else {}
        )

    def _next(self, name: str) -> NextModel | None:
        """The next model that neglects less, and its predicted seconds."""
        current, order = left_out_by(name, self.design), list(MODELS)
        better = [
            other
            for other in self.models
            if order.index(other) > order.index(name)
            and (name == "winkler" or len(left_out_by(other, self.design)) <= len(current))
        ]
        if not better:
            return None
        return NextModel(better[0], self._seconds(better[0]))

    def _seconds(self, name: str) -> float:
        """Expected seconds of a model from here, by the last one's, with the yield."""
        return expected_seconds(name, self.design, self.solved) + self._yield_seconds()


def exceeds_model(design: Design, check: ContactCheck) -> bool:
    """Whether a small-strain model found large strains, so that a better model must judge."""
    return is_small_strain(check.model) and (bool(check.out_of_range) or exceeds_small_strain(design, check))


def mesh_tolerance(name: str, tol: float | None) -> float:
    """Return the mesh tolerance, relative, that `auto` sets for a tolerance `tol` of the whole."""
    share = MESH_SHARE if MODELS[name].leaves_out else FULL_MODEL_MESH_SHARE
    finest = SOLID_TOLERANCE if name == "solid" else FINEST_TOLERANCE
    return finest if tol is None else min(finest, share * tol)


def _scatter_warnings(design: Design) -> tuple[str, ...]:
    """Say of pins and rings, which have no yield, that their crests are taken as drawn."""
    skin, spread = skin_of(design), spread_of(design)
    if skin.family not in ("pin", "ring") or skin.count == 1 or not spread.crest_sigma:
        return ()
    each = f"crests are taken as drawn; by {spread.process} they scatter by {spread.crest_sigma:g} mm"
    return (f"{each}, and then {skin.family}s touch later than said",)


def spread_of(design: Design) -> Spread:
    """Return how parts of a design differ: by its mold's process and its material's range."""
    process, modulus = design.mold.process, silicone(design).young_modulus
    sigma = processes(design.printer)[process].crest_sigma
    return Spread(process, sigma, (modulus.low, modulus.value, modulus.high))
