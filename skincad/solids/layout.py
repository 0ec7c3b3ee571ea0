"""Where the mold's screws, pins and seats lie, and how it is closed.

The cover as a plate: how many screws hold it, how thick it is, and how far it bows between them. A filled
mold pushes its cover up over its carriers. The cover is a plate on rows of screws: across (x) it spans from
row to row, along (y) from screw to screw. As in a flat slab each way carries the whole load (Nichols, Trans.
ASCE 77, 1914), so both bows add: for a square plate on its four corners 2 x 5/384 q a4 / D, 0.0260, where the
plate's exact solution has 0.0257 (Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, section 47).
Without the walls' support and the plate's Poisson ratio it is on the safe side.

Screws run along y through both end plates (a lane in each wall, nearest the trough) and down z from the cover
(the outer lane), so no two bores meet. Those along y end in hexagonal nut pockets of end plate b where it is
printed, in tapped holes where it is cut from metal; the cover's end in the cavity, in a tapped hole or in a
threaded insert, so that the floor stays flat and closed. A pocket from below would be an overhang in print.
A round skin's mold has no end plates: its block is square, with one row of screws a side.
Pins press into one part and slide in the other: both fits are the process's. On a skin too short for bolts
and pins side by side the cover has its pins alone, and clamps hold it down.

What the design leaves to the mold, its wall, floor and carrier's thickness, is a plain value where bolts and
pins find room in it, and what they need where they don't.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.inputs.process import Process, processes
from skincad.shape.curves import Point, loop
from skincad.shape.skin import Section, summit
from skincad.solids.fasteners import TAP_RADIUS, blind_depth, insert_radius, least_thickness
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.kind import STRAIGHT, kind_of
from skincad.solids.pins import flank_end, pins
from skincad.solids.plan import CutRole, Prism
from skincad.solids.shrinkage import on_grid, shrinkage
from skincad.solids.split import split_height

PRESSURE = 0.01  # MPa, assumption: 10 kPa, a syringe pushed by hand after the mold is full
SHEETS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0)  # mm, assumption: as closed-cell foam is sold
SQUEEZED_SHARE = 0.7  # assumption: of a sheet's thickness, under the cover; by 0.5 to 0.9 it seals
SEAL_PLAY = 0.2  # of its thickness, that follows from it, up and down
# MPa, source: makers' data sheets, EVA foam of 100 kg/m3 squeezed by 30 %; at 10 % it is 0.02
SEAL_PRESSURE = 0.06
MOST_BOW = 0.02  # mm, assumption: what the cover may bow under it; a flash as thin is wiped off
LEAST_COVER = 4.0  # mm, assumption: least thickness, for its pins and the cup
TWIST_REACH = 2.6  # of the skin's length, by finite elements: a gang's cover twists on rows of one screw each
THICKEST = 50.0  # mm, that of mold.cover


class Spans(NamedTuple):
    """What a cover spans, mm: from row to row across, how wide its load is there, and its reach along: from
    screw to screw, or twice what stands over the last one."""

    row_distance: float
    load: float
    along: float


def bow(spans: Spans, thickness: float, modulus: float, pressure: float = PRESSURE) -> float:
    """Return how far a cover bows, mm: two simply supported beams' bows, across under a load in the middle,
    along under its whole one (handbooks). A cantilever bows less than a beam twice as long."""
    a, c, b = spans
    rigid = 384 * modulus * thickness**3 / 12  # N mm2 a mm of width
    return pressure * (c * (8 * a**3 - 4 * a * c**2 + c**3) + 5 * b**4) / rigid


def thick_enough(spans: Spans, modulus: float, stock: float) -> float:
    """Return the least thickness from `LEAST_COVER` on, in steps of `stock` mm, that keeps to `MOST_BOW`."""
    need = LEAST_COVER * max(1.0, math.cbrt(bow(spans, LEAST_COVER, modulus) / MOST_BOW))
    return min(THICKEST, math.ceil(need / stock - 1e-9) * stock)


class ScrewRow(NamedTuple):
    """A row of screws along y: how many, how far apart, mm, and their reach, as in `Spans`."""

    screws: int
    spacing: float
    reach: float


def screw_rows(
    length: float, diagonal: float, end_distance: float, least_spacing: float, skins: int = 1
) -> list[ScrewRow]:
    """Return the rows that a cover of this length can have, the fewest screws first. One in each row, the
    outer ones' at `diagonal` mm from the middle, opposite a pin; or more, `aside` mm from the ends and at
    least `beside` from each other, where a pin stands between two."""
    choices = [ScrewRow(1, 0.0, length + 2 * diagonal if skins == 1 else TWIST_REACH * length)]
    last = length / 2 - end_distance
    count = 2
    while last > 0 and (spacing := 2 * last / (count - 1)) >= least_spacing:
        choices.append(ScrewRow(count, spacing, max(spacing, 2 * end_distance)))
        count += 1
    return choices


def choose_screws(
    choices: list[ScrewRow],
    row_distance: float,
    load: float,
    modulus: float,
    thickness: float | None,
    stock: float,
) -> tuple[ScrewRow, float]:
    """Return the row of fewest screws and the cover's thickness, mm, with which it keeps to
    `MOST_BOW`; a given thickness is kept, whatever its bow."""
    least = thickness or thick_enough(Spans(row_distance, load, 0.0), modulus, stock)
    for row in choices:
        if bow(Spans(row_distance, load, row.reach), least, modulus) <= MOST_BOW:
            return row, least
    row = min(choices, key=lambda choice: choice.reach)
    return row, thickness or thick_enough(Spans(row_distance, load, row.reach), modulus, stock)


def seal_thickness(stack: float) -> float:
    """Return the thickness of the foam sheet that stays squeezed by 10 to 50 % where what it lies on is up to
    `stack` mm higher or lower; the thickest there is where none does."""
    return next((sheet for sheet in SHEETS if SEAL_PLAY * sheet >= stack - 1e-9), SHEETS[-1])


BOLT_RADIUS = 1.7  # mm, source: ISO 273 clearance hole for M3, medium series
NUT_FLATS = 5.5  # mm, source: ISO 4032, M3, width across flats
NUT_DEPTH = 2.75  # mm: ISO 4032 has 2.4 mm high M3 nuts; the rest is an assumption
NUT_PLAY = 0.1  # mm, assumption: least gap a side of a nut in its pocket
# mm a side, by which a hole is smaller than the pin that is pressed into it. Metal: source: ISO 286-2, P7 of
# a hole of 2 mm is 0.006 to 0.016 below; a reamer of 1.99 makes it. Print, assumption: it is reamed to 2 mm
PRESS_METAL, PRESS_PRINT = 0.005, 0.1
EDGE = 1.2  # mm, assumption: least material between two bores, or a bore and an edge
BESIDE = 0.8  # mm, assumption: least of a keeper over and under its bolts and nuts
LEDGE = 2.0  # mm, assumption: width of the seat on which the carrier seals the skin's back
PIN_DEPTH = 6.0  # mm, assumption: three diameters of a pin hold it
FOOT = 1.0  # mm, assumption: least of a split cavity's piece under the deepest ridge, to be held by
BASE_PIN = 3.0  # mm, assumption: of a pin in a split cavity's base, and as much in the piece on it
WALL, FLOOR, CARRIER = 13.0, 9.0, 4.0  # mm, assumption: where bolts and pins find room in them
STOCK = 0.5  # mm, assumption: what is computed goes up to a multiple of this, as plates are sold
ROUND_DOWN = 0.05  # mm, assumption: by which a wall or a ledge may be thinner than asked for a round size
OVERHANG = 3.0  # mm, assumption: of the cover beyond the block or the end plates, to be lifted by
LEAST_BOLTED = 9.0  # mm, assumption: length of a skin whose cover has bolts; a shorter one's is clamped
KEYING = 0.5  # mm, assumption: one pin stands aside by this and two clearances: the cover fits one way only


class Fits(NamedTuple):
    """Radii of the holes of one part, mm: for a pin that slides, a pin pressed in, and an M3 thread."""

    slide: float
    press: float
    thread: float
    insert: str  # how an insert is set into that, "" where it is tapped
    printed: bool


class Layout(NamedTuple):
    """Positions that several parts share, mm. The skins of a gang lie side by side along x at `centres`."""

    centres: tuple[float, ...]
    half: float  # block, along x
    end: float  # cavity's y end
    bottom: float
    back: float  # top of carrier and end plates
    top: float  # of the cavity, on which the cover lies; a seal is squeezed between
    trough: float  # half width of the carrier's seat
    lanes: tuple[float, ...]  # x of the bolts along y
    pins: tuple[float, float]  # x of the end plates' pins
    outer: float  # x of the bolts along z
    bolts: tuple[tuple[float, float], ...]  # (x, y) of those along z; none where the cover is clamped
    pin_along: float  # y of the pins along z
    pin_depth: float  # of the end plates' pins in the cavity
    cover: float  # the cover's y end
    lid: float  # its thickness
    spans: Spans  # what it spans
    split: float  # height of the split at the bolts
    comb_bolt: float
    comb_pin: float
    keeper_bolt: float
    keying: tuple[float, float]  # (x, y) by which one of the cover's pins stands aside
    nut: float  # half width of a nut's pocket across its flats


def fits(design: Design, name: str) -> Fits:
    """Return the holes of a part that a process makes."""
    process = processes(design.printer)[name]
    gap, printed = max(design.mold.clearance, process.clearance), process.layer > 0
    press = PIN_RADIUS - (PRESS_PRINT if printed else PRESS_METAL)
    insert = "" if process.thread == "tapped" else process.thread
    hole = insert_radius("M3", insert) if insert else TAP_RADIUS
    return Fits(PIN_RADIUS + gap, press, hole, insert, printed)


def end_process(design: Design) -> Process:
    """Return the process of the end plates."""
    return processes(design.printer)[design.mold.end_plate_process or design.mold.process]


def end_fits(design: Design) -> Fits:
    """Return the fits of the end plates' process."""
    return fits(design, design.mold.end_plate_process or design.mold.process)


