"""What a recording of the films tells: dead, reversed and swapped strips, and what it can't tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.table_recordings import judged
from skincad.base import InputError
from skincad.inputs import FilmRecording
from skincad.scenes import CANT_TELL, judge, recorded_scene
from skincad.scenes.film_prediction import press_end
from skincad.scenes.strip_assignment import cell_means
from tests.refusals import refused
from tests.scenes.recordings import DELAY, prediction, recording, scene

NAMES = [f"ridge {r} S{s}" for r in (1, 2, 3) for s in (1, 2)]


def states(made: FilmRecording) -> dict[str, str]:
    result = judge(scene(), prediction(), made)
    return {strip.name: strip.state for strip in result.strips}


def test_all_work() -> None:
    result = judge(scene(), prediction(), recording())
    assert {strip.state for strip in result.strips} == {"works"}
    assert result.passed
    assert result.exit_status == 0
    # the charge scales with the modulus, and gains are 0.7 in the middle
    assert result.common_gain.value == pytest.approx(0.7, rel=0.2)
    assert result.delay.value == pytest.approx(DELAY, abs=0.004)  # a few cells of the press
    assert result.pull


@pytest.mark.parametrize("channel", [0, 3])
def test_one_dead(channel: int) -> None:
    assert states(recording(dead=channel)) == {**dict.fromkeys(NAMES, "works"), NAMES[channel]: "dead"}


def test_a_channel_of_zeros_is_dead() -> None:
    made = recording()
    made.volts[2] = 0.0
    assert states(made)[NAMES[2]] == "dead"


@pytest.mark.parametrize("channel", [1, 4])
def test_one_reversed(channel: int) -> None:
    result = judge(scene(), prediction(), recording(reversed_=channel))
    told = {strip.name: strip.state for strip in result.strips}
    assert told == {**dict.fromkeys(NAMES, "works"), NAMES[channel]: "reversed"}
    assert result.strips[channel].gain.value < -0.5
    assert result.exit_status == 1


def test_two_swapped() -> None:
    told = states(recording(swapped=(0, 3)))
    wrong = {NAMES[0]: f"swapped with {NAMES[3]}", NAMES[3]: f"swapped with {NAMES[0]}"}
    assert told == {**dict.fromkeys(NAMES, "works"), **wrong}


def test_mirrored_strips_are_alike_in_a_press_alone() -> None:
    made = recording()
    pressed = made.time <= DELAY + prediction().press_end
    result = judge(
        scene(), prediction(), FilmRecording(made.strips, made.time[pressed], made.volts[:, pressed])
    )
    assert not result.pull
    assert "ridge 3 S2" in result.strips[0].alike
    whole = judge(scene(), prediction(), made)
    assert "ridge 3 S2" not in whole.strips[0].alike


def test_ridges_that_change_places_crosswise_are_not_told_by_a_press_alone() -> None:
    """A press on a crest that is lower than its mirror image shows the same; a pull after it tells."""
    loud = np.array([1.5, 1.5, 1.0, 1.0, 0.7, 0.7])[:, None]
    uneven = replace(prediction(), worlds=prediction().worlds * loud, changes=prediction().changes * loud)
    made = recording()
    volts = (made.volts * loud)[[5, 4, 2, 3, 1, 0]]
    pressed = made.time <= DELAY + prediction().press_end
    alone = judge(scene(), uneven, FilmRecording(made.strips, made.time[pressed], volts[:, pressed]))
    assert [strip.state for strip in alone.strips] == [
        CANT_TELL, CANT_TELL, "works", "works", CANT_TELL, CANT_TELL,
    ]  # fmt: skip
    whole = judge(scene(), uneven, FilmRecording(made.strips, made.time, volts))
    shown = [NAMES[5], NAMES[4], None, None, NAMES[1], NAMES[0]]
    assert [strip.shows for strip in whole.strips] == shown


def test_a_swap_by_a_press_alone_is_never_said_to_be_sure() -> None:
    made = recording(swapped=(2, 5))
    pressed = made.time <= DELAY + prediction().press_end
    result = judge(
        scene(), prediction(), FilmRecording(made.strips, made.time[pressed], made.volts[:, pressed])
    )
    assert result.strips[2].shows == NAMES[5]
    assert result.strips[2].probability == 0.95
    assert judge(scene(), prediction(), made).strips[2].probability > 0.95


def test_millivolts_are_refused() -> None:
    made = recording()
    with refused("must be in volts"):
        judge(scene(), prediction(), FilmRecording(made.strips, made.time, 1000 * made.volts))


def test_a_scene_without_circuit_is_refused() -> None:
    with pytest.raises(InputError, match=r"effects\.piezo: is missing"):
        recorded_scene(scene().with_(effects={"piezo": None}))


def test_the_press_ends_where_the_force_stops_growing() -> None:
    history = {"normal_force_N": [0.0, 1.0, 1.3], "time_s": [0.0, 0.1, 0.25]}
    assert press_end(scene()) == 0.1
    assert press_end(scene().with_(history=history)) == 0.25


def test_means_of_cells_are_those_of_straight_lines() -> None:
    time = np.array([0.0, 1.0, 3.0])
    means = cell_means(time, np.array([[0.0, 2.0, 2.0]]), np.array([0.0, 0.5, 2.0]))
    assert means[0] == pytest.approx([0.5, (0.75 + 2.0) / 1.5])


@pytest.mark.slow
def test_most_recordings_of_the_exam_are_judged_right(tmp_path) -> None:
    """Of the seeds on which thresholds were chosen, in one scene."""
    worth = [answer for seed in range(22000, 22040) if (answer := _worth(seed, tmp_path))]
    assert worth.count("right") >= 0.9 * len(worth)
    assert len(worth) >= 5


def _worth(seed: int, folder) -> str | None:
    if (
        str(np.random.default_rng(seed).choice(["press", "press and pull", "fast pull", "lab bench"]))
        != "press and pull"
    ):
        return None
    return judged(seed, folder)[2]
