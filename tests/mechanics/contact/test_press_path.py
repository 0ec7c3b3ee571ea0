"""A press with friction, in the plane and in space, against relaxation on the same compliance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy import sparse

from skincad import mechanics as mech
from skincad.base import Array
from skincad.mechanics.bodies import elements
from skincad.mechanics.contact import disc_friction, frictionless, press_path
from tests.mechanics.designs import SHORT, reference

GAPS = (0.0, 0.3, 0.5)
StickingPad, press_with_friction = press_path.StickingPad, press_path.press_with_friction
solve_discs, unloaded = disc_friction.solve_discs, disc_friction.unloaded


def springs(gaps: tuple[float, ...] = GAPS, seed: int = 3) -> StickingPad:
    """Ridges of two points each whose compliance is drawn: symmetric, positive definite, x and z coupled."""
    m = 2 * len(gaps)
    random = np.random.default_rng(seed)
    root = np.eye(2 * m) + 0.25 * random.uniform(-1.0, 1.0, (2 * m, 2 * m))
    root[:m, m:] += 0.3 * np.eye(m)  # what is pressed goes sideways, and would slide
    compliance = root @ root.T
    gap = np.repeat(gaps, 2) + np.tile([0.0, 0.02], len(gaps))
    ridge, rows = np.repeat(np.arange(len(gaps)) + 1, 2), sparse.identity(m, format="csr")
    lift = compliance[m:, m:]
    ridges = mech.Ridges(lift, gap, ridge, rows, rows, gap, np.arange(m), ridge)
    return StickingPad(ridges, compliance, compliance[m:])


@cache
def meshed() -> StickingPad:
    """Three ridges on a short pad, meshed as coarsely as can be."""
    pad = mech.pad_of(reference().with_(**SHORT))
    mesh = elements.curved(mech.triangles(pad, mech.default_sizes(pad, 0.25)), 2)
    return press_path.sticking_pad_of(pad, elements.assemble(mesh, 2, pad.materials), mech.unit_of(pad))


def first_of(pad: StickingPad) -> float:
    return frictionless.all_touch_force(pad.ridges, 1.0) or 0.0


def relaxed(pad: StickingPad, mu: float, path: list[mech.ContactState], sweeps: int) -> tuple[Array, Array]:
    """Forces `(m,)` across and along when the plate is led where it was: point after point is put right by
    itself, over and over (Gauss-Seidel), and no set is ever solved for.

    Jourdan, Alart and Jean, CMAME 155 (1998) 31. Where a point touched the plate is told from its movement.
    """
    c, gap, m = pad.compliance, pad.ridges.gap, pad.ridges.gap.size
    force, place, travel = np.zeros(2 * m), np.zeros(m), 0.0
    for plate in path:
        for _ in range(sweeps):
            for i in range(m):
                w = gap[i] - plate.approach - c[m + i] @ force
                force[m + i] = min(0.0, force[m + i] + w / c[m + i, m + i])
                slid = c[i] @ force - place[i] - (plate.travel - travel)
                most = -mu * force[m + i]
                force[i] = min(max(force[i] - slid / c[i, i], -most), most)
        place, travel = c[:m] @ force, plate.travel
    return -force[m:], force[:m]


def test_without_friction_it_is_the_frictionless_press() -> None:
    pad, force = springs(GAPS), 1.2
    first = first_of(pad)
    assert 0 < first < force
    result, all_touch = press_with_friction(pad, 0.0, force, first, 7)
    smooth = mech.press(pad.ridges.flexibility, pad.ridges.gap, force)
    assert all_touch == pytest.approx(first, rel=1e-8)
    assert result.approach == pytest.approx(smooth.approach, rel=1e-12)
    by_ridge = np.bincount(pad.ridges.of_point, smooth.force)[1:]
    np.testing.assert_allclose(pad.ridges.sums(result.normal), by_ridge, rtol=1e-10)
    skin = drawn(6, 7, floats=True)
    state = solve_discs(skin, unloaded(6), 1.5, 0.0)
    np.testing.assert_allclose(state.normal, mech.press(skin.normal, skin.gap, 1.5).force, rtol=1e-12)
    assert not state.tangential.any()


MESHED = pytest.mark.evidence(subject="friction by relaxation")


@pytest.mark.parametrize(
    ("pad", "mu"),
    [(springs, 0.1), (springs, 0.2), *(pytest.param(meshed, mu, marks=MESHED) for mu in (0.2, 1.0))],
)
def test_a_press_is_the_one_that_point_by_point_relaxation_finds(
    pad: Callable[[], StickingPad], mu: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The plate is led along the product's path: forces, and with them the force that was asked, are found
    again. Both are to rounding where the sweeps have settled."""
    what, path, step = pad(), list[mech.ContactState](), press_path.halved
    first = first_of(what)
    force, steps, sweeps = (1.2, 5, 200) if pad is springs else (1.3 * first, 8, 4000)

    def watched(*arguments: object) -> mech.ContactState:
        state = step(*arguments)  # type: ignore[arg-type]
        if state.normal.size == what.ridges.gap.size:  # not the search for a ridge that is out of contact
            path.append(state)
        return state

    monkeypatch.setattr(press_path, "halved", watched)
    result, _ = press_with_friction(what, mu, force, first, steps)
    assert any((state.status >= 2).any() for state in path)  # slips somewhere,
    assert any((state.status == 1).any() for state in path)  # and sticks
    normal, along = relaxed(what, mu, path, sweeps)
    np.testing.assert_allclose(normal, path[-1].normal, atol=1e-6 * force)
    np.testing.assert_allclose(along, path[-1].tangential, atol=1e-6 * force)
    assert normal.sum() == pytest.approx(force, rel=1e-6)
    assert along.sum() == pytest.approx(0.0, abs=1e-6 * force)
    np.testing.assert_allclose(what.ridges.sums(result.normal).sum(), force)


