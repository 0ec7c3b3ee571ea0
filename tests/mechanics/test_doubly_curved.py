"""A skin curved along y too: the solid against itself, the straight one and CalculiX; the closed form against
the solid, and its limits."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import integrate

from skincad import check
from skincad.base import InputError
from skincad.inputs import Design
from skincad.mechanics import crest_gaps, meshed_piece, pad_of, problem, ridge_stiffness, solid_pad_of
from skincad.mechanics.bodies import prisms, solid_body, solid_law
from skincad.mechanics.models import solid as level
from skincad.mechanics.models import winkler
from skincad.outputs import tetrahedra
from tests.mechanics.bodies.test_elements import block
from tests.mechanics.designs import reference, yamada
from tests.outputs.simulators import ccx

SKINS = (("thickness", 8.0), ("thickness", 2.0), ("length", 24.0))
INSIDE = [
    *product(({}, *({"skin": {key: value}} for key, value in SKINS)), (20.0, 60.0, 1e3), (4.0,)),
    *(({"ridge": {"count": 5}}, radius, 4.0) for radius in (20.0, 60.0, 1e3)),
    # one ridge carries three quarters or all, where the springs share among three
    ({}, 20.0, 0.004),
    ({"skin": {"thickness": 12.0}}, 60.0, 0.02),
]


def bent(design: Design, radius: float) -> Design:
    return design.with_(skin={"curvature_radius_y": radius})


def solved(design: Design, radius: float, force: float) -> level.LevelAnswer:
    """The solid, on a coarse mesh and without friction."""
    pad = solid_pad_of(bent(design, radius))
    meshed = meshed_piece(pad, level.coarse_sizes(pad, 1.0))
    return level.solve_level(meshed, level.forms_of(meshed, 2), level.Layers(0.4, 1.8, 4), force, {})


@pytest.mark.evidence(subject="doubly curved")
@pytest.mark.parametrize(("change", "radius", "force"), INSIDE)
def test_solid_lies_inside_the_closed_forms_error(
    change: dict[str, Any], radius: float, force: float
) -> None:
    design = reference().with_(**change)
    spring, solid = check(bent(design, radius), model="winkler", force=force), solved(design, radius, force)
    for one, other in (
        (spring.all_touch_force, solid.all_touch_force or 0.0),
        (spring.approach, solid.approach),
        *zip(spring.ridge_force, solid.ridge_force, strict=True),
    ):
        assert abs((one.value or 0.0) - other) <= (one.error or 0.0)


BEND = problem.Bend(20.0, -17.0)  # of a section whose base is 3 mm thick


def forms_and_borders() -> tuple[prisms.SectionForms, np.ndarray]:
    """A coarse section of three ridges, and four layers, in units."""
    pad = pad_of(reference().with_(ridge={"count": 3}, skin={"width": 4.0, "thickness": 3.0}))
    meshed = meshed_piece(pad, level.coarse_sizes(pad, 0.7))
    return level.forms_of(meshed, 2), np.linspace(0.0, 6.0, 5) / meshed.unit


def test_a_solid_that_hardly_turns_is_the_straight_one() -> None:
    forms, borders = forms_and_borders()
    straight, turned = (
        prisms.condensed(forms, prisms.line(borders, 2, bend=bend)).flexibility
        for bend in (None, problem.Bend(1e7, 3.0 - 1e7))
    )
    # the arc's length varies by 4 / 1e7 over the height, times what incompressible silicone makes of it
    assert np.abs(turned - straight).max() < 1e-5 * np.abs(straight).max()


@pytest.mark.slow
def test_a_lift_of_the_back_lifts_all() -> None:
    """A rigid movement, which in turned sections is neither away from the axis nor around it: no stress."""
    forms, borders = forms_and_borders()
    bend = BEND.over(float(borders[-1] / 6.0) ** -1)
    errors = [
        prisms.condensed(forms, prisms.line(borders, order, bend=bend)).rigid_body_error
        for order in (2, 3, 4)
    ]
    assert max(errors) < 1e-9
    missed = [prisms.missed_lift(prisms.line(borders, order, bend=bend)) for order in (2, 3, 4)]
    assert missed[2] < 0.1 * missed[1] < 0.01 * missed[0] < 1e-6


def test_small_strain_is_the_tangent_at_rest_of_finite_strain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two programs: one integrates along y once for all triangles, in movements that turn with the section.

    The other does it point by point, in movements along x, z and y. Their functions differ by a power of a
    layer's angle: under an even pressure ten times less with half the layers' thickness.
    """
    monkeypatch.setattr(solid_law, "POINTWISE_BULK", 0.0)
    meshed = meshed_piece(block(3.0, 2.0, 0.499), level.coarse_sizes(block(3.0, 2.0, 0.499), 1.0))
    forms, bend = level.forms_of(meshed, 2), problem.Bend(10.0, -8.0)
    off = []
    for layers in (2, 4):
        borders = np.linspace(0.0, 3.0, layers + 1)
        body, line = solid_body.solid_body(forms, borders, 3, bend=bend), prisms.line(borders, 3, bend=bend)
        rest, load = np.zeros(body.free.size), body.rest.nodes.rows.T @ body.rest.nodes.weight
        sinks, other, straight = (
            float(load @ flexibility @ load)
            for flexibility in (
                body.linearised(rest, rest).flexibility,
                prisms.condensed(forms, line).flexibility,
                prisms.condensed(forms, prisms.line(borders, 3)).flexibility,
            )
        )
        off.append(abs(sinks / other - 1))
        assert abs(straight / other - 1) > 0.05

    assert off[1] < 0.1 * off[0] < 5e-5


