"""What is read of a march: steps that are kept, drawn and animated, and what effects add to it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from skincad.effects import Reader
from skincad.mechanics import DeformedSection
from skincad.outputs import COLOURS, FRAME_WIDTH, Moment, moments_limit, section_animation, section_picture
from skincad.scenes import LEVELS, Simulation, at_level, frames, simulation
from tests.small_scene import make_up_effects, small_scene

SCENE = "yamada-2002-press-and-pull"


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Simulation:
    folder = tmp_path_factory.mktemp("small")
    forces = ("history.normal_force_N=[0.0, 1.3, 1.3]", "history.tangential_force_N=[0.0, 0.0, 0.4]")
    drawn = ("readout.steps=[4, 2]", "readout.frames=3", "readout.ridges=[2]")
    return at_level(small_scene(folder, SCENE, "history.steps=4", *forces, *drawn), LEVELS[0])


@pytest.mark.parametrize(
    ("steps", "number", "wanted"), [(40, 3, [0, 20, 40]), (40, 0, []), (4, 50, [0, 1, 2, 3, 4])]
)
def test_frames_are_spread_evenly(steps: int, number: int, wanted: list[int], tmp_path: Path) -> None:
    """No more than there are states."""
    named = (f"history.steps={steps}", "readout.ridges=[]", f"readout.frames={number}")
    assert frames(small_scene(tmp_path, SCENE, *named)) == wanted


def test_states_of_kept_steps_are_those_marched(shown: Simulation) -> None:
    """What touches the plate is at its height: it rests on the ridges, and nothing is above."""
    march = shown.march
    assert set(march.states) == {0, 2, 4}
    for step, state in march.states.items():
        assert state.approach == march.readings[step].approach
        assert state.normal.sum() == pytest.approx(march.readings[step].normal, abs=1e-12)
        if step:
            section = march.pad.shown(state)
            # a crown between contact points is up to 1e-3 of the unit above it
            assert (section.place + section.shift)[:, 1].max() == pytest.approx(section.plate, abs=1e-3)


def moments(simulation: Simulation) -> list[Moment]:
    march = simulation.march
    return [(f"step {i}", march.pad.shown(s)) for i, s in sorted(march.states.items())]


def test_a_section_is_drawn_with_its_plate(shown: Simulation, tmp_path: Path) -> None:
    section_picture(moments(shown)[-1], tmp_path / "section.png")
    picture = np.asarray(Image.open(tmp_path / "section.png").convert("RGB")).reshape(-1, 3)
    plate, film = (np.abs(picture.astype(int) - c).max(axis=1) <= 8 for c in (0x9A, 0x11))
    # share of the picture: the plate is a band of a tenth, the films are thin
    assert 0.03 < plate.mean() < 0.3
    assert 1e-4 < film.mean() < 0.05


def test_an_animation_has_its_frames_and_few_colours(shown: Simulation, tmp_path: Path) -> None:
    section_animation(moments(shown), tmp_path / "section.gif")
    with Image.open(tmp_path / "section.gif") as picture:
        assert picture.n_frames == 3
        assert picture.width == FRAME_WIDTH
        picture.seek(0)
        assert len(picture.convert("RGB").getcolors(256) or []) <= COLOURS
    # 60 frames, the most, of the nine ridges are 1.0 MB
    assert (tmp_path / "section.gif").stat().st_size < 2_000_000 / 60 * 3


def test_colours_are_one_scale_for_all_frames() -> None:
    place, none = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), np.zeros(1, dtype=bool)

    def stressed(stress: float) -> Moment:
        stresses, triangle = np.full((3, 4), stress), np.array([[0, 1, 2]])
        return "", DeformedSection(place, 0 * place, stresses, triangle, none, 1.0, 0.0)

    assert moments_limit([stressed(-2.0), stressed(1.0)]) == pytest.approx(2.0)
    assert moments_limit([stressed(0.0)]) > 0


PRESS = ("history.steps=1", "readout.ridges=[]", "effects.film=none", "effects.friction=none")


class One(Reader):
    """A reader."""

    key: str = "one"

    def read(self, watched: Any, time: Any, readings: Any) -> dict[str, Any]:  # noqa: ARG002
        return {self.key: len(readings), "warnings": [f"{self.key} is made up"]}


class Other(One):
    """Another."""

    key: str = "other"


@pytest.fixture
def _made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    make_up_effects(monkeypatch, One, Other)


def read(folder: Path, *tables: str) -> Simulation:
    return at_level(small_scene(folder, "yamada-2002-press", *PRESS, *tables), LEVELS[0])


@pytest.mark.usefixtures("_made_up")
def test_two_readers_tell_side_by_side(tmp_path: Path) -> None:
    result = read(tmp_path, "effects.other={}", "effects.one={}")
    assert list(result.read.items()) == [("other", 2), ("one", 2)]  # as they are named
    assert result.as_json()["other"] == 2
    assert {"one is made up", "other is made up"} <= set(result.warnings)
    assert {"effect one", "effect other"} <= result.seconds.keys()


@pytest.mark.usefixtures("_made_up")
def test_a_reader_may_not_overwrite_what_another_or_the_march_tells(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"effects\.other gives 'one', which effects\.one gives already"):
        read(tmp_path, "effects.one={}", "effects.other.key=one")
    for key in ("time_s", "energy"):
        with pytest.raises(ValueError, match=f"gives '{key}' twice: rename one of them"):
            read(tmp_path, f"effects.one.key={key}").as_json()


@pytest.mark.usefixtures("_made_up")
def test_what_follows_has_keys_of_its_own_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def half(readings: Any, *_: Any) -> dict[str, Any]:
        return {"half": readings["one"] / 2}

    monkeypatch.setitem(simulation.FOLLOWING, "one", half)
    assert read(tmp_path, "effects.one={}").read == {"one": 2, "half": 1.0}
    taken = r"what follows one gives 'half', which effects\.other gives already"
    with pytest.raises(ValueError, match=taken):
        read(tmp_path, "effects.one={}", "effects.other.key=half")
