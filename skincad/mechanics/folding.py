"""Where the finite-strain model ends: parts of the skin that would touch without being in contact.

Only crowns and tip fillets meet the plate in the model. A flank that reaches it, two ridges that meet
and a slot that closes would go through each other unseen; a state that shows one is refused.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from skincad.mechanics.neo_hooke import Body, outline

Array = NDArray[np.float64]
THROUGH = 2e-3  # of the unit; between contact points the crown itself is up to 1e-3 above the plate


def fault(body: Body, values: Array, plate: float) -> str | None:
    """Return what is wrong with the state `values` `(n,)` under a plate at z = `plate`, or None."""
    loops = list(outline(body, values))
    for _, moved, touches in loops:
        free = ~(touches | np.roll(touches, 1))
        if (moved[free, 1] > plate + THROUGH).any():
            return "a ridge's flank or the skin between ridges meets the plate"
    if any(_area(rest) * _area(moved) <= 0 for rest, moved, _ in loops):
        return "a slot is turned inside out"
    outer = max(range(len(loops)), key=lambda i: abs(_area(loops[i][0])))
    holes = [moved for i, (_, moved, _) in enumerate(loops) if i != outer]
    if not shapely.is_valid(shapely.Polygon(loops[outer][1], holes)):
        return "the skin folds onto itself: two ridges meet or a slot closes"
    return None


def _area(loop: Array) -> float:
    """Signed area of a closed polygon `(points, 2)`."""
    x, z = loop.T
    return float(x @ np.roll(z, -1) - z @ np.roll(x, -1)) / 2
