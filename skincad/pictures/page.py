"""Pages that need nothing else: one HTML file with its style, text and pictures in it."""

from __future__ import annotations

import base64
from html import escape
from importlib.resources import files

from markdown_it import MarkdownIt

HERE = files("skincad.pictures")


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
