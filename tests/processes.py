"""Processes of tests: each hears Ctrl-C, and none outlives its test or a limit."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Timer
from typing import Any

Finished = subprocess.CompletedProcess[str]
LIMIT = 300.0  # s; the longest takes some 20 on an idle core


@contextmanager
def started(words: Sequence[str], limit: float = LIMIT, **options: Any) -> Iterator[subprocess.Popen[Any]]:
    """Give a process that is killed, with all that it started, when the block ends or after `limit` s.

    So a line or an end that is waited for in the block comes, or the pipe ends.
    """
    options |= {"start_new_session": True, "preexec_fn": hear_ctrl_c}
    process = subprocess.Popen(words, **options)
    watch = Timer(limit, kill, (process,))
    watch.daemon = True
    watch.start()
    try:
        yield process
    finally:
        watch.cancel()
        kill(process)
        process.wait(timeout=60)
        for stream in (process.stdin, process.stdout, process.stderr):
            if stream is not None:
                with suppress(BrokenPipeError):
                    stream.close()


def python(program: str, *arguments: str, cwd: Path | None = None, **environment: str) -> Finished:
    """What a process of its own prints that runs a program, and its status."""
    return subprocess.run(
        [sys.executable, "-c", program, *arguments],
        cwd=cwd, env={**os.environ, **environment},
        capture_output=True, text=True, check=False, timeout=LIMIT,
    )  # fmt: skip


def run_gmsh(script: Path) -> Finished:
    """What gmsh prints of a script, which must succeed."""
    words = ["gmsh", script.name, "-"]
    return subprocess.run(words, cwd=script.parent, capture_output=True, text=True, check=True, timeout=LIMIT)


def hear_ctrl_c() -> None:
    """Undo that a script's background, in which tests may run, ignores Ctrl-C: children inherit that."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def kill(process: subprocess.Popen[Any]) -> None:
    """End a process of `started` and its children at once."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)


def lines_until(last: str, lines: Iterable[str]) -> list[str]:
    """The lines before the one that is waited for; AssertionError where they end without it."""
    before: list[str] = []
    for line in lines:
        if line == last:
            return before
        before.append(line)
    raise AssertionError(f"{last!r} did not come, but {before}")
