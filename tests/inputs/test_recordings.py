"""Recordings of films as a logger's CSV has them: what is read, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from skincad.inputs import film_recording
from tests.refusals import refused

RIDGES = (4, 5)
HEAD = "time_s,ridge_4_S1_V,ridge_4_S2_V,ridge_5_S1_V"


def recorded(folder: Path, head: str = HEAD) -> Path:
    time = np.arange(40) / 1000
    values = 0.001 * np.random.default_rng(0).integers(0, 100, (3, 40))
    path = folder / "r.csv"
    np.savetxt(path, np.column_stack([time, *values]), "%.6f", ",", header=head, comments="")
    return path


def test_the_channels_of_the_file_are_read(tmp_path: Path) -> None:
    films = film_recording(recorded(tmp_path), RIDGES)
    assert films.strips == ((4, "S1"), (4, "S2"), (5, "S1"))
    assert films.values.shape == (3, 40)
    assert films.rate == pytest.approx(1000)
    assert film_recording(recorded(tmp_path), (5,)).strips == ((5, "S1"),)


def going_back(table: str) -> str:
    lines = table.splitlines(keepends=True)
    return "".join([*lines[:30], lines[10], *lines[30:]])


BAD = {
    "no channel": (lambda t: t.replace("ridge_", "strip_"), "ridge_4_S1_V"),
    "time that goes back": (going_back, "row 30: time_s must grow from row to row"),
    "two units": (lambda t: t.replace("ridge_4_S2_V", "ridge_4_S2_mV"), "must have one unit in all channels"),
    "no time": (lambda t: t.replace("time_s", "when", 1), "time_s"),
    "three rows": (lambda t: "".join(t.splitlines(keepends=True)[:4]), "must have at least 20 rows, got 3"),
    "text": (lambda t: t.replace("0.001000,", "soon,", 1), "must be a finite number"),
    "nothing": (lambda _: "", "has no rows of numbers"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_recordings_are_refused(name: str, tmp_path: Path) -> None:
    path = recorded(tmp_path)
    change, said = BAD[name]
    changed = change(path.read_text())
    assert changed != path.read_text()
    path.write_text(changed)
    with refused(said):
        film_recording(path, RIDGES)


def test_milliseconds_and_a_jittering_clock_are_read(tmp_path: Path) -> None:
    path = recorded(tmp_path)
    expected = film_recording(path, RIDGES)
    head, *rows = path.read_text().splitlines()
    cells = [row.split(",") for row in rows]
    jitter = np.random.default_rng(1).uniform(-0.3, 0.3, len(rows))
    lines = [
        f"{1000 * float(time) + late:.4f},{','.join(values)}"
        for (time, *values), late in zip(cells, jitter, strict=True)
    ]
    path.write_text("\n".join([head.replace("time_s", "time_ms"), *lines]))
    films = film_recording(path, RIDGES)
    np.testing.assert_array_equal(films.values, expected.values)
    assert films.rate == pytest.approx(1000, rel=0.02)  # by the first and the last of 40 stamps
