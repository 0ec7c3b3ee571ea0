"""A pad condensed slab by slab, against the same pad condensed at once."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy import sparse

from skincad import load
from skincad.base import Array, Index
from skincad.mechanics import (
    ContactError,
    Pad,
    condense,
    default_sizes,
    pad_of,
    plane_piece,
    ridge_model,
    triangles,
    unit_of,
)
from skincad.mechanics.bodies import chain, elements
from skincad.mechanics.bodies.chain import ChainFactors, SlabChain, condense_by_slabs
from skincad.mechanics.bodies.condense import Condensation
from skincad.mechanics.bodies.elements import ContactStiffness
from skincad.mechanics.models import linear
from tests.mechanics.designs import wide

# Chain and dense differ by rounding alone: they eliminate the same matrix in another order. Its condition
# (Poisson's ratio near 0.5, corners graded to 1/2000 of the height) leaves 2e-13 to 3e-12 of the largest
ROUNDING = 1e-10
LARGE = ("yamada-2002", "milled-pad")


@cache
def system_of(name: str, order: int = 2, ridges: int = 0) -> ContactStiffness:
    pad = pad_of(wide(ridges) if ridges else load(name))
    mesh = elements.curved(triangles(pad, default_sizes(pad, 0.5)), order)
    return elements.assemble(mesh, order, pad.materials)


def at_once(system: ContactStiffness) -> Condensation:
    return condense(system.matrix, system.interior, system.contact)


@cache
def nine_at_once(name: str) -> Condensation:
    return at_once(system_of(name))


def assert_close(values: Array, exact: Array, most: float) -> None:
    """No number further off than `most`; pytest.approx takes a Python step for each of a million."""
    np.testing.assert_allclose(values, exact, rtol=0, atol=most, equal_nan=False)


@pytest.fixture(params=[1, 2, 5, 9])
def of_ridges(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    """Slabs of about so many ridges: nine, five or four, two and one for nine ridges."""
    monkeypatch.setattr(chain, "RIDGES", request.param)
    return int(request.param)


@pytest.mark.parametrize("name", ["plain-ridges", "yamada-2002"])
def test_a_chain_is_the_flexibility_condensed_at_once(name: str, of_ridges: int) -> None:
    system, random = system_of(name), np.random.default_rng(3)
    small, whole = condense_by_slabs(system), nine_at_once(name)
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
    chain, whole = condense_by_slabs(system).flexibility, nine_at_once("plain-ridges").flexibility
    few = system.contact.size // 20  # some slabs hold none of them
    for inside in (np.arange(few), np.flatnonzero(random.random(chain.size) < 0.5), np.arange(chain.size)):
        sides = random.normal(size=(inside.size, 2))
        forces, exact = chain.carried(inside, sides), np.linalg.solve(whole[np.ix_(inside, inside)], sides)
        # the forces of a random movement are large, and so is the condition of what they come from
        assert_close(forces, exact, 1e-8 * np.abs(exact).max())
        assert_close(whole[np.ix_(inside, inside)] @ forces, sides, 1e-9)


def test_a_chain_gives_no_block_across_slabs() -> None:
    chain = condense_by_slabs(system_of("plain-ridges")).flexibility
    first, last = chain.slabs[0].points[:2], chain.slabs[-1].points[:2]
    for where in (np.ix_(np.append(first, last), np.append(first, last)), np.ix_(first, last)):
        with pytest.raises(IndexError, match="one slab"):
            chain[where]


def stored(small: ChainFactors) -> int:
    """Numbers that a chain keeps."""
    slabs = sum(s.flexibility.size + s.follow.size + s.stiffness.size for s in small.flexibility.slabs)
    joints = sum(s.root.size + s.side.size for s in small.flexibility.free.steps)
    return int(slabs + joints + sum(lower.nnz for lower in small.lowers))


@pytest.mark.slow
def test_what_a_chain_stores_grows_with_the_ridges() -> None:
    """Between 6, 12 and 24 ridges as much is added for each: the ends cancel, netgen's scatter remains."""
    few, some, many = (stored(condense_by_slabs(system_of("", 2, ridges))) for ridges in (6, 12, 24))
    assert (many - some) / 12 == pytest.approx((some - few) / 6, rel=0.1)


