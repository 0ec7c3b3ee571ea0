r"""The mold, ridges down: cavity, end plates with combs and keepers, carrier, cover, pins, bores.

    z up                 cover            vent in the carrier at +y, a cup over it
    ---------------------------------
    | wall | ledge  carrier  | wall |     carrier lies on the ledge, flush with the cavity's top
    |      |_     skin      _|      |     skin's back at z = 0
    |        |_/\/\/\/\/\_|        |     ridges' negative, open at both y ends
    |______________floor____________|

The carrier seals on its ledge along x; along y it ends a clearance before the end plates, where a thin flash
rises that is cut off. While it is poured, end b is up: what air is left runs along the carrier's lower face
to end b's edge and up that gap, so the cup over the vent covers the gap too. A gap of 0.01 mm lets 0.6 mm3/s
of air out under 5 mm of silicone (plane Poiseuille flow, 11 mm wide, 4 mm high) and next to no silicone.
Every hole of the carrier has a bleed in the cover, under the highest point of its rim.

An end plate closes each y end. Where there are slots it is split across the slits, at their back ends: the
comb below has a notch a slot, open towards the keeper above, so that a strip with tabs can be laid in and
a slit of 0.05 mm never has to be cut closed. Bolts run through along y (inner lane of each wall) and along
z (outer lane), so no two bores meet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from skincad.curves import Point, Segment, flipped
from skincad.design import Design
from skincad.errors import InputError
from skincad.section import Section, section
from skincad.solids.inserts import PIN_RADIUS, pin, shims
from skincad.solids.plan import Axis, Body, Bore, Part, Prism, box
from skincad.solids.skin import cast_skin
from skincad.solids.split import closed, path, split_edges, split_height

if TYPE_CHECKING:
    import cadquery as cq

BOLT_RADIUS = 1.7  # mm, source: ISO 273 clearance hole for M3, medium series
EDGE = 1.2  # mm, assumption: least material between two bores, or a bore and an edge
LEDGE = 2.0  # mm, assumption: width of the seat on which the carrier seals the skin's back
PIN_DEPTH = 6.0  # mm, assumption: three diameters of a pin hold it
KEYING = 0.5  # mm, assumption: one pin stands aside by this and two clearances: the cover fits one way only
HOLD = (0.75, 1.25, 4.0)  # mm, assumption: radius at the skin, at the cover, spacing of the carrier's holes
MOST_HOLES = (
    60  # assumption: a large carrier spaces its holes wider; the kernel's time grows with their square
)
BLEED = 0.4  # mm, assumption: radius of the cover's bleed over each of them, or it would fill with air only
CUP = 2.5  # mm, assumption: least upper radius of the cup; its 50 mm3 are a tenth of a small skin
CUP_RIM = 0.5  # mm, assumption: by which the cup is at least wider above than below, to be filled and cleaned
OVERLAP = 0.3  # mm, assumption: the cup's reach over the end plate, should the cover sit aside
GATE_SILL = 0.3  # mm, assumption: least skin below and above the gate, so that it can be trimmed
GREY, DARK, GLASS, GREEN = (0.75, 0.77, 0.80), (0.45, 0.50, 0.58), (0.70, 0.85, 0.95), (0.55, 0.75, 0.60)


class Step(NamedTuple):
    """One step of opening: these parts leave along an axis, over this signed travel in mm."""

    parts: tuple[str, ...]
    axis: Axis
    travel: float


@dataclass(frozen=True)
class Mold:
    """The closed mold with the skin in it, and the order in which it opens."""

    parts: tuple[Part, ...]
    opening: tuple[Step, ...]

    def part(self, name: str) -> Part:
        """Return the part of this name."""
        return next(p for p in self.parts if p.name == name)


class _Layout(NamedTuple):
    """Positions that several parts share, mm."""

    half: float  # block, along x
    end: float  # cavity's y end
    bottom: float
    top: float
    trough: float  # half width of the carrier's seat
    inner: float  # x of the bolts along y
    outer: float  # x of the bolts along z
    along: float  # y of the bolts and pins along z
    split: float  # height of the split at the bolts
    comb_bolt: float
    comb_pin: float
    keeper_bolt: float
    keying: float


def mold(design: Design) -> Mold:
    """Return the closed mold's parts, the skin, shims and pins in it, and the opening sequence.

    Raises InputError when a bore, the gate or a notch finds no room.
    """
    shape, place = section(design), _layout(design)
    ends = [part for end in ("a", "b") for part in _end_plates(design, shape, place, end)]
    lids = [_carrier(design, place), _cover(design, place)]
    pins = _pins(design, place)
    strips = shims(design)
    parts = (cast_skin(design), _cavity(design, shape, place), *ends, *lids, *pins, *strips)
    far = 2 * design.skin.length + 4 * design.mold.end_plate
    high = 2 * (place.top - place.bottom)
    names = [part.name for part in parts]
    return Mold(
        parts,
        (
            *([Step(tuple(p.name for p in strips), "y", far)] if strips else []),
            Step(tuple(n for n in names if n.startswith("end-a")), "y", -far),
            Step(tuple(n for n in names if n.startswith("end-b")), "y", far),
            Step(("cover", *(n for n in names if n.startswith("pin-cover"))), "z", high),
            Step(("skin", "carrier"), "z", high),
        ),
    )


def mold_solids(design: Design) -> dict[str, cq.Workplane]:
    """Return the exact solids of the parts that one makes or casts, by name, in the mold's frame, mm."""
    from skincad.solids.occ import workplane

    return {p.name: workplane(p) for p in mold(design).parts if p.made != "bought"}


