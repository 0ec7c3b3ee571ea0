"""Weights against closed forms, and against gmsh's on the STEP files."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.outputs import links
from skincad.outputs.simulators.links import Weight, combine, without
from skincad.shape import area
from tests.consumers import gmsh
from tests.outputs.simulators.conftest import PackageFolder
from tests.processes import run_gmsh


def box(mass: float, x: float, y: float, z: float, at: tuple[float, float, float]) -> Weight:
    inertia = mass / 12 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
    return Weight(mass, np.array(at), inertia)


def test_two_boxes_are_one_and_apart_again() -> None:
    """A box of 2 x 1 x 1 cut in two, by the textbook's formula."""
    halves = [box(1.0, 1.0, 1.0, 1.0, (x, 3.0, 0.0)) for x in (-0.5, 0.5)]
    whole = box(2.0, 2.0, 1.0, 1.0, (0.0, 3.0, 0.0))
    joined = combine(halves)
    assert joined.centre == pytest.approx(whole.centre)
    assert joined.inertia == pytest.approx(whole.inertia)
    left = without(whole, halves[1:])
    assert left.mass == pytest.approx(1.0)
    assert left.centre == pytest.approx(halves[0].centre)
    assert left.inertia == pytest.approx(halves[0].inertia)


def test_the_filling_weighs_what_its_slots_hold() -> None:
    """18 slots of 0.05 x 0.25 x 12 mm, a film of 0.028 mm in each."""
    design = skincad.load_design("yamada-2002")
    weights = links(design)
    film = 18 * 0.028 * 0.25 * 12 * 1780e-6
    glue = 18 * (0.05 - 0.028) * 0.25 * 12 * 1080e-6
    assert weights.filling.mass == pytest.approx(film + glue, rel=1e-9)
    assert links(design.with_(contact={"film": "ignored"})).filling.mass == pytest.approx(
        18 * 0.05 * 0.25 * 12 * 1080e-6, rel=1e-9
    )
    assert links(design.with_(slot=None)).filling is None


def test_ridges_and_base_are_the_skin() -> None:
    """Mass by the section's area, and the skin symmetric."""
    design = skincad.load_design("yamada-2002")
    weights = links(design)
    assert weights.skin.mass == pytest.approx(skincad.section(design).area * 12 * 1080e-6, rel=1e-9)
    assert weights.base.mass + sum(r.mass for r in weights.ridges) == pytest.approx(
        weights.skin.mass, rel=1e-12
    )
    assert area(skincad.section(design).outline) > 0
    assert weights.skin.centre[:2] == pytest.approx([0, 0], abs=1e-9)


SCRIPT = """SetFactory("OpenCASCADE");
Geometry.OCCTargetUnit = "MM";
s() = ShapeFromFile("{path}");
m() = Mass Volume{{s(0)}}; c() = CenterOfMass Volume{{s(0)}}; i() = MatrixOfInertia Volume{{s(0)}};
Printf("FOUND %.17g %.17g %.17g %.17g", m(0), c(0), c(1), c(2));
For j In {{0 : 8}}
  Printf("FOUND %.17g", i(j));
EndFor
"""


def by_gmsh(path: Path) -> tuple[float, np.ndarray, np.ndarray]:
    """Volume, centre and inertia about it, of density 1, that gmsh finds in a STEP file, mm."""
    script = path.with_suffix(".geo")
    script.write_text(SCRIPT.format(path=path))
    process = run_gmsh(script)
    script.unlink()
    words = [float(w) for line in re.findall(r"FOUND (.*)", process.stdout) for w in line.split()]
    return words[0], np.array(words[1:4]), np.array(words[4:13]).reshape(3, 3)


@pytest.mark.slow
@pytest.mark.xdist_group("packages")
@pytest.mark.skipif(bool(gmsh.missing()), reason=gmsh.missing())
def test_mass_and_inertia_are_those_that_gmsh_reads_from_step(simulated: PackageFolder) -> None:
    """1e-6 is the issue's; the carrier's density in EDM is that of brass."""
    weighs, density = simulated.package.weighs, {"skin": 1.0, "carrier": 1.0}
    for name, weight in (("skin", weighs.skin), ("carrier", weighs.carrier)):
        volume, centre, inertia = by_gmsh(simulated.folder / f"{name}.step")
        density[name] = weight.mass / volume
        assert centre == pytest.approx(weight.centre, abs=1e-6)
        assert density[name] * inertia == pytest.approx(weight.inertia, abs=1e-6 * weight.inertia.max())
    stuff = {"dragon-skin-30": 1080e-6, "sylgard-184": 1030e-6}[simulated.package.design.material.name]
    assert density["skin"] == pytest.approx(stuff, rel=1e-6)
