"""A recording of the films: a time and a voltage of each strip, as a person's CSV has them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skincad.base.arrays import Array
from skincad.base.columns import read_columns
from skincad.base.errors import InputError

FEWEST_ROWS = 20  # assumption: fewer show no press
TIMES = {"time_s": 1.0, "time [s]": 1.0, "time_ms": 1e-3, "time [ms]": 1e-3}
# of `simulate`'s signals.csv, which has more than a recording
PASSED_OVER = re.compile(
    r"step \[1\]|(normal|tangential) force \[N\]|(approach|travel) \[mm\]|slipping ridges \[1\]"
    r"|ridge \d+ (raw differential stress|differential stress|stress-rate|stress-jerk) \[.*\]"
    r"|ridge \d+ pair output \[V\]|ridge_\d+_pair_V"
)
OTHER_UNIT = re.compile(r"ridge[_ ]\d+[_ ]S[12][_ ](output \[)?(mV|uV|µV|kV|MPa|pC|C|A|nA)\]?")


@dataclass(frozen=True, eq=False)
class FilmRecording:
    """Voltages `(strips, samples)` V of `strips` (ridge from 1, side) at `time` `(samples,)` s."""

    strips: tuple[tuple[int, str], ...]
    time: Array
    volts: Array


def column_name(ridge: int, side: str) -> str:
    """Return the column of a strip's voltage."""
    return f"ridge_{ridge}_{side}_V"


def film_recording(path: Path | str, strips: Sequence[tuple[int, str]]) -> FilmRecording:
    """Return the recording of a CSV with `time_s` or `time_ms` and a column a strip, as `ridge_3_S1_V`.

    The names of `simulate`'s signals.csv, `time [s]` and `ridge 3 S1 output [V]`, do too; its other columns
    are passed over. Raises InputError for a missing or unknown column, another unit, time that does not
    grow, and too few rows.
    """
    name = str(path)
    wanted = {column_name(ridge, side): f"ridge {ridge} {side} output [V]" for ridge, side in strips}
    allowed = (*TIMES, *wanted, *wanted.values())
    columns = read_columns(path, allowed, ignored=PASSED_OVER, refuse=_other_unit)
    times = [key for key in TIMES if key in columns]
    if len(times) != 1:
        rule = "needs one column of time, time_s or time_ms"
        raise InputError(name, rule, ", ".join(times) or None, "name the time in the first row")
    volts = []
    for short, long in wanted.items():
        if (short in columns) == (long in columns):
            rule = "must be given once" if short in columns else "is missing"
            remedy = (
                "give a column for each strip of readout.ridges, or name the ridges that you recorded there"
            )
            raise InputError(f"{name}, column '{short}'", rule, remedy=remedy)
        volts.append(columns[short if short in columns else long])
    time = columns[times[0]] * TIMES[times[0]]
    if time.size < FEWEST_ROWS:
        rule = f"must have at least {FEWEST_ROWS} rows"
        raise InputError(
            name, rule, int(time.size), "record the whole press, with a moment of rest before it"
        )
    check_time(time, f"{name}, row {{}}", times[0])
    return FilmRecording(tuple(strips), time, np.array(volts))


def check_time(time: Array, where: str, key: str) -> None:
    """Raise InputError where time `(samples,)` s does not grow from sample to sample."""
    back = np.flatnonzero(np.diff(time) <= 0)
    if back.size:
        row = int(back[0]) + 2
        rule = f"{key} must grow from row to row, after {time[row - 2]:g} s"
        remedy = "give one recording, its rows in the order of time"
        raise InputError(where.format(row), rule, float(time[row - 1]), remedy)


def _other_unit(column: str) -> str:
    """Return the remedy for a strip's column in another unit, "" for any other column."""
    return "give volts, as ridge_3_S1_V" if OTHER_UNIT.fullmatch(column) else ""
