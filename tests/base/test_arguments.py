"""Numbers that callers give: taken within their limits, refused by the argument's name beyond them."""

from __future__ import annotations

import math

import pytest

from skincad.base import InputError, require_goals, require_number


@pytest.mark.parametrize(("tol", "budget"), [(None, None), (1e-9, 1e-9), (0.999, 1e9)])
def test_goals_within_their_limits_are_taken(tol: float | None, budget: float | None) -> None:
    require_goals(tol, budget, "0.05")


@pytest.mark.parametrize("tol", [0.0, 1.0, -0.1, math.nan])
def test_a_tolerance_is_a_share(tol: float) -> None:
    with pytest.raises(InputError, match=r"tol: must be between 0 and 1.*try 0\.05"):
        require_goals(tol, 1.0, "0.05")


@pytest.mark.parametrize("budget", [0.0, -1.0, math.inf, math.nan])
def test_a_budget_is_a_time(budget: float) -> None:
    with pytest.raises(InputError, match="budget: must be above 0 s"):
        require_goals(0.1, budget, "0.05")


@pytest.mark.parametrize("value", ["2 N", None, True, [2.0]])
def test_what_is_no_number_is_said_to_be_none(value: object) -> None:
    with pytest.raises(InputError, match="force: must be a number"):
        require_number("force", value, lambda _: True, "must be anything")
