"""What a climb reached of what was asked: its largest relative error, and in words what it did not keep."""

from __future__ import annotations

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
    found = []
    if reached > wanted > 0:
        words = f"the mesh's error is {reached:.1e} of the value: the tolerance {wanted:.1e} is not met"
        found.append(words + full)
    if budget is not None and spent > budget:
        found.append(f"the cheapest {least} took {spent:.2g} s, more than the budget of {budget:g} s")
    return tuple(found)
