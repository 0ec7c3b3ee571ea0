"""Policies that hear: a grip is raised at an alarm, and by less at each later one."""

from __future__ import annotations

import numpy as np
import pytest

import skincad
from skincad.scenes import load_scene
from skincad.scenes.ears import bandwidth, ears_of
from skincad.scenes.grip import HARDER, LESS, PAUSE, Raising, alarmed, fallen
from skincad.scenes.lift import tuning_of


@pytest.mark.parametrize("block", [1, 7, 100])
def test_a_policy_raises_at_alarms_and_pauses(block: int) -> None:
    """It is told from sample 20 to 59, and hears from 10 on: it raises at 20, and where it is still told 25
    later; the same however the samples are cut."""
    told = np.zeros(100)
    told[20:60] = told[5] = told[90] = 1.0
    policy = Raising(lambda values: values[:, 0, 0] > 0.5, 24.9 / PAUSE, 10)
    asked, grip = [], 2.0
    for begin in range(0, 100, block):
        rows = told[begin : begin + block, None, None] * np.ones((1, 1, 2))
        asked += policy.wanted(rows, grip, len(rows)).tolist()
        grip = asked[-1]
    assert policy.alarms == [20, 45, 90]
    assert asked[19] == 2.0
    steps = HARDER / np.arange(1.0, 4.0) ** LESS
    raised = 2.0 * (1.0 + np.array([steps[0], steps[0], steps[:2].sum(), steps.sum()]))
    np.testing.assert_allclose([asked[i] for i in (20, 44, 45, 99)], raised)


@pytest.mark.parametrize("differs", [False, True])
@pytest.mark.parametrize("block", [3, 200])
def test_a_stress_rate_that_falls_is_a_slip(differs: bool, block: int) -> None:
    """A pair is pulled from sample 50 on at an even rate, which ends at 120; as a rate, and as the stress."""
    rate = np.zeros(200)
    rate[50:120] = 1.0
    pair = np.cumsum(rate) if differs else 100.0 * rate
    heard = fallen(4, 0.1, differs=differs)
    outputs = np.stack([pair, np.zeros(200)], axis=1)[:, None]
    falls = np.concatenate([heard(outputs[i : i + block]) for i in range(0, 200, block)])
    at = np.flatnonzero(falls)
    assert 120 <= at[0] <= 123
    assert at[-1] <= 128


@pytest.mark.parametrize(("circuit", "changes"), [("charge-amplifier", True), ("transimpedance", False)])
def test_a_lift_hears_as_a_robot_behind_the_same_circuit(circuit: str, changes: bool) -> None:
    """What it hears, over which window, and from which odds it warns are those of a Detector made for the
    design; however the lift is cut, it warns at the same samples."""
    ridges, rate = [3, 4], 2000.0
    scene = load_scene("lift", [f"effects.piezo.circuit={circuit}", f"readout.ridges={ridges}"])
    ears = ears_of(scene, rate, 2000, None, 1.0)
    assert ears is not None
    ours, band = tuning_of(scene, rate, ears.chain), bandwidth(scene, rate)
    robot = skincad.Detector(scene.design, circuit, rate, ridges, alarms="grip", bandwidth=band)
    assert (ours.change is not None) == changes
    assert (ours.change, ours.window, ours.warning) == (
        robot.tuning.change, robot.tuning.window, robot.tuning.warning,
    )  # fmt: skip
    pulls = np.repeat(np.random.default_rng(2).normal(0.0, 40.0, (40, 2, 2)), 25, axis=0)
    outputs = (np.cumsum(pulls, axis=0) if changes else 3 * pulls) * ours.noise_floor
    heard = alarmed(skincad.Detector.of(ours, ridges, rate))
    told = np.concatenate([heard(outputs[i : i + 40]) for i in range(0, 1000, 40)])
    right = skincad.Detector.of(ours, ridges, rate).decisions(outputs.reshape(1000, 4))[1].any(axis=1)
    np.testing.assert_array_equal(told, right)
    assert 0 < told.sum() < 1000


def test_a_lift_hears_by_the_grippers_network_unless_told_otherwise() -> None:
    assert load_scene("lift").readout.alarms == "grip"
    assert load_scene("lift", ["readout.alarms=sure"]).readout.alarms == "sure"
    assert load_scene("yamada-2002-slip").readout.alarms == "sure"
