"""The detector of slip: what it hears and what alarms; no look-ahead, pieces as at once, and its score."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

from skincad.base import InputError
from skincad.circuit import band_limited, circuit_network, delay, fitted, load_circuit
from skincad.detector import (
    AHEAD,
    EARLY,
    GRIP,
    INCIPIENT,
    POINTS,
    SURE,
    Alarm,
    Detector,
    Tuning,
    change_noise,
    features,
    tuned,
)
from skincad.inputs import load_design
from skincad.outputs import write_table
from skincad.scenes import (
    LEVELS,
    NOT_AHEAD,
    NOTHING,
    PASSING,
    Score,
    at_level,
    intervals,
    load_scene,
    report,
    score,
)
from tests.small_scene import small_scene

RATE, WIDTH, NOISE = 1e5, 5000.0, 1e-3  # rate and band of the paper's scene
TIME = np.arange(600) / RATE
D = tuned(RATE, WIDTH, NOISE, EARLY)
KEEN = replace(D, threshold=1.0, warning=1.0)  # which has alarms of either kind in the paper's scene


def by_name(outputs: np.ndarray) -> dict[str, dict[str, list[float]]]:
    """Outputs `(n, 2, 2)` of ridges 2 and 3 as a reader gives them."""
    return {
        name: {side: outputs[:, i, k].tolist() for k, side in enumerate(("S1", "S2"))}
        for i, name in enumerate(("2", "3"))
    }


def behind(*rates: np.ndarray) -> np.ndarray:
    """Outputs `(n, ridges, 2)` of pairs behind the low-pass, S1 + S2 being 0."""
    values = [band_limited(TIME, np.asarray(r, float), WIDTH).value for r in rates]
    return np.stack([np.stack([v / 2, -v / 2], axis=1) for v in values], axis=1)


def pieces(*points: tuple[int, float]) -> np.ndarray:
    """Constant from each step on."""
    values = np.zeros(TIME.size)
    for at, value in points:
        values[at:] = value
    return values


def felt(level: int, scene: str, *settings: str) -> dict[str, Any]:
    overrides = ["effects.piezo.circuit=transimpedance", "readout.ridges=[2, 3]", *settings]
    return at_level(load_scene(scene, overrides), LEVELS[level]).as_json()


Runs = list[list[list[int]]]


def in_noise(data: dict[str, Any]) -> np.ndarray:
    """Outputs `(n, 2, 2)` of ridges 2 and 3 in a unit in which a pair's noise is NOISE."""
    strips = [[data["output_V"][r][side] for side in ("S1", "S2")] for r in "23"]
    return np.moveaxis(np.array(strips), 2, 0) * NOISE / (math.sqrt(2) * data["output_noise_V_rms"])


@cache
def papers() -> np.ndarray:
    """The paper's scene. Ridge 2 slips from step 186 to 200 and from 477 on, ridge 3 from 488, all at 550."""
    return in_noise(felt(1, "yamada-2002-slip", "effects.small_strain.masses=false"))


@cache
def small() -> tuple[np.ndarray, Runs]:
    """The same of three ridges, which bear a third: outputs, and when ridges 2 and 3 slip."""
    forces = (
        "history.normal_force_N=[0.0, 1.3333, 1.3333, 1.3333, 1.3333, 1.3333, 1.3333]",
        "history.tangential_force_N=[0.0, 0.0, 1.1333, 1.1333, 0.8667, 1.0667, 1.3333]",
    )
    more = ("effects.piezo.circuit=transimpedance", "readout.ridges=[2, 3]")
    masses = "effects.small_strain.masses=false"
    with TemporaryDirectory() as folder:
        scene = small_scene(Path(folder), "yamada-2002-slip", *forces, *more, masses)
        run = at_level(scene, LEVELS[0])
    assert run.gross_slip_step == 550
    return in_noise(run.as_json()), run.runs[1:]


RUNS = [[[186, 200], [477, 550]], [[488, 550]]]


def detector(tuning: Tuning = D, ridges: int = 2) -> Detector:
    return Detector.of(tuning, range(ridges), RATE)


