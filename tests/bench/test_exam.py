"""The detector's exam: what it is fitted to and judged on is apart, histories are possible, marks by hand."""

from __future__ import annotations

import tomllib
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from bench.exam import fitting, network
from bench.exam.histories import ENDS, STEPS, history
from bench.exam.scenes import (
    COUNT,
    DESIGN,
    EXAM,
    FIRST,
    LATER,
    MORE,
    RANDOM,
    SceneRun,
    Skin,
    batch,
    drawn,
    seeds,
)
from bench.exam.scoring import Alarm, Case, lasting, mark, near, rate
from skincad.detector import RIDGES, SKIN, detector
from skincad.inputs import load_design

STEP = 1e-3  # s


def test_what_it_is_fitted_to_is_not_what_judges_it() -> None:
    fit, judge = seeds(DESIGN), seeds(EXAM)
    assert not set(fit) & set(judge)
    later = [seed for seed in fit if batch(seed)]
    assert len(set(fit)) == COUNT[DESIGN] + len(later)
    assert len(later) == sum(LATER)
    assert (len(judge), judge[0], judge[-1]) == (320, 4001, 4639)  # as it was when it was judged
    for more in (RANDOM[DESIGN], *MORE):
        assert not set(RANDOM[EXAM]) & set(more)


def test_each_seed_has_its_batchs_skins() -> None:
    after = (0, 1, 639, 478, 480, 1198, 1200, 1598)
    assert [batch(FIRST + s) for s in after] == [0, 0, 0, 0, 1, 1, 2, 2]
    for seed in (1200, 1500, 1598):
        assert int(drawn(FIRST + seed).skin.name.split("-")[1]) in MORE[1]


def test_a_seed_is_the_same_scene_every_time() -> None:
    one, same, other = drawn(4007), drawn(4007), drawn(4009)
    np.testing.assert_array_equal(one.way.normal, same.way.normal)
    assert one.friction == same.friction != other.friction


@pytest.mark.parametrize("seed", range(60))
def test_a_history_is_held_until_its_end_and_slips_there(seed: int) -> None:
    draw = np.random.default_rng(seed)
    way = history(draw, 4.0, 0.6, 3.0, 0.2)
    steps = np.diff(way.time)
    assert way.time.size == way.normal.size == way.tangential.size == way.angle.size == STEPS + 1
    np.testing.assert_allclose(steps, steps[0])
    assert 0.01 < way.bandwidth * steps[0] <= 0.4
    assert way.normal.min() >= 0
    assert np.abs(way.angle).max() <= 3.0
    names, firsts = zip(*way.phases, strict=True)
    assert names[0] == "first press"
    assert firsts[0] == 0
    assert all(b > a for a, b in pairwise(firsts))
    used = np.abs(way.tangential) / np.maximum(0.6 * way.normal, 1e-9)
    gentle = used[1 : firsts[-1]] if names[-1] in ENDS else used[1:]
    assert gentle.max() < 1.0
    if names[-1] in ENDS and names[-1] != "drag":
        assert used[firsts[-1] :].max() > 1.0
    assert (way.travel is not None) == (names[-1] == "drag")


def by_hand() -> Case:
    """Three ridges, of which 1 and 3 are told: ridge 1 slips from step 40 to 49 and from 80 on, 2 from 70 on,
    3 from 90 on; all do at 99."""
    slipping = np.zeros((100, 3), bool)
    slipping[40:50, 0] = slipping[80:, 0] = slipping[70:, 1] = slipping[90:, 2] = True
    design = load_design("yamada-2002")
    scene = SceneRun(
        1, Skin("by hand", design, 4.0), 0.5, None, STEP * np.arange(100), 100.0, np.zeros((100, 6, 3)),
        slipping, np.full(100, 4.0), np.linspace(0, 2.1, 100), 99, (("first press", 0), ("pull", 60)), (1, 3),
    )  # fmt: skip
    return Case(scene, "none", 1 / STEP, np.zeros((100, 2, 2)), slipping[:, [0, 2]], 1.0, np.zeros(513), 1)


def test_where_slip_begins_that_lasts() -> None:
    case = by_hand()
    assert lasting(case.scene.slipping, 99) == [80, 70, 90]
    assert lasting(case.scene.slipping, None) == [None] * 3
    assert lasting(np.zeros((5, 1), bool), 4) == [None]
    assert np.flatnonzero(near(case.slipping, 3)[:, 0]).tolist() == [*range(37, 53), *range(77, 100)]


