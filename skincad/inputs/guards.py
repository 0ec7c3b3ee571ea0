"""Rules between the tables of a design, beyond each key's own range; broken ones are reported together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial

from skincad.base.errors import InputError, refusals
from skincad.inputs.gripper import Gripper, check_grippers, gripper_named
from skincad.inputs.mold_table import Mold, Mount
from skincad.inputs.process import Process, check_named, check_own
from skincad.inputs.silicone import Silicone, check_law, check_own_silicones, check_silicone, silicone_of
from skincad.inputs.skin_tables import Base, Contact, Features, Film, Material, Ridge, Slot, lean

MOST_RIDGES = 999  # the largest ridge.count that a remedy names
FAN_LIMIT_DEG = 90.0  # assumption: a flat back under a wider fan leaves knife edges at the sides
# mm; ten times the length below which the CAD kernel takes an edge's ends for one point
SMALLEST_FILLET = 1e-6
CORE_SHARE = 0.2  # assumption: least radius of a revolved skin's back, of curvature_radius_y


def processes(mold: Mold, own: Mapping[str, Process]) -> Iterator[InputError]:
    """Yield what a workshop's own processes lack, and names of the mold's that nobody knows."""
    yield from refusals(lambda: check_own(own))
    for key in ("process", "end_plate_process", "lid_process"):
        yield from refusals(partial(check_named, f"mold.{key}", getattr(mold, key), own))


def grippers(mold: Mold, mount: Mount | None, own: Mapping[str, Gripper]) -> Iterator[InputError]:
    """Yield what a lab's own grippers lack, a name that nobody knows, and holes that are given twice."""
    yield from refusals(lambda: check_grippers(own))
    if mold.mount is None:
        return
    yield from refusals(lambda: gripper_named(mold.mount or "", own))
    if mount is not None:
        remedy = "leave one of them out; [grippers] holds a gripper of your own"
        yield InputError("mold.mount", "has its own holes, and so has [mount]", mold.mount, remedy)


def silicones(material: Material, own: Mapping[str, Silicone]) -> Iterator[InputError]:
    """Yield what a lab's own silicones lack, and a material's name that nobody knows."""
    broken = [
        *refusals(lambda: check_own_silicones(own)),
        *refusals(lambda: check_silicone(material.name, own)),
    ]
    yield from broken
    if material.law is not None and not broken:
        meant = silicone_of(material.name, material.given, own)
        yield from refusals(lambda: check_law("material", meant))


def features_on_skin(skin: Base, features: Features) -> Iterator[InputError]:
    """Yield what keeps the skin from being a fan of less than `FAN_LIMIT_DEG` that bears all its features."""
    if skin.width >= 2 * skin.curvature_radius:
        yield InputError(
            "skin.width",
            f"must be less than {2 * skin.curvature_radius:g} mm (twice skin.curvature_radius)",
            skin.width,
        )
        return  # nothing below has a meaning then
    side = math.asin(skin.width / (2 * skin.curvature_radius))
    if math.degrees(2 * side) >= FAN_LIMIT_DEG:
        widest = 2 * skin.curvature_radius * math.sin(math.radians(FAN_LIMIT_DEG / 2))
        yield InputError(
            "skin.width",
            f"the fan from side to side must stay below {FAN_LIMIT_DEG:g} degrees, so below {widest:.4g} mm",
            skin.width,
            "make the skin narrower or curvature_radius larger",
        )
    sag = 2 * skin.curvature_radius * math.sin(side / 2) ** 2
    if sag > 0.8 * skin.thickness:
        yield InputError(
            "skin.thickness",
            f"must be above {sag / 0.8:.4g} mm, or too little is left at the sides (the base circle "
            f"falls by {sag:.4g} mm)",
            skin.thickness,
        )
    half_root = features.root_width / 2 + features.root_fillet
    reach = abs(lean(skin, features, 1)) + half_root / skin.curvature_radius
    if reach >= side:
        more = (
            2 * (side * skin.curvature_radius - half_root) / features.spacing
        )  # infinite where there is no pitch
        most = max(0, math.ceil(min(more, MOST_RIDGES)))
        yield InputError(
            f"{features.family}.count",
            f"at most {most} {features.family}s of this pitch and root fit on skin.width",
            features.count,
            f"take fewer {features.family}s, a smaller pitch or a wider skin"
            if most
            else "take a wider skin or a smaller root",
        )


