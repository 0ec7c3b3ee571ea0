"""Slip felt from the films' outputs alone: which ridge slips, and whether gross slip is ahead. No look-ahead.

Two small networks (one hidden layer each, their weights as data) hear what each monitored ridge and those
beside it felt over short and long times (slip_features.py). One tells of each ridge how likely it slips. The
other tells how likely gross slip is ahead, by the mean of what it says of each ridge. They were fitted to the
design set of bench/exam: scenes of other skins, frictions and histories than those of the exam that scores
them (docs/understand/detector.md). An alarm asks for more than a threshold, which is the user's choice
(POINTS), and for outputs that stand out of the noise.

Range: outputs that follow the stress-rate in their band; more monitored ridges are better. Neither network
knows friction or the plate's forces: a pull that eases just before gross slip feels like one that goes on.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from skincad.base.arrays import Array, Index, Mask
from skincad.base.errors import InputError
from skincad.circuit.state import delay
from skincad.scenes import slip_features
from skincad.scenes.slip_features import features

WINDOW = 3.5  # of the low-pass's delay; assumption
FEWEST = 3  # samples of a window
SEEN = 5.0  # noise rms of a pair, a window's mean, below which there is no alarm: noise alone reaches 2.9

INCIPIENT, AHEAD = "incipient slip", "gross slip ahead"


@dataclass(frozen=True)
class OperatingPoint:
    """A choice of alarms: a ridge is told to slip above the logarithm of odds `threshold`, gross slip to be
    ahead above `warning`, until BACK below.

    These by cross-validation on the design set of bench/exam. On its exam, behind a transimpedance amplifier
    with all ridges monitored: the share of gross slips `warned` of, with its 95 % interval `between`, and
    false warnings a minute of handling, all (`false`) and those while nothing slips (`idle`). While a load is
    held there are none.
    """

    threshold: float
    warning: float
    warned: float
    between: tuple[float, float]
    false: float
    idle: float


BACK = 1.0
SURE, EARLY = "sure", "early"
POINTS = {
    SURE: OperatingPoint(
        threshold=4.0, warning=2.5, warned=0.57, between=(0.50, 0.64), false=77.0, idle=13.0
    ),
    EARLY: OperatingPoint(
        threshold=2.5, warning=1.25, warned=0.70, between=(0.63, 0.77), false=196.0, idle=54.0
    ),
}
RIDGES, SKIN = "slip_weights_ridges.toml", "slip_weights_skin.toml"


@dataclass(frozen=True)
class Detector:
    """`window` samples, `noise` V rms of a pair; alarms at the logarithms of odds `threshold` and `warning`,
    those of SURE if not given."""

    window: int
    noise: float
    threshold: float = POINTS[SURE].threshold
    warning: float = POINTS[SURE].warning

    def __post_init__(self) -> None:
        if not (math.isfinite(self.noise) and self.noise > 0):
            raise InputError("noise", "must be above 0 V and finite", self.noise)
        for key in ("threshold", "warning"):
            if not math.isfinite(getattr(self, key)):
                raise InputError(key, "must be finite", getattr(self, key))


@dataclass(frozen=True)
class Event:
    """At sample `index` `ridge` of the monitored (from 0) begins to slip, or (None) gross slip is ahead."""

    kind: str
    ridge: int | None
    index: int


@dataclass(frozen=True, eq=False)
class Memory:
    """All that the detector keeps: the running means' state; which ridges are taken to slip, and last whether
    gross slip is ahead `(ridges + 1,)`; how many samples were fed."""

    means: Array
    told: Mask
    count: int


@dataclass(frozen=True, eq=False)
class Weights:
    """The network: of `(features,)` to `(hidden,)`, and of these to one."""

    into: Array
    bias: Array
    out: Array
    base: float


@cache
def weights(file: str) -> Weights:
    """Return a network's weights as fitted by bench/exam/fitting.py; the head of its file says to what."""
    table = tomllib.loads((Path(__file__).parent / file).read_text())
    into = np.ascontiguousarray(np.array(table["into"]).T)
    return Weights(into, np.array(table["bias"]), np.array(table["out"]), float(table["base"]))


def detector(
    rate: float, bandwidth: float, noise: float, threshold: float | None = None, alarms: str = SURE
) -> Detector:
    """Return the detector of outputs at `rate` Hz behind the low-pass of `bandwidth` Hz; its `threshold` of a
    ridge is that of `alarms`, one of POINTS, if not given."""
    window, point = max(FEWEST, math.ceil(WINDOW * delay(bandwidth) * rate)), POINTS[alarms]
    return Detector(window, noise, point.threshold if threshold is None else threshold, point.warning)


def at_rest(ridges: int) -> Memory:
    """Return the state before the first sample."""
    return Memory(slip_features.at_rest(ridges), np.zeros(ridges + 1, bool), 0)


