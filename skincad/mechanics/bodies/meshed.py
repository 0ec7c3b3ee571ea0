"""What is meshed of a pad: its half where it is its own mirror image, else all of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.bodies.mesh import Sizes, default_sizes, triangles, unit_of
from skincad.mechanics.bodies.symmetry import half_of
from skincad.mechanics.problem import Pad


@dataclass(frozen=True)
class PadMesh:
    """The piece of a pad that is meshed: half of it where `mirrored`; `height` is the pad's, mm.

    `unit` is the piece's, mm: another one than the pad's where a middle ridge is cut, which no number in mm
    or N depends on.
    """

    whole: Pad
    piece: Pad
    mirrored: bool
    unit: float
    height: float
    mesh: Any

    @property
    def sides(self) -> int:
        """How many times the piece makes up the pad."""
        return 2 if self.mirrored else 1

    def on_whole(self, shares: Array) -> Array:
        """Return each ridge's force `(ridges,)` from those of the piece's ridges, in N on the whole pad; of a
        mirrored half, the sides share what its ridges carry."""
        return on_whole(self.whole, self.piece, shares) if self.mirrored else shares


def on_whole(pad: Pad, half: Pad, shares: Array) -> Array:
    """Return the force on each ridge of a pad from what those of its half carry on both sides together."""
    numbers = pad.ridges
    values = np.zeros(len(numbers))
    for ridge, share in zip(half.ridges, shares, strict=True):
        values[numbers.index(ridge)] += share / 2
    return values + values[::-1]


def height_of(pad: Pad) -> float:
    """Return the height of the pad's corners over its lowest, mm."""
    heights = [s.start.z for s in pad.section.outline]
    return max(heights) - min(heights)


def meshed_piece(pad: Pad, sizes: Sizes, *, whole: bool = False) -> PadMesh:
    """Return the mesh of the pad's half, or of all of it where asked or not mirror-symmetric."""
    half = None if whole else half_of(pad)
    piece = pad if half is None else half
    return PadMesh(pad, piece, half is not None, unit_of(piece), height_of(pad), triangles(piece, sizes))


def plane_piece(pad: Pad, fineness: float = 1.0, *, whole: bool = False) -> PadMesh:
    """Return `meshed_piece` in the default sizes of the plane; twice the fineness halves them all."""
    return meshed_piece(pad, replace(default_sizes(pad, fineness), smooth=True), whole=whole)
