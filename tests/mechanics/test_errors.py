"""Stated errors against finer meshes: the truth must lie inside."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from skincad.inputs import Design
from skincad.mechanics import Request, pad_of, plane_piece
from skincad.mechanics.models import linear
from skincad.mechanics.models.linear import PlaneSolution, level
from tests.mechanics.designs import THREE, assert_inside, filleted, reference, void_slots, yamada

DESIGNS = {
    "reference": reference,
    "filleted": lambda: filleted().with_(**THREE),
    "voids": lambda: void_slots(0.05).with_(**THREE),
    "yamada": lambda: yamada().with_(**THREE),
}


def force_on(design: Design) -> float:
    return 4.0 if design.ridge.count == 9 else 1.3


@cache
def truth(name: str) -> PlaneSolution:
    """Order 4 on a mesh finer than any rung's."""
    design = DESIGNS[name]()
    pad = pad_of(design)
    return level(plane_piece(pad, 3.0), 4, force_on(design))


@pytest.mark.parametrize(
    ("name", "tol"),
    [
        pytest.param(name, tol, marks=() if (name, tol) == ("yamada", 1e-2) else pytest.mark.slow)
        for name in DESIGNS
        for tol in (1e-2, 5e-3)
    ],
)
def test_truth_lies_inside(name: str, tol: float) -> None:
    design = DESIGNS[name]()
    assert_inside(linear.answer(design, Request(force_on(design), tol)), truth(name))


@pytest.mark.slow
def test_truth_lies_inside_on_higher_refinements() -> None:
    assert_inside(linear.answer(DESIGNS["yamada"](), Request(1.3, 6e-4)), truth("yamada"))


VARIANTS: dict[str, dict[str, dict[str, float]]] = {
    "high": {"ridge": {"height": 0.7}},
    "thin": {"skin": {"thickness": 2.0}},
    "round": {"skin": {"curvature_radius": 8.0}},
    "flat crown": {"ridge": {"crown": 0.0}},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", VARIANTS)
def test_variants_errors(name: str) -> None:
    design: Design = yamada().with_(**THREE).with_(**VARIANTS[name])
    pad = pad_of(design)
    exact = level(plane_piece(pad, 2.0), 4, 1.3)
    assert_inside(linear.answer(design, Request(1.3)), exact)


def test_a_tolerance_out_of_reach_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(linear, "REFINEMENTS", (replace(linear.REFINEMENTS[0], usual=0.0),))
    answer = linear.answer(reference().with_(ridge={"count": 3}), Request(4.0, 1e-9))
    assert any("not met" in w for w in answer.warnings)
