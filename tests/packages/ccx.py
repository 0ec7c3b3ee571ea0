"""CalculiX on a package's mesh: pressed by a rigid flat plate without friction, small strain.

Contact is solved outside of it: points of the crests are moved down to the plate, those that pull are let go,
until none does. Middles of edges alone bear a second-order face's even pressure, so they alone are held.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.packages.tetrahedra import Tetrahedra

ROUNDS = 12


def missing() -> str:
    """Return what to install, or ""."""
    return "" if shutil.which("ccx") else "CalculiX is not compared: apt-get install calculix-ccx"


def approach(design: Design, mesh: Tetrahedra, force: float, start: float) -> float:
    """Return the approach, mm, at a force, N: by a straight line through two approaches near `start`."""
    near = [0.99 * start, 1.01 * start]
    carried = [_pressed(design, mesh, each) for each in near]
    return (
        float(np.interp(force, carried, near))
        if carried[0] <= force <= carried[1]
        else float(near[0] + (force - carried[0]) * (near[1] - near[0]) / (carried[1] - carried[0]))
    )


def _pressed(design: Design, mesh: Tetrahedra, down: float) -> float:
    crests = np.concatenate([rows for name, rows in mesh.surfaces.items() if name != "back"])
    gap = mesh.nodes[crests].max(axis=(0, 1))[2] - mesh.nodes[:, 2]
    middles = np.unique(crests[:, 3:])
    held = middles[gap[middles] < down]
    for _ in range(ROUNDS):
        bears = _solved(design, mesh, held, gap[held] - down)
        if (bears >= 0).all():
            return float(bears.sum())
        held = held[bears > 0]
    raise RuntimeError("the contact does not settle")


def _solved(design: Design, mesh: Tetrahedra, held: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Forces on the held points, N, that move them by so much, mm."""
    stuff = silicone(design)
    lines = ["*NODE, NSET=all"]
    lines += [f"{i}, {x:.15g}, {y:.15g}, {z:.15g}" for i, (x, y, z) in enumerate(mesh.nodes.tolist(), 1)]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=skin")
    rows = (mesh.elements["skin"] + 1).tolist()
    lines += [", ".join(map(str, (i, *row))) for i, row in enumerate(rows, 1)]
    lines += ["*MATERIAL, NAME=silicone", "*ELASTIC"]
    lines.append(f"{stuff.young_modulus.value!r}, {stuff.poisson_ratio!r}")
    lines += ["*SOLID SECTION, ELSET=skin, MATERIAL=silicone", "*BOUNDARY"]
    lines += [f"{n + 1}, 1, 3" for n in np.unique(mesh.surfaces["back"])]
    lines += ["*NSET, NSET=held", *(f"{n + 1}" for n in held), "*STEP", "*STATIC", "*BOUNDARY"]
    lines += [f"{n + 1}, 3, 3, {z:.15g}" for n, z in zip(held, moved, strict=True)]
    lines += ["*NODE PRINT, NSET=held", "RF", "*END STEP", ""]
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "a.inp").write_text("\n".join(lines))
        alone = {**os.environ, "OMP_NUM_THREADS": "1"}
        subprocess.run(
            ["ccx", "-i", "a"], cwd=folder, env=alone, capture_output=True, check=True, timeout=600
        )
        told = (Path(folder) / "a.dat").read_text()
    found = {int(n): -float(z) for n, z in re.findall(r"^\s+(\d+)\s+\S+\s+\S+\s+(\S+)\s*$", told, re.M)}
    return np.array([found[n + 1] for n in held.tolist()])
