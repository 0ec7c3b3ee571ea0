"""A pin at finite strain: against the elastica, CalculiX and the cell in small strain, and its own table."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy import optimize, special

import skincad
from bench.calculix import run_program
from bench.pins import six, tetrahedra
from skincad.inputs import Design
from skincad.inputs.material import silicone
from skincad.mechanics import lone
from skincad.mechanics.models import pin_body, reduced
from skincad.mechanics.models.pin_body import MIXED, SWAY, bent_pin, bent_pins
from skincad.mechanics.models.pin_cell import pin_cell
from skincad.mechanics.problem import ContactError
from skincad.shape import skin_of


def pin(height: float, tip: float, **table: float) -> Design:
    """Two pins far apart, of a compressible silicone: CalculiX's tetrahedra are stiff at 0.49."""
    return skincad.Design(
        name="two",
        skin={"curvature_radius": 1e8, "thickness": 2.0, "width": 7.0, "length": 16.0},
        pin={"columns": 1, "rows": 2, "pitch": 7.0, "height": height, "tip_diameter": tip, **table},
        material={"name": "dragon-skin-20", "poisson_ratio": 0.4},
        mold={"process": "sla", "pour": "open"},
        contact={"force": 0.1},
    )


def free(cell: Design) -> pin_body.PinBody:
    """A cell whose tip takes no moment: a crown of no radius."""
    return replace(pin_body.pin_body(cell), radius=1e-9)


def followed(body: pin_body.PinBody, path: list[tuple[float, float]]) -> list[np.ndarray]:
    """The numbers of equilibria along a path of normal forces, N, and ways, mm."""
    zero = np.zeros(body.body.free.size)
    state, before, found = pin_body._equilibrium(body, zero, np.zeros(3), 0.0, 0.0), (0.0, 0.0), []
    for at in path:
        state = pin_body._followed(body, state, before, at)
        before = at
        found.append(state.numbers)
    return found


def elastica(sway: float) -> tuple[float, float]:
    """A cantilever's force across, times L^2 / (E I), and how far its tip sinks, of L. Bisshopp and Drucker,
    Q. Appl. Math. 3 (1945) 272."""

    def of(angle: float) -> tuple[float, float, float]:
        m = (1 + np.sin(angle)) / 2
        at = np.arcsin(1 / np.sqrt(2 * m))
        load = (special.ellipk(m) - special.ellipkinc(at, m)) ** 2
        way = 1 - 2 / np.sqrt(load) * (special.ellipe(m) - special.ellipeinc(at, m))
        return load, way, 1 - np.sqrt(2 * np.sin(angle) / load)

    load, _, sinks = of(optimize.brentq(lambda angle: of(angle)[1] - sway, 1e-3, 1.5))
    return load, sinks


@pytest.mark.evidence(subject="pins: finite strain")
def test_a_slender_pin_is_an_elastica() -> None:
    """To 3 %: the base and shear give way by 0.5 % each, and at a strain of 8 % bending is not linear."""
    slender = pin(20.0, 1.0, root_diameter=1.0, crown=0.1).with_(skin={"thickness": 0.2})
    cell = lone(slender, 20.0, 0.2)
    ways = [20.0 * part for part in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)]
    numbers = followed(free(cell), [(0.0, way) for way in ways])
    bending = silicone(cell).young_modulus.value * np.pi / 64
    for way, row in zip(ways[2:], numbers[2:], strict=True):
        load, sinks = elastica(way / 20.0)
        assert row[1] * 20.0**2 / bending == pytest.approx(load, rel=0.03)
        assert row[2] / 20.0 == pytest.approx(sinks, rel=0.02)


@pytest.mark.evidence(subject="pins: finite strain")
def test_a_pressed_slender_pin_sways_at_eulers_force() -> None:
    """Its stiffness across falls to nothing at pi^2 E I / (4 L^2), nearly on a line from 3 E I / L^3: the
    exact tan(a) / a is within 2 % of that at half of the force."""
    slender = pin(20.0, 1.0, root_diameter=1.0, crown=0.1).with_(skin={"thickness": 0.2})
    cell = lone(slender, 20.0, 0.2)
    bending = silicone(cell).young_modulus.value * np.pi / 64
    euler = np.pi**2 * bending / (4 * 20.0**2)
    alone, pressed = followed(free(cell), [(0.0, 0.0), (euler / 2, 0.0)])
    assert alone[4] == pytest.approx(3 * bending / 20.0**3, rel=0.02)
    a = np.sqrt(np.pi**2 / 8)
    assert pressed[4] / alone[4] == pytest.approx(a**3 / 3 / (np.tan(a) - a), rel=0.03)


@pytest.mark.slow
def test_small_loads_are_those_of_the_cell() -> None:
    """A flat tip keeps its angle in both. A rigid one sinks by 8 % less of its half-space than the mean of an
    even pressure does, which is a third of all; 2 % are the mesh."""
    cell = lone(pin(3.0, 1.8, root_diameter=2.2, root_fillet=0.3, crown=0.0), 3.0, 2.0)
    numbers, small = bent_pin(cell, 0.1, 0, 0).numbers, pin_cell(cell)
    across = small.across[0, 0] - small.across[0, 1] ** 2 / small.across[1, 1]
    assert numbers[4] * across == pytest.approx(1.0, abs=0.04)
    assert numbers[5] / small.axial == pytest.approx(1.0, abs=0.04)


