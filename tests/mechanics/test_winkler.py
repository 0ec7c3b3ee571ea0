"""The closed form against the linear tier: inside its stated model error, and far cheaper."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.mechanics.check import check
from tests.mechanics.designs import linear_check, reference, yamada

VARIANTS = {
    "reference": {},
    "thin": {"skin": {"thickness": 2.0}},
    "thick": {"skin": {"thickness": 8.0}},
    "high": {"ridge": {"height": 0.8}},
    "flatter": {"skin": {"curvature_radius": 120.0}},
    "five": {"ridge": {"count": 5}},
    "narrow": {"ridge": {"root_width": 0.6, "tip_width": 0.4}},
}


@pytest.mark.parametrize("name", VARIANTS)
def test_linear_tier_lies_inside_the_model_error(name: str) -> None:
    design = reference().with_(**VARIANTS[name])
    spring, solid = check(design, tier="winkler"), linear_check(design, tol=0.05)
    for one, other in (
        (spring.all_touch_force, solid.all_touch_force),
        (spring.approach, solid.approach),
        *zip(spring.ridge_force, solid.ridge_force, strict=True),
    ):
        assert abs((one.value or 0.0) - (other.value or 0.0)) <= (one.error or 0.0)


def test_reference_is_low_as_measured() -> None:
    """FACTS.md: F9 25 to 35 % low."""
    low = (check(reference(), tier="winkler").all_touch_force.value or 0.0) / 3.026
    assert 0.65 <= low <= 0.75


def test_shares_balance_and_the_last_ridge_starts_at_the_threshold() -> None:
    threshold = check(yamada(), tier="winkler").all_touch_force.value or 0.0
    at = check(yamada(), tier="winkler", force=threshold)
    assert sum(f.value or 0.0 for f in at.ridge_force) == pytest.approx(threshold, rel=1e-12)  # rounding
    assert np.isclose(at.ridge_force[0].value or 0.0, 0.0, atol=1e-12)


@pytest.mark.parametrize("force", [1e-9, 1.0, 100.0])
def test_any_force(force: float) -> None:
    found = check(yamada(), tier="winkler", force=force)
    assert sum(f.value or 0.0 for f in found.ridge_force) == pytest.approx(force, rel=1e-9)  # cancellation


def test_says_when_the_tolerance_is_beyond_it() -> None:
    assert any(
        "0.8 of its value: the asked 0.01 is not met" in w
        for w in check(yamada(), tier="winkler", tol=0.01).warnings
    )
