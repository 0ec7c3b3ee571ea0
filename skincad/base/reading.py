"""Texts as data: what is read from a person's files, and what is written so that programs read it.

Text of other people's files in files that we write: it stays text, and steers neither table nor page. A
silicone's name, a choice in a sweep and a refusal may hold any letters. HTML has `html.escape`.

tomllib alone takes time quadratic in a dotted key's parts and recurs with depth, so both are bounded before.
"""

from __future__ import annotations

import codecs
import csv
import io
import json
import re
import tomllib
from collections.abc import Iterable, Sequence
from itertools import accumulate
from pathlib import Path
from typing import Any

from skincad.base.errors import InputError, RefusedError, shown

Cell = str | float | int | None
# what makes a spreadsheet compute a cell, or split it before it looks at its first letter
# (source: OWASP, CSV injection)
_COMPUTED = ("=", "+", "-", "@", "\t", "\r", "\n")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# what begins emphasis, code, links, HTML, entities and cells of a table wherever it stands, links without
# brackets, and what begins a block at the head of a line (source: CommonMark 0.31, GitHub's extensions)
_MARKDOWN = re.compile(
    r"[\\`*<>|~&$]|\](?=[(\[:]|$)|^\[(?=[ x]\])|\[(?=\^)|(?<![^\W_])_|_(?![^\W_])|:(?=//)|(?<=www)\.|^[#+=-]"
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


def strict_json(data: dict[str, Any], indent: int | None = None) -> str:
    """Return the JSON of a result; raises RefusedError for a NaN or an infinite number in it.

    To be asked before anything is written: JSON has no such numbers, and nobody can use them.
    """
    try:
        return json.dumps(data, allow_nan=False, indent=indent)
    except ValueError:
        raise RefusedError("the result holds numbers that are not finite: nothing is written") from None


MOST_VALUES = 100_000  # of a TOML; a history of 10,000 points has 50,000
MOST_PARTS = 8  # of a key, as in contact.plate.shape; no table of skincad's has more than 3
DEEPEST = 8  # lists and tables within each other; none of skincad's has more than 2
_STRING_OR_COMMENT = re.compile(
    r'''"""(?:[^"\\]|\\.|"(?!""))*+(?:"{3,5})?|"(?:[^"\\\n]|\\.)*+"?|'''
    r"""'''(?:[^']|'(?!''))*+(?:'{3,5})?|'[^'\n]*+'?|"""
    r"#[^\n]*+",
    re.DOTALL,
)
_LONG_KEY = re.compile(rf"(?:\.[^.=,\[\]{{}}\n]*+){{{MOST_PARTS}}}")
_NO_BRACKET = re.compile(r"[^\[\]{}]++")


def text_of(path: Path, name: str, most: int, kind: str, otherwise: str | None = None) -> str:
    """Return the text of a regular file of at most `most` bytes: UTF-8, UTF-16 with its mark, or, where it is
    neither, in the encoding `otherwise`.

    Raises InputError, which calls the file `name` and says what `kind` was wanted, for any other.
    """
    try:
        if path.exists() and not path.is_file():  # a pipe would be waited for, a device has no end
            raise InputError(name, "is not a regular file", remedy=f"name a {kind} file")
        with path.open("rb") as file:
            data = file.read(most + 1)
        if len(data) > most:
            raise InputError(name, f"must be at most {most} bytes", path.stat().st_size)
        marked = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        try:
            text = data.decode("utf-16" if marked else "utf-8-sig")
        except UnicodeDecodeError:
            if otherwise is None or marked:
                raise
            text = data.decode(otherwise)
    except OSError as failure:
        raise InputError(name, f"cannot be read ({failure.strerror})", remedy="check the path") from None
    except UnicodeDecodeError:
        text = "\0"
    except ValueError as failure:
        if isinstance(failure, InputError):
            raise
        raise InputError(name, f"is no path ({failure})") from None
    if "\0" in text:  # as every other letter of a UTF-16 without its mark is
        raise InputError(name, "is not UTF-8 text", remedy=f"save it as {kind} in UTF-8")
    return text


def tables_of(text: str, name: str) -> dict[str, Any]:
    """Return the tables of a TOML text; raises InputError, which calls it `name`, for any other text."""
    if excess := _excess(text):
        raise InputError(name, f"is not TOML of ordinary size: {excess}", remedy="see `skincad new`")
    try:
        return tomllib.loads(text)
    except ValueError as failure:  # beside TOML's own: integers of thousands of digits
        raise InputError(name, f"is not TOML: {failure}", remedy="see `skincad new`") from None


def _excess(text: str) -> str:
    """What would make parsing a TOML text, or using its tables, take out of all proportion; "" if nothing."""
    structure = _STRING_OR_COMMENT.sub("", text)
    depths = accumulate(1 if bracket in "[{" else -1 for bracket in _NO_BRACKET.sub("", structure))
    if max(depths, default=0) > DEEPEST:
        return f"it has lists or tables nested more than {DEEPEST} deep"
    if _LONG_KEY.search(structure):
        return f"it has a key of more than {MOST_PARTS} parts"
    if sum(map(structure.count, "=,[{")) > MOST_VALUES:
        return f"it has more than {MOST_VALUES} values"
    return ""
