"""Slip felt from the films' outputs alone: which ridge slips, and when all that is told do. No look-ahead.

While a ridge sticks, its pair's output (S1 - S2, about the stress-rate) follows the load; as its neighbours
slip, it takes their load on; when it slips itself, the output turns round within the low-pass's own time. So
an alarm asks for a reversal: opposite signs a window apart, both large against the noise, against the ridge's
recent outputs, against S1 + S2 (a change of normal force moves the sum, a slip the difference) and against
what the other ridges do at the time (a load that turns round takes all of them with it).

Range: outputs that follow the stress-rate in their band; two ridges at least, since one alone cannot tell a
slip from a load that turns round. Two ridges that slip within one window and the same way hide each other.
Gross slip is told when every told ridge is taken to slip: early, where not all ridges are told.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter1d

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError
from skincad.circuit.low_pass import delay

# all four chosen on yamada-2002-slip, -stage, hold and pulls and presses of 1 to 6 ms (bench/
# table_detector): measured there, assumptions elsewhere
WINDOW = 3.5  # of the low-pass's delay
OF_RECENT = 0.1  # of the largest output of the last MEMORY windows
OF_SUM = 1 / 6  # of |S1 + S2|
OF_OTHERS = 3.0  # of the other ridges' median change in the same direction
MEMORY = 10  # windows
FEWEST = 3  # samples of a window
THRESHOLD = 4.0  # noise rms of a pair

INCIPIENT, GROSS = "incipient slip", "gross slip"


@dataclass(frozen=True)
class Detector:
    """`window` samples, `noise` V rms of a pair, alarm at `threshold` times that."""

    window: int
    noise: float
    threshold: float = THRESHOLD

    def __post_init__(self) -> None:
        if not (math.isfinite(self.noise) and self.noise > 0):
            raise InputError("noise", "must be above 0 V and finite", self.noise)
        if not (math.isfinite(self.threshold) and self.threshold > 0):
            raise InputError("threshold", "must be above 0 times the noise and finite", self.threshold)


@dataclass(frozen=True)
class Event:
    """At sample `index` `ridge` of the told ones (from 0) begins to slip, or (None) the last of them does."""

    kind: str
    ridge: int | None
    index: int


@dataclass(frozen=True, eq=False)
class Memory:
    """All that the detector keeps: the pairs' last outputs `(memory, ridges)`, newest last; who was above the
    threshold; the sign of the output since a ridge slips, 0 while it sticks; how many samples were fed."""

    recent: Array
    above: Mask
    slipping: Array
    count: int


def detector(rate: float, bandwidth: float, noise: float, threshold: float = THRESHOLD) -> Detector:
    """Return the detector of outputs at `rate` Hz behind the low-pass of `bandwidth` Hz."""
    return Detector(max(FEWEST, math.ceil(WINDOW * delay(bandwidth) * rate)), noise, threshold)


def at_rest(d: Detector, ridges: int) -> Memory:
    """Return the state before the first sample."""
    return Memory(np.zeros((MEMORY * d.window, ridges)), np.zeros(ridges, bool), np.zeros(ridges), 0)


def fed(d: Detector, state: Memory, outputs: Array) -> tuple[list[Event], Memory]:
    """Return the events of `outputs` `(n, ridges, 2)` V (S1, S2), and the state behind them; n may be 1."""
    pair = outputs[:, :, 0] - outputs[:, :, 1]
    above = np.concatenate([state.above[None], statistic(d, state, outputs) > d.threshold])
    rises = above[1:] & ~above[:-1]
    told = [_slipping(d, pair[:, r], rises[:, r], float(sign)) for r, sign in enumerate(state.slipping)]
    every: Mask = np.asarray(np.stack([mask for mask, _ in told], axis=1).all(axis=1))
    first = every & ~np.concatenate([[(state.slipping != 0).all()], every[:-1]])
    events = [Event(INCIPIENT, int(r), state.count + int(i)) for i, r in np.argwhere(rises)]
    events += [Event(GROSS, None, state.count + int(i)) for i in np.flatnonzero(first)]
    recent = np.concatenate([state.recent, pair])[-state.recent.shape[0] :]
    after = Memory(recent, above[-1], np.array([sign for _, sign in told]), state.count + pair.shape[0])
    return sorted(events, key=lambda event: event.index), after


def _slipping(d: Detector, pair: Array, rises: Mask, sign: float) -> tuple[Mask, float]:
    """Return when a ridge is taken to slip `(n,)`, and its output's sign at the end, 0 while it sticks.

    From each alarm on, until its output is no longer of that sign: at rest, or turned back, it sticks again.
    """
    found = np.zeros(pair.size, bool)
    for start, end in pairwise([-1, *np.flatnonzero(rises).tolist(), pair.size]):
        if start >= 0:
            sign, found[start] = float(np.sign(pair[start])), True
        gone = sign * pair[start + 1 : end] < d.threshold * d.noise
        last = start + 1 + int(gone.argmax()) if gone.any() else end
        found[start + 1 : last] = sign != 0
        sign = 0.0 if last < end else sign
    return found, sign


def statistic(d: Detector, state: Memory, outputs: Array) -> Array:
    """Return by how many noise rms each sample is a reversal of its ridge alone, `(n, ridges)`.

    It hangs on the last MEMORY windows alone, so that it is the same however the samples are cut in pieces.
    """
    pair, total = outputs[:, :, 0] - outputs[:, :, 1], outputs.sum(axis=2)
    joined = np.concatenate([state.recent, pair])
    memory = state.recent.shape[0]
    before = joined[memory - d.window : -d.window]
    # the largest of each sample and its memory: a centred filter, read where its window ends at the sample
    first = (memory + 1) // 2
    largest = maximum_filter1d(np.abs(joined), memory + 1, axis=0)[first : first + pair.shape[0]]
    turned = np.where(pair * before < 0, np.minimum(np.abs(pair), np.abs(before)), 0.0)
    alike = np.maximum(others(pair - before) * np.sign(pair), 0.0)
    return np.asarray((turned - OF_RECENT * largest - OF_SUM * np.abs(total) - OF_OTHERS * alike) / d.noise)


def others(change: Array) -> Array:
    """Return for each ridge the median of the other ridges' values `(n, ridges)`; 0 for a ridge alone."""
    count = change.shape[1]
    if count == 1:
        return np.zeros_like(change)
    return np.stack([np.median(np.delete(change, k, axis=1), axis=1) for k in range(count)], axis=1)


