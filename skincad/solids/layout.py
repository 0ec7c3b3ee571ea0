"""Where the mold's screws, pins and seats lie: positions that several parts share.

Screws run along y through both end plates (a lane in each wall, nearest the trough) and down z from the cover
(the outer lane), so no two bores meet. Those along y end in hexagonal nut pockets of end plate b where it is
printed, in tapped holes where it is cut from metal; the cover's end in the cavity, in a tapped hole or in a
threaded insert, so that the floor stays flat and closed. A pocket from below would be an overhang in print.
Pins press into one part and slide in the other: both fits are the process's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from skincad.catalog import processes
from skincad.curves import Point, loop
from skincad.design import Design
from skincad.errors import InputError
from skincad.process import Process
from skincad.section import Section
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.plan import Prism
from skincad.solids.shrinkage import on_grid
from skincad.solids.split import split_height

BOLT_RADIUS = 1.7  # mm, source: ISO 273 clearance hole for M3, medium series
TAP_RADIUS = 1.25  # mm, source: ISO 2306, drill before tapping M3
INSERT_RADIUS = 2.0  # mm, source: makers' tables, hole for a threaded M3 insert, 3.9 to 4.2 mm wide
THREAD = 6.0  # mm, assumption: two diameters of thread hold in anything; inserts are up to 5.7 mm long
NUT_FLATS = 5.5  # mm, source: ISO 4032, M3, width across flats
NUT_DEPTH = 2.75  # mm: ISO 4032 has 2.4 mm high M3 nuts; the rest is an assumption
NUT_PLAY = 0.1  # mm, assumption: least gap a side of a nut in its pocket
PRESS_SHARE = 0.25  # assumption: of a print's sliding clearance, for a pin pressed into it; metal is reamed
EDGE = 1.2  # mm, assumption: least material between two bores, or a bore and an edge
BESIDE = 0.8  # mm, assumption: least of a keeper over and under its bolts and nuts
LEDGE = 2.0  # mm, assumption: width of the seat on which the carrier seals the skin's back
PIN_DEPTH = 6.0  # mm, assumption: three diameters of a pin hold it
KEYING = 0.5  # mm, assumption: one pin stands aside by this and two clearances: the cover fits one way only


class Fits(NamedTuple):
    """Radii of the holes of one part, mm: for a pin that slides, a pin pressed in, and an M3 thread."""

    slide: float
    press: float
    thread: float
    printed: bool


class Layout(NamedTuple):
    """Positions that several parts share, mm. The skins of a gang lie side by side along x at `centres`."""

    centres: tuple[float, ...]
    half: float  # block, along x
    end: float  # cavity's y end
    bottom: float
    top: float
    trough: float  # half width of the carrier's seat
    lanes: tuple[float, ...]  # x of the bolts along y
    pins: tuple[float, float]  # x of the end plates' pins
    outer: float  # x of the bolts along z
    along: float  # y of the bolts along z
    pin_along: float  # y of the pins along z
    pin_depth: float  # of the end plates' pins in the cavity
    cover: float  # the cover's y end
    split: float  # height of the split at the bolts
    comb_bolt: float
    comb_pin: float
    keeper_bolt: float
    keying: tuple[float, float]  # (x, y) by which one of the cover's pins stands aside
    nut: float  # half width of a nut's pocket across its flats


def fits(design: Design, name: str | None) -> Fits:
    """Return the holes of a part that a process makes; None is any process, which keeps the design's gap."""
    process: Process | None = processes(design.printer)[name] if name else None
    gap = max(design.mold.clearance, process.clearance if process else 0.0)
    printed = process is not None and process.layer > 0
    press = PIN_RADIUS + (PRESS_SHARE * gap if printed else 0.0)
    return Fits(PIN_RADIUS + gap, press, INSERT_RADIUS if printed else TAP_RADIUS, printed)


def end_fits(design: Design) -> Fits:
    """Return the fits of the end plates' process."""
    return fits(design, design.mold.end_plate_process or design.mold.process)


