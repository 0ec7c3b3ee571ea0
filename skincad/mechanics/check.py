"""Do all ridges touch? The one question of this room, and its answer with error and price."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import Any

from skincad.catalog import processes, silicone
from skincad.design import Design
from skincad.errors import InputError, did_you_mean
from skincad.measurements import crest_drops
from skincad.mechanics.plate import steepest
from skincad.mechanics.problem import Answer, Manufacture, Request, Spread
from skincad.quantities import Estimate
from skincad.stopwatch import Progress

TIERS = {
    "winkler": "skincad.mechanics.winkler:answer",
    "linear": "skincad.mechanics.linear:answer",
    "corrected": "skincad.mechanics.corrected:answer",
    "finite-strain": "skincad.mechanics.finite_strain:answer",
    "solid": "skincad.mechanics.solid:answer",
}
PLANNED_TIERS = ("solid-finite-strain",)
LARGEST_FORCE = 1e6  # N, as contact.force
SHAPED_PLATES = ("winkler", "linear")
STEEPEST = 0.35  # slope of the plate; half its square, 6 %, is what vertical contact leaves out
LARGEST_STRAIN = 0.3  # nominal strain of a ridge where all touch, beyond which there is no verdict
STUB = 2.0  # heights in widths up to which a ridge is no column
SMALL_STRAIN = 0.1  # nominal strain of a ridge up to which the linear tier is meant

# Sizes of what a tier leaves out, measured on plain-ridges: 12 mm long, 4 mm thick (FACTS.md; finite strain
# by its own tier)
FREE_ENDS = (
    "free ends are left out: plain-ridges, 12 mm long, touches at 23 % less force, yamada-2002 with its "
    "strips at 16 % less (--tier corrected computes it)"
)
FINITE_STRAIN = (
    "finite strain is left out: plain-ridges touches at 5 % more force, its outer shares a quarter smaller "
    "(--tier finite-strain computes it)"
)
LEFT_OUT = {
    "linear": (FREE_ENDS, FINITE_STRAIN),
    "corrected": (FINITE_STRAIN,),
    "finite-strain": (FREE_ENDS,),
    "solid": (FINITE_STRAIN,),
}
SMALL_STRAIN_TIERS = ("winkler", "linear", "corrected", "solid")


@dataclass(frozen=True)
class ContactCheck:
    """The verdict at `force` N; `touching` of `ridges` carry load, `seconds` is wall time by stage.

    Errors are those of discretisation (of the model, for winkler); what the tier leaves out is in
    `warnings`. `residual` is the largest relative violation of contact and equilibrium.
    """

    name: str
    passed: bool
    force: float
    ridges: int
    touching: int
    all_touch_force: Estimate
    approach: Estimate
    ridge_force: tuple[Estimate, ...]
    tier: str
    unknowns: int
    residual: float
    seconds: dict[str, float]
    warnings: tuple[str, ...]
    manufacture: Manufacture | None = None
    plate: str = "flat"
    beyond: str = ""  # why the verdict is outside the model's range

    def as_json(self) -> dict[str, Any]:
        """Return the `check` object of `--json`; the unit is the key's suffix."""
        return {
            "name": self.name,
            "passed": self.passed,
            "force_N": self.force,
            "plate": self.plate,
            "ridges": self.ridges,
            "touching": self.touching,
            "all_touch_force_N": self.all_touch_force.as_json(),
            "approach_mm": self.approach.as_json(),
            "ridge_force_N": [f.as_json() for f in self.ridge_force],
            "tier": self.tier,
            "unknowns": self.unknowns,
            "residual": self.residual,
            **self._manufacture(),
            "seconds": dict(self.seconds),
            "warnings": list(self.warnings),
            "beyond_range": self.beyond or None,
        }

    def _manufacture(self) -> dict[str, Any]:
        made = self.manufacture
        if made is None:
            return {"yield": None}
        return {
            "yield": made.passing.value,
            "yield_error": made.passing.error,
            "crest_sensitivity_N_per_mm": list(made.crest_sensitivity),
            "modulus_sensitivity_N_per_MPa": made.modulus_sensitivity,
            "yield_largest_loss": made.largest,
        }


def check(
    design: Design,
    *,
    force: float | None = None,
    tol: float | None = None,
    budget: float | None = None,
    tier: str = "auto",
    measured: Path | str | None = None,
    progress: Progress | None = None,
) -> ContactCheck:
    """Return whether all ridges touch a rigid flat plate at `force` N (the design's own if None).

    `tol` is the asked relative error of discretisation, `budget` the seconds that it may take (alone it
    asks for the best that they buy); `measured` a CSV of a cast part's crest heights (columns ridge,
    crest_mm), to judge that part. Passed means: all touch, and F9 with its error still lies at or below
    the force. Raises InputError for a force, tolerance, budget or tier out of range.
    """
    if not isinstance(design, Design):
        raise InputError("design", "must be a Design", design, "skincad.load(...) gives one")
    asked = design.contact.force if force is None else force
    if not 0 < asked <= LARGEST_FORCE:
        raise InputError("--force", f"must be above 0 N and at most {LARGEST_FORCE:g} N", asked)
    if tol is not None and not 0 < tol < 1:
        raise InputError("--tol", "must be between 0 and 1 (relative)", tol, "try --tol 0.005")
    if budget is not None and not (budget > 0 and math.isfinite(budget)):
        raise InputError("--budget", "must be above 0 s", budget)
    name = _tier(tier)
    plate_notes = _check_plate(design, name)
    module, _, function = TIERS[name].partition(":")
    solve: Callable[..., Answer] = getattr(import_module(module), function)
    started = perf_counter()
    found = solve(design, _request(design, name, asked, tol, budget, measured), progress)
    total = perf_counter() - started
    if (found.approach.value or 0.0) >= design.skin.thickness + design.ridge.height:
        raise InputError(
            "contact.force" if force is None else "--force",
            f"presses the skin through its whole thickness in the {name} tier",
            asked,
            "take a smaller force",
        )
    found = replace(found, warnings=(*found.warnings, *plate_notes))
    return _verdict(design, asked, name, found, total)


