"""Error bars of random designs: they hold in 95 % of the cases, not ten times too wide in the median."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from bench.error_bars import TOPS, Row, groups, outcome
from bench.table_error_bars import table

HELD, WIDEST = 0.95, 10.0
SEEDS = [seed for seed in range(2, 12) if seed % TOPS]  # the whole 200: python -m bench.table_error_bars


def row(stated: float, true: float, *, top: bool = False) -> Row:
    return Row(1, "linear", "mesh", "approach", 1.0, stated, true, "order 4", top)


def test_a_bar_holds_what_lies_within() -> None:
    assert row(0.1, 0.1).held
    assert not row(0.1, 0.11).held
    assert row(0.2, 0.1).width == 2.0
    assert row(0.2, 0.0).width == np.inf


def test_the_top_rung_is_told_apart() -> None:
    found = dict(groups([row(0.1, 0.2), row(0.1, 0.05, top=True)]))
    assert set(found) == {("linear", "mesh", "approach", "above"), ("linear", "mesh", "approach", "top")}
    lines = table([row(0.1, 0.2), row(0.1, 0.05, top=True)])
    assert "0.0%" in lines[1]
    assert "1 (0.2 > 0.1)" in lines[1]
    assert "100.0%" in lines[2]


def test_a_seed_gives_the_same_rows_again() -> None:
    first, again = (outcome(25, solids=False, ends=False).rows for _ in range(2))
    assert first == again
    assert {r.tier for r in first} == {"winkler", "linear, tol 0.05", "linear, tol 0.005"}


@pytest.mark.slow
def test_bars_of_random_designs_hold(record_property: Callable[[str, object], None]) -> None:
    """By tier and part, over both quantities: of some 20 cases one may miss. Every other seed is also held
    against the model with free ends, which costs four times the rest."""
    rows = [r for seed in SEEDS for r in outcome(seed, solids=False, ends=seed % 2 == 0).rows]
    told = "\n".join(table(rows))
    record_property("summary", told)
    print(told)
    for key in dict.fromkeys((r.tier, r.part) for r in rows):
        mine = [r for r in rows if (r.tier, r.part) == key]
        assert np.mean([r.held for r in mine]) >= HELD, told
        assert np.median([r.width for r in mine]) <= WIDEST, told
