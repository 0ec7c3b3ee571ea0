"""Searches of functions whose roots are known by hand."""

from __future__ import annotations

import math

import pytest

from skincad.studies.roots import CLOSE, Function, search

TOL = 1e-3  # relative to the wanted value
RISING: dict[str, tuple[Function, float, float]] = {  # function, wanted, root
    "line": (lambda x: 3 * x, 1.0, 1 / 3),
    "power": (lambda x: (0.05 + x) ** -1.5, 5.0, 5.0 ** (-1 / 1.5) - 0.05),
    "exponential": (lambda x: math.exp(8 * x), 100.0, math.log(100) / 8),
}


@pytest.mark.parametrize("name", RISING)
def test_a_monotone_function_is_solved_in_seven_evaluations(name: str) -> None:
    function, wanted, root = RISING[name]
    found = search(function, wanted, TOL * wanted, 40)
    assert found.exact
    assert len(found.seen) <= 7  # five that are spread, and two
    (x,) = found.roots
    assert abs(function(x) - wanted) <= TOL * wanted  # type: ignore[operator]
    assert x == pytest.approx(root, abs=2e-3)  # TOL over the smallest slope, relative, of the three


def test_all_crossings_are_found() -> None:
    found = search(lambda x: math.sin(9 * x), 0.5, 5e-4, 40)
    by_hand = [(math.asin(0.5) + turn) / 9 for turn in (0, 2 * math.pi)]
    by_hand += [(math.pi - math.asin(0.5) + turn) / 9 for turn in (0, 2 * math.pi)]
    # an error of 5e-4 over the slope there, 9 cos(asin 0.5)
    assert found.roots == pytest.approx(sorted(by_hand), abs=5e-4 / 7)


def test_a_pair_between_two_evaluations_is_found_by_the_extremum() -> None:
    found = search(lambda x: (x - 0.4) ** 2, 0.01, 1e-5, 40)
    assert found.roots == pytest.approx([0.3, 0.5], abs=1e-4)  # 1e-5 over the slope 0.2, doubled
    touching = search(lambda x: (x - 0.37) ** 2, 0.0, 1e-6, 40)
    assert touching.roots == pytest.approx([0.37], abs=1e-3)  # the root of the tolerance


def test_a_guide_of_the_same_shape_takes_three_evaluations() -> None:
    found = search(lambda x: (1 + 0.3 * x) * (0.05 + x) ** -1.5, 5.0, 0.02, 40, lambda x: (0.05 + x) ** -1.5)
    assert len(found.seen) <= 3
    assert len(found.roots) == 1


def test_a_guide_shows_crossings_that_a_few_evaluations_do_not() -> None:
    found = search(
        lambda x: (1 + 0.3 * x) * (2 + math.sin(9 * x)), 2.3, 2e-3, 40, lambda x: 2 + math.sin(9 * x)
    )
    assert len(found.roots) == 3
    assert len(found.seen) <= 9


def test_a_guide_that_is_wrong_misleads_nobody() -> None:
    found = search(lambda x: 3 * x + 1, 2.0, 1e-3, 40, lambda x: math.exp(-3 * x))
    assert found.exact
    assert found.roots == pytest.approx([1 / 3], abs=1e-3)


def test_a_guide_that_vanishes_tells_no_ratio_there() -> None:
    """As levelling does: the closed form needs no force at all where crests are level."""
    found = search(lambda x: 2.7 - 2.68 * x, 2.0, 0.01, 40, lambda x: max(2.2 * (1 - x), 1e-13), first=0.0)
    assert len(found.roots) == 1
    low, high = found.within(found.roots[0], 0.27)
    assert (low, high) == pytest.approx((0.43 / 2.68, 0.97 / 2.68), rel=0.1)  # the guide's own slope


def test_a_guide_with_holes_is_filled_and_one_of_no_sign_is_left_out() -> None:
    def holes(x: float) -> float | None:
        return None if x > 0.8 else 1 + x

    assert search(lambda x: 2 + 2 * x, 3.0, 1e-3, 40, holes).roots == pytest.approx([0.5], abs=1e-3)
    assert search(lambda x: 2 * x, 1.0, 1e-3, 40, lambda x: x - 0.3).roots == pytest.approx([0.5], abs=1e-3)


def test_a_jump_is_told_and_is_no_root() -> None:
    found = search(lambda x: 0.0 if x < 0.3 else 1.0, 0.5, 1e-3, 40)
    assert not found.roots
    assert found.jumps == pytest.approx([0.3], abs=CLOSE)


def test_where_there_is_no_value_the_end_of_values_is_approached() -> None:
    found = search(lambda x: None if x < 0.55 else 1 / (x - 0.5), 12.0, 0.05, 40)
    assert found.roots == pytest.approx([0.5 + 1 / 12], abs=1e-3)  # 0.05 over the slope 144, doubled


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
    found = search(lambda x: math.sin(9 * x), 0.5, 5e-4, 6)
    assert (found.exact, len(found.seen)) == (False, 6)
