"""A pad's section pressed and dragged in GetFEM: triangles from gmsh, contact with Coulomb friction.

Both are processes of their own (Debian packages `python3-getfem`, LGPL, and `gmsh`), on files in a temporary
folder. The mesh, the elements and the way of finding who sticks are others than skincad's: the section and
the plate's history alone are shared. What GetFEM solves is in `getfem_process.py`.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from subprocess import run

import numpy as np
from numpy.typing import NDArray

from bench import calculix
from skincad.mechanics import Drive, Pad, Sizes, default_sizes

PACKAGES = ("python3-getfem", "gmsh")
PYTHON = "/usr/bin/python3"  # Debian's, whose package it is
PROCESS = Path(__file__).with_name("getfem_process.py")
QUADRATURE = 6  # degree integrated exactly: curved P2 triangles
AUGMENTATION = 10.0  # MPa/mm; 1 and 100 give the same to the residual
RESIDUAL = 1e-9  # relative
ITERATIONS = 60  # of Newton; two to six are usual
HOLD = 1e3  # N/mm a mm of length: the first contact is held at START, then let go
START = 0.02  # mm, approach of the first contact


@dataclass(frozen=True)
class FrictionalPad:
    """A history's states, one a row: `normal` and `tangential` `(steps, ridges)` N on the skin, and the
    plate's `approach` `(steps,)` mm."""

    normal: NDArray[np.float64]
    tangential: NDArray[np.float64]
    approach: NDArray[np.float64]
    unknowns: int


@cache
def missing() -> str:
    """Return what to install, or "" where both programs are there."""
    there = Path(PYTHON).exists() and shutil.which("gmsh") is not None
    if there and run([PYTHON, "-I", "-c", "import getfem"], capture_output=True, check=False).returncode == 0:
        return ""
    return f"GetFEM is not compared: apt-get install {' '.join(PACKAGES)}"


def drag(pad: Pad, fineness: float, drives: list[Drive], friction: float) -> FrictionalPad:
    """Return GetFEM's states at these drives' ends; each needs a normal force and a travel.

    Raises RuntimeError when a program fails.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        triangles(pad, default_sizes(pad, fineness), folder)
        (folder / "asked.json").write_text(json.dumps(_asked(pad, drives, friction)))
        calculix.run_program([PYTHON, "-I", str(PROCESS)], folder)
        return read((folder / "found.json").read_text(), pad.length)


def triangles(pad: Pad, sizes: Sizes, folder: Path) -> None:
    """Write gmsh's second-order triangles of the section, pad.msh, its ridges' curves by their numbers."""
    if pad.strips or pad.voids:
        raise ValueError("only sections without slots and strips are compared")
    (folder / "pad.geo").write_text("\n".join(calculix.geometry(pad, sizes, recombined=False)))
    calculix.run_program(["gmsh", "-2", "-order", "2", "-format", "msh22", "-nt", "1", "pad.geo"], folder)


def _asked(pad: Pad, drives: list[Drive], friction: float) -> dict[str, object]:
    """What the process is told; forces are of a slice 1 mm long."""
    shear = pad.young_modulus / (2 * (1 + pad.poisson_ratio))
    numbers = {
        "shear": shear,
        "lame": 2 * shear * pad.poisson_ratio / (1 - 2 * pad.poisson_ratio),
        "coefficient": friction,
        "augmentation": AUGMENTATION,
        "rate": 1.0,
        "start": START,
        "width": sum(s.length for s in pad.section.outline if s.kind == "back"),
    }
    return {
        "back": calculix.BACK,
        "ridges": list(pad.ridges),
        "top": pad.top,
        "quadrature": QUADRATURE,
        "residual": RESIDUAL,
        "iterations": ITERATIONS,
        "hold": HOLD,
        "numbers": numbers,
        "steps": [(drive.normal / pad.length, drive.travel) for drive in drives],
    }


def read(text: str, length: float) -> FrictionalPad:
    """Return the process' answer for a pad of this length, mm."""
    data = json.loads(text)

    def table(name: str) -> NDArray[np.float64]:
        return np.array([step[name] for step in data["steps"]])

    forces = length * table("normal"), length * table("tangential")
    return FrictionalPad(*forces, table("approach"), int(data["unknowns"]))
