"""P-delta: the column between springs against a beam's own stiffness, and its limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import linalg

from skincad.mechanics import mean_width, sway_amplification, sway_force
from skincad.mechanics.left_out import sway_angle
from skincad.mechanics.validity import buckling_force
from tests.mechanics.designs import yamada

STIFF = 1e9  # a spring that is as good as a clamp


def beam(root: float, top: float, elements: int = 40) -> float:
    """phi of the smallest load at which a beam of E I = h = 1 sways, from Hermite elements' stiffness."""
    size = 2 * (elements + 1)
    bends, tilts, h = np.zeros((size, size)), np.zeros((size, size)), 1 / elements
    stiffness = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2]])
    stiffness = np.vstack([stiffness, -stiffness[0], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]) / h**3
    tilt = np.array([[36, 3 * h, -36, 3 * h], [3 * h, 4 * h**2, -3 * h, -(h**2)]])
    tilt = np.vstack([tilt, -tilt[0], [3 * h, -(h**2), -3 * h, 4 * h**2]]) / (30 * h)
    for i in range(elements):
        part = slice(2 * i, 2 * i + 4)
        bends[part, part] += stiffness
        tilts[part, part] += tilt
    bends[1, 1] += root
    bends[-1, -1] += top
    free = np.arange(1, size)  # the root does not move
    load = linalg.eigvals(bends[np.ix_(free, free)], tilts[np.ix_(free, free)]).real
    return math.sqrt(load[load > 0].min())


@pytest.mark.parametrize("springs", [(2.7, 1.2), (0.3, 4.0), (50.0, 0.1)])
def test_the_column_between_springs_is_a_beams(springs: tuple[float, float]) -> None:
    """1e-6: 40 Hermite elements."""
    assert sway_angle(*springs) == pytest.approx(beam(*springs), rel=1e-6)


@pytest.mark.parametrize(("springs", "phi"), [((STIFF, STIFF), math.pi), ((STIFF, 1e-9), math.pi / 2)])
def test_the_column_between_clamps_is_eulers(springs: tuple[float, float], phi: float) -> None:
    """1e-8: what springs of 1e9 give way."""
    assert sway_angle(*springs) == pytest.approx(phi, rel=1e-8)


def test_ends_that_turn_bear_less_than_clamps() -> None:
    """Unpressed, less than Haringx's column of validity.py, which is clamped and whose tip is level; pressed,
    a ridge is squatter."""
    design = yamada()
    assert 0.3 * buckling_force(design) < sway_force(design, 0.0) < buckling_force(design)
    assert sway_force(design, 0.6) > 1.1 * sway_force(design, 0.0)


def test_similar_ridges_sway_at_similar_forces() -> None:
    """E times two: twice the force; all of a section and the length times two: four times. To rounding."""
    design, modulus = yamada(), {"young_modulus": {"value": 1.6, "low": 1.3, "high": 1.9}}
    one = sway_force(design, 0.5)
    assert sway_force(design.with_(material=modulus), 1.0) == pytest.approx(2 * one, rel=1e-12)
    twice = {
        "height": 2 * design.ridge.height,
        "root_width": 2 * design.ridge.root_width,
        "tip_width": 2 * design.ridge.tip_width,
        "pitch": 2 * design.ridge.pitch,
    }
    larger = design.with_(ridge=twice, skin={"length": 2 * design.skin.length, "width": 22.0})
    assert mean_width(larger) == 2 * mean_width(design)
    assert sway_force(larger, 2.0) == pytest.approx(4 * one, rel=1e-12)


def test_a_ridge_that_does_not_stand_is_told_as_the_most() -> None:
    design = yamada()
    assert sway_amplification(design, 0.0, 2.0) == 0.0
    critical = sway_force(design, 0.5)
    assert sway_amplification(design, 0.5, 2.0) == pytest.approx(0.5 / (critical - 0.5), rel=1e-12)
    assert sway_amplification(design, 0.5, 0.1) == 0.1
    assert sway_amplification(design, 100.0, 2.0) == 2.0
