"""The neo-Hookean model and pads of any law: closed forms, tangent, limits, facts, refusals."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from skincad import mechanics as mech
from skincad.base import InputError
from skincad.effects import FiniteStrain
from skincad.laws import Gent, NeoHooke, Ogden, Rubber, Yeoh
from skincad.mechanics.bodies import elements, plane_body
from skincad.mechanics.contact import newton as pressing
from skincad.mechanics.models import finite_strain, linear, solid_finite_strain
from skincad.scenes.march import march
from tests.laws.test_laws import plane_stress
from tests.mechanics.bodies.test_elements import block
from tests.mechanics.contact.test_dragged import affine, whole
from tests.mechanics.designs import THREE, assert_inside, filleted, reference, value, void_slots, yamada

LIMITS = pytest.mark.evidence(subject="finite strain: limits")
COARSE = 1e-2  # tolerance that takes the cheapest refinement


def solved(design: Any, force: float = 4.0, tol: float = COARSE) -> mech.Answer:
    return finite_strain.answer(design, mech.Request(force, tol))


def soft() -> Any:
    """13 soft ridges, closely set, on a thick base."""
    skin = {"curvature_radius": 120.0, "thickness": 8.0, "width": 22.0, "length": 22.0}
    flank = {"height": 1.0, "root_width": 1.05, "tip_width": 0.7, "crown": 0.05}
    ridge = {"count": 13, "pitch": 1.5, "tip_fillet": 0.1, "root_fillet": 0.15, **flank}
    return filleted().with_(skin=skin, ridge=ridge, material={"young_modulus": 0.1, "poisson_ratio": 0.4995})


def shares(answer: mech.Answer) -> np.ndarray:
    return np.array([value(f) for f in answer.ridge_force])


def coarse(design: Any, order: int = 2) -> pressing.PressedPad:
    pad = mech.pad_of(design)
    mesh = elements.curved(mech.triangles(pad, mech.default_sizes(pad, 0.5)), order)
    materials = {"skin": (1.0, pad.poisson_ratio), "film": (3750.0, 0.35)}
    return pressing.PressedPad(plane_body.body(mesh, order, materials), pad.top / mech.unit_of(pad))


def test_a_block_shortens_as_the_closed_form() -> None:
    """At nu = 0 a clamped block stays straight and its nominal stress is G (1/l - l), G = E / 2.

    The small-strain law at its clamped ends disturbs it: 2 %, of a strain of 20 %, in 0.5 % of the height.
    """
    pad = block(3.0, 2.0, 0.0)
    force, area, shear = 0.9, 6.0, 0.35
    ratio = force / area / shear
    stretch = (np.sqrt(ratio**2 + 4) - ratio) / 2
    solution = finite_strain.level(mech.plane_piece(pad, 0.5), 3, force)
    assert solution.approach == pytest.approx(2.0 * (1 - stretch), rel=1e-4)
    assert solution.pressure == pytest.approx(force / area, rel=0.02)


def test_tangent_is_the_residuals_derivative() -> None:
    """Condensed tangent against central differences at a random state; 1e-6: their truncation."""
    body = coarse(reference().with_(ridge={"count": 2})).body
    random = np.random.default_rng(7)
    state = 2e-3 * random.standard_normal(body.free.size)
    assert np.isfinite(body.energy(state))
    at = body.linearised(state, np.zeros_like(state))
    free = np.concatenate([body.rest.interior, body.rest.contact])
    step = np.zeros_like(state)
    step[free] = random.standard_normal(free.size)
    whole = at.recover(step)  # what is inside the elements follows, so that its residual stays
    size = 1e-6 / np.abs(whole).max()
    after, before = (body.residual(state + s * size * whole) for s in (1, -1))
    slope = (after - before) / (2 * size)
    wanted = at.matrix @ step
    assert np.abs(slope[free] - wanted[free]).max() <= 1e-6 * np.abs(wanted).max()
    inside = body.free.copy()
    inside[free] = False
    assert np.abs(slope[inside]).max() <= 1e-6 * np.abs(wanted).max()


@pytest.mark.slow
def test_at_rest_it_is_the_linear_stiffness() -> None:
    pad = mech.pad_of(yamada())
    mesh = elements.curved(mech.triangles(pad, mech.default_sizes(pad, 0.5)), 2)
    materials = {"skin": (1.0, pad.poisson_ratio), "film": (3750.0, 0.35)}
    wanted = elements.assemble(mesh, 2, materials).matrix
    rest = plane_body.body(mesh, 2, materials).rest.matrix
    assert abs(rest - wanted).max() <= 1e-12 * abs(wanted).max()  # rounding


@pytest.mark.slow
def test_newton_converges_quadratically(monkeypatch: pytest.MonkeyPatch) -> None:
    """From rest in one step, a new tangent in each: in the last steps the residual's exponent grows by 1.7 or
    more. A kept tangent takes more steps and ends at the same state."""
    pad = coarse(filleted().with_(**THREE))
    kept = pressing.newton(pad, np.zeros(pad.body.free.size), lambda *_: 0.25)
    monkeypatch.setattr(pressing, "NEAR", 0.0)
    state = pressing.newton(pad, np.zeros(pad.body.free.size), lambda *_: 0.25)
    assert kept.contact.approach == pytest.approx(state.contact.approach, rel=1e-9)  # the residual
    assert len(kept.history) >= len(state.history)
    assert len(state.history) <= 6
    before, here, after = np.log10(np.array(state.history[:4])[-3:])
    assert here < -2
    assert after / here > 1.7
    assert before > here
    assert state.history[-1] <= pressing.RESIDUAL


@pytest.mark.slow
def test_all_touch_force_is_where_the_last_ridge_starts() -> None:
    """Independent of the root: plain presses just below and above have 3 and 5 ridges in touch."""
    pad = coarse(reference().with_(ridge={"count": 5}, skin={"width": 7.0}))
    state = pressing.press_to(pad, 0.2)
    solution = pressing.press_until_all_touch(pad, state)
    for share, touching in ((0.998, 3), (1.002, 5)):
        near = pressing.press_to(pad, share * solution.force)
        ridges = near.ridges
        carried = [near.contact.force[ridges.of_point == r].sum() for r in ridges.numbers]
        assert np.count_nonzero(carried) == touching
    other = pressing.press_until_all_touch(pad, pressing.press_to(pad, 1e-3))  # from another side
    # the residuals' 1e-9, times the gap's slope
    assert other.force == pytest.approx(solution.force, rel=1e-7)


@pytest.mark.parametrize("force", [0.04, pytest.param(0.004, marks=LIMITS)])
def test_light_loads_are_linear(force: float) -> None:
    """The distance to the linear model is of the order of the strain, which is approach over ridge height."""
    design = reference().with_(**THREE)
    one, other = solved(design, force, 0.9), linear.answer(design, mech.Request(force, 0.9))
    strain = value(other.approach) / design.ridge.height
    assert one.touching == other.touching == 1
    assert value(one.approach) == pytest.approx(value(other.approach), rel=strain)
    assert shares(one) == pytest.approx(shares(other), abs=strain * force)


@pytest.mark.slow
def test_reference_section_against_facts() -> None:
    """docs/evidence/facts.md#what-a-model-leaves-out: approach about -4 %, outer share -25 to -45 %.

    Its F9 "about +10 %" comes out as +5 %, as the outer share's -25 % asks for: that share starts at F9 and
    grows by 0.09 N per N. Bounds wide enough for both. Outer crests 0.025 mm low: F9 32 % higher by
    docs/evidence/facts.md#manufacture; here a third too.
    """
    one, other = solved(reference()), linear.answer(reference(), mech.Request(4.0, COARSE))
    assert -0.05 < value(one.approach) / value(other.approach) - 1 < -0.03
    assert -0.45 < shares(one)[0] / shares(other)[0] - 1 < -0.23
    assert 0.03 < value(one.all_touch_force) / value(other.all_touch_force) - 1 < 0.12
    assert value(one.all_touch_force) == pytest.approx(3.178, rel=4e-3)  # the rung's error
    assert one.touching == 9
    assert one.residual <= pressing.RESIDUAL
    low = finite_strain.answer(
        reference(), mech.Request(4.0, COARSE, crest_offsets=(0.025, *[0.0] * 7, 0.025))
    )
    assert 1.25 < value(low.all_touch_force) / value(one.all_touch_force) < 1.45


@pytest.mark.parametrize("ratio", [pytest.param(r, marks=LIMITS) for r in (0.0, 0.49999, 0.4999999)])
def test_any_poisson_ratio(ratio: float) -> None:
    answer = solved(reference().with_(**THREE, material={"poisson_ratio": ratio}), 1.3)
    assert answer.touching == 3
    assert answer.residual <= pressing.RESIDUAL


def test_a_single_ridge_that_tips_over_is_refused() -> None:
    with pytest.raises(InputError, match=r"^force: .* \(up to about 2\.\d+ N\): ridge 1 tips over"):
        solved(reference().with_(ridge={"count": 1}, skin={"width": 3.0}), 4.0)


@LIMITS
def test_a_soft_pad_that_its_plate_holds_up_against_an_independent_solver() -> None:
    """Free, its ridges would buckle above 2.8 N. 1e-3: both of them solve the section to that."""
    answer = solved(soft(), 3.2, 2e-3)
    assert value(answer.approach) == pytest.approx(0.4762, rel=1e-3)
    assert value(answer.all_touch_force) == pytest.approx(2.387, rel=1e-3)
    assert answer.touching == 13


@LIMITS
def test_the_lightest_load() -> None:
    answer = solved(filleted().with_(**THREE), 1e-6)
    assert answer.touching == 1
    assert answer.residual <= pressing.RESIDUAL


@pytest.mark.slow
def test_an_overload_is_refused_with_its_range() -> None:
    with pytest.raises(
        InputError, match=r"^force: must lie .* \(up to about [1-9]\.\d+ N\): .*; take a"
    ) as caught:
        solved(filleted().with_(**THREE), 40.0)
    assert caught.value.value == pytest.approx(40.0)


@LIMITS
def test_a_threshold_out_of_reach_is_said() -> None:
    """Strongly curved: the ridges in the middle tip over before the outer ones touch."""
    answer = solved(reference().with_(skin={"curvature_radius": 9.0}, ridge={"count": 7}), 1.0)
    assert answer.all_touch_force.value is None
    assert answer.touching < 7
    assert any("beyond the finite-strain model's range (looked up to" in w for w in answer.warnings)


def test_neighbours_that_meet_are_found() -> None:
    """A state moved by hand so that flanks overlap: the model has no contact there."""
    pad = coarse(filleted().with_(**THREE))
    state = pressing.press_to(pad, 0.03)
    plate = pad.top - state.contact.approach
    pressed_loops, far_loops = (elements.outlines(pad.body.rest, m * state.values) for m in (1, 40))
    assert plane_body.undetected_contact(pressed_loops, lambda x: 0 * x + plate) is None
    assert "meets the plate" in (
        plane_body.undetected_contact(pressed_loops, lambda x: 0 * x + plate - 1.0) or ""
    )
    assert "onto itself" in (plane_body.undetected_contact(far_loops, lambda x: 0 * x + plate + 100.0) or "")


DESIGNS = {"reference": reference, "filleted": filleted, "voids": lambda: void_slots(0.05), "yamada": yamada}


@pytest.mark.evidence(subject="finer meshes: finite strain")
@pytest.mark.parametrize("name", DESIGNS)
def test_truth_lies_inside(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Order 4 on a mesh twice as fine, with half the reach of the law at the clamped ends."""
    design, force = DESIGNS[name]().with_(**THREE), 1.3
    answers = [solved(design, force, tol) for tol in (COARSE, 5e-3)]
    monkeypatch.setattr(plane_body, "CLAMPED_EDGE", plane_body.CLAMPED_EDGE / 2)
    pad = mech.pad_of(design)
    meshed = mech.plane_piece(pad, 2.0)
    exact = finite_strain.level(meshed, 4, force, before=finite_strain.level(meshed, 3, force))
    for one in answers:
        assert one.all_touch_force.value is not None
        assert_inside(one, exact)


