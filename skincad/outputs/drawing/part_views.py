"""The views of a part on its sheet, in first-angle arrangement, with dimensions, datums and tagged holes.

Threads are drawn by ISO 6410-1; of hidden edges that would run together one is drawn. A hole's tag stands
beside it where it covers no other words and circles, and few lines.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skincad.base.arrays import Array
from skincad.fabrication.drawn_features import ABOVE, FRONT, LEFT, HoleGroup, SideView, number
from skincad.fabrication.fasteners import major
from skincad.fabrication.part_drawing import NUT, PartDrawing
from skincad.outputs.drawing.marks import (
    Box,
    Dimension,
    Fill,
    Ink,
    Mark,
    Words,
    diameter,
    line,
    linear,
    moved,
    overlap,
    rectangle,
    width,
)
from skincad.solids.projection import Arc, Place, Polyline, Projection, Stroke

FIRST, NEXT = 9.5, 6.0  # mm, of a dimension's line from the view, and of the next one from it
BETWEEN, UNDER = 17.0, 22.0  # mm, between front and left view; between front view and that from above
FOOT, RIGHT = 12.0, 8.0  # mm, under the lowest view, and right of the last
DIMENSION_LINE_COST = 6.0  # assumption: cost of words on a dimension's line, by their cost on an edge
TAG, SIZE = 1.8, 2.0  # mm, height of capitals
RIM = 0.2  # mm, of a circle that no tag comes nearer to
ANGLES = tuple(math.radians(a) for a in (45, 135, -45, -135, 20, 160, -20, -160, 70, 110, -70, -110))
REACHES = (3.2, 4.5, 6.5, 9.0, 12.0, 16.0)  # mm, from a circle's rim to its tag's foot: past the arrow
LINE, FAR, WORD = 1.0, 0.25, 40.0  # assumption: cost of a crossed line, a millimetre further, a covered word
CLEAR = 0.6  # mm, of a tag from lines and other words
LEADER = 6  # points of a leader that are tested for collisions
OVERSHOOT = 1.0  # mm of paper, of a centre line beyond the bore
THREE_QUARTERS = math.radians(100.0), math.radians(270.0)  # start and sweep of a thread's circle
MIN_SPACING = 0.6  # mm, assumption: parallel hidden edges nearer than this are one on paper


def size_of(drawing: PartDrawing, scale: float) -> tuple[float, float]:
    """Return width and height of the views with their dimensions on paper, mm."""
    (fw, fh), (_, ah), (lw, _) = (_extent(drawing.views[name], scale) for name in (FRONT, ABOVE, LEFT))
    left, top = _margins(drawing)
    return left + fw + BETWEEN + lw + RIGHT, top + fh + UNDER + ah + FOOT


def corner_of(drawing: PartDrawing, scale: float) -> tuple[float, float]:
    """Return how far the corner that the three views leave free is from their upper left one, mm."""
    wide, tall = _extent(drawing.views[FRONT], scale)
    left, top = _margins(drawing)
    return left + wide, top + tall


def _extent(projection: Projection, scale: float) -> tuple[float, float]:
    (left, low), (right, high) = projection.box()
    return scale * (right - left), scale * (high - low)


def _margins(drawing: PartDrawing) -> tuple[float, float]:
    """Room for dimensions at the left of the views and over them, mm."""
    counts = [sum(1 for one in drawing.lengths if (one.view, one.way) == (FRONT, way)) for way in "vu"]
    left, top = (FIRST + NEXT * max(count - 1, 0) + 5.0 for count in counts)
    return left, top


def view_marks(
    drawing: PartDrawing, placements: dict[str, ViewPlacement], area: Box, blocked: Box
) -> list[Mark]:
    """Return the views as they lie, with dimensions, datums and tags, all within an area, mm, and none of
    their tags on the `blocked` rectangle."""
    room, marks = Room(area), list[Mark]()
    room.block(blocked)
    for name, place in placements.items():
        marks += _strokes(drawing.views[name], place, room)
        left, low, right, _ = place.box(drawing.views[name])
        marks.append(Words(drawing.captions[name], ((left + right) / 2, low - 4.5), TAG, "TEXT", "middle"))
    marks += _datums(drawing, placements)
    marks += _lengths(drawing, placements)
    for mark in marks:
        if isinstance(mark, Words):
            room.block(mark.box())
        elif isinstance(mark, Dimension):
            room.block(mark.words.box())
            for part in mark.drawn:
                if isinstance(part, Ink):
                    room.cross(part.stroke, DIMENSION_LINE_COST)
    return [*marks, *bore_marks(drawing.holes, placements), *_tags(drawing, placements, room)]


def places(drawing: PartDrawing, scale: float, area: Box) -> dict[str, ViewPlacement]:
    """Return where the views lie, from the upper left corner of an area, mm."""
    margin = _margins(drawing)
    left, high = area[0] + margin[0], area[3] - margin[1]
    (x, y), (x1, y1) = drawing.views[FRONT].box()
    front = ViewPlacement((left - scale * x, high - scale * y1), scale)
    right, low = left + scale * (x1 - x), high - scale * (y1 - y)
    (_, _), (_, a1) = drawing.views[ABOVE].box()
    (l0, _), _ = drawing.views[LEFT].box()
    above = ViewPlacement((front.origin[0], low - UNDER - scale * a1), scale)
    left_view = ViewPlacement((right + BETWEEN - scale * l0, front.origin[1]), scale)
    return {FRONT: front, ABOVE: above, LEFT: left_view}


def _strokes(projection: Projection, place: ViewPlacement, room: Room) -> list[Mark]:
    marks: list[Mark] = []
    visible = [place.stroke(s) for s in projection.visible]
    hidden = thinned([place.stroke(s) for s in projection.hidden], visible)
    for strokes, layer, weight in ((visible, "OUTLINE", 6.0), (hidden, "HIDDEN", 0.6)):
        for stroke in strokes:
            marks.append(Ink(stroke, layer))
            room.cross(stroke, weight)
    return marks


def _lengths(drawing: PartDrawing, placements: dict[str, ViewPlacement]) -> list[Mark]:
    """The dimensions: the longest of a side is outermost."""
    marks: list[Mark] = []
    for name, place in placements.items():
        projection = drawing.views[name]
        left, _, _, high = place.box(projection)
        for way in ("u", "v"):
            lengths = sorted(
                (one for one in drawing.lengths if (one.view, one.way) == (name, way)),
                key=lambda one: one.high - one.low,
            )
            for i, one in enumerate(lengths):
                out = FIRST + NEXT * i
                words = f"{one.words} {number(one.high - one.low)}".strip()
                if way == "u":
                    ends = [(place.at((v, 0.0))[0], high) for v in (one.low, one.high)]
                else:
                    ends = [(left, place.at((0.0, v))[1]) for v in (one.low, one.high)]
                away = high + out if way == "u" else left - out
                marks.append(linear((ends[0], ends[1]), away, way == "u", place.scale, words, SIZE))
    return marks


def _datums(drawing: PartDrawing, placements: dict[str, ViewPlacement]) -> list[Mark]:
    """Datum letters in boxes on a triangle (ISO 5459), at the edges at which the faces are seen."""
    marks: list[Mark] = []
    for datum in drawing.datums:
        left, low, right, high = placements[datum.view].box(drawing.views[datum.view])
        x, y, way = {
            "bottom": (left + 0.88 * (right - left), low, (0.0, -1.0)),
            "top": (left + 0.88 * (right - left), high, (0.0, 1.0)),
            "left": (left, low + 0.22 * (high - low), (-1.0, 0.0)),
            "right": (right, low + 0.22 * (high - low), (1.0, 0.0)),
        }[datum.edge]
        (u, v), (tip, end, middle) = way, (moved((x, y), way, far) for far in (1.6, 3.4, 5.2))
        marks.append(Fill(((x - 1.0 * v, y + 1.0 * u), (x + 1.0 * v, y - 1.0 * u), tip), "DIMENSIONS"))
        marks.append(line(tip, end, "DIMENSIONS"))
        box = middle[0] - 1.8, middle[1] - 1.8, middle[0] + 1.8, middle[1] + 1.8
        words = Words(datum.letter, (middle[0], middle[1] - 1.0), SIZE, "DIMENSIONS", "middle")
        marks += [rectangle(box, "DIMENSIONS"), words]
    return marks


def _tags(drawing: PartDrawing, placements: dict[str, ViewPlacement], room: Room) -> list[Mark]:
    """Every hole's diameter with its tag; the first of a group says how many there are, and their size."""
    rows = [
        (placements[group.view], group, at, _tag_text(group, i, tag))
        for group in drawing.holes
        for i, (tag, at) in enumerate(group.holes.items())
    ]
    for place, group, at, _ in rows:
        (x, y), r = place.at(at), place.scale * max(group.diameter, group.far_diameter) / 2 + RIM
        room.block((x - r, y - r, x + r, y + r))
    room.settle()
    marks: list[Mark] = []
    for place, group, at, text in sorted(rows, key=lambda row: -width(row[3], TAG)):
        centre, size = place.at(at), (group.diameter, place.scale)
        marks.append(tagged(centre, place.scale * group.diameter / 2, text, size, TAG, room))
    for i, pocket in enumerate(drawing.pockets):
        place, flats = placements[FRONT], pocket.flats
        text = f"{NUT}{i + 1}" if i else f"{NUT}1 {len(drawing.pockets)}x hexagon {number(flats)}"
        size = (flats, place.scale)
        leader = tagged(place.at(pocket.at), place.scale * flats / 2, text, size, TAG, room)
        marks += [*leader.drawn, leader.words]
    return marks


