"""How far a refinement met its request: the largest relative error, and warnings for missed goals."""

from __future__ import annotations

from skincad.base.climbing import overrun, unmet
from skincad.mechanics.problem import NEGLIGIBLE, Answer


def relative_error(answer: Answer, force: float, unit: float) -> float:
    """Return the largest relative error: of the all-touch force, of the approach, of a share against the mean
    share."""
    shares, approach, threshold = answer.ridge_force, answer.approach, answer.all_touch_force
    errors = [(shares[0].error or 0.0) * len(shares) / force]
    errors.append((approach.error or 0.0) / max(abs(approach.value or 0.0), NEGLIGIBLE * unit))
    if threshold.value is not None:
        errors.append((threshold.error or 0.0) / max(threshold.value, NEGLIGIBLE * force))
    return float(max(errors))


def shortfalls(
    reached: float, wanted: float, full: str, spent: float, budget: float | None, least: str
) -> tuple[str, ...]:
    """Return warnings for a missed tolerance or budget.

    `full` says why no finer mesh follows; `least` names the cheapest option.
    """
    missed = unmet(f"the mesh's error is {reached:.1e} of the value", reached, wanted)
    return (*(words + full for words in missed), *overrun(f"the cheapest {least} ", spent, budget))
