"""Climbs and errors of made-up levels: what is solved, what is told of it, and what it may cost."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from skincad.base import Estimate, adaptivity
from skincad.inputs import load
from skincad.mechanics import (
    NEGLIGIBLE,
    Answer,
    Correction,
    Errors,
    LateError,
    LevelAnswer,
    Request,
    SizeError,
    pad_of,
)
from skincad.mechanics.models import corrected, linear, solid, solid_finite_strain
from skincad.mechanics.models.linear import REFINEMENTS, PlaneSolution, relative_error, shortfalls


def plane(force: float | None, approach: float, shares: tuple[float, ...], residual: float = 0.0) -> Any:
    at_work: Any = None
    state = {
        "x": np.empty(0),
        "pressure": np.empty(0),
        "seconds": {"contact": 1.0},
        "ridges": at_work,
        "unit": 1.0,
        "scale": 1.0,
    }
    return PlaneSolution(force, approach, np.array(shares), 10, residual, **state)


def spatial(force: float | None, approach: float, shares: tuple[float, ...], unknowns: int = 10) -> Any:
    return LevelAnswer(force, approach, np.array(shares), unknowns, 1e-12 * unknowns)


def answer(force: float | None, approach: float, shares: tuple[float, ...], error: float = 0.01) -> Answer:
    return Answer(
        sum(s > 0 for s in shares),
        Estimate(force, None if force is None else error, "N"),
        Estimate(approach, error, "mm"),
        tuple(Estimate(s, error, "N") for s in shares),
        20,
        1e-9,
        {"contact": 1.0},
        ("said before",),
    )


@pytest.mark.parametrize("order", [4, 5, 6])
def test_where_the_error_falls_as_one_over_the_order_the_bar_is_that_error_times_the_tail(order: int) -> None:
    """What is then left at order k is k - 1 times what k - 1 and k differ by."""

    def at(k: float, of: float, by: float) -> float:
        return of + by / k

    best, lower = (
        plane(at(k, 3.0, 0.2), at(k, 0.2, 0.008), (at(k, 1.0, 0.1), at(k, 2.0, -0.3)))
        for k in (order, order - 1)
    )
    estimated = linear.estimated_answer(best, lower, None, order, {})
    assert estimated.all_touch_force.error == pytest.approx(linear.TAIL * 0.2 / order, rel=1e-9)
    assert estimated.approach.error == pytest.approx(linear.TAIL * 0.008 / order, rel=1e-9)
    # the largest of the ridges' is every ridge's
    assert [f.error for f in estimated.ridge_force] == pytest.approx(
        [linear.TAIL * 0.3 / order] * 2, rel=1e-9
    )
    assert [f.value for f in estimated.ridge_force] == list(best.ridge_force)
    third = linear.estimated_answer(best, lower, None, 3, {})
    assert (third.approach.error or 0.0) * (order - 1) > (estimated.approach.error or 0.0)
    assert (third.approach.error or 0.0) < (estimated.approach.error or 0.0)


def test_the_refinement_before_bounds_the_error_too() -> None:
    best, lower = plane(3.0, 0.2, (1.0, 2.0)), plane(3.0, 0.2, (1.0, 2.0))
    nothing = linear.estimated_answer(best, lower, None, 4, {})
    assert [nothing.all_touch_force.error, nothing.approach.error, nothing.ridge_force[0].error] == [0, 0, 0]
    far = linear.estimated_answer(best, lower, plane(2.5, 0.21, (1.4, 1.6)), 4, {})
    assert far.all_touch_force.error == pytest.approx(0.5, rel=1e-12)
    assert far.ridge_force[0].error == pytest.approx(0.4, rel=1e-12)
    # 1/6 of F9, of which a part is the approach's, and more than its own 5 %
    assert far.approach.error == pytest.approx(linear.APPROACH_BY_THRESHOLD * 0.5 / 3.0 * 0.2, rel=1e-12)
    assert far.approach.error > 0.01
    nearer = linear.estimated_answer(best, lower, plane(3.0, 0.25, (1.0, 2.0)), 4, {})
    assert nearer.approach.error == pytest.approx(0.05, rel=1e-12)
    assert nearer.all_touch_force.error == pytest.approx(linear.THRESHOLD_BY_APPROACH * 0.25 * 3.0, rel=1e-12)
    for levels in ((plane(None, 0.2, (1.0, 2.0)), lower, None), (best, lower, plane(None, 0.2, (1.0, 2.0)))):
        unknown = linear.estimated_answer(*levels, 4, {}).all_touch_force
        assert (unknown.value, unknown.error) == (None, None)


def test_the_relative_error_is_the_largest_of_force_approach_and_share() -> None:
    known = answer(2.0, 0.1, (1.0, 3.0), 0.0)
    assert relative_error(known, 4.0, 0.5) == 0.0
    by_force = replace(known, all_touch_force=Estimate(2.0, 0.02, "N"))
    assert relative_error(by_force, 4.0, 0.5) == pytest.approx(0.01, rel=1e-12)
    by_approach = replace(known, approach=Estimate(-0.1, 0.002, "mm"))
    assert relative_error(by_approach, 4.0, 0.5) == pytest.approx(0.02, rel=1e-12)
    by_share = replace(known, ridge_force=tuple(Estimate(f, 0.06, "N") for f in (1.0, 3.0)))
    assert relative_error(by_share, 4.0, 0.5) == pytest.approx(0.03, rel=1e-12)  # of the mean share, 2 N
    # what is next to nothing is compared with a part of the force, or of the pad
    small = replace(known, all_touch_force=Estimate(1e-9 * NEGLIGIBLE, 0.01, "N"))
    assert relative_error(small, 4.0, 0.5) == pytest.approx(0.01 / (4.0 * NEGLIGIBLE), rel=1e-12)
    still = replace(known, approach=Estimate(0.0, 0.01, "mm"))
    assert relative_error(still, 4.0, 0.5) == pytest.approx(0.01 / (0.5 * NEGLIGIBLE), rel=1e-12)
    assert relative_error(replace(known, all_touch_force=Estimate(None, None, "N")), 4.0, 0.5) == 0.0


def test_only_what_was_asked_and_not_kept_is_told() -> None:
    assert shortfalls(0.01, 0.01, "", 2.0, 2.0, "mesh") == ()
    assert shortfalls(0.02, 0.0, "", 2.0, None, "mesh") == ()  # no tolerance was asked
    (missed,) = shortfalls(0.02, 0.01, ": no more", 2.0, None, "mesh")
    assert missed == "the mesh's error is 2.0e-02 of the value: the tolerance 1.0e-02 is not met: no more"
    (late,) = shortfalls(0.01, 0.01, "", 2.0, 1.9, "solid")
    assert late == "the cheapest solid took 2 s, more than the budget of 1.9 s"


class Clock:
    """A clock that only stands still or is moved on."""

    def __init__(self, patch: pytest.MonkeyPatch, *modules: Any) -> None:
        self.now = 50.0
        for module in modules:
            patch.setattr(module, "perf_counter", lambda: self.now)


class Levels:
    """Made-up levels of the plane: `prices` s a level, an error that falls as the fineness and the order
    rise, and a mesh that takes `meshing` s and has `contact` unknowns for a fineness of 1."""

    def __init__(self, patch: pytest.MonkeyPatch, seconds: float = 0.0, meshing: float = 0.0) -> None:
        self.clock, self.seconds, self.meshing = Clock(patch, adaptivity, linear), seconds, meshing
        self.solved: list[tuple[float, int]] = []
        self.contact = 10.0
        patch.setattr(linear, "plane_piece", self.piece)
        patch.setattr(linear, "default_sizes", lambda _, fineness: fineness)
        patch.setattr(linear, "triangles", lambda _, fineness: fineness)
        patch.setattr(linear.elements, "curved", lambda mesh, _: mesh)
        patch.setattr(linear.elements, "contact_unknowns", lambda mesh, _: self.contact * mesh)
        patch.setattr(linear, "contact_unknowns", lambda meshed, _: self.contact * meshed.mesh)

    def piece(self, _: object, fineness: float, *, whole: bool) -> Any:
        assert not whole
        self.clock.now += self.meshing
        return SimpleNamespace(mesh=fineness)

    def __call__(self, meshed: Any, order: int, force: float, *_: object) -> Any:
        self.solved.append((meshed.mesh, order))
        self.clock.now += self.seconds
        off = 0.1 / meshed.mesh / order**2
        solution = plane(2.0 * (1 + off), 0.1, (force / 2, force / 2))
        return replace(solution, seconds={"contact": self.seconds})

    def climbed(self, **goals: Any) -> Answer:
        self.solved.clear()
        return linear.refine(pad_of(load("plain-ridges")), Request(4.0, **goals), self, "linear")[0]


def test_a_refinement_solves_no_level_twice_and_ends_where_the_tolerance_is_met(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    levels = Levels(monkeypatch, 1.0, 0.5)
    whole = levels.climbed(tol=1e-9)
    first = (REFINEMENTS[-2].fineness, REFINEMENTS[-2].order - 1)
    assert levels.solved[0] == first  # from the refinement before the one that may do: that bounds its error
    assert len(levels.solved) == len(set(levels.solved)) == 3
    assert whole.seconds == {"mesh": 0.5, "contact": 3.0}
    assert [w.split(":")[1] for w in whole.warnings] == [" the tolerance 1.0e-09 is not met"]
    coarse = levels.climbed(tol=0.5)
    assert levels.solved == [(REFINEMENTS[0].fineness, 2), (REFINEMENTS[0].fineness, 3)]
    assert (coarse.warnings, coarse.seconds) == ((), {"mesh": 0.5, "contact": 2.0})
    for i, refinement in enumerate(REFINEMENTS):
        levels.climbed(tol=max(refinement.usual, 1e-12))
        first_refinement = REFINEMENTS[i if i < 2 else i - 1]
        assert levels.solved[0] == (first_refinement.fineness, first_refinement.order - 1)
    # a budget without a tolerance asks for the best: all refinements from the first
    best = levels.climbed(budget=1e6)
    assert {(r.fineness, k) for r in REFINEMENTS for k in (r.order - 1, r.order)} == set(levels.solved)
    assert best.warnings == ()


def test_a_budget_is_kept_by_what_the_refinements_before_took(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two levels at 1 s are the first refinement; the next is expected to take its price times that."""
    stub = Levels(monkeypatch, 1.0)
    needed = 2.0 * (1 + REFINEMENTS[1].price / REFINEMENTS[0].price)
    for more, levels in ((-1e-6, 2), (1e-6, 4)):
        assert stub.climbed(budget=needed + more).warnings == ()
        assert len(stub.solved) == levels
    (late,) = stub.climbed(budget=1.5).warnings
    assert late == "the cheapest mesh took 2 s, more than the budget of 1.5 s"