@dataclass(frozen=True)
class Score:
    """Alarms against the true slips: `hits` and `missed` of these, `false` alarms; `lead` s by told ridge and
    `gross_lead` s from the alarm to gross slip, None without one of them."""

    hits: int
    missed: int
    false: int
    lead: tuple[float | None, ...]
    gross_lead: float | None


def score(
    d: Detector,
    events: Sequence[Event],
    time: Array,
    runs: Sequence[Sequence[Sequence[int]]],
    gross: int | None,
) -> Score:
    """Return how `events` meet the true `runs` of slip, [from, to] by told ridge.

    A ridge slips while all its touching points do. A run shorter than the window is not asked for. An alarm
    is true within a run or a window beside it (before: its first points slip already); each run counts once.
    An alarm of gross slip is false where none follows. Lead time runs from the first true alarm of the run
    that lasts to gross slip.
    """
    w = d.window
    hits = missed = false = 0
    leads: list[float | None] = []
    for told, mine in enumerate(runs):
        alarms = [event.index for event in events if event.ridge == told]
        asked = [(a, b) for a, b in mine if b - a + 1 >= w]
        found = [next((i for i in alarms if a - w <= i <= b + w), None) for a, b in asked]
        hits += sum(at is not None for at in found)
        missed += sum(at is None for at in found)
        false += sum(not any(a - w <= i <= b + w for a, b in mine) for i in alarms)
        last = [at for (a, b), at in zip(asked, found, strict=True) if gross is not None and a <= gross <= b]
        leads.append(_lead(time, gross, last[-1] if last else None))
    whole = [event.index for event in events if event.kind == GROSS]
    early = [i for i in whole if gross is not None and i <= gross + w]
    false += len(whole) - len(early)
    return Score(hits, missed, false, tuple(leads), _lead(time, gross, early[-1] if early else None))


def _lead(time: Array, gross: int | None, alarm: int | None) -> float | None:
    return None if gross is None or alarm is None else float(time[gross] - time[alarm])


def report(
    time: Array,
    outputs: dict[str, dict[str, list[float]]],
    noise: float,
    bandwidth: float,
    runs: Sequence[Sequence[Sequence[int]]],
    gross: int | None,
) -> dict[str, Any]:
    """Return the keys `events`, `lead_time_s`, the longest of these and `event_score` of a march's outputs by
    ridge, S1 and S2.

    `noise` V rms of one strip; `runs` by ridge from 1.
    """
    names = list(outputs)
    if not names or time.size < 2:
        return {"events": [], "lead_time_s": {}, "longest_lead_time_s": None, "event_score": None}
    d = detector(1 / float(time[1] - time[0]), bandwidth, math.sqrt(2) * noise)
    values = np.stack([np.stack([outputs[r]["S1"], outputs[r]["S2"]], axis=1) for r in names], axis=1)
    events, _ = fed(d, at_rest(d, len(names)), values)
    found = score(d, events, time, [runs[int(r) - 1] for r in names], gross)
    return {
        "events": [
            {
                "kind": event.kind,
                "ridge": None if event.ridge is None else int(names[event.ridge]),
                "step": event.index,
                "time_s": float(time[event.index]),
            }
            for event in events
        ],
        "lead_time_s": {**dict(zip(names, found.lead, strict=True)), "all": found.gross_lead},
        "longest_lead_time_s": max((lead for lead in found.lead if lead is not None), default=None),
        "event_score": {"hits": found.hits, "missed": found.missed, "false": found.false},
    }
