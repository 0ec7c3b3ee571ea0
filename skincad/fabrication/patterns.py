"""Patterns that are cut from sheet or through a part: film strips, shims, the foam under the cover, profiles.

Strips are drawn as they lie in the mold, each in its own row, seen from +x with the + side, the front, facing
you: x in the drawing is the mold's y (end a left, end b right, 0 in the skin's middle), ridges' tips are
below. The draw axis runs along the strips (assumption), so that the tension pulls along it and d31 is that of
stress along the ridges. The wiring end has a tab with the pads, which stays and carries number and + sign.
What is cut off is at the other end: the tail that a shim draws in (that end goes through the slot, first), or
the tab for a weight.

A wire, a laser or a router follows a profile; kerf and spark gap are the machine's to compensate. A conical
hole is in it with its narrow end, to be reamed afterwards. Blind and crosswise cuts are not: the sheet's
tables have them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from skincad.fabrication.drawn_features import views
from skincad.fabrication.electrodes import (
    CORNER,
    EDGE,
    LABEL,
    PAD,
    SHOULDER,
    faces,
    half_tab,
    label_offset,
    tab,
)
from skincad.fabrication.job import Job
from skincad.fabrication.papers import macro
from skincad.fabrication.strips import edge_strain, lap
from skincad.inputs.design import Design
from skincad.inputs.skin_tables import Film
from skincad.shape.curves import Loop, Point, Segment, area, rectangle
from skincad.shape.feature import SensorPlace
from skincad.shape.skin import section
from skincad.solids.inserts import GRIP, PITCH, strip_overhangs
from skincad.solids.layout import SQUEEZED_SHARE
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import (
    Axis,
    Body,
    Bore,
    Part,
    PartRole,
    Prism,
    RevolvedBody,
    Vector,
    mirrored,
    unturned,
)
from skincad.solids.projection import View

FLUSH_TOLERANCE = 1e-9  # mm, within which a cut reaches a face: rounding
PLACES = 6  # decimals of a millimetre within which cuts are in line
AXES: tuple[Axis, ...] = ("x", "y", "z")
LABEL_DISTANCE = 5.0  # mm, of a label beside its shim
ROW_GAP = 2.0  # mm, assumption: between strips on the cutting pattern
# mm, assumption: of a strip's tail, by which its shim draws it in; it is cut off afterwards
GLUED_LENGTH = 5.0
TAB = (8.0, 3.0)  # mm, assumption: length and width of a tab that a weight hangs on and that is cut off
HOLE = 0.75  # mm, assumption: radius of a tab's hole for the weight's hook
Corner = tuple[float, float, float]  # x, z, and bulge of the segment that begins there
INWARD = -math.tan(math.pi / 8)  # the bulge of a quarter circle, inward


# The view that looks along a body's axis, and the profile in it, mm: outline first, then holes, all
# counterclockwise
CutProfile = tuple[str, tuple[Loop, ...]]


def cut_profile(part: Part) -> CutProfile | None:
    """Return the profile of a part whose body is a prism; None for any other body."""
    plain = unturned(part)
    body = plain.body
    if not isinstance(body, Prism):
        return None
    index = AXES.index(body.axis)
    seen = next(view for view in views(part) if abs(view.of_part.towards[index]) == 1.0)
    loops = [body.outline, *body.holes, *_through(plain.cuts, body)]
    return seen.name, tuple(_seen(loop, body.axis, seen.of_part) for loop in loops)


def pattern_words(name: str, **facts: Any) -> list[str]:
    """Return what is written on a pattern: the lines of a macro of templates/papers/pattern-notes.md."""
    return macro("papers/pattern-notes.md", name, PAD=PAD, PITCH=PITCH, **facts).splitlines()


def _through(cuts: tuple[Body, ...], body: Prism) -> tuple[Loop, ...]:
    """The loops of what goes from face to face of a prism: by itself, or a hole with the pocket that it ends
    in; the narrowest of what is in line."""
    rows: dict[tuple[float, float], list[Prism | Bore]] = {}
    for cut in cuts:
        if isinstance(cut, Prism | Bore) and cut.axis == body.axis:
            u, v = _middle(cut)
            rows.setdefault((round(u, PLACES), round(v, PLACES)), []).append(cut)
    loops = ([_outline(cut) for cut in row] for row in rows.values() if _spans(row, body))
    return tuple(min(row, key=area) for row in loops)


def _spans(row: list[Prism | Bore], body: Prism) -> bool:
    """Whether cuts in line with each other go through without a gap."""
    reached = body.low
    for low, high in sorted(map(_range, row)):
        reached = max(reached, high) if low <= reached + FLUSH_TOLERANCE else reached
    return reached >= body.high - FLUSH_TOLERANCE


def _outline(cut: Prism | Bore) -> Loop:
    """A cut's loop; a bore's narrow end as two half circles, mm."""
    if isinstance(cut, Prism):
        return cut.outline
    (u, v), radius = _middle(cut), min(cut.radius, cut.far_radius)
    return _path([(u - radius, v, 1.0), (u + radius, v, 1.0)])


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
    cut_off: tuple[tuple[Point, Point], ...]
    label_at: Point
    plus_at: Point


def strip_patterns(job: Job) -> list[StripPattern]:
    """Return the pattern of every strip, ridge by ridge from the drawing's foot up; none without film.

    Strips of a skin that is curved along y too are cut straight, each as long as its slot's arc: the slot
    bends them on edge by what `pattern_notes` says.
    """
    design = job.cast if job.design.mold.method == "cast-in" else job.design
    film, shape = design.film, section(design)
    if film is None:
        return []
    pitch = row_height(job) + ROW_GAP
    middles = [row_height(job) / 2 + index * pitch for index in range(len(shape.slots))]
    return [_pattern(design, film, s, z) for s, z in zip(shape.slots, middles, strict=True)]


def pattern_notes(job: Job) -> list[str]:
    """Return what is written under the pattern; call it where there is film."""
    return pattern_words("strips", job=job, strain=edge_strain(job))


def row_height(job: Job) -> float:
    """Return the height of one strip on the drawing, mm: its tab's."""
    slot = job.skin.slot
    return 2 * half_tab(job.design.film, slot.depth) if job.design.film and slot else 0.0


