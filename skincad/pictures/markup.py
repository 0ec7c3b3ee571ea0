"""Pieces of a page: tables, figures with their source and command, calculations with their formulas."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from skincad.base.formula import Calculation, Quantity, rounded
from skincad.pictures.mathml import formula, formula_with_numbers, name, part

MAX_TERMS = 12  # of a sum that are written out
Cell = str | float | int | None


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


def figure(address: str, caption: str, command: str, look: str = "") -> str:
    """Return a picture with what it shows, where that comes from, and the command that gives it."""
    kind = f' class="{look}"' if look else ""
    return (
        f'<figure{kind}><img src="{address}" alt="{escape(caption)}">\n<figcaption>{escape(caption)} '
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