def fed(d: Detector, state: Memory, outputs: Array) -> tuple[list[Event], Memory]:
    """Return the events of `outputs` `(n, ridges, 2)` V (S1, S2), and the state behind them; n may be 1."""
    odds, means = statistic(d, state, outputs)
    levels = np.append(np.full(odds.shape[1] - 1, d.threshold), d.warning)
    told = taken(state.told, odds, levels, BACK)
    before: Mask = np.concatenate([state.told[None], told])
    rises = np.argwhere(told & ~np.asarray(before[:-1]))
    events = []
    for sample, place in rises:
        ridge = None if place == odds.shape[1] - 1 else int(place)
        events.append(Event(AHEAD if ridge is None else INCIPIENT, ridge, state.count + int(sample)))
    return events, Memory(means, before[-1], state.count + outputs.shape[0])


def taken(before: Mask, odds: Array, threshold: Array | float, back: float) -> Mask:
    """Return when each of odds `(n, m)` is taken to be so: from its threshold on until `back` below it."""
    turns = np.where(odds > threshold, 1, np.where(odds < np.subtract(threshold, back), -1, 0))
    turns = np.concatenate([np.where(before, 1, -1)[None], turns])
    last = np.maximum.accumulate(np.where(turns != 0, np.arange(turns.shape[0])[:, None], 0), axis=0)
    return np.asarray(np.take_along_axis(turns, last, axis=0)[1:] > 0)


def statistic(d: Detector, state: Memory, outputs: Array) -> tuple[Array, Array]:
    """Return the logarithms of the odds that each ridge slips, and last that gross slip is ahead
    `(n, ridges + 1)`, and the means' state.

    One sample is multiplied at a time, so that it is the same however the samples are cut in pieces.
    """
    felt, loud, after = features(d.window, d.noise, outputs, state.means)
    each, whole = (_odds(weights(file), felt) for file in (RIDGES, SKIN))
    odds = np.concatenate([each, _mean(whole)[:, None]], axis=1)
    seen = np.concatenate([loud > SEEN, np.any(loud > SEEN, axis=1, keepdims=True)], axis=1)
    return np.where(seen, odds, np.minimum(odds, min(d.threshold, d.warning) - BACK - 1.0)), after


def _odds(w: Weights, felt: Array) -> Array:
    hidden = np.tanh(np.matmul(felt[:, :, None, :], w.into) + w.bias)
    return np.asarray(np.matmul(hidden, w.out[:, None])[:, :, 0, 0] + w.base)


def _mean(values: Array) -> Array:
    """The mean of each row, added one after the other: the same for any number of rows."""
    total = np.zeros(values.shape[0])
    for column in values.T:
        total += column
    return np.asarray(total / max(1, values.shape[1]))


# Why an alarm is no true warning of gross slip
PASSING = "the slip ends before gross slip"
MISNAMED = "another ridge slips"
NOTHING = "no monitored ridge slips"
NOT_AHEAD = "no ridge slips until gross slip"


@dataclass(frozen=True)
class Score:
    """Alarms against the true slips: `hits` and `missed` of these; by event why it is no true warning of
    gross slip (`reasons`), "" of a true one; s to gross slip from the first true alarm of each monitored
    ridge (`lead`) and of the skin (`gross_lead`), None without one of them."""

    hits: int
    missed: int
    reasons: tuple[str, ...]
    lead: tuple[float | None, ...]
    gross_lead: float | None

    @property
    def false(self) -> int:
        """Number of alarms of a ridge's slip where none is."""
        return self.reasons.count(NOTHING)

    @property
    def misnamed(self) -> int:
        """Number of alarms that name a ridge that sticks while another slips."""
        return self.reasons.count(MISNAMED)


def score(
    d: Detector,
    events: Sequence[Event],
    time: Array,
    runs: Sequence[Sequence[Sequence[int]]],
    gross: int | None,
    begun: int | None = None,
) -> Score:
    """Return how `events` meet the true `runs` of slip, [from, to] by monitored ridge; `begun` is the sample
    at which the first slip of any ridge begins that lasts until gross slip.

    A ridge slips while all its touching points do. A run shorter than the window is not asked for; each other
    counts once, as a hit where an alarm of its ridge lies in it or within a window beside it (before: its
    first points slip already). An alarm warns of gross slip truly where the ridge that it names, or any where
    it names none, is in the run that lasts until then, or within a window before it; else falsely, however
    much slips at the time. Lead time runs from the first true one of a run that is asked for.
    """
    w = d.window
    last = [
        next(((a, b) for a, b in ridge_runs if gross is not None and a <= gross <= b), None)
        for ridge_runs in runs
    ]
    reasons = []
    for event in events:
        near = [any(_beside(event.index, run, w) for run in ridge_runs) for ridge_runs in runs]
        if event.ridge is None:
            reasons.append("" if begun is not None and event.index >= begun - w else NOT_AHEAD)
        elif _beside(event.index, last[event.ridge], w):
            reasons.append("")
        else:
            reasons.append(PASSING if near[event.ridge] else MISNAMED if any(near) else NOTHING)

    def first(ridge: int | None) -> float | None:
        pairs = zip(events, reasons, strict=True)
        true = [event.index for event, reason in pairs if event.ridge == ridge and not reason]
        return float(time[gross] - time[true[0]]) if true and gross is not None else None

    long_runs = [[run for run in ridge_runs if run[1] - run[0] + 1 >= w] for ridge_runs in runs]
    heard = [
        any(event.ridge == ridge and _beside(event.index, run, w) for event in events)
        for ridge, ridge_runs in enumerate(long_runs)
        for run in ridge_runs
    ]
    long = [run is not None and run[1] - run[0] + 1 >= w for run in last]
    leads = tuple(first(ridge) if long[ridge] else None for ridge in range(len(runs)))
    return Score(sum(heard), len(heard) - sum(heard), tuple(reasons), leads, first(None))


