"""A closed form as it is written down by hand: formula, numbers put in, result, source.

The formula is Python's arithmetic in the quantities' symbols: it is drawn from what is computed with.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skincad.base.arrays import Array

DIGITS = 5  # that are printed of a number
FUNCTIONS: dict[str, Callable[..., Any]] = {"sin": np.sin, "sqrt": np.sqrt, "sum": np.sum}
CONSTANTS = {"pi": np.pi}


@dataclass(frozen=True)
class Quantity:
    """A number in its unit, or one of each ridge, as `symbol` in a formula: `E_1` has an index, `E1` a prime;
    Greek letters are named."""

    symbol: str
    meaning: str
    value: float | tuple[float, ...]
    unit: str

    @property
    def printed(self) -> float | Array:
        """The number as it is printed, rounded."""
        if isinstance(self.value, tuple):
            return np.array([float(rounded(value)) for value in self.value])
        return float(rounded(self.value))


@dataclass(frozen=True)
class Calculation:
    """A result by a formula of what is given; `source` is author, year and place.

    The result comes from the function that the program itself uses: `recomputed` is the formula's.
    """

    title: str
    result: Quantity
    formula: str
    given: tuple[Quantity, ...]
    source: str
    remark: str = ""

    def recomputed(self) -> float:
        """Return the result by the formula from the numbers as they are printed."""
        return self.at({quantity.symbol: quantity.printed for quantity in self.given})

    def at(self, values: dict[str, float | Array]) -> float:
        """Return the result by the formula for these values of the given symbols."""
        return float(np.asarray(evaluated(ast.parse(self.formula, mode="eval").body, values)))

    def sums(self) -> list[tuple[ast.Call, list[float]]]:
        """Return each sum of the formula with the terms that it adds up, from the numbers as printed."""
        values = {term.symbol: term.printed for term in self.given}
        summed = []
        for call in ast.walk(ast.parse(self.formula, mode="eval")):
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "sum":
                summed.append(
                    (call, [float(term) for term in np.atleast_1d(evaluated(call.args[0], values))])
                )
        return summed


def rounded(value: float) -> str:
    """Return a number to DIGITS digits."""
    return f"{value:.{DIGITS}g}"


def evaluated(node: ast.expr, values: dict[str, float | Array]) -> float | Array:
    """Return the value of a formula's part; raises ValueError for what no formula has."""
    result: float | Array
    match node:
        case ast.Constant(value=int() | float() as number):
            result = number
        case ast.Name(id=name):
            result = values[name] if name in values else CONSTANTS[name]
        case ast.UnaryOp(op=ast.USub(), operand=inner):
            result = -evaluated(inner, values)
        case ast.Call(func=ast.Name(id=name), args=[inner]):
            result = FUNCTIONS[name](evaluated(inner, values))
        case ast.BinOp(left=left, op=op, right=right):
            result = _of_two(op, evaluated(left, values), evaluated(right, values))
        case _:
            raise ValueError(f"no part of a formula: {ast.unparse(node)}")
    return result


def _of_two(op: ast.operator, left: float | Array, right: float | Array) -> float | Array:
    match op:
        case ast.Add():
            return left + right
        case ast.Sub():
            return left - right
        case ast.Mult():
            return left * right
        case ast.Div():
            return left / right
        case ast.Pow():
            return left**right
    raise ValueError(f"no operator of a formula: {op}")
