"""Condensing: one factorisation, and a pad condensed slab by slab against the same at once."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from netgen.geom2d import SplineGeometry
from netgen.meshing import NgException
from ngsolve import Mesh
from scipy import sparse

from skincad import load
from skincad.base import Array, Index
from skincad.mechanics import (
    ContactError,
    default_sizes,
    pad_of,
    plane_piece,
    ridge_model,
    triangles,
    unit_of,
)
from skincad.mechanics.bodies import chain, condense, elements, mesh, plane_body
from skincad.mechanics.models import linear
from tests.designs import template
from tests.mechanics.designs import filleted, wide


def test_only_a_singular_matrix_is_called_singular(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ContactError, match="singular"):
        condense.factors(sparse.csc_matrix(np.zeros((3, 3))))

    def splu(*_: object, **__: object) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(condense, "splu", splu)
    with pytest.raises(RuntimeError, match="thread"):
        condense.factors(sparse.identity(3, format="csc"))


def indefinite(seed: int) -> np.ndarray:
    """Of 12 unknowns, positive definite while the last 4 are held, and with 2 negative eigenvalues."""
    random = np.random.default_rng(seed)
    inner, side = random.standard_normal((8, 8)), random.standard_normal((4, 8))
    inner = inner @ inner.T + 8 * np.eye(8)
    turned = np.linalg.qr(random.standard_normal((4, 4)))[0]
    last = turned @ np.diag([-2.0, -1.0, 1.0, 3.0]) @ turned.T + side @ np.linalg.solve(inner, side.T)
    return np.block([[inner, side.T], [side, last]])


@pytest.mark.parametrize("seed", range(4))
def test_an_indefinite_matrix_is_condensed_and_its_signs_counted(seed: int) -> None:
    whole = indefinite(seed)
    condensed = condense.factorise(sparse.csr_matrix(whole), np.arange(12), 4)
    assert condensed.flexibility == pytest.approx(np.linalg.inv(whole)[-4:, -4:], rel=1e-9)
    assert (int((condensed.pivots[:-4] < 0).sum()), int((condensed.pivots < 0).sum())) == (0, 2)
    loads = np.arange(24.0).reshape(12, 2)
    assert condensed.at_contact(loads) == pytest.approx(np.linalg.solve(whole, loads)[-4:], rel=1e-9)
    with pytest.raises(ContactError, match="not positive definite"):
        condense.condense(sparse.csr_matrix(whole), np.arange(8), np.arange(8, 12))
    one = condense.Front(np.arange(8), np.arange(8, 12), (), np.arange(1))
    factors = condense.factored(lambda _: [(np.arange(12), whole)], [one], lambda functions: functions, 12)
    assert factors.flexibility == pytest.approx(condensed.flexibility, rel=1e-9)
    assert factors.solve(loads[:, 0]) == pytest.approx(np.linalg.solve(whole, loads[:, 0]), rel=1e-9)
    assert factors.negative_eigenvalues == 2


def test_a_tangent_is_singular_only_where_its_library_says_so() -> None:
    """Of a state that is no state NGSolve finds an element's block singular; memory is another matter."""
    square = SplineGeometry()
    square.AddRectangle((0, 0), (1, 1), bcs=("back", "free", "contact1", "free"))
    square.SetMaterial(1, "skin")
    body = plane_body.body(Mesh(square.GenerateMesh(maxh=0.5)), 2, {"skin": (1.0, 0.49)})
    nowhere = np.full(body.free.size, np.nan)
    with pytest.raises(ContactError, match="the tangent stiffness of an element is singular"):
        plane_body.tangent(body, nowhere, nowhere)


