"""The solid against plane strain, itself refined and docs/evidence/facts.md; the model that it corrects."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from skincad import check, load
from skincad import mechanics as mech
from skincad.base import InputError
from skincad.inputs import Design
from skincad.mechanics.bodies import prisms
from skincad.mechanics.contact import frictionless
from skincad.mechanics.models import corrected, linear, solid
from tests.mechanics import closed_forms
from tests.mechanics.bodies.test_elements import block
from tests.mechanics.designs import SHORT, THREE, assert_inside, filleted, reference, yamada

FEW = mech.Layers(0.6, 2.0, 3)
USUAL = mech.Layers(0.6, 2.0, 4)
FORCE = 1.3  # N on three ridges
FACTS = pytest.mark.evidence(subject="solid: facts")


def coarse(
    pad: mech.Pad, order: int = 2, along: mech.Layers | None = USUAL, force: float = 4.0, **how: Any
) -> mech.LevelAnswer:
    meshed = mech.meshed_piece(pad, mech.coarse_sizes(pad, 1.0))
    return mech.solve_level(meshed, mech.forms_of(meshed, order), along, force, {}, **how)


def whole_of(pad: mech.Pad, sizes: mech.Sizes) -> mech.PadPiece:
    return mech.PadPiece(pad, pad, False, mech.unit_of(pad), mech.triangles(pad, sizes))


@cache
def refined() -> mech.LevelAnswer:
    """Three ridges of the reference section: order 3 on a finer mesh and finer layers than any rung's."""
    pad = mech.pad_of(reference().with_(**THREE))
    meshed = mech.meshed_piece(pad, mech.coarse_sizes(pad, 2.0))
    return mech.solve_level(meshed, mech.forms_of(meshed, 3), mech.Layers(0.15, 1.8, 4), FORCE, {})


@pytest.mark.slow
@pytest.mark.parametrize("order", [2, pytest.param(3, marks=FACTS)])
def test_plane_strain_of_the_prisms_is_the_linear_model(order: int) -> None:
    """The whole section on the same mesh: the same functions. 1e-5: on curved triangles, where integrands
    are rational, ngsolve's quadrature of the parts differs from that of the whole (measured 4e-6, 2e-7)."""
    pad = mech.pad_of(reference())
    meshed = whole_of(pad, mech.default_sizes(pad, 0.25))
    solution = mech.solve_level(meshed, mech.forms_of(meshed, order), None, 4.0, {})
    exact = linear.level(meshed, order, 4.0)
    assert solution.approach == pytest.approx(exact.approach, rel=1e-5)
    assert solution.all_touch_force == pytest.approx(exact.all_touch_force, rel=1e-5)
    assert solution.ridge_force == pytest.approx(exact.ridge_force, rel=1e-4)


