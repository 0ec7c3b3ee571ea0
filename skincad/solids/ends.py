"""End plates: comb and keeper of each y end, the gate, the nuts' pockets and the pry notches."""

from __future__ import annotations

import math

from skincad.curves import Point, Segment, flipped, loop
from skincad.design import Design
from skincad.errors import InputError
from skincad.section import Section
from skincad.solids.layout import (
    BESIDE,
    BOLT_RADIUS,
    EDGE,
    NUT_DEPTH,
    TAP_RADIUS,
    Layout,
    end_fits,
    nut_pocket,
)
from skincad.solids.plan import Body, Bore, Part, Prism, box, moved, shifted
from skincad.solids.split import closed, split_edges, split_height

GATE_SILL = 0.3  # mm, assumption: least skin below and above the gate, so that it can be trimmed
PRY = (1.5, 6.0)  # mm, assumption: leg of a pry notch, at 45 degrees so that it prints, and its width
LEAST_UNDER_NUT = 1.0  # mm, assumption: of an end plate
DARK, GREEN = (0.45, 0.50, 0.58), (0.55, 0.75, 0.60)


def end_plates(design: Design, shape: Section, place: Layout, end: str) -> list[Part]:
    """Return comb and keeper of one end, or a plain plate where there are no slots."""
    thick = design.mold.end_plate
    low, high = (-place.end - thick, -place.end) if end == "a" else (place.end, place.end + thick)
    lower = [cut for x in place.lanes for cut in _bolt(design, place, end, low, x, place.comb_bolt)]
    lower += [Bore((x, low, place.comb_pin), "y", thick, end_fits(design).slide) for x in place.pins]
    lower += _pry(design, place, end, (place.bottom, place.split))
    upper = [cut for x in place.lanes for cut in _bolt(design, place, end, low, x, place.keeper_bolt)]
    upper += _pry(design, place, end, (place.split, place.top))
    if end == "a" and design.mold.pour == "syringe":
        gate = _gate(design, shape, low)
        upper += [moved(gate, x) for x in place.centres]
    if not shape.slots:
        body = box(place.half, (low, high), (place.bottom, place.top), "y")
        return [Part(f"end-{end}", DARK, "made", body, (*lower, *upper), lies_on_end=True)]
    toothed, smooth = _edges(design, shape, place)
    comb = closed(toothed, -place.bottom)
    keeper = closed([s.reversed() for s in reversed(smooth)], -place.top)
    return [
        Part(f"end-{end}-comb", DARK, "made", Prism(flipped(comb), "y", low, high), tuple(lower), True),
        Part(f"end-{end}-keeper", GREEN, "made", Prism(flipped(keeper), "y", low, high), tuple(upper), True),
    ]


def _bolt(design: Design, place: Layout, end: str, low: float, x: float, z: float) -> list[Body]:
    """A bolt's way through an end plate: a clearance hole, or at end b a nut's pocket or a thread."""
    thick = design.mold.end_plate
    depth = min(NUT_DEPTH, thick - LEAST_UNDER_NUT)
    if end == "b" and not end_fits(design).printed:
        return [Bore((x, low, z), "y", thick, TAP_RADIUS)]
    fits_in = min(z - place.bottom, place.top - z, abs(z - place.split)) >= place.nut + BESIDE
    if end == "a" or depth < NUT_DEPTH / 2 or not fits_in:
        return [Bore((x, low, z), "y", thick, BOLT_RADIUS)]
    return [
        Bore((x, low, z), "y", thick - depth, BOLT_RADIUS),
        nut_pocket(place, x, z, low + thick - depth, low + thick),
    ]


def _pry(design: Design, place: Layout, end: str, levels: tuple[float, float]) -> list[Body]:
    """Notches for a screwdriver at both sides of an end plate's inner face; none in a thin or low plate."""
    leg, wide = PRY
    size = min(leg, design.mold.end_plate / 2)
    middle, height = (levels[0] + levels[1]) / 2, min(wide, levels[1] - levels[0] - EDGE)
    face, out = (-place.end, -size) if end == "a" else (place.end, size)
    if height < wide / 2:
        return []
    notches: list[Body] = []
    for side in (-place.half, place.half):
        towards = math.copysign(size, -side)
        corners = [Point(side, face), Point(side + towards, face), Point(side, face + out)]
        if towards * out < 0:
            corners.reverse()
        notches.append(Prism(loop(corners), "z", middle - height / 2, middle + height / 2))
    return notches


def _edges(design: Design, shape: Section, place: Layout) -> tuple[list[Segment], list[Segment]]:
    """The split from side to side of the block, in the design's frame: that of one skin, once for each."""
    single = split_edges(design, shape, place.half - place.centres[-1])
    if len(place.centres) == 1:
        return single
    first, second = ([_without_ends(edge, x) for x in place.centres] for edge in single)
    return _joined(first, place.half), _joined(second, place.half)


def _without_ends(edge: list[Segment], x: float) -> list[Segment]:
    return list(shifted(tuple(edge[1:-1]), x))


def _joined(edges: list[list[Segment]], half: float) -> list[Segment]:
    level = edges[0][0].start.z
    joined = [Segment(Point(-half, level), edges[0][0].start)]
    for here, there in zip(edges, [*edges[1:], []], strict=True):
        end = there[0].start if there else Point(half, level)
        joined += [*here, Segment(here[-1].end, end)]
    return joined


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
