"""Pages that need nothing else: texts of templates/pages, filled in."""

from __future__ import annotations

import base64
from importlib.resources import files
from typing import Any

from markdown_it import MarkdownIt

from skincad.fabrication.papers import macro

HERE = files("skincad.outputs") / "web"


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


def rounded(value: float) -> str:
    """Return a number as it is printed."""
    return f"{value:.5g}".replace("-", "−")  # noqa: RUF001


FACTS = {"rounded": rounded}
