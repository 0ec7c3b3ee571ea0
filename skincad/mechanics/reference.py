"""Closed forms that the finite elements are measured against."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LineContact:
    """Half-width, mm, and peak pressure, MPa, of a contact that is long along y."""

    half_width: float
    peak_pressure: float


def hertz(load: float, radius: float, young_modulus: float, poisson_ratio: float) -> LineContact:
    """Return Hertz's line contact of an elastic cylinder with a rigid plane.

    `load` in N per mm along y, `radius` in mm, modulus in MPa. Valid for half-widths far below the
    radius and the body's size. Johnson, Contact Mechanics, 1985, eqs (4.43), (4.45).
    """
    plane = young_modulus / (1 - poisson_ratio**2)
    half_width = math.sqrt(4 * load * radius / (math.pi * plane))
    return LineContact(half_width, 2 * load / (math.pi * half_width))


def fitted_line_contact(x: Array, pressure: Array) -> LineContact:
    """Return half-width and peak of the ellipse through a computed pressure `(m,)` MPa at `x` `(m,)` mm.

    Hertz's p^2 is linear in x^2; the fit takes the points above 0.4 of the largest pressure, because the
    edge, where the slope is infinite, falls between two points.
    """
    inside = pressure > 0.4 * pressure.max()
    centre = float(np.average(x, weights=pressure))
    slope, top = np.polyfit((x[inside] - centre) ** 2, pressure[inside] ** 2, 1)
    return LineContact(math.sqrt(-top / slope), math.sqrt(top))


def column_approach(force: float, height: float, area: float, young_modulus: float) -> float:
    """Return how far a block without lateral strain effects (nu = 0) shortens, mm: F h / (E A)."""
    return force * height / (young_modulus * area)
