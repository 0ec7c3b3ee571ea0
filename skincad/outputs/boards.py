"""Output of an amplifier board: schematic, parts, the map from strip to converter, and how to build it."""

from __future__ import annotations

import math

from skincad.base.reading import Cell, csv_text
from skincad.base.result import Writer
from skincad.base.version import __version__
from skincad.circuit.boards import (
    CLAMP_LEAKAGE,
    INPUTS,
    MIDDLE,
    OPAMP_BIAS,
    OPAMP_OFFSET,
    SPARK,
    SUPPLY,
    UNITS,
    Board,
    BoardPart,
    unit,
)
from skincad.circuit.model import UNLIMITED
from skincad.fabrication.papers import macro
from skincad.outputs.delivery import Presentation, text
from skincad.outputs.drawing.schematic import schematic

PARTS, CHANNELS, PAGE = "bom.csv", "channels.csv", "board.md"


def board_names(name: str) -> list[str]:
    """Return the names of what will be written for a circuit's board."""
    return [f"{name}.kicad_sch", f"{name}.kicad_pro", PARTS, CHANNELS, PAGE]


def _files(board: Board) -> dict[str, Writer]:
    texts = (
        lambda: kicad_schematic(board),
        lambda: macro("papers/board.kicad_sch", "project", board),
        lambda: parts_csv(board),
        lambda: channels_csv(board),
        lambda: macro("papers/board.md", "page", board, **FACTS),
    )
    return dict(zip(board_names(board.name), map(text, texts), strict=True))


def kicad_schematic(board: Board) -> str:
    """Return the schematic as a .kicad_sch file of KiCad 6, with its symbols in it."""
    return macro("papers/board.kicad_sch", "sheet", board, schematic(board), __version__)


def parts_csv(board: Board) -> str:
    """Return the parts list as CSV: a row for each number of a maker."""
    groups: dict[tuple[str, ...], list[BoardPart]] = {}
    for part in board.parts:
        groups.setdefault((part.value, part.footprint, part.maker, part.number), []).append(part)
    rows: list[list[Cell]] = [["reference", "quantity", "value", "footprint", "maker", "number", "note"]]
    for key, parts in groups.items():
        notes = dict.fromkeys(macro("papers/board.md", "note", part.role) for part in parts)
        rows.append([" ".join(part.reference for part in parts), len(parts), *key, "; ".join(notes)])
    return csv_text(rows)


def channels_csv(board: Board) -> str:
    """Return the map as CSV: strip, pins of the film's header, amplifier, pin of the converter's header, and
    the Teensy's input; the last row is the middle of the supply."""
    head = [
        "strip",
        "film_plus",
        "film_minus",
        "amplifier",
        "output",
        "teensy_input",
        "teensy_pin",
        "converter",
    ]
    rows: list[list[Cell]] = [
        [
            c.strip,
            f"J1.{c.plus}",
            f"J1.{c.minus}",
            c.amplifier,
            f"J2.{c.output}",
            c.analog,
            c.pin,
            c.converter,
        ]
        for c in board.channels
    ]
    count = len(rows)
    chip, letter, _ = unit(count)
    rows.append([MIDDLE, "", "", f"{chip}{letter}", f"J2.{count + 3}", *INPUTS[count]])
    return csv_text([head, *rows])


def _of_channel(board: Board, role: str) -> str:
    """The printed value of a channel's first part of a role."""
    return next(part.value for part in board.parts if part.role == role)


FACTS = {
    "CLAMP_LEAKAGE": CLAMP_LEAKAGE,
    "MIDDLE": MIDDLE,
    "OPAMP_BIAS": OPAMP_BIAS,
    "OPAMP_OFFSET": OPAMP_OFFSET,
    "SPARK": SPARK,
    "SUPPLY": SUPPLY,
    "UNITS": UNITS,
    "UNLIMITED": UNLIMITED,
    "PARTS": PARTS,
    "CHANNELS": CHANNELS,
    "PAGE": PAGE,
    "log10": math.log10,
    "of_channel": _of_channel,
}
BOARD = Presentation(
    COMMAND="board",
    words="board.txt",
    facts=FACTS,
    writers=_files,
    manifest=lambda board: {"name": board.name},
)
