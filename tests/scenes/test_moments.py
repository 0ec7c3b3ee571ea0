"""Steps that are kept, drawn and animated; sections as pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from skincad.mechanics import DeformedSection
from skincad.outputs import COLOURS, FRAME_WIDTH, Moment, section_animation, section_picture
from skincad.scenes import LEVELS, Simulation, at_level, frames
from skincad.scenes.march import kept_steps
from tests.small_scene import small_scene

SCENE = "yamada-2002-press-and-pull"
FORCES = ("history.normal_force_N=[0.0, 1.3, 1.3]", "history.tangential_force_N=[0.0, 0.0, 0.4]")

FORTY = (SCENE, "history.steps=40", "readout.ridges=[]")


@pytest.fixture(scope="module")
def simulation(tmp_path_factory: pytest.TempPathFactory) -> Simulation:
    folder = tmp_path_factory.mktemp("small")
    drawn = ("readout.steps=[4, 2]", "readout.frames=3", "readout.ridges=[2]")
    return at_level(small_scene(folder, SCENE, "history.steps=4", *FORCES, *drawn), LEVELS[0])


def test_named_steps_and_frames_are_kept(tmp_path: Path) -> None:
    scene = small_scene(tmp_path, *FORTY, "readout.steps=[7]", "readout.frames=3")
    assert frames(scene) == [0, 20, 40]
    assert kept_steps(scene) == {0, 7, 20, 40}
    plain = small_scene(tmp_path, *FORTY)
    assert frames(plain) == []
    assert kept_steps(plain) == frozenset()


def test_states_of_kept_steps_are_those_marched(simulation: Simulation) -> None:
    assert set(simulation.march.states) == {0, 2, 4}
    for step, state in simulation.march.states.items():
        assert state.approach == simulation.march.readings[step].approach
        assert state.normal.sum() == pytest.approx(simulation.march.readings[step].normal, abs=1e-12)


def moments(simulation: Simulation) -> list[Moment]:
    return [
        Moment(f"step {i}", simulation.march.pad.shown(s)) for i, s in sorted(simulation.march.states.items())
    ]


def test_what_touches_the_plate_is_at_its_height(simulation: Simulation) -> None:
    """The drawn section under the drawn plate: it rests on the ridges, and nothing is above."""
    for moment in moments(simulation)[1:]:
        shown = moment.shown
        height = (shown.place + shown.shift)[:, 1].max()
        # a crown between contact points is up to 1e-3 of the unit above it
        assert height == pytest.approx(shown.plate, abs=1e-3)


def test_a_section_is_drawn_with_its_plate(simulation: Simulation, tmp_path: Path) -> None:
    section_picture(moments(simulation)[-1], tmp_path / "section.png")
    picture = np.asarray(Image.open(tmp_path / "section.png").convert("RGB")).reshape(-1, 3)
    plate, film = (np.abs(picture.astype(int) - c).max(axis=1) <= 8 for c in (0x9A, 0x11))
    # share of the picture: the plate is a band of a tenth, the films are thin
    assert 0.03 < plate.mean() < 0.3
    assert 1e-4 < film.mean() < 0.05


def test_an_animation_has_its_frames_and_few_colours(simulation: Simulation, tmp_path: Path) -> None:
    section_animation(moments(simulation), tmp_path / "section.gif")
    with Image.open(tmp_path / "section.gif") as picture:
        assert picture.n_frames == 3
        assert picture.width == FRAME_WIDTH
        picture.seek(0)
        assert len(picture.convert("RGB").getcolors(256) or []) <= COLOURS
    # 60 frames, the most, of the nine ridges are 1.0 MB
    assert (tmp_path / "section.gif").stat().st_size < 2_000_000 / 60 * 3


def test_colours_are_one_scale_for_all_frames() -> None:
    from skincad.outputs import moments_limit

    place = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])

    def shown(stress: float) -> Moment:
        stresses = np.full((3, 4), stress)
        return Moment(
            "",
            DeformedSection(
                place, 0 * place, stresses, np.array([[0, 1, 2]]), np.zeros(1, dtype=bool), 1.0, 0.0
            ),
        )

    assert moments_limit([shown(-2.0), shown(1.0)]) == pytest.approx(2.0)
    assert moments_limit([shown(0.0)]) > 0


def test_an_animation_has_no_more_frames_than_there_are_states(tmp_path: Path) -> None:
    few = small_scene(tmp_path, SCENE, "history.steps=4", "readout.ridges=[]", "readout.frames=50")
    assert frames(few) == [0, 1, 2, 3, 4]
