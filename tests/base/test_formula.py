"""Formulas as data: what is computed by them is what is drawn of them, and nothing else runs."""

from __future__ import annotations

import ast
import math

import pytest

from skincad.base import Calculation, Quantity
from skincad.base.formula import evaluated

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
