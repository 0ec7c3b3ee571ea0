"""Signals from a march: band-limited stress with its rate and jerk, and when ridges slip.

A quasi-static march with Coulomb friction is piecewise smooth, so its raw jerk is spikes of 1 / dt at events
that hang on the mesh; nobody may read those as signal. Everything goes through one causal low-pass.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


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
    """
    w = corner(bandwidth)
    start, count = values[0], values.size
    y, rate, jerk = np.zeros(count), np.zeros(count), np.zeros(count)
    if count > 1:
        # in units of 1 / w, the states y, y' and the input with its slope
        h = w * float(time[1] - time[0])
        system = np.zeros((4, 4))
        system[0, 1] = system[2, 3] = 1.0
        system[1, :3] = -1.0, -2.0, 1.0
        step = linalg.expm(system * h)
        x = values - start
        for i in range(1, count):
            now = step @ np.array([y[i - 1], rate[i - 1], x[i - 1], (x[i] - x[i - 1]) / h])
            y[i], rate[i] = now[:2]
            jerk[i] = x[i] - y[i] - 2 * rate[i]
    return Limited(y + start, rate * w, jerk * w**2)


def slip_by_ridge(touches: Mask, slips: Mask, ridge: NDArray[np.int64], ridges: int) -> Mask:
    """Return `(steps + 1, ridges)`: a ridge slips while all its touching points slip, and some touch."""
    mine = [ridge == r for r in range(1, ridges + 1)]
    columns = [touches[:, m].any(axis=1) & (slips | ~touches)[:, m].all(axis=1) for m in mine]
    return np.stack(columns, axis=1)


def intervals(slipping: Mask) -> list[list[int]]:
    """Return [from, to] of every run of True in `(n,)`, both inside the run."""
    edges = np.flatnonzero(np.diff(slipping.astype(np.int8), prepend=0, append=0))
    return [[int(a), int(b) - 1] for a, b in zip(edges[::2], edges[1::2], strict=True)]


def gross_slip_step(touches: Mask, slips: Mask) -> int | None:
    """Return the first index at which every touching point slips, None if there is none."""
    found = np.flatnonzero(touches.any(axis=1) & (slips | ~touches).all(axis=1))
    return int(found[0]) if found.size else None


def lasting_slip_step(runs: list[list[int]], gross: int | None, last: int) -> int | None:
    """Return the start of the run that lasts to gross slip, or to the end."""
    end = last if gross is None else gross
    return next((a for a, b in runs if a <= end <= b), None)
