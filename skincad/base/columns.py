"""Columns of numbers from a CSV, as a person, a spreadsheet or a test machine wrote it.

One row names the columns: the first one with most of the names that are asked for. What stands above it is
passed over, and so are a row of units below it, columns that nobody asks for, blank rows, rows that begin
with #, and what follows the numbers. Names of other programs are known ("Engineering Stress (MPa)"), and
their units are converted. What was passed over, and how each column was read, is noted.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import takewhile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, did_you_mean, shown
from skincad.base.reading import text_of

LARGEST_FILE = 20_000_000  # bytes; a material test of an hour at 100 Hz has about 10 MB
MOST_ROWS, MOST_COLUMNS = 1_000_000, 1000
MOST_ABOVE = 200  # rows above the columns' names, assumption: machines write 5 to 60
LONGEST_NAME = 80  # letters of a column's name
MOST_TOLD = 5  # columns named in a note
MOST_NAMED = 4  # columns that are named together where some are missing
SEPARATORS = {",": "comma", ";": "semicolon", "\t": "tab"}
NO_COMMAS = "write decimals with a point, or separate columns by semicolons"
_NUMBER = re.compile(r"[+-]?(\d++(\.\d*+)?|\.\d++)([eE][+-]?\d++)?", re.ASCII)

# By a column's own unit, how many of it one of another unit is; as written, but for capitals where the small
# letters are unambiguous.
STANDARD_GRAVITY = 9.80665  # m/s2 (source: 3rd CGPM, 1901)
POUND, INCH = 0.45359237, 25.4  # kg, mm (source: international yard and pound agreement, 1959)
UNITS: dict[str, dict[str, float]] = {
    "": {"": 1.0, "1": 1.0, "-": 1.0, "mm/mm": 1.0, "m/m": 1.0, "in/in": 1.0, "%": 0.01, "percent": 0.01},
    "s": {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "min": 60.0},
    "mm": {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "micron": 1e-3, "cm": 10.0, "m": 1e3, "in": INCH, "inch": INCH},
    "N": {
        **{"N": 1.0, "newton": 1.0, "mN": 1e-3, "cN": 0.01, "kN": 1e3, "lbf": STANDARD_GRAVITY * POUND},
        **dict.fromkeys(("g", "gf", "gram", "grams"), STANDARD_GRAVITY * 0.001),
        **dict.fromkeys(("kg", "kgf", "kp"), STANDARD_GRAVITY),
        "lb": STANDARD_GRAVITY * POUND,
    },
    "MPa": {
        **dict.fromkeys(("MPa", "N/mm2", "N/mm^2", "N/mm²"), 1.0),
        **{"Pa": 1e-6, "kPa": 1e-3, "GPa": 1e3, "bar": 0.1},
        "psi": STANDARD_GRAVITY * POUND / INCH**2,
    },
    "V": {"V": 1.0, "volt": 1.0, "volts": 1.0, "mV": 1e-3, "uV": 1e-6, "µV": 1e-6},
    "Hz": {"Hz": 1.0, "kHz": 1e3},
    "dB": {"dB": 1.0},
}
_MEGA = ("mN", "MN", "mPa", "MPa", "ms", "Ms", "mV", "MV")  # whose first letter tells milli from mega

# What other programs call a quantity, the plainest first: Bluehill, testXpert, TestWorks, LabVIEW's loggers
NAMES = {
    quantity: tuple(words.split(", "))
    for quantity, words in {
        "time": "time, elapsed time, zeit",
        "force": "force, load, compressive load, tensile load, standard force, kraft, standardkraft",
        "strain": "strain, engineering strain, eng strain, nominal strain, tensile strain, "
        "compressive strain, strain 1, dehnung",
        "stress": "stress, engineering stress, eng stress, nominal stress, tensile stress, "
        "compressive stress, spannung",
        "extension": "extension, tensile extension, elongation, crosshead, crosshead displacement, "
        "displacement, travel, standard travel, weg, standardweg",
        "approach": "approach, indentation, compression, compressive extension, compressive displacement, "
        "depth, deflection, displacement, travel, extension, position, weg",
        "crest": "crest, crest height",
        "frequency": "frequency, freq, f",
        "gain": "gain, magnitude, mag",
    }.items()
}
_QUALIFIERS = {"", *(name for names in NAMES.values() for name in names)}  # "Tensile strain (Extension)"
_BRACKETS = re.compile(r"[(\[{<]([^()\[\]{}<>]*)[)\]}>]")
_LAST = re.compile(r"(.*?)(?:\s+in\s+|\s*[,/:]\s*|[\s_]+)(\S+)")


@dataclass(frozen=True)
class Columns:
    """The columns of a CSV: `by_name` each `(rows,)` in the unit of its name, and how they were read."""

    by_name: dict[str, Array]
    notes: tuple[str, ...]

    def __getitem__(self, name: str) -> Array:
        return self.by_name[name]


class _Match(NamedTuple):
    """A wanted column in a header: where it is, how many of its unit one of the file's is, None if the file
    names no unit, and how far down in NAMES its name is: -1 if it is as wanted."""

    place: int
    factor: float | None
    rank: int


class _Header(NamedTuple):
    """A row that names columns: its number of lines read, what separates columns, its cells, what it has."""

    row: int
    separator: str
    cells: list[str]
    found: dict[str, _Match]


def read_columns(path: Path | str, *sets: Sequence[str]) -> Columns:
    """Return the columns of the first of the `sets` that a CSV has, all numbers finite.

    A wanted column is called by quantity and unit, as `stress_MPa`. Comma, semicolon or tab separates
    columns; decimals have a point or, where no comma separates columns, all of them a comma. Raises
    InputError for a file that cannot be read, a set of which no column is there, and a value that is no
    number, with its row after that of the names.
    """
    name = str(path)
    text = text_of(Path(path), name, LARGEST_FILE, "CSV", "cp1252")  # as Windows writes µ and ²
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if text.count("\n") > MOST_ROWS:
        raise InputError(
            name, f"must have at most {MOST_ROWS} rows", text.count("\n"), "keep every second one"
        )
    lines = [line for line in text.split("\n") if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise InputError(name, "has no rows of numbers", remedy=f"first row: {','.join(sets[0])}")
    wanted = dict.fromkeys(column for one in sets for column in one)
    try:
        header = _header(name, lines, tuple(wanted))
        return _read(name, lines, header, _chosen(name, header, sets))
    except csv.Error as failure:
        raise InputError(name, f"is not CSV ({failure})") from None


def _read(name: str, lines: list[str], header: _Header, asked: Sequence[str]) -> Columns:
    """The columns that are asked for, of the rows below the header."""
    below = lines[header.row + 1 :]
    rows = [cells for cells in map(_cells, csv.reader(below, delimiter=header.separator)) if cells]
    matches = [header.found[column] for column in asked]
    units = rows and _units(rows[0])
    if units:
        rows = rows[1:]
    factors = []
    for column, match in zip(asked, matches, strict=True):
        under = units[match.place] if units and match.place < len(units) else ""
        factor = _factor(unit_of(column), under) if match.factor is None or under else match.factor
        if factor is None or (match.factor is not None and match.factor != factor):
            where = f"{name}, column {shown(header.cells[match.place])!r}"
            raise InputError(where, f"must be in a unit of {_told(column)}, as {column}", under or None)
        factors.append(factor)
    places = [match.place for match in matches]
    numbers, after = _numbers(name, rows, header.separator, len(header.cells), places)
    if not numbers:
        raise InputError(name, "has no rows of numbers", remedy=f"first row: {','.join(asked)}")
    table = np.array(numbers) * factors
    notes = _notes(header, asked, factors, bool(units), after)
    return Columns({column: table[:, i] for i, column in enumerate(asked)}, tuple(notes))


def _told(column: str) -> str:
    """The units that a column may have."""
    return ", ".join(dict.fromkeys(unit for unit in UNITS[unit_of(column)] if unit)) or "1"


def _notes(
    header: _Header, asked: Sequence[str], factors: Sequence[float], units: bool, after: int
) -> Iterator[str]:
    """How a file was read that is not just what was asked for."""
    parts = []
    for column, factor in zip(asked, factors, strict=True):
        theirs = header.cells[header.found[column].place]
        if theirs != column:
            parts.append(f"'{shown(theirs)}' as {column}" + (f", times {factor:.6g}" if factor != 1 else ""))
    if parts:
        yield f"read {'; '.join(parts)}"
    places = {header.found[column].place for column in asked}
    others = [shown(cell)[:40] for i, cell in enumerate(header.cells) if i not in places and cell]
    others = [cell for cell in others if _split(cell, "s")[0] not in NAMES["time"]]  # most tables have it
    passed = []
    if header.row:
        passed.append(f"{header.row} row{'s' * (header.row > 1)} above the columns' names")
    if units:
        passed.append("a row of units")
    if after:
        passed.append(f"{after} row{'s' * (after > 1)} after the numbers")
    if others:
        more = f" and {len(others) - MOST_TOLD} more" if len(others) > MOST_TOLD else ""
        listed = ", ".join(f"'{other}'" for other in others[:MOST_TOLD])
        passed.append(f"the column{'s' * (len(others) > 1)} {listed}{more}")
    if passed:
        yield f"passed over: {'; '.join(passed)}"


def _header(name: str, lines: list[str], wanted: tuple[str, ...]) -> _Header:
    """The row that names most of the wanted columns; the first one if none names any."""
    best: _Header | None = None
    for row, line in enumerate(lines[:MOST_ABOVE]):
        for separator in SEPARATORS:
            if line.count(separator) > MOST_COLUMNS:
                raise InputError(name, f"must have at most {MOST_COLUMNS} columns", line.count(separator) + 1)
            cells = next(map(_cells, csv.reader([line], delimiter=separator)), [])
            found = {column: match for column in wanted if (match := _match(name, column, cells))}
            if found and (best is None or len(found) > len(best.found)):
                best = _Header(row, separator, cells, found)
    return best or _unnamed(name, lines, wanted)


def _unnamed(name: str, lines: list[str], wanted: tuple[str, ...]) -> _Header:
    """Say what to do with a file of which no row names a column that is wanted."""
    separator = max(SEPARATORS, key=lambda mark: max(line.count(mark) for line in lines[:MOST_ABOVE]))
    table = [next(map(_cells, csv.reader([line], delimiter=separator)), []) for line in lines[:MOST_ABOVE]]
    numbers = [sum(_is_number(cell) for cell in cells) for cells in table]
    first = next((i for i, count in enumerate(numbers) if count and count >= max(numbers)), None)
    names = separator.join(wanted[:2]) if separator.strip() else f"{' and '.join(wanted[:2])}, a tab between,"
    if first is None:
        raise InputError(name, "has no rows of numbers", remedy=f"first row: {names}")
    theirs = [shown(cell)[:LONGEST_NAME] for cell in table[first - 1]] if first else []
    near = next((hint for cell in theirs if "did you mean" in (hint := did_you_mean(cell, wanted))), "")
    remedy = f"delete the {first} rows above the numbers, and write {names} first"
    if first < 2:
        remedy = near or f"write {names} as the first row" + (" instead" if first else "")
    raise InputError(name, "has no row that names its columns", ", ".join(theirs[:MOST_TOLD]) or None, remedy)


def _chosen(name: str, header: _Header, sets: Sequence[Sequence[str]]) -> Sequence[str]:
    """The first set that a header has."""
    for one in sets:
        if all(column in header.found for column in one):
            return one
    nearest = max(sets, key=lambda one: sum(column in header.found for column in one))
    missing = [column for column in nearest if column not in header.found]
    places = {match.place for match in header.found.values()}
    others = [shown(cell)[:80] for i, cell in enumerate(header.cells) if i not in places and cell]
    if len(nearest) > MOST_NAMED and len(missing) < len(nearest):  # all their names say less
        raise InputError(f"{name}, column '{missing[0]}'", "is missing", remedy="add the column")
    rule = "must have the columns " + ", or ".join(map(" and ".join, sets))
    near = ((other, hint) for other in others if "did you mean" in (hint := did_you_mean(other, missing)))
    if meant := next(near, None):
        remedy = f"{meant[0]!r}: {meant[1]}"
    elif others:
        remedy = f"rename the column that is {missing[0]}: {', '.join(map(repr, others[:MOST_TOLD]))}"
    else:
        remedy = f"add {', '.join(missing)}"
    raise InputError(name, rule, ", ".join(cell[:80] for cell in header.cells[:MOST_TOLD]), remedy)


def unit_of(column: str) -> str:
    """Return the unit in a wanted column's name, "" for a number without one."""
    unit = column.rpartition("_")[2]
    return unit if unit in UNITS else ""