def block_process(design: Design) -> Process:
    """Return the process of the block: the cavity's, if this is not a disc in it."""
    return processes(design.printer)[design.mold.block_process or design.mold.process]


def block_fits(design: Design) -> Fits:
    """Return the fits of the block."""
    return fits(design, design.mold.block_process or design.mold.process)


def lid_process(design: Design) -> Process:
    """Return the process of carrier and cover."""
    return processes(design.printer)[design.mold.lid_process or design.mold.process]


def layout(design: Design, shape: Section, *, split_cavity: bool = False) -> tuple[Layout, list[InputError]]:
    """Return the positions, and an error for every value that leaves a bore no room. `design` is what is
    poured."""
    skin, choice, ends = design.skin, design.mold, end_fits(design)
    slide = max(ends.slide, block_fits(design).slide)
    nut = NUT_FLATS / 2 + max(NUT_PLAY, ends.slide - PIN_RADIUS)
    pin_offset = 2 / math.sqrt(3) * nut + EDGE + slide  # of a pin beside a nut's corner
    trough = _rounded_up(skin.width + 2 * LEDGE) / 2 + choice.clearance
    inner = max(trough + EDGE + BOLT_RADIUS, pin_offset + slide + EDGE / 2)
    widest = max(BOLT_RADIUS, block_fits(design).thread)  # of the cover's row: it may have inserts
    kind = kind_of(design)
    plates = kind.ends
    outer = inner + EDGE + BOLT_RADIUS + widest if plates else trough + EDGE + widest
    count, short = choice.cavities, is_clamped(design)
    row_offset = BOLT_RADIUS + EDGE / 2  # of a row along z and the lane beside it, from the middle of a land
    half_pitch = trough + EDGE + BOLT_RADIUS + (row_offset if count > 1 else 0.0)
    centres = tuple((2 * i + 1 - count) * half_pitch for i in range(count))
    between = [(2 * i - count) * half_pitch for i in range(1, count)]
    outer, inner = outer + centres[-1], inner + centres[-1]
    row_places = (-outer, *(x + row_offset for x in between), outer)
    need = outer - centres[-1] + BOLT_RADIUS + EDGE - skin.width / 2
    what = f"{'two rows of bolts' if plates else 'bolts'} beside the trough"
    wall, broken = _room("mold.wall", choice.wall, WALL if plates else 0.0, need, what)
    half = _rounded_up(2 * (centres[-1] + skin.width / 2 + wall)) / 2
    long = skin.length if plates else 2 * half  # of the cavity
    diagonal = 0.0 if short else max(2.0, long / 4)
    row, lid, spans = _cover_screws(
        design, row_places, diagonal, 2 * trough, BOLT_RADIUS + slide + EDGE, long
    )
    broken += _length(design) if plates else []
    split, lowest = -split_height(design, shape)[1], on_grid(-summit(design))
    need = split + bevel(design) + 2 * (BOLT_RADIUS + BESIDE) if plates else 0.0
    mount = least_thickness(design.mounting, lid_process(design)) if design.mounting else (0.0, "")
    need, what = max((need, "the keeper's bolts"), mount)
    if split_cavity and (holes := pins(design, shape)):
        plate = BASE_PIN + EDGE + PIN_DEPTH - (holes[0].origin[2] + flank_end(holes))
        need, what = max((need, what), (plate, "the pins in the wall of a plate of through holes"))
    back, thin = _room("mold.carrier_thickness", choice.carrier_thickness, CARRIER, need, what)
    seal = 0.0 if kind.leans else SQUEEZED_SHARE * seal_thickness(stack_error(design, spans, lid))
    top = on_grid(back + seal) if seal else back  # a bent mold's narrow top has no height to give
    need = lowest - split + 2 * (nut + EDGE) if plates else 0.0
    if split_cavity:
        need = max(need, *_under_pieces(nut, top - lowest))
    else:  # the cover's screws end in it
        need = max(need, blind_depth(lid, block_process(design)) + EDGE - (top - lowest))
    floor, low = _room("mold.floor", choice.floor, FLOOR, need, "bolts, nuts and pins")
    broken += [*low, *thin]
    bottom = lowest - floor if choice.floor else _bottom(design, lowest - floor, top)
    depth = on_grid(min(PIN_DEPTH, 0.4 * skin.length))
    bolt = bottom + EDGE + nut
    key = KEYING + 2 * (slide - PIN_RADIUS)
    place = Layout(
        centres=centres,
        half=half,
        end=long / 2,
        bottom=bottom,
        back=back,
        top=top,
        trough=trough,
        lanes=(-inner, *(x - (row_offset if count > 1 else 0.0) for x in between), inner) if plates else (),
        pins=(pin_offset - inner, inner - pin_offset),
        outer=outer,
        bolts=() if short else _bolts(row_places, row, diagonal),
        pin_along=diagonal if row.screws == 1 else row.spacing / 2 * (row.screws % 2),
        pin_depth=depth,
        cover=_rounded_up(skin.length + 2 * choice.end_plate) / 2 if plates else half + OVERHANG,
        lid=lid,
        spans=spans,
        split=split,
        comb_bolt=bolt,
        comb_pin=bolt,
        keeper_bolt=(split + back - bevel(design)) / 2,
        keying=(key, 0.0) if short else (0.0, key),
        nut=nut,
    )
    return place, broken


