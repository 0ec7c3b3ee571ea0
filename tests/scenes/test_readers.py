"""What effects read of a march: keys of their own, and what follows from them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from skincad.effects import Reader
from skincad.scenes import LEVELS, at_level, simulation
from skincad.scenes.simulation import joined
from tests.small_scene import make_up_effects, small_scene

PRESS = ("history.steps=1", "readout.ridges=[]", "effects.film=none", "effects.friction=none")


class One(Reader):
    """A reader."""

    key: str = "one"

    def read(self, watched: Any, time: Any, readings: Any) -> dict[str, Any]:  # noqa: ARG002
        return {self.key: len(readings), "warnings": [f"{self.key} is made up"]}


class Other(One):
    """Another."""

    key: str = "other"


@pytest.fixture(autouse=True)
def made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    make_up_effects(monkeypatch, One, Other)


def test_two_readers_tell_side_by_side(tmp_path: Path) -> None:
    scene = small_scene(tmp_path, "yamada-2002-press", *PRESS, "effects.one={}", "effects.other={}")
    simulation = at_level(scene, LEVELS[0])
    assert simulation.read == {"one": 2, "other": 2}
    assert simulation.as_json()["other"] == 2
    assert {"one is made up", "other is made up"} <= set(simulation.warnings)
    assert {"effect one", "effect other"} <= simulation.seconds.keys()


def test_a_reader_may_not_overwrite_what_another_tells(tmp_path: Path) -> None:
    tables = ("effects.one={}", "effects.other.key=one")
    scene = small_scene(tmp_path, "yamada-2002-press", *PRESS, *tables)
    with pytest.raises(ValueError, match=r"effects\.other gives 'one', which effects\.one gives already"):
        at_level(scene, LEVELS[0])


@pytest.mark.parametrize("key", ["time_s", "energy"])
def test_a_reader_may_not_overwrite_what_the_march_tells(key: str, tmp_path: Path) -> None:
    scene = small_scene(tmp_path, "yamada-2002-press", *PRESS, f"effects.one.key={key}")
    simulation = at_level(scene, LEVELS[0])
    with pytest.raises(ValueError, match=f"gives '{key}' twice: rename one of them"):
        simulation.as_json()


def test_what_follows_has_keys_of_its_own_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def half(readings: Any, *_: Any) -> dict[str, Any]:
        return {"half": readings["one"] / 2}

    monkeypatch.setitem(simulation.FOLLOWING, "one", half)
    scene = small_scene(tmp_path, "yamada-2002-press", *PRESS, "effects.one={}")
    assert at_level(scene, LEVELS[0]).read == {"one": 2, "half": 1.0}
    scene = small_scene(tmp_path, "yamada-2002-press", *PRESS, "effects.one={}", "effects.other.key=half")
    with pytest.raises(
        ValueError, match=r"what follows one gives 'half', which effects\.other gives already"
    ):
        at_level(scene, LEVELS[0])


def test_keys_are_joined_in_the_order_in_which_they_are_told() -> None:
    assert list(joined({"a": {"z": 1}, "b": {"y": 2, "x": 3}})) == ["z", "y", "x"]
