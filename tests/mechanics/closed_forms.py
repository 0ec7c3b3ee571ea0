"""Closed forms that the finite elements are measured against, and the orders at which they are approached.

Plane strain throughout. Lengths in mm, loads in N per mm along y, moduli and stresses in MPa; in time masses
in tonne.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize

Array = NDArray[np.float64]


def lame(young_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Return Lame's constants: G = E / (2 (1 + nu)) and lambda = 2 G nu / (1 - 2 nu)."""
    shear = young_modulus / (2 * (1 + poisson_ratio))
    return shear, 2 * shear * poisson_ratio / (1 - 2 * poisson_ratio)


def observed_order(sizes: ArrayLike, errors: ArrayLike) -> float:
    """Return p of error = C size^p through the points `(m,)`: least squares of the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


@dataclass(frozen=True)
class LineContact:
    """Half-width, mm, and peak pressure, MPa, of a contact that is long along y."""

    half_width: float
    peak_pressure: float

    def elliptic(self, x: Array) -> Array:
        """Return Hertz's pressure `(m,)` MPa at `x` `(m,)` mm from the middle: p0 sqrt(1 - (x / a)^2)."""
        inside = np.maximum(1 - (x / self.half_width) ** 2, 0.0)
        return np.asarray(self.peak_pressure * np.sqrt(inside))


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


def stick_half_width(normal: LineContact, friction: float, tangential: float) -> float:
    """Return the half-width, mm, that sticks in a Hertzian line contact under a `tangential` load, N/mm, put
    on after P.

    c / a = sqrt(1 - Q / (mu P)), for Q from 0 (all sticks) to mu P (all slips). Bodies like half-planes whose
    normal and tangential displacements do not couple: equal materials, or a rigid one on an incompressible
    one. Cattaneo 1938, Mindlin 1949; Johnson, Contact Mechanics, 1985, sec. 7.2(b).
    """
    load = math.pi * normal.half_width * normal.peak_pressure / 2
    return normal.half_width * math.sqrt(1 - tangential / (friction * load))


@dataclass(frozen=True)
class LayerContact:
    """Half-width, mm, peak pressure, MPa, and approach, mm, of a cylinder on a thin layer."""

    half_width: float
    peak_pressure: float
    approach: float


def bonded_layer(load: float, radius: float, thickness: float, shear: float) -> LayerContact:
    """Return a rigid cylinder's frictionless line contact with a thin incompressible bonded layer.

    Bonded below and free of shear above, the layer bears a pressure gradient p' by the flux -p' h^3 / (3 G),
    which takes up what the cylinder displaces, d x - x^3 / (6 R). With p and p' zero at x = a:
    d = a^2 / (6 R), p = G (a^2 - x^2)^2 / (8 R h^3), P = 2 G a^5 / (15 R h^3).

    The limit of h / a to 0 at nu = 1/2. Pressure and approach are off by the order (h / a)^2, because at wave
    number k the layer's compliance is this one's times 1 - 9/5 (k h)^2; the half-width by h / a. Johnson,
    Contact Mechanics, 1985, sec. 5.8; Jaffar, Int. J. Mech. Sci. 31 (1989) 229.
    """
    half_width = (15 * load * radius * thickness**3 / (2 * shear)) ** 0.2
    peak = shear * half_width**4 / (8 * radius * thickness**3)
    return LayerContact(half_width, peak, half_width**2 / (6 * radius))


def column_approach(force: float, height: float, area: float, young_modulus: float) -> float:
    """Return how far a block without lateral strain effects (nu = 0) shortens, mm: F h / (E A)."""
    return force * height / (young_modulus * area)


def uniform_stress(strain: Array, young_modulus: float, poisson_ratio: float) -> Array:
    """Return the stress `(2, 2)` MPa of a uniform small strain `(2, 2)`: 2 G e + lambda tr(e).

    The patch test's: elements that hold every linear displacement give it exactly, and no force inside.
    Bathe, Finite Element Procedures, 1996, sec. 4.2.3.
    """
    shear, rest = lame(young_modulus, poisson_ratio)
    return np.asarray(2 * shear * strain + rest * np.trace(strain) * np.eye(2))


def spinning_ring(
    inner: float, outer: float, spin: float, shear: float, lame_lambda: float
) -> tuple[float, float, float]:
    """Return A, B, C of u_r = A r + B / r - C r^3 in a ring that is bonded to a rigid core and spins with it.

    Clamped at r = a, free at r = b, under the body force `spin` r outward, N/mm^3 with r in mm. Small strain.
    C = spin / (8 (lambda + 2 G)), the rest from u_r(a) = 0 and sigma_r(b) = 0. Timoshenko and Goodier, Theory
    of Elasticity, 3rd ed., secs. 28 and 32, in plane strain.
    """
    c = spin / (8 * (lame_lambda + 2 * shear))
    pull = 4 * lame_lambda * c * outer**2 + 2 * shear * c * (inner**4 / outer**2 + 3 * outer**2)
    a = pull / (2 * (lame_lambda + shear) + 2 * shear * (inner / outer) ** 2)
    return a, c * inner**4 - a * inner**2, c


