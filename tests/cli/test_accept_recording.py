"""`skincad accept --recording FILM.csv SCENE` as a user meets it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from skincad.scenes import acceptance
from tests.conftest import run_skincad
from tests.refusals import refused_command
from tests.scenes.recordings import prediction, recording, scene, text

pytestmark = pytest.mark.slow


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a scene, whose prediction is there already."""
    monkeypatch.setattr(acceptance, "predict_films", lambda *_: prediction())
    (tmp_path / "scene.toml").write_text(scene().to_toml())
    (tmp_path / "film.csv").write_text(text(recording()))
    return tmp_path


def accept(folder: Path, *more: str):
    return run_skincad("accept", "--recording", "film.csv", "scene.toml", *more, cwd=folder)


@pytest.mark.dear("the first to need the prediction, which this group of tests shares")
def test_all_work(folder: Path) -> None:
    done = accept(folder)
    assert done.returncode == 0, done.stderr
    assert "ACCEPTED, 6 of 6 strips work" in done.stdout


def test_a_dead_strip_is_named_with_status_1(folder: Path) -> None:
    (folder / "film.csv").write_text(text(recording(dead=2), "time_ms"))
    done = accept(folder, "--json")
    assert done.returncode == 1, done.stderr
    answer = json.loads(done.stdout)
    assert not answer["passed"]
    assert [s["state"] for s in answer["strips"]] == ["works", "works", "dead", "works", "works", "works"]
    keys = {"name", "passed", "strips", "common_gain", "delay_s", "duration", "pull", "seconds", "warnings"}
    assert answer.keys() == keys
    strip = {"ridge", "side", "state", "shows", "probability", "second", "gain", "alike"}
    assert answer["strips"][0].keys() == strip


def without_a_column(table: str) -> str:
    return "".join(f"{line.rpartition(',')[0]}\n" for line in table.splitlines())


def going_back(table: str) -> str:
    lines = table.splitlines(keepends=True)
    return "".join([*lines[:40], lines[10], *lines[40:]])


BAD = {
    "a missing channel": (without_a_column, "film.csv, column 'ridge_3_S2_V': is missing"),
    "an unknown channel": (
        lambda t: t.replace("ridge_3_S2_V", "ridge_4_S2_V"),
        "column 'ridge_4_S2_V': unknown",
    ),
    "time that goes back": (going_back, "film.csv, row 40: time_s must grow from row to row"),
    "millivolts": (lambda t: t.replace("ridge_2_S1_V", "ridge_2_S1_mV"), "unknown; give volts"),
    "no time": (lambda t: t.replace("time_s", "ridge_1_S1_V", 1), "must be given once"),
    "time in another unit": (lambda t: t.replace("time_s", "time_ms"), "time_s: must cover the press"),
    "too short": (lambda t: "".join(t.splitlines(keepends=True)[:60]), "time_s: must cover the press"),
    "three rows": (lambda t: "".join(t.splitlines(keepends=True)[:4]), "must have at least 20 rows, got 3"),
    "too few samples": (lambda t: "".join(_thin(t, 50)), "time_s: must have a step of at most"),
    "text": (lambda t: t.replace("0.001,", "soon,", 1), "must be a finite number"),
    "nothing": (lambda _: "", "film.csv"),
}


def _thin(table: str, by: int) -> list[str]:
    head, *rows = table.splitlines(keepends=True)
    longer = [
        f"{float(r.partition(',')[0]) + 0.24 * k:.9g},{r.partition(',')[2]}" for k in range(5) for r in rows
    ]
    return [head, *longer[::by]]


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_line_and_status_2(folder: Path, name: str) -> None:
    change, words = BAD[name]
    table = (folder / "film.csv").read_text()
    changed = change(table)
    assert changed != table
    (folder / "film.csv").write_text(changed)
    assert words in refused_command("accept", "--recording", "film.csv", "scene.toml", cwd=folder)


def test_a_missing_file_is_refused(folder: Path) -> None:
    assert "none.csv" in refused_command("accept", "--recording", "none.csv", "scene.toml", cwd=folder)


def test_signals_of_simulate_are_a_recording(folder: Path) -> None:
    made = recording()
    head = ["step [1]", "time [s]", "normal force [N]"]
    head += [f"ridge {r} {s} output [V]" for r, s in made.strips] + [
        "ridge 1 pair output [V]",
        "slipping ridges [1]",
    ]
    rows = [
        [str(i), f"{t:.9g}", "1", *(f"{v:.9g}" for v in made.volts[:, i]), "0", "1 2" * (i > 100)]
        for i, t in enumerate(made.time)
    ]
    (folder / "film.csv").write_text("\n".join(",".join(row) for row in [head, *rows]))
    assert accept(folder).returncode == 0
