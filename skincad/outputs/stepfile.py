"""STEP files with the same bytes for the same solids.

The CAD kernel writes the clock's time, a counter that runs on through the process, colours in the order of
memory addresses, and its version as of whichever copy of itself was loaded first (the FE library brings one
too); all are made constant here, in the text.
"""

from __future__ import annotations

import errno
import os
import re
from datetime import UTC, datetime
from pathlib import Path

from skincad.base.errors import InputError

_TIME = re.compile(r"(FILE_NAME\('[^']*',')[^']*(')")
_VERSION = re.compile(r"'(Open CASCADE(?: STEP processor)?) \d+\.\d+'")
_NAMELESS = re.compile(r"'Open CASCADE STEP translator [\d. ]+'")
_OCCURRENCE = re.compile(r"(NEXT_ASSEMBLY_USAGE_OCCURRENCE\(')\d+('[^;]*;)")
_WRAP = re.compile(r"\n *")
_ENTITY = re.compile(r"#(\d+) = (.*)", re.DOTALL)
_REFERENCE = re.compile(r"#(\d+)")
_STYLE = "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION"


def make_deterministic(path: Path, name: str) -> None:
    """Rewrite a STEP file in place: header time by SOURCE_DATE_EPOCH (1970 without it), products without a
    name called `name`, occurrences counted from 1, colours in the order of the solids that carry them.

    Raises InputError when SOURCE_DATE_EPOCH is no whole number of seconds, OSError when the file is
    incomplete, which the kernel does not report.
    """
    text = path.read_text("latin-1")
    if not text.rstrip().endswith("END-ISO-10303-21;"):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
    moment = source_date()
    text = _TIME.sub(lambda m: m[1] + moment + m[2], text, count=1)
    text = text.replace("'Open CASCADE Shape Model'", f"'{name}'", 1).replace("('Author')", "('skincad')", 1)
    text = _VERSION.sub(r"'\1'", text)
    text = _NAMELESS.sub(f"'{name}'", text)
    count = iter(range(1, text.count("NEXT_ASSEMBLY_USAGE_OCCURRENCE") + 1))
    text = _OCCURRENCE.sub(lambda m: f"{m[1]}{next(count)}{_WRAP.sub('', m[2])}", text)
    path.write_text(_styles_in_order(text), "latin-1", newline="\n")


def source_date() -> str:
    """Return the time to write into files, ISO 8601 without zone: SOURCE_DATE_EPOCH, or 1970."""
    seconds = os.environ.get("SOURCE_DATE_EPOCH", "0")
    try:
        moment = datetime.fromtimestamp(int(seconds), UTC)
    except (ValueError, OverflowError, OSError):
        raise InputError("SOURCE_DATE_EPOCH", "must be whole seconds since 1970", seconds) from None
    return moment.strftime("%Y-%m-%dT%H:%M:%S")


def _styles_in_order(text: str) -> str:
    """Renumber the presentation styles, which the kernel writes last, by the solids that they refer to."""
    first = text.find(_STYLE)
    if first < 0:
        return text
    start = text.rfind("#", 0, first)
    end = text.index("ENDSEC;", start)
    entities = {}
    for statement in text[start:end].split(";\n"):
        if match := _ENTITY.fullmatch(statement):
            entities[int(match[1])] = _WRAP.sub("", match[2])
    base = min(entities)
    roots = [number for number, body in entities.items() if body.startswith(_STYLE)]
    order: dict[int, int] = {}
    for root in sorted(roots, key=lambda number: _solids(number, entities)):
        _number(root, entities, base, order)
    lines = [
        f"#{new} = " + _REFERENCE.sub(lambda m: f"#{order.get(int(m[1]), int(m[1]))}", entities[old])
        for old, new in order.items()
    ]
    return text[:start] + ";\n".join(lines) + ";\n" + text[end:]


def _solids(number: int, entities: dict[int, str]) -> list[int]:
    """Entities before the styles that a style refers to; their numbers are stable."""
    references = [int(r) for r in _REFERENCE.findall(entities[number])]
    return [r for r in references if r not in entities]


def _number(old: int, entities: dict[int, str], base: int, order: dict[int, int]) -> None:
    if old in order or old not in entities:
        return
    order[old] = base + len(order)
    for reference in _REFERENCE.findall(entities[old]):
        _number(int(reference), entities, base, order)
