"""What a person measured: tests of a material, and the coupon's forms."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skincad.base.arrays import Array
from skincad.base.columns import LARGEST_FILE, SEPARATORS, read_columns
from skincad.base.errors import InputError, require_number
from skincad.base.reading import csv_text, text_of

PRESSED, STRETCHED = ("approach_mm", "force_N"), ("extension_mm", "force_N")
TESTS = (("strain", "stress_MPa"), STRETCHED, PRESSED)
FEWEST_ROWS = 8  # assumption: fewer leave no residual worth the name beside two fitted numbers
MOST_BACK = 0.05  # of the span; assumption: noise of a crosshead is less, an unloading more
MOST_WRONG = 0.05  # of the largest load; assumption: noise of a load cell is less
NEAR_ONE = 0.05  # of a stretch, and of the largest load, in row 1


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
    """Return the loading of a material test; the columns say which kind it is.

    `approach_mm, force_N`: a pad pressed by a plate. `strain, stress_MPa`, or `extension_mm, force_N` with
    gauge length in mm and cross-section in mm2: a bar. A column `time_s` is passed over. Rows after the
    largest deformation are left out. Raises InputError for other columns, rows that go to and fro, loads
    of the wrong sign and too few rows.
    """
    bar = gauge_length is not None or area is not None
    columns = read_columns(path, *(sorted(TESTS, key=lambda pair: pair != STRETCHED) if bar else TESTS))
    pair = next(pair for pair in TESTS if {*pair} <= columns.by_name.keys())
    deformation, load = (columns[name] for name in pair)
    if pair[0] == "strain":
        _refuse_stretch(str(path), deformation, load)
    sides = (("gauge_length", gauge_length, "mm"), ("area", area, "mm2"))
    for option, size, unit in sides:
        if size is not None:
            require_number(option, size, lambda value: value > 0, f"must be above 0 {unit}")
        if (size is None) == (pair == STRETCHED):
            rule = "is missing" if size is None else "is not used by a test"
            remedy = (
                "" if size else f"give the bar's; of a pressed pad call the columns {' and '.join(PRESSED)}"
            )
            raise InputError(option, f"{rule} with the columns {' and '.join(pair)}", size, remedy)
    if gauge_length is not None and area is not None:
        deformation, load = deformation / gauge_length, load / area
    squeezed = pair != PRESSED and abs(deformation.min()) > abs(deformation.max())
    kind: Literal["pad", "tensile", "compression"] = "tensile"
    if pair == PRESSED or squeezed:
        kind = "pad" if pair == PRESSED else "compression"
    return _loading(str(path), pair, kind, deformation, load, columns.notes)


def _refuse_stretch(name: str, strain: Array, load: Array) -> None:
    """Raise InputError for a stretch, which is 1 without load."""
    if abs(strain[0] - 1) <= NEAR_ONE and strain.min() > 0 and abs(load[0]) <= NEAR_ONE * np.abs(load).max():
        rule = "strain must be 0 without load"
        raise InputError(
            name, rule, float(strain[0]), "subtract 1 if these are stretches, length over length"
        )


def _loading(
    name: str,
    pair: tuple[str, str],
    kind: Literal["pad", "tensile", "compression"],
    deformation: NDArray[np.float64],
    load: NDArray[np.float64],
    notes: tuple[str, ...],
) -> MaterialTest:
    """The rows up to the largest deformation, if they go there once and the load with them."""
    sign = -1.0 if kind == "compression" else 1.0
    along, against = sign * deformation, sign * load
    last = int(np.argmax(along)) + 1
    loaded = last if kind == "pad" else _until_rupture(against[:last])
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
    if along.size > last:
        notes = (*notes, f"{along.size - last} rows after the largest {pair[0]} are left out")
    if loaded < last:
        notes = (*notes, f"the last {last - loaded} rows of loading are left out: the bar breaks before them")
    return MaterialTest(kind, deformation[:loaded], load[:loaded], along.size, notes)


def _until_rupture(force: Array) -> int:
    """The number of rows up to the largest load, if it then falls by more than noise; else of all."""
    steady = force.copy()
    steady[1:-1] = np.median([force[:-2], force[1:-1], force[2:]], axis=0)  # a spike of one row is no peak
    top = int(np.argmax(steady))
    top += int(np.argmax(force[top : top + 2]))
    noise = float(np.median(np.abs(np.diff(force, 2)))) if force.size > 2 else 0.0
    fall = float(steady[top] - force[top:].min())
    falls = fall > max(MOST_WRONG * float(steady[top]), NOISES * noise)
    return top + 1 if falls else force.size


FEWEST_PRESSES = 5  # rows above the noise; assumption: fewer leave nothing to judge beside zero and modulus
MOST_PRESSES = 5000  # rows; of so many `accept` takes two seconds, and no gauge has more to say
NOISES = 4.0  # standard deviations; a step to and fro by more is no noise
STEADY_ROWS = 3  # at the end of a press, from which a force that stays is a load cell's full scale
FULL_SCALE = 0.5  # of the force's error: what stays within it


@dataclass(frozen=True)
class PressCurve:
    """A cast part's press: `approach` `(n,)` mm from about the first touch, `force` `(n,)` N, as read.

    `force_error` N and `approach_error` mm are the standard deviations of their readings; that of the
    approach's zero is `approach_error` too. `notes` say how its file was read.
    """

    name: str
    approach: Array
    force: Array
    force_error: float
    approach_error: float
    notes: tuple[str, ...] = ()

    @property
    def loaded(self) -> NDArray[np.bool_]:
        """Which rows `(n,)` bear more than the noise of the force."""
        return np.asarray(self.force > 2 * self.force_error)


def press_curve(path: Path | str, force_error: float, approach_error: float) -> PressCurve:
    """Return a press from a CSV with the columns `approach_mm, force_N`, its rows in the order of the test.

    Raises InputError for other columns, too few rows under load, more than MOST_PRESSES, and an approach or
    a force that falls by more than the noise: by NOISES of the standard deviations given.
    """
    name = str(path)
    for option, error, unit in (("force_error", force_error, "N"), ("approach_error", approach_error, "mm")):
        require_number(option, error, lambda value: 0 < value <= 1e3, f"must be above 0 {unit}")
    columns = read_columns(path, PRESSED)
    approach, force = (columns[column] for column in PRESSED)
    if force.size > MOST_PRESSES:
        one_in = math.ceil(force.size / MOST_PRESSES)
        raise InputError(name, f"must have at most {MOST_PRESSES} rows", force.size, f"keep one in {one_in}")
    curve = PressCurve(name, approach, force, force_error, approach_error, columns.notes)
    _refuse_falling(curve)
    curve = _below_full_scale(curve)
    rows = int(np.count_nonzero(curve.loaded))
    if rows < FEWEST_PRESSES:
        rule = f"must have at least {FEWEST_PRESSES} rows above {2 * force_error:g} N, twice a force's error"
        raise InputError(name, rule, rows, "read the force at ten approaches, up to the design's force")
    return curve


def _below_full_scale(curve: PressCurve) -> PressCurve:
    """The rows less the last ones if their force stays while the approach grows: a load cell at its end."""
    stays = curve.force >= curve.force.max() - FULL_SCALE * curve.force_error
    last = int(np.argmin(stays[::-1])) if not stays.all() else 0
    before = curve.force.size - last
    rows = slice(max(0, before - STEADY_ROWS), before)
    gone = curve.approach[rows][-1] - curve.approach[rows][0]
    if last < STEADY_ROWS or gone <= 0:
        return curve
    slope = (curve.force[rows][-1] - curve.force[rows][0]) / gone
    if slope * (curve.approach[-1] - curve.approach[before]) < NOISES * curve.force_error:
        return curve
    stays_at = f"the force stays at {curve.force.max():.4g} N, as at the end of a scale"
    notes = (*curve.notes, f"the last {last} rows are left out: {stays_at}")
    return replace(curve, approach=curve.approach[:before], force=curve.force[:before], notes=notes)


def _refuse_falling(curve: PressCurve) -> None:
    """Raise InputError for the first row whose approach or force falls by more than noise, and for rows that
    do not grow at all."""
    span = float(np.ptp(curve.approach))
    for column, values in zip(PRESSED, (curve.approach, curve.force), strict=True):
        if values.size > 1 and not np.ptp(values):
            rule = f"{column} must grow from row to row"
            raise InputError(curve.name, rule, float(values[0]), "give one loading, a row for each approach")
    slope = 2 * float(np.ptp(curve.force)) / span if span else 0.0  # near the end of a bent curve
    noise = math.hypot(curve.force_error, slope * curve.approach_error)
    checks = (
        (
            PRESSED[0],
            curve.approach,
            curve.approach_error,
            "give one loading, its rows in the order of the test",
        ),
        (
            PRESSED[1],
            curve.force,
            noise,
            "tare the scale, count compression positive, leave the unloading out",
        ),
    )
    for column, values, error, remedy in checks:
        fall = np.maximum.accumulate(values) - values
        limit = NOISES * math.sqrt(2) * error
        if values[-1] < values[0] or (fall > limit).any():
            row = int(np.argmax(fall > limit)) if (fall > limit).any() else values.size - 1
            where = f"{curve.name}, row {row + 1}"
            raise InputError(where, f"{column} must not fall", float(values[row]), remedy)


NOTCH_FORM, CREST_FORM = "notches.csv", "crests.csv"
NOTCH_COLUMNS = ("notch", "drawn_mm", "goes_mm", "stops_mm")
CREST_COLUMNS = ("step", "drawn_mm", "measured_mm")
FEWEST = 5  # rows; assumption: fewer leave no scatter worth the name
SAME_SIZE = 1e-6  # mm: far below the 0.01 mm to which a form is written
MOST_OFF = 1.0  # mm from what is drawn, assumption: more is a slip of the pen, or another unit


class NotchForm(NamedTuple):
    """Notches `(n,)`, mm: as drawn, the thickest blade that goes in (0: none), the next one that stops."""

    drawn: Array
    goes: Array
    stops: Array


class CrestForm(NamedTuple):
    """Steps `(n,)`, mm: heights over the land as drawn and as measured; `place` along the block, from 1."""

    place: Array
    drawn: Array
    measured: Array


def form(columns: Sequence[str], rows: Iterable[Sequence[str]], notes: Iterable[str] = ()) -> str:
    """Return a form as CSV: notes behind #, the columns' names, rows whose empty cells are to be filled."""
    return csv_text([columns, *rows], notes)


