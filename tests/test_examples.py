"""The notebooks of examples/ run from top to bottom, and are committed without outputs."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

import skincad
from skincad.base import files_below

NOTEBOOKS = sorted((Path(__file__).parent.parent / "examples").glob("*.ipynb"))
WALK = "wish-to-skin"  # the one that writes


def code(notebook: Path) -> list[dict[str, Any]]:
    return [cell for cell in json.loads(notebook.read_text())["cells"] if cell["cell_type"] == "code"]


@pytest.mark.slow
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names: dict[str, Any] = {}
    for number, cell in enumerate(code(notebook)):
        exec(compile("".join(cell["source"]), f"{notebook.name}, code cell {number}", "exec"), names)
    # computing writes nothing
    assert [path.name for path in tmp_path.iterdir()] == (["out"] if notebook.stem == WALK else [])
    if notebook.stem == WALK:
        keeps_its_word(names, tmp_path / "out/pad")
    if notebook.stem == "slip-scene":
        warns_in_time(names)


def keeps_its_word(names: dict[str, Any], folder: Path) -> None:
    """A wish becomes a part that can be cast, with its verdict."""
    wish, verdict, made = names["wish"], names["verdict"], names["made"]
    assert wish.passed
    assert (wish.design.skin.width, wish.design.skin.length, verdict.force) == (16.0, 20.0, 0.5)
    assert verdict.passed
    assert verdict.all_touch_force.error > 0
    assert verdict.all_touch_force.upper < verdict.force
    assert made.passed
    assert json.loads((folder / "make.json").read_text())["passed"]
    assert {"solids/skin.step", "solids/mold.3mf", "casting-sheet.md"} <= {*files_below(folder)}


def warns_in_time(names: dict[str, Any]) -> None:
    """The amplifier's voltage follows the rate, and what is noticed behind it is noticed after it began."""
    assert names["gain"].slopes.below.value == pytest.approx(20, abs=0.1)  # dB/dec
    answer = names["answer"]
    noticed = answer["lead_time_s"]["all"]
    assert 0 < noticed < 1e-3 * max(lead for lead in answer["slip_lead_ms"].values() if lead is not None)
    assert len(names["columns"]) == 3


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_has_no_outputs_and_names_that_are_skincads(notebook: Path) -> None:
    for cell in code(notebook):
        for name in re.findall(r"\bskincad\.(\w+)", "".join(cell["source"])):
            assert hasattr(skincad, name), name
    assert not any(cell["outputs"] or cell["execution_count"] for cell in code(notebook))
