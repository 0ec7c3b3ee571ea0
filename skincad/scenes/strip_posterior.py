"""What all channels of a recording show, judged together.

Strips have much in common: modulus, crests and friction move all signals at once, as do what is left of
delay, speed and gain. These are normal factors, and given them channels are independent. Each assignment of
strips is integrated over the factors in closed form, as in factor analysis. So the two strips of a ridge are
told apart by their difference, which the factors hardly touch.

The most probable assignment is climbed to by one channel or one exchange at a time, from the linear
assignment and from all strips in place. Probabilities are over all such steps from there, and from its
likeliest neighbours.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from skincad.base.arrays import Array, Index
from skincad.scenes.strip_assignment import (
    DEAD,
    PRIOR,
    REVERSED,
    SCATTER,
    SWAP_REVERSED,
    TAIL,
    UNEXPLAINED,
    WANDER,
    WEAK,
    WEAK_SPREAD,
    WEAK_STATE,
    WORKS,
    Judge,
    SignalModel,
    log_half_swap,
)

OWN_FLOOR = 0.03  # of a signal: what neither a factor nor its own spread has
ALIKE = 3.0  # of log-likelihood: below it the data do not tell two assignments apart
NEIGHBOURS = 6  # likeliest ones, whose neighbours count too
SWAPPED = "swapped"
State = tuple[str, int | None, int]  # name, the other strip (from 0) where swapped, and its sign
ChannelStates = list[tuple[State, float]]  # with their probabilities, the most probable first


@dataclass(frozen=True, eq=False)
class Posterior:
    """States of all channels; `alike` pairs of channels whose strips could change places without the data's
    saying so; `dead_evidence` `(channels,)` the log-likelihood by which each shows its strip and not none."""

    channels: tuple[ChannelStates, ...]
    alike: tuple[tuple[int, int], ...]
    dead_evidence: Array


def posterior(
    model: SignalModel, parts: Array, noise: Array, hum: Array, gain: float, start: Index
) -> Posterior:
    """Return what channels' `parts` `(channels, rank)` V s^0.5 show at a common `gain`.

    `start` `(channels,)` has the strip that each shows at first sight, or more than there are where none.
    """
    like = Judge(model, noise, np.linalg.norm(parts, axis=1), np.array([gain])).likelihoods(parts, hum)
    n, at = len(parts), np.arange(len(parts))
    alone = np.stack([like.dead[0], like.unexplained[0]], axis=1)
    evidence = np.maximum(like.upright, like.reversed)[0, at, at] - like.dead[0]
    upright = like.upright[0] >= like.reversed[0]
    seen = np.where(start < n, start, at)
    places = np.where(start < n, np.where(upright[at, seen], seen, n + seen), 2 * n + 1)
    first = _Joint(model, parts, noise, gain, alone, np.ones(len(parts)))
    peaks = [first.climbed(begin) for begin in (places, np.where(upright[at, at], at, n + at))]
    peak = max(peaks, key=lambda assignment: float(first.scores(assignment[None])[0]))
    joint = _Joint(model, parts, noise, gain, alone, first.softness(peak))
    best = joint.climbed(peak)
    return Posterior(joint.states(best), tuple(joint.alike(best)), evidence)


class _Joint:
    """Scores of assignments. Of `n` channels on `n` strips, a channel's place is `j` for a strip upright,
    `n + j` for it reversed, `2 n` for its own strip weak, then dead, and unexplained. `alone` `(channels, 2)`
    is the log-likelihood of the last two.

    `soft` `(channels,)` is by how much a channel's own covariance is larger where its strip is not weak: the
    heavy tail of Student's t.
    """

    def __init__(
        self, model: SignalModel, parts: Array, noise: Array, gain: float, alone: Array, soft: Array
    ) -> None:
        mean, shared = model.mean, model.shared
        self.count, self.rank = mean.shape
        n, rank, eye = self.count, self.rank, np.eye(self.rank)
        power = np.einsum("sa,sa->s", mean, mean)
        size = np.einsum("ca,ca->c", parts, parts)
        outer = np.einsum("sa,sb->sab", mean, mean)
        unknown = model.spread / power[:, None, None] + OWN_FLOOR**2 / rank * eye
        white = (noise**2)[:, None, None] * eye + WANDER**2 * power.mean() * (model.wander @ model.wander.T)
        rest = size[:, None, None, None] * unknown + white[:, None]
        at, by = np.arange(n), soft[:, None, None]
        live = _Terms.of(by[:, None] * (rest + gain**2 * SCATTER**2 * outer), gain * shared)
        weak = _Terms.of(rest[at, at] + gain**2 * WEAK_SPREAD**2 * outer, WEAK * gain * shared)
        up, down = (live.at(sign * parts[:, None] - gain * mean) for sign in (1, -1))
        faint = weak.at(parts - WEAK * gain * mean)
        none = np.zeros((n, 2, len(shared)))
        prior = np.log([PRIOR[name] for name in (WEAK_STATE, DEAD, UNEXPLAINED)])
        self.half = log_half_swap(n)
        swapped = np.stack([self.half, self.half + np.log(SWAP_REVERSED)], axis=1)
        swapped[at, :, at] = np.log([PRIOR[WORKS], PRIOR[REVERSED]])
        self.prior = np.concatenate([swapped.reshape(n, 2 * n), np.tile(prior, (n, 1))], axis=1)
        self.value = np.concatenate([up[0], down[0], faint[0][:, None], alone], axis=1)
        self.slope = np.concatenate([up[1], down[1], faint[1][:, None], none], axis=1)
        nothing = np.zeros((n, 1, len(shared), len(shared)))
        self.bend = np.concatenate([live.bend, weak.bend[:, None], nothing], axis=1)
        self.scale = np.concatenate([np.tile(live.size, 2), weak.size[:, None]], axis=1)

    def _bends(self, places: Index) -> Index:
        """Where `bend` has the terms of places: a strip either way, weak, none."""
        n = self.count
        return np.asarray(np.where(places < 2 * n, places % n, np.minimum(places - n, n + 1)))

    def _integrals(self, places: Index) -> tuple[Array, Array]:
        """Of assignments `(m, channels)`: the factors' precision `(m, f, f)`, and its product with their
        mean `(m, f)`."""
        factors = self.slope.shape[2]
        precision = np.tile(np.eye(factors), (len(places), 1, 1))
        total = np.zeros((len(places), factors))
        where = self._bends(places)
        for c in range(self.count):
            precision += self.bend[c, where[:, c]]
            total += self.slope[c, places[:, c]]
        return precision, total

    def likelihoods(self, places: Index) -> Array:
        """Log-likelihoods `(m,)` of assignments `(m, channels)`."""
        precision, total = self._integrals(places)
        root = np.linalg.cholesky(precision)
        mean = np.linalg.solve(root, total[..., None])[..., 0]
        values = np.take_along_axis(self.value[None], places[..., None], axis=2)[..., 0].sum(axis=1)
        diagonal = np.einsum("mff->mf", root)
        return np.asarray(values + (mean**2).sum(axis=1) / 2 - np.log(diagonal).sum(axis=1))

    def scores(self, places: Index) -> Array:
        """Log-posteriors `(m,)` of assignments `(m, channels)`.

        Half of a swap's prior is on each channel; a channel whose partner shows nothing bears both halves.
        """
        n = self.count
        prior = np.take_along_axis(self.prior[None], places[..., None], axis=2)[..., 0]
        shown = np.where(places < 2 * n, places % n, np.arange(n))
        silent = np.take_along_axis(places > 2 * n, shown, axis=1) & (shown != np.arange(n))
        prior = prior + silent * self.half[np.arange(n), shown]
        return np.asarray(self.likelihoods(places) + prior.sum(axis=1))

    def steps(self, places: Index) -> Index:
        """Assignments `(m, channels)` one step away: a channel's state, or two channels' places."""
        n = self.count
        rows = [places]
        for c in range(n):
            for state in (c, n + c, 2 * n, 2 * n + 1, 2 * n + 2):
                rows.append(_with(places, {c: state}))
            if places[c] != 2 * n:
                others = (d for d in range(c) if places[d] != 2 * n)
                rows += [_with(places, {c: places[d], d: places[c]}) for d in others]
        table = np.unique(np.array(rows), axis=0)
        strips = np.where(table < 2 * n, table % n, np.where(table == 2 * n, np.arange(n), n + np.arange(n)))
        ordered = np.sort(strips, axis=1)
        return np.asarray(table[(ordered[:, 1:] != ordered[:, :-1]).all(axis=1)])

    def climbed(self, places: Index) -> Index:
        """The most probable assignment that steps upwards lead to."""
        now = float(self.scores(places[None])[0])
        while True:
            near = self.steps(places)
            scores = self.scores(near)
            top = int(scores.argmax())
            if scores[top] <= now + 1e-9:
                return places
            places, now = near[top], float(scores[top])

    def softness(self, places: Index) -> Array:
        """By how much each channel's own covariance is to grow, to bear what is left of the channel as
        Student's t with `TAIL` degrees of freedom does."""
        n = self.count
        at = np.arange(n)
        precision, total = self._integrals(places[None])
        factors = np.linalg.solve(precision[0], total[0])
        in_place = np.where(self.value[at, at] >= self.value[at, n + at], at, n + at)
        seen = np.where(places > 2 * n, in_place, places)
        bend = self.bend[at, self._bends(seen)]
        left = -2 * self.value[at, seen] - self.scale[at, seen]
        left += np.einsum("f,cfg,g->c", factors, bend, factors) - 2 * self.slope[at, seen] @ factors
        grown = np.maximum(1.0, (TAIL + left) / (TAIL + self.rank))
        return np.asarray(np.where(places == 2 * n + 1, 1.0, grown))

    def states(self, best: Index) -> tuple[ChannelStates, ...]:
        """Each channel's states with their probabilities, by what is near the `best` assignment."""
        near = self.steps(best)
        scores = self.scores(near)
        top = near[np.argsort(-scores)[1 : NEIGHBOURS + 1]]
        table = np.unique(np.concatenate([near, *(self.steps(places) for places in top)]), axis=0)
        scores = self.scores(table)
        weights = np.exp(scores - logsumexp(scores))
        channels = []
        for c, places in enumerate(table.T):
            chances: dict[State, float] = defaultdict(float)
            for place in np.unique(places):
                chances[self._state(c, int(place))] += float(weights[places == place].sum())
            channels.append(sorted(chances.items(), key=lambda entry: -entry[1]))
        return tuple(channels)

    def _state(self, c: int, place: int) -> State:
        n = self.count
        if place >= 2 * n:
            return (WEAK_STATE, DEAD, UNEXPLAINED)[place - 2 * n], None, 1
        sign = 1 if place < n else -1
        if place % n != c:
            return SWAPPED, place % n, sign
        return (WORKS if sign > 0 else REVERSED), None, sign

    def alike(self, best: Index) -> list[tuple[int, int]]:
        """Pairs of channels on strips whose exchange costs less than ALIKE of log-likelihood."""
        n = self.count
        pairs = [(a, b) for b in range(n) for a in range(b) if max(best[a], best[b]) < 2 * n]
        if not pairs:
            return []
        changed = np.array([_with(best, {a: best[b], b: best[a]}) for a, b in pairs])
        cost = self.likelihoods(best[None])[0] - self.likelihoods(changed)
        return [pair for pair, less in zip(pairs, cost < ALIKE, strict=True) if less]


