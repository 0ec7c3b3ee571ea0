"""Values at which a costly function is what is wanted, in few evaluations: all of one number, or of several
those with the least change.

One number: a guide, a cheap function of about the same shape, is scanned finely; the costly one is asked only
for what it is times the guide, which varies slowly. Without a guide the function itself is interpolated. A
guide may be wrong, so that there is no such value is said by the costly function alone.

Several numbers: the results are taken as linear near where one is, by secants that every evaluation betters
(Broyden 1965); the least change that gives the wanted values then is looked up within the ranges and a trust
region, and evaluated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import lsq_linear

from skincad.base.arrays import Array

Function = Callable[[float], float | None]  # None where there is no value
GRID: Array = np.linspace(0.0, 1.0, 401)  # of the range: where a guide is scanned
STEP = 1 / 4  # of the range: how far apart places may be before it is said that there is no root
NARROW = 1e-3  # of the range: in a narrower interval nothing turns; how far beside a cut a place is
CLOSE = 1e-5  # of the range: two ends of a crossing nearer than this are a jump
SMALL = 1e-4  # of the largest value: with smaller ones logarithms would make much of little
LEAST = 0.01  # of a guide's largest value; a smaller one is taken as this, for what is divided by it
UNSURE = 1.5  # by which factor a guide may be off where nothing was evaluated
BENT = 3.0  # by which factor a function may be more curved, or steeper, than its points tell
PROBE = 0.04  # of a range: the step of the first slopes
TRUST, SMALLEST = 0.5, 1e-4  # of a range: how far a step goes at first, and where it is given up
STILL = 0.01  # of a range: a better place this near is not worth an evaluation
STARTS = 8  # places that are tried where the start has no values
WEIGHT = 1e3  # of what is wanted, in tolerances, over the change, in ranges


@dataclass
class Search:
    """What is known of a function on [0, 1] that is to be within `tol` of `wanted`, and of its guide.

    `seen` is where it was evaluated, None for no value. `roots` are arguments at which it is within `tol`,
    `jumps` where it passes the wanted value without taking it, `exact` whether nothing is left to look at
    (else the evaluations were used up). `complete` says that there are no other roots: both ends and points
    between were evaluated, and no interval is so wide and so curved that the function may reach the wanted
    value inside. At `cuts`, ends of the range, it may jump. `tries` counts places in search of one crossing.
    `guide` lies on the GRID, NaN where it has no value; `shape` is it without gaps and zeros, None where too
    little is known of it, or where it is below 0.
    """

    wanted: float
    tol: float
    guide: Array | None = None
    cuts: Sequence[float] = ()
    seen: dict[float, float | None] = field(default_factory=dict)
    roots: list[float] = field(default_factory=list)
    jumps: list[float] = field(default_factory=list)
    exact: bool = False
    complete: bool = False
    tries: int = 0

    def __post_init__(self) -> None:
        self.shape: Array | None = None
        if self.guide is not None:
            known = np.isfinite(self.guide)
            if 2 * known.sum() >= len(GRID) and self.guide[known].min() >= 0 < self.guide[known].max():
                filled = np.interp(GRID, GRID[known], self.guide[known])
                self.shape = np.maximum(filled, LEAST * filled.max())

    @property
    def points(self) -> tuple[Array, Array]:
        """Arguments with a value, rising, and their values."""
        known = sorted((x, y) for x, y in self.seen.items() if y is not None)
        return np.array([x for x, _ in known]), np.array([y for _, y in known])

    def met(self, x: float) -> bool:
        """Return whether an argument was evaluated and is a root."""
        y = self.seen[x]
        return y is not None and abs(y - self.wanted) <= self.tol

    def model(self, at: Array) -> Array:
        """Return the function by what is known of it: monotone cubics through its points; or the guide times
        those of its ratio to the guide, which beyond the last point stays as it is there. NaN where nothing
        is known."""
        x, y = self.points
        if len(x) < (2 if self.shape is None else 1):
            return np.full(len(at), np.nan)
        shape, inside = np.ones(len(at)), at
        if self.shape is not None:
            y, shape = y / np.interp(x, GRID, self.shape), np.interp(at, GRID, self.shape)
            inside = np.clip(at, x[0], x[-1])
        if len(x) == 1:
            return np.asarray(y * shape)
        if y.min() > SMALL * y.max():  # powers are lines then, or nearly
            return np.asarray(shape * np.exp(PchipInterpolator(x, np.log(y), extrapolate=False)(inside)))
        return np.asarray(shape * PchipInterpolator(x, y, extrapolate=False)(inside))

    def within(self, root: float, error: float) -> tuple[float, float]:
        """Return the ends of the stretch around a root in which the model is within `error` of it there."""
        model = self.model(GRID)
        off = np.nan_to_num(np.abs(model - np.interp(root, GRID, model)) - error, nan=1e100)
        ends = [_zero(GRID, off, i) for i in np.flatnonzero(off[:-1] * off[1:] < 0).tolist()]
        below, above = [x for x in ends if x < root], [x for x in ends if x > root]
        return max(below, default=0.0), min(above, default=1.0)


def search(
    function: Function,
    wanted: float,
    tol: float,
    most: int,
    guide: Function | None = None,
    first: float = 0.5,
    step: float = STEP,
    nowhere: float = STEP / 2,
    cuts: Sequence[float] = (),
) -> Search:
    """Return where a function on [0, 1] is within `tol` of `wanted`, in at most `most` evaluations.

    All crossings are found that its values at places a STEP apart tell of, and pairs of them at an extremum
    that comes near the wanted value; with a guide those that the guide's shape tells of, from one value at
    `first`. If these are none, the search goes on, to places no further than `step` apart (`nowhere` while
    none has a value) and to others, until the function's own values leave no room for one. At the ends that
    are `cuts` the function may jump: a length of 0 is often no small length, but none at all.
    """
    values = None if guide is None else [math.nan if (y := guide(x)) is None else y for x in GRID.tolist()]
    state = Search(wanted, tol, None if values is None else np.array(values), cuts)
    spread = np.arange(0.0, 1.0 + STEP, STEP).tolist() if state.shape is None else []
    for x in dict.fromkeys([first, *spread][:most]):
        state.seen[x] = function(x)
    while len(state.seen) < most and not state.exact:
        place = _crossing(state)
        if place is None and any(map(state.met, state.seen)):
            place = _turn(state) if state.shape is None else _end(state)
        elif place is None:
            place = _unsure(state, step, nowhere)
        if place is None:
            state.exact = True
        else:
            state.seen[place] = function(place)
            state.tries = 0 if state.met(place) else state.tries + 1
    state.complete = _unsure(state, step, nowhere) is None
    _settle(state)
    return state


def _zero(x: Array, off: Array, i: int) -> float:
    """Where a line through two neighbouring points passes 0."""
    return float(x[i] + off[i] / (off[i] - off[i + 1]) * (x[i + 1] - x[i]))


def _crossing(state: Search) -> float | None:
    """Where the model takes the wanted value without a known root beside; each fourth time the middle between
    the points on both sides of it."""
    at = np.unique([*GRID, *state.seen])
    off = state.model(at) - state.wanted
    x, y = state.points
    edges = np.array([-1, *np.flatnonzero(~(np.abs(off) <= state.tol)), len(at)])
    lows, highs = np.maximum(edges[:-1], 0), np.minimum(edges[1:], len(at) - 1)
    for i in np.flatnonzero((np.diff(edges) > 1) | (off[lows] * off[highs] < 0)).tolist():
        if any(place in state.seen for place in at[edges[i] + 1 : edges[i + 1]]):
            continue
        low, high = int(lows[i]), int(highs[i])
        turns = low + np.flatnonzero(off[low:high] * off[low + 1 : high + 1] < 0)
        nearest = float(at[low + np.argmin(np.abs(off[low : high + 1]))])
        place = _zero(at, off, turns[0]) if len(turns) else nearest
        k = int(np.searchsorted(x, place))
        if 0 < k < len(x) and (y[k - 1] - state.wanted) * (y[k] - state.wanted) < 0:
            if x[k] - x[k - 1] <= CLOSE:
                continue
            if state.tries % 4 == 3:  # the model does not see what turns there
                place = float(x[k - 1] + x[k]) / 2
        if place not in state.seen:
            return place
    return None


def _end(state: Search) -> float | None:
    """An end that was not looked at, where a guide that is off by UNSURE would have other crossings."""
    model = state.model(GRID)
    counts = {np.sum(np.diff(model * factor > state.wanted)) for factor in (1 / UNSURE, 1.0, UNSURE)}
    ends = [x for x in (0.0, 1.0) if x not in state.seen and len(counts) > 1]
    return min(ends, key=lambda x: abs(model[-int(x)] - state.wanted), default=None)


def _unsure(state: Search, step: float, nowhere: float) -> float | None:
    """Where the function may take the wanted value though its points do not tell: the ends, the middle of a
    wide interval or of a stretch that only a guide knows, a place where it may turn; None where its points
    leave no room."""
    for end in (0.0, 1.0, *(abs(end - NARROW) for end in state.cuts)):
        if end not in state.seen:
            return end
    places = sorted(state.seen)
    low, high = max(pairwise(places), key=lambda pair: pair[1] - pair[0])
    if high - low > (step if len(state.points[0]) else nowhere) * (1 + CLOSE):
        return (low + high) / 2
    if state.guide is not None:
        known = np.isfinite(state.guide)
        for stretch in np.split(np.arange(len(GRID)), np.flatnonzero(np.diff(known)) + 1):
            low, high = GRID[stretch[0]], GRID[stretch[-1]]
            if known[stretch[0]] and not any(low <= place <= high for place in places):
                return float((low + high) / 2)
    return _turn(state, 1 / STEP)


def _turn(state: Search, rise: float = 0.0) -> float | None:
    """Where the function may turn and take the wanted value between its points; None for nowhere.

    In an interval it may be as curved as the points around it tell, times BENT, and as it has to be to rise
    by its whole spread in 1 / `rise` of the range. Towards a place without a value it may go on as it does
    beside, twice as steeply, times BENT.
    """
    x = np.array(sorted(state.seen))
    y = np.array([np.nan if state.seen[place] is None else state.seen[place] for place in x.tolist()], float)
    known, low, high = np.isfinite(y), state.wanted - state.tol, state.wanted + state.tol
    if not known.any():
        return None
    if low > 0 and np.nanmin(y) > SMALL * np.nanmax(y):
        y, low, high = np.log(y), math.log(low), math.log(high)
    wide, cut = np.diff(x), np.isin(x, state.cuts)
    slope = np.where((wide <= NARROW) | cut[:-1] | cut[1:], np.nan, np.diff(y) / wide)  # a jump has none
    slopes, widths = (np.pad(values, 1, constant_values=np.nan) for values in (slope, wide))
    before, after = slopes[:-2], slopes[2:]
    # to be sure, all of it may lie inside the interval: a wide neighbour must not make it look slight
    bends = [
        2 * abs(other - slope) / (wide + (np.minimum(wide, width) if rise else width))
        for other, width in ((before, widths[:-2]), (after, widths[2:]))
    ]
    bend = np.fmax(BENT * np.fmax(*bends), max(8 * np.ptp(y[known]) * rise**2, 1e-300))
    rooms, places = [], []
    for side, limit in ((1.0, low), (-1.0, -high)):
        left, right = side * y[:-1], side * y[1:]
        top = np.clip(wide / 2 + side * slope / bend, 0.0, wide)
        reach = left + side * slope * top + bend / 2 * top * (wide - top)
        # where the ends lie on both sides, or at it, it is enough that the function does not turn
        more = np.where(np.fmax(left, right) < limit, limit, np.fmax(left, right) + high - low)
        rooms.append(np.where(np.fmin(left, right) > limit, -math.inf, reach - more))
        places.append(x[:-1] + np.clip(top, 0.1 * wide, 0.9 * wide))
    for value, steep in ((y[:-1], before), (y[1:], -after)):  # towards a place without a value
        far = np.fmax(low - value, value - high)
        more = 2 * BENT * wide * np.nan_to_num(steep * np.sign(low - value), nan=math.inf)
        rooms.append(np.where((known[:-1] != known[1:]) & (wide > CLOSE) & (far > 0), more - far, -math.inf))
        places.append(x[:-1] + wide / 2)
    room = np.nan_to_num(np.array(rooms), nan=-math.inf, posinf=math.inf)
    return float(np.array(places).flat[np.argmax(room)]) if room.max() > 0 else None


def _settle(state: Search) -> None:
    """Tell roots, one of neighbours between which the model is within tolerance too, and jumps. A crossing as
    steep as the function beside it is no jump: the tolerance is finer than the search tells."""
    x, y = state.points
    off = np.abs(y - state.wanted)
    hits = np.flatnonzero(off <= state.tol)
    apart = np.abs(state.model((x[:-1] + x[1:]) / 2) - state.wanted) > state.tol
    groups = np.split(hits, 1 + np.flatnonzero((np.diff(hits) > 1) | apart[hits[:-1]]))
    state.roots = [float(x[group[np.argmin(off[group])]]) for group in groups if len(group)]
    turned = np.diff(y > state.wanted) & (np.minimum(off[:-1], off[1:]) > state.tol) & (np.diff(x) <= CLOSE)
    slopes = np.pad(np.abs(np.diff(y) / np.diff(x)), 1)
    jumps = turned & (slopes[1:-1] > BENT * np.maximum(slopes[:-2], slopes[2:]))
    state.jumps = ((x[:-1] + x[1:]) / 2)[jumps].tolist()
    state.complete = state.complete and not (turned & ~jumps).any()


Place = tuple[float, ...]  # on the unit cube


def least_change(
    function: Callable[[Array], Array | None], start: Array, wanted: Array, tol: Array, most: int
) -> tuple[Array | None, dict[Place, Array | None]]:
    """Return the place on the unit cube nearest to `start` `(n,)` with `function` within `tol` `(m,)` of
    `wanted` `(m,)`, as far as `most` evaluations tell, None where none is; and all values by their places."""
    seen: dict[Place, Array | None] = {}

    def ask(at: Array) -> Array | None:
        place = tuple(at.tolist())
        if place not in seen and len(seen) < most:
            seen[place] = function(at)
        return seen.get(place)

    def off(values: Array) -> float:
        return float(np.abs((values - wanted) / tol).max())

    def change(place: Array) -> float:
        return float(np.linalg.norm(place - start))

    at, reached = start, ask(start)
    if reached is None:
        from scipy.stats import qmc  # half a second, which most commands need not wait for

        for at in sorted(qmc.Sobol(len(start), scramble=False).random(STARTS), key=change):
            if (reached := ask(at)) is not None:
                break
        else:
            return None, seen
    slopes = _slopes(ask, at, reached)
    trust, evaluated = TRUST, -1
    while len(seen) < most and trust > SMALLEST and len(seen) != evaluated:
        evaluated = len(seen)
        low, high = np.maximum(0.0, at - trust), np.minimum(1.0, at + trust)
        rows = np.vstack([WEIGHT * slopes / tol[:, None], np.eye(len(at))])
        sides = np.concatenate([WEIGHT * (wanted - reached) / tol, start - at])
        step = lsq_linear(rows, sides, (low - at - 1e-12, high - at + 1e-12), method="bvls").x
        candidate = np.clip(at + step, low, high)
        good = off(reached) <= 1.0
        if good and np.linalg.norm(candidate - at) < STILL:
            break
        new = ask(candidate)
        if new is None:
            trust /= 4
            continue
        step = candidate - at
        slopes += np.outer(new - reached - slopes @ step, step) / (float(step @ step) or 1.0)
        if off(new) < max(off(reached), 1.0) and not (good and change(candidate) > change(at)):
            at, reached, trust = candidate, new, min(2 * trust, 1.0)
        else:
            trust = min(trust, float(np.abs(step).max())) / 3
    within = [np.array(place) for place, values in seen.items() if values is not None and off(values) <= 1.0]
    return min(within, key=change, default=None), seen


def _slopes(ask: Callable[[Array], Array | None], at: Array, values: Array) -> Array:
    """Slopes `(m, n)` by a step in each number, away from the nearer end; 0 where there is no value."""
    slopes = np.zeros((len(values), len(at)))
    for i in range(len(at)):
        for step in (PROBE, -PROBE) if at[i] < 0.5 else (-PROBE, PROBE):
            probe = at + step * np.eye(len(at))[i]
            if 0 <= probe[i] <= 1 and (there := ask(probe)) is not None:
                slopes[:, i] = (there - values) / step
                break
    return slopes
