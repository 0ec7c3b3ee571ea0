"""What README.md and docs/ show works: each command and Python line, in order, in one folder for each page.

A block of csv or toml right after a line that ends in a file's name and a colon is that file. `# fails` after
a command means status 1, `# until Ctrl-C` that it goes on until then. A text block right after commands is
what the last of them prints: its first line word for word, all others but for their numbers, which are times
and what rounding leaves.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import typer

import skincad
from skincad.cli.app import app
from tests.conftest import run_skincad
from tests.processes import started

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
FENCED = re.compile(r"(?:`([\w-]+\.(?:csv|toml))`:\n+)?^```(\w+)\n(.*?)^```$", re.M | re.S)
ELSEWHERE = re.compile(r"^(python3|py) -m venv ")  # .ci/run takes README's install and tests word for word
INTERRUPTED = 130  # status of what Ctrl-C ended
COMMANDS = typer.main.get_command(app).commands  # type: ignore[attr-defined]


class Block(NamedTuple):
    file: str
    kind: str
    text: str


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


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_a_page_shows_works(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    # pages show what a machine prints that has the time: `auto` goes on from a clear verdict for so long
    monkeypatch.setattr("skincad.mechanics.check.SHARP_SECONDS", 60.0)
    names: dict[str, Any] = {}
    printed = ""
    for block in blocks(page):
        if block.file:
            Path(block.file).write_text(block.text)
        elif block.kind == "sh":
            for arguments, status in commands(block):
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
