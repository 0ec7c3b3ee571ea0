"""What the bars on stderr say: seconds left, and nothing at all off a terminal."""

from __future__ import annotations

import io
import sys
from collections.abc import Iterator

import pytest

from skincad.base import Progress, one_by_one, stage_bar, step_bar
from skincad.base.progress import LATE, clock, left_in_words


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_the_time_left_runs_down_and_is_not_negative() -> None:
    times = {0.0: "0:00", 59.4: "0:59", 59.6: "1:00", 3725.0: "62:05", -3.0: "0:00"}
    assert {seconds: clock(seconds) for seconds in times} == times
    assert left_in_words(None, 5.0) == ""
    assert [left_in_words(70.0, now) for now in (5.0, 65.0, 70.0, 70.1)] == [
        "1:05 left", "0:05 left", "0:00 left", LATE,
    ]  # fmt: skip


def test_off_a_terminal_nothing_is_shown() -> None:
    with stage_bar(3) as progress, step_bar(3) as tick:
        assert progress is None
        assert tick is None
    assert list(one_by_one(2, found)) == ["first", "second"]


def test_on_a_terminal_the_stage_and_the_time_left_are_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "stderr", shown := Terminal())
    with stage_bar(3) as progress:
        progress("linear model", 100.4)
    with step_bar(50) as tick:
        tick("fineness 0.5, order 2", 20, 65.4)
    with stage_bar(3) as progress:
        progress("solids")
    text = shown.getvalue()
    assert "linear model" in text
    assert "1:40 left" in text
    assert "20/50" in text
    assert "1:05 left" in text
    assert "solids" in text


def found(progress: Progress | None) -> Iterator[str]:
    for name in ("first", "second"):
        if progress:
            progress(f"looking for the {name}")
        yield name


def test_a_bar_is_off_the_terminal_while_lines_are_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is printed goes to stdout, between a bar that is erased and one that is drawn anew."""
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "stderr", shown := Terminal())
    monkeypatch.setattr(sys, "stdout", out := io.StringIO())
    ends = []
    for name in one_by_one(2, found):
        print(name)
        ends.append(len(shown.getvalue()))
    assert out.getvalue() == "first\nsecond\n"
    bars = shown.getvalue()
    for name, end in zip(("first", "second"), ends, strict=True):
        drawn, _, after = bars[:end].rpartition(f"looking for the {name}")
        assert drawn
        assert after.endswith("\x1b[1A\x1b[2K")  # up to the bar's line, which is erased
    assert "looking for the second" in bars[ends[0] :]
