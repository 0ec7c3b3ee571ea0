"""Content of a made part's shop drawing, as plain data: no paper, no scale, no place of any text."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from skincad.fabrication.bore_fits import process_of
from skincad.fabrication.bore_table import HoleGroup, hole_groups, number
from skincad.fabrication.cut_profile import CutProfile, cut_profile, cut_words
from skincad.fabrication.drawing_views import ABOVE, FRONT, views
from skincad.fabrication.drawn_features import (
    Datum,
    Groove,
    Length,
    Notch,
    NutPocket,
    Slit,
    datums,
    downward,
    grooves_of,
    leftward,
    notches,
    pockets,
    seat_lengths,
    skins_at,
    slits,
)
from skincad.fabrication.tolerances import (
    CrestAllowance,
    general_tolerance,
    material_words,
    notes,
    process_words,
    surface_words,
    what_matters,
)
from skincad.inputs.catalog import display_name
from skincad.inputs.design import Design
from skincad.solids.plan import CutRole, Part, PartRole, Prism
from skincad.solids.projection import Projection, Stroke, outlined

if TYPE_CHECKING:
    import cadquery as cq

Coordinate = Callable[[float], float]
NUT = "N"
LEANING = "leaning from upright, positive with the mouth to the right"
MOST_ROWS = 40  # of a table of slits or grooves, assumption: more are read from the STEP file


class DrawingTable(NamedTuple):
    """A table: its title, its heads and its rows."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class PartDrawing:
    """A part's drawing: views by name, what is dimensioned in them, tables, and words; lengths mm."""

    name: str
    design: str
    revision: str
    what: str
    views: dict[str, Projection]
    captions: dict[str, str]
    holes: tuple[HoleGroup, ...]
    pockets: tuple[NutPocket, ...]
    datums: tuple[Datum, ...]
    lengths: tuple[Length, ...]
    slits: tuple[Slit, ...]
    grooves: tuple[Groove, ...]
    profile: tuple[Stroke, ...]  # that a detail shows: the front view, or a bent mold's middle section
    cut: CutProfile | None  # what is cut right through, for DXF
    cut_notes: tuple[str, ...]  # what is said of it there
    tables: tuple[DrawingTable, ...]
    notes: tuple[str, ...]
    process: str
    material: str
    tolerance: str
    surface: str  # "" where the process says nothing of it
    cut_from_solid: bool  # not printed


def part_drawing(design: Design, part: Part, shape: cq.Solid, judged: CrestAllowance | None) -> PartDrawing:
    """Return the drawing of a made part; `made` is its solid in the mold, `judged` the check's, if any."""
    from skincad.solids.occ import projection

    seen = {view.name: projection(shape, view.of_solid) for view in views(part)}
    holes, nuts = tuple(hole_groups(design, part, shape)), pockets(part)
    cut, carved = slits(design, part), grooves_of(design, part)
    datum = datums(part)
    tables = [
        _hole_table(holes, nuts, general_tolerance(design, part)),
        _places(holes, nuts, seen, part),
        _notch_table(notches(part), seen, part),
        _slit_table(cut, seen),
        _groove_table(carved, seen, part, judged.drops if judged else ()),
    ]
    top, cut_through = seen[FRONT].box()[1][1], cut_profile(part)
    words = [*notes(design, part), *what_matters(design, part, judged)]
    if design.mold.cavities > 1 and (cut or carved):
        words.append(_gang_words(design, part))
    return PartDrawing(
        name=part.name,
        design=display_name(design),
        revision=design.revision,
        what=part.role.what,
        views=seen,
        captions={view.name: view.words for view in views(part)},
        holes=holes,
        pockets=nuts,
        datums=datum,
        lengths=(*_overall(seen), *seat_lengths(part, top)),
        slits=cut,
        grooves=carved,
        profile=_profile(part, seen[FRONT]),
        cut=cut_through,
        cut_notes=(cut_words(design, part),) if cut_through else (),
        tables=tuple(table for table in tables if table.rows),
        notes=("Datums: " + "; ".join(f"{d.letter} {d.what}" for d in datum) + ".", *words),
        process=process_words(design, part),
        material=material_words(design, part),
        tolerance=general_tolerance(design, part),
        surface=surface_words(design, part),
        cut_from_solid=not process_of(design, part).layer,
    )


def _profile(part: Part, front: Projection) -> tuple[Stroke, ...]:
    if part.straight is not None and isinstance(part.straight.body, Prism):
        return outlined(part.straight.body.outline)
    return front.visible


def _gang_words(design: Design, part: Part) -> str:
    """Where in the front view the slits and grooves of a gang's further skins lie."""
    first, *others = skins_at(design)
    here, there = ("right", "left") if part.end == "b" else ("left", "right")
    offsets = " and ".join(number(x - first) for x in others)
    what = "Slits" if part.role is PartRole.COMB else "Seat, trough and grooves"
    return f"{what}: of the skin furthest {here}; the others' are {offsets} to the {there} of them."


