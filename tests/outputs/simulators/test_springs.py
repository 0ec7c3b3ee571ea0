"""The springs solve the check's own equation; a plate's contact with them against a closed form."""

from __future__ import annotations

import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.outputs.simulators import springs as room
from skincad.outputs.simulators.springs import Springs, plate_response, springs


def plain(gap: list[float], flexibility: np.ndarray) -> Springs:
    return Springs(gap=np.array(gap), flexibility=flexibility, coupled=True, verdict=None)


def test_two_springs_of_their_own_close_one_after_the_other() -> None:
    fit = plain([0.0, 0.3], np.diag([0.5, 0.25]))
    assert plate_response(fit, 0.4)[0] == pytest.approx(0.2)
    approach, forces = plate_response(fit, 2.0)  # d / 0.5 + (d - 0.3) / 0.25 = 2
    assert approach == pytest.approx(3.2 / 6)
    assert forces == pytest.approx([2 * approach, 4 * (approach - 0.3)])


def test_rows_squared_are_the_stiffness() -> None:
    rng = np.random.default_rng(3)
    factor = rng.normal(size=(5, 5))
    fit = plain([0.0] * 5, factor @ factor.T + np.eye(5))
    assert fit.rows.T @ fit.rows == pytest.approx(fit.stiffness)
    assert np.tril(fit.rows, -1) == pytest.approx(np.zeros((5, 5)))


@pytest.mark.parametrize(
    ("changes", "coupled"), [({}, True), ({"skin": {"curvature_radius_y": 100.0}}, False)]
)
def test_at_the_checks_load_they_are_the_check(
    changes: dict[str, object], coupled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room, "SPANS", ())
    fit = springs(skincad.load_design("plain-ridges").with_(**changes), "winkler")
    approach, forces = plate_response(fit, fit.verdict.force)
    assert fit.coupled is coupled
    assert approach == pytest.approx(float(fit.verdict.approach), rel=1e-6)
    assert forces == pytest.approx([float(share) for share in fit.verdict.ridge_force], abs=1e-6)


@pytest.mark.slow
def test_at_other_loads_they_are_near_the_check() -> None:
    """Measured 3 % and 5 %, of the shares 5.5 % and 13 % of the mean one: what a secant leaves."""
    fit = springs(skincad.load_design("yamada-2002"), "corrected")
    half, twice = fit.elsewhere
    assert (half.force, twice.force) == (2.0, 8.0)
    assert max(half.approach_off, twice.approach_off) < 0.07
    assert max(half.shares_off, twice.shares_off) < 0.2
    assert half.check_shares[0] < 0.01  # an outer ridge is clear there, and so it is by springs
    assert half.shares[0] < 0.05


def test_a_plate_that_is_not_flat_is_refused() -> None:
    design = skincad.load_design("yamada-2002").with_(contact={"plate": {"shape": "tilted", "tilt": 1.0}})
    with pytest.raises(InputError, match=r"contact\.plate\.shape: must be 'flat' for mujoco.*--for"):
        springs(design)
