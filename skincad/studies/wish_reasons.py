"""Why a design for a wish is as it is: each choice with its rule, and each wish that it does not meet."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from skincad.base.result import Record, item, record
from skincad.fabrication.job import Job
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import Ridge
from skincad.shape.skin import skin_of
from skincad.studies.wish_shapes import (
    DROP,
    FILM_ROOM,
    FLAT,
    FORMS,
    MOST_PINS,
    MOST_RIDGES,
    THICKEST,
    THINNEST,
    Wish,
    usual_pitch,
    usual_thickness,
)


@record()
class Choice(Record):
    """A value that was chosen for a key of the design, and why."""

    key: str = item(meaning="of the design")
    value: str = item(meaning="chosen, with its unit")
    why: str = item(meaning="the rule that it follows")


@record()
class BrokenWish(Record):
    """A wish that could not be met."""

    wish: str = item(meaning="size, touch, gripper, film or process")
    asked: str = item(meaning="as it was wished")
    given: str = item(meaning="as the design has it instead")
    why: str = item(meaning="the obstacle, and what may help")


def choices(design: Design, asked: Collection[str] = ()) -> tuple[Choice, ...]:
    """Return what was chosen, and by which rule; keys that were `asked` for are no choices."""
    skin, mold, force, process = design.skin, design.mold, design.contact.force, design.mold.process
    family, pitch, height = design.features.family, design.spacing, design.heights[0]
    whose = f"the face of {mold.mount}" if mold.mount else "the usual pad"
    usual, thick, share = usual_pitch(skin.width), usual_thickness(pitch), FORMS[0][0]
    many = f"as many ridges as fit, about {MOST_RIDGES} as in the paper"
    high = f"{share:g} of the pitch, as the paper's"
    deep = f"four pitches, {THINNEST:g} mm at least and {THICKEST:g} mm at most"
    if family == "pin":
        many = f"the smallest with at most about {MOST_PINS} pins that the mold by {process} bears"
        high = f"{height / pitch:.2g} of the pitch; assumption: higher ones sway more, lower ones are stiffer"
        deep = f"{deep}, or more to be softer"
    else:
        if pitch > usual:
            many = f"finer ridges break a rule of the mold by {process}, or are too stiff"
        elif pitch < usual:
            many = "larger ridges break a rule of the mold, or are too stiff"
        if height > (share + 0.1) * pitch:
            high = f"more than {share:g} of the pitch, to be softer"
        if skin.thickness > 1.1 * thick:
            deep = f"{skin.thickness / thick:.2g} times the usual, to be softer"
    crests, scatter = skin_of(design).crests, Job(design).cavity_process.crest_sigma
    low = max(crests) - min(crests)
    curved = f"the outer crests lie {low:.2g} mm lower"
    if low > (DROP - 0.03) * height:
        curved = f"{curved}, a quarter of a {family}'s height, as the paper's"
    elif low < 2 * FLAT * height:
        curved = "nearly flat: at this force the plate comes down too little for more"
    else:
        scattered = f"crests that scatter by {scatter:g} mm, as {process} makes them"
        curved = f"{curved}; at {force:g} N that leaves room for {scattered}"
    rows = [
        ("skin", _size(skin.width, skin.length), whose),
        (f"{family}.pitch", f"{pitch:g} mm, {design.count} {family}s", many),
        (f"{family}.height", f"{height:g} mm", high),
        ("skin.thickness", f"{skin.thickness:g} mm", deep),
        ("skin.curvature_radius", f"{skin.curvature_radius:g} mm", curved),
    ]
    if family == "ridge":
        why = "the curvature is chosen instead, so that all ridges are alike"
        rows.append(("ridge.levelling", f"{design.of(Ridge).levelling or 0.0:g}", why))
    why = f"the hardest that feels {force:g} N and bears being pulled out of a mold"
    rows.append(("material.name", str(design.material.name), why))
    if (slot := skin_of(design).slot) and design.film:
        why = f"shim sheet as it is sold, thicker than the film by at least {FILM_ROOM:g} mm"
        rows.append(("slot.thickness", f"{slot.thickness:g} mm", why))
    if mold.end_plate_process:
        why = f"{process} is too coarse for the slots' combs"
        rows.append(("mold.end_plate_process", mold.end_plate_process, why))
    return tuple(Choice(key=key, value=value, why=why) for key, value, why in rows if key not in asked)


def broken_wishes(
    wish: Wish, design: Design, given_up: Mapping[str, str], met: bool
) -> tuple[BrokenWish, ...]:
    """Return the wishes that a design does not meet; `given_up` says which rule each part of it broke, `met`
    whether the design passes at its own force."""
    skin, force, process = design.skin, design.contact.force, design.mold.process
    rows = []
    if rule := given_up.get("length") or given_up.get("width"):
        why = f"the mold is too large for {wish.process} ({rule}); take a larger machine by --printer"
        rows.append(("size", _size(wish.width, wish.length), _size(skin.width, skin.length), why))
    if "gripper" in given_up:
        why = f"its holes have no room in a carrier of this size; {given_up['gripper']}"
        rows.append(("gripper", str(wish.gripper), "no holes", why))
    for key, asked, given, features, remedy in (
        ("film", f"{wish.film:g} mm", "no film", "slots", "a thinner film, a larger size or a finer process"),
        ("process", wish.process, process, f"{design.features.family}s", "a larger size or another process"),
    ):
        if key in given_up:
            why = f"no {features} for it were found that keep all rules ({given_up[key]} is the last broken)"
            rows.append((key, asked, given, f"{why}; take {remedy}"))
    if force != wish.touch or not met:
        why = f"{design.features.family}s of {design.material.name} would bear too much"
        remedy = "a harder silicone or a larger size"
        if force >= wish.touch:
            scatter = Job(design).cavity_process.crest_sigma
            why = f"{design.material.name} is too stiff for crests that scatter by {scatter:g} mm"
            why = f"{why}, as {process} makes them"
            remedy = "a softer silicone, a finer process or a smaller size"
        given = f"{force:g} N" if met else f"{force:g} N, which it does not pass either"
        rows.append(("touch", f"{wish.touch:g} N", given, f"{why}; take {remedy}"))
    return tuple(BrokenWish(wish=key, asked=asked, given=given, why=why) for key, asked, given, why in rows)


def _size(width: float, length: float) -> str:
    return f"{width:g} x {length:g} mm"
