"""Hard cases that need more than a row of the catalogue (tests/hard_cases.toml): meshes, a light contact."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from skincad.inputs import Design
from skincad.mechanics import Pad, coarse_sizes, default_sizes, meshed_piece, pad_of, triangles
from skincad.mechanics.models.linear import PlaneSolution, level
from skincad.shape import Section, Segment
from tests.mechanics import closed_forms
from tests.mechanics.designs import reference as sharp

GAPS = [*((1e6, gap) for gap in (1e-2, 1e-4, 1e-5, 1e-6, 1e-7)), (120.0, 1e-3), (120.0, 3e-6)]
FAST = ((1e6, 1e-2), (1e6, 1e-7), (120.0, 3e-6))


@pytest.mark.parametrize(
    ("radius", "gap"),
    [case if case in FAST else pytest.param(*case, marks=pytest.mark.slow) for case in GAPS],
)
def test_touching_ridges_are_meshed(radius: float, gap: float) -> None:
    """On all models' meshes; where triangles grow fast, netgen alone fails on gaps of 1e-3 mm and less."""
    pad = pad_of(sharp().with_(skin={"curvature_radius": radius}, ridge={"root_width": 1.0 - gap}))
    for sizes in (default_sizes(pad, 0.5), *(coarse_sizes(pad, fineness) for fineness in (1.0, 1.5))):
        assert len(triangles(pad, sizes).Elements2D()) > 50


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
                    points[i],
                    points[i + 1],
                    bulge,
                    "crown" if touches else "flank",
                    1 if touches else None,
                    touches,
                )
            )
    return replace(pad, section=Section(tuple(outline)))


def hertz_of(pad: Pad, force: float) -> closed_forms.LineContact:
    radius = next(s.radius for s in pad.section.outline if s.kind == "crown")
    return closed_forms.hertz(force / pad.length, radius, pad.young_modulus, pad.poisson_ratio)


@cache
def light(force: float) -> PlaneSolution:
    """A single ridge at order 3 with ten edges across half of its contact."""
    pad = pad_of(one_ridge())
    half_width = hertz_of(pad, force).half_width
    pad = narrowed(pad, 3 * half_width)
    sizes = replace(default_sizes(pad), contact=half_width / 10, ridge=0.06, bulk=0.5, corner=0.002)
    return level(meshed_piece(pad, sizes, whole=True), 3, force)


def test_a_single_ridge_under_a_micronewton_is_hertzs() -> None:
    """Half-width 0.3 um on a ridge of 0.5 mm: 0.5 %, the mesh's, as in test_elements.py."""
    answer, exact = light(1e-6), hertz_of(pad_of(one_ridge()), 1e-6)
    fitted = closed_forms.fitted_line_contact(answer.x, answer.pressure)
    assert fitted.half_width == pytest.approx(exact.half_width, rel=5e-3)
    assert fitted.peak_pressure == pytest.approx(exact.peak_pressure, rel=5e-3)


def test_a_light_approach_grows_as_the_logarithm() -> None:
    """Far from the contact only the force is felt, near it only the half-width, which goes as its root. So
    approach over force falls by ln(100) / (pi E' L) over two decades. 1 %: the meshes' difference."""
    pad = pad_of(one_ridge())
    plane = pad.young_modulus / (1 - pad.poisson_ratio**2)
    fall = light(1e-6).approach / 1e-6 - light(1e-4).approach / 1e-4
    assert fall == pytest.approx(math.log(100) / (math.pi * plane * pad.length), rel=1e-2)
