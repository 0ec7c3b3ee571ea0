"""End plates: comb and keeper of each y end, the gate, nuts' pockets, pry notches, marks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from skincad.base.errors import InputError, refusals
from skincad.inputs.design import Design
from skincad.shape.curves import Loop, Point, Segment, flipped, loop
from skincad.shape.shots import heights
from skincad.shape.skin import Section, section
from skincad.solids.fasteners import TAP_RADIUS, engagement
from skincad.solids.gate import WIDTHS, wanted_gate
from skincad.solids.kind import kind_of
from skincad.solids.layout import (
    BESIDE,
    BOLT_RADIUS,
    EDGE,
    NUT_DEPTH,
    Layout,
    bevel,
    end_fits,
    end_process,
    nut_pocket,
)
from skincad.solids.plan import Body, Bore, CutRole, End, Part, PartRole, Prism, box, drilled, moved, shifted
from skincad.solids.shrinkage import scaled_for_shrinkage, shrinkage
from skincad.solids.split import closed_edge, split_edges, split_height

LEAST_GATE = 0.7  # mm, assumption: takes the thinnest usual blunt tip, 25 gauge, 0.51 mm
GATE_SILL = 0.3  # mm, assumption: least skin below and above the gate, so that it can be trimmed
GATE_WEB = 0.8  # mm, assumption: of plate under the gate, two lines of a nozzle; less where there is no room
PRY = (1.5, 6.0)  # mm, assumption: leg of a pry notch, at 45 degrees so that it prints, and its width
MARK = (1.0, 2.0)  # mm, assumption: leg of a nick that a finger finds, at 45 degrees too, and its height
LEAST_UNDER_NUT = 1.0  # mm, assumption: of an end plate
BEVELLED = 1.0  # mm; a leaning end plate is drawn higher by this before its top is cut level


def end_plates(design: Design, shape: Section, place: Layout, end: End) -> list[Part]:
    """Return comb and keeper of one end, or a plain plate where there are no slots."""
    thick, bent = design.mold.end_plate, kind_of(design).leans
    low, high = (-place.end - thick, -place.end) if end == "a" else (place.end, place.end + thick)
    lower = [cut for x in place.lanes for cut in _bolt(design, place, end, low, x, place.comb_bolt)]
    pins = [(x, place.comb_pin) for x in place.pins]
    lower += drilled(CutRole.END_PIN, "y", pins, low, thick, end_fits(design).slide)
    lower += _pry(design, place, end, (place.bottom, place.split))
    lower += _marks(design, place, end)
    upper = [cut for x in place.lanes for cut in _bolt(design, place, end, low, x, place.keeper_bolt)]
    upper += _pry(design, place, end, (place.split, place.back - bevel(design)))
    if end == "a":
        upper += [moved(opening, x) for opening in gate_bores(design, shape) for x in place.centres]
    upper += [_bevelled(design, place, end)] if bent else []
    top = place.back + BEVELLED if bent else place.back
    if not shape.slots:
        body = box(place.half, (low, high), (place.bottom, top), "y")
        return [Part(f"end-{end}", PartRole.END_PLATE, body, (*lower, *upper), end)]
    toothed, smooth = _edges(design, shape, place)
    comb = Prism(flipped(closed_edge(toothed, -place.bottom)), "y", low, high)
    keeper = Prism(flipped(closed_edge([s.reversed() for s in reversed(smooth)], -top)), "y", low, high)
    return [
        Part(f"end-{end}-comb", PartRole.COMB, comb, tuple(lower), end),
        Part(f"end-{end}-keeper", PartRole.KEEPER, keeper, tuple(upper), end),
    ]


def _bolt(design: Design, place: Layout, end: End, low: float, x: float, z: float) -> list[Body]:
    """A bolt's way through an end plate: a clearance hole, or at end b a nut's pocket or a thread. The plates
    of a doubly curved mold are not parallel: each has its own screws into the cavity."""
    thick = design.mold.end_plate
    depth = min(NUT_DEPTH, thick - LEAST_UNDER_NUT)
    fits_in = min(z - place.bottom, place.back - z, abs(z - place.split)) >= place.nut + BESIDE
    through = Bore((x, low, z), "y", thick, BOLT_RADIUS, role=CutRole.END_BOLT)
    if end == "b" and not kind_of(design).leans:
        if not end_fits(design).printed and thick >= engagement(end_process(design)):
            return [replace(through, radius=TAP_RADIUS, role=CutRole.END_THREAD)]
        if end_fits(design).printed and depth >= NUT_DEPTH / 2 and fits_in:
            nut = nut_pocket(place, x, z, low + thick - depth, low + thick)
            return [replace(through, length=thick - depth), nut]
    return [through]


def _pry(design: Design, place: Layout, end: End, levels: tuple[float, float]) -> list[Body]:
    """Notches for a screwdriver at both sides of an end plate's inner face; none in a thin or low plate."""
    leg, wide = PRY
    size = min(leg, design.mold.end_plate / 2)
    middle, height = (levels[0] + levels[1]) / 2, min(wide, levels[1] - levels[0] - EDGE)
    face, out = (-place.end, -size) if end == "a" else (place.end, size)
    if height < wide / 2:
        return []
    low, high = middle - height / 2, middle + height / 2
    return [_nick(CutRole.PRY, side, face, out, (low, high)) for side in (-place.half, place.half)]


