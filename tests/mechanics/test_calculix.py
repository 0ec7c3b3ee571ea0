"""Another program's contact on the same section: CalculiX, where it is installed."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench import calculix
from bench.bench_calculix import FORCE, SOFTER, own
from skincad.laws import Ogden
from skincad.mechanics import pad_of, plane_piece
from skincad.mechanics.models import finite_strain
from tests.mechanics.designs import filleted

COARSE = 0.25  # fineness of CalculiX's mesh
pytestmark = pytest.mark.xdist_group("calculix")  # pressed() is shared


@pytest.mark.slow
@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
@pytest.mark.parametrize("model", ["linear", "finite-strain"])
def test_calculix_gives_the_same_shares(model: str) -> None:
    pad = pad_of(filleted())
    theirs, ours = pressed(None, large=model != "linear"), own(pad, model, 0.5, 3)
    # 0.01 N of a mean share of 0.44: the coarse mesh is off by 0.0025 N, large strain shifts shares by 0.02
    assert np.abs(theirs.shares - ours.shares).max() <= 0.01
    assert theirs.shares.sum() == pytest.approx(FORCE, rel=1e-3)  # CalculiX's own convergence
    assert theirs.approach == pytest.approx(ours.approach, rel=5e-3)  # penalty and coarse mesh


@pytest.mark.slow
@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
def test_calculix_on_the_half_gives_the_same_shares() -> None:
    """0.001 N: on another mesh its shares are 0.0004 N off (coarse, linear)."""
    half, whole = calculix.press(pad_of(filleted()), COARSE, FORCE, whole=False), pressed(None, large=False)
    assert half.unknowns < 0.6 * whole.unknowns
    assert np.abs(half.shares - whole.shares).max() <= 1e-3
    assert half.approach == pytest.approx(whole.approach, rel=1e-4)


@pytest.mark.slow
@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
@pytest.mark.parametrize("law", [Ogden(mu=[1.0], alpha=[10.0]), Ogden(mu=[0.7, 0.3], alpha=[6.0, -3.0])])
def test_calculix_gives_the_same_shares_by_ogdens_law(law: Ogden) -> None:
    """Within 1 % of the mean share and of the approach. What the law changes, by up to 1.7 % of the approach
    and 2 % of a mean share, agrees to a tenth of that: the coarse mesh's error is the same for any law.
    """
    theirs, ours = (by(law) for by in (calculixs, skincads))
    mean = FORCE / (ours.size - 1)
    assert np.abs(theirs[1:] - ours[1:]).max() <= 0.01 * mean
    assert theirs[0] == pytest.approx(ours[0], rel=0.01)
    their_change, our_change = theirs - calculixs(None), ours - skincads(None)
    scale = np.array([ours[0], *(mean for _ in ours[1:])])
    assert np.abs(our_change / scale).max() >= 0.005  # the law counts: a wrong one would not pass
    assert np.abs((their_change - our_change) / scale).max() <= 0.1 * np.abs(our_change / scale).max()


@cache
def pressed(law: Ogden | None, *, large: bool) -> calculix.PressedPad:
    """CalculiX's contact, at small or at large strain."""
    pad = pad_of(filleted())
    start = SOFTER * own(pad, "linear", 0.5, 2).approach if large else None
    return calculix.press(replace(pad, law=law), COARSE, FORCE, start)


def calculixs(law: Ogden | None) -> np.ndarray:
    """CalculiX's approach, mm, and shares, N, at large strain."""
    result = pressed(law, large=True)
    return np.array([result.approach, *result.shares])


@cache
def skincads(law: Ogden | None) -> np.ndarray:
    """This program's."""
    pad = replace(pad_of(filleted()), law=law)
    solution = finite_strain.Levels()(plane_piece(pad, 0.5), 3, FORCE)
    return np.array([solution.approach, *solution.ridge_force])


def test_ogdens_constants_are_calculixs() -> None:
    """Both have 2 mu / alpha^2 and the sum of mu as shear modulus; D1 = 2 / K."""
    law = Ogden(mu=[3.0, 1.0], alpha=[6.0, -3.0])
    head, constants = next(iter(calculix._ogden(replace(pad_of(filleted()), law=law), 100.0))).split("\n")
    assert head == "*HYPERELASTIC, OGDEN, N=2"
    shear = 0.8 / 2 / 1.499
    wanted = [0.75 * shear, 6.0, 0.25 * shear, -3.0, 0.02, 0.0]
    assert [float(word) for word in constants.split(",")] == pytest.approx(wanted, rel=1e-12)
