"""What a climb reached of what was asked: its largest relative error, and in words what it did not keep."""

from __future__ import annotations

from skincad.base.climbing import overrun, unmet
from skincad.mechanics.problem import FLOOR, Answer


def relative_error(found: Answer, force: float, unit: float) -> float:
    """Return the largest relative error: of F9, of the approach, of a share against the mean share."""
    shares, approach, threshold = found.ridge_force, found.approach, found.all_touch_force
    errors = [(shares[0].error or 0.0) * len(shares) / force]
    errors.append((approach.error or 0.0) / max(abs(approach.value or 0.0), FLOOR * unit))
    if threshold.value is not None:
        errors.append((threshold.error or 0.0) / max(threshold.value, FLOOR * force))
    return float(max(errors))


def shortfalls(
    reached: float, wanted: float, full: str, spent: float, budget: float | None, least: str
) -> tuple[str, ...]:
    """Return what was asked and not kept; `full` says why no rung follows, `least` what the least is."""
    missed = unmet(f"the mesh's error is {reached:.1e} of the value", reached, wanted)
    return (*(words + full for words in missed), *overrun(f"the cheapest {least} ", spent, budget))