@pytest.mark.slow
def test_three_times_the_ridges_do_not_take_twice_the_solves(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a pad curved so that its outer ridges touch last, as with nine: 31 solves of contact for either,
    most of them in the search for the force at which the last one touches."""
    solves: list[int] = []
    carried = SlabChain.carried

    def counted(chain: SlabChain, inside: Index, sides: Array) -> Array:
        solves.append(inside.size)
        return carried(chain, inside, sides)

    monkeypatch.setattr(SlabChain, "carried", counted)
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
    flexibility = condense_by_slabs(system).flexibility @ np.eye(len(exact))
    assert_close(flexibility, exact, ROUNDING * np.abs(exact).max())


@pytest.mark.parametrize("part", ["interior", "contact"])
def test_a_stiffness_that_is_not_definite_is_refused(part: str) -> None:
    system = system_of("plain-ridges")
    less = np.zeros(system.lift.size)
    less[getattr(system, part)[::7]] = -1e3
    bad = replace(system, matrix=sparse.csr_matrix(system.matrix + sparse.diags(less)))
    with pytest.raises(ContactError, match="not positive definite"):
        condense_by_slabs(bad)


def test_one_that_is_definite_slab_by_slab_alone_is_refused() -> None:
    """A joint's own unknown may fall with the slabs on its both sides, each held where the other begins."""
    system = system_of("plain-ridges")
    joint = chain.cut(system).joints[0]
    less = np.zeros(system.lift.size)
    less[joint] = 0.4
    scaled = sparse.diags(less) @ sparse.diags(system.matrix.diagonal())
    bad = replace(system, matrix=sparse.csr_matrix(system.matrix - scaled))
    with pytest.raises(ContactError, match="not positive definite"):
        condense_by_slabs(bad)


def both(pad: Pad, force: float, monkeypatch: pytest.MonkeyPatch) -> list[linear.PlaneSolution]:
    """A level's answers by the chain and by the pad condensed at once."""
    meshed = plane_piece(pad, 0.5, whole=True)
    one = linear.level(meshed, 2, force)
    monkeypatch.setattr(linear, "condense_by_slabs", at_once)
    return [one, linear.level(meshed, 2, force)]


@pytest.mark.parametrize(
    "name", ["plain-ridges", "fingertip-soft", *(pytest.param(n, marks=pytest.mark.slow) for n in LARGE)]
)
def test_the_verdict_and_the_ridge_model_are_those_of_the_pad_condensed_at_once(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    design = load(name)
    pad = pad_of(design)
    one, other = both(pad, design.contact.force, monkeypatch)
    close: dict[str, Any] = {"rel": 1e-9}  # rounding, times the condition of the contact problem
    assert one.all_touch_force == pytest.approx(other.all_touch_force, **close)
    assert one.approach == pytest.approx(other.approach, **close)
    assert one.ridge_force == pytest.approx(other.ridge_force, rel=0, abs=1e-9 * design.contact.force)
    assert_close(one.pressure, other.pressure, 1e-8 * other.pressure.max())
    assert (one.touching, one.unknowns, one.fault) == (other.touching, other.unknowns, other.fault)
    models = [
        ridge_model(level.ridges, design.contact.force, unit_of(pad), level.scale) for level in (one, other)
    ]
    for by_chain, dense in (
        (models[0].coupling, models[1].coupling),
        (models[0].indentation, models[1].indentation),
    ):
        assert by_chain == pytest.approx(dense, rel=0, abs=1e-9 * np.abs(dense).max())


def test_inner_ridges_of_a_long_flat_pad_carry_the_same() -> None:
    """Far from the ends every ridge sees the same neighbours, if the skin is compressible: a rubber between
    plate and back has nowhere to go but to the ends. What the mesh breaks of it is its own error, and no
    joint between slabs is to be seen."""
    design = wide(31).with_(skin={"curvature_radius": 1e8}, material={"poisson_ratio": 0.3})
    pad = pad_of(design)
    solution = linear.level(plane_piece(pad, 0.5, whole=True), 2, design.contact.force)
    assert len(solution.ridges.flexibility.slabs) == 6  # type: ignore[union-attr]
    assert solution.ridge_force.sum() == pytest.approx(design.contact.force, rel=1e-12)
    inner = solution.ridge_force[12:-12]
    assert inner == pytest.approx(np.full(inner.size, inner.mean()), rel=5e-3)
    assert solution.ridge_force == pytest.approx(
        solution.ridge_force[::-1], rel=2e-2
    )  # the mesh is not mirrored
