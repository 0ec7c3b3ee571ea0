"""The neo-Hookean solid: closed forms, derivatives, plane strain, limits, the model, and what it refuses."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy import optimize

from skincad import mechanics as mech
from skincad.base import InputError
from skincad.mechanics.bodies import elements, plane_body, prisms, solid_law
from skincad.mechanics.contact import frictionless
from skincad.mechanics.contact import newton as pressing
from skincad.mechanics.models import solid_finite_strain
from tests.mechanics.bodies.test_elements import block
from tests.mechanics.designs import reference, value, yamada

FEW = mech.Layers(0.6, 2.0, 2)
SMALL: dict[str, Any] = {"ridge": {"count": 3}, "skin": {"width": 5.0, "length": 6.0}}


def meshed_of(pad: mech.Pad, fineness: float = 1.0, *, whole: bool = False) -> mech.PadPiece:
    return mech.meshed_piece(pad, mech.coarse_sizes(pad, fineness), whole=whole)


def small_body(along: mech.Layers = FEW) -> mech.SolidBody:
    return mech.body_of(meshed_of(mech.pad_of(reference().with_(**SMALL))), along)


def affine(body: mech.SolidBody, gradient: np.ndarray, pressure: float = 0.0) -> np.ndarray:
    """The state of a homogeneous displacement gradient, components and axes (x, z, y): in the hierarchical
    basis a linear function has values at the vertices alone."""
    plane = body.forms.plane.mesh
    points = np.array([v.point for v in plane.vertices])
    along = np.unique(body.along)
    at = np.empty((3, len(points), along.size))
    at[0], at[1], at[2] = points[:, :1], points[:, 1:], along
    moved = np.zeros((3, body.forms.clamped.size, along.size))
    moved[:, : len(points)] = np.einsum("ij,jvl->ivl", gradient, at)
    tested = np.zeros((len(body.of_element), body.elements.softening.shape[1]))
    tested[:, 0] = pressure  # the constant comes first, of value 1
    return np.concatenate([moved.ravel(), tested.ravel()])


@cache
def plain_block(ratio: float) -> mech.SolidBody:
    return mech.body_of(meshed_of(block(3.0, 2.0, ratio), whole=True), FEW)


def nominal_stress(body: mech.SolidBody, gradient: np.ndarray, pressure: float) -> np.ndarray:
    """P from virtual work: the residual's work on each affine displacement, per volume."""
    residual = body.residual(affine(body, gradient, pressure))
    volume = body.elements.weight.sum()
    stress = np.zeros((3, 3))
    for i, j in np.ndindex(3, 3):
        virtual = np.zeros((3, 3))
        virtual[i, j] = 1.0
        stress[i, j] = residual @ affine(body, virtual) / volume
    return stress


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("stretch", [0.6, 0.95, 1.4])
def test_uniaxial_stretch(axis: int, stretch: float) -> None:
    """Sides free: G (t - 1/t) + L (J - 1) l t = 0 gives t, and P = G (l - 1/l) + L (J - 1) t^2, L Lame's."""
    body, shear, lame = plain_block(0.4), 1 / 2.8, 0.4 / (1.4 * 0.2)

    def sides(t: float) -> float:
        return shear * (t - 1 / t) + lame * (stretch * t * t - 1) * stretch * t

    t = optimize.brentq(sides, 0.3, 3.0, xtol=1e-15)
    swell = stretch * t * t - 1
    gradient = np.diag([stretch - 1 if a == axis else t - 1 for a in range(3)])
    stress = nominal_stress(body, gradient, float(body.elements.bulk[0, 0]) * swell)
    wanted = np.zeros((3, 3))
    wanted[axis, axis] = shear * (stretch - 1 / stretch) + lame * swell * t * t
    assert stress == pytest.approx(wanted, abs=1e-11)  # rounding
    residual = body.residual(affine(body, gradient, float(body.elements.bulk[0, 0]) * swell))
    assert np.abs(residual[body.displacements :]).max() <= 1e-12  # the pressure is K (J - 1)


def test_a_block_shortens_as_the_closed_form() -> None:
    """At nu = 0 a clamped block with free ends stays straight: nominal stress G (1/l - l), G = E / 2."""
    pad = block(3.0, 2.0, 0.0)
    solution = solid_finite_strain.solve(pad, 0.9, {}, FEW).after
    ratio = 0.9 / 6.0 / 0.35
    stretch = (np.sqrt(ratio**2 + 4) - ratio) / 2
    assert solution.approach == pytest.approx(2.0 * (1 - stretch), rel=1e-8)  # Newton's residual
    meshed = meshed_of(pad)
    body = mech.body_of(meshed, FEW)
    contact = pressing.press_to(
        pressing.PressedPad(body, pad.top / meshed.unit), 0.9 / (0.7 * meshed.unit**2 * 2 * meshed.sides)
    ).contact
    assert 0.7 * contact.force / body.rest.nodes.weight == pytest.approx(0.9 / 6.0, rel=1e-6)


