"""Positions of a mold's parts in the exploded view."""

from __future__ import annotations

import math

import numpy as np

from skincad.base.arrays import Array
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import CAVITIES, END_PLATES, Part, PartRole, Prism, RotatedBody


def explosion_offset(part: Part, closed: ClosedMold) -> Array:
    """Return where a part is drawn, relative to the closed mold, `(3,)` mm."""
    high, side, body = _height(closed), 1.1 * closed.length, part.body
    if part.end is not None:
        out = side * (1.0 if part.role in END_PLATES else 0.5) * (-1 if part.end == "a" else 1)
        lift = 0.25 * high if part.role is PartRole.KEEPER else 0.0
        lean = body.angle if isinstance(body, RotatedBody) else 0.0
        return np.array([0.0, out * math.cos(lean), out * math.sin(lean) + lift])
    places = {
        PartRole.COVER: (0.0, 0.0, 2.3 * high),
        PartRole.SEAL: (0.0, 0.0, 2.0 * high),
        PartRole.COVER_PIN: (0.0, 0.0, 2.3 * high),
        PartRole.CARRIER: (0.0, 0.0, 1.7 * high),
        PartRole.SKIN: (0.0, 0.0, 1.0 * high),
        PartRole.STRIP: (0.0, 0.0, 1.0 * high),
        PartRole.SHIM: (0.0, 2.4 * side, 0.0),
        PartRole.BASE: (0.0, 0.0, -0.7 * high),
        PartRole.BASE_PIN: (0.0, 0.0, -0.7 * high),
        PartRole.LEFT: (-0.3 * high, 0.0, 0.0),
        PartRole.RIGHT: (0.3 * high, 0.0, 0.0),
    }
    return np.array(places.get(part.role, (0.0, 0.0, 0.0)))


def _height(closed: ClosedMold) -> float:
    blocks = [part.body for part in closed.of(*CAVITIES)]
    levels = [s.start.z for block in blocks if isinstance(block, Prism) for s in block.outline]
    return max(levels) - min(levels)
