"""Shrinkage: the mold is made larger than the skin as designed, which is the cured part.

The cavity is the skin's section and length, all times 1 / (1 - s): isotropic, as silicone cures that nothing
holds. The carrier holds the back along x and y, so that near it the skin stays up to s times its distance
from the middle larger, and its thickness shrinks up to (1 + nu) / (1 - nu), nearly three, times s. A shim is
bought: its place moves with the silicone, its size doesn't.
"""

from __future__ import annotations

from typing import TypeVar

from skincad.base.tables import Table
from skincad.inputs.design import Design, scaled_skin
from skincad.inputs.material import silicone

_GRID = 2.0**40  # per mm
_HEIGHTS = ("floor", "end_plate", "cover", "carrier_thickness", "clearance")
_Table = TypeVar("_Table", bound=Table)


def shrinkage(design: Design) -> float:
    """Return the linear shrinkage that the mold makes up for: the design's own, or its silicone's."""
    chosen = design.mold.shrinkage
    return silicone(design).shrinkage if chosen is None else chosen


def scaled_for_shrinkage(design: Design) -> Design:
    """Return the design of what is poured, so that it cures to `design`: every length of skin and ridge, and
    a slot's place, times 1 / (1 - shrinkage). It may pass a key's limit by that much, so it isn't checked.

    Lengths along y and z that bores end at are put on a binary grid, and stay on it when they are added.
    """
    larger = scaled_skin(design, 1 / (1 - shrinkage(design)))
    lengths = {key: getattr(design.mold, key) for key in _HEIGHTS}
    heights = {key: on_grid(value) for key, value in lengths.items() if value is not None}
    return larger.model_copy(
        update={
            "skin": larger.skin.model_copy(update={"length": on_grid(larger.skin.length)}),
            "mold": design.mold.model_copy(update=heights),
        }
    )


def on_grid(length: float) -> float:
    """Return a length on a grid of 1e-12 mm whose sums below 4 m are exact: a bore that ends 1e-15 mm before
    a face leaves a film in a print mesh."""
    return round(length * _GRID) / _GRID
