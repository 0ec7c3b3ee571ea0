"""`skincad accept` as a user meets it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import skincad
from tests.conftest import run_skincad
from tests.material.test_accept import APPROACH, FORCE, TEN, written

JSON_KEYS = {
    *("name", "passed", "verdict", "good_probability", "good_share", "in_from_share", "cause", "cause_alone"),
    *("causes", "young_modulus_MPa", "modulus_range_MPa", "zero_mm", "good_misfit", "rows", "rows_used"),
    *("largest_force_N", "force_error_N", "approach_error_mm", "seconds", "warnings", "file"),
}
SOFT = ("press.csv", "plain-ridges", "--set", "contact.force=5.0")


@pytest.fixture
def soft(tmp_path: Path) -> Path:
    """A part of half the modulus."""
    written(tmp_path, np.interp(TEN, FORCE, APPROACH), TEN / 2)
    return tmp_path


def test_a_soft_part_is_out_and_updates_the_design(soft: Path) -> None:
    done = run_skincad("accept", *SOFT, "--update", "mine.toml", "--ruled-out", "back", "--json", cwd=soft)
    assert done.returncode == 1, done.stderr
    result = json.loads(done.stdout)
    assert result.keys() == JSON_KEYS
    assert (result["verdict"], result["cause"], result["file"]) == ("out", "modulus", "mine.toml")
    assert result["causes"][0].keys() >= {"cause", "probability", "size", "unit", "misfit", "place"}
    modulus = skincad.load(soft / "mine.toml").material.young_modulus
    assert modulus is not None
    assert modulus.low < 0.4 < modulus.high
    assert "# measured: press press.csv" in (soft / "mine.toml").read_text()
    assert skincad.load(soft / "mine.toml").contact.force == 5.0
    assert sorted(p.name for p in soft.iterdir()) == ["mine.toml", "press.csv"]


@pytest.mark.slow
def test_the_part_is_in_by_the_silicone_that_it_measured(soft: Path) -> None:
    run_skincad("accept", *SOFT, "--update", "mine.toml", "--ruled-out", "back", cwd=soft)
    done = run_skincad("accept", "press.csv", "mine.toml", "--good-share", "0.97", cwd=soft)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("IN: the curve is a good part's, by 9")


@pytest.mark.slow
def test_a_modulus_that_is_not_the_silicones_is_not_written(tmp_path: Path) -> None:
    approach = np.interp(TEN, FORCE, APPROACH) + 0.06 * TEN  # on a soft back
    written(tmp_path, approach, TEN)
    fine = ("--force-error", "0.01", "--approach-error", "0.002")
    done = run_skincad("accept", "press.csv", "plain-ridges", *fine, "--update", "mine.toml", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("OUT: the curve is no good part's. A soft back of 0.0")
    assert "not written    mine.toml: another cause" in done.stdout
    assert [p.name for p in tmp_path.iterdir()] == ["press.csv"]


@pytest.mark.parametrize(
    ("header", "rows", "words"),
    [
        ("approach_mm,force_N", 3, "press.csv: must have at least 5 rows with a force above"),
        ("approach_um,force_g", 10, "press.csv: must have the columns approach_mm and force_N, got"),
        ("approach_mm,force_N", -10, "press.csv, row 9: force_N must not fall, got 1.6; tare"),
    ],
)
def test_a_bad_file_is_one_line_and_nothing_is_written(
    tmp_path: Path, header: str, rows: int, words: str
) -> None:
    force = TEN[::-1] if rows < 0 else TEN[:rows]
    written(tmp_path, np.interp(TEN, FORCE, APPROACH)[: force.size], force, header)
    done = run_skincad("accept", "press.csv", "plain-ridges", "--update", "mine.toml", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"skincad: {words}")
    assert done.stderr.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["press.csv"]


def test_an_update_over_a_file_is_refused_first(soft: Path) -> None:
    (soft / "mine.toml").write_text("")
    done = run_skincad("accept", *SOFT, "--update", "mine.toml", cwd=soft)
    assert done.returncode == 2
    assert done.stderr.startswith("skincad: --update: ")
    assert (soft / "mine.toml").read_text() == ""