@pytest.mark.parametrize("failure", [NgException("Could not allocate localheap"), MemoryError()])
def test_memory_that_ran_out_is_no_singular_tangent(
    failure: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Form:
        def AssembleLinearization(self, _: object) -> None:  # noqa: N802
            raise failure

    class Body:
        form = Form()

    monkeypatch.setattr(plane_body, "_vector", lambda *_: None)
    with pytest.raises(type(failure)):
        plane_body.tangent(Body(), np.zeros(1), np.zeros(1))  # type: ignore[arg-type]


def test_netgen_without_memory_is_no_bad_section(monkeypatch: pytest.MonkeyPatch) -> None:
    def without(*_: object) -> object:
        raise NgException("std::bad_alloc")

    monkeypatch.setattr(mesh, "_geometry", without)
    pad = pad_of(filleted())
    with pytest.raises(NgException):
        mesh.triangles(pad, mesh.default_sizes(pad, 1.0))


@pytest.mark.parametrize(
    ("springs", "negative_eigenvalues"),
    [([2, 0.5, 3], (0, 0)), ([2, -0.5, 3], (1, 1)), ([2, 0.5, -3], (0, 1))],
)
def test_negative_stiffnesses_are_counted_inside_and_in_all(
    springs: list[float], negative_eigenvalues: tuple[int, int]
) -> None:
    """Of three springs the last is the contact's."""
    small = condense.factorise(sparse.csr_matrix(np.diag(springs)), np.arange(3), 1)
    linear_state = plane_body.PlaneLinearised(None, None, small, small.flexibility)  # type: ignore[arg-type]
    assert linear_state.negative_eigenvalues == negative_eigenvalues


# Chain and dense differ by rounding alone: they eliminate the same matrix in another order. Its condition
# (Poisson's ratio near 0.5, corners graded to 1/2000 of the height) leaves 2e-13 to 3e-12 of the largest
ROUNDING = 1e-10


@cache
def system_of(name: str, order: int = 2, ridges: int = 0) -> elements.ContactStiffness:
    pad = pad_of(wide(ridges) if ridges else load(name))
    mesh = elements.curved(triangles(pad, default_sizes(pad, 0.5)), order)
    return elements.assemble(mesh, order, pad.materials)


def at_once(system: elements.ContactStiffness) -> condense.Condensation:
    return condense.condense(system.matrix, system.interior, system.contact)


@cache
def nine_at_once(name: str) -> condense.Condensation:
    return at_once(system_of(name))


def assert_close(values: Array, exact: Array, most: float) -> None:
    """No number further off than `most`; pytest.approx takes a Python step for each of a million."""
    np.testing.assert_allclose(values, exact, rtol=0, atol=most, equal_nan=False)


@pytest.fixture(params=[1, 2, 5, 9])
def of_ridges(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    """Slabs of about so many ridges: nine, five or four, two and one for nine ridges."""
    monkeypatch.setattr(chain, "RIDGES", request.param)
    return int(request.param)


@pytest.mark.parametrize("name", ["plain-ridges", template("yamada-2002", tier="slow")])
def test_a_chain_is_the_flexibility_condensed_at_once(name: str, of_ridges: int) -> None:
    system, random = system_of(name), np.random.default_rng(3)
    small, whole = chain.condense_by_slabs(system), nine_at_once(name)
    assert len(small.flexibility.slabs) == round(9 / of_ridges)
    rows = system.nodes.rows
    seen, points = small.flexibility.seen(rows), np.asarray(rows @ whole.flexibility @ rows.T)
    close = ROUNDING * np.abs(points).max()
    assert_close(seen @ np.eye(len(points)), points, close)
    force = random.uniform(size=len(points)) / len(points)
    assert_close(seen @ force, points @ force, close)
    for ridge in (1, 4, 9):
        some = np.ix_(*2 * [np.flatnonzero(system.nodes.ridge == ridge)])
        assert_close(seen[some], points[some], close)
    push = np.zeros_like(system.lift)
    push[system.contact] = random.normal(size=system.contact.size)
    moved = whole.solve(push)
    assert_close(small.solve(push), moved, ROUNDING * np.abs(moved).max())


def test_what_points_carry_moves_them_so_and_is_found_anew_for_other_points(of_ridges: int) -> None:
    system, random = system_of("plain-ridges"), np.random.default_rng(4)
    flexibility, whole = chain.condense_by_slabs(system).flexibility, nine_at_once("plain-ridges").flexibility
    few = system.contact.size // 20  # some slabs hold none of them
    for inside in (
        np.arange(few),
        np.flatnonzero(random.random(flexibility.size) < 0.5),
        np.arange(flexibility.size),
    ):
        sides = random.normal(size=(inside.size, 2))
        forces, exact = (
            flexibility.carried(inside, sides),
            np.linalg.solve(whole[np.ix_(inside, inside)], sides),
        )
        # the forces of a random movement are large, and so is the condition of what they come from
        assert_close(forces, exact, 1e-8 * np.abs(exact).max())
        assert_close(whole[np.ix_(inside, inside)] @ forces, sides, 1e-9)


def test_a_chain_gives_no_block_across_slabs() -> None:
    flexibility = chain.condense_by_slabs(system_of("plain-ridges")).flexibility
    first, last = flexibility.slabs[0].points[:2], flexibility.slabs[-1].points[:2]
    for where in (np.ix_(np.append(first, last), np.append(first, last)), np.ix_(first, last)):
        with pytest.raises(IndexError, match="one slab"):
            flexibility[where]


def stored(small: chain.ChainFactors) -> int:
    """Numbers that a chain keeps."""
    slabs = sum(s.flexibility.size + s.follow.size + s.stiffness.size for s in small.flexibility.slabs)
    joints = sum(s.root.size + s.side.size for s in small.flexibility.free.steps)
    return int(slabs + joints + sum(lower.nnz for lower in small.lowers))


@pytest.mark.evidence(subject="condensing: growth")
def test_what_a_chain_stores_grows_with_the_ridges() -> None:
    """Between 6, 12 and 24 ridges as much is added for each: the ends cancel, netgen's scatter remains."""
    few, some, many = (stored(chain.condense_by_slabs(system_of("", 2, ridges))) for ridges in (6, 12, 24))
    assert (many - some) / 12 == pytest.approx((some - few) / 6, rel=0.1)


@pytest.mark.evidence(subject="condensing: growth")
def test_three_times_the_ridges_do_not_take_twice_the_solves(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a pad curved so that its outer ridges touch last, as with nine: 31 solves of contact for either,
    most of them in the search for the force at which the last one touches."""
    solves: list[int] = []
    carried = chain.SlabChain.carried

    def counted(slabs: chain.SlabChain, inside: Index, sides: Array) -> Array:
        solves.append(inside.size)
        return carried(slabs, inside, sides)

    monkeypatch.setattr(chain.SlabChain, "carried", counted)
    counts = []
    for ridges in (9, 27):
        design = wide(ridges).with_(skin={"curvature_radius": 60.0 * (ridges / 9) ** 2})
        pad = pad_of(design)
        solution = linear.level(plane_piece(pad, 0.5, whole=True), 2, design.contact.force)
        assert solution.all_touch_force
        counts.append(len(solves))
        solves.clear()
    assert 0 < counts[1] < 2 * counts[0]


def test_cuts_are_left_out_where_triangles_reach_too_far(monkeypatch: pytest.MonkeyPatch) -> None:
    """Triangles as large as some ridges: slabs of one ridge would share unknowns three by three."""
    monkeypatch.setattr(chain, "RIDGES", 1)
    pad = pad_of(wide(9))
    sizes = default_sizes(pad, 0.5)
    coarse = replace(sizes, bulk=20 * sizes.bulk, ridge=20 * sizes.ridge, grading=0.9)
    system = elements.assemble(elements.curved(triangles(pad, coarse), 1), 1, pad.materials)
    parts = chain.cut(system)
    assert 1 < len(parts.contact) < 9
    together = np.concatenate([*parts.interior, *parts.contact, *parts.joints])
    assert np.array_equal(np.sort(together), np.union1d(system.interior, system.contact))
    exact = at_once(system).flexibility
    flexibility = chain.condense_by_slabs(system).flexibility @ np.eye(len(exact))
    assert_close(flexibility, exact, ROUNDING * np.abs(exact).max())


@pytest.mark.parametrize("part", ["interior", "contact", "joint"])
def test_a_stiffness_that_is_not_definite_is_refused(part: str) -> None:
    """A joint's unknown may fall with the slabs on both its sides, each held where the other begins."""
    system = system_of("plain-ridges")
    less = np.zeros(system.lift.size)
    if part == "joint":
        joint = chain.cut(system).joints[0]
        less[joint] = 0.4 * system.matrix.diagonal()[joint]
    else:
        less[getattr(system, part)[::7]] = 1e3
    bad = replace(system, matrix=sparse.csr_matrix(system.matrix - sparse.diags(less)))
    with pytest.raises(ContactError, match="not positive definite"):
        chain.condense_by_slabs(bad)


@pytest.mark.parametrize(
    "name",
    [template(n, tier="slow") for n in ("plain-ridges", "fingertip-soft", "yamada-2002", "milled-pad")],
)
def test_the_verdict_and_the_ridge_model_are_those_of_the_pad_condensed_at_once(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    design = load(name)
    pad, force = pad_of(design), design.contact.force
    meshed = plane_piece(pad, 0.5, whole=True)
    one = linear.level(meshed, 2, force)
    monkeypatch.setattr(linear, "condense_by_slabs", at_once)
    other = linear.level(meshed, 2, force)
    close: dict[str, Any] = {"rel": 1e-9}  # rounding, times the condition of the contact problem
    assert one.all_touch_force == pytest.approx(other.all_touch_force, **close)
    assert one.approach == pytest.approx(other.approach, **close)
    assert one.ridge_force == pytest.approx(other.ridge_force, rel=0, abs=1e-9 * force)
    assert_close(one.pressure, other.pressure, 1e-8 * other.pressure.max())
    assert (one.touching, one.unknowns, one.fault) == (other.touching, other.unknowns, other.fault)
    by_chain, dense = (ridge_model(level.ridges, force, unit_of(pad), level.scale) for level in (one, other))
    for of in ("coupling", "indentation"):
        assert_close(getattr(by_chain, of), getattr(dense, of), 1e-9 * np.abs(getattr(dense, of)).max())
