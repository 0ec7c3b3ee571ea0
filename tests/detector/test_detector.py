"""The detector made for a design, a circuit, a rate and wired ridges: blocks, rest, state, bad input."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import skincad
from skincad.circuit import circuit_network, corner, fitted, load_circuit, total_density
from skincad.detector import AHEAD, BACK, INCIPIENT, Alarm, Detector, Tuning, taken
from tests.refusals import refused

RATE = 5000.0
RIDGES = (2, 3, 7)


def made(**more: object) -> Detector:
    return skincad.Detector("yamada-2002", "transimpedance", RATE, RIDGES, **more)  # type: ignore[arg-type]


def slipping(detector: Detector, seed: int = 1) -> np.ndarray:
    """A second of outputs `(5000, 6)` V: pulls that run and stop, ridge after ridge, in noise."""
    draw, noise = np.random.default_rng(seed), detector.tuning.noise
    pull = np.repeat(draw.normal(0, 60 * noise, 50), 100)
    lags = np.stack([np.roll(pull, 9 * k) * (1 - 0.3 * k) for k in range(3)], axis=1)
    press = np.repeat(draw.normal(0, 20 * noise, 50), 100)[:, None]
    strips = np.stack([press + lags, press - lags], axis=2).reshape(pull.size, 6) / 2
    return np.asarray(strips + draw.normal(0, noise / math.sqrt(2), strips.shape))


def test_it_alarms_by_ridge_and_of_the_whole_skin() -> None:
    alarms = made(alarms="early").feed(slipping(made()))
    assert {alarm.ridge for alarm in alarms} <= {*RIDGES, None}
    assert {(alarm.kind, alarm.ridge is None) for alarm in alarms} <= {(AHEAD, True), (INCIPIENT, False)}
    assert len(alarms) > 10
    assert [alarm.index for alarm in alarms] == sorted(alarm.index for alarm in alarms)


@pytest.mark.parametrize("every", [1, 2, 7])
@pytest.mark.parametrize("block", [1, 3, 64, 777])
def test_blocks_of_any_size_give_the_same(every: int, block: int) -> None:
    whole, pieces = made(every=every), made(every=every)
    outputs = slipping(whole)[:1600]
    found: list[Alarm] = []
    for start in range(0, outputs.shape[0], block):
        found += pieces.feed(outputs[start : start + block])
    assert found == whole.feed(outputs)
    assert found
    assert all((alarm.index + 1) % every == 0 for alarm in found)
    assert pieces.state == whole.state


def test_asked_less_often_it_says_the_same_where_it_is_asked() -> None:
    often, seldom, outputs = made(), made(every=5), slipping(made())
    np.testing.assert_array_equal(often.odds(outputs)[4::5], seldom.odds(outputs))


def test_what_is_quiet_need_not_be_asked() -> None:
    """The networks are skipped where no ridge is loud: alarms are those of the odds at each sample."""
    detector, outputs = made(), slipping(made())
    outputs[2000:4000] = np.random.default_rng(5).normal(0, detector.tuning.noise / math.sqrt(2), (2000, 6))
    levels = np.array([*[detector.tuning.threshold] * len(RIDGES), detector.tuning.warning])
    now = taken(np.zeros(len(RIDGES) + 1, bool), detector.odds(outputs), levels, BACK)
    rises = np.argwhere(now & ~np.concatenate([np.zeros_like(now[:1]), now[:-1]]))
    alarms = detector.feed(outputs)
    assert [(a.index, a.ridge) for a in alarms] == [(row, [*RIDGES, None][place]) for row, place in rises]
    assert len(alarms) >= 5


def test_a_grippers_alarms_are_of_the_skin_alone() -> None:
    """It says at each sample whether the grip is too weak: alarms are where that begins."""
    detector, outputs = made(alarms="grip"), slipping(made())
    alarms = made(alarms="grip").feed(outputs)
    asked, told = detector.decisions(outputs)
    assert {(alarm.kind, alarm.ridge) for alarm in alarms} == {(AHEAD, None)}
    assert not told[:, :-1].any()
    now = told[:, -1]
    begins = np.flatnonzero(now & ~np.concatenate([[False], now[:-1]]))
    assert [alarm.index for alarm in alarms] == begins.tolist() == asked[begins].tolist()
    with pytest.raises(skincad.InputError, match=r"state\.threshold: must be"):
        made().restore(detector.state)


def test_a_state_of_before_there_were_three_networks_goes_on() -> None:
    old = {key: made().state[key] for key in made().state if key not in ("network", "change", "last")}
    made().restore(old)
    with pytest.raises(skincad.InputError, match=r"state\.\w+: must be"):
        made(alarms="grip").restore(old)


@pytest.mark.parametrize("stress", [False, True])
def test_its_state_goes_on_in_another_process(stress: bool) -> None:
    make, outputs = (of_stress, stressed()) if stress else (made, slipping(made()))
    one, other = make(), make()
    one.rest(outputs[:100])
    one.feed(outputs[:2000])
    other.restore(json.loads(json.dumps(one.state)))
    alarms = one.feed(outputs[2000:])
    assert other.feed(outputs[2000:]) == alarms
    assert alarms
    assert other.state == one.state
    with pytest.raises(skincad.InputError, match=r"state\.every: must be 2"):
        make(every=2).restore(one.state)


def of_stress(**more: object) -> Detector:
    """A gripper's detector behind an amplifier whose outputs are the stress."""
    return skincad.Detector("yamada-2002", "charge-amplifier", RATE, RIDGES, alarms="grip", **more)  # type: ignore[arg-type]


