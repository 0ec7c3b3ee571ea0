"""Programs and libraries that read what `make` writes, each by its own code.

`CONSUMERS` names them all; a module has `missing()`, why it can't run here or "", and `complaints(job)`, what
it finds wrong in the files of one make.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest

import skincad.fabrication.job
from skincad.fabrication import PartReport
from skincad.inputs import Design
from tests.conftest import Made

CONSUMERS = ("prusaslicer", "gmsh", "lib_3mf", "dxf", "meshlab", "camlib", "steps")


def consumed(name: str, *values: Any) -> Any:
    """Return a test's parameters: those of yamada-2002 are slow, those of other templates evidence."""
    slow = name == "yamada-2002"
    return pytest.param(name, *values, marks=pytest.mark.slow if slow else pytest.mark.evidence(subject=name))


@dataclass(frozen=True)
class Job:
    """A design and what `make` made of it."""

    design: Design
    result: Made

    @cached_property
    def plan(self) -> skincad.fabrication.job.Job:
        """What follows from the design."""
        return skincad.fabrication.job.Job(self.design)

    def file(self, name: str) -> Path:
        """Return the path of a file that was made."""
        return self.result.folder / name

    @property
    def names(self) -> list[str]:
        """Names of all parts of the closed mold."""
        return [part.name for part in self.plan.closed.parts]

    @property
    def printed(self) -> list[PartReport]:
        """Parts with an STL of their own, the skin among them."""
        return [part for part in self.result.parts if self.file(f"solids/{part.name}.stl").is_file()]


def volume_slack(part: PartReport) -> float:
    """Return by how much a mesh may differ from the exact volume, mm3: its deviation over all its surface."""
    return part.deviation * part.area
