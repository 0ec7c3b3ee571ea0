"""The README keeps its word: its Python runs, its files are made, its picture is the program's."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from skincad.commands import app
from tests.conftest import Made, run_skincad

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()


def test_the_python_lines_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    (block,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "README.md", "exec"), {})
    assert "cavity" in capsys.readouterr().out
    assert (tmp_path / "out/higher/assembly.step").is_file()


def test_every_file_of_a_make_is_explained(made: Made) -> None:
    table = README.split("## What you get")[1].split("\n## ")[0]
    for name, _ in made.written.files:
        kind = name.rpartition(".")[2]
        assert f"`{name}`" in table or (kind in ("step", "stl") and f".{kind}`" in table), name


LINES = re.findall(r"^    (skincad (?:make|check|new) .+?)(?:  .*)?$", README, re.M)
DEAR = re.compile(r"skincad make|--stress|--tol")  # the first command of all is a fast test's, by `made`


@pytest.mark.parametrize(
    "line", [pytest.param(each, marks=[pytest.mark.slow] * bool(DEAR.search(each))) for each in LINES]
)
def test_the_commands_shown_work(tmp_path: Path, line: str) -> None:
    run_skincad("new", "mine.toml", cwd=tmp_path)
    arguments = line.split()[1:]
    if arguments[0] == "new":
        arguments[1] = "other.toml"
    if arguments[0] == "make":
        arguments += ["--format", "md"]
    done = run_skincad(*arguments, cwd=tmp_path)
    assert done.returncode == 0, done.stderr


def test_every_command_is_shown() -> None:
    for command in app.registered_commands:
        assert f"skincad {command.name or command.callback.__name__}" in README


def test_the_picture_is_what_the_program_draws(made: Made) -> None:
    shown, drawn = (
        np.asarray(Image.open(p).convert("L").resize((363, 203)), dtype=float)
        for p in (ROOT / "README.png", made.folder / "picture.png")
    )
    # other fonts move letters by a pixel or two: 0.3; tilted strips already make 1.1, a lower ridge 1.9
    assert np.abs(shown - drawn).mean() < 0.6


def test_the_files_it_sends_people_to_are_there() -> None:
    named = re.findall(r"`((?:skincad|templates|tests)/[\w/.]+)`", README)
    assert len(named) > 10
    for name in named:
        assert (ROOT / name).exists(), name
