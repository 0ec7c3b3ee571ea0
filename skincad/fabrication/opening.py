"""How a mold is opened: what the casting sheet says of each step, and which parts leave by it."""

from __future__ import annotations

from typing import NamedTuple

from skincad.fabrication.bent_steps import leave_steps
from skincad.fabrication.bond_steps import (
    curing_steps,
    drawing_step,
    gluing_steps,
    preparation_steps,
    pull_test_steps,
)
from skincad.fabrication.drawing_in import lap
from skincad.fabrication.electrodes import past_tabs
from skincad.fabrication.fan_out import fan_out_steps
from skincad.fabrication.strip_steps import release_steps
from skincad.inputs.design import Design
from skincad.shape.skin import skin_of
from skincad.solids.cavity import split_ridges
from skincad.solids.ends import gate
from skincad.solids.layout import is_clamped
from skincad.solids.mold import ClosedMold, Move
from skincad.solids.plan import END_PLATES, CutRole, PartRole, bores
from skincad.solids.shrinkage import scaled_for_shrinkage


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
    shims, straight = tuple(by["shims"]), design.skin.curvature_radius_y is None
    first = _without_moves(release_steps(design) if lap(design) is None else preparation_steps(design))
    drawn_in = (
        [*_without_moves(gluing_steps(design)), OpeningStep(drawing_step(design), shims)] if shims else []
    )
    drawn_in += _without_moves(curing_steps(design))
    out, proof = (
        OpeningStep(_skin_removal_words(design, closed), tuple(by["skin"])),
        _without_moves(pull_test_steps(design)),
    )
    led = _without_moves(fan_out_steps(design))
    if not straight:
        removal = map(OpeningStep, leave_steps(closed), (tuple(by["lid"]), tuple(by["ends"])))
        return [*first, *drawn_in, *removal, out, *proof, *led]
    ends, lid = map(OpeningStep, _removal_words(design), (tuple(by["ends"]), tuple(by["lid"])))
    if lap(design) is None:  # cast in, or no film
        return [*first, ends, *drawn_in, lid, out, *proof, *led]
    return [*first, ends, *drawn_in, *proof, lid, out, *led]


def _without_moves(lines: list[str]) -> list[OpeningStep]:
    """Steps in which no part leaves the mold."""
    return [OpeningStep(words, ()) for words in lines]


def _removal_words(design: Design) -> list[str]:
    """How end plates and cover come off; the cover holds skin and carrier until the shims are out."""
    slides, tabs = "along y,", ""
    if skin_of(design).slot is not None:
        cast_in = design.mold.method == "cast-in" and design.film
        tabs = f" {past_tabs(design)}" if cast_in else ""
        slides += " over the strips," if cast_in else " over the shims (hold these back by their other ends),"
    fasteners = "clamps" if is_clamped(scaled_for_shrinkage(design)) else "bolts"
    return [
        "Take the end plates' bolts out; the cover stays on. "
        + ("Cut the sprue at the gate, and slide" if gate(design) else "Slide")
        + f" the end plates off {slides} with a screwdriver in the notches at their sides.{tabs}",
        f"Take the cover's {fasteners} off and lift it where it overhung the end plates, with the foam; the "
        "silicone in the reservoir and the bleeds tears off, or is cut flush.",
    ]


def _skin_removal_words(design: Design, closed: ClosedMold) -> str:
    """How the skin and its cavity part."""
    carrier = closed.first(PartRole.CARRIER)
    pulls, mount = bores(carrier, CutRole.PULL), bores(carrier, CutRole.MOUNT)
    other = "by two screws in its mount's threads" if mount else "from its two ends"
    how = "by two M3 screws in its blind holes" if pulls else other
    if not split_ridges(design):
        return f"Pull the carrier up {how}; the skin comes out of the cavity with it. Cut the flash there."
    return (
        f"Hold the carrier {how} and draw the base plate off downward. Tilt the two outer pieces of the "
        "cavity off along the outermost splits, then draw the pieces between out of the valleys, each along "
        "its own ridges. Cut the flash at the carrier; that on the split crowns must be thin: wipe it off, "
        "don't cut into a crown."
    )
