"""How a mold is opened: what the casting sheet says of each step, and which parts leave by it."""

from __future__ import annotations

from typing import NamedTuple

from skincad.fabrication.bent_steps import leave_steps
from skincad.fabrication.strip_steps import freed
from skincad.inputs.design import Design
from skincad.solids.ends import gate
from skincad.solids.layout import is_clamped
from skincad.solids.mold import ClosedMold, Move
from skincad.solids.plan import bores
from skincad.solids.roles import END_PLATES, CutRole, PartRole
from skincad.solids.shrinkage import poured
from skincad.solids.undercut import split_ridges


class OpeningStep(NamedTuple):
    """A step of opening: the sheet's words, and the moves that it makes; none where nothing leaves yet."""

    words: str
    moves: tuple[Move, ...]


def opening_steps(design: Design, closed: ClosedMold) -> list[OpeningStep]:
    """Return the steps by which a cured skin comes out of its mold, in order; together they make each move of
    `closed.opening` once."""
    by: dict[str, list[Move]] = {"shims": [], "ends": [], "lid": [], "skin": []}
    for move in closed.opening:
        role = closed.part(move.parts[0]).role
        known = {PartRole.SHIM: "shims", PartRole.COVER: "lid", **dict.fromkeys(END_PLATES, "ends")}
        by[known.get(role, "skin")].append(move)
    steps = [OpeningStep(words, tuple(by["shims"])) for words in freed(design)]
    if design.skin.curvature_radius_y is None:
        steps += map(OpeningStep, _taken_off(design), (tuple(by["ends"]), tuple(by["lid"])))
    else:
        steps += map(OpeningStep, leave_steps(), (tuple(by["lid"]), tuple(by["ends"])))
    return [*steps, OpeningStep(_out(design, closed), tuple(by["skin"]))]


def _taken_off(design: Design) -> list[str]:
    """How end plates and cover come off."""
    return [
        (
            "Take the clamps off and all bolts out. "
            if is_clamped(poured(design))
            else "Take all bolts out, the cover's first. "
        )
        + ("Cut the sprue at the gate, take" if gate(design) else "Take")
        + " the end plates off along y, with a screwdriver in the notches at their sides.",
        "Lift the cover where it overhung the end plates; the silicone in the reservoir and the bleeds tears "
        "off, or is cut flush.",
    ]


def _out(design: Design, closed: ClosedMold) -> str:
    """How the skin and its cavity part."""
    pulls = bores(closed.first(PartRole.CARRIER), CutRole.PULL)
    grip = "by two M3 screws in its blind holes" if pulls else "from its two ends"
    if not split_ridges(design):
        return f"Pull the carrier up {grip}; the skin comes out of the cavity with it. Cut the flash there."
    return (
        f"Hold the carrier {grip} and draw the base plate off downward. Tilt the two outer pieces of the "
        "cavity off along the outermost splits, then draw the pieces between out of the valleys, each along "
        "its own ridges. Cut the flash at the carrier; that on the split crowns must be thin: wipe it off, "
        "don't cut into a crown."
    )
