"""Numbers as data: an estimate never says more than its error allows, a formula is what is computed by it."""

from __future__ import annotations

import ast
import math
import operator

import numpy as np
import pytest

from skincad.base import Calculation, Estimate, Quantity, UnclearError
from skincad.base.formula import evaluated

FORCE = Estimate(2.5, 0.25, "N")  # all of it is exact in binary
NONE = Estimate(None, None, "N")


def test_its_float_is_the_value() -> None:
    assert float(FORCE) == FORCE.value
    assert math.sqrt(Estimate(4.0, None, "N")) == 2.0
    with pytest.raises(ValueError, match="has no value"):
        float(NONE)


def test_its_ends() -> None:
    assert (FORCE.lower, FORCE.upper) == (2.25, 2.75)
    for unknown in (NONE, Estimate(2.5, None, "N")):
        assert (unknown.lower, unknown.upper) == (None, None)


# a number, and what <, <=, >, >= say: True, False, or None for unclear
COMPARED = [
    (2.0, (False, False, True, True)),
    (2.25, (False, None, None, True)),
    (2.5, (None, None, None, None)),
    (2.75, (None, True, False, None)),
    (3, (True, True, False, False)),
    (math.inf, (True, True, False, False)),
    (math.nan, (None, None, None, None)),
]
OPERATORS = (operator.lt, operator.le, operator.gt, operator.ge)
REFLECTED = (operator.gt, operator.ge, operator.lt, operator.le)


def said(compare: object, *sides: object) -> bool | None:
    try:
        return compare(*sides)
    except UnclearError:
        return None


@pytest.mark.parametrize(("number", "answers"), COMPARED)
def test_a_comparison_holds_all_over_the_interval_or_is_unclear(number: float, answers: tuple) -> None:
    assert tuple(said(compare, FORCE, number) for compare in OPERATORS) == answers
    assert tuple(said(compare, number, FORCE) for compare in REFLECTED) == answers
    assert tuple(said(compare, FORCE, np.float64(number)) for compare in OPERATORS) == answers
    assert tuple(said(compare, np.float64(number), FORCE) for compare in REFLECTED) == answers


def test_without_error_a_comparison_is_exact() -> None:
    exact = Estimate(2.5, 0.0, "N")
    assert tuple(said(compare, exact, 2.5) for compare in OPERATORS) == (False, True, False, True)


def test_what_is_unknown_is_unclear_and_the_message_says_what_to_compare() -> None:
    for unknown in (NONE, Estimate(2.5, None, "N")):
        assert {said(compare, unknown, 4.0) for compare in OPERATORS} == {None}
    with pytest.raises(UnclearError, match=r"whether 2\.50 ± 0\.25 N is above or below 2\.6 N is unclear"):
        operator.lt(FORCE, 2.6)


def test_it_compares_with_numbers_alone() -> None:
    for other in (FORCE, "4", None):
        with pytest.raises(TypeError, match=f"not with {type(other).__name__}"):
            operator.lt(FORCE, other)
    same, other = Estimate(2.5, 0.25, "N"), Estimate(2.5, 0.25, "mm")
    assert (same == FORCE, other == FORCE) == (True, False)


def test_its_text() -> None:
    assert str(Estimate(2.6412, 0.217, "N")) == "2.64 ± 0.22 N"
    assert str(Estimate(2.6412, None, "N")) == "2.641 N"
    assert str(NONE) == "none"


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        (479.0, 411.0, "70 to 890 EUR"),
        (40.0, 90.0, "0 to 130 EUR"),
        (12.3, 1.0, "12.3 ± 1.0 EUR"),
        (0.5, 0.4, "0.10 to 0.90 EUR"),
        (0.0, 0.0, "0 EUR"),
    ],
)
def test_a_rough_number_is_read_as_a_range(value: float, error: float, words: str) -> None:
    assert Estimate(value, error, "EUR").span() == words


LENGTHS = Quantity("l_i", "lengths", (1.0, 2.0, 3.5), "mm")


def step(formula: str, *given: Quantity) -> Calculation:
    return Calculation("a step", Quantity("r", "result", 0.0, "1"), formula, given, "nowhere")


@pytest.mark.parametrize(
    ("formula", "value"),
    [("a + b * a", 50.0), ("(a - b) / b", -11 / 12), ("-a**2", -4.0), ("sqrt(b + 1) * pi", 5 * math.pi)],
)
def test_a_formula_is_pythons_arithmetic(formula: str, value: float) -> None:
    values = Quantity("a", "", 2.0, "1"), Quantity("b", "", 24.0, "1")
    assert step(formula, *values).recomputed() == pytest.approx(value)


def test_a_sum_runs_over_the_ridges_and_tells_its_terms() -> None:
    calculation = step("sum(l_i * a) / sum(l_i)", Quantity("a", "", 2.0, "1"), LENGTHS)
    assert calculation.recomputed() == 2.0
    assert [terms for _, terms in calculation.sums()] == [[2.0, 4.0, 7.0], [1.0, 2.0, 3.5]]


def test_numbers_are_taken_as_they_are_printed() -> None:
    assert step("a", Quantity("a", "", 0.1234567, "mm")).recomputed() == 0.12346


@pytest.mark.parametrize("formula", ["a if a else 1", "__import__('os')", "a.real", "a @ a", "a % 2", "[a]"])
def test_nothing_but_arithmetic_is_a_formula(formula: str) -> None:
    with pytest.raises((ValueError, KeyError)):
        evaluated(ast.parse(formula, mode="eval").body, {"a": 1.0})
