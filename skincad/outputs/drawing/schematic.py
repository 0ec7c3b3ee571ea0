"""A board's schematic as a drawing: symbols, wires and labels on a sheet, for KiCad.

Lengths are in steps of 2.54 mm, x to the right and y down. Each block is drawn at its own origin. KiCad
connects what meets at the end of a wire, and what lies along a wire at a junction alone.
"""

from __future__ import annotations

import uuid
from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise

from skincad.circuit.boards import GND, MIDDLE, RAIL, SOURCE, UNITS, Board, BoardPart, unit

STEP = 2.54  # mm
IDS = uuid.UUID("6d1f0d6e-8a35-5c5b-9a3b-0f6a52d1f7a1")  # of this drawing: the same board has the same file
WIDTH, HEIGHT = 48.0, {"inverting": 17.0, "follower": 19.0}  # steps, of a channel by its topology
SMALL = 9  # strips, at most, on A3
COLUMNS = {"A3": 3, "A2": 4}  # channels a row, by the sheet's size
Spot = tuple[float, float]


@dataclass(frozen=True)
class Symbol:
    """A part's unit at a spot, turned by `angle` degrees counterclockwise; `part` is None for a supply."""

    kind: str
    reference: str
    value: str
    at: Spot
    angle: int = 0
    unit: int = 1
    part: BoardPart | None = None


@dataclass
class Schematic:
    """What is on a sheet, in mm; `id_of` gives things their lasting names."""

    paper: str
    symbols: list[Symbol] = field(default_factory=list)
    wires: list[tuple[Spot, Spot]] = field(default_factory=list)
    labels: list[tuple[str, Spot, int]] = field(default_factory=list)  # a net, and where its text runs to
    notes: list[tuple[str, Spot]] = field(default_factory=list)

    def junctions(self) -> list[Spot]:
        """Return the points where three or more ends meet; no wire goes on past another's end."""
        ends = Counter(end for wire in self.wires for end in wire)
        return sorted(spot for spot, count in ends.items() if count > 2)

    @staticmethod
    def id_of(*words: object) -> str:
        """Return the lasting name of a thing."""
        return str(uuid.uuid5(IDS, " ".join(map(str, words))))


class _Pen:
    """Draws at an origin, in steps, the parts of a board by their references."""

    def __init__(self, sheet: Schematic, parts: dict[str, BoardPart], x: float, y: float) -> None:
        self.sheet, self.parts, self.x, self.y = sheet, parts, x, y

    def spot(self, x: float, y: float) -> Spot:
        return round((self.x + x) * STEP, 2), round((self.y + y) * STEP, 2)

    def part(self, reference: str, x: float, y: float, angle: int = 0, number: int = 1) -> None:
        part = self.parts[reference]
        at = self.spot(x, y)
        self.sheet.symbols.append(Symbol(part.kind, reference, part.value, at, angle, number, part))

    def supply(self, net: str, x: float, y: float) -> None:
        """A supply's symbol, or for "flag" the mark that power comes in here."""
        kind = {GND: "ground", "flag": "flag"}.get(net, "rail")
        number = sum(symbol.part is None for symbol in self.sheet.symbols) + 1
        reference = f"#{'FLG' if net == 'flag' else 'PWR'}{number:03d}"
        value = "PWR_FLAG" if net == "flag" else net
        self.sheet.symbols.append(Symbol(kind, reference, value, self.spot(x, y)))

    def wire(self, *spots: Spot) -> None:
        self.sheet.wires += pairwise(self.spot(*spot) for spot in spots)

    def label(self, net: str, x: float, y: float, angle: int = 0) -> None:
        self.sheet.labels.append((net, self.spot(x, y), angle))

    def note(self, words: str, x: float, y: float) -> None:
        self.sheet.notes.append((words, self.spot(x, y)))


