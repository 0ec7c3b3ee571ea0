"""Shared designs, and one `make` of the default design for all tests of a run that look at its files."""

from __future__ import annotations

import fcntl
import gc
import io
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import chdir, contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import IO, TYPE_CHECKING

import pytest
import typer

import skincad
from tests.processes import LIMIT

if TYPE_CHECKING:  # no module that takes a function by name which tests.shared keeps results of
    from skincad.fabrication import MakeResult, PartReport
    from skincad.inputs import Design
    from skincad.outputs import Delivery

pytest_plugins = ["tests.tiers", "tests.clock", "tests.shared"]


@pytest.fixture(scope="session", autouse=True)
def _one_command_line() -> Iterator[None]:
    """The parser of the command line is built once for all that is run in this process, not for each."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.main, "get_command", cache(typer.main.get_command))
        yield


@pytest.fixture(scope="session")
def yamada() -> Design:
    return skincad.load("yamada-2002")


@pytest.fixture(scope="session")
def variants(yamada: Design) -> dict[str, Design]:
    """Designs at the corners of the model: each a shape that once broke some tool."""
    bare = {"slot": None, "film": None, "contact": {"film": None}}
    return {
        "yamada-2002": yamada,
        "tilted": skincad.load("yamada-2002-tilted"),
        "no slots": yamada.with_(**bare),
        "sharp": yamada.with_(ridge={"tip_fillet": 0.0, "root_fillet": 0.0}),
        "flat crown": yamada.with_(ridge={"crown": 0.0}),
        "R 1e6": yamada.with_(skin={"curvature_radius": 1e6}),
        "R 1e8": yamada.with_(skin={"curvature_radius": 1e8}),
        "R 12": yamada.with_(skin={"curvature_radius": 12.0, "width": 10.0}, ridge={"count": 7}),
        "unlike": yamada.with_(ridge={"heights": [0.5, 0.52, 0.5, 0.48, 0.5, 0.5, 0.47, 0.5, 0.55]}),
        "levelled": yamada.with_(ridge={"levelling": 1.0}),
        "one ridge": yamada.with_(ridge={"count": 1}),
        "two ridges": yamada.with_(ridge={"count": 2}),
        "101 ridges": yamada.with_(ridge={"count": 101}, skin={"curvature_radius": 1000.0, "width": 104.0}),
    }


@dataclass(frozen=True)
class Made:
    """A design as made, and what was written of it; no solids and meshes where another process made it."""

    result: MakeResult
    written: Delivery

    @property
    def folder(self) -> Path:
        return self.written.folder

    @property
    def parts(self) -> tuple[PartReport, ...]:
        return self.result.parts


def files_into(design: Design, folder: Path, formats: Iterable[str] = ()) -> Made:
    """Make a design and write its files for who looks at them: the verdict that stands in them is by the
    closed form, not by seconds of finite elements."""
    result = skincad.make(design, model="winkler")
    return Made(result, skincad.write(result, folder, formats=formats))


@pytest.fixture(scope="session")
def made(yamada: Design, tmp_path_factory: pytest.TempPathFactory) -> Made:
    """Made by the worker that is first to ask for it; the others wait, and read what it left."""
    folder = tmp_path_factory.getbasetemp()
    # a worker's folder lies in the run's
    shared = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder
    left = shared / "made.pickle"
    with (shared / "made.lock").open("w") as lock:
        _wait_for(lock)
        if not left.exists():
            left.write_bytes(pickle.dumps(files_into(yamada, shared / "made" / "yamada-2002")))
    return pickle.loads(left.read_bytes())


def _wait_for(lock: IO[str]) -> None:
    """Lock a file once no other worker has it."""
    deadline = time.monotonic() + LIMIT
    while True:
        try:
            return fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.05)


def pytest_configure() -> None:
    """Started in the background of a script, the tests' processes would inherit that Ctrl-C is ignored; of a
    container, that no bytecode is kept, so that each of some hundred processes would compile skincad anew."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False
    gc.disable()  # until all tests are collected: no import leaves garbage worth looking for


def pytest_collection_finish() -> None:
    """What is imported stays until the end: no collection of garbage need look through it again."""
    gc.collect()
    gc.freeze()
    gc.enable()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Show what long tests have to tell (`record_property("summary", ...)`), passed or not."""
    for report in terminalreporter.getreports("passed") + terminalreporter.getreports("failed"):
        for key, text in report.user_properties:
            if key == "summary" and report.when == "call":
                terminalreporter.write_line(f"{report.nodeid}: {text}")


@contextmanager
def _caught(name: str) -> Iterator[io.BufferedRandom]:
    """A standard stream into a file, by its descriptor too: C libraries print there."""
    before, number = getattr(sys, name), ("stdin", "stdout", "stderr").index(name)
    before.flush()
    answer = os.dup(number)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), number)
        setattr(sys, name, os.fdopen(os.dup(number), "w", encoding="utf-8", errors="backslashreplace"))
        try:
            yield file
        finally:
            getattr(sys, name).close()
            setattr(sys, name, before)
            os.dup2(answer, number)
            os.close(answer)


def run_skincad(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the command line in this process: what it prints, its status, its files, and no second of imports.

    What is the process's own (descriptors, signals, limits, environment) is `skincad_process`'s.
    """
    from skincad.cli import main

    with (
        chdir(cwd),
        pytest.MonkeyPatch.context() as patch,
        _caught("stderr") as err,
        _caught("stdout") as out,
    ):
        patch.setattr(sys, "argv", ["skincad", *arguments])
        with pytest.raises(SystemExit) as end:
            main()
        sys.stdout.flush()
        sys.stderr.flush()
        for file in (out, err):
            file.seek(0)
        return subprocess.CompletedProcess(
            arguments, int(end.value.code or 0), out.read().decode(), err.read().decode()
        )


def skincad_process(*arguments: str, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the command line in its own process, as a user does."""
    return subprocess.run(
        [sys.executable, "-m", "skincad", *arguments],
        cwd=cwd,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
