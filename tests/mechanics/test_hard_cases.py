"""Hard cases: shapes, ratios and loads at the ends of what a design may ask, on the tiers that take them.

More of them, on the linear tier alone: test_check.py (extremes, 101 ridges, light and heavy loads).
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from skincad.curves import Segment
from skincad.design import Design
from skincad.errors import InputError
from skincad.mechanics import reference
from skincad.mechanics.check import check
from skincad.mechanics.linear import Level, level
from skincad.mechanics.mesh import default_sizes, triangles
from skincad.mechanics.problem import Pad, pad_of
from skincad.mechanics.solid_level import coarse_sizes
from skincad.section import Section
from tests.mechanics.designs import filleted
from tests.mechanics.designs import reference as sharp

SLOW = [pytest.param(tier, marks=pytest.mark.slow) for tier in ("finite-strain", "solid")]
FLAT = {"curvature_radius": 1e6}
SOFT = {"poisson_ratio": 0.4999999}

HARD = {
    "incompressible": lambda: filleted().with_(material=SOFT),
    "nearly flat": lambda: filleted().with_(skin=FLAT),
    "touching ridges": lambda: sharp().with_(skin=FLAT, ridge={"root_width": 1.0 - 1e-6}),
    "no crown": lambda: filleted().with_(ridge={"crown": 0.0}),
    "no crown nor fillets": lambda: sharp().with_(ridge={"crown": 0.0}),
    "all at once": lambda: sharp().with_(
        skin=FLAT, material=SOFT, ridge={"crown": 0.0, "root_width": 1.0 - 1e-6}
    ),
}


@pytest.mark.parametrize("tier", ["linear", "corrected", *SLOW])
@pytest.mark.parametrize("name", HARD)
def test_hard_case(name: str, tier: str) -> None:
    """All nine touch under 4 N, in balance, and every number has an error."""
    found = check(HARD[name](), tier=tier, tol=0.05)
    assert found.touching == 9
    assert found.residual <= 1e-6  # the tiers' own bound of balance
    assert sum(f.value or 0.0 for f in found.ridge_force) == pytest.approx(4.0, rel=1e-9)
    numbers = (found.all_touch_force, found.approach, *found.ridge_force)
    assert all(math.isfinite(n.value) and math.isfinite(n.error) for n in numbers)


@pytest.mark.parametrize("tier", ["linear", "corrected", *SLOW])
def test_force_tends_to_the_incompressible_one(tier: str) -> None:
    """Distance to the limit over 1 - 2 nu is one number, no locking. 10 %: at 0.49 the next power shows."""
    ratios = np.array([0.49, 0.499, 0.49999, 0.4999999])
    designs = [filleted().with_(material={"poisson_ratio": float(nu)}) for nu in ratios]
    force = np.array([check(d, tier=tier, tol=0.05).all_touch_force.value for d in designs], dtype=float)
    slope = (force[-1] - force[:-1]) / (2 * (ratios[-1] - ratios[:-1]))
    assert slope == pytest.approx(np.full(3, slope[1]), rel=0.1)


GAPS = [*((1e6, gap) for gap in (1e-2, 1e-4, 1e-5, 1e-6, 1e-7)), (120.0, 1e-3), (120.0, 3e-6)]


@pytest.mark.parametrize(("radius", "gap"), GAPS)
def test_touching_ridges_are_meshed(radius: float, gap: float) -> None:
    """On all tiers' meshes; where triangles grow fast, netgen alone fails on gaps of 1e-3 mm and less."""
    pad = pad_of(sharp().with_(skin={"curvature_radius": radius}, ridge={"root_width": 1.0 - gap}))
    for sizes in (default_sizes(pad, 0.5), *(coarse_sizes(pad, fineness) for fineness in (1.0, 1.5))):
        assert len(triangles(pad, sizes).Elements2D()) > 50


def test_ridges_that_overlap_on_the_arc_are_refused() -> None:
    """Straight roots on an arc of 60 mm meet 1e-5 mm before their width is the pitch."""
    with pytest.raises(InputError, match=r"^ridge: the outline crosses itself .*; move ridges apart"):
        pad_of(sharp().with_(ridge={"root_width": 1.0 - 1e-6}))


