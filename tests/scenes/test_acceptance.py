"""A recording of the films: dead, reversed and swapped strips, and what it can't tell; the command."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from bench.table_recordings import judged
from skincad.base import InputError
from skincad.inputs import FilmRecording, film_recording
from skincad.scenes import (
    CANT_TELL,
    RecordingAcceptance,
    acceptance,
    judge,
    recorded_scene,
    strip_assignment,
    strip_posterior,
)
from tests.conftest import run_skincad
from tests.refusals import refused, refused_command
from tests.scenes.recordings import DELAY, prediction, recording, scene, text

pytestmark = pytest.mark.xdist_group("scenes/test_acceptance.py")  # one prediction for all
NAMES = [f"ridge {r} S{s}" for r in (1, 2, 3) for s in (1, 2)]


def judged_recording(**faults: object) -> RecordingAcceptance:
    return judge(scene(), prediction(), recording(**faults))


def press_alone(made: FilmRecording) -> FilmRecording:
    pressed = made.time <= DELAY + prediction().press_end
    return FilmRecording(made.strips, made.time[pressed], made.volts[:, pressed])


@pytest.mark.slow
def test_all_work() -> None:
    result = judged_recording()
    assert {strip.state for strip in result.strips} == {"works"}
    assert result.passed
    assert result.exit_status == 0
    # the charge scales with the modulus, and gains are 0.7 in the middle
    assert result.common_gain.value == pytest.approx(0.7, rel=0.2)
    assert result.delay.value == pytest.approx(DELAY, abs=0.004)  # a few cells of the press
    assert result.pull


SWAPPED = {0: f"swapped with {NAMES[3]}", 3: f"swapped with {NAMES[0]}"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("faults", "wrong"),
    [
        ({"dead": 0}, {0: "dead"}),
        ({"dead": 3}, {3: "dead"}),
        ({"reversed_": 1}, {1: "reversed"}),
        ({"swapped": (0, 3)}, SWAPPED),
    ],
)
def test_a_fault_is_named_and_the_others_work(faults: dict[str, object], wrong: dict[int, str]) -> None:
    result = judged_recording(**faults)
    assert {i: strip.state for i, strip in enumerate(result.strips) if strip.state != "works"} == wrong
    assert [strip.name for strip in result.strips] == NAMES
    assert result.exit_status == 1
    if "reversed_" in faults:
        assert result.strips[1].gain.value < -0.5


@pytest.mark.slow
def test_a_channel_of_zeros_is_dead() -> None:
    made = recording()
    made.volts[2] = 0.0
    assert judge(scene(), prediction(), made).strips[2].state == "dead"


@pytest.mark.slow
def test_a_press_alone_tells_less() -> None:
    """Mirrored strips are alike in it, and of two that are swapped it is never said to be sure."""
    alone, whole = judge(scene(), prediction(), press_alone(recording())), judged_recording()
    assert not alone.pull
    assert "ridge 3 S2" in alone.strips[0].alike
    assert "ridge 3 S2" not in whole.strips[0].alike
    made = recording(swapped=(2, 5))
    alone = judge(scene(), prediction(), press_alone(made))
    assert alone.strips[2].shows == NAMES[5]
    assert alone.strips[2].probability == 0.95
    assert judge(scene(), prediction(), made).strips[2].probability > 0.95


@pytest.mark.slow
def test_ridges_that_change_places_crosswise_are_not_told_by_a_press_alone() -> None:
    """A press on a crest that is lower than its mirror image shows the same; a pull after it tells."""
    loud = np.array([1.5, 1.5, 1.0, 1.0, 0.7, 0.7])[:, None]
    uneven = replace(prediction(), worlds=prediction().worlds * loud, changes=prediction().changes * loud)
    made = recording()
    crossed = FilmRecording(made.strips, made.time, (made.volts * loud)[[5, 4, 2, 3, 1, 0]])
    alone = judge(scene(), uneven, press_alone(crossed))
    cant = [CANT_TELL] * 2
    assert [strip.state for strip in alone.strips] == [*cant, "works", "works", *cant]
    shown = [NAMES[5], NAMES[4], None, None, NAMES[1], NAMES[0]]
    assert [strip.shows for strip in judge(scene(), uneven, crossed).strips] == shown


@pytest.mark.slow
def test_millivolts_and_a_scene_without_circuit_are_refused() -> None:
    made = recording()
    with refused("must be in volts"):
        judge(scene(), prediction(), FilmRecording(made.strips, made.time, 1000 * made.volts))
    with pytest.raises(InputError, match=r"effects\.piezo: is missing"):
        recorded_scene(scene().with_(effects={"piezo": None}))


@pytest.mark.slow
def test_the_press_ends_where_the_force_stops_growing() -> None:
    assert prediction().press_end == 0.1


def test_means_of_cells_are_those_of_straight_lines() -> None:
    time, edges = np.array([0.0, 1.0, 3.0]), np.array([0.0, 0.5, 2.0])
    means = strip_assignment.cell_means(time, np.array([[0.0, 2.0, 2.0]]), edges)
    assert means[0] == pytest.approx([0.5, (0.75 + 2.0) / 1.5])


@pytest.mark.evidence(subject="seeds: recordings")
def test_most_recordings_of_the_exam_are_judged_right(tmp_path: Path) -> None:
    """Of the seeds on which thresholds were chosen, in one scene."""
    scenes = ["press", "press and pull", "fast pull", "lab bench"]
    drawn = [s for s in range(22000, 22040) if np.random.default_rng(s).choice(scenes) == scenes[1]]
    worth = [answer for seed in drawn if (answer := judged(seed, tmp_path)[2])]
    assert worth.count("right") >= 0.9 * len(worth)
    assert len(worth) >= 5


RANK, NOISE, GAIN = 6, 0.01, 0.8
HUM = np.zeros((RANK, 1))


def model(mean: np.ndarray, shared: np.ndarray) -> strip_assignment.SignalModel:
    """Two strips of one ridge, without offset or drift, whose own spread is none."""
    zero, edges = np.zeros((2, RANK, RANK)), np.linspace(0.0, 1.0, RANK + 1)
    return strip_assignment.SignalModel(edges, np.eye(RANK), np.zeros((RANK, 2)), mean, zero, shared)


def posterior(mean: np.ndarray, shared: np.ndarray, parts: np.ndarray, starts: tuple[int, int] = (0, 1)):
    noise = np.full(2, NOISE)
    return strip_posterior.posterior(model(mean, shared), parts, noise, HUM, GAIN, np.array(starts))


def nearly_alike() -> tuple[np.ndarray, np.ndarray]:
    draw = np.random.default_rng(3)
    common = draw.normal(0.0, 1.0, RANK)
    mean = np.stack([common, common + draw.normal(0.0, 0.05, RANK)])
    moved = draw.normal(0.0, 0.2, RANK)
    return mean, np.stack([np.stack([moved, 1.02 * moved])])


def log_density(parts: np.ndarray, order: list[int], mean: np.ndarray, shared: np.ndarray) -> float:
    """Of both channels at once, by their whole covariance `(2 rank, 2 rank)`."""
    way = GAIN * shared[:, order].reshape(len(shared), -1)
    covariance = way.T @ way
    for c, strip in enumerate(order):
        at = slice(c * RANK, (c + 1) * RANK)
        own = (NOISE**2 + strip_posterior.OWN_FLOOR**2 / RANK * (parts[c] @ parts[c])) * np.eye(RANK)
        covariance[at, at] += own + (GAIN * strip_assignment.SCATTER) ** 2 * np.outer(
            mean[strip], mean[strip]
        )
    return float(multivariate_normal.logpdf(parts.ravel(), GAIN * mean[order].ravel(), covariance))


def test_the_odds_of_a_swap_are_those_of_the_whole_normal_distribution() -> None:
    mean, shared = nearly_alike()
    parts = GAIN * (mean + 0.4 * (mean[::-1] - mean))  # nearer to works
    channel = posterior(mean, shared, parts).channels[0]
    chances = dict(channel)
    odds = chances["works", None, 1] / chances["swapped", 1, 1]
    expected = log_density(parts, [0, 1], mean, shared) - log_density(parts, [1, 0], mean, shared)
    # one pair of strips: all swaps are of it, but half of their prior goes to pairs of other ridges
    expected += 2 * np.log(strip_assignment.PRIOR["works"]) - np.log(strip_assignment.SWAP_PRIOR / 2)
    # 1e-3: assignments with a strip that is weak or reversed count in both chances, by less
    assert np.log(odds) == pytest.approx(expected, abs=1e-3)


def test_strips_that_move_together_are_told_by_their_difference() -> None:
    """One standard deviation of the common factor off, four of the difference."""
    mean, shared = nearly_alike()
    moved = GAIN * (mean + shared[0])
    straight, crossed = posterior(mean, shared, moved), posterior(mean, shared, moved[::-1])
    assert [channel[0][0] for channel in straight.channels] == [("works", None, 1)] * 2
    assert [channel[0][0] for channel in crossed.channels] == [("swapped", 1, 1), ("swapped", 0, 1)]
    assert straight.channels[0][0][1] > 0.99
    assert straight.alike == ()


def test_strips_that_nothing_tells_apart_are_alike() -> None:
    mean, shared = nearly_alike()
    same = np.stack([mean[0], mean[0]])
    answer = posterior(same, shared, GAIN * same)
    assert answer.alike == ((0, 1),)
    assert answer.channels[0][0][0] == ("works", None, 1)


def test_a_start_without_a_strip_is_left_where_the_strip_shows() -> None:
    mean, shared = nearly_alike()
    answer = posterior(mean, shared, GAIN * mean, (2, 5))
    assert [channel[0][0][0] for channel in answer.channels] == ["works", "works"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a scene, whose prediction is there already."""
    monkeypatch.setattr(acceptance, "predict_films", lambda *_: prediction())
    (tmp_path / "scene.toml").write_text(scene().to_toml())
    (tmp_path / "film.csv").write_text(text(recording()))
    return tmp_path


