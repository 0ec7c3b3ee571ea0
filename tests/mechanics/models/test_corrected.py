"""The corrected model against the solid refined, and what it keeps."""

from __future__ import annotations

import pytest

from skincad import check
from skincad.mechanics import Layers, Request, coarse_sizes, forms_of, meshed_piece, pad_of, solve_level
from skincad.mechanics.models import corrected, linear
from tests.mechanics.designs import THREE, filleted, reference
from tests.mechanics.models.test_solid import FORCE, assert_inside, refined


@pytest.mark.evidence(subject="finer meshes: corrected")
def test_refined_solid_lies_inside() -> None:
    answer = corrected.answer(reference().with_(**THREE), Request(FORCE))
    assert_inside(answer, refined())
    # docs/evidence/facts.md: a coarse run's ratio is a fine one's to 0.5 %; the linear model's error aside
    assert answer.approach.value == pytest.approx(refined().approach, rel=5e-3)
    assert answer.all_touch_force.value == pytest.approx(refined().all_touch_force, rel=5e-3)


@pytest.mark.evidence(subject="finer meshes: corrected")
def test_small_fillets_leave_the_change_alone() -> None:
    """What a sharp section spares: the change of approach and F9 differ by less than half their error."""
    design = filleted().with_(**THREE)
    with_fillets = corrected.free_ends(pad_of(design), FORCE, {})
    without = corrected.free_ends(corrected.plain_pad(design), FORCE, {})
    ratios = [(approach_ratio(e), threshold_ratio(e)) for e in (with_fillets, without)]
    assert ratios[0][0] == pytest.approx(ratios[1][0], rel=corrected.ERRORS.approach / 2)
    assert ratios[0][1] == pytest.approx(ratios[1][1], rel=corrected.ERRORS.threshold / 2)


@pytest.mark.evidence(subject="finer meshes: corrected")
def test_finer_layers_change_less_than_the_error() -> None:
    pad = pad_of(reference().with_(**THREE))
    few, many = (
        corrected.free_ends(pad, FORCE, {}, along) for along in (corrected.LAYERS, Layers(0.15, 1.8, 4))
    )
    assert few.solid.approach == pytest.approx(many.solid.approach, rel=corrected.ERRORS.approach / 2)
    assert few.solid.all_touch_force == pytest.approx(
        many.solid.all_touch_force, rel=corrected.ERRORS.threshold
    )


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
    pad = pad_of(design)
    meshed = meshed_piece(pad, coarse_sizes(pad, 1.25))
    forms = forms_of(meshed, 3)
    plane, solid = (solve_level(meshed, forms, along, FORCE, {}) for along in (None, Layers(0.3, 1.8, 4)))
    fine = corrected.Ends(plane, solid)
    assert approach_ratio(coarse) == pytest.approx(approach_ratio(fine), rel=corrected.ERRORS.approach)
    assert threshold_ratio(coarse) == pytest.approx(threshold_ratio(fine), rel=corrected.ERRORS.threshold)
    change = [e.solid.ridge_force - e.plane.ridge_force for e in (coarse, fine)]
    assert change[0] == pytest.approx(change[1], abs=corrected.ERRORS.share * FORCE / 3)


def approach_ratio(ends: corrected.Ends) -> float:
    return ends.solid.approach / ends.plane.approach


def threshold_ratio(ends: corrected.Ends) -> float:
    return (ends.solid.all_touch_force or 0.0) / (ends.plane.all_touch_force or 1.0)


def test_a_long_pad_is_hardly_changed() -> None:
    """The ends' share falls as 1 / L: the 28 % of docs/evidence/facts.md at 12 mm is 0.7 % at 480 mm."""
    long = reference().with_(**THREE).with_(skin={"length": 480.0})
    ends = corrected.free_ends(pad_of(long), 40 * FORCE, {})
    assert 1.0 < ends.solid.approach / ends.plane.approach < 1.01


@pytest.mark.slow
@pytest.mark.parametrize("force", [1e-3, 20.0])
def test_light_and_heavy_forces(force: float) -> None:
    answer = corrected.answer(filleted().with_(**THREE), Request(force, tol=0.05))
    assert sum(f.value or 0.0 for f in answer.ridge_force) == pytest.approx(force, rel=1e-9)
    assert all((f.value or 0.0) >= 0.0 for f in answer.ridge_force)


@pytest.mark.slow
def test_a_tolerance_below_the_changes_error_is_said() -> None:
    verdict = check(reference().with_(**THREE), force=FORCE, model="corrected", tol=4e-3)
    assert any("the tolerance 0.004 is not met" in w for w in verdict.warnings)


def test_a_part_measured_as_designed_is_corrected_as_designed() -> None:
    """On the whole pad's mesh instead of its half's: two coarse meshes, half the change's own error."""
    design = reference().with_(**THREE)
    part = corrected.answer(design, Request(FORCE, 0.05, crest_offsets=(0.0,) * 3))
    whole = corrected.answer(design, Request(FORCE, 0.05))
    assert part.all_touch_force.value == pytest.approx(
        whole.all_touch_force.value, rel=corrected.ERRORS.threshold / 2
    )
    assert part.approach.value == pytest.approx(whole.approach.value, rel=corrected.ERRORS.approach / 2)


@pytest.mark.slow
def test_a_lower_crest_delays_the_touch_with_free_ends_too() -> None:
    design = reference()
    drops = (0.01, *(0.0,) * 8)
    plane, ends = (
        model.answer(design, Request(4.0, 0.05, crest_offsets=drops)) for model in (linear, corrected)
    )
    base = linear.answer(design, Request(4.0, 0.05)), corrected.answer(design, Request(4.0, 0.05))
    delay = [
        (low.all_touch_force.value or 0.0) / (as_made.all_touch_force.value or 1.0) - 1
        for low, as_made in zip((plane, ends), base, strict=True)
    ]
    assert delay[0] > 0.05
    assert delay[1] == pytest.approx(delay[0], rel=0.15)  # free ends soften the pad, nearly alike everywhere


@pytest.mark.slow
def test_a_shaped_plate_is_corrected() -> None:
    tilted = reference().with_(contact={"plate": {"shape": "tilted", "tilt": 0.3}})
    plane, ends = (model.answer(tilted, Request(4.0, 0.05)) for model in (linear, corrected))
    assert 0.6 < (ends.all_touch_force.value or 0.0) / (plane.all_touch_force.value or 1.0) < 0.95
    assert (ends.ridge_force[0].value or 0.0) > (ends.ridge_force[-1].value or 0.0)


def test_the_coarse_pad_has_sharp_corners_in_place_of_small_fillets() -> None:
    round_, plain = pad_of(filleted()), corrected.plain_pad(filleted())
    assert {"tip_fillet", "root_fillet"} <= {s.kind for s in round_.section.outline}
    assert not {"tip_fillet", "root_fillet"} & {s.kind for s in plain.section.outline}
    large = filleted().with_(ridge={"tip_fillet": 0.15})
    assert corrected.plain_pad(large).section.outline == pad_of(large).section.outline
