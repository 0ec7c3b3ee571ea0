"""[grip] in a scene: its table, what is refused, and what a lift tells."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.scenes import LEVELS, Grip, Lift, PressedSkin, Scene, at_level, carried, load_scene
from tests.refusals import refused, refused_command
from tests.small_scene import small_scene

BAD = {
    "grip.policy=squeeze": "grip.policy: must be 'constant', 'detector', 'stress-rate' or 'force'",
    "grip.gripper=robotik-2f85": "no such gripper, got 'robotik-2f85'; did you mean 'robotiq-2f85'?",
    "grip.gripper=anyskin-plate": "grip.delay: is missing, and anyskin-plate has none; give grip.delay",
    "grip.gripper=robotiq-2f85": "grip.force: must be at least what robotiq-2f85 can hold, 20 N, got 2",
    "grip.force=8.0": "grip.force: must be at most the gripper's largest, 7 N, got 8",
    "grip.mass=none": "grip.mass: is missing",
    "grip.mass=0.0": "grip.mass: must be greater than 0 (g), got 0",
    "grip.mas=3.0": "grip.mas: unknown key; did you mean 'mass'?",
    "grip.rise=0.0": "grip.rise: must be greater than or equal to 0.001",
    "grip.delay=0.0": "grip.delay: must be greater than or equal to 0.001",
    "grip.acceleration=nan": "grip.acceleration: must be a finite number",
    "grip.load_N=[0.0, 1.0]": "grip.load_time_s: is missing beside the other",
    "grip.load_time_s=[0.0, 1.0]": "grip.load_N: is missing beside the other",
    "history={time_s=[0.0, 1.0], normal_force_N=[0.0, 1.0], tangential_force_N=[0.0, 0.0], steps=5}": (
        "history: has no effect beside [grip]; leave one of them out"
    ),
    "grip=none": "history: is missing; give history a value, or [grip]",
    "effects.friction=none": "effects.friction: is missing; a lift needs friction",
    "effects.friction.coefficient=0.0": "effects.friction.coefficient: must be above 0 in a lift, got 0",
    "effects.piezo=none": "effects.piezo: is missing: policy = detector hears the films",
    "readout.ridges=[]": "readout.ridges: is missing: policy = detector hears the films",
    "effects.texture={wavelength=0.5, amplitude=0.01}": "effects.texture: is not simulated of a lift",
    "effects.viscosity={prony=[[0.5, 0.1]]}": "effects.viscosity.prony: has no effect on a lift",
    "effects.finite_strain={}": "effects.finite_strain: is not simulated of a lift",
    "plate.mass=3.0": "plate.mass: has no effect beside",
    "readout.steps=[3]": "readout.steps: has no effect beside [grip]",
    "skin=pillars-9": "effects.film: is not simulated of pins",
}


@pytest.mark.parametrize("override", BAD)
def test_bad_lifts_are_one_line(override: str) -> None:
    with refused(BAD[override]):
        load_scene("lift", [override])


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["grip.load_time_s=[0.0, 1.0]", "grip.load_N=[0.0]"], "grip.load_N: "),
        (["grip.load_time_s=[0.0, 1.0]", "grip.load_N=[0.0, 1.0, 2.0]"], "grip.load_N: needs 2 values"),
        (["grip.load_time_s=[0.1, 1.0]", "grip.load_N=[0.0, 1.0]"], "grip.load_time_s: must begin at 0"),
        (["grip.load_time_s=[0.0, 1.0]", "grip.load_N=[0.5, 1.0]"], "grip.load_N: must begin at 0"),
        (["grip.load_time_s=[0.0, 1.0]", "grip.load_N=[0.0, 0.0]"], "grip.load_N: must not be 0 all along"),
        (["grip.load_time_s=[0.0, 0.0]", "grip.load_N=[0.0, 1.0]"], "grip.load_time_s: must rise"),
    ],
)
def test_a_load_over_time_has_its_rules(settings: list[str], words: str) -> None:
    with refused(words):
        load_scene("lift", settings)


def test_a_command_refuses_a_lift_before_it_writes(tmp_path: Path) -> None:
    words = refused_command("simulate", "lift", "--set", "grip.force=9.0", cwd=tmp_path)
    assert words.startswith("grip.force: must be at most the gripper's largest, 7 N")
    for option in ("--tol=0.1", "--budget=3"):
        assert refused_command("simulate", "lift", option, cwd=tmp_path).endswith("leave it out")
    assert refused_command("live", "lift", cwd=tmp_path).startswith("grip: is not shown live")


def test_a_lift_is_what_its_toml_says() -> None:
    scene = load_scene("lift")
    assert "history" not in scene.to_toml()
    again = Scene(**scene.model_dump(exclude_none=True))
    assert again == scene
    heavier = scene.with_(grip={"mass": 600.0})
    assert heavier.grip is not None
    assert max(heavier.history.tangential_force_N or []) == pytest.approx(
        2 * max(scene.history.tangential_force_N or [])
    )


def test_the_load_is_the_weight_and_what_the_lift_asks() -> None:
    grip = Grip(gripper="leap-hand", mass=200.0, force=2.0, acceleration=4.0)
    time, load = grip.points
    assert time.tolist() == pytest.approx([0.0, 0.1, 0.4, 0.475, 0.625, 0.7, 1.0])
    carried = 0.1  # kg, of one finger
    at_rest, up, down = carried * 9.81, carried * (9.81 + 4.0), carried * (9.81 - 4.0)
    assert load.tolist() == pytest.approx([0.0, 0.0, at_rest, up, down, at_rest, at_rest])
    bumps = Grip(
        gripper="leap-hand", mass=200.0, force=2.0, load_time_s=[0.0, 0.2, 0.3], load_N=[0.0, 1.0, 0.4]
    )
    time, load = bumps.points
    assert time.tolist() == pytest.approx([0.0, 0.1, 0.3, 0.4])
    assert load.tolist() == [0.0, 0.0, 1.0, 0.4]


QUICK = ["grip.close=0.03", "grip.rise=0.05", "grip.lift=0.02", "grip.mass=100.0", "effects.piezo=none"]


@pytest.fixture(scope="module")
def quick(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Lift]:
    """A lift by three ridges, too fast to be more than a toy, by what becomes of it."""
    made = {"holds": ["grip.force=1.3", "grip.hold=0.05"], "drops": ["grip.force=0.3"]}
    lifts = {}
    for name, settings in made.items():
        more = [*QUICK, "grip.policy=constant", "readout.ridges=[2]", *settings]
        lift = skincad.simulate(small_scene(tmp_path_factory.mktemp(name), "lift", *more))
        assert isinstance(lift, Lift)
        lifts[name] = lift
    return lifts


@pytest.mark.slow
def test_enough_grip_holds_and_too_little_drops(quick: dict[str, Lift]) -> None:
    holds, drops = quick["holds"], quick["drops"]
    assert (holds.verdict, drops.verdict) == ("held", "dropped")
    # the whole object never slides; what a point slides it does beside others that stick
    assert holds.slide.value == 0.0
    assert drops.slide.value is not None
    assert drops.slide.value > drops.scene.design.skin.width / 2
    assert holds.least_grip == pytest.approx(0.05 * (9.81 + 2.0) / 0.6)
    assert holds.mean_grip.value == pytest.approx(1.3)
    assert (holds.peak_grip.value, holds.peak_grip.error) == (1.3, 0.0)
    assert holds.peak_grip_ratio.value == pytest.approx(1.3 / holds.least_grip)
    assert drops.slide_begins.value is not None
    # the load passes what friction bears of 0.3 N in the rise, and the skin gives before it pulls as much
    assert drops.slide_begins.value > 0.03 + 0.05 * 0.6 * 0.3 / (0.05 * 9.81)
    assert drops.slide_ends.value is None
    assert holds.first_alarm.value is None


@pytest.mark.slow
def test_a_load_to_the_other_side_is_held_alike(tmp_path: Path, quick: dict[str, Lift]) -> None:
    load = ["grip.load_time_s=[0.0, 0.05, 0.1]", "grip.load_N=[0.0, -0.6, -0.4]", "grip.policy=constant"]
    more = ["grip.force=1.3", "grip.close=0.03", "grip.mass=100.0", "effects.piezo=none"]
    lift = skincad.simulate(small_scene(tmp_path, "lift", *load, *more, "readout.ridges=[2]"))
    assert isinstance(lift, Lift)
    assert (lift.passed, lift.held, lift.lost) == (True, 1, False)
    assert lift.least_grip == pytest.approx(0.6 / 0.6)
    assert quick["drops"].passed is False
    assert quick["drops"].numbers()["held"].value == 0


@pytest.mark.slow
def test_a_lift_writes_its_files_and_keys(quick: dict[str, Lift], tmp_path: Path) -> None:
    lift = quick["drops"]
    skincad.write(lift, tmp_path / "out")
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["lift.csv", "lift.png", "simulate.json"]
    told = json.loads((tmp_path / "out" / "simulate.json").read_text())
    assert told["verdict"] == "dropped"
    assert set(told["slide_mm"]) == {"value", "error"}
    assert set(told["slide_error_mm"]) == {"mesh", "time_step", "left_out"}
    rows = np.genfromtxt(tmp_path / "out" / "lift.csv", delimiter=",", names=True)
    assert rows.dtype.names is not None
    assert rows.dtype.names[:7] == (
        "time_s",
        "asked_N",
        "grip_N",
        "load_N",
        "pull_N",
        "travel_mm",
        "slide_mm",
    )
    assert rows["slide_mm"][-1] == pytest.approx(told["slide_mm"]["value"])
    # while it slides, the skin pulls with all that friction bears of this grip
    sliding = np.diff(rows["slide_mm"], prepend=0.0) > 1e-3
    assert rows["pull_N"][sliding] == pytest.approx(0.6 * rows["grip_N"][sliding], rel=1e-9)


@pytest.mark.slow
def test_a_lift_is_no_scene_of_a_report(quick: dict[str, Lift]) -> None:
    with pytest.raises(InputError, match="scenes: must not be lifts"):
        skincad.make(quick["holds"].scene.design, checked=False, solids=False, scenes=[quick["holds"]])


@pytest.mark.slow
def test_a_pressed_skin_is_that_of_finite_strain(tmp_path: Path) -> None:
    """Linear about its equilibrium under the grip, against finite strain in chosen steps of one scene."""
    load = ["grip.load_time_s=[0.0, 0.4, 0.5]", "grip.load_N=[0.0, 0.25, 0.25]", "grip.mass=4.0"]
    more = ["grip.policy=constant", "grip.force=0.8", "effects.piezo=none", "readout.ridges=[1, 2, 3]"]
    scene = small_scene(tmp_path, "lift", *load, *more)
    assert scene.grip is not None
    run = carried(scene, PressedSkin(scene).at(0.8), rate=500.0)
    history = {**scene.grip.plan(), "steps": 100}
    finite = scene.with_(
        grip=None, history=history, effects={"viscosity": None, "finite_strain": {"steps": "chosen"}}
    )
    small = scene.with_(grip=None, history=history, effects={"viscosity": None})

    def pulled(time: np.ndarray, films: np.ndarray) -> np.ndarray:
        """What the pull alone makes of S1 - S2 of each ridge, MPa."""
        pairs = films[:, ::2, 0] - films[:, 1::2, 0]
        return np.asarray(pairs[-1] - pairs[np.searchsorted(time, 0.1)])

    mine = pulled(run.time, run.films)
    marches = [at_level(other, LEVELS[0]).march for other in (finite, small)]
    judge, linear = (pulled(march.time, march.column("films")) for march in marches)
    # a pull of 0.3 times the grip leans the ridges: 5 % of the signal. Small strain lacks what pressing bends
    assert mine == pytest.approx(judge, abs=0.07 * np.abs(judge).max())
    assert np.abs(linear - judge).max() > 0.15 * np.abs(judge).max()
