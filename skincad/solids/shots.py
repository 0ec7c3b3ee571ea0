"""Shots: the layers that a skin is cast in, and the plugs that keep the room of those that come later.

The layer in front is poured first, into the cavity with its shims. A plug lies in the carrier's place
meanwhile, with the negative of all that is poured behind that layer; it lifts straight off. The last plug is
the thinnest. At last the carrier goes on, over the layer at the back. A shot that is laid wet on wet needs no
plug: its face is level, and what is poured before it is weighed. The mold of a doubly curved skin is closed
over each plug, and each layer comes in through a gate of its own.

A plug is one clearance smaller than the trough all round, through which air leaves; its vent lies under the
cover's cup. Rivets are pegs on a plug that widen from it: silicone stretches over their heads as the plug
is pulled, and the shot behind fills the holes that they leave.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.inputs.guards import face_heights, shoulder
from skincad.inputs.material import layers, silicone
from skincad.inputs.skin_tables import Shot
from skincad.shape.curves import Loop, Point, Segment, flipped, polygon, right_half
from skincad.shape.shots import face, heights
from skincad.shape.skin import Section
from skincad.solids.bone import cut_of
from skincad.solids.kind import kind_of
from skincad.solids.layout import EDGE, Layout, ends_rise
from skincad.solids.lids import core_bores, core_pins, openings, pull_threads, vent_bore
from skincad.solids.pins import over_disc, pocket_cuts, pockets
from skincad.solids.plan import Body, Bore, ExtendedCut, Part, PartRole, Prism, RevolvedBody, TurnedBody, disc
from skincad.solids.skin import along_skin
from skincad.solids.split import path

NECK, HEAD_SHARE = 0.5, 0.25  # mm, assumption: radius of a rivet's neck, and by which its head is wider
DEEP, LEAST_DEEP = 1.5, 0.6  # mm, assumption: how far a rivet reaches into the layer in front, and at least
WEB = 0.3  # mm, assumption: least silicone between a rivet and a slot or the skin's face
LEAST_LAYER = 0.5  # mm, assumption: a thinner one tears as a plug is pulled, and its air stays
SAFE_SHARE = 0.2  # of the elongation at break, as the undercut rule has it (cavity.py)
SUNK = 0.2  # mm, by which what is added to a plug goes into it
CHORD = 1e-3  # mm, of faces and outlines that distances are measured to


def behind(design: Design, number: int) -> Prism | RevolvedBody | TurnedBody:
    """Return what of a skin lies behind the face of shot `number`, in the design's frame."""
    half = design.skin.width / 2
    line = face(design, number, half)
    outline = (*path([Point(-half, 0.0), Point(half, 0.0), line[0].start]), *line)
    outline = (*outline, Segment(line[0].end, Point(-half, 0.0)))
    return along_skin(design, outline, ())


def room(design: Design, number: int) -> Part:
    """Return what is cast behind the face of shot `number`: without pockets and a bone."""
    cuts = (*pocket_cuts(design, number=number), *cut_of(design))
    return Part(f"shot-{number}", PartRole.SKIN, behind(design, number), cuts)


def _passes(design: Design, number: int, pocket: Bore) -> bool:
    """Whether a pocket goes through a shot's face."""
    return pocket.length > over_disc(design, number, pocket.start[:2], pocket.radius)[0]


def bond_of(shot: Shot) -> str:
    """Return how a shot is bound to the layer in front of it."""
    return shot.bond or "primer"


def plugged(design: Design) -> list[int]:
    """Return the numbers of the shots whose room a plug keeps, in the order in which plugs are used."""
    shots = design.shot or ()
    return [number for number in range(len(shots), 0, -1) if bond_of(shots[number - 1]) != "wet"]


class Blank(NamedTuple):
    """A plug without bores and pegs: its plate with what is under it, or both in one body; by how much its
    vent stands further in than the carrier's, mm; and the section that rules judge, where it is bent."""

    body: Prism
    adds: tuple[TurnedBody | RevolvedBody, ...] = ()
    inset: float = 0.0
    straight: Prism | None = None


def plugs(
    design: Design, shape: Section, place: Layout, blank: Callable[[Design, Layout, int], Blank]
) -> list[list[Part]]:
    """Return the plugs, ridges down as the mold has them, each with the core pins that stand in it; `design`
    is what is poured, `place` the layout as the lids see it, `blank` gives a plug's by its shot. Raises
    InputError where rivets find no room."""
    deep = {number: [_passes(design, number, bore) for bore in pockets(design)] for number in plugged(design)}
    return [
        [
            _plug(design, shape, place, number, blank(design, place, number)),
            *(core_pins(design, place) if any(passing) else ()),
        ]
        for number, passing in deep.items()
    ]


