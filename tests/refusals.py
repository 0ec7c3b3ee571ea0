"""What a user is told where an input is refused: one line, with these words."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from skincad.base import InputError
from tests.conftest import run_skincad


@contextmanager
def refused(words: str = "") -> Iterator[None]:
    """What is done within is an input error of one line that has these words, as long as a terminal bears."""
    with pytest.raises(InputError) as refusal:
        yield
    assert words in str(refusal.value)
    assert_a_line(str(refusal.value))


@contextmanager
def refused_by(start: str) -> Iterator[None]:
    """What is done within is an input error of one line that begins so: its key, mostly."""
    with pytest.raises(InputError) as refusal:
        yield
    assert str(refusal.value).startswith(start)
    assert_a_line(str(refusal.value))


def assert_a_line(message: str) -> None:
    assert "\n" not in message
    assert len(message) < 2000


def refused_command(*arguments: str, cwd: Path) -> str:
    """The one line that a command refuses with: it has status 2, prints nothing else and writes no file."""
    before = sorted(cwd.iterdir())
    done = run_skincad(*arguments, cwd=cwd)
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("skincad: ")
    assert done.stderr.count("\n") == 1, done.stderr
    assert done.stdout == ""
    assert sorted(cwd.iterdir()) == before
    return done.stderr.removeprefix("skincad: ").removesuffix("\n")
