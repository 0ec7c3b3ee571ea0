"""A rigid sphere on an incompressible half-space: patches under uniform pressure and traction, closed form.

Love, Phil. Trans. R. Soc. A 228 (1929) 377; Johnson, Contact Mechanics, 1985, eqs (3.25), (2.22). At a
Poisson ratio of one half pressure moves nothing sideways and traction nothing up or down. Tractions act along
x only.
"""

from __future__ import annotations

import numpy as np

from skincad.mechanics import Compliance

MODULUS, RADIUS = 0.8, 10.0  # MPa, mm


def sphere(reach: float, size: float) -> Compliance:
    """Return the square patches of `size` mm within `reach` mm of the axis."""
    count = int(reach / size)
    line = size * np.arange(-count, count + 1)
    x, y = (centres.ravel() for centres in np.meshgrid(line, line))
    inside = np.hypot(x, y) <= reach
    x, y = x[inside], y[inside]
    m = x.size
    far = np.subtract.outer(x, x), np.subtract.outer(y, y)
    by_x, by_y = np.zeros((m, m)), np.zeros((m, m))
    for side, end in ((a, b) for a in (1, -1) for b in (1, -1)):
        at_x, at_y = far[0] + side * size / 2, far[1] + end * size / 2
        r = np.hypot(at_x, at_y)
        by_x += side * end * at_x * np.log(at_y + r)
        by_y += side * end * at_y * np.log(at_x + r)  # also the integral of x^2 / r^3
    shear = MODULUS / 3
    down = 0.5 * (by_x + by_y) / (2 * np.pi * shear)
    along = (0.5 * (by_x + by_y) + 0.5 * by_y) / (2 * np.pi * shear)
    none = np.zeros((m, m))
    compliance = np.block([[along, none], [none, down]]) / size**2
    return Compliance(compliance, (x**2 + y**2) / (2 * RADIUS), np.zeros(2 * m), area=np.full(m, size**2))


def hertz_area(load: float) -> float:
    """Return the area of contact, mm2, under a load, N. Johnson, eq. (4.22)."""
    plane = MODULUS / (1 - 0.5**2)
    return float(np.pi * (3 * load * RADIUS / (4 * plane)) ** (2 / 3))
