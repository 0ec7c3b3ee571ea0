"""Measured data from CSV files: crest heights of a cast part, and material tests.

The first row names the columns, with their unit; blank rows and rows that begin with # are passed over.
Spreadsheets' separators and decimal commas are read as they come.
"""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from skincad.design import Design
from skincad.errors import InputError, did_you_mean
from skincad.reading import text_of
from skincad.section import frame

LARGEST_FILE = 20_000_000  # bytes; a material test of an hour at 100 Hz has about 10 MB
MOST_ROWS = 1_000_000
SEPARATORS = {",": "comma", ";": "semicolon", "\t": "tab"}
NO_COMMAS = "write decimals with a point, or separate columns by semicolons"
_NUMBER = re.compile(r"[+-]?(\d++(\.\d*+)?|\.\d++)([eE][+-]?\d++)?", re.ASCII)
PRESSED, STRETCHED = ("approach_mm", "force_N"), ("extension_mm", "force_N")
TESTS = (PRESSED, ("strain", "stress_MPa"), STRETCHED)
FEWEST_ROWS = 8  # assumption: fewer leave no residual worth the name beside two fitted numbers
MOST_BACK = 0.05  # of the span; assumption: noise of a crosshead is less, an unloading more
MOST_SHIFT = 0.02  # of the skin's thickness; F9 goes with its power -0.65, so this changes it by 1.3 %
MOST_WRONG = 0.05  # of the largest load; assumption: noise of a load cell is less


def read_columns(path: Path | str, allowed: tuple[str, ...]) -> dict[str, NDArray[np.float64]]:
    """Return the columns of a CSV by name, each `(rows,)`, all numbers finite.

    The first row tells what separates columns: comma, semicolon or tab. Decimals have a point or, where no
    comma separates columns, all of them a comma. Raises InputError for a file that cannot be read, a column
    not in `allowed`, or a value that is no number, with its row.
    """
    name = str(path)
    text = text_of(Path(path), name, LARGEST_FILE, "CSV").replace("\r\n", "\n").replace("\r", "\n")
    if text.count("\n") > MOST_ROWS:
        raise InputError(
            name, f"must have at most {MOST_ROWS} rows", text.count("\n"), "take every second one"
        )
    lines = [line for line in text.split("\n") if line.strip() and not line.lstrip().startswith("#")]
    try:
        separator, header = _header(name, lines[:1], allowed)
        numbers = _numbers(name, lines[1:], separator, len(header))
    except csv.Error as failure:
        raise InputError(name, f"is not CSV ({failure})") from None
    if not numbers:
        raise InputError(name, "has no rows of numbers", remedy=f"first row: {','.join(allowed)}")
    table = np.array(numbers)
    return {column: table[:, i] for i, column in enumerate(header)}


def _header(name: str, lines: list[str], allowed: tuple[str, ...]) -> tuple[str, list[str]]:
    """What separates columns, and their names: as most of the names are known, or else as most come apart."""
    split = {mark: next(map(_cells, csv.reader(lines, delimiter=mark)), []) for mark in SEPARATORS}
    separator, header = max(split.items(), key=lambda found: (len({*found[1]} & {*allowed}), len(found[1])))
    for column in header:
        if column not in allowed:
            remedy = did_you_mean(column, allowed)
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


def _numbers(name: str, lines: list[str], separator: str, columns: int) -> list[list[float]]:
    """The rows of numbers, as many in each as there are columns; rows of empty cells are passed over."""
    decimal = "," if separator != "," and any("," in line for line in lines) else "."
    rows = filter(None, map(_cells, csv.reader(lines, delimiter=separator)))
    numbers = []
    for i, row in enumerate(rows, 1):
        if len(row) != columns:
            many = separator == "," and len(row) > columns
            remedy = NO_COMMAS if many else f"separate them by {SEPARATORS[separator]}, as in the first row"
            raise InputError(f"{name}, row {i}", f"must have {columns} values", len(row), remedy)
        numbers.append([_number(f"{name}, row {i}", cell, decimal) for cell in row])
    return numbers


def _number(where: str, cell: str, decimal: str) -> float:
    plain = cell if decimal == "." else cell.replace(".", " ").replace(",", ".")
    value = float(plain) if _NUMBER.fullmatch(plain) else math.nan
    if not math.isfinite(value):
        other = {".": NO_COMMAS, ",": "write all decimals with a comma, and nothing between thousands"}
        marked = set(cell) & {",", "."} - {decimal}
        raise InputError(where, "must be a finite number", cell, other[decimal] if marked else "")
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


