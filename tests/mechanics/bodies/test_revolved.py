"""A section that turns about x = 0: spheres, discs, rings and pins, against closed forms and CalculiX."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Literal

import ngsolve as ng
import numpy as np
import pytest

import skincad
from bench import calculix
from skincad.base import InputError
from skincad.inputs import Design
from skincad.laws import Ogden
from skincad.mechanics import Pad, Request, half_of, pad_of, plane_piece, problem
from skincad.mechanics import finite_strain as finite_strain_bound
from skincad.mechanics import left_out as bounds
from skincad.mechanics.bodies import elements, plane_body, solid_law
from skincad.mechanics.models import finite_strain, linear
from skincad.shape import Point, Section, Segment, cell_section
from tests.designs import rings

MODULUS, INCOMPRESSIBLE = 0.7, 0.4999


def disc(radius: float, height: float, ratio: float) -> Pad:
    """A disc bonded to its back, whose whole face touches."""
    corners = [Point(*p) for p in ((-radius, 0), (radius, 0), (radius, height), (-radius, height))]
    kinds = ("back", "side", "base", "side")
    outline = [
        Segment(a, b, 0.0, kind, 1 if kind == "base" else None, kind == "base")
        for a, b, kind in zip(corners, [*corners[1:], corners[0]], kinds, strict=True)
    ]
    return Pad(Section(tuple(outline)), 1.0, MODULUS, ratio, revolved=True)


def ball(ratio: float, **of_material: float) -> Design:
    """A flat skin that is the cap of a ball, on a base of 50 times the contact."""
    skin = {"outline": "round", "curvature_radius": 60.0, "thickness": 50.0, "width": 60.0}
    material = {"young_modulus": MODULUS, "poisson_ratio": ratio, **of_material}
    return skincad.Design(
        name="ball", skin=skin, flat={}, material=material, mold={"process": "sla"}, contact={"force": 1.0}
    )


@pytest.mark.parametrize("model", ["linear", pytest.param("finite-strain", marks=pytest.mark.slow)])
@pytest.mark.parametrize("ratio", [0.3, INCOMPRESSIBLE])
def test_a_ball_touches_as_hertz_says(ratio: float, model: str) -> None:
    """Johnson, Contact Mechanics, eq. (4.22) to (4.24). The base of 50 mm gives 1 % of the approach, and the
    pressure 2e-3 of its peak at the middle, where a force is shared by few points. Strain, half / radius, is
    0.008."""
    radius, half, stiffness = 60.0, 0.5, MODULUS / (1 - ratio**2)
    force, peak = 4 * stiffness * half**3 / (3 * radius), 2 * stiffness * half / (math.pi * radius)
    pad = problem.focused(pad_of(ball(ratio)), force)
    solve = linear.level if model == "linear" else finite_strain.level
    answer, best = linear.refine(pad, Request(force), solve, model)
    assert answer.approach.value == pytest.approx(half**2 / radius, rel=0.015)
    edge = best.x[best.pressure > 0].max()
    assert edge == pytest.approx(half, rel=0.01)  # between two points
    inside = best.x < 0.9 * half
    wanted = peak * np.sqrt(1 - (best.x[inside] / half) ** 2)
    assert best.pressure[inside] == pytest.approx(wanted, abs=0.01 * peak)


@pytest.mark.slow
def test_a_face_is_pressed_far_beyond_small_strain(monkeypatch: pytest.MonkeyPatch) -> None:
    """At 8 N flat-magnet's clamped corners fold without the small-strain law there; what it changes is within
    the error, and what small strain leaves out within its bound."""
    design = skincad.load("flat-magnet")
    pad, small = pad_of(design), linear.answer(design, Request(8.0))
    answer = finite_strain.solve(problem.focused(pad, 8.0), Request(8.0)).approach
    change = abs((answer.value or 0.0) / (small.approach.value or 0.0) - 1)
    assert 0.1 < change < finite_strain_bound(design, small, 8.0).approach
    monkeypatch.setattr(plane_body, "FACE_EDGE", 2 * plane_body.FACE_EDGE)
    wider = finite_strain.solve(problem.focused(pad, 8.0), Request(8.0)).approach
    assert abs((wider.value or 0.0) - (answer.value or 0.0)) < (answer.error or 0.0)
    monkeypatch.setattr(plane_body, "FACE_EDGE", plane_body.CLAMPED_EDGE)
    with pytest.raises(InputError, match="inside out"):
        finite_strain.solve(problem.focused(pad, 8.0), Request(8.0))


@pytest.mark.slow
def test_a_contact_is_no_wider_than_its_face() -> None:
    """20 N press a nearly level face of 20 mm all over: 22 ± 13 mm by the root of the approach."""
    design = skincad.load("flat-magnet").with_(skin={"curvature_radius": 400.0}, contact={"force": 20.0})
    width = skincad.check(design, model="corrected").contact_width
    assert width is not None
    assert width.upper == design.skin.width
    assert 0.0 < width.lower < 15.0


@pytest.mark.parametrize("height", [2.0, pytest.param(1.0, marks=pytest.mark.slow)])
def test_a_bonded_disc_is_stiff_as_gent_and_lindley_say(height: float) -> None:
    """E (1 + 2 S^2), of a disc bonded on both sides and twice as high; S = radius / (4 height). Proc. Inst.
    Mech. Eng. 173 (1959) 111: a bound that takes plane sections as plane, up to 6 % soft at S of 1 to 3."""
    radius, force = 8.0, 0.5
    state = linear.level(plane_piece(disc(radius, height, INCOMPRESSIBLE)), 3, force)
    shape = radius / (4 * height)
    modulus = force * height / (math.pi * radius**2 * state.approach)
    assert modulus == pytest.approx(MODULUS * (1 + 2 * shape**2), rel=0.06)


@pytest.mark.parametrize("solve", [linear.level, finite_strain.level])
def test_a_disc_without_sideways_strain_is_the_law(solve: linear.LevelSolver) -> None:
    """At nu = 0 it stays straight: E e, and G (1/l - l), but for the small-strain law at its clamped edge."""
    radius, height, force = 3.0, 2.0, 6.0
    state = solve(plane_piece(disc(radius, height, 0.0)), 2, force, (), None)
    stress = force / (math.pi * radius**2)
    if solve is linear.level:
        assert state.approach == pytest.approx(stress / MODULUS * height, rel=1e-9)
        assert state.pressure == pytest.approx(np.full(state.x.size, stress), rel=1e-6)  # rounding near x = 0
    else:
        stretch = (math.hypot(stress / MODULUS * 2, 2) - 2 * stress / MODULUS) / 2
        assert state.approach == pytest.approx((1 - stretch) * height, rel=2e-3)


@pytest.mark.parametrize("law", [None, Ogden(mu=[0.7, 0.3], alpha=[6.0, -3.0])])
def test_the_energy_of_an_even_stretch_is_the_laws(
    law: Ogden | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """u_x = (a - 1) x, whose hoop stretch is a: density times volume, in three dimensions; rounding."""
    monkeypatch.setattr(plane_body, "CLAMPED_EDGE", 0.0)  # the small-strain law is nowhere
    across, up, ratio = 1.3, 0.7, 0.4
    piece = plane_piece(replace(disc(3.0, 2.0, ratio), law=law))
    body = plane_body.body(
        elements.curved(piece.mesh, 2), 2, {"skin": (1.0, ratio)}, piece.pad.laws, revolved=True
    )
    field = ng.GridFunction(body.space)
    swell = across**2 * up - 1
    shear, bulk = 1 / (2 * (1 + ratio)), 1 / (3 * (1 - 2 * ratio))
    field.components[0].Set(ng.CF(((across - 1) * ng.x, (up - 1) * ng.y)))
    field.components[1].Set(ng.CF(bulk * swell))
    h = np.diag([across - 1, across - 1, up - 1])[:, :, None]
    density = plane_body.strain_energy(h, bulk * swell, shear, bulk, np.log)[0]
    if law:
        deformed = (np.eye(3) + h[:, :, 0])[None, None]
        density += shear * float(solid_law.excess_density(law, deformed, np.array([[swell]]))[0, 0])
    volume = math.pi * 9.0 * 2.0 / piece.unit**3
    assert body.energy(np.array(field.vec.FV().NumPy())) == pytest.approx(volume * density, rel=1e-10)


def test_a_wide_ring_is_a_ridge() -> None:
    """Of radius r it is a ridge as long as 2 pi r: by the same section in plane strain. They differ
    by a part of (width / r), which is 0.03, and of its square where the section is even about the ring."""
    ring = {"count": 1, "radius": 50.0, "pitch": 2.0, "height": 1.0, "root_width": 1.5, "tip_width": 1.0}
    skin = {"outline": "round", "curvature_radius": 1e8, "thickness": 1.0, "width": 106.0, "length": 106.0}
    design = rings().with_(ring={**ring, "crown": 0.08}, skin=skin)
    revolved = pad_of(design)
    plane = replace(revolved, revolved=False, length=math.pi * 50.0)
    one, other = (linear.level(plane_piece(pad, 0.5), 2, 20.0) for pad in (revolved, plane))
    assert one.approach == pytest.approx(other.approach, rel=2e-3)


def test_one_pin_alone_stands_on_a_disc() -> None:
    pin = {"pitch": 5.0, "columns": 1, "rows": 1, "height": 3.0, "root_diameter": 2.0, "tip_diameter": 2.0}
    skin = {"outline": "round", "curvature_radius": 1e8, "thickness": 3.0, "width": 9.0, "length": 9.0}
    design = skincad.Design(
        name="pin",
        skin=skin,
        pin={**pin, "crown": 1.0},
        material={"young_modulus": MODULUS},
        mold={"process": "sla"},
        contact={"force": 0.1},
    )
    pad = pad_of(design)
    volume = 2 * math.pi * half_of(pad).section.area * half_of(pad).section.centroid.x  # type: ignore[union-attr]
    base, shaft, cap = (
        math.pi * 4.5**2 * 3,
        math.pi * 2.0,
        2 / 3 * math.pi,
    )  # the pin: a cylinder, half a ball
    assert volume == pytest.approx(base + shaft + cap, rel=1e-7)  # the base of 1e8 mm falls by 1e-7 mm
    assert cell_section(design, 4.5).area == pytest.approx(pad.section.area, rel=1e-7)
    with pytest.raises(InputError, match=r"skin\.width: must leave base round a pin's foot"):
        cell_section(design, 0.9)
    with pytest.raises(InputError, match=r"skin\.outline: must be 'round'"):
        pad_of(design.with_(skin={"outline": "rectangle"}))
    with pytest.raises(InputError, match="pin: must be one"):
        pad_of(design.with_(skin={"width": 12.0, "length": 12.0}, pin={"columns": 2}))


@pytest.mark.evidence(subject="calculix: rings")
@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
@pytest.mark.parametrize("large", [False, True])
def test_calculix_gives_the_same_rings(large: bool) -> None:
    """CAX8R under a plate: 3e-3 of the approach and a mean share, the coarse mesh's; the all-touch
    force to 1 %, between whose ends the last ring takes up load."""
    ours = pressed(large)
    theirs = calculix.press(pad_of(rings()), 0.5, FORCE, 0.95 * ours.approach if large else None)
    assert theirs.approach == pytest.approx(ours.approach, rel=3e-3)
    assert theirs.shares == pytest.approx(ours.ridge_force, abs=3e-3 * FORCE / 3)
    needed = ours.all_touch_force
    last = [
        calculix.press(pad_of(rings()), 0.5, by * needed, 0.9 * ours.approach if large else None).shares[-1]
        for by in (0.99, 1.01)
    ]
    assert last[0] <= 0.0 < last[1]


FORCE = 3.0


@cache
def pressed(large: bool) -> linear.PlaneSolution:
    return (finite_strain.level if large else linear.level)(plane_piece(pad_of(rings())), 3, FORCE)


def pocketed(pad: Pad, diameter: float, depth: float, kind: Literal["side", "back"]) -> Pad:
    """A section that turns with a pocket in the middle of its back: empty, or filled by something rigid."""
    (back,) = (s for s in pad.section.outline if s.kind == "back")
    to, half = math.copysign(1.0, back.end.x - back.start.x), diameter / 2
    corners = [
        back.start,
        Point(-to * half, 0.0),
        Point(-to * half, depth),
        Point(to * half, depth),
        Point(to * half, 0.0),
        back.end,
    ]
    kinds: list[Literal["side", "back"]] = ["back", kind, kind, kind, "back"]
    edges = [
        replace(back, start=a, end=b, kind=k) for (a, b), k in zip(pairwise(corners), kinds, strict=True)
    ]
    outline = [e for s in pad.section.outline for e in (edges if s is back else [s])]
    return replace(pad, section=Section(tuple(outline)))


@pytest.mark.parametrize("kind", ["side", pytest.param("back", marks=pytest.mark.slow)])
@pytest.mark.parametrize("family", ["pin", pytest.param("flat", marks=pytest.mark.slow)])
def test_a_pocket_changes_the_approach_within_its_bound(family: str, kind: Literal["side", "back"]) -> None:
    pocket = {"diameter": 1.6, "depth": 3.5}
    table: dict[str, object] = {"pitch": 9.0, "columns": 1, "rows": 1, "pocket": pocket}
    if family == "pin":
        table |= {"height": 3.0, "root_diameter": 3.4, "tip_diameter": 3.0, "crown": 0.5}
    radius = 60.0 if family == "flat" else 1e8
    skin = {"outline": "round", "curvature_radius": radius, "thickness": 5.0, "width": 20.0}
    material = {"young_modulus": 0.3, "poisson_ratio": 0.49}
    rest = {"material": material, "mold": {"process": "sla"}, "contact": {"force": 0.5}}
    design = skincad.Design(name="pocket", skin=skin, **{family: table}, **rest)
    pad = problem.focused(pad_of(design), 0.5)
    whole = linear.solve(pad, Request(0.5))
    (bound,) = bounds.left_out((bounds.POCKETS,), design, whole, 0.5)
    change = linear.solve(pocketed(pad, 1.6, 3.5, kind), Request(0.5)).approach.value or 0.0
    change = change / (whole.approach.value or 1.0) - 1
    assert (change > 0) == (kind == "side")  # empty is softer
    assert 0.01 < abs(change) < bound.approach
