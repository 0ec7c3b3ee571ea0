"""Stiffness, condensation and closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from skincad.mechanics import (
    Pad,
    Sizes,
    condense,
    default_sizes,
    meshed_piece,
    pad_of,
    plane_piece,
    triangles,
    unit_of,
)
from skincad.mechanics.bodies import elements
from skincad.mechanics.models.linear import level
from skincad.shape import Point, Section, Segment
from tests.mechanics import closed_forms
from tests.mechanics.designs import THREE, filleted, yamada
from tests.mechanics.designs import reference as sharp


def block(width: float, height: float, ratio: float) -> Pad:
    """A rectangle whose whole top may touch."""
    x = width / 2
    corners = [Point(-x, 0.0), Point(x, 0.0), Point(x, height), Point(-x, height)]
    kinds = ("back", "side", "crown", "side")
    outline = tuple(
        Segment(a, b, kind=kind, feature=1 if kind == "crown" else None, touches=kind == "crown")
        for a, b, kind in zip(corners, [*corners[1:], corners[0]], kinds, strict=True)
    )
    return Pad(Section(outline), 2.0, 0.7, ratio)


def cylinder(radius: float, ratio: float) -> Pad:
    """A thick pad with a top of one radius, of which the middle may touch."""
    half, height, reach = 6.0, 6.0, 0.3

    def at(x: float) -> Point:
        return Point(x, height - 2 * radius * math.sin(math.asin(x / radius) / 2) ** 2)

    def arc(a: float, b: float) -> float:
        return math.tan((math.asin(a / radius) - math.asin(b / radius)) / 4)

    outline = (
        Segment(Point(-half, 0.0), Point(half, 0.0), kind="back"),
        Segment(Point(half, 0.0), at(half), kind="side"),
        Segment(at(half), at(reach), arc(half, reach), "base"),
        Segment(at(reach), at(-reach), arc(reach, -reach), "crown", 1, True),
        Segment(at(-reach), at(-half), arc(-reach, -half), "base"),
        Segment(at(-half), Point(-half, 0.0), kind="side"),
    )
    return Pad(Section(outline), 10.0, 0.8, ratio)


@pytest.mark.parametrize("order", [2, 3, 4])
def test_patch_uniform_stress(order: int) -> None:
    """At nu = 0 a clamped block shortens uniformly: the elements hold it, so only rounding is left."""
    pad = block(3.0, 2.0, 0.0)
    solution = level(plane_piece(pad), order, 0.5)
    assert solution.approach == pytest.approx(closed_forms.column_approach(0.5, 2.0, 6.0, 0.7), rel=1e-9)
    assert solution.pressure == pytest.approx(0.5 / 6.0, rel=1e-7)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.499, 0.4999999])
def test_rigid_translation_needs_no_force(ratio: float) -> None:
    pad = block(3.0, 2.0, ratio)
    mesh = elements.curved(triangles(pad, default_sizes(pad)), 3)
    system = elements.assemble(mesh, 3, {"skin": (1.0, ratio)})
    # rounding of the largest entry, which grows as the bulk modulus
    assert np.abs(system.matrix @ system.lift).max() <= 1e-12 * np.abs(system.matrix.data).max()


@pytest.mark.parametrize("ratio", [0.3, 0.499, 0.49999])
def test_hertz(ratio: float) -> None:
    """Half-width and peak from the ellipse fitted to nodal pressure, 25 points across the contact.

    0.5 %: the pad's finite depth shifts both by about (a / depth)^2 = 3e-4, the mesh by about 1e-3.
    """
    radius, wanted = 50.0, 0.1
    pad = cylinder(radius, ratio)
    plane = pad.young_modulus / (1 - ratio**2)
    load = math.pi * plane * wanted**2 / (4 * radius)
    exact = closed_forms.hertz(load, radius, pad.young_modulus, ratio)
    assert exact.half_width == pytest.approx(wanted, rel=1e-14)
    meshed = meshed_piece(pad, Sizes(contact=0.01, ridge=0.5, bulk=0.7, corner=0.05), whole=True)
    solution = level(meshed, 3, load * pad.length)
    fitted = closed_forms.fitted_line_contact(solution.x, solution.pressure)
    assert fitted.half_width == pytest.approx(exact.half_width, rel=5e-3)
    assert fitted.peak_pressure == pytest.approx(exact.peak_pressure, rel=5e-3)
    # and not from the fit: the outermost loaded point lies within one edge of the half-width
    assert np.abs(solution.x[solution.pressure > 0]).max() == pytest.approx(wanted, abs=0.01)


@pytest.mark.slow
def test_trailing_block_is_a_solve_per_unknown() -> None:
    pad = pad_of(yamada())
    materials = {"skin": (1.0, 0.499), "film": (3750.0, 0.35)}
    system = elements.assemble(elements.curved(triangles(pad, default_sizes(pad)), 2), 2, materials)
    free = np.concatenate([system.interior, system.contact])
    factor = splu(system.matrix[free][:, free].tocsc())
    sides = np.zeros((free.size, system.contact.size))
    sides[-system.contact.size :] = np.eye(system.contact.size)
    by_solves = factor.solve(sides)[-system.contact.size :]
    trailing = condense(system.matrix, system.interior, system.contact).flexibility
    # 1e-10: rounding at a condition of 1e8, the film being 3750 times stiffer
    assert np.abs(trailing - by_solves).max() <= 1e-10 * np.abs(by_solves).max()


def test_error_falls_with_the_order() -> None:
    """Rounded corners: each order divides the error of the all-touch force by 5 or more, against k = 4 on a
    finer mesh."""
    pad = pad_of(filleted().with_(**THREE))
    exact = level(plane_piece(pad, 2.0, whole=True), 4, 1.3).all_touch_force or 0.0
    meshed = plane_piece(pad, 0.5, whole=True)
    errors = [abs((level(meshed, k, 1.3).all_touch_force or 0.0) - exact) for k in (1, 2, 3)]
    assert errors[1] < errors[0] / 5
    assert errors[2] < errors[1] / 5


@pytest.mark.slow
def test_error_falls_with_the_mesh() -> None:
    """Sharp re-entrant corners leave less than the order's rate; halving still divides by at least 1.5."""
    pad = pad_of(sharp())
    exact = level(plane_piece(pad, 4.0), 3, 4.0).all_touch_force
    values = [level(plane_piece(pad, fineness), 2, 4.0).all_touch_force for fineness in (0.5, 1.0, 2.0)]
    errors = [abs((f or 0.0) - (exact or 0.0)) for f in values]
    assert errors[1] < errors[0] / 1.5
    assert errors[2] < errors[1] / 1.5