@pytest.mark.parametrize(
    ("alarms", "told"),
    [  # warned, true, passing, other, none
        ([], (False, 0, 0, 0, 0)),
        ([(0, 20)], (False, 0, 0, 0, 1)),  # nothing slips yet
        ([(0, 45)], (False, 0, 1, 0, 0)),  # ridge 1 slips, but sticks again
        ([(1, 45)], (False, 0, 0, 1, 0)),  # ridge 1 slips, not 3
        ([(0, 67)], (False, 0, 0, 1, 0)),  # within a window of ridge 2's slip; ridge 1 sticks
        ([(0, 66)], (False, 0, 0, 0, 1)),
        ([(0, 78)], (True, 1, 0, 0, 0)),
        ([(1, 85)], (False, 0, 0, 1, 0)),
        ([(1, 95), (0, 10), (0, 11)], (True, 1, 0, 0, 2)),
        ([(0, 99)], (False, 1, 0, 0, 0)),  # as late as gross slip itself
        ([(None, 67)], (True, 1, 0, 0, 0)),  # the skin: ridge 2 slips on
        ([(None, 45)], (False, 0, 1, 0, 0)),
        ([(None, 60)], (False, 0, 0, 0, 1)),
    ],
)
def test_marks_by_hand(alarms: list[Alarm], told: tuple[bool, int, int, int, int]) -> None:
    answer = mark(by_hand(), alarms, 3)
    assert (answer.warned, answer.true, answer.passing, answer.other, answer.none) == told
    assert answer.false == sum(told[2:])
    assert answer.slips
    assert answer.possible == pytest.approx(29 * STEP)
    assert answer.seconds == pytest.approx(100 * STEP)


def test_a_lead_runs_from_the_first_alarm_and_a_false_one_has_its_phase() -> None:
    answer = mark(by_hand(), [(1, 95), (0, 77), (0, 10), (1, 63)], 3)
    assert answer.lead == pytest.approx(22 * STEP)
    assert answer.within == ("first press", "pull")


def test_intervals_as_in_tables() -> None:
    """Garwood of none and of 5 events in 2 minutes."""
    assert rate(0, 2.0)[1:] == (0.0, pytest.approx(3.689 / 2, abs=1e-3))
    assert rate(5, 2.0) == (2.5, pytest.approx(1.6235 / 2, abs=1e-3), pytest.approx(11.668 / 2, abs=1e-3))


def samples(
    draw: np.random.Generator, count: int, features: int, spread: float = 1.0
) -> list[network.Samples]:
    """Of one to three ridges; the label is 1 where the mean over ridges of the first two features' product is
    above 0."""
    parts = []
    for ridges in (1, 2, 3):
        x = draw.normal(3.0, spread, (count, ridges, features))
        label = ((x[:, :, 0] - 3.0) * (x[:, :, 1] - 3.0)).mean(axis=1) > 0
        parts.append((x, label, draw.uniform(0.5, 2.0, count)))
    return parts


def test_the_fits_slope_is_the_losss() -> None:
    """Central differences of doubles: right to about 1e-8 of slopes of about 1e-2."""
    draw = np.random.default_rng(4)
    layers = [draw.normal(size=s) for s in ((5, 3), (3,), (3,), (1,))]
    some = network.stacked(samples(draw, 12, 5))
    slopes = network.gradient(layers, some)
    for layer, slope in zip(layers, slopes, strict=True):
        for at in np.ndindex(layer.shape):
            entry = layer[at]
            sides = []
            for h in (1e-6, -1e-6):
                layer[at] = entry + h
                sides.append(network.loss(layers, some))
            layer[at] = entry
            assert slope[at] == pytest.approx((sides[0] - sides[1]) / 2e-6, abs=1e-8)


def test_a_fit_finds_what_no_straight_line_tells(monkeypatch: pytest.MonkeyPatch) -> None:
    """The mean of products of two features among four; and what is written is read as the same network."""
    for key, value in {"HIDDEN": 16, "EPOCHS": 60, "BATCH": 64}.items():
        monkeypatch.setattr(network, key, value)
    draw = np.random.default_rng(5)
    answer = network.fitted(samples(draw, 1000, 4, 2.0))
    for x, label, _ in samples(draw, 300, 4, 2.0):
        assert np.mean((fitting.odds(answer, x).mean(axis=1) > 0) == label) > 0.85  # a line gets a half
    table = tomllib.loads(fitting.written(answer, "a test"))
    np.testing.assert_allclose(np.array(table["into"]).T, answer.into, rtol=1e-3)
    np.testing.assert_allclose(table["out"], answer.out, rtol=1e-3)


@pytest.mark.parametrize("file", [RIDGES, SKIN])
def test_the_shipped_weights_are_of_the_fits_size(file: str) -> None:
    table = tomllib.loads((Path(detector.__file__).parent / file).read_text())
    assert len(table["into"]) == len(table["out"]) == len(table["bias"]) == network.HIDDEN
