"""What the tables of a design must agree on, beyond each key's own range; the first broken rule is raised."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from skincad.errors import InputError
from skincad.process import check_named, check_own

if TYPE_CHECKING:
    from skincad.design import Design, Ridge, Skin

MOST = 999  # ridges that are told of, as ridge.count
FAN_LIMIT_DEG = 90.0  # assumption: a flat back under a wider fan leaves knife edges at the sides
SMALLEST_FILLET = (
    1e-6  # mm; ten times the length below which the CAD kernel takes an edge's ends for one point
)
CORE = 0.2  # assumption: least radius of a revolved skin's back, of curvature_radius_y


def check_design(design: Design) -> None:
    """Raise InputError for the first rule between keys that a design breaks."""
    _check_mold(design)
    _check_skin(design)
    _check_revolved(design.skin)
    _check_ridge(design.ridge)
    _check_film(design)


def _check_mold(design: Design) -> None:
    own, choice = design.printer or {}, design.mold
    check_own(own)
    check_named("mold.process", choice.process, own)
    check_named("mold.end_plate_process", choice.end_plate_process, own)
    check_named("mold.lid_process", choice.lid_process, own)


def _check_skin(design: Design) -> None:
    skin, ridge = design.skin, design.ridge
    if skin.width >= 2 * skin.curvature_radius:
        raise InputError(
            "skin.width",
            f"must be less than {2 * skin.curvature_radius:g} mm (twice skin.curvature_radius)",
            skin.width,
        )
    side = math.asin(skin.width / (2 * skin.curvature_radius))
    if math.degrees(2 * side) >= FAN_LIMIT_DEG:
        widest = 2 * skin.curvature_radius * math.sin(math.radians(FAN_LIMIT_DEG / 2))
        raise InputError(
            "skin.width",
            f"the fan from side to side must stay below {FAN_LIMIT_DEG:g} degrees, so below {widest:.4g} mm",
            skin.width,
            "make the skin narrower or curvature_radius larger",
        )
    sag = 2 * skin.curvature_radius * math.sin(side / 2) ** 2
    if sag > 0.8 * skin.thickness:
        raise InputError(
            "skin.thickness",
            f"must be above {sag / 0.8:.4g} mm, or too little is left at the sides (the base circle "
            f"falls by {sag:.4g} mm)",
            skin.thickness,
        )
    half_root = ridge.root_width / 2 + ridge.root_fillet
    reach = abs(design.lean(1)) + half_root / skin.curvature_radius
    if reach >= side:
        more = (
            2 * (side * skin.curvature_radius - half_root) / ridge.pitch
        )  # infinite where there is no pitch
        most = 0 if more < -1 else int(min(more, MOST)) + 1
        raise InputError(
            "ridge.count",
            f"at most {most} ridges of this pitch and root fit on skin.width",
            ridge.count,
            "take fewer ridges, a smaller pitch or a wider skin",
        )


def _check_revolved(skin: Skin) -> None:
    """The section must keep clear of the axis that it turns about, and turn by less than the fan's limit."""
    radius = skin.curvature_radius_y
    if radius is None:
        return
    least = skin.thickness / (1 - CORE)
    if radius < least:
        raise InputError(
            "skin.curvature_radius_y",
            f"must be at least {least:.4g} mm, or the back at skin.thickness below comes too near its axis",
            radius,
            "make the skin thinner or the radius larger",
        )
    longest = radius * math.radians(FAN_LIMIT_DEG)
    if skin.length >= longest:
        raise InputError(
            "skin.length",
            f"the fan from end to end must stay below {FAN_LIMIT_DEG:g} degrees, so below {longest:.4g} mm",
            skin.length,
            "make the skin shorter or curvature_radius_y larger",
        )


def _check_ridge(ridge: Ridge) -> None:
    if ridge.root_width >= ridge.pitch:
        raise InputError(
            "ridge.root_width", f"must be less than {ridge.pitch:g} mm (ridge.pitch)", ridge.root_width
        )
    if ridge.tip_width > ridge.root_width:
        raise InputError(
            "ridge.tip_width",
            f"must be at most {ridge.root_width:g} mm (ridge.root_width), or the ridge hooks in its mold",
            ridge.tip_width,
        )
    for key, radius in (("tip_fillet", ridge.tip_fillet), ("root_fillet", ridge.root_fillet)):
        if 0 < radius < SMALLEST_FILLET:
            raise InputError(f"ridge.{key}", f"must be 0 or at least {SMALLEST_FILLET:g} mm", radius)
    limit = min(ridge.height, ridge.tip_width / 2)
    if ridge.crown >= limit:
        raise InputError(
            "ridge.crown",
            f"must be less than {limit:g} mm (the smaller of height and half tip_width)",
            ridge.crown,
        )


def _check_film(design: Design) -> None:
    slot, film = design.slot, design.film
    if film is not None and slot is None:
        raise InputError("film", "needs a slot to lie in", remedy="add [slot] or drop [film]")
    if film is not None and slot is not None and film.thickness > slot.thickness:
        raise InputError(
            "film.thickness", f"must be at most {slot.thickness:g} mm (slot.thickness)", film.thickness
        )
    if film is not None and slot is not None and 2 * film.electrode_margin >= slot.depth:
        rule = f"must be less than {slot.depth / 2:g} mm (half of slot.depth), or no electrode is left"
        raise InputError("film.electrode_margin", rule, film.electrode_margin)
    if design.mold.method == "cast-in":
        _check_cast_in(design)
    if design.contact.film == "bonded" and film is None:
        raise InputError("contact.film", "'bonded' needs a [film]", remedy="add [film] or say 'loose'")


def _check_cast_in(design: Design) -> None:
    """Strips lie straight in the mold, and what is round them is silicone."""
    key, given = "mold.method", design.mold.method
    if design.slot is not None and design.film is None:
        raise InputError(key, "needs a [film] to cast in", given, "add [film], or take 'shim'")
    if design.skin.curvature_radius_y is not None:
        rule = "needs straight strips, and skin.curvature_radius_y bends them"
        raise InputError(key, rule, given, "drop curvature_radius_y")
