"""Which strip each channel of a recording shows: alignment, likelihoods, and the most probable assignment.

A channel's signal over a grid of cells of the scene's time is taken as normal round each strip's predicted
signal times a common gain; its covariance is that of simulations with modulus, friction and crests drawn from
their tolerances, each strip's own scatter of gain, and noise. Heavy tails (Student's t) allow for what no
simulation has. Offset and drift are projected out. Channels are independent but for gain, delay and speed,
and for each strip's lying behind one channel at most: a linear assignment (Jonker and Volgenant, Computing 38
(1987) 325) finds the most probable one, and one more for each state of each channel gives its probability.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.special import logsumexp

from skincad.base.arrays import Array, Index

CELLS = 120  # of the press, and as many of what follows: the narrowest peak of the templates has three
FEWEST_CELLS = 12  # of the press
BASIS = 32  # signals by which all predictions are described
SPEEDS = np.geomspace(0.7, 1.45, 17)  # duration of a recorded scene over the predicted one
SPEED_SPREAD = 0.15  # of its logarithm
SPEED_COST = 0.01  # of the share explained, at that spread
GAINS = np.geomspace(0.33, 3.0, 16)  # common to all strips
GAIN_SPREAD = 0.4  # of its logarithm: d31, amplifier and modulus
SCATTER = 0.1  # of each strip's gain
FLOOR = 0.05  # of a signal: what no drawn simulation has
TAIL = 6.0  # degrees of freedom of Student's t
WEAK, WEAK_SPREAD = 0.35, 0.15  # gain of a weak strip over the common one
DEAD_LEAK = 0.03  # gain of a dead one
SURPRISE = 2.0  # size of an unexplained signal over the predicted ones
WORKS, REVERSED, WEAK_STATE, DEAD, UNEXPLAINED = "works", "reversed", "weak", "dead", "unexplained"
PRIOR = {WORKS: 0.93, REVERSED: 0.02, WEAK_STATE: 0.01, DEAD: 0.03, UNEXPLAINED: 0.002}
SWAP_PRIOR, SWAP_REVERSED = 0.02, 0.1  # of some pair; of a reversed one among those
HUM = 50.0, 60.0  # Hz
HUM_COST = float(np.log(4.0))  # of a dead strip that hums


@dataclass(frozen=True, eq=False)
class SignalModel:
    """Predicted signals over the cells between `edges` `(cells + 1,)` s of the scene, in a basis
    `(cells, rank)`: `mean` `(strips, rank)` and `spread` `(strips, rank, rank)`; V s^0.5.

    `free` `(cells, 2)` is what offset and drift are.
    """

    edges: Array
    basis: Array
    free: Array
    mean: Array
    spread: Array

    @property
    def strips(self) -> int:
        """How many strips there are."""
        return len(self.mean)

    def project(self, cells: Array) -> Array:
        """Return signals `(n, cells)` V without offset and drift, weighted by the root of a cell's width."""
        weighted = cells * np.sqrt(np.diff(self.edges))
        return np.asarray(weighted - (weighted @ self.free) @ self.free.T)


def signal_model(time: Array, outputs: Array, changes: Array, edges: Array) -> SignalModel:
    """Return the model of outputs `(strips, steps)` V at `time` `(steps,)` s, with what tolerances change
    of them `(members, strips, steps)` V."""
    width = np.sqrt(np.diff(edges))
    middle = (edges[1:] + edges[:-1]) / 2
    free = np.linalg.qr(np.stack([width, width * middle / edges[-1]], axis=1))[0]
    cells = np.array([cell_means(time, member, edges) for member in (outputs, *changes)])
    blank = SignalModel(edges, np.zeros((len(width), 0)), free, np.zeros((0, 0)), np.zeros((0, 0, 0)))
    signals = np.array([blank.project(member) for member in cells])
    flat = signals.reshape(-1, len(width))
    rank = min(BASIS, *flat.shape)
    basis = np.linalg.svd(flat, full_matrices=False)[2][:rank].T
    mean, off = (signals @ basis)[0], (signals @ basis)[1:]
    spread = np.einsum("msa,msb->sab", off, off) / max(1, len(off))
    return SignalModel(edges, basis, free, mean, spread)


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


def align(model: SignalModel, time: Array, signals: Array, delays: Array, speeds: Array) -> Alignment:
    """Return the delay and speed at which each strip best explains its own channel of a recording
    `(channels, samples)`, with either sign; few channels show another strip."""
    step = np.gradient(time)
    energy = ((signals - np.median(signals, axis=1, keepdims=True)) ** 2 * step).sum(axis=1) + 1e-300
    own = _subspaces(model)
    best = Alignment(0.0, 1.0, -np.inf)
    for speed in speeds:
        for delay in delays:
            parts = model.project(cell_means(time, signals, delay + speed * model.edges)) @ model.basis
            share = speed * (np.einsum("ca,cak->ck", parts, own) ** 2).sum(axis=1) / energy
            score = float(share.mean()) - SPEED_COST * (np.log(speed) / SPEED_SPREAD) ** 2
            if score > best.score:
                best = Alignment(float(delay), float(speed), score)
    return best