def events(outputs: np.ndarray, tuning: Tuning = D) -> list[Alarm]:
    return detector(tuning, outputs.shape[1]).feed(flat(outputs))


def flat(outputs: np.ndarray) -> np.ndarray:
    """Outputs `(n, ridges, 2)` as a detector's channels."""
    return outputs.reshape(outputs.shape[0], -1)


@pytest.mark.slow
def test_the_slip_that_lasts_is_warned_of_once() -> None:
    """It begins at step 477; the warning takes 0.19 ms, a window and a quarter. The slip of steps 186 to 200,
    after which ridge 2 sticks, is no warning."""
    (warning,) = events(papers())
    assert (warning.kind, warning.ridge) == (AHEAD, None)
    assert 0 < warning.index - 477 <= 25


def test_it_hears_the_same_on_the_other_side() -> None:
    """Mirrored, S1 and S2 change places, and so do the ridges."""
    outputs, _ = small()
    here, there = (events(x, KEEN) for x in (outputs, outputs[:, ::-1, ::-1]))
    assert len(here) >= 4
    turned = [(e.kind, None if e.ridge is None else 1 - e.ridge, e.index) for e in there]
    # of two alarms at one sample the first ridge's comes first
    assert sorted(turned, key=str) == sorted(((e.kind, e.ridge, e.index) for e in here), key=str)


@pytest.mark.parametrize("cuts", [[0, *range(450, 552)], [0, 7, 8, 180, 190, 490, 551], [0, 0, 551]])
def test_in_pieces_as_at_once(cuts: list[int]) -> None:
    """Sample by sample from before the alarms on, and by other pieces, an empty one too: the same bits."""
    noise = np.random.default_rng(1).normal(0.0, NOISE / math.sqrt(2), (551, 2, 2))
    noisy = small()[0] + noise
    noisy = flat(noisy)
    at_once, by_pieces = detector(KEEN), detector(KEEN)
    odds = at_once.odds(noisy)
    whole = at_once.feed(noisy)
    alarms, seen = [], []
    for a, b in pairwise(cuts):
        before = by_pieces.state
        seen.append(by_pieces.odds(noisy[a:b]))
        assert by_pieces.state == before  # asking feeds nothing
        another = detector(KEEN)  # its state is all that it keeps
        another.restore(json.loads(json.dumps(before)))
        alarms += by_pieces.feed(noisy[a:b])
        another.feed(noisy[a:b])
        assert another.state == by_pieces.state
    assert alarms == whole
    assert len(whole) >= 2
    np.testing.assert_array_equal(np.concatenate(seen), odds)
    assert by_pieces.state == at_once.state
    assert at_once.state["count"] == 551


@pytest.mark.parametrize("now", [0, 185, 193, 300, 489])
def test_what_comes_later_changes_nothing_before(now: int) -> None:
    outputs, _ = small()
    other = outputs.copy()
    other[now + 1 :] = np.random.default_rng(2).normal(0.0, 10.0, other[now + 1 :].shape)
    early, changed = ([e for e in events(x, KEEN) if e.index <= now] for x in (outputs, other))
    assert early == changed
    assert np.abs(other - outputs).max() > 1.0


@pytest.mark.parametrize(
    "load",
    [
        pieces((50, 0.5), (300, 0.0)),  # the pull stops
        pieces((50, 0.5), (300, -0.4)),  # and turns back: both ridges turn
        pieces((50, 0.5), (300, 0.9)),  # is faster
        pieces((50, 0.5)),
    ],
)
def test_what_the_load_does_to_both_ridges_is_no_slip(load: np.ndarray) -> None:
    assert events(behind(load, 0.8 * load)) == []


@pytest.mark.slow
def test_a_press_and_a_hold_are_no_slip() -> None:
    assert felt(0, "yamada-2002-press", "effects.piezo.noise_seed=1")["events"] == []
    data = felt(0, "hold", "history.steps=100", "readout.bandwidth_Hz=80.0", "effects.piezo.noise_seed=1")
    assert data["events"] == []
    assert data["event_score"] == {"hits": 0, "missed": 0, "false": 0, "misnamed": 0}


