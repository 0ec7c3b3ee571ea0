"""Do all ridges touch? `check` answers with an error and the cost of a better answer."""

from __future__ import annotations

from pathlib import Path

from skincad.base.arguments import require_goals, require_number
from skincad.base.errors import InputError
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.mechanics.climb import Climb, OnVerdict
from skincad.mechanics.problem import (
    Request,
)
from skincad.mechanics.tiers.measured import timing_cache
from skincad.mechanics.tiers.table import tier_of, unsupported_reason
from skincad.mechanics.validity import (
    material_warnings,
    slope_warnings,
)
from skincad.mechanics.verdict import (
    ContactCheck,
    with_shortfall,
)
from skincad.shape.crests import crest_drops, shift_warnings

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
    tier: str = "auto",
    measured: Path | str | None = None,
    progress: Progress | None = None,
    on_verdict: OnVerdict | None = None,
) -> ContactCheck:
    """Return whether all ridges touch a rigid plate at `force` N (the design's own if None).

    `tier` names a model; `auto` starts with the cheapest that may do and takes better ones until the whole
    relative error of the all-touch force is `tol`; without `tol` until the verdict is clear; with a `budget`
    in seconds, no further than it may last. If a tier refuses, the verdict of the one before stands. With a
    tier named, `tol` and `budget` are asked of its mesh. `measured` is a CSV of a cast part's crest heights
    (columns ridge, crest_mm), to judge that part. `on_verdict` is called with each tier's verdict as soon as
    it is known. Passed means: all touch, and the all-touch force with its error still lies at or below the
    force. Raises InputError for a force, tolerance, budget or tier out of range.
    """
    if not isinstance(design, Design):
        raise InputError("design", "must be a Design", design, "skincad.load(...) gives one")
    load = design.contact.force if force is None else force
    require_force(load)
    require_goals(tol, budget, "0.05")
    if measured is not None and design.skin.curvature_radius_y is not None:
        raise InputError("measured", "judges skins that are straight along y", measured, "leave it out")
    crest_offsets = () if measured is None else crest_drops(measured, design)
    notes = (*slope_warnings(design), *shift_warnings(crest_offsets, design), *material_warnings(design))
    notes += (trouble,) if (trouble := timing_cache().trouble) else ()
    climb = Climb(design, load, crest_offsets, notes, progress, on_verdict)
    if tier == "auto":
        return climb.auto(tol, budget)
    tier_of(tier)
    if reason := unsupported_reason(tier, design, bool(crest_offsets)):
        raise InputError("tier", reason, tier, "leave it out")
    verdict = climb.verdict_of(tier, Request(load, tol, budget, crest_offsets, ridge_model=not crest_offsets))
    return with_shortfall(verdict, tol, verdict.model_error)
