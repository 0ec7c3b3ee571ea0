"""What every law must be: a table with one energy, of neo-Hooke's small strain. Tested by being listed."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import ngsolve as ng
import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.laws import LAWS, Rubber, law, law_of
from skincad.mechanics import Layers, Sizes, SolidBody, body_of, excess, triangles
from skincad.mechanics.bodies import elements, plane_body
from tests.laws.closed import ARRAYS, STEP, plane_energy, plane_stress
from tests.mechanics.bodies.test_elements import block
from tests.mechanics.models.test_solid_finite_strain import affine, meshed_of

ALL = [
    pytest.param(
        candidate.make(np.array(candidate.start) * (1.0, *(1.1,) * (len(candidate.start) - 1))),
        id=candidate.name,
    )
    for kind in LAWS
    for candidate in law(kind).candidates()
]
every_law = pytest.mark.parametrize("rubber", ALL)


@every_law
def test_it_is_the_table_that_it_dumps(rubber: Rubber) -> None:
    assert law_of(rubber.model_dump()) == rubber
    assert type(rubber) is law(rubber.kind)
    assert sum(share for share, _ in rubber.powers) == pytest.approx(1.0, rel=1e-14)


@every_law
def test_scaled_is_scaled(rubber: Rubber) -> None:
    stretch = np.array([0.7, 1.4])
    assert rubber.scaled(0.37).stress(stretch) == pytest.approx(0.37 * rubber.stress(stretch), rel=1e-13)


@every_law
def test_slopes_are_the_energys(rubber: Rubber) -> None:
    x = np.array([0.0, 0.01, 0.3, 0.8])
    first, second = rubber.slopes(x)
    assert np.imag(rubber.energy(x + 1j * STEP, np)) / STEP == pytest.approx(first, rel=1e-13)
    assert np.imag(rubber.slopes(x + 1j * STEP)[0]) / STEP == pytest.approx(second, rel=1e-13)
    assert (float(rubber.energy(np.zeros(1), np)[0]), float(first[0])) == (0.0, 1.0)


@every_law
def test_a_bars_stress_is_its_energys_slope(rubber: Rubber) -> None:
    """By the plane body's energy of the same stretches, one of which is 1: a sheet held at its sides."""
    stretch = np.array([0.7, 1.2, 1.8])
    for t in stretch:
        stress = plane_stress(rubber, np.diag([t - 1, 1 / t - 1]))
        nominal = stress[0, 0] - stress[1, 1] / t**2
        size = 1e-6

        def energy(at: float) -> float:
            x = sum(m * 2 / a**2 * (at**a + at**-a - 2) for m, a in rubber.powers)
            return float(rubber.shear * rubber.energy(np.array(x), np))

        slope = (energy(t + size) - energy(t - size)) / (2 * size)
        assert nominal == pytest.approx(slope, rel=1e-8)  # the difference's truncation
    assert rubber.stress(np.array([1 + 1e-6]))[0] == pytest.approx(3e-6 * rubber.shear, rel=1e-5)


@every_law
def test_small_strain_is_neo_hookes(rubber: Rubber) -> None:
    """What is beyond neo-Hooke's is of the third order: it falls to 1e-3 where strain falls to 0.1."""
    gradient = np.array([[0.3, -0.2], [0.5, 0.4]])
    large, small = (abs(float(excess(rubber, s * gradient, ARRAYS))) for s in (1e-2, 1e-3))
    assert small <= max(1.3e-3 * large, 1e-14)


def plane_body_of(rubber: Rubber | None) -> plane_body.NeoHookeBody:
    mesh = elements.curved(triangles(block(2.0, 3.0, 0.49), Sizes(0.9, 0.9, 0.9, 0.3)), 2)
    return plane_body.body(mesh, 2, {"skin": (1.0, 0.49)}, {"skin": rubber} if rubber else {})


@every_law
def test_the_bodys_derivatives_are_its_energys(rubber: Rubber) -> None:
    """Residual and condensed tangent by central differences, at small and large strain: 1e-5, truncation."""
    body, random = plane_body_of(rubber), np.random.default_rng(7)
    for strain in (1e-3, 0.3):
        field = ng.GridFunction(body.space)
        field.components[0].Set(ng.CF((strain * ng.x * ng.y, -strain * ng.y**2)))
        state = np.array(field.vec.FV().NumPy()) + 1e-4 * random.standard_normal(body.free.size)
        assert np.isfinite(body.energy(state))
        step = np.zeros_like(state)
        free = np.concatenate([body.rest.interior, body.rest.contact])
        step[free] = random.standard_normal(free.size)
        whole = plane_body.tangent(body, state, np.zeros_like(state)).recover(step)
        size = 1e-5 / np.abs(whole).max()
        slope = body.energy(state + size * whole) - body.energy(state - size * whole)
        assert body.residual(state) @ whole == pytest.approx(slope / (2 * size), rel=1e-5)
        after, before = (body.residual(state + s * size * whole) for s in (1, -1))
        wanted = plane_body.tangent(body, state, np.zeros_like(state)).matrix @ step
        assert np.abs((after - before)[free] / (2 * size) - wanted[free]).max() <= 1e-5 * np.abs(wanted).max()