def stressed() -> np.ndarray:
    """A second of outputs `(5000, 6)` V whose changes are pulls that run and stop, ridge after ridge."""
    change = of_stress().tuning.change
    assert change is not None
    return np.asarray(np.cumsum(slipping(made()), axis=0) * (change / made().tuning.noise))


@pytest.mark.parametrize("block", [1, 3, 64, 5000])
def test_of_a_stress_a_grippers_alarms_hear_what_it_changes_by(block: int) -> None:
    """They are, to the bit, those of a detector that is fed the differences, however the outputs are cut."""
    detector, outputs = of_stress(), stressed()[:1600]
    change = detector.tuning.change
    assert change is not None
    rates = np.diff(outputs, axis=0, prepend=outputs[:1])
    plain = Detector.of(replace(detector.tuning, noise=change, change=None), RIDGES, RATE)
    odds, right = plain.odds(rates), plain.feed(rates)
    np.testing.assert_array_equal(detector.odds(outputs), odds)
    found: list[Alarm] = []
    for start in range(0, outputs.shape[0], block):
        found += detector.feed(outputs[start : start + block])
        assert detector.feed(outputs[:0]) == []
    assert found == right
    assert len(found) >= 5
    assert detector.state["means"] == plain.state["means"]


@pytest.mark.parametrize(
    ("circuit", "alarms", "changes"),
    [
        ("charge-amplifier", "grip", True),
        ("voltage-follower", "grip", True),
        ("charge-amplifier", "sure", False),
        ("charge-amplifier", "early", False),
        ("transimpedance", "grip", False),
        ("single-supply", "grip", False),
        ("yamada-2002", "grip", False),
    ],
)
def test_changes_are_heard_of_a_stress_by_a_grippers_alarms_alone(
    circuit: str, alarms: str, changes: bool
) -> None:
    detector = skincad.Detector("yamada-2002", circuit, RATE, RIDGES, alarms=alarms)
    assert (detector.tuning.change is not None) == changes
    detector.feed(np.ones((2, 6)))
    assert (detector.state["last"] is not None) == changes


def test_the_noise_of_changes_is_that_of_film_amplifier_and_what_the_board_adds() -> None:
    """By adaptive quadrature; more noise is white, of which differences have twice the power."""
    network = circuit_network(fitted(load_circuit("charge-amplifier"), skincad.load_design("yamada-2002")))
    band = 0.4 * RATE

    def density(log: float) -> float:
        f = math.exp(log)
        power = total_density(network, np.array([f]))[0] / (1 + (2 * math.pi * f / corner(band)) ** 2) ** 2
        return float(power * f * 4 * math.sin(math.pi * f / RATE) ** 2)

    own = of_stress().tuning
    power = 2 * quad(density, math.log(0.1), math.log(RATE / 2))[0]
    assert own.change == pytest.approx(math.sqrt(power), rel=1e-4)  # its rule has 4000 points
    white = 3e-4  # V rms
    board = of_stress(noise=math.hypot(own.noise, white)).tuning
    assert board.noise == pytest.approx(math.hypot(own.noise, white))
    assert board.change == pytest.approx(math.sqrt(power + 2 * white**2), rel=1e-6)
    assert of_stress(noise=own.noise / 2).tuning.change == own.change


def test_the_first_sample_changes_nothing_and_rest_neither() -> None:
    """Outputs that stand at 1.65 V are quiet from the first sample on, at rest or not."""
    detector, rested, outputs = of_stress(), of_stress(), np.round(stressed() * 2.0**40) * 2.0**-40
    rested.rest(np.full((10, 6), 1.625))
    standing = np.full((10, 6), 1.625)  # few bits, so that sums and differences are exact
    assert detector.feed(standing) == rested.feed(standing) == []
    np.testing.assert_array_equal(detector.state["means"], np.zeros((6, 1, 30)))
    rested.rest(standing + 0.25)
    assert rested.feed(outputs + 1.625) == detector.feed(outputs + 1.625)
    assert rested.state["means"] == detector.state["means"]


