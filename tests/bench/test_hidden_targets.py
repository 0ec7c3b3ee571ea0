"""Solving finds what random designs tell, by the closed form; `python -m bench.hidden_targets` takes finite
elements."""

from __future__ import annotations

import pytest

from bench.hidden_targets import HIT, MOST, ways, wide


@pytest.mark.parametrize("knobs", MOST)
def test_hidden_targets_are_hit_in_few_evaluations(knobs: int) -> None:
    entries = list(ways(20, 500, knobs, "winkler"))  # seeds that nothing was set on
    assert sum(way.hit for way in entries) >= 18, "\n".join(str(way) for way in entries if not way.hit)


@pytest.mark.slow
def test_sixty_hidden_targets_over_twelve_keys_are_not_denied() -> None:
    entries = list(ways(60, 0, 1, "winkler", "yamada-2002", wide("yamada-2002")))
    assert len({way.keys for way in entries}) >= 12
    assert not [str(way) for way in entries if way.missed > HIT]


@pytest.mark.slow  # an evaluation takes a second
def test_hidden_targets_that_the_closed_form_does_not_see_are_not_denied() -> None:
    blind = ("ridge.crown", "ridge.tip_fillet", "ridge.root_fillet", "skin.width")
    ranges = {key: ends for key, ends in wide("plain-ridges").items() if key in blind}
    entries = list(ways(12, 0, 1, "corrected", "plain-ridges", ranges))
    assert {way.keys for way in entries} == {(key,) for key in blind}
    assert not [str(way) for way in entries if way.missed > HIT]
