"""Plane elements against closed forms, the orders at which they get there, and hard meshes.

The solid's are in test_solid.py.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import ngsolve as ng
import numpy as np
import pytest
from scipy.sparse.linalg import splu

from skincad.inputs import Plate
from skincad.mechanics import (
    Pad,
    Sizes,
    coarse_sizes,
    default_sizes,
    meshed_piece,
    pad_of,
    press,
    triangles,
    unit_of,
)
from skincad.mechanics.bodies import elements, plane_body
from skincad.mechanics.models import linear
from skincad.shape import Loop, Point, Section, Segment
from tests.mechanics import closed_forms
from tests.mechanics.designs import reference, yamada


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
    solution = linear.level(meshed, 3, load * pad.length)
    fitted = closed_forms.fitted_line_contact(solution.x, solution.pressure)
    assert fitted.half_width == pytest.approx(exact.half_width, rel=5e-3)
    assert fitted.peak_pressure == pytest.approx(exact.peak_pressure, rel=5e-3)
    # and not from the fit: the outermost loaded point lies within one edge of the half-width
    assert np.abs(solution.x[solution.pressure > 0]).max() == pytest.approx(wanted, abs=0.01)


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


Array = np.ndarray
STRAIN = np.array([[0.3, 0.7], [0.7, -0.9]])


@pytest.fixture(scope="module", autouse=True)
def _same_triangles() -> None:
    """Meshes are refined in place here, so none is another test's."""


def everywhere(space: object, mesh: object) -> Array:
    """Which unknowns `(n,)` belong to the boundary."""
    marks = np.zeros(space.ndof, dtype=bool)
    marks[: space.components[0].ndof] = list(space.components[0].GetDofs(mesh.Boundaries(".*")))
    return marks


