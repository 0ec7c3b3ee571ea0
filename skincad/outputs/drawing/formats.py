"""Marks and sheets as files: DXF, SVG and PDF, by layer; same input, same bytes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
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
    Contour,
    Dimension,
    Fill,
    Ink,
    Mark,
    Sheet,
    Words,
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
_ONE_AT_A_TIME = Lock()  # the DXF library's options are the process's
_SIDES = {"start": "left", "middle": "center", "end": "right"}
THIN = 0.03  # mm of the part, no contour is drawn wider in a picture: strips are 0.25 mm wide
INCH = 25.4  # mm
POINT = 72 / INCH  # points in a millimetre


def write_dxf(path: Path, marks: Iterable[Mark], scale: float = 1.0, notes: Iterable[str] = ()) -> None:
    """Write marks on paper as DXF in the part's own millimetres: `scale` is paper by part. Notes are the
    file's properties, which a program shows without drawing them."""
    with _no_clock():
        marks = sorted(marks, key=lambda mark: not isinstance(mark, Contour))
        document = _dxf_document(scale, {_layer(mark) for mark in marks})
        for number, note in enumerate(notes, 1):
            document.header.custom_vars.append(f"note {number}", note)
        space = document.modelspace()
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
    x, y = FIRST_NOTE
    texts = [Words(note, (x, y - 4.0 * i), 2.0, "TEXT") for i, note in enumerate(sheet.notes)]
    write_dxf(path, [*sheet.cut, *sheet.marks, *texts], sheet.scale, sheet.notes)


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


def _dxf_mark(space: BaseLayout, mark: Ink | Fill | Contour | Words, scale: float) -> None:
    layer = {"layer": mark.layer}
    if isinstance(mark, Contour):
        corners = [(s.start.x, s.start.z, s.bulge) for s in mark.loop]
        space.add_lwpolyline(corners, format="xyb", close=True, dxfattribs=layer)
    elif isinstance(mark, Ink):
        _dxf_stroke(space, mark.stroke, layer, scale)
    elif isinstance(mark, Fill):
        a, b, c = (_scaled(point, scale) for point in mark.points)
        space.add_solid([a, b, c, c], dxfattribs=layer)
    else:
        attributes = {**layer, "style": FONT, "rotation": mark.turn}
        text = space.add_text(mark.text, height=mark.height / scale, dxfattribs=attributes)
        text.set_placement(_scaled(mark.at, scale), align=TextEntityAlignment[_SIDES[mark.anchor].upper()])


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


def sheet_svg(sheet: Sheet, size: float = 1.0) -> str:
    """Return a sheet as an SVG document, `size` times as large as its paper; groups bear layers' names."""
    (left, low), (wide, tall) = sheet.corner, sheet.size

    def at(point: Place) -> Place:
        """Where a point is on the page, from its upper left corner."""
        return point[0] - left, low + tall - point[1]

    rows: dict[str, list[str]] = {}
    for mark in primitives(sheet.marks):
        rows.setdefault(mark.layer, []).append(_svg_row(mark, at, sheet.scale))
    groups = [
        f'<g id="{name}" {_svg_style(name)}>\n' + "\n".join(rows[name]) + "\n</g>"
        for name in LAYERS
        if name in rows
    ]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size * wide:g}mm" height="{size * tall:g}mm" '
        f'viewBox="0 0 {wide:g} {tall:g}" font-family="Arial, Helvetica, sans-serif">\n'
        f"<title>{escape(sheet.title)}</title>\n"
        f'<rect width="{wide:g}" height="{tall:g}" fill="#fff"/>\n' + "\n".join(groups) + "\n</svg>\n"
    )


def primitives(marks: Iterable[Mark]) -> Iterable[Ink | Fill | Contour | Words]:
    """Yield what is drawn: of a dimension its lines, arrows and words."""
    for mark in marks:
        if isinstance(mark, Dimension):
            yield from mark.drawn
            yield mark.words
        else:
            yield mark


def _svg_style(name: str) -> str:
    """A layer's fill, colour, width and dashes as SVG's attributes."""
    layer = LAYERS[name]
    dashes = " ".join(f"{abs(length):g}" for length in LINES[layer.line])
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    clear = f' fill-opacity="{layer.opacity:g}"' if layer.opacity < 1 else ""
    return f'fill="{layer.fill}"{clear} stroke="{layer.ink}" stroke-width="{layer.width:g}"{dashed}'


