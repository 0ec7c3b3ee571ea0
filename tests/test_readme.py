"""README, docs/ and examples/ keep their word: what they show runs, files are made, the picture is ours."""

from __future__ import annotations

import re
import shlex
import tomllib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import skincad
from skincad.commands import app
from tests.conftest import Made, run_skincad
from tests.documents import DOCUMENTS, ROOT, blocks, commands, programs
from tests.material.test_cli import APPROACH, FORCE

README = (ROOT / "README.md").read_text()

# --- commands --------------------------------------------------------------------------------------------

DEAR = re.compile(r"skincad (make|check|simulate|accuracy|fit-material|solve|sweep|optimise)")
# what keeps a command as shown within a minute, and its meaning
CHEAPER = {
    "make": ("--format", "md"),
    "simulate": ("--budget", "0.1"),
    "accuracy": ("--repeats", "1", "--set", "ridge.count=3", "--set", "skin.width=5.0"),
}


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that the documents' reader sits in: one for all commands, with the files that they name."""
    folder = tmp_path_factory.mktemp("desk")
    run_skincad("new", "mine.toml", cwd=folder)
    approach = np.linspace(APPROACH[0] - 0.05, APPROACH[-1], 30)
    rows = [f"{a:.5f},{f:.4f}" for a, f in zip(approach, np.interp(approach, APPROACH, FORCE), strict=True)]
    (folder / "press.csv").write_text("\n".join(["approach_mm,force_N", *rows]) + "\n")
    return folder


def test_every_line_of_shell_is_a_command_of_ours() -> None:
    """What is none is run elsewhere (`documents.ELSEWHERE` says where); nothing is passed over."""
    assert commands()
    for line in commands():
        assert line.startswith("skincad "), line


@pytest.mark.parametrize(
    "line", [pytest.param(each, marks=[pytest.mark.slow] * bool(DEAR.search(each))) for each in commands()]
)
def test_the_commands_shown_work(desk: Path, tmp_path: Path, line: str) -> None:
    arguments = shlex.split(line)[1:]
    arguments += CHEAPER.get(arguments[0], ())
    done = run_skincad(*arguments, cwd=tmp_path if arguments[0] == "new" else desk)
    assert done.returncode == 0, done.stderr


def test_every_command_is_shown() -> None:
    for command in app.registered_commands:
        assert f"skincad {command.name or command.callback.__name__}" in README


# --- Python and TOML -------------------------------------------------------------------------------------

PROGRAMS = programs()


def test_names_in_the_python_shown_are_skincads() -> None:
    for where, text in PROGRAMS.items():
        compile(text, where, "exec")
        for name in re.findall(r"\bskincad\.(\w+)", text):
            assert hasattr(skincad, name), f"{where}: skincad.{name}"


@pytest.mark.slow
@pytest.mark.parametrize("where", PROGRAMS)
def test_the_python_shown_runs(
    where: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    text = PROGRAMS[where]
    monkeypatch.chdir(tmp_path)
    exec(compile(text, where, "exec"), {})
    assert bool(capsys.readouterr().out.strip()) or "print(" not in text
    for folder in re.findall(r"\"(out/[\w/.-]+)\"", text):
        assert any((tmp_path / folder).iterdir()), folder


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_the_toml_shown_is_toml(path: Path) -> None:
    for block in blocks(path):
        if block.language == "toml":
            tomllib.loads(block.text)


# --- files -----------------------------------------------------------------------------------------------


def test_every_file_of_a_make_is_explained(made: Made) -> None:
    table = README.split("## What you get")[1].split("\n## ")[0]
    for name, _ in made.written.files:
        kind = name.rpartition(".")[2]
        assert f"`{name}`" in table or (kind in ("step", "stl") and f".{kind}`" in table), name


def test_the_picture_is_what_the_program_draws(made: Made) -> None:
    shown, drawn = (
        np.asarray(Image.open(p).convert("L").resize((363, 203)), dtype=float)
        for p in (ROOT / "README.png", made.folder / "picture.png")
    )
    # other fonts move letters by a pixel or two: 0.3; tilted strips already make 1.1, a lower ridge 1.9
    assert np.abs(shown - drawn).mean() < 0.6


def test_the_files_it_sends_people_to_are_there() -> None:
    named = [
        n
        for p in DOCUMENTS
        for n in re.findall(r"`((?:skincad|templates|tests|bench)/[\w/.]+)`", p.read_text())
    ]
    assert len(named) > 10
    for name in named:
        assert (ROOT / name).exists(), name