def _check_plate(design: Design, tier: str) -> list[str]:
    """Refuse a shaped plate where the tier has none; say what its slopes leave out."""
    plate = design.contact.plate
    if plate.shape == "flat":
        return []
    if tier not in SHAPED_PLATES:
        raise InputError("contact.plate.shape", f"must be 'flat' for --tier {tier}", plate.shape)
    slope = steepest(plate, design.skin.width / 2)
    if slope > STEEPEST:
        raise InputError(
            "contact.plate",
            f"must not slope by more than {STEEPEST:g} within the skin (contact is taken as vertical)",
            slope,
            "take a larger radius",
        )
    return [f"contact is taken as vertical: at the plate's slopes up to {slope:.2g}, {slope**2 / 2:.1%} off"]


def _request(
    design: Design,
    tier: str,
    force: float,
    tol: float | None,
    budget: float | None,
    measured: Path | str | None,
) -> Request:
    if measured is None:
        return Request(force, tol, budget, _spread(design))
    if tier != "linear":
        raise InputError("--measured", "is judged by the linear tier only", tier, "leave --tier out")
    return Request(force, tol, budget, drops=crest_drops(measured, design))


def _spread(design: Design) -> Spread:
    process, modulus = design.mold.process, silicone(design.material).young_modulus
    sigma = processes()[process].crest_sigma
    return Spread(process, sigma, (modulus.low, modulus.value, modulus.high))


def _tier(tier: str) -> str:
    if tier == "auto":
        return "linear"
    if tier in PLANNED_TIERS:
        raise InputError("--tier", "is not available in this version", tier, "use linear or winkler")
    if tier not in TIERS:
        raise InputError("--tier", "unknown tier", tier, did_you_mean(tier, [*TIERS, *PLANNED_TIERS, "auto"]))
    return tier


def _verdict(design: Design, force: float, tier: str, found: Answer, total: float) -> ContactCheck:
    ridges, upper = design.ridge.count, found.all_touch_force.upper
    warnings, beyond = (
        list(found.warnings),
        _beyond(design, force, found) if tier in SMALL_STRAIN_TIERS else "",
    )
    warnings += LEFT_OUT.get(tier, ())
    if tier in SMALL_STRAIN_TIERS and tier != "winkler":
        warnings += _strain_warning(design, found)
    return ContactCheck(
        design.name,
        found.touching == ridges and upper is not None and upper <= force and not beyond,
        force,
        ridges,
        found.touching,
        found.all_touch_force,
        found.approach,
        found.ridge_force,
        tier,
        found.unknowns,
        found.residual,
        {"total": total, **found.seconds},
        tuple(warnings),
        found.manufacture,
        design.contact.plate.shape,
        beyond,
    )


def _plane_modulus(design: Design) -> float:
    stuff = silicone(design.material)
    return stuff.young_modulus.value / (1 - stuff.poisson_ratio**2)


def ridge_strain(design: Design, found: Answer) -> float:
    """Return the nominal strain of the most loaded ridge: force over E' times its mean width and length."""
    width = (design.ridge.root_width + design.ridge.tip_width) / 2
    largest = max(f.value or 0.0 for f in found.ridge_force)
    return largest / (_plane_modulus(design) * width * design.skin.length)


def buckling_force(design: Design) -> float:
    """Return the force, N, at which a slender ridge buckles: a column clamped at its root, free at its tip.

    pi^2 E' I / (4 h^2) with I = L w^3 / 12, w the mean width; a stub no higher than `STUB` widths gives way
    otherwise, infinite. Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., sec. 2.2.
    """
    ridge = design.ridge
    width = (ridge.root_width + ridge.tip_width) / 2
    if ridge.height <= STUB * width:
        return math.inf
    inertia = design.skin.length * width**3 / 12
    return math.pi**2 * _plane_modulus(design) * inertia / (4 * ridge.height**2)


def _beyond(design: Design, force: float, found: Answer) -> str:
    """Why the verdict lies beyond the model's range, or "": judged where all ridges begin to touch."""
    threshold = found.all_touch_force.value
    at = 1.0 if threshold is None else min(1.0, threshold / force)
    strain = ridge_strain(design, found) * at
    if strain > LARGEST_STRAIN:
        return f"the ridges' nominal strain is {strain:.2g}, the model's range ends at {LARGEST_STRAIN:g}"
    largest, critical = max(f.value or 0.0 for f in found.ridge_force) * at, buckling_force(design)
    if largest > critical:
        return f"a ridge buckles at {critical:.3g} N and would carry {largest:.3g} N"
    return ""


def _strain_warning(design: Design, found: Answer) -> list[str]:
    strain = ridge_strain(design, found)
    if strain <= SMALL_STRAIN:
        return []
    return [f"nominal ridge strain {strain:.2g} is beyond the small-strain range ({SMALL_STRAIN:g})"]
