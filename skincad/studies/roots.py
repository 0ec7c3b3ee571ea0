"""All values of one number at which a costly function has a wanted value, in few evaluations.

A guide, a cheap function of about the same shape, is scanned finely; the costly one is asked only for what it
is times the guide, which varies slowly. Without a guide the function itself is interpolated. A guide may be
wrong, so that there is no such value is said by the costly function alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator

from skincad.base.arrays import Array

Function = Callable[[float], float | None]  # None where there is no value
FIRST = 5  # evaluations spread over the range before any is chosen, without a guide
UNSURE = 1.5  # by which factor a guide may be off where nothing was evaluated
SCAN = 400  # intervals of the range in which crossings are looked for
CLOSE = 1e-5  # of the range: two ends of a crossing nearer than this are a jump
SMALL = 1e-4  # of the largest value; a smaller one is as good as 0
LEAST = 0.01  # of a guide's largest value; a smaller one is taken as this, for what is divided by it
NEAR = 0.15  # of the function's spread: an extremum this near the wanted value is looked at
EDGE = 1e-3  # of a bracket: nearer to its end nothing new is learnt
EDGES = 4  # halvings towards the end of where there are values, at each such end
STEP = 1 / (FIRST - 1)  # of the range: how far apart places may be before it is said that there is no root
NOWHERE = STEP / 8  # of the range: the same where none has a value, and no guide tells which may
WIDEST = STEP / 2  # of the range: in a wider interval a function may rise by its whole spread
OUTER = 2.0**-6  # of the range: how far from where values end the next place is, to tell the slope there
BESIDE = 1e-3  # of the range: how far from an end that is apart its neighbour is
NARROWEST = 2.0**-10  # of the range: in a narrower interval a function is taken as a line
BENT = 3.0  # by which factor a function may be more curved than its points tell


@dataclass
class Search:
    """What is known of a function on [0, 1]: where it was evaluated, and what the crossings are.

    `roots` are arguments at which it is within tolerance, `jumps` where it passes the wanted value without
    taking it, `exact` whether nothing is left to look at (else the evaluations were used up). `complete` says
    that there are no other roots: both ends and points between were evaluated, and no interval is so wide and
    so curved that the function may reach the wanted value inside. `model` is the function at even steps of
    [0, 1] by what is known, NaN where nothing is.
    """

    seen: dict[float, float | None] = field(default_factory=dict)
    roots: list[float] = field(default_factory=list)
    jumps: list[float] = field(default_factory=list)
    exact: bool = False
    complete: bool = False
    model: Array = field(default_factory=lambda: np.zeros(0))

    def within(self, root: float, error: float) -> tuple[float, float]:
        """Return the ends of the stretch around a root in which the model is within `error` of it there."""
        grid: Array = np.linspace(0.0, 1.0, len(self.model))
        off = np.abs(self.model - np.interp(root, grid, self.model)) - error
        ends = _crossings(grid, np.nan_to_num(off, nan=1e100))
        below, above = [x for x in ends if x < root], [x for x in ends if x > root]
        return max(below, default=0.0), min(above, default=1.0)

    def near(self, wanted: float, tol: float) -> bool:
        """Return whether a value is within `tol` of `wanted`."""
        return any(y is not None and abs(y - wanted) <= tol for y in self.seen.values())

    @property
    def points(self) -> tuple[Array, Array]:
        """Arguments with a value, rising, and their values."""
        known = sorted((x, y) for x, y in self.seen.items() if y is not None)
        return np.array([x for x, _ in known]), np.array([y for _, y in known])


def search(
    function: Function,
    wanted: float,
    tol: float,
    most: int,
    guide: Function | None = None,
    first: float = 0.5,
    step: float | None = None,
    cuts: Sequence[float] = (),
) -> Search:
    """Return where a function on [0, 1] is within `tol` of `wanted`, in at most `most` evaluations.

    All crossings are found that its values at FIRST points tell of, and pairs of them at an extremum that
    lies near the wanted value. With a guide those that the guide's shape tells of, from one value at `first`.
    If these are none, a search with a `step` goes on, to places no further than this apart and to others,
    until the function's own values leave no room for one. At the ends that are `apart` the function may jump:
    a length of 0 is often no small length, but none at all.
    """
    state = Search()
    grid: Array = np.linspace(0.0, 1.0, SCAN + 1)
    values = _told(guide, grid)
    scanned = _scanned(values, grid)

    def ask(x: float) -> None:
        if x not in state.seen and len(state.seen) < most:
            state.seen[x] = function(x)

    ask(first)
    if scanned is None:
        for x in np.linspace(0.0, 1.0, FIRST):
            ask(float(x))
    if not any(y is not None for y in state.seen.values()):
        for x in np.linspace(0.0, 1.0, 2 * FIRST - 1):
            ask(float(x))
    while len(state.seen) < most:
        following = _next(state, wanted, tol, grid, scanned)
        if following is None or following in state.seen:
            unsure = _unsure(state, wanted, tol, values, cuts, step or STEP)
            if unsure is None or not step or state.near(wanted, tol):
                state.exact = True
                break
            following = unsure
        ask(following)
    state.complete = _unsure(state, wanted, tol, values, cuts, step or STEP) is None
    _settle(state, wanted, tol, lambda at: _ratio(state, grid, scanned, np.array([at]))[0])
    state.model = _ratio(state, grid, scanned, grid)
    return state


def _told(guide: Function | None, grid: Array) -> Array | None:
    """A guide's values on the grid, NaN where it has none; None without a guide."""
    if guide is None:
        return None
    return np.array([np.nan if (y := guide(float(x))) is None else y for x in grid], dtype=float)


