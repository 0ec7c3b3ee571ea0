"""Pages that need nothing else: texts of templates/pages, filled in, and formulas as MathML."""

from __future__ import annotations

import ast
import base64
from html import escape
from importlib.resources import files
from typing import Any

from markdown_it import MarkdownIt

from skincad.base.formula import Calculation, rounded
from skincad.fabrication.papers import macro

HERE = files("skincad.outputs") / "web"
GREEK = {
    "delta": "δ",
    "epsilon": "ε",
    "nu": "\u03bd",
    "phi": "φ",
    "pi": "π",
    "rho": "\u03c1",
    "sigma": "\u03c3",
}
PRECEDENCE = {ast.Add: 1, ast.Sub: 1, ast.Mult: 2, ast.Div: 4, ast.USub: 2, ast.Pow: 3}
WHOLE = 5  # of what needs no brackets


def html(text: str, name: str, *values: Any, **facts: Any) -> str:
    """Return what a macro of a text of templates/pages makes of these values; it may ask for facts too."""
    return macro(f"pages/{text}", name, *values, **FACTS, **facts)


def document(title: str, body: str, *styles: str) -> str:
    """Return an HTML document of a body; `styles` are files of this room, the common one comes first."""
    style = "".join((HERE / name).read_text("utf-8") for name in ("page.css", *styles))
    return html("pieces.html", "document", title, style, body)


def page(markdown: str, drawing: str, title: str) -> str:
    """Return the casting sheet as a page to print: its Markdown and the drawing."""
    return document(title, f"{markdown_html(markdown)}<h2>Drawing</h2>\n{drawing}")


def markdown_html(markdown: str) -> str:
    """Return Markdown as HTML; raw HTML in it is shown, not taken."""
    return str(MarkdownIt("commonmark", {"html": False}).enable("table").render(markdown))


def data_url(data: bytes, kind: str) -> str:
    """Return an address that holds the data itself; `kind` as `image/png`."""
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


def formula(step: Calculation) -> str:
    """Return the formula in symbols: result = ..."""
    drawn = _FormulaWriter({}).of(_tree(step), 0)
    return _math(f"{symbol(step.result.symbol)}<mo>=</mo>{drawn}")


def formula_with_numbers(step: Calculation) -> str:
    """Return the formula with the numbers put in; those of each ridge stay symbols."""
    numbers = {
        quantity.symbol: number(quantity.value)
        for quantity in step.given
        if not isinstance(quantity.value, tuple)
    }
    drawn = _FormulaWriter(numbers).of(_tree(step), 0)
    return _math(f"{symbol(step.result.symbol)}<mo>=</mo>{drawn}")


def symbol(text: str) -> str:
    """Return a symbol: `c_r` has an index, `E1` a prime."""
    letter, _, index = text.partition("_")
    primed = letter.endswith("1")
    letter = GREEK.get(letter.removesuffix("1"), letter.removesuffix("1"))
    drawn = f"<mi>{escape(letter)}</mi>"
    drawn = f"<msup>{drawn}<mo>′</mo></msup>" if primed else drawn  # noqa: RUF001
    return f"<msub><mrow>{drawn}</mrow><mi>{escape(index)}</mi></msub>" if index else drawn


def number(value: float) -> str:
    """Return a number as printed, its power of ten as one."""
    digits, _, power = rounded(value).partition("e")
    drawn = f"<mn>{digits.replace('-', '−')}</mn>"  # noqa: RUF001
    if power:
        drawn += f"<mo>·</mo><msup><mn>10</mn><mn>{int(power)}</mn></msup>".replace("-", "−")  # noqa: RUF001
    return f"<mrow>{drawn}</mrow>"


def _math(inner: str) -> str:
    return f'<math displaystyle="true">{inner}</math>'


def _tree(step: Calculation) -> ast.expr:
    return ast.parse(step.formula, mode="eval").body


class _FormulaWriter:
    """Draws parts of a formula, with numbers in the place of some symbols."""

    def __init__(self, numbers: dict[str, str]) -> None:
        self.numbers = numbers

    def of(self, node: ast.expr, outer: int) -> str:
        """The part, in brackets where what is round it binds more tightly than `outer` says."""
        drawn, binds = self._part(node)
        return f"<mrow><mo>(</mo>{drawn}<mo>)</mo></mrow>" if binds < outer else f"<mrow>{drawn}</mrow>"

    def _part(self, node: ast.expr) -> tuple[str, int]:
        """A part and how tightly it binds."""
        match node:
            case ast.Constant(value=value):
                return f"<mn>{value!r}</mn>", WHOLE
            case ast.Name(id=name):
                text = self.numbers.get(name)
                negative = text is not None and text.startswith("<mrow><mn>−")  # noqa: RUF001
                return text or symbol(name), 1 if negative else WHOLE
            case ast.UnaryOp(operand=inner):
                return f"<mo>−</mo>{self.of(inner, 2)}", 1  # noqa: RUF001
            case ast.Call(func=ast.Name(id=name), args=[inner]):
                return self._function(name, inner)
            case ast.BinOp(left=left, op=op, right=right):
                return self._of_two(left, op, right)
        raise ValueError(f"no part of a formula: {ast.unparse(node)}")

    def _function(self, name: str, inner: ast.expr, power: str = "") -> tuple[str, int]:
        if name == "sqrt":
            return f"<msqrt>{self.of(inner, 0)}</msqrt>", WHOLE
        if name == "sum":
            return f"<munder><mo>∑</mo><mi>i</mi></munder>{self.of(inner, 2)}", 2
        head = f"<msup><mi>{name}</mi>{power}</msup>" if power else f"<mi>{name}</mi>"
        return f"{head}<mo>⁡</mo><mrow><mo>(</mo>{self.of(inner, 0)}<mo>)</mo></mrow>", 3

    def _of_two(self, left: ast.expr, op: ast.operator, right: ast.expr) -> tuple[str, int]:
        binds = PRECEDENCE[type(op)]
        match left, op:
            case ast.Call(func=ast.Name(id="sin"), args=[inner]), ast.Pow():
                return self._function("sin", inner, self.of(right, 0))
        match op:
            case ast.Div():
                return f"<mfrac>{self.of(left, 0)}{self.of(right, 0)}</mfrac>", binds
            case ast.Pow():
                return f"<msup>{self.of(left, WHOLE)}{self.of(right, 0)}</msup>", binds
            case ast.Mult():
                sign = "<mo>·</mo>"
            case ast.Add():
                sign = "<mo>+</mo>"
            case _:
                sign = "<mo>−</mo>"  # noqa: RUF001
        return f"{self.of(left, binds)}{sign}{self.of(right, binds + isinstance(op, ast.Sub))}", binds


FACTS = {
    "formula": formula,
    "formula_with_numbers": formula_with_numbers,
    "part": lambda node: _math(_FormulaWriter({}).of(node, 0)),
    "symbol_of": lambda quantity: _math(symbol(quantity.symbol)),
    "rounded": rounded,
    "MAX_TERMS": 12,  # of a sum that are written out
}
