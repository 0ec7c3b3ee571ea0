"""The exam of lifts: what it is fitted to and judged on is apart, a seed is a lift, marks by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.exam.scenes import MORE, RANDOM
from bench.lifts import fitting
from bench.lifts.__main__ import LINKS, Mark, false, line
from bench.lifts.scenes import DELAY, FIRST, FORCE_RATE, KINDS, RATE, RISE, drawn, history, set_skins
from skincad.detector import GRIPPER, features, weights
from skincad.scenes import LiftRun


def random_skins(kind: str) -> set[str]:
    return {skin.name for skin in set_skins(kind) if skin.name.startswith("random")}


@pytest.mark.slow
def test_random_skins_to_fit_on_are_not_those_that_judge() -> None:
    fit, judge = random_skins("design"), random_skins("exam")
    assert not fit & judge
    assert len(fit) == len(RANDOM["design"]) + sum(map(len, MORE))
    assert len(judge) == len(RANDOM["exam"])
    assert drawn(7).skin.name in {skin.name for skin in set_skins("exam")}
    assert drawn(8).skin.name in {skin.name for skin in set_skins("design")}


@pytest.mark.slow
def test_a_seed_is_the_same_lift_every_time() -> None:
    """The gripper is as late and as slow as the exam says; the largest load needs the least grip."""
    for seed in (1, 3, 5, 7, 9, 11):
        one, same = drawn(seed), drawn(seed)
        assert one.scene == same.scene
        grip = one.scene.grip
        assert grip is not None
        assert DELAY[0] <= (grip.delay or 0.0) <= DELAY[1]
        assert (grip.force_rate or 0.0) <= FORCE_RATE[1]
        assert FIRST[0] <= grip.force / one.least <= FIRST[1]
        assert grip.points[1].max() == pytest.approx(one.friction * one.least)
    assert drawn(1).least != drawn(3).least


@pytest.mark.parametrize("kind", KINDS[1:])
def test_a_load_comes_in_its_time_and_stays(kind: str) -> None:
    for seed in range(20):
        time, load = history(np.random.default_rng(seed), kind, RISE[1])
        assert (time[0], load[0], load[-1]) == (0.0, 0.0, pytest.approx(1.0))
        assert (np.diff(time) > 0).all()
        assert load.min() >= 0.0
        assert RISE[1] <= time[-1] < 3.0
        assert load.max() < 1.6


@pytest.mark.slow
def test_a_link_changes_its_own_keys_alone() -> None:
    one = drawn(1)
    assert one.scene.grip is not None
    for name, link in LINKS.items():
        changes = link(one)
        scene = one.scene.with_(**changes) if changes else one.scene
        grip, piezo = scene.grip, scene.effects["piezo"]
        assert grip is not None
        assert (piezo.get("noise_seed") is None) == (name == "no noise")
        assert (piezo["sampling_Hz"], scene.readout.alarms) == (RATE, "grip")
        values = {key: getattr(grip, key) for key in type(grip).model_fields}
        before = {key: getattr(one.scene.grip, key) for key in values}
        assert {key for key in values if values[key] != before[key]} == set(changes.get("grip", {}))


def by_hand(**changes: object) -> LiftRun:
    """A load that rises from 0 to 1 N in 1000 samples, on 1 N."""
    n = 1001
    run = LiftRun(
        time=np.arange(n) / 2000.0, asked=np.ones(n), grip=np.ones(n), pull=np.zeros(n),
        load=np.linspace(0, 1, n), approach=np.zeros(n), travel=np.zeros(n), slide=np.zeros(n),
        slipping=np.zeros((n, 1), bool), loads=np.zeros((n, 3, 1)), films=np.zeros((n, 2, 3)),
        outputs=np.zeros((n, 1, 2)), noise=np.zeros((n, 1, 2)), noise_rms=0.0, alarms=(), lost=False,
        residual=0.0, unknowns=0, seconds=0.0,
    )  # fmt: skip
    return replace(run, **changes)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_raise_is_false_while_nothing_needs_it() -> None:
    """0.85 of a friction of 0.5 is 0.425 N, which comes in the 60 ms and the delay of 15 ms after sample 275:
    150 samples before sample 425."""
    one = replace(drawn(1), friction=0.5)
    assert [false(one, by_hand(alarms=(at,)), 0.015) for at in (100, 274, 276, 500)] == [1, 1, 0, 0]
    slides = np.arange(1001) * 0.01
    assert false(one, by_hand(alarms=(100,), slide=slides), 0.015) == 0


def test_more_grip_is_needed_ahead_of_the_load() -> None:
    """0.9 of 0.5 N is 0.45 N: 120 samples of AHEAD before the load has it."""
    load = np.linspace(0, 1, 1001)
    march = fitting.Marched(2, np.ones(1001), load, np.zeros((1001, 2, 3)), np.zeros(1001, bool), 0)
    assert np.flatnonzero(fitting.needs(march, 0.5))[0] == 450 - 120 + 1
    slides = np.arange(1001) == 50
    assert fitting.needs(replace(march, slides=slides), 0.5)[50]


def test_a_tables_line_counts_what_is_held_and_what_slides() -> None:
    one = Mark(
        seed=1, policy="p", link="", held=True, slide=0.2, mean=1.2, peak=1.5, raises=2, false=1, delay=0.02,
        rise=0.1, first=0.5, friction=0.5, kind="lift", amplifier="a", skin="s", signal=20.0, seconds=1.0,
    )  # fmt: skip
    marks = [one, replace(one, slide=3.0, mean=1.0), replace(one, held=False, slide=9.0)]
    name, count, firm, held, mean = line("p", marks)[:5]
    assert (name, count, mean) == ("p", 3, "1.13")
    assert (firm.split()[0], held.split()[0]) == ("33", "67")  # type: ignore[attr-defined]


def test_the_shipped_network_is_of_the_fits_size() -> None:
    network = weights(GRIPPER)
    assert network.into.shape == (features.COUNT, fitting.HIDDEN)
    assert network.bias.shape == network.out.shape == (fitting.HIDDEN,)