def read_notches(folder: Path, ladder: Sequence[float] | None = None) -> NotchForm | None:
    """Return the form of the notches in a folder; None where there is none.

    Raises InputError for one that is not filled in, where a blade stops that is no thicker than what goes, or
    whose rows are not those of the `ladder`, the widths in mm as drawn, notch 1 first.
    """
    columns = _filled(folder / NOTCH_FORM, NOTCH_COLUMNS)
    if columns is None:
        return None
    path, (number, drawn, goes, stops) = folder / NOTCH_FORM, columns
    _check_drawn(path, "notch", number, drawn, ladder)
    _off(path, "goes_mm", drawn, goes, least=0.0)
    for i in range(drawn.size):
        if not goes[i] < stops[i]:
            rule = f"stops_mm must be thicker than goes_mm, {goes[i]:g}"
            remedy = "give the thickest blade that goes in, 0 for none, and the next one, which does not"
            raise InputError(f"{path}, row {i + 1}", rule, float(stops[i]), remedy)
    return NotchForm(drawn, goes, stops)


def read_crests(folder: Path, steps: Sequence[float] | None = None) -> CrestForm | None:
    """Return the form of the crests in a folder; None where there is none.

    Raises InputError for one that is not filled in, for heights of which none comes twice, or where rows are
    not those of the `steps`, the heights in mm as drawn, step 1 first.
    """
    columns = _filled(folder / CREST_FORM, CREST_COLUMNS)
    if columns is None:
        return None
    path, (place, drawn, measured) = folder / CREST_FORM, columns
    _check_drawn(path, "step", place, drawn, steps)
    _off(path, "measured_mm", drawn, measured)
    heights = sorted({*drawn.tolist()})
    fewest = min(int((drawn == height).sum()) for height in heights)
    if len(heights) < 3 or fewest < 2:  # less has no scatter
        rule = "must have at least three heights, each twice"
        raise InputError(str(path), rule, remedy="measure all steps")
    return CrestForm(place, drawn, measured)


