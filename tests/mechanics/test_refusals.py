"""Nothing that was solved is lost by what refuses after it; what is too large is told before it is solved."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skincad import load
from skincad.inputs import Design
from skincad.mechanics import (
    ContactError,
    Request,
    RidgeModel,
    SizeError,
    default_sizes,
    film_stresses,
    pad_of,
    plane_piece,
    triangles,
)
from skincad.mechanics import check as adaptivity
from skincad.mechanics.bodies import elements
from skincad.mechanics.check import check
from skincad.mechanics.film import sliding, stress
from skincad.mechanics.manufacture import manufacture
from skincad.mechanics.models import finite_strain, linear, solid
from skincad.mechanics.problem import Spread, one_ridge
from skincad.scenes import simulate
from tests.mechanics.designs import linear_check, plane, wide
from tests.small_scene import THIRD, small_scene

# two columns with a base of their own height: both touch at once, the all-touch force is rounding
COLUMNS = [
    *("ridge.count=2", "ridge.pitch=10.343", "ridge.height=8.2", "ridge.root_width=8.2745"),
    *("ridge.tip_width=5.792", "ridge.crown=0.29", "ridge.tip_fillet=0.029", "ridge.root_fillet=1.03"),
    *("skin.curvature_radius=24.8", "skin.width=24.8", "skin.thickness=41.6", "skin.length=7.45"),
]


@pytest.fixture(scope="module")
def small() -> Design:
    return load("plain-ridges", ["ridge.count=3", "skin.width=5.0", "contact.force=1.3"])


def contact(design: Design, fineness: float, order: int) -> int:
    """Contact unknowns of the plane at this mesh and order."""
    pad = pad_of(design)
    return linear.contact_unknowns(plane_piece(pad, fineness), order)


def unsolved(*arguments: Any, **options: Any) -> Any:
    raise AssertionError("solved, and then refused")


def test_a_finer_mesh_that_is_too_large_leaves_the_last_ones_answer(
    small: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    pad = pad_of(small)
    best = linear.level(plane_piece(pad, 1.0), 3, small.contact.force)
    monkeypatch.setattr(linear, "MOST_CONTACT_UNKNOWNS", contact(small, 1.0, 3))
    answer = plane(small, tol=1e-4)
    assert answer.unknowns == best.unknowns
    assert answer.all_touch_force.value == best.all_touch_force
    assert any("a finer mesh takes more than" in w for w in answer.warnings)


def test_a_first_mesh_that_is_too_large_gives_way_to_a_coarser(
    small: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    fine, coarse = contact(small, 1.0, 3), contact(small, 0.5, 3)
    assert coarse < fine
    before = linear_check(small, tol=2e-3)
    monkeypatch.setattr(linear, "MOST_CONTACT_UNKNOWNS", coarse)
    verdict = linear_check(small, tol=2e-3)
    assert verdict.unknowns < before.unknowns
    assert any("a finer mesh takes more than" in w for w in verdict.warnings)
    difference = abs(verdict.all_touch_force.value - before.all_touch_force.value)
    assert difference <= verdict.all_touch_force.error  # what it says of itself holds


def test_what_fits_no_mesh_is_refused_unsolved_and_auto_takes_the_closed_form(
    small: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(linear, "MOST_CONTACT_UNKNOWNS", contact(small, 0.5, 3) - 1)
    monkeypatch.setattr(linear, "_level", unsolved)
    with pytest.raises(SizeError, match=r"ridge\.count: the linear model takes at most"):
        linear_check(small)
    for options in ({}, {"tol": 0.01}, {"budget": 500.0}):
        verdict = check(small, **options)
        assert verdict.model == "winkler"
        assert verdict.all_touch_force == check(small, model="winkler").all_touch_force
        assert any(
            "model, which leaves out less, cannot judge this: ridge.count" in w for w in verdict.warnings
        )


def test_far_too_many_ridges_are_told_by_one_of_them_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    meshed: list[int] = []

    def counted(pad: Any, sizes: Any) -> Any:
        meshed.append(len(pad.ridges))
        return triangles(pad, sizes)

    monkeypatch.setattr(linear, "MOST_CONTACT_UNKNOWNS", 3000)
    monkeypatch.setattr(linear, "triangles", counted)
    verdict = check(wide(120), budget=10.0)  # the reduced model takes longer
    assert (verdict.model, verdict.ridges, meshed) == ("winkler", 120, [1])


def test_as_many_ridges_as_a_design_may_have_are_not_too_many() -> None:
    most = linear.MOST_CONTACT_UNKNOWNS
    design = load("plain-ridges", ["ridge.count=999", "skin.width=1000", "skin.curvature_radius=1e6"])
    linear.check_coarsest(pad_of(design), most, "linear")
    with pytest.raises(SizeError, match=r"ridge\.count: the finite-strain model takes at most 6000"):
        finite_strain.solve(pad_of(design), Request(450.0))


@pytest.mark.parametrize("name", ["plain-ridges", "fingertip-soft", "milled-pad", "nozzle-04"])
def test_one_ridge_alone_does_not_ask_for_much_more_than_its_share(name: str) -> None:
    pad = pad_of(load(name))
    sizes = default_sizes(pad, linear.REFINEMENTS[0].fineness)
    alone, whole = (
        elements.contact_unknowns(elements.curved(triangles(p, sizes), 1), 1) for p in (one_ridge(pad), pad)
    )
    assert whole >= linear.SINGLE_RIDGE_FACTOR * alone * len(pad.ridges)
    assert linear.contact_unknowns(plane_piece(pad, 0.5), 1) >= linear.SINGLE_RIDGE_FACTOR * alone * len(
        pad.ridges
    )


def test_a_better_model_that_is_too_large_leaves_the_one_before(
    small: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(solid, "MOST_CONTACT", 10)
    verdict = check(small, tol=0.02)
    assert verdict.model == "linear"
    assert verdict.all_touch_force == linear_check(small, tol=adaptivity.FINEST_TOLERANCE).all_touch_force
    assert any(
        "the corrected model, which leaves out less, cannot judge this: ridge.count" in w
        for w in verdict.warnings
    )


def test_a_solid_is_refused_before_any_of_its_levels_is_solved(
    small: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes: list[int] = []
    check_size = solid.check_size

    def seen(forms: Any, line: Any) -> None:
        sizes.append(3 * forms.clamped.size * line.at.size)
        check_size(forms, line)

    monkeypatch.setattr(solid, "check_size", seen)
    monkeypatch.setattr(solid, "solve_level", unsolved)
    with pytest.raises(AssertionError, match="solved, and then refused"):
        check(small, model="solid")
    assert len(sizes) == 2
    # what the first level takes, and not all do
    monkeypatch.setattr(solid, "MOST_UNKNOWNS", min(sizes))
    with pytest.raises(SizeError, match="three dimensions take at most"):
        check(small, model="solid")


@pytest.mark.slow
def test_film_stresses_keep_the_last_mesh(monkeypatch: pytest.MonkeyPatch) -> None:
    design = load("yamada-2002", ["ridge.count=3", "skin.width=5.0"])
    whole = film_stresses(design, 1.3, (0.0,), tol=0.5)[0]
    orders: list[int] = []
    counted = stress.contact_unknowns

    def seen(mesh: Any, order: int) -> int:
        orders.append(counted(mesh, order))
        return orders[-1]

    monkeypatch.setattr(stress, "contact_unknowns", seen)
    film_stresses(design, 1.3, (0.0,), tol=0.5)
    monkeypatch.setattr(stress, "MOST_CONTACT_UNKNOWNS", max(orders))
    finest = film_stresses(design, 1.3, (0.0,), tol=1e-6)[0]
    assert finest.differential == whole.differential
    assert any("a finer mesh takes more than" in w for w in finest.warnings)
    monkeypatch.setattr(stress, "MOST_CONTACT_UNKNOWNS", orders[0] - 1)
    monkeypatch.setattr(stress, "level", unsolved)
    with pytest.raises(SizeError, match="films' stresses take at most"):
        film_stresses(design, 1.3, (0.0,))


def test_a_scene_keeps_the_mesh_that_it_marched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = small_scene(tmp_path, "yamada-2002-press", THIRD, "history.steps=4", "readout.ridges=[1, 3]")
    orders: list[int] = []
    counted = elements.contact_unknowns

    def seen(mesh: Any, order: int) -> int:
        orders.append(counted(mesh, order))
        return orders[-1]

    monkeypatch.setattr(elements, "contact_unknowns", seen)
    simulate(scene, budget=1e-3)
    monkeypatch.setattr(sliding, "MOST_CONTACT_UNKNOWNS", 2 * 2 * orders[0])  # both components, both halves
    simulation = simulate(scene)
    assert any(
        "a finer mesh is refused (ridge.count: a scene takes at most" in w for w in simulation.warnings
    )
    assert len(simulation.march.readings) == 5
    assert simulation.error is None


def test_two_columns_that_touch_at_once_have_a_verdict_and_a_yield() -> None:
    verdict = check(load("plain-ridges", [*COLUMNS, "contact.force=4.0"]))
    assert verdict.touching == 2
    assert verdict.manufacture is not None
    # both touch from next to nothing on, and crests of 0.015 mm against an approach of 1.3 mm change little
    assert verdict.manufacture.passing.value == pytest.approx(1.0, abs=0.01)
    assert max(verdict.manufacture.crest_sensitivity) < 10.0  # N/mm; 4 N press them by 1.3 mm


@pytest.mark.parametrize("place", ["manufacture", "ridge model"])
def test_a_yield_that_does_not_settle_is_no_veto(
    place: str, small: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = linear_check(small, tol=0.05)

    def unsettled(*_: Any) -> Any:
        raise ContactError("does not settle")

    if place == "manufacture":
        monkeypatch.setattr("skincad.mechanics.manufacture.manufacture", unsettled)
    else:
        monkeypatch.setattr(linear, "ridge_model", unsettled)
    verdict = linear_check(small, tol=0.05)
    assert (verdict.passed, verdict.all_touch_force) == (whole.passed, whole.all_touch_force)
    assert (verdict.manufacture, whole.manufacture is None) == (None, False)
    assert "no yield: does not settle" in verdict.warnings
    assert verdict.as_json()["yield"] is None


@pytest.mark.parametrize(("ridges", "parts"), [(9, 4096), (33, 3848), (48, 1816)])
def test_many_ridges_are_judged_by_fewer_parts_and_the_error_says_so(ridges: int, parts: int) -> None:
    """Springs that do not feel each other, as high as each other: all touch in every part."""
    force = np.linspace(0.0, 1.0, 5)
    springs = RidgeModel(
        np.zeros(ridges), np.zeros((ridges, ridges)), force, np.tile(force, (ridges, 1)), 1.0, 1.0
    )
    result = manufacture(springs, 0.5 * ridges, 1e-9, Spread("sla", 1e-3, (0.8, 0.8, 0.8)))
    assert result.passing.value == 1.0
    # Wilson's score interval at 95 % if none of n fails: 1 - z^2 / (n + z^2)
    assert result.passing.error == pytest.approx(1.96**2 / (parts + 1.96**2), rel=1e-9)
