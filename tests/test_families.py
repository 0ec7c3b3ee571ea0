"""Every command with every family: a result, or one line that says why not."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import skincad
from skincad.inputs import display_name
from skincad.live import apply_moves, start_session
from skincad.live.controls import controls
from skincad.shape import FAMILIES, skin_of
from tests.conftest import run_skincad
from tests.refusals import assert_a_line

TEMPLATES = {"ridge": "plain-ridges", "pin": "pillars-9", "ring": "rings-5", "flat": "flat-magnet"}
PULL = """name = "pull"
skin = "{name}"
[history]
steps = 40
time_s = [0.0, 1.0, 2.0]
normal_force_N = [0.0, {force}, {force}]
tangential_force_N = [0.0, 0.0, {pull}]
[effects.friction]
coefficient = 0.5
"""
STUDY = """name = "pad"
about = "{name}"
evaluations = 6
judge = "{model}"
[vary]
"skin.thickness" = "{low}:{high}"
[[objectives]]
key = "approach"
"""


def ran(folder: Path, *arguments: str) -> str:
    """What a command prints that does what it is asked."""
    result = run_skincad(*arguments, cwd=folder)
    assert result.returncode == 0, f"{arguments}: {result.stdout}{result.stderr}"
    return result.stdout


def test_each_family_has_a_template() -> None:
    assert set(TEMPLATES) == set(FAMILIES)
    for family, name in TEMPLATES.items():
        assert skincad.load(name).features.family == family


@pytest.fixture(
    params=[pytest.param(key, marks=pytest.mark.evidence(subject=name)) for key, name in TEMPLATES.items()]
)
def family(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_check_make_and_their_words(family: str, tmp_path: Path) -> None:
    name = TEMPLATES[family]
    said = ran(tmp_path, "check", name, "--no-advice", "-v")
    assert "Passes" in said
    made = ran(tmp_path, "make", name, "-v")
    assert "no errors" in made
    folder = tmp_path / "out" / name
    names = {path.name for path in folder.rglob("*") if path.is_file()}
    assert {"picture.png", "view.html", "report.html", "casting-sheet.md", "skin.step", "skin.stl"} <= names
    if family != "ridge":
        sheet = (folder / "casting-sheet.md").read_text("utf-8")
        report = (folder / "report.html").read_text("utf-8")
        for text in (said, made, sheet):
            assert "ridge" not in text.lower()
        assert f"all {family}s touch" in report or family == "flat"


def test_json_of_check_has_the_contracts_keys(family: str, tmp_path: Path) -> None:
    data = json.loads(ran(tmp_path, "check", TEMPLATES[family], "--no-advice", "--json"))
    assert data["verdict"] == "passes"
    assert len(data["ridge_force_N"]) == data["ridges"] == skin_of(skincad.load(TEMPLATES[family])).count


def test_sweep_solve_and_optimise(family: str, tmp_path: Path) -> None:
    name = TEMPLATES[family]
    thick = skincad.load(name).skin.thickness
    low, high = thick, round(1.2 * thick, 3)
    said = ran(tmp_path, "sweep", name, "--vary", f"skin.thickness={low}:{high}:2")
    assert "2 by" in said
    approach = float(skincad.check(skincad.load(name), model=model(family)).approach)
    varied = "material.young_modulus=0.05:3"
    ran(tmp_path, "solve", name, "--target", f"approach={0.9 * approach:.4g}", "--vary", varied)
    study = STUDY.format(name=name, model=model(family), low=low, high=high)
    (tmp_path / "study.toml").write_text(study)
    assert ran(tmp_path, "optimise", "study.toml")


def model(family: str) -> str:
    return "reduced" if family == "pin" else "linear"


def test_live_moves_its_sliders(family: str) -> None:
    session = start_session(skincad.load(TEMPLATES[family]))
    keys = {control.key for control in controls(session.subject)}
    assert "skin.thickness" in keys
    assert all(not key.startswith("ridge.") for key in keys) or family == "ridge"
    after = apply_moves(session, {"skin.thickness": 1.1 * session.design.skin.thickness}, 0.0)
    assert after.refusal is None
    assert display_name(after.design).endswith("(changed)")


def test_a_package_presses_as_the_check_says(family: str, tmp_path: Path) -> None:
    import mujoco

    name = TEMPLATES[family]
    ran(tmp_path, "package", name, "--for", "mujoco", "--for", "taxels", "-o", "pack")
    verdict = skincad.check(skincad.load(name))
    scene = mujoco.MjModel.from_xml_path(str(tmp_path / "pack" / "scene.xml"))
    data = mujoco.MjData(scene)
    mujoco.mj_resetDataKeyframe(scene, data, 0)
    for _ in range(1500):
        mujoco.mj_step(scene, data)
    count = skin_of(skincad.load(name)).count
    forces = data.sensordata[:count]
    assert forces.sum() == pytest.approx(verdict.force, rel=0.03)  # a plate that still rests on its springs
    for force, told in zip(forces, verdict.ridge_force, strict=True):
        assert abs(force - float(told)) <= (told.error or 0.0) + 0.03 * verdict.force / count
    taxels = (tmp_path / "pack" / "taxels.csv").read_text()
    pocket = getattr(skincad.load(name).features, "pocket", None)
    assert (",pocket," in taxels) == (pocket is not None)


@pytest.mark.evidence(subject="{name}")
@pytest.mark.parametrize("name", ["nibs-fine", "pins-dome"])
def test_of_many_pins_neighbours_are_one_body_and_press_as_the_check_says(name: str, tmp_path: Path) -> None:
    """The forces on the springs are exact; 0.1 %: a plate that still rests on them."""
    import mujoco

    said = ran(tmp_path, "package", name, "-o", "pack")
    assert "--for mesh" in said  # which takes minutes
    assert not (tmp_path / "pack" / "skin.vtu").exists()
    springs = json.loads((tmp_path / "pack" / "package.json").read_text())["springs"]
    count = skin_of(skincad.load(name)).count
    assert sorted(pin for group in springs["members"] for pin in group) == list(range(count))
    assert len(springs["members"]) == 64
    verdict = skincad.check(skincad.load(name))
    scene = mujoco.MjModel.from_xml_path(str(tmp_path / "pack" / "scene.xml"))
    data = mujoco.MjData(scene)
    mujoco.mj_resetDataKeyframe(scene, data, 0)
    for _ in range(1500):
        mujoco.mj_step(scene, data)
    assert data.sensordata[:64].sum() == pytest.approx(verdict.force, rel=1e-3)
    approach = verdict.approach
    assert abs(data.joint("plate-z").qpos[0] * 1e3 - approach.value) < (approach.error or 0.0)
    for force, group in zip(data.sensordata[:64], springs["members"], strict=True):
        shares = [verdict.ridge_force[pin] for pin in group]
        error = sum(share.error or 0.0 for share in shares) + 0.03 * verdict.force / 64
        assert abs(force - sum(map(float, shares))) < error
    places = (tmp_path / "pack" / "taxels.csv").read_text()
    assert places.count(",crest,") == count


def test_a_pull_is_marched(family: str, tmp_path: Path) -> None:
    name = TEMPLATES[family]
    (tmp_path / "pull.toml").write_text(PULL.format(name=name, force=0.4, pull=0.15))
    said = ran(tmp_path, "simulate", "pull.toml", "-v")
    assert "ridge" not in said or family == "ridge"
    assert "flat" not in said.replace(str(tmp_path), "").replace("flat-", "") or family != "flat"
    data = json.loads((tmp_path / "out" / "pull" / "simulate.json").read_text())
    assert len(data["slip_share"]) == len(data["time_s"])
    assert 0.0 < data["slip_share"][-1] < 1.0


def test_a_new_file_of_a_family_has_its_keys_alone(family: str, tmp_path: Path) -> None:
    ran(tmp_path, "new", "pad.toml", "--template", TEMPLATES[family])
    text = (tmp_path / "pad.toml").read_text()
    assert f"[{family}]" in text
    for other in FAMILIES:
        assert (f"\n[{other}]" in text) == (other == family)


@pytest.mark.parametrize("change", ["--set ridge.count=3", "--set pin.pitch=1"])
def test_two_families_are_refused_in_one_line(change: str, tmp_path: Path) -> None:
    result = run_skincad("check", TEMPLATES["ring"], *change.split(), cwd=tmp_path)
    assert result.returncode == 2
    assert "two families" in result.stderr
    assert_a_line(result.stderr.removeprefix("skincad: ").strip())