def _match(name: str, column: str, cells: Sequence[str]) -> _Match | None:
    """Where a header has a wanted column, by its own name or the plainest of others'."""
    own = [i for i, cell in enumerate(cells) if cell == column]
    if len(own) > 1:
        raise InputError(f"{name}, column {column!r}", "must be given once", len(own))
    if own:
        return _Match(own[0], 1.0 if unit_of(column) else None, -1)
    unit = unit_of(column)
    quantity = column.removesuffix(f"_{unit}") if unit else column
    names = NAMES.get(quantity, (_plain(quantity), f"{_plain(quantity)} output"))
    found = []
    for i, cell in enumerate(cells):
        theirs, factor = _split(cell, unit)
        if theirs in names:
            found.append(_Match(i, factor, names.index(theirs)))
    best = [match for match in found if match.rank == min(other.rank for other in found)]
    if len(best) > 1:
        both = " and ".join(repr(shown(cells[match.place])[:80]) for match in best[:2])
        raise InputError(name, f"both columns {both} may be {column}", remedy="remove one of them")
    return best[0] if best else None


def _plain(text: str) -> str:
    return " ".join(text.replace("_", " ").lower().split())


def _split(cell: str, unit: str) -> tuple[str, float | None]:
    """A header's name in small letters, and how many of `unit` one of its unit is: None where it names none,
    NaN where that is not known. "Tensile strain (Extension) [%]" is "tensile strain" in hundredths."""
    bare, inner, head, last = _parts(cell)
    if inner:
        factor = _factor(unit, inner)
        return bare, math.nan if factor is None else factor
    if last and (factor := _factor(unit, last)) is not None:
        return head, factor
    return bare, None


