"""The detector of slip: no look-ahead, pieces as at once, what alarms and what does not, and its score."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from skincad.base.errors import InputError
from skincad.circuit.low_pass import band_limited, delay
from skincad.scenes.levels import LEVELS
from skincad.scenes.scene import load_scene
from skincad.scenes.simulation import at_level
from skincad.scenes.slip import (
    ALL,
    EARLY,
    INCIPIENT,
    POINTS,
    SURE,
    Detector,
    Event,
    at_rest,
    detector,
    fed,
    report,
    score,
    statistic,
)

RATE, WIDTH, NOISE = 1e5, 5000.0, 1e-3  # rate and band of the paper's scene
TIME = np.arange(600) / RATE
D = detector(RATE, WIDTH, NOISE)


def behind(*rates: np.ndarray) -> np.ndarray:
    """Outputs `(n, ridges, 2)` of pairs behind the low-pass, S1 + S2 being 0."""
    values = [band_limited(TIME, np.asarray(r, float), WIDTH).value for r in rates]
    return np.stack([np.stack([v / 2, -v / 2], axis=1) for v in values], axis=1)


def pieces(*points: tuple[int, float]) -> np.ndarray:
    """Constant from each step on."""
    found = np.zeros(TIME.size)
    for at, value in points:
        found[at:] = value
    return found


def felt(level: int, scene: str, *settings: str) -> dict[str, Any]:
    asked = ["effects.piezo.circuit=transimpedance", "readout.ridges=[2, 3]", *settings]
    return at_level(load_scene(scene, asked), LEVELS[level]).as_json()


@cache
def papers() -> np.ndarray:
    """Outputs of ridges 2 and 3 in the paper's scene, in a unit in which a pair's noise is NOISE.

    Ridge 2 slips from step 186 to 200 and from 477 on, ridge 3 from 488 on, all do at 550.
    """
    found = felt(1, "yamada-2002-slip")
    strips = [[found["output_V"][r][side] for side in ("S1", "S2")] for r in "23"]
    return np.moveaxis(np.array(strips), 2, 0) * NOISE / (math.sqrt(2) * found["output_noise_V_rms"])


RUNS = [[[186, 200], [477, 550]], [[488, 550]]]


def events(outputs: np.ndarray) -> list[Event]:
    return fed(D, at_rest(outputs.shape[1]), outputs)[0]


def test_each_slip_is_told_once_and_then_that_all_do() -> None:
    """Ridge 2 sticks again in between, so that its first slip does not count for gross slip."""
    found = events(papers())
    assert [(e.kind, e.ridge) for e in found] == [
        (INCIPIENT, 0),
        (INCIPIENT, 1),
        (INCIPIENT, 0),
        (ALL, None),
    ]
    # 0.2 ms, a window and a third: the low-pass's delay is 0.04 ms
    late = [e.index - at for e, at in zip(found, (186, 488, 477, 488), strict=True)]
    assert [0 < steps <= 20 for steps in late] == [True] * 4


def test_it_hears_the_same_on_the_other_side() -> None:
    """Mirrored, S1 and S2 change places, and so do the ridges."""
    other = [
        (e.kind, None if e.ridge is None else 1 - e.ridge, e.index) for e in events(papers()[:, ::-1, ::-1])
    ]
    assert other == [(e.kind, e.ridge, e.index) for e in events(papers())]


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("cuts", [range(552), [0, 7, 8, 180, 190, 490, 551], [0, 550, 551], [0, 0, 551]])
def test_in_pieces_as_at_once(cuts: list[int], side: int) -> None:
    """Sample by sample, and by other pieces, an empty one too: the same events, and the same bits."""
    noise = np.random.default_rng(1).normal(0.0, NOISE / math.sqrt(2), papers().shape)
    noisy = papers()[:, ::side, ::side] + noise
    whole, end = fed(D, at_rest(2), noisy)
    state, found, seen = at_rest(2), [], []
    for a, b in pairwise(cuts):
        seen.append(statistic(D, state, noisy[a:b])[0])
        some, state = fed(D, state, noisy[a:b])
        found += some
    assert found == whole
    assert len(whole) >= 2
    np.testing.assert_array_equal(np.concatenate(seen), statistic(D, at_rest(2), noisy)[0])
    np.testing.assert_array_equal(state.means, end.means)
    np.testing.assert_array_equal(state.slipping, end.slipping)
    assert state.count == end.count == 551


@pytest.mark.parametrize("now", [0, 185, 192, 300, 489])
def test_what_comes_later_changes_nothing_before(now: int) -> None:
    other = papers().copy()
    other[now + 1 :] = np.random.default_rng(2).normal(0.0, 10.0, other[now + 1 :].shape)
    early, changed = ([e for e in events(x) if e.index <= now] for x in (papers(), other))
    assert early == changed
    assert np.abs(other - papers()).max() > 1.0


def test_its_state_is_all_it_keeps_and_is_not_changed() -> None:
    state = at_rest(2)
    before = state.means.copy(), state.slipping.copy()
    one, other = (fed(D, state, papers())[0] for _ in range(2))
    assert one == other
    for kept, now in zip(before, (state.means, state.slipping), strict=True):
        np.testing.assert_array_equal(kept, now)


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


def test_pressing_is_no_slip() -> None:
    assert felt(0, "yamada-2002-press", "effects.piezo.noise_seed=1")["events"] == []


def test_noise_alone_does_not_alarm() -> None:
    """White noise, 200 000 decisions: none beyond the threshold, so no event; a window's mean reaches 2.9 rms
    and SEEN is 5."""
    noise = np.random.default_rng(3).normal(0.0, NOISE / math.sqrt(2), (100_000, 2, 2))
    assert statistic(D, at_rest(2), noise)[0].max() < POINTS[SURE].threshold


def test_the_window_grows_with_the_low_passs_delay() -> None:
    assert D.window == math.ceil(3.5 * delay(WIDTH) * RATE)
    assert detector(RATE, WIDTH / 10, NOISE).window == pytest.approx(10 * D.window, abs=10)
    assert detector(10.0, WIDTH, NOISE).window == 3


def test_a_score_by_hand() -> None:
    d = Detector(10, NOISE)
    runs = [[[100, 120], [300, 400]], [[200, 203], [350, 400]]]
    alarms = [Event(INCIPIENT, 0, 95), Event(INCIPIENT, 0, 310), Event(INCIPIENT, 0, 330)]
    alarms += [Event(INCIPIENT, 1, 50), Event(ALL, None, 20), Event(ALL, None, 340)]
    found = score(d, alarms, TIME, runs, 400)
    # ridge 0's both runs; ridge 1's short one is not asked for, its other is missed; the gross slip that
    # follows an alarm makes it a warning, however early
    assert (found.hits, found.missed, found.false) == (2, 1, 1)
    assert found.lead == (pytest.approx(90e-5), None)
    assert found.gross_lead == pytest.approx(60e-5)
    without = score(d, alarms, TIME, runs, None)
    assert (without.false, without.lead, without.gross_lead) == (3, (None, None), None)
    other = score(d, [Event(INCIPIENT, 1, 110), Event(INCIPIENT, 1, 140)], TIME, runs, None)
    assert (other.false, other.misnamed) == (1, 1)  # ridge 0 slips at the first of them, none at the second


def test_always_and_never_alarming_have_the_scores_that_they_deserve() -> None:
    runs = RUNS
    never = score(D, [], TIME, runs, 550)
    always = [Event(INCIPIENT, r, i) for i in range(0, 551, D.window) for r in (0, 1)]
    ever = score(D, always, TIME, runs, 550)
    assert (never.hits, never.missed, never.false) == (0, 3, 0)
    assert (ever.hits, ever.missed) == (3, 0)
    assert ever.false > 40
    ours = score(D, events(papers()), TIME, runs, 550)
    assert (ours.hits, ours.missed, ours.false) == (3, 0, 0)


def test_the_report_has_steps_and_lead_times_by_ridge() -> None:
    outputs = {
        name: {side: papers()[:, i, k].tolist() for k, side in enumerate(("S1", "S2"))}
        for i, name in enumerate(("2", "3"))
    }
    runs: list[list[list[int]]] = [[], *RUNS]
    found = report(TIME[:551], outputs, NOISE / math.sqrt(2), WIDTH, runs, 550)
    assert [(e["kind"], e["ridge"]) for e in found["events"]] == [
        (INCIPIENT, 2),
        (INCIPIENT, 3),
        (INCIPIENT, 2),
        (ALL, None),
    ]
    assert all(e["time_s"] == pytest.approx(e["step"] / RATE) for e in found["events"])
    assert found["event_score"] == {"hits": 3, "missed": 0, "false": 0, "misnamed": 0}
    assert found["lead_time_s"]["2"] == pytest.approx((550 - found["events"][2]["step"]) / RATE)
    assert set(found["lead_time_s"]) == {"2", "3", "all"}
    told = found["detector"]
    assert told["alarms"] == SURE
    assert told["share_of_gross_slips_warned_of"] == POINTS[SURE].warned
    assert found["longest_lead_time_s"] == found["lead_time_s"]["3"]
    empty = report(TIME[:1], {}, NOISE, WIDTH, runs, None)
    assert empty == {"events": [], "lead_time_s": {}, "longest_lead_time_s": None, "event_score": None}


@pytest.mark.parametrize(
    ("noise", "threshold"), [(0.0, 5.0), (math.nan, 5.0), (1.0, math.nan), (1.0, math.inf)]
)
def test_bad_constants_are_told(noise: float, threshold: float) -> None:
    with pytest.raises(InputError, match=r"must be (above 0|finite)"):
        detector(RATE, WIDTH, noise, threshold)


def test_early_alarms_are_more_and_told_as_such() -> None:
    """They come of another network, and none of them of noise alone."""
    outputs = {
        name: {side: papers()[:, i, k].tolist() for k, side in enumerate(("S1", "S2"))}
        for i, name in enumerate(("2", "3"))
    }
    runs: list[list[list[int]]] = [[], *RUNS]
    sure, early = (
        report(TIME[:551], outputs, NOISE / math.sqrt(2), WIDTH, runs, 550, alarms) for alarms in POINTS
    )
    assert early["detector"]["alarms"] == EARLY
    assert early["event_score"]["hits"] == 3
    assert len(early["events"]) > len(sure["events"])
    better, worse = (POINTS[kind] for kind in (EARLY, SURE))
    assert better.warned > worse.warned
    assert better.false > worse.false
    assert all(p.between[0] < p.warned < p.between[1] for p in POINTS.values())
    d = detector(RATE, WIDTH, NOISE, alarms=EARLY)
    assert d.threshold == better.threshold
    noise = np.random.default_rng(3).normal(0.0, NOISE / math.sqrt(2), (100_000, 2, 2))
    assert fed(d, at_rest(2), noise)[0] == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", [None, 1])
def test_the_papers_scene_is_warned_of_before_gross_slip(seed: int | None) -> None:
    """With and without noise; ridge 2 slips from step 186 to 200 and sticks again, which is told too."""
    found = felt(1, "yamada-2002-slip", *([] if seed is None else [f"effects.piezo.noise_seed={seed}"]))
    assert found["event_score"] == {"hits": 3, "missed": 0, "false": 0, "misnamed": 0}
    # ridges 2 and 3 slip 0.73 and 0.62 ms before all do; an alarm may take a window of 0.15 ms
    assert found["lead_time_s"]["2"] > 0.55e-3
    assert found["lead_time_s"]["3"] > 0.45e-3
    assert found["lead_time_s"]["all"] == min(found["lead_time_s"][ridge] for ridge in "23")


def test_a_hold_is_no_slip() -> None:
    found = felt(0, "hold", "history.steps=100", "readout.bandwidth_Hz=80.0", "effects.piezo.noise_seed=1")
    assert found["events"] == []
    assert found["event_score"] == {"hits": 0, "missed": 0, "false": 0, "misnamed": 0}
