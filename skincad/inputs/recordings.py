"""A recording of the films: a time and a value of each strip, as a person's CSV has them."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np

from skincad.base.arrays import Array
from skincad.base.columns import read_columns
from skincad.base.errors import InputError

HEAD = 200_000  # bytes, in which the columns' names are
_CHANNEL = re.compile(r"\bridge_(\d{1,4})_(S[12])(_V|_mV|_counts|)(?![\w])")
FEWEST_ROWS = 20  # assumption: fewer show no tap


@dataclass(frozen=True, eq=False)
class FilmRecording:
    """Values `(strips, samples)` of `strips` (ridge from 1, side) at even `time` `(samples,)` s.

    `unit` is V, mV, counts of a converter, or "" where it is not known. `notes` say how its file was read.
    """

    strips: tuple[tuple[int, str], ...]
    time: Array
    values: Array
    notes: tuple[str, ...] = ()
    unit: str = "V"

    @property
    def rate(self) -> float:
        """Samples per second, Hz."""
        return (self.time.size - 1) / float(self.time[-1] - self.time[0])


def column_name(ridge: int, side: str) -> str:
    """Return the column of a strip's voltage."""
    return f"ridge_{ridge}_{side}_V"


def film_recording(path: Path | str, ridges: Collection[int]) -> FilmRecording:
    """Return the recording of a CSV with `time_s` and a column a strip of these ridges, in the file's order.

    A column is `ridge_3_S1_V`, or with `_mV`, `_counts` of a converter or nothing in the place of `_V`; all
    have one of these. Times that are not even are those of even samples where they are off by less than a
    step, as a logger's clock is; else the values are interpolated. Raises InputError for a file without
    such a column, for two units, time that does not grow, and too few rows.
    """
    name, path = str(path), Path(path)
    with path.open("rb") if path.is_file() else BytesIO() as file:
        head = file.read(HEAD).decode("latin-1")
    cells = dict.fromkeys(_CHANNEL.findall(head))
    strips = [(int(ridge), side) for ridge, side, _ in cells if int(ridge) in ridges]
    units = {unit for ridge, _, unit in cells if int(ridge) in ridges}
    if len(units) > 1:
        raise InputError(name, "must have one unit in all channels", ", ".join(sorted(units)))
    unit = units.pop() if units else "_V"
    first = min(ridges)
    wanted = [f"ridge_{ridge}_{side}{unit}" for ridge, side in strips or [(first, "S1"), (first, "S2")]]
    columns = read_columns(path, ("time_s", *wanted))
    time = columns["time_s"]
    if time.size < FEWEST_ROWS:
        raise InputError(name, f"must have at least {FEWEST_ROWS} rows", int(time.size), "record all taps")
    check_time(time, f"{name}, row {{}}", "time_s")
    values = np.array([columns[column] for column in wanted])
    even = np.linspace(time[0], time[-1], time.size)
    step = float(np.median(np.diff(time)))
    if np.abs(time - even).max() > step:
        even = np.arange(time[0], time[-1], step)
        values = np.array([np.interp(even, time, row) for row in values])
    return FilmRecording(tuple(strips), even, values, columns.notes, unit.removeprefix("_"))


def check_time(time: Array, where: str, key: str) -> None:
    """Raise InputError where time `(samples,)` s does not grow from sample to sample."""
    back = np.flatnonzero(np.diff(time) <= 0)
    if back.size:
        row = int(back[0]) + 2
        rule = f"{key} must grow from row to row, after {time[row - 2]:g} s"
        remedy = "give one recording, its rows in the order of time"
        raise InputError(where.format(row), rule, float(time[row - 1]), remedy)
