"""A ridge's undercut: how much its groove squeezes it when the skin leaves straight along its own -z.

The fan leans alike to both sides and leaves as one, so no ridge can give way sideways: every level of a ridge
has to pass the narrowest opening that the groove leaves on its way, w out of its width W. It is squeezed by
the nominal strain 1 - w / W; rubber keeps its volume and the skin is long, so it stretches upward by
W / w - 1, and that is held against the elongation at break. Friction and the ridge's bending are left out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.cross_section import GUARD_TOLERANCE, section
from skincad.shape.curves import polygon

SAFE_SHARE = 0.2  # assumption: a cast edge has nicks, from which it tears long before a test bar does
VISIBLE = 10 * GUARD_TOLERANCE  # mm; less is the chords' own error


class Undercut(NamedTuple):
    """A ridge's overhang: mm by which a flank widens towards the tip, and the nominal squeeze to pass it,
    1 where nothing passes."""

    width: float
    strain: float


def undercuts(design: Design) -> dict[int, float]:
    """Return each ridge's overhang against the pull, mm, by its number."""
    return {ridge: undercut.width for ridge, undercut in squeezes(design).items()}


def squeezes(design: Design) -> dict[int, Undercut]:
    """Return each ridge's undercut, by its number. Exact to the guards' chord tolerance; 0 is below it."""
    return {ridge: _undercut(design, ridge) for ridge in range(1, design.ridge.count + 1)}


def _undercut(design: Design, ridge: int) -> Undercut:
    ridge_outline = tuple(s for s in section(design).outline if s.ridge == ridge)
    points = np.vstack([polygon(ridge_outline, GUARD_TOLERANCE), ridge_outline[-1].end])
    summit = int(np.argmax(points[:, 1]))
    sides = points[: summit + 1], (points[summit:] * [-1.0, 1.0])[::-1]  # each from its foot to the summit
    mouths = [np.minimum.accumulate(side[:, 0]) for side in sides]
    width = max(float((side[:, 0] - mouth).max()) for side, mouth in zip(sides, mouths, strict=True))
    if width <= VISIBLE:
        return Undercut(0.0, 0.0)
    levels = np.unique(np.concatenate([side[:, 1] for side in sides]))
    levels = levels[(levels >= max(s[0, 1] for s in sides)) & (levels < points[summit, 1])]
    # a side may dip at its foot where the ridge leans much: below the dip there is no groove
    heights = [np.maximum.accumulate(side[:, 1]) for side in sides]
    full = sum(np.interp(levels, z, side[:, 0]) for z, side in zip(heights, sides, strict=True))
    free = sum(np.interp(levels, z, mouth) for z, mouth in zip(heights, mouths, strict=True))
    return Undercut(width, min(1.0, float((1 - free / full).max())))


def safe_strain(design: Design) -> float:
    """Return the nominal squeeze that the silicone takes: its stretch is `SAFE_SHARE` of that at break."""
    return 1 - 1 / (1 + SAFE_SHARE * silicone(design).elongation_at_break)


def split_ridges(design: Design) -> list[int]:
    """Return the ridges at which the cavity is parted: with split = "auto" those that are squeezed beyond
    what is safe, and their mirror images, so that the pieces between come out straight."""
    if design.mold.split == "none":
        return []
    limit, count = safe_strain(design), design.ridge.count
    caught = [ridge for ridge, undercut in squeezes(design).items() if undercut.strain > limit]
    return sorted({*caught, *(count + 1 - ridge for ridge in caught)})