def _layout(design: Design) -> _Layout:
    skin, choice, shape = design.skin, design.mold, section(design)
    trough = skin.width / 2 + LEDGE + choice.clearance
    inner = trough + EDGE + BOLT_RADIUS
    outer = inner + EDGE + 2 * BOLT_RADIUS
    need = outer + BOLT_RADIUS + EDGE - skin.width / 2
    _at_least("mold.wall", choice.wall, need, "two rows of bolts beside the trough")
    _at_least("skin.length", skin.length, 9.0, "bolts and pins of a mold")
    top, bottom = choice.carrier_thickness, -shape.top - choice.floor
    split = -split_height(design, shape)[1]
    bolt = bottom + EDGE + BOLT_RADIUS
    pin_height = bolt + BOLT_RADIUS + EDGE + PIN_RADIUS
    _at_least("mold.floor", split - bottom, pin_height + PIN_RADIUS + EDGE - bottom, "bolt and pin of a comb")
    _at_least("mold.carrier_thickness", top - split, 2 * (BOLT_RADIUS + 0.8), "the bolts of the keeper")
    return _Layout(
        half=skin.width / 2 + choice.wall,
        end=skin.length / 2,
        bottom=bottom,
        top=top,
        trough=trough,
        inner=inner,
        outer=outer,
        along=max(2.0, skin.length / 4),
        split=split,
        comb_bolt=bolt,
        comb_pin=pin_height,
        keeper_bolt=(split + top) / 2,
        keying=KEYING + 2 * choice.clearance,
    )


def _at_least(key: str, given: float, need: float, what: str) -> None:
    if given < need:
        raise InputError(
            key, f"leaves {given:.4g} mm for {what}, which need {need:.4g} mm", remedy="enlarge it"
        )


def _mirrored(x: float) -> tuple[float, float]:
    return (-x, x)


def _cavity(design: Design, shape: Section, place: _Layout) -> Part:
    """Block with the trough: the skin's outline as its negative, and the carrier's seat above it."""
    top_edge = [s for s in shape.outline if s.kind != "back"]  # right foot of the back to its left foot
    trough = [
        Point(place.trough, place.top),
        Point(place.trough, 0.0),
        *(Point(s.start.x, -s.start.z) for s in top_edge[:1]),
    ]
    left = [Point(-p.x, p.z) for p in reversed(trough)]
    corners = [Point(-place.half, place.top), Point(-place.half, place.bottom)]
    rim = [*corners, *(Point(-p.x, p.z) for p in reversed(corners))]
    negative = [
        Segment(Point(s.start.x, -s.start.z), Point(s.end.x, -s.end.z), -s.bulge, s.kind, s.ridge)
        for s in top_edge
    ]
    outline = (*path([*rim, *trough]), *negative, *path([*left, rim[0]]))
    half, depth = place.end, min(PIN_DEPTH, 0.4 * design.skin.length)
    bores = [
        Bore((x, -half, z), "y", 2 * half, BOLT_RADIUS)
        for x in _mirrored(place.inner)
        for z in (place.comb_bolt, place.keeper_bolt)
    ]
    holes = [
        Bore((x, y, place.comb_pin), "y", depth, PIN_RADIUS)
        for x in _mirrored(place.inner)
        for y in (-half, half - depth)
    ]
    upright = [
        Bore((x, y, place.bottom), "z", place.top - place.bottom, BOLT_RADIUS) for x, y in _cover_bolts(place)
    ]
    fits = PIN_RADIUS + design.mold.clearance
    sockets = [Bore((x, y, place.top - PIN_DEPTH), "z", PIN_DEPTH, fits) for x, y in _cover_pins(place)]
    body = Prism(outline, "y", -half, half)
    return Part("cavity", GREY, "made", body, (*bores, *holes, *upright, *sockets))


