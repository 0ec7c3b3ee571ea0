"""The meshes that a scene is marched on, and what the next will take by what the last one took."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Level:
    """A mesh and an order; `size` is its unknowns in units of the first level's.

    Sizes were measured on yamada-2002-slip: 22 700, 39 600, 56 500 and 105 000 unknowns; with masses, where
    the inside is not condensed, the second has 2.2.
    """

    fineness: float
    order: int
    size: float = 1.0


LEVELS = (Level(0.5, 2, 1.0), Level(0.5, 3, 1.75), Level(0.5, 4, 2.5), Level(1.0, 4, 4.6))
# s ~ size^EXPONENT of condensation and march. Measured (ladder slip and seven scenes): 1.1 to 1.5 from level
# to level, so within a factor of 1.3 from one to the next
EXPONENT = 1.35


def expected(level: Level, last: Level, spent: Mapping[str, float]) -> float:
    """Return the seconds that a level will take, by the stages' seconds of the last; its mesh is made anew
    if it is finer, else shared."""
    growth = level.size / last.size
    mesh = spent["mesh"] * growth if level.fineness != last.fineness else 0.0
    return mesh + float(growth**EXPONENT) * (spent["condense"] + spent["march"])
