"""The detector made for a design, a circuit, a rate and wired ridges: blocks, rest, state, bad input."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from scipy.integrate import quad

import skincad
from skincad.circuit import circuit_network, corner, fitted, load_circuit, total_density
from skincad.detector import AHEAD, BACK, INCIPIENT, Alarm, Detector, taken

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


def test_its_state_goes_on_in_another_process() -> None:
    one, other, outputs = made(), made(), slipping(made())
    one.rest(outputs[:100])
    one.feed(outputs[:2000])
    other.restore(json.loads(json.dumps(one.state)))
    assert other.feed(outputs[2000:]) == one.feed(outputs[2000:])
    assert other.state == one.state
    with pytest.raises(skincad.InputError, match=r"state\.every: must be 2"):
        made(every=2).restore(one.state)


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
