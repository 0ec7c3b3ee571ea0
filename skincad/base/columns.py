"""Columns of numbers from a person's CSV file.

The first row names the columns, with their unit; blank rows and rows that begin with # are passed over.
Spreadsheets' separators and decimal commas are read as they come.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, did_you_mean
from skincad.base.reading import text_of

LARGEST_FILE = 20_000_000  # bytes; a material test of an hour at 100 Hz has about 10 MB
MOST_ROWS = 1_000_000
SEPARATORS = {",": "comma", ";": "semicolon", "\t": "tab"}
NO_COMMAS = "write decimals with a point, or separate columns by semicolons"
_NUMBER = re.compile(r"[+-]?(\d++(\.\d*+)?|\.\d++)([eE][+-]?\d++)?", re.ASCII)


def read_columns(
    path: Path | str,
    allowed: tuple[str, ...],
    *,
    ignored: re.Pattern[str] | None = None,
    refuse: Callable[[str], str] = lambda _: "",
) -> dict[str, Array]:
    """Return the columns of a CSV by name, each `(rows,)`, all numbers finite.

    The first row tells what separates columns: comma, semicolon or tab. Decimals have a point or, where no
    comma separates columns, all of them a comma. Columns whose names match `ignored` are passed over,
    whatever their cells are; `refuse` gives an unknown column's remedy where it knows a better one. Raises
    InputError for a file that cannot be read, a column not in `allowed`, or a value that is no number, with
    its row.
    """
    name = str(path)
    text = text_of(Path(path), name, LARGEST_FILE, "CSV").replace("\r\n", "\n").replace("\r", "\n")
    if text.count("\n") > MOST_ROWS:
        raise InputError(
            name, f"must have at most {MOST_ROWS} rows", text.count("\n"), "keep every second one"
        )
    lines = [line for line in text.split("\n") if line.strip() and not line.lstrip().startswith("#")]
    try:
        separator, header = _header(name, lines[:1], allowed, ignored, refuse)
        places = [i for i, column in enumerate(header) if not (ignored and ignored.fullmatch(column))]
        numbers = _numbers(name, lines[1:], separator, len(header), places)
    except csv.Error as failure:
        raise InputError(name, f"is not CSV ({failure})") from None
    if not numbers:
        raise InputError(name, "has no rows of numbers", remedy=f"first row: {','.join(allowed)}")
    table = np.array(numbers)
    return {header[place]: table[:, i] for i, place in enumerate(places)}


def _header(
    name: str,
    lines: list[str],
    allowed: tuple[str, ...],
    ignored: re.Pattern[str] | None,
    refuse: Callable[[str], str],
) -> tuple[str, list[str]]:
    """What separates columns, and their names: as most of the names are known, or else as most come apart."""
    split = {mark: next(map(_cells, csv.reader(lines, delimiter=mark)), []) for mark in SEPARATORS}
    separator, header = max(split.items(), key=lambda found: (len({*found[1]} & {*allowed}), len(found[1])))
    for column in header:
        if ignored and ignored.fullmatch(column):
            continue
        if column not in allowed:
            remedy = refuse(column) or did_you_mean(column, allowed)
            if len(header) == 1:
                remedy = f"separate columns by {', '.join(SEPARATORS.values())}: {','.join(allowed)}"
            raise InputError(f"{name}, column {column[:80]!r}", "unknown", remedy=remedy)
        if header.count(column) > 1:
            raise InputError(f"{name}, column {column!r}", "must be given once", header.count(column))
    return separator, header


def _cells(row: list[str]) -> list[str]:
    """The cells of a row, without the empty ones that spreadsheets put at its end."""
    cells = [cell.strip() for cell in row]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _numbers(
    name: str, lines: list[str], separator: str, columns: int, places: list[int]
) -> list[list[float]]:
    """The rows of numbers at these places, as many cells in each as there are columns; rows of empty cells
    are passed over."""
    decimal = "," if separator != "," and any("," in line for line in lines) else "."
    rows = filter(None, map(_cells, csv.reader(lines, delimiter=separator)))
    numbers = []
    for i, row in enumerate(rows, 1):
        if len(row) > places[-1]:
            row.extend([""] * (columns - len(row)))  # last cells that nobody reads may be empty
        if len(row) != columns:
            many = separator == "," and len(row) > columns
            remedy = NO_COMMAS if many else f"separate them by {SEPARATORS[separator]}, as in the first row"
            raise InputError(f"{name}, row {i}", f"must have {columns} values", len(row), remedy)
        numbers.append([_number(f"{name}, row {i}", row[place], decimal) for place in places])
    return numbers


def _number(where: str, cell: str, decimal: str) -> float:
    plain = cell if decimal == "." else cell.replace(".", " ").replace(",", ".")
    value = float(plain) if _NUMBER.fullmatch(plain) else math.nan
    if not math.isfinite(value):
        other = {".": NO_COMMAS, ",": "write all decimals with a comma, and no thousands separator"}
        marked = set(cell) & {",", "."} - {decimal}
        raise InputError(where, "must be a finite number", cell, other[decimal] if marked else "")
    return value
