"""The contact solver alone, on dense compliances."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg, optimize

from skincad.mechanics import ContactError, press
from skincad.mechanics.contact import frictionless as contact


def problem(seed: int, size: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """A smooth kernel like an elastic half-plane's, with rough gaps: condition about 1e3."""
    random = np.random.default_rng(seed)
    at = np.linspace(0.0, 1.0, size)
    flexibility = np.exp(-np.abs(at[:, None] - at) / 0.3) + 0.01 * np.eye(size)
    return flexibility, 0.3 * (at - 0.5) ** 2 + 0.02 * random.random(size)


def press_by_least_squares(flexibility: np.ndarray, gap: np.ndarray, force: float) -> contact.NodalContact:
    """The same state by another way: non-negative least squares.

    With C = R^T R the forces minimise |R f + R^-T (g - d)|; the approach d that gives the force is found
    by bisection, the force being monotone in it. Lawson and Hanson, Solving Least Squares Problems, ch. 23.
    """
    root = linalg.cholesky(flexibility)

    def forces(approach: float) -> np.ndarray:
        side = linalg.solve_triangular(root, approach - gap, trans="T")
        return np.asarray(optimize.nnls(root, side)[0])

    low, high = float(gap.min()), float(gap.min() + force * np.diag(flexibility).max())
    while forces(high).sum() < force:
        high = low + 2 * (high - low)
    approach = optimize.brentq(lambda d: forces(d).sum() - force, low, high, xtol=1e-15, rtol=1e-14)
    nodal = forces(approach)
    return contact.NodalContact(nodal, approach, gap - approach + flexibility @ nodal, nodal > 0, 0.0)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("force", [1e-9, 0.01, 1.0, 1e6])
def test_two_algorithms_agree(seed: int, force: float) -> None:
    flexibility, gap = problem(seed)
    one, other = press(flexibility, gap, force), press_by_least_squares(flexibility, gap, force)
    # 1e-7 of the force: the second way roots on the approach, of which a light force is a small difference
    assert np.abs(one.force - other.force).max() <= 1e-7 * max(force, 1e-6)
    assert one.residual <= contact.COMPLEMENTARITY


@pytest.mark.parametrize("seed", range(8))
def test_fallback_gives_the_same_state(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    flexibility, gap = problem(seed)
    quick = press(flexibility, gap, 0.5)
    monkeypatch.setattr(contact, "SWEEPS", 0)  # as if the sweeps cycled
    slow = press(flexibility, gap, 0.5)
    assert np.array_equal(quick.active, slow.active)
    assert slow.force == pytest.approx(quick.force, abs=1e-12)  # the same linear system: rounding only


def test_start_does_not_matter() -> None:
    flexibility, gap = problem(3)
    for start in (np.ones(60, bool), np.arange(60) == 59, np.arange(60) % 2 == 0):
        assert (
            press(flexibility, gap, 0.2, start).active.tolist()
            == press(flexibility, gap, 0.2).active.tolist()
        )


def test_flat_gaps_share_by_stiffness() -> None:
    state = press(np.diag([1.0, 2.0, 4.0]), np.zeros(3), 7.0)
    assert state.force == pytest.approx([4.0, 2.0, 1.0], rel=1e-14)  # by hand, rounding only
    assert state.approach == pytest.approx(4.0, rel=1e-14)


def test_what_has_no_state_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    for force in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(ContactError, match="above 0"):
            press(np.eye(2), np.zeros(2), force)
    with pytest.raises(ContactError, match="coarser contact mesh"):
        press(np.array([[1.0, 2.0], [2.0, 1.0]]), np.zeros(2), 1.0)
    flexibility, gap = problem(3)
    monkeypatch.setattr(contact, "SWEEPS", 1)
    with pytest.raises(ContactError, match="does not settle"):
        press(flexibility, gap, 0.5, np.ones(60, bool), definite=False)


def test_in_a_saddle_point_the_state_nearby_is_found() -> None:
    """Two points that push each other up more than themselves: both carry half, or one of them all."""
    flexibility, gap = np.array([[1.0, 2.0], [2.0, 1.0]]), np.zeros(2)
    both = press(flexibility, gap, 1.0, np.array([True, True]), definite=False)
    assert (both.force.tolist(), both.approach) == ([0.5, 0.5], 1.5)
    one = press(flexibility, gap, 1.0, np.array([True, False]), definite=False)
    assert (one.force.tolist(), one.approach, one.gap.tolist()) == ([1.0, 0.0], 1.0, [0.0, 1.0])


def test_a_flexibility_that_is_not_definite_starts_from_the_lowest_point() -> None:
    """Two ridges that bend sideways push each other up: the first guess of the approach is negative. Before,
    no point touched then. By hand the lower one carries all, and the other opens by 3 + 1."""
    state = press(np.array([[1.0, -3.0], [-3.0, 1.0]]), np.array([0.0, 10.0]), 1.0, definite=False)
    assert state.force == pytest.approx([1.0, 0.0])
    assert state.approach == pytest.approx(1.0)
    assert state.gap == pytest.approx([0.0, 10.0 - 4.0])
