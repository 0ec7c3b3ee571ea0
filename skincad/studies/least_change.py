"""Several numbers so that several results have wanted values, with the least change from the start.

Sequential: the results are taken as linear near where one is, by secants that every evaluation betters
(Broyden 1965); the least change that gives the wanted values then is looked up within the ranges and a trust
region, and evaluated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import lsq_linear, minimize

from skincad.base.arrays import Array

Function = Callable[[Array], Array | None]  # (n,) on [0, 1] -> (m,), None where there is no value
PROBE = 0.04  # of a range: the step of the first slopes
TRUST, SMALLEST = 0.5, 1e-4  # of a range: how far a step goes at first, and where it is given up
STILL = 0.01  # of a range: a better place this near is not worth an evaluation
STARTS = 8  # places that are tried where the start has no values


@dataclass
class Walk:
    """What was evaluated, `(n,)` and `(m,)` or None, and the best of it within tolerance, None if none is."""

    seen: list[tuple[Array, Array | None]] = field(default_factory=list)
    best: Array | None = None
    closest: Array | None = None


def least_change(function: Function, start: Array, wanted: Array, tol: Array, most: int) -> Walk:
    """Return the place on the unit cube nearest to `start` `(n,)` with `function` within `tol` `(m,)` of
    `wanted` `(m,)`, as far as `most` evaluations tell."""
    path = Walk()

    def ask(at: Array) -> Array | None:
        for place, values in path.seen:
            if np.array_equal(place, at):
                return values
        if len(path.seen) >= most:
            return None
        path.seen.append((at, function(at)))
        return path.seen[-1][1]

    at, reached = _first(ask, start)
    if reached is None:
        return path
    scale = tol
    slopes = _slopes(ask, at, reached)
    trust, evaluated = TRUST, -1
    while len(path.seen) < most and trust > SMALLEST and len(path.seen) != evaluated:
        evaluated = len(path.seen)
        good = bool(np.all(np.abs(reached - wanted) <= tol))
        candidate = _nearest(start, at, reached - wanted, slopes, trust, scale)
        if good and np.linalg.norm(candidate - at) < STILL:
            break
        new = ask(candidate)
        if new is None:
            trust /= 4
            continue
        step = candidate - at
        slopes = slopes + np.outer(new - reached - slopes @ step, step) / (float(step @ step) or 1.0)
        if _merit(new, wanted, scale) < max(_merit(reached, wanted, scale), 1.0) and not (
            good and np.linalg.norm(candidate - start) > np.linalg.norm(at - start)
        ):
            at, reached = candidate, new
            trust = min(2 * trust, 1.0)
        else:
            trust = min(trust, float(np.abs(step).max())) / 3
    known = [(place, known_values) for place, known_values in path.seen if known_values is not None]
    path.closest = min(known, key=lambda one: _merit(one[1], wanted, scale))[0]
    within = [place for place, known_values in known if np.all(np.abs(known_values - wanted) <= tol)]
    path.best = min(within, key=lambda place: float(np.linalg.norm(place - start)), default=None)
    return path


def _merit(values: Array, wanted: Array, scale: Array) -> float:
    """How far off, in tolerances."""
    return float(np.abs((values - wanted) / scale).max())


def _first(ask: Function, start: Array) -> tuple[Array, Array | None]:
    """The start, or the nearest of some places that has values."""
    if (values := ask(start)) is not None:
        return start, values
    from scipy.stats import qmc  # half a second, which most commands need not wait for

    places = qmc.Sobol(len(start), scramble=False).random(STARTS)
    for place in sorted(places, key=lambda each: float(np.linalg.norm(each - start))):
        if (values := ask(place)) is not None:
            return place, values
    return start, None


def _slopes(ask: Function, at: Array, values: Array) -> Array:
    """Slopes `(m, n)` by a step in each number, away from the nearer end; 0 where there is no value."""
    slopes = np.zeros((len(values), len(at)))
    for i in range(len(at)):
        for sign in (1.0, -1.0) if at[i] < 0.5 else (-1.0, 1.0):
            step = at.copy()
            step[i] += sign * PROBE
            if 0 <= step[i] <= 1 and (there := ask(step)) is not None:
                slopes[:, i] = (there - values) / (sign * PROBE)
                break
    return slopes


def _nearest(start: Array, at: Array, off: Array, slopes: Array, trust: float, scale: Array) -> Array:
    """Return the place nearest to the start that gives the wanted values if slopes are right; where none in
    reach does, the one that comes nearest to them."""
    low, high = np.maximum(0.0, at - trust), np.minimum(1.0, at + trust)
    scaled = slopes / scale[:, None]

    def clipped(place: Array) -> Array:
        inside: Array = np.clip(place, low, high)
        return inside

    reach = lsq_linear(scaled, -off / scale, (low - at - 1e-12, high - at + 1e-12))
    if np.abs(scaled @ reach.x + off / scale).max() > 1.0:
        return clipped(at + reach.x)
    minimum = minimize(
        lambda place: float((place - start) @ (place - start)),
        clipped(at + reach.x),
        jac=lambda place: 2 * (place - start),
        bounds=list(zip(low, high, strict=True)),
        constraints={
            "type": "eq",
            "fun": lambda place: scaled @ (place - at) + off / scale,
            "jac": lambda _: scaled,
        },
        method="SLSQP",
    )
    return clipped(minimum.x)