def test_states_of_detectors_that_hear_otherwise_are_refused() -> None:
    state = of_stress().state
    with refused("state.change: must be None, as this detector was made"):
        Detector.of(replace(of_stress().tuning, change=None), RIDGES, RATE).restore(state)
    old = {key: value for key, value in state.items() if key not in ("change", "last")}
    with refused("state.change: must be "):  # its means are of outputs
        of_stress().restore(old)
    with refused("state.last: must have the shape (6,)"):
        of_stress().restore({**state, "last": [0.0, 0.0]})
    with refused("state.last: must have the shape (6,)"):
        of_stress().restore({**state, "count": 7, "last": None})
    with refused("change: must be above 0 V and finite, got 0"):
        Tuning(3, 1e-4, change=0.0)


def test_a_resting_voltage_changes_nothing() -> None:
    """The outputs of a single supply rest at half of it, each a little beside."""
    plain, biased, outputs = made(), made(), slipping(made())
    rest = 1.65 + 0.01 * np.arange(6)
    biased.rest(np.broadcast_to(rest, (10, 6)))
    there, here = biased.odds(outputs + rest), plain.odds(outputs)
    np.testing.assert_allclose(there, here, atol=1e-6)  # rounding of 1.65 V against microvolts


def test_its_noise_is_that_of_film_and_amplifier_in_the_band() -> None:
    network = circuit_network(fitted(load_circuit("transimpedance"), skincad.load_design("yamada-2002")))
    band = 0.4 * RATE

    def density(log: float) -> float:
        f = math.exp(log)
        power = total_density(network, np.array([f]))[0] / (1 + (2 * math.pi * f / corner(band)) ** 2) ** 2
        return float(power * f)

    power = quad(density, math.log(0.1), math.log(RATE / 2))[0]
    assert made().tuning.noise == pytest.approx(math.sqrt(2 * power), rel=1e-4)  # its rule has 4000 points
    assert made(noise=1e-3).tuning.noise == 1e-3


def test_what_is_not_given_is_the_circuits_and_the_skins() -> None:
    detector = skincad.Detector(skincad.load_design("yamada-2002"), skincad.load_circuit("transimpedance"))
    assert (detector.rate, detector.ridges) == (50_000.0, tuple(range(1, 10)))
    assert detector.channels[:3] == ((1, "S1"), (1, "S2"), (2, "S1"))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"ridges": (3, 10)}, "ridges: must be from 1 to 9, got 10"),
        ({"ridges": (3, 2)}, "ridges: must be one or more, each once, in their order"),
        ({"ridges": ()}, "ridges: must be one or more"),
        ({"rate": 0.0}, "rate: must be above 0 Hz"),
        ({"bandwidth": math.nan}, "bandwidth: must be above 0 Hz"),
        ({"noise": -1.0}, "noise: must be above 0 V"),
        ({"alarms": "surely"}, "must be one of sure, early"),
        ({"every": 0}, "every: must be at least 1"),
        ({"every": 2.5}, "every: must be at least 1 sample, a whole number"),
        ({"design": "plain-ridges"}, "design: needs a skin with a"),
        ({"circuit": "voltage-follower", "rate": None}, "rate: is missing"),
    ],
)
def test_what_cannot_be_made_is_refused(more: dict[str, object], words: str) -> None:
    given = {"design": "yamada-2002", "circuit": "transimpedance", "rate": RATE, "ridges": RIDGES, **more}
    with pytest.raises(skincad.InputError, match=words):
        skincad.Detector(**given)  # type: ignore[arg-type]


@pytest.mark.parametrize("key", ["means", "told", "rest", "count"])
@pytest.mark.parametrize("wrong", [None, [0.0, 0.0]])
def test_a_damaged_state_is_refused(key: str, wrong: object) -> None:
    state = made().state
    for damaged in ({**state, key: wrong}, {k: v for k, v in state.items() if k != key}):
        with pytest.raises(skincad.InputError, match=rf"state\.{key}: must have the shape"):
            made().restore(damaged)


def test_ridges_may_be_any_whole_numbers() -> None:
    ridges = np.array(RIDGES)
    json.dumps(skincad.Detector("yamada-2002", "transimpedance", RATE, ridges).state)  # type: ignore[arg-type]


def test_a_block_that_cannot_be_fed_feeds_nothing() -> None:
    detector = made()
    before, outputs = detector.state, slipping(detector)
    with pytest.raises(skincad.InputError, match=r"\(n, 6\): S1 and S2 of 3 ridges"):
        detector.feed(outputs[:, :5])
    outputs[17, 3] = math.nan
    with pytest.raises(skincad.InputError, match="row 17 of ridge 3 S2"):
        detector.feed(outputs)
    with pytest.raises(skincad.InputError, match="within 1e\\+09 times the noise"):
        detector.feed(np.full((1, 6), 1e200))
    assert detector.state == before
