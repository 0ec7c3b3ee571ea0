"""The faces of a skin's shots, which are its layers behind the skin's own silicone, from the back."""

from __future__ import annotations

import math

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.inputs.guards import face_heights
from skincad.shape.curves import Loop, Point, Segment
from skincad.shape.skin import skin_of


def face(design: Design, number: int, half: float) -> Loop:
    """Return the face of shot `number` from x = half to -half, mm, as one segment of a loop."""
    shot = (design.shot or ())[number - 1]
    middle, _ = face_heights(design.skin, shot)
    if shot.depth is None:
        return (Segment(Point(half, middle), Point(-half, middle)),)
    radius = design.skin.curvature_radius - shot.depth
    turn = math.asin(half / radius)
    side = middle - 2 * radius * math.sin(turn / 2) ** 2
    return (skin_of(design).levelled(Segment(Point(half, side), Point(-half, side), math.tan(turn / 2))),)


def heights(design: Design, number: int, x: Array, y: Array) -> Array:
    """Return how high the face of shot `number`, or with 0 the back, lies at `x` and `y` above the back's
    middle, mm."""
    arm = design.skin.back_radius + (level := _level(design, number, x, y))
    return np.asarray(level - y**2 / (arm + np.sqrt(arm**2 - y**2)))


def _level(design: Design, number: int, x: Array, y: Array) -> Array:
    """A face's height in the section, or, of a round skin, in that through the place."""
    if number == 0:
        return np.zeros_like(x)
    shot = (design.shot or ())[number - 1]
    middle, _ = face_heights(design.skin, shot)
    if shot.depth is None:
        return np.full_like(x, middle)
    radius = design.skin.curvature_radius - shot.depth
    across = np.hypot(x, y) if design.skin.round else np.abs(x)
    return np.asarray(middle - 2 * radius * np.sin(np.arcsin(across / radius) / 2) ** 2)
