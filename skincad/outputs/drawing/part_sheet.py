"""A made part's sheet: paper and scale that suit it, an enlarged detail, the column of notes and tables.

Paper is ISO 216's with the frame of ISO 5457, scales are ISO 5455's, the title block is ISO 7200's.
"""

from __future__ import annotations

import math
import textwrap
from collections import Counter
from typing import NamedTuple

import numpy as np
import shapely

from skincad.base.arrays import Array
from skincad.base.version import __version__
from skincad.fabrication.drawn_features import FRONT, Groove, Slit, number
from skincad.fabrication.part_drawing import DrawingTable, PartDrawing, Titled
from skincad.outputs.drawing.marks import (
    Box,
    Contour,
    Ink,
    Mark,
    Sheet,
    Words,
    aligned,
    line,
    moved,
    rectangle,
    width,
)
from skincad.outputs.drawing.part_views import ViewPlacement, corner_of, places, size_of, view_marks
from skincad.solids.plan import shifted
from skincad.solids.projection import Arc, Place, Polyline, Stroke

SCALES = (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02)  # source: ISO 5455
BINDING_MARGIN = 20.0  # mm, source: ISO 5457, the frame's distance from the paper's left edge
EDGE_MARGIN = 10.0  # mm, source: ISO 5457, its distance from the other edges
VIEW_GAP = 6.0  # mm, between views and column
TAGS, CAPTION = 12.0, 8.0  # mm, between the view from above and a detail to its right; under the left view
# mm, assumption: between neighbouring holes on paper, for their tags; and where a view has more than CROWD
HOLE_SPACING, CROWD, CROWDED_SPACING = 7.0, 20, 10.0
MIN_VIEW_SIZE = 45.0  # mm, assumption: a view's larger side on paper is at least so long
DETAIL_MARGIN = (10.0, 10.0)  # mm of paper beside and over it, for dimensions and caption
WINDOW_FACTOR = (1.3, 1.4)  # assumption: a window's size by that of what it shows
MIN_WINDOW = (42.0, 34.0)  # mm of paper, assumption: width and height of a window, at least
SLACK = 1.05  # the shown extent may exceed the window by this factor: it has margins of its own
DETAIL_SCALES = (200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0)  # source: ISO 5455
LETTER, DETAIL_TEXT = "W", 2.0
CHORD = 0.01  # mm of paper, of arcs that are cut at the window
COLUMN = 180.0  # mm, source: ISO 7200, the title block's width
TEXT, HEAD, LABEL = 1.8, 2.5, 1.3  # mm, height of capitals
ROW, GAP = 3.9, 3.5  # mm, of a table's row, and between tables
TITLE = 40.0  # mm, height of the title block
SPACE = 1.2  # mm, beside a cell's text


class Paper(NamedTuple):
    """A size of paper, mm, and whether its column is beside the views or under them."""

    name: str
    size: tuple[float, float]
    beside: bool

    @property
    def window(self) -> tuple[float, float]:
        """Width and height of a detail on it, mm."""
        return (52.0, 36.0) if self.name == "A4" else (104.0, 60.0)

    @property
    def frame(self) -> Box:
        """The frame, mm."""
        return BINDING_MARGIN, EDGE_MARGIN, self.size[0] - EDGE_MARGIN, self.size[1] - EDGE_MARGIN


PAPERS = (
    Paper("A4", (210.0, 297.0), False),
    Paper("A3", (420.0, 297.0), True),
    Paper("A3", (297.0, 420.0), False),
    Paper("A2", (594.0, 420.0), True),
    Paper("A1", (841.0, 594.0), True),
)


def scale_words(scale: float) -> str:
    """Return a scale as a title block has it."""
    return f"{scale:g}:1" if scale >= 1 else f"1:{1 / scale:g}"


# How views and detail lie on a paper: scale, width and height of all, mm, and whether the detail is in the
# corner between the left view and that from above, or under the views
Arrangement = tuple[float, tuple[float, float], bool]


