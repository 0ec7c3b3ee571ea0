"""A flat plate that turns about y while it presses: the condensed pad in the axes of the plate.

All is exact for a rigid plane on a pad of small strain: gaps along the plate's normal, slip along the plate,
forces and displacements turned into its axes. Left out is that a load is put on the undeformed section. The
plate turns about the line of first touch at x = 0; `approach` counts from where it would just touch at its
angle. Reference: a plane that rolls on a circle of radius R by an angle a without slip travels R (sin a - a)
along itself (tests/mechanics/film/test_sliding.py).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.contact.state import Compliance, ContactState

if TYPE_CHECKING:
    from skincad.mechanics.film.sliding import ContactPad


def rotated_pad(pad: ContactPad, angle: float) -> Compliance:
    """Return the pad as a plate at `angle` rad sees it, positive where the plate rises towards +x."""
    m, gap = pad.gap.size, _gap(pad, angle)
    cos, sin = math.cos(angle), math.sin(angle)
    c = pad.compliance
    xx, xz, zx, zz = c[:m, :m], c[:m, m:], c[m:, :m], c[m:, m:]
    # u' = R^T C R f' with R = [[cos, -sin], [sin, cos]], the same at every point
    top = cos * xx + sin * zx, cos * xz + sin * zz
    low = cos * zx - sin * xx, cos * zz - sin * xz
    compliance = np.block(
        [
            [cos * top[0] + sin * top[1], cos * top[1] - sin * top[0]],
            [cos * low[0] + sin * low[1], cos * low[1] - sin * low[0]],
        ]
    )
    free = np.concatenate([_along(pad, angle) - pad.x, np.zeros(m)])
    return Compliance((compliance + compliance.T) / 2, gap - gap.min(), free, area=pad.area)


def in_skin_axes(force: Array, angle: float) -> Array:
    """Return forces `(2 m,)` along the plate, then along its normal, as forces in x, then in z."""
    along, up = np.split(force, 2)
    cos, sin = math.cos(angle), math.sin(angle)
    return np.concatenate([cos * along - sin * up, sin * along + cos * up])


def work(pad: ContactPad, before: ContactState, after: ContactState) -> float:
    """Return what the plate does in a step in which it may turn, mJ: forces, and their moment, by what they
    move, both at their mean over the step."""
    moment = [_moment(pad, state) for state in (before, after)]
    down = [depth(pad, state) for state in (before, after)]
    return float(
        (before.normal.sum() + after.normal.sum()) / 2 * (down[1] - down[0])
        + (before.tangential.sum() + after.tangential.sum()) / 2 * (after.travel - before.travel)
        + (moment[0] + moment[1]) / 2 * (after.angle - before.angle)
    )


def depth(pad: ContactPad, state: ContactState) -> float:
    """Return how far the plate is, along its normal, below the line of first touch at x = 0, mm."""
    return state.approach + float(_gap(pad, state.angle).min())


def _moment(pad: ContactPad, state: ContactState) -> float:
    """What the plate does, N mm, when it turns: forces at their places along it and at its height."""
    force = in_skin_axes(state.force, state.angle)
    moved_x, moved_z = np.split(pad.compliance @ force, 2)
    place = _along(pad, state.angle) + math.cos(state.angle) * moved_x + math.sin(state.angle) * moved_z
    return float(-state.normal @ place + depth(pad, state) * state.tangential.sum())


def _gap(pad: ContactPad, angle: float) -> Array:
    """Gaps `(m,)` mm along the plate's normal, the plate on the line of first touch at x = 0."""
    return np.asarray(pad.gap * math.cos(angle) + pad.x * math.sin(angle))


def _along(pad: ContactPad, angle: float) -> Array:
    """Where the points are along the plate `(m,)`, mm."""
    return np.asarray(pad.x * math.cos(angle) - pad.gap * math.sin(angle))
