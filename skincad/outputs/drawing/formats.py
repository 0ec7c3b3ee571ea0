"""Marks and sheets as files: DXF, SVG and PDF, by layer; same input, same bytes.

A sheet as PDF takes 2 ms: it is lines, filled triangles and words in Helvetica, one of the fonts that every
reader of PDF has (ISO 32000-1, 9.6.2.2). matplotlib took 0.1 s a sheet, and `make` writes one for each part.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import escape

import ezdxf
from ezdxf import units as dxf_units
from ezdxf.enums import TextEntityAlignment

from skincad.outputs.drawing.marks import (
    ARROW,
    CAP,
    LAYERS,
    LINES,
    Dimension,
    Fill,
    Ink,
    Mark,
    Sheet,
    Words,
    width,
)
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
POINT = 72 / 25.4  # points in a millimetre


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
        document = _dxf_document(scale, {name for name, _ in outlines} | {_layer(mark) for mark in marks})
        for number, note in enumerate(notes, 1):
            document.header.custom_vars.append(f"note {number}", note)
        space = document.modelspace()
        for layer, outline in outlines:
            corners = [(s.start.x, s.start.z, s.bulge) for s in outline]
            space.add_lwpolyline(corners, format="xyb", close=True, dxfattribs={"layer": layer})
        for mark in marks:
            if isinstance(mark, Dimension):
                _dxf_dimension(document, space, mark, scale)
            else:
                _dxf_mark(space, mark, scale)
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


def _layer(mark: Mark) -> str:
    return "DIMENSIONS" if isinstance(mark, Dimension) else mark.layer


def _dxf_document(scale: float, used: set[str]) -> Drawing:
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


def _dxf_mark(space: BaseLayout, mark: Ink | Fill | Words, scale: float) -> None:
    layer = {"layer": mark.layer}
    if isinstance(mark, Ink):
        _dxf_stroke(space, mark.stroke, layer, scale)
    elif isinstance(mark, Fill):
        a, b, c = (_scaled(point, scale) for point in mark.points)
        space.add_solid([a, b, c, c], dxfattribs=layer)
    else:
        attributes = {**layer, "style": FONT, "rotation": mark.turn}
        text = space.add_text(mark.text, height=mark.height / scale, dxfattribs=attributes)
        text.set_placement(_scaled(mark.at, scale), align=_ANCHORS[mark.anchor])


def _dxf_stroke(space: BaseLayout, stroke: Stroke, layer: dict[str, str], scale: float) -> None:
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


def _dxf_dimension(document: Drawing, space: BaseLayout, mark: Dimension, scale: float) -> None:
    """A dimension as such, with what is drawn of it in a block of its own, as DXF has it."""
    block = document.blocks.new_anonymous_block(type_char="D")
    for part in (*mark.drawn, mark.words):
        _dxf_mark(block, part, scale)
    (left, low, right, high) = mark.words.box()
    attributes: dict[str, Any] = {
        "layer": "DIMENSIONS",
        "geometry": block.name,
        "dimstyle": _dxf_style(document, mark, scale),
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


def _dxf_style(document: Drawing, mark: Dimension, scale: float) -> str:
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


def sheet_svg(sheet: Sheet) -> str:
    """Return a sheet as an SVG document of its size; groups carry the layers' names."""
    wide, tall = sheet.size
    rows: dict[str, list[str]] = {}
    for mark in primitives(sheet.marks):
        rows.setdefault(mark.layer, []).append(svg_row(mark, tall))
    groups = [
        f'<g id="{name}" {svg_style(name)}>\n' + "\n".join(rows[name]) + "\n</g>"
        for name in LAYERS
        if name in rows
    ]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide:g}mm" height="{tall:g}mm" '
        f'viewBox="0 0 {wide:g} {tall:g}" font-family="Arial, Helvetica, sans-serif">\n'
        f"<title>{escape(sheet.title)}</title>\n"
        f'<rect width="{wide:g}" height="{tall:g}" fill="#fff"/>\n' + "\n".join(groups) + "\n</svg>\n"
    )


def primitives(marks: Iterable[Mark]) -> Iterable[Ink | Fill | Words]:
    """Yield what is drawn: of a dimension its lines, arrows and words."""
    for mark in marks:
        if isinstance(mark, Dimension):
            yield from mark.drawn
            yield mark.words
        else:
            yield mark


def svg_style(name: str) -> str:
    """Return a layer's colour, width and dashes as SVG's attributes."""
    layer = LAYERS[name]
    dashes = " ".join(f"{abs(length):g}" for length in LINES[layer.line])
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    return f'fill="none" stroke="{layer.ink}" stroke-width="{layer.width:g}"{dashed}'


def svg_row(mark: Ink | Fill | Words, tall: float) -> str:
    """Return a mark on paper that is `tall` mm high."""
    ink = LAYERS[mark.layer].ink
    if isinstance(mark, Ink):
        return _svg_stroke(mark.stroke, tall)
    if isinstance(mark, Fill):
        points = " ".join(f"{x:.3f},{tall - y:.3f}" for x, y in mark.points)
        return f'<polygon points="{points}" fill="{ink}" stroke="none"/>'
    x, y = mark.at[0], tall - mark.at[1]
    turn = f' transform="rotate({-mark.turn:.3f} {x:.3f} {y:.3f})"' if mark.turn else ""
    return (
        f'<text x="{x:.3f}" y="{y:.3f}" style="font-size:{mark.height / CAP:.3f}px" '
        f'text-anchor="{mark.anchor}" fill="{ink}" stroke="none"{turn}>{escape(mark.text)}</text>'
    )


