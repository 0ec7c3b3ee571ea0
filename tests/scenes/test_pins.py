"""Slip of pins: against springs of their own, by heights, by symmetry; and what is not simulated of them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.mechanics.models.pin_springs import pin_springs
from skincad.scenes.scene import Scene
from skincad.scenes.simulation import Simulation, simulate
from skincad.shape.skin import skin_of
from tests import families
from tests.conftest import run_skincad
from tests.refusals import refused_by

FRICTION = 0.8
PRESS, PULL = 1.0, 1.2  # N, of friction's limit where it is 1
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


@cache
def run(name: str) -> Simulation:
    return simulate(pulled({"wide": wide, **families.OF_FAMILIES}[name]()))


def wide() -> skincad.Design:
    """The pillars, so far apart that none feels another, and all of different heights."""
    heights = [6.0, 5.99, 5.98, 5.97, 5.96, 5.95, 5.94, 5.93, 5.92]
    skin = {"width": 110.0, "length": 110.0}
    return families.pillars().with_(pin={"pitch": 40.0, "heights": heights}, skin=skin)


def test_pins_far_apart_slip_as_springs_of_their_own() -> None:
    """Each sticks until its spring, stretched by the plate's travel, bears what friction does: in the order
    of that travel, at the pull of all springs together."""
    result, count = run("wide"), 9
    pad = pin_springs(wide(), PRESS)
    own = np.diag(pad.compliance)[:count]
    others = pad.compliance - np.diag(np.diag(pad.compliance))
    assert np.abs(others).max() < 1e-6 * own.min()  # the skin's radius of 1e8 mm leaves a lean
    normal = result.march.loads[STEPS // 2, 0]
    assert normal.sum() == pytest.approx(PRESS, rel=1e-9)
    travel = FRICTION * normal * own
    order = np.argsort(travel)
    for place, pin in enumerate(order):
        stuck, slid = order[place:], order[:place]
        pull = travel[pin] * (1 / own[stuck]).sum() + FRICTION * normal[slid].sum()
        step = STEPS // 2 + pull / (PULL * FRICTION * PRESS) * STEPS // 2
        found = result.slip_steps[pin]
        assert found is not None
        assert found == pytest.approx(step + 1, abs=1.01)  # the first step in which it slides
    assert order[0] == normal.argmin()


def test_short_pillars_slip_before_the_high_one() -> None:
    result = run("pillars")
    steps = np.array(result.slip_steps, dtype=float)
    assert result.gross_slip_step == steps[4] == steps.max()
    assert np.delete(steps, 4).max() < steps[4] - 5


def test_pins_mirrored_in_y_slip_alike_and_work_is_accounted_for() -> None:
    for name in ("pillars", "dome"):
        result = run(name)
        tips = np.array([placed.tip for placed in skin_of(result.scene.design).placed])
        twin = np.linalg.norm(tips[:, None] - (tips * [1, -1, 1])[None], axis=2).argmin(axis=1)
        # rows of pins that are not mirrored have none; those that are bear alike up to the cells' meshes
        same = np.abs(tips[twin] - tips * [1, -1, 1]).max(axis=1) < 1e-9
        assert same.sum() > 6
        loads = result.march.loads[-2]
        np.testing.assert_allclose(loads[:, same], loads[:, twin[same]], rtol=1e-6, atol=1e-9)
        assert result.energy["imbalance"] < 1e-3


def test_what_it_bears_when_pressed_is_the_checks() -> None:
    """The springs are those of the reduced model at that force, within what friction at the tips changes."""
    design = families.pillars().with_(contact={"force": PRESS})
    shares = [float(share) for share in skincad.check(design, model="reduced").ridge_force]
    assert run("pillars").march.loads[STEPS // 2, 0] == pytest.approx(shares, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "change", "key"),
    [
        ("rings", {}, "skin"),
        ("flat", {}, "skin"),
        ("pillars", {"effects": {"viscosity": {}}}, "effects.viscosity"),
        ("pillars", {"readout": {"steps": [3]}}, "readout.steps"),
        ("pillars", {"readout": {"ridges": [1]}}, "readout.ridges"),
    ],
)
def test_what_is_not_simulated_is_one_line(name: str, change: dict[str, Any], key: str) -> None:
    with refused_by(key):
        pulled(families.OF_FAMILIES[name](), **change)


def test_the_command_draws_a_map_of_pins(tmp_path: Path) -> None:
    (tmp_path / "pad.toml").write_text(families.pillars().to_toml())
    history = "steps = 20\ntime_s = [0.0, 1.0, 2.0]\nnormal_force_N = [0.0, 1.0, 1.0]\n"
    history += "tangential_force_N = [0.0, 0.0, 1.2]\n"
    scene = f'name = "pull"\nskin = "pad.toml"\n[history]\n{history}[effects.friction]\ncoefficient = 1.0\n'
    (tmp_path / "pull.toml").write_text(scene)
    result = run_skincad("simulate", str(tmp_path / "pull.toml"), "-o", str(tmp_path / "out"), cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "pins" in result.stdout
    assert "ridge" not in result.stdout
    assert (tmp_path / "out" / "signals.png").stat().st_size > 10_000