def test_noise_alone_does_not_alarm() -> None:
    """White noise, 20 000 decisions: none beyond the threshold, so no event; a window's mean reaches 2.9 rms
    and SEEN is 5."""
    noise = np.random.default_rng(3).normal(0.0, NOISE / math.sqrt(2), (10_000, 2, 2))
    assert detector().odds(flat(noise)).max() < min(D.threshold, D.warning)


def test_the_window_grows_with_the_low_passs_delay() -> None:
    assert D.window == math.ceil(3.5 * delay(WIDTH) * RATE)
    assert tuned(RATE, WIDTH / 10, NOISE).window == pytest.approx(10 * D.window, abs=10)
    assert tuned(10.0, WIDTH, NOISE).window == 3


def scored(
    window: int, alarms: list[Alarm], runs: Runs, gross: int | None, begun: int | None = None
) -> Score:
    """What alarms of ridges from 0 are worth."""
    return score(window, alarms, TIME, dict(enumerate(runs)), gross, begun)


def test_a_score_by_hand() -> None:
    runs = [[[100, 120], [300, 400]], [[200, 203], [350, 400]]]
    alarms = [Alarm(INCIPIENT, 0, 95), Alarm(INCIPIENT, 0, 310), Alarm(INCIPIENT, 0, 330)]
    alarms += [Alarm(INCIPIENT, 1, 50), Alarm(AHEAD, None, 20), Alarm(AHEAD, None, 290)]
    result = scored(10, alarms, runs, 400, 300)
    # ridge 0's both runs; ridge 1's short one is not asked for, its other is missed; that gross slip is ahead
    # is false at step 20, as no slip goes on from there until it, and true within a window of 300
    assert (result.hits, result.missed, result.false) == (2, 1, 1)
    assert result.reasons == (PASSING, "", "", NOTHING, NOT_AHEAD, "")
    assert result.lead == (pytest.approx(90e-5), None)
    assert result.gross_lead == pytest.approx(110e-5)
    without = scored(10, alarms, runs, None)
    assert (without.false, without.lead, without.gross_lead) == (1, (None, None), None)
    assert without.reasons.count(NOT_AHEAD) == 2
    other = scored(10, [Alarm(INCIPIENT, 1, 110), Alarm(INCIPIENT, 1, 140)], runs, None)
    assert (other.false, other.misnamed) == (1, 1)  # ridge 0 slips at the first of them, none at the second


def test_an_alarm_of_a_pull_that_eased_off_is_no_warning_of_the_next() -> None:
    """Both ridges slip in either pull, and gross slip is said to be ahead in both, 1.8 ms before it."""
    runs = [[[50, 90], [400, 599]], [[60, 90], [410, 599]]]
    alarms = [Alarm(INCIPIENT, 0, 52), Alarm(INCIPIENT, 1, 62), Alarm(AHEAD, None, 62)]
    alone = scored(10, alarms, runs, 599, 400)
    assert (alone.hits, alone.false, alone.lead, alone.gross_lead) == (2, 0, (None, None), None)
    assert alone.reasons == (PASSING, PASSING, NOT_AHEAD)
    again = scored(10, [*alarms, Alarm(INCIPIENT, 0, 405), Alarm(AHEAD, None, 419)], runs, 599, 400)
    assert again.reasons == (*alone.reasons, "", "")
    assert again.lead == (pytest.approx(194 / RATE), None)
    assert again.gross_lead == pytest.approx(1.8e-3)


