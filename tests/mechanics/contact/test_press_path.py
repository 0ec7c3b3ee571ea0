"""A press with friction, against another method on the same compliance."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy import sparse

from skincad.base import Array
from skincad.mechanics import (
    ContactError,
    ContactState,
    Ridges,
    default_sizes,
    pad_of,
    press,
    triangles,
    unit_of,
)
from skincad.mechanics.bodies import elements
from skincad.mechanics.contact import press_path
from skincad.mechanics.contact.frictionless import all_touch_force
from skincad.mechanics.contact.press_path import StickingPad, press_with_friction, sticking_pad_of
from tests.mechanics.designs import SHORT, reference


def springs(gaps: tuple[float, ...], seed: int = 3) -> StickingPad:
    """Ridges of two points each whose compliance is drawn: symmetric, positive definite, x and z coupled."""
    m = 2 * len(gaps)
    random = np.random.default_rng(seed)
    root = np.eye(2 * m) + 0.25 * random.uniform(-1.0, 1.0, (2 * m, 2 * m))
    root[:m, m:] += 0.3 * np.eye(m)  # what is pressed goes sideways, and would slide
    compliance = root @ root.T
    gap = np.repeat(gaps, 2) + np.tile([0.0, 0.02], len(gaps))
    ridge, rows = np.repeat(np.arange(len(gaps)) + 1, 2), sparse.identity(m, format="csr")
    lift = compliance[m:, m:]
    ridges = Ridges(lift, gap, ridge, rows, rows, gap, np.arange(m), ridge)
    return StickingPad(ridges, compliance, compliance[m:])


@cache
def meshed() -> StickingPad:
    """Three ridges on a short pad, meshed as coarsely as can be."""
    pad = pad_of(reference().with_(**SHORT))
    mesh = elements.curved(triangles(pad, default_sizes(pad, 0.25)), 2)
    return sticking_pad_of(pad, elements.assemble(mesh, 2, pad.materials), unit_of(pad))


def first_of(pad: StickingPad) -> float:
    return all_touch_force(pad.ridges, 1.0) or 0.0


def relaxed(pad: StickingPad, mu: float, path: list[ContactState], sweeps: int) -> tuple[Array, Array]:
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
    pad = springs((0.0, 0.3, 0.5))
    force, first = 1.2, first_of(pad)
    assert 0 < first < force
    result, smooth = (
        press_with_friction(pad, 0.0, force, first, 7),
        press(pad.ridges.flexibility, pad.ridges.gap, force),
    )
    assert result.all_touch_force == pytest.approx(first, rel=1e-8)
    assert result.approach == pytest.approx(smooth.approach, rel=1e-12)
    by_ridge = np.bincount(pad.ridges.of_point, smooth.force)[1:]
    np.testing.assert_allclose(result.ridge_force, by_ridge, rtol=1e-10)


@pytest.mark.parametrize("mu", [0.1, 0.2])
def test_a_press_is_the_one_that_point_by_point_relaxation_finds(
    mu: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert_same(springs((0.0, 0.3, 0.5)), mu, 1.2, 5, 200, monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.2, 1.0])
def test_a_meshed_press_is_the_one_that_relaxation_finds(mu: float, monkeypatch: pytest.MonkeyPatch) -> None:
    pad = meshed()
    assert_same(pad, mu, 1.3 * first_of(pad), 8, 4000, monkeypatch)


def assert_same(
    pad: StickingPad, mu: float, force: float, steps: int, sweeps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The plate is led along the product's path: forces, and with them the force that was asked, are found
    again. Both are to rounding where the sweeps have settled."""
    path: list[ContactState] = []
    step = press_path._PlanePoints.step

    def watched(*arguments: object) -> ContactState:
        state = step(*arguments)  # type: ignore[arg-type]
        if state.normal.size == pad.ridges.gap.size:  # not the search for a ridge that is out of contact
            path.append(state)
        return state

    monkeypatch.setattr(press_path._PlanePoints, "step", watched)
    result = press_with_friction(pad, mu, force, first_of(pad), steps)
    assert any((state.status >= 2).any() for state in path)  # slips somewhere,
    assert any((state.status == 1).any() for state in path)  # and sticks
    normal, along = relaxed(pad, mu, path, sweeps)
    np.testing.assert_allclose(normal, path[-1].normal, atol=1e-6 * force)
    np.testing.assert_allclose(along, path[-1].tangential, atol=1e-6 * force)
    assert normal.sum() == pytest.approx(force, rel=1e-6)
    assert along.sum() == pytest.approx(0.0, abs=1e-6 * force)
    np.testing.assert_allclose(result.ridge_force.sum(), force)


@pytest.mark.parametrize("force", [0.3, 3.0])
def test_the_last_ridge_begins_to_carry_where_all_touch(force: float) -> None:
    """Asked at a force before or after it, and pressed a little less or more than it."""
    pad, mu = springs((0.0, 0.3, 0.5)), 0.5
    first = first_of(pad)
    all_touch = press_with_friction(pad, mu, force, first, 40).all_touch_force or 0.0
    assert all_touch != pytest.approx(first, rel=1e-3)
    less, more = (
        press_with_friction(pad, mu, share * all_touch, first, 40).ridge_force for share in (0.999, 1.001)
    )
    assert (less > 0).sum() == 2
    assert (more > 0).sum() == 3


def test_steps_change_little_and_ever_less() -> None:
    """The error of a step is of first order: with four times the steps it is a quarter, or less."""
    pad = springs((0.0, 0.3, 0.5))
    first = first_of(pad)
    few, some, many = (
        press_with_friction(pad, 0.5, 1.2, first, steps).all_touch_force or 0.0 for steps in (5, 20, 160)
    )
    assert abs(some - many) <= 0.3 * abs(few - many)
    assert abs(some - many) < 5e-3 * many


def test_a_single_ridge_touches_at_once_and_what_never_touches_is_none() -> None:
    assert press_with_friction(springs((0.0,)), 0.5, 1.0, 0.0, 5).all_touch_force == 0.0
    assert press_with_friction(springs((0.0, 0.3)), 0.5, 1.0, None, 5).all_touch_force is None


def test_ridges_that_friction_keeps_apart_are_said() -> None:
    """Looked for up to a multiple of the force without friction, and no further."""
    with pytest.raises(ContactError, match="not all ridges touch at up to 3 times"):
        press_with_friction(springs((0.0, 0.3, 0.5)), 0.5, 0.01, 0.01, 5)
