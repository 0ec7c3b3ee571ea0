"""Every law against its closed forms, and what each must be: a table with one energy, tested by being listed.

Sources: Treloar, The Physics of Rubber Elasticity, 3rd ed. 1975, sections 5.3 and 10.2; Yeoh, Rubber Chem.
Technol. 63 (1990) 792; Gent, Rubber Chem. Technol. 69 (1996) 59; Ogden, Proc. R. Soc. A 326 (1972) 565, eqs
(37) and (41).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import NamedTuple

import ngsolve as ng
import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.laws import LAWS, Gent, MooneyRivlin, NeoHooke, Ogden, Rubber, Yeoh, law, law_of
from skincad.mechanics import Excess, Layers, Sizes, SolidBody, body_of, excess, triangles
from skincad.mechanics.bodies import elements, plane_body
from tests.mechanics.bodies.test_elements import block
from tests.mechanics.models.test_solid_finite_strain import affine, meshed_of

Array = np.ndarray
ARRAYS = SimpleNamespace(
    exp=np.exp, log=np.log, sqrt=np.sqrt, IfPos=lambda c, a, b: np.where(np.real(c) > 0, a, b)
)
STEP = 1e-30  # of a complex step: exact to rounding
STRETCHES = (0.6, 0.97, 1.0 + 1e-6, 1.3, 1.9)
SHIFTS = (-0.8, 1e-3, 0.15, 0.7)


class Closed(NamedTuple):
    """A law and its nominal stresses, MPa, of kept volume: of a bar and of a sheet pulled both ways by a
    stretch, and of simple shear by a shift."""

    law: Rubber
    bar: Callable[[float], float]
    sheet: Callable[[float], float]
    sheared: Callable[[float], float]


def plane_energy(law: Rubber, gradient: Array, pressure: float = 0.0, bulk: float = 1e3) -> complex:
    """The plane body's energy density at one point, MPa."""
    whole = plane_body.strain_energy(gradient, pressure, law.shear, bulk, np.log)
    return complex(whole + law.shear * excess(law, gradient, ARRAYS))


def plane_stress(law: Rubber, gradient: Array) -> Array:
    """First Piola-Kirchhoff stress `(2, 2)`, MPa, without a pressure."""
    stress = np.zeros((2, 2))
    for at in np.ndindex(2, 2):
        moved = gradient.astype(complex)
        moved[at] += 1j * STEP
        stress[at] = plane_energy(law, moved).imag / STEP
    return stress


def solid_stress(law: Rubber, stretch: Array) -> Array:
    """First Piola-Kirchhoff stress `(3, 3)`, MPa, of F in three dimensions, without a pressure."""
    swell = np.full((1, 1), np.linalg.det(stretch) - 1)
    more = Excess(law, np.zeros(1, dtype=int), stretch[None, None], swell)
    cofactor = np.linalg.inv(stretch).T  # over J
    stress = stretch - cofactor + more.stress()[0, 0] + more.volume[0, 0] * cofactor
    return law.shear * (stress - 2 / 3 * swell[0, 0] * (1 + swell[0, 0]) * cofactor)


MU, LIMIT = 0.3, 20.0
C1, C2, C3 = 0.15, 0.03, 0.004
TERMS = ((0.2, 2.5), (0.06, -1.7), (0.01, 7.0))


def mooney(c10: float, c01: float) -> Closed:
    return Closed(
        MooneyRivlin(c10=c10, c01=c01),
        bar=lambda t: 2 * (t - t**-2) * (c10 + c01 / t),
        sheet=lambda t: 2 * (t - t**-5) * (c10 + c01 * t**2),
        sheared=lambda k: 2 * (c10 + c01) * k,
    )


def by_first_invariant(law: NeoHooke | Yeoh | Gent, slope: Callable[[float], float]) -> Closed:
    """Of a law whose energy has this slope in I1, at I1 - 3."""
    return Closed(
        law,
        bar=lambda t: 2 * (t - t**-2) * slope(t**2 + 2 / t - 3),
        sheet=lambda t: 2 * (t - t**-5) * slope(2 * t**2 + t**-4 - 3),
        sheared=lambda k: 2 * k * slope(k**2),
    )