@pytest.mark.parametrize("seed", range(40))
def test_an_alarm_is_true_where_what_it_names_slips_on_until_gross_slip(seed: int) -> None:
    """By slips drawn at random, sample by sample: no alarm that is far from a lasting slip gives a lead."""
    draw = np.random.default_rng((37, seed))
    window, ridges, count = int(draw.integers(3, 12)), int(draw.integers(1, 5)), 300
    slipping = np.zeros((count, ridges), bool)
    for ridge in range(ridges):
        for _ in range(int(draw.integers(0, 4))):
            start = int(draw.integers(0, 200))
            slipping[start : start + int(draw.integers(1, 40)), ridge] = True
    gross = int(draw.integers(250, count)) if draw.random() < 0.7 else None
    lasts = np.full(ridges, count)
    for ridge in np.flatnonzero(draw.random(ridges) < 0.9) if gross is not None else ():
        slipping[gross - int(draw.integers(0, 60)) :, ridge] = True
        lasts[ridge] = np.flatnonzero(np.append(True, ~slipping[:, ridge])).max()
    runs = [intervals(column) for column in slipping.T]
    alarms = []
    for _ in range(int(draw.integers(1, 15))):
        ridge = None if draw.random() < 0.3 else int(draw.integers(ridges))
        alarms.append(Alarm(INCIPIENT if ridge is not None else AHEAD, ridge, int(draw.integers(count))))
    alarms.sort(key=lambda event: event.index)
    begun = int(lasts.min()) if lasts.min() < count else None
    result = scored(window, alarms, runs, gross, begun)
    since = [int(lasts.min() if event.ridge is None else lasts[event.ridge]) for event in alarms]
    true = [e.index >= at - window and at < count for e, at in zip(alarms, since, strict=True)]
    assert [not reason for reason in result.reasons] == true
    for ridge, lead in [*enumerate(result.lead), (None, result.gross_lead)]:
        first = [e.index for e, right in zip(alarms, true, strict=True) if e.ridge == ridge and right]
        if lead is not None:
            assert gross is not None
            assert lead == pytest.approx((gross - first[0]) / RATE, abs=1e-12)
        elif first:  # a slip shorter than a window is not asked for
            assert ridge is not None
            assert count - lasts[ridge] < window


@pytest.mark.parametrize("seed", range(10))
def test_the_detector_hears_the_equal_steps_alone(seed: int) -> None:
    """Steps at corners between them, which it does not hear, move the steps of events, and no lead."""
    draw, (outputs, slips) = np.random.default_rng((38, seed)), small()
    between = np.sort(draw.choice(550, int(draw.integers(1, 40)), replace=False)) + draw.uniform(0.1, 0.9)
    place = np.sort(np.concatenate([np.arange(551), between]))
    even = np.searchsorted(place, np.arange(551))
    columns = [np.interp(place, np.arange(551), column) for column in outputs.reshape(551, 4).T]
    runs: Runs = [[], *slips]
    moved = [[[int(even[a]), int(even[b])] for a, b in ridge_runs] for ridge_runs in runs]
    one = report(TIME[:551], by_name(outputs), NOISE / math.sqrt(2), WIDTH, runs, 550)
    more, gross = by_name(np.stack(columns, axis=1).reshape(-1, 2, 2)), int(even[550])
    other = report(place / RATE, more, NOISE / math.sqrt(2), WIDTH, moved, gross, even=even)
    assert len(one["events"]) > 1
    assert [e["step"] for e in other["events"]] == [even[e["step"]] for e in one["events"]]
    for e, same in zip(other["events"], one["events"], strict=True):
        assert e["time_s"] == pytest.approx(same["time_s"])
    assert other["lead_time_s"] == pytest.approx(one["lead_time_s"])
    assert other["event_score"] == one["event_score"]


