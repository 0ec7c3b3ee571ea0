"""What a slip shows in: the films' outputs of a ridge and of those beside it, over short and long times.

Running means of the pairs' differences and sums and of their products, all first-order filters, so that they
are the same however the samples are cut in pieces. The features are without a unit, bounded, and the
same to either side: positive is where the ridge has been pulled to.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from skincad.base.arrays import Array, Index

SPANS = (0.25, 1.0, 3.0, 10.0, 40.0, 160.0)  # windows that a mean looks back; 160 are the load itself
KINDS = (
    "pair", "sum", "others", "others' sum", "pair^2", "sum^2", "others^2", "others' sum^2", "pair others",
    "pair sum",
)  # fmt: skip
FLOOR = 3.0  # noise rms, below which nothing is a signal
OF_SUM = 0.3  # of a sum counts as much as a pair's difference
MOST = 4.0  # of what is usual

Means = dict[str, list[Array]]


def at_rest(ridges: int) -> Array:
    """Return the filters' state before the first sample."""
    return np.zeros((len(SPANS), 1, len(KINDS) * ridges))


def means(window: int, outputs: Array, state: Array) -> tuple[Means, Array]:
    """Return by kind the value and its running means `(n, ridges)` of `outputs` `(n, ridges, 2)`, and the
    state behind them."""
    pair, total = outputs[:, :, 0] - outputs[:, :, 1], outputs[:, :, 0] + outputs[:, :, 1]
    rest, rest_sum = of_others(pair), of_others(total)
    products = [pair * pair, total * total, rest * rest, rest_sum * rest_sum, pair * rest, pair * total]
    raw = np.concatenate([pair, total, rest, rest_sum, *products], axis=1)
    rows, after = [raw], state.copy()
    for k, span in enumerate(SPANS):
        if raw.shape[0]:
            share = 1.0 / (1.0 + span * window)
            mean, after[k] = lfilter([share], [1.0, share - 1.0], raw, axis=0, zi=state[k])
            rows.append(mean)
        else:
            rows.append(raw)
    parts = [np.split(row, len(KINDS), axis=1) for row in rows]
    return {kind: [part[i] for part in parts] for i, kind in enumerate(KINDS)}, after


def of_others(values: Array) -> Array:
    """Return for each ridge the mean of the other ridges' values `(n, ridges)`; 0 for a ridge alone."""
    count = values.shape[1]
    sums = np.zeros_like(values)
    for k in range(count):
        for j in range(count):
            if j != k:
                sums[:, k] += values[:, j]
    return np.asarray(sums / max(1, count - 1))


def bounded(x: Array) -> Array:
    """Return x, gently bounded by MOST."""
    return np.asarray(x / np.sqrt(1.0 + (x / MOST) ** 2))


def beside(values: Array, side: Array, ahead: bool) -> Array:
    """Return the values of each ridge's monitored neighbour, ahead of its pull or behind; 0 without."""
    nothing = np.zeros_like(values[:, :1])
    up = np.concatenate([values[:, 1:], nothing], axis=1)
    down = np.concatenate([nothing, values[:, :-1]], axis=1)
    return np.where((side > 0) == ahead, up, down)


def features(
    window: int, noise: float, outputs: Array, state: Array, asked: Index | slice = slice(None)
) -> tuple[Array, Array, Array]:
    """Return `(n, ridges, features)` of `outputs` `(n, ridges, 2)` V, how many noise rms the pairs' last
    window had, `(n, ridges)`, both at the samples `asked`, and the state; `noise` V rms of a pair."""
    every, after = means(window, outputs, state)
    m = {kind: [part[asked] for part in parts] for kind, parts in every.items()}
    least = (FLOOR * noise) ** 2
    side = np.where(m["pair"][5] < 0, -1.0, 1.0)
    usual = {k: np.sqrt(m["pair^2"][k] + OF_SUM**2 * m["sum^2"][k] + least) for k in (3, 4, 5)}
    columns = _own(m, side, usual) + _tied(m, side, usual, least) + _neighbours(m, side, usual[4])
    columns += _sizes(m, usual, noise, least)
    return np.stack(columns, axis=2), np.sqrt(m["pair^2"][2]) / noise, after


def _own(m: Means, side: Array, usual: dict[int, Array]) -> list[Array]:
    """What a ridge and the mean of the others feel, against the usual."""
    columns = []
    for kind in ("pair", "sum", "others", "others' sum"):
        sign = side if kind in {"pair", "others"} else 1.0
        columns += [bounded(m[kind][k] * sign / usual[4]) for k in range(6)]
    columns += [bounded(m["pair"][k] * side / usual[3]) for k in (0, 1, 2)]
    return columns + [bounded(m["pair"][k] * side / usual[5]) for k in (0, 2, 5)]


def _tied(m: Means, side: Array, usual: dict[int, Array], least: float) -> list[Array]:
    """How a ridge departs from following the others, its own sum, or its own load as a ridge that slips."""
    columns = []
    for k in (3, 4, 5):
        follows = m["pair others"][k] / (m["others^2"][k] + least)
        tied = m["pair sum"][k] / (m["sum^2"][k] + least)
        for fast in (0, 2):
            columns.append(bounded((m["pair"][fast] - follows * m["others"][fast]) * side / usual[k]))
            columns.append(bounded((m["pair"][fast] - tied * m["sum"][fast]) * side / usual[k]))
        columns += [bounded(follows), bounded(tied * side)]
    load = m["pair"][6] / (np.abs(m["sum"][6]) + np.abs(m["pair"][6]) + np.sqrt(least) * 0.01)
    columns.append(load * side)
    cone = m["pair"][6] / (np.abs(m["sum"][6]) + np.sqrt(least) * 0.01)
    return columns + [bounded((m["pair"][k] - cone * m["sum"][k]) * side / usual[4]) for k in (0, 2, 3)]


def _neighbours(m: Means, side: Array, usual: Array) -> list[Array]:
    """What the monitored ridges ahead and behind feel."""
    columns = []
    for ahead in (True, False):
        columns += [bounded(beside(m["pair"][k], side, ahead) * side / usual) for k in (1, 2, 3)]
        columns += [bounded(beside(m["sum"][k], side, ahead) / usual) for k in (1, 2)]
        columns.append(beside(np.ones_like(side), side, ahead))
    return columns


def _sizes(m: Means, usual: dict[int, Array], noise: float, least: float) -> list[Array]:
    """How much is going on, in logarithms, against the noise, against before, and in what."""
    levels = [np.log(m["pair^2"][k] + least) for k in range(1, 7)]
    columns = [np.log(usual[k] / noise) / 4 for k in (3, 5)]
    columns += [(levels[k] - levels[4]) / 4 for k in (0, 1, 2, 3, 5)]
    columns += [(np.log(m["sum^2"][k] + least) - levels[k - 1]) / 4 for k in (1, 2, 4, 6)]
    columns += [(np.log(m["others^2"][k] + least) - levels[k - 1]) / 4 for k in (1, 2, 4, 6)]
    return [*columns, (np.log(m["others' sum^2"][4] + least) - levels[3]) / 4]
