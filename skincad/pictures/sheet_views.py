"""The views of a part on its sheet, in first-angle arrangement, with dimensions, datums and tagged holes."""

from __future__ import annotations

from skincad.fabrication.bore_table import HoleGroup, number
from skincad.fabrication.drawing_views import ABOVE, FRONT, LEFT
from skincad.fabrication.part_drawing import NUT, PartDrawing
from skincad.pictures.hidden_edges import thinned
from skincad.pictures.marks import (
    Box,
    Dimension,
    Fill,
    Ink,
    Mark,
    Words,
    line,
    linear,
    rectangle,
    width,
)
from skincad.pictures.sheet_bores import ViewPlacement, bore_marks
from skincad.pictures.tags import Room, tagged
from skincad.solids.projection import Projection

FIRST, NEXT = 9.5, 6.0  # mm, of a dimension's line from the view, and of the next one from it
BETWEEN, UNDER = 17.0, 22.0  # mm, between front and left view; between front view and that from above
FOOT, RIGHT = 12.0, 8.0  # mm, under the lowest view, and right of the last
DIMENSION_LINE_COST = 6.0  # assumption: cost of words on a dimension's line, by their cost on an edge
TAG, SIZE = 1.8, 2.0  # mm, height of capitals
RIM = 0.2  # mm, of a circle that no tag comes nearer to


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
        box = place.box(drawing.views[name])
        marks.append(_caption(drawing.captions[name], box))
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


def _caption(text: str, box: Box) -> Words:
    return Words(text, ((box[0] + box[2]) / 2, box[1] - 4.5), TAG, "TEXT", "middle")


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
        u, v = way
        foot = Fill(
            ((x - 1.0 * v, y + 1.0 * u), (x + 1.0 * v, y - 1.0 * u), (x + 1.6 * u, y + 1.6 * v)), "DIMENSIONS"
        )
        tip = x + 3.4 * u, y + 3.4 * v
        middle = x + 5.2 * u, y + 5.2 * v
        box = middle[0] - 1.8, middle[1] - 1.8, middle[0] + 1.8, middle[1] + 1.8
        words = Words(datum.letter, (middle[0], middle[1] - 1.0), SIZE, "DIMENSIONS", "middle")
        marks += [foot, line((x + 1.6 * u, y + 1.6 * v), tip, "DIMENSIONS")]
        marks += [rectangle(box, "DIMENSIONS"), words]
    return marks


def _tags(drawing: PartDrawing, placements: dict[str, ViewPlacement], room: Room) -> list[Mark]:
    """Every hole's diameter with its tag; the first of a group says how many there are, and their size."""
    rows = [
        (placements[group.view], group, hole.at, _tag_text(group, i, hole.tag))
        for group in drawing.holes
        for i, hole in enumerate(group.holes)
    ]
    for place, group, at, _ in rows:
        x, y = place.at(at)
        r = place.scale * max(group.diameter, group.far_diameter) / 2
        r += RIM
        room.block((x - r, y - r, x + r, y + r))
    room.settle()
    marks: list[Mark] = []
    for place, group, at, text in sorted(rows, key=lambda row: -width(row[3], TAG)):
        centre, size = place.at(at), (group.diameter, place.scale)
        marks.append(tagged(centre, place.scale * group.diameter / 2, text, size, TAG, room))
    for i, pocket in enumerate(drawing.pockets):
        place = placements[FRONT]
        flats = number(pocket.flats)
        text = f"{NUT}{i + 1}" if i else f"{NUT}1 {len(drawing.pockets)}x hexagon {flats}"
        leader = tagged(
            place.at(pocket.at), place.scale * pocket.flats / 2, text, (pocket.flats, place.scale), TAG, room
        )
        marks += [*leader.drawn, leader.words]
    return marks


def _tag_text(group: HoleGroup, index: int, tag: str) -> str:
    if index:
        return tag
    count = f"{len(group.holes)}x" if len(group.holes) > 1 else ""
    return " ".join(t for t in (tag, count, group.size, group.thread) if t)