def _svg_row(mark: Ink | Fill | Contour | Words, at: Callable[[Place], Place], scale: float) -> str:
    layer = LAYERS[mark.layer]
    if isinstance(mark, Ink):
        return _svg_stroke(mark.stroke, at)
    if isinstance(mark, Contour):
        thin = f' stroke-width="{min(layer.width, scale * THIN):g}"'
        return f'<path d="{_svg_path(mark.loop, at, scale)}"{thin}/>'
    if isinstance(mark, Fill):
        return f'<polygon points="{_svg_points(mark.points, at)}" fill="{layer.ink}" stroke="none"/>'
    x, y = at(mark.at)
    turn = f' transform="rotate({-mark.turn:.3f} {x:.3f} {y:.3f})"' if mark.turn else ""
    return (
        f'<text x="{x:.3f}" y="{y:.3f}" style="font-size:{mark.height / CAP:.3f}px" '
        f'text-anchor="{mark.anchor}" fill="{layer.ink}" stroke="none"{turn}>{escape(mark.text)}</text>'
    )


def _svg_points(points: Iterable[Place], at: Callable[[Place], Place]) -> str:
    return " ".join(f"{x:.3f},{y:.3f}" for x, y in map(at, points))


def _svg_stroke(stroke: Stroke, at: Callable[[Place], Place]) -> str:
    if not isinstance(stroke, Arc):
        return f'<polyline points="{_svg_points(stroke.points, at)}"/>'
    r = f"{stroke.radius:.3f}"
    if stroke.whole:
        x, y = at(stroke.centre)
        return f'<circle cx="{x:.3f}" cy="{y:.3f}" r="{r}"/>'
    (a, b), (c, d) = at(stroke.at(0.0)), at(stroke.at(1.0))
    return f'<path d="M{a:.3f} {b:.3f} A{r} {r} 0 {int(stroke.sweep > math.pi)} 0 {c:.3f} {d:.3f}"/>'


def _svg_path(loop: Loop, at: Callable[[Place], Place], scale: float) -> str:
    """A contour's steps; of an arc that is nearly straight, its chord."""
    steps = []
    for segment in loop:
        x, y = at((scale * segment.end.x, scale * segment.end.z))
        arc, r = segment.bulge != 0.0 and math.isfinite(segment.radius), scale * segment.radius
        sides = f"{int(abs(segment.sweep) > math.pi)} {int(segment.bulge < 0)}"
        steps.append(f"A{r:.6g} {r:.6g} 0 {sides} {x:.4f} {y:.4f}" if arc else f"L{x:.4f} {y:.4f}")
    x, y = at((scale * loop[0].start.x, scale * loop[0].start.z))
    return " ".join([f"M{x:.4f} {y:.4f}", *steps, "Z"])


def write_sheet_pdf(sheet: Sheet, path: Path) -> None:
    """Write a sheet without contours as PDF of its size, mm; its words are text in Helvetica."""
    # here, because DXF and SVG, which a notebook shows at once, need none of it
    from skincad.outputs.figures.canvas import Affine2D, Curve, PathCollection, Picture, own_style, pdf

    def curve(stroke: Stroke) -> Curve:
        if not isinstance(stroke, Arc):
            return Curve(stroke.points)
        unit = Curve.unit_circle() if stroke.whole else Curve.arc(0.0, DEGREES * stroke.sweep)
        at_its_place = Affine2D().rotate(stroke.start).scale(stroke.radius).translate(*stroke.centre)
        return unit.transformed(at_its_place)

    marks, (wide, tall) = list(primitives(sheet.marks)), sheet.size
    with own_style():
        figure = Picture(figsize=(wide / INCH, tall / INCH), frameon=False)
        on_paper = Affine2D().scale(1 / INCH) + figure.dpi_scale_trans
        for name, layer in LAYERS.items():
            dashes = [abs(length) / layer.width for length in LINES[layer.line]]
            look: dict[str, Any] = {"edgecolor": layer.ink, "linestyle": (0, dashes) if dashes else "-"}
            look |= {"capstyle": "round", "joinstyle": "round", "transform": on_paper}
            strokes = [curve(m.stroke) for m in marks if m.layer == name and isinstance(m, Ink)]
            fills = [Curve(m.points) for m in marks if m.layer == name and isinstance(m, Fill)]
            edge: dict[str, Any] = {"facecolor": "none", "linewidth": layer.width * POINT}
            figure.add_artist(PathCollection(strokes, **edge, **look))
            figure.add_artist(PathCollection(fills, facecolor=layer.ink, linewidth=0.0, **look))
            for mark in (m for m in marks if m.layer == name and isinstance(m, Words)):
                words = figure.text(*mark.at, mark.text, size=mark.height / CAP * POINT, color=layer.ink)
                words.set(family="Helvetica", weight="medium", parse_math=False, transform=on_paper)
                words.set(ha=_SIDES[mark.anchor], va="baseline", rotation=mark.turn, rotation_mode="anchor")
        path.write_bytes(pdf(figure, sheet.title))
