"""Arguments of public functions: numbers within their limits, or an InputError that names the argument."""

from __future__ import annotations

import math
from collections.abc import Callable
from numbers import Real

from skincad.base.errors import InputError


def require_number(
    key: str, value: object, holds: Callable[[float], bool], rule: str, remedy: str = ""
) -> None:
    """Raise InputError unless `value` is a finite number for which `rule` holds."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(key, "must be a number", value, remedy)
    if not (math.isfinite(value) and holds(float(value))):
        raise InputError(key, rule, value, remedy)


def require_goals(tol: float | None, budget: float | None, example: str) -> None:
    """Raise InputError unless `tol` is a relative error, `budget` a time in s, where they are given."""
    if tol is not None:
        rule = "must be between 0 and 1 (relative)"
        require_number("tol", tol, lambda value: 0 < value < 1, rule, f"try {example}")
    if budget is not None:
        require_number("budget", budget, lambda value: value > 0, "must be above 0 s")
