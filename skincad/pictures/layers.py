"""Layers of our drawings, by the names that a shop's program shows: colour, line and what is on them.

What is cut, what is engraved and what is only read have layers of their own, so that a CAM operator switches
the others off. Colours are AutoCAD's numbers (ACI): red is what cuts, as lasers' programs have it.
"""

from __future__ import annotations

from typing import NamedTuple


class Layer(NamedTuple):
    """A layer: ACI colour, line type, its lines' width on paper, mm, and colour there, and what is on it."""

    aci: int
    line: str
    width: float
    ink: str
    what: str


LINES = {  # on paper, mm: total, then strokes and gaps
    "CONTINUOUS": (),
    "HIDDEN": (3.0, -1.0),
    "CENTER": (6.0, -1.0, 1.0, -1.0),
}
LAYERS = {
    "OUTLINE": Layer(7, "CONTINUOUS", 0.35, "#000000", "visible edges; the skin's outline: not for cutting"),
    "SLOTS": Layer(30, "CONTINUOUS", 0.25, "#000000", "slots of the skin's section: not for cutting"),
    "CUT": Layer(1, "CONTINUOUS", 0.25, "#c00000", "what is cut through, at nominal size: no kerf taken off"),
    "FRONT": Layer(3, "CONTINUOUS", 0.18, "#707040", "metal on the film's front, its + side: keep it"),
    "BACK": Layer(4, "CONTINUOUS", 0.18, "#2a7f9e", "metal on its back, as seen through it: keep it"),
    "ENGRAVE": Layer(2, "CONTINUOUS", 0.18, "#1f3f68", "what stays to be read: engraved or inked"),
    "MARK": Layer(5, "CONTINUOUS", 0.18, "#1f3f68", "lines that are only marked: cut off or thinned there"),
    "HIDDEN": Layer(8, "HIDDEN", 0.18, "#707070", "edges behind what is seen: off for cutting"),
    "CENTRE": Layer(140, "CENTER", 0.13, "#909090", "centre lines: off for cutting"),
    "THREAD": Layer(40, "CONTINUOUS", 0.18, "#000000", "threads' major diameters: off for cutting"),
    "DIMENSIONS": Layer(6, "CONTINUOUS", 0.13, "#1f5fa8", "dimensions, leaders and datums: off for cutting"),
    "TEXT": Layer(9, "CONTINUOUS", 0.18, "#000000", "tables and notes: off for cutting"),
    "FRAME": Layer(251, "CONTINUOUS", 0.25, "#000000", "the sheet's frame and title block: off for cutting"),
}
