"""Closed forms in time, to hold the dynamics against: oscillators with friction, viscous stress, impacts.

Units mm, N, s, and tonne unless another is said.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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
