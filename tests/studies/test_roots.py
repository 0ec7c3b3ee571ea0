"""Searches of functions whose roots are known by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from skincad.studies.roots import CLOSE, STEP, Function, search

TOL = 1e-3  # relative to the wanted value
RISING: dict[str, tuple[Function, float, float]] = {  # function, wanted, root
    "line": (lambda x: 3 * x, 1.0, 1 / 3),
    "power": (lambda x: (0.05 + x) ** -1.5, 5.0, 5.0 ** (-1 / 1.5) - 0.05),
    "exponential": (lambda x: math.exp(8 * x), 100.0, math.log(100) / 8),
}


@pytest.mark.parametrize("name", RISING)
def test_a_monotone_function_is_solved_in_seven_evaluations(name: str) -> None:
    function, wanted, root = RISING[name]
    match = search(function, wanted, TOL * wanted, 40)
    assert match.exact
    assert len(match.seen) <= 7  # five that are spread, and two
    (x,) = match.roots
    assert abs(function(x) - wanted) <= TOL * wanted  # type: ignore[operator]
    assert x == pytest.approx(root, abs=2e-3)  # TOL over the smallest slope, relative, of the three


def test_all_crossings_are_found() -> None:
    match = search(lambda x: math.sin(9 * x), 0.5, 5e-4, 40)
    by_hand = [(math.asin(0.5) + turn) / 9 for turn in (0, 2 * math.pi)]
    by_hand += [(math.pi - math.asin(0.5) + turn) / 9 for turn in (0, 2 * math.pi)]
    # an error of 5e-4 over the slope there, 9 cos(asin 0.5)
    assert match.roots == pytest.approx(sorted(by_hand), abs=5e-4 / 7)


def test_a_pair_between_two_evaluations_is_found_by_the_extremum() -> None:
    match = search(lambda x: (x - 0.4) ** 2, 0.01, 1e-5, 40)
    assert match.roots == pytest.approx([0.3, 0.5], abs=1e-4)  # 1e-5 over the slope 0.2, doubled
    touching = search(lambda x: (x - 0.37) ** 2, 0.0, 1e-6, 40)
    assert touching.roots == pytest.approx([0.37], abs=1e-3)  # the root of the tolerance


def test_a_guide_of_the_same_shape_takes_three_evaluations() -> None:
    match = search(lambda x: (1 + 0.3 * x) * (0.05 + x) ** -1.5, 5.0, 0.02, 40, lambda x: (0.05 + x) ** -1.5)
    assert len(match.seen) <= 3
    assert len(match.roots) == 1


def test_a_guide_shows_crossings_that_a_few_evaluations_do_not() -> None:
    match = search(
        lambda x: (1 + 0.3 * x) * (2 + math.sin(9 * x)), 2.3, 2e-3, 40, lambda x: 2 + math.sin(9 * x)
    )
    assert len(match.roots) == 3
    assert len(match.seen) <= 9


def test_a_guide_that_is_wrong_misleads_nobody() -> None:
    match = search(lambda x: 3 * x + 1, 2.0, 1e-3, 40, lambda x: math.exp(-3 * x))
    assert match.exact
    assert match.roots == pytest.approx([1 / 3], abs=1e-3)


def test_a_guide_that_vanishes_tells_no_ratio_there() -> None:
    """As levelling does: the closed form needs no force at all where crests are level."""
    match = search(lambda x: 2.7 - 2.68 * x, 2.0, 0.01, 40, lambda x: max(2.2 * (1 - x), 1e-13), first=0.0)
    assert len(match.roots) == 1
    low, high = match.within(match.roots[0], 0.27)
    assert (low, high) == pytest.approx((0.43 / 2.68, 0.97 / 2.68), rel=0.1)  # the guide's own slope


def test_a_guide_with_holes_is_filled_and_one_of_no_sign_is_left_out() -> None:
    def holes(x: float) -> float | None:
        return None if x > 0.8 else 1 + x

    assert search(lambda x: 2 + 2 * x, 3.0, 1e-3, 40, holes).roots == pytest.approx([0.5], abs=1e-3)
    assert search(lambda x: 2 * x, 1.0, 1e-3, 40, lambda x: x - 0.3).roots == pytest.approx([0.5], abs=1e-3)


def test_a_jump_is_told_and_is_no_root() -> None:
    match = search(lambda x: 0.0 if x < 0.3 else 1.0, 0.5, 1e-3, 40)
    assert not match.roots
    assert match.jumps == pytest.approx([0.3], abs=CLOSE)


def test_where_there_is_no_value_the_end_of_values_is_approached() -> None:
    match = search(lambda x: None if x < 0.55 else 1 / (x - 0.5), 12.0, 0.05, 40)
    assert match.roots == pytest.approx([0.5 + 1 / 12], abs=1e-3)  # 0.05 over the slope 144, doubled


def test_no_value_anywhere_and_none_that_is_wanted() -> None:
    nothing = search(lambda _: None, 1.0, 1e-3, 40)
    assert (nothing.roots, nothing.exact, len(nothing.seen)) == ([], True, 9)
    above = search(lambda x: 1 + x, 3.0, 1e-3, 40)
    assert (above.roots, above.exact) == ([], True)
    assert above.seen[1.0] == 2.0  # the nearest that there is
    guided = search(lambda x: 1 + x, 9.0, 1e-3, 40, lambda x: 1 + 0.9 * x)
    assert (guided.roots, guided.exact) == ([], True)
    assert guided.seen[1.0] == 2.0


def test_a_root_at_an_end_counts_and_a_constant_is_one_root() -> None:
    assert search(lambda x: 3 * x, 3.0, 1e-3, 40).roots == [1.0]
    assert len(search(lambda _: 1.0, 1.0, 1e-3, 40).roots) == 1


def test_what_is_used_up_is_said() -> None:
    match = search(lambda x: math.sin(9 * x), 0.5, 5e-4, 6)
    assert (match.exact, len(match.seen)) == (False, 6)


def shapes(seed: int) -> list[Function]:
    """Random functions that turn, are bent sharply, or have no value at first."""
    rng = np.random.default_rng(seed)
    turns, phase, above, middle, width, tilt, hole, steep = rng.uniform(0.05, 0.95, size=8).tolist()
    powers = rng.normal(size=6)
    return [
        lambda x: 1.1 + above + math.sin((1 + 8 * turns) * x + 6.3 * phase),
        lambda x: 2 + tilt * x + math.exp(-(((x - middle) / (0.07 + 0.33 * width)) ** 2) / 2),
        lambda x: 4 - (3 * turns if x < middle else 3 * tilt) * abs(x - middle),
        lambda x: (0.02 + above / 2 + x) ** (6 * phase - 3),
        lambda x: None if x < 0.9 * hole else 1 / (x - 0.9 * hole + 0.01 + steep / 5),
        lambda x: 5 + float(np.polyval(powers, 2 * x - 1)),
    ]


def test_no_hidden_value_is_denied_by_a_guide_that_sees_nothing() -> None:
    """Random values, and those of the extrema, which lie between all evaluations; a flat guide, and none."""
    grid = np.linspace(0.0, 1.0, 201)
    denied = []
    for seed in range(25):
        for number, function in enumerate(shapes(seed)):
            values = np.array([np.nan if (y := function(x)) is None else y for x in grid])
            chosen = np.random.default_rng(seed).choice(np.flatnonzero(np.isfinite(values)))
            for at in (chosen, np.nanargmax(values), np.nanargmin(values)):
                wanted = float(values[at])
                guide: Function | None = (lambda _: 1.0) if seed % 2 else None
                match = search(function, wanted, 5e-3 * abs(wanted), 40, guide, step=STEP)
                if not match.roots:
                    denied.append((seed, number, grid[at], wanted, match.complete))
    assert not denied


def test_a_sharp_extremum_beside_an_end_is_not_denied() -> None:
    for top in np.linspace(0.01, 0.11, 6):
        for rise, fall in ((1, 1), (3, 1), (1, 3), (6, 1)):
            match = search(
                lambda x, top=top, rise=rise, fall=fall: 4 - (rise if x < top else fall) * abs(x - top),
                4.0 - 0.007,
                0.008,
                40,
                step=STEP,
            )
            assert match.roots, (top, rise, fall)


def test_what_is_denied_is_nowhere_and_both_ends_were_looked_at() -> None:
    for seed in range(8):
        for function in shapes(seed):
            values = [y for x in np.linspace(0, 1, 2001) if (y := function(x)) is not None]
            spread = max(values) - min(values)
            for wanted in (max(values) + 0.1 * spread, min(values) - 0.1 * spread, max(values) + 9 * spread):
                match = search(function, wanted, 1e-3 * spread, 40, lambda _: 1.0, step=STEP)
                assert match.complete
                assert not match.roots
                assert {0.0, 1.0} <= match.seen.keys()
                assert len(match.seen) >= 5


def test_a_search_that_runs_out_is_not_complete() -> None:
    for most in range(1, 5):
        assert not search(lambda x: 1 + x, 9.0, 1e-3, most, lambda _: 1.0, step=STEP).complete


def test_a_value_beside_an_end_that_is_apart_is_found() -> None:
    """As where levelling of 0 is none at all: what holds beside it holds not there."""

    def apart(x: float) -> float:
        return 2.35 if x == 0 else 2.16 + 12 * x

    assert search(apart, 2.25, 0.01, 40, step=STEP, cuts=[0.0]).roots
    denied = search(apart, 1.9, 0.01, 40, step=STEP, cuts=[0.0])
    assert denied.complete
    assert not denied.roots


def test_a_narrow_stretch_with_values_is_looked_at_where_a_guide_has_them() -> None:
    def narrow(x: float) -> float | None:
        return 3 * x if 0.3 < x < 0.33 else None

    assert search(narrow, 0.95, 5e-3, 40, narrow, first=1.0, step=STEP).roots
