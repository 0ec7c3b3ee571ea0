"""What alarms are worth: gross slips warned of, by how much ahead, and false alarms, with their confidence.

An alarm names a ridge. It is true where that ridge slips in a run that lasts until gross slip, or within a
window before; else it is false: of a slip that passes, where the ridge slips within a window of it, but not
until gross slip; of another ridge, where only another of the skin's slips, monitored or not; of none. An
alarm without a ridge is of the skin as a whole: true where any ridge so slips. A gross slip is warned of by a
true alarm before it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from bench.exam.cases import Case
from bench.runner import wilson

Alarm = tuple[int | None, int]  # monitored ridge from 0, None for the skin; sample


@dataclass(frozen=True)
class Mark:
    """A case's score: whether it slips as a whole and is warned of; s ahead and the most that slip allows;
    how many alarms are true, and false as of a slip that is `passing`, of an`other` ridge, of `none`;
    `seconds`; the phases of false alarms."""

    slips: bool
    warned: bool
    lead: float
    possible: float
    true: int
    passing: int
    other: int
    none: int
    seconds: float
    within: tuple[str, ...]

    @property
    def false(self) -> int:
        """Number of false alarms."""
        return self.passing + self.other + self.none


def lasting(slipping: np.ndarray, gross: int | None) -> list[int | None]:
    """Return by ridge where the slip begins that lasts to gross slip, of `slipping` `(n, ridges)`."""
    if gross is None:
        return [None] * slipping.shape[1]
    still = [np.flatnonzero(~column[: gross + 1]) for column in slipping.T]
    starts = [int(at[-1]) + 1 if at.size else 0 for at in still]
    return [a if a <= gross else None for a in starts]


def near(slipping: np.ndarray, window: int) -> np.ndarray:
    """Return where a slip is, or within a window before or behind it, along the first axis."""
    total = np.cumsum(np.pad(slipping.astype(int), [(window + 1, window), (0, 0)]), axis=0)
    return np.asarray(total[2 * window + 1 :] > total[: -2 * window - 1])


def mark(case: Case, alarms: Iterable[Alarm], window: int) -> Mark:
    """Return the score of a case's alarms, `window` samples."""
    gross, whole = case.gross, case.scene.slipping[: case.outputs.shape[0]]
    own, skin = near(case.slipping, window), near(whole, window).any(axis=1)
    begun = lasting(case.slipping, gross)
    start = min((a for a in lasting(whole, gross) if a is not None), default=None)
    ahead, within = list[int](), list[str]()
    true = passing = other = none = 0
    for ridge, i in alarms:
        since = start if ridge is None else begun[ridge]
        if gross is not None and since is not None and i >= since - window:
            true += 1
            if i < gross:
                ahead.append(gross - i)
            continue
        slipped = skin[i] if ridge is None else own[i, ridge]
        passing, other = passing + bool(slipped), other + bool(skin[i] and not slipped)
        none += not skin[i]
        within.append(next(name for name, at in reversed(case.scene.phases) if at <= i))
    possible = 0 if gross is None or start is None else gross - start
    return Mark(
        gross is not None, bool(ahead), max(ahead, default=0) / case.rate, possible / case.rate, true,
        passing, other, none, case.outputs.shape[0] / case.rate, tuple(within),
    )  # fmt: skip


def rate(events: int, span: float) -> tuple[float, float, float]:
    """Return events per unit of `span` with its 95 % interval (Garwood, Biometrika 28 (1936) 437)."""
    low = chi2.ppf(0.025, 2 * events) / 2 if events else 0.0
    return events / span, float(low) / span, float(chi2.ppf(0.975, 2 * events + 2)) / 2 / span


HEAD = (
    f"{'':30} warned      % (95 %)    lead ms  5th pct  part   true passing other  none  clean scenes (95 %)"
    "  false/min (95 %)  of none"
)


def line(name: str, marks: list[Mark]) -> str:
    """Return a table's line: gross slips warned of, leads and their part of what slip allows; alarms, true
    and false ones by kind; the share of scenes without a false one; false ones by the minute, and of them
    those of no slip."""
    slips = [m for m in marks if m.slips]
    hits, clean = sum(m.warned for m in slips), sum(m.false == 0 for m in marks)
    low, high = wilson(hits, len(slips))
    least, most = wilson(clean, len(marks))
    false = sum(m.false for m in marks)
    minutes = sum(m.seconds for m in marks) / 60
    minute, fewest, largest = rate(false, minutes)
    kinds = (sum(getattr(m, kind) for m in marks) for kind in ("true", "passing", "other", "none"))
    true, passing, other, none = kinds
    leads = np.array([1e3 * m.lead for m in slips if m.warned] or [math.nan])
    parts = [m.lead / m.possible for m in slips if m.warned and m.possible > 0] or [math.nan]
    return (
        f"{name:30} {hits:3}/{len(slips):<3} {100 * hits / max(1, len(slips)):5.1f} "
        f"({100 * low:3.0f}-{100 * high:3.0f}) "
        f"{np.median(leads):9.3g} {np.percentile(leads, 5):8.2g} {np.median(parts):6.2f} "
        f"{true:6} {passing:7} {other:5} {none:5} "
        f"{100 * clean / len(marks):6.1f} ({100 * least:.0f}-{100 * most:.0f})"
        f"{minute:15.3g} ({fewest:.2g}-{largest:.2g}) {none / minutes:8.3g}"
    )
