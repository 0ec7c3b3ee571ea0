"""The cutting pattern of the film strips: outline with tabs, electrode and lead, each strip in its own row.

Drawn as the strips lie in the mold, seen from +x with the + side facing you: x in the drawing is the mold's
y (end a left, end b right, 0 in the skin's middle), ridges' tips are below. The draw axis runs along the
strips (assumption), so that the tension pulls along it and d31 is that of stress along the ridges.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from skincad.inputs.design import Design
from skincad.inputs.skin_tables import Film
from skincad.shape.cross_section import SlotPlace, section
from skincad.shape.curves import Loop, Point, Segment, rectangle
from skincad.solids.inserts import stands_out
from skincad.solids.plan import mirrored
from skincad.solids.shrinkage import poured

ROW_GAP = 2.0  # mm, assumption: between strips on the cutting pattern
GLUED = 5.0  # mm, assumption: of a strip's tail, by which its shim draws it in; it is cut off afterwards
TAB = (8.0, 3.0)  # mm, assumption: length and width of a tab that a weight hangs on
SHOULDER = 0.5  # mm, assumption: fillet between strip and tab, or the film tears there
HOLE = 0.75  # mm, assumption: radius of a tab's hole for the weight's hook


class Line(NamedTuple):
    """A line to be marked, mm."""

    start: Point
    end: Point


@dataclass(frozen=True)
class StripPattern:
    """One strip: closed outlines in mm, what is marked on it, and where its label and its + sign begin."""

    label: str
    cut: Loop
    holes: tuple[Loop, ...]
    electrode: Loop
    lead: Loop
    cut_off: tuple[Line, ...]
    label_at: Point
    plus_at: Point


def strip_patterns(design: Design) -> list[StripPattern]:
    """Return the pattern of every strip, ridge by ridge from the drawing's foot up; none without film.

    Strips of a skin that is curved along y too are cut straight, each as long as its slot's arc: the slot
    bends them on edge by what `pattern_notes` says.
    """
    design = poured(design) if design.mold.method == "cast-in" else design
    film, shape = design.film, section(design)
    if film is None:
        return []
    pitch = row_height(design) + ROW_GAP
    middles = [row_height(design) / 2 + index * pitch for index in range(len(shape.slots))]
    return [_pattern(design, film, s, z) for s, z in zip(shape.slots, middles, strict=True)]


def pattern_notes(design: Design) -> list[str]:
    """Return what is written under the pattern."""
    film, strain = design.film, _edge_strain(design)
    wiring, skins = film.wiring_side if film else "b", design.mold.cavities
    return [
        *([f"for one skin: cut it {skins} times"] if skins > 1 else []),
        *([f"straight strips, bent on edge by their slots: strain {100 * strain:.2g} %"] if strain else []),
        "seen from the + side, which faces +x in every slot; end a left, end b right, ridges below",
        f"leads at end {wiring}, where the corner at the ridge is cut off; draw axis (d31) along the strips",
    ]


def _arc(design: Design, slot: SlotPlace) -> float:
    """A slot's arc along y by skin.length: 1 where it is straight."""
    radius = design.skin.curvature_radius_y
    return 1.0 if radius is None else 1 + (slot.centre.z - design.skin.thickness) / radius


def _edge_strain(design: Design) -> float:
    """Strain of a straight strip's edges in a slot that is bent along y."""
    radius = design.skin.curvature_radius_y
    return 0.0 if radius is None or design.slot is None else design.slot.depth / 2 / radius


def row_height(design: Design) -> float:
    """Return the height of one strip on the drawing, mm: its tab's where it has one, or its own."""
    depth = design.slot.depth if design.slot else 0.0
    return 2 * _half_tab(depth) if design.mold.method == "cast-in" else depth


def _half_tab(depth: float) -> float:
    return max(TAB[1] / 2, depth + SHOULDER)


