"""Text of other people's files in files that we write: it stays text, and steers neither table nor page.

A silicone's name, a choice in a sweep and a refusal may hold any letters. HTML has `html.escape`.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence

from skincad.base.errors import shown

Cell = str | float | int | None
# what makes a spreadsheet compute a cell, or split it before it looks at its first letter
# (source: OWASP, CSV injection)
_COMPUTED = ("=", "+", "-", "@", "\t", "\r", "\n")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# what begins emphasis, code, links, HTML, entities and cells of a table wherever it stands, links without
# brackets, and what begins a block at the head of a line (source: CommonMark 0.31, GitHub's extensions)
_MARKDOWN = re.compile(
    r"[\\`*\[\]<>|~&$]|(?<![^\W_])_|_(?![^\W_])|:(?=//)|(?<=www)\.|^[#+=-]"
    r"|^(?P<digits>\d{1,9})(?P<mark>[.)])",
    re.IGNORECASE,
)


def csv_text(rows: Iterable[Sequence[Cell]], comments: Iterable[str] = ()) -> str:
    """Return a CSV file's text, `comments` as lines that begin with # before its rows; None is empty.

    A text that a spreadsheet would compute begins with an apostrophe. Numbers stay numbers, those that are
    formatted already too.
    """
    lines = [f"# {shown(comment)}" for comment in comments]
    for row in rows:
        line = io.StringIO()
        csv.writer(line, lineterminator="\r\n").writerow([_cell(value) for value in row])  # quotes \r and \n
        lines.append(line.getvalue().removesuffix("\r\n"))
    return "".join(f"{line}\n" for line in lines)


def _cell(value: Cell) -> Cell:
    if isinstance(value, str) and value.startswith(_COMPUTED) and not _NUMBER.fullmatch(value):
        return f"'{value}"
    return "" if value is None else value


def markdown_text(text: str) -> str:
    """Return a text that Markdown, with HTML or without, shows as it is, in one line; letters that nobody
    sees are shown as their escapes."""
    return _MARKDOWN.sub(_escaped, shown(text).strip())


def _escaped(special: re.Match[str]) -> str:
    if special["digits"]:  # of a numbered list
        return f"{special['digits']}\\{special['mark']}"
    return f"\\{special[0]}"
