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

from skincad.inputs import Design
from skincad.inputs.material import silicone
from skincad.outputs.simulators import meshes

ROUNDS = 12


def missing() -> str:
    """Return what to install, or ""."""
    return "" if shutil.which("ccx") else "CalculiX is not compared: apt-get install calculix-ccx"


def pressed(design: Design, mesh: meshes.Tetrahedra, down: float) -> float:
    """Return the plate's force, N, at an approach, mm. Points that were let go stay free."""
    crests = np.concatenate([rows for name, rows in mesh.surfaces.items() if name != "back"])
    gap = mesh.nodes[crests].max(axis=(0, 1))[2] - mesh.nodes[:, 2]
    middles = np.unique(crests[:, 3:])
    touching = middles[gap[middles] < down]
    for _ in range(ROUNDS):
        bears = _solved(design, mesh, touching, gap[touching] - down)
        if (bears >= 0).all():
            return float(bears.sum())
        touching = touching[bears > 0]
    raise RuntimeError("the contact does not settle")


def _solved(design: Design, mesh: meshes.Tetrahedra, held: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Forces on the held points, N, that move them by so much, mm."""
    stuff = silicone(design)  # CalculiX reads 20 letters of a number
    lines = ["*NODE, NSET=all"]
    lines += [f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(mesh.nodes.tolist(), 1)]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=skin")
    rows = (mesh.elements["skin"] + 1).tolist()
    lines += [", ".join(map(str, (i, *row))) for i, row in enumerate(rows, 1)]
    lines += ["*MATERIAL, NAME=silicone", "*ELASTIC"]
    lines.append(f"{stuff.young_modulus.value!r}, {stuff.poisson_ratio!r}")
    lines += ["*SOLID SECTION, ELSET=skin, MATERIAL=silicone", "*BOUNDARY"]
    lines += [f"{n + 1}, 1, 3" for n in np.unique(mesh.surfaces["back"])]
    lines += ["*NSET, NSET=held", *(f"{n + 1}" for n in held), "*STEP", "*STATIC", "*BOUNDARY"]
    lines += [f"{n + 1}, 3, 3, {z:.12g}" for n, z in zip(held, moved, strict=True)]
    lines += ["*NODE PRINT, NSET=held", "RF", "*END STEP", ""]
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "a.inp").write_text("\n".join(lines))
        alone = {**os.environ, "OMP_NUM_THREADS": "1"}
        subprocess.run(
            ["ccx", "-i", "a"], cwd=folder, env=alone, capture_output=True, check=True, timeout=600
        )
        text = (Path(folder) / "a.dat").read_text()
    heights = {int(n): -float(z) for n, z in re.findall(r"^\s+(\d+)\s+\S+\s+\S+\s+(\S+)\s*$", text, re.M)}
    return np.array([heights[n + 1] for n in held.tolist()])
