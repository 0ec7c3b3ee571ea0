"""The families of features: one file each, named by its table in a design's TOML.

A family's file has `place(design)`, which returns its features on the skin, and `without_fillets(design)`. To
add one: its table in `inputs/feature_tables.py`, that table's key in a design, its file here, its line in
FAMILIES. Solids, mechanics, scenes and pictures read what a family has in common, its
`Form` in `shape/feature.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from types import ModuleType

from skincad.inputs.design import Design
from skincad.shape.feature import Placed

_ROOM = "skincad.shape.families."
FAMILIES = {  # a design's table: the module that places its features
    "ridge": f"{_ROOM}ridges",
    "pin": f"{_ROOM}pins",
    "ring": f"{_ROOM}rings",
    "flat": f"{_ROOM}flat",
}


def place(design: Design) -> tuple[Placed, ...]:
    """Return the features that the design's table of a family names, on its skin.

    Raises InputError where they have no shape or no room.
    """
    placement: Callable[[Design], tuple[Placed, ...]] = _module(design).place
    return placement(design)


def without_fillets(design: Design) -> Design:
    """Return the design with the sharp corners that a coarse mesh has."""
    change: Callable[[Design], Design] = _module(design).without_fillets
    return change(design)


def _module(design: Design) -> ModuleType:
    return import_module(FAMILIES[design.features.family])
