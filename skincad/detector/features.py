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

PAIR, SUM, OTHERS, OTHERS_SUM, PAIR2, SUM2, OTHERS2, OTHERS_SUM2, PAIR_OTHERS, PAIR_SUM = range(len(KINDS))
COUNT = 80  # features


def at_rest(ridges: int) -> Array:
    """Return the filters' state before the first sample."""
    return np.zeros((len(SPANS), 1, len(KINDS) * ridges))


def means(window: int, outputs: Array, state: Array) -> tuple[dict[str, Array], Array]:
    """Return by kind the value and its running means `(1 + spans, n, ridges)` of `outputs` `(n, ridges, 2)`,
    and the state behind them."""
    every, after = _means(window, outputs, state)
    return {kind: every[:, place] for place, kind in enumerate(KINDS)}, after


def _means(window: int, outputs: Array, state: Array) -> tuple[Array, Array]:
    """The same of all kinds, `(1 + spans, kinds, n, ridges)`."""
    count, ridges, _ = outputs.shape
    every = np.empty((1 + len(SPANS), len(KINDS), count, ridges))
    raw, after = every[0], state.copy()
    np.subtract(outputs[:, :, 0], outputs[:, :, 1], out=raw[PAIR])
    np.add(outputs[:, :, 0], outputs[:, :, 1], out=raw[SUM])
    raw[OTHERS : OTHERS_SUM + 1] = of_others(raw[PAIR : SUM + 1])
    np.multiply(raw[PAIR : OTHERS_SUM + 1], raw[PAIR : OTHERS_SUM + 1], out=raw[PAIR2 : OTHERS_SUM2 + 1])
    np.multiply(raw[PAIR], raw[[OTHERS, SUM]], out=raw[PAIR_OTHERS : PAIR_SUM + 1])
    for k, span in enumerate(SPANS if count else ()):
        share = 1.0 / (1.0 + span * window)
        before = state[k].reshape(len(KINDS), 1, ridges)
        every[k + 1], end = lfilter([share], [1.0, share - 1.0], raw, axis=1, zi=before)
        after[k] = end.reshape(1, -1)
    return every, after


def of_others(values: Array) -> Array:
    """Return for each ridge the mean of the other ridges' values `(..., ridges)`; 0 for a ridge alone."""
    count = values.shape[-1]
    sums = np.zeros_like(values)
    for k in range(count):  # one after the other, so that each sum has the same bits in blocks of any size
        sums[..., :k] += values[..., k : k + 1]
        sums[..., k + 1 :] += values[..., k : k + 1]
    return np.asarray(sums / max(1, count - 1))


def bounded(x: Array) -> Array:
    """Return x, gently bounded by MOST."""
    return np.asarray(x / np.sqrt(1.0 + (x / MOST) ** 2))


def beside(values: Array, side: Array, ahead: bool) -> Array:
    """Return the values `(..., ridges)` of each ridge's monitored neighbour, ahead of its pull or behind; 0
    without."""
    up, down = np.zeros_like(values), np.zeros_like(values)
    up[..., :-1], down[..., 1:] = values[..., 1:], values[..., :-1]
    return np.where((side > 0) == ahead, up, down)


def features(
    window: int, noise: float, outputs: Array, state: Array, asked: Index | slice = slice(None)
) -> tuple[Array, Array, Array]:
    """Return `(n, ridges, features)` of `outputs` `(n, ridges, 2)` V, how many noise rms the pairs' last
    window had, `(n, ridges)`, both at the samples `asked`, and the state; `noise` V rms of a pair."""
    every, after = _means(window, outputs, state)
    m = np.ascontiguousarray(every[:, :, asked]).swapaxes(0, 1)  # by kind, then by span
    least = (FLOOR * noise) ** 2
    side = np.where(m[PAIR, 5] < 0, -1.0, 1.0)
    usual = np.sqrt(m[PAIR2, 3:6] + OF_SUM**2 * m[SUM2, 3:6] + least)  # of the spans 3, 4 and 5
    columns = np.empty((COUNT, *side.shape))
    _fill_own(columns[:30], m, side, usual)
    _fill_tied(columns[30:52], m, side, usual, least)
    _fill_neighbours(columns[52:64], m, side, usual[1])
    _fill_sizes(columns[64:], m, usual, noise, least)
    for part in (columns[:48], columns[49:57], columns[58:63]):  # all that is no share and no logarithm
        part[...] = bounded(part)
    return np.ascontiguousarray(columns.transpose(1, 2, 0)), np.sqrt(m[PAIR2, 2]) / noise, after


def _fill_own(columns: Array, m: Array, side: Array, usual: Array) -> None:
    """What a ridge and the mean of the others feel, against the usual."""
    pulled = m[PAIR, :6] * side
    columns[0:6] = pulled / usual[1]
    columns[6:12] = m[SUM, :6] / usual[1]
    columns[12:18] = m[OTHERS, :6] * side / usual[1]
    columns[18:24] = m[OTHERS_SUM, :6] / usual[1]
    columns[24:27] = pulled[:3] / usual[0]
    columns[27:30] = pulled[[0, 2, 5]] / usual[2]


def _fill_tied(columns: Array, m: Array, side: Array, usual: Array, least: float) -> None:
    """How a ridge departs from following the others, its own sum, or its own load as a ridge that slips."""
    follows = m[PAIR_OTHERS, 3:6] / (m[OTHERS2, 3:6] + least)
    tied = m[PAIR_SUM, 3:6] / (m[SUM2, 3:6] + least)
    spans = columns[:18].reshape(3, 6, *side.shape)
    for place, fast in ((0, 0), (2, 2)):
        spans[:, place] = (m[PAIR, fast] - follows * m[OTHERS, fast]) * side / usual
        spans[:, place + 1] = (m[PAIR, fast] - tied * m[SUM, fast]) * side / usual
    spans[:, 4], spans[:, 5] = follows, tied * side
    pressed = np.abs(m[SUM, 6])
    columns[18] = m[PAIR, 6] / (pressed + np.abs(m[PAIR, 6]) + np.sqrt(least) * 0.01) * side
    cone = m[PAIR, 6] / (pressed + np.sqrt(least) * 0.01)
    for place, k in enumerate((0, 2, 3), 19):
        columns[place] = (m[PAIR, k] - cone * m[SUM, k]) * side / usual[1]


def _fill_neighbours(columns: Array, m: Array, side: Array, usual: Array) -> None:
    """What the monitored ridges ahead and behind feel."""
    there = np.ones_like(side)
    for place, ahead in ((0, True), (6, False)):
        columns[place : place + 3] = beside(m[PAIR, 1:4], side, ahead) * side / usual
        columns[place + 3 : place + 5] = beside(m[SUM, 1:3], side, ahead) / usual
        columns[place + 5] = beside(there, side, ahead)


def _fill_sizes(columns: Array, m: Array, usual: Array, noise: float, least: float) -> None:
    """How much is going on, in logarithms, against the noise, against before, and in what."""
    levels = np.log(m[PAIR2, 1:] + least)
    columns[:2] = np.log(usual[::2] / noise) / 4
    columns[2:7] = (levels[[0, 1, 2, 3, 5]] - levels[4]) / 4
    some, before = [1, 2, 4, 6], [0, 1, 3, 5]
    columns[7:11] = (np.log(m[SUM2][some] + least) - levels[before]) / 4
    columns[11:15] = (np.log(m[OTHERS2][some] + least) - levels[before]) / 4
    columns[15] = (np.log(m[OTHERS_SUM2, 4] + least) - levels[3]) / 4
