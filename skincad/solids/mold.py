r"""The mold, ridges down: cavity, end plates with combs and keepers, carrier, cover, pins, bores.

    z up                 cover            vent in the carrier at +y, a cup over it
    ---------------------------------
    | wall | ledge  carrier  | wall |     carrier lies on the ledge, under a seal as high as the walls
    |      |_     skin      _|      |     skin's back at z = 0
    |        |_/\/\/\/\/\_|        |     ridges' negative, open at both y ends
    |______________floor____________|

The carrier seals on its ledge along x; along y it ends a clearance before the end plates, where a thin flash
rises that is cut off. While it is poured, end b is up: what air is left runs along the carrier's lower face
to end b's edge and up that gap, so the cup over the vent covers the gap too. A gap of 0.01 mm lets 0.6 mm3/s
of air out under 5 mm of silicone (plane Poiseuille flow, 11 mm wide, 4 mm high) and negligible silicone.
Every hole of the carrier has a bleed in the cover, under the highest point of its rim.

An end plate closes each y end. Where there are slots it is split across the slits, at their back ends: the
comb below has a notch a slot, open towards the keeper above, so that a strip with tabs can be laid in and
a slit of 0.05 mm never has to be cut closed.

The end plates slide off along y over the shims; then each shim is drawn out along y, and a strip glued to its
tail follows it. The lap of both is thicker than a notch, and has none on its way: only the slot, which is
soft. A strip that is cast in lies in the notches
instead, under tension: it stands on the notch's bottom, which is its datum, has the slit clearance at its
sides, and the keeper over the notch's mouth keeps it from rising. Nothing squeezes it there: weights on its
tabs hold it until the silicone has cured. Tabs are wider than a notch and would block the combs, so they are
cut off flush with the straight part before the mold opens; then combs and keepers slide off along y over
straight strips, and the strips leave the cavity in the skin.

Screws, pins and their fits are in layout.py; the cavity, whole or in several pull pieces, in cavity.py. A
gang mold has its skins side by side along x, each with its own gate, carrier, reservoir and bleeds, between
common end plates and under one cover.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

from skincad.base.errors import InputError, refusals, together
from skincad.inputs.design import Design
from skincad.shape.skin import section, skin_of
from skincad.solids.bent import bent_parts, bent_plugs, check_bent, shims_turn
from skincad.solids.bone import bone_parts, check_bone
from skincad.solids.cavity import (
    base_dowels,
    cavity,
    cavity_pieces,
    cavity_plate,
    headings,
    parted,
    parts_at_tips,
    split_ridges,
)
from skincad.solids.ends import end_plates, refused_ends
from skincad.solids.inserts import drawing_end, pin, shims, strips
from skincad.solids.kind import kind_of
from skincad.solids.layout import Layout, layout
from skincad.solids.lids import (
    backing,
    cover,
    cover_dowels,
    refused_lids,
    seal_sheet,
)
from skincad.solids.pins import on_plane
from skincad.solids.plan import CAVITIES, END_PLATES, ENDS, End, Part, PartRole, Prism, RotatedBody, moved
from skincad.solids.round import check_round, lids_layout, round_parts
from skincad.solids.shots import check_shots, plugs, round_blank, straight_blank
from skincad.solids.shrinkage import scaled_for_shrinkage
from skincad.solids.skin import Way, cast_skin

if TYPE_CHECKING:
    import cadquery as cq


class Move(NamedTuple):
    """One step of opening: these parts leave along an axis or heading, over this signed travel in mm, or turn
    about their own axis by it in rad. y is an end plate's own where it leans."""

    parts: tuple[str, ...]
    axis: Way
    travel: float


@dataclass(frozen=True)
class ClosedMold:
    """The closed mold with the skin in it, and the order in which it opens."""

    parts: tuple[Part, ...]
    opening: tuple[Move, ...]
    earlier: tuple[ClosedMold, ...] = ()  # of a skin in layers: as it is closed for each plug, in order

    @property
    def plugs(self) -> list[Part]:
        """What lies in the carrier's place in earlier pours."""
        return [part for stage in self.earlier for part in stage.of(PartRole.PLUG)]

    @property
    def made(self) -> list[Part]:
        """The parts that one makes, the plugs too."""
        return [part for part in (*self.parts, *self.plugs) if part.made == "made"]

    def part(self, name: str) -> Part:
        """Return the part of this name."""
        return next(p for p in (*self.parts, *self.plugs) if p.name == name)

    def of(self, *roles: PartRole) -> list[Part]:
        """Return the parts of these roles."""
        return [part for part in self.parts if part.role in roles]

    def first(self, role: PartRole) -> Part:
        """Return the part of this role; the first one's of a gang."""
        return self.of(role)[0]

    @property
    def length(self) -> float:
        """Length of the cavity along y, mm, where it is longest."""
        block = self.of(*CAVITIES)[0].body
        if not isinstance(block, Prism):
            raise ValueError("a cavity is a prism less its cuts")
        if block.axis == "y":
            return block.high - block.low
        return 2 * max(max(s.start) if block.axis == "z" else s.start.x for s in block.outline)


