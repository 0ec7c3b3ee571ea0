"""A made part's sheet: paper (ISO 216, frame by ISO 5457) and scale (ISO 5455) that suit it, all in place."""

from __future__ import annotations

import math
from typing import NamedTuple

from skincad.fabrication.drawing_views import FRONT
from skincad.fabrication.part_drawing import PartDrawing
from skincad.pictures.detail import detail_marks, detail_size
from skincad.pictures.marks import Box, Mark, Sheet, rectangle
from skincad.pictures.sheet_bores import ViewPlacement
from skincad.pictures.sheet_column import COLUMN, TitleBlock, column, column_height
from skincad.pictures.sheet_views import corner_of, places, size_of, view_marks
from skincad.shape.curves import Loop
from skincad.solids.plan import shifted

SCALES = (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02)  # source: ISO 5455
BINDING_MARGIN = 20.0  # mm, source: ISO 5457, the frame's distance from the paper's left edge
EDGE_MARGIN = 10.0  # mm, source: ISO 5457, its distance from the other edges
VIEW_GAP = 6.0  # mm, between views and column
TAGS, CAPTION = 12.0, 8.0  # mm, between the view from above and a detail to its right; under the left view
HOLE_SPACING = 7.0  # mm, assumption: between neighbouring holes on paper, for their tags
MIN_VIEW_SIZE = 45.0  # mm, assumption: a view's larger side on paper is at least so long


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


class Arrangement(NamedTuple):
    """How views and detail lie on a paper: scale, width and height of all, mm, and whether the detail is in
    the corner between the left view and that from above, or under the views."""

    scale: float
    size: tuple[float, float]
    in_corner: bool


def part_sheet(drawing: PartDrawing, version: str, date: str) -> Sheet:
    """Return the sheet of a part; `date` is "" where it is left out."""
    paper, arrangement = _choice(drawing)
    _, low, right, _ = paper.frame
    area, detail = _area(drawing, paper), detail_size(drawing, paper.window)
    title_block = TitleBlock(scale_words(arrangement.scale), paper.name, version, date)
    side_margin = (area[2] - area[0] - arrangement.size[0]) / 2
    spare = (area[3] - area[1] - arrangement.size[1]) / (2 if arrangement.in_corner else 3)
    views = area[0] + side_margin, area[1], area[2], area[3] - spare
    placements = places(drawing, arrangement.scale, views)
    if arrangement.in_corner:
        corner = (
            area[0] + side_margin + arrangement.size[0] - detail[0],
            area[3] - spare - arrangement.size[1],
        )
    else:
        corner = area[0] + side_margin, area[1] + spare
    detail_box = (*corner, corner[0] + detail[0], corner[1] + detail[1])
    marks: list[Mark] = [
        rectangle(paper.frame, "FRAME"),
        *column(drawing, title_block, right - COLUMN, low),
        *view_marks(drawing, placements, views, detail_box),
        *detail_marks(drawing, placements[FRONT], corner, paper.window),
    ]
    title = f"{drawing.design}: {drawing.name}"
    return Sheet(
        title, paper.size, arrangement.scale, tuple(marks), _cut(drawing, placements), drawing.cut_notes
    )


def _cut(drawing: PartDrawing, placements: dict[str, ViewPlacement]) -> tuple[tuple[str, Loop], ...]:
    """What is cut through, where its view lies, mm of the part."""
    if drawing.cut is None:
        return ()
    (x, y), scale = placements[drawing.cut.view].origin, placements[drawing.cut.view].scale
    return tuple(("CUT", shifted(loop, x / scale, y / scale)) for loop in drawing.cut.loops)


def _area(drawing: PartDrawing, paper: Paper) -> Box:
    """Where views and detail have room, mm: left of the column, or over it."""
    left, low, right, high = paper.frame
    if paper.beside:
        return left, low, right - COLUMN - VIEW_GAP, high
    return left, low + column_height(drawing) + VIEW_GAP, right, high


def _choice(drawing: PartDrawing) -> tuple[Paper, Arrangement]:
    """The smallest paper on which views and holes are read well, or else the one of the largest scale."""
    best: tuple[Paper, Arrangement] | None = None
    for paper in PAPERS:
        if paper.beside and column_height(drawing) > paper.frame[3] - paper.frame[1]:
            continue
        options = (_arrangement(drawing, paper, scale) for scale in SCALES)
        arrangement = next((one for one in options if one is not None), None)
        if arrangement is None:
            continue
        if best is None or arrangement.scale > best[1].scale:
            best = paper, arrangement
        if arrangement.scale * _legibility(drawing) >= 1:
            break
    return best or (PAPERS[-1], _arrangements(drawing, PAPERS[-1], SCALES[-1])[-1])


def _legibility(drawing: PartDrawing) -> float:
    """The part's size at 1:1 over the size at which it can be read."""
    (left, low), (right, high) = drawing.views[FRONT].box()
    return min(max(right - left, high - low) / MIN_VIEW_SIZE, _spacing(drawing) / HOLE_SPACING)


def _spacing(drawing: PartDrawing) -> float:
    """Least distance of two holes in a view, mm; those on one line are one."""
    views: dict[str, list[tuple[float, float]]] = {}
    for group in drawing.holes:
        views.setdefault(group.view, []).extend(hole.at for hole in group.holes)
    pairs = (math.dist(a, b) for ats in views.values() for i, a in enumerate(ats) for b in ats[:i])
    return min((distance for distance in pairs if distance > 1e-6), default=math.inf)


def _arrangement(drawing: PartDrawing, paper: Paper, scale: float) -> Arrangement | None:
    """How all of it fits on a paper at a scale; None where it does not."""
    left, low, right, high = _area(drawing, paper)
    wide, tall = right - left - 4.0, high - low - 4.0
    rows = _arrangements(drawing, paper, scale)
    return next((one for one in rows if one.size[0] <= wide and one.size[1] <= tall), None)


def _arrangements(drawing: PartDrawing, paper: Paper, scale: float) -> tuple[Arrangement, ...]:
    """The ways to lay out views and detail, the most even one first."""
    views, corner = size_of(drawing, scale), corner_of(drawing, scale)
    wide, tall = detail_size(drawing, paper.window)
    if not wide:
        return (Arrangement(scale, views, False),)
    beside = max(views[0], corner[0] + TAGS + wide), max(views[1], corner[1] + CAPTION + tall)
    under = max(views[0], wide), views[1] + tall
    return Arrangement(scale, beside, True), Arrangement(scale, under, False)