def ogden(terms: tuple[tuple[float, float], ...]) -> Closed:
    def summed(of: Callable[[float], float]) -> float:
        return sum(2 * mu / a * of(a) for mu, a in terms)

    def sheared(shift: float) -> float:
        stretch = (shift + np.sqrt(shift**2 + 4)) / 2
        return summed(lambda a: (stretch**a - stretch**-a) / (stretch + 1 / stretch))

    return Closed(
        Ogden(mu=[mu for mu, _ in terms], alpha=[a for _, a in terms]),
        bar=lambda t: summed(lambda a: t ** (a - 1) - t ** (-a / 2 - 1)),
        sheet=lambda t: summed(lambda a: t ** (a - 1) - t ** (-2 * a - 1)),
        sheared=sheared,
    )


CLOSED = {
    "neo-hooke": by_first_invariant(NeoHooke(mu=MU), lambda _: MU / 2),
    "yeoh": by_first_invariant(Yeoh(c10=C1, c20=C2, c30=C3), lambda i: C1 + 2 * C2 * i + 3 * C3 * i**2),
    "gent": by_first_invariant(Gent(mu=MU, j_m=LIMIT), lambda i: MU / 2 * LIMIT / (LIMIT - i)),
    **{f"mooney-rivlin {pair}": mooney(*pair) for pair in ((0.11, 0.05), (0.3, 0.0), (0.3, -0.02))},
    **{
        f"ogden {terms}": ogden(terms)
        for terms in (TERMS[:1], TERMS, ((0.3, 2.0),), ((0.3, -14.0),), ((0.3, 14.0),))
    },
}


@pytest.mark.parametrize("name", CLOSED)
def test_closed_forms(name: str) -> None:
    """1e-12 of the shear modulus is rounding."""
    closed = CLOSED[name]
    law, within = closed.law, 1e-12 * closed.law.shear
    for t in STRETCHES:
        assert law.stress(np.array([t]))[0] == pytest.approx(closed.bar(t), rel=1e-11, abs=within)
        bar, sheet = (np.diag([t, *free]) for free in ((t**-0.5, t**-0.5), (t, t**-2)))
        for stretch, wanted in ((bar, closed.bar(t)), (sheet, closed.sheet(t))):
            stress = np.diag(solid_stress(law, stretch))
            free = stress[2] * stretch[2, 2] / t  # what a pressure takes off
            assert stress[0] - free == pytest.approx(wanted, rel=1e-11, abs=3 * within)
    for shift in SHIFTS:
        result = plane_stress(law, np.array([[0.0, shift], [0.0, 0.0]]))
        assert result[0, 1] == pytest.approx(closed.sheared(shift), rel=1e-11, abs=within)
        in_space = np.eye(3)
        in_space[:2, :2] += [[0.0, shift], [0.1, 0.2]]
        in_plane = plane_stress(law, in_space[:2, :2] - np.eye(2))
        assert solid_stress(law, in_space)[:2, :2] == pytest.approx(in_plane, rel=1e-11, abs=within)
        turned = np.array([[0.0, 0.0], [shift, 0.0]])
        assert plane_stress(law, turned)[1, 0] == pytest.approx(closed.sheared(shift), rel=1e-11, abs=within)


def test_gent_tends_to_neo_hooke_and_ends_where_chains_are_straight() -> None:
    stretch = np.linspace(0.5, 2.0, 7)
    far = Gent(mu=MU, j_m=1e6).stress(stretch)
    assert far == pytest.approx(NeoHooke(mu=MU).stress(stretch), rel=3e-6)  # (I1 - 3) / j_m
    near, past_end = Gent(mu=MU, j_m=2.0).stress(np.array([1.99, 2.01]))  # I1 - 3 is 2 at a stretch of 2
    assert near > 50 * MU
    assert np.isnan(past_end)


def test_powers_2_and_minus_2_are_mooney_rivlin() -> None:
    gradient = np.array([[0.3, -0.2], [0.5, 0.1]])
    two, one = Ogden(mu=[0.4, 0.2], alpha=[2.0, -2.0]), MooneyRivlin(c10=0.2, c01=0.1)
    assert plane_stress(two, gradient) == pytest.approx(plane_stress(one, gradient), rel=1e-12)  # rounding


