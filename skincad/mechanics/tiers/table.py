"""The tiers, cheapest first: the effects each neglects, its prerequisites, limits, cost and code."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from statistics import median
from time import perf_counter

from skincad.base.errors import InputError, did_you_mean, needing
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.mechanics.left_out import FINITE_STRAIN, FREE_ENDS
from skincad.mechanics.problem import Answer, Request
from skincad.mechanics.tiers.measured import timing_cache
from skincad.mechanics.tiers.prices import (
    OVERHEAD,
    CostModel,
    any_size,
    coarse_solid_unknowns,
    plane_unknowns,
    solid_unknowns,
)
from skincad.shape.skin import skin_of


@dataclass(frozen=True)
class Tier:
    """`where` is module and function of its `answer(design, request, progress, *answers it builds on)`.

    `law` is the time of its own part, without the tiers in `builds_on`, by its `size` of a design. Flags say
    whether it supports `shaped_plates`, `measured` crests and `doubly_curved` skins.
    """

    where: str
    law: CostModel
    size: Callable[[Design], float]
    leaves_out: tuple[str, ...] = ()
    builds_on: tuple[str, ...] = ()
    shaped_plates: bool = False
    measured: bool = False
    doubly_curved: bool = False


_ROOM = "skincad.mechanics.tiers."
TIERS = {
    "winkler": Tier(
        f"{_ROOM}winkler:answer", CostModel(1.0, 4e-4, 0.0), any_size, shaped_plates=True, doubly_curved=True
    ),
    "linear": Tier(
        f"{_ROOM}linear:answer",
        CostModel(9_800, 0.45, 1.05),
        plane_unknowns,
        (FREE_ENDS, FINITE_STRAIN),
        shaped_plates=True,
        measured=True,
    ),
    "corrected": Tier(
        f"{_ROOM}corrected:answer",
        CostModel(8_700, 0.27, 1.25),
        coarse_solid_unknowns,
        (FINITE_STRAIN,),
        ("linear",),
        shaped_plates=True,
        measured=True,
    ),
    "finite-strain": Tier(
        f"{_ROOM}finite_strain:answer",
        CostModel(9_800, 1.8, 1.3),
        plane_unknowns,
        (FREE_ENDS,),
        measured=True,
    ),
    "corrected-finite-strain": Tier(
        f"{_ROOM}product:answer",
        CostModel(1.0, 1e-3, 0.0),
        any_size,
        builds_on=("linear", "corrected", "finite-strain"),
        measured=True,
    ),
    "solid": Tier(
        f"{_ROOM}solid:answer",
        CostModel(75_000, 8.0, 1.65),
        solid_unknowns,
        (FINITE_STRAIN,),
        shaped_plates=True,
    ),
    "solid-finite-strain": Tier(
        f"{_ROOM}solid_finite_strain:answer",
        CostModel(8_700, 0.9, 1.6),
        coarse_solid_unknowns,
        builds_on=("solid",),
    ),
}
AUTO = ("winkler", "linear", "corrected", "corrected-finite-strain", "solid-finite-strain")


def tier_of(name: str) -> Tier:
    """Return a tier by name; raises InputError for an unknown one."""
    if name not in TIERS:
        raise InputError("tier", "unknown tier", name, did_you_mean(name, [*TIERS, "auto"]))
    return TIERS[name]


def is_small_strain(name: str) -> bool:
    """Return whether a tier takes strains as small."""
    return name == "winkler" or FINITE_STRAIN in TIERS[name].leaves_out


def unsupported_reason(name: str, design: Design, measured: bool) -> str:
    """Return why a tier cannot judge this design (or a measured part of it), or ""."""
    tier, shape = tier_of(name), design.contact.plate.shape
    if shape != "flat" and not tier.shaped_plates:
        return f"contact.plate.shape: must be 'flat' for the {name} tier"
    if design.skin.curvature_radius_y is not None and not tier.doubly_curved:
        return f"skin.curvature_radius_y: must not be given for the {name} tier, which takes y as straight"
    if measured and not tier.measured:
        return f"measured: is not judged by the {name} tier"
    return ""


def prerequisites(name: str) -> list[str]:
    """Return all tiers that a tier builds on, in the order in which they must be solved."""
    return list(
        dict.fromkeys(base for other in TIERS[name].builds_on for base in (*prerequisites(other), other))
    )


def seconds_at_size(name: str, size: float) -> float:
    """Return the seconds of a tier's own part at a size."""
    return TIERS[name].law.at(size) * machine_factor(name)


def machine_factor(name: str = "") -> float:
    """Return measured over predicted seconds on this machine: the tier's median, or if it was not measured
    that of all tiers; 1 if none was.

    The exponent stays the law's: it is the method's, and a few designs say little about it.
    """
    ratios_by_tier = {
        tier: [timing.seconds / TIERS[tier].law.at(timing.size) for timing in by_design.values()]
        for tier, by_design in timing_cache().timings.items()
        if tier in TIERS
    }
    every = [ratio for ratios in ratios_by_tier.values() for ratio in ratios]
    return median(ratios_by_tier.get(name) or every or [1.0])


def own_seconds(name: str, design: Design) -> float:
    """Return the seconds of a tier's own part."""
    return seconds_at_size(name, TIERS[name].size(design))


def expected_seconds(name: str, design: Design, solved: set[str]) -> float:
    """Return the seconds of a tier and its prerequisites, without those in `solved`."""
    return math.fsum(own_seconds(tier, design) for tier in {*prerequisites(name), name} - solved)


def overhead_seconds(what: str, design: Design) -> float:
    """Return the predicted seconds of a check's `yield`, or of its plate's `friction`."""
    return OVERHEAD[what].at(skin_of(design).count) * machine_factor()


def run(
    name: str, design: Design, request: Request, solved: dict[str, Answer], progress: Progress | None
) -> Answer:
    """Return a tier's answer; it and its prerequisites are stored in `solved` and never solved twice.

    Raises ExhaustedError where memory or another resource does not suffice.
    """
    if name not in solved:
        tier = TIERS[name]
        on = [run(other, design, request, solved, progress) for other in tier.builds_on]
        with needing(f"the {name} tier"):
            answer, began = load(name), perf_counter()
            result = answer(design, request, progress, *on)
            solved[name] = replace(result, own_seconds=perf_counter() - began)
    return solved[name]


def load(name: str) -> Callable[..., Answer]:
    """Import and return a tier's function."""
    module, _, function = TIERS[name].where.partition(":")
    answer: Callable[..., Answer] = getattr(import_module(module), function)
    return answer
