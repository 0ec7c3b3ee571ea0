"""What a scene's alarms are worth: which are true, and how long before gross slip they come."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.circuit.network import Network
from skincad.detector.detector import POINTS, SURE, Alarm, Detector, change_noise, tuned

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
    window: int,
    events: Sequence[Alarm],
    time: Array,
    runs: Mapping[int, Sequence[Sequence[int]]],
    gross: int | None,
    begun: int | None = None,
) -> Score:
    """Return how `events` meet the true `runs` of slip, [from, to] by monitored ridge, for a detector of
    `window` samples; `begun` is the sample at which the first slip of any ridge begins that lasts until gross
    slip.

    A ridge slips while all its touching points do. A run shorter than the window is not asked for; each other
    counts once, as a hit where an alarm of its ridge lies in it or within a window beside it (before: its
    first points slip already). An alarm warns of gross slip truly where the ridge that it names, or any where
    it names none, is in the run that lasts until then, or within a window before it; else falsely, however
    much slips at the time. Lead time runs from the first true one of a run that is asked for.
    """
    w = window
    last = {
        ridge: next(((a, b) for a, b in ridge_runs if gross is not None and a <= gross <= b), None)
        for ridge, ridge_runs in runs.items()
    }
    reasons = []
    for event in events:
        near = {
            ridge: any(_beside(event.index, run, w) for run in ridge_runs)
            for ridge, ridge_runs in runs.items()
        }
        if event.ridge is None:
            reasons.append("" if begun is not None and event.index >= begun - w else NOT_AHEAD)
        elif _beside(event.index, last[event.ridge], w):
            reasons.append("")
        else:
            reasons.append(PASSING if near[event.ridge] else MISNAMED if any(near.values()) else NOTHING)

    def first(ridge: int | None) -> float | None:
        pairs = zip(events, reasons, strict=True)
        true = [event.index for event, reason in pairs if event.ridge == ridge and not reason]
        return float(time[gross] - time[true[0]]) if true and gross is not None else None

    heard = [
        any(event.ridge == ridge and _beside(event.index, run, w) for event in events)
        for ridge, ridge_runs in runs.items()
        for run in ridge_runs
        if _length(run) >= w
    ]
    leads = tuple(first(ridge) if run and _length(run) >= w else None for ridge, run in last.items())
    return Score(sum(heard), len(heard) - sum(heard), tuple(reasons), leads, first(None))


def _length(run: Sequence[int]) -> int:
    return run[1] - run[0] + 1


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
    network: Network | None = None,
) -> dict[str, Any]:
    """Return the keys `events`, `lead_time_s`, the longest of these and the warning's, `warned_share` of the
    runs with this and other noise in which all monitored ridges warn, `event_score`, which counts
    slips and alarms of slips, and, of outputs, `warning_score`, which counts warnings of gross slip,
    and `detector`, of a march's outputs by ridge, S1 and S2.

    `noise` V rms of one strip; `runs` by ridge from 1; `alarms` one of POINTS. The detector's samples are the
    steps `even`, equally spaced; all steps if not given. Each of `noises` `(steps + 1, ridges, 2)` V makes
    the outputs those of another seed: with some, `lead_time_by_noise` has the leads' spread. `network` is the
    circuit's.
    """
    names, point = list(outputs), POINTS[alarms]
    at = np.arange(time.size) if even is None else even[even < time.size]
    if not names or at.size < 2:
        nothing = dict.fromkeys(("longest_lead_time_s", "warning_lead_time_s", "warned_share", "event_score"))
        return {"events": [], "lead_time_s": {}, **nothing}
    rate, ridges = 1 / float(time[at[1]] - time[at[0]]), [int(name) for name in names]
    change = None if network is None else change_noise(alarms, network, bandwidth, rate)
    tuning = tuned(rate, bandwidth, math.sqrt(2) * noise, alarms, change=change)
    values = np.stack([outputs[r][side] for r in names for side in ("S1", "S2")], axis=1)
    # runs and gross slip in samples; what happens between two of them is put at the later one
    sampled = {r: np.searchsorted(at, np.array(runs[r - 1], dtype=int)).tolist() for r in ridges}
    whole, begun, times = None, None, np.append(time[at], time[-1])
    if gross is not None:
        whole = int(np.searchsorted(at, gross))
        times[whole] = time[gross]
        lasting = [a for ridge_runs in runs for a, b in ridge_runs if a <= gross <= b]
        begun = int(np.searchsorted(at, min(lasting))) if lasting else None

    def scored(felt: Array) -> tuple[list[Alarm], Score]:
        events = Detector.of(tuning, ridges, rate).feed(felt[at])
        return events, score(tuning.window, events, times, sampled, whole, begun)

    def leads(result: Score) -> dict[str, float | None]:
        return {**dict(zip(names, result.lead, strict=True)), "all": result.gross_lead}

    events, scores = scored(values)
    others = [leads(scored(values + more.reshape(values.shape))[1]) for more in noises]
    in_time = [run["all"] is not None for run in (leads(scores), *others)]
    warned = [not reason for event, reason in zip(events, scores.reasons, strict=True) if event.ridge is None]
    return {
        "events": [
            {
                "kind": event.kind,
                "ridge": event.ridge,
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
            "share_of_lifts_held": point.held,
            "share_of_lifts_held_between": list(point.held_between),
            "mean_grip_over_the_least": point.grip,
            "share_of_gross_slips_warned_of": point.warned,
            "between": None if point.between is None else list(point.between),
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
