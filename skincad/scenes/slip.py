"""Slip felt from the films' outputs alone: which ridge slips, and when all that is told do. No look-ahead.

A small network (one hidden layer, its weights as data) tells of each ridge how likely it slips,
by what the ridge and those beside it felt over short and long times (slip_features.py). It was fitted to the
design set of bench/exam: scenes of other skins, frictions and histories than those of the exam that scores it
(docs/detector.md). An alarm asks for more than a threshold, which is the user's choice (POINTS), and for
outputs that stand out of the noise.

Range: outputs that follow the stress-rate in their band; the more ridges are told the better, one alone warns
of a quarter of gross slips, of two fifths by early alarms. Gross slip is told when every told ridge is taken
to slip: early, where not all ridges are told.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError
from skincad.circuit.low_pass import delay
from skincad.scenes import slip_features
from skincad.scenes.slip_features import features

WINDOW = 3.5  # of the low-pass's delay; assumption
FEWEST = 3  # samples of a window
SEEN = 5.0  # noise rms of a pair, a window's mean, below which nothing is told: noise alone reaches 2.9

INCIPIENT, GROSS = "incipient slip", "gross slip"


@dataclass(frozen=True)
class OperatingPoint:
    """A choice of alarms: a network's `file`, told at the logarithm of odds `threshold`, until `back` below.

    These by cross-validation on the design set of bench/exam. On its exam, behind a transimpedance amplifier:
    the share of gross slips `warned` of, with its 95 % interval `between`, and false alarms `false` a minute
    of handling. While a load is held there are none.
    """

    file: str
    threshold: float
    back: float
    warned: float
    between: tuple[float, float]
    false: float


SURE, EARLY = "sure", "early"
# Of thresholds on the design set these cost least where a slip missed is as bad as 5 and as 20 false alarms.
POINTS = {
    SURE: OperatingPoint("slip_weights.toml", 1.5, 2.0, 0.66, (0.56, 0.75), 17.0),
    EARLY: OperatingPoint("slip_weights_early.toml", 1.25, 1.0, 0.86, (0.77, 0.91), 33.0),
}


@dataclass(frozen=True)
class Detector:
    """`window` samples, `noise` V rms of a pair, alarm at the logarithm of odds `threshold`; `alarms` of
    POINTS, whose network it is."""

    window: int
    noise: float
    threshold: float = POINTS[SURE].threshold
    alarms: str = SURE

    def __post_init__(self) -> None:
        if not (math.isfinite(self.noise) and self.noise > 0):
            raise InputError("noise", "must be above 0 V and finite", self.noise)
        if not math.isfinite(self.threshold):
            raise InputError("threshold", "must be finite", self.threshold)


@dataclass(frozen=True)
class Event:
    """At sample `index` `ridge` of the told ones (from 0) begins to slip, or (None) the last of them does."""

    kind: str
    ridge: int | None
    index: int


@dataclass(frozen=True, eq=False)
class Memory:
    """All that the detector keeps: the running means' state; which ridges are taken to slip; how many samples
    were fed."""

    means: Array
    slipping: Mask
    count: int


@dataclass(frozen=True, eq=False)
class Weights:
    """The network: of `(features,)` to `(hidden,)`, and of these to one."""

    into: Array
    bias: Array
    out: Array
    base: float


@cache
def weights(alarms: str = SURE) -> Weights:
    """Return a network's weights as fitted by bench/exam/fitting.py; the head of its file says to what."""
    table = tomllib.loads((Path(__file__).parent / POINTS[alarms].file).read_text())
    into = np.ascontiguousarray(np.array(table["into"]).T)
    return Weights(into, np.array(table["bias"]), np.array(table["out"]), float(table["base"]))


def detector(
    rate: float, bandwidth: float, noise: float, threshold: float | None = None, alarms: str = SURE
) -> Detector:
    """Return the detector of outputs at `rate` Hz behind the low-pass of `bandwidth` Hz; its threshold is
    that of `alarms`, one of POINTS, if not given."""
    window = max(FEWEST, math.ceil(WINDOW * delay(bandwidth) * rate))
    return Detector(window, noise, POINTS[alarms].threshold if threshold is None else threshold, alarms)


def at_rest(ridges: int) -> Memory:
    """Return the state before the first sample."""
    return Memory(slip_features.at_rest(ridges), np.zeros(ridges, bool), 0)


def fed(d: Detector, state: Memory, outputs: Array) -> tuple[list[Event], Memory]:
    """Return the events of `outputs` `(n, ridges, 2)` V (S1, S2), and the state behind them; n may be 1."""
    odds, means = statistic(d, state, outputs)
    slipping = taken(d, state.slipping, odds)
    before: Mask = np.concatenate([state.slipping[None], slipping])
    rises = slipping & ~before[:-1]
    every: Mask = np.asarray(before.all(axis=1))
    events = [Event(INCIPIENT, int(r), state.count + int(i)) for i, r in np.argwhere(rises)]
    events += [Event(GROSS, None, state.count + int(i)) for i in np.flatnonzero(every[1:] & ~every[:-1])]
    after = Memory(means, before[-1], state.count + outputs.shape[0])
    return sorted(events, key=lambda event: event.index), after


