"""What a scene is told to leave out, against runs with the effect; and how that is told."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from skincad.effects import LeftOutEffect, PlatePath, SceneOutline
from skincad.inputs import template_text
from skincad.scenes import LEVELS, Simulation, at_level, load_scene, models
from tests.small_scene import small_scene

PULL = "yamada-2002-press-and-pull"
FORCES = ("history.normal_force_N=[0.0, 1.3, 1.3]", "history.tangential_force_N=[0.0, 0.0, 0.4]")


def change(named: Simulation, without: Simulation) -> float:
    """Largest change of the told differences, of the largest without the effect."""
    largest = max(np.abs(values).max() for values in without.raw.values())
    return max(np.abs(named.raw[r] - without.raw[r]).max() for r in named.raw) / largest


def left_out_entry(simulation: Simulation, effect: str) -> LeftOutEffect:
    return next(entry for entry in simulation.left_out if entry.effect == effect)


def assert_told(entry: LeftOutEffect, change: float) -> None:
    assert entry.within is not None
    assert change / entry.within <= entry.change <= change * entry.within


@pytest.mark.slow
def test_small_pad(tmp_path: Path) -> None:
    """Three ridges, films along the axis."""
    press = (*FORCES, "history.steps=10", "readout.ridges=[1, 2, 3]")
    plain = at_level(small_scene(tmp_path, PULL, *press), LEVELS[0])
    without = at_level(small_scene(tmp_path, PULL, *press, "effects.film=none"), LEVELS[0])
    ends = at_level(small_scene(tmp_path, PULL, *press, "effects.free_ends={}"), LEVELS[0])
    assert_told(left_out_entry(without, "film"), change(plain, without))
    assert_told(left_out_entry(plain, "free_ends"), change(ends, plain))
    assert {"film"} <= {entry.effect for entry in without.left_out}
    assert not {"film", "free_ends"} & {entry.effect for entry in ends.left_out}


def test_an_estimate_on_an_unlike_pad_is_not_calibrated(tmp_path: Path) -> None:
    """A base of six pitches, where no scene behind the constants had more than five."""
    few = ("history.steps=4", "readout.ridges=[1, 2, 3]")
    small_scene(tmp_path, PULL, *few)
    skin = tmp_path / "small.toml"
    skin.write_text(skin.read_text().replace("thickness = 4.0", "thickness = 6.0", 1))
    scene = load_scene(tmp_path / "scene.toml", ["skin=small.toml", *FORCES, *few])
    entry = left_out_entry(at_level(scene, LEVELS[0]), "free_ends")
    assert (entry.calibrated, entry.within) == (False, None)
    assert "an uncalibrated estimate" in entry.warning


@pytest.mark.slow
@pytest.mark.parametrize("skin", ["yamada-2002", "yamada-2002-tilted", "fingertip-soft", "tilt 20"])
def test_films(skin: str, tmp_path: Path) -> None:
    if skin == "tilt 20":
        (tmp_path / "skin.toml").write_text(
            template_text("yamada-2002").replace("tilt = 0.0 ", "tilt = 20.0 ")
        )
        skin = str(tmp_path / "skin.toml")
    # the scene's 4 N would strain the soft fingertip's ridges beyond small strain: a quarter of them
    light = ["history.normal_force_N=[0.0, 1.0, 1.0]", "history.tangential_force_N=[0.0, 0.0, 0.25]"]
    more = light if skin == "fingertip-soft" else []
    assert_left_out_as_told("film", "effects.film=none", skin, "readout.ridges=[2, 3]", *more)


@pytest.mark.slow
@pytest.mark.parametrize("skin", ["yamada-2002", "yamada-2002-tilted"])
def test_ends(skin: str) -> None:
    every = "readout.ridges=[1, 2, 3, 4, 5, 6, 7, 8, 9]"
    assert_left_out_as_told("free_ends", "effects.free_ends={}", skin, every)


def assert_left_out_as_told(effect: str, setting: str, skin: str, *press: str) -> None:
    settings = [f"skin={skin}", "history.steps=40", *press]
    runs = [at_level(load_scene(PULL, [*settings, *more]), LEVELS[0]) for more in ([], [setting])]
    named, without = runs if setting.endswith("none") else reversed(runs)
    assert_told(left_out_entry(without, effect), change(named, without))


def test_what_matters_is_warned_of(tmp_path: Path) -> None:
    gentle = (FORCES[0], "history.tangential_force_N=[0.0, 0.0, 0.1]", "history.steps=2")
    simulation = at_level(
        small_scene(tmp_path, PULL, *gentle, "readout.ridges=[2]", "effects.film=none"), LEVELS[0]
    )
    film = next(entry for entry in simulation.left_out if entry.effect == "film")
    assert film.change > 0.1
    assert film.warning in simulation.warnings
    assert f"{film.change:.0%}, to a factor of {film.within:g}" in film.warning


def test_how_sure_an_estimate_is_stands_beside_it() -> None:
    known, roughly, guessed = (
        LeftOutEffect("film", "strips", 0.2, *more) for more in ((True, 2.5), (True, None), ())
    )
    assert known.warning.endswith("may change signals by 20%, to a factor of 2.5")
    assert roughly.warning.endswith("by 20%, calibrated")
    assert guessed.warning.endswith("by 20%, an uncalibrated estimate")
    assert known.as_json()["within"] == 2.5
    assert guessed.as_json()["within"] is None


@pytest.mark.parametrize(
    ("name", "key"), [(PULL, "tangential_force_N"), ("yamada-2002-stage", "displacement_mm")]
)
def test_what_is_left_out_is_judged_by_what_drives_the_plate_along(
    name: str, key: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[SceneOutline] = []
    monkeypatch.setattr(models, "effect", lambda _: SimpleNamespace(left_out=seen.append))
    scene = load_scene(name)
    loads = np.array([[[0.1, 0.3], [0.5, 0.2], [9.0, 9.0]], [[0.2, 0.1], [0.6, 0.7], [9.0, 9.0]]])
    readings = {
        "approach": np.array([0.0, 0.1]),
        "travel": np.array([0.0, 0.2]),
        "films": np.arange(24.0).reshape(2, 4, 3),
        "touches": np.array([[False, True, True, True], [True, True, True, True]]),
        "slips": np.array([[False, True, False, False], [False, True, True, True]]),
    }
    ridge = np.array([1, 1, 2, 2])
    march = SimpleNamespace(time=np.array([0.0, 1.0]), column=readings.get, loads=loads, ridge=ridge)
    assert models.left_out_effects(scene, march) == []  # type: ignore[arg-type]
    assert seen
    for outline in seen:
        assert outline.ridge_normal == 0.3
        assert outline.end == 1.0
        assert outline.pulls
        assert outline.driven == (key == "displacement_mm")
        assert outline.friction == scene.effects["friction"]["coefficient"]
        assert outline.path.slips.tolist() == [[1.0, 0.0], [0.5, 1.0]]
        assert outline.path.felt.tolist() == [[-3.0, -3.0], [-3.0, -3.0]]
        assert outline.path.pulled.tolist() == [[0.5, 0.2], [0.6, 0.7]]
        assert outline.loads == (tuple(scene.history.normal_force_N), tuple(getattr(scene.history, key)))


def test_a_signal_follows_pull_and_normal_force() -> None:
    """S = 3 T + 0.5 P of ridge 1 and -0.5 P of ridge 2; a third one that hardly touches tells nothing."""
    normal = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.05], [2.0, 2.0, 0.05], [2.0, 2.0, 0.05]])
    pulled = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.4, 0.4, 0.0]])
    signal = 3 * pulled + normal * [0.5, -0.5, 7.0]
    zero = np.zeros(4)
    path = PlatePath(np.arange(4.0), zero, zero, normal, pulled, 0 * normal, signal)
    down, along = path.per_force()
    # what presses both ridges alike cancels, so the pull is told apart exactly
    assert along == pytest.approx([3.0, 3.0, 3.0])
    assert down == pytest.approx([0.5, -0.5, 0.0])


def test_without_films_the_pull_stands_for_the_signal_and_without_that_the_normal_force() -> None:
    ones, zero = np.ones((2, 3)), np.zeros(2)
    untold = np.zeros((2, 0))
    pull = PlatePath(zero, zero, zero, ones, 2 * ones, 0 * ones, untold)
    assert pull.signal is pull.pulled
    press = PlatePath(zero, zero, zero, ones, 0 * ones, 0 * ones, untold)
    assert press.signal is press.pressed
