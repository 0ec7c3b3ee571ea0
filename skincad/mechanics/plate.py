"""The rigid plate's shape: how far it rises above its lowest line, and the slopes that it shows the skin."""

from __future__ import annotations

import math

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.skin_tables import Plate


def rise(plate: Plate, x: Array) -> Array:
    """Return the height, mm, of the plate's surface at x `(n,)` mm over its lowest line (of a tilted plate:
    over x = 0). Beyond a cylinder's side it is infinite."""
    if plate.shape == "tilted":
        return np.asarray(x * math.tan(math.radians(plate.tilt or 0.0)))
    if plate.shape == "step":
        return np.where(x > plate.position, plate.height or 0.0, 0.0)
    if plate.shape == "cylinder":
        radius = plate.radius or math.inf
        offset = np.abs(x - plate.position) / radius
        half = np.arcsin(np.minimum(offset, 1.0)) / 2
        return np.where(offset < 1.0, 2 * radius * np.sin(half) ** 2, np.inf)
    return np.zeros_like(x)


def steepest(plate: Plate, half_width: float) -> float:
    """Return the largest slope within half_width mm of x = 0; the model takes contact as vertical, which
    is wrong by about half its square."""
    if plate.shape == "tilted":
        return abs(math.tan(math.radians(plate.tilt or 0.0)))
    if plate.shape == "cylinder" and plate.radius:
        return (half_width + abs(plate.position)) / plate.radius
    return 0.0
