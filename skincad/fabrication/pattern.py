"""The pattern by which strips are cut, and parts' cut profiles.

Profile that is cut right through a made part along its body's axis: outline and holes, at nominal size. A
wire, a laser or a router follows it; kerf and spark gap are the machine's to compensate. A conical hole is in
it with its narrow end, to be reamed afterwards. Blind and crosswise cuts are not: the sheet's tables have
them.

Drawn as the strips lie in the mold, seen from +x with the + side, the front, facing you: x in the drawing is
the mold's y (end a left, end b right, 0 in the skin's middle), ridges' tips are below. The draw axis runs
along the strips (assumption), so that the tension pulls along it and d31 is that of stress along the ridges.

The wiring end has a tab with the pads, which stays and carries number and + sign. What is cut off is at the
other end: the tail that a shim draws in (that end goes through the slot, first), or the tab for a weight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from skincad.fabrication.bores import process_of
from skincad.fabrication.drawn_features import PartView, views
from skincad.fabrication.electrodes import (
    CORNER,
    EDGE,
    LABEL,
    PAD,
    PITCH,
    SHOULDER,
    faces,
    half_tab,
    label_offset,
    tab,
)
from skincad.inputs.design import Design
from skincad.inputs.skin_tables import Film
from skincad.shape.curves import Loop, Point, Segment, area
from skincad.shape.feature import SensorPlace
from skincad.shape.skin import section, skin_of
from skincad.solids.inserts import strip_overhangs
from skincad.solids.plan import Axis, Body, Bore, Part, Prism, Vector, mirrored, unturned
from skincad.solids.projection import View
from skincad.solids.shrinkage import scaled_for_shrinkage

FLUSH_TOLERANCE = 1e-9  # mm, within which a cut reaches a face: rounding
PLACES = 6  # decimals of a millimetre within which cuts are in line
AXES: tuple[Axis, ...] = ("x", "y", "z")


class CutProfile(NamedTuple):
    """The view that looks along the body's axis, and the profile in it, mm: outline first, then holes, all
    counterclockwise."""

    view: str
    loops: tuple[Loop, ...]

    @property
    def area(self) -> float:
        """Area of the outline less its holes, mm2."""
        outline, *holes = (area(loop) for loop in self.loops)
        return outline - sum(holes)


def cut_profile(part: Part) -> CutProfile | None:
    """Return the profile of a part whose body is a prism; None for any other body."""
    plain = unturned(part)
    body = plain.body
    if not isinstance(body, Prism):
        return None
    seen = _along(part, body.axis)
    loops = [body.outline, *body.holes, *_through(plain.cuts, body)]
    return CutProfile(seen.name, tuple(_seen(loop, body.axis, seen.of_part) for loop in loops))


def cut_words(design: Design, part: Part) -> str:
    """Return what layer CUT of a part's DXF holds, and what the machine has to take off."""
    process = process_of(design, part)
    kerf = "kerf not compensated"
    if process.tool == "wire":
        wire, off = f"wire Ø{2 * process.tool_radius:g}", f"{process.spark_gap:g} a side sparks off"
        kerf += f": {wire}, {off}, path {process.reach:g} beside it"
    return f"Layer CUT: profile and through holes (of a cone the narrow end) at nominal size, {kerf}."


def _along(part: Part, axis: Axis) -> PartView:
    index = AXES.index(axis)
    return next(view for view in views(part) if abs(view.of_part.towards[index]) == 1.0)


def _through(cuts: tuple[Body, ...], body: Prism) -> tuple[Loop, ...]:
    """The loops of what goes from face to face of a prism: by itself, or a hole with the pocket that it ends
    in; the narrowest of what is in line."""
    rows: dict[tuple[float, float], list[Prism | Bore]] = {}
    for cut in cuts:
        if isinstance(cut, Prism | Bore) and cut.axis == body.axis:
            u, v = _middle(cut)
            rows.setdefault((round(u, PLACES), round(v, PLACES)), []).append(cut)
    return tuple(_narrowest(row) for row in rows.values() if _spans(row, body))


def _narrowest(row: list[Prism | Bore]) -> Loop:
    loops = [cut.outline if isinstance(cut, Prism) else _circle(cut) for cut in row]
    return min(loops, key=area)


def _spans(row: list[Prism | Bore], body: Prism) -> bool:
    """Whether cuts in line with each other go through without a gap."""
    reached = body.low
    for low, high in sorted(map(_range, row)):
        reached = max(reached, high) if low <= reached + FLUSH_TOLERANCE else reached
    return reached >= body.high - FLUSH_TOLERANCE