@dataclass(frozen=True, eq=False)
class _Terms:
    """Of normal channels `(...)`: covariance's `inverse` `(..., rank, rank)`, log-determinant `size` `(...)`,
    its product with the strips' `shared` `(factors, strips, rank)`, and what that gives twice, `bend`."""

    inverse: Array
    size: Array
    pulled: Array
    bend: Array

    @classmethod
    def of(cls, covariance: Array, shared: Array) -> _Terms:
        """Return those of covariances `(..., strips, rank, rank)`."""
        inverse = np.asarray(np.linalg.inv(covariance), float)
        way = np.moveaxis(shared, 0, -1)  # (strips, rank, factors)
        pulled = inverse @ way
        return cls(
            inverse,
            np.asarray(np.linalg.slogdet(covariance)[1], float),
            pulled,
            np.swapaxes(way, -1, -2) @ pulled,
        )

    def at(self, off: Array) -> tuple[Array, Array]:
        """Return log-densities `(...)` at `off` `(..., rank)` without factors, and their slope in these."""
        quad = np.einsum("...a,...ab,...b->...", off, self.inverse, off)
        return np.asarray(-(self.size + quad) / 2), np.einsum("...af,...a->...f", self.pulled, off)


def _with(places: Index, changes: dict[int, int]) -> Index:
    changed = places.copy()
    changed[list(changes)] = list(changes.values())
    return changed
