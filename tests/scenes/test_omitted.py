"""Bounds of what a scene leaves out, against runs with the effect."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from skincad.effects.omitted import SceneOutline
from skincad.inputs.catalog import template_text
from skincad.scenes import omitted
from skincad.scenes.levels import LEVELS
from skincad.scenes.scene import load_scene
from skincad.scenes.simulation import Simulation, at_level
from tests.small_scene import small_scene

PULL = "yamada-2002-press-and-pull"
FORCES = ("history.normal_force_N=[0.0, 1.3, 1.3]", "history.tangential_force_N=[0.0, 0.0, 0.4]")


def change(named: Simulation, without: Simulation) -> float:
    """Largest change of the told differences, of the largest with the effect."""
    largest = max(np.abs(values).max() for values in named.raw.values())
    return max(np.abs(named.raw[r] - without.raw[r]).max() for r in named.raw) / largest


def bound(found: Simulation, effect: str) -> float:
    entry = next(entry for entry in found.left_out if entry.effect == effect)
    assert entry.calibrated
    return entry.change


def test_small_pad(tmp_path: Path) -> None:
    """Three ridges, films along the axis: bounds hold, the film's is no more than ten times too wide."""
    press = (*FORCES, "history.steps=10", "readout.ridges=[1, 2]")
    plain = at_level(small_scene(tmp_path, PULL, *press), LEVELS[0])
    without = at_level(small_scene(tmp_path, PULL, *press, "effects.film=none"), LEVELS[0])
    ends = at_level(small_scene(tmp_path, PULL, *press, "effects.free_ends={}"), LEVELS[0])
    assert change(plain, without) <= bound(without, "film") <= 10 * change(plain, without)
    assert change(ends, plain) <= bound(plain, "free_ends")
    assert {"film"} <= {entry.effect for entry in without.left_out}
    assert not {"film", "free_ends"} & {entry.effect for entry in ends.left_out}


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
    press = [f"skin={skin}", "history.steps=40", "readout.ridges=[2, 3]"]
    press += light if skin == "fingertip-soft" else []
    named, without = (
        at_level(load_scene(PULL, [*press, *more]), LEVELS[0]) for more in ([], ["effects.film=none"])
    )
    assert change(named, without) <= bound(without, "film")


@pytest.mark.slow
@pytest.mark.parametrize("skin", ["yamada-2002", "yamada-2002-tilted"])
def test_ends(skin: str) -> None:
    press = [f"skin={skin}", "history.steps=40", "readout.ridges=[2, 3, 5]"]
    without, named = (
        at_level(load_scene(PULL, [*press, *more]), LEVELS[0]) for more in ([], ["effects.free_ends={}"])
    )
    assert change(named, without) <= bound(without, "free_ends")


def test_what_matters_is_warned_of(tmp_path: Path) -> None:
    found = at_level(
        small_scene(tmp_path, PULL, *FORCES, "history.steps=2", "readout.ridges=[2]", "effects.film=none"),
        LEVELS[0],
    )
    film = next(entry for entry in found.left_out if entry.effect == "film")
    assert film.change > 0.1
    assert film.warning in found.warnings
    assert f"{film.change:.0%}" in film.warning


@pytest.mark.parametrize(
    ("name", "across"), [(PULL, "tangential_force_N"), ("yamada-2002-stage", "displacement_mm")]
)
def test_what_is_left_out_is_judged_by_what_drives_the_plate_along(
    name: str, across: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[SceneOutline] = []
    monkeypatch.setattr(omitted, "effect", lambda _: SimpleNamespace(left_out=seen.append))
    scene = load_scene(name)
    loads = np.array([[[0.1, 0.3], [0.5, 0.2], [9.0, 9.0]], [[0.2, 0.1], [0.6, 0.7], [9.0, 9.0]]])
    march = SimpleNamespace(time=np.array([0.0, 1.0]), column=lambda _: np.zeros(2), loads=loads)
    assert omitted.omitted(scene, march) == []  # type: ignore[arg-type]
    assert seen
    for outline in seen:
        assert outline.ridge_normal == 0.3
        assert outline.loads == (
            tuple(scene.history.normal_force_N),
            tuple(getattr(scene.history, across)),
        )
