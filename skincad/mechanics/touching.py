"""Do all ridges touch? The one question of this room, and its answer with error and price."""

from __future__ import annotations

from pathlib import Path

from skincad.base.arguments import require_goals, require_number
from skincad.base.errors import InputError
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.mechanics.climb import Climb, Told
from skincad.mechanics.problem import (
    Request,
)
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
    progress: Progress | None = None,
    told: Told | None = None,
) -> ContactCheck:
    """Return whether all ridges touch a rigid plate at `force` N (the design's own if None).

    `tier` names a model; `auto` climbs from the cheapest that may do, until the whole relative error of the
    all-touch force is `tol`; without `tol` until the verdict is clear; with a `budget` in seconds, no
    further than it may last. A tier that refuses ends the climb at the one before. With a tier named, `tol`
    and `budget` are asked of its mesh. `measured` is a CSV of a cast part's crest heights (columns ridge,
    crest_mm), to judge that part. `told` is given each tier's verdict as it is known. Passed means: all
    touch, and the all-touch force with its error still lies at or below the force. Raises InputError for a
    force, tolerance, budget or tier out of range.
    """
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
    climb = Climb(design, asked, drops, notes, progress, told)
    if tier == "auto":
        return climb.auto(tol, budget)
    tier_of(tier)
    if reason := able(tier, design, bool(drops)):
        raise InputError("tier", reason, tier, "leave it out")
    found = climb.judged(tier, Request(asked, tol, budget, drops, parts=not drops))
    return with_shortfall(found, tol, found.model_error)
