"""Textbook stresses of a law, and what holds its energy, in plane strain and in three dimensions, to them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from skincad.laws import Rubber
from skincad.mechanics import Functions, excess, excess_at
from skincad.mechanics.bodies import plane_body

Array = np.ndarray
ARRAYS = Functions(np.exp, np.log, np.sqrt, lambda c, a, b: np.where(np.real(c) > 0, a, b))
STEP = 1e-30  # of a complex step: exact to rounding
STRETCHES = (0.6, 0.97, 1.0 + 1e-6, 1.3, 1.9)
SHIFTS = (-0.8, 1e-3, 0.15, 0.7)


class Closed(NamedTuple):
    """A law and its nominal stresses, MPa, of kept volume: of a bar and of a sheet pulled both ways by a
    stretch, and of simple shear by a shift."""

    law: Rubber
    bar: Callable[[float], float]
    sheet: Callable[[float], float]
    sheared: Callable[[float], float]


def plane_energy(law: Rubber, gradient: Array, pressure: float = 0.0, bulk: float = 1e3) -> complex:
    """The plane body's energy density at one point, MPa."""
    whole = plane_body.strain_energy(gradient, pressure, law.shear, bulk, np.log)
    return complex(whole + law.shear * excess(law, gradient, ARRAYS))


def plane_stress(law: Rubber, gradient: Array) -> Array:
    """First Piola-Kirchhoff stress `(2, 2)`, MPa, without a pressure."""
    stress = np.zeros((2, 2))
    for at in np.ndindex(2, 2):
        moved = gradient.astype(complex)
        moved[at] += 1j * STEP
        stress[at] = plane_energy(law, moved).imag / STEP
    return stress


def solid_stress(law: Rubber, stretch: Array) -> Array:
    """First Piola-Kirchhoff stress `(3, 3)`, MPa, of F in three dimensions, without a pressure."""
    swell = np.full((1, 1), np.linalg.det(stretch) - 1)
    more = excess_at(law, np.zeros(1, dtype=int), stretch[None, None], swell)
    cofactor = np.linalg.inv(stretch).T  # over J
    stress = stretch - cofactor + more.stress()[0, 0] + more.volume[0, 0] * cofactor
    return law.shear * (stress - 2 / 3 * swell[0, 0] * (1 + swell[0, 0]) * cofactor)


def holds(closed: Closed) -> None:
    """Assert that the law gives its closed forms; 1e-12 of the shear modulus is rounding."""
    law, within = closed.law, 1e-12 * closed.law.shear
    for t in STRETCHES:
        assert law.stress(np.array([t]))[0] == pytest.approx(closed.bar(t), rel=1e-11, abs=within)
        bar, sheet = (np.diag([t, *free]) for free in ((t**-0.5, t**-0.5), (t, t**-2)))
        for stretch, wanted in ((bar, closed.bar(t)), (sheet, closed.sheet(t))):
            stress = np.diag(solid_stress(law, stretch))
            free = stress[2] * stretch[2, 2] / t  # what a pressure takes off
            assert stress[0] - free == pytest.approx(wanted, rel=1e-11, abs=3 * within)
    for shift in SHIFTS:
        result = plane_stress(law, np.array([[0.0, shift], [0.0, 0.0]]))
        assert result[0, 1] == pytest.approx(closed.sheared(shift), rel=1e-11, abs=within)
        in_space = np.eye(3)
        in_space[:2, :2] += [[0.0, shift], [0.1, 0.2]]
        in_plane = plane_stress(law, in_space[:2, :2] - np.eye(2))
        assert solid_stress(law, in_space)[:2, :2] == pytest.approx(in_plane, rel=1e-11, abs=within)
        turned = np.array([[0.0, 0.0], [shift, 0.0]])
        assert plane_stress(law, turned)[1, 0] == pytest.approx(closed.sheared(shift), rel=1e-11, abs=within)