def _cover_bolts(place: _Layout) -> list[tuple[float, float]]:
    return [(place.outer, place.along), (-place.outer, -place.along)]


def _cover_pins(place: _Layout) -> list[tuple[float, float]]:
    return [(place.outer, -place.along), (-place.outer, place.along - place.keying)]


def _end_plates(design: Design, shape: Section, place: _Layout, end: str) -> list[Part]:
    """Comb and keeper of one end, or a plain plate where there are no slots."""
    thick = design.mold.end_plate
    low, high = (-place.end - thick, -place.end) if end == "a" else (place.end, place.end + thick)
    fits = PIN_RADIUS + design.mold.clearance

    def bores(z: float, radius: float) -> list[Body]:
        return [Bore((x, low, z), "y", thick, radius) for x in _mirrored(place.inner)]

    lower = [*bores(place.comb_bolt, BOLT_RADIUS), *bores(place.comb_pin, fits)]
    upper = bores(place.keeper_bolt, BOLT_RADIUS)
    if end == "a" and design.mold.pour == "syringe":
        upper.append(_gate(design, shape, low))
    if not shape.slots:
        body = box(place.half, (low, high), (place.bottom, place.top), "y")
        return [Part(f"end-{end}", DARK, "made", body, (*lower, *upper), lies_on_end=True)]
    toothed, smooth = split_edges(design, shape, place.half)
    comb = closed(toothed, -place.bottom)
    keeper = closed([s.reversed() for s in reversed(smooth)], -place.top)
    return [
        Part(f"end-{end}-comb", DARK, "made", Prism(flipped(comb), "y", low, high), tuple(lower), True),
        Part(f"end-{end}-keeper", GREEN, "made", Prism(flipped(keeper), "y", low, high), tuple(upper), True),
    ]


def _gate(design: Design, shape: Section, low: float) -> Bore:
    """The pouring gate: along y through the upper end plate of end a, as low as the skin's body allows."""
    skin, radius = design.skin, design.mold.gate / 2
    fall = 2 * skin.curvature_radius * math.sin(math.asin(min(1.0, radius / skin.curvature_radius)) / 2) ** 2
    body = skin.thickness + min(split_height(design, shape)[0], 0.0) - fall
    most = min(body - 2 * GATE_SILL, skin.width - 2 * GATE_SILL)
    if 2 * radius > most:
        key = "mold.gate" if most > 0 else "skin.thickness"
        raise InputError(key, f"leaves {most:.4g} mm for the gate in the skin's end", design.mold.gate)
    return Bore((0.0, low, GATE_SILL + radius - body), "y", design.mold.end_plate, radius)


def _vent(design: Design, place: _Layout, low: float, thick: float) -> Bore:
    """The vent: in the middle of end b, as near to the end plate as the carrier allows."""
    radius, gap = design.mold.vent / 2, design.mold.clearance
    room = min(design.skin.width, design.skin.length) - 2 * (gap + EDGE)
    if 2 * radius > room:
        raise InputError("mold.vent", f"must be at most {room:.4g} mm (the skin's back)", 2 * radius)
    return Bore((0.0, place.end - gap - radius - EDGE / 2, low), "z", thick, radius)