def accept(folder: Path, *more: str):
    return run_skincad("accept", "--recording", "film.csv", "scene.toml", *more, cwd=folder)


@pytest.mark.slow
def test_the_command_names_a_dead_strip_with_status_1(folder: Path) -> None:
    (folder / "film.csv").write_text(text(recording(dead=2), "time_ms"))
    done = accept(folder, "--json")
    assert done.returncode == 1, done.stderr
    answer = json.loads(done.stdout)
    assert not answer["passed"]
    assert [s["state"] for s in answer["strips"]] == ["works", "works", "dead", "works", "works", "works"]
    keys = {"name", "passed", "strips", "common_gain", "delay_s", "duration", "pull", "seconds", "warnings"}
    assert answer.keys() == keys
    strip = {"ridge", "side", "state", "shows", "probability", "second", "gain", "alike"}
    assert answer["strips"][0].keys() == strip


def without_a_column(table: str) -> str:
    return "".join(f"{line.rpartition(',')[0]}\n" for line in table.splitlines())


def going_back(table: str) -> str:
    lines = table.splitlines(keepends=True)
    return "".join([*lines[:40], lines[10], *lines[40:]])


BAD = {
    "a missing channel": (without_a_column, "film.csv, column 'ridge_3_S2_V': is missing"),
    "an unknown channel": (
        lambda t: t.replace("ridge_3_S2_V", "ridge_4_S2_V"),
        "column 'ridge_3_S2_V': is missing",
    ),
    "time that goes back": (going_back, "film.csv, row 40: time_s must grow from row to row"),
    "milliamperes": (lambda t: t.replace("ridge_2_S1_V", "ridge_2_S1_mA"), "ridge_2_S1_V': is missing"),
    "no time": (lambda t: t.replace("time_s", "ridge_1_S1_V", 1), "must be given once"),
    "time in another unit": (lambda t: t.replace("time_s", "time_ms"), "time_s: must cover the press"),
    "too short": (lambda t: "".join(t.splitlines(keepends=True)[:60]), "time_s: must cover the press"),
    "three rows": (lambda t: "".join(t.splitlines(keepends=True)[:4]), "must have at least 20 rows, got 3"),
    "too few samples": (lambda t: "".join(_thin(t, 50)), "time_s: must have a step of at most"),
    "text": (lambda t: t.replace("0.001,", "soon,", 1), "must be a finite number"),
    "nothing": (lambda _: "", "film.csv"),
}