def _beside(sample: int, run: Sequence[int] | None, window: int) -> bool:
    """Whether a sample lies in a run of slip, or within a window beside it."""
    return run is not None and run[0] - window <= sample <= run[1] + window


def report(
    time: Array,
    outputs: dict[str, dict[str, list[float]]],
    noise: float,
    bandwidth: float,
    runs: Sequence[Sequence[Sequence[int]]],
    gross: int | None,
    alarms: str = SURE,
    even: Index | None = None,
    noises: Iterable[Array] = (),
) -> dict[str, Any]:
    """Return the keys `events`, `lead_time_s`, the longest of these and the warning's, `warned_share` of the
    runs with this and other noise in which all monitored ridges warn, `event_score`, which counts
    slips and alarms of slips, and, of outputs, `warning_score`, which counts warnings of gross slip,
    and `detector`, of a march's outputs by ridge, S1 and S2.

    `noise` V rms of one strip; `runs` by ridge from 1; `alarms` one of POINTS. The detector's samples are the
    steps `even`, equally spaced; all steps if not given. Each of `noises` `(steps + 1, ridges, 2)` V makes
    the outputs those of another seed: with some, `lead_time_by_noise` has the leads' spread.
    """
    names, point = list(outputs), POINTS[alarms]
    at = np.arange(time.size) if even is None else even[even < time.size]
    if not names or at.size < 2:
        nothing = dict.fromkeys(("longest_lead_time_s", "warning_lead_time_s", "warned_share", "event_score"))
        return {"events": [], "lead_time_s": {}, **nothing}
    d = detector(1 / float(time[at[1]] - time[at[0]]), bandwidth, math.sqrt(2) * noise, alarms=alarms)
    values = np.stack([np.stack([outputs[r]["S1"], outputs[r]["S2"]], axis=1) for r in names], axis=1)
    # runs and gross slip in samples; what happens between two of them is put at the later one
    sampled = [np.searchsorted(at, np.array(runs[int(r) - 1], dtype=int)).tolist() for r in names]
    whole, begun, times = None, None, np.append(time[at], time[-1])
    if gross is not None:
        whole = int(np.searchsorted(at, gross))
        times[whole] = time[gross]
        lasting = [a for ridge_runs in runs for a, b in ridge_runs if a <= gross <= b]
        begun = int(np.searchsorted(at, min(lasting))) if lasting else None

    def scored(felt: Array) -> tuple[list[Event], Score]:
        events, _ = fed(d, at_rest(len(names)), felt[at])
        return events, score(d, events, times, sampled, whole, begun)

    def leads(result: Score) -> dict[str, float | None]:
        return {**dict(zip(names, result.lead, strict=True)), "all": result.gross_lead}

    events, scores = scored(values)
    others = [leads(scored(values + more)[1]) for more in noises]
    in_time = [run["all"] is not None for run in (leads(scores), *others)]
    warned = [not reason for event, reason in zip(events, scores.reasons, strict=True) if event.ridge is None]
    return {
        "events": [
            {
                "kind": event.kind,
                "ridge": None if event.ridge is None else int(names[event.ridge]),
                "step": int(at[event.index]),
                "time_s": float(time[at[event.index]]),
                "true": not reason,
                "reason": reason or None,
            }
            for event, reason in zip(events, scores.reasons, strict=True)
        ],
        "lead_time_s": leads(scores),
        **({"lead_time_by_noise": _spreads([leads(scores), *others])} if others else {}),
        "longest_lead_time_s": max((s for s in leads(scores).values() if s is not None), default=None),
        "warning_lead_time_s": scores.gross_lead,
        "warned_share": None if gross is None else sum(in_time) / len(in_time),
        "warning_score": {"true": sum(warned), "false": len(warned) - sum(warned)},
        "event_score": {key: getattr(scores, key) for key in ("hits", "missed", "false", "misnamed")},
        "detector": {
            "alarms": alarms,
            "share_of_gross_slips_warned_of": point.warned,
            "between": list(point.between),
            "false_alarms_per_minute_of_handling": point.false,
            "of_these_while_nothing_slips": point.idle,
        },
    }


def _spreads(leads: Sequence[dict[str, float | None]]) -> list[dict[str, Any]]:
    """Return by ridge the smallest and largest of `leads`, one a noise seed, and how many seeds warn."""
    spreads = []
    for ridge in leads[0]:
        known = [lead for leads_of_seed in leads if (lead := leads_of_seed[ridge]) is not None]
        ends = {"smallest_s": min(known, default=None), "largest_s": max(known, default=None)}
        spreads.append({"ridge": ridge, **ends, "warned": len(known), "seeds": len(leads)})
    return spreads