def _cover_screws(
    design: Design,
    row_places: tuple[float, ...],
    diagonal: float,
    load: float,
    between: float,
    length: float,
) -> tuple[ScrewRow, float, Spans]:
    """Return a row of the cover's screws, its thickness and what it spans; `between` is from a screw to a pin
    beside it. A clamped cover has no screws, and the narrow top of a bent mold has room for a diagonal."""
    wide = max(b - a for a, b in pairwise(row_places))
    holes = block_fits(design)
    choices = screw_rows(
        length, diagonal, max(BOLT_RADIUS, holes.thread) + EDGE, 2 * between, design.mold.cavities
    )
    if is_clamped(design) or kind_of(design).leans:
        choices = choices[:1]
    modulus, thickness = lid_process(design).part_modulus, design.mold.cover
    row, lid = choose_screws(choices, wide, load, modulus, thickness, STOCK)
    return row, lid, Spans(wide, load, row.reach)


def stack_error(design: Design, spans: Spans, lid: float) -> float:
    """Return by how much what the seal lies on may be higher or lower against the cavity's top than designed,
    mm, every part at the worst end of its process's tolerance: a carrier on its ledge, or a keeper on its
    comb, which slides on pins; and by how much the seal itself bows the cover."""
    block, ends, lids = block_process(design), end_process(design), lid_process(design)
    on_ledge = block.tolerance + lids.tolerance
    if design.mold.block_process is not None:
        on_ledge += processes(design.printer)[design.mold.process].tolerance  # of the disc between them
    keeper = block.tolerance + 2 * ends.tolerance + end_fits(design).slide - PIN_RADIUS
    under = max(on_ledge, keeper) if kind_of(design).ends else on_ledge
    return under + bow(spans, lid, lids.part_modulus, SEAL_PRESSURE)


