"""What a mold's parts and their cuts are for: said where they are made, asked wherever it matters."""

from __future__ import annotations

from enum import Enum, auto
from typing import Literal, NamedTuple

MadeBy = Literal["cast", "made", "bought"]
End = Literal["a", "b"]  # of the mold along y: b is up while it is poured
ENDS: tuple[End, ...] = ("a", "b")


class PartRole(Enum):
    """What a part of a mold is."""

    SKIN = auto()
    CAVITY = auto()  # in one piece
    BASE = auto()  # of a split cavity, under its pieces
    LEFT = auto()  # outer piece of a split cavity, at -x
    RIGHT = auto()
    BETWEEN = auto()  # piece of a split cavity, between two splits
    END_PLATE = auto()  # in one piece
    COMB = auto()  # lower part of an end plate
    KEEPER = auto()  # its upper part
    CARRIER = auto()
    COVER = auto()
    SHIM = auto()
    STRIP = auto()
    END_PIN = auto()
    COVER_PIN = auto()
    BASE_PIN = auto()


class CutRole(Enum):
    """What a cut of a part is for."""

    TROUGH = auto()  # the skin's negative
    SEAT = auto()  # the carrier's
    END_BOLT = auto()  # clearance hole of a screw through an end plate
    END_THREAD = auto()  # in which such a screw ends
    NUT = auto()  # its pocket
    END_PIN = auto()
    COVER_BOLT = auto()
    COVER_THREAD = auto()
    COVER_PIN = auto()
    BASE_PIN = auto()
    GATE = auto()
    VENT = auto()
    RIVET = auto()  # a carrier's hole that holds the skin
    PULL = auto()  # a carrier's blind thread, to lift the skin by
    RESERVOIR = auto()
    BLEED = auto()
    PRY = auto()  # notch for a screwdriver
    MARK = auto()  # nick that tells the ends apart
    BEVEL = auto()  # of a leaning end plate


CAVITIES = frozenset({PartRole.CAVITY, PartRole.BASE, PartRole.LEFT, PartRole.BETWEEN, PartRole.RIGHT})
END_PLATES = frozenset({PartRole.END_PLATE, PartRole.COMB, PartRole.KEEPER})
PINS = frozenset({PartRole.END_PIN, PartRole.COVER_PIN, PartRole.BASE_PIN})


class Implied(NamedTuple):
    """What follows from a part's role: how findings call it, how one comes by it, its colour (r, g, b)."""

    label: str
    made: MadeBy
    colour: tuple[float, float, float]


_DARK, _STONE, _GLASS, _STEEL = (0.45, 0.50, 0.58), (0.66, 0.69, 0.74), (0.70, 0.85, 0.95), (0.62, 0.65, 0.70)
IMPLIED = {
    PartRole.SKIN: Implied("skin", "cast", (0.93, 0.72, 0.62)),
    **dict.fromkeys((PartRole.CAVITY, PartRole.BASE), Implied("cavity", "made", (0.75, 0.77, 0.80))),
    **dict.fromkeys((PartRole.LEFT, PartRole.BETWEEN, PartRole.RIGHT), Implied("cavity", "made", _STONE)),
    PartRole.END_PLATE: Implied("end plates", "made", _DARK),
    PartRole.COMB: Implied("end plates comb", "made", _DARK),
    PartRole.KEEPER: Implied("end plates keeper", "made", (0.55, 0.75, 0.60)),
    PartRole.CARRIER: Implied("carrier", "made", _GLASS),
    PartRole.COVER: Implied("cover", "made", _GLASS),
    PartRole.SHIM: Implied("shim", "bought", _STEEL),
    PartRole.STRIP: Implied("strip", "bought", (0.80, 0.80, 0.74)),
    **dict.fromkeys(PINS, Implied("pin", "bought", _STEEL)),
}