def mold(design: Design) -> ClosedMold:
    """Return the closed mold's parts, the skin, shims or strips and pins in it, and the opening sequence.

    Raises InputError when a bore, the gate or a notch finds no room, and for what a doubly curved mold can't
    be: split, for several skins, or poured open; or a round one's: split, for several, or through a gate.
    """
    ridges = split_ridges(design)
    broken = list(_choices(design, ridges))
    # the part as designed must be one, not only the larger cavity
    kind = kind_of(design)
    whole = [*(check_bent(design) if kind.leans else ()), *check_round(design)]
    whole += [*check_shots(design), *check_bone(design)]
    whole += refusals(lambda: (section(design), section(scaled_for_shrinkage(design))))
    if whole:  # nothing is laid out in what is none
        raise together([*broken, *whole])
    design = scaled_for_shrinkage(design)
    plain = section(design)
    shape = replace(plain, outline=parted(plain.outline, ridges))
    on_base = bool(ridges) or parts_at_tips(design)
    place, more = layout(design, shape, split_cavity=on_base)
    broken += [*more, *(refused_ends(design, shape, place) if place.lanes else ())]
    broken += [*refused_lids(design, lids_layout(design, place))]
    if broken:
        raise together(broken)
    if kind.leans:
        closed = _with_opening(design, place, tuple(bent_parts(design, shape, place)), [])
        return _with_plugs(closed, place, bent_plugs(design, shape, place))
    if not kind.ends:
        closed = _with_opening(design, place, tuple(round_parts(design, shape, place)), [])
        return _with_plugs(closed, place, plugs(design, shape, lids_layout(design, place), round_blank))
    pieces = [cavity(design, shape, place)] if not on_base else cavity_plate(design, shape, place)
    pieces = cavity_pieces(design, shape, place, ridges) if ridges else pieces
    ends = [part for end in ENDS for part in end_plates(design, shape, place, end)]
    shim_parts, cast_strips = (shims(design), []) if design.mold.method == "shim" else ([], strips(design))
    skins = _gang(place, [cast_skin(design, shape)])
    rest = [*_gang(place, backing(design, place)), cover(design, place), *_pins(design, place)]
    rest.append(seal_sheet(design, place))
    rest += _gang(place, bone_parts(design))
    rest += base_dowels(design, shape, place) if on_base else []
    shim_parts, cast_strips = _gang(place, shim_parts), _gang(place, cast_strips)
    parts = (*skins, *pieces, *ends, *rest, *shim_parts, *cast_strips)
    closed = _with_opening(design, place, parts, ridges)
    stages = plugs(design, shape, place, straight_blank)
    return _with_plugs(closed, place, [_gang(place, stage) for stage in stages])


def _with_plugs(closed: ClosedMold, place: Layout, stages: list[list[Part]]) -> ClosedMold:
    """The mold with what it is before the last layer: plugs, and core pins in them, in the place of skin,
    carrier and what is in it.
    Plugs leave upward, once the cover is off, and plates that lean over them: keepers off their combs, over
    which shims stay. Core pins stay too, and nothing else is opened then."""
    gone = (PartRole.SKIN, PartRole.CARRIER, PartRole.CORE_PIN, PartRole.BONE, PartRole.BONE_SCREW)
    kept = [part for part in closed.parts if part.role not in gone]
    lid = (PartRole.COVER, PartRole.COVER_PIN, PartRole.SEAL)
    high = 2 * (place.top - place.bottom)
    steps = [Move(tuple(part.name for part in kept if part.role in lid), "z", high)]
    leaning = [part for part in kept if isinstance(part.body, RotatedBody) and part.role in END_PLATES]
    if keepers := tuple(part.name for part in leaning if part.role is PartRole.KEEPER):
        steps.append(Move(keepers, "z", high))
    elif leaning:
        steps += [step for step in closed.opening if step.parts[0] in [part.name for part in leaning]]
    earlier = tuple(
        ClosedMold(
            (*kept, *stage),
            (*steps, Move(tuple(part.name for part in stage if part.role is PartRole.PLUG), "z", high)),
        )
        for stage in stages
    )
    return replace(closed, earlier=earlier)