def _tag_text(group: HoleGroup, index: int, tag: str) -> str:
    if index:
        return tag
    count = f"{len(group.holes)}x" if len(group.holes) > 1 else ""
    return " ".join(t for t in (tag, count, group.size, group.thread) if t)


class Room:
    """Occupied places of a sheet: boxes of words and circles, and strokes; grows as words are placed."""

    def __init__(self, limits: Box) -> None:
        self.limits = limits
        self.blocked: list[Box] = []
        self._lines: list[tuple[float, float, float, float, float]] = []

    def block(self, box: Box) -> None:
        """Add a rectangle that words must not cover, mm."""
        self.blocked.append(box)

    def cross(self, stroke: Stroke, weight: float = 1.0) -> None:
        """Add a stroke that words should not cross; `weight` is its cost."""
        points = (
            stroke.points if isinstance(stroke, Polyline) else tuple(stroke.at(i / 12) for i in range(13))
        )
        for (x, y), (u, v) in pairwise(points):
            self._lines.append((min(x, u), min(y, v), max(x, u), max(y, v), weight))

    def settle(self) -> None:
        """Prepare the strokes for `cost`."""
        self._boxes: Array = np.array(self._lines or [(0.0, 0.0, -1.0, -1.0, 0.0)])

    def cost(self, box: Box) -> float:
        """Return the cost of words in a rectangle."""
        left, low, right, high = self.limits
        if box[0] < left or box[1] < low or box[2] > right or box[3] > high:
            return 10 * WORD
        b = self._boxes
        crossed = (b[:, 0] < box[2]) & (b[:, 2] > box[0]) & (b[:, 1] < box[3]) & (b[:, 3] > box[1])
        return LINE * min(30.0, float(b[crossed, 4].sum())) + WORD * self.covered(box)

    def covered(self, box: Box) -> int:
        """Return how many blocked rectangles share more than an edge with this one."""
        return sum(overlap(box, other) for other in self.blocked)

    def pierced(self, points: list[Place], centre: Place) -> int:
        """Return how many blocked rectangles hold one of these points, without those that hold `centre`."""
        return sum(
            any(_inside(box, point) for point in points) for box in self.blocked if not _inside(box, centre)
        )