def _plug(design: Design, shape: Section, place: Layout, number: int, blank: Blank) -> Part:
    """A plate on the carrier's ledge with the shots' negative under it. Core pins of pockets that go through
    the shot's face stand in it as they do in the carrier."""
    adds = (*blank.adds, *_rivets(design, shape, place, number))
    vent, cup = vent_bore(design, place), openings(design, place).cup
    x, y, z = vent.start
    vent = replace(vent, start=(x, y - blank.inset, z))
    passing = [_passes(design, number, pocket) for pocket in pockets(design)]
    cores = [core for core, deep in zip(core_bores(design, place), passing, strict=False) if deep]
    filled = [(vent.start, vent.radius), (cup.start, cup.radius)]
    filled += [(core.start, core.radius + EDGE / 2) for core in cores]
    through = (_through(design, number, bore) for bore in (vent, *cores))
    cuts: tuple[Body, ...] = (*through, *pull_threads(design, place, filled))
    name, role, alike = f"plug-{number}", PartRole.PLUG, blank.straight
    return Part(name, role, blank.body, cuts, adds=adds, straight=Part(name, role, alike) if alike else None)


def straight_blank(design: Design, place: Layout, number: int) -> Blank:
    """Return a straight plug's plate and what is under it, in one section."""
    gap = design.mold.clearance
    wide, half = place.trough - gap, design.skin.width / 2 - gap
    rim = [Point(half, 0.0), Point(wide, 0.0), Point(wide, place.back)]
    rim += [Point(-wide, place.back), Point(-wide, 0.0), Point(-half, 0.0)]
    return Blank(Prism(under(design, number, rim), "y", gap - place.end, place.end - gap))


def round_blank(design: Design, place: Layout, number: int) -> Blank:
    """Return a round plug's disc, and what is under it; the carrier's vent is at the very rim."""
    gap = design.mold.clearance
    half = design.skin.width / 2 - gap
    sunk = flipped(under(design, number, [Point(half, SUNK), Point(-half, SUNK)]))
    buried = math.pi * half**2 * SUNK
    core = TurnedBody(right_half(sunk), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), buried)
    return Blank(disc(place.trough - gap, 0.0, place.back), (core,), gap + EDGE / 2)


def under(design: Design, number: int, rim: list[Point]) -> Loop:
    """Return what is under a plug's plate, ridges down: the shot's face, and a `rim` from right to left."""
    (line,) = face(design, number, rim[0].x)
    low = Segment(Point(line.end.x, -line.end.z), Point(line.start.x, -line.start.z), line.bulge)
    return (low, *path([low.end, *rim, low.start]))


def _at(at: tuple[float, float]) -> tuple[Array, Array]:
    return np.array([at[0]]), np.array([at[1]])


def _through(design: Design, number: int, bore: Bore) -> ExtendedCut:
    """A bore of the carrier, from a shot's face up. It is built from below that face, whatever its curve, to
    above the plug: at the same height a film of rounding would stay."""
    mean, top, _ = over_disc(design, number, bore.start[:2], bore.radius)
    counts = replace(bore, start=(*bore.start[:2], -mean), length=bore.length + mean)
    low = top + SUNK
    return ExtendedCut(counts, replace(bore, start=(*bore.start[:2], -low), length=bore.length + low + SUNK))


def _rivets(design: Design, shape: Section, place: Layout, number: int) -> Iterator[TurnedBody]:
    """Pegs on a plug that widen away from it. Raises InputError where none has room."""
    shots = design.shot or ()
    if bond_of(shots[number - 1]) != "rivets":
        return
    in_front = silicone(design) if number == len(shots) else layers(design)[number]
    head = NECK * (1 + min(HEAD_SHARE, SAFE_SHARE * in_front.elongation_at_break))
    room = _room_in_front(design, shape, number)
    found = 0
    for x, y in openings(design, place).rivets:
        across = kind_of(design).apart(x, y)[0]
        deep = next((d for d in np.arange(DEEP, LEAST_DEEP - 1e-9, -0.1).tolist() if room(across, d)), None)
        if deep is not None:
            found += 1
            yield _peg(design, number, (x, y), deep, head)
    if not found:
        rule = f"'rivets' need {LEAST_DEEP + WEB:g} mm of the layer in front, clear of slots"
        remedy = "take 'primer', a thicker layer in front, or mold.carrier = 'perforated'"
        raise InputError("shot.bond", rule, number, remedy)