def _choices(design: Design, ridges: list[int]) -> Iterator[InputError]:
    """What a cavity that is split at these ridges can't be."""
    skin = skin_of(design)
    how, at_tips = design.mold.split, parts_at_tips(design)
    if how == "tips" and not (at_tips and on_plane(design, section(design))):
        rule = "needs pins on a flat base, whose tips lie on one plane"
        yield InputError("mold.split", rule, how, "leave it out: one block, its holes brushed full")
    elif how == "auto" and not skin.form.parting:
        rule = f"must be 'none' here: a cavity is split at ridges or pins, and [{skin.family}] has none"
        yield InputError("mold.split", rule, how, "leave it out")
    if ridges and skin.count % 2 == 0:
        rule = "splits only an odd number of ridges, so that the middle one comes straight out"
        yield InputError("mold.split", rule, skin.count, "take one ridge more or less")
    if (ridges or at_tips) and design.mold.cavities > 1:
        yield InputError("mold.cavities", "must be 1 where the cavity is split", design.mold.cavities)


def _with_opening(design: Design, place: Layout, parts: tuple[Part, ...], ridges: list[int]) -> ClosedMold:
    """The mold of these parts, opened. End plates slide off over straight shims, which leave along y; then
    the cover. Shims that are arcs are turned out first, then the cover, then end plates, square to their
    faces. A whole cavity lets the skin be pulled up with its carrier; the pieces of a split one leave the
    skin, its base first, then the outer ones, then the others from the middle. Off a plate of through holes
    comes its base, then the skin."""
    bent, closed = kind_of(design).leans, ClosedMold(parts, ())
    far = 2 * design.skin.length + 4 * design.mold.end_plate
    high = 2 * (place.top - place.bottom) + (design.skin.length if bent else 0.0)

    def leave(way: Way, travel: float, *roles: PartRole, end: End | None = None) -> Move:
        leaving = closed.of(*roles)
        return Move(tuple(p.name for p in leaving if end in (None, p.end)), way, travel)

    sign = 1.0 if drawing_end(design) == "b" else -1.0
    drawn = leave("turn", shims_turn(design), PartRole.SHIM) if bent else leave("y", far, PartRole.SHIM)
    shims = [drawn._replace(travel=sign * drawn.travel)] if drawn.parts else []
    plates = [leave("y", y, *END_PLATES, end=end) for end, y in zip(ENDS, (-far, far), strict=True)]
    plates = [step for step in plates if step.parts]
    lid = leave("z", high, PartRole.COVER, PartRole.COVER_PIN, PartRole.SEAL)
    steps = [*shims, lid, *plates] if bent else [*plates, *shims, lid]
    if not ridges:
        if closed.of(PartRole.BASE):
            steps.append(leave("z", -high, PartRole.BASE, PartRole.END_PIN, PartRole.BASE_PIN))
        standing = PartRole.BONE, PartRole.CORE_PIN, PartRole.BONE_SCREW
        out = (PartRole.SKIN, PartRole.CARRIER, *standing, PartRole.STRIP)
        steps.append(leave("z", high, *out))
        steps += [leave("z", high, PartRole.CAVITY)] if closed.of(PartRole.BLOCK) else []
        return replace(closed, opening=tuple(steps))
    steps.append(leave("z", -high, PartRole.BASE, PartRole.END_PIN, PartRole.BASE_PIN))
    pieces = zip(
        closed.of(PartRole.LEFT, PartRole.BETWEEN, PartRole.RIGHT), headings(design, ridges), strict=True
    )
    from_outside = sorted(pieces, key=lambda piece: (piece[0].role is PartRole.BETWEEN, abs(piece[1][0])))
    steps += [Move((part.name,), heading, high) for part, heading in from_outside]
    return replace(closed, opening=tuple(steps))


def _gang(place: Layout, parts: list[Part]) -> list[Part]:
    """The parts once for each skin; the first keep their names."""
    return [
        replace(
            part,
            name=part.name + (f"-{i}" if i > 1 else ""),
            body=moved(part.body, x),
            cuts=tuple(moved(cut, x) for cut in part.cuts),
            adds=tuple(moved(body, x) for body in part.adds),
        )
        for i, x in enumerate(place.centres, 1)
        for part in parts
    ]


def mold_solids(design: Design) -> dict[str, cq.Workplane]:
    """Return the exact solids of the parts that one makes or casts, by name, in the mold's frame, mm."""
    from skincad.solids.occ import workplane

    closed = mold(design)
    return {p.name: workplane(p) for p in (*closed.parts, *closed.plugs) if p.made != "bought"}


def _pins(design: Design, place: Layout) -> list[Part]:
    """Pins pressed into the cavity's ends and into the cover; they slide in end plates and cavity."""
    depth, thick = place.pin_depth, design.mold.end_plate
    starts = zip(ENDS, (-place.end - thick, place.end - depth), strict=True)
    pins = [
        pin(PartRole.END_PIN, f"pin-{end}-{side}", (x, y, place.comb_pin), depth + thick, end)
        for (side, x), (end, y) in product(zip(("left", "right"), place.pins, strict=True), starts)
    ]
    return [*pins, *cover_dowels(design, place)]
