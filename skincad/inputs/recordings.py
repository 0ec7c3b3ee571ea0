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
CLIPPED_SHARE = 0.2  # assumption: of the rows at one end, from which on a press is not seen
REST_ROWS, NOISY = 10, 3  # of the first rows so many values differ where noise is finer than the converter


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

    `simulate`'s signals.csv does too. Raises InputError for a missing column, time that does not grow, too
    few rows, and a voltage that is clipped or at its amplifier's rails.
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
    volts = np.array([columns[column] for column in wanted])
    for column, row in zip(wanted, volts, strict=True):
        _check_range(f"{name}, {column}", row, float(np.median(np.abs(volts).max(axis=1))))
    return FilmRecording(tuple(strips), time, volts, columns.notes)


def _check_range(where: str, volts: Array, usual: float) -> None:
    """Raise InputError for volts `(samples,)` cut at one end: a share of them is its very value, the others
    and those at rest differ; or at the rails of their amplifier, beyond what strips `usual`ly reach.

    A strip that is dead or coarsely converted is read.
    """
    values, rows = np.unique(volts, return_counts=True)
    if values.size == 2 and np.abs(values).max() > usual:
        rule = "must be a film's signal; each of its rows is one of two values"
        remedy = "see to its amplifier, or leave the ridge out of readout.ridges"
        raise InputError(where, rule, float(values[1]), remedy)
    at_rest = np.unique(volts[:REST_ROWS]).size
    for end, word in ((0, "least"), (-1, "largest")):
        others = volts.size - int(rows[end])
        cut = rows[end] >= CLIPPED_SHARE * volts.size and values.size - 1 >= (1 - CLIPPED_SHARE) * others
        if cut and at_rest >= NOISY:
            rule = f"must not be clipped; {rows[end]} of {volts.size} rows are its {word} value"
            remedy = "record again with less gain, a wider range or both signs"
            raise InputError(where, rule, float(values[end]), remedy)


def check_time(time: Array, where: str, key: str) -> None:
    """Raise InputError where time `(samples,)` s does not grow from sample to sample."""
    back = np.flatnonzero(np.diff(time) <= 0)
    if back.size:
        row = int(back[0]) + 2
        rule = f"{key} must grow from row to row, after {time[row - 2]:g} s"
        remedy = "give one recording, its rows in the order of time"
        raise InputError(where.format(row), rule, float(time[row - 1]), remedy)