def _thin(table: str, by: int) -> list[str]:
    head, *rows = table.splitlines(keepends=True)
    longer = [
        f"{float(r.partition(',')[0]) + 0.24 * k:.9g},{r.partition(',')[2]}" for k in range(5) for r in rows
    ]
    return [head, *longer[::by]]


@pytest.mark.slow
def test_bad_input_of_the_command_is_one_line_and_status_2(folder: Path) -> None:
    words = ("accept", "--recording", "film.csv", "scene.toml")
    table = (folder / "film.csv").read_text()
    for name, (change, said) in BAD.items():
        assert change(table) != table, name
        (folder / "film.csv").write_text(change(table))
        assert said in refused_command(*words, cwd=folder), name
    assert "none.csv" in refused_command("accept", "--recording", "none.csv", "scene.toml", cwd=folder)


@pytest.mark.slow
def test_signals_of_simulate_are_a_recording(folder: Path) -> None:
    made = recording()
    head = ["step [1]", "time [s]", "normal force [N]"]
    head += [f"ridge {r} {s} output [V]" for r, s in made.strips]
    head += ["ridge 1 pair output [V]", "slipping ridges [1]"]
    rows = [
        [str(i), f"{t:.9g}", "1", *(f"{v:.9g}" for v in made.volts[:, i]), "0", "1 2" * (i > 100)]
        for i, t in enumerate(made.time)
    ]
    (folder / "film.csv").write_text("\n".join(",".join(row) for row in [head, *rows]))
    done = accept(folder)
    assert done.returncode == 0, done.stderr
    assert "ACCEPTED, 6 of 6 strips work" in done.stdout


