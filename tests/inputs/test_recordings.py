"""Recordings of films as a logger's CSV has them: what is read, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from skincad.inputs import film_recording
from tests.refusals import refused

STRIPS = ((4, "S1"), (4, "S2"), (5, "S1"))


def recorded(tmp_path: Path, seed: int, fault: str) -> Path:
    """300 rows of three strips at rest, then pressed, as a logger leaves them in a CSV."""
    dice = np.random.default_rng(seed)
    time = np.arange(300) / 1000.0
    press = float(dice.choice([-1.0, 1.0])) * np.clip((time - 0.1) / 0.1, 0.0, 1.0)
    volts = 0.05 * press * dice.uniform(0.7, 1.0, 3)[:, None] + 4e-4 * dice.standard_normal((3, 300))
    level = float(dice.uniform(0.2, 0.6)) * 0.05
    if fault == "clipped":
        volts = np.clip(volts, -level, level)
    elif fault == "one sign":
        volts = np.maximum(volts * -press[-1], 0.0)  # the sign that is lost
    elif fault == "rails":
        volts[2] = np.where(volts[2] > np.median(volts[2]), 5.0, -5.0)
    elif fault == "dead":
        volts[1] = 0.0
    elif fault == "dead but for its last bit":
        volts[1] = 1e-4 * (volts[1] > np.median(volts[1]))
    elif fault == "coarse":
        volts = 2e-3 * np.round(volts / 2e-3)
    path = tmp_path / "r.csv"
    names = ",".join(f"ridge_{ridge}_{side}_V" for ridge, side in STRIPS)
    np.savetxt(path, np.column_stack([time, *volts]), "%.6f", ",", header=f"time_s,{names}", comments="")
    return path


@pytest.mark.parametrize("seed", range(6))
def test_a_clipped_recording_is_refused(seed: int, tmp_path: Path) -> None:
    """Clipped, cut at zero, or at its rails; a dead strip and a coarse converter are read."""
    for fault, words in (
        ("clipped", "must not be clipped"),
        ("one sign", "clipped"),
        ("rails", "two values"),
    ):
        with refused(words):
            film_recording(recorded(tmp_path, seed, fault), STRIPS)
    for fault in ("none", "dead", "dead but for its last bit", "coarse"):
        assert film_recording(recorded(tmp_path, seed, fault), STRIPS).volts.shape == (3, 300)


def thin(table: str) -> str:
    return "".join(table.splitlines(keepends=True)[:4])


def going_back(table: str) -> str:
    lines = table.splitlines(keepends=True)
    return "".join([*lines[:40], lines[10], *lines[40:]])


BAD = {
    "a missing channel": (
        lambda t: t.replace("ridge_5_S1_V", "ridge_6_S1_V"),
        "'ridge_6_S1_V': did you mean 'ridge_5_S1_V'",
    ),
    "time that goes back": (going_back, "row 40: time_s must grow from row to row"),
    "milliamperes": (
        lambda t: t.replace("ridge_4_S2_V", "ridge_4_S2_mA"),
        "'ridge_4_S2_mA': did you mean 'ridge_4_S2_V'",
    ),
    "no time": (lambda t: t.replace("time_s", "ridge_4_S1_V", 1), "must be given once"),
    "three rows": (thin, "must have at least 20 rows, got 3"),
    "text": (lambda t: t.replace("0.001000,", "soon,", 1), "must be a finite number"),
    "nothing": (lambda _: "", "has no rows of numbers"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_recordings_are_refused(name: str, tmp_path: Path) -> None:
    path = recorded(tmp_path, 0, "none")
    change, said = BAD[name]
    changed = change(path.read_text())
    assert changed != path.read_text()
    path.write_text(changed)
    with refused(said):
        film_recording(path, STRIPS)


def test_signals_of_simulate_and_milliseconds_are_read(tmp_path: Path) -> None:
    path = recorded(tmp_path, 0, "none")
    expected = film_recording(path, STRIPS)
    head, *rows = path.read_text().splitlines()
    named = "time [s],ridge 4 S1 output [V],ridge 4 S2 output [V],ridge 5 S1 output [V],slipping ridges [1]"
    path.write_text("\n".join([named, *(f"{row},1 2" for row in rows)]))
    signals = film_recording(path, STRIPS)
    np.testing.assert_array_equal(signals.volts, expected.volts)
    milli = [f"{1000 * float(row.partition(',')[0]):g},{row.partition(',')[2]}" for row in rows]
    path.write_text("\n".join([head.replace("time_s", "time_ms"), *milli]))
    np.testing.assert_allclose(film_recording(path, STRIPS).time, expected.time, rtol=1e-12)