THREE_FORCE = 1.3
# neo-Hooke's by the general way: two terms of the power 2
NEO = Ogden(mu=[0.6, 0.4], alpha=[2.0, 2.0])


@cache
def three(law: Rubber | None) -> linear.PlaneSolution:
    """Three ridges on the coarsest mesh."""
    pad = replace(mech.pad_of(reference().with_(**THREE)), law=law)
    return finite_strain.level(mech.plane_piece(pad, 0.5), 2, THREE_FORCE)


def numbers(of: linear.PlaneSolution) -> np.ndarray:
    assert of.all_touch_force is not None
    return np.array([of.all_touch_force, of.approach, *of.ridge_force])


@pytest.mark.slow
def test_ogdens_alpha_2_and_neo_hookes_law_are_the_model_without_one() -> None:
    assert numbers(three(NEO)) == pytest.approx(numbers(three(None)), rel=1e-9)
    assert (numbers(three(NeoHooke(mu=7.0))) == numbers(three(None))).all()  # to the bit


@pytest.mark.parametrize(
    "law",
    [
        Yeoh(c10=0.5, c20=0.2),
        *(
            pytest.param(x, marks=pytest.mark.slow)
            for x in (Gent(mu=1.0, j_m=4.0), Ogden(mu=[1.0], alpha=[6.0]))
        ),
    ],
)
def test_a_law_that_stiffens_gives_way_less(law: Rubber) -> None:
    assert three(law).approach < 0.9995 * three(None).approach