def _scanned(values: Array | None, grid: Array) -> Array | None:
    """A guide's values, its gaps filled; None where it has too few, or some below 0."""
    if values is None:
        return None
    known = np.isfinite(values)
    if known.sum() < len(grid) / 2 or np.any(values[known] < 0):
        return None
    filled: Array = np.interp(grid, grid[known], values[known])
    return np.maximum(filled, LEAST * filled.max()) if filled.max() > 0 else None


def _ratio(state: Search, grid: Array, scanned: Array | None, at: Array) -> Array:
    """The function by what is known of it: interpolated, or as the guide times what is interpolated, which
    beyond the known places stays as it is at the last of them. NaN where nothing is known."""
    x, y = state.points
    if len(x) < (2 if scanned is None else 1):
        return np.full(len(at), np.nan)
    if scanned is None:
        return _interpolated(x, y, at)
    known = y / np.interp(x, grid, scanned)
    ratio = _interpolated(x, known, np.clip(at, x[0], x[-1])) if len(x) > 1 else known[0]
    return np.asarray(ratio * np.interp(at, grid, scanned))


def _interpolated(x: Array, y: Array, at: Array) -> Array:
    """Monotone cubics through points, of the logarithm where all are clearly above 0: powers are lines then,
    or nearly."""
    if y.min() > SMALL * y.max():
        return np.asarray(np.exp(PchipInterpolator(x, np.log(y), extrapolate=False)(at)))
    return np.asarray(PchipInterpolator(x, y, extrapolate=False)(at))


def _next(state: Search, wanted: float, tol: float, grid: Array, scanned: Array | None) -> float | None:
    """Where to look next: at a crossing, at an end of where there are values, at an extremum near it."""
    x, y = state.points
    for left, right in _brackets(x, y, wanted, tol):
        return _inside(state, x[left], x[right], wanted, grid, scanned)
    off = _ratio(state, grid, scanned, grid) - wanted
    roots = x[np.abs(y - wanted) <= tol]
    for crossing in _unexplained(_crossings(grid, off), roots):
        if _far(state, crossing, CLOSE):
            return crossing
    if scanned is not None and (end := _end(state, off + wanted, wanted)) is not None:
        return end
    if not len(roots) and not np.isnan(off).all():
        nearest = float(grid[np.nanargmin(np.abs(off))])
        if _far(state, nearest, 1.0 / SCAN):
            return nearest
    edge = _edge(state)
    return edge if edge is not None else _extremum(state, wanted, tol)


def _crossings(grid: Array, off: Array) -> list[float]:
    """Where a function passes 0, its values on the grid as lines."""
    turned = np.flatnonzero(off[:-1] * off[1:] < 0)  # NaN passes nothing
    return [
        float(grid[i] + off[i] / (off[i] - off[i + 1]) * (grid[i + 1] - grid[i])) for i in turned.tolist()
    ]


def _end(state: Search, model: Array, wanted: float) -> float | None:
    """An end of the range that was not looked at, where a guide that is off by UNSURE there would have other
    crossings."""
    grid: Array = np.linspace(0.0, 1.0, len(model))
    here = len(_crossings(grid, model - wanted))
    if all(len(_crossings(grid, factor * model - wanted)) == here for factor in (UNSURE, 1 / UNSURE)):
        return None
    ends = [end for end in (0.0, 1.0) if end not in state.seen]
    return min(ends, key=lambda end: abs(model[0 if end == 0 else -1] - wanted), default=None)


def _brackets(x: Array, y: Array, wanted: float, tol: float) -> list[tuple[int, int]]:
    """Neighbours on both sides of the wanted value, neither of which is within tolerance, nor too close."""
    off = y - wanted
    return [
        (i, i + 1)
        for i in range(len(x) - 1)
        if off[i] * off[i + 1] < 0 and min(abs(off[i]), abs(off[i + 1])) > tol and x[i + 1] - x[i] > CLOSE
    ]