def _inside(box: Box, point: Place) -> bool:
    return box[0] < point[0] < box[2] and box[1] < point[1] < box[3]


def tagged(
    centre: Place, radius: float, text: str, measured: tuple[float, float], height: float, room: Room
) -> Dimension:
    """Return a circle's diameter with its tag where it costs least. `measured`: the part's diameter, mm, and
    the view's scale."""
    best: tuple[float, float, Words] | None = None
    for reach in REACHES:
        for angle in ANGLES:
            way = math.cos(angle), math.sin(angle)
            x, y = moved(centre, way, radius + reach)
            words = Words(text, (x, y + 0.4), height, "DIMENSIONS", "start" if way[0] > 0 else "end")
            left, low, right, high = words.box()
            cost = room.cost((left - CLEAR, low - CLEAR, right + CLEAR, high + CLEAR)) + FAR * reach
            leader = [radius + reach * i / LEADER for i in range(1, LEADER + 1)]
            cost += WORD * room.pierced([moved(centre, way, r) for r in leader], centre)
            if best is None or cost < best[0] - 1e-9:
                best = cost, angle, words
        if best and best[0] < LINE + FAR * reach:
            break
    if best is None:
        raise ValueError("there are angles and reaches to choose from")
    _, angle, words = best
    room.block(words.box())
    return replace(diameter(centre, radius, angle, measured[1], words), measured=measured[0])