@pytest.mark.parametrize("force", [0.3, 3.0])
def test_the_last_ridge_begins_to_carry_where_all_touch(force: float) -> None:
    """Asked at a force before or after it, and pressed a little less or more than it."""
    pad, mu = springs(GAPS), 0.5
    first = first_of(pad)
    all_touch = press_with_friction(pad, mu, force, first, 40)[1] or 0.0
    assert all_touch != pytest.approx(first, rel=1e-3)
    less, more = (
        pad.ridges.sums(press_with_friction(pad, mu, share * all_touch, first, 40)[0].normal)
        for share in (0.999, 1.001)
    )
    assert (less > 0).sum() == 2
    assert (more > 0).sum() == 3


def test_steps_change_little_and_ever_less() -> None:
    """The error of a step is of first order: with four times the steps it is a quarter, or less."""
    pad = springs(GAPS)
    first = first_of(pad)
    few, some, many = (press_with_friction(pad, 0.5, 1.2, first, steps)[1] or 0.0 for steps in (5, 20, 160))
    assert abs(some - many) <= 0.3 * abs(few - many)
    assert abs(some - many) < 5e-3 * many


def test_where_all_touch_at_once_never_or_not_by_any_force(monkeypatch: pytest.MonkeyPatch) -> None:
    """Looked for up to a multiple of the force without friction, and no further."""
    assert press_with_friction(springs((0.0,)), 0.5, 1.0, 0.0, 5)[1] == 0.0
    assert press_with_friction(springs((0.0, 0.3)), 0.5, 1.0, None, 5)[1] is None
    with pytest.raises(mech.ContactError, match="not all ridges touch at up to 3 times"):
        press_with_friction(springs(GAPS), 0.5, 0.01, 0.01, 5)
    monkeypatch.setattr(disc_friction, "ITERATIONS", 1)
    with pytest.raises(mech.ContactError, match="do not settle in 1 sweeps"):
        solve_discs(drawn(5, 4, floats=False), unloaded(5), 1.0, 0.3)


def in_space(plane: StickingPad) -> StickingPad:
    """The same points, which nothing moves along y."""
    m = plane.ridges.gap.size
    compliance = np.zeros((3 * m, 3 * m))
    compliance[: 2 * m, : 2 * m] = plane.compliance
    return replace(plane, compliance=compliance, fine=np.hstack([plane.fine, 0 * plane.fine[:, :m]]))


def drawn(points: int, seed: int, *, floats: bool) -> disc_friction.DiscCompliance:
    """Points whose compliance is drawn: symmetric, positive definite, all directions coupled."""
    random = np.random.default_rng(seed)
    root = np.eye(3 * points) + 0.2 * random.uniform(-1.0, 1.0, (3 * points, 3 * points))
    root[:points, points : 2 * points] += 0.4 * np.eye(points)
    whole = root @ root.T
    x, z, y = np.arange(3 * points).reshape(3, -1)
    sideways = np.concatenate([x, y])
    return disc_friction.DiscCompliance(
        normal=whole[np.ix_(z, z)],
        tangential=whole[np.ix_(sideways, sideways)],
        cross=whole[np.ix_(z, sideways)],
        gap=random.uniform(0.0, 0.4, points),
        able=np.ones(2 * points, dtype=bool),
        floats=floats,
    )


def pressed(skin: disc_friction.DiscCompliance, mu: float, forces: Array) -> list[mech.ContactState]:
    states = [unloaded(skin.gap.size)]
    for force in forces.tolist():
        states.append(solve_discs(skin, states[-1], force, mu))
    return states[1:]


