"""The cavity, whole or in several pull pieces, and where it has to be split.

A parted cavity stands on a base plate. Each split runs from a crown's summit down that ridge's own axis. The
ridges fan out, so a piece between two splits widens downward: wedged between its neighbours, on the base and
between the end plates it can't move, and once the base is off it leaves down its own middle direction, past
flanks that lean away from it. The outer pieces leave half a pitch further outward. The price: a parting line
on the summit of each ridge that is split, where a flash has to be kept thin.

Where a cavity has to be split, because a ridge would be squeezed too much on its way out. Rubber keeps its
volume and the skin is long. So a ridge that passes an opening w out of its width W stretches upward by W / w
- 1, which is held against the elongation at break. Friction and bending are left out.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise, product

from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.curves import Loop, Point, Segment
from skincad.shape.skin import Section, section, skin_of
from skincad.solids.fasteners import blind_depth
from skincad.solids.inserts import pin
from skincad.solids.kind import kind_of
from skincad.solids.layout import (
    BASE_PIN,
    BOLT_RADIUS,
    EDGE,
    PIN_DEPTH,
    Layout,
    block_fits,
    block_process,
    cover_pins,
)
from skincad.solids.pins import cast, flank_end, on_plane, pins
from skincad.solids.pins import parted as parted_pin
from skincad.solids.plan import (
    Body,
    Bore,
    CutRole,
    Heading,
    Part,
    PartRole,
    Prism,
    TurnedBody,
    box,
    drilled,
    moved,
    shifted,
)
from skincad.solids.shrinkage import on_grid
from skincad.solids.split import path


def cavity(design: Design, shape: Section, place: Layout) -> Part:
    """Return the block with one trough for each skin: its negative, with its pins' holes, and the carrier's
    seat above it."""
    single = (*_rim(design, place, 1), *negative(shape.outline), *_rim(design, place, -1))
    lands = [shifted(single, x) for x in reversed(place.centres)]  # from right to left
    right = Point(place.half, place.bottom), Point(place.half, place.top)
    outline = path([*right, lands[0][0].start])
    for here, there in zip(lands, [*lands[1:], None], strict=True):
        outline += here
        outline += path([here[-1].end, there[0].start]) if there else []
    left = [Point(-place.half, place.top), Point(-place.half, place.bottom)]
    outline += path([outline[-1].end, *left, outline[0].start])
    holes, deep = block_fits(design), on_grid(blind_depth(place.lid, block_process(design)))
    cuts: tuple[Body, ...] = (
        *_along(place, place.lanes, (place.comb_bolt, place.keeper_bolt)),
        *_pin_holes(design, place),
        *drilled(CutRole.COVER_THREAD, "z", place.bolts, place.top - deep, deep, holes.thread),
        *_sockets(design, place, cover_pins(place)),
        *(moved(cast(pin, CutRole.FEATURE), x) for pin in pins(design, shape) for x in place.centres),
    )
    return Part("cavity", PartRole.CAVITY, Prism(tuple(outline), "y", -place.end, place.end), cuts)


def parted(outline: Loop, ridges: list[int]) -> Loop:
    """Return the section's outline with the crowns of these ridges cut in two at their summits, so that skin
    and pieces have the same corners there."""
    halved: list[Segment] = []
    for s in outline:
        if s.kind == "crown" and s.feature in ridges:
            middle, bulge = s.point(0.5), math.tan(s.sweep / 8)
            halved += [replace(s, end=middle, bulge=bulge), replace(s, start=middle, bulge=bulge)]
        else:
            halved.append(s)
    return tuple(halved)


def cavity_pieces(design: Design, shape: Section, place: Layout, ridges: list[int]) -> list[Part]:
    """Return base, outer pieces and the pieces between, from left to right. `shape` is parted at `ridges`."""
    level, half = base_level(design, shape, place), place.end
    chunks, summits = _chunks(shape.outline, ridges)
    feet = [_foot(design, ridge, s, level) for ridge, s in zip(reversed(ridges), summits, strict=True)]
    most = place.outer - BOLT_RADIUS - EDGE
    if max(abs(f.x) for f in feet) > most:
        rule = f"spreads the cavity's pieces to {max(abs(f.x) for f in feet):.4g} mm, beyond {most:.4g} mm"
        raise InputError(
            "skin.curvature_radius",
            rule,
            design.skin.curvature_radius,
            "make it larger, or take fewer ridges",
        )
    right = [Point(feet[0].x, level), Point(place.half, level), Point(place.half, place.top)]
    left = [Point(-place.half, place.top), Point(-place.half, level), feet[-1]]
    rims = _rim(design, place, 1), _rim(design, place, -1)
    outlines = [(*path([*right, rims[0][0].start]), *rims[0], *chunks[0], *path([summits[0], feet[0]]))]
    for i in range(1, len(summits)):
        sides = path([feet[i - 1], summits[i - 1]]), path([summits[i], feet[i], feet[i - 1]])
        outlines.append((*sides[0], *chunks[i], *sides[1]))
    outlines.append((*path([feet[-1], summits[-1]]), *chunks[-1], *rims[1], *path([rims[1][-1].end, *left])))
    first, *between, last = (Prism(outline, "y", -half, half) for outline in reversed(outlines))
    return [
        _base(design, place, level),
        Part("cavity-left", PartRole.LEFT, first, _wall_cuts(design, place, level, -1)),
        *(Part(f"cavity-{i}", PartRole.BETWEEN, body) for i, body in enumerate(between, 1)),
        Part("cavity-right", PartRole.RIGHT, last, _wall_cuts(design, place, level, 1)),
    ]


def cavity_plate(design: Design, shape: Section, place: Layout) -> list[Part]:
    """Return a base with the pins' tips as cups, and the plate on it, whose holes go through."""
    level = base_level(design, shape, place)
    whole = cavity(design, shape, place._replace(bottom=level))
    pieces = [
        parted_pin(cut, flank_end(pins(design, shape))) for cut in whole.cuts if isinstance(cut, TurnedBody)
    ]
    base = _base(design, place, level)
    walls = (*_wall_cuts(design, place, level, -1), *_wall_cuts(design, place, level, 1))
    return [
        replace(base, cuts=(*base.cuts, *(cup for _, cup in pieces))),
        replace(whole, name="cavity-plate", cuts=(*walls, *(hole for hole, _ in pieces))),
    ]


