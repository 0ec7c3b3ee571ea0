"""The product of both changes against the solid with finite strain, and its limits."""

from __future__ import annotations

from dataclasses import replace

import pytest

from skincad import check, load
from skincad.base.estimate import Estimate
from skincad.mechanics.models import corrected_finite_strain
from skincad.mechanics.problem import Answer, Request
from tests.mechanics.designs import THREE

REQUEST = Request(4.0)


def answer(force: float | None, approach: float, shares: tuple[float, ...]) -> Answer:
    return Answer(
        len(shares),
        Estimate(force, None if force is None else 0.01, "N"),
        Estimate(approach, 1e-3, "mm"),
        tuple(Estimate(s, 0.01, "N") for s in shares),
        1,
        0.0,
        {},
    )


SMALL = answer(3.0, 0.20, (1.0, 2.0, 1.0))
ENDS = answer(2.4, 0.25, (1.2, 1.6, 1.2))
FINITE = answer(3.3, 0.19, (0.9, 2.2, 0.9))


def test_changes_multiply_and_shares_add() -> None:
    answer = corrected_finite_strain.answer(load("plain-ridges"), REQUEST, None, SMALL, ENDS, FINITE)
    assert answer.all_touch_force.value == pytest.approx(2.4 * 1.1)
    assert answer.approach.value == pytest.approx(0.25 * 0.95)
    assert [s.value for s in answer.ridge_force] == pytest.approx([1.1, 1.8, 1.1])
    # 0.01 of each side times the other's ratio, and half of the 10 % of finite strain
    assert answer.all_touch_force.error == pytest.approx(0.01 * 1.1 + 0.01 * 0.8 + 0.05 * 2.4)


def test_no_threshold_without_all_three() -> None:
    none = replace(FINITE, all_touch_force=Estimate(None, None, "N"))
    assert (
        corrected_finite_strain.answer(
            load("plain-ridges"), REQUEST, None, SMALL, ENDS, none
        ).all_touch_force.value
        is None
    )


def test_a_single_ridge_touches_at_once() -> None:
    one = replace(SMALL, all_touch_force=Estimate(0.0, 0.0, "N"))
    at_once = replace(ENDS, all_touch_force=Estimate(0.0, 0.0, "N"))
    assert (
        corrected_finite_strain.answer(
            load("plain-ridges"), REQUEST, None, one, at_once, one
        ).all_touch_force.value
        == 0.0
    )


@pytest.mark.slow
def test_the_solid_with_finite_strain_lies_inside() -> None:
    design = load("plain-ridges").with_(**THREE, contact={"force": 1.3, "friction": 0.0})
    cheap = check(design, model="corrected-finite-strain")
    truth = check(design, model="solid-finite-strain")
    pairs = [(cheap.all_touch_force, truth.all_touch_force), (cheap.approach, truth.approach)]
    for one, other in (*pairs, *zip(cheap.ridge_force, truth.ridge_force, strict=True)):
        assert abs(one.value - other.value) <= one.error
    assert truth.all_touch_force.error < 0.3 * cheap.all_touch_force.error