def test_a_vanishing_gap_is_no_gap() -> None:
    """Forces go to a limit as ridges meet, across the gap below which the mesh closes it: 1e-3, twice the
    mesh's own difference at the notch that is left."""
    forces = []
    for gap in (1e-3, 1e-4, 1e-5, 1e-6):
        pad = pad_of(sharp().with_(skin={"curvature_radius": 1e3}, ridge={"root_width": 1.0 - gap}))
        forces.append(level(pad, triangles(pad, default_sizes(pad)), 3, 4.0).all_touch_force or 0.0)
    assert forces[:-1] == pytest.approx([forces[-1]] * 3, rel=1e-3)


LOADS = {
    "winkler": "must stay below about 1",
    "linear": "must stay below about 1",
    "corrected": "must stay below about 1",
    "finite-strain": "must lie within the finite-strain model's range",
}


@pytest.mark.parametrize("tier", LOADS)
def test_a_load_beyond_the_model_is_refused(tier: str) -> None:
    with pytest.raises(InputError) as caught:
        check(filleted(), tier=tier, tol=0.05, force=1e4)
    assert caught.value.key == "--force"
    assert LOADS[tier] in caught.value.rule
    assert "take a smaller force" in caught.value.remedy


def test_a_load_beyond_any_skin_is_refused_with_the_range() -> None:
    with pytest.raises(InputError, match=r"^--force: must be above 0 N and at most 1e\+06 N, got 1e\+12"):
        check(filleted(), force=1e12)


def one_ridge() -> Design:
    return sharp().with_(ridge={"count": 1}, skin={"width": 3.0})


def narrowed(pad: Pad, reach: float) -> Pad:
    """The same shape, of whose crown only the middle `2 reach` mm may touch and is meshed finely."""
    outline: list[Segment] = []
    for s in pad.section.outline:
        if s.kind != "crown":
            outline.append(s)
            continue
        cuts = [0.0, 0.5 - reach / s.length, 0.5 + reach / s.length, 1.0]
        points = [s.start, s.point(cuts[1]), s.point(cuts[2]), s.end]
        for i, share in enumerate(np.diff(cuts).tolist()):
            bulge = math.tan(s.sweep * share / 4)
            touches = i == 1
            outline.append(
                Segment(
                    points[i], points[i + 1], bulge, "crown" if touches else "flank", 1 if touches else None
                )
            )
    return replace(pad, section=Section(tuple(outline)))


def hertz_of(pad: Pad, force: float) -> reference.LineContact:
    radius = next(s.radius for s in pad.section.outline if s.kind == "crown")
    return reference.hertz(force / pad.length, radius, pad.young_modulus, pad.poisson_ratio)


@cache
def light(force: float) -> Level:
    """A single ridge at order 3 with ten edges across half of its contact."""
    pad = pad_of(one_ridge())
    half_width = hertz_of(pad, force).half_width
    pad = narrowed(pad, 3 * half_width)
    sizes = replace(default_sizes(pad), contact=half_width / 10, ridge=0.06, bulk=0.5, corner=0.002)
    return level(pad, triangles(pad, sizes), 3, force)


def test_a_single_ridge_under_a_micronewton_is_hertzs() -> None:
    """Half-width 0.3 um on a ridge of 0.5 mm: 0.5 %, the mesh's, as in test_elements.py."""
    found, exact = light(1e-6), hertz_of(pad_of(one_ridge()), 1e-6)
    fitted = reference.fitted_line_contact(found.x, found.pressure)
    assert fitted.half_width == pytest.approx(exact.half_width, rel=5e-3)
    assert fitted.peak_pressure == pytest.approx(exact.peak_pressure, rel=5e-3)


def test_a_light_approach_grows_as_the_logarithm() -> None:
    """Far from the contact only the force is felt, near it only the half-width, which goes as its root. So
    approach over force falls by ln(100) / (pi E' L) over two decades. 1 %: the meshes' difference."""
    pad = pad_of(one_ridge())
    plane = pad.young_modulus / (1 - pad.poisson_ratio**2)
    fall = light(1e-6).approach / 1e-6 - light(1e-4).approach / 1e-4
    assert fall == pytest.approx(math.log(100) / (math.pi * plane * pad.length), rel=1e-2)


@pytest.mark.parametrize("tier", ["winkler", "linear", "corrected", "finite-strain", "solid"])
def test_a_single_ridge_takes_a_micronewton(tier: str) -> None:
    found = check(one_ridge(), tier=tier, tol=0.05, force=1e-6)
    assert (found.touching, found.all_touch_force.value) == (1, 0.0)
    assert found.ridge_force[0].value == pytest.approx(1e-6, rel=1e-9)