def headings(design: Design, ridges: list[int]) -> list[Heading]:
    """Return the direction (x, z) in which each piece leaves, from left to right."""
    skin = skin_of(design)
    leans = [skin.lean(ridge) for ridge in ridges]
    half_pitch = skin.pitch / (2 * design.skin.curvature_radius)
    middle = [(a + b) / 2 for a, b in pairwise(leans)]
    angles = [leans[0] - half_pitch, *middle, leans[-1] + half_pitch]
    return [(math.sin(angle), -math.cos(angle)) for angle in angles]


def base_dowels(design: Design, shape: Section, place: Layout) -> list[Part]:
    """Return the pins pressed into a split cavity's base, on which its outer pieces or its plate slide."""
    length, level = on_grid(2 * BASE_PIN - design.mold.clearance), base_level(design, shape, place)
    places = zip(("right", "left"), cover_pins(place), strict=True)
    return [
        pin(PartRole.BASE_PIN, f"pin-base-{side}", (x, y, level - BASE_PIN), length)
        for side, (x, y) in places
    ]


def _base(design: Design, place: Layout, level: float) -> Part:
    holes, through = block_fits(design), (place.bottom, level - place.bottom)
    cuts = (
        *_along(place, place.lanes, (place.comb_bolt,)),
        *_pin_holes(design, place),
        *drilled(CutRole.COVER_THREAD, "z", place.bolts, *through, holes.thread),
        *drilled(CutRole.BASE_PIN, "z", cover_pins(place), level - BASE_PIN, BASE_PIN, holes.press),
    )
    body = box(place.half, (-place.end, place.end), (place.bottom, level), "y")
    return Part("cavity-base", PartRole.BASE, body, cuts)


def _wall_cuts(design: Design, place: Layout, level: float, side: int) -> tuple[Body, ...]:
    slide = block_fits(design).slide
    bolts, pins = ([p for p in places if p[0] * side > 0] for places in (place.bolts, cover_pins(place)))
    lanes = tuple(x for x in place.lanes if x * side > 0)
    return (
        *_along(place, lanes, (place.keeper_bolt,)),
        *drilled(CutRole.COVER_BOLT, "z", bolts, level, place.top - level, BOLT_RADIUS),
        *drilled(CutRole.BASE_PIN, "z", pins, level, BASE_PIN, slide),
        *_sockets(design, place, pins),
    )