def schematic(board: Board) -> Schematic:
    """Return the sheet of a board: a block for each channel, and what they share below."""
    paper = "A3" if len(board.channels) <= SMALL else "A2"
    sheet, parts = Schematic(paper), {part.reference: part for part in board.parts}
    columns, height = COLUMNS[paper], HEIGHT[board.circuit.amplifier.topology]
    left, top = 7.0, 9.0
    for n in range(len(board.channels)):
        row, column = divmod(n, columns)
        _channel(_Pen(sheet, parts, left + column * WIDTH, top + row * height), board, n)
    rows = -(-len(board.channels) // columns)
    _shared(sheet, parts, board, left, top + rows * height + 1)
    return sheet


def _channel(pen: _Pen, board: Board, n: int) -> None:
    """A strip's way from the header to the converter."""
    channel, at = board.channels[n], 100 * (n + 1)
    chip, _, _ = unit(n)
    pen.note(f"Channel {n + 1}: strip {channel.strip}, Teensy {channel.analog} (pin {channel.pin})", 0, -2.5)
    row = 8 if board.follows else 6
    pen.label(f"{channel.strip}+", 5, row, 180)
    pen.wire((5, row), (6.5, row))
    pen.part(f"R{at + 1}", 8, row, 90)
    pen.wire((9.5, row), (12, row), (16.5, row))
    pen.wire((12, row), (12, row + 1.5))
    pen.part(f"D{at + 1}", 12, row + 3)
    pen.wire((9, row + 3), (9, row + 4))
    pen.supply(GND, 9, row + 4)
    pen.wire((15, row + 3), (15, row + 2.5))
    pen.supply(RAIL, 15, row + 2.5)
    pen.part(f"R{at + 2}", 18, row, 90)
    pen.part(chip, 27, 7, 0, n % UNITS + 1)
    if board.follows:
        pen.wire((19.5, row), (22, row), (24, row))
        pen.wire((22, row), (22, row + 1))
        pen.part(f"R{at + 5}", 22, row + 2.5)
        pen.wire((22, row + 4), (21, row + 4))
        pen.label(MIDDLE, 21, row + 4, 180)
        pen.wire((24, 6), (23, 6), (23, 3))
        corner = 23.0
    else:
        pen.wire((19.5, row), (21, row), (24, row))
        pen.wire((21, row), (21, 3))
        pen.wire((24, 8), (23, 8))
        pen.label(MIDDLE, 23, 8, 180)
        corner = 21.0
    pen.wire((corner, 3), (24.5, 3))
    pen.part(f"R{at + 3}", 26, 3, 90)
    pen.wire((27.5, 3), (32, 3), (32, 7))
    pen.wire((corner, 3), (corner, -0.5), (24.5, -0.5))
    pen.part(f"C{at + 1}", 26, -0.5, 90)
    pen.wire((27.5, -0.5), (32, -0.5), (32, 3))
    pen.wire((30, 7), (32, 7), (34.5, 7))
    pen.part(f"R{at + 4}", 36, 7, 90)
    pen.wire((37.5, 7), (39, 7), (41, 7))
    pen.wire((39, 7), (39, 8))
    pen.part(f"C{at + 2}", 39, 9.5)
    pen.supply(GND, 39, 11)
    pen.label(channel.strip, 41, 7)


def _shared(sheet: Schematic, parts: dict[str, BoardPart], board: Board, x: float, y: float) -> None:
    """Headers, supply, the middle of it, the chips' own supply and the amplifiers that are left over."""
    count = len(board.channels)
    pen = _Pen(sheet, parts, x, y)
    pen.note("Film: + and - of each strip", 0, -2)
    pen.part("J1", 7, 1)
    for n in range(count):
        pen.label(f"{board.channels[n].strip}+", 5, n + 1, 180)
        pen.label(MIDDLE, 9, n + 1, 0)
    pen = _Pen(sheet, parts, x + 24, y)
    pen.note("Converter", -2, -2)
    pen.part("J2", 4, 1)
    for n, net in enumerate(pen.parts["J2"].nets.values()):
        if net not in (SOURCE, GND):
            pen.label(net, 2, n + 1, 180)
    last = len(pen.parts["J2"].nets)
    pen.wire((2, 1), (1, 1), (1, 0.5))
    pen.supply(SOURCE, 1, 0.5)
    for n in (2, last):
        pen.wire((2, n), (-3, n), (-3, n + 0.5))
        pen.supply(GND, -3, n + 0.5)
    _supply(_Pen(sheet, parts, x + 38, y))
    _middle(_Pen(sheet, parts, x + 57, y), count)
    _chips(_Pen(sheet, parts, x + 38, y + 15), board.chips)
    for n, number in enumerate(range(count + 1, UNITS * board.chips)):
        _spare(_Pen(sheet, parts, x + 41 + 9 * board.chips + 12 * n, y + 15), number)


def _supply(pen: _Pen) -> None:
    pen.note("Supply: the Teensy's 3.3 V", 0, -2)
    pen.wire((0, 1.5), (0, 2), (4, 2), (5.5, 2))
    pen.supply(SOURCE, 0, 1.5)
    pen.wire((4, 2), (4, 1.5))
    pen.supply("flag", 4, 1.5)
    pen.part("FB1", 7, 2, 90)
    pen.wire((8.5, 2), (10, 2), (14, 2), (14, 1.5))
    pen.supply(RAIL, 14, 1.5)
    pen.wire((10, 2), (10, 1.5))
    pen.supply("flag", 10, 1.5)
    pen.wire((14, 2), (14, 3.5))
    pen.part("C1", 14, 5)
    pen.wire((14, 6.5), (14, 7))
    pen.supply(GND, 14, 7)
    pen.wire((10, 6), (10, 6.5), (14, 6.5))
    pen.supply("flag", 10, 6)


def _middle(pen: _Pen, number: int) -> None:
    """Half the supply, behind an amplifier and a resistor that keeps it steady with the capacitor."""
    chip, letter, _ = unit(number)
    pen.note(f"Middle of the supply: {chip}{letter}", 0, -2)
    pen.supply(RAIL, 1, 1)
    pen.part("R1", 1, 2.5)
    pen.wire((1, 4), (1, 5), (1, 6))
    pen.part("R2", 1, 7.5)
    pen.supply(GND, 1, 9)
    pen.wire((1, 5), (6, 5), (10, 5))
    pen.wire((6, 5), (6, 6))
    pen.part("C2", 6, 7.5)
    pen.supply(GND, 6, 9)
    pen.part(chip, 13, 4, 0, number % UNITS + 1)
    pen.wire((10, 3), (9, 3), (9, 0.5), (17, 0.5), (17, 4))
    pen.wire((16, 4), (17, 4), (18.5, 4))
    pen.part("R3", 20, 4, 90)
    pen.wire((21.5, 4), (23, 4), (25, 4))
    pen.wire((23, 4), (23, 5))
    pen.part("C3", 23, 6.5)
    pen.supply(GND, 23, 8)
    pen.label(MIDDLE, 25, 4)


def _chips(pen: _Pen, count: int) -> None:
    pen.note("Supply of the chips", 0, -2)
    for n in range(count):
        at = 9 * n + 1
        pen.supply(RAIL, at, 0.5)
        pen.wire((at, 0.5), (at, 1), (at, 1.5))
        pen.part(f"U{n + 1}", at, 4.5, 0, UNITS + 1)
        pen.wire((at, 7.5), (at, 8), (at, 8.5))
        pen.supply(GND, at, 8.5)
        pen.wire((at, 1), (at + 4, 1), (at + 4, 3))
        pen.part(f"C{n + 4}", at + 4, 4.5)
        pen.wire((at + 4, 6), (at + 4, 8), (at, 8))


def _spare(pen: _Pen, number: int) -> None:
    chip, letter, _ = unit(number)
    pen.note(f"Spare: {chip}{letter}", 0, -2)
    pen.part(chip, 5, 4, 0, number % UNITS + 1)
    pen.label(MIDDLE, 2, 5, 180)
    pen.wire((2, 3), (1, 3), (1, 0.5), (9, 0.5), (9, 4), (8, 4))
