"""The calculation report by hand: the printed formula with the printed numbers gives the printed result."""

from __future__ import annotations

import ast
import math
import re
from itertools import chain
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import skincad
from skincad.circuit import without_rig
from skincad.fabrication import Job
from skincad.inputs import Design, template_names
from skincad.outputs import calculations
from skincad.outputs.calculations import Calculation, Quantity
from skincad.outputs.pages import html
from tests.designs import RIDGED

VARIANTS: dict[str, dict[str, object]] = {
    "levelled": {"ridge": {"levelling": 0.6}},
    "even count": {"ridge": {"count": 8}},
    "one ridge": {"ridge": {"count": 1}},
    "own heights": {"ridge": {"count": 3, "heights": [0.5, 0.52, 0.49]}, "skin": {"width": 5.0}},
    "tilted plate": {"contact": {"plate": {"shape": "tilted", "tilt": 1.0}}},
    "few touch": {"contact": {"force": 0.05}},
    "shrinks much": {"mold": {"shrinkage": 0.03}},
    "doubly curved": {"skin": {"curvature_radius_y": 60.0}, "slot": None, "ridge": {"count": 3}},
}


def design_of(name: str) -> Design:
    return skincad.load("yamada-2002").with_(**VARIANTS[name]) if name in VARIANTS else skincad.load(name)


def steps(design: Design) -> list[Calculation]:
    return [
        *calculations.contact_calculations(design, 0.6),
        *calculations.casting_calculations(Job(design)),
        *calculations.strip_calculations(design),
    ]


FUNCTIONS = {"sin": np.sin, "sqrt": np.sqrt, "sum": np.sum, "pi": np.pi}
ARITHMETIC = (
    *(ast.Expression, ast.Constant, ast.Name, ast.Load, ast.Call, ast.UnaryOp, ast.USub, ast.BinOp),
    *(ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow),
)


def printed(quantity: Quantity) -> Any:
    """The number as it is printed, to five digits, or one of each ridge."""
    if isinstance(quantity.value, tuple):
        return np.array([float(f"{value:.5g}") for value in quantity.value])
    return float(f"{quantity.value:.5g}")


def at(step: Calculation, values: dict[str, Any]) -> float:
    """The result by the formula for these values of the given symbols."""
    tree = ast.parse(step.formula, mode="eval")
    assert all(isinstance(node, ARITHMETIC) for node in ast.walk(tree)), step.formula
    return float(eval(compile(tree, step.title, "eval"), {"__builtins__": {}}, {**FUNCTIONS, **values}))


def recomputed(step: Calculation) -> float:
    """The result by the formula from the numbers as they are printed."""
    return at(step, {quantity.symbol: printed(quantity) for quantity in step.given})


def half_a_digit(value: float) -> float:
    """Half of the last digit that is printed; what printing may have taken away."""
    if float(f"{value:.5g}") == value:
        return 0.0
    return 0.5 * 10 ** (math.floor(math.log10(abs(value))) - 4)


def unsure(step: Calculation) -> float:
    """By how much the formula's result may be off because its numbers are rounded: a full step of each."""
    values = {quantity.symbol: printed(quantity) for quantity in step.given}
    parts = []
    for quantity in step.given:
        numbers = quantity.value if isinstance(quantity.value, tuple) else (quantity.value,)
        by = np.array([half_a_digit(value) for value in numbers])
        for i in np.flatnonzero(by):
            moved = np.array(np.atleast_1d(values[quantity.symbol]), dtype=float)
            moved[i] += by[i]
            changed = moved if isinstance(quantity.value, tuple) else float(moved[0])
            parts.append(abs(at(step, {**values, quantity.symbol: changed}) - at(step, values)))
    return math.fsum(parts)


@pytest.mark.parametrize("name", [*RIDGED, *VARIANTS])
def test_printed_numbers_in_the_printed_formula_give_the_printed_result(name: str) -> None:
    """Within the rounding of the printed numbers, twice for its second order, and 1e-9 of arithmetic."""
    for step in steps(design_of(name)):
        result = step.result.value
        assert isinstance(result, float | int)
        allowed = 2 * unsure(step) + half_a_digit(result) + 1e-9 * abs(result)
        assert recomputed(step) == pytest.approx(float(f"{result:.5g}"), abs=allowed), step.title


@pytest.mark.parametrize("name", ["yamada-2002", "own heights"])
def test_a_changed_number_is_found(name: str) -> None:
    """The test above can fail: each given number counts in its result."""
    for step in steps(design_of(name)):
        for quantity in step.given:
            values = {symbol_quantity.symbol: printed(symbol_quantity) for symbol_quantity in step.given}
            if np.all(np.asarray(values[quantity.symbol]) == 0):
                continue
            moved = at(step, {**values, quantity.symbol: np.asarray(values[quantity.symbol]) * 1.5})
            assert moved != pytest.approx(recomputed(step), rel=1e-6), (step.title, quantity.symbol)