@pytest.mark.parametrize("order", [2, 3])
def test_plane_strain_on_straight_triangles_is_the_linear_model(order: int) -> None:
    """Quadrature is exact here: rounding only."""
    pad = block(3.0, 2.0, 0.499)
    meshed = whole_of(pad, mech.coarse_sizes(pad, 1.0))
    solution = mech.solve_level(meshed, mech.forms_of(meshed, order), None, 0.5, {})
    exact = linear.level(meshed, order, 0.5)
    assert solution.approach == pytest.approx(exact.approach, rel=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("film", [pytest.param(False, marks=FACTS), True])
def test_clamped_ends_are_plane_strain(film: bool) -> None:
    """With u_y = 0 at both ends the solution doesn't depend on y: rounding only, the film at 3750 E."""
    pad = mech.pad_of((yamada() if film else reference()).with_(**SHORT))
    meshed = mech.meshed_piece(pad, mech.coarse_sizes(pad, 1.0))
    forms = mech.forms_of(meshed, 2)
    plane = mech.solve_level(meshed, forms, None, 1.0, {})
    clamped = mech.solve_level(meshed, forms, FEW, 1.0, {}, clamped_end=True)
    assert clamped.approach == pytest.approx(plane.approach, rel=1e-8)
    assert clamped.all_touch_force == pytest.approx(plane.all_touch_force, rel=1e-7)
    assert clamped.ridge_force == pytest.approx(plane.ridge_force, rel=1e-7)


@pytest.mark.parametrize("order", [2, 3])
def test_patch_uniform_compression(order: int) -> None:
    """At nu = 0 the clamped back holds nothing sideways: the block shortens uniformly, rounding only."""
    pad = block(3.0, 2.0, 0.0)
    solution = coarse(pad, order, FEW, 0.5)
    assert solution.approach == pytest.approx(closed_forms.column_approach(0.5, 2.0, 6.0, 0.7), rel=1e-9)
    meshed = mech.meshed_piece(pad, mech.coarse_sizes(pad, 1.0))
    small, scale = mech.condensed_pad(meshed, mech.forms_of(meshed, order), FEW, {})
    ridges = frictionless.seen_by_plate(pad, small.seen, small.flexibility, meshed.unit)
    state = mech.press(ridges.flexibility, ridges.gap, 0.5 / scale)
    assert 0.7 * state.force / small.seen.nodes.weight == pytest.approx(0.5 / 6.0, rel=1e-7)


@pytest.mark.slow
def test_half_is_the_whole() -> None:
    """A mesh of half the section against one of all of it: at order 2 they differ by the mesh, 0.5 %; of F9,
    1.7 % of the force here, by that of the force."""
    pad = mech.pad_of(reference().with_(ridge={"count": 3}, skin={"width": 5.0, "length": 6.0}))
    sizes = mech.coarse_sizes(pad, 1.5)
    half = mech.meshed_piece(pad, sizes)
    assert half.mirrored
    whole = whole_of(pad, sizes)
    one, other = (mech.solve_level(m, mech.forms_of(m, 2), FEW, 1.0, {}) for m in (half, whole))
    assert one.approach == pytest.approx(other.approach, rel=5e-3)
    assert one.all_touch_force == pytest.approx(other.all_touch_force, abs=5e-3)
    assert one.ridge_force == pytest.approx(other.ridge_force, abs=5e-3)


def test_a_half_is_half_of_the_area() -> None:
    pad = mech.pad_of(filleted())
    half = mech.half_of(pad)
    assert half.section.area == pytest.approx(pad.section.area / 2, rel=1e-12)  # rounding
    assert mech.half_of(replace(pad, section=replace(pad.section, outline=pad.section.outline[1:]))) is None


def test_layers_integrate_polynomials() -> None:
    along = prisms.line(mech.graded(3.0, 0.5, 1.8), 4)
    y = along.at
    assert along.weight.sum() == pytest.approx(3.0, rel=1e-13)  # rounding
    assert y**4 @ along.mass @ y**2 == pytest.approx(3.0**7 / 7, rel=1e-12)
    assert y**2 @ along.slope @ y**3 == pytest.approx(3 * 3.0**5 / 5, rel=1e-12)
    assert y**3 @ along.stiff @ y**3 == pytest.approx(9 * 3.0**5 / 5, rel=1e-12)


@pytest.mark.evidence(subject="solid: facts")
def test_free_ends_as_in_the_facts() -> None:
    """docs/evidence/facts.md: approach 0.2224 mm, F9 23 % below 3.026 N, outer share doubled; meshes: 1 %."""
    solution = solid.solve(mech.pad_of(reference()), mech.Request(4.0))
    assert not solution.warnings
    assert solution.touching == 9
    assert solution.approach.value == pytest.approx(0.2224, rel=1e-2)
    assert solution.all_touch_force.value == pytest.approx(0.77 * 3.026, rel=1e-2)
    assert (solution.ridge_force[0].value or 0.0) / 0.0885 == pytest.approx(2.0, rel=3e-2)


@pytest.mark.parametrize(
    ("length", "approach"),
    [(6.0, 0.2395), *(pytest.param(*row, marks=FACTS) for row in ((24.0, 0.1999), (48.0, 0.1859)))],
)
def test_length_at_equal_force_per_length(length: float, approach: float) -> None:
    """Of docs/evidence/facts.md; 1.5 %: the coarse mesh is 0.7 % stiff in the section, theirs errs too."""
    pad = replace(mech.pad_of(reference()), length=length)
    solution = coarse(pad, force=4.0 * length / 12.0)
    assert solution.approach == pytest.approx(approach, rel=1.5e-2)


@pytest.mark.evidence(subject="solid: facts")
def test_bonded_strips_hold_the_ends() -> None:
    """Strips at 3750 times E resist the stretch along y, so free ends soften the pad less; measured 1.139
    against 1.280."""
    bare, bonded = mech.pad_of(reference()), mech.pad_of(yamada())
    ratios = [coarse(p).approach / coarse(p, along=None).approach for p in (bare, bonded)]
    assert ratios == pytest.approx([1.280, 1.139], abs=0.01)


@pytest.mark.evidence(subject="finer meshes: corrected")
def test_answer_holds_the_refined_solution_and_its_residual() -> None:
    solution, exact = solid.solve(mech.pad_of(reference().with_(**THREE)), mech.Request(FORCE)), refined()
    assert not solution.warnings
    assert solution.residual <= frictionless.COMPLEMENTARITY
    assert solution.touching == 3
    assert sum(f.value or 0.0 for f in solution.ridge_force) == pytest.approx(FORCE, rel=1e-9)
    assert_inside(solution, exact)
    answer = corrected.answer(reference().with_(**THREE), mech.Request(FORCE))
    assert_inside(answer, exact)
    # docs/evidence/facts.md: a coarse run's ratio is a fine one's to 0.5 %; the linear model's error aside
    assert answer.approach.value == pytest.approx(exact.approach, rel=5e-3)
    assert answer.all_touch_force.value == pytest.approx(exact.all_touch_force, rel=5e-3)


@pytest.mark.evidence(subject="{name}")
@pytest.mark.parametrize("name", ["plain-ridges", "fingertip-soft", "yamada-2002"])
def test_truth_lies_inside_for_templates(name: str) -> None:
    whole = load(name)
    design: Design = whole.with_(
        ridge={"count": 3},
        skin={
            "width": 3 * whole.ridge.pitch + 2.0,
            "curvature_radius": whole.skin.curvature_radius * 2 / (whole.ridge.count - 1),
        },
    )
    pad, force = mech.pad_of(design), whole.contact.force * 3 / whole.ridge.count
    meshed = mech.meshed_piece(pad, mech.coarse_sizes(pad, 1.5))
    exact = mech.solve_level(meshed, mech.forms_of(meshed, 3), mech.Layers(0.15, 1.8, 4), force, {})
    for answer in (solid.answer, corrected.answer):
        assert_inside(answer(design, mech.Request(force)), exact)


def test_too_large_a_pad_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solid, "MOST_UNKNOWNS", 1000)
    with pytest.raises(InputError, match=r"three dimensions take at most 1000 unknowns.*the linear model"):
        solid.solve(mech.pad_of(reference()), mech.Request(4.0))