def taken(d: Detector, before: Mask, odds: Array) -> Mask:
    """Return when each ridge is taken to slip `(n, ridges)`: from the threshold on until `back` below it."""
    turns = np.where(odds > d.threshold, 1, np.where(odds < d.threshold - POINTS[d.alarms].back, -1, 0))
    turns = np.concatenate([np.where(before, 1, -1)[None], turns])
    last = np.maximum.accumulate(np.where(turns != 0, np.arange(turns.shape[0])[:, None], 0), axis=0)
    return np.asarray(np.take_along_axis(turns, last, axis=0)[1:] > 0)


def statistic(d: Detector, state: Memory, outputs: Array) -> tuple[Array, Array]:
    """Return the logarithm of the odds that each ridge slips `(n, ridges)`, and the means' state.

    One sample is multiplied at a time, so that it is the same however the samples are cut in pieces.
    """
    felt, loud, after = features(d.window, d.noise, outputs, state.means)
    w = weights(d.alarms)
    hidden = np.tanh(np.matmul(felt[:, :, None, :], w.into) + w.bias)
    odds = np.matmul(hidden, w.out[:, None])[:, :, 0, 0] + w.base
    return np.where(loud > SEEN, odds, np.minimum(odds, d.threshold - POINTS[d.alarms].back - 1.0)), after


@dataclass(frozen=True)
class Score:
    """Alarms against the true slips: `hits` and `missed` of these, `false` alarms, and `misnamed` ones, which
    name a ridge that sticks while another slips; `lead` s by told ridge and `gross_lead` s from the alarm to
    gross slip, None without one of them."""

    hits: int
    missed: int
    false: int
    misnamed: int
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
    An alarm is false where no told ridge slips, misnamed where only another one does.
    An alarm of gross slip is false where none follows. Lead time runs from the first true alarm of the run
    that lasts to gross slip.
    """
    w = d.window
    hits = missed = false = misnamed = 0
    every = [(a, b) for each in runs for a, b in each]
    leads: list[float | None] = []
    for told, mine in enumerate(runs):
        alarms = [event.index for event in events if event.ridge == told]
        asked = [(a, b) for a, b in mine if b - a + 1 >= w]
        found = [next((i for i in alarms if a - w <= i <= b + w), None) for a, b in asked]
        hits += sum(at is not None for at in found)
        missed += sum(at is None for at in found)
        untrue = [i for i in alarms if not any(a - w <= i <= b + w for a, b in mine)]
        elsewhere = sum(any(a - w <= i <= b + w for a, b in every) for i in untrue)
        misnamed, false = misnamed + elsewhere, false + len(untrue) - elsewhere
        last = [at for (a, b), at in zip(asked, found, strict=True) if gross is not None and a <= gross <= b]
        leads.append(_lead(time, gross, last[-1] if last else None))
    whole = [event.index for event in events if event.kind == GROSS]
    early = [i for i in whole if gross is not None and i <= gross + w]
    false += len(whole) - len(early)
    ahead = _lead(time, gross, early[-1] if early else None)
    return Score(hits, missed, false, misnamed, tuple(leads), ahead)


def _lead(time: Array, gross: int | None, alarm: int | None) -> float | None:
    return None if gross is None or alarm is None else float(time[gross] - time[alarm])


def report(
    time: Array,
    outputs: dict[str, dict[str, list[float]]],
    noise: float,
    bandwidth: float,
    runs: Sequence[Sequence[Sequence[int]]],
    gross: int | None,
    alarms: str = SURE,
) -> dict[str, Any]:
    """Return the keys `events`, `lead_time_s`, the longest of these, `event_score` and, of outputs,
    `detector`, of a march's outputs by ridge, S1 and S2.

    `noise` V rms of one strip; `runs` by ridge from 1; `alarms` one of POINTS.
    """
    names, point = list(outputs), POINTS[alarms]
    if not names or time.size < 2:
        nothing = dict.fromkeys(("longest_lead_time_s", "event_score"))
        return {"events": [], "lead_time_s": {}, **nothing}
    d = detector(1 / float(time[1] - time[0]), bandwidth, math.sqrt(2) * noise, alarms=alarms)
    values = np.stack([np.stack([outputs[r]["S1"], outputs[r]["S2"]], axis=1) for r in names], axis=1)
    events, _ = fed(d, at_rest(len(names)), values)
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
        "event_score": {key: getattr(found, key) for key in ("hits", "missed", "false", "misnamed")},
        "detector": {
            "alarms": alarms,
            "share_of_gross_slips_warned_of": point.warned,
            "between": list(point.between),
            "false_alarms_per_minute_of_handling": point.false,
        },
    }