def _bolts(row_places: tuple[float, ...], row: ScrewRow, diagonal: float) -> tuple[tuple[float, float], ...]:
    """(x, y) of the cover's screws: one in each row, the outer ones on one diagonal, or more, evenly."""
    if row.screws == 1:
        return (row_places[-1], diagonal), (row_places[0], -diagonal), *((x, 0.0) for x in row_places[1:-1])
    ys = [row.spacing * (i - (row.screws - 1) / 2) for i in range(row.screws)]
    return tuple((x, y) for x in row_places for y in ys)


def _bottom(design: Design, highest: float, top: float) -> float:
    """The underside of a block whose floor is computed, mm, at most at `highest`: a whole number of layers
    under the ledge, z = 0, so that a print has it where it is drawn, or else a round size under the top."""
    layer = block_process(design).layer
    if layer:
        return on_grid(-math.ceil(-highest / layer - 1e-6) * layer)
    return top - _rounded_up(top - highest)


def _rounded_up(size: float) -> float:
    """An outer size, mm, up to a multiple of `STOCK`, or down to one that lies within `ROUND_DOWN`: only the
    skin's negative carries shrinkage."""
    return on_grid(math.ceil((size - ROUND_DOWN) / STOCK) * STOCK)


def is_clamped(design: Design) -> bool:
    """Whether a skin is so short that clamps hold its mold's cover, not bolts; `design` is what is poured."""
    return kind_of(design) is STRAIGHT and design.skin.length < LEAST_BOLTED


