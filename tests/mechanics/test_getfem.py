"""Another program's friction on the same section: GetFEM, where it is installed."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from bench import getfem
from bench.bench_getfem import (
    FORCE,
    FRICTION,
    ORDER,
    STRIDES,
    TRAVEL,
    WHOLE,
    apart,
    history,
    let_go,
    own,
    section,
    used,
)
from bench.getfem import FrictionalPad
from skincad.mechanics import Drive

pytestmark = pytest.mark.xdist_group("getfem")  # dragged() is shared


@cache
def dragged(fineness: float) -> FrictionalPad:
    """GetFEM's."""
    return getfem.drag(section(), fineness, history(), FRICTION)


@cache
def ours() -> FrictionalPad:
    """This program's."""
    return own(section(), 0.5, ORDER, history(), FRICTION)


@pytest.mark.slow
@pytest.mark.skipif(bool(getfem.missing()), reason=getfem.missing())
def test_getfem_gives_the_same_drag() -> None:
    """Through all steps, from the first touch to gross slip; about twice what was found, 2.1e-3 of a mean
    ridge's force and 4.6e-4 of the pull and the approach. On the coarser mesh it is twice as much or more:
    the rest is GetFEM's mesh."""
    fine, coarse = (apart(dragged(fineness), ours()) for fineness in (0.5, 0.25))
    for name, bound in {"normal": 5e-3, "tangential": 5e-3, "pull": 1e-3, "approach": 1e-3}.items():
        assert fine[name] <= bound
        assert fine[name] <= 0.75 * coarse[name]
    assert ours().tangential[-1].sum() == pytest.approx(FRICTION * FORCE, rel=1e-9)  # it ends in gross slip


@pytest.mark.slow
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
