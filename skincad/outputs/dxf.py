"""DXF files, mm, with named layers, colours and line types; same input, same bytes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any

import ezdxf
from ezdxf import units as dxf_units
from ezdxf.enums import TextEntityAlignment

from skincad.pictures.layers import LAYERS, LINES
from skincad.pictures.marks import ARROW, Dimension, Fill, Ink, Mark, Sheet, Words
from skincad.shape.curves import Loop
from skincad.solids.projection import Arc, Place, Stroke

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.layouts import BaseLayout

FONT = "SKINCAD"  # text style, in Arial
ROTATED, DIAMETER, OWN_BLOCK, PLACED = 0, 3, 32, 128  # source: DXF reference, group 70 of DIMENSION
DEGREES = 180 / math.pi
FIRST_NOTE = 20.0, 4.0  # mm of paper: the first note of a sheet, under its frame
_ANCHORS = {
    "start": TextEntityAlignment.LEFT,
    "middle": TextEntityAlignment.CENTER,
    "end": TextEntityAlignment.RIGHT,
}
_ONE_AT_A_TIME = Lock()  # the DXF library's options are the process's


def write_dxf(
    path: Path,
    marks: Iterable[Mark],
    scale: float = 1.0,
    loops: Iterable[tuple[str, Loop]] = (),
    notes: Iterable[str] = (),
) -> None:
    """Write marks on paper as DXF in the part's own millimetres: `scale` is paper by part; and closed
    outlines with true arcs, mm of the part, on these layers. Notes are the file's properties, which a
    program shows without drawing them."""
    with _no_clock():
        marks, outlines = list(marks), list(loops)
        document = _document(scale, {name for name, _ in outlines} | set(_layers(marks)))
        for number, note in enumerate(notes, 1):
            document.header.custom_vars.append(f"note {number}", note)
        space = document.modelspace()
        for layer, outline in outlines:
            corners = [(s.start.x, s.start.z, s.bulge) for s in outline]
            space.add_lwpolyline(corners, format="xyb", close=True, dxfattribs={"layer": layer})
        for mark in marks:
            if isinstance(mark, Dimension):
                _dimension(document, space, mark, scale)
            else:
                _draw(space, mark, scale)
        for kind in sorted(document.entitydb.dxf_types_in_use()):  # the library goes through a set
            document.classes.add_class(kind)
        document.saveas(path)


def write_sheet_dxf(sheet: Sheet, path: Path) -> None:
    """Write a sheet as DXF at the part's full size, with what is cut on layer CUT, and what is said of that
    under the frame."""
    texts = [
        Words(note, (FIRST_NOTE[0], FIRST_NOTE[1] - 4.0 * i), 2.0, "TEXT")
        for i, note in enumerate(sheet.notes)
    ]
    write_dxf(path, [*sheet.marks, *texts], sheet.scale, sheet.loops, sheet.notes)


def _layers(marks: Iterable[Mark]) -> Iterator[str]:
    for mark in marks:
        yield "DIMENSIONS" if isinstance(mark, Dimension) else mark.layer


def _document(scale: float, used: set[str]) -> Drawing:
    """An empty drawing with the layers that are used, so that nobody looks for what isn't there."""
    document = ezdxf.new("R2010", units=dxf_units.MM)
    document.header["$LTSCALE"] = 1 / scale
    document.styles.add(FONT, font="arial.ttf")
    for name, strokes in LINES.items():
        if strokes:
            pattern = [sum(abs(length) for length in strokes), *strokes]
            document.linetypes.add(name, pattern=pattern)
    for name in (name for name in LAYERS if name in used):
        layer = LAYERS[name]
        weight = round(100 * layer.width)
        entry = document.layers.add(name, color=layer.aci, linetype=layer.line, lineweight=weight)
        entry.description = layer.what
    return document


def _draw(space: BaseLayout, mark: Ink | Fill | Words, scale: float) -> None:
    layer = {"layer": mark.layer}
    if isinstance(mark, Ink):
        _stroke(space, mark.stroke, layer, scale)
    elif isinstance(mark, Fill):
        a, b, c = (_scaled(point, scale) for point in mark.points)
        space.add_solid([a, b, c, c], dxfattribs=layer)
    else:
        attributes = {**layer, "style": FONT, "rotation": mark.turn}
        text = space.add_text(mark.text, height=mark.height / scale, dxfattribs=attributes)
        text.set_placement(_scaled(mark.at, scale), align=_ANCHORS[mark.anchor])


def _stroke(space: BaseLayout, stroke: Stroke, layer: dict[str, str], scale: float) -> None:
    if isinstance(stroke, Arc):
        centre, radius = _scaled(stroke.centre, scale), stroke.radius / scale
        if stroke.whole:
            space.add_circle(centre, radius, dxfattribs=layer)
        else:
            start = DEGREES * stroke.start
            space.add_arc(centre, radius, start, start + DEGREES * stroke.sweep, dxfattribs=layer)
    elif len(stroke.points) == 2:
        space.add_line(*(_scaled(point, scale) for point in stroke.points), dxfattribs=layer)
    else:
        space.add_lwpolyline([_scaled(point, scale) for point in stroke.points], dxfattribs=layer)


def _scaled(point: Place, scale: float) -> Place:
    return point[0] / scale, point[1] / scale


def _dimension(document: Drawing, space: BaseLayout, mark: Dimension, scale: float) -> None:
    """A dimension as such, with what is drawn of it in a block of its own, as DXF has it."""
    block = document.blocks.new_anonymous_block(type_char="D")
    for part in (*mark.drawn, mark.words):
        _draw(block, part, scale)
    (left, low, right, high) = mark.words.box()
    attributes: dict[str, Any] = {
        "layer": "DIMENSIONS",
        "geometry": block.name,
        "dimstyle": _style(document, mark, scale),
        "text": mark.words.text,
        "text_midpoint": _scaled(((left + right) / 2, (low + high) / 2), scale),
        "actual_measurement": mark.measured,
    }
    first, second = (_scaled(end, scale) for end in mark.ends)
    if mark.kind == "diameter":
        attributes |= {"dimtype": DIAMETER | OWN_BLOCK | PLACED, "defpoint": first, "defpoint4": second}
    else:
        attributes |= {"dimtype": ROTATED | OWN_BLOCK | PLACED, "defpoint": _scaled(mark.line, scale)}
        attributes |= {"defpoint2": first, "defpoint3": second, "angle": mark.turn}
    space.new_entity("DIMENSION", attributes)


def _style(document: Drawing, mark: Dimension, scale: float) -> str:
    """The dimension style of a view: its own factor from what is drawn to what is measured."""
    factor = scale / mark.scale
    name = FONT if factor == 1.0 else f"{FONT}-{1 / factor:g}"
    if name not in document.dimstyles:
        sizes = {"dimtxt": mark.words.height / scale, "dimasz": ARROW[0] / scale, "dimdec": 3}
        document.dimstyles.add(name, dxfattribs={**sizes, "dimlfac": factor, "dimtxsty": FONT})
    return name


@contextmanager
def _no_clock() -> Iterator[None]:
    """Have the DXF library write constant times and identifiers, in here only."""
    with _ONE_AT_A_TIME:
        before = ezdxf.options.write_fixed_meta_data_for_testing
        ezdxf.options.write_fixed_meta_data_for_testing = True
        try:
            yield
        finally:
            ezdxf.options.write_fixed_meta_data_for_testing = before
