"""When a file was saved, as a person saves it and as an editor replaces it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from skincad.base import saved, saves


@pytest.fixture
def acts(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """What is done in each wait, one a wait; when nothing is left the watching is interrupted."""
    left: list[object] = []

    def sleep(_: float) -> None:
        if not left:
            raise KeyboardInterrupt
        act = left.pop(0)
        if callable(act):
            act()

    monkeypatch.setattr(saved, "sleep", sleep)
    return left


def counted(*files: Path) -> int:
    seen = 0
    with pytest.raises(KeyboardInterrupt):
        for _ in saves(files):
            seen += 1
    return seen


def write(file: Path, text: str, second: int) -> None:
    file.write_text(text)
    os.utime(file, (second, second))  # clocks of file systems may stand still between two tests' lines


def test_each_save_is_told_once(tmp_path: Path, acts: list[object]) -> None:
    file = tmp_path / "a.toml"
    write(file, "a", 1)
    acts += [None, None, None, lambda: write(file, "b", 2), None, None, None, lambda: write(file, "b", 3)]
    acts += [None] * 6
    assert counted(file) == 3


def test_a_save_in_two_steps_is_told_when_it_is_whole(tmp_path: Path, acts: list[object]) -> None:
    file = tmp_path / "a.toml"
    write(file, "a", 1)
    texts = []
    acts += [None, None, lambda: write(file, "half", 2), lambda: write(file, "whole", 3), *[None] * 6]
    with pytest.raises(KeyboardInterrupt):
        for _ in saves([file]):
            texts.append(file.read_text())
    assert texts == ["a", "whole"]


def test_a_file_that_is_being_replaced_is_waited_for(tmp_path: Path, acts: list[object]) -> None:
    file, other = tmp_path / "a.toml", tmp_path / "printer.toml"
    write(file, "a", 1)
    write(other, "p", 1)
    acts += [None, None, file.unlink, None, lambda: write(file, "b", 2), *[None] * 4]
    acts += [lambda: write(other, "q", 3), *[None] * 4]
    assert counted(file, other) == 3
