"""A .kicad_sch file read as KiCad reads it: symbols, pins in their places, and what is connected to what.

Written from the description of the format alone. A wire connects at its ends; what lies along it is connected
only at a junction. A power symbol's pin carries the name of its net, a global label its own.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

Point = tuple[int, int]  # um
Pin = tuple[str, str]  # reference and number
WORDS = re.compile(r'\(|\)|"((?:[^"\\]|\\.)*)"|([^\s()"]+)')


def parsed(text: str) -> list[Any]:
    """Return the lists of an S-expression's file."""
    stack: list[list[Any]] = [[]]
    for match in WORDS.finditer(text):
        if match[0] == "(":
            stack.append([])
        elif match[0] == ")":
            stack[-2].append(stack.pop())
        else:
            stack[-1].append(match[2] if match[2] is not None else match[1])
    (whole,) = stack
    return whole[0]


def of(node: list[Any], name: str) -> list[list[Any]]:
    return [child for child in node if isinstance(child, list) and child[0] == name]


def property_of(node: list[Any], name: str) -> str:
    return next(child[2] for child in of(node, "property") if child[1] == name)


def point(x: str | float, y: str | float) -> Point:
    return round(1000 * float(x)), round(1000 * float(y))


@dataclass
class Drawing:
    """Parts by reference, and the sets of pins that are connected, with the names that each has."""

    parts: dict[str, dict[str, str]] = field(default_factory=dict)  # their properties
    nets: dict[frozenset[Pin], set[str]] = field(default_factory=dict)
    dots: set[Point] = field(default_factory=set)
    meetings: set[Point] = field(default_factory=set)  # of three ends of wires or more

    def named(self, name: str) -> frozenset[Pin]:
        """Return the pins of the net that has this name."""
        (pins,) = [pins for pins, names in self.nets.items() if name in names]
        return pins


def library_pins(symbol: list[Any], unit: int) -> Iterator[tuple[str, str, float, float]]:
    """Return number, name and place of the pins of a symbol's unit; unit 0 is common to all."""
    bare = symbol[1].partition(":")[2]
    for part in of(symbol, "symbol"):
        number = int(part[1].removeprefix(f"{bare}_").split("_")[0])
        for pin in of(part, "pin") if number in (0, unit) else ():
            (at,) = of(pin, "at")
            yield of(pin, "number")[0][1], of(pin, "name")[0][1], float(at[1]), float(at[2])


class _Links:
    """Things that are connected, in groups (union-find)."""

    def __init__(self) -> None:
        self.links: dict[Any, Any] = {}

    def root(self, thing: Any) -> Any:
        while self.links.setdefault(thing, thing) != thing:
            thing = self.links[thing]
        return thing

    def join(self, a: Any, b: Any) -> None:
        self.links[self.root(a)] = self.root(b)


def placed_pins(symbol: list[Any], library: list[Any]) -> Iterator[tuple[str, str, Point]]:
    """Return number, name and place of the pins of a symbol on the sheet."""
    (at,) = of(symbol, "at")
    x, y, turn = float(at[1]), float(at[2]), math.radians(float(at[3]))
    for number, name, px, py in library_pins(library, int(of(symbol, "unit")[0][1])):
        # counterclockwise as one sees it; the library's y points up, the sheet's down
        rx, ry = px * math.cos(turn) - py * math.sin(turn), px * math.sin(turn) + py * math.cos(turn)
        yield number, name, point(x + rx, y - ry)


def read(text: str) -> Drawing:
    """Return what a schematic connects."""
    sheet, drawing, wired = parsed(text), Drawing(), _Links()
    library = {symbol[1]: symbol for symbol in of(of(sheet, "lib_symbols")[0], "symbol")}
    pins: dict[Pin, Point] = {}
    names = [(point(*of(label, "at")[0][1:3]), label[1]) for label in of(sheet, "global_label")]
    for symbol in of(sheet, "symbol"):
        kind, reference = library[of(symbol, "lib_id")[0][1]], property_of(symbol, "Reference")
        if of(kind, "power"):
            names += [(place, name) for _, name, place in placed_pins(symbol, kind) if name != "pwr"]
        else:
            drawing.parts[reference] = {name: text for _, name, text, *_ in of(symbol, "property")}
            pins |= {(reference, number): place for number, _, place in placed_pins(symbol, kind)}
    wires = [[point(*xy[1:]) for xy in of(of(wire, "pts")[0], "xy")] for wire in of(sheet, "wire")]
    segments = [pair for wire in wires for pair in pairwise(wire)]
    for a, b in segments:
        wired.join(a, b)
    ends = Counter(end for ends in segments for end in ends)
    drawing.meetings = {spot for spot, count in ends.items() if count > 2}
    drawing.dots = {point(*of(junction, "at")[0][1:3]) for junction in of(sheet, "junction")}
    for spot in drawing.dots:
        for a, _ in (ends for ends in segments if _between(ends[0], spot, ends[1])):
            wired.join(a, spot)
    for place, name in names:
        wired.join(place, ("name", name))
    groups: dict[Any, tuple[set[Pin], set[str]]] = {}
    for pin, place in pins.items():
        groups.setdefault(wired.root(place), (set(), set()))[0].add(pin)
    for place, name in names:
        groups[wired.root(place)][1].add(name)
    drawing.nets = {frozenset(group): words for group, words in groups.values()}
    return drawing


def _between(a: Point, p: Point, b: Point) -> bool:
    along = (b[0] - a[0]) * (p[1] - a[1]) == (b[1] - a[1]) * (p[0] - a[0])
    return along and all(min(a[i], b[i]) <= p[i] <= max(a[i], b[i]) for i in (0, 1))


class Words(NamedTuple):
    """A text on the sheet and its box: left, upper, right and lower end, mm."""

    words: str
    box: tuple[float, float, float, float]


def texts(text: str) -> list[Words]:
    """Return what one can read on a schematic: notes, labels, and the symbols' fields that are shown."""
    sheet = parsed(text)
    shown = [(note[1], note, 0) for note in of(sheet, "text")]
    shown += [(label[1], label, 2) for label in of(sheet, "global_label")]
    for symbol in of(sheet, "symbol"):
        shown += [(field[2], field, 0) for field in of(symbol, "property")]
    return [Words(words, _box(words, node, more)) for words, node, more in shown if not _is_hidden(node)]


def _is_hidden(node: list[Any]) -> bool:
    return "hide" in of(node, "effects")[0]


def _box(words: str, node: list[Any], more: int) -> tuple[float, float, float, float]:
    (at,), (effects,) = of(node, "at"), of(node, "effects")
    size = float(of(of(effects, "font")[0], "size")[0][1])
    x, y, width = float(at[1]), float(at[2]), 0.85 * size * (len(words) + more)
    justify = of(effects, "justify")[0] if of(effects, "justify") else []
    left = x if "left" in justify else x - width if "right" in justify else x - width / 2
    low = y - size if "bottom" in justify else y - size / 2
    return left, low, left + width, low + size


PREFIXES = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}


def value(text: str) -> float:
    """Return a printed value in SI."""
    match = re.fullmatch(r"([0-9.]+)([pnumkMG]?)", text)
    assert match, text
    return float(match[1]) * PREFIXES[match[2]]
