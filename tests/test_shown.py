"""What README.md and docs/ show works: each command and Python line, in order, in one folder for each page.

A block of csv or toml right after a line that ends in a file's name and a colon is that file. `# fails` after
a command means status 1. A text block right after commands is what the last of them prints: its first line
word for word, all others but for their numbers, which are times and what rounding leaves.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

import skincad
from skincad.commands import app
from tests.conftest import run_skincad

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"(?:`([\w.-]+)`:\n+)?^```(\w+)\n(.*?)^```$", re.M | re.S)
COMMANDS = typer.main.get_command(app).commands  # type: ignore[attr-defined]


def commands(block: str) -> Iterator[tuple[list[str], int]]:
    """Each command of a block, and its status; what installs is run by .ci/run."""
    for line in block.splitlines():
        if line.startswith("skincad "):
            command, _, remark = line.partition("#")
            yield shlex.split(command)[1:], int("fails" in remark)


def blocks(kind: str) -> list[Any]:
    return [
        pytest.param(block, id=f"{page.name}-{number}")
        for page in PAGES
        for number, (_, this, block) in enumerate(BLOCK.findall(page.read_text()))
        if this == kind
    ]


def words(line: str) -> str:
    return re.sub(r"[+-]?\d[\d.e+-]*", "#", " ".join(line.split()))


@pytest.mark.parametrize("block", blocks("sh"))
def test_commands_have_the_options_that_are_shown(block: str) -> None:
    for arguments, _ in commands(block):
        COMMANDS[arguments[0]].make_context(arguments[0], arguments[1:])


@pytest.mark.parametrize("block", blocks("python"))
def test_python_has_the_names_that_are_shown(block: str) -> None:
    compile(block, "page", "exec")
    for name in re.findall(r"\bskincad\.(\w+)", block):
        assert hasattr(skincad, name), name


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_what_a_page_shows_works(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names: dict[str, Any] = {}
    printed = ""
    for file, kind, block in BLOCK.findall(page.read_text()):
        if kind in ("csv", "toml"):
            Path(file).write_text(block)
        elif kind == "sh":
            for arguments, status in commands(block):
                done = run_skincad(*arguments, cwd=tmp_path)
                assert done.returncode == status, f"{arguments}: {done.stdout}{done.stderr}"
                printed = done.stdout
        elif kind == "python":
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(compile(block, page.name, "exec"), names)
            printed = out.getvalue()
        elif kind == "text":
            shown, real = block.splitlines(), printed.splitlines()
            assert shown[0] == real[0]
            assert [words(line) for line in shown] == [words(line) for line in real[: len(shown)]]