def layout(design: Design, shape: Section) -> Layout:
    """Return the positions; raises InputError where a bore finds no room. `design` is what is poured."""
    skin, choice, ends = design.skin, design.mold, end_fits(design)
    slide = max(ends.slide, fits(design, choice.process).slide)
    nut = NUT_FLATS / 2 + max(NUT_PLAY, ends.slide - PIN_RADIUS)
    aside = 2 / math.sqrt(3) * nut + EDGE + slide  # of a pin beside a nut's corner
    trough = skin.width / 2 + LEDGE + choice.clearance
    inner = max(trough + EDGE + BOLT_RADIUS, aside + slide + EDGE / 2)
    outer = inner + EDGE + 2 * BOLT_RADIUS
    if skin.curvature_radius_y is not None:  # screws into threads beside the cover's, which may be inserts
        outer += max(0.0, fits(design, choice.process).thread - BOLT_RADIUS)
    need = outer + BOLT_RADIUS + EDGE - skin.width / 2
    at_least("mold.wall", choice.wall, need, "two rows of bolts beside the trough")
    at_least("skin.length", skin.length, 9.0, "bolts and pins of a mold")
    top, bottom = choice.carrier_thickness, on_grid(-shape.top) - choice.floor
    split = -split_height(design, shape)[1]
    depth = on_grid(min(PIN_DEPTH, 0.4 * skin.length))
    bolt = bottom + EDGE + nut
    at_least("mold.floor", split - bottom, 2 * (nut + EDGE), "bolt, nut and pin of a comb")
    room = top - bevel(design) - split
    at_least("mold.carrier_thickness", room, 2 * (BOLT_RADIUS + BESIDE), "the bolts of the keeper")
    apart = trough + EDGE + BOLT_RADIUS  # of a middle and the lane in the wall beside it
    count = choice.cavities
    centres = tuple((2 * i + 1 - count) * apart for i in range(count))
    between = [(2 * i - count) * apart for i in range(1, count)]
    far = centres[-1]
    return Layout(
        centres=centres,
        half=far + skin.width / 2 + choice.wall,
        end=skin.length / 2,
        bottom=bottom,
        top=top,
        trough=trough,
        lanes=(-far - inner, *between, far + inner),
        pins=(-far - inner + aside, far + inner - aside),
        outer=far + outer,
        along=max(2.0, skin.length / 4),
        pin_along=max(2.0, skin.length / 4),
        pin_depth=depth,
        cover=skin.length / 2 + choice.end_plate,
        split=split,
        comb_bolt=bolt,
        comb_pin=bolt,
        keeper_bolt=(split + top - bevel(design)) / 2,
        keying=(0.0, KEYING + 2 * (slide - PIN_RADIUS)),
        nut=nut,
    )


def end_angle(design: Design) -> float:
    """Return the angle by which an end plate of a doubly curved mold leans, rad; 0 where it is upright."""
    radius = design.skin.curvature_radius_y
    return 0.0 if radius is None else design.skin.length / 2 / radius


def bevel(design: Design) -> float:
    """Return by how much a leaning end plate is lower at its outer face than at its inner one, mm."""
    return design.mold.end_plate * math.tan(end_angle(design))


def at_least(key: str, given: float, need: float, what: str) -> None:
    """Raise InputError where a key leaves less room than is needed."""
    if given < need:
        raise InputError(
            key, f"leaves {given:.4g} mm for {what}, which need {need:.4g} mm", remedy="enlarge it"
        )


def cover_bolts(place: Layout) -> list[tuple[float, float]]:
    """Return (x, y) of the cover's bolts, on one diagonal."""
    return [(place.outer, place.along), (-place.outer, -place.along)]


def cover_pins(place: Layout) -> list[tuple[float, float]]:
    """Return (x, y) of the cover's pins, on the other diagonal, one aside."""
    aside, along = place.keying
    return [(place.outer, -place.pin_along), (aside - place.outer, place.pin_along - along)]


def nut_pocket(place: Layout, x: float, z: float, low: float, high: float) -> Prism:
    """Return a nut's pocket along y about (x, z), two of its flats level."""
    corner = 2 / math.sqrt(3) * place.nut
    turns = [math.radians(60 * i) for i in range(6)]
    points = [Point(x + corner * math.cos(a), z + corner * math.sin(a)) for a in turns]
    return Prism(loop(points), "y", low, high)