def revolved(skin: Base) -> Iterator[InputError]:
    """Yield a section too near the axis that it turns about, and a turn of the fan's limit or more."""
    radius = skin.curvature_radius_y
    if radius is None:
        return
    least = skin.thickness / (1 - CORE_SHARE)
    if radius < least:
        yield InputError(
            "skin.curvature_radius_y",
            f"must be at least {least:.4g} mm, or the back at skin.thickness below comes too near its axis",
            radius,
            "make the skin thinner or the radius larger",
        )
    longest = radius * math.radians(FAN_LIMIT_DEG)
    if skin.length >= longest:
        yield InputError(
            "skin.length",
            f"the fan from end to end must stay below {FAN_LIMIT_DEG:g} degrees, so below {longest:.4g} mm",
            skin.length,
            "make the skin shorter or curvature_radius_y larger",
        )


def profile(ridge: Ridge) -> Iterator[InputError]:
    """Yield widths, fillets and a crown that make no ridge."""
    if ridge.root_width >= ridge.spacing:
        yield InputError(
            "ridge.root_width", f"must be less than {ridge.spacing:g} mm (ridge.pitch)", ridge.root_width
        )
    if ridge.tip_width > ridge.root_width:
        yield InputError(
            "ridge.tip_width",
            f"must be at most {ridge.root_width:g} mm (ridge.root_width), or the ridge hooks in its mold",
            ridge.tip_width,
        )
    for key, radius in (("tip_fillet", ridge.tip_fillet), ("root_fillet", ridge.root_fillet)):
        if 0 < radius < SMALLEST_FILLET:
            yield InputError(f"ridge.{key}", f"must be 0 or at least {SMALLEST_FILLET:g} mm", radius)
    heights = ridge.heights or (ridge.height or 0.0,)  # levelling makes none lower
    limit = min(*heights, ridge.tip_width / 2)
    if ridge.crown >= limit:
        lowest = f" of ridge {heights.index(limit) + 1}" if limit in heights and limit < max(heights) else ""
        yield InputError(
            "ridge.crown",
            f"must be less than {limit:g} mm (the smaller of height{lowest} and half tip_width)",
            ridge.crown,
        )


def strips(skin: Base, slot: Slot | None, film: Film | None, mold: Mold) -> Iterator[InputError]:
    """Yield a film that finds no room in its slot, and strips that cannot be cast in, which lie straight."""
    if film is not None and slot is None:
        yield InputError("film", "needs a slot to lie in", remedy="add [slot] or drop [film]")
    if film is not None and slot is not None and film.thickness > slot.thickness:
        yield InputError(
            "film.thickness", f"must be at most {slot.thickness:g} mm (slot.thickness)", film.thickness
        )
    if film is not None and slot is not None and 2 * film.margin >= slot.depth:
        rule = f"must be less than {slot.depth / 2:g} mm (half of slot.depth), or no electrode is left"
        remedy = "a deeper slot, or a finer film.cut_tolerance and film.registration"
        yield InputError("film.electrode_margin", rule, film.margin, remedy)
    key, method = "mold.method", mold.method
    if method == "cast-in" and slot is not None and film is None:
        yield InputError(key, "needs a [film] to cast in", method, "add [film], or take 'shim'")
    if method == "cast-in" and skin.curvature_radius_y is not None:
        rule = "needs straight strips, and skin.curvature_radius_y bends them"
        yield InputError(key, rule, method, "drop curvature_radius_y")


def bond(contact: Contact, film: Film | None) -> Iterator[InputError]:
    """Yield a bond of films that are not there."""
    if contact.film == "bonded" and film is None:
        yield InputError("contact.film", "'bonded' needs a [film]", remedy="add [film] or say 'loose'")