def test_lobatto_points_integrate_exactly() -> None:
    for order in range(1, 7):
        points, weights = elements.lobatto(order)
        for degree in range(2 * order):
            assert weights @ points**degree == pytest.approx(1 / (degree + 1), rel=1e-13)  # rounding


@pytest.mark.parametrize(("film", "longest"), [(0.028, 2 * 0.028), (0.005, 0.25 / 8)])
def test_a_strip_has_one_edge_at_its_ends_and_else_no_finer_ones_than_it_needs(
    film: float, longest: float
) -> None:
    """Twice its thickness, for it bends as a beam, and eight along it where it is thin. 7 %: netgen's own."""
    pad = pad_of(yamada().with_(ridge={"count": 1}, skin={"width": 3.0}, film={"thickness": film}))
    mesh = triangles(pad, Sizes(0.3, 0.5, 0.5, 0.05, grading=1.0))
    places = np.array([point.p for point in mesh.Points()])[:, :2] * unit_of(pad)
    strips = [edge for edge in mesh.Elements1D() if mesh.GetBCName(edge.index - 1) == "inside"]
    lengths = [math.dist(*places[[vertex.nr - 1 for vertex in edge.vertices]]) for edge in strips]
    assert np.isclose(lengths, film).sum() == 2 * len(pad.strips)
    assert max(lengths) == pytest.approx(longest, rel=0.07)
