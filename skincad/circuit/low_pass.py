"""The signals' low-pass: two equal causal poles, with the value's rate and jerk behind them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from scipy import linalg
from scipy.signal import lfilter

from skincad.base.arrays import Array

EVEN = 1e-6  # of a step, by which evenly spaced ones may differ: rounding of a million steps leaves 2e-10


@dataclass(frozen=True)
class FilteredSignal:
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


def longest_step(time: Array) -> float:
    """Return the step of evenly spaced `time` `(n,)` s, and of others the longest, s; n is at least 2."""
    steps = np.diff(time)
    return float(steps[0]) if evenly_spaced(time) else float(steps.max())


def evenly_spaced(time: Array) -> bool:
    """Return whether all steps of `time` `(n,)` s are equal but for rounding; n is at least 2."""
    steps = np.diff(time)
    return bool(np.ptp(steps) <= EVEN * steps[0])


def band_limited(time: Array, values: Array, bandwidth: float) -> FilteredSignal:
    """Return `values` `(n,)` at `time` `(n,)` s behind two equal poles of -3 dB at `bandwidth`.

    y'' + 2 w y' + w^2 y = w^2 x, from rest at the first value; exact for an input straight between its
    samples. Franklin, Powell, Workman, Digital Control of Dynamic Systems, 3rd ed., sec. 6.3 (triangle hold).
    Solved as two poles one behind the other, u' = w (x - u), y' = w (u - y).
    """
    w = corner(bandwidth)
    start, count = values[0], values.size
    if count == 1:
        return FilteredSignal(values.copy(), np.zeros(1), np.zeros(1))
    x = values - start
    steps = w * np.diff(time)
    u, y = _even_poles(w * float(time[1] - time[0]), x) if evenly_spaced(time) else _uneven_poles(steps, x)
    rate = u - y
    return FilteredSignal(y + start, rate * w, (x - u - rate) * w**2)


def _even_poles(h: float, x: Array) -> tuple[Array, Array]:
    """Return u and y `(n,)` of inputs `(n,)` a step `h` apart, in units of 1 / w."""
    # u, y and the input with its slope
    system = np.zeros((4, 4))
    system[0, 0], system[0, 2] = -1.0, 1.0
    system[1, 0], system[1, 1] = 1.0, -1.0
    system[2, 3] = 1.0
    step = linalg.expm(system * h)
    slope = np.diff(x) / h

    def behind(row: int, forcing: Array) -> Array:
        pole = step[row, row]
        whole = forcing + step[row, 2] * x[:-1] + step[row, 3] * slope
        return np.concatenate([[0.0], lfilter([1.0], [1.0, -pole], whole)])

    u = behind(0, np.zeros(x.size - 1))
    return u, behind(1, step[1, 0] * u[:-1])


def _uneven_poles(h: Array, x: Array) -> tuple[Array, Array]:
    """Return u and y `(n,)` of inputs `(n,)` with steps `h` `(n - 1,)` between them, in units of 1 / w.

    The closed form of a step: with x = x0 + s t, u = x0 + s (t - 1) + c e^-t and
    y = x0 + s (t - 2) + (c t + d) e^-t.
    """
    fades, faded = np.exp(-h), -np.expm1(-h)
    before, slope = x[:-1], np.diff(x) / h

    def behind(forcing: Array) -> Array:
        pairs = zip(fades.tolist(), forcing.tolist(), strict=True)
        return np.array(list(accumulate(pairs, lambda last, pair: pair[0] * last + pair[1], initial=0.0)))

    u = behind(before * faded + slope * (h - faded))
    fed = h * fades * (u[:-1] - before) + before * faded + slope * (h * (1 + fades) - 2 * faded)
    return u, behind(fed)
