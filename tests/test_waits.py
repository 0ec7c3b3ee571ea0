"""No test waits for ever: each wait for a process, a thread or a file has a limit in seconds."""

from __future__ import annotations

import ast
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.processes import lines_until, started

ROOT = Path(__file__).parents[1]
RUNS = {f"subprocess.{name}" for name in ("run", "call", "check_call", "check_output")}
WAITS = {"wait", "communicate", "join", "acquire", "get", "result", "recv", "wait_for"}
CLOCKS = ("monotonic", "perf_counter")


def endless(text: str) -> Iterator[tuple[int, str]]:
    """Line and text of each wait without a limit."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call):
            name = ast.unparse(node.func)
            limited = any(keyword.arg == "timeout" for keyword in node.keywords)
            waits = isinstance(node.func, ast.Attribute) and node.func.attr in WAITS and not node.args
            if name == "subprocess.Popen" or ((name in RUNS or waits) and not limited):
                yield node.lineno, name
        if isinstance(node, ast.While):
            loop = ast.unparse(node)
            if "sleep(" in loop and not any(clock in loop for clock in CLOCKS):
                yield node.lineno, loop.partition("\n")[0]


# processes of their own way: `started` itself, and a bench that gives each change its own limit
OWN = {"tests/processes.py": "subprocess.Popen", "bench/mutants.py": "subprocess.Popen"}
# a queue of the trees that are free: as many as workers, so that it is never empty
NEVER_EMPTY = {("bench/mutants.py", "self.trees.get")}


@pytest.mark.parametrize("folder", ["tests", "bench"])
def test_each_wait_has_a_limit(folder: str) -> None:
    rows = [
        f"{file}:{line}: {what}"
        for path in sorted((ROOT / folder).rglob("*.py"))
        for file in [path.relative_to(ROOT).as_posix()]
        for line, what in endless(path.read_text("utf-8"))
        if OWN.get(file) != what and (file, what) not in NEVER_EMPTY
    ]
    assert not rows


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("subprocess.run(words)", 1),
        ("subprocess.check_output(words, text=True)", 1),
        ("subprocess.run(words, timeout=5)", 0),
        ("with subprocess.Popen(words) as p:\n    p.communicate(timeout=3)", 1),
        ("process.wait()\nthread.join()\nqueue.get()\nevent.wait(timeout=3)", 3),
        ("table.get('key')\n', '.join(words)", 0),
        ("while not file.exists():\n    time.sleep(0.1)", 1),
        ("while not file.exists() and time.monotonic() < end:\n    time.sleep(0.1)", 0),
    ],
)
def test_an_endless_wait_is_seen(text: str, count: int) -> None:
    assert len([*endless(text)]) == count


def test_a_started_process_hears_ctrl_c_where_tests_run_in_the_background() -> None:
    """As `skincad live` in a script's background, which would wait for ever."""
    code = "import time; print('ready', flush=True); time.sleep(100)"
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with started([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=-3, text=True) as process:
            assert lines_until("ready\n", process.stdout) == []
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=60) == -signal.SIGINT
    finally:
        signal.signal(signal.SIGINT, before)


def test_what_does_not_end_is_ended() -> None:
    code = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'import time; time.sleep(100)'])"
    with started([sys.executable, "-c", code], limit=0.5, stdout=subprocess.PIPE, text=True) as process:
        with pytest.raises(AssertionError, match="did not come"):  # its child has the pipe too
            lines_until("ready\n", process.stdout)
        assert process.wait(timeout=60) == -signal.SIGKILL
