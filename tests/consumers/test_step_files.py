"""Heights and mounts as gmsh and the CAD kernel read them back from STEP."""

from __future__ import annotations

import math
import re
import subprocess
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest

import skincad
from skincad.fabrication import Job, mount_of
from skincad.inputs import Design
from skincad.outputs import write_step
from skincad.shape import skin_of
from skincad.solids import skin_solid, workplane
from skincad.solids.mold import mold
from tests.conftest import Made, files_into
from tests.consumers import consumed, gmsh
from tests.designs import mounted_design
from tests.processes import run_gmsh

pytestmark = pytest.mark.skipif(bool(gmsh.missing()), reason=gmsh.missing())
CLOSE = 1e-6  # mm, asked; STEP has 15 digits
FIVE = ("ridge.count=5", "skin.width=7.0", "contact.force=2.2")  # three heights each other's mirror images
UNLIKE = [0.5, 0.52, 0.5, 0.48, 0.5, 0.5, 0.47, 0.5, 0.55]
# every arc gets a point in its middle, which is a crown's summit
HEIGHTS_SCRIPT = """SetFactory("OpenCASCADE");
Geometry.OCCTargetUnit = "MM";
solids() = ShapeFromFile("{path}");
Transfinite Curve{{:}} = 3;
"""


WITHIN = 1e-3  # mm, the micrometre that is promised; gmsh's boxes are padded by 1e-7 on either side
EDGES_SCRIPT = """SetFactory("OpenCASCADE");
Geometry.OCCTargetUnit = "MM";
solids() = ShapeFromFile("{path}");
edges() = Curve{{:}};
For i In {{0 : #edges() - 1}}
  box() = BoundingBox Curve{{edges(i)}};
  Printf("EDGE %.17g %.17g %.17g %.17g %.17g %.17g", box(0), box(1), box(2), box(3), box(4), box(5));
EndFor
"""
Circle = tuple[float, float, float, float]  # x, y, z and radius, mm


@pytest.fixture(scope="module")
def levelled(tmp_path_factory: pytest.TempPathFactory) -> tuple[Design, Made]:
    design = skincad.load("yamada-2002", ["ridge.levelling=0.7", *FIVE])
    return design, files_into(design, tmp_path_factory.mktemp("levelled") / design.name, ("step",))


def heights_by_kernel(path: Path, design: Design) -> list[float]:
    """What lies in the solid of each ridge's axis, from the base circle on, mm."""
    solid = cq.importers.importStep(str(path)).val()
    heights = []
    for ridge in range(1, design.ridge.count + 1):
        frame = skin_of(design).placed[ridge - 1].frame
        foot, far = frame.at(0.0, 0.0), frame.at(0.0, 5.0)
        axis = cq.Edge.makeLine(cq.Vector(foot.x, 0.0, foot.z), cq.Vector(far.x, 0.0, far.z))
        heights.append(sum(edge.Length() for edge in axis.intersect(solid).Edges()))
    return heights


def heights_by_gmsh(path: Path, design: Design, folder: Path) -> list[float]:
    """The summits that gmsh finds on the edges at the skin's end, over the base circle, mm."""
    (folder / "read.geo").write_text(HEIGHTS_SCRIPT.format(path=path.resolve()))
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


@pytest.mark.slow
def test_the_levelled_mold_is_made_and_passes_its_checks(levelled: tuple[Design, Made]) -> None:
    design, result = levelled
    assert result.result.passed
    assert {f.severity for f in result.result.findings} <= {"note"}
    made_of = {part.name for part in mold(design).parts if part.made == "made"}
    assert {part.name for part in result.parts} == made_of | {"skin"}
    assert all(part.valid and part.watertight for part in result.parts)
    skin = next(part for part in result.parts if part.name == "skin")
    assert skin.volume == pytest.approx(skincad.section(design).area * design.skin.length, rel=1e-11)


def read_back(file: Path, design: Design, folder: Path) -> None:
    for heights in (heights_by_kernel(file, design), heights_by_gmsh(file, design, folder)):
        assert heights == pytest.approx(design.heights, abs=CLOSE)


@pytest.mark.slow
def test_levelled_heights_and_those_one_a_ridge_are_read_back(
    levelled: tuple[Design, Made], yamada: Design, tmp_path: Path
) -> None:
    design, result = levelled
    read_back(result.folder / "solids/skin.step", design, tmp_path)
    unlike = yamada.with_(ridge={"heights": UNLIKE})
    write_step(skin_solid(unlike), tmp_path / "skin.step")
    read_back(tmp_path / "skin.step", unlike, tmp_path)


def level_circles(path: Path) -> list[Circle]:
    """Every level circle of a STEP file as gmsh reads it."""
    script = path.with_suffix(".geo")
    script.write_text(EDGES_SCRIPT.format(path=path))
    process = run_gmsh(script)
    circles = []
    for row in re.findall(r"EDGE (.*)", process.stdout):
        x0, y0, z0, x1, y1, z1 = map(float, row.split())
        if z1 - z0 < 1e-5 and x1 - x0 > 0.1 and abs((x1 - x0) - (y1 - y0)) < 1e-5:
            circles.append(((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2, (x1 - x0) / 2))
    return circles


def there(circles: list[Circle], wanted: Circle) -> bool:
    return any(math.dist(circle, wanted) < WITHIN for circle in circles)


@pytest.mark.parametrize(
    "name", [consumed(name) for name in ("yamada-2002", "milled-pad", "lab-bench", "bent")]
)
def test_holes_are_in_the_step_where_the_keys_say(name: str, tmp_path: Path) -> None:
    design = mounted_design(name)
    closed = mold(design)
    write_step(workplane(closed.part("carrier")), tmp_path / "carrier.step")
    circles, mount = level_circles(tmp_path / "carrier.step"), mount_of(Job(design, closed))
    drilled = {"yamada-2002": 1.6, "milled-pad": 2.5, "lab-bench": 4.0, "bent": 1.6}[name]
    bottom = mount.top - (mount.depth or 0.0)
    assert mount.positions
    for x, y in mount.positions:
        for z in (mount.top, bottom):
            assert there(circles, (x, y, z, drilled / 2)), (x, y, z)
        assert not there(circles, (x, y, 0.0, drilled / 2))  # it does not go through
        assert not there(circles, (x + 2 * WITHIN, y, mount.top, drilled / 2))  # and would be seen aside
    for x, y in mount.fiducials:
        assert there(circles, (x, y, mount.top, mount.fiducial_diameter / 2))
    if mount.pin and mount.pin_position:
        assert there(circles, (*mount.pin_position, mount.top, mount.pin / 2))


@pytest.mark.evidence(subject="milled-pad")
def test_a_milled_pads_are_on_its_bolt_circle(tmp_path: Path) -> None:
    """By the keys alone: a circle of 20, four screws, the first at 45 degrees, its pin at +x."""
    closed = mold(mounted_design("milled-pad"))
    write_step(workplane(closed.part("carrier")), tmp_path / "carrier.step")
    circles = level_circles(tmp_path / "carrier.step")
    for turn in (45, 135, 225, 315):
        x, y = 10 * math.cos(math.radians(turn)), 10 * math.sin(math.radians(turn))
        assert there(circles, (x, y, 7.5, 1.25))
    assert there(circles, (10.0, 0.0, 7.5, 1.0))
