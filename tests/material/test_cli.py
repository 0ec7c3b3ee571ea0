"""`skincad fit-material` as a user meets it."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

import skincad
from tests.conftest import run_skincad
from tests.refusals import refused_command

# yamada-2002 at 0.8 MPa, first touch at 0.25 mm, by models solid and finite-strain (test_fit.py)
FORCE = [0.0, 0.5, 1.0, 2.0, 3.0, 4.0]
APPROACH = [0.25, 0.29856, 0.32620, 0.36780, 0.40368, 0.43460]

JSON_KEYS = {
    *("passed", "kind", "rows", "rows_used", "young_modulus_MPa", "low_MPa", "high_MPa", "scatter_MPa"),
    *("model_MPa", "misfit_MPa", "offset_mm", "seconds", "warnings", "file"),
}


@pytest.fixture
def bar(tmp_path: Path) -> Path:
    stretch = 1 + np.linspace(0.0, 0.3, 40)
    stress = 0.7 / 3 * (stretch - stretch**-2) + 1e-3 * np.random.default_rng(1).standard_normal(40)
    rows = "\n".join(f"{s - 1:.6g},{p:.6g}" for s, p in zip(stretch, stress, strict=True))
    (tmp_path / "bar.csv").write_text(f"strain,stress_MPa\n{rows}\n")
    return tmp_path


def test_a_bar_gives_a_sentence_and_lines_to_paste(bar: Path) -> None:
    result = run_skincad("fit-material", "bar.csv", cwd=bar)
    assert (result.returncode, result.stderr) == (0, "")
    assert result.stdout.startswith("The tensile test gives a Young's modulus of 0.699")
    pasted = tomllib.loads(result.stdout[result.stdout.index("[material]") :])
    design = skincad.load("yamada-2002").with_(**pasted)
    assert design.material.young_modulus is not None
    assert design.material.young_modulus.low < 0.7 < design.material.young_modulus.high
    assert [p.name for p in bar.iterdir()] == ["bar.csv"]


def test_json_is_one_object_and_nothing_else(bar: Path) -> None:
    result = json.loads(run_skincad("fit-material", "bar.csv", "--json", cwd=bar).stdout)
    assert result.keys() >= JSON_KEYS
    assert result["young_modulus_MPa"].keys() == {"value", "error"}
    assert result["low_MPa"] < 0.7 < result["high_MPa"]
    assert result["offset_mm"] == {"value": None, "error": None}


@pytest.mark.slow
def test_a_pad_writes_a_design_that_checks_with_its_range(tmp_path: Path) -> None:
    approach = np.linspace(0.2, 0.4346, 30)
    force = np.interp(approach, APPROACH, FORCE)
    rows = "\n".join(f"{a:.5f},{f:.4f}" for a, f in zip(approach, force, strict=True))
    (tmp_path / "pad.csv").write_text(f"approach_mm,force_N\n{rows}\n")
    arguments = ("pad.csv", "--design", "yamada-2002", "--set", "contact.force=5.0", "-o", "mine.toml")
    run = run_skincad("fit-material", *arguments, "--json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    result = json.loads(run.stdout)
    assert result["low_MPa"] < 0.8 < result["high_MPa"]
    # straight lines between six points of a bent curve: the touch is a few um off
    assert result["offset_mm"]["value"] == pytest.approx(0.25, abs=0.01)
    text = (tmp_path / "mine.toml").read_text()
    assert "# paper: nine ridges" in text
    assert "# measured: pad test pad.csv" in text
    written = skincad.load(tmp_path / "mine.toml")
    said = written.material.young_modulus
    assert said is not None
    assert (said.low, said.high) == (result["low_MPa"], result["high_MPa"])
    assert written.with_(material={"young_modulus": 0.8}) == skincad.load(
        "yamada-2002", ["contact.force=5.0", "material.young_modulus=0.8"]
    )
    check = run_skincad("check", "mine.toml", "--tier", "linear", "--json", cwd=tmp_path)
    assert json.loads(check.stdout)["yield"] is not None, check.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mine.toml", "pad.csv"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.csv"], "none.csv: cannot be read"),
        (["empty.csv"], "empty.csv: has no rows of numbers"),
        (["bar.csv", "--up-to", "-1"], "--up-to: must be above 0"),
        (["bar.csv", "--up-to", "0.01"], "bar.csv: must have at least 8 rows under load up to 0.01"),
        (["bar.csv", "--area", "3"], "--area: is not used"),
        (["bar.csv", "--set", "skin.width=10.0"], "--set: needs --design"),
        (["bar.csv", "-o", "new.toml"], "-o: needs --design"),
        (["bar.csv", "--design", "yamada-2003"], "yamada-2003: no such template"),
        (["bar.csv", "--design", "yamada-2002", "-o", "there.toml"], "-o: there.toml exists already"),
        (["bar.csv", "--design", "yamada-2002", "-o", "new.txt"], "-o: new.txt must end in .toml"),
        (
            ["bar.csv", "--design", "yamada-2002", "-o", "there.toml/new.toml"],
            "-o: there.toml/new.toml cannot",
        ),
        (["bar.csv", "--design", "yamada-2002", "-o", "x" * 300 + ".toml"], "-o: xxxxxxxx"),
        (["pad.csv"], "--design: is missing"),
        ([], "Missing argument"),
    ],
)
def test_bad_input_is_one_line_and_exit_2_and_no_file(bar: Path, arguments: list[str], words: str) -> None:
    (bar / "empty.csv").write_text("")
    (bar / "there.toml").write_text("precious")
    (bar / "pad.csv").write_text("approach_mm,force_N\n" + "".join(f"{i},{i}\n" for i in range(20)))
    assert refused_command("fit-material", *arguments, cwd=bar).startswith(words)
    assert (bar / "there.toml").read_text() == "precious"


def test_a_curve_that_is_not_the_models_exits_with_1(bar: Path) -> None:
    rows = "".join(f"{i / 100},{(i / 100) ** 0.3}\n" for i in range(30))
    (bar / "odd.csv").write_text(f"strain,stress_MPa\n{rows}")
    result = run_skincad("fit-material", "odd.csv", "--json", cwd=bar)
    assert result.returncode == 1
    assert json.loads(result.stdout)["passed"] is False
    assert "does not follow the model" in result.stderr


def test_a_design_of_ones_own_keeps_its_comments_and_a_catalogs_name_goes_where_it_is_said(bar: Path) -> None:
    run_skincad("new", "own.toml", cwd=bar)
    result = run_skincad(
        "fit-material", "bar.csv", "--design", "own.toml", "--set", "slot=none",
        "--set", "contact.film=ignored", "-o", "in/here.toml", cwd=bar,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    text = (bar / "in" / "here.toml").read_text()
    assert "[slot]" not in [line.strip() for line in text.splitlines()]
    assert "# radius of the base circle" in text
    assert skincad.load(bar / "in" / "here.toml").slot is None
