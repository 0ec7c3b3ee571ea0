"""A recording of the films: a time and a voltage of each strip, as a person's CSV has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skincad.base.arrays import Array
from skincad.base.columns import read_columns
from skincad.base.errors import InputError

FEWEST_ROWS = 20  # assumption: fewer show no press


@dataclass(frozen=True, eq=False)
class FilmRecording:
    """Voltages `(strips, samples)` V of `strips` (ridge from 1, side) at `time` `(samples,)` s. `notes` say
    how its file was read."""

    strips: tuple[tuple[int, str], ...]
    time: Array
    volts: Array
    notes: tuple[str, ...] = ()


def column_name(ridge: int, side: str) -> str:
    """Return the column of a strip's voltage."""
    return f"ridge_{ridge}_{side}_V"


def film_recording(path: Path | str, strips: Sequence[tuple[int, str]]) -> FilmRecording:
    """Return the recording of a CSV with `time_s` and a column a strip, as `ridge_3_S1_V`.

    `simulate`'s signals.csv does too. Raises InputError for a missing column, time that does not grow, and
    too few rows.
    """
    name = str(path)
    wanted = [column_name(ridge, side) for ridge, side in strips]
    columns = read_columns(path, ("time_s", *wanted))
    time = columns["time_s"]
    if time.size < FEWEST_ROWS:
        rule = f"must have at least {FEWEST_ROWS} rows"
        raise InputError(
            name, rule, int(time.size), "record the whole press, with a moment of rest before it"
        )
    check_time(time, f"{name}, row {{}}", "time_s")
    return FilmRecording(tuple(strips), time, np.array([columns[column] for column in wanted]), columns.notes)


def check_time(time: Array, where: str, key: str) -> None:
    """Raise InputError where time `(samples,)` s does not grow from sample to sample."""
    back = np.flatnonzero(np.diff(time) <= 0)
    if back.size:
        row = int(back[0]) + 2
        rule = f"{key} must grow from row to row, after {time[row - 2]:g} s"
        remedy = "give one recording, its rows in the order of time"
        raise InputError(where.format(row), rule, float(time[row - 1]), remedy)