@pytest.mark.evidence(subject="calculix: doubly curved")
@pytest.mark.skipif(bool(ccx.missing()), reason=ccx.missing())
def test_calculix_finds_the_same_force() -> None:
    """At the solid's approach. Measured -1.0 % on a package's tetrahedra, +0.2 % on layers half as thick."""
    design = reference().with_(ridge={"count": 3}, skin={"curvature_radius": 20.0, "width": 4.0})
    design = bent(design, 30.0).with_(contact={"friction": 0.0, "force": 1.2})
    verdict = check(design, model="solid", tol=0.05)
    force = ccx.pressed(design, tetrahedra(design, 0.5), float(verdict.approach))
    assert force == pytest.approx(verdict.force, rel=0.02)


@pytest.mark.parametrize("approach", [1e-4, 0.05, 0.4])
def test_force_is_the_springs_integral_along_the_ridge(approach: float) -> None:
    design = bent(yamada(), 20.0)
    per_angle = ridge_stiffness(design) * 20.0 / 12.0
    total = 0.0
    for lean, depth in zip(range(1, 10), approach - crest_gaps(design), strict=True):
        arm = 20.0 + 0.5 - 60.5 * (1 - np.cos(design.lean(lean)))  # of the crest about the axis

        def spring(angle: float, depth: float = depth, arm: float = arm) -> float:
            return per_angle * max(depth - arm * (1 - np.cos(angle)), 0.0)

        edge = np.arccos(1 - depth / arm) if depth > 0 else 0.0
        points = [edge] if 0 < edge < 0.3 else None
        total += 2 * integrate.quad(spring, 0.0, 0.3, points=points, epsabs=0.0)[0]
    force = winkler.line_forces(design, approach).sum()
    assert force == pytest.approx(total, rel=1e-9)  # the cosines' digits at the smallest approach


@pytest.mark.parametrize("force", [1e-9, 0.3, 4.0])
def test_shares_balance_at_any_force(force: float) -> None:
    verdict = check(bent(yamada(), 30.0), force=force, model="winkler")
    assert verdict.residual < 1e-9
    assert sum(f.value or 0.0 for f in verdict.ridge_force) == pytest.approx(force, rel=1e-9)


