"""Pages that need nothing else, and their pieces: tables, figures, calculations with formulas as MathML."""

from __future__ import annotations

import ast
import base64
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files

from markdown_it import MarkdownIt

from skincad.base.formula import Calculation, Quantity, rounded

HERE = files("skincad.outputs") / "web"
MAX_TERMS = 12  # of a sum that are written out
Cell = str | float | int | None
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


def document(title: str, body: str, *styles: str) -> str:
    """Return an HTML document of a body; `styles` are files of this room, the common one comes first."""
    style = "".join((HERE / name).read_text("utf-8") for name in ("page.css", *styles))
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width">\n<title>{escape(title)}</title>\n'
        f"<style>\n{style}</style>\n</head>\n<body>\n{body}</body>\n</html>\n"
    )


def page(markdown: str, drawing: str, title: str) -> str:
    """Return the casting sheet as a page to print: its Markdown and the drawing."""
    return document(title, f"{markdown_html(markdown)}<h2>Drawing</h2>\n{drawing}")


def markdown_html(markdown: str) -> str:
    """Return Markdown as HTML; raw HTML in it is shown, not taken."""
    return str(MarkdownIt("commonmark", {"html": False}).enable("table").render(markdown))


def data_url(data: bytes, kind: str) -> str:
    """Return an address that holds the data itself; `kind` as `image/png`."""
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


def heading(text: str, key: str, *, new_page: bool = False) -> str:
    """Return a section's head, which the contents lead to."""
    look = ' class="page"' if new_page else ""
    return f'<h2 id="{escape(key)}"{look}>{escape(text)}</h2>\n'


def paragraph(text: str, look: str = "") -> str:
    """Return a paragraph of plain text."""
    kind = f' class="{look}"' if look else ""
    return f"<p{kind}>{escape(text)}</p>\n"


def command_line(command: str, words: str = "By") -> str:
    """Return the command that gives what stands above."""
    return f'<p class="from">{escape(words)} <code>{escape(command)}</code></p>\n'


def table(head: Sequence[str], rows: Iterable[Sequence[Cell]], look: str = "") -> str:
    """Return a table whose head stands on each printed page; numbers stand to the right."""
    kind = f' class="{look}"' if look else ""
    heads = "".join(f"<th>{escape(title)}</th>" for title in head)
    body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>\n" for row in rows)
    return f"<table{kind}><thead><tr>{heads}</tr></thead>\n<tbody>\n{body}</tbody></table>\n"


def _cell(value: Cell) -> str:
    if value is None:
        return "<td></td>"
    if isinstance(value, float | int):
        return f'<td class="number">{_minus(rounded(value))}</td>'
    return f"<td>{escape(value)}</td>"


def figure(address: str, caption: str, command: str) -> str:
    """Return a picture with what it shows, where that comes from, and the command that gives it."""
    return (
        f'<figure><img src="{address}" alt="{escape(caption)}">\n<figcaption>{escape(caption)} '
        f"By <code>{escape(command)}</code></figcaption></figure>\n"
    )


def calculation(step: Calculation) -> str:
    """Return formula, numbers put in, result, symbols and source of one step."""
    result = f"{_minus(_value(step.result))}{_unit(step.result.unit)}"
    numbers = formula_with_numbers(step)
    if step.sums():
        numbers += " with the ridges' values of the table below"
    sums = "".join(
        f'<p class="small">{part(call)} = {" + ".join(_minus(rounded(term)) for term in terms)}</p>\n'
        for call, terms in step.sums()
        if len(terms) <= MAX_TERMS
    )
    remark = paragraph(step.remark, "small") if step.remark else ""
    return (
        f'<div class="step">\n<h3>{escape(step.title)}</h3>\n'
        f'<p class="formula">{formula(step)}</p>\n<p class="formula">{numbers} '
        f'<span class="result">= {result}</span></p>\n{sums}'
        f'<p class="small">{"; ".join(_symbol_meaning(quantity) for quantity in step.given)}.<br>'
        f"Source: {escape(step.source)}.</p>\n{remark}</div>\n"
    )


def ridge_table(quantities: Sequence[Quantity]) -> str:
    """Return the table of what differs from ridge to ridge."""
    columns = [quantity.value for quantity in quantities if isinstance(quantity.value, tuple)]
    heads = "".join(f"<th>{name(quantity)}{_unit(quantity.unit, ', ')}</th>" for quantity in quantities)
    rows = "".join(
        f'<tr><td class="number">{ridge}</td>{"".join(_cell(value) for value in row)}</tr>\n'
        for ridge, row in enumerate(zip(*columns, strict=True), 1)
    )
    head = f"<th>ridge <math><mi>i</mi></math></th>{heads}"
    return f'<table class="small"><thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody></table>\n'


def _symbol_meaning(quantity: Quantity) -> str:
    """A symbol with its meaning, and its number and unit but for those of each ridge."""
    if isinstance(quantity.value, tuple):
        return f"{name(quantity)} {escape(quantity.meaning)}"
    return f"{name(quantity)} = {_minus(_value(quantity))}{_unit(quantity.unit)}, {escape(quantity.meaning)}"


def _value(quantity: Quantity) -> str:
    assert not isinstance(quantity.value, tuple)
    return rounded(quantity.value)


def _unit(unit: str, before: str = " ") -> str:
    return "" if unit == "1" else f"{before}{escape(unit)}"


def _minus(number: str) -> str:
    return number.replace("-", "−")  # noqa: RUF001


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


def name(quantity: Quantity) -> str:
    """Return a quantity's symbol alone."""
    return _math(symbol(quantity.symbol))


def symbol(text: str) -> str:
    """Return a symbol: `c_r` has an index, `E1` a prime."""
    letter, _, index = text.partition("_")
    primed = letter.endswith("1")
    letter = GREEK.get(letter.removesuffix("1"), letter.removesuffix("1"))
    drawn = f"<mi>{escape(letter)}</mi>"
    drawn = f"<msup>{drawn}<mo>′</mo></msup>" if primed else drawn  # noqa: RUF001
    return f"<msub><mrow>{drawn}</mrow><mi>{escape(index)}</mi></msub>" if index else drawn


def part(node: ast.expr) -> str:
    """Return a part of a formula in symbols."""
    return _math(_FormulaWriter({}).of(node, 0))


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