def test_a_lead_has_its_spread_over_noises() -> None:
    """The smallest and the largest of what each noise gives alone; and how many of them warn at all."""
    clean, slips = small()
    draw = np.random.default_rng(9)
    noises = [20 * NOISE * k * draw.normal(size=clean.shape) for k in range(4)]
    noises.append(-clean)  # of these outputs nothing is left, so that none warns

    def report_of(outputs: np.ndarray, **more: Any) -> dict[str, Any]:
        runs: Runs = [[], *slips]
        return report(TIME[:551], by_name(outputs), NOISE / math.sqrt(2), WIDTH, runs, 550, EARLY, **more)

    every = [report_of(clean + noise)["lead_time_s"] for noise in [*noises, np.zeros_like(clean)]]
    spreads = report_of(clean, noises=noises)["lead_time_by_noise"]
    assert "lead_time_by_noise" not in report_of(clean)
    for ridge, spread in zip(("2", "3", "all"), spreads, strict=True):
        leads = [by_ridge[ridge] for by_ridge in every if by_ridge[ridge] is not None]
        assert len(leads) < 6
        ends = {"smallest_s": min(leads, default=None), "largest_s": max(leads, default=None)}
        assert spread == {"ridge": ridge, **ends, "warned": len(leads), "seeds": 6}


def test_of_a_stress_a_grippers_alarms_are_those_of_its_changes() -> None:
    """Also where the detector hears some of the steps alone."""
    network = circuit_network(fitted(load_circuit("charge-amplifier"), load_design("yamada-2002")))
    change = change_noise(GRIP, network, WIDTH, RATE)
    assert change is not None
    rates, slips = small()
    rates = rates * (change / NOISE)
    rates[0] = 0.0  # nothing has changed by the first sample
    runs: Runs = [[], *slips]
    right = report(TIME[:551], by_name(rates), change / math.sqrt(2), WIDTH, runs, 550, GRIP)
    twice, even = np.repeat(np.cumsum(rates, axis=0), 2, axis=0), np.arange(0, 1102, 2)
    time = np.arange(1102) / (2 * RATE)
    moved = [[[2 * a, 2 * b] for a, b in ridge_runs] for ridge_runs in runs]
    whole = report(time, by_name(twice), 1e-5, WIDTH, moved, 1100, GRIP, even, network=network)
    raw = report(time, by_name(twice), 1e-5, WIDTH, moved, 1100, GRIP, even)
    assert [e["step"] for e in whole["events"]] == [2 * e["step"] for e in right["events"]]
    assert whole["lead_time_s"] == pytest.approx(right["lead_time_s"])
    assert right["events"]
    assert raw["events"] != whole["events"]
    early = report(TIME[:551], by_name(rates), NOISE, WIDTH, runs, 550, EARLY, network=network)
    assert early == report(TIME[:551], by_name(rates), NOISE, WIDTH, runs, 550, EARLY)


@pytest.mark.slow
def test_the_papers_scene_is_reported_by_ridge() -> None:
    outputs = by_name(papers())
    runs: Runs = [[], *RUNS]
    result = report(TIME[:551], outputs, NOISE / math.sqrt(2), WIDTH, runs, 550, EARLY)
    assert [(e["kind"], e["ridge"]) for e in result["events"]] == [(AHEAD, None)]
    assert all(e["time_s"] == pytest.approx(e["step"] / RATE) for e in result["events"])
    assert result["event_score"] == {"hits": 0, "missed": 3, "false": 0, "misnamed": 0}
    assert result["warning_score"] == {"true": 1, "false": 0}
    assert [(e["true"], e["reason"]) for e in result["events"]] == [(True, None)]
    assert result["lead_time_s"]["all"] == pytest.approx((550 - result["events"][0]["step"]) / RATE)
    assert set(result["lead_time_s"]) == {"2", "3", "all"}
    assert result["detector"]["alarms"] == EARLY
    assert result["detector"]["share_of_gross_slips_warned_of"] == POINTS[EARLY].warned
    assert result["longest_lead_time_s"] == result["warning_lead_time_s"] == result["lead_time_s"]["all"]
    without_slip = report(TIME[:551], outputs, NOISE / math.sqrt(2), WIDTH, runs[:1] * 3, None, EARLY)
    assert without_slip["warning_score"] == {"true": 0, "false": 1}
    assert [e["reason"] for e in without_slip["events"]] == [NOT_AHEAD]
    ours = scored(KEEN.window, events(papers(), KEEN), RUNS, 550, 477)
    assert ours.hits >= 2
    assert ours.false == 0
    sure = report(TIME[:551], outputs, NOISE / math.sqrt(2), WIDTH, runs, 550, SURE)
    assert len(result["events"]) > len(sure["events"])