def base_level(design: Design, shape: Section, place: Layout) -> float:
    """Return the height of a split cavity's base, mm: where the flanks of the shortest pins end, or over the
    lower bolts."""
    if cast_pins := pins(design, shape):
        return -(cast_pins[0].origin[2] + flank_end(cast_pins))
    return on_grid(place.comb_bolt + BOLT_RADIUS + EDGE)


def _foot(design: Design, ridge: int, summit: Point, level: float) -> Point:
    """Where a ridge's axis from its summit meets the base."""
    return Point(summit.x + (summit.z - level) * math.tan(skin_of(design).lean(ridge)), level)


def _chunks(outline: Loop, ridges: list[int]) -> tuple[list[Loop], list[Point]]:
    """The negative from right to left, cut at the summits of these ridges, and the summits."""
    edge = negative(outline)
    cuts = []
    for ridge in reversed(ridges):
        crown = [i for i, s in enumerate(edge) if s.feature == ridge]
        cuts.append(crown[len(crown) // 2])
    ends = [0, *cuts, len(edge)]
    chunks = [edge[a:b] for a, b in pairwise(ends)]
    return chunks, [edge[i].start for i in cuts]


def negative(outline: Loop) -> Loop:
    """The section's outline but its back, upside down, from right to left, the cavity on its left."""
    return tuple(
        replace(s, start=Point(s.start.x, -s.start.z), end=Point(s.end.x, -s.end.z), bulge=-s.bulge)
        for s in outline
        if s.kind != "back"
    )


def _rim(design: Design, place: Layout, side: int) -> Loop:
    """The carrier's seat on one side: from the top down at the right, up at the left."""
    points = [
        Point(side * place.trough, place.top),
        Point(side * place.trough, 0.0),
        Point(side * design.skin.width / 2, 0.0),
    ]
    return tuple(path(points if side > 0 else points[::-1]))


def _along(place: Layout, lanes: tuple[float, ...], heights: tuple[float, ...]) -> list[Bore]:
    return drilled(CutRole.END_BOLT, "y", product(lanes, heights), -place.end, 2 * place.end, BOLT_RADIUS)


def _pin_holes(design: Design, place: Layout) -> list[Bore]:
    press, depth = block_fits(design).press, place.pin_depth
    ends = (-place.end, place.end - depth)
    return [
        Bore((x, y, place.comb_pin), "y", depth, press, role=CutRole.END_PIN)
        for x in place.pins
        for y in ends
    ]


def _sockets(design: Design, place: Layout, places: list[tuple[float, float]]) -> list[Bore]:
    slide = block_fits(design).slide
    return drilled(CutRole.COVER_PIN, "z", places, place.top - PIN_DEPTH, PIN_DEPTH, slide)


SAFE_SHARE = 0.2  # assumption: a cast edge has nicks, from which it tears long before a test bar does


def safe_strain(design: Design) -> float:
    """Return the nominal squeeze that the silicone takes: its stretch is `SAFE_SHARE` of that at break."""
    return 1 - 1 / (1 + SAFE_SHARE * silicone(design).elongation_at_break)


def parts_at_tips(design: Design) -> bool:
    """Whether the cavity of pins is a plate of through holes on a base of cups: with split = "tips", or
    "auto" where a tool makes the holes, and they stand on a plane."""
    if design.mold.split == "none" or skin_of(design).form.parting != "tips":
        return False
    plane = on_plane(design, section(design)) and kind_of(design).ends and design.mold.cavities == 1
    return design.mold.split == "tips" or (plane and block_process(design).layer == 0)


def split_ridges(design: Design) -> list[int]:
    """Return the ridges at which the cavity is parted: with split = "auto" those that are squeezed beyond
    what is safe, and their mirror images, so that the pieces between come out straight."""
    if design.mold.split == "none" or skin_of(design).form.parting != "flanks":
        return []
    skin, limit = skin_of(design), safe_strain(design)
    caught = [ridge for ridge, undercut in skin.undercuts.items() if undercut.strain > limit]
    return sorted({*caught, *(skin.count + 1 - ridge for ridge in caught)})