def test_what_must_fit_and_will_not_is_given_up_after_its_mesh_or_its_first_order(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    levels = Levels(monkeypatch, 0.0, 1.0)
    expected = 1.0 + linear.AFTER_MESH
    with pytest.raises(LateError) as late:
        levels.climbed(budget=expected - 1e-6, must_fit=True)
    assert (late.value.seconds, levels.solved) == (pytest.approx(expected), [])
    levels.climbed(budget=expected + 1e-6, must_fit=True)
    levels.climbed(budget=1.1)  # what need not fit is solved as the least there is
    assert len(levels.solved) == 2
    slow = Levels(monkeypatch, 1.0)
    expected = 1.0 + linear.AFTER_ORDER
    with pytest.raises(LateError) as late:
        slow.climbed(budget=expected - 1e-6, must_fit=True)
    assert (late.value.seconds, len(slow.solved)) == (pytest.approx(expected), 1)
    slow.climbed(budget=expected + 1e-6, must_fit=True)
    assert len(slow.solved) >= 2


def test_a_mesh_of_as_many_unknowns_as_fit_is_solved_and_one_of_more_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    levels = Levels(monkeypatch)
    levels.contact = linear.MOST_CONTACT_UNKNOWNS / REFINEMENTS[1].fineness
    answer = levels.climbed(budget=1e6, tol=1e-9)
    assert {fineness for fineness, _ in levels.solved} == {REFINEMENTS[0].fineness, REFINEMENTS[1].fineness}
    assert answer.warnings[0].endswith(
        f"is not met: a finer mesh takes more than {linear.MOST_CONTACT_UNKNOWNS} contact unknowns"
    )
    levels.climbed(tol=1e-9)  # begun on the finest, which does not fit
    assert {fineness for fineness, _ in levels.solved} == {REFINEMENTS[1].fineness}
    levels.contact = 1.01 * linear.MOST_CONTACT_UNKNOWNS / REFINEMENTS[0].fineness
    with pytest.raises(SizeError, match=r"ridge\.count: the linear model takes at most"):
        levels.climbed()


def test_a_ridge_too_many_is_told_before_anything_is_meshed(monkeypatch: pytest.MonkeyPatch) -> None:
    levels = Levels(monkeypatch)
    levels.contact = 1e9
    pad = pad_of(load("plain-ridges"))
    most = linear.MOST_A_RIDGE * len(pad.ridges)
    linear.check_coarsest(pad, most, "linear")
    with pytest.raises(SizeError) as large:
        linear.check_coarsest(pad, most - 1, "linear")
    alone = 1e9 * REFINEMENTS[0].fineness
    assert f"got {round(linear.SINGLE_RIDGE_FACTOR * len(pad.ridges) * alone)}" in str(large.value)


def test_finer_layers_and_a_higher_order_add_up_in_the_solid() -> None:
    """Values of order and layers apart: f + g at the best of both. Its bar adds both differences."""
    lower = spatial(3.0, 0.20, (1.0, 2.0), 1)
    best = spatial(3.1, 0.19, (1.2, 1.8), 2)  # the higher order changes by this much
    finer = spatial(2.8, 0.23, (0.9, 2.1), 3)  # the finer layers by this
    result = solid.estimated_answer(best, lower, finer)
    assert result.all_touch_force.value == pytest.approx(2.9)
    assert result.approach.value == pytest.approx(0.22)
    assert [f.value for f in result.ridge_force] == pytest.approx([1.1, 1.9])
    tails = np.array([solid.SECTION_TAIL, solid.LAYERS_TAIL])
    assert result.all_touch_force.error == pytest.approx(tails @ [0.1, 0.2])
    assert result.approach.error == pytest.approx(tails @ [0.01, 0.03])
    assert [f.error for f in result.ridge_force] == pytest.approx([tails @ [0.2, 0.1]] * 2)
    assert (result.touching, result.unknowns, result.residual) == (2, 2, pytest.approx(3e-12))
    unknown = solid.estimated_answer(best, lower, spatial(None, 0.23, (0.9, 2.1)))
    assert unknown.all_touch_force.value is None
    # a ridge at the brink: no sum of differences makes it pull
    brink = solid.estimated_answer(
        spatial(3.1, 0.19, (0.0, 3.0)), spatial(3.0, 0.2, (0.2, 2.8)), spatial(3.0, 0.2, (0.1, 2.9))
    )
    assert [f.value for f in brink.ridge_force] == [0.0, 3.0]
    assert brink.touching == 1


def test_the_solid_refinements_where_the_tolerance_asks_it_and_the_budget_lets_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock, climbed = Clock(monkeypatch, adaptivity, solid), []
    pad = pad_of(load("plain-ridges"))

    def refine(_: object, refinement: Any, *__: object) -> Answer:
        climbed.append(refinement)
        clock.now += 2.0 * refinement.price
        if refinement is solid.REFINEMENTS[1] and too_large:
            raise SizeError("ridge.count", "too many", 1)
        return answer(3.0, 0.2, (1.0, 3.0), 0.0 if refinement is solid.REFINEMENTS[1] else 0.002)

    monkeypatch.setattr(solid, "_refine", refine)

    def asked(**what: Any) -> tuple[int, tuple[str, ...]]:
        climbed.clear()
        return len(climbed), solid.solve(pad, Request(4.0, **what)).warnings

    too_large = False
    error = 0.01  # 0.002 mm of 0.2 mm
    for tol, refinements in ((error * (1 + 1e-9), 1), (error * (1 - 1e-9), 2)):
        assert asked(tol=tol)[1] == ()
        assert len(climbed) == refinements
    needed = 2.0 * (1 + solid.REFINEMENTS[1].price)
    for budget, refinements in ((needed - 1e-6, 1), (needed + 1e-6, 2)):
        assert asked(budget=budget)[1] == ()
        assert len(climbed) == refinements
    assert asked(budget=1.9)[1] == ("the cheapest solid took 2 s, more than the budget of 1.9 s",)
    too_large = True
    assert asked(tol=1e-3)[1] == (
        "the mesh's error is 1.0e-02 of the value: the tolerance 1.0e-03 is not met",
    )


ERRORS = Errors(approach=0.01, threshold=0.02, share=0.03)


def changed(fine: Answer, before: LevelAnswer, after: LevelAnswer) -> Answer:
    return Correction(before, after, ERRORS).applied(fine, 4.0)


def test_a_change_scales_force_and_approach_and_shifts_shares() -> None:
    fine = answer(3.0, 0.2, (1.0, 2.0, 1.0))
    result = changed(fine, spatial(2.0, 0.1, (1.1, 1.8, 1.1)), spatial(1.5, 0.11, (1.3, 1.4, 1.3)))
    assert result.all_touch_force.value == pytest.approx(3.0 * 0.75)
    assert result.all_touch_force.error == pytest.approx(math.hypot(0.01, 0.02 * 3.0) * 0.75)
    assert result.approach.value == pytest.approx(0.2 * 1.1)
    assert result.approach.error == pytest.approx(math.hypot(0.01, 0.01 * 0.2) * 1.1)
    assert [f.value for f in result.ridge_force] == pytest.approx([1.2, 1.6, 1.2])
    assert result.ridge_force[0].error == pytest.approx(math.hypot(0.01, 0.03 * 4.0 / 3))
    assert (result.touching, result.unknowns, result.residual) == (3, 20, pytest.approx(1e-9))
    more = changed(fine, spatial(2.0, 0.1, (1, 2, 1), 2000), spatial(2.0, 0.1, (1, 2, 1), 30))
    assert (more.unknowns, more.residual) == (30, pytest.approx(2e-9))


def test_a_ridge_that_the_changed_level_leaves_clear_carries_nothing_and_none_pulls() -> None:
    fine = answer(3.0, 0.2, (0.5, 3.0, 0.5))
    result = changed(fine, spatial(2.0, 0.1, (1.0, 2.0, 0.1)), spatial(2.0, 0.1, (0.1, 2.9, 0.0)))
    assert [f.value for f in result.ridge_force] == pytest.approx([0.0, 4.0, 0.0])
    assert result.touching == 1


@pytest.mark.parametrize(("first", "last"), [(None, 1.0), (1.0, None)])
def test_no_changed_force_without_both(first: float | None, last: float | None) -> None:
    one, other = spatial(first, 0.1, (2.0, 2.0)), spatial(last, 0.1, (2.0, 2.0))
    assert changed(answer(3.0, 0.2, (2.0, 2.0)), one, other).all_touch_force.value is None


def test_a_force_next_to_nothing_is_the_changed_levels_own() -> None:
    floor, shares = NEGLIGIBLE * 4.0, (2.0, 2.0)
    after = spatial(0.3, 0.1, shares)
    for value, first in ((3.0, 0.9 * floor), (0.9 * floor, 3.0)):
        result = changed(answer(value, 0.2, shares), spatial(first, 0.1, shares), after)
        assert (result.all_touch_force.value, result.all_touch_force.error) == (0.3, pytest.approx(floor))
    usual = changed(answer(3.0, 0.2, shares), spatial(1.1 * floor, 0.1, shares), after)
    assert usual.all_touch_force.value == pytest.approx(3.0 * 0.3 / (1.1 * floor))
    one = changed(answer(0.0, 0.2, shares), spatial(0.0, 0.1, shares), spatial(0.0, 0.1, shares))
    assert (one.all_touch_force.value, one.all_touch_force.error) == (0.0, 0.0)  # it touches at once


def test_a_coarse_solid_that_overruns_the_budget_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch, corrected, solid_finite_strain)
    level = spatial(2.0, 0.1, (2.0, 2.0))

    def ends(_: object, __: float, seconds: dict[str, float], *___: object, **____: object) -> Any:
        clock.now += 3.0
        seconds.update(mesh=1.0, contact=2.0)
        return Correction(level, level, ERRORS)

    monkeypatch.setattr(corrected, "free_ends", ends)
    monkeypatch.setattr(solid_finite_strain, "solve", ends)
    design, fine = load("plain-ridges"), answer(3.0, 0.2, (2.0, 2.0))
    for budget, words in ((3.5, ()), (None, ()), (2.5, (" overran the budget of 2.5 s",))):
        request = Request(4.0, budget=budget)
        result = corrected.answer(design, request, None, fine)
        assert result.warnings == ("said before", *(f"the coarse solid{end}" for end in words))
        assert result.seconds == {"contact": 1.0, "solid": 3.0}
        for by_strain in (solid_finite_strain.answer, solid_finite_strain.on_corrected):
            result = by_strain(design, request, None, fine)
            assert result.warnings == (
                "said before",
                *(f"the solid with finite strain{end}" for end in words),
            )
            assert result.seconds == {"contact": 1.0, "finite mesh": 1.0, "finite contact": 2.0}


