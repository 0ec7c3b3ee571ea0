"""Friction on discs, against the plane's solver and point-by-point relaxation on the same compliance."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from skincad.base import Array
from skincad.mechanics import ContactError, press
from skincad.mechanics.contact import disc_friction, press_path
from skincad.mechanics.contact.disc_friction import DiscCompliance, DiscState, solve_discs, unloaded
from skincad.mechanics.contact.press_path import StickingPad, press_with_friction
from tests.mechanics.contact.test_press_path import first_of, meshed, springs

GAPS = (0.0, 0.3, 0.5)


def in_space(plane: StickingPad) -> StickingPad:
    """The same points, which nothing moves along y."""
    m = plane.ridges.gap.size
    compliance = np.zeros((3 * m, 3 * m))
    compliance[: 2 * m, : 2 * m] = plane.compliance
    return replace(plane, compliance=compliance, fine=np.hstack([plane.fine, 0 * plane.fine[:, :m]]))


def drawn(points: int, seed: int, *, floats: bool) -> DiscCompliance:
    """Points whose compliance is drawn: symmetric, positive definite, all directions coupled."""
    random = np.random.default_rng(seed)
    root = np.eye(3 * points) + 0.2 * random.uniform(-1.0, 1.0, (3 * points, 3 * points))
    root[:points, points : 2 * points] += 0.4 * np.eye(points)
    whole = root @ root.T
    x, z, y = np.arange(3 * points).reshape(3, -1)
    sideways = np.concatenate([x, y])
    return DiscCompliance(
        normal=whole[np.ix_(z, z)],
        tangential=whole[np.ix_(sideways, sideways)],
        cross=whole[np.ix_(z, sideways)],
        gap=random.uniform(0.0, 0.4, points),
        able=np.ones(2 * points, dtype=bool),
        floats=floats,
    )


def pressed(skin: DiscCompliance, mu: float, forces: Array) -> list[DiscState]:
    states = [unloaded(skin.gap.size)]
    for force in forces.tolist():
        states.append(solve_discs(skin, states[-1], force, mu))
    return states[1:]


@pytest.mark.parametrize("mu", [0.0, 0.1, 0.3, 1.0])
def test_points_that_y_does_not_move_are_the_planes(mu: float) -> None:
    """Another solver, by sets (frictional.py); forces are known to 1e-8, and the root of a force to 1e-6."""
    plane = springs(GAPS)
    first = first_of(plane)
    one, other = (press_with_friction(pad, mu, 2 * first, first, 7) for pad in (plane, in_space(plane)))
    assert other.all_touch_force == pytest.approx(one.all_touch_force, rel=1e-5)
    assert other.approach == pytest.approx(one.approach, rel=1e-7)
    np.testing.assert_allclose(other.ridge_force, one.ridge_force, atol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.2, 1.0])
def test_a_meshed_section_is_the_planes_too(mu: float) -> None:
    plane = meshed()
    first = first_of(plane)
    one, other = (press_with_friction(pad, mu, 2 * first, first, 8) for pad in (plane, in_space(plane)))
    assert other.all_touch_force == pytest.approx(one.all_touch_force, rel=1e-5)
    np.testing.assert_allclose(other.ridge_force, one.ridge_force, atol=1e-6 * first)


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


def test_without_friction_it_is_the_frictionless_press() -> None:
    skin = drawn(6, 7, floats=True)
    state = solve_discs(skin, unloaded(6), 1.5, 0.0)
    smooth = press(skin.normal, skin.gap, 1.5)
    np.testing.assert_allclose(state.normal, smooth.force, rtol=1e-12)
    assert not state.tangential.any()


def test_forces_that_do_not_settle_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(disc_friction, "ITERATIONS", 1)
    with pytest.raises(ContactError, match="do not settle in 1 sweeps"):
        solve_discs(drawn(5, 4, floats=False), unloaded(5), 1.0, 0.3)


def test_crests_that_are_level_take_no_more_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """All touch at a millionth of the force: up to it and from it on as many steps as of any pad."""
    level = in_space(springs((0.0, 1e-6, 2e-6)))
    first, forces = first_of(level), list[float]()
    step = press_path._SolidPoints.step

    def counted(points: Any, before: Any, start: float, end: float, *deeper: int) -> DiscState:
        if points.numbers.size == level.compliance.shape[0]:
            forces.append(end)
        return step(points, before, start, end, *deeper)

    monkeypatch.setattr(press_path._SolidPoints, "step", counted)
    assert first < 1e-2
    press_with_friction(level, 0.5, 1e3 * first, first, 6)
    assert len(forces) <= 12
