"""Other programs on the same sections, where they are installed: contact by CalculiX, friction by GetFEM."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench import bonded_rings, calculix, getfem
from bench.calculix import FORCE, SOFTER
from bench.getfem import (
    FRICTION,
    STRIDES,
    TRAVEL,
    WHOLE,
    FrictionalPad,
    apart,
    history,
    let_go,
    section,
    used,
)
from skincad.inputs import load_design as load
from skincad.laws import Ogden
from skincad.mechanics import Drive, pad_of, plane_piece
from skincad.mechanics.models import finite_strain, linear
from tests.mechanics.designs import filleted

COARSE = 0.25  # fineness of CalculiX's mesh
with_calculix = pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())


@with_calculix
@pytest.mark.parametrize(
    "large",
    [
        pytest.param(False, marks=pytest.mark.slow),  # of all cases the one that any commit runs
        pytest.param(True, marks=pytest.mark.evidence(subject="calculix: shares")),
    ],
    ids=["linear", "finite strain"],
)
def test_calculix_gives_the_same_shares(large: bool) -> None:
    theirs, ours = pressed_by_calculix(None, large=large), pressed(None, large=large)
    # 0.01 N of a mean share of 0.44: the coarse mesh is off by 0.0025 N, large strain shifts shares by 0.02
    assert np.abs(theirs.shares - ours.ridge_force).max() <= 0.01
    assert theirs.shares.sum() == pytest.approx(FORCE, rel=1e-3)  # CalculiX's own convergence
    assert theirs.approach == pytest.approx(ours.approach, rel=5e-3)  # penalty and coarse mesh


@pytest.mark.evidence(subject="calculix: half")
@with_calculix
def test_calculix_on_the_half_gives_the_same_shares() -> None:
    """Two meshes, which gmsh makes otherwise on each machine: seen 1.5e-4 N and 5e-6 of the approach. On one
    twice as coarse 5e-4 N and 1.5e-4: the mesh's, and the half adds nothing."""
    half, whole = (calculix.press(pad_of(filleted()), 2 * COARSE, FORCE, whole=w) for w in (False, True))
    assert half.unknowns < 0.6 * whole.unknowns
    assert np.abs(half.shares - whole.shares).max() <= 1e-3
    assert half.approach == pytest.approx(whole.approach, rel=1e-4)


@pytest.mark.evidence(subject="calculix: shares")
@with_calculix
@pytest.mark.parametrize("law", [Ogden(mu=[1.0], alpha=[10.0]), Ogden(mu=[0.7, 0.3], alpha=[6.0, -3.0])])
def test_calculix_gives_the_same_shares_by_ogdens_law(law: Ogden) -> None:
    """Within 1 % of the mean share and of the approach. What the law changes, by up to 1.7 % of the approach
    and 2 % of a mean share, agrees to a tenth of that: the coarse mesh's error is the same for any law.
    """
    (theirs, ours), (their_plain, our_plain) = (
        (numbers(run.approach, run.shares), numbers(own.approach, own.ridge_force))
        for run, own in ((pressed_by_calculix(of, large=True), pressed(of, large=True)) for of in (law, None))
    )
    mean = FORCE / (ours.size - 1)
    assert np.abs(theirs[1:] - ours[1:]).max() <= 0.01 * mean
    assert theirs[0] == pytest.approx(ours[0], rel=0.01)
    their_change, our_change = theirs - their_plain, ours - our_plain
    scale = np.array([ours[0], *(mean for _ in ours[1:])])
    assert np.abs(our_change / scale).max() >= 0.005  # the law counts: a wrong one would not pass
    assert np.abs((their_change - our_change) / scale).max() <= 0.1 * np.abs(our_change / scale).max()


def numbers(approach: float, shares: np.ndarray) -> np.ndarray:
    return np.array([approach, *shares])


@cache
def pressed_by_calculix(law: Ogden | None, *, large: bool) -> calculix.PressedPad:
    """CalculiX's contact: at small strain of the whole, at large strain of the half, in half the time."""
    pad = replace(pad_of(filleted()), law=law)
    start = SOFTER * pressed(None, large=False).approach if large else None
    return calculix.press(pad, COARSE, FORCE, start, whole=not large)


@cache
def pressed(law: Ogden | None, *, large: bool) -> linear.PlaneSolution:
    """This program's."""
    pad = replace(pad_of(filleted()), law=law)
    return (finite_strain.level if large else linear.level)(plane_piece(pad, 0.5), 3, FORCE)


def test_ogdens_constants_are_calculixs() -> None:
    """Both have 2 mu / alpha^2 and the sum of mu as shear modulus; D1 = 2 / K."""
    law = Ogden(mu=[3.0, 1.0], alpha=[6.0, -3.0])
    head, constants = next(iter(calculix._ogden(replace(pad_of(filleted()), law=law), 100.0))).split("\n")
    assert head == "*HYPERELASTIC, OGDEN, N=2"
    shear = 0.8 / 2 / 1.499
    wanted = [0.75 * shear, 6.0, 0.25 * shear, -3.0, 0.02, 0.0]
    assert [float(word) for word in constants.split(",")] == pytest.approx(wanted, rel=1e-12)


@cache
def dragged(fineness: float) -> FrictionalPad:
    """GetFEM's."""
    return getfem.drag(section(), fineness, history(), FRICTION)


