"""Do all ridges touch? The one question of this room, and its answer with error and price."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from skincad.base.arguments import require_goals, require_number
from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.mechanics.climb import Climb, mesh_tolerance, outgrown
from skincad.mechanics.problem import (
    Request,
)
from skincad.mechanics.remedies import cause, changes
from skincad.mechanics.tiers.measured import kept
from skincad.mechanics.tiers.table import able, tier_of
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
    advise: bool = False,
    progress: Progress | None = None,
) -> ContactCheck:
    """Return whether all ridges touch a rigid plate at `force` N (the design's own if None).

    `tier` names a model; `auto` climbs from the cheapest that may do, until the whole relative error of the
    all-touch force is `tol`; without `tol` until the verdict is clear; with a `budget` in seconds, no
    further than it may last. A tier that refuses ends the climb at the one before. With a tier named, `tol`
    and `budget` are asked of its mesh. `measured` is a CSV of a cast part's crest heights (columns ridge,
    crest_mm), to judge that part. With `advise` a design that fails is told why, and which single changes
    would pass, which takes as long as several checks. Passed means: all touch, and the all-touch force with
    its error still lies at or below the force. Raises InputError for a force, tolerance, budget or tier out
    of range.
    """
    if advise and (budget is not None or measured is not None):
        raise InputError("advise", "is for a design, without budget or measured part", advise, "leave it out")
    if not isinstance(design, Design):
        raise InputError("design", "must be a Design", design, "skincad.load(...) gives one")
    asked = design.contact.force if force is None else force
    require_force(asked)
    require_goals(tol, budget, "0.05")
    if measured is not None and design.skin.curvature_radius_y is not None:
        raise InputError("measured", "judges skins that are straight along y", measured, "leave it out")
    drops = () if measured is None else crest_drops(measured, design)
    notes = (*slope_warnings(design), *shift_warnings(drops, design), *material_warnings(design))
    notes += (trouble,) if (trouble := kept().trouble) else ()
    climb = Climb(design, asked, drops, notes, progress)
    if tier == "auto":
        found = climb.auto(tol, budget)
        return _advised(design, found, mesh_tolerance(found.tier, tol), progress) if advise else found
    tier_of(tier)
    if reason := able(tier, design, bool(drops)):
        raise InputError("tier", reason, tier, "leave it out")
    found = climb.judged(tier, Request(asked, tol, budget, drops, parts=not drops))
    found = with_shortfall(found, tol, found.model_error)
    return _advised(design, found, tol, progress) if advise else found


def _advised(
    design: Design, found: ContactCheck, tol: float | None, progress: Progress | None
) -> ContactCheck:
    """The verdict with why a design fails, and what would pass by the same tier, its mesh to `tol`."""
    if found.passed or found.beyond:
        return found

    def judge(other: Design) -> tuple[bool, Estimate]:
        then = check(other, force=found.force, tier=found.tier, tol=tol, progress=progress)
        return then.passed and not outgrown(other, then), then.all_touch_force

    why = cause(design, found.approach.value or 0.0, found.force)
    return replace(found, cause=why, changes=changes(design, found.all_touch_force, found.force, judge))
