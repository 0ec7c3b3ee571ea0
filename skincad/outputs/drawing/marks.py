"""Marks of a sheet and their layers, plain data in mm of paper, y up: strokes, fills, words, dimensions.

A dimension has its points, its words and the strokes that draw it. So each format draws it alike, and DXF,
which has dimensions of its own, keeps it as one. Layers have the names that a shop's program shows. What is
cut, what is engraved and what is only read have layers of their own, so that a CAM operator switches the
others off. Colours are AutoCAD's numbers (ACI): red is what cuts, as lasers' programs have it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

from skincad.shape.curves import Loop
from skincad.solids.projection import Place, Polyline, Stroke

Box = tuple[float, float, float, float]  # left, low, right, high, mm
ARROW = (2.2, 0.75)  # mm, length and width of an arrow's head
CAP = 0.72  # height of a capital by the size of Helvetica's or Arial's type
_WIDTHS = {  # thousandths of the size of its type, source: Adobe's metrics of Helvetica, which Arial has too
    191: "'",
    222: "ijl",
    260: "|",
    278: " !,./:;I[\\]ft",
    333: "-()`r",
    334: "{}",
    355: '"',
    389: "*",
    400: "°",
    469: "^",
    500: "Jcksvxyz",
    584: "+<=>~±",
    611: "FTZ",
    667: "ABEKPSVXY&",
    722: "CDHNRUw",
    778: "GOQØ",
    833: "Mm",
    889: "%",
    944: "W",
    1015: "@",
}
_SHARES = {character: share / 1000 for share, row in _WIDTHS.items() for character in row}
LINES = {  # on paper, mm: total, then strokes and gaps
    "CONTINUOUS": (),
    "HIDDEN": (3.0, -1.0),
    "CENTER": (6.0, -1.0, 1.0, -1.0),
}


class Ink(NamedTuple):
    """A stroke on a layer."""

    stroke: Stroke
    layer: str


class Fill(NamedTuple):
    """A filled polygon on a layer."""

    points: tuple[Place, ...]
    layer: str


class Contour(NamedTuple):
    """A closed line with true arcs on a layer: mm of the part, whose numbers a file has as they are."""

    loop: Loop
    layer: str


class Words(NamedTuple):
    """A line of text: where its foot's start, middle or end is, the height of its capitals, mm, and by how
    much it is turned counterclockwise, degrees."""

    text: str
    at: Place
    height: float
    layer: str
    anchor: Literal["start", "middle", "end"] = "start"
    turn: float = 0.0

    def box(self) -> Box:
        """Return the rectangle that it fills, mm; for text that is level or upright."""
        wide = width(self.text, self.height)
        back = {"start": 0.0, "middle": wide / 2, "end": wide}[self.anchor]
        x, y = self.at
        if abs(self.turn) > 45.0:
            return (x - self.height, y - back, x + 0.3 * self.height, y - back + wide)
        return (x - back, y - 0.3 * self.height, x - back + wide, y + self.height)


@dataclass(frozen=True, kw_only=True)
class Dimension:
    """A dimension between two points: a diameter's opposite ones, or the two that a linear one measures along
    `turn`, degrees, its line through `line`. `measured` mm is the part's, `scale` paper by part."""

    kind: Literal["diameter", "linear"]
    ends: tuple[Place, Place]
    line: Place
    turn: float
    measured: float
    scale: float
    words: Words
    drawn: tuple[Ink | Fill, ...]


Mark = Ink | Fill | Contour | Words | Dimension


@dataclass(frozen=True)
class Sheet:
    """A sheet of paper, mm, what is on it, the scale of its views, paper by part, what is cut, which its DXF
    alone shows besides, what is said of that, and where the paper's lower left corner is."""

    title: str
    size: tuple[float, float]
    scale: float
    marks: tuple[Mark, ...]
    cut: tuple[Contour, ...] = ()
    notes: tuple[str, ...] = ()
    corner: Place = (0.0, 0.0)


def width(text: str, height: float) -> float:
    """Return how wide a text with capitals of this height is, mm, in Helvetica or Arial."""
    return height / CAP * math.fsum(_SHARES.get(character, 0.556) for character in text)


def moved(point: Place, way: Place, far: float) -> Place:
    """Return a point moved along a way, `far` times as far."""
    return point[0] + far * way[0], point[1] + far * way[1]


def line(a: Place, b: Place, layer: str) -> Ink:
    """Return a straight stroke."""
    return Ink(Polyline((a, b)), layer)


def rectangle(box: Box, layer: str) -> Ink:
    """Return a rectangle's outline."""
    left, low, right, high = box
    return Ink(Polyline(((left, low), (right, low), (right, high), (left, high), (left, low))), layer)


def arrow(tip: Place, angle: float) -> Fill:
    """Return an arrow's head that points along an angle, rad."""
    long, wide = ARROW
    (x, y), c, s = tip, math.cos(angle), math.sin(angle)
    sides = [(x - long * c - side * wide / 2 * s, y - long * s + side * wide / 2 * c) for side in (-1, 1)]
    return Fill((tip, *sides), "DIMENSIONS")


def overlap(a: Box, b: Box) -> bool:
    """Whether two rectangles share more than an edge."""
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def linear(
    ends: tuple[Place, Place], away: float, level: bool, scale: float, words: str, height: float = 2.0
) -> Dimension:
    """Return a dimension along x (`level`) or y, its line at y or x = `away` mm."""
    (x0, y0), (x1, y1) = ends
    feet = ((x0, away), (x1, away)) if level else ((away, y0), (away, y1))
    return _linear_dimension(ends, feet, scale, words, height, 0.0 if level else 90.0)


