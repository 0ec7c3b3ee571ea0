"""What a tier leaves out, against the tier that computes it."""

from __future__ import annotations

import pytest

from skincad import load
from skincad.mechanics.left_out import LeftOut, free_ends
from skincad.mechanics.left_out import finite_strain as small_strain
from skincad.mechanics.problem import Answer, Request
from skincad.mechanics.tiers import corrected, finite_strain, linear

CASES: dict[str, tuple[str, dict[str, dict[str, float]]]] = {
    "plain-ridges": ("plain-ridges", {}),
    "yamada-2002": ("yamada-2002", {}),
    "fingertip-soft": ("fingertip-soft", {}),
    "long": ("plain-ridges", {"skin": {"length": 48.0}}),
    "short": ("plain-ridges", {"skin": {"length": 6.0}}),
    "thin": ("plain-ridges", {"skin": {"thickness": 2.0}}),
    "five": ("plain-ridges", {"ridge": {"count": 5}}),
}
FAST = ("short", "thin", "five")
TOO_WIDE = 10.0  # times the change; at most 7 over the calibration at nu 0.499 (left_out.py)


def assert_bounds(bound: LeftOut, without: Answer, computed: Answer, force: float) -> None:
    for of, limit in (("all_touch_force", bound.threshold), ("approach", bound.approach)):
        left, right = getattr(without, of).value, getattr(computed, of).value
        change = abs(right / left - 1)
        assert change <= limit <= TOO_WIDE * change
    mean = force / len(without.ridge_force)
    pairs = zip(without.ridge_force, computed.ridge_force, strict=True)
    assert max(abs((a.value or 0.0) - (b.value or 0.0)) for a, b in pairs) <= bound.share * mean


@pytest.mark.parametrize("name", [n if n in FAST else pytest.param(n, marks=pytest.mark.slow) for n in CASES])
def test_the_free_ends_lie_within_their_bound(name: str) -> None:
    template, change = CASES[name]
    design = load(template).with_(**change)
    request = Request(design.contact.force, 0.05)
    plane = linear.answer(design, request)
    ends = corrected.answer(design, request, fine=plane)
    assert_bounds(free_ends(design), plane, ends, request.force)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_finite_strain_lies_within_its_bound(name: str) -> None:
    template, change = CASES[name]
    design = load(template).with_(**change)
    request = Request(design.contact.force, 0.05)
    small, finite = linear.answer(design, request), finite_strain.answer(design, request)
    assert_bounds(small_strain(design, small, request.force), small, finite, request.force)
