"""Random scenes: the same for a seed, within the ranges that are stated, of every kind."""

from __future__ import annotations

import numpy as np

from bench import table_left_out, table_swaying
from bench.random_scenes import PERIODS, slowest


def test_a_seed_draws_the_same_scenes() -> None:
    one, other = (list(table_left_out.scenes(5, 3)) for _ in range(2))
    assert [entry.to_toml() for entry in one] == [entry.to_toml() for entry in other]
    assert one[0].to_toml() != next(table_left_out.scenes(6, 1)).to_toml()


def test_scenes_are_of_every_kind_and_in_the_ranges() -> None:
    entries = list(table_left_out.scenes(5, 40))
    for scene in entries:
        ramps = np.diff(scene.history.time_s)[::2] * slowest(scene.design)
        # numbers are written with five digits
        assert ((ramps > PERIODS[0] * 0.99) & (ramps < PERIODS[1] * 1.01)).all()
        assert scene.readout.ridges == list(range(1, scene.design.ridge.count + 1))
    pulls = [s.history.tangential_force_N or s.history.displacement_mm or [] for s in entries]
    kinds = {
        "driven": [s.history.tangential_force_N is None for s in entries],
        "pulled": [any(pull) for pull in pulls],
        "film": ["film" in s.effects for s in entries],
        "tilted": [bool(s.design.slot and s.design.slot.tilt) for s in entries],
        "shipped": [s.design.name != "yamada-2002" for s in entries],
    }
    for name, pull in kinds.items():
        assert 0 < sum(pull) < len(pull), name


def test_the_table_of_swaying_draws_scenes_too() -> None:
    rng = np.random.default_rng(1)
    scene = table_swaying.drawn(rng)
    assert scene.history.steps == table_swaying.STEPS
    assert scene.effects["friction"]["coefficient"] > 0


def test_a_change_is_the_largest_one_by_the_largest_signal_without() -> None:
    without, named = np.array([[0.0, 1.0], [-4.0, 2.0], [9.0, 9.0]]), np.array([[0.5, 1.0], [-4.0, 3.0]])
    assert table_left_out.change(without, named) == 0.1 + 0.15


def test_misses_are_counted_by_both_factors() -> None:
    rows = [table_left_out.Compared("film", entry, 3.0, 1.0) for entry in (0.4, 1.0, 2.5, 4.0)]
    answer = table_left_out.held(rows)
    assert "within 2 in 1 of 4" in answer
    assert "within its own in 3 of 4" in answer
    assert "3 4 times" in answer
