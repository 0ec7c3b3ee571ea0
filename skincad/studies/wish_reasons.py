"""Why a design for a wish is as it is: each choice with its rule, and each wish that it does not meet."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import Any

from skincad.base.result import Record, item, record
from skincad.fabrication.job import Job
from skincad.fabrication.papers import cell, cells, macro
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import Ridge
from skincad.inputs.gripper import Gripper
from skincad.mechanics.verdict import ContactCheck
from skincad.shape.skin import skin_of
from skincad.studies import wish_shapes
from skincad.studies.wish_shapes import Wish


@record()
class Choice(Record):
    """A value that was chosen for a key of the design, and why."""

    key: str = item(meaning="of the design")
    value: str = item(meaning="chosen, with its unit")
    why: str = item(meaning="the rule that it follows")


@record()
class BrokenWish(Record):
    """A wish that could not be met."""

    wish: str = item(meaning="size, touch, gripper, film, process or hold")
    asked: str = item(meaning="as it was wished")
    given: str = item(meaning="as the design has it instead")
    why: str = item(meaning="the obstacle, and what may help")
    undecided: bool = item(meaning="whether too few lifts were tried to say so", default=False)


def choices(
    design: Design, asked: Collection[str] = (), for_hold: Mapping[str, str] = MappingProxyType({})
) -> tuple[Choice, ...]:
    """Return what was chosen, and by which rule; keys that were `asked` for are no choices, those `for_hold`
    were chosen by the lifts that they hold, with its reason."""
    return tuple(
        Choice(key=key, value=value, why=for_hold.get(key, why))
        for key, value, why in _rows("choices", design)
        if key not in asked
    )


def held_reason(design: Design, tried: int, lifts: int, *, most: bool) -> str:
    """Return why a design was taken of those `tried` in a few `lifts`: it held `most`, or it came first."""
    ((why,),) = _rows("for_hold", design, tried, lifts, most)
    return why


def broken_wishes(
    wish: Wish,
    design: Design,
    given_up: Mapping[str, str],
    verdict: ContactCheck,
    *,
    met: bool,
    mass: float | None,
    holds: float,
) -> tuple[BrokenWish, ...]:
    """Return the wishes that a design does not meet; `given_up` says which rule each part of it broke, `met`
    whether the design passes at its own force. Of lifts of `mass` g a share of `holds` was wished: it is
    undecided where fewer are held but the share's interval includes it."""
    rows = _rows("broken", design, wish, given_up, met)
    undecided, holding = False, verdict.holding
    if mass is not None:
        undecided = holding is not None and holding.high is not None and holding.high >= holds
        rows += _rows("not_held", design, wish, mass, holding, verdict.lift_signal, holds, undecided)
    return tuple(
        BrokenWish(wish=key, asked=asked, given=given, why=why, undecided=undecided and key == "hold")
        for key, asked, given, why in rows
    )


def thick_warnings(design: Design, face: Gripper | None) -> tuple[str, ...]:
    """Return warnings of a pad that leans under a pull, or leaves its gripper little room to open."""
    return tuple(words for (words,) in _rows("warnings", design, face))


def _rows(name: str, design: Design, *values: Any) -> list[list[str]]:
    """The entries of a macro of templates/reasons/wish.txt, each by its parts."""
    skin, pitch, crests = skin_of(design), design.spacing, skin_of(design).crests
    text = macro(
        "reasons/wish.txt",
        name,
        *values,
        rules=wish_shapes,
        design=design,
        skin=design.skin,
        mold=design.mold,
        force=design.contact.force,
        process=cell(design.mold.process),
        family=design.features.family,
        pitch=pitch,
        height=design.heights[0],
        usual_pitch=wish_shapes.usual_pitch(design.skin.width),
        usual_thickness=wish_shapes.usual_thickness(pitch),
        share=wish_shapes.FORMS[0][0],
        low=max(crests) - min(crests),
        scatter=Job(design).cavity_process.crest_sigma,
        levelling=design.of(Ridge).levelling or 0.0 if design.features.family == "ridge" else 0.0,
        slot=skin.slot,
    )
    entries = f"\n{text}".split("\n- ")[1:]
    return [cells(" ".join(entry.split())) for entry in entries]