def _svg_stroke(stroke: Stroke, tall: float) -> str:
    if not isinstance(stroke, Arc):
        points = " ".join(f"{x:.3f},{tall - y:.3f}" for x, y in stroke.points)
        return f'<polyline points="{points}"/>'
    x, y = stroke.centre
    if stroke.whole:
        return f'<circle cx="{x:.3f}" cy="{tall - y:.3f}" r="{stroke.radius:.3f}"/>'
    (a, b), (c, d) = stroke.at(0.0), stroke.at(1.0)
    wide = int(stroke.sweep > math.pi)
    r = f"{stroke.radius:.3f}"
    return f'<path d="M{a:.3f} {tall - b:.3f} A{r} {r} 0 {wide} 0 {c:.3f} {tall - d:.3f}"/>'


def write_sheet_pdf(sheet: Sheet, path: Path) -> None:
    """Write a sheet as PDF."""
    wide, tall = (f"{POINT * size:.3f}" for size in sheet.size)
    content = zlib.compress("\n".join(_pdf_content(sheet)).encode("cp1252", "replace"), 9)
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {wide} {tall}] /Contents 4 0 R "
        "/Resources << /Font << /F 5 0 R >> >> >>".encode(),
        b"<< /Length %d /Filter /FlateDecode >>\nstream\n%b\nendstream" % (len(content), content),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
        b"<< /Title %b /Creator (skincad) >>" % _pdf_string(sheet.title).encode("cp1252", "replace"),
    ]
    path.write_bytes(_pdf_file(objects))


def _pdf_file(objects: list[bytes]) -> bytes:
    """The objects, numbered from 1, the table of where they begin, and the trailer."""
    written, places = b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n", []
    for number, body in enumerate(objects, 1):
        places.append(len(written))
        written += b"%d 0 obj\n%b\nendobj\n" % (number, body)
    table = b"".join(b"%010d 00000 n \n" % place for place in places)
    count = len(objects) + 1
    return (
        written
        + b"xref\n0 %d\n0000000000 65535 f \n%b" % (count, table)
        + b"trailer\n<< /Size %d /Root 1 0 R /Info %d 0 R >>\n" % (count, len(objects))
        + b"startxref\n%d\n%%%%EOF\n" % len(written)
    )


def _pdf_content(sheet: Sheet) -> Iterator[str]:
    """The page's operators; lengths are scaled to millimetres at once."""
    yield f"{POINT:.6f} 0 0 {POINT:.6f} 0 0 cm 1 J 1 j"
    marks = list(primitives(sheet.marks))
    for name, layer in LAYERS.items():
        layer_marks = [mark for mark in marks if mark.layer == name]
        if not layer_marks:
            continue
        red, green, blue = (int(layer.ink[i : i + 2], 16) / 255 for i in (1, 3, 5))
        dashes = " ".join(f"{abs(length):g}" for length in LINES[layer.line])
        yield f"{red:.3f} {green:.3f} {blue:.3f} RG {red:.3f} {green:.3f} {blue:.3f} rg"
        yield f"{layer.width:g} w [{dashes}] 0 d"
        for mark in layer_marks:
            if isinstance(mark, Ink):
                yield f"{_pdf_path(mark.stroke)} S"
            elif isinstance(mark, Fill):
                yield f"{_pdf_lines(mark.points)} f"
            else:
                yield _pdf_text(mark)


def _pdf_lines(points: tuple[Place, ...]) -> str:
    steps = [f"{x:.4f} {y:.4f} {'l' if i else 'm'}" for i, (x, y) in enumerate(points)]
    return " ".join(steps)


def _pdf_path(stroke: Stroke) -> str:
    """A stroke; an arc as Bezier curves of a quarter circle at most, within 0.03 % of its radius."""
    if not isinstance(stroke, Arc):
        return _pdf_lines(stroke.points)
    count = max(1, math.ceil(stroke.sweep / (math.pi / 2) - 1e-9))
    step = stroke.sweep / count
    handle = 4 / 3 * math.tan(step / 4) * stroke.radius
    x, y = stroke.at(0.0)
    steps = [f"{x:.4f} {y:.4f} m"]
    for i in range(count):
        (a, b), (c, d) = stroke.at(i / count), stroke.at((i + 1) / count)
        start, end = stroke.start + i * step, stroke.start + (i + 1) * step
        p, q = a - handle * math.sin(start), b + handle * math.cos(start)
        r, s = c + handle * math.sin(end), d - handle * math.cos(end)
        steps.append(f"{p:.4f} {q:.4f} {r:.4f} {s:.4f} {c:.4f} {d:.4f} c")
    return " ".join(steps)


def _pdf_text(words: Words) -> str:
    back = {"start": 0.0, "middle": 0.5, "end": 1.0}[words.anchor] * width(words.text, words.height)
    way = math.radians(words.turn)
    c, s = math.cos(way), math.sin(way)
    x, y = words.at[0] - back * c, words.at[1] - back * s
    turned = f"{c:.5f} {s:.5f} {-s:.5f} {c:.5f} {x:.4f} {y:.4f} Tm"
    return f"BT /F {words.height / CAP:.4f} Tf {turned} {_pdf_string(words.text)} Tj ET"


def _pdf_string(text: str) -> str:
    escaped = text.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")
    return f"({escaped})"
