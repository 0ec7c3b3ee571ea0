"""Which strip each channel of a recording shows at first sight: alignment, likelihoods, and an assignment.

A channel's signal over a grid of cells of the scene's time is taken as normal round each strip's predicted
signal times a common gain; its covariance is that of simulations with modulus, friction and crests drawn from
their tolerances, each strip's own scatter of gain, and noise. Heavy tails (Student's t) allow for what no
simulation has, and for some offset and drift. Channels are independent here but for gain, delay and speed,
and for each strip's lying behind one channel at most: a linear assignment (Jonker and Volgenant, Computing 38
(1987) 325) finds the most probable one. From there `strip_posterior` judges all channels together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.special import logsumexp

from skincad.base.arrays import Array, Index

CELLS = 120  # of the press, and as many of what follows: the narrowest peak of the templates has three
FEWEST_CELLS = 12  # of the press
BASIS = 16  # signals by which all predictions are described
SPEEDS = np.geomspace(0.7, 1.45, 13)  # duration of a recorded scene over the predicted one
SPEED_SPREAD = 0.15  # of its logarithm
SPEED_COST = 0.01  # of the share explained, at that spread
GAINS = np.geomspace(0.4, 2.5, 13)  # common to all strips
FINE = np.geomspace(0.84, 1.19, 9)  # round the best of them
GAIN_SPREAD = 0.4  # of its logarithm: d31, amplifier and modulus
SCATTER = 0.1  # of each strip's gain
CHANGES = 1.5  # by which drawn changes are taken as larger: few are drawn
FLOOR = 0.06  # of a signal: what no drawn simulation has
LATE = 0.5  # cells, standard deviation that alignment leaves of the delay
LONG, GAIN_STEP = 0.01, 0.1  # relative, that it leaves of the duration, and the search of the common gain
WANDER = 0.03  # of all signals: offset and drift that the rest before the press does not show
TAIL = 20.0  # degrees of freedom of Student's t
WEAK, WEAK_SPREAD = 0.35, 0.15  # gain of a weak strip over the common one
DEAD_LEAK = 0.03  # gain of a dead one
SURPRISE = 1.5  # power of an unexplained signal over the recorded one
WORKS, REVERSED, WEAK_STATE, DEAD, UNEXPLAINED = "works", "reversed", "weak", "dead", "unexplained"
PRIOR = {WORKS: 0.93, REVERSED: 0.02, WEAK_STATE: 0.01, DEAD: 0.03, UNEXPLAINED: 0.002}
SAME_RIDGE = 0.5  # of all swaps
SWAP_PRIOR, SWAP_REVERSED = 0.02, 0.1  # of some pair; of a reversed one among those
HUM = 50.0, 60.0  # Hz
HUM_COST = float(np.log(2.0))  # of a dead strip that hums


@dataclass(frozen=True, eq=False)
class SignalModel:
    """Predicted signals over the cells between `edges` `(cells + 1,)` s of the scene, in a basis
    `(cells, rank)`: `mean` `(strips, rank)` and `spread` `(strips, rank, rank)`; V s^0.5.

    `wander` `(rank, 2)` is an offset and a drift of V s^0.5 1. `shared` `(factors, strips, rank)` is what one
    standard deviation of each common factor changes: each drawn member, the other moduli, delay, speed, gain.
    """

    edges: Array
    basis: Array
    wander: Array
    mean: Array
    spread: Array
    shared: Array

    @property
    def strips(self) -> int:
        """How many strips there are."""
        return len(self.mean)

    def weighted(self, cells: Array) -> Array:
        """Return signals `(n, cells)` V weighted by the root of a cell's width, V s^0.5."""
        return np.asarray(cells * np.sqrt(np.diff(self.edges)))


def signal_model(time: Array, worlds: Array, world: int, changes: Array, edges: Array) -> SignalModel:
    """Return the model of outputs `worlds[world]` `(strips, steps)` V at `time` `(steps,)` s, with what
    tolerances change of them `(members, strips, steps)` V, and as common factors what other worlds do."""
    width = np.sqrt(np.diff(edges))
    middle, cell = (edges[1:] + edges[:-1]) / 2, float(np.diff(edges).min())

    def weighted(signals: Array, at: Array) -> Array:
        return np.array([cell_means(time, member, at) * width for member in signals])

    outputs = worlds[[world]]
    signals = weighted(np.concatenate([outputs, changes]), edges)
    flat = signals.reshape(-1, len(width))
    rank = min(BASIS, *flat.shape)
    basis = np.linalg.eigh(flat.T @ flat)[1][:, ::-1][:, :rank]
    mean, off = (signals @ basis)[0], (signals @ basis)[1:]
    spread = np.einsum("msa,msb->sab", off, off) / max(1, len(off))
    slow = np.stack([width, width * middle / edges[-1]])
    wander = basis.T @ (slow / np.linalg.norm(slow, axis=1, keepdims=True)).T
    delayed = (weighted(outputs, edges + LATE * cell) - weighted(outputs, edges - LATE * cell)) / 2
    longer = (weighted(outputs, edges * (1 + LONG)) - weighted(outputs, edges * (1 - LONG))) / 2
    others = weighted(np.delete(worlds, world, axis=0), edges).reshape(-1, *signals.shape[1:]) - signals[0]
    shared = [off / np.sqrt(max(1, len(off))), (GAIN_STEP * mean)[None]]
    shared += [moved @ basis for moved in (others, delayed, longer)]
    return SignalModel(edges, basis, wander, mean, spread, np.concatenate(shared))