def part_sheet(drawing: PartDrawing, date: str) -> Sheet:
    """Return the sheet of a part; `date` is "" where it is left out."""
    paper, (scale, size, in_corner) = _choice(drawing)
    area, detail = _area(drawing, paper), detail_size(drawing, paper.window)
    side_margin = (area[2] - area[0] - size[0]) / 2
    spare = (area[3] - area[1] - size[1]) / (2 if in_corner else 3)
    views = area[0] + side_margin, area[1], area[2], area[3] - spare
    placements = places(drawing, scale, views)
    corner = area[0] + side_margin, area[1] + spare
    if in_corner:
        corner = corner[0] + size[0] - detail[0], area[3] - spare - size[1]
    detail_box = (*corner, corner[0] + detail[0], corner[1] + detail[1])
    marks: list[Mark] = [
        rectangle(paper.frame, "FRAME"),
        *column(drawing, paper, scale, date),
        *view_marks(drawing, placements, views, detail_box),
        *detail_marks(drawing, placements[FRONT], corner, paper.window),
    ]
    title, cut = f"{drawing.design}: {drawing.name}", _cut(drawing, placements)
    return Sheet(title, paper.size, scale, tuple(marks), cut, drawing.cut_notes)


def _cut(drawing: PartDrawing, placements: dict[str, ViewPlacement]) -> tuple[Contour, ...]:
    """What is cut through, where its view lies, mm of the part."""
    if drawing.cut is None:
        return ()
    view, loops = drawing.cut
    (x, y), scale = placements[view]
    return tuple(Contour(shifted(loop, x / scale, y / scale), "CUT") for loop in loops)


def _area(drawing: PartDrawing, paper: Paper) -> Box:
    """Where views and detail have room, mm: left of the column, or over it."""
    left, low, right, high = paper.frame
    if paper.beside:
        return left, low, right - COLUMN - VIEW_GAP, high
    return left, low + column_height(drawing) + VIEW_GAP, right, high


def _choice(drawing: PartDrawing) -> tuple[Paper, Arrangement]:
    """The smallest paper on which views and holes are read well, or else the one of the largest scale."""
    (left, low), (right, high) = drawing.views[FRONT].box()
    # the part's size at 1:1 over the size at which it can be read
    crowd = Counter(group.view for group in drawing.holes for _ in group.holes)
    apart = CROWDED_SPACING if max(crowd.values(), default=0) > CROWD else HOLE_SPACING
    legibility = min(max(right - left, high - low) / MIN_VIEW_SIZE, _spacing(drawing) / apart)
    best: tuple[Paper, Arrangement] | None = None
    for paper in PAPERS:
        if paper.beside and column_height(drawing) > paper.frame[3] - paper.frame[1]:
            continue
        room = _area(drawing, paper)
        wide, tall = room[2] - room[0] - 4.0, room[3] - room[1] - 4.0
        options = (one for scale in SCALES for one in _arrangements(drawing, paper, scale))
        fitting = ((scale, size, at) for scale, size, at in options if size[0] <= wide and size[1] <= tall)
        if (arrangement := next(fitting, None)) is None:
            continue
        scale = arrangement[0]
        if best is None or scale > best[1][0]:
            best = paper, arrangement
        if scale * legibility >= 1:
            break
    return best or (PAPERS[-1], _arrangements(drawing, PAPERS[-1], SCALES[-1])[-1])


def _spacing(drawing: PartDrawing) -> float:
    """Least distance of two holes in a view, mm; those on one line are one."""
    views: dict[str, list[tuple[float, float]]] = {}
    for group in drawing.holes:
        views.setdefault(group.view, []).extend(group.holes.values())
    pairs = (math.dist(a, b) for ats in views.values() for i, a in enumerate(ats) for b in ats[:i])
    return min((distance for distance in pairs if distance > 1e-6), default=math.inf)


