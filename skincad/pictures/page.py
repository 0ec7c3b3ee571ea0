"""The casting sheet as a page to print: its Markdown and the drawing in one HTML file."""

from __future__ import annotations

from html import escape

from markdown_it import MarkdownIt

STYLE = (
    "body{font:11pt/1.4 sans-serif;max-width:180mm;margin:12mm auto;color:#222}"
    "h1{font-size:17pt}h2{font-size:13pt;border-bottom:1px solid #999;page-break-after:avoid}"
    "table{border-collapse:collapse;page-break-inside:avoid}td,th{border:1px solid #aaa;padding:.15em .6em;"
    "text-align:left;vertical-align:top}svg{max-width:100%;height:auto}li{margin:.25em 0}"
    "@media print{body{margin:0;max-width:none}}"
)


def page(markdown: str, drawing: str, title: str) -> str:
    """Return an HTML document that needs nothing else; raw HTML in the Markdown is shown, not taken."""
    body = MarkdownIt("commonmark", {"html": False}).enable("table").render(markdown)
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{escape(title)}</title>\n'
        f"<style>{STYLE}</style>\n</head>\n<body>\n{body}<h2>Drawing</h2>\n{drawing}</body>\n</html>\n"
    )