def _subspaces(model: SignalModel) -> Array:
    """Each strip's signal and its two largest changes `(strips, rank, 3)`, of length 1 and orthogonal."""
    rows = []
    for mean, spread in zip(model.mean, model.spread, strict=True):
        changes = np.linalg.eigh(spread)[1][:, -2:]
        rows.append(np.linalg.qr(np.column_stack([mean, changes]))[0])
    return np.array(rows)


@dataclass(frozen=True, eq=False)
class Likelihoods:
    """Log-likelihoods at each common gain, first axis `(gains,)`: of channel `c` showing strip `j` upright or
    reversed `(gains, channels, strips)`, and of its own strip's being weak or dead, or of neither
    `(gains, channels)`."""

    upright: Array
    reversed: Array
    weak: Array
    dead: Array
    unexplained: Array


@dataclass(frozen=True, eq=False)
class _Normal:
    """Normal distributions `(...)` with their means' `factor` of a strip's signal, `inverse` covariance
    `(..., rank, rank)` and its log-determinant `size` `(...)`."""

    inverse: Array
    size: Array

    @classmethod
    def of(cls, covariance: Array) -> _Normal:
        return cls(np.linalg.inv(covariance), np.linalg.slogdet(covariance)[1])

    def student(self, off: Array) -> Array:
        """Log-density of Student's t at `off` `(..., rank)`, without its constant."""
        quad = np.einsum("...a,...a->...", off, np.matmul(self.inverse, off[..., None])[..., 0])
        rank = off.shape[-1]
        return np.asarray(-0.5 * self.size - (TAIL + rank) / 2 * np.log1p(quad / TAIL))


class Judge:
    """The distributions of channels with `noise` `(channels,)` V s^0.5 about a model's strips: made once,
    for recordings aligned in many ways."""

    def __init__(self, model: SignalModel, noise: Array) -> None:
        self.model = model
        rank = model.mean.shape[1]
        eye = np.eye(rank)
        size = np.einsum("sa,sa->s", model.mean, model.mean)
        own = np.einsum("sa,sb->sab", model.mean, model.mean)
        shape = model.spread + (FLOOR**2 * size / rank)[:, None, None] * eye
        white = (noise**2)[:, None, None] * eye
        gain = GAINS[:, None, None, None] ** 2
        self.white = white
        live = (shape + SCATTER**2 * own)[None]
        self.live = _Normal.of(gain[:, None] * live[:, None] + white[:, None])
        self.weak = _Normal.of(gain * (WEAK**2 * shape + WEAK_SPREAD**2 * own) + white)
        self.silent_covariance = gain * DEAD_LEAK**2 * own + white
        self.silent = _Normal.of(self.silent_covariance)
        broad = gain * SURPRISE**2 * size.mean() / rank * eye
        self.broad = _Normal.of(broad + white)

    def likelihoods(self, parts: Array, hum: Array) -> Likelihoods:
        """Return the likelihoods of channels `(channels, rank)` V s^0.5 in the model's basis, with `hum`
        `(rank, k)` signals of the mains that a dead strip may show."""
        mean, gain = self.model.mean, GAINS[:, None, None]
        shown = (gain * mean)[:, None]
        strength = (parts**2).sum(axis=1)[:, None, None]
        loud = _Normal.of(self.silent_covariance + strength * (hum @ hum.T)).student(parts[None])
        return Likelihoods(
            upright=self.live.student(parts[:, None] - shown),
            reversed=self.live.student(parts[:, None] + shown),
            weak=self.weak.student(parts - WEAK * gain * mean),
            dead=np.logaddexp(self.silent.student(parts[None]), loud - HUM_COST),
            unexplained=self.broad.student(parts[None]),
        )


@dataclass(frozen=True, eq=False)
class ChannelStates:
    """A channel's states with their probabilities, the most probable first: a name, and the strip (from 0)
    that it shows with its sign where that is another's."""

    states: tuple[tuple[str, int | None, int], ...]
    probabilities: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Assignment:
    """States of all channels, the common gain, and the log-probability of it all; `alike` pairs of channels
    whose strips could change places without the data's saying so."""

    channels: tuple[ChannelStates, ...]
    gain: float
    gain_error: float
    score: float
    alike: tuple[tuple[int, int], ...]
    dead_evidence: Array