@cache
def ours() -> FrictionalPad:
    """This program's."""
    return getfem.own(section(), 0.5, getfem.ORDER, history(), FRICTION)


@pytest.mark.evidence(subject="calculix: rings")
@with_calculix
def test_calculix_gives_the_same_stiffness_of_rings() -> None:
    """Bonded rings in three dimensions, 2.6 and 1.8 % stiffer: by 1 % for the bricks, as seen on twice as
    large ones, the rest because theirs may not move along y. A plate that follows the skin is a fourth
    softer: that a level one presses rings unevenly counts."""
    theirs, ours = bonded_rings.theirs(), bonded_rings.own()
    assert theirs == pytest.approx(ours["level"], rel=0.035)
    assert (theirs > ours["level"]).all()
    assert (ours["free"] < 0.85 * theirs).all()


@pytest.mark.evidence(subject="getfem: face")
@pytest.mark.skipif(bool(getfem.missing()), reason=getfem.missing())
def test_getfem_gives_the_same_drag_of_a_face() -> None:
    """A layer of a quarter of its contact's width, of which more and more slips: twice what was found, 1.2e-3
    of the pull and 1.0e-3 of the approach. On the coarser mesh it is twice as much or more: the rest is
    GetFEM's mesh."""
    pad, force = pad_of(load("flat-magnet")), 4.0
    drives = [Drive(force * i / 8, travel=0.0) for i in range(1, 9)]
    drives += [Drive(force, travel=2.4 * i / STRIDES) for i in range(1, STRIDES + 1)]
    own = getfem.own(pad, 0.5, getfem.ORDER, drives, FRICTION)
    fine, coarse = (
        apart(getfem.drag(pad, fineness, drives, FRICTION, augmentation=0.1, start=0.1), own)
        for fineness in (0.5, 0.25)
    )
    for name, bound in {"pull": 2.5e-3, "approach": 2e-3}.items():
        assert fine[name] <= bound
        assert fine[name] <= 0.6 * coarse[name]
    slips = own.tangential[:, 0] / (FRICTION * force)
    assert np.count_nonzero((slips > 0.5) & (slips < 0.99)) > STRIDES / 3
    assert slips[-1] == pytest.approx(1.0, rel=1e-9)


@pytest.mark.evidence(subject="getfem: drag")
@pytest.mark.skipif(bool(getfem.missing()), reason=getfem.missing())
def test_getfem_gives_the_same_drag() -> None:
    """Through all steps, from the first touch to gross slip; about twice what was found, 2.1e-3 of a mean
    ridge's force and 4.6e-4 of the pull and the approach. On the coarser mesh it is twice as much or more:
    the rest is GetFEM's mesh."""
    fine, coarse = (apart(dragged(fineness), ours()) for fineness in (0.5, 0.25))
    for name, bound in {"normal": 5e-3, "tangential": 5e-3, "pull": 1e-3, "approach": 1e-3}.items():
        assert fine[name] <= bound
        assert fine[name] <= 0.75 * coarse[name]
    assert ours().tangential[-1].sum() == pytest.approx(
        FRICTION * getfem.FORCE, rel=1e-9
    )  # it ends in gross slip


@pytest.mark.evidence(subject="getfem: drag")
@pytest.mark.skipif(bool(getfem.missing()), reason=getfem.missing())
def test_getfem_lets_the_same_ridges_slip_in_the_same_steps() -> None:
    """A tenth of a step's travel, which the line between two steps is good for."""
    theirs, slips = dragged(0.5), used(ours(), FRICTION) >= WHOLE
    assert (slips == (used(theirs, FRICTION) >= WHOLE)).all()
    assert slips[-1].sum() == 8  # of nine: the trailing one has lifted off
    ends = [let_go(run, history(), FRICTION) for run in (ours(), theirs)]
    assert np.isfinite(ends[0]).all()
    assert np.abs(ends[0] - ends[1]).max() <= 0.1 * TRAVEL * FRICTION / STRIDES


def test_a_ridge_lets_go_between_two_steps() -> None:
    """By hand: of 0.5 N held the first bears 0.4 and then 0.6 N, the second never as much, the third is
    clear."""
    normal = np.array([[1.0, 1.0, 0.0]] * 3)
    tangential = np.array([[0.0, 0.0, 0.0], [0.4, 0.2, 1e-17], [0.6, 0.3, 1e-17]])
    drives = [Drive(2.0, travel=0.1 * i) for i in range(3)]
    path = FrictionalPad(normal, tangential, np.zeros(3), 0)
    first, second, third = let_go(path, drives, 0.5)
    assert first == pytest.approx(0.1 + 0.1 * (WHOLE * 0.5 - 0.4) / 0.2, rel=1e-12)
    assert math.isnan(second)
    assert math.isnan(third)


def test_getfems_answer_is_read() -> None:
    text = '{"unknowns": 7, "steps": [{"approach": 0.1, "normal": [1, 2], "tangential": [0.5, 0]}]}'
    path = getfem.read(text, 12.0)
    assert path.unknowns == 7
    assert path.normal.tolist() == [[12.0, 24.0]]
    assert path.tangential.tolist() == [[6.0, 0.0]]
    assert path.approach.tolist() == [0.1]
