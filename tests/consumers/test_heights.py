"""Ridges of unlike height as others read them: a levelled pad with its mold, and back from STEP."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest

import skincad
from skincad.inputs import Design
from skincad.outputs import write_step
from skincad.shape import skin_of
from skincad.solids import skin_solid

# gone
from skincad.solids.mold import mold
from tests.conftest import Made, files_into
from tests.consumers import gmsh

CLOSE = 1e-6  # mm, asked; STEP has 15 digits
FIVE = ("ridge.count=5", "skin.width=7.0", "contact.force=2.2")  # three heights each other's mirror images
UNLIKE = [0.5, 0.52, 0.5, 0.48, 0.5, 0.5, 0.47, 0.5, 0.55]
# every arc gets a point in its middle, which is a crown's summit
_SCRIPT = """SetFactory("OpenCASCADE");
Geometry.OCCTargetUnit = "MM";
solids() = ShapeFromFile("{path}");
Transfinite Curve{{:}} = 3;
"""


@pytest.fixture(scope="module")
def levelled(tmp_path_factory: pytest.TempPathFactory) -> tuple[Design, Made]:
    design = skincad.load("yamada-2002", ["ridge.levelling=0.7", *FIVE])
    return design, files_into(design, tmp_path_factory.mktemp("levelled") / design.name, ("step",))


def heights_by_kernel(path: Path, design: Design) -> list[float]:
    """What lies in the solid of each ridge's axis, from the base circle on, mm."""
    solid = cq.importers.importStep(str(path)).val()
    heights = []
    for ridge in range(1, design.ridge.count + 1):
        foot, far = (
            skin_of(design).placed[ridge - 1].frame.at(0.0, 0.0),
            skin_of(design).placed[ridge - 1].frame.at(0.0, 5.0),
        )
        axis = cq.Edge.makeLine(cq.Vector(foot.x, 0.0, foot.z), cq.Vector(far.x, 0.0, far.z))
        heights.append(sum(edge.Length() for edge in axis.intersect(solid).Edges()))
    return heights


def heights_by_gmsh(path: Path, design: Design, folder: Path) -> list[float]:
    """The summits that gmsh finds on the edges at the skin's end, over the base circle, mm."""
    (folder / "read.geo").write_text(_SCRIPT.format(path=path.resolve()))
    command = ["gmsh", "read.geo", "-v", "2", "-1", "-format", "msh22", "-o", "read.msh"]
    process = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)
    assert process.returncode == 0, process.stdout + process.stderr
    nodes = re.findall(r"^\d+ (\S+) (\S+) (\S+)$", (folder / "read.msh").read_text(), re.M)
    x, y, z = np.array(nodes, dtype=float).T
    radius, thickness = design.skin.curvature_radius, design.skin.thickness
    up, end = z - thickness + radius, np.isclose(y, y.max(), atol=1e-9)
    heights = []
    for ridge in range(1, design.ridge.count + 1):
        at = end & (np.abs(radius * (np.arctan2(x, up) - design.lean(ridge))) < 1e-6) & (z > thickness - 1)
        heights.append(float((np.hypot(x[at], up[at]) - radius).max()))
    return heights


def test_the_levelled_mold_is_made_and_passes_its_checks(levelled: tuple[Design, Made]) -> None:
    design, result = levelled
    assert result.result.passed
    assert {f.severity for f in result.result.findings} <= {"note"}
    made_of = {part.name for part in mold(design).parts if part.made == "made"}
    assert {part.name for part in result.parts} == made_of | {"skin"}
    assert all(part.valid and part.watertight for part in result.parts)
    skin = next(part for part in result.parts if part.name == "skin")
    assert skin.volume == pytest.approx(skincad.section(design).area * design.skin.length, rel=1e-11)


def test_the_kernel_reads_the_levelled_heights_back(levelled: tuple[Design, Made]) -> None:
    design, result = levelled
    assert heights_by_kernel(result.folder / "solids/skin.step", design) == pytest.approx(
        design.heights, abs=CLOSE
    )


@pytest.mark.skipif(bool(gmsh.missing()), reason=gmsh.missing())
def test_gmsh_reads_the_levelled_heights_back(levelled: tuple[Design, Made], tmp_path: Path) -> None:
    design, result = levelled
    heights = heights_by_gmsh(result.folder / "solids/skin.step", design, tmp_path)
    assert heights == pytest.approx(design.heights, abs=CLOSE)


@pytest.mark.skipif(bool(gmsh.missing()), reason=gmsh.missing())
def test_heights_one_a_ridge_are_read_back_by_both(yamada: Design, tmp_path: Path) -> None:
    design = yamada.with_(ridge={"heights": UNLIKE})
    write_step(skin_solid(design), tmp_path / "skin.step")
    assert heights_by_kernel(tmp_path / "skin.step", design) == pytest.approx(UNLIKE, abs=CLOSE)
    assert heights_by_gmsh(tmp_path / "skin.step", design, tmp_path) == pytest.approx(UNLIKE, abs=CLOSE)