@pytest.mark.parametrize("growth", [1.8, 2.0])
@pytest.mark.parametrize("half", [0.1, 1.5, 6.0, 50.0])
def test_layers_grow_from_the_end_by_one_factor_and_are_two_at_least(half: float, growth: float) -> None:
    borders = mech.graded(half, 0.5, growth)
    sizes = np.diff(borders)
    assert (borders[0], borders[-1]) == (0.0, pytest.approx(half, rel=1e-13))
    assert sizes[:-1] / sizes[1:] == pytest.approx(growth, rel=1e-9)
    assert sizes.size >= 2
    # as near to the thickness asked for as whole layers come: one layer more or less is a factor of growth
    if sizes.size > 2:
        assert 0.5 / growth < sizes[-1] < 0.5 * growth
        nearer = [half * (growth - 1) / (growth**n - 1) for n in (sizes.size - 1, sizes.size, sizes.size + 1)]
        assert min(range(3), key=lambda i: abs(np.log(nearer[i] / 0.5))) == 1
    else:
        assert sizes[-1] == pytest.approx(half / (1 + growth), rel=1e-12)


@pytest.mark.evidence(subject="finer meshes: corrected")
def test_small_fillets_and_finer_layers_leave_the_change_alone() -> None:
    """What a sharp section spares: the change of approach and F9 differ by less than half their error."""
    design = filleted().with_(**THREE)
    with_fillets, without = (
        corrected.free_ends(pad, FORCE, {}) for pad in (mech.pad_of(design), corrected.plain_pad(design))
    )
    error = corrected.ERRORS
    assert approach_ratio(with_fillets) == pytest.approx(approach_ratio(without), rel=error.approach / 2)
    assert threshold_ratio(with_fillets) == pytest.approx(threshold_ratio(without), rel=error.threshold / 2)
    few, many = (
        corrected.free_ends(mech.pad_of(reference().with_(**THREE)), FORCE, {}, along).after
        for along in (corrected.LAYERS, mech.Layers(0.15, 1.8, 4))
    )
    assert few.approach == pytest.approx(many.approach, rel=error.approach / 2)
    assert few.all_touch_force == pytest.approx(many.all_touch_force, rel=error.threshold)


VARIANTS = {
    "thin": {"skin": {"thickness": 2.0}},
    "thick": {"skin": {"thickness": 8.0}},
    "high": {"ridge": {"height": 0.7}},
    "short": {"skin": {"length": 6.0}},
    "round": {"ridge": {"tip_fillet": 0.12}},
    "incompressible": {"material": {"poisson_ratio": 0.49999}},
}


