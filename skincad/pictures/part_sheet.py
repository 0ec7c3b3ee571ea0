"""A made part's sheet: paper (ISO 216, frame by ISO 5457) and scale (ISO 5455) that suit it, all in place."""

from __future__ import annotations

import math
from typing import NamedTuple

from skincad.fabrication.drawing_views import FRONT
from skincad.fabrication.part_drawing import PartDrawing
from skincad.pictures.detail import detail_marks, detail_size
from skincad.pictures.marks import Box, Mark, Sheet, rectangle
from skincad.pictures.sheet_column import COLUMN, Titled, column, column_height
from skincad.pictures.sheet_views import places, size_of, view_marks

SCALES = (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02)  # source: ISO 5455
FILED, EDGE = (
    20.0,
    10.0,
)  # mm, source: ISO 5457, the frame's distance from the paper at the left and elsewhere
APART = 6.0  # mm, between views and column
ROOM = 7.0  # mm, assumption: between neighbouring holes on paper, for their tags
READ = 45.0  # mm, assumption: a view's larger side on paper is at least so long


class Paper(NamedTuple):
    """A size of paper, mm, and whether its column is beside the views or under them."""

    name: str
    size: tuple[float, float]
    beside: bool

    @property
    def window(self) -> tuple[float, float]:
        """Width and height of a detail on it, mm."""
        return (64.0, 36.0) if self.name == "A4" else (104.0, 60.0)

    @property
    def frame(self) -> Box:
        """The frame, mm."""
        return FILED, EDGE, self.size[0] - EDGE, self.size[1] - EDGE


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


def part_sheet(drawing: PartDrawing, version: str, date: str) -> Sheet:
    """Return the sheet of a part; `date` is "" where it is omitted."""
    paper, scale = _choice(drawing)
    left, low, right, high = paper.frame
    tall = column_height(drawing)
    if paper.beside:
        area = left, low, right - COLUMN - APART, high
    else:
        area = left, low + tall + APART, right, high
    titled = Titled(scale_words(scale), paper.name, version, date)
    detail = detail_size(drawing, paper.window)
    need = size_of(drawing, scale)
    spare = [(area[2] - area[0] - max(need[0], detail[0])) / 2, (area[3] - area[1] - need[1] - detail[1]) / 3]
    views = left + spare[0], area[1] + detail[1] + spare[1], area[2], high - spare[1]
    corner = area[0] + spare[0], area[1] + spare[1]
    placed = places(drawing, scale, views)
    marks: list[Mark] = [
        rectangle(paper.frame, "FRAME"),
        *column(drawing, titled, right - COLUMN, low),
        *view_marks(drawing, placed, views),
        *detail_marks(drawing, placed[FRONT], corner, paper.window),
    ]
    return Sheet(f"{drawing.design}: {drawing.name}", paper.size, scale, tuple(marks))


def _choice(drawing: PartDrawing) -> tuple[Paper, float]:
    """The smallest paper on which views and holes are read well, or else the one of the largest scale."""
    best: tuple[Paper, float] | None = None
    for paper in PAPERS:
        scale = next((s for s in SCALES if _fits(drawing, paper, s)), None)
        if scale is None:
            continue
        if best is None or scale > best[1]:
            best = paper, scale
        if scale * _wanted(drawing) >= 1:
            break
    return best or (PAPERS[-1], SCALES[-1])


def _wanted(drawing: PartDrawing) -> float:
    """How much room the part has at 1:1 by what it needs to be read."""
    (left, low), (right, high) = drawing.views[FRONT].box()
    return min(max(right - left, high - low) / READ, _spacing(drawing) / ROOM)


def _spacing(drawing: PartDrawing) -> float:
    """Least distance of two holes in a view, mm; those on one line are one."""
    views: dict[str, list[tuple[float, float]]] = {}
    for group in drawing.holes:
        views.setdefault(group.view, []).extend(hole.at for hole in group.holes)
    pairs = (math.dist(a, b) for ats in views.values() for i, a in enumerate(ats) for b in ats[:i])
    return min((apart for apart in pairs if apart > 1e-6), default=math.inf)


def _fits(drawing: PartDrawing, paper: Paper, scale: float) -> bool:
    left, low, right, high = paper.frame
    wide, tall = right - left - 4.0, high - low - 4.0
    column_tall = column_height(drawing)
    if paper.beside:
        wide -= COLUMN + APART
        if column_tall > tall:
            return False
    else:
        tall -= column_tall + APART
    need, aside = size_of(drawing, scale), detail_size(drawing, paper.window)
    return max(need[0], aside[0]) <= wide and need[1] + aside[1] <= tall
