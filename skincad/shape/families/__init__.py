"""The families of features: one file each, named by its table in a design's TOML.

A family's file has `place(design)`, which returns its features on the skin. To add one: its table in
`inputs/`, its file here, its line in FAMILIES.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.shape.feature import ViewPlacement

FAMILIES = {"ridge": "skincad.shape.families.ridges"}  # a design's table: the module that places its features


def place(design: Design) -> tuple[ViewPlacement, ...]:
    """Return the features that the design's table of a family names, on its skin.

    Raises InputError where they have no shape or no room, or where no table names a family.
    """
    for table, module in FAMILIES.items():
        if getattr(design, table, None) is not None:
            placement: Callable[[Design], tuple[ViewPlacement, ...]] = import_module(module).place
            return placement(design)
    raise InputError("design", "names no family of features", remedy=f"add [{'] or ['.join(FAMILIES)}]")