def _room(
    key: str, value: float | None, usual: float, need: float, what: str
) -> tuple[float, list[InputError]]:
    """Return a length that has to be at least `need`, mm: the given one and what is wrong with it, or else
    the usual one, or what is needed."""
    if value is None:
        return max(usual, math.ceil(need / STOCK) * STOCK), []
    return value, at_least(key, value, need, what, "enlarge it, or leave it out to have it computed")


def at_least(key: str, value: float, need: float, what: str, remedy: str) -> list[InputError]:
    """Return the error of a length that leaves too little room, if it does; what is asked is rounded up."""
    rounded = math.ceil(1000 * need) / 1000
    return [InputError(key, f"must be at least {rounded:g} mm, for {what}", value, remedy)] * (value < need)


def _length(design: Design) -> list[InputError]:
    """What is wrong with the skin's length: bolts and pins of a cover, or its pins alone, stand beside it."""
    least, what = LEAST_BOLTED, "bolts and pins of a mold"
    if is_clamped(design):
        least, what = 2 * (block_fits(design).slide + BESIDE), "the pins of a mold's cover"
    cured = 1 - shrinkage(design)
    remedy = "cast a longer skin and cut it to length"
    return at_least("skin.length", cured * design.skin.length, cured * least, what, remedy)


def _under_pieces(nut: float, high: float) -> tuple[float, float]:
    """Return what a floor needs for a split cavity, mm: its base and the pieces' feet on it, and the wall's
    pins over the base. `high` is from the deepest ridge to the top, `nut` as in `Layout`."""
    base = EDGE + nut + BOLT_RADIUS + EDGE
    return base + FOOT, base + BASE_PIN + EDGE + PIN_DEPTH - high


def end_angle(design: Design) -> float:
    """Return the angle by which an end plate of a doubly curved mold leans, rad; 0 where it is upright."""
    return design.skin.length / 2 / design.skin.radius_y


def ends_rise(design: Design) -> float:
    """Return how much higher the back's ends lie than its middle in the mold, mm."""
    angle, skin = end_angle(design), design.skin
    arc = skin.length / 2 * (1 - skin.thickness / skin.radius_y)
    return arc * math.sin(angle / 2) * float(np.sinc(angle / 2 / math.pi))


def bevel(design: Design) -> float:
    """Return by how much a leaning end plate is lower at its outer face than at its inner one, mm."""
    return design.mold.end_plate * math.tan(end_angle(design))


def cover_pins(place: Layout) -> list[tuple[float, float]]:
    """Return (x, y) of the cover's pins, on the diagonal that has no bolts or between them, one aside."""
    shift, along = place.keying
    return [(place.outer, -place.pin_along), (shift - place.outer, place.pin_along - along)]


def nut_pocket(place: Layout, x: float, z: float, low: float, high: float) -> Prism:
    """Return a nut's pocket along y about (x, z), two of its flats level."""
    corner = 2 / math.sqrt(3) * place.nut
    turns = [math.radians(60 * i) for i in range(6)]
    points = [Point(x + corner * math.cos(a), z + corner * math.sin(a)) for a in turns]
    return Prism(loop(points), "y", low, high, role=CutRole.NUT)
