"""Slip of pins: against springs of their own, by heights, by symmetry; and what is not simulated of them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.scenes import Scene, Simulation, simulate
from skincad.shape import skin_of
from tests import families

FRICTION = 0.3
PRESS, PULL = 0.25, 1.2  # N, of friction's limit where it is 1
STEPS = 400


def pulled(design: skincad.Design, **changes: Any) -> Scene:
    """The plate presses within a second, and pulls in the next."""
    tables: dict[str, Any] = {
        "name": "pull",
        "skin": design,
        "history": {
            "steps": STEPS,
            "time_s": [0.0, 1.0, 2.0],
            "normal_force_N": [0.0, PRESS, PRESS],
            "tangential_force_N": [0.0, 0.0, PULL * FRICTION * PRESS],
        },
        "effects": {"friction": {"coefficient": FRICTION}},
    }
    return Scene(**{**tables, **changes})


def pillars() -> skincad.Design:
    """Pillars of nearly one height: the middle one of the family's would nearly tip over."""
    return families.pillars().with_(pin={"heights": [6.0, 5.9]})


@cache
def run(name: str) -> Simulation:
    return simulate(pulled(pillars() if name == "pillars" else families.OF_FAMILIES[name]()))


def test_short_pillars_slip_before_the_high_one() -> None:
    result = run("pillars")
    steps = np.array(result.slip_steps, dtype=float)
    assert result.gross_slip_step == steps[4] == steps.max()
    assert np.delete(steps, 4).max() < steps[4] - 5


@pytest.mark.slow
def test_pins_mirrored_in_y_slip_alike_and_work_is_accounted_for() -> None:
    for name in ("pillars", "dome"):
        result = run(name)
        tips = np.array([placed.tip for placed in skin_of(result.scene.design).placed])
        twin = np.linalg.norm(tips[:, None] - (tips * [1, -1, 1])[None], axis=2).argmin(axis=1)
        loads = result.march.loads[-2, :2]
        # a root's mean over the base is by points that no plane mirrors
        np.testing.assert_allclose(loads, loads[:, twin], rtol=2e-3, atol=1e-3 * loads.max())
        assert result.energy["imbalance"] < 5e-3


def test_what_it_bears_when_pressed_is_the_checks() -> None:
    """The springs are those of the reduced model at that force, within what friction at the tips changes."""
    design = pillars().with_(contact={"force": PRESS})
    shares = [float(share) for share in skincad.check(design, model="reduced").ridge_force]
    assert run("pillars").march.loads[STEPS // 2, 0] == pytest.approx(shares, rel=1e-3)