@pytest.mark.slow
def test_the_table_between_its_nodes_and_its_derivatives() -> None:
    """In the middle of a square pulls are off by less than is told; Maxwell's relation holds at a node."""
    design = six()
    cells = reduced.pin_cells(design)
    pins = bent_pins(cells, np.array(skin_of(design).heights))
    pins = pins.moved(np.ones((2, 6), dtype=int))
    cell = pins.cells[1]
    normal, way = 1.5 * pins.force, 1.5 * SWAY * skin_of(cell).heights[0]
    start = bent_pin(cell, pins.force, 1, 1)
    between = pin_body._equilibrium(pin_body.pin_body(cell), start.values, start.moved, normal, way).numbers
    high = 1  # the second pin's height is that of the cell
    pulled = np.full(6, between[1])
    bent = pins.bending(np.full(6, normal), pulled)
    gone = bent.way + pins.soft * pulled
    sinks = bent.sinking + pins.sinks * normal
    assert abs(gone[high] - way) * between[4] <= pins.off[0, high] + MIXED * between[1]
    assert abs(sinks[high] - between[2]) <= pins.off[1, high] + MIXED * between[2]
    assert pins.off[0, high] < 0.01 * between[1]
    small = 1e-4 * normal
    more = pins.bending(np.full(6, normal + small), pulled)
    further = pins.bending(np.full(6, normal), pulled + small)
    assert (more.way - bent.way)[high] / small == pytest.approx(bent.by_normal[high], rel=1e-2)
    assert (further.sinking - bent.sinking)[high] / small == pytest.approx(bent.by_normal[high], rel=1e-2)
    assert (further.way - bent.way)[high] / small == pytest.approx(bent.by_pull[high], rel=1e-2)


@pytest.mark.slow
def test_a_pin_that_folds_is_refused() -> None:
    cell = lone(six(), 2.5, 2.0)
    with pytest.raises(ContactError, match="a pin folds, pressed by 3 N"):
        bent_pin(cell, 3.0, 1, 0)


DRIVES = [(0.0, -0.15), (0.0, -0.3), (0.3, -0.3), (0.6, -0.3), (0.9, -0.3)]  # mm, along x and z


@cache
def bonded(folder: Path, size: float) -> np.ndarray:
    """CalculiX's forces on a pin's tip that is bonded to a plate `(drives, 3)` N; edges of `size` mm."""
    design = pin(3.0, 1.8, root_diameter=2.2, root_fillet=0.3, crown=0.0)
    mesh, material = tetrahedra(design, size, folder, 1), silicone(design)
    nodes, young, poisson = mesh.nodes, material.young_modulus.value, material.poisson_ratio
    back, tip = (np.flatnonzero(abs(nodes[:, 2] - z) < 1e-6) + 1 for z in (0.0, nodes[:, 2].max()))
    cut = np.setdiff1d(np.flatnonzero(abs(nodes[:, 1]) < 1e-6) + 1, back)
    lines = ["*NODE, NSET=all"]
    lines += [f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(nodes.tolist(), 1)]
    lines += ["*ELEMENT, TYPE=C3D10, ELSET=pin"]
    lines += [", ".join(map(str, (i, *(row + 1)))) for i, row in enumerate(mesh.elements, 1)]
    for name, found in (("back", back), ("tip", tip), ("cut", cut)):
        lines += [f"*NSET, NSET={name}", *map(str, found.tolist())]
    law = f"{young / 4 / (1 + poisson)!r}, {6 * (1 - 2 * poisson) / young!r}"
    lines += ["*MATERIAL, NAME=rubber\n*HYPERELASTIC, NEO HOOKE", law]
    lines += ["*SOLID SECTION, ELSET=pin, MATERIAL=rubber\n*BOUNDARY\nback, 1, 3\ntip, 2, 2\ncut, 2, 2"]
    for x, z in DRIVES:
        lines += [f"*STEP, INC=1000, NLGEOM\n*STATIC\n1., 1.\n*BOUNDARY\ntip, 1, 1, {x}\ntip, 3, 3, {z}"]
        lines += ["*NODE PRINT, NSET=tip, TOTALS=ONLY, FREQUENCY=1000\nRF\n*END STEP"]
    (folder / "pin.inp").write_text("\n".join(lines) + "\n")
    run_program(["ccx", "-i", "pin"], folder)
    tables = (folder / "pin.dat").read_text().split("total force")[1:]
    return np.array([[float(x) for x in table.splitlines()[2].split()] for table in tables])


@pytest.mark.evidence(subject="pins: finite strain")
def test_a_bonded_pin_against_calculix(tmp_path: Path) -> None:
    """Pressed by a tenth and pulled aside by 0.3 of its height: to 5 %, what CalculiX's own pulls still
    change by from edges of 0.2 mm to 0, taken to go with their square."""
    coarse, fine = (bonded(tmp_path, size) for size in (0.27, 0.2))
    theirs = fine - (coarse - fine) * 0.2**2 / (0.27**2 - 0.2**2)
    cell = lone(pin(3.0, 1.8, root_diameter=2.2, root_fillet=0.3, crown=0.0), 3.0, 2.0)
    path = [(float(-row[2]), x) for row, (x, _) in zip(theirs, DRIVES, strict=True)]
    for row, their, (x, z) in zip(followed(pin_body.pin_body(cell), path), theirs, DRIVES, strict=True):
        assert row[2] == pytest.approx(-z, rel=0.05)
        if x:
            assert row[1] == pytest.approx(their[0], rel=0.05)
