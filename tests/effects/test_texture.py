"""A plate with a profile: the films' frequency, its depth, and what it does not go with."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from skincad.base import InputError
from skincad.effects import effect
from skincad.inputs import template_text
from skincad.scenes import LEVELS, Simulation, at_level, load_scene
from tests.small_scene import small_scene

Texture = effect("texture")
SLIDE = (
    "history.steps=150",
    "history.time_s=[0.0, 0.02, 0.2]",
    "history.normal_force_N=[0.0, 1.2, 1.2]",
    "history.displacement_mm=[0.0, 0.0, 5.4]",  # 30 mm/s
    "readout.ridges=[1, 2, 3]",
)


def slid(folder: Path, *more: str) -> Simulation:
    return at_level(small_scene(folder, "texture", *SLIDE, *more), LEVELS[0])


@pytest.fixture(scope="module")
def smooth(tmp_path_factory: pytest.TempPathFactory) -> Simulation:
    return slid(tmp_path_factory.mktemp("smooth"), "effects.texture=none")


@pytest.mark.parametrize("wavelength", [0.5, 0.75])
def test_the_films_feel_speed_over_wavelength(wavelength: float, smooth: Simulation, tmp_path: Path) -> None:
    """Within the spectrum's resolution, 1 / 0.1 s; a smooth plate makes no tenth of that swing."""
    rough = slid(tmp_path, f"effects.texture.wavelength={wavelength}")
    assert rough.march.stopped is None
    slides = rough.march.time > 0.1
    dt = rough.march.time[1]
    for ridge in (1, 2, 3):
        felt, plain = (run.raw[ridge][slides] for run in (rough, smooth))
        swing = np.abs(np.fft.rfft((felt - felt.mean()) * np.hanning(felt.size)))
        frequency = np.fft.rfftfreq(felt.size, dt)[swing.argmax()]
        assert frequency == pytest.approx(30 / wavelength, abs=1 / (felt.size * dt))
        assert np.ptp(plain) < 0.1 * np.ptp(felt)


def test_ridges_a_wavelength_apart_rise_together_and_half_of_one_apart_in_turn(tmp_path: Path) -> None:
    """The pitch is 1 mm along the arc; of the outer ridges, for the middle one bears what they do not."""
    normal = {}
    for wavelength in (2.0, 4.0):
        run = slid(tmp_path, f"effects.texture.wavelength={wavelength}", "effects.texture.amplitude=0.005")
        normal[wavelength] = run.march.loads[run.march.time > 0.1, 0]
    together, in_turn = (np.corrcoef(normal[w][:, 0], normal[w][:, 2])[0, 1] for w in (2.0, 4.0))
    assert together > 0.8
    assert in_turn < -0.5


def test_its_depth_is_that_of_the_wave_or_of_the_table() -> None:
    wave = Texture(wavelength=2.0, amplitude=0.1)
    assert wave.depth(np.array([0.0, 0.5, 1.0, 2.0, -1.0])) == pytest.approx([0.0, 0.1, 0.2, 0.0, 0.2])
    teeth = Texture(wavelength=2.0, table=[[0.0, 0.0], [1.0, 0.3]])
    assert teeth.depth(np.array([0.0, 0.5, 1.0, 1.5, 3.0])) == pytest.approx([0.3, 0.15, 0.0, 0.15, 0.0])
    assert (wave.rise, teeth.rise) == (pytest.approx(0.2), pytest.approx(0.3))


@pytest.mark.parametrize(
    ("more", "line"),
    [
        ("effects.viscosity={}", "effects.texture: does not work together with viscosity"),
        (
            "effects.texture.table=[[0.0, 0.0], [0.2, 0.1]]",
            "effects.texture.amplitude: or a table or a file must be given",
        ),
        ("effects.texture.amplitude=none", "effects.texture.amplitude: or a table or a file must be given"),
        ("effects.texture.wavelength=0.0", "effects.texture.wavelength: must be greater than 0"),
    ],
)
def test_what_it_does_not_go_with_is_one_line(more: str, line: str) -> None:
    with pytest.raises(InputError, match=line):
        _ = load_scene("texture", [more]).parts


def test_a_table_must_rise_within_its_period() -> None:
    with pytest.raises(InputError, match="table: needs x that rise from 0 to at most wavelength"):
        Texture(wavelength=1.0, table=[[0.0, 0.0], [1.5, 0.1]])


def test_a_file_is_found_beside_its_scene_and_means_its_table(tmp_path: Path) -> None:
    (tmp_path / "teeth.csv").write_text("x_mm;out_mm\n0;0\n1,0;0,3\n")
    table = "wavelength = 2.0\nfile = 'teeth.csv'\n"
    head, _, tail = template_text("texture", "scenes").partition("[effects.texture]\n")
    rest = tail.partition("[readout]")[2]
    (tmp_path / "mine.toml").write_text(f"{head}[effects.texture]\n{table}[readout]{rest}")
    part = load_scene(tmp_path / "mine.toml").parts["texture"]
    assert isinstance(part, Texture)
    at = np.linspace(-1.0, 3.0, 9)
    assert part.depth(at) == pytest.approx(Texture(wavelength=2.0, table=[[0.0, 0.0], [1.0, 0.3]]).depth(at))


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("x_mm,out_mm\n0,0\n0,1\n", "file: needs x that rise"),
        ("x_mm,out_mm\n0,0\n1,11\n", "file: must come out by at most 10 mm, got 11"),
        ("x_mm\n0\n1\n", "must have the columns x_mm and out_mm"),
        ("a,b\n0,0\n", "has no row that names its columns"),
    ],
)
def test_a_file_that_is_no_profile_is_one_line(text: str, line: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=line):
        Texture(wavelength=2.0, file=str(path))