def shift_warnings(drops: tuple[float, ...], design: Design) -> tuple[str, ...]:
    """Say that all crests of a measured part are shifted: the contact does not feel it, the thickness may."""
    shift = -float(np.median(drops)) if drops else 0.0
    if abs(shift) <= MOST_SHIFT * design.skin.thickness:
        return ()
    side = "higher" if shift > 0 else "lower"
    return (
        f"the median crest lies {abs(shift):.3g} mm {side} than designed: the gauge's zero, or a back of "
        f"another thickness than the {design.skin.thickness:g} mm that the model takes",
    )


@dataclass(frozen=True)
class MaterialTest:
    """A test while it loads: `deformation` and `load`, each `(rows,)`, mm and N of a pad, or strain and MPa.

    Strain and stress are engineering ones, negative in compression. `rows` counts those of the file.
    """

    kind: Literal["pad", "tensile", "compression"]
    deformation: NDArray[np.float64]
    load: NDArray[np.float64]
    rows: int
    warnings: tuple[str, ...]


def material_test(
    path: Path | str, gauge_length: float | None = None, area: float | None = None
) -> MaterialTest:
    """Return the loading of a material test, its kind told by the columns.

    `approach_mm, force_N`: a pad pressed by a plate. `strain, stress_MPa`, or `extension_mm, force_N` with
    gauge length in mm and cross-section in mm2: a bar. A column `time_s` is passed over. Rows after the
    largest deformation are left out. Raises InputError for other columns, rows that go to and fro, loads
    of the wrong sign and too few rows.
    """
    columns = read_columns(path, tuple(sorted({"time_s", *(c for pair in TESTS for c in pair)})))
    pair = next((pair for pair in TESTS if set(pair) == columns.keys() - {"time_s"}), None)
    if pair is None:
        raise InputError(str(path), "must have the columns " + ", or ".join(map(" and ".join, TESTS)))
    deformation, load = (columns[name] for name in pair)
    sides = (("--gauge-length", gauge_length, "mm"), ("--area", area, "mm2"))
    for option, size, unit in sides:
        if size is not None and not 0 < size < math.inf:
            raise InputError(option, f"must be above 0 {unit}", size)
        if (size is None) == (pair == STRETCHED):
            rule = "is missing" if size is None else "is not used by a test"
            raise InputError(option, f"{rule} with the columns {' and '.join(pair)}", size)
    if gauge_length is not None and area is not None:
        deformation, load = deformation / gauge_length, load / area
    squeezed = pair != PRESSED and abs(deformation.min()) > abs(deformation.max())
    kind: Literal["pad", "tensile", "compression"] = "tensile"
    if pair == PRESSED or squeezed:
        kind = "pad" if pair == PRESSED else "compression"
    return _loading(str(path), pair, kind, deformation, load)


def _loading(
    name: str,
    pair: tuple[str, str],
    kind: Literal["pad", "tensile", "compression"],
    deformation: NDArray[np.float64],
    load: NDArray[np.float64],
) -> MaterialTest:
    """The rows up to the largest deformation, if they go there once and the load with them."""
    sign = -1.0 if kind == "compression" else 1.0
    along, against = sign * deformation, sign * load
    last = int(np.argmax(along)) + 1
    up, force = along[:last], against[:last]
    span, largest = float(np.ptp(up)), float(force.max())
    if last < FEWEST_ROWS:
        rule = f"must have at least {FEWEST_ROWS} rows of loading, up to the largest {pair[0]}"
        raise InputError(name, rule, last, "give the rows in the order of the test, the load growing")
    back = np.maximum.accumulate(up) - up
    if (back > MOST_BACK * span).any():
        row = int(np.argmax(back > MOST_BACK * span)) + 1
        raise InputError(
            f"{name}, row {row}",
            f"{pair[0]} goes back before its largest value",
            remedy="give one loading, its rows in the order of the test",
        )
    if largest <= 0 or force.min() < -MOST_WRONG * largest:
        remedy = (
            "tare the load cell; a pad's force counts positive, a compression's stress and strain negative"
        )
        raise InputError(
            name, f"{pair[1]} must have the sign of {pair[0]}", sign * float(force.min()), remedy
        )
    left_out = along.size - last
    warnings = (f"{left_out} rows after the largest {pair[0]} are left out",) if left_out else ()
    return MaterialTest(kind, deformation[:last], load[:last], along.size, warnings)