def _room_in_front(design: Design, shape: Section, number: int) -> Callable[[float, float], bool]:
    """A function that says whether a rivet of some depth, mm, has room at a distance across."""
    half, count = design.skin.width / 2, len(design.shot or ())
    front = shapely.Polygon(polygon(shape.outline, CHORD))
    if number < count:
        front = shapely.Polygon(polygon(behind(design, number + 1).outline, CHORD))
    slots = shapely.MultiPolygon([shapely.Polygon(polygon(slot.loop(), CHORD)) for slot in shape.slots])

    def fits(across: float, deep: float) -> bool:
        low = float(heights(design, number, *_at((across, 0.0)))[0])
        peg = shapely.box(across - NECK, low, across + NECK, low + deep).buffer(WEB)
        inside = shapely.box(-half, -WEB, half, low + deep + WEB).contains(peg) and front.contains(
            peg.intersection(shapely.box(-half, low, half, 1e6))
        )
        return bool(inside and not peg.intersects(slots))

    return fits


def _peg(design: Design, number: int, at: tuple[float, float], deep: float, head: float) -> TurnedBody:
    """A peg from inside a plug down: a cylinder as far as the face's curve goes, then a cone to its head."""
    mean, top, _ = over_disc(design, number, at, NECK)
    level = float(heights(design, number, *_at(at))[0])
    sunk, out = SUNK + level - mean, max(0.05, top - level + 0.02)
    corners = [Point(0.0, -sunk), Point(NECK, -sunk), Point(NECK, out), Point(head, deep), Point(0.0, deep)]
    outline = tuple(path([*corners, corners[0]]))
    buried = math.pi * NECK**2 * (sunk + mean - level)
    return TurnedBody(outline, (*at, -level), (0.0, 0.0, -1.0), buried)


def check_shots(design: Design) -> Iterator[InputError]:
    """Yield an error for each thing that a mold can't do for a skin's layers; none for a skin of one."""
    shots = design.shot or ()
    if not shots:
        return
    rise = ends_rise(design)
    if rise == 0.0 and (design.mold.pour == "syringe" or design.mold.gate is not None):
        key, value = ("mold.pour", design.mold.pour) if design.mold.pour else ("mold.gate", design.mold.gate)
        rule = "must not be given with [[shot]], whose layers are poured one by one into the open mold"
        yield InputError(key, rule, value, "leave it out")
    if rise > 0.0 and any(bond_of(shot) == "wet" for shot in shots):
        rule = "must not be 'wet' in a doubly curved skin: a liquid's face is level, and this one rises by "
        rule += f"{rise:.3g} mm to the ends"
        yield InputError("shot.bond", rule, "wet", "take 'primer' or 'rivets'")
    below, key, value = (0.0, 0.0), "", None
    for number, shot in enumerate(shots, 1):
        key, value = ("thickness", shot.thickness) if shot.depth is None else ("depth", shot.depth)
        middle, _ = face_heights(design.skin, shot)
        side = face(design, number, design.skin.width / 2)[0].start.z
        if min(side - below[1], middle - below[0]) < LEAST_LAYER:
            rule = f"leaves shot {number} less than {LEAST_LAYER:g} mm: it tears as it is cast or pulled"
            yield InputError(f"shot.{key}", rule, value, "a thicker layer")
        below = middle, side
    if min(shoulder(design.skin) - below[1], design.skin.thickness - below[0]) < LEAST_LAYER:
        rule = f"leaves less than {LEAST_LAYER:g} mm of the layer in front, which tears as its plug is pulled"
        yield InputError(f"shot.{key}", rule, value, "a thicker layer in front")
    for number in range(1, len(shots) + 1):
        for pocket in pockets(design):
            mean, top, _ = over_disc(design, number, pocket.start[:2], pocket.radius)
            low = 2 * mean - top
            if low - LEAST_LAYER < pocket.length < top + LEAST_LAYER:
                rule = f"must end {LEAST_LAYER:g} mm before or beyond shot {number}'s face, at {mean:.4g} mm"
                key = f"{design.features.family}.pocket.depth"
                yield InputError(key, rule, pocket.length, "another depth, or another thickness of the shot")
                break
