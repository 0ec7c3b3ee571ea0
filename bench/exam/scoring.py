"""What alarms are worth: gross slips warned of, by how much ahead, and false alarms, with their confidence.

An alarm names a ridge. It is right where that ridge slips, or within a window before or behind that; of
another ridge where only another of the skin's, told or not, slips then; false where none does. A gross slip
is warned of by an alarm, right or of another ridge, while a ridge slips that slips on until all do.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from bench.exam.cases import Case

Alarm = tuple[int, int]  # told ridge from 0, sample
LEVEL = 1.96  # two-sided 95 %


@dataclass(frozen=True)
class Mark:
    """A case's score: whether it slips as a whole and is warned of, and by its own ridge's alarm; s ahead and
    the most that slip allows; how many alarms are right, of another ridge, false; `seconds`; the phases of
    false alarms."""

    slips: bool
    warned: bool
    named: bool
    lead: float
    possible: float
    right: int
    other: int
    false: int
    seconds: float
    within: tuple[str, ...]


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
    start = min((a for a in lasting(whole, gross) if a is not None), default=0)
    ahead, named, right, other, false = list[int](), False, 0, 0, list[str]()
    for ridge, i in alarms:
        before, mine = gross is not None and i < gross, begun[ridge]
        if own[i, ridge]:
            right += 1
            named = named or (before and mine is not None and i >= mine - window)
        elif skin[i]:
            other += 1
        else:
            false.append(next(name for name, at in reversed(case.scene.phases) if at <= i))
            continue
        if gross is not None and before and i >= start - window:
            ahead.append(gross - i)
    possible = 0 if gross is None else gross - start
    return Mark(
        gross is not None, bool(ahead), named, max(ahead, default=0) / case.rate, possible / case.rate, right,
        other, len(false), case.outputs.shape[0] / case.rate, tuple(false),
    )  # fmt: skip


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
    low = chi2.ppf(0.025, 2 * events) / 2 if events else 0.0
    return events / span, float(low) / span, float(chi2.ppf(0.975, 2 * events + 2)) / 2 / span


HEAD = (
    f"{'':30} warned      % (95 %)  named     lead ms  5th pct  part  right other false  clean scenes (95 %)"
    "  false/min (95 %)"
)


def line(name: str, marks: list[Mark]) -> str:
    """Return a table's line: gross slips warned of, by an alarm of a ridge that slips, leads and their part
    of what slip allows; alarms; the share of scenes without a false one, and false ones by the minute."""
    slips = [m for m in marks if m.slips]
    hits, clean = sum(m.warned for m in slips), sum(m.false == 0 for m in marks)
    low, high = wilson(hits, len(slips))
    least, most = wilson(clean, len(marks))
    false = sum(m.false for m in marks)
    minute, fewest, largest = rate(false, sum(m.seconds for m in marks) / 60)
    leads = np.array([1e3 * m.lead for m in slips if m.warned] or [math.nan])
    parts = [m.lead / m.possible for m in slips if m.warned and m.possible > 0] or [math.nan]
    return (
        f"{name:30} {hits:3}/{len(slips):<3} {100 * hits / max(1, len(slips)):5.1f} "
        f"({100 * low:3.0f}-{100 * high:3.0f}) {sum(m.named for m in slips):4} "
        f"{np.median(leads):9.3g} {np.percentile(leads, 5):8.2g} {np.median(parts):6.2f} "
        f"{sum(m.right for m in marks):5} {sum(m.other for m in marks):5} {false:5} "
        f"{100 * clean / len(marks):6.1f} ({100 * least:.0f}-{100 * most:.0f})"
        f"{minute:15.3g} ({fewest:.2g}-{largest:.2g})"
    )
