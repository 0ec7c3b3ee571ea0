"""What rings about a load of straight lines, against the equation of motion integrated in time."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from skincad.mechanics import RETARDATION
from skincad.mechanics.dynamics.ringing import Ringer, ringer

CORNERS = np.array([0.0, 1e-3, 2.5e-3, 2.9e-3, 6e-3])
LOADS = np.array([0.0, 2.0, 2.0, -1.0, -0.5])


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.6])
def test_ringing_is_what_the_equation_of_motion_gives(damping: float) -> None:
    ring = Ringer(3000.0, damping)

    def pushed(t: float, state: np.ndarray) -> list[float]:
        load = np.interp(t, CORNERS, LOADS)
        return [state[1], ring.frequency**2 * (load - state[0]) - 2 * damping * ring.frequency * state[1]]

    times = CORNERS[:, None] + np.linspace(0, 1, 7) * np.append(np.diff(CORNERS), 3e-3)[:, None]
    motion = solve_ivp(pushed, (0, 9e-3), [0, 0], rtol=1e-9, atol=1e-12, max_step=2e-5, dense_output=True)
    x, speed = motion.sol(times.ravel()).reshape(2, *times.shape)
    lag = 2 * damping / ring.frequency * speed
    wanted = x + lag - np.interp(times, CORNERS, LOADS)
    assert ring.rings(CORNERS, LOADS, times) == pytest.approx(wanted, abs=1e-6)


def test_a_ramp_of_whole_periods_leaves_nothing() -> None:
    ring = Ringer(2 * np.pi * 500, 0.0)
    corners, values = np.array([0.0, 0.004]), np.array([0.0, 1.0])
    times = corners[:, None] + np.linspace(0, 2e-3, 41)
    during, after = np.abs(ring.rings(corners, values, times)).max(axis=1)
    assert after == pytest.approx(0, abs=1e-12)
    assert during == pytest.approx(1 / (2 * np.pi * 500 * 0.004), rel=1e-9)


def test_silicone_on_a_spring_is_damped_by_its_retardation() -> None:
    swing = ringer(4.0, 1e-6)
    assert swing.frequency == 2000.0
    assert swing.damping == pytest.approx(1000 * RETARDATION)
    assert ringer(4e12, 1e-6).damping < 1
