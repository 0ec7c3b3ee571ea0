"""The signals' low-pass: two equal causal poles, with the value's rate and jerk behind them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import linalg
from scipy.signal import lfilter

from skincad.base.arrays import Array


@dataclass(frozen=True)
class Limited:
    """A signal behind the low-pass with its rate and jerk, each `(steps + 1,)`; units of the input, per s."""

    value: Array
    rate: Array
    jerk: Array


def corner(bandwidth: float) -> float:
    """Return the double pole, rad/s, whose gain 1 / (1 + (w / pole)^2) is down by 3 dB at `bandwidth` Hz."""
    return 2 * math.pi * bandwidth / math.sqrt(math.sqrt(2) - 1)


def delay(bandwidth: float) -> float:
    """Return by how many s the low-pass delays a slow signal: 2 / pole."""
    return 2 / corner(bandwidth)


def band_limited(time: Array, values: Array, bandwidth: float) -> Limited:
    """Return `values` `(n,)` at evenly spaced `time` `(n,)` s behind two equal poles of -3 dB at `bandwidth`.

    y'' + 2 w y' + w^2 y = w^2 x, from rest at the first value; exact for an input straight between its
    samples. Franklin, Powell, Workman, Digital Control of Dynamic Systems, 3rd ed., sec. 6.3 (triangle hold).
    Solved as two poles one behind the other, u' = w (x - u), y' = w (u - y).
    """
    w = corner(bandwidth)
    start, count = values[0], values.size
    if count == 1:
        return Limited(values.copy(), np.zeros(1), np.zeros(1))
    # in units of 1 / w: u, y and the input with its slope
    h = w * float(time[1] - time[0])
    system = np.zeros((4, 4))
    system[0, 0], system[0, 2] = -1.0, 1.0
    system[1, 0], system[1, 1] = 1.0, -1.0
    system[2, 3] = 1.0
    step = linalg.expm(system * h)
    x = values - start
    slope = np.diff(x) / h

    def behind(row: int, forcing: Array) -> Array:
        pole = step[row, row]
        whole = forcing + step[row, 2] * x[:-1] + step[row, 3] * slope
        return np.concatenate([[0.0], lfilter([1.0], [1.0, -pole], whole)])

    u = behind(0, np.zeros(count - 1))
    y = behind(1, step[1, 0] * u[:-1])
    rate = u - y
    return Limited(y + start, rate * w, (x - u - rate) * w**2)
