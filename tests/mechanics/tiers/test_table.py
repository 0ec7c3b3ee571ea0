"""The ladder of models: what builds on what."""

from __future__ import annotations

import pytest

from skincad.base.errors import InputError
from skincad.mechanics.tiers.linear import RUNGS
from skincad.mechanics.tiers.prices import LAWS
from skincad.mechanics.tiers.table import AUTO, TIERS, below, tier_of


@pytest.mark.parametrize("name", TIERS)
def test_a_tier_comes_after_all_that_it_builds_on(name: str) -> None:
    order = [*below(name), name]
    assert len(set(order)) == len(order)
    for i, each in enumerate(order):
        assert set(TIERS[each].on) <= set(order[:i])


def test_what_builds_on_nothing_has_nothing_below() -> None:
    assert below("linear") == []
    assert below("corrected-finite-strain") == ["linear", "corrected", "finite-strain"]


def test_every_tier_has_its_law_of_time_and_auto_climbs_by_price() -> None:
    assert set(LAWS) == set(TIERS)
    prices = [TIERS[name].price for name in AUTO]
    assert prices == sorted(prices)


def test_a_tier_is_had_by_its_name_alone() -> None:
    assert all(tier_of(name) is TIERS[name] for name in TIERS)
    with pytest.raises(InputError, match="did you mean 'linear'"):
        tier_of("lineer")


def test_finer_rungs_are_nearer_and_the_finest_is_taken_whatever_is_asked() -> None:
    usual = [rung.usual for rung in RUNGS]
    assert usual == sorted(usual, reverse=True)
    assert usual[-1] == 0.0
    assert [(rung.fineness, rung.order) for rung in RUNGS] == sorted({(r.fineness, r.order) for r in RUNGS})
    assert all(rung.price >= 1 for rung in RUNGS)
