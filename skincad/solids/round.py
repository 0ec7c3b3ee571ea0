r"""The mold of a round skin, whose section turns about z.

    z up          cover, with the cup over the vent at +y
    ------------------------------
    | wall |     carrier      | wall |     carrier and seal are discs in the block's round seat
    |      |_     skin      _|      |     skin's back at z = 0; the carrier lies on a ledge all round
    |        |_/\/\__/\/\_|        |     the negative turns about z
    |____________block____________|

It needs no end plates: no slot runs out of a round skin, so nothing has to be drawn out along y. The block is
square, to be clamped, and its screws and pins are those of the straight mold's cover. The section that rules
judge is that of the straight mold, through the axis: a mill or a lathe's tool goes round it as a mill goes
along a trough. Silicone is poured into the open trough before the carrier is let down: there is no wall
through which a gate could lead without a mark on the skin's side. The back's rim is tight on its ledge, so
the vent stands at the rim, which is the highest place once the mold is tilted.

Where `mold.block_process` is given, the cavity is a disc in the block's seat, under the carrier, so that its
grooves can be turned, or printed finer than the block: the skin touches the disc alone, and no seam marks
it. The disc lies on the seat's floor and is pushed out through a hole from below.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.shape.curves import Point, flipped, right_half
from skincad.shape.skin import Section, summit
from skincad.solids.bone import bone_parts
from skincad.solids.cavity import cavity, negative
from skincad.solids.kind import kind_of
from skincad.solids.layout import STOCK, Layout
from skincad.solids.lids import (
    backing,
    cover,
    cover_dowels,
    round_marks,
    seal_sheet,
)
from skincad.solids.plan import Bore, CutRole, Part, PartRole, Prism, TurnedBody, box, disc
from skincad.solids.shrinkage import on_grid
from skincad.solids.skin import cast_skin
from skincad.solids.split import path

_OF_BLOCK = (CutRole.COVER_THREAD, CutRole.COVER_PIN, CutRole.MARK)
UNDER_GROOVES = 3.0  # mm, assumption: of a disc under its deepest groove, to be held by while it is turned
EJECT = 2.5  # mm, assumption: radius of the hole for a rod that pushes the disc out; a disc is wider than 8


def check_round(design: Design) -> Iterator[InputError]:
    """Yield an error for each thing that the mold of a round skin can't be, and for a block of another's."""
    choice = design.mold
    if kind_of(design).ends:
        if choice.block_process is not None:
            rule = "must not be given for a skin that is not round, whose block is its cavity"
            yield InputError("mold.block_process", rule, choice.block_process, "leave it out")
        return
    if choice.pour == "syringe" or choice.gate is not None:
        key, value = ("mold.pour", choice.pour) if choice.pour == "syringe" else ("mold.gate", choice.gate)
        rule = "must not be given for a round skin, whose mold is poured open: it has no end to put a gate in"
        yield InputError(key, rule, value, "leave it out")
    if choice.cavities > 1:
        yield InputError("mold.cavities", "must be 1 for a round skin", choice.cavities, "leave it out")
    if choice.split != "none":
        rule = "must be 'none' for a round skin: no piece of its cavity could leave sideways"
        yield InputError("mold.split", rule, choice.split, "give the rings draft")


def lids_layout(design: Design, place: Layout) -> Layout:
    """Return the layout as carrier, cover and seal see it: silicone ends at the skin's rim."""
    return place._replace(end=design.skin.width / 2) if not kind_of(design).ends else place


def round_parts(design: Design, shape: Section, place: Layout) -> list[Part]:
    """Return the closed mold's parts; `design` is what is poured. Raises InputError if one has no room."""
    lids, whole = lids_layout(design, place), _block(design, shape, place)
    blocks = [whole] if design.mold.block_process is None else _parted(design, shape, place, whole)
    rest = [
        *backing(design, lids),
        cover(design, lids),
        *cover_dowels(design, lids),
        seal_sheet(design, lids),
    ]
    return [cast_skin(design, shape), *blocks, *rest, *bone_parts(design)]


def _block(design: Design, shape: Section, place: Layout) -> Part:
    """The square block less the skin's negative and, above the back, the carrier's seat."""
    straight = cavity(design, shape, place)
    body = box(place.half, (-place.end, place.end), (place.bottom, place.top))
    half = right_half(flipped(shape.outline))
    trough = TurnedBody(half, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), role=CutRole.TROUGH)
    seat = replace(disc(place.trough, 0.0, place.top), role=CutRole.SEAT)
    marks = round_marks(design, lids_layout(design, place))[1:]
    cuts = (
        trough,
        seat,
        *(cut for cut in straight.cuts if cut.role in (*_OF_BLOCK, CutRole.FEATURE)),
        *marks,
    )
    return Part("cavity", PartRole.CAVITY, body, cuts, straight=straight)


def _parted(design: Design, shape: Section, place: Layout, whole: Part) -> list[Part]:
    """The block with a deeper seat, and the cavity as a disc in it."""
    low = -on_grid(math.ceil((summit(design) + UNDER_GROOVES) / STOCK) * STOCK)
    seat = replace(disc(place.trough, low, place.top), role=CutRole.SEAT)
    eject = Bore((0.0, 0.0, place.bottom), "z", low - place.bottom, EJECT, role=CutRole.EJECT)
    threads = (cut for cut in whole.cuts if cut.role in _OF_BLOCK)
    wide, half = place.trough - design.mold.clearance, design.skin.width / 2
    right = Point(wide, low), Point(wide, 0.0), Point(half, 0.0)
    left = Point(-half, 0.0), Point(-wide, 0.0), Point(-wide, low), Point(wide, low)
    outline = (*path([*right]), *negative(shape.outline), *path([*left]))
    section = Part("cavity", PartRole.CAVITY, Prism(outline, "y", -wide, wide))
    carved = tuple(cut for cut in whole.cuts if cut.role in (CutRole.TROUGH, CutRole.FEATURE))
    return [
        Part("block", PartRole.BLOCK, whole.body, (seat, eject, *threads)),
        Part("cavity", PartRole.CAVITY, disc(wide, low, 0.0), carved, straight=section),
    ]
