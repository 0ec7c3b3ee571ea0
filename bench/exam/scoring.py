"""What alarms are worth: gross slips warned of, by how much ahead, and false alarms, with their confidence.

An alarm is true where its own ridge slips, or within a window before or behind that. A gross slip is warned
of by a true alarm of a slip that lasts to it, before it. Alarms are those of one ridge (incipient slip).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from bench.exam.cases import Case

Alarm = tuple[int, int]  # told ridge from 0, sample
LEVEL = 1.96  # two-sided 95 %


@dataclass(frozen=True)
class Mark:
    """A case's score: whether it slips as a whole and is warned of, s ahead, the most that a told ridge's own
    slip allows, `false` alarms, `seconds`, the name of the phase of each false alarm."""

    slips: bool
    warned: bool
    lead: float
    possible: float
    false: int
    seconds: float
    within: tuple[str, ...]


def lasting(case: Case) -> list[int | None]:
    """Return by told ridge where the slip begins that lasts to gross slip."""
    gross = case.gross
    if gross is None:
        return [None] * len(case.runs)
    return [next((a for a, b in mine if a <= gross <= b), None) for mine in case.runs]


def mark(case: Case, alarms: Iterable[Alarm], window: int) -> Mark:
    """Return the score of a case's alarms, `window` samples."""
    starts, gross = lasting(case), case.gross
    warned, false = [], []
    for ridge, i in alarms:
        if not any(a - window <= i <= b + window for a, b in case.runs[ridge]):
            false.append(next(name for name, at in reversed(case.scene.phases) if at <= max(i, 0)))
            continue
        start = starts[ridge]
        if gross is not None and start is not None and start - window <= i < gross:
            warned.append((gross - i) / case.rate)
    possible = max((gross - a for a in starts if a is not None and gross is not None), default=0) / case.rate
    seconds = case.outputs.shape[0] / case.rate
    return Mark(
        gross is not None, bool(warned), max(warned, default=0.0), possible, len(false), seconds, tuple(false)
    )


def wilson(hits: int, count: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (Wilson, J. Am. Stat. Assoc. 22 (1927) 209)."""
    if not count:
        return 0.0, 1.0
    share, z2 = hits / count, LEVEL**2
    middle = (share + z2 / (2 * count)) / (1 + z2 / count)
    half = LEVEL / (1 + z2 / count) * math.sqrt(share * (1 - share) / count + z2 / (4 * count**2))
    return max(0.0, middle - half), min(1.0, middle + half)


def rate(events: int, span: float) -> tuple[float, float, float]:
    """Return events per unit of `span` with its 95 % interval (Garwood, Biometrika 28 (1936) 437)."""
    from scipy.stats import chi2

    low = chi2.ppf(0.025, 2 * events) / 2 if events else 0.0
    return events / span, float(low) / span, float(chi2.ppf(0.975, 2 * events + 2)) / 2 / span


def line(name: str, marks: list[Mark]) -> str:
    """Return a table's line: warned, of those that could be, leads, false alarms by scene and minute."""
    slips = [m for m in marks if m.slips]
    hits = sum(m.warned for m in slips)
    able = [m for m in slips if m.possible > 0]
    low, high = wilson(hits, len(slips))
    ahead = [m.lead / m.possible for m in able if m.warned and m.possible > 0]
    leads = np.array([1e3 * m.lead for m in slips if m.warned])
    false = sum(m.false for m in marks)
    clean = sum(m.false == 0 for m in marks)
    minute, least, most = rate(false, sum(m.seconds for m in marks) / 60)
    share = hits / len(slips) if slips else math.nan
    shown = (
        f"{np.median(leads):8.3g} {np.percentile(leads, 5):8.2g} {np.median(ahead):5.2f}"
        if leads.size
        else f"{'-':>8} {'-':>8} {'-':>5}"
    )
    return (
        f"{name:34} {hits:4}/{len(slips):<4} {100 * share:5.1f} ({100 * low:.0f}-{100 * high:.0f}) "
        f"{sum(m.warned for m in able):4}/{len(able):<4} {shown} {false:5} "
        f"{false / len(marks):6.2f} {clean / len(marks):6.2f} {minute:7.2f} ({least:.2g}-{most:.2g})"
    )


HEAD = (
    f"{'':34} warned       % (95 %)   could        lead ms  5th pct  part  false /scene  clean   /min (95 %)"
)