def _marks(design: Design, place: Layout, end: End) -> list[Body]:
    """Nicks in an end plate's outer edge, on the side where the strips' numbers begin: one at end a, two at
    end b. Engraved numbers would be 0.6 mm high."""
    size, height = min(MARK[0], design.mold.end_plate / 4), MARK[1]
    out = place.end + design.mold.end_plate
    face, into = (-out, size) if end == "a" else (out, -size)
    levels = [place.comb_bolt] if end == "a" else [place.comb_bolt - height, place.comb_bolt + height]
    return [_nick(CutRole.MARK, -place.half, face, into, (z - height / 2, z + height / 2)) for z in levels]


def _nick(role: CutRole, side: float, face: float, into: float, levels: tuple[float, float]) -> Prism:
    """A plate's upright edge at (`side`, `face`), cut off at 45 degrees between two levels."""
    towards = math.copysign(into, -side)
    corners = [Point(side, face), Point(side + towards, face), Point(side, face + into)]
    if towards * into < 0:
        corners.reverse()
    return Prism(loop(corners), "z", *levels, role=role)


def _bevelled(design: Design, place: Layout, end: End) -> Prism:
    """What is cut off a plate that leans inward, so that its top is level with the cavity's: from the
    cavity's edge on its inner face down to its outer face. In its own frame."""
    top, out = place.back + BEVELLED, place.end + design.mold.end_plate
    points = [Point(place.end, place.back), Point(out, place.back - bevel(design)), Point(out, top)]
    points.append(Point(place.end, top))
    side = points if end == "b" else [Point(-p.x, p.z) for p in reversed(points)]
    return Prism(loop(side), "x", -place.half, place.half, role=CutRole.BEVEL)


def _edges(design: Design, shape: Section, place: Layout) -> tuple[list[Segment], list[Segment]]:
    """The split from side to side of the block, in the design's frame: that of one skin, once for each."""
    single = split_edges(design, shape, place.half - place.centres[-1])
    if len(place.centres) == 1:
        return single
    first, second = ([shifted(tuple(edge[1:-1]), x) for x in place.centres] for edge in single)
    return _joined(first, place.half), _joined(second, place.half)


def _joined(edges: list[Loop], half: float) -> list[Segment]:
    level = edges[0][0].start.z
    joined = [Segment(Point(-half, level), edges[0][0].start)]
    for here, there in zip(edges, [*edges[1:], ()], strict=True):
        end = there[0].start if there else Point(half, level)
        joined += [*here, Segment(here[-1].end, end)]
    return joined