STRIPS = ((4, "S1"), (4, "S2"), (5, "S1"))


def recorded(tmp_path: Path, seed: int, fault: str) -> Path:
    """300 rows of three strips at rest, then pressed, as a logger leaves them in a CSV."""
    dice = np.random.default_rng(seed)
    time = np.arange(300) / 1000.0
    press = float(dice.choice([-1.0, 1.0])) * np.clip((time - 0.1) / 0.1, 0.0, 1.0)
    volts = 0.05 * press * dice.uniform(0.7, 1.0, 3)[:, None] + 4e-4 * dice.standard_normal((3, 300))
    level = float(dice.uniform(0.2, 0.6)) * 0.05
    if fault == "clipped":
        volts = np.clip(volts, -level, level)
    elif fault == "one sign":
        volts = np.maximum(volts * -press[-1], 0.0)  # the sign that is lost
    elif fault == "rails":
        volts[2] = np.where(volts[2] > np.median(volts[2]), 5.0, -5.0)
    elif fault == "dead":
        volts[1] = 0.0
    elif fault == "dead but for its last bit":
        volts[1] = 1e-4 * (volts[1] > np.median(volts[1]))
    elif fault == "coarse":
        volts = 2e-3 * np.round(volts / 2e-3)
    path = tmp_path / "r.csv"
    names = ",".join(f"ridge_{ridge}_{side}_V" for ridge, side in STRIPS)
    np.savetxt(path, np.column_stack([time, *volts]), "%.6f", ",", header=f"time_s,{names}", comments="")
    return path


@pytest.mark.parametrize("seed", range(6))
def test_a_clipped_recording_is_refused(seed: int, tmp_path: Path) -> None:
    """Clipped, cut at zero, or at its rails; a dead strip and a coarse converter are read."""
    for fault, words in (
        ("clipped", "must not be clipped"),
        ("one sign", "clipped"),
        ("rails", "two values"),
    ):
        with refused(words):
            film_recording(recorded(tmp_path, seed, fault), STRIPS)
    for fault in ("none", "dead", "dead but for its last bit", "coarse"):
        assert film_recording(recorded(tmp_path, seed, fault), STRIPS).volts.shape == (3, 300)