def test_a_nearly_straight_skin_is_the_straight_one_and_the_rounder_takes_fewer_newtons() -> None:
    straight, *bends = (
        check(design, model="winkler")
        for design in (yamada(), *(bent(yamada(), radius) for radius in (1e8, 1e3, 100.0, 30.0, 10.0)))
    )
    # 0.4 um of fall at the ends of 12 mm, against gaps of 0.13 mm
    assert bends[0].all_touch_force.value == pytest.approx(straight.all_touch_force.value, rel=1e-5)
    assert bends[0].approach.value == pytest.approx(straight.approach.value, rel=1e-5)
    forces = [verdict.all_touch_force.value for verdict in bends]
    assert forces == sorted(forces, reverse=True)


@pytest.mark.slow
def test_auto_takes_the_solid() -> None:
    design = bent(reference(), 30.0)
    verdict, spring = check(design), check(design, model="winkler")
    assert verdict.model in ("solid", "solid-finite-strain")
    assert verdict.manufacture is None
    assert (verdict.all_touch_force.error or 0.0) < 0.1 * (spring.all_touch_force.error or 0.0)
    for sharp, wide in (
        (verdict.all_touch_force, spring.all_touch_force),
        (verdict.approach, spring.approach),
    ):
        assert abs((sharp.value or 0.0) - (wide.value or 0.0)) < (wide.error or 0.0)


def test_a_budget_without_a_solid_ends_with_the_closed_form() -> None:
    verdict = check(bent(yamada(), 30.0), budget=1.0)
    assert verdict.model == "winkler"
    assert verdict.next_model.model == "solid"
    assert any("slopes of up to" in w and "along y" in w for w in verdict.warnings)


def test_a_straight_pad_is_not_taken_for_it() -> None:
    with pytest.raises(InputError, match="leave it out"):
        pad_of(bent(yamada(), 30.0))
    with pytest.raises(InputError, match="measured"):
        check(bent(yamada(), 30.0), measured=Path("crests.csv"))


@pytest.mark.parametrize(
    ("change", "radius", "words"),
    [
        (
            {"skin": {"curvature_radius": 12.0, "thickness": 2.5}, "ridge": {"height": 0.4}},
            40.0,
            "middle is strained by",
        ),
        ({"skin": {"curvature_radius": 12.0}, "slot": None}, 8.0, "slopes by"),
    ],
)
def test_a_crushed_middle_or_too_steep_a_contact_is_no_pass(
    change: dict[str, Any], radius: float, words: str
) -> None:
    verdict = check(bent(yamada().with_(**change), radius), force=50.0, model="winkler")
    assert words in verdict.out_of_range
    assert not verdict.passed


@pytest.mark.parametrize("radius", [20.0, 40.0])
def test_the_slope_that_is_told_is_where_the_plate_cuts_the_crest(radius: float) -> None:
    """A crest along y is a circle of radius R + h; a plate d below its top cuts it where it slopes by
    sqrt(1 - (1 - d / (R + h))^2)."""
    design = bent(yamada().with_(slot=None, film=None), radius)
    verdict = check(design, force=0.5, model="winkler")
    depth = (verdict.approach.value or 0.0) / (radius + design.ridge.height)  # the middle ridge touches first
    slope = math.sqrt(1 - (1 - depth) ** 2)
    assert f"slopes of up to {slope:.2g} along y" in " ".join(verdict.warnings)


@pytest.mark.parametrize("radius", [20.0, 40.0, 1e5])
def test_the_bars_at_usual_sizes_are_what_was_measured_and_little_more(radius: float) -> None:
    """In 47 cases F9 was up to 2.07 times, the approach 1.53 times and a share 0.17 of the mean off."""
    design = bent(yamada().with_(slot=None, film=None), radius)
    verdict = check(design, model="winkler")
    threshold, approach = verdict.all_touch_force, verdict.approach
    assert 1.07 <= (threshold.error or 0.0) / (threshold.value or 1.0) <= 1.5
    assert 0.53 <= (approach.error or 0.0) / (approach.value or 1.0) <= 0.8