def _inside(
    state: Search, low: float, high: float, wanted: float, grid: Array, scanned: Array | None
) -> float:
    """A point of a bracket: at the model's crossing there, or half-way where that has gained little."""
    fine: Array = np.linspace(low, high, 257)
    crossings = _crossings(fine, _ratio(state, grid, scanned, fine) - wanted)
    wide, middle = high - low, (low + high) / 2
    point = crossings[0] if crossings else middle
    if min(point - low, high - point) >= EDGE * wide:
        return point
    near = [
        seen_point
        for seen_point in state.seen
        if low - EDGE * wide * 100 <= seen_point <= high + EDGE * wide * 100
    ]
    if len(near) > 2:  # one end was there already: the model does not see what turns between
        return middle
    return min(max(point, low + EDGE * wide), high - EDGE * wide)


def _edge(state: Search) -> float | None:
    """The middle between a point with a value and one without, if not halved often enough."""
    seen = sorted(state.seen.items())
    for (a, at_a), (b, at_b) in pairwise(seen):
        if (at_a is None) != (at_b is None) and b - a > 2.0**-EDGES / (FIRST - 1):
            return (a + b) / 2
    return None


def _extremum(state: Search, wanted: float, tol: float) -> float | None:
    """Where a parabola through three neighbours turns towards the wanted value, and comes near it."""
    x, y = state.points
    spread = float(np.ptp(y)) if len(y) else 0.0
    for i in range(1, len(x) - 1):
        off = y[i - 1 : i + 2] - wanted
        if off[0] * off[2] <= 0 or off[1] * off[0] < -tol * abs(off[0]):
            continue  # a crossing, which is looked for as one
        if abs(off[1]) > min(abs(off[0]), abs(off[2])):
            continue
        a, b, _ = np.polyfit(x[i - 1 : i + 2] - x[i], off, 2)
        turn = float(x[i] - b / (2 * a)) if a else float(x[i])
        lowest = abs(off[1] - b * b / (4 * a)) if a else abs(off[1])
        crosses = a and (off[1] - b * b / (4 * a)) * off[1] < 0
        if (crosses or lowest < NEAR * spread) and x[i - 1] < turn < x[i + 1] and _far(state, turn, 0.01):
            return turn
    return None


def _unsure(
    state: Search, wanted: float, tol: float, guesses: Array | None, cuts: Sequence[float], step: float
) -> float | None:
    """Where the function may take the wanted value though its points do not tell: the ends, the middle of a
    wide interval, the place where it may come nearest; None where its points leave no room.

    An interval is judged by the largest curvature of the points around it, times BENT: the more curved and
    the wider, the further the function may go beyond its values at the interval's ends.
    """
    beside = [abs(end - BESIDE) for end in cuts]
    for end in (0.0, 1.0, *beside):
        if end not in state.seen:
            return end
    _, y = state.points
    places = sorted(state.seen)
    narrow = step if len(y) else min(step, NOWHERE if guesses is None else WIDEST)
    wide = max(pairwise(places), key=lambda pair: pair[1] - pair[0])
    if wide[1] - wide[0] > narrow * (1 + CLOSE):
        return sum(wide) / 2
    if (place := _unvisited(state, guesses)) is not None:
        return place
    if not len(y):
        return None
    logs = y.min() > SMALL * y.max() and wanted > tol
    low, high = (math.log(wanted - tol), math.log(wanted + tol)) if logs else (wanted - tol, wanted + tol)
    spread = float(np.ptp(np.log(y) if logs else y))
    best, where = 0.0, None
    for piece, before, after in _pieces(state, wanted, cuts):
        at = np.array(piece)
        values = np.array([state.seen[place] for place in piece], dtype=float)
        values = np.log(values) if logs else values
        widths, slopes = np.diff(at), np.diff(values) / np.diff(at)
        for i in range(len(at) - 1):
            ends = values[i : i + 2]
            bend = max(
                # all of it may lie inside the interval: a wide neighbour must not make it look slight
                (
                    BENT * 2 * abs(slopes[k] - slopes[i]) / (widths[i] + min(widths[i], widths[k]))
                    for k in (i - 1, i + 1)
                    if 0 <= k < len(slopes)
                ),
                default=math.inf,
            )
            for side, limit in ((1.0, low), (-1.0, -high)):
                if min(side * ends) > limit:
                    continue  # it is on the far side, which the other direction looks at
                top, place = _reach(at[i], at[i + 1], side * ends[0], side * ends[1], bend, spread)
                if i in (0, len(at) - 2) and at[i + 1] - at[i] > OUTER * (1 + CLOSE):
                    # no point outside tells how it bends there, so the slope must
                    place = at[0] + OUTER if i == 0 else at[-1] - OUTER
                # where the ends lie on both sides, or at it, it is enough that the function does not turn
                room = top - (limit if max(side * ends) < limit else max(side * ends) + high - low)
                if room > best:
                    best, where = room, place
        if where is None:
            where = _beyond(at, values, before, after, low, high)
    return where


