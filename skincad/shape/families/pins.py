"""Pins: round pillars or bumps on normals of the base, alike but for their heights.

A pin is drawn as a ridge is, in its own frame, and turned about its axis. Its foot stands on the plane that
touches the base there; what the curved base falls away under it, the solid fills.
"""

from __future__ import annotations

import math

import numpy as np

from skincad.inputs.design import Design
from skincad.inputs.feature_tables import places
from skincad.inputs.skin_tables import Base
from skincad.shape.curves import Point
from skincad.shape.families.ridges import profiles, without_fillets
from skincad.shape.feature import Feature, Frame, Placed

__all__ = ["place", "without_fillets"]

NEIGHBOURS = 1.2  # pitches: a hexagonal pattern's six, a square's four


def place(design: Design) -> tuple[Placed, ...]:
    """Return the design's pins on its skin, in the order of `places`. Raises InputError where one has no
    shape."""
    # a pin stands on the plane that touches the base at its foot
    features = profiles(design, math.inf)
    where = places(design.skin, design.features)
    plan = np.array([complex(at.u, at.v) for at in where])
    near = [np.flatnonzero(np.abs(plan - at) <= NEIGHBOURS * design.spacing).tolist() for at in plan]
    return tuple(
        _placed(design.skin, feature, number, (at.u, at.v), tuple(n + 1 for n in beside if n != number - 1))
        for number, (feature, at, beside) in enumerate(zip(features, where, near, strict=True), 1)
    )


def _placed(
    skin: Base, feature: Feature, number: int, at: tuple[float, float], neighbours: tuple[int, ...]
) -> Placed:
    """A pin at arcs (u, v): the section's point at u, moved along y by v or turned by its angle; on a round
    skin at the arc from the middle, in the direction of (u, v)."""
    (u, v), radius, along = at, skin.curvature_radius, skin.radius_y
    arc = skin.arm(u, v)
    x, y = (u / arc, v / arc if skin.round else 0.0) if arc else (1.0, 0.0)  # the way in which it leans
    out, low = math.sin(arc / radius), skin.thickness - 2 * radius * math.sin(arc / radius / 2) ** 2
    foot = radius * out * x, radius * out * y if skin.round else v, low
    axis = out * x, out * y, math.cos(arc / radius)
    if math.isfinite(along):
        turn, arm = v / along, along - skin.thickness + low
        foot = foot[0], arm * math.sin(turn), low - 2 * arm * math.sin(turn / 2) ** 2
        axis = axis[0], axis[2] * math.sin(turn), axis[2] * math.cos(turn)
    tilt = math.hypot(axis[0], axis[1])
    frame = Frame(Point(foot[0], foot[2]), Point(axis[2], -axis[0]), Point(axis[0], axis[2]))
    lean, long = math.atan2(tilt, axis[2]), math.pi / 4 * feature.mean_width
    return Placed(feature, frame, number, lean, neighbours, long, foot[1], axis[1])
