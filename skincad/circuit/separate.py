"""Stress-rate and stress-jerk apart, from one output: an observer of the network, and a crossover beside it.

The observer is the steady Kalman filter (Kalman 1960; Anderson and Moore, Optimal Filtering, 1979, sec. 4.4)
of the network driven by a current, the charge's rate, whose own rate walks at random. It knows the network,
so it undoes it: rate and jerk of the charge, each sample from those so far. It is a fixed linear filter.
Range: the output's noise is taken as white, of its own rms in the band up to half the rate.
The crossover splits the output at the cut-off: below it the paper's stress-rate, above it its stress-jerk.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import schur

from skincad.base.errors import InputError, RefusedError
from skincad.circuit.exponential import exponential
from skincad.circuit.low_pass import band_limited
from skincad.circuit.network import Complex, Constants, Real
from skincad.circuit.state import recursion, sizes, state_space

SETTLED = 1e-10  # relative change of the filter's gain in a step
MOST_STEPS = 100_000


@dataclass(frozen=True)
class Separator:
    """z = step z + gain vout in a triangular basis; rows of `read` give the charge's rate and jerk."""

    rate: float  # Hz
    step: Complex  # (n, n), upper triangular
    gain: Complex  # (n,)
    read: Complex  # (2, n), C/s and C/s2


def separator(c: Constants, rate: float, noise: float, jerk: float, bandwidth: float) -> Separator:
    """Return the observer of outputs at `rate` Hz with `noise` V rms.

    It expects jerks of `jerk` C/s2 that last about 1 / (2 pi bandwidth): more of it or less noise make it
    faster. Raises InputError for values that are not above 0, RefusedError where its gain does not settle.
    """
    given = {"rate": rate, "noise": noise, "jerk": jerk, "bandwidth": bandwidth}
    for key, value in given.items():
        if not (math.isfinite(value) and value > 0):
            raise InputError(key, "must be above 0 and finite", value)
    system, size = state_space(c), sizes(c)
    n = size.size
    # voltages instead of the charge's share of them: the input is the current, through the film's capacitance
    whole = np.zeros((n + 2, n + 2))
    units = np.concatenate([size / c.capacitance, [rate, rate**2]])  # of 1 C
    whole[:n, :n] = system.a
    whole[0, n], whole[n, n + 1] = 1 / c.capacitance, 1.0
    with np.errstate(over="ignore"):  # the exponential refuses what is not finite
        step = exponential(whole * units[None, :] / units[:, None] / rate)
    seen = np.concatenate([system.c * size / c.capacitance, [0.0, 0.0]])
    walk = 2 * math.pi * bandwidth * 2 * jerk**2 / rate / units[-1] ** 2  # of the jerk's variance in a sample
    gain = _steady_gain(step, seen, walk, noise**2)
    triangle, basis = schur(step - np.outer(gain, seen @ step), output="complex")
    if not np.abs(np.diag(triangle)).max() < 1:
        raise RefusedError("the observer is not stable: its noise and jerk are too far apart")
    return Separator(rate, triangle, basis.conj().T @ gain, units[n:, None] * basis[n:])


def separated(s: Separator, output: Real, state: Complex | None = None) -> tuple[Real, Real, Complex]:
    """Return the charge's rate C/s and jerk C/s2, `(n,)` each, of an output `(n,)` V, and the last state.

    Without a state all was at rest before.
    """
    output = np.asarray(output, float)
    before = np.zeros(s.gain.size, complex) if state is None else state
    found = recursion(s.step, lambda k: s.gain[k] * output, before, output.size + 1)
    rate, jerk = (s.read @ found[:, 1:]).real
    return rate, jerk, found[:, -1].copy()


def crossover(output: Real, rate: float, cutoff: float) -> tuple[Real, Real]:
    """Return what of an output `(n,)` V lies below the cut-off, Hz, and the rest: they add up to it."""
    below = band_limited(np.arange(output.size) / rate, output, cutoff).value
    return below, output - below


def _steady_gain(step: Real, seen: Real, walk: float, noise: float) -> Real:
    """The Kalman gain that the Riccati recursion settles at, from certainty of nothing but rest."""
    spread, gain = np.zeros_like(step), np.zeros(step.shape[0])
    for _ in range(MOST_STEPS):
        spread = step @ spread @ step.T
        spread[-1, -1] += walk
        across = spread @ seen
        new = across / (float(seen @ across) + noise)
        spread = spread - np.outer(new, across)
        spread = (spread + spread.T) / 2
        if np.abs(new).max() > 0 and np.abs(new - gain).max() <= SETTLED * np.abs(new).max():
            return np.asarray(new)
        gain = new
    raise RefusedError(f"the observer's gain has not settled in {MOST_STEPS} samples")
