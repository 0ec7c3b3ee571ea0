"""Where a model of contact ends: parts of the skin that would touch without being in contact.

Only crowns and tip fillets meet the plate in the models. A flank that reaches it, two ridges that meet
and a slot that closes would go through each other unseen; a state that shows one is refused.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import shapely

from skincad.base.arrays import Array
from skincad.mechanics.bodies.elements import Outline

THROUGH = 2e-3  # of the unit; between contact points the crown itself is up to 1e-3 above the plate


def fault(
    loops: list[Outline],
    plate: Callable[[Array], Array],
    with_itself: bool = True,
    *,
    mirrored: bool = False,
) -> str | None:
    """Return what is wrong with deformed loops under a plate at the heights `plate` of x, or None.

    Contact of the skin with itself is looked for unless `with_itself` is false. Of a `mirrored` half, what
    crosses x = 0 meets its own image.
    """
    for loop in loops:
        x, z = loop.moved[~(loop.touches | np.roll(loop.touches, 1))].T
        if (z > plate(x) + THROUGH).any():
            return "a ridge's flank or the skin between ridges meets the plate"
    if any(_area(loop.rest) * _area(loop.moved) <= 0 for loop in loops):
        return "a slot is turned inside out"
    if mirrored and min(loop.moved[:, 0].min() for loop in loops) < -THROUGH:
        return "two ridges meet in the middle"
    outer = max(range(len(loops)), key=lambda i: abs(_area(loops[i].rest)))
    holes = [loop.moved for i, loop in enumerate(loops) if i != outer]
    if with_itself and not shapely.is_valid(shapely.Polygon(loops[outer].moved, holes)):
        return "the skin folds onto itself: two ridges meet or a slot closes"
    return None


def x_of_largest_displacement(loops: list[Outline]) -> float:
    """Return x at rest of the place that moves furthest."""
    moves = np.concatenate([loop.moved - loop.rest for loop in loops])
    return float(np.concatenate([loop.rest for loop in loops])[np.hypot(*moves.T).argmax(), 0])


def _area(loop: Array) -> float:
    """Signed area of a closed polygon `(points, 2)`."""
    x, z = loop.T
    return float(x @ np.roll(z, -1) - z @ np.roll(x, -1)) / 2