def test_nothing_is_reported_of_one_sample_without_films() -> None:
    nothing = dict.fromkeys(("longest_lead_time_s", "warning_lead_time_s", "warned_share", "event_score"))
    empty = report(TIME[:1], {}, NOISE, WIDTH, [[], *RUNS], None)
    assert empty == {"events": [], "lead_time_s": {}, **nothing}


@pytest.mark.parametrize(
    ("noise", "threshold"), [(0.0, 5.0), (math.nan, 5.0), (1.0, math.nan), (1.0, math.inf)]
)
def test_bad_constants_are_told(noise: float, threshold: float) -> None:
    with pytest.raises(InputError, match=r"must be (above 0|finite)"):
        Tuning(10, noise, threshold)


def test_early_alarms_are_more_than_sure_ones() -> None:
    better, worse = (POINTS[kind] for kind in (EARLY, SURE))
    assert better.warned > worse.warned
    assert better.false > worse.false
    assert better.held > worse.held
    assert better.grip > worse.grip
    assert all(p.between[0] < p.warned < p.between[1] for p in (better, worse))
    assert all(p.held_between[0] < p.held < p.held_between[1] for p in POINTS.values())
    assert (D.threshold, D.warning) == (better.threshold, better.warning)


@pytest.mark.evidence(subject="yamada-2002-slip: alarms")
@pytest.mark.parametrize("masses", [True, False])
@pytest.mark.parametrize("seed", [None, 1])
def test_the_papers_scene_is_warned_of_before_gross_slip(seed: int | None, masses: bool) -> None:
    """With and without noise and the skin's mass; ridges 2 and 3 slip 0.7 and 0.5 to 0.6 ms before all do,
    and a warning may take a window and a half, 0.23 ms."""
    more = ["readout.alarms=early", f"effects.small_strain.masses={str(masses).lower()}"]
    more += [f"effects.piezo.noise_seed={seed}"] * (seed is not None)
    data = felt(1, "yamada-2002-slip", *more)
    # with masses the slip that ends at step 200 is taken for one that lasts
    assert data["warning_score"]["false"] <= int(masses)
    assert data["event_score"]["false"] == 0
    assert data["lead_time_s"]["all"] > 0.45e-3


@pytest.mark.slow
def test_a_scene_hears_a_stress_as_a_robot_does() -> None:
    piezo = ["effects.piezo.circuit=charge-amplifier", "effects.piezo.noise_seed=1"]
    scene = load_scene("steady-pull", [*piezo, "readout.alarms=grip", "readout.ridges=[2, 3]"])
    simulation = at_level(scene, LEVELS[0])
    outputs, time, even = simulation.read["output_V"], simulation.march.time, scene.history.even
    even = even[even < time.size]
    rate, band = 1 / float(np.diff(time[even[:2]])[0]), scene.readout.bandwidth_Hz
    robot = Detector(scene.design, "charge-amplifier", rate, (2, 3), alarms=GRIP, bandwidth=band)
    values = np.stack([outputs[r][side] for r in "23" for side in ("S1", "S2")], axis=1)
    right = [int(even[alarm.index]) for alarm in robot.feed(values[even])]
    assert [event["step"] for event in simulation.read["events"]] == right
    assert right


@pytest.mark.slow
def test_what_is_printed_of_alarms_names_the_monitored_ridges_and_the_noise(tmp_path: Path) -> None:
    piezo = ["effects.piezo.circuit=yamada-2002", "effects.piezo.noise_seed=1"]
    settings = [*piezo, "readout.alarms=early", "readout.ridges=[2, 3]", "readout.bandwidth_Hz=10000.0"]
    simulation = at_level(load_scene("steady-pull", settings), LEVELS[0])
    lines = [line.split(maxsplit=1) for line in simulation.details().split("\n")]
    felt = [words for key, words in lines if key == "felt"]
    assert sum("gross slip ahead at step" in words for words in felt) >= 1
    (warned,) = (words for key, words in lines if key == "warned" and "by ridge 2" in words)
    assert re.search(r"\([\d.]+ to [\d.]+ ms with 20 of 20 noise seeds\)", warned)
    score = simulation.read["warning_score"]
    if score["false"]:
        assert f"{score['false']} of {score['true'] + score['false']} warnings: no" in simulation.details()
    warnings = [event for event in simulation.read["events"] if event["ridge"] is None]
    assert sum(not event["true"] for event in warnings) == score["false"]
    write_table(simulation, tmp_path / "signals.csv")  # of what is told by step alone
    assert "lead" not in (tmp_path / "signals.csv").read_text().split("\n")[0]


