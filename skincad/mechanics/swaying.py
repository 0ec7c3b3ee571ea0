"""P-delta: how much a ridge's normal force increases its bending under a pull.

A ridge under a normal force P, displaced sideways by a pull, is also bent by P times that displacement. Both
grow by 1 / (1 - P / Pcr), with Pcr the force at which the ridge sways without any pull: Timoshenko and Gere,
Theory of Elastic Stability, 2nd ed., chap. 1 (beam-columns). Small strain knows none of it.

Nothing here is fitted. The ridge is a column that bends and shears between two halves of elastic space, which
its root and its tip turn in: the plate keeps a tip level only as far as silicone does. It is as squat and
wide as P has pressed it. bench/table_swaying.py compares it with simulations at finite strain.
"""

from __future__ import annotations

import math

from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.validity import SHEAR_FACTOR, mean_width, plane_modulus
from skincad.shape.skin import skin_of

BISECTIONS = 60  # of an angle below pi, to rounding
LARGEST_SQUEEZE = 0.9  # of the height pressed away, where nothing is left to sway


def sway_force(design: Design, normal: float) -> float:
    """Return the force Pcr, N, at which a ridge, the highest of unlike ones, sways that `normal` N press.

    An end of width b that turns by theta in a half-space has the moment pi E' L b^2 theta / 16, of the
    pressure E' theta x / (2 sqrt(a^2 - x^2)), a = b / 2, which solves Johnson's integral equation (Contact
    Mechanics, 1985, sec. 2.7). The column that sways between two such springs bears P_b = phi^2 E' I / h^2
    in bending (`_sway_angle`), and with its shear G A / 2 (sqrt(1 + 4 P_b / (G A)) - 1): Haringx, Philips
    Res. Rep. 3 (1948) 401.
    """
    skin = skin_of(design)
    modulus, length, material = plane_modulus(design), design.skin.length, silicone(design)
    squeeze = min(normal / (modulus * length * mean_width(design)), LARGEST_SQUEEZE)
    height = max(skin.heights) * (1 - squeeze)
    width, tip = (
        width_at_rest * (1 + squeeze) for width_at_rest in (mean_width(design), skin.profile.tip_width)
    )
    bending = modulus * length * width**3 / 12
    root, top = (
        math.pi * modulus * length * b**2 / 16 * height / bending for b in (skin.profile.root_width, tip)
    )
    straight = _sway_angle(root, top) ** 2 * bending / height**2
    shear = SHEAR_FACTOR * material.young_modulus.value / (2 * (1 + material.poisson_ratio)) * length * width
    return shear / 2 * (math.sqrt(1 + 4 * straight / shear) - 1)


def sway_amplification(design: Design, normal: float, most: float) -> float:
    """Return the relative increase of a ridge's bending by P-delta under `normal` N: P / (Pcr - P), at most
    `most`, the value for a ridge that buckles."""
    critical = sway_force(design, normal)
    if normal * (1 + most) >= most * critical:
        return most
    return normal / (critical - normal)


def _sway_angle(root: float, top: float) -> float:
    """Return phi, in which a column that may sway buckles at phi^2 E I / h^2; its ends turn in springs of
    `root` and `top` times E I / h.

    With G = 6 / spring, (G_a G_b phi^2 - 36) / (6 (G_a + G_b)) = phi cot phi: the alignment chart's equation,
    Kavanagh, Trans. ASCE 127 II (1962) 81.
    """
    one, other = 6 / root, 6 / top
    low, high = 0.0, math.pi
    for _ in range(BISECTIONS):
        phi = (low + high) / 2
        missing = (one * other * phi**2 - 36) * math.sin(phi) - 6 * (one + other) * phi * math.cos(phi)
        low, high = (phi, high) if missing < 0 else (low, phi)
    return low
