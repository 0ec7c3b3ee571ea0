"""The clock of checks in tests: the same design gets the same models on any machine."""

from __future__ import annotations

import sys
import time
from itertools import count

import pytest

from skincad import check, load
from skincad.mechanics import MODELS, ContactCheck
from tests.clock import SECONDS_A_RIDGE, PriceClock

DESIGN = load("plain-ridges", ["ridge.count=3", "skin.width=5.0", "contact.force=1.0"])


def steps(verdict: ContactCheck) -> list[tuple[str, float]]:
    """The models that a check took, and their seconds."""
    tried = [(run.model, round(run.seconds, 6)) for run in verdict.models_tried]
    return [*tried, (verdict.model, round(verdict.seconds["total"], 6))]


@pytest.fixture(scope="module")
def verdict() -> ContactCheck:
    return check(DESIGN)


@pytest.mark.slow
def test_a_busy_machine_changes_no_verdict(verdict: ContactCheck, monkeypatch: pytest.MonkeyPatch) -> None:
    minutes = count(step=60)
    modules = [m for name, m in sys.modules.items() if name.startswith("skincad.")]
    slow = [m for m in modules if getattr(m, "perf_counter", None) is time.perf_counter]
    assert {"skincad.base.adaptivity", "skincad.mechanics.models.linear"} <= {m.__name__ for m in slow}
    for module in slow:  # each reading is a minute after the one before
        monkeypatch.setattr(module, "perf_counter", lambda: float(next(minutes)))
    again = check(DESIGN)
    assert next(minutes) > 0
    assert steps(again) == steps(verdict)
    assert again.all_touch_force == verdict.all_touch_force


def test_models_take_their_price(verdict: ContactCheck) -> None:
    models = [model for model, _ in steps(verdict)]
    assert models[:2] == ["linear", "corrected"]
    price = sum(MODELS[name].price for name in set(models))
    # 0.1: readings of the clock, a thousandth of a second each
    assert verdict.seconds["total"] == pytest.approx(3 * SECONDS_A_RIDGE * price, abs=0.1)


@pytest.mark.usefixtures("real_clock")
def test_the_clock_can_be_set_back(price_clock: PriceClock) -> None:
    before = price_clock.now
    check(DESIGN, model="winkler")
    assert price_clock.now - before == pytest.approx(3 * SECONDS_A_RIDGE * MODELS["winkler"].price)