@pytest.mark.slow
def test_a_scene_without_friction_is_the_models_state() -> None:
    """Silicone in the slots has the law too. 1e-8: Newton's residual of both."""
    law = Gent(mu=1.0, j_m=2.0)
    one = yamada().with_(ridge={"count": 1}, skin={"width": 3.0}, contact={"film": "ignored"})
    pad, thickness = mech.filled_pad(one)
    pad = replace(pad, law=law)
    assert set(pad.laws) == {"skin", "film"}
    mesh, unit = mech.triangles(pad, mech.default_sizes(pad, 0.25)), mech.unit_of(pad)
    large = FiniteStrain().marched(mech.piece_of(pad, thickness, halved=False), mesh, 2, True, [])
    depth = march(large, np.arange(2.0), [mech.Drive(0.0, 0.0), mech.Drive(0.8, 0.0)], []).column("approach")[
        -1
    ]
    approach = []
    for laws in (pad.laws, {"skin": law}, {}):
        body = plane_body.body(elements.curved(mesh, 2), 2, pad.materials, laws)
        state = pressing.press_to(
            pressing.PressedPad(body, pad.top / unit), 0.8 / (pad.young_modulus * unit * pad.length)
        )
        approach.append(state.contact.approach * unit)
    assert depth == pytest.approx(approach[0], rel=1e-8)
    assert depth * 1.00003 < approach[1] < approach[2] * 0.999  # without the slots, without the law