@pytest.mark.evidence(subject="finer meshes: corrected")
@pytest.mark.parametrize("name", VARIANTS)
def test_the_changes_error_on_variants(name: str) -> None:
    """Against order 3 with fillets on a finer mesh and finer layers, both sides."""
    design = filleted().with_(**THREE).with_(**VARIANTS[name])
    coarse = corrected.free_ends(corrected.plain_pad(design), FORCE, {})
    pad = mech.pad_of(design)
    meshed = mech.meshed_piece(pad, mech.coarse_sizes(pad, 1.25))
    forms = mech.forms_of(meshed, 3)
    plane, solid = (
        mech.solve_level(meshed, forms, along, FORCE, {}) for along in (None, mech.Layers(0.3, 1.8, 4))
    )
    fine = mech.Correction(plane, solid, corrected.ERRORS)
    assert approach_ratio(coarse) == pytest.approx(approach_ratio(fine), rel=corrected.ERRORS.approach)
    assert threshold_ratio(coarse) == pytest.approx(threshold_ratio(fine), rel=corrected.ERRORS.threshold)
    change = [e.after.ridge_force - e.before.ridge_force for e in (coarse, fine)]
    assert change[0] == pytest.approx(change[1], abs=corrected.ERRORS.share * FORCE / 3)


def approach_ratio(ends: mech.Correction) -> float:
    return ends.after.approach / ends.before.approach


def threshold_ratio(ends: mech.Correction) -> float:
    return (ends.after.all_touch_force or 0.0) / (ends.before.all_touch_force or 1.0)


@pytest.mark.slow
def test_a_long_pad_is_hardly_changed() -> None:
    """The ends' share falls as 1 / L: the 28 % of docs/evidence/facts.md at 12 mm is 0.7 % at 480 mm."""
    long = reference().with_(**THREE).with_(skin={"length": 480.0})
    ends = corrected.free_ends(mech.pad_of(long), 40 * FORCE, {})
    assert 1.0 < ends.after.approach / ends.before.approach < 1.01


@pytest.mark.slow
@pytest.mark.parametrize("force", [1e-3, 20.0])
def test_light_and_heavy_forces(force: float) -> None:
    answer = corrected.answer(filleted().with_(**THREE), mech.Request(force, tol=0.05))
    assert sum(f.value or 0.0 for f in answer.ridge_force) == pytest.approx(force, rel=1e-9)
    assert all((f.value or 0.0) >= 0.0 for f in answer.ridge_force)


@pytest.mark.slow
def test_a_tolerance_below_the_changes_error_is_said() -> None:
    verdict = check(reference().with_(**THREE), force=FORCE, model="corrected", tol=4e-3)
    assert any("the tolerance 0.004 is not met" in w for w in verdict.warnings)


@pytest.mark.slow
def test_a_part_measured_as_designed_is_corrected_as_designed() -> None:
    """On the whole pad's mesh instead of its half's: two coarse meshes, half the change's own error."""
    design = reference().with_(**THREE)
    part = corrected.answer(design, mech.Request(FORCE, 0.05, crest_offsets=(0.0,) * 3))
    whole = corrected.answer(design, mech.Request(FORCE, 0.05))
    assert part.all_touch_force.value == pytest.approx(
        whole.all_touch_force.value, rel=corrected.ERRORS.threshold / 2
    )
    assert part.approach.value == pytest.approx(whole.approach.value, rel=corrected.ERRORS.approach / 2)


@pytest.mark.slow
def test_a_lower_crest_delays_the_touch_with_free_ends_too() -> None:
    design = reference()
    drops = (0.01, *(0.0,) * 8)
    plane, ends = (
        model.answer(design, mech.Request(4.0, 0.05, crest_offsets=drops)) for model in (linear, corrected)
    )
    base = linear.answer(design, mech.Request(4.0, 0.05)), corrected.answer(design, mech.Request(4.0, 0.05))
    delay = [
        (low.all_touch_force.value or 0.0) / (as_made.all_touch_force.value or 1.0) - 1
        for low, as_made in zip((plane, ends), base, strict=True)
    ]
    assert delay[0] > 0.05
    assert delay[1] == pytest.approx(delay[0], rel=0.15)  # free ends soften the pad, nearly alike everywhere


@pytest.mark.slow
def test_a_shaped_plate_is_corrected() -> None:
    tilted = reference().with_(contact={"plate": {"shape": "tilted", "tilt": 0.3}})
    plane, ends = (model.answer(tilted, mech.Request(4.0, 0.05)) for model in (linear, corrected))
    assert 0.6 < (ends.all_touch_force.value or 0.0) / (plane.all_touch_force.value or 1.0) < 0.95
    assert (ends.ridge_force[0].value or 0.0) > (ends.ridge_force[-1].value or 0.0)


def test_the_coarse_pad_has_sharp_corners_in_place_of_small_fillets() -> None:
    round_, plain = mech.pad_of(filleted()), corrected.plain_pad(filleted())
    assert {"tip_fillet", "root_fillet"} <= {s.kind for s in round_.section.outline}
    assert not {"tip_fillet", "root_fillet"} & {s.kind for s in plain.section.outline}
    large = filleted().with_(ridge={"tip_fillet": 0.15})
    assert corrected.plain_pad(large).section.outline == mech.pad_of(large).section.outline
