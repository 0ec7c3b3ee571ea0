"""A pad of any law in both models of finite strain and in scenes: neo-Hooke's as a special case."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from skincad.effects import FiniteStrain
from skincad.laws import Gent, NeoHooke, Ogden, Rubber, Yeoh
from skincad.mechanics import (
    Drive,
    Layers,
    SolidSolution,
    default_sizes,
    filled_pad,
    pad_of,
    piece_of,
    plane_piece,
    strip_stress,
    triangles,
    unit_of,
)
from skincad.mechanics.bodies import elements, plane_body
from skincad.mechanics.contact.newton import PressedPad, press_to
from skincad.mechanics.models import finite_strain
from skincad.mechanics.models.linear import PlaneSolution
from skincad.mechanics.models.solid_finite_strain import solve
from skincad.scenes.march import march
from tests.laws.closed import plane_stress
from tests.mechanics.contact.test_dragged import affine, whole
from tests.mechanics.designs import THREE, reference, yamada

FORCE = 1.3
# neo-Hooke's by the general way: two terms of the power 2
NEO = Ogden(mu=[0.6, 0.4], alpha=[2.0, 2.0])


@cache
def three(law: Rubber | None) -> PlaneSolution:
    """Three ridges on the coarsest mesh."""
    pad = replace(pad_of(reference().with_(**THREE)), law=law)
    return finite_strain.Levels()(plane_piece(pad, 0.5), 2, FORCE)


def numbers(of: PlaneSolution) -> np.ndarray:
    assert of.all_touch_force is not None
    return np.array([of.all_touch_force, of.approach, *of.ridge_force])


def test_ogdens_alpha_2_is_the_neo_hookean_model() -> None:
    assert numbers(three(NEO)) == pytest.approx(numbers(three(None)), rel=1e-9)


def test_a_neo_hookean_law_is_the_model_without_one_to_the_bit() -> None:
    assert (numbers(three(NeoHooke(mu=7.0))) == numbers(three(None))).all()


@pytest.mark.parametrize("law", [Yeoh(c10=0.5, c20=0.2), Gent(mu=1.0, j_m=4.0), Ogden(mu=[1.0], alpha=[6.0])])
def test_a_law_that_stiffens_gives_way_less(law: Rubber) -> None:
    assert three(law).approach < 0.9995 * three(None).approach


@pytest.mark.slow
def test_a_scene_without_friction_is_the_models_state() -> None:
    """Silicone in the slots has the law too. 1e-8: Newton's residual of both."""
    law = Gent(mu=1.0, j_m=2.0)
    one = yamada().with_(ridge={"count": 1}, skin={"width": 3.0}, contact={"film": "ignored"})
    pad, thickness = filled_pad(one)
    pad = replace(pad, law=law)
    assert set(pad.laws) == {"skin", "film"}
    mesh, unit = triangles(pad, default_sizes(pad, 0.25)), unit_of(pad)
    large = FiniteStrain().marched(piece_of(pad, thickness, halved=False), mesh, 2, True, [])
    depth = march(large, np.arange(2.0), [Drive(0.0, 0.0), Drive(0.8, 0.0)], []).column("approach")[-1]
    approach = []
    for laws in (pad.laws, {"skin": law}, {}):
        body = plane_body.body(elements.curved(mesh, 2), 2, pad.materials, laws)
        state = press_to(PressedPad(body, pad.top / unit), 0.8 / (pad.young_modulus * unit * pad.length))
        approach.append(state.approach * unit)
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
    pad = pad_of(reference().with_(ridge={"count": 1}, skin={"width": 3.0}))
    mesh = elements.curved(triangles(pad, default_sizes(pad, 0.25)), 2)
    body = plane_body.body(mesh, 2, pad.materials, {"skin": law} if law else {})
    what = replace(whole(pad, 0.25), body=body)
    for share, finite in ((0.1, True), (1.0, False)):
        state = affine(what, share * np.diag(gradient), 0.0)
        assert np.isfinite(body.energy(state)) == finite
        assert np.isfinite(body.residual(state)).all() == finite


def test_real_strips_stay_neo_hookean() -> None:
    pad = replace(pad_of(yamada()), law=NEO)
    assert pad.strips
    assert set(pad.laws) == {"skin"}


@pytest.mark.parametrize("law", [Ogden(mu=[0.3, 0.1], alpha=[3.5, -2.0]), Gent(mu=0.2, j_m=2.0), NEO])
def test_strips_stress_is_the_laws(law: Rubber) -> None:
    """Cauchy's, J sigma = P F^T, resolved along and across the strip as it then lies."""
    design = yamada().with_(ridge={"count": 1}, skin={"width": 3.0})
    piece = piece_of(*filled_pad(design), halved=False)
    both = {"skin": (1.0, 0.3), "film": (1.0, 0.3)}
    what = whole(replace(piece.pad, poisson_ratio=0.3), 0.25)
    laws = {"skin": law, "film": law}
    strips = strip_stress(what.body, 2, both, piece.slots, piece.thickness, piece.unit, laws)
    gradient = np.array([[0.2, 0.3], [-0.1, 0.15]])
    stretch, shear, bulk = np.eye(2) + gradient, 1 / 2.6, 1 / 1.2
    swell = np.linalg.det(stretch) - 1
    pressure = bulk * swell
    stress = strips.at(affine(what, gradient, pressure))
    # q enters as q cof F beside what has none, in units of E
    nominal = plane_stress(law, gradient) / law.shear * shear
    cauchy = nominal @ stretch.T / (1 + swell) + pressure * np.eye(2)
    for got, slot in zip(stress, piece.slots, strict=True):
        along = stretch @ np.array(slot.direction)
        along /= np.linalg.norm(along)
        normal = np.array([-along[1], along[0]])
        wanted = [normal @ cauchy @ normal, along @ cauchy @ along, pressure - 2 / 3 * shear * swell]
        assert got == pytest.approx(wanted, abs=1e-10)  # rounding


@cache
def in_space(law: Rubber | None) -> SolidSolution:
    """One ridge of finite length, coarse."""
    one = reference().with_(ridge={"count": 1}, skin={"width": 2.5, "length": 2.5, "thickness": 1.5})
    return solve(replace(pad_of(one), law=law), 0.4, {}, Layers(0.9, 2.0, 2), fineness=0.6).finite


def test_ogdens_alpha_2_is_the_neo_hookean_solid() -> None:
    assert in_space(NEO).approach == pytest.approx(in_space(None).approach, rel=1e-9)


def test_a_bar_like_ridge_gives_way_more_by_a_larger_power() -> None:
    """Squeezed with free sides, alpha 3.25 is softer than neo-Hooke; in plane strain any power is stiffer."""
    law = Ogden(mu=[1.0], alpha=[3.25])
    assert law.stress(np.array([0.6]))[0] > NEO.stress(np.array([0.6]))[0]
    assert in_space(law).approach > 1.0005 * in_space(None).approach
    assert three(law).approach < 0.99999 * three(None).approach
