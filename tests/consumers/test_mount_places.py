"""gmsh finds a mount's holes in the carrier's STEP where the keys and the manifest say they are."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from skincad.fabrication import Job, mount_of
from skincad.outputs import write_step
from skincad.solids import workplane
from skincad.solids.mold import mold
from tests.consumers import gmsh
from tests.mounted import mounted_design
from tests.processes import run_gmsh

pytestmark = pytest.mark.skipif(bool(gmsh.missing()), reason=gmsh.missing())
WITHIN = 1e-3  # mm, the micrometre that is promised; gmsh's boxes are padded by 1e-7 on either side
_SCRIPT = """SetFactory("OpenCASCADE");
Geometry.OCCTargetUnit = "MM";
solids() = ShapeFromFile("{path}");
edges() = Curve{{:}};
For i In {{0 : #edges() - 1}}
  box() = BoundingBox Curve{{edges(i)}};
  Printf("EDGE %.17g %.17g %.17g %.17g %.17g %.17g", box(0), box(1), box(2), box(3), box(4), box(5));
EndFor
"""

Circle = tuple[float, float, float, float]  # x, y, z and radius, mm


def level_circles(path: Path) -> list[Circle]:
    """Every level circle of a STEP file as gmsh reads it."""
    script = path.with_suffix(".geo")
    script.write_text(_SCRIPT.format(path=path))
    process = run_gmsh(script)
    circles = []
    for row in re.findall(r"EDGE (.*)", process.stdout):
        x0, y0, z0, x1, y1, z1 = map(float, row.split())
        if z1 - z0 < 1e-5 and x1 - x0 > 0.1 and abs((x1 - x0) - (y1 - y0)) < 1e-5:
            circles.append(((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2, (x1 - x0) / 2))
    return circles


def there(circles: list[Circle], wanted: Circle) -> bool:
    return any(math.dist(circle, wanted) < WITHIN for circle in circles)


@pytest.mark.parametrize("name", ["yamada-2002", "milled-pad", "lab-bench", "bent"])
def test_holes_are_in_the_step_where_the_keys_say(name: str, tmp_path: Path) -> None:
    design = mounted_design(name)
    closed = mold(design)
    write_step(workplane(closed.part("carrier")), tmp_path / "carrier.step")
    circles, mount = level_circles(tmp_path / "carrier.step"), mount_of(Job(design, closed))
    assert mount is not None
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


def test_a_milled_pads_are_on_its_bolt_circle(tmp_path: Path) -> None:
    """By the keys alone: a circle of 20, four screws, the first at 45 degrees, its pin at +x."""
    closed = mold(mounted_design("milled-pad"))
    write_step(workplane(closed.part("carrier")), tmp_path / "carrier.step")
    circles = level_circles(tmp_path / "carrier.step")
    for turn in (45, 135, 225, 315):
        x, y = 10 * math.cos(math.radians(turn)), 10 * math.sin(math.radians(turn))
        assert there(circles, (x, y, 7.5, 1.25))
    assert there(circles, (10.0, 0.0, 7.5, 1.0))