@pytest.mark.parametrize(
    ("law", "gradient"),
    [(None, (-1.2, 0.1)), (NEO, (-1.2, 0.1)), (Gent(mu=1.0, j_m=2.0), (3.0, -0.7))],
    ids=["inside out", "a law inside out", "beyond a law's end"],
)
def test_where_there_is_no_energy_there_is_no_residual(
    law: Rubber | None, gradient: tuple[float, float]
) -> None:
    """A number would let Newton go on from a state that is none."""
    pad = mech.pad_of(reference().with_(ridge={"count": 1}, skin={"width": 3.0}))
    mesh = elements.curved(mech.triangles(pad, mech.default_sizes(pad, 0.25)), 2)
    body = plane_body.body(mesh, 2, pad.materials, {"skin": law} if law else {})
    what = replace(whole(pad, 0.25), body=body)
    for share, finite in ((0.1, True), (1.0, False)):
        state = affine(what, share * np.diag(gradient), 0.0)
        assert np.isfinite(body.energy(state)) == finite
        assert np.isfinite(body.residual(state)).all() == finite


def test_real_strips_stay_neo_hookean() -> None:
    pad = replace(mech.pad_of(yamada()), law=NEO)
    assert pad.strips
    assert set(pad.laws) == {"skin"}


@pytest.mark.slow
def test_strips_stress_is_the_laws() -> None:
    """Cauchy's, J sigma = P F^T, resolved along and across the strip as it then lies."""
    design = yamada().with_(ridge={"count": 1}, skin={"width": 3.0})
    piece = mech.piece_of(*mech.filled_pad(design), halved=False)
    pad = replace(piece.pad, poisson_ratio=0.3, film_modulus=piece.pad.young_modulus, film_ratio=0.3)
    what = whole(pad, 0.25)
    gradient = np.array([[0.2, 0.3], [-0.1, 0.15]])
    stretch, shear, bulk = np.eye(2) + gradient, 1 / 2.6, 1 / 1.2
    swell = np.linalg.det(stretch) - 1
    pressure = bulk * swell
    state = affine(what, gradient, pressure)
    for law in (Ogden(mu=[0.3, 0.1], alpha=[3.5, -2.0]), Gent(mu=0.2, j_m=2.0), NEO, None):
        strips = mech.strip_stress(what.body, 2, replace(piece, pad=replace(pad, law=law)))
        # q enters as q cof F beside what has none, in units of E
        nominal = plane_stress(law or NEO, gradient) / (law or NEO).shear * shear
        cauchy = nominal @ stretch.T / (1 + swell) + pressure * np.eye(2)
        for got, slot in zip(strips.at(state), piece.slots, strict=True):
            along = stretch @ np.array(slot.direction)
            along /= np.linalg.norm(along)
            normal = np.array([-along[1], along[0]])
            wanted = [normal @ cauchy @ normal, along @ cauchy @ along, pressure - 2 / 3 * shear * swell]
            assert got == pytest.approx(wanted, abs=1e-10)  # rounding


@cache
def in_space(law: Rubber | None) -> mech.LevelAnswer:
    """One ridge of finite length, coarse."""
    one = reference().with_(ridge={"count": 1}, skin={"width": 2.5, "length": 2.5, "thickness": 1.5})
    return solid_finite_strain.solve(
        replace(mech.pad_of(one), law=law), 0.4, {}, mech.Layers(0.9, 2.0, 2), fineness=0.6
    ).after


@pytest.mark.slow
def test_a_bar_like_ridge_gives_way_more_by_a_larger_power() -> None:
    """Squeezed with free sides, alpha 3.25 is softer than neo-Hooke; in plane strain any power is stiffer."""
    assert in_space(NEO).approach == pytest.approx(in_space(None).approach, rel=1e-9)
    law = Ogden(mu=[1.0], alpha=[3.25])
    assert law.stress(np.array([0.6]))[0] > NEO.stress(np.array([0.6]))[0]
    assert in_space(law).approach > 1.0005 * in_space(None).approach
    assert three(law).approach < 0.99999 * three(None).approach