@lru_cache(maxsize=10_000)
def _parts(cell: str) -> tuple[str, str, str, str]:
    """A header's name without brackets, the unit in them, and its name and unit where these are words."""
    if len(cell) > LONGEST_NAME or _is_number(cell):
        return "", "", "", ""
    bare = _BRACKETS.sub(" ", cell).strip()
    inner = [text for text in _BRACKETS.findall(cell) if _plain(text) not in _QUALIFIERS]
    words = _LAST.fullmatch(bare)
    head, last = (_plain(words[1]), words[2]) if words else ("", "")
    return _plain(bare), inner[-1] if inner else "", head, last


def _factor(unit: str, theirs: str) -> float | None:
    """How many of `unit` one of another is; None where it is not known to be one of the same quantity."""
    word, units = theirs.replace("\u03bc", "\u00b5").strip("()[]{}<> \t"), UNITS[unit]  # Greek mu for micro
    if not word:
        return 1.0
    if word in units:
        return units[word]
    if any(word.lower() == other.lower() for other in _MEGA):
        return None
    return next((value for key, value in units.items() if key.lower() == word.lower()), None)


def _units(cells: Sequence[str]) -> list[str] | None:
    """The units in a row that has nothing else, None if it has."""
    known = [not cell or any(_factor(unit, cell) is not None for unit in UNITS) for cell in cells]
    marked = any(not _is_number(cell) and cell for cell in cells)
    return [*cells] if known and all(known) and marked and not any(map(_is_number, cells)) else None


