"""Papers: texts of templates/papers, which ask a job and the rooms that plan it. A number is computed in one
place alone, so no two papers say two of it."""

from __future__ import annotations

from functools import cache
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined

from skincad.base.reading import markdown_text
from skincad.inputs.shipped import templates_folder


def paper(name: str, **facts: Any) -> str:
    """Return a text of `templates/papers` with its facts filled in; Markdown."""
    return _environment().get_template(name).render(**facts)


def listed(words: list[str]) -> str:
    """Return words as a sentence lists them: "a, b and c"."""
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]


def span(minutes: float) -> str:
    """Return how long something takes, as a plan has it."""
    if not minutes:
        return "-"
    return f"{minutes:.0f} min" if minutes < 90 else f"{minutes / 60:.2g} h"


@cache
def _environment() -> Environment:
    """Texts with no HTML in them, so nothing is escaped here: the facts that people write are by then."""
    found = Environment(
        loader=FunctionLoader(lambda name: (templates_folder() / "papers" / name).read_text("utf-8")),
        undefined=StrictUndefined,
        autoescape=False,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    found.filters |= {"listed": listed, "md": markdown_text, "num": format, "span": span}
    found.filters["g"] = lambda number: f"{number:g}"
    return found