def cell_means(time: Array, signals: Array, edges: Array) -> Array:
    """Return the means `(n, cells)` of signals `(n, samples)`, straight between samples, between edges s."""
    steps = np.diff(time)
    areas = (signals[:, 1:] + signals[:, :-1]) / 2 * steps
    total = np.concatenate([np.zeros((len(signals), 1)), np.cumsum(areas, axis=1)], axis=1)
    place = np.clip(np.searchsorted(time, edges, side="right") - 1, 0, time.size - 2)
    ahead = np.clip(edges, time[0], time[-1]) - time[place]
    slope = (signals[:, place + 1] - signals[:, place]) / steps[place]
    at_edges = total[:, place] + ahead * (signals[:, place] + slope * ahead / 2)
    return np.asarray(np.diff(at_edges, axis=1) / np.diff(edges))


@dataclass(frozen=True, eq=False)
class Alignment:
    """When a recording's scene begins, s, and how long it takes over the predicted one."""

    delay: float
    speed: float
    score: float


def align(
    edges: Array, press: int, worlds: Array, time: Array, signals: Array, delays: Array, speeds: Array
) -> list[Alignment]:
    """Return for each of some `worlds` `(worlds, strips, cells)` V the delay and speed at which each strip
    best explains its own channel of a recording `(channels, samples)` that begins at 0 V.

    Either sign does, and few channels show another strip. A channel counts by its size. Cells behind the
    recording's end do not count, but the first `press` must lie before it.
    """
    step = np.gradient(time)
    energy = np.concatenate([np.zeros((len(signals), 1)), np.cumsum(signals**2 * step, axis=1)], axis=1)
    weight = np.sqrt(energy[:, -1] / energy[:, -1].max()) if energy[:, -1].any() else np.ones(len(signals))
    weight, width = weight / weight.sum(), np.diff(edges)
    best = [Alignment(0.0, 1.0, -np.inf) for _ in worlds]
    for speed in speeds:
        for delay in delays:
            count = int(np.searchsorted(edges, (time[-1] - delay) / speed * (1 + 1e-9), side="right")) - 1
            if count < press:
                continue
            places = delay + speed * edges[: count + 1]
            weighted = cell_means(time, signals, places) * (speed * width[:count])
            until = energy[:, np.searchsorted(time, places[-1])] + 1e-300
            shown = worlds[:, :, :count]
            overlap = np.einsum("wck,ck->wc", shown, weighted) ** 2
            size = np.einsum("wck,wck,k->wc", shown, shown, speed * width[:count]) + 1e-300
            scores = np.minimum(overlap / size / until, 1.0) @ weight
            scores -= SPEED_COST * (np.log(speed) / SPEED_SPREAD) ** 2
            best = [
                Alignment(float(delay), float(speed), float(score)) if score > old.score else old
                for score, old in zip(scores, best, strict=True)
            ]
    return best


@dataclass(frozen=True, eq=False)
class Likelihoods:
    """Log-likelihoods at each common gain, first axis `(gains,)`: of channel `c` showing strip `j` upright or
    reversed `(gains, channels, strips)`, and of its own strip's being weak or dead, or of neither
    `(gains, channels)`."""

    gains: Array
    upright: Array
    reversed: Array
    weak: Array
    dead: Array
    unexplained: Array


@dataclass(frozen=True, eq=False)
class _Normal:
    """Normal distributions `(...)`: the `inverse` of their covariance `(..., rank, rank)` and its
    log-determinant `size` `(...)`."""

    inverse: Array
    size: Array

    @classmethod
    def of(cls, covariance: Array) -> _Normal:
        """Return those of covariances `(..., rank, rank)`."""
        inverse = np.asarray(np.linalg.inv(covariance), float)
        return cls(inverse, np.asarray(np.linalg.slogdet(covariance)[1], float))

    def log_density(self, off: Array, tail: float = TAIL) -> Array:
        """Log-density at `off` `(..., rank)`, without its constant: of Student's t with `tail` degrees of
        freedom, or normal with infinitely many."""
        quad = np.einsum("...a,...a->...", off, np.matmul(self.inverse, off[..., None])[..., 0])
        if np.isinf(tail):
            return np.asarray(-0.5 * (self.size + quad))
        return np.asarray(-0.5 * self.size - (tail + off.shape[-1]) / 2 * np.log1p(quad / tail))