def _cells(row: list[str]) -> list[str]:
    """The cells of a row, without the empty ones that spreadsheets put at its end."""
    cells = [cell.strip() for cell in row]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _is_number(cell: str) -> bool:
    return _NUMBER.fullmatch(cell.replace(",", ".", 1)) is not None


def _numbers(
    name: str, rows: list[list[str]], separator: str, columns: int, places: list[int]
) -> tuple[list[list[float]], int]:
    """The rows of numbers at these places, as many cells in each as there are columns, and how many rows
    without a number follow the last."""

    def empty(row: list[str]) -> bool:
        return not any(_is_number(row[place]) for place in places if place < len(row))

    after = len([*takewhile(empty, reversed(rows))])
    after = 0 if after == len(rows) else after  # then the first row is told
    rows = rows[: len(rows) - after]
    wanted = (row[place] for row in rows for place in places if place < len(row))
    decimal = "," if separator != "," and any("," in cell for cell in wanted) else "."
    numbers = []
    for i, row in enumerate(rows, 1):
        if len(row) > max(places):
            row.extend([""] * (columns - len(row)))  # last cells that nobody reads may be empty
        if len(row) != columns:
            many = separator == "," and len(row) > columns
            remedy = (
                NO_COMMAS if many else f"separate them by {SEPARATORS[separator]}, as in the row of names"
            )
            raise InputError(f"{name}, row {i}", f"must have {columns} values", len(row), remedy)
        numbers.append([_number(f"{name}, row {i}", row[place], decimal) for place in places])
    return numbers, after


def _number(where: str, cell: str, decimal: str) -> float:
    plain = cell if decimal == "." else cell.replace(".", " ").replace(",", ".")
    value = float(plain) if _NUMBER.fullmatch(plain) else math.nan
    if not math.isfinite(value):
        other = {".": NO_COMMAS, ",": "write all decimals with a comma, and no thousands separator"}
        marked = set(cell) & {",", "."} - {decimal}
        raise InputError(where, "must be a finite number", cell, other[decimal] if marked else "")
    return value