@pytest.mark.parametrize(
    ("pad", "mu", "steps"),
    [
        *((springs, mu, 7) for mu in (0.0, 0.1, 0.3, 1.0)),
        *(pytest.param(meshed, mu, 8, marks=MESHED) for mu in (0.2, 1.0)),
    ],
)
def test_points_that_y_does_not_move_are_the_planes(
    pad: Callable[[], StickingPad], mu: float, steps: int
) -> None:
    """Another solver, by sets (frictional.py); forces are known to 1e-8, and the root of a force to 1e-6."""
    plane = pad()
    first = first_of(plane)
    (one, one_touch), (other, other_touch) = (
        press_with_friction(p, mu, 2 * first, first, steps) for p in (plane, in_space(plane))
    )
    assert other_touch == pytest.approx(one_touch, rel=1e-5)
    shares = (plane.ridges.sums(state.normal) for state in (other, one))
    np.testing.assert_allclose(*shares, atol=(1e-7 if pad is springs else 1e-6 * first))
    assert pad is meshed or other.approach == pytest.approx(one.approach, rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("floats", [False, True])
@pytest.mark.parametrize("mu", [0.1, 0.4])
def test_point_by_point_relaxation_finds_the_same(mu: float, floats: bool) -> None:
    """Jourdan, Alart and Jean, CMAME 155 (1998) 31: each point is put right by itself, over and over, the
    plate led where it was. Neither a set nor a direction is solved for."""
    skin, m = drawn(5, 4, floats=floats), 5
    states = pressed(skin, mu, np.linspace(0.2, 2.0, 6))
    pulled = [np.hypot(*s.tangential.reshape(2, -1)) / np.maximum(s.normal, 1e-300) for s in states]
    assert any((pull[s.touches] > 0.999 * mu).any() for pull, s in zip(pulled, states, strict=True))
    sticks = any((pull[s.touches] < 0.999 * mu).any() for pull, s in zip(pulled, states, strict=True))
    assert sticks or mu < 0.2
    force, anchor = np.zeros(3 * m), np.zeros(2 * m)
    travels = np.array([s.travel for s in states])
    for state, travel in zip(states, travels, strict=True):
        t, p = force[: 2 * m], force[2 * m :]
        for _ in range(400):
            for i in range(m):
                gap = skin.gap[i] - state.approach - skin.cross[i] @ t + skin.normal[i] @ p
                p[i] = max(0.0, p[i] - gap / skin.normal[i, i])
                pair = [i, i + m]
                block = skin.tangential[np.ix_(pair, pair)]
                off = skin.tangential[pair] @ t - skin.cross[:, pair].T @ p - anchor[pair]
                off[0] -= travel
                pull = t[pair] - off / np.linalg.eigvalsh(block)[-1]
                size = float(np.hypot(*pull))
                t[pair] = pull * min(1.0, mu * p[i] / size) if size else 0.0
        place = skin.tangential @ t - skin.cross.T @ p
        place[:m] -= travel
        held = np.tile(np.hypot(*t.reshape(2, -1)) < mu * p * (1 - 1e-9), 2) & np.tile(p > 0, 2)
        anchor = np.where(held, anchor, place)
        np.testing.assert_allclose(p, state.normal, atol=1e-6)  # of up to 2 N
        np.testing.assert_allclose(t, state.tangential, atol=1e-6)
    if floats:
        assert states[-1].tangential[:m].sum() == pytest.approx(0.0, abs=1e-7)
        assert np.abs(travels).max() > 1e-3


def test_x_and_y_are_alike() -> None:
    skin, m = drawn(6, 7, floats=False), 6
    turned = np.concatenate([np.arange(m) + m, np.arange(m)])
    swapped = replace(skin, tangential=skin.tangential[np.ix_(turned, turned)], cross=skin.cross[:, turned])
    forces = np.linspace(0.3, 2.0, 4)
    one, other = pressed(skin, 0.3, forces)[-1], pressed(swapped, 0.3, forces)[-1]
    np.testing.assert_allclose(other.tangential[turned], one.tangential, atol=1e-7)
    assert other.approach == pytest.approx(one.approach, rel=1e-7)


def test_crests_that_are_level_take_no_more_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """All touch at a millionth of the force: up to it and from it on as many steps as of any pad."""
    level = in_space(springs((0.0, 1e-6, 2e-6)))
    first, forces = first_of(level), list[float]()

    def counted(skin: Any, before: Any, force: float, mu: float) -> mech.ContactState:
        if skin.gap.size == level.ridges.gap.size:
            forces.append(force)
        return solve_discs(skin, before, force, mu)

    monkeypatch.setattr(press_path, "solve_discs", counted)
    assert first < 1e-2
    press_with_friction(level, 0.5, 1e3 * first, first, 6)
    assert len(forces) <= 12
