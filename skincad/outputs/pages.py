"""Pages that need nothing else, and their pieces: heads, tables, figures."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files

from markdown_it import MarkdownIt

HERE = files("skincad.outputs") / "web"
Cell = str | float | int | None


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
        return f'<td class="number">{rounded(value)}</td>'
    return f"<td>{escape(value)}</td>"


def figure(address: str, caption: str, command: str) -> str:
    """Return a picture with what it shows, where that comes from, and the command that gives it."""
    return (
        f'<figure><img src="{address}" alt="{escape(caption)}">\n<figcaption>{escape(caption)} '
        f"By <code>{escape(command)}</code></figcaption></figure>\n"
    )


def rounded(value: float) -> str:
    """Return a number as it is printed."""
    return f"{value:.5g}".replace("-", "−")  # noqa: RUF001