def _filled(path: Path, columns: tuple[str, ...]) -> tuple[Array, ...] | None:
    """The columns of a form, if it is there."""
    if not path.exists():
        return None
    name = str(path)
    _check_filled(name, text_of(path, name, LARGEST_FILE, "CSV"), columns)
    table = read_columns(path, columns)
    rows = table["drawn_mm"].size
    if rows < FEWEST:
        raise InputError(name, f"must have at least {FEWEST} rows", rows)
    return tuple(table[column] for column in columns)


def _check_filled(name: str, text: str, columns: tuple[str, ...]) -> None:
    """Raise InputError for the first row with an empty cell, in the words of who has a form before them."""
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        return  # the reader of columns says what is missing
    separator = max(SEPARATORS, key=lines[0].count)
    header = [cell.strip() for cell in lines[0].split(separator)]
    for row, line in enumerate(lines[1:], 1):
        cells = [cell.strip() for cell in line.split(separator)]
        cells += [""] * (len(header) - len(cells))
        empty = [
            column for column, cell in zip(header, cells, strict=False) if column in columns and not cell
        ]
        if empty and any(cells):
            remedy = "measure it; a form that you did not measure: remove the whole file"
            raise InputError(f"{name}, row {row}", f"{empty[0]} is empty", remedy=remedy)


