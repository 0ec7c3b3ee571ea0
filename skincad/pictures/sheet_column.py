"""The column of a drawing sheet: title block (ISO 7200), notes and tables, 180 mm wide, from its foot up."""

from __future__ import annotations

import math
import textwrap
from typing import NamedTuple

from skincad.fabrication.part_drawing import DrawingTable, PartDrawing
from skincad.pictures.marks import Box, Ink, Mark, Words, line, rectangle, width
from skincad.solids.projection import Arc, Polyline

COLUMN = 180.0  # mm, source: ISO 7200, the title block's width
TEXT, HEAD, LABEL = 1.8, 2.5, 1.3  # mm, height of capitals
ROW, GAP = 3.9, 3.5  # mm, of a table's row, and between tables
TITLE = 40.0  # mm, height of the title block
SPACE = 1.2  # mm, beside a cell's text


class TitleBlock(NamedTuple):
    """What the title block says besides what the drawing does."""

    scale: str
    paper: str
    version: str
    date: str  # "" where it is left out


def column_height(drawing: PartDrawing) -> float:
    """Return how high the column is, mm."""
    return TITLE + GAP + _notes_height(drawing) + sum(GAP + _table_height(t) for t in drawing.tables)


def column(drawing: PartDrawing, title_block: TitleBlock, left: float, low: float) -> list[Mark]:
    """Return the column's marks, its lower left corner there."""
    marks = _title(drawing, title_block, left, low)
    high = low + TITLE + GAP + _notes_height(drawing)
    lines = _wrapped(drawing)
    for i, text in enumerate(lines):
        indent = 1.0 if text.startswith("-") else 2.2
        marks.append(Words(text, (left + indent, high - (i + 1) * ROW), TEXT, "TEXT"))
    for table in reversed(drawing.tables):
        high += GAP + _table_height(table)
        marks += _table(table, left, high)
    return marks


def _wrapped(drawing: PartDrawing) -> list[str]:
    max_letters = int((COLUMN - 4.0) / width("n", TEXT) * 1.12)  # a text has narrow letters too
    lines = []
    for note in drawing.notes:
        lines += textwrap.wrap(note, max_letters, initial_indent="- ")
    return lines


def _notes_height(drawing: PartDrawing) -> float:
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


def _title(drawing: PartDrawing, title_block: TitleBlock, left: float, low: float) -> list[Mark]:
    cells: list[tuple[Box, str, str, float]] = [
        ((0, 30, 96, TITLE), "title", f"{drawing.name}", 3.5),
        ((96, 30, 150, TITLE), "design", drawing.design, HEAD),
        ((0, 22.5, 96, 30), "what it is", drawing.what, HEAD),
        ((96, 22.5, 150, 30), "document", "part drawing", HEAD),
        ((0, 15, 58, 22.5), "material (proposal)", drawing.material, HEAD),
        ((58, 15, 102, 22.5), "process", drawing.process, HEAD),
        ((102, 15, 141, 22.5), "general tolerance", drawing.tolerance, HEAD),
        ((141, 15, 180, 22.5), "all faces, µm (ISO 21920-1)", "" if drawing.surface else "-", HEAD),
        ((0, 7.5, 75, 15), "owner", "", HEAD),  # by hand, as ISO 7200 asks for them
        ((75, 7.5, 125, 15), "drawn by", f"skincad {title_block.version}", HEAD),
        ((125, 7.5, 180, 15), "approved by", "", HEAD),
        ((0, 0, 40, 7.5), "drawing number", f"{drawing.design}/{drawing.name}", HEAD),
        ((40, 0, 60, 7.5), "revision", drawing.revision, HEAD),
        ((60, 0, 75, 7.5), "scale", title_block.scale, HEAD),
        ((75, 0, 92, 7.5), "unit", "mm", HEAD),
        ((92, 0, 108, 7.5), "paper", title_block.paper, HEAD),
        ((108, 0, 120, 7.5), "sheet", "1/1", HEAD),
        ((120, 0, 180, 7.5), "date", title_block.date, HEAD),
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


def _surface(drawing: PartDrawing, x: float, y: float) -> list[Mark]:
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
