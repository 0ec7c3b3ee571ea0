"""Words for people: texts of templates/, which ask a job and the rooms that plan it. A number is computed in
one place alone, so no two papers say two of it.

`papers` are Markdown and files that people read, `answers` what commands print of a result, `reasons` why a
result is as it is, `pages` HTML, `simulators` XML.
"""

from __future__ import annotations

import re
from functools import cache
from html import escape
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined, pass_eval_context
from jinja2.nodes import EvalContext
from markupsafe import Markup

from skincad.base.reading import markdown_text
from skincad.inputs.shipped import templates_folder


def paper(name: str, **facts: Any) -> str:
    """Return a text of `templates/papers` with its facts filled in; Markdown."""
    return environment().get_template(f"papers/{name}").render(**facts)


def macro(text: str, name: str, *values: Any, **facts: Any) -> str:
    """Return what a macro of a text, as "answers/check.txt", makes of these values; "" where it has none of
    that name. It may ask for the facts too."""
    chosen = getattr(environment().get_template(text).make_module(facts), name, None)
    return "" if chosen is None else str(chosen(*values))


def listed(words: list[str]) -> str:
    """Return words as a sentence lists them: "a, b and c"."""
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]


def cell(text: str) -> str:
    """Return what a person named, for a text whose rows and cells are told apart by lines, spaces and |."""
    return re.sub(r"[\s|\0]", lambda found: f"\0{ord(found[0]):x};", text)


def cells(row: str) -> list[str]:
    """Return a row's cells, with | between them, names as `cell` was given them."""
    return [
        re.sub("\0([0-9a-f]+);", lambda code: chr(int(code[1], 16)), part.strip()) for part in row.split("|")
    ]


def span(minutes: float) -> str:
    """Return how long something takes, as a plan has it."""
    if not minutes:
        return "-"
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.2g} h"


@cache
def environment() -> Environment:
    """Return where texts are found, and their filters.

    Facts in a page are escaped unless they are HTML already. Other texts have no HTML, and in papers the
    facts that people write are escaped by then.
    """
    found = Environment(
        loader=FunctionLoader(lambda name: templates_folder().joinpath(*name.split("/")).read_text("utf-8")),
        undefined=StrictUndefined,
        autoescape=lambda name: str(name).endswith(".html"),
        finalize=_finalized,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    found.filters |= {"aligned": _aligned, "listed": listed, "md": markdown_text, "num": format, "span": span}
    found.filters["cell"] = cell
    found.filters["g"] = lambda number: f"{number:g}"
    found.filters["joined"] = _joined
    found.filters["plural"] = lambda word, count: word if count == 1 else f"{word}s"
    found.globals["row"] = lambda head, caller: f"  {head:14} {_joined(caller())}\n"
    return found


def _joined(lines: str) -> str:
    """A text's lines as one, with no space before punctuation."""
    return re.sub(r" (?=[.,;:)]( |$))", "", " ".join(lines.split()))


def _aligned(text: str, side: str = ">") -> str:
    """A text whose lines of cells, with | between them, are a table: the first column to the left, the others
    to a side. Lines without | stay as they are."""
    lines = [line.split("|") for line in text.splitlines()]
    widths = [max(map(len, column)) for column in zip(*(row for row in lines if len(row) > 1), strict=True)]
    sides = "<" + side * len(widths)
    rows = [
        "  ".join(
            f"{cell:{where}{width}}" for cell, where, width in zip(row, sides, widths, strict=False)
        ).rstrip()
        if len(row) > 1
        else row[0]
        for row in lines
    ]
    return "".join(f"{row}\n" for row in rows)


@pass_eval_context
def _finalized(context: EvalContext, value: Any) -> Any:
    """A fact in a page, escaped as `html.escape` does."""
    return Markup(escape(str(value))) if context.autoescape and not hasattr(value, "__html__") else value