def _arrangements(drawing: PartDrawing, paper: Paper, scale: float) -> tuple[Arrangement, ...]:
    """The ways to lay out views and detail, the most even one first."""
    views, corner = size_of(drawing, scale), corner_of(drawing, scale)
    wide, tall = detail_size(drawing, paper.window)
    if not wide:
        return ((scale, views, False),)
    beside = max(views[0], corner[0] + TAGS + wide), max(views[1], corner[1] + CAPTION + tall)
    under = max(views[0], wide), views[1] + tall
    return (scale, beside, True), (scale, under, False)


Size = tuple[float, float]
# What a detail shows: its middle in the front view and its extent, mm, and what is dimensioned: two points,
# the line's distance from them (to the left of the way), all mm, and words
Focus = tuple[Place, Size, tuple[tuple[Place, Place, float, str], ...]]


def detail_size(drawing: PartDrawing, window: tuple[float, float]) -> tuple[float, float]:
    """Return width and height of the detail with its dimensions in a window of at most this size, mm; 0 where
    there is none."""
    focus = _focus(drawing)
    if focus is None:
        return 0.0, 0.0
    _, (wide, tall) = _scale_and_window(focus[1], window)
    return wide + 2 * DETAIL_MARGIN[0], tall + 2 * DETAIL_MARGIN[1]


def _focus(drawing: PartDrawing) -> Focus | None:
    if drawing.slits:
        return _slit_focus(drawing.slits)
    return _groove_focus(drawing.grooves) if drawing.grooves else None


def _scale_and_window(extent: Size, max_size: Size) -> tuple[float, Size]:
    """The largest standard scale at which a window of at most this size shows an extent; the window, mm."""
    fits = SLACK * min(w / e for w, e in zip(max_size, extent, strict=True))
    scale = next((s for s in DETAIL_SCALES if s <= fits), DETAIL_SCALES[-1])
    rows = zip(max_size, MIN_WINDOW, WINDOW_FACTOR, extent, strict=True)
    wide, tall = (min(room, max(least, by * scale * size)) for room, least, by, size in rows)
    return scale, (wide, tall)


def detail_marks(
    drawing: PartDrawing, front: ViewPlacement, corner: Place, max_size: tuple[float, float]
) -> list[Mark]:
    """Return the detail in a window of at most this size, mm, the lower left corner of all there, and where
    it is in the front view, which lies so."""
    focus = _focus(drawing)
    if focus is None:
        return []
    shown, extent, sizes = focus
    scale, size = _scale_and_window(extent, max_size)
    left, low = corner[0] + DETAIL_MARGIN[0], corner[1] + DETAIL_MARGIN[1]
    middle = left + size[0] / 2, low + size[1] / 2
    place = ViewPlacement((middle[0] - scale * shown[0], middle[1] - scale * shown[1]), scale)
    window = left, low, left + size[0], low + size[1]
    marks: list[Mark] = [rectangle(window, "CENTRE")]
    marks += [Ink(s, "OUTLINE") for s in _profile_in_window(drawing, place, window)]
    for a, b, out, words in sizes:
        marks.append(aligned((place.at(a), place.at(b)), scale * out, scale, words, DETAIL_TEXT))
    caption = f"detail {LETTER} ({scale:g}:1)"
    marks.append(Words(caption, (middle[0], corner[1] + 3.5), 2.5, "TEXT", "middle"))
    (x, y), (w, h) = front.at(shown), (length / scale / 2 * front.scale for length in size)
    marks.append(rectangle((x - w, y - h, x + w, y + h), "DIMENSIONS"))
    return [*marks, Words(LETTER, (x + w + 0.5, y + h + 0.3), 1.8, "DIMENSIONS")]


