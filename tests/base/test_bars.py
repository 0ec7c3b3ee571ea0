"""What the bars on stderr say: seconds left, and nothing at all off a terminal."""

from __future__ import annotations

import io
import sys

import pytest

from skincad.base.bars import LATE, left_in_words, stage_bar, step_bar
from skincad.base.stopwatch import clock


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(
    ("seconds", "words"), [(0.0, "0:00"), (59.4, "0:59"), (59.6, "1:00"), (3725.0, "62:05"), (-3.0, "0:00")]
)
def test_a_time_in_words(seconds: float, words: str) -> None:
    assert clock(seconds) == words


def test_the_time_left_runs_down_and_is_not_negative() -> None:
    assert left_in_words(None, 5.0) == ""
    assert [left_in_words(70.0, now) for now in (5.0, 65.0, 70.0, 70.1)] == [
        "1:05 left", "0:05 left", "0:00 left", LATE,
    ]  # fmt: skip


def test_off_a_terminal_nothing_is_shown() -> None:
    with stage_bar(3) as progress, step_bar(3) as tick:
        assert progress is None
        assert tick is None


def test_on_a_terminal_the_stage_and_the_time_left_are_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "stderr", shown := Terminal())
    with stage_bar(3) as progress:
        progress("linear tier", 100.4)
    with step_bar(50) as tick:
        tick("fineness 0.5, order 2", 20, 65.4)
    with stage_bar(3) as progress:
        progress("solids")
    text = shown.getvalue()
    assert "linear tier" in text
    assert "1:40 left" in text
    assert "20/50" in text
    assert "1:05 left" in text
    assert "solids" in text
