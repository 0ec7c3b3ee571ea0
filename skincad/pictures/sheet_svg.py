"""A drawing sheet as SVG, mm; words are text."""

from __future__ import annotations

import math
from collections.abc import Iterable
from xml.sax.saxutils import escape

from skincad.pictures.layers import LAYERS, LINES
from skincad.pictures.marks import CAP, Dimension, Fill, Ink, Mark, Sheet, Words
from skincad.solids.projection import Arc, Stroke


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
        return _stroke(mark.stroke, tall)
    if isinstance(mark, Fill):
        points = " ".join(f"{x:.3f},{tall - y:.3f}" for x, y in mark.points)
        return f'<polygon points="{points}" fill="{ink}" stroke="none"/>'
    x, y = mark.at[0], tall - mark.at[1]
    turn = f' transform="rotate({-mark.turn:.3f} {x:.3f} {y:.3f})"' if mark.turn else ""
    return (
        f'<text x="{x:.3f}" y="{y:.3f}" style="font-size:{mark.height / CAP:.3f}px" '
        f'text-anchor="{mark.anchor}" fill="{ink}" stroke="none"{turn}>{escape(mark.text)}</text>'
    )


def _stroke(stroke: Stroke, tall: float) -> str:
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