def test_a_tolerance_below_what_a_change_is_known_to_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    level = spatial(2.0, 0.1, (2.0, 2.0))
    strains = Correction(level, level, solid_finite_strain.ERRORS, out_of_range="F9 is beyond")
    monkeypatch.setattr(solid_finite_strain, "solve", lambda *_, **__: strains)
    design, fine = load("plain-ridges"), answer(3.0, 0.2, (2.0, 2.0))
    by_model = {
        solid_finite_strain.ERRORS: solid_finite_strain.answer,
        solid_finite_strain.COARSE_ERRORS: solid_finite_strain.on_corrected,  # nothing changes here
    }
    for errors, by_strain in by_model.items():
        known = max(vars(errors).values())
        for tol, missed in ((None, 0), (known, 0), (0.9 * known, 1)):
            said = by_strain(design, Request(4.0, tol), None, fine).warnings
            assert said[:2] == ("said before", "F9 is beyond")
            assert len(said) == 2 + missed
            assert not missed or f"is known to {known:g}: the tolerance" in said[-1]


def test_a_ridge_that_carries_anything_touches() -> None:
    """Shares of 0.4 N at the ends, by each way of adding changes."""
    fine, before, after = (
        kind(3.0, 0.2, (0.5 + by, 3.0 - 2 * by, 0.5 + by))
        for kind, by in ((answer, 0.0), (spatial, 0.1), (spatial, 0.0))
    )
    by_ends = changed(fine, before, after)
    in_solid = solid.estimated_answer(before, before, after)
    for result, outer in ((by_ends, 0.4), (in_solid, 0.5)):
        assert result.ridge_force[0].value == pytest.approx(outer)
        assert result.touching == 3