def test_a_move_is_newtons() -> None:
    """The tangent, factorised and its pressures condensed, against central differences: along a move the
    residual changes by minus itself and the push. 1e-6: truncation."""
    body = small_body()
    random = np.random.default_rng(7)
    state = 1e-3 * random.standard_normal(body.free.size)
    start, push = 1e-3 * random.standard_normal((2, body.free.size))
    push[body.displacements :] = 0.0
    move = body.linearised(state, start).move(push)
    size = 1e-6 / np.abs(move).max()
    slope = (body.residual(state + size * move) - body.residual(state - size * move)) / (2 * size)
    assert np.abs((slope + start + push)[body.free]).max() <= 1e-6 * np.abs(start + push).max()
    assert (move[~body.free] == 0).all()


@pytest.mark.parametrize("ratio", [0.0, 0.499])
def test_at_rest_it_is_the_small_strain_solid(ratio: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """With all of the bulk modulus on the pressure, on straight triangles: the same functions, rounding."""
    monkeypatch.setattr(solid_law, "POINTWISE_BULK", 0.0)
    meshed = meshed_of(block(3.0, 2.0, ratio))
    body = mech.body_of(meshed, FEW)
    rest = np.zeros(body.free.size)
    along = prisms.line(np.unique(body.along)[::2], 2)
    wanted = prisms.condensed(mech.forms_of(meshed, 2), along).flexibility
    flexibility = body.linearised(rest, rest).flexibility
    assert np.abs(flexibility - wanted).max() <= 1e-10 * np.abs(wanted).max()
    assert np.abs(body.residual(rest)).max() <= 1e-12


def test_clamped_ends_are_the_plane_neo_hookean_pad(monkeypatch: pytest.MonkeyPatch) -> None:
    """u_y = 0 at both ends, on the same mesh and order, all of the bulk modulus on the pressure. 1e-4: the
    points of integration differ on curved triangles and for a law that is no polynomial."""
    monkeypatch.setattr(solid_law, "POINTWISE_BULK", 0.0)
    pad = mech.pad_of(reference().with_(**SMALL))
    meshed = meshed_of(pad, whole=True)
    body = mech.body_of(meshed, FEW, clamped_end=True)
    top, half = pad.top / meshed.unit, pad.length / 2 / meshed.unit
    force = 0.05  # per length; strains of 5 %
    clamped = pressing.press_to(pressing.PressedPad(body, top), force * half)
    flat = plane_body.body(elements.curved(meshed.mesh, 2), 2, pad.materials)
    plane = pressing.press_to(pressing.PressedPad(flat, top), force)
    assert clamped.contact.approach == pytest.approx(plane.contact.approach, rel=1e-4)
    assert np.abs(clamped.values[2 * body.displacements // 3 : body.displacements]).max() <= 1e-9  # u_y


@pytest.mark.evidence(subject="solid finite strain: limits")
def test_half_is_the_whole() -> None:
    """On two meshes, which differ by 0.5 % at this order (test_solid.py); finite strain's change less."""
    pad = mech.pad_of(reference().with_(**SMALL))
    half = solid_finite_strain.solve(pad, 1.0, {}, FEW, fineness=1.5)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            solid_finite_strain,
            "meshed_piece",
            lambda pad, sizes, **_: mech.meshed_piece(pad, sizes, whole=True),
        )
        whole = solid_finite_strain.solve(pad, 1.0, {}, FEW, fineness=1.5)
    assert half.after.approach == pytest.approx(whole.after.approach, rel=5e-3)
    assert half.after.ridge_force == pytest.approx(whole.after.ridge_force, abs=5e-3)
    assert ratios(half) == pytest.approx(ratios(whole), rel=1e-3)


def ratios(strains: mech.Correction) -> tuple[float, float]:
    return (
        (strains.after.all_touch_force or 0.0) / (strains.before.all_touch_force or 1.0),
        strains.after.approach / strains.before.approach,
    )


@pytest.mark.slow
def test_plain_ridges() -> None:
    """Finite strain with free ends: F9 +2.9 % (plane strain +4.8 %), approach -3.2 % (-3.8 %); errors as
    the model's own. At small strain it is close to the solid's model: what acts on the volume change itself
    stiffens coarse elements, by 0.9 % of F9 and 0.3 % of the approach."""
    solution = solid_finite_strain.solve(mech.pad_of(reference()), 4.0, {})
    assert ratios(solution) == pytest.approx((1.029, 0.968), abs=0.002)
    assert solution.after.residual <= max(pressing.RESIDUAL, frictionless.COMPLEMENTARITY)
    assert solution.before.residual <= frictionless.COMPLEMENTARITY
    assert solution.after.ridge_force.sum() == pytest.approx(4.0, rel=1e-9)  # equilibrium
    assert solution.after.touching == 9
    assert not solution.out_of_range
    meshed = meshed_of(mech.pad_of(reference()))
    other = mech.solve_level(meshed, mech.forms_of(meshed, 2), solid_finite_strain.LAYERS, 4.0, {})
    assert solution.before.approach == pytest.approx(other.approach, rel=0.005)
    assert solution.before.all_touch_force == pytest.approx(other.all_touch_force, rel=0.02)


@pytest.mark.evidence(subject="solid finite strain: limits")
def test_pressures_that_waves_escape(monkeypatch: pytest.MonkeyPatch) -> None:
    """Why a part of the bulk modulus acts on the volume change itself: without it 2 N have no stable
    state."""
    pad = mech.pad_of(reference().with_(**SMALL))
    assert solid_finite_strain.solve(pad, 2.0, {}, FEW).after.touching == 3
    monkeypatch.setattr(solid_law, "POINTWISE_BULK", 0.0)
    with pytest.raises(InputError, match=r"tips over, no equilibrium beyond is stable"):
        solid_finite_strain.solve(pad, 2.0, {}, FEW)


def test_a_single_ridge_touches_at_once() -> None:
    design = reference().with_(ridge={"count": 1}, skin={"width": 5.0, "length": 6.0})
    solution = solid_finite_strain.solve(mech.pad_of(design), 0.3, {}, FEW)
    assert (solution.after.all_touch_force, solution.after.touching) == (0.0, 1)


@pytest.mark.slow
def test_an_overload_is_refused_with_its_range() -> None:
    with pytest.raises(InputError, match=r"^force: must lie .* range \(up to about \d\.?\d* N\): .*; take a"):
        solid_finite_strain.solve(mech.pad_of(reference().with_(**SMALL)), 20.0, {}, FEW)


def test_faults_are_found_in_the_middle_and_at_the_end() -> None:
    body = small_body()
    top = 1e3
    rest = np.zeros(body.free.size)
    assert body.undetected_contact(rest, top) is None
    assert "meets the plate" in (body.undetected_contact(rest, -1e3) or "")
    at_end = rest[: body.displacements].reshape(3, body.forms.clamped.size, -1)
    at_end[1, : body.forms.plane.mesh.nv, -1] = 2e3  # lifted as a whole, at the end alone
    assert "meets the plate" in (body.undetected_contact(rest, top) or "")
    sideways = affine(body, np.zeros((3, 3)))
    sideways[: body.displacements].reshape(at_end.shape)[0, : body.forms.plane.mesh.nv] = -0.1
    assert "in the middle" in (body.undetected_contact(sideways, top) or "")


def test_too_large_a_pad_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solid_finite_strain, "MOST_UNKNOWNS", 1000)
    with pytest.raises(InputError, match=r"at finite strain take at most 1000 unknowns"):
        solid_finite_strain.solve(mech.pad_of(reference()), 4.0, {})


@pytest.mark.slow
def test_the_answer_is_the_solids_changed() -> None:
    """F9 and approach by the factors, shares in sum the force, errors larger than the solid's."""
    design = reference().with_(**SMALL)
    small = solid_finite_strain.solid.answer(design, mech.Request(1.0, tol=0.05))
    answer = solid_finite_strain.answer(design, mech.Request(1.0, tol=1e-3), fine=small)
    by_threshold, by_approach = ratios(solid_finite_strain.solve(mech.pad_of(design), 1.0, {}))
    assert value(answer.all_touch_force) == pytest.approx(
        by_threshold * value(small.all_touch_force), rel=1e-9
    )
    assert value(answer.approach) == pytest.approx(by_approach * value(small.approach), rel=1e-9)
    assert sum(value(f) for f in answer.ridge_force) == pytest.approx(1.0, rel=1e-9)
    assert (answer.approach.error or 0.0) > (small.approach.error or 0.0) * by_approach
    assert any("1.0e-03 is not met" in w for w in answer.warnings)


@pytest.mark.evidence(subject="solid finite strain: limits")
def test_a_threshold_out_of_reach_is_said() -> None:
    """Strongly curved: the ridges in the middle fail before the outer ones touch."""
    skin = {"curvature_radius": 4.0, "length": 6.0, "width": 5.5}
    design = reference().with_(skin=skin, ridge={"count": 5})
    solution = solid_finite_strain.solve(mech.pad_of(design), 0.1, {}, FEW)
    assert solution.after.all_touch_force is None
    assert "beyond the finite-strain model's range (looked up to" in solution.out_of_range


@pytest.mark.evidence(subject="yamada-2002")
def test_yamada_2002() -> None:
    """Strips of PVDF hold the ends: F9 +3.1 %, approach -3.2 %."""
    solution = solid_finite_strain.solve(mech.pad_of(yamada()), 4.0, {})
    assert ratios(solution) == pytest.approx((1.0315, 0.9673), abs=0.001)
    assert solution.after.residual <= pressing.RESIDUAL


VARIANTS: dict[str, dict[str, Any]] = {
    "plain": {},
    "thin": {"skin": {"thickness": 2.0}},
    "high": {"ridge": {"height": 0.7}},
    "short": {"skin": {"length": 6.0}},
    "incompressible": {"material": {"poisson_ratio": 0.49999}},
}


@pytest.mark.evidence(subject="solid finite strain: {name}")
@pytest.mark.parametrize("name", VARIANTS)
def test_the_changes_error_on_variants(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against order 3 on a finer mesh with finer prisms, both sides."""
    pad = mech.pad_of(reference().with_(**VARIANTS[name]))
    coarse, body_of = solid_finite_strain.solve(pad, 4.0, {}), solid_finite_strain.body_of
    monkeypatch.setattr(solid_finite_strain, "body_of", lambda m, along: body_of(m, along, 3))
    fine = solid_finite_strain.solve(pad, 4.0, {}, mech.Layers(0.3, 1.8, 3), fineness=1.25)
    assert ratios(coarse)[0] == pytest.approx(ratios(fine)[0], rel=solid_finite_strain.ERRORS.threshold)
    assert ratios(coarse)[1] == pytest.approx(ratios(fine)[1], rel=solid_finite_strain.ERRORS.approach)
    change = [s.after.ridge_force - s.before.ridge_force for s in (coarse, fine)]
    assert change[0] == pytest.approx(change[1], abs=solid_finite_strain.ERRORS.share * 4.0 / 9)


@pytest.mark.parametrize("along", [FEW, mech.Layers(0.6, 2.0, 3), mech.Layers(0.4, 1.5, 2)])
def test_the_unknowns_that_are_refused_are_those_that_would_be_solved(
    along: mech.Layers, monkeypatch: pytest.MonkeyPatch
) -> None:
    meshed = meshed_of(block(3.0, 2.0, 0.3))
    count = mech.body_of(meshed, along).displacements
    monkeypatch.setattr(solid_finite_strain, "MOST_UNKNOWNS", count)
    assert mech.body_of(meshed, along).displacements == count
    monkeypatch.setattr(solid_finite_strain, "MOST_UNKNOWNS", count - 1)
    with pytest.raises(InputError, match=f"at most {count - 1} unknowns") as refused:
        mech.body_of(meshed, along)
    assert refused.value.value == count


@pytest.mark.parametrize("along", [0, -1])
def test_the_boundary_is_looked_at_in_the_middle_and_at_the_end(along: int) -> None:
    """A pad of which one cross-section alone has moved, by 0.2 along x: its outline is seen there."""
    body = plain_block(0.3)
    moved = affine(body, np.zeros((3, 3)))
    sections = moved[: body.displacements].reshape(3, body.forms.clamped.size, -1)
    sections[0, : len(list(body.forms.plane.mesh.vertices)), along] = 0.2
    middle, end = ([p.moved[:, 0] - p.rest[:, 0] for p in loops] for loops in body.outlines(moved))
    for shift, here in ((middle, along == 0), (end, along == -1)):
        assert np.concatenate(shift) == pytest.approx(0.2 if here else 0.0, abs=1e-12)


@pytest.mark.slow
def test_crests_that_are_equally_low_change_nothing_but_the_mesh() -> None:
    """Pressed whole, as crests of one part need not mirror each other. The whole's mesh is another one than
    the half's twice: its change differs by 3e-4 at most of what strain changes."""
    pad = mech.pad_of(reference().with_(**SMALL))
    half = solid_finite_strain.solve(pad, 0.5, {}, FEW)
    whole = solid_finite_strain.solve(pad, 0.5, {}, FEW, crest_offsets=(0.01, 0.01, 0.01))
    for of in ("all_touch_force", "approach"):
        changes = [getattr(s.after, of) / getattr(s.before, of) for s in (half, whole)]
        assert changes[0] == pytest.approx(changes[1], abs=1e-3)


@pytest.mark.slow
def test_a_lower_crest_asks_for_more_force_in_finite_strain_too() -> None:
    pad = mech.pad_of(reference().with_(**SMALL))
    as_designed, lower = (
        solid_finite_strain.solve(pad, 0.5, {}, FEW, crest_offsets=drops)
        for drops in ((0.0, 0.0, 1e-9), (0.02, 0.0, 0.0))
    )
    for strains in ("before", "after"):
        one, other = getattr(as_designed, strains), getattr(lower, strains)
        assert other.all_touch_force > 1.05 * one.all_touch_force
        assert other.ridge_force[0] < one.ridge_force[0]
