"""The error of a slip's time: closed forms, and that it holds against finer steps and meshes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from skincad.mechanics.contact.grip import Cone
from skincad.scenes import on_mesh
from skincad.scenes.march import INTERRUPTED, March, march
from skincad.scenes.scene import load_scene
from skincad.scenes.simulation import Simulation, simulate
from skincad.scenes.slip_errors import SlipError, lead, spread, thinned

COULOMB = Cone(1.0, 1.0)


@pytest.mark.parametrize("change", [0.0, 0.1, 1.0])
def test_a_pull_that_grows_evenly_slips_earlier_by_its_share(change: float) -> None:
    """A ratio that rises evenly from 0 to 1 in 10 ms passes 1 / (1 + c) at 10 ms / (1 + c)."""
    time = np.linspace(0.0, 0.01, 1001)
    loads = np.stack([np.full(1001, 4.0), np.linspace(0.0, -2.0, 1001), np.ones(1001)], axis=1)
    expected = 10.0 * (1 - 1 / (1 + change))
    assert spread(time, loads, 1000, change, COULOMB) == pytest.approx(
        expected, abs=0.011
    )  # a step of 0.01 ms


def test_an_earlier_pull_does_not_count_once_it_was_eased() -> None:
    time, ratio = np.linspace(0.0, 0.01, 11), np.array([0, 0.9, 0.9, 0.1, 0.2, 0.4, 0.6, 0.8, 1, 1, 1])
    loads = np.stack([np.ones(11), ratio, np.ones(11)], axis=1)
    assert spread(time, loads, 8, 0.5, COULOMB) == pytest.approx(1.0)  # from 0.8 on; 0.67 is needed
    assert spread(time, loads, None, 0.5, COULOMB) == 0.0


def test_by_a_constant_shear_stress_the_area_counts() -> None:
    """A pull that stays while the area shrinks from 2 to 1 mm2 uses ever more of what the area bears."""
    time = np.linspace(0.0, 0.01, 101)
    loads = np.stack([np.full(101, 4.0), np.full(101, 0.1), np.linspace(2.0, 1.0, 101)], axis=1)
    found = spread(time, loads, 100, 0.25, Cone(1.0, 1.0, ((0.1, 0.1),)))
    assert found == pytest.approx(2.5, abs=0.11)  # from 1.25 mm2 on; a step of 0.1 ms
    assert spread(time, loads, 100, 0.25, COULOMB) == pytest.approx(10.0)  # never below


def test_fewer_steps_keep_the_history_s_points() -> None:
    kept = thinned(23, np.array([0.0, 7.0, 13.0, 23.0]))
    assert kept.tolist() == [0, 5, 7, 10, 13, 15, 20, 23]


def test_a_lead_needs_both_slips() -> None:
    time = np.linspace(0.0, 0.01, 11)
    assert lead(time, 8, 5, 0.5).as_json() == {"value": pytest.approx(3.0), "error": 0.5}
    assert lead(time, None, 5, 0.5).value is None
    assert lead(time, 8, None, 0.5).value is None
    assert SlipError(None, 0.1, 0.0).total is None
    assert SlipError(0.1, 0.2, 0.3).total == pytest.approx(0.6)


@cache
def slip(*more: str) -> Simulation:
    return simulate(load_scene("yamada-2002-slip", ["readout.ridges=[1,2,3,4,6,7,8]", *more]))


@pytest.mark.slow
def test_the_step_and_the_mesh_are_told() -> None:
    """110 steps of 0.05 ms on two meshes against 550 on the same: the finer leads lie within the error."""
    coarse, fine = slip("history.steps=110"), slip()
    for ridge, told in coarse.lead.items():
        error = coarse.slip_errors[ridge - 1]
        assert told.value is not None
        assert error.mesh is not None
        assert error.time_step is not None
        assert error.time_step >= 0.05 - 1e-9
        other = fine.lead[ridge].value
        assert other is not None
        assert abs(told.value - other) <= error.mesh + error.time_step + 1e-9


def test_what_is_left_out_moves_a_slip_more_than_the_mesh() -> None:
    found = slip("history.steps=110")
    told = found.as_json()
    assert told["lead_ms"]["3"]["error"] == pytest.approx(sum(told["lead_error_ms"]["3"].values()))
    assert told["lead_ms"]["3"]["value"] == told["slip_lead_ms"]["3"]
    assert told["lead_error_ms"]["3"]["left_out"] > told["lead_error_ms"]["3"]["mesh"]


def test_ctrl_c_while_the_steps_error_is_found_keeps_the_march(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = load_scene("yamada-2002-press", ["history.steps=12", "readout.ridges=[3]"])

    def interrupted(pad: Any, times: Any, *rest: Any, **more: Any) -> March:
        found = march(pad, times, *rest, **more)
        return found if times.size == 13 else replace(found, stopped=INTERRUPTED)

    monkeypatch.setattr(on_mesh, "march", interrupted)
    found = simulate(scene, partial=True)
    assert found.march.interrupted
    assert len(found.march.readings) == 13
    assert found.slip_errors[2].time_step is None


def test_the_extra_march_is_a_stage_of_its_own() -> None:
    found = slip("history.steps=110")
    assert 0 < found.seconds["march with fewer steps"] < found.seconds["march"]
