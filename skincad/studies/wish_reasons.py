"""Why a design for a wish is as it is: each choice with its rule, and each wish that it does not meet."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from skincad.base.result import Record, item, record
from skincad.fabrication.job import Job
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import Pin, Ridge
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


def choices(
    design: Design, *, asked_size: bool, asked_silicone: bool, asked_thickness: bool = False
) -> tuple[Choice, ...]:
    """Return what was chosen, and by which rule."""
    found = _choices(design, asked_size, asked_silicone)
    return tuple(c for c in found if not (asked_thickness and c.key == "skin.thickness"))


def _choices(design: Design, asked_size: bool, asked_silicone: bool) -> Iterator[Choice]:
    skin, mold, pins = design.skin, design.mold, design.features.family == "pin"
    if not asked_size:
        whose = f"the face of {mold.mount}" if mold.mount else "the usual pad"
        yield Choice(key="skin", value=_size(skin.width, skin.length), why=whose)
    yield from _pins(design) if pins else _ridges(design)
    yield _curvature(design)
    if not pins:
        why = "the curvature is chosen instead, so that all ridges are alike"
        level = design.of(Ridge).levelling or 0.0
        yield Choice(key="ridge.levelling", value=f"{level:g}", why=why)
    if not asked_silicone:
        why = f"the hardest that feels {design.contact.force:g} N and bears being pulled out of a mold"
        yield Choice(key="material.name", value=str(design.material.name), why=why)
    if (slot := skin_of(design).slot) and design.film:
        why = f"shim sheet as it is sold, thicker than the film by at least {FILM_ROOM:g} mm"
        yield Choice(key="slot.thickness", value=f"{slot.thickness:g} mm", why=why)
    if mold.end_plate_process:
        why = f"{mold.process} is too coarse for the slots' combs"
        yield Choice(key="mold.end_plate_process", value=mold.end_plate_process, why=why)


def _ridges(design: Design) -> Iterator[Choice]:
    """The choice of pitch, height and thickness."""
    skin, ridge, mold = design.skin, design.of(Ridge), design.mold
    usual, pitch, height = usual_pitch(skin.width), ridge.pitch or 0.0, ridge.height or 0.0
    why = f"as many ridges as fit, about {MOST_RIDGES} as in the paper"
    if pitch > usual:
        why = f"finer ridges break a rule of the mold by {mold.process}, or are too stiff"
    elif pitch < usual:
        why = "larger ridges break a rule of the mold, or are too stiff"
    yield Choice(key="ridge.pitch", value=f"{pitch:g} mm, {ridge.count} ridges", why=why)
    (share, _, _), softer = FORMS[0], ", to be softer"
    tall = height > (share + 0.1) * pitch
    why = f"more than {share:g} of the pitch{softer}" if tall else f"{share:g} of the pitch, as the paper's"
    yield Choice(key="ridge.height", value=f"{height:g} mm", why=why)
    thick = usual_thickness(pitch)
    why = f"four pitches, {THINNEST:g} mm at least and {THICKEST:g} mm at most"
    if skin.thickness > 1.1 * thick:
        why = f"{skin.thickness / thick:.2g} times the usual{softer}"
    yield Choice(key="skin.thickness", value=f"{skin.thickness:g} mm", why=why)


def _pins(design: Design) -> Iterator[Choice]:
    """The choice of pitch, height and thickness of pins."""
    skin, pin = design.skin, design.of(Pin)
    why = f"the smallest with at most about {MOST_PINS} pins that the mold by {design.mold.process} bears"
    yield Choice(key="pin.pitch", value=f"{pin.pitch:g} mm, {design.count} pins", why=why)
    share = (pin.height or 0.0) / pin.pitch
    why = f"{share:.2g} of the pitch; assumption: higher ones sway more, lower ones are stiffer"
    yield Choice(key="pin.height", value=f"{pin.height:g} mm", why=why)
    why = f"four pitches, {THINNEST:g} mm at least and {THICKEST:g} mm at most, or more to be softer"
    yield Choice(key="skin.thickness", value=f"{skin.thickness:g} mm", why=why)


def _curvature(design: Design) -> Choice:
    """The choice of the radius."""
    crests, scatter = skin_of(design).crests, Job(design).cavity_process.crest_sigma
    low = max(crests) - min(crests)
    force, process = design.contact.force, design.mold.process
    room = (
        f"at {force:g} N that leaves room for crests that scatter by {scatter:g} mm, as {process} makes them"
    )
    why = f"the outer crests lie {low:.2g} mm lower; {room}"
    if low > (DROP - 0.03) * design.heights[0]:
        quarter = f"a quarter of a {design.features.family}'s height"
        why = f"the outer crests lie {low:.2g} mm lower, {quarter}, as the paper's"
    elif low < 2 * FLAT * design.heights[0]:
        why = "nearly flat: at this force the plate comes down too little for more"
    return Choice(key="skin.curvature_radius", value=f"{design.skin.curvature_radius:g} mm", why=why)


def broken_wishes(
    wish: Wish, design: Design, given_up: Mapping[str, str], met: bool
) -> tuple[BrokenWish, ...]:
    """Return the wishes that a design does not meet; `given_up` says which rule each part of it broke, `met`
    whether the design passes at its own force."""
    return tuple(_broken(wish, design, given_up, met))


def _broken(wish: Wish, design: Design, given_up: Mapping[str, str], met: bool) -> Iterator[BrokenWish]:
    skin, force = design.skin, design.contact.force
    if "width" in given_up or "length" in given_up:
        rule = given_up.get("length") or given_up["width"]
        why = f"the mold is too large for {wish.process} ({rule}); take a larger machine by --printer"
        asked, given = _size(wish.width, wish.length), _size(skin.width, skin.length)
        yield BrokenWish(wish="size", asked=asked, given=given, why=why)
    if "gripper" in given_up:
        why = f"its holes have no room in a carrier of this size; {given_up['gripper']}"
        yield BrokenWish(wish="gripper", asked=str(wish.gripper), given="no holes", why=why)
    if "film" in given_up:
        why = f"no slots for it were found that keep all rules ({given_up['film']} is the last broken); "
        why += "take a thinner film, a larger size or a finer process"
        yield BrokenWish(wish="film", asked=f"{wish.film:g} mm", given="no film", why=why)
    if "process" in given_up:
        why = f"no {design.features.family}s for it were found that keep all rules ({given_up['process']} is "
        why += "the last broken); take a larger size or another process"
        yield BrokenWish(wish="process", asked=wish.process, given=str(design.mold.process), why=why)
    if force != wish.touch or not met:
        yield BrokenWish(
            wish="touch",
            asked=f"{wish.touch:g} N",
            given=f"{force:g} N" if met else f"{force:g} N, which it does not pass either",
            why=_why_no_touch(wish, design),
        )


def _why_no_touch(wish: Wish, design: Design) -> str:
    name, process = design.material.name, design.mold.process
    if design.contact.force < wish.touch:
        what = f"{design.features.family}s of {name}"
        return f"{what} would bear too much; take a harder silicone or a larger size"
    scatter = Job(design).cavity_process.crest_sigma
    softer = f"{name} is too stiff for crests that scatter by {scatter:g} mm, as {process} makes them"
    return f"{softer}; take a softer silicone, a finer process or a smaller size"


def _size(width: float, length: float) -> str:
    return f"{width:g} x {length:g} mm"