def _slit_focus(slits: tuple[Slit, ...]) -> Focus:
    """The slits of the ridge in the middle: width and depth, and how far apart."""
    ridges = sorted({slit.ridge for slit in slits})
    middle = ridges[len(ridges) // 2]
    ridge_slits = sorted((slit for slit in slits if slit.ridge == middle), key=lambda slit: slit.at)
    first, last = ridge_slits[0], ridge_slits[-1]
    mouths = [moved(slit.at, slit.out, slit.depth) for slit in ridge_slits]
    points = [slit.at for slit in ridge_slits] + mouths
    x, y = zip(*points, strict=True)
    u, v = last.out
    corners = [moved(last.at, (v * last.width / 2, -u * last.width / 2), s) for s in (-1, 1)]
    foot = first.at[0] - first.out[1] * first.width / 2, first.at[1] + first.out[0] * first.width / 2
    sizes = [
        (corners[0], corners[1], -0.35 * last.depth, number(last.width)),
        (foot, moved(foot, first.out, first.depth), 0.5 * first.depth, number(first.depth)),
    ]
    if len(ridge_slits) > 1:
        spacing = number(math.dist(mouths[0], mouths[-1]))
        sizes.append((mouths[0], mouths[-1], 0.4 * first.depth, spacing))
    size = max(x) - min(x) + 2.2 * first.depth, (max(y) - min(y)) * 2.2
    return ((max(x) + min(x)) / 2, (max(y) + min(y)) / 2), size, tuple(sizes)


def _groove_focus(grooves: tuple[Groove, ...]) -> Focus:
    """The groove in the middle: depth, and widths at root and tip before fillets."""
    groove = grooves[len(grooves) // 2]
    lean, h = math.radians(groove.lean), groove.height
    up, sideways = (math.sin(lean), math.cos(lean)), (math.cos(lean), -math.sin(lean))
    mouth = moved(groove.bottom, up, h)
    root = [moved(mouth, sideways, s * groove.root / 2) for s in (-1, 1)]
    tip = [moved(groove.bottom, sideways, s * groove.tip / 2) for s in (-1, 1)]
    sizes = (
        (root[0], root[1], 0.35 * h, f"root {number(groove.root)}"),
        (tip[0], tip[1], -0.3 * h, f"tip {number(groove.tip)}"),
        (moved(groove.bottom, sideways, 0.0), mouth, 0.5 * groove.root + 0.4 * h, number(h)),
    )
    middle = moved(groove.bottom, up, h / 2)
    return middle, (1.6 * groove.root, 1.9 * h), sizes


def _profile_in_window(drawing: PartDrawing, place: ViewPlacement, window: Box) -> list[Stroke]:
    """What of the profile lies in the window, on paper."""
    frame, strokes = shapely.box(*window), list[Stroke]()
    for stroke in drawing.profile:
        on_paper = place.stroke(stroke)
        (left, low), (right, high) = on_paper.box()
        if left > window[2] or right < window[0] or low > window[3] or high < window[1]:
            continue
        points = np.array(on_paper.points) if isinstance(on_paper, Polyline) else _chords(on_paper)
        cut = shapely.LineString(points).intersection(frame)
        for one in getattr(cut, "geoms", [cut]):
            if one.geom_type == "LineString" and not one.is_empty:
                strokes.append(Polyline(tuple((float(x), float(y)) for x, y in one.coords)))
    return strokes


def _chords(arc: Arc) -> Array:
    count = math.ceil(arc.sweep / (2 * math.acos(1 - min(0.5, CHORD / arc.radius)))) + 1
    return np.array([arc.at(i / count) for i in range(count + 1)])


def column_height(drawing: Titled) -> float:
    """Return how high the column is, mm."""
    return TITLE + GAP + _notes_height(drawing) + sum(GAP + _table_height(t) for t in drawing.tables)


def column(drawing: Titled, paper: Paper, scale: float, date: str) -> list[Mark]:
    """Return the column's marks, in the lower right corner of the paper's frame; `date` is "" where it is
    left out."""
    left, low = paper.frame[2] - COLUMN, paper.frame[1]
    marks = _title(drawing, paper.name, scale_words(scale), date, left, low)
    high = low + TITLE + GAP + _notes_height(drawing)
    lines = _wrapped(drawing)
    for i, text in enumerate(lines):
        indent = 1.0 if text.startswith("-") else 2.2
        marks.append(Words(text, (left + indent, high - (i + 1) * ROW), TEXT, "TEXT"))
    for table in reversed(drawing.tables):
        high += GAP + _table_height(table)
        marks += _table(table, left, high)
    return marks


def _wrapped(drawing: Titled) -> list[str]:
    max_letters = int((COLUMN - 4.0) / width("n", TEXT) * 1.12)  # a text has narrow letters too
    lines = []
    for note in drawing.notes:
        lines += textwrap.wrap(note, max_letters, initial_indent="- ")
    return lines


def _notes_height(drawing: Titled) -> float:
    return ROW * len(_wrapped(drawing)) + 1.0


def _natural(table: DrawingTable) -> list[float]:
    """Widths of a table's columns, mm, as its texts need them."""
    rows = zip(table.heads, *table.rows, strict=True)
    return [max(width(text, TEXT) for text in texts) + 2 * SPACE for texts in rows]


def _abreast(table: DrawingTable) -> int:
    """How many times a table of short rows stands beside itself."""
    if len(table.rows) <= 2:
        return 1
    return max(1, min(len(table.rows), math.floor(COLUMN / (sum(_natural(table)) + 2.0)), 8))


def _rows(table: DrawingTable) -> int:
    return math.ceil(len(table.rows) / _abreast(table))


def _table_height(table: DrawingTable) -> float:
    return ROW * (_rows(table) + 2)


def _table(table: DrawingTable, left: float, high: float) -> list[Mark]:
    marks: list[Mark] = [Words(table.title, (left + SPACE, high - ROW + 1.2), TEXT, "TEXT")]
    count, rows, widths = _abreast(table), _rows(table), _natural(table)
    if count == 1 and len(table.heads) > 3:
        spare = (COLUMN - sum(widths)) / len(widths)
        widths = [w + max(0.0, spare) for w in widths]
    for i in range(count):
        part = table.rows[i * rows : (i + 1) * rows]
        if part:
            marks += _grid(table.heads, part, widths, left + i * (sum(widths) + 2.0), high - ROW)
    return marks


def _grid(
    heads: tuple[str, ...], rows: tuple[tuple[str, ...], ...], widths: list[float], left: float, high: float
) -> list[Mark]:
    right, low = left + sum(widths), high - ROW * (len(rows) + 1)
    marks: list[Mark] = [rectangle((left, low, right, high), "TEXT")]
    marks += [line((left, high - ROW * i), (right, high - ROW * i), "TEXT") for i in range(1, len(rows) + 1)]
    starts = [left + sum(widths[:k]) for k in range(len(widths))]
    marks += [line((x, low), (x, high), "TEXT") for x in starts[1:]]
    for i, row in enumerate((heads, *rows), 1):  # row by row, as who copies the text reads it
        y = high - ROW * i + 1.1
        marks += [Words(text, (x + SPACE, y), TEXT, "TEXT") for x, text in zip(starts, row, strict=True)]
    return marks


def _title(drawing: Titled, paper: str, scale: str, date: str, left: float, low: float) -> list[Mark]:
    cells: list[tuple[Box, str, str, float]] = [
        ((0, 30, 96, TITLE), "title", f"{drawing.name}", 3.5),
        ((96, 30, 150, TITLE), "design", drawing.design, HEAD),
        ((0, 22.5, 96, 30), "what it is", drawing.what, HEAD),
        ((96, 22.5, 150, 30), "document", drawing.document, HEAD),
        ((0, 15, 58, 22.5), "material", drawing.material, HEAD),
        ((58, 15, 102, 22.5), "process", drawing.process, HEAD),
        ((102, 15, 141, 22.5), "tolerance unless said", drawing.tolerance, HEAD),
        ((141, 15, 180, 22.5), "all faces, µm (ISO 21920-1)", "" if drawing.surface else "-", HEAD),
        ((0, 7.5, 60, 15), "owner", "", HEAD),  # by hand, as ISO 7200 asks for them
        ((60, 7.5, 75, 15), "quantity", "1", HEAD),
        ((75, 7.5, 125, 15), "drawn by", f"skincad {__version__}", HEAD),
        ((125, 7.5, 180, 15), "approved by", "", HEAD),
        ((0, 0, 40, 7.5), "drawing number", f"{drawing.design}/{drawing.name}", HEAD),
        ((40, 0, 60, 7.5), "revision", drawing.revision, HEAD),
        ((60, 0, 75, 7.5), "scale", scale, HEAD),
        ((75, 0, 92, 7.5), "unit", "mm", HEAD),
        ((92, 0, 108, 7.5), "paper", paper, HEAD),
        ((108, 0, 120, 7.5), "sheet", "1/1", HEAD),
        ((120, 0, 180, 7.5), "date", date, HEAD),
    ]
    marks: list[Mark] = []
    for (x0, y0, x1, y1), label, text, height in cells:
        marks.append(rectangle((left + x0, low + y0, left + x1, low + y1), "FRAME"))
        marks.append(Words(label, (left + x0 + 1.0, low + y1 - 2.0), LABEL, "FRAME"))
        if not text:
            continue
        fit = min(height, height * (x1 - x0 - 2.0) / max(width(text, height), 1e-9))
        marks.append(Words(text, (left + x0 + 1.0, low + y0 + 1.5), fit, "FRAME"))
    marks.append(rectangle((left + 150, low + 22.5, left + 180, low + TITLE), "FRAME"))
    return [*marks, *_surface(drawing, left + 144.0, low + 15.6), *_symbol(left, low)]


def _surface(drawing: Titled, x: float, y: float) -> list[Mark]:
    """The symbol of a surface's texture (ISO 21920-1), its tip there, with a bar where material is taken off
    and without one where it is only put on, and what it asks for."""
    if not drawing.surface:
        return []
    high = 2.1
    end, up = x + 3.4 + width(drawing.surface, high), y + 3.8
    legs = Polyline(((x - 1.1, y + 1.9), (x, y), (x + 2.2, up), (end, up)))
    bar = [line((x - 1.1, y + 1.9), (x + 1.1, y + 1.9), "FRAME")] if drawing.cut_from_solid else []
    return [Ink(legs, "FRAME"), *bar, Words(drawing.surface, (x + 2.8, y + 0.8), high, "FRAME")]


def _symbol(left: float, low: float) -> list[Mark]:
    """First-angle projection's symbol (ISO 5456-2): a cone, its narrow end at the left, and to its right what
    is seen from the left."""
    x, y = left + 158.0, low + 32.5
    cone = Polyline(((x - 4, y - 2), (x + 4, y - 4), (x + 4, y + 4), (x - 4, y + 2), (x - 4, y - 2)))
    circles = [Arc((x + 13.5, y), r, 0.0, 2 * math.pi) for r in (2.0, 4.0)]
    marks: list[Mark] = [Ink(cone, "FRAME"), *(Ink(c, "FRAME") for c in circles)]
    marks += [line((x - 5.5, y), (x + 5.5, y), "CENTRE"), line((x + 8, y), (x + 19, y), "CENTRE")]
    marks.append(line((x + 13.5, y - 5), (x + 13.5, y + 5), "CENTRE"))
    words = Words("first-angle (ISO 5456-2)", (left + 165.0, low + 24.0), LABEL, "FRAME", "middle")
    return [*marks, words]