def _check_drawn(
    path: Path, column: str, numbers: Array, drawn: Array, expected: Sequence[float] | None
) -> None:
    """Raise InputError unless each place of the part has one row, in any order, of its size as drawn."""
    if expected is None:
        return
    remedy = "restore the row from a new form: skincad coupon PROCESS"
    rows = dict[int, int]()
    for i, (number, size) in enumerate(zip(numbers.tolist(), drawn.tolist(), strict=True), 1):
        where, places = f"{path}, row {i}", len(expected)
        if number not in range(1, places + 1):
            rule = f"{column} must be a whole number from 1 to {places}, as many as are drawn"
            raise InputError(where, rule, number, "remove the row, or name the process of this form")
        if int(number) in rows:
            rule = f"{column} must be another one: row {rows[int(number)]} is {column} {number:g} too"
            raise InputError(where, rule, number, "keep one row of each")
        rows[int(number)] = i
        as_drawn = expected[int(number) - 1]
        if abs(size - as_drawn) > SAME_SIZE:
            rule = f"drawn_mm of {column} {number:g} must be {as_drawn:g}, as drawn"
            raise InputError(where, rule, size, f"{remedy}; what you measure goes in the columns after it")
    missing = [str(i) for i in range(1, len(expected) + 1) if i not in rows]
    if missing:
        rule = f"must have a row for each {column} of the part; missing: {', '.join(missing)}"
        raise InputError(str(path), rule, remedy=remedy)


def _off(path: Path, column: str, drawn: Array, measured: Array, least: float | None = None) -> None:
    """Raise InputError for what can't have been meant."""
    for i in range(drawn.size):
        where = f"{path}, row {i + 1}"
        if drawn[i] <= 0:
            raise InputError(where, "drawn_mm must be above 0", float(drawn[i]), "print a new form")
        if least is not None and measured[i] < least:
            raise InputError(where, f"{column} must not be below {least:g}", float(measured[i]))
        if abs(measured[i] - drawn[i]) > MOST_OFF:
            rule = f"{column} must be within {MOST_OFF:g} mm of drawn_mm, {drawn[i]:g}"
            raise InputError(where, rule, float(measured[i]), "give millimetres")