def _unvisited(state: Search, values: Array | None) -> float | None:
    """The middle of a stretch in which a guide has values, and no place of which was looked at."""
    if values is None:
        return None
    grid: Array = np.linspace(0.0, 1.0, len(values))
    turns = np.flatnonzero(np.diff(np.isfinite(values))) + 1
    for stretch in np.split(np.arange(len(grid)), turns):
        first, last = grid[stretch[0]], grid[stretch[-1]]
        if np.isfinite(values[stretch[0]]) and not any(first <= place <= last for place in state.seen):
            return float((first + last) / 2)
    return None


def _pieces(
    state: Search, wanted: float, cuts: Sequence[float]
) -> Iterator[tuple[list[float], float | None, float | None]]:
    """Runs of places with values, without a jump between, and the places without a value beside them."""
    piece: list[float] = []
    before, last = None, math.nan
    for place, value in sorted(state.seen.items()):
        if value is None:
            if piece:
                yield piece, before, place
            piece, before = [], place
            continue
        jump = place - piece[-1] <= CLOSE and (last - wanted) * (value - wanted) < 0 if piece else False
        if piece and (jump or piece[-1] in cuts or place in cuts):
            yield piece, before, None
            piece, before = [], None
        piece.append(place)
        last = value
    if piece:
        yield piece, before, None


def _reach(
    low: float, high: float, at_low: float, at_high: float, bend: float, spread: float
) -> tuple[float, float]:
    """How high a function of no more curvature than `bend` may be between two points, and where."""
    wide, end = high - low, max(at_low, at_high)
    middle = (low + high) / 2
    if wide <= NARROWEST:
        return end, middle
    if not math.isfinite(bend):
        return math.inf, middle
    slope = (at_high - at_low) / wide
    along = wide / 2 + (slope / bend if bend else math.inf * slope if slope else 0.0)
    if bend and 0 < along < wide:
        top = at_low + slope * along + bend / 2 * along * (wide - along)
        place = low + min(max(along, 0.1 * wide), 0.9 * wide)
    else:
        top, place = end, middle
    return (max(top, end + spread), middle) if wide > WIDEST * (1 + CLOSE) else (top, place)


def _beyond(
    at: Array, values: Array, before: float | None, after: float | None, low: float, high: float
) -> float | None:
    """The middle of a gap between a piece's end and a place without a value, if the function, going on as
    it does there, may pass the wanted value inside."""
    for gap, near, inner in ((before, 0, 1), (after, -1, -2)):
        if gap is None or abs(gap - at[near]) <= CLOSE:
            continue
        toward = 1.0 if values[near] < low else -1.0 if values[near] > high else 0.0
        if len(at) < 2 or not toward:
            continue
        slope = toward * (values[near] - values[inner]) / abs(at[near] - at[inner])
        # twice as steep as at the last two points: towards where there is no value functions grow steeper
        rise = 2 * BENT * max(slope, 0.0) * abs(gap - at[near])
        if rise > (low - values[near] if toward > 0 else values[near] - high):
            return float((gap + at[near]) / 2)
    return None


def _far(state: Search, point: float, least: float) -> bool:
    return all(abs(point - seen_point) > least for seen_point in state.seen)


def _unexplained(crossings: list[float], roots: Array) -> list[float]:
    """The crossings of a model without, for each known root, the one that is nearest to it."""
    left = list(crossings)
    for root in roots:
        if left:
            left.remove(min(left, key=lambda each: abs(each - root)))
    return left


def _settle(state: Search, wanted: float, tol: float, model: Callable[[float], float]) -> None:
    """Tell roots, one of neighbours between which the model is within tolerance too, and jumps."""
    x, y = state.points
    off = y - wanted
    groups: list[list[int]] = []
    for i in np.flatnonzero(np.abs(off) <= tol).tolist():
        beside = groups and i == groups[-1][-1] + 1
        if beside and abs(model((x[i - 1] + x[i]) / 2) - wanted) <= tol:
            groups[-1].append(i)
        else:
            groups.append([i])
    state.roots = [float(x[min(group, key=lambda i: abs(off[i]))]) for group in groups]
    state.jumps = [
        float((x[i] + x[i + 1]) / 2)
        for i in range(len(x) - 1)
        if off[i] * off[i + 1] < 0 and min(abs(off[i]), abs(off[i + 1])) > tol and x[i + 1] - x[i] <= CLOSE
    ]
