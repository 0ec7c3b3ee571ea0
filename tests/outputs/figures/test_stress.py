"""The picture of Fig 8: it draws what it is given, the same bytes each time, readable at 900 pixels."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from skincad import load
from skincad.mechanics import FilmStress, film_stresses
from skincad.mechanics.film import stress
from skincad.outputs.figures import canvas
from skincad.outputs.figures.stress import band_share, colour_limit, film_stress_figure


@cache
def states() -> tuple[FilmStress, ...]:
    design = load("yamada-2002").with_(ridge={"count": 4}, skin={"width": 6.0})
    with pytest.MonkeyPatch.context() as patch:  # what is drawn need not be accurate
        patch.setattr(stress, "REFINEMENTS", (stress.FilmRefinement(0.3, 2, 1 / 10, 0.5),))
        return film_stresses(design, 2.0, (0.0, 0.5), show=(2, 3))


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Axes], str]:
    """A picture, its axes and its note."""
    drawn: list[Figure] = []
    path = tmp_path_factory.mktemp("drawn") / "stress.png"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(canvas, "FigureCanvasAgg", lambda f: drawn.append(f) or Agg(f))
        canvas.save(film_stress_figure(*states()), path)
    return path, drawn[0].axes, drawn[0].get_supxlabel()


Agg = canvas.FigureCanvasAgg


def test_picture_is_900_wide_and_not_blank(written: tuple[Path, list[Axes], str]) -> None:
    image = Image.open(written[0])
    assert image.size[0] == 900
    assert image.format == "PNG"
    assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 50  # a field, not lines


def test_both_panels_hold_the_numbers(written: tuple[Path, list[Axes], str]) -> None:
    for axes, state in zip(written[1][:2], states(), strict=True):
        for bars, estimates in zip(axes.containers, (state.s1, state.s2, state.differential), strict=True):
            points, _, (spans,) = bars
            assert points.get_ydata() == pytest.approx([e.value for e in estimates], rel=1e-12)
            half = [float(np.ptp(s[:, 1])) / 2 for s in spans.get_segments()]
            assert half == pytest.approx([e.error for e in estimates], rel=1e-9)
    titles = [axes.get_title() for axes in written[1][:6]]
    assert titles[:2] == ["(a) normal force 2 N", "(b) normal 2 N, tangential 0.5 N to +x"]
    assert titles[2:] == ["ridge 2", "ridge 3"] * 2


def test_the_note_tells_the_lean_with_its_figure(written: tuple[Path, list[Axes], str]) -> None:
    share = states()[0].lean_share(2).value
    assert "Outer ridges lean" in written[2]
    assert f"{share:.0%}" in written[2]
    assert "at ridge 2" in written[2]
    assert "Full stick is an assumption" in written[2]


def test_bytes_repeat(written: tuple[Path, list[Axes], str], tmp_path: Path) -> None:
    canvas.save(film_stress_figure(*states()), tmp_path / "again.png")
    assert (tmp_path / "again.png").read_bytes() == written[0].read_bytes()


def test_without_fields_only_the_numbers(tmp_path: Path) -> None:
    bare = [replace(state, fields=()) for state in states()]
    canvas.save(film_stress_figure(bare[0], bare[1]), tmp_path / "bare.png")
    image = Image.open(tmp_path / "bare.png")
    assert image.size == (900, 400)


def test_a_share_far_above_one_is_a_ratio() -> None:
    assert band_share(8.43, 0.87) == "8.43 ± 0.87 times"
    assert band_share(0.31, 0.02) == "31.0% ± 2.0% of"


def test_the_colours_end_where_the_largest_part_of_the_area_lies() -> None:
    """97 % of the area lies within: of areas 96, 2 and 2 the second stress, whichever way triangles lie."""
    corners = np.array([[0.0, 0.0], [1.0, 1.0], [1.0, -1.0]])
    place = np.concatenate([corners * math.sqrt(area) for area in (96.0, 2.0, 2.0)])
    triangles = np.arange(9).reshape(3, 3)
    values = np.repeat([-1.0, 2.0, 5.0], 3)
    assert colour_limit(place, triangles, values) == 2.0
