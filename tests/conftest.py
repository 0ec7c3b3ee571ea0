"""Shared designs, and one `make` of the default design for all tests that look at its files."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

import skincad
from skincad.inputs.design import Design
from skincad.outputs.delivery import Written
from skincad.outputs.making import MakeResult, PartReport


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
        "one ridge": yamada.with_(ridge={"count": 1}),
        "two ridges": yamada.with_(ridge={"count": 2}),
        "101 ridges": yamada.with_(ridge={"count": 101}, skin={"curvature_radius": 1000.0, "width": 104.0}),
    }


@dataclass(frozen=True)
class Made:
    """A design as made, and what was written of it."""

    result: MakeResult
    written: Written

    @property
    def folder(self) -> Path:
        return self.written.folder

    @property
    def parts(self) -> tuple[PartReport, ...]:
        return self.result.parts


def make_into(design: Design, folder: Path) -> Made:
    """Make a design and write all its files."""
    result = skincad.make(design)
    return Made(result, skincad.write(result, folder))


@pytest.fixture(scope="session")
def made(yamada: Design, tmp_path_factory: pytest.TempPathFactory) -> Made:
    return make_into(yamada, tmp_path_factory.mktemp("made") / "yamada-2002")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Show what long tests have to tell (`record_property("summary", ...)`), passed or not."""
    for report in terminalreporter.getreports("passed") + terminalreporter.getreports("failed"):
        for key, text in report.user_properties:
            if key == "summary" and report.when == "call":
                terminalreporter.write_line(f"{report.nodeid}: {text}")


def run_skincad(*arguments: str, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
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