@every_law
def test_the_body_has_the_laws_energy(rubber: Rubber, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a uniform deformation: the density at a point times the area, without the clamped ends' own law."""
    monkeypatch.setattr(plane_body, "CLAMPED_EDGE", -1.0)
    body, gradient = plane_body_of(rubber), np.array([[0.4, -0.3], [0.6, 0.2]])
    field = ng.GridFunction(body.space)
    field.components[0].Set(ng.CF(tuple(row[0] * ng.x + row[1] * ng.y for row in gradient.tolist())))
    shear, bulk = 1 / 2.98, 1 / 0.06
    density = plane_energy(rubber, gradient, 0.0, bulk).real / rubber.shear * shear
    area = ng.Integrate(ng.CF(1.0), body.mesh)
    assert body.energy(np.array(field.vec.FV().NumPy())) == pytest.approx(density * area, rel=1e-12)


@every_law
def test_the_body_at_rest_is_any_laws(rubber: Rubber) -> None:
    one, other = plane_body_of(rubber).rest.matrix, plane_body_of(None).rest.matrix
    assert abs(one - other).max() <= 1e-12 * abs(other).max()  # rounding


@every_law
def test_the_solids_derivatives_are_its_energys(rubber: Rubber) -> None:
    """As the plane body's: 1e-5, truncation, and at small strain what the energies' differences round to."""
    body, random = solid(rubber), np.random.default_rng(7)
    gradient = np.array([[0.1, 0.3, 0.0], [-0.1, 0.2, 0.1], [0.2, 0.0, -0.2]])
    for strain in (1e-2, 1.0):
        state = affine(body, strain * gradient) + 1e-3 * random.standard_normal(body.free.size)
        step = random.standard_normal(body.free.size) * body.free
        size = 1e-5
        slope = (body.energy(state + size * step) - body.energy(state - size * step)) / (2 * size)
        residual = body.residual(state)
        assert residual @ step == pytest.approx(slope, rel=1e-5)
        linear = body.linearised(state, residual)
        move = linear.move(np.zeros_like(state))  # along it the residual changes by minus itself
        size = 1e-5 / np.abs(move).max()
        after, before = (body.residual(state + s * size * move) for s in (1, -1))
        change = (after - before)[body.free] / (2 * size)
        assert np.abs(change + residual[body.free]).max() <= 1e-5 * np.abs(residual).max()


@every_law
def test_the_solid_at_rest_is_any_laws(rubber: Rubber) -> None:
    one, other = (body.linearised(*np.zeros((2, body.free.size))) for body in (solid(rubber), solid(None)))
    assert one.flexibility == pytest.approx(other.flexibility, abs=1e-11 * np.abs(other.flexibility).max())


@cache
def solid(rubber: Rubber | None) -> SolidBody:
    pad = replace(block(2.0, 2.0, 0.4), law=rubber)
    return body_of(meshed_of(pad, 0.5, whole=True), Layers(0.9, 2.0, 2))


def test_an_unknown_law_is_refused() -> None:
    with pytest.raises(InputError, match="kind: unknown law, got 'ogdn'; did you mean 'ogden'"):
        law_of({"kind": "ogdn"})
    with pytest.raises(InputError, match="kind: is missing; take one of neo-hooke"):
        law_of({"mu": 1.0})


@every_law
def test_stress_and_modulus_are_the_energys_slopes(rubber: Rubber) -> None:
    """By central differences: 1e-7 is their truncation and rounding."""
    stretch, step = np.array([0.7, 0.95, 1.0, 1.2, 1.6]), 1e-5
    for of, slope in ((rubber.strain_energy, rubber.stress), (rubber.stress, rubber.tangent_modulus)):
        differences = (of(stretch + step) - of(stretch - step)) / (2 * step)
        assert slope(stretch) == pytest.approx(differences, rel=1e-7, abs=1e-8)
    at_rest = np.ones(1)
    assert (rubber.strain_energy(at_rest)[0], rubber.stress(at_rest)[0]) == (0.0, 0.0)
    assert rubber.tangent_modulus(at_rest)[0] == pytest.approx(rubber.young_modulus(0.5), rel=1e-13)


@every_law
def test_it_draws_its_curve_and_is_public_by_its_name(rubber: Rubber) -> None:
    assert getattr(skincad.laws, type(rubber).__name__) is type(rubber)
    (axes,) = rubber.figure().axes
    stress, modulus = (line.get_ydata() for line in axes.lines)
    stretch = axes.lines[0].get_xdata()
    np.testing.assert_array_equal(stress, rubber.stress(stretch))
    np.testing.assert_array_equal(modulus, rubber.tangent_modulus(stretch))
    assert "base64" in rubber._repr_html_()


def test_no_law_of_another_name() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Hooke'"):
        skincad.laws.Hooke  # noqa: B018