def _range(cut: Prism | Bore) -> tuple[float, float]:
    if isinstance(cut, Prism):
        return cut.low, cut.high
    low = cut.start[AXES.index(cut.axis)]
    return low, low + cut.length


def _middle(cut: Prism | Bore) -> tuple[float, float]:
    if isinstance(cut, Bore):
        u, v = (place for axis, place in zip(AXES, cut.start, strict=True) if axis != cut.axis)
        return u, v
    x, z = zip(*(s.start for s in cut.outline), strict=True)
    return (min(x) + max(x)) / 2, (min(z) + max(z)) / 2


def _circle(bore: Bore) -> Loop:
    """A bore's narrow end as two half circles, mm."""
    (u, v), radius = _middle(bore), min(bore.radius, bore.far_radius)
    left, right = Point(u - radius, v), Point(u + radius, v)
    return Segment(left, right, 1.0), Segment(right, left, 1.0)


def _seen(loop: Loop, axis: Axis, view: View) -> Loop:
    """A loop of a prism's section as a view shows it, counterclockwise again where that mirrors it."""

    def at(point: Point) -> Point:
        u, v = point.x, point.z
        placed: dict[Axis, Vector] = {"x": (0.0, u, v), "y": (u, 0.0, v), "z": (u, v, 0.0)}
        return Point(*view.at(placed[axis]))

    ahead = tuple(replace(s, start=at(s.start), end=at(s.end)) for s in loop)
    behind = view.towards[AXES.index(axis)] < 0.0
    if behind == (axis == "y"):  # (x, z) is seen unmirrored from -y
        return ahead
    return tuple(replace(s, start=s.end, end=s.start) for s in reversed(ahead))


ROW_GAP = 2.0  # mm, assumption: between strips on the cutting pattern
# mm, assumption: of a strip's tail, by which its shim draws it in; it is cut off afterwards
GLUED_LENGTH = 5.0
TAB = (8.0, 3.0)  # mm, assumption: length and width of a tab that a weight hangs on and that is cut off
HOLE = 0.75  # mm, assumption: radius of a tab's hole for the weight's hook


class Line(NamedTuple):
    """A line to be marked, mm."""

    start: Point
    end: Point


@dataclass(frozen=True)
class StripPattern:
    """One strip: closed outlines in mm of film, of what is left once it is trimmed, of holes, metal of both
    faces, where that overlaps, and pads; what is marked, and where on its tab label and + sign begin."""

    label: str
    cut: Loop
    trimmed: Loop
    holes: tuple[Loop, ...]
    front: Loop
    back: Loop
    overlap: Loop
    pads: tuple[Loop, ...]
    cut_off: tuple[Line, ...]
    label_at: Point
    plus_at: Point


def strip_patterns(design: Design) -> list[StripPattern]:
    """Return the pattern of every strip, ridge by ridge from the drawing's foot up; none without film.

    Strips of a skin that is curved along y too are cut straight, each as long as its slot's arc: the slot
    bends them on edge by what `pattern_notes` says.
    """
    design = scaled_for_shrinkage(design) if design.mold.method == "cast-in" else design
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
        "seen from the + side, which faces +x in every slot, the front; end a left, b right, ridges below",
        f"leads at end {wiring}, where the corner at the ridge is cut off; draw axis (d31) along the strips",
        "back: as seen through the film, so mirror it when that face lies up; let metal go on beyond the cut",
        "CUT at nominal size, kerf not compensated; ENGRAVE stays to be read, cut off at MARK later",
        f"pads: {PAD[0]:g} x {PAD[1]:g} mm, one a face, pitch {PITCH:g} mm: flat cable crimps, clinchers",
    ]


def _arc(design: Design, slot: SensorPlace) -> float:
    """A slot's arc along y by skin.length: 1 where it is straight."""
    radius = design.skin.curvature_radius_y
    return 1.0 if radius is None else 1 + (slot.centre.z - design.skin.thickness) / radius


def _edge_strain(design: Design) -> float:
    """Strain of a straight strip's edges in a slot that is bent along y."""
    slot = skin_of(design).slot
    radius = design.skin.curvature_radius_y
    return 0.0 if radius is None or slot is None else slot.depth / 2 / radius


def row_height(design: Design) -> float:
    """Return the height of one strip on the drawing, mm: its tab's."""
    slot = skin_of(design).slot
    return 2 * half_tab(design.film, slot.depth) if design.film and slot else 0.0


