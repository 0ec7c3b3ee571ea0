"""Formulas as MathML: well-formed, bracketed where it matters, with the numbers as printed."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from skincad.base import Calculation, Quantity
from skincad.outputs.pages import formula, formula_with_numbers

MINUS = "\u2212"  # as it is printed


def step(text: str, **values: float) -> Calculation:
    quantities = tuple(Quantity(name, "", value, "1") for name, value in values.items())
    return Calculation("a step", Quantity("F", "", 1.0, "N"), text, quantities, "nowhere")


def read(drawn: str) -> str:
    """What a reader sees, from left to right; a fraction's line as /."""
    root = ElementTree.fromstring(drawn)
    for fraction in root.iter("mfrac"):
        fraction[0].tail = "/"
    return "".join(root.itertext()).replace("\u2061", "").replace(MINUS, "-")


@pytest.mark.parametrize(
    ("text", "symbols", "numbers"),
    [
        ("a * (b + c)", "F=a·(b+c)", "F=2·(3+-4.5)"),
        ("a - (b - c)", "F=a-(b-c)", "F=2-(3-(-4.5))"),
        ("a / (b * c)", "F=a/b·c", "F=2/3·(-4.5)"),
        ("c**2", "F=c2", "F=(-4.5)2"),
        ("sin(a / b)**2", "F=sin2(a/b)", "F=sin2(2/3)"),
        ("sqrt(a + b)", "F=a+b", "F=2+3"),
        ("-a + b", "F=-a+b", "F=-2+3"),
    ],
)
def test_a_formula_reads_as_it_computes(text: str, symbols: str, numbers: str) -> None:
    calculation = step(text, a=2.0, b=3.0, c=-4.5)
    assert read(formula(calculation)) == symbols
    assert read(formula_with_numbers(calculation)) == numbers


def test_indices_primes_greek_letters_and_powers_of_ten() -> None:
    calculation = step("E1 * nu * c_b", E1=1e-12, nu=0.499, c_b=2.5e9)
    drawn = formula(calculation)
    assert "<msup><mi>E</mi><mo>\u2032</mo></msup>" in drawn
    assert "<mi>\u03bd</mi>" in drawn
    assert "<msub><mrow><mi>c</mi></mrow><mi>b</mi></msub>" in drawn
    assert read(formula_with_numbers(calculation)) == "F=1·10-12·0.499·2.5·109"


def test_what_each_ridge_has_stays_a_symbol_under_its_sum() -> None:
    many = Quantity("k_i", "", (1.0, 2.0), "N/mm")
    calculation = Calculation(
        "a sum", Quantity("F", "", 3.0, "N"), "sum(k_i * (g - k_i))", (many,), "nowhere"
    )
    assert read(formula_with_numbers(calculation)) == "F=∑iki·(g-ki)"
