"""Measured data from CSV files: crest heights of a cast part, and material tests.

The first row names the columns, with their unit; blank rows and rows that begin with # are passed over.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skincad.design import Design
from skincad.errors import InputError, did_you_mean
from skincad.section import frame

LARGEST_FILE = 20_000_000  # bytes; a material test of an hour at 100 Hz has about 10 MB


def read_columns(path: Path | str, allowed: tuple[str, ...]) -> dict[str, NDArray[np.float64]]:
    """Return the columns of a CSV by name, each `(rows,)`, all numbers finite.

    Raises InputError for a file that cannot be read, a column not in `allowed`, or a value that is no
    number, with its row.
    """
    name = str(path)
    try:
        if Path(path).stat().st_size > LARGEST_FILE:
            raise InputError(name, f"must be at most {LARGEST_FILE} bytes")
        text = Path(path).read_text("utf-8-sig")
    except OSError as failure:
        raise InputError(name, f"cannot be read ({failure.strerror})", remedy="check the path") from None
    except UnicodeDecodeError:
        raise InputError(name, "is not UTF-8 text", remedy="save it as CSV in UTF-8") from None
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    rows = list(csv.reader(lines))
    if len(rows) < 2:
        raise InputError(name, "has no rows of numbers", remedy=f"first row: {','.join(allowed)}")
    header = [cell.strip() for cell in rows[0]]
    for column in header:
        if column not in allowed:
            raise InputError(f"{name}, column {column!r}", "unknown", remedy=did_you_mean(column, allowed))
    table = np.array([[_number(name, i, cell) for cell in row] for i, row in _even(name, header, rows)])
    return {column: table[:, i] for i, column in enumerate(header)}


def _even(name: str, header: list[str], rows: list[list[str]]) -> list[tuple[int, list[str]]]:
    for i, row in enumerate(rows[1:], 1):
        if len(row) != len(header):
            raise InputError(f"{name}, row {i}", f"must have {len(header)} values", len(row))
    return list(enumerate(rows[1:], 1))


def _number(name: str, row: int, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{name}, row {row}", "must be a finite number", cell)
    return value


def crest_drops(path: Path | str, design: Design) -> tuple[float, ...]:
    """Return by how much each crest of a measured part lies lower than designed, mm, ridge 1 first.

    Columns `ridge` and `crest_mm`: the summit's height over the flat back, every ridge once.
    """
    columns = read_columns(path, ("ridge", "crest_mm"))
    count, ridges = design.ridge.count, columns.get("ridge", np.array([]))
    if sorted(ridges.tolist()) != list(range(1, count + 1)) or "crest_mm" not in columns:
        raise InputError(str(path), f"must give crest_mm of each ridge from 1 to {count} once")
    measured = dict(zip(ridges.astype(int).tolist(), columns["crest_mm"].tolist(), strict=True))
    summits = {ridge: frame(design, ridge).at(0.0, design.ridge.height).z for ridge in measured}
    drops = tuple(summits[ridge] - measured[ridge] for ridge in range(1, count + 1))
    worst = max(range(count), key=lambda i: abs(drops[i]))
    if abs(drops[worst]) > design.ridge.height:
        raise InputError(
            f"{path}, ridge {worst + 1}",
            f"must be within {design.ridge.height:g} mm (ridge.height) of the designed "
            f"{summits[worst + 1]:.4g} mm over the back",
            measured[worst + 1],
        )
    return drops