def _pattern(design: Design, film: Film, slot: SensorPlace, middle: float) -> StripPattern:
    """One strip about z = `middle`, drawn with its wiring side at +x and mirrored where that is end a."""
    arc = 1 + (slot.centre.z - design.skin.thickness) / design.skin.radius_y  # the slot's along y
    half, h = arc * design.skin.length / 2, slot.depth / 2
    wired_a, cast_in = film.wiring_side == "a", design.mold.method == "cast-in"
    a, b = strip_overhangs(design)
    wired, other = (half + a, half + b) if wired_a else (half + b, half + a)
    end, w = wired + tab(film)[1], half_tab(film, slot.depth)
    front, back, overlap, pads = faces(film, slot.depth, half, wired)
    left = -other - (SHOULDER + TAB[0] if cast_in else GLUED_LENGTH)
    right = end + (4 * HOLE if cast_in else 0.0)
    tail = _tail(left, -other, h) if cast_in else [(left, -h, 0.0), (left, h, 0.0)]
    cuts = [(-other, h), *([(end, w - CORNER)] if cast_in else [])]

    def placed(outline: Loop) -> Loop:
        rows = ((s, s.start, s.end) for s in (mirrored(outline) if wired_a else outline))
        return tuple(
            replace(s, start=Point(a.x, a.z + middle), end=Point(b.x, b.z + middle)) for s, a, b in rows
        )

    side, text, up = -1.0 if wired_a else 1.0, wired + SHOULDER + EDGE / 2, label_offset(slot.depth)
    text = -text - LABEL[0] if wired_a else text
    return StripPattern(
        label=f"{slot.feature} {slot.side}",
        cut=placed(_path([*_tab(wired, end, right, h, w), *tail[len(tail) // 2 :], *tail[: len(tail) // 2]])),
        trimmed=placed(_path([*_tab(wired, end, end, h, w), (-other, h, 0.0), (-other, -h, 0.0)])),
        holes=tuple(placed(_hole(x)) for x in (left + 2 * HOLE, right - 2 * HOLE) if cast_in),
        front=placed(front),
        back=placed(back),
        overlap=placed(overlap),
        pads=tuple(placed(pad) for pad in pads),
        cut_off=tuple((Point(side * x, middle - u), Point(side * x, middle + u)) for x, u in cuts),
        label_at=Point(text, middle + up),
        plus_at=Point(text, middle - up - LABEL[1]),
    )


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


class ShimPattern(NamedTuple):
    """One shim: its ridge and slot, its outline, and the line at which a tail begins that is thinned; None
    where it is not. The tail is at +x. The label's foot is at `label_at`."""

    label: str
    cut: Loop
    thinned: tuple[Point, Point] | None
    label_at: Point


def shim_patterns(job: Job) -> list[ShimPattern]:
    """Return the shims of one skin, ridge 1 first, one above the other; none where strips are cast in."""
    slot, joint = job.skin.slot, lap(job)
    if slot is None or job.design.mold.method == "cast-in":
        return []
    thin = joint is not None and joint.tail < slot.thickness
    bodies = [part.body for part in job.closed.of(PartRole.SHIM)]
    pairs = zip(job.section.slots, bodies, strict=False)  # of a gang the first skin's
    rows = []
    for number, (place, body) in enumerate(pairs):
        label, pitch = f"{place.feature} {place.side}", slot.depth + ROW_GAP
        if isinstance(body, RevolvedBody):
            radius = arc_radius(job, place.feature, place.side)
            half = (body.high - body.low) * abs(place.direction.z) / 2
            centre = number * pitch / math.cos(half) - radius
            inner, outer = radius - slot.depth / 2, radius + slot.depth / 2
            cut, foot = _sector(inner, outer, half, centre), _at(inner, -half, centre)
            tail = half - GRIP / radius
            tail_line = _at(inner, tail, centre), _at(outer, tail, centre)
        else:
            long, low = shim_length(job) / 2, number * pitch - slot.depth / 2
            cut, foot = rectangle(-long, long, low, low + slot.depth), Point(-long, low)
            tail_line = Point(long - GRIP, low), Point(long - GRIP, low + slot.depth)
        rows.append(
            ShimPattern(label, cut, tail_line if thin else None, Point(foot.x - LABEL_DISTANCE, foot.z))
        )
    return rows


def _at(radius: float, angle: float, centre: float) -> Point:
    """A point at this angle from the upright, rad, about (0, centre)."""
    return Point(radius * math.sin(angle), centre + radius * math.cos(angle))


def _sector(inner: float, outer: float, half: float, centre: float) -> Loop:
    """Part of a ring about (0, centre), from -half to half of the upright, rad."""
    a, b = _at(outer, half, centre), _at(outer, -half, centre)
    c, d = _at(inner, -half, centre), _at(inner, half, centre)
    bulge = math.tan(half / 2)
    return Segment(a, b, bulge), Segment(b, c), Segment(c, d, -bulge), Segment(d, a)


def seal_pattern(closed: ClosedMold) -> tuple[tuple[Loop, ...], list[str]]:
    """Return a seal's outline and then its holes, seen from above with end b up, mm, and what is said of it.

    Raises ValueError where the mold has none.
    """
    seal = closed.first(PartRole.SEAL)
    profile = cut_profile(seal)
    if profile is None or not isinstance(seal.body, Prism):
        raise ValueError("a seal is cut from a sheet")
    high = seal.body.high - seal.body.low
    return profile[1], pattern_words("seal", high=high, SQUEEZED_SHARE=SQUEEZED_SHARE)


def arc_length(closed: ClosedMold) -> float:
    """Return how long the longest shim of a doubly curved mold is along its outer edge, mm."""
    arcs = [part.body for part in closed.of(PartRole.SHIM) if isinstance(part.body, RevolvedBody)]
    return max((arc.high - arc.low) * (arc.centre - min(s.start.z for s in arc.outline)) for arc in arcs)


def arc_radius(job: Job, ridge: int, side: str) -> float:
    """Return the radius of a slot's shim laid flat, mm: it is a part of a cone whose lines run along its
    depth, so the distance along them from the axis to the middle of the depth."""
    base = job.cast.skin
    slot = next(s for s in section(job.cast).slots if (s.feature, s.side) == (ridge, side))
    return (base.radius_y - base.thickness + slot.centre.z) / abs(slot.direction.z)


def shim_length(job: Job) -> int:
    """Return how long a shim is, whole mm: it stands out at both ends; along its arc in a bent mold."""
    if job.bent:
        return math.ceil(arc_length(job.closed))
    return math.ceil(job.cast.skin.length + 2 * job.design.mold.end_plate + 2 * GRIP)
