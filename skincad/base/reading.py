"""What a person's file says, read as data only and in bounded work: its text, and the tables of a TOML.

tomllib alone takes time quadratic in a dotted key's parts and recurs with depth, so both are bounded before.
"""

from __future__ import annotations

import codecs
import re
import tomllib
from itertools import accumulate
from pathlib import Path
from typing import Any

from skincad.base.errors import InputError

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


def text_of(path: Path, name: str, most: int, kind: str) -> str:
    """Return the text of a regular file of at most `most` bytes: UTF-8, or UTF-16 with its mark.

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
        text = data.decode("utf-16" if marked else "utf-8-sig")
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
