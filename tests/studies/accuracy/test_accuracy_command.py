"""`skincad accuracy` from the outside: its JSON, its files, and what it refuses."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from PIL import Image

from skincad.base import replaced
from skincad.base.machine import machine
from skincad.outputs import LADDER_SIZE, STYLES, diagram, save
from skincad.studies import ErrorMeasure, Ladder, Measurement
from skincad.studies.accuracy import circuit
from tests.conftest import run_skincad

NUMBER, TEXT = {"type": "number"}, {"type": "string"}
SCHEMA = {
    "type": "object",
    "required": ["name", "rows", "reference", "time_laws", "machine", "repeats", "seconds", "files"],
    "properties": {
        "rows": {
            "type": "array",
            "minItems": 1,
            "items": {
                "type": "object",
                "required": ["ladder", "model", "setting", "unknowns", "seconds", "error"],
                "properties": {
                    "ladder": TEXT,
                    "model": TEXT,
                    "setting": TEXT,
                    "unknowns": {"type": "integer"},
                    "seconds": {"type": "number", "exclusiveMinimum": 0},
                    "error": {"type": ["number", "null"]},
                    "errors": {"type": "object", "additionalProperties": NUMBER},
                },
            },
        },
        "reference": {"type": "object", "minProperties": 1},
        "machine": {"type": "object", "required": ["processor", "cores", "versions", "load"]},
        "seconds": {"type": "object", "required": ["total"]},
    },
}


@pytest.fixture
def _few_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    """A short ladder: what is told of it does not hang on its length."""
    monkeypatch.setattr(circuit, "PER_PERIOD", (16, 64))


@pytest.mark.usefixtures("_few_samples")
def test_json_files_and_manifest(tmp_path: Path) -> None:
    done = run_skincad(
        "accuracy", "plain-ridges", "--ladder", "circuit", "--repeats", "1", "--json", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    jsonschema.validate(data, SCHEMA)
    assert done.stderr == ""
    folder = tmp_path / "out" / "plain-ridges"
    assert {Path(file["path"]).name for file in data["files"]} == {"accuracy.csv", "accuracy-circuit.png"}
    assert {path.name for path in folder.iterdir()} == {
        "accuracy.csv",
        "accuracy-circuit.png",
        "accuracy.json",
    }
    rows = list(csv.DictReader((folder / "accuracy.csv").open()))
    assert [row["setting"] for row in rows] == [row["setting"] for row in data["rows"]]
    first = float(rows[0]["circuit: output"])
    assert first == pytest.approx(data["rows"][0]["error"], rel=1e-3)  # four digits
    with Image.open(folder / "accuracy-circuit.png") as picture:
        assert picture.size == (round(100 * LADDER_SIZE[0]), round(100 * LADDER_SIZE[1]))


def test_no_host_and_no_user_is_told() -> None:
    import platform

    answer = json.dumps(machine())
    assert platform.node() not in answer or not platform.node()
    assert machine()["cores"] >= 1


@pytest.mark.usefixtures("_few_samples")
def test_another_jobs_files_stay(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with replaced(folder, "make") as staging:
        (staging / "skin.step").write_text("solid")
    done = run_skincad(
        "accuracy", "plain-ridges", "--ladder", "circuit", "--repeats", "1", "-o", "out", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert (folder / "skin.step").read_text() == "solid"
    assert (folder / "accuracy.csv").is_file()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--ladder", "contcat"), "--ladder: unknown ladder, got 'contcat'; did you mean 'contact'?"),
        (("--repeats", "0"), "--repeats: must be from 1 to 100, got 0"),
        (("--set", "ridge.hight=1"), "ridge.hight: unknown key; did you mean 'height'?"),
    ],
)
def test_bad_input_is_one_line_and_touches_nothing(
    arguments: tuple[str, ...], said: str, tmp_path: Path
) -> None:
    done = run_skincad("accuracy", "plain-ridges", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert said in done.stderr
    assert not any(tmp_path.iterdir())


def test_methods_differ_without_colour() -> None:
    assert len({marker for _, marker, _ in STYLES}) == len(STYLES)
    assert len({str(dashes) for _, _, dashes in STYLES}) == len(STYLES)


def test_a_diagram_in_grey_shows_every_trial(tmp_path: Path) -> None:
    """A trial more is ink more, in grey; a ladder without any is a picture that says so."""
    measure = ErrorMeasure("all", "error", "1", "the truth", "")
    trials = tuple(
        Measurement("a", f"{i}", i, (10.0**-i, 2 * 10.0**-i), {"all": 10.0 ** (i - 5)}) for i in range(4)
    )
    other = tuple(Measurement("b", f"{i}", i, (2.0**-i,), {"all": 10.0 ** (i - 4)}) for i in range(4))
    ink = []
    for name, these in (("none", ()), ("one", trials), ("two", trials + other)):
        path = tmp_path / f"{name}.png"
        save(diagram(Ladder("x", "x", these, (measure,)), machine()), path)
        with Image.open(path) as picture:
            ink.append(int((np.asarray(picture.convert("L")) < 160).sum()))
    assert ink[0] < ink[1] < ink[2]
