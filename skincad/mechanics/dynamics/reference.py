"""A closed form in time: how slowly a layer swings."""

from __future__ import annotations

import math


def shear_frequency(shear: float, density: float, height: float) -> float:
    """Return the lowest frequency, Hz, of a layer bonded below and free above, sqrt(G / rho) / (4 h).

    `shear` MPa, `density` kg/m3, `height` mm.
    """
    return math.sqrt(shear / (1e-12 * density)) / (4 * height)