def _overall(seen: dict[str, Projection]) -> tuple[Length, ...]:
    (left, low), (right, high) = seen[FRONT].box()
    (_, near), (_, far) = seen[ABOVE].box()
    return Length(FRONT, "u", left, right), Length(FRONT, "v", low, high), Length(ABOVE, "v", near, far)


def _hole_table(holes: tuple[HoleGroup, ...], nuts: tuple[NutPocket, ...], limits: str) -> DrawingTable:
    rows = [
        (
            f"{g.letter} ({len(g.holes)}x)",
            g.purpose,
            g.size,
            g.limits,
            g.reach,
            g.thread or "-",
            _from(g),
        )
        for g in holes
    ]
    if nuts:
        size = f"{number(nuts[0].flats)} A/F"
        tolerance = limits.split(" ", maxsplit=1)[0] if limits.startswith("±") else ""
        rows.append(
            (f"{NUT} ({len(nuts)}x)", "M3 nut, hexagon", size, tolerance, number(nuts[0].depth), "-", "end b")
        )
    return DrawingTable("Holes", ("hole", "for", "size", "limits", "depth", "thread", "open at"), tuple(rows))


def _from(group: HoleGroup) -> str:
    sides = " & ".join(group.sides) + (", from each" if group.depth and len(group.sides) == 2 else "")
    return f"{sides}, {_degrees(math.degrees(group.lean))} aslant" if group.lean else sides


def _degrees(angle: float) -> str:
    return f"{round(angle, 3) + 0.0:.3f}°"


def _places(
    holes: tuple[HoleGroup, ...], nuts: tuple[NutPocket, ...], seen: dict[str, Projection], part: Part
) -> DrawingTable:
    rows = []
    for group in holes:
        x, y = _coordinates(seen, group.view, part)
        rows += [(h.tag, number(x(h.at[0])), number(y(h.at[1]))) for h in group.holes]
    x, y = _coordinates(seen, FRONT, part)
    rows += [(f"{NUT}{i}", number(x(p.at[0])), number(y(p.at[1]))) for i, p in enumerate(nuts, 1)]
    return DrawingTable("Positions of holes", ("hole", "x", "y"), tuple(rows))


def _coordinates(seen: dict[str, Projection], view: str, part: Part) -> tuple[Coordinate, Coordinate]:
    """How x and y count in a view: from its left and lower edge, or from those opposite."""
    (left, low), (right, high) = seen[view].box()
    return (
        (lambda x: right - x) if leftward(part) else (lambda x: x - left),
        (lambda y: high - y) if downward(part) and view == FRONT else (lambda y: y - low),
    )


def _notch_table(cut: tuple[Notch, ...], seen: dict[str, Projection], part: Part) -> DrawingTable:
    _, y = _coordinates(seen, FRONT, part)
    rows = []
    for way in dict.fromkeys(notch._replace(side="left") for notch in cut):
        sides = [notch.side for notch in cut if notch._replace(side="left") == way]
        use = "mark of the end" if way.role is CutRole.MARK else "to pry at"
        face = "outer face" if way.outer else "inner face"
        where = f"{' & '.join(sorted(sides))}, {face}"
        rows.append((use, f"{number(way.leg)} x 45°", where, *map(number, sorted((y(way.low), y(way.high))))))
    return DrawingTable(
        "Notches across upright edges", ("notch", "size", "edge", "from y", "to y"), tuple(rows)
    )


def _slit_table(cut: tuple[Slit, ...], seen: dict[str, Projection]) -> DrawingTable:
    (left, low), _ = seen[FRONT].box()
    rows = [
        (f"{s.ridge} {s.side}", number(s.at[0] - left), number(s.at[1] - low), _degrees(s.lean))
        for s in cut[:MOST_ROWS]
    ]
    size = f"Slits, {number(cut[0].width)} wide: middle of the bottom; {LEANING}" if cut else ""
    return DrawingTable(size, ("ridge", "x", "y", "leaning"), tuple(rows))


def _groove_table(
    carved: tuple[Groove, ...], seen: dict[str, Projection], part: Part, drops: tuple[float, ...]
) -> DrawingTable:
    x_of, _ = _coordinates(seen, FRONT, part)
    rows: list[tuple[str, ...]] = []
    for groove in carved[:MOST_ROWS]:
        x, z = groove.bottom
        row = str(groove.ridge), number(x_of(x)), number(-z), _degrees(groove.lean)
        allowed = drops[groove.ridge - 1] if drops else None
        rows.append(row if allowed is None else (*row, _allowance(allowed)))
    heads = ("ridge", "x", "below seat", "leaning", "too shallow by")[: 5 if drops else 4]
    return DrawingTable(f"Grooves of the ridges: deepest point; {LEANING}", heads, tuple(rows))


def _allowance(drop: float) -> str:
    return "any" if math.isinf(drop) else f"{drop:.4f}"