class Judge:
    """The distributions of channels about a model's strips, made once, for recordings aligned in many ways.

    `noise` `(channels,)` V s^0.5 is a number's, `size` `(channels,)` that of the whole signals. What no
    simulation has goes with a channel's own size, so that no state gains by a smaller one.
    """

    def __init__(self, model: SignalModel, noise: Array, size: Array, gains: Array = GAINS) -> None:
        self.model, self.gains = model, gains
        rank = model.mean.shape[1]
        eye = np.eye(rank)
        power = np.einsum("sa,sa->s", model.mean, model.mean)
        own = np.einsum("sa,sb->sab", model.mean, model.mean)
        unknown = CHANGES**2 * model.spread / power[:, None, None] + FLOOR**2 / rank * eye
        unknown = (size**2)[:, None, None, None] * unknown  # (channels, strips, rank, rank)
        wander = (WANDER**2 * power.mean()) * (model.wander @ model.wander.T)
        white = (noise**2)[:, None, None] * eye + wander
        gain = gains[:, None, None, None] ** 2
        at = np.arange(len(noise))
        self.live = _Normal.of(unknown + white[:, None] + gain[:, None] * SCATTER**2 * own)
        self.weak = _Normal.of(unknown[at, at] + white + gain * WEAK_SPREAD**2 * own)
        self.silent_covariance = np.minimum(gain, 1.0) * DEAD_LEAK**2 * own + white
        self.silent = _Normal.of(self.silent_covariance)
        surprise = SURPRISE * np.maximum(size**2, DEAD_LEAK**2 * power)  # a smaller one is a dead strip
        self.broad = _Normal.of((surprise / rank)[:, None, None] * eye + white)

    def likelihoods(self, parts: Array, hum: Array) -> Likelihoods:
        """Return the likelihoods of channels `(channels, rank)` V s^0.5 in the model's basis, with `hum`
        `(rank, k)` signals of the mains that a dead strip may show."""
        mean, gain = self.model.mean, self.gains[:, None, None]
        shown = (gain * mean)[:, None]
        strength = (parts**2).sum(axis=1)[:, None, None]
        loud = _Normal.of(self.silent_covariance + strength * (hum @ hum.T)).log_density(parts[None], np.inf)
        return Likelihoods(
            gains=self.gains,
            upright=self.live.log_density(parts[:, None] - shown),
            reversed=self.live.log_density(parts[:, None] + shown),
            weak=self.weak.log_density(parts - WEAK * gain * mean),
            dead=np.logaddexp(self.silent.log_density(parts[None], np.inf), loud - HUM_COST),
            unexplained=np.broadcast_to(self.broad.log_density(parts, np.inf), (len(self.gains), len(parts))),
        )


@dataclass(frozen=True, eq=False)
class Assignment:
    """The strip (from 0) that each channel shows `(channels,)`, or a number beyond the last where none;
    the common gain, its mean with an error and the `likeliest`; and the log-probability of it all."""

    places: Index
    gain: float
    gain_error: float
    likeliest: float
    score: float


def costs(like: Likelihoods) -> Array:
    """Return minus the log-posteriors `(gains, channels, strips + 2 channels)` of each channel's place: a
    strip, dead, unexplained."""
    gains, count, strips = like.upright.shape
    table = np.full((gains, count, strips + 2 * count), 1e9)
    table[:, :, :strips] = -np.logaddexp(like.upright, like.reversed + np.log(SWAP_REVERSED))
    table[:, :, :strips] -= log_half_swap(count)
    at = np.arange(count)
    own = np.stack(
        [
            -like.upright[:, at, at] - np.log(PRIOR[WORKS]),
            -like.reversed[:, at, at] - np.log(PRIOR[REVERSED]),
            -like.weak - np.log(PRIOR[WEAK_STATE]),
        ],
        axis=2,
    )
    table[:, at, at] = own.min(axis=2)
    table[:, at, strips + at] = -like.dead - np.log(PRIOR[DEAD])
    table[:, at, strips + count + at] = -like.unexplained - np.log(PRIOR[UNEXPLAINED])
    return table


def log_half_swap(count: int) -> Array:
    """Log-prior `(channels, channels)` of one of the two channels of each swapped pair.

    Half of all swaps are taken to be of the two strips of a ridge, whose pads lie side by side (assumption).
    """
    ridge = np.arange(count) // 2
    same, pairs = ridge[:, None] == ridge, count // 2
    others = max(1, count * (count - 1) // 2 - pairs)
    share = np.where(same, SAME_RIDGE / pairs, (1 - SAME_RIDGE) / others)
    return np.asarray(np.log(SWAP_PRIOR * share) / 2)


def assign(like: Likelihoods) -> Assignment:
    """Return the most probable assignment."""
    logs, table = np.log(like.gains), costs(like)
    pairs = [linear_sum_assignment(cost) for cost in table]
    whole = np.array([-float(cost[pair].sum()) for cost, pair in zip(table, pairs, strict=True)])
    whole += -0.5 * (logs / GAIN_SPREAD) ** 2  # the gain's prior
    best, weights = int(whole.argmax()), np.exp(whole - logsumexp(whole))
    middle = float(weights @ logs)
    spread = float(np.sqrt(weights @ (logs - middle) ** 2))
    gain = float(np.exp(middle))
    return Assignment(pairs[best][1], gain, gain * spread, float(like.gains[best]), float(whole[best]))