WINDOW = 12
DRAWN = np.random.default_rng(1).normal(size=(300, 3, 2)).cumsum(axis=0) / 30


def feature_values(outputs: np.ndarray, noise: float = NOISE) -> np.ndarray:
    return features.features(WINDOW, noise, outputs, features.at_rest(outputs.shape[1]))[0]


def test_a_mean_by_hand() -> None:
    values = features.means(WINDOW, DRAWN, features.at_rest(3))[0]
    pair = DRAWN[:, :, 0] - DRAWN[:, :, 1]
    for k, span in enumerate(features.SPANS, 1):
        mean, share = np.zeros(3), 1 / (1 + span * WINDOW)
        for value in pair:
            mean = mean + share * (value - mean)
        np.testing.assert_allclose(values["pair"][k][-1], mean, rtol=1e-9)  # rounding of 300 steps
    np.testing.assert_array_equal(values["pair sum"][0], pair * DRAWN.sum(axis=2))


def test_features_are_the_same_to_either_side() -> None:
    """A mirror exchanges S1 with S2 and the order of ridges."""
    mirrored = DRAWN[:, ::-1, ::-1]
    np.testing.assert_allclose(
        feature_values(mirrored)[:, ::-1], feature_values(DRAWN), atol=1e-9
    )  # sums in another order


@pytest.mark.parametrize("unit", [1e-6, 1e3])
def test_features_have_no_unit(unit: float) -> None:
    np.testing.assert_allclose(feature_values(unit * DRAWN, unit * NOISE), feature_values(DRAWN), atol=1e-9)


def test_features_stay_finite_and_bounded_at_rest_and_when_loud() -> None:
    for size in (0.0, 1.0, 1e9):
        values = feature_values(size * DRAWN)
        assert np.isfinite(values).all()
        assert np.abs(values).max() < 16  # logarithms of up to 1e12 noise rms, by 4


def test_others_are_the_mean_of_the_others() -> None:
    values = np.array([[1.0, 2.0, 6.0]])
    np.testing.assert_array_equal(features.of_others(values), [[4.0, 3.5, 1.5]])
    np.testing.assert_array_equal(features.of_others(values[:, :1]), [[0.0]])


def test_beside_is_the_next_told_ridge_where_it_is_pulled_to() -> None:
    values, right = np.array([[1.0, 2.0, 6.0]]), np.ones((1, 3))
    np.testing.assert_array_equal(features.beside(values, right, True), [[2.0, 6.0, 0.0]])
    np.testing.assert_array_equal(features.beside(values, right, False), [[0.0, 1.0, 2.0]])
    np.testing.assert_array_equal(features.beside(values, -right, True), [[0.0, 1.0, 2.0]])


def test_bounded_is_itself_where_small() -> None:
    assert features.bounded(np.array(0.01)) == pytest.approx(0.01, rel=1e-5)
    assert abs(features.bounded(np.array(-1e6))) <= features.MOST


def test_noise_rms_of_the_last_window() -> None:
    """White noise of 3 rms of a pair's: its running power is within what 300 samples of it scatter."""
    noise = np.random.default_rng(2).normal(0, 3 * NOISE / np.sqrt(2), (3000, 2, 2))
    loud = features.features(WINDOW, NOISE, noise, features.at_rest(2))[1]
    assert np.median(loud[500:]) == pytest.approx(3, rel=0.1)