def _pattern(design: Design, film: Film, slot: SlotPlace, middle: float) -> StripPattern:
    """One strip about z = `middle`, drawn with its wiring side at +x and mirrored where that is end a."""
    half, h, margin = design.skin.length / 2 * _arc(design, slot), slot.depth / 2, film.electrode_margin
    wired_a, cast_in = film.wiring_side == "a", design.mold.method == "cast-in"
    marks: tuple[float, ...]
    a, b = stands_out(design)
    wired, other = (half + a, half + b) if wired_a else (half + b, half + a)
    if cast_in:
        w, tab = _half_tab(slot.depth), SHOULDER + TAB[0]
        cut = _with_tabs(-other, wired, h, w)
        ends, marks = (-other - tab, wired + tab), (-other, wired)
        holes = [_hole(x) for x in (-other - tab + 2 * HOLE, wired + tab - 2 * HOLE)]
    else:
        ends, marks, holes = (-other - GLUED, wired), (-other,), []
        cut = _straight(*ends, h)
    e, tip = h - margin, wired - margin - (h if ends[1] == wired else 0.0)  # clear of the corner

    def placed(outline: Loop) -> Loop:
        return tuple(_moved(s, middle) for s in (mirrored(outline) if wired_a else outline))

    side = -1.0 if wired_a else 1.0
    left, right = (-ends[1], -ends[0]) if wired_a else ends
    return StripPattern(
        label=f"{slot.ridge} {slot.side}",
        cut=placed(cut),
        holes=tuple(placed(hole) for hole in holes),
        electrode=placed(rectangle(-half + margin, half, -e, e)),
        lead=placed(rectangle(half, tip, -e, e)),
        cut_off=tuple(Line(Point(side * x, middle - h), Point(side * x, middle + h)) for x in marks),
        label_at=Point(right + 1.0, middle - 0.5),
        plus_at=Point(left - 2.0, middle - 0.5),
    )


def _straight(left: float, right: float, h: float) -> Loop:
    """A straight strip; the wiring end's corner at the ridge's tip is cut off, to tell a strip's sides."""
    corners = [(left, -h), (right - h, -h), (right, 0.0), (right, h), (left, h)]
    return _path([(x, z, 0.0) for x, z in corners])


def _with_tabs(left: float, right: float, h: float, w: float) -> Loop:
    """A strip, straight from `left` to `right`, with filleted tabs of half width `w` beyond; its wiring end's
    corner at the ridge's tip is cut off too."""
    r, t, k = SHOULDER, SHOULDER + TAB[0], -math.tan(math.pi / 8)  # the bulge of a quarter circle, inward
    corners = [
        *[(left - t, -w, 0.0), (left - r, -w, 0.0), (left - r, -h - r, k), (left, -h, 0.0)],
        *[(right, -h, k), (right + r, -h - r, 0.0), (right + r, -w, 0.0), (right + t - w, -w, 0.0)],
        *[(right + t, 0.0, 0.0), (right + t, w, 0.0), (right + r, w, 0.0), (right + r, h + r, k)],
        *[(right, h, 0.0), (left, h, k), (left - r, h + r, 0.0), (left - r, w, 0.0), (left - t, w, 0.0)],
    ]
    return _path(corners)


def _path(corners: list[tuple[float, float, float]]) -> Loop:
    """Return the closed loop through corners (x, z, bulge of the segment that begins there)."""
    following = [*corners[1:], corners[0]]
    return tuple(
        Segment(Point(x, z), Point(u, v), bulge)
        for (x, z, bulge), (u, v, _) in zip(corners, following, strict=True)
        if (x, z) != (u, v)
    )


def _hole(x: float) -> Loop:
    return _path([(x - HOLE, 0.0, 1.0), (x + HOLE, 0.0, 1.0)])


def _moved(segment: Segment, up: float) -> Segment:
    (x, z), (u, v) = segment.start, segment.end
    return replace(segment, start=Point(x, z + up), end=Point(u, v + up))
