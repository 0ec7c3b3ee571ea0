"""Figures hold the numbers of their result: checks, gains, models, sensitivities, film stress, recordings."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

import skincad
from skincad.base import Estimate
from skincad.circuit import CircuitGain, gain, load_circuit
from skincad.inputs import Design
from skincad.mechanics import FilmStress, Sensitivity, film_stresses
from skincad.mechanics.film import stress
from skincad.outputs import Axes, gain_figure, save
from skincad.outputs.figures import canvas, results, scenes
from skincad.outputs.figures import stress as film_pictures


def test_each_ridge_has_its_bar_and_the_mean_is_a_line(yamada: Design) -> None:
    result = skincad.check(yamada, model="winkler")
    figure = result.figure("ridge-forces.png")
    (axes,) = figure.axes
    bars = axes.patches
    assert [bar.get_x() + bar.get_width() / 2 for bar in bars] == pytest.approx(range(1, 10))
    assert [bar.get_height() for bar in bars] == pytest.approx([f.value for f in result.ridge_force])
    (errors,) = axes.collections
    half = [float(np.ptp(segment[:, 1])) / 2 for segment in errors.get_segments()]
    assert half == pytest.approx([f.error for f in result.ridge_force])
    mean = next(line for line in axes.lines if line.get_label() == "mean")
    assert list(mean.get_ydata()) == pytest.approx([4.0 / 9] * 2)
    assert list(axes.get_xticks()) == list(range(1, 10))
    assert (
        figure.get_suptitle() == f"yamada-2002: 9 of 9 touch at 4 N; all touch from {result.all_touch_force}"
    )


@pytest.mark.parametrize(("count", "named"), [(20, True), (21, False)])
def test_many_ridges_are_not_each_named_and_no_force_is_told_where_none_does(count: int, named: bool) -> None:
    share = (Estimate(0.2, None, "N"), *(Estimate(None, None, "N"),) * (count - 1))
    shown = skincad.check(skincad.load("yamada-2002"), model="winkler")
    never = replace(shown, ridges=count, ridge_force=share, all_touch_force=Estimate(None, None, "N"))
    figure = never.figure("ridge-forces.png")
    (axes,) = figure.axes
    assert (list(axes.get_xticks()) == list(range(1, count + 1))) == named
    assert [bar.get_height() for bar in axes.patches] == [0.2, *[0.0] * (count - 1)]
    assert "all touch" not in figure.get_suptitle()


def test_each_model_is_a_point_with_its_name() -> None:
    models = [("winkler", 4e-4, 0.8), ("linear", 0.7, 0.45), ("corrected", 2.8, 0.14)]
    (axes,) = results.models_figure(models).axes
    before, last = (np.asarray(collection.get_offsets()) for collection in axes.collections)
    assert np.vstack([before, last]) == pytest.approx(np.array([model[1:] for model in models]))
    assert [text.get_text() for text in axes.texts] == [name for name, *_ in models]
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")


def test_no_models_name_lies_on_another_or_on_a_point() -> None:
    """As gripper-pad has them: the last two errors are nearly the same."""
    models = [("winkler", 4e-4, 1.1), ("linear", 1.4, 0.69), ("corrected", 5.9, 0.35)]
    figure = results.models_figure([*models, ("corrected-finite-strain", 15.0, 0.31)])
    (axes,) = figure.axes
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in axes.texts]
    points = axes.transData.transform([(time, error) for _, time, error in models])
    for i, box in enumerate(boxes):
        assert box.count_overlaps(boxes) == 1, axes.texts[i].get_text()  # itself
        assert not any(box.contains(*point) for point in points)
        assert axes.bbox.x0 < box.x0 < box.x1 < axes.bbox.x1


def test_each_key_is_a_bar_the_first_one_on_top() -> None:
    sensitivities = [
        Sensitivity("ridge.pitch", 1.0, "mm", Estimate(0.05, 0.02, "N")),
        Sensitivity("skin.thickness", 4.0, "mm", Estimate(-0.02, 0.01, "N")),
    ]
    (axes,) = results.sensitivity_figure(sensitivities).axes
    assert [bar.get_width() for bar in axes.patches] == [0.05, -0.02]
    assert axes.patches[0].get_y() > axes.patches[1].get_y()
    assert [label.get_text() for label in axes.get_yticklabels()] == ["ridge.pitch", "skin.thickness"]


@cache
def of(name: str) -> CircuitGain:
    return gain(load_circuit(name))


def lines(circuit_gain: CircuitGain) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    axes: Axes = gain_figure(circuit_gain).axes[0]
    assert axes.get_xscale() == "log"
    return {str(line.get_label()): np.array(line.get_data(), dtype=float) for line in axes.lines}


def slope(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.diff(y) / np.diff(np.log10(x))


def starting(drawn: dict[str, tuple[np.ndarray, np.ndarray]], words: str) -> tuple[np.ndarray, np.ndarray]:
    (curve,) = (data for label, data in drawn.items() if label.startswith(words))
    return curve


def test_the_fitted_lines_meet_at_the_cut_off_and_span_the_fitted_range() -> None:
    circuit_gain = of("transimpedance")
    assert np.array(starting(lines(circuit_gain), "network")) == pytest.approx(
        np.array([circuit_gain.frequency, circuit_gain.gain])
    )
    circuit_gain = of("yamada-2002")
    assert circuit_gain.own is not None
    drawn, slopes = lines(circuit_gain), circuit_gain.slopes
    film_gain = np.array([circuit_gain.frequency, circuit_gain.own.gain])
    assert np.array(starting(drawn, "network alone")) == pytest.approx(film_gain)
    assert np.array(starting(drawn, "network and rig")) == pytest.approx(
        np.array([circuit_gain.frequency, circuit_gain.gain])
    )
    x, y = starting(drawn, "fitted")
    assert x == pytest.approx(
        [circuit_gain.frequency[0], slopes.cutoff.value, circuit_gain.circuit.sweep.fit_high]
    )
    assert y[1] == pytest.approx(slopes.level)
    assert slope(x, y) == pytest.approx([slopes.below.value, slopes.above.value])


@pytest.mark.parametrize("name", ["yamada-2002", "yamada-2002-motional"])
def test_the_papers_lines_have_its_slopes_and_the_curves_mean_level(name: str) -> None:
    """20 dB a decade up to 1.2 kHz and 60 dB above, from 10 Hz to 8 kHz, and a drop at 9 kHz."""
    circuit_gain = of(name)
    drawn = lines(circuit_gain)
    x, y = starting(drawn, "paper: 20")
    assert list(x) == [10.0, 1200.0, 8000.0]
    assert slope(x, y) == pytest.approx([20.0, 60.0])
    inside = circuit_gain.frequency <= 8000.0
    at = circuit_gain.frequency[inside]
    line = y[1] + np.where(at < 1200.0, 20.0, 60.0) * np.log10(at / 1200.0)
    assert np.mean(circuit_gain.gain[inside] - line) == pytest.approx(0.0, abs=1e-9)
    assert list(starting(drawn, "paper: drop at 9 kHz")[0]) == [9000.0, 9000.0]
    other = of("transimpedance")
    assert not any(label.startswith("paper") for label in lines(other))


def test_without_a_cut_off_one_line_goes_through_the_fitted_ranges_middle() -> None:
    circuit_gain = of("yamada-2002")
    none = Estimate(None, None, "Hz")
    slopes = replace(circuit_gain.slopes, cutoff=none, above=circuit_gain.slopes.below)
    drawn = lines(replace(circuit_gain, slopes=slopes))
    x, y = starting(drawn, "fitted")
    sweep = circuit_gain.circuit.sweep
    assert x[1] == pytest.approx(np.sqrt(sweep.low * sweep.fit_high))
    assert slope(x, y) == pytest.approx([slopes.below.value] * 2)


def test_data_are_drawn_without_the_offset_that_was_fitted() -> None:
    circuit_gain = of("yamada-2002")
    measured = SimpleNamespace(frequency=np.array([20.0, 200.0]), gain=np.array([3.0, 5.0]))
    fitted = replace(circuit_gain, measured=measured, calibration=SimpleNamespace(offset=-12.5))
    x, y = starting(lines(fitted), "measured, +12.5 dB")
    assert (list(x), list(y)) == ([20.0, 200.0], [15.5, 17.5])


@cache
def states() -> tuple[FilmStress, ...]:
    design = skincad.load("yamada-2002").with_(ridge={"count": 3}, skin={"width": 5.0})
    with pytest.MonkeyPatch.context() as patch:  # what is drawn need not be accurate
        patch.setattr(stress, "REFINEMENTS", (stress.MeshRefinement(0.3, 2, tip=1 / 10, grading=0.5),))
        return film_stresses(design, 2.0, (0.0, 0.5), show=(1, 2))


@pytest.fixture(scope="module")
def drawn() -> canvas.Picture:
    """The picture of Fig 8."""
    return film_pictures.film_stress_figure(*states())


@pytest.mark.slow
def test_a_film_stress_picture_is_900_wide_not_blank_and_the_same_again(
    drawn: canvas.Picture, tmp_path: Path
) -> None:
    for name, figure in (("a.png", drawn), ("b.png", film_pictures.film_stress_figure(*states()))):
        save(figure, tmp_path / name)
    image = Image.open(tmp_path / "a.png")
    assert image.size[0] == 900
    assert image.format == "PNG"
    assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 50  # a field, not lines
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_both_panels_hold_the_numbers(drawn: canvas.Picture) -> None:
    for axes, state in zip(drawn.axes[:2], states(), strict=True):
        for bars, estimates in zip(axes.containers, (state.s1, state.s2, state.differential), strict=True):
            points, _, (spans,) = bars
            assert points.get_ydata() == pytest.approx([e.value for e in estimates], rel=1e-12)
            half = [float(np.ptp(s[:, 1])) / 2 for s in spans.get_segments()]
            assert half == pytest.approx([e.error for e in estimates], rel=1e-9)
    titles = [axes.get_title() for axes in drawn.axes[:6]]
    assert titles[:2] == ["(a) normal force 2 N", "(b) normal 2 N, tangential 0.5 N to +x"]
    assert titles[2:] == ["ridge 1", "ridge 2"] * 2


def test_the_note_tells_the_lean_with_its_figure(drawn: canvas.Picture) -> None:
    note, share = drawn.get_supxlabel(), states()[0].lean_share(1).value
    assert "Outer ridges lean" in note
    assert f"{share:.0%}" in note
    assert "at ridge 1" in note
    assert "Full stick is an assumption" in note


def test_without_fields_only_the_numbers(tmp_path: Path) -> None:
    bare = [replace(state, fields=()) for state in states()]
    save(film_pictures.film_stress_figure(bare[0], bare[1]), tmp_path / "bare.png")
    assert Image.open(tmp_path / "bare.png").size == (900, 400)


def test_a_share_far_above_one_is_a_ratio() -> None:
    assert film_pictures.band_share(8.43, 0.87) == "8.43 ± 0.87 times"
    assert film_pictures.band_share(0.31, 0.02) == "31.0% ± 2.0% of"


def test_the_colours_end_where_the_largest_part_of_the_area_lies() -> None:
    """97 % of the area lies within: of areas 96, 2 and 2 the second stress, whichever way triangles lie."""
    corners = np.array([[0.0, 0.0], [1.0, 1.0], [1.0, -1.0]])
    place = np.concatenate([corners * math.sqrt(area) for area in (96.0, 2.0, 2.0)])
    triangles = np.arange(9).reshape(3, 3)
    values = np.repeat([-1.0, 2.0, 5.0], 3)
    assert film_pictures.colour_limit(place, triangles, values) == 2.0


def scene(rate: float = 1300.0, sampling: float | None = 650.0, **changes: Any) -> Any:
    """A second of outputs of ridges 2 and 3: a slow sine, and a fast one that 650 Hz does not show."""
    time = np.arange(int(rate) + 1) / rate
    slow, fast = np.sin(2 * np.pi * 5.0 * time), np.sin(2 * np.pi * 600.0 * time)
    outputs = {
        r: {"S1": slow.tolist(), "S2": (-slow).tolist(), "pair": (2 * slow + fast).tolist()} for r in "23"
    }
    read = {
        "output_V": outputs,
        "sampling_Hz": sampling,
        "circuit": "mine",
        "signal_to_noise_dB": {"3": 20.0},
    }
    half = int(rate / 2)
    fields = {
        "read": read,
        "march": SimpleNamespace(time=time, column=lambda _: np.maximum(time - 0.2, 0.0)),
        "scene": SimpleNamespace(name="made-up", readout=SimpleNamespace(bandwidth_Hz=160.0)),
        "slip_steps": [None, half - 100, half, *6 * [None]],
        "gross_slip_step": half + 200,
    }
    return SimpleNamespace(**{**fields, **changes})


def test_it_is_ridge_3_at_the_recorders_rate_without_what_would_fold_back() -> None:
    seen = scenes.recording(scene())
    assert seen is not None
    assert (seen.ridge, seen.pair.rate) == (3, 650.0)
    at = np.arange(seen.pair.values.size) / 650.0
    middle = slice(65, -65)  # beyond the filter's ends
    exact = 2 * np.sin(2 * np.pi * 5.0 * at)
    # 600 Hz would fold to 50 Hz at full size; 80 dB of filter leave 1e-4, its ripple 1e-3
    assert np.abs(seen.pair.values - exact)[middle].max() < 3e-3


@pytest.mark.parametrize(
    "simulation",
    [
        scene(sampling=None),
        scene(rate=500.0),  # the march's steps are coarser than the recorder's
        scene(sampling=40.0),  # a second has 40 samples
        scene(sampling=649.99999),
    ],
)
def test_what_no_recorder_samples_is_drawn_at_the_runs_steps(simulation: Any) -> None:
    seen = scenes.recording(simulation)
    assert seen is not None
    assert not seen.sampled
    assert np.array_equal(seen.pair.values, simulation.read["output_V"]["3"]["pair"])
    assert "Steps are" in scenes.caption(simulation, seen)


def test_without_outputs_nothing_is_drawn() -> None:
    assert scenes.recording(scene(read={})) is None


def test_the_phases_are_the_papers() -> None:
    spans = scenes.phases(scene(), 3)
    assert list(spans) == ["$P_A$", "$P_B$"]
    (start, slip), (again, end) = spans.values()
    assert start == pytest.approx(0.2, abs=2e-3)  # a thousandth of the largest pull
    assert slip == again == pytest.approx(0.5)
    assert end == pytest.approx(0.5 + 200 / 1300)
    assert scenes.phases(scene(slip_steps=9 * [None]), 3) == {}


def test_the_caption_says_what_is_not_seen() -> None:
    simulation = scene()
    seen = scenes.recording(simulation)
    assert seen is not None
    text = scenes.caption(simulation, seen)
    assert "True up to 160 Hz: neither the cut-off at 1.2 kHz" in text
    assert "Samples are 1.54 ms apart: no shorter lead time is claimed." in text
    assert "20 dB" in text
    assert "of the signal's power lies above 260 Hz" in text
    wide = scene(rate=20000.0, sampling=10000.0)
    wide.scene.readout.bandwidth_Hz = 2000.0
    record = scenes.recording(wide)
    assert record is not None
    assert "1.2 kHz" not in scenes.caption(wide, record)


@pytest.mark.slow
def test_the_picture_is_drawn(tmp_path: Path) -> None:
    simulation = scene()
    seen = scenes.recording(simulation)
    assert seen is not None
    save(scenes.recording_figure(simulation, seen), tmp_path / "one.png")
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")
    save(
        scenes.recording_figure(scene(gross_slip_step=None, slip_steps=9 * [None]), seen),
        tmp_path / "other.png",
    )
