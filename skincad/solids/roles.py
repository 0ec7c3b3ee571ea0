"""What a mold's parts and their cuts are for: said where they are made, asked wherever it matters."""

from __future__ import annotations

from enum import Enum, auto
from typing import Literal

MadeBy = Literal["cast", "made", "bought"]
End = Literal["a", "b"]  # of the mold along y: b is up while it is poured
ENDS: tuple[End, ...] = ("a", "b")


_GREY, _STONE, _DARK = (0.75, 0.77, 0.80), (0.66, 0.69, 0.74), (0.45, 0.50, 0.58)
_GREEN, _GLASS, _ROSE = (0.55, 0.75, 0.60), (0.70, 0.85, 0.95), (0.93, 0.72, 0.62)
_STEEL, _SILVER = (0.62, 0.65, 0.70), (0.80, 0.80, 0.74)


class PartRole(Enum):
    """What a part of a mold is, and what follows: how findings call it, how one comes by it, its colour."""

    SKIN = "the skin", "skin", "cast", _ROSE
    CAVITY = "a cavity in one piece", "cavity", "made", _GREY
    BASE = "base of a split cavity", "cavity", "made", _GREY
    LEFT = "outer piece of a split cavity, at -x", "cavity", "made", _STONE
    BETWEEN = "piece of a split cavity, between two splits", "cavity", "made", _STONE
    RIGHT = "outer piece of a split cavity, at +x", "cavity", "made", _STONE
    END_PLATE = "an end plate in one piece", "end plates", "made", _DARK
    COMB = "lower part of an end plate", "end plates' combs", "made", _DARK
    KEEPER = "upper part of an end plate", "end plates' keepers", "made", _GREEN
    CARRIER = "the skin's rigid backing", "carrier", "made", _GLASS
    COVER = "the lid", "cover", "made", _GLASS
    SEAL = "foam between the cover and what it closes", "seal", "bought", _DARK
    SHIM = "what keeps a slot free", "shim", "bought", _STEEL
    STRIP = "a film that is cast in", "strip", "bought", _SILVER
    END_PIN = "dowel between cavity and end plate", "pin", "bought", _STEEL
    COVER_PIN = "dowel between cavity and cover", "pin", "bought", _STEEL
    BASE_PIN = "dowel between the base and a piece of a split cavity", "pin", "bought", _STEEL

    def __init__(self, what: str, label: str, made: MadeBy, colour: tuple[float, float, float]) -> None:
        self.what, self.label, self.made, self.colour = what, label, made, colour


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
    MOUNT = auto()  # a carrier's blind thread, by which a robot holds it
    MOUNT_PIN = auto()  # a hole for the pin that says where
    FIDUCIAL = auto()  # a dimple that a camera finds
    RESERVOIR = auto()
    BLEED = auto()
    PRY = auto()  # notch for a screwdriver
    MARK = auto()  # nick that tells the ends apart
    BEVEL = auto()  # of a leaning end plate


CAVITIES = frozenset({PartRole.CAVITY, PartRole.BASE, PartRole.LEFT, PartRole.BETWEEN, PartRole.RIGHT})
END_PLATES = frozenset({PartRole.END_PLATE, PartRole.COMB, PartRole.KEEPER})
PINS = frozenset({PartRole.END_PIN, PartRole.COVER_PIN, PartRole.BASE_PIN})