def refused_ends(design: Design, shape: Section, place: Layout) -> Iterator[InputError]:
    """Yield an error for a gate, and one for notches, that find no room in the end plates."""
    yield from refusals(lambda: gate_bores(design, shape))
    yield from refusals(lambda: _edges(design, shape, place) if shape.slots else None)


def gate(design: Design) -> float | None:
    """Return the diameter of the pouring gate of a design's mold, mm; None for an open pour."""
    bores = gate_bores(scaled_for_shrinkage(design), section(scaled_for_shrinkage(design)))
    return 2 * bores[0].radius if bores else None


def gate_bores(design: Design, shape: Section) -> list[Bore]:
    """Return the pouring gates: along y through the upper end plate of end a, as low as the skin's body and
    the web under it allow; none for an open pour. A doubly curved skin in layers has one for each, all of one
    width, the back's first. `design` is what is poured.

    Raises InputError where a gate finds no room and an open pour is no way out.
    """
    skin, choice, diameter = design.skin, design.mold, design.mold.gate
    kind, shots = kind_of(design), len(design.shot or ())
    straight = not kind.leans
    if choice.pour == "open" or not kind.ends or (straight and shots):
        return []

    def least(wide: float) -> tuple[float, int]:
        """The largest diameter that has room in all layers, and in which it is least."""
        return min((_gate_room(design, shape, n, wide / 2)[2], n) for n in range(shots + 1))

    most, narrow = least(diameter or WIDTHS[0])
    wide = diameter or min(wanted_gate(design, shape), math.floor(10 * most) / 10)  # a drill
    if diameter is None and wide > WIDTHS[0]:  # a wider one stands further from the middle
        most, narrow = least(wide)
        wide = max(WIDTHS[0], min(wide, math.floor(10 * most) / 10))
    where = (
        f"of {'the layer in front' if narrow == shots else f'shot {narrow + 1}'}"
        if shots
        else "in the skin's end"
    )
    room = f"leaves {most:.4g} mm for the gate {where}"
    way_out = ', or take mold.pour = "open"' if straight else ""
    if most <= 0 or (diameter is None and wide < LEAST_GATE):
        if diameter is None and choice.pour is None and straight:
            return []
        needs = f"{room}, which needs {LEAST_GATE:g} mm"
        raise InputError(
            "skin.thickness", needs, skin.thickness * (1 - shrinkage(design)), f"make it thicker{way_out}"
        )
    if wide > most:
        raise InputError("mold.gate", room, wide, f"make it smaller{way_out}")
    gates = []
    for number in range(shots + 1):
        back, front, _ = _gate_room(design, shape, number, wide / 2)
        web = max(_sill(design), min(GATE_WEB, front - back - wide - GATE_SILL))
        start = (0.0, -skin.length / 2 - choice.end_plate, web + wide / 2 - front)
        gates.append(Bore(start, "y", choice.end_plate, wide / 2, role=CutRole.GATE))
    return gates


def _gate_room(design: Design, shape: Section, number: int, radius: float) -> tuple[float, float, float]:
    """Return how high the layer on the face of shot `number`, or on the back, 0, begins and ends at this
    distance from its middle, and a gate's largest diameter, mm."""
    skin = design.skin
    fall = 2 * skin.curvature_radius * math.sin(math.asin(min(1.0, radius / skin.curvature_radius)) / 2) ** 2
    front = skin.thickness + min(split_height(design, shape)[0], 0.0) - fall
    if number < len(design.shot or ()):
        front = min(front, _height(design, number + 1, radius))
    back = _height(design, number, 0.0)
    return back, front, min(front - back - GATE_SILL - _sill(design), skin.width - 2 * GATE_SILL)


def _height(design: Design, number: int, x: float) -> float:
    return float(heights(design, number, np.array([x]), np.zeros(1))[0])


def _sill(design: Design) -> float:
    """The least web under the gate, mm: the thinnest wall that the end plates' process makes."""
    return max(GATE_SILL, end_process(design).wall)
