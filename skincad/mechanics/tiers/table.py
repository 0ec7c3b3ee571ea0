"""The tiers, cheapest first: what each leaves out, builds on, can judge and costs, and where its code is."""

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
from skincad.mechanics.tiers.measured import kept
from skincad.mechanics.tiers.prices import (
    BESIDE,
    TimeLaw,
    any_size,
    coarse_solid_unknowns,
    plane_unknowns,
    solid_unknowns,
)


@dataclass(frozen=True)
class Tier:
    """`where` is module and function of its `answer(design, request, progress, *answers of on)`.

    `law` is the time of its own part, without the tiers in `on`, by its `size` of a design. `shaped` says
    whether it knows plates that are not flat, `drops` whether measured crests, `doubly` whether skins that
    are curved along y too.
    """

    where: str
    law: TimeLaw
    size: Callable[[Design], float]
    leaves_out: tuple[str, ...] = ()
    on: tuple[str, ...] = ()
    shaped: bool = False
    drops: bool = False
    doubly: bool = False


_ROOM = "skincad.mechanics.tiers."
TIERS = {
    "winkler": Tier(f"{_ROOM}winkler:answer", TimeLaw(1.0, 4e-4, 0.0), any_size, shaped=True, doubly=True),
    "linear": Tier(
        f"{_ROOM}linear:answer",
        TimeLaw(9_800, 0.45, 1.05),
        plane_unknowns,
        (FREE_ENDS, FINITE_STRAIN),
        shaped=True,
        drops=True,
    ),
    "corrected": Tier(
        f"{_ROOM}corrected:answer",
        TimeLaw(8_700, 0.27, 1.25),
        coarse_solid_unknowns,
        (FINITE_STRAIN,),
        ("linear",),
        shaped=True,
        drops=True,
    ),
    "finite-strain": Tier(
        f"{_ROOM}finite_strain:answer",
        TimeLaw(9_800, 1.8, 1.3),
        plane_unknowns,
        (FREE_ENDS,),
        drops=True,
    ),
    "corrected-finite-strain": Tier(
        f"{_ROOM}product:answer",
        TimeLaw(1.0, 1e-3, 0.0),
        any_size,
        on=("linear", "corrected", "finite-strain"),
        drops=True,
    ),
    "solid": Tier(
        f"{_ROOM}solid:answer", TimeLaw(75_000, 8.0, 1.65), solid_unknowns, (FINITE_STRAIN,), shaped=True
    ),
    "solid-finite-strain": Tier(
        f"{_ROOM}solid_finite_strain:answer",
        TimeLaw(8_700, 0.9, 1.6),
        coarse_solid_unknowns,
        on=("solid",),
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


def able(name: str, design: Design, drops: bool) -> str:
    """Return why a tier cannot judge this design (or a measured part of it), or ""."""
    tier, shape = tier_of(name), design.contact.plate.shape
    if shape != "flat" and not tier.shaped:
        return f"contact.plate.shape: must be 'flat' for the {name} tier"
    if design.skin.curvature_radius_y is not None and not tier.doubly:
        return f"skin.curvature_radius_y: must not be given for the {name} tier, which takes y as straight"
    if drops and not tier.drops:
        return f"measured: is not judged by the {name} tier"
    return ""


def below(name: str) -> list[str]:
    """Return the tiers that a tier builds on, each after those that it builds on itself."""
    return list(dict.fromkeys(each for other in TIERS[name].on for each in (*below(other), other)))


def at_size(name: str, size: float) -> float:
    """Return the seconds of a tier's own part at a size."""
    return TIERS[name].law.at(size) * factor(name)


def factor(name: str = "") -> float:
    """Return the seconds of this machine for one of a law's: the median of what the tier took here, of what
    all took where it was not measured, 1 where none was.

    The exponent stays the law's: it is the method's, and what one design or a few span says little of it.
    """
    found = {
        tier: [one.seconds / TIERS[tier].law.at(one.size) for one in by_design.values()]
        for tier, by_design in kept().taken.items()
        if tier in TIERS
    }
    every = [ratio for ratios in found.values() for ratio in ratios]
    return median(found.get(name) or every or [1.0])


def own(name: str, design: Design) -> float:
    """Return the seconds of a tier's own part."""
    return at_size(name, TIERS[name].size(design))


def expected(name: str, design: Design, done: set[str]) -> float:
    """Return the seconds that a tier takes on top of those in `done`."""
    return math.fsum(own(each, design) for each in {*below(name), name} - done)


def beside(what: str, design: Design) -> float:
    """Return the seconds of a check's `yield`, or of its plate's `friction`."""
    return BESIDE[what].at(design.ridge.count) * factor()


def run(
    name: str, design: Design, request: Request, done: dict[str, Answer], progress: Progress | None
) -> Answer:
    """Return a tier's answer; it and what it builds on go into `done`, from where nothing is solved twice.

    Raises ExhaustedError where memory or another resource does not suffice.
    """
    if name not in done:
        tier = TIERS[name]
        on = [run(other, design, request, done, progress) for other in tier.on]
        with needing(f"the {name} tier"):
            answer, began = load(name), perf_counter()
            found = answer(design, request, progress, *on)
            done[name] = replace(found, took=perf_counter() - began)
    return done[name]


def load(name: str) -> Callable[..., Answer]:
    """Import and return a tier's function."""
    module, _, function = TIERS[name].where.partition(":")
    found: Callable[..., Answer] = getattr(import_module(module), function)
    return found