@pytest.mark.parametrize("power", [-14.0, -3.0, 0.1, 2.4, 14.0])
def test_the_series_meets_the_root(power: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same stress by both ways where they meet: 1e-10, the rest is what the root's slope loses."""
    law, gradient = Ogden(mu=[1.0], alpha=[power]), np.array([[0.06, 0.07], [0.02, -0.03]])
    errors = []
    for near in (0.0, 1.0):
        monkeypatch.setattr(plane_body, "NEAR", near)
        errors.append(plane_stress(law, gradient))
    assert errors[0] == pytest.approx(errors[1], abs=1e-10)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"alpha": [2.0, 3.0]}, "alpha: must have as many numbers as mu, 1"),
        ({"alpha": [0.0]}, "alpha: must be from 0.1 to 14"),
        ({"mu": [-1.0]}, "must have a shear modulus above 0 MPa"),
        ({"mu": 1.0}, "mu: must be a list"),
        ({"mu": [3.0, -2.0], "alpha": [-9.0, 4.0]}, "must pull a bar the more the longer it is"),
    ],
)
def test_terms_that_are_none_are_refused(change: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Ogden(**{"mu": [1.0], "alpha": [2.0], **change})


ALL = [
    pytest.param(
        candidate.make(np.array(candidate.start) * (1.0, *(1.1,) * (len(candidate.start) - 1))),
        id=candidate.name,
    )
    for kind in LAWS
    for candidate in law(kind).candidates()
]
every_law = pytest.mark.parametrize("rubber", ALL)
QUICK = ("neo-hooke", "gent", "ogden, 2 terms")
dear_law = pytest.mark.parametrize(
    "rubber", [p if p.id in QUICK else pytest.param(*p.values, id=p.id, marks=pytest.mark.slow) for p in ALL]
)


@every_law
def test_it_is_the_table_that_it_dumps(rubber: Rubber) -> None:
    assert law_of(rubber.model_dump()) == rubber
    assert type(rubber) is law(rubber.kind)
    assert sum(share for share, _ in rubber.powers) == pytest.approx(1.0, rel=1e-14)
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
        whole = body.linearised(state, np.zeros_like(state)).recover(step)
        size = 1e-5 / np.abs(whole).max()
        slope = body.energy(state + size * whole) - body.energy(state - size * whole)
        assert body.residual(state) @ whole == pytest.approx(slope / (2 * size), rel=1e-5)
        after, before = (body.residual(state + s * size * whole) for s in (1, -1))
        wanted = body.linearised(state, np.zeros_like(state)).matrix @ step
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


@dear_law
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


@dear_law
def test_the_solid_at_rest_is_any_laws(rubber: Rubber) -> None:
    one, other = (body.linearised(*np.zeros((2, body.free.size))) for body in (solid(rubber), solid(None)))
    assert one.flexibility == pytest.approx(other.flexibility, abs=1e-11 * np.abs(other.flexibility).max())


@cache
def solid(rubber: Rubber | None) -> SolidBody:
    pad = replace(block(2.0, 2.0, 0.4), law=rubber)
    return body_of(meshed_of(pad, 0.5, whole=True), Layers(0.9, 2.0, 2))


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


@dear_law
def test_it_draws_its_curve_and_is_public_by_its_name(rubber: Rubber) -> None:
    assert getattr(skincad.laws, type(rubber).__name__) is type(rubber)
    (axes,) = rubber.figure().axes
    stress, modulus = (line.get_ydata() for line in axes.lines)
    stretch = axes.lines[0].get_xdata()
    np.testing.assert_array_equal(stress, rubber.stress(stretch))
    np.testing.assert_array_equal(modulus, rubber.tangent_modulus(stretch))
    assert "base64" in rubber._repr_html_()


def test_an_unknown_law_is_refused() -> None:
    with pytest.raises(InputError, match="kind: unknown law, got 'ogdn'; did you mean 'ogden'"):
        law_of({"kind": "ogdn"})
    with pytest.raises(InputError, match="kind: is missing; take one of neo-hooke"):
        law_of({"mu": 1.0})
    with pytest.raises(AttributeError, match="no attribute 'Hooke'"):
        skincad.laws.Hooke  # noqa: B018