def aligned(
    ends: tuple[Place, Place], out: float, scale: float, words: str, height: float = 2.0
) -> Dimension:
    """Return a dimension parallel to the way between two ends, its line `out` mm to the left of it."""
    (x0, y0), (x1, y1) = ends
    along = math.atan2(y1 - y0, x1 - x0)
    u, v = -out * math.sin(along), out * math.cos(along)
    feet = (x0 + u, y0 + v), (x1 + u, y1 + v)
    turn = math.degrees(along)
    if not -89.0 < turn <= 91.0:  # read from below or from the right
        turn, feet, ends = turn - math.copysign(180.0, turn), feet[::-1], ends[::-1]
    return _linear_dimension(ends, feet, scale, words, height, turn)


def _linear_dimension(
    ends: tuple[Place, Place], feet: tuple[Place, Place], scale: float, words: str, height: float, turn: float
) -> Dimension:
    a, b = feet
    along = math.atan2(b[1] - a[1], b[0] - a[0])
    span, inner = math.dist(a, b), 2.5 * ARROW[0]
    marks: list[Ink | Fill] = []
    for end, foot in zip(ends, feet, strict=True):
        out = math.dist(end, foot)
        if out > 0.8:
            way = (foot[0] - end[0]) / out, (foot[1] - end[1]) / out
            marks.append(line(moved(end, way, 0.8), moved(foot, way, 1.2), "DIMENSIONS"))
    tight = span < inner
    flip = math.pi if tight else 0.0
    marks += [arrow(a, along + math.pi + flip), arrow(b, along + flip)]
    overshoot = 2 * ARROW[0] if tight else 0.0
    way = math.cos(along), math.sin(along)
    need = width(words, height)
    outside = need > span - (0.0 if tight else 2 * ARROW[0]) + 1.0
    far = overshoot + (need + 1.5 if outside else 0.0)
    marks.append(line(moved(a, way, -overshoot), moved(b, way, far), "DIMENSIONS"))
    middle = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
    if outside:
        middle = moved(b, way, overshoot + 1.0 + need / 2)
    up = -math.sin(math.radians(turn)), math.cos(math.radians(turn))
    text = Words(words, moved(middle, up, 0.7), height, "DIMENSIONS", "middle", turn)
    return Dimension(
        kind="linear",
        ends=ends,
        line=feet[0],
        turn=turn,
        measured=span / scale,
        scale=scale,
        words=text,
        drawn=tuple(marks),
    )


def diameter(centre: Place, radius: float, angle: float, scale: float, words: Words) -> Dimension:
    """Return a circle's diameter, its leader out of it along an angle, rad, to the text."""
    way, box = (math.cos(angle), math.sin(angle)), words.box()
    near, far = moved(centre, way, radius), moved(centre, way, -radius)
    end = box[0] if words.anchor == "start" else box[2], words.at[1] - 0.4
    marks = (
        arrow(near, angle + math.pi),
        line(near, end, "DIMENSIONS"),
        line((box[0], end[1]), (box[2], end[1]), "DIMENSIONS"),
    )
    return Dimension(
        kind="diameter",
        ends=(far, near),
        line=end,
        turn=0.0,
        measured=2 * radius / scale,
        scale=scale,
        words=words,
        drawn=marks,
    )


class Layer(NamedTuple):
    """A layer: ACI colour, line type, its lines' width on paper, mm, and colour there, what is on it, and the
    colour and opacity that fill its closed lines in a picture."""

    aci: int
    line: str
    width: float
    ink: str
    what: str
    fill: str = "none"
    opacity: float = 1.0


LAYERS = {
    "MOLD": Layer(252, "CONTINUOUS", 0.25, "#222222", "the mold's parts", "#dde1e6"),
    "OPENING": Layer(254, "CONTINUOUS", 0.25, "#222222", "bores, and the carrier's place", "#ffffff"),
    "SKIN": Layer(31, "CONTINUOUS", 0.25, "#222222", "the skin", "#f3d3c4"),
    "OUTLINE": Layer(7, "CONTINUOUS", 0.35, "#000000", "visible edges; the skin's outline: not for cutting"),
    "SLOTS": Layer(
        30, "CONTINUOUS", 0.25, "#000000", "slots of the skin's section: not for cutting", "#ffffff"
    ),
    "CUT": Layer(1, "CONTINUOUS", 0.25, "#c00000", "what is cut through, at nominal size: no kerf taken off"),
    "FRONT": Layer(
        *(3, "CONTINUOUS", 0.18, "#707040", "metal on the film's front, its + side: keep it"),
        fill="#d08020",
        opacity=0.5,
    ),
    "BACK": Layer(
        *(4, "CONTINUOUS", 0.18, "#2a7f9e", "metal on its back, as seen through it: keep it"),
        fill="#2080c0",
        opacity=0.5,
    ),
    "ENGRAVE": Layer(2, "CONTINUOUS", 0.18, "#1f3f68", "what stays to be read: engraved or inked"),
    "MARK": Layer(5, "CONTINUOUS", 0.18, "#1f3f68", "lines that are only marked: cut off or thinned there"),
    "HIDDEN": Layer(8, "HIDDEN", 0.18, "#707070", "edges behind what is seen: off for cutting"),
    "CENTRE": Layer(140, "CENTER", 0.13, "#909090", "centre lines: off for cutting"),
    "THREAD": Layer(40, "CONTINUOUS", 0.18, "#000000", "threads' major diameters: off for cutting"),
    "DIMENSIONS": Layer(6, "CONTINUOUS", 0.13, "#1f5fa8", "dimensions, leaders and datums: off for cutting"),
    "TEXT": Layer(9, "CONTINUOUS", 0.18, "#000000", "tables and notes: off for cutting"),
    "FRAME": Layer(251, "CONTINUOUS", 0.25, "#000000", "the sheet's frame and title block: off for cutting"),
}
