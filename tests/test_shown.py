"""What README.md, docs/ and examples/ show works: each command, Python line and cell, in one folder for each.

A block of csv or toml right after a line that ends in a file's name and a colon is that file. `# fails` after
a command means status 1, `# until Ctrl-C` that it goes on until then. PORT is a simulated board. A text block
right after commands is what the last of them prints: its first line word for word, all others but for their
numbers, which are times and what rounding leaves.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import typer

import skincad
from skincad.base import files_below
from skincad.cli.app import app
from skincad.scenes import SceneRun, marched, marching
from tests.conftest import run_skincad
from tests.ports import board
from tests.processes import started

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))
WALK = "wish-to-skin"  # the one that writes
WITH_EACH_COMMIT = ("README.md", "docs/start/", "examples/sweep.ipynb")
BY_TURNS = ("docs/start/first-scene.md", "docs/start/own-design.md")  # the two dearest
FENCED = re.compile(r"(?:`([\w-]+\.(?:csv|toml))`:\n+)?^```(\w+)\n(.*?)^```$", re.M | re.S)
ELSEWHERE = re.compile(r"^(python3|py) -m venv ")  # .ci/run takes README's install and tests word for word
INTERRUPTED = 130  # status of what Ctrl-C ended
PORT = "/dev/ttyACM0"
COMMANDS = typer.main.get_command(app).commands  # type: ignore[attr-defined]


class Block(NamedTuple):
    file: str
    kind: str
    text: str


def files(paths: list[Path]) -> list[Any]:
    """Parameters: what a person meets first runs with each commit, the rest by turns."""
    names = {path: path.relative_to(ROOT).as_posix() for path in paths}
    return [
        pytest.param(path, id=name, marks=[_mark(name)] if _shows_work(path) else [])
        for path, name in names.items()
    ]


def _mark(name: str) -> pytest.MarkDecorator:
    often = name.startswith(WITH_EACH_COMMIT) and name not in BY_TURNS
    return pytest.mark.slow if often else pytest.mark.evidence(subject=name)


def _shows_work(path: Path) -> bool:
    return path in NOTEBOOKS or any(block.kind in ("sh", "python") for block in blocks(path))


def blocks(page: Path) -> list[Block]:
    return [Block(*entry) for entry in FENCED.findall(page.read_text("utf-8"))]


def shown(*kinds: str) -> list[Any]:
    return [
        pytest.param(block, id=f"{page.relative_to(ROOT)}-{number}")
        for page in PAGES
        for number, block in enumerate(blocks(page))
        if block.kind in kinds
    ]


def commands(block: Block) -> Iterator[tuple[list[str], int]]:
    """Each command's arguments, and its status."""
    for line in block.text.splitlines():
        if not ELSEWHERE.match(line):
            program, *arguments = shlex.split(line, comments=True)
            assert program == "skincad", line
            yield arguments, INTERRUPTED if line.endswith("# until Ctrl-C") else int(line.endswith("# fails"))


def goes_on_until_ctrl_c(arguments: list[str], folder: Path) -> int:
    """Run what does not end by itself, interrupt it once it has said something, return its status."""
    line = [sys.executable, "-m", "skincad", *arguments]
    quiet = {**os.environ, "BROWSER": "true"}  # opens nothing
    with started(line, cwd=folder, env=quiet, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline()
        process.send_signal(signal.SIGINT)
        return process.wait(timeout=60)


@contextlib.contextmanager
def on_board(arguments: list[str]) -> Iterator[list[str]]:
    """Give PORT's place to a board whose ridges 4 and 5 rest for a second, are tapped, and then pulled."""
    if PORT not in arguments:
        yield arguments
        return
    draw, rate = np.random.default_rng(1), 5000
    values = np.full((5 * rate, 4), 1.65) + draw.normal(0, 1e-4, (5 * rate, 4))
    tap = 0.2 * np.sin(np.linspace(0, np.pi, rate // 25))[:, None]
    for ridge, second in ((0, 1.2), (1, 2.2)):
        share = np.where(np.arange(4) // 2 == ridge, 1.0, 0.2)
        values[int(second * rate) : int(second * rate) + tap.size] += tap * share
    pull = np.repeat(draw.normal(0, 0.02, 2 * rate // 100), 100)[:, None]
    values[3 * rate :] += pull * np.array([1.0, -1.0, 0.6, -0.6])
    head = ",".join(["sample", *(f"ridge_{ridge}_{side}_V" for ridge in (4, 5) for side in ("S1", "S2"))])
    with board(head, values, rate) as port:
        yield [port if word == PORT else word for word in arguments]


def one_march(runs: list[tuple[object, SceneRun]], scene: skincad.Scene, **asked: Any) -> SceneRun:
    """Return a scene's march. Commands and Python of a page that only read it in other ways share it."""
    key = (marching(scene), asked | {"tick": None, "partial": None})
    if (known := next((run for of, run in runs if of == key), None)) is None:
        known = marched(scene, **asked)
        runs.append((key, known))
    return known


def words(line: str) -> str:
    return re.sub(r"[+-]?\d[\d.e+-]*", "#", " ".join(line.split()))


def test_every_block_is_of_a_kind_that_is_looked_at() -> None:
    for page in PAGES:
        assert page.read_text("utf-8").count("```") == 2 * len(blocks(page)), page
        for block in blocks(page):
            assert block.kind in ("sh", "bat", "text", "python", "csv", "toml")
            assert bool(block.file) == (block.kind in ("csv", "toml")), block.text


@pytest.mark.parametrize("block", shown("sh", "bat"))
def test_commands_have_the_options_that_are_shown(block: Block) -> None:
    for arguments, _ in commands(block):
        COMMANDS[arguments[0]].make_context(arguments[0], arguments[1:])


@pytest.mark.parametrize("block", shown("python"))
def test_python_has_the_names_that_are_shown(block: Block) -> None:
    compile(block.text, "page", "exec")
    for name in re.findall(r"\bskincad\.(\w+)", block.text):
        assert hasattr(skincad, name), name


@pytest.mark.dear("a page or notebook shows whole runs of skincad")
@pytest.mark.parametrize("page", files(PAGES))
def test_what_a_page_shows_works(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    # pages show what a machine prints that has the time: `auto` goes on from a clear verdict for so long
    monkeypatch.setattr("skincad.mechanics.check.SHARP_SECONDS", 60.0)
    monkeypatch.setattr("skincad.scenes.simulation.marched", partial(one_march, []))
    names: dict[str, Any] = {}
    printed = ""
    for block in blocks(page):
        if block.file:
            Path(block.file).write_text(block.text)
        elif block.kind == "sh":
            for line, status in commands(block):
                with on_board(line) as arguments:
                    if status == INTERRUPTED:
                        assert goes_on_until_ctrl_c(arguments, tmp_path) == status
                        continue
                    done = run_skincad(*arguments, cwd=tmp_path)
                assert done.returncode == status, f"{arguments}: {done.stdout}{done.stderr}"
                printed = done.stdout
        elif block.kind == "python":
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(compile(block.text, page.name, "exec"), names)
            printed = out.getvalue()
        elif block.kind == "text":
            told, real = block.text.splitlines(), printed.splitlines()
            assert told[0] == real[0]
            assert [words(line) for line in told] == [words(line) for line in real[: len(told)]]


def code(notebook: Path) -> list[dict[str, Any]]:
    return [cell for cell in json.loads(notebook.read_text())["cells"] if cell["cell_type"] == "code"]


@pytest.mark.parametrize("notebook", files(NOTEBOOKS))
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