def uniform(ratio: float, gradient: Array) -> tuple[Array, Array]:
    """The neo-Hookean block of 1 by 2 units under a uniform displacement gradient `(2, 2)`.

    Nominal stress `(2,)` on its top, shear first; the largest force inside, and inside or on free sides.
    """
    pad = block(2.0, 4.0, ratio)
    mesh = elements.curved(triangles(pad, Sizes(0.9, 0.9, 0.9, 0.3)), 2)
    body = plane_body.body(mesh, 2, {"skin": (1.0, ratio)})
    state = ng.GridFunction(body.space)
    displacement, pressure = state.components
    displacement.Set(ng.CF(tuple(row[0] * ng.x + row[1] * ng.y for row in gradient.tolist())))
    bulk = 1 / (3 * (1 - 2 * ratio))
    pressure.Set(ng.CF(bulk * (np.linalg.det(np.eye(2) + gradient) - 1)))
    force = body.residual(np.array(state.vec.FV().NumPy()))
    vertical = body.rest.contact
    start = body.space.components[0].Range(1).start
    lift = body.rest.lift[vertical]
    top = np.array([lift @ force[vertical - start], lift @ force[vertical]])
    sides = body.free.copy()
    sides[vertical] = False
    inside = sides & ~everywhere(body.space, mesh)
    return top, np.array([np.abs(force[inside]).max(), np.abs(force[sides]).max()])


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.4999999])
@pytest.mark.parametrize("order", [2, 3])
def test_patch(ratio: float, order: int) -> None:
    """Energy of STRAIN in a block of area 1.5 on an irregular mesh, and no force inside: to rounding, at a
    condition of 1e7 for the largest nu."""
    mesh = elements.curved(triangles(block(2.0, 3.0, ratio), Sizes(0.9, 0.9, 0.9, 0.05)), order)
    body = plane_body.body(mesh, order, {"skin": (1.0, ratio)})
    system = elements.assemble(mesh, order, {"skin": (1.0, ratio)})
    vertical = np.flatnonzero(system.lift)
    moved = np.zeros(system.lift.size)
    places = np.array([v.point for v in mesh.vertices]) @ STRAIN
    moved[vertical - vertical[0]], moved[vertical] = places.T
    force = system.matrix @ moved
    energy = np.sum(closed_forms.uniform_stress(STRAIN, 1.0, ratio) * STRAIN) / 2 * 1.5
    assert moved @ force / 2 == pytest.approx(energy, rel=1e-9)
    assert np.abs(force[~everywhere(body.space, mesh)]).max() <= 1e-9 * energy


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.499, 0.4999999])
@pytest.mark.parametrize("stretch", [0.5, 0.9, 1.5])
def test_neo_hookean_compression(ratio: float, stretch: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """On top, and no force but on top and back: rounding, at nu 0.4999999 of pressures at a bulk modulus of
    2e6."""
    monkeypatch.setattr(plane_body, "CLAMPED_EDGE", -1.0)  # the small-strain law there is no part of it
    width, stress = closed_forms.neo_hookean_compression(stretch, *closed_forms.lame(1.0, ratio))
    top, (_, sides) = uniform(ratio, np.diag([width - 1, stretch - 1]))
    within = (1e-7 if ratio > 0.4999 else 1e-12) * abs(stress)
    assert top[1] == pytest.approx(stress, abs=within)
    assert sides <= within


@pytest.mark.parametrize("shift", [-0.8, 1e-3, 2.0])
def test_neo_hookean_shear(shift: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rounding, at a bulk modulus of 170."""
    monkeypatch.setattr(plane_body, "CLAMPED_EDGE", -1.0)
    stress = closed_forms.neo_hookean_shear(shift, closed_forms.lame(1.0, 0.499)[0])
    top, (inside, _) = uniform(0.499, np.array([[0.0, shift], [0.0, 0.0]]))
    assert top == pytest.approx([stress, 0.0], abs=1e-10 * abs(stress))
    assert inside <= 1e-10 * abs(stress)


INNER, OUTER = 1.0, 2.0


def circle(radius: float, kind: str, ridge: int | None = None) -> Loop:
    ends = [Point(radius, 0.0), Point(0.0, radius), Point(-radius, 0.0), Point(0.0, -radius)]
    quarter = math.tan(math.pi / 8)
    return tuple(
        Segment(a, b, quarter, kind, ridge, kind == "crown")
        for a, b in zip(ends, ends[1:] + ends[:1], strict=True)
    )


@cache
def ring_errors(ratio: float, order: int, refined: int) -> tuple[float, float]:
    """L2 errors of displacement and stress of a ring that spins on a rigid core, relative."""
    pad = Pad(Section(circle(OUTER, "crown", 1)), 1.0, 1.0, ratio, voids=(circle(INNER, "back"),))
    mesh = triangles(pad, Sizes(0.7, 0.7, 0.7, 0.7))
    for _ in range(refined):
        mesh.Refine()
    mesh, unit = elements.curved(mesh, order), unit_of(pad)
    body = plane_body.body(mesh, order, {"skin": (1.0, ratio)})
    load = ng.LinearForm(body.space)
    load += -ng.InnerProduct(body.space.TestFunction()[0], ng.CF((ng.x, ng.y))) * ng.dx
    at = body.linearised(np.zeros(body.free.size), np.array(load.Assemble().vec.FV().NumPy()))
    free = np.concatenate([body.rest.interior, body.rest.contact])
    step = np.zeros(body.free.size)
    step[free] = splu(at.matrix[free][:, free].tocsc()).solve(-at.residual[free])
    traction = ng.GridFunction(body.space)
    traction.vec.FV().NumPy()[:] = at.recover(step)
    u, q = traction.components
    shear, rest = closed_forms.lame(1.0, ratio)
    a, b, c = closed_forms.spinning_ring(INNER / unit, OUTER / unit, 1.0, shear, rest)
    square = ng.x**2 + ng.y**2
    swell = a + b / square - c * square
    turned = -2 * (b / square**2 + c)
    wanted = swell * ng.CF((ng.x, ng.y))
    cross = turned * ng.x * ng.y
    strain = ng.CF((swell + turned * ng.x**2, cross, cross, swell + turned * ng.y**2), dims=(2, 2))
    one = ng.Id(2)
    stress = 2 * shear * strain + rest * (2 * a - 4 * c * square) * one
    has = 2 * shear * (ng.Sym(ng.Grad(u)) - ng.div(u) / 3 * one) + q * one

    def norm(of: object) -> float:
        return math.sqrt(ng.Integrate(ng.InnerProduct(of, of) * ng.dx(bonus_intorder=6), mesh))

    return norm(u - wanted) / norm(wanted), norm(has - stress) / norm(stress)


# of all combinations most are evidence
FINER = pytest.mark.evidence(subject="finer meshes: orders")
RINGS = {(0.3, 3): [], (0.45, 4): [pytest.mark.slow]}


@pytest.mark.parametrize("of", [0, 1], ids=["displacement", "stress"])
@pytest.mark.parametrize(
    ("ratio", "order"),
    [pytest.param(nu, k, marks=RINGS.get((nu, k), [FINER])) for nu in (0.0, 0.3, 0.45) for k in (2, 3, 4)],
)
def test_order_where_all_is_smooth(ratio: float, order: int, of: int) -> None:
    """Over the last halving. Near nu = 1/2 the ring hardly moves, and errors still fall faster."""
    errors = [ring_errors(ratio, order, refined)[of] for refined in (2, 3)]
    assert closed_forms.observed_order([1.0, 0.5], errors) == pytest.approx(order + 1 - of, abs=0.2)


@FINER
@pytest.mark.parametrize("ratio", [0.3, 0.499, 0.4999999])
@pytest.mark.parametrize("order", [3, 4])
def test_order_at_clamped_corners(ratio: float, order: int) -> None:
    """Of a block's approach on uniform meshes, against order 6 on one graded into its corners; towards nu =
    1/2 the next exponents are near."""
    pad = block(2.0, 2.0, ratio)
    exact = linear.level(meshed_piece(pad, Sizes(0.1, 0.1, 0.1, 1e-5), whole=True), 6, 0.01)
    assert (exact.pressure > 0).all()  # all of the top touches, so that no edge of contact is in play
    errors = []
    for refined in (2, 3, 4):
        meshed = meshed_piece(pad, Sizes(0.5, 0.5, 0.5, 0.5), whole=True)
        for _ in range(refined):
            meshed.mesh.Refine()
        errors.append(abs(linear.level(meshed, order, 0.01).approach / exact.approach - 1))
    wanted = 2 * closed_forms.corner_exponent(ratio)
    assert closed_forms.observed_order([4.0, 2.0, 1.0], errors) == pytest.approx(wanted, abs=0.03)


@pytest.mark.parametrize(
    "order", [pytest.param(k, marks=pytest.mark.slow if k == 3 else FINER) for k in (2, 3, 4)]
)
def test_order_at_a_contacts_edge(order: int) -> None:
    """1, by the pressure's root there: L2 error of Hertz's, the mean over 16 half-widths from 0.08 to 0.12
    mm. The edge falls anywhere between the mesh's points; a single load would show that more than the order.
    """
    pad = cylinder(50.0, 0.3)
    errors = []
    for size in (0.04, 0.02, 0.01):
        meshed = meshed_piece(pad, Sizes(contact=size, ridge=0.3, bulk=0.7, corner=0.05), whole=True)
        traction = linear.level(meshed, order, 1e-3)
        curved = elements.curved(meshed.mesh, order)
        weight = elements.assemble(curved, order, {"skin": (1.0, 0.3)}).nodes.weight
        squares = []
        for half_width in np.linspace(0.08, 0.12, 16):
            load = math.pi * pad.young_modulus / (1 - 0.3**2) * half_width**2 / (4 * 50.0)
            exact = closed_forms.hertz(load, 50.0, pad.young_modulus, 0.3).elliptic(traction.x)
            ridges = traction.ridges
            state = press(ridges.flexibility, ridges.gap, load * pad.length / traction.scale)
            pressure = state.force / weight * pad.young_modulus
            squares.append(weight @ (pressure - exact) ** 2 / (weight @ exact**2))
        errors.append(math.sqrt(float(np.mean(squares))))
    assert closed_forms.observed_order([4.0, 2.0, 1.0], errors) == pytest.approx(1.0, abs=0.1)


def layer_errors(ratio: float) -> tuple[float, float, float]:
    """Peak pressure, approach and half-width of a cylinder on a bonded layer of thickness a / ratio."""
    thickness, radius, poisson = 1.0, 1e3 * ratio, 0.4999999
    shear = closed_forms.lame(0.7, poisson)[0]
    load = 2 * shear * ratio**5 / (15 * radius)
    exact = closed_forms.bonded_layer(load, radius, thickness, shear)
    assert exact.half_width == pytest.approx(ratio, rel=1e-12)  # rounding
    pad = block(2 * ratio + 12 * thickness, thickness, poisson)
    pad = replace(pad, plate=Plate(shape="cylinder", radius=radius))
    traction = linear.level(meshed_piece(pad, Sizes(0.25, 0.25, 0.25, 0.02)), 3, load * pad.length)
    half_width = float(np.abs(traction.x[traction.pressure > 0]).max())
    return (
        abs(float(traction.pressure.max()) / exact.peak_pressure - 1),
        abs(traction.approach / exact.approach - 1),
        abs(half_width / exact.half_width - 1),
    )


@pytest.mark.slow
def test_a_thin_layer_tends_to_its_limit() -> None:
    """Peak pressure and approach by the closed form's next terms, the half-width by the edge, a layer of
    width h. At a / h = 16 the first two differ by 1.4 % and 1.9 % as measured, 5 (h / a)^2."""
    errors = np.array([layer_errors(ratio) for ratio in (8.0, 16.0)])
    for of, theory, within in ((0, 2.0, 0.1), (1, 2.0, 0.25), (2, 1.0, 0.1)):
        order = closed_forms.observed_order([1 / 8, 1 / 16], errors[:, of])
        assert order == pytest.approx(theory, abs=within)
    assert max(errors[1, :2]) <= 5 / 16**2


def test_corner_exponents_of_the_literature() -> None:
    """Williams' figure and tables since: 1 at nu 0, 0.7112 at 0.3, 0.5946 at 1/2; digits as given."""
    exponents = [closed_forms.corner_exponent(ratio) for ratio in (0.0, 0.3, 0.5)]
    assert exponents == pytest.approx([1.0, 0.7112, 0.5946], abs=5e-5)


GAPS = [*((1e6, gap) for gap in (1e-2, 1e-4, 1e-5, 1e-6, 1e-7)), (120.0, 1e-3), (120.0, 3e-6)]
HARD = pytest.mark.evidence(subject="meshes of touching ridges")
FAST_GAPS = ((1e6, 1e-2), (1e6, 1e-7), (120.0, 3e-6))


@pytest.mark.parametrize(
    ("radius", "gap"), [case if case in FAST_GAPS else pytest.param(*case, marks=HARD) for case in GAPS]
)
def test_touching_ridges_are_meshed(radius: float, gap: float) -> None:
    """On all models' meshes; where triangles grow fast, netgen alone fails on gaps of 1e-3 mm and less."""
    pad = pad_of(reference().with_(skin={"curvature_radius": radius}, ridge={"root_width": 1.0 - gap}))
    for sizes in (default_sizes(pad, 0.5), *(coarse_sizes(pad, fineness) for fineness in (1.0, 1.5))):
        assert len(triangles(pad, sizes).Elements2D()) > 50


def one_ridge() -> Pad:
    return pad_of(reference().with_(ridge={"count": 1}, skin={"width": 3.0}))


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
            kind = ("crown", 1, True) if i == 1 else ("flank", None, False)
            outline.append(Segment(points[i], points[i + 1], bulge, *kind))
    return replace(pad, section=Section(tuple(outline)))


def hertz_of(pad: Pad, force: float) -> closed_forms.LineContact:
    radius = next(s.radius for s in pad.section.outline if s.kind == "crown")
    return closed_forms.hertz(force / pad.length, radius, pad.young_modulus, pad.poisson_ratio)


@cache
def light(force: float) -> linear.PlaneSolution:
    """A single ridge at order 3 with ten edges across half of its contact."""
    pad = one_ridge()
    half_width = hertz_of(pad, force).half_width
    pad = narrowed(pad, 3 * half_width)
    sizes = replace(default_sizes(pad), contact=half_width / 10, ridge=0.06, bulk=0.5, corner=0.002)
    return linear.level(meshed_piece(pad, sizes, whole=True), 3, force)


@pytest.mark.slow
def test_a_single_ridge_under_a_micronewton_is_hertzs() -> None:
    """Half-width 0.3 um on a ridge of 0.5 mm: 0.5 %, the mesh's, as above. Far from the contact only the
    force is felt, near it only the half-width, which goes as its root. So approach over force falls by
    ln(100) / (pi E' L) over two decades. 1 %: the meshes' difference."""
    pad, answer = one_ridge(), light(1e-6)
    fitted, exact = closed_forms.fitted_line_contact(answer.x, answer.pressure), hertz_of(pad, 1e-6)
    assert fitted.half_width == pytest.approx(exact.half_width, rel=5e-3)
    assert fitted.peak_pressure == pytest.approx(exact.peak_pressure, rel=5e-3)
    plane = pad.young_modulus / (1 - pad.poisson_ratio**2)
    fall = answer.approach / 1e-6 - light(1e-4).approach / 1e-4
    assert fall == pytest.approx(math.log(100) / (math.pi * plane * pad.length), rel=1e-2)