class ViewPlacement(NamedTuple):
    """A view on paper: `origin` mm is where its (0, 0) lies, `scale` paper by part."""

    origin: Place
    scale: float

    def at(self, point: Place) -> Place:
        """Return a view's point on paper, mm."""
        return self.origin[0] + self.scale * point[0], self.origin[1] + self.scale * point[1]

    def stroke(self, stroke: Stroke) -> Stroke:
        """Return a view's stroke on paper."""
        if isinstance(stroke, Arc):
            return Arc(self.at(stroke.centre), self.scale * stroke.radius, stroke.start, stroke.sweep)
        return Polyline(tuple(self.at(point) for point in stroke.points))

    def box(self, projection: Projection) -> Box:
        """Return the rectangle of a view on paper, mm."""
        low, high = projection.box()
        return (*self.at(low), *self.at(high))


def bore_marks(holes: tuple[HoleGroup, ...], placements: dict[str, ViewPlacement]) -> list[Mark]:
    """Return the bores' centre lines, from their ends and sides, and their threads."""
    marks: list[Mark] = []
    for group in holes:
        place, wide = placements[group.view], major(group.thread)
        for at in group.holes.values():
            centre = place.at(at)
            (x, y), out = centre, place.scale * max(group.diameter, group.far_diameter) / 2 + OVERSHOOT
            marks.append(line((x - out, y), (x + out, y), "CENTRE"))
            marks.append(line((x, y - out), (x, y + out), "CENTRE"))
            if wide is not None:
                marks.append(Ink(Arc(centre, place.scale * wide / 2, *THREE_QUARTERS), "THREAD"))
        for side_view in group.side_views:
            marks += _bore_side(side_view, placements[side_view.view], wide and wide / 2, group)
    return marks


def _bore_side(
    side_view: SideView, place: ViewPlacement, radius: float | None, group: HoleGroup
) -> list[Mark]:
    """A bore's centre line from the side, and its thread's lines: hidden, so broken. Where the thread ends
    before the bore does, a line across says so."""
    start, end = place.at(side_view.start), place.at(side_view.end)
    long = math.dist(start, end)
    u, v = (end[0] - start[0]) / long, (end[1] - start[1]) / long
    tail, head = moved(start, (u, v), -OVERSHOOT), moved(end, (u, v), OVERSHOOT)
    marks: list[Mark] = [line(tail, head, "CENTRE")]
    if radius is None:
        return marks
    if group.full is not None:  # blind, from above: its mouth is where the bore ends
        start = moved(end, (u, v), -group.full * place.scale)
    out = -radius * place.scale * v, radius * place.scale * u
    sides = [(moved(start, out, s), moved(end, out, s)) for s in (-1, 1)]
    marks += [line(*side, "HIDDEN") for side in sides]
    if group.full is not None:
        marks.append(line(sides[0][0], sides[1][0], "HIDDEN"))
    return marks


def thinned(hidden: Iterable[Stroke], visible: Iterable[Stroke]) -> list[Stroke]:
    """Return hidden edges without those that would run together on paper: nearer than `MIN_SPACING` mm to
    a parallel one that is drawn, all along."""
    strokes: list[Stroke] = []
    lines: list[tuple[float, float, float, float]] = []  # direction, offset, from, to

    def covered(chain: Polyline) -> bool:
        angle, offset, low, high = _straight(chain)
        for other, at, start, end in lines:
            turn = abs((angle - other + math.pi / 2) % math.pi - math.pi / 2)
            within = start - MIN_SPACING < low and high < end + MIN_SPACING
            if turn < 0.05 and abs(at - offset) < MIN_SPACING and within:
                return True
        return False

    for stroke in visible:
        if isinstance(stroke, Polyline) and len(stroke.points) == 2:
            lines.append(_straight(stroke))
    for stroke in sorted(hidden, key=_long, reverse=True):
        if isinstance(stroke, Polyline) and len(stroke.points) == 2:
            if covered(stroke):
                continue
            lines.append(_straight(stroke))
        elif isinstance(stroke, Polyline) and _long(stroke) < MIN_SPACING:
            continue
        strokes.append(stroke)
    return strokes


def _straight(chain: Polyline) -> tuple[float, float, float, float]:
    """A line's direction, rad, its distance from the sheet's corner and its ends along it, mm."""
    (x, y), (u, v) = chain.points[0], chain.points[-1]
    angle = math.atan2(v - y, u - x) % math.pi
    if math.pi - angle < 1e-6:
        angle = 0.0
    c, s = math.cos(angle), math.sin(angle)
    ends = sorted((x * c + y * s, u * c + v * s))
    return angle, y * c - x * s, ends[0], ends[1]


def _long(stroke: Stroke) -> float:
    (left, low), (right, high) = stroke.box()
    return math.hypot(right - left, high - low)