@pytest.mark.parametrize("name", ["yamada-2002", *VARIANTS])
def test_a_formula_has_its_given_symbols_and_no_other(name: str) -> None:
    for step in steps(design_of(name)):
        names = {node.id for node in ast.walk(ast.parse(step.formula)) if isinstance(node, ast.Name)}
        assert names - {"sin", "sqrt", "sum", "pi"} == {quantity.symbol for quantity in step.given}
        assert step.source


def test_one_symbol_means_one_thing_in_the_contact_steps() -> None:
    steps = calculations.contact_calculations(skincad.load("yamada-2002"), 0.6)
    quantities: dict[str, Quantity] = {}
    for quantity in chain.from_iterable((step.result, *step.given) for step in steps):
        assert quantities.setdefault(quantity.symbol, quantity).value == quantity.value


def test_the_steps_end_in_the_closed_forms_verdict() -> None:
    design = skincad.load("yamada-2002")
    check = skincad.check(design, model="winkler")
    values = {step.result.symbol: step.result.value for step in calculations.contact_calculations(design)}
    assert values["F"] == check.all_touch_force.value
    assert values["delta"] == check.approach.value


def test_no_line_is_written_where_none_holds() -> None:
    """A doubly curved skin's force is an integral; with slots, its cavity is no power of its volume."""
    symbols = [step.result.symbol for step in steps(design_of("doubly curved"))]
    assert "F" not in symbols
    assert "g" in symbols
    assert calculations.strip_calculations(skincad.load("plain-ridges")) == []


@pytest.mark.parametrize("name", template_names("circuits"))
def test_an_amplifiers_printed_numbers_give_its_printed_results(name: str) -> None:
    """Without a signal there are two steps: the strip's capacitance and the ideal amplifier's gain."""
    design, no_signal = skincad.load("yamada-2002"), cast(Any, SimpleNamespace)
    run = no_signal(raw={}, scene=no_signal(design=design))
    circuit = without_rig(skincad.load_circuit(name))
    for step in calculations.scene_calculations(run, circuit, skincad.gain(circuit)):
        result = step.result.value
        assert isinstance(result, float)
        assert recomputed(step) == pytest.approx(result, rel=1e-3), step.title


def step(text: str, **values: float) -> Calculation:
    quantities = tuple(Quantity(name, "", value, "1") for name, value in values.items())
    return Calculation("a step", Quantity("F", "", 1.0, "N"), text, quantities, "nowhere")


def read(drawn: str) -> str:
    """What a reader sees of a step's formula: with its numbers, and its result."""
    (formula,) = re.findall(r'<p class="formula">(.*?)</p>', drawn, re.DOTALL)
    return re.sub(r"<sup>(\d)</sup>", r"^\1", formula).replace("<br>\n", " ").replace("\u2212", "-")


def drawn_step(given: Calculation) -> str:
    return html("pieces.html", "calculation", given)


@pytest.mark.parametrize(
    ("text", "symbols", "numbers"),
    [
        ("a * (b + c)", "a · (b + c)", "2 · (3 + (-4.5))"),
        ("a - (b - c)", "a - (b - c)", "2 - (3 - (-4.5))"),
        ("a / (b * c)", "a / (b · c)", "2 / (3 · (-4.5))"),
        ("c**2", "c^2", "(-4.5)^2"),
        ("sin(a / b)**2", "sin(a / b)^2", "sin(2 / 3)^2"),
        ("sqrt(a + b)", "√(a + b)", "√(2 + 3)"),
        ("-a + b", "-a + b", "-2 + 3"),
    ],
)
def test_a_formula_reads_as_it_computes(text: str, symbols: str, numbers: str) -> None:
    drawn = drawn_step(step(text, a=2.0, b=3.0, c=-4.5))
    assert read(drawn) == f'F = {symbols} = {numbers} <span class="result">= 1 N</span>'


def test_indices_primes_greek_letters_and_powers_of_ten() -> None:
    drawn = read(drawn_step(step("E1 * nu * c_b", E1=1e-12, nu=0.499, c_b=2.5e9)))
    assert drawn.startswith("F = E\u2032 · \u03bd · c<sub>b</sub> = 1e-12 · 0.499 · 2.5e+09 ")


def test_a_number_of_each_ridge_stays_a_symbol_under_its_sum() -> None:
    many = Quantity("k_i", "", (1.0, 2.0), "N/mm")
    result = Quantity("F", "", 3.0, "N")
    drawn = read(drawn_step(Calculation("a sum", result, "sum(k_i * (g - k_i))", (many,), "nowhere")))
    assert "= ∑(k<sub>i</sub> · (g - k<sub>i</sub>)) with the ridges' values of the table below" in drawn
    rows = re.findall(r"<td[^>]*>([^<]*)</td>", html("pieces.html", "ridge_table", [many]))
    assert rows == ["1", "1", "2", "2"]