def corner_exponent(poisson_ratio: float) -> float:
    """Return lambda of the displacements r^lambda at a right-angled corner between clamped and free sides.

    Smallest root of sin^2(lambda w) = (k + 1)^2 / (4 k) - lambda^2 sin^2(w) / k, w = pi / 2, k = 3 - 4 nu:
    from 1 at nu = 0 to 0.595 at 1/2. Energy, and an approach under a given force, converge as h^(2 lambda) on
    uniform meshes, whatever the order. Williams, J. Appl. Mech. 19 (1952) 526.
    """
    k = 3 - 4 * poisson_ratio

    def missed(power: float) -> float:
        return math.sin(power * math.pi / 2) ** 2 + power**2 / k - (k + 1) ** 2 / (4 * k)

    return float(optimize.brentq(missed, 0.1, 1.0, xtol=1e-14))


def neo_hookean_compression(stretch: float, shear: float, lame_lambda: float) -> tuple[float, float]:
    """Return the width's stretch w and nominal stress, MPa, of a block, sides free, at a vertical stretch l.

    Law of neo_hooke.strain_energy, any l > 0. No stress on the sides, G (w - 1 / w) + lambda l (w l - 1) = 0,
    is quadratic in w; the stress G (l - 1 / l) + lambda w (w l - 1) tends to G (l - l^-3) for nu to 1/2.
    Ogden, Non-linear Elastic Deformations, 1984, sec. 4.4, for that limit.
    """
    a, b = shear + lame_lambda * stretch**2, lame_lambda * stretch
    width = (b + math.sqrt(b**2 + 4 * a * shear)) / (2 * a)
    # w l - 1 from the sides' balance: as a difference it would lose its digits near nu = 1/2
    return width, shear * (stretch - 1 / stretch - width * (width - 1 / width) / stretch)


def neo_hookean_shear(shift: float, shear: float) -> float:
    """Return the nominal shear stress, MPa, of a simple shear by `shift`: G times it, at any size and nu.

    The volume is kept. Ogden, Non-linear Elastic Deformations, 1984, sec. 4.4.
    """
    return shear * shift


def rubbed_swing(start: float, stiffness: float, mass: float, limit: float, time: Array) -> Array:
    """Return places `(n,)` of a mass let go at `start` on a spring, on a still plate that rubs by `limit` N.

    Each half swing turns 2 limit / k nearer to 0; a turn within limit / k of 0 is where it stays. Den Hartog,
    Trans. ASME 53 (1931) 107.
    """
    omega, reach = math.sqrt(stiffness / mass), limit / stiffness
    swings = np.floor(omega * time / math.pi).astype(int)
    last = max(0, math.ceil((abs(start) / reach - 1) / 2))  # half swings until it stays
    turns = np.minimum(swings, last)
    turn = math.copysign(1.0, start) * (-1.0) ** turns * (abs(start) - 2 * reach * turns)
    middle = np.sign(turn) * reach
    phase = np.where(swings < last, omega * time - math.pi * swings, 0.0)
    return np.asarray(np.where(swings < last, middle + (turn - middle) * np.cos(phase), turn))


def dragged_swing(
    speed: float, stiffness: float, mass: float, limits: tuple[float, float], time: Array
) -> tuple[Array, float]:
    """Return places `(n,)` of a mass on a spring that a plate of this speed drags, first sticking, then
    slipping, and the time at which it sticks again, up to which they hold. `limits` N, static and kinetic."""
    omega, begin = math.sqrt(stiffness / mass), limits[0] / stiffness / speed
    middle, swing = limits[1] / stiffness, (limits[0] - limits[1]) / stiffness
    phase = omega * (time - begin)
    slips = middle + swing * np.cos(phase) + speed / omega * np.sin(phase)
    again = begin + (2 * math.pi - 2 * math.atan(swing * omega / speed)) / omega
    return np.where(time < begin, speed * time, slips), again


def kelvin_voigt_creep(force: float, stiffness: float, delay: float, time: Array) -> Array:
    """Return displacements `(n,)` under a sudden force of a spring with a dashpot of stiffness x `delay`."""
    return np.asarray(force / stiffness * -np.expm1(-time / delay))


def ramped_prony(rate: float, branches: Sequence[tuple[float, float]], time: Array) -> Array:
    """Return forces `(n,)` while the slow spring's grows by `rate` N/s.

    rate (t + sum g tau (1 - exp(-t / tau))); `branches` are pairs of stiffness by the slow one and time.
    """
    fast = sum((g * tau * -np.expm1(-time / tau) for g, tau in branches), np.zeros_like(time))
    return np.asarray(rate * (time + fast))


def struck_bar(speed: float, plate: float, impedance: float, time: Array) -> Array:
    """Return speeds `(n,)` of a plate of this mass that strikes a bar, until the bar's wave is back.

    v exp(-z t / m), with the impedance z = E A / c, N s/mm. Saint-Venant; Goldsmith, Impact, 1960, sec. 2.6.
    """
    return np.asarray(speed * np.exp(-impedance * time / plate))
