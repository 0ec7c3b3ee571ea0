"""Packages that several tests read: written once, without a film's response where nobody asks for it."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

import skincad
from skincad.outputs import Package

DESIGNS = {
    "straight": skincad.load_design("yamada-2002"),
    "tilted": skincad.load_design("yamada-2002-tilted"),
    "doubly curved": skincad.load_design("yamada-2002").with_(skin={"curvature_radius_y": 100.0}),
    "few and steep": skincad.load_design("steep-fingertip"),
}


SUBJECTS = {
    "tilted": "yamada-2002-tilted",
    "doubly curved": "packages: doubly curved",
    "few and steep": "steep-fingertip",
}


class PackageFolder:
    """A package and the folder that it was written to."""

    def __init__(self, package: Package, folder: Path) -> None:
        self.package, self.folder = package, folder
        skincad.write(package, folder)


@cache
def packaged(name: str, parent: Path) -> PackageFolder:
    """A design for MuJoCo and URDF, made once: a fixture is made anew when another design came between."""
    model = "auto" if name == "doubly curved" else "linear"  # which knows one curvature
    package = skincad.package(DESIGNS[name], ("mujoco", "urdf"), model=model)
    return PackageFolder(package, parent / name)


def marks(name: str) -> tuple[pytest.MarkDecorator, ...]:
    """What any commit can break is seen on the straight skin."""
    return (pytest.mark.slow if name == "straight" else pytest.mark.evidence(subject=SUBJECTS[name]),)


@pytest.fixture(scope="session", params=[pytest.param(name, marks=marks(name)) for name in DESIGNS])
def simulated(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> PackageFolder:
    """Each design for MuJoCo and URDF."""
    return packaged(request.param, tmp_path_factory.getbasetemp())