ALIKE = 3.0  # of log-likelihood: below it the data do not tell two assignments apart


def costs(like: Likelihoods) -> tuple[Array, Array]:
    """Return minus the log-posteriors `(gains, channels, strips + 2 channels)` of each channel's place: a
    strip, dead, unexplained; and those of the states on the own strip `(gains, channels, 3)`."""
    gains, count, strips = like.upright.shape
    pair = np.sqrt(SWAP_PRIOR / max(1, count * (count - 1) // 2))
    table = np.full((gains, count, strips + 2 * count), 1e9)
    table[:, :, :strips] = -np.logaddexp(like.upright, like.reversed + np.log(SWAP_REVERSED)) - np.log(pair)
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
    return table, own


def best_score(like: Likelihoods) -> float:
    """Return the log-posterior of the most probable assignment at the most probable gain."""
    table, _ = costs(like)
    return max(-_total(cost) + prior for cost, prior in zip(table, _gain_prior(), strict=True))


def _gain_prior() -> Array:
    return np.asarray(-0.5 * (np.log(GAINS) / GAIN_SPREAD) ** 2)


def _total(cost: Array) -> float:
    return float(cost[linear_sum_assignment(cost)].sum())


def assign(like: Likelihoods) -> Assignment:
    """Return the most probable state of each channel, with the probabilities of all."""
    table, own = costs(like)
    prior = _gain_prior()
    whole = np.array([-_total(cost) for cost in table]) + prior
    near = np.flatnonzero(whole > whole.max() - 8.0)
    count, strips = like.upright.shape[1:]
    channels = tuple(_channel(c, table, own, near, prior, like) for c in range(count))
    weights = np.exp(whole - logsumexp(whole))
    logs = np.log(GAINS)
    middle = float(weights @ logs)
    top = int(whole.argmax())
    rows, columns = linear_sum_assignment(table[top])
    alike = tuple(_alike(rows, columns, like, top))
    at = np.arange(count)
    evidence = np.maximum(like.upright[top], like.reversed[top])[at, at] - like.dead[top]
    spread = float(np.sqrt(weights @ (logs - middle) ** 2))
    gain = float(np.exp(middle))
    return Assignment(channels, gain, gain * spread, float(whole.max()), alike, evidence)


def _channel(
    c: int, table: Array, own: Array, near: Index, prior: Array, like: Likelihoods
) -> ChannelStates:
    """The states of one channel by the best assignment that each allows."""
    count, strips = like.upright.shape[1:]
    scores: dict[tuple[str, int | None, int], list[float]] = {}
    others = np.delete(np.arange(count), c)
    for g in near:
        for column in [*range(strips), strips + c, strips + count + c]:
            rest = np.delete(table[g][others], column, axis=1)
            base = prior[g] - _total(rest)
            for state, cost in _states(c, column, g, table, own, like):
                scores.setdefault(state, []).append(base - cost)
    logs = {state: float(logsumexp(rows)) for state, rows in scores.items()}
    total = float(logsumexp(list(logs.values())))
    ordered = sorted(logs, key=lambda state: -logs[state])
    return ChannelStates(tuple(ordered), tuple(float(np.exp(logs[s] - total)) for s in ordered))


def _states(
    c: int, column: int, g: int, table: Array, own: Array, like: Likelihoods
) -> Iterator[tuple[tuple[str, int | None, int], float]]:
    """Each state that a place stands for, with its cost."""
    count, strips = like.upright.shape[1:]
    if column == c:
        for k, name in enumerate((WORKS, REVERSED, WEAK_STATE)):
            yield (name, None, -1 if name == REVERSED else 1), float(own[g, c, k])
    elif column < strips:
        sign = 1 if like.upright[g, c, column] > like.reversed[g, c, column] + np.log(SWAP_REVERSED) else -1
        yield ("swapped", column, sign), float(table[g, c, column])
    else:
        yield (DEAD if column < strips + count else UNEXPLAINED, None, 1), float(table[g, c, column])


def _alike(rows: Index, columns: Index, like: Likelihoods, g: int) -> Iterator[tuple[int, int]]:
    """Pairs of channels on strips whose exchange costs less than ALIKE of log-likelihood."""
    count, strips = like.upright.shape[1:]
    best = np.maximum(like.upright[g], like.reversed[g])
    shown = {int(c): int(j) for c, j in zip(rows, columns, strict=True) if j < strips}
    for a in shown:
        for b in shown:
            if a < b:
                now = best[a, shown[a]] + best[b, shown[b]]
                if now - best[a, shown[b]] - best[b, shown[a]] < ALIKE:
                    yield a, b