def _reservoir(design: Design, place: _Layout) -> Bore:
    """The riser: a cup in the cover, open above, over the vent and the gap at end b, where air collects."""
    vent, end = _vent(design, place, 0.0, 1.0), place.end
    own, inner = design.mold.reservoir, vent.start[1] - vent.radius
    wide = own / 2 if own else max(CUP, end - inner + CUP_RIM)
    y = min(end, end + design.mold.end_plate - EDGE / 2 - wide)
    need = max(y - inner, vent.start[1] + vent.radius - y, end + OVERLAP - y)
    most = place.outer - BOLT_RADIUS - EDGE
    if not need <= wide <= most:
        rule = f"must be from {2 * need:.4g} to {2 * most:.4g} mm, over vent and gap and clear of the bolts"
        raise InputError("mold.reservoir", rule, 2 * wide)
    return Bore((0.0, y, place.top), "z", design.mold.cover, need, wide)


def _bleed(hole: tuple[float, float]) -> tuple[float, float]:
    """Place of the bleed over a carrier's hole: inside its rim, at end b's side, which is the highest."""
    return hole[0], hole[1] + HOLD[1] - BLEED


def _rivets(design: Design, place: _Layout) -> list[tuple[float, float]]:
    """Places (x, y) of the carrier's holes; none for a plain carrier."""
    if design.mold.carrier == "plain":
        return []
    vent, cup = _vent(design, place, 0.0, 1.0), _reservoir(design, place)
    beside = (cup.end_radius or 0.0) + BLEED + EDGE / 2
    small, large, spacing = HOLD
    wide, long = design.skin.width - 2 * (small + EDGE), design.skin.length - 2 * (large + EDGE)
    spacing = max(spacing, math.sqrt(max(wide, 0.0) * max(long, 0.0) / MOST_HOLES))
    places = [
        (x, y)
        for x in _grid(wide, spacing)
        for y in _grid(long, spacing)
        if math.hypot(x, y - vent.start[1]) > large + vent.radius + EDGE / 2
        and math.dist(_bleed((x, y)), cup.start[:2]) > beside
    ]
    if not places:
        raise InputError(
            "mold.carrier",
            "finds no room for a hole beside the vent, so nothing would hold the skin",
            design.mold.carrier,
            'take carrier = "plain" and a primer, a smaller vent or a larger skin',
        )
    return places


def _carrier(design: Design, place: _Layout) -> Part:
    """The rigid backing: holes widen away from the skin, so that the silicone in them holds like rivets."""
    thick, gap = design.mold.carrier_thickness, design.mold.clearance
    small, large, _ = HOLD
    holes: list[Body] = [_vent(design, place, 0.0, thick)]
    holes += [Bore((x, y, 0.0), "z", thick, small, large) for x, y in _rivets(design, place)]
    half = place.end - gap
    return Part("carrier", GLASS, "made", box(place.trough - gap, (-half, half), (0.0, thick)), tuple(holes))


def _grid(room: float, spacing: float) -> list[float]:
    count = max(0, math.floor(room / spacing)) + 1 if room >= 0 else 0
    return [(i - (count - 1) / 2) * spacing for i in range(count)]


def _cover(design: Design, place: _Layout) -> Part:
    thick, end = design.mold.cover, place.end + design.mold.end_plate
    bores: list[Body] = [Bore((x, y, place.top), "z", thick, BOLT_RADIUS) for x, y in _cover_bolts(place)]
    bores += [Bore((x, y, place.top), "z", thick, PIN_RADIUS) for x, y in _cover_pins(place)]
    bores.append(_reservoir(design, place))
    bores += [Bore((*_bleed(hole), place.top), "z", thick, BLEED) for hole in _rivets(design, place)]
    body = box(place.half, (-end, end), (place.top, place.top + thick))
    return Part("cover", GLASS, "made", body, tuple(bores))


def _pins(design: Design, place: _Layout) -> list[Part]:
    """Pins pressed into the cavity's ends and into the cover; they slide in end plates and cavity."""
    depth, thick = min(PIN_DEPTH, 0.4 * design.skin.length), design.mold.end_plate
    pins = []
    for side, x in (("left", -place.inner), ("right", place.inner)):
        pins.append(pin(f"pin-a-{side}", (x, -place.end - thick, place.comb_pin), "y", depth + thick))
        pins.append(pin(f"pin-b-{side}", (x, place.end - depth, place.comb_pin), "y", depth + thick))
    length = design.mold.cover + PIN_DEPTH - design.mold.clearance
    low = place.top + design.mold.cover - length
    for side, (x, y) in zip(("right", "left"), _cover_pins(place), strict=True):
        pins.append(pin(f"pin-cover-{side}", (x, y, low), "z", length))
    return pins
