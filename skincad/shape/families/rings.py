"""Rings: concentric ridges of a round skin, whose section turns about its middle.

A ring is drawn as a ridge is, in the frame on the base circle at its radius, and turned about z.
"""

from __future__ import annotations

import math
from dataclasses import replace

from skincad.inputs.design import Design
from skincad.shape.families import ridges
from skincad.shape.families.ridges import without_fillets
from skincad.shape.feature import Placed

__all__ = ["place", "without_fillets"]


def place(design: Design) -> tuple[Placed, ...]:
    """Return the design's rings on its skin, ring 1 the innermost, each where the section's half at +x
    crosses it.

    Raises InputError where a ring has no shape, or neighbours no room.
    """
    return tuple(replace(ring, long=2 * math.pi * ring.summit.x) for ring in ridges.place(design))