def _pattern(design: Design, film: Film, slot: SensorPlace, middle: float) -> StripPattern:
    """One strip about z = `middle`, drawn with its wiring side at +x and mirrored where that is end a."""
    half, h = design.skin.length / 2 * _arc(design, slot), slot.depth / 2
    wired_a, cast_in = film.wiring_side == "a", design.mold.method == "cast-in"
    a, b = strip_overhangs(design)
    wired, other = (half + a, half + b) if wired_a else (half + b, half + a)
    end, w, metal = wired + tab(film)[1], half_tab(film, slot.depth), faces(film, slot.depth, half, wired)
    left, right = (
        -other - (SHOULDER + TAB[0] if cast_in else GLUED_LENGTH),
        end + (4 * HOLE if cast_in else 0.0),
    )
    tail = _tail(left, -other, h) if cast_in else [(left, -h, 0.0), (left, h, 0.0)]
    cuts = [(-other, h), *([(end, w - CORNER)] if cast_in else [])]

    def placed(outline: Loop) -> Loop:
        return tuple(_shifted(s, middle) for s in (mirrored(outline) if wired_a else outline))

    side, text, up = -1.0 if wired_a else 1.0, wired + SHOULDER + EDGE / 2, label_offset(slot.depth)
    text = -text - LABEL[0] if wired_a else text
    return StripPattern(
        label=f"{slot.feature} {slot.side}",
        cut=placed(_path([*_tab(wired, end, right, h, w), *tail[len(tail) // 2 :], *tail[: len(tail) // 2]])),
        trimmed=placed(_path([*_tab(wired, end, end, h, w), (-other, h, 0.0), (-other, -h, 0.0)])),
        holes=tuple(placed(_hole(x)) for x in (left + 2 * HOLE, right - 2 * HOLE) if cast_in),
        front=placed(metal.front),
        back=placed(metal.back),
        overlap=placed(metal.overlap),
        pads=tuple(placed(pad) for pad in metal.pads),
        cut_off=tuple(Line(Point(side * x, middle - u), Point(side * x, middle + u)) for x, u in cuts),
        label_at=Point(text, middle + up),
        plus_at=Point(text, middle - up - LABEL[1]),
    )


Corner = tuple[float, float, float]  # x, z, and bulge of the segment that begins there
INWARD = -math.tan(math.pi / 8)  # the bulge of a quarter circle, inward


def _tab(start: float, end: float, right: float, h: float, w: float) -> list[Corner]:
    """The wiring end from its lower side to its upper: a filleted tab of half width `w` whose corner at the
    ridge's side is cut off, which marks a strip's sides; and, cast in, beyond `end` a narrower piece for a
    weight."""
    r, k, u = SHOULDER, INWARD, w - CORNER
    tongue = [(end, -u, 0.0), (right, -u, 0.0), (right, u, 0.0), (end, u, 0.0)] if right > end else []
    return [
        *[(start, -h, k), (start + r, -h - r, 0.0), (start + r, -w, 0.0), (end - CORNER, -w, 0.0)],
        *(tongue or [(end, -u, 0.0)]),
        *[(end, w, 0.0), (start + r, w, 0.0), (start + r, h + r, k), (start, h, 0.0)],
    ]


def _tail(left: float, start: float, h: float) -> list[Corner]:
    """The other end's tab, from its left, lower side to its upper, which ends at `start` and is cut off."""
    r, k, u = SHOULDER, INWARD, max(TAB[1] / 2, h + SHOULDER)
    lower = [(left, -u, 0.0), (start - r, -u, 0.0), (start - r, -h - r, k), (start, -h, 0.0)]
    return [*lower, (start, h, k), (start - r, h + r, 0.0), (start - r, u, 0.0), (left, u, 0.0)]


def _path(corners: list[Corner]) -> Loop:
    """Return the closed loop through corners (x, z, bulge of the segment that begins there)."""
    following = [*corners[1:], corners[0]]
    return tuple(
        Segment(Point(x, z), Point(u, v), bulge)
        for (x, z, bulge), (u, v, _) in zip(corners, following, strict=True)
        if (x, z) != (u, v)
    )


def _hole(x: float) -> Loop:
    return _path([(x - HOLE, 0.0, 1.0), (x + HOLE, 0.0, 1.0)])


def _shifted(segment: Segment, up: float) -> Segment:
    (x, z), (u, v) = segment.start, segment.end
    return replace(segment, start=Point(x, z + up), end=Point(u, v + up))
