"""Crests come out of a slicer's layers as high as the casting sheet says: resin pictures and G-code."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.base import Array
from skincad.fabrication import Job, laid, mesh, print_chord, snapped_to_layers, uncertain_ridges
from skincad.fabrication.inspection import inspection
from skincad.inputs import Design, processes
from skincad.outputs import write_stl
from skincad.shape import skin_of
from skincad.solids.mold import mold
from skincad.solids.shrinkage import shrinkage
from tests.consumers import prusaslicer
from tests.consumers.print_levels import filament_levels, resin_levels

pytestmark = [pytest.mark.skipif(bool(prusaslicer.missing()), reason=prusaslicer.missing()), pytest.mark.slow]
CLOSE = 0.02  # mm, asked: below half a layer of 0.05, so that another layer is seen


def crests_as_sliced(design: Design, folder: Path) -> Array:
    """The cured skin's crests over its back, mm, by the levels of the cavity's grooves and its ledge."""
    process, closed = processes(design.printer)[design.mold.process], mold(design)
    part = closed.part("cavity")
    write_stl(laid(mesh(part, print_chord(design)), False, part), folder / "cavity.stl")
    grown = 1 / (1 - shrinkage(design))
    radius, height = design.skin.curvature_radius, np.array(design.heights)
    lean = (np.arange(design.ridge.count) - (design.ridge.count - 1) / 2) * design.ridge.pitch / radius
    ledge = design.skin.width / 2 * grown + 1.0  # mm, in the middle of its 2 mm
    places = np.array([*((radius + height) * np.sin(lean) * grown), ledge])
    if process.pixel < 0.1:
        levels = resin_levels(folder / "cavity.stl", places, process.layer, process.pixel, folder)
    else:
        levels = filament_levels(folder / "cavity.stl", places, process.layer, folder)
    return np.asarray((levels[-1] - levels[:-1]) / grown)


@pytest.mark.parametrize("name", ["lab-bench", "plain-ridges", "nozzle-04"])
def test_crests_on_layers_come_out_as_designed(name: str, tmp_path: Path) -> None:
    design = skincad.load(name)
    heights_and_floor = snapped_to_layers(Job(design))
    assert heights_and_floor is not None
    heights, floor = heights_and_floor
    snapped = skincad.load(name, [f"ridge.heights={list(heights)}", f"mold.floor={floor}"])
    assert crests_as_sliced(snapped, tmp_path) == pytest.approx(
        skin_of(snapped).crests, abs=1e-3
    )  # of no layer


@pytest.mark.parametrize("floor", [9.0, 9.0045, 9.013, 9.0195, 9.03, 9.0475])
def test_crests_are_within_20_um_of_the_sheet_or_told_as_unsure(floor: float, tmp_path: Path) -> None:
    """Floors over a layer; by four of them middles lie at grooves' bottoms, or the ledge."""
    design = skincad.load("plain-ridges", [f"mold.floor={floor}"])
    closed = mold(design)
    off = np.abs(crests_as_sliced(design, tmp_path) - inspection(Job(design, closed)).crests.heights)
    uncertain = uncertain_ridges(Job(design, closed))
    assert {i for i, error in enumerate(off, 1) if error > CLOSE} <= set(uncertain)
    assert bool(uncertain) == (floor in (9.0, 9.013, 9.0195, 9.0475))


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("lab-bench", []),
        ("plain-ridges", []),
        ("plain-ridges", ["ridge.levelling=0.5", "mold.floor=9.02"]),
        ("plain-ridges", ["mold.floor=9.014"]),
        ("lab-bench", ["printer.sla.layer=0.08"]),
        ("nozzle-04", []),
        ("nozzle-04", ["printer.fdm.layer=0.15"]),
    ],
)
def test_crests_come_out_as_the_sheet_says(name: str, changes: list[str], tmp_path: Path) -> None:
    design = skincad.load(name, changes)
    said = np.array(inspection(Job(design)).crests.heights)
    assert np.abs(said - skin_of(design).crests).max() > 2e-3  # there is something to say
    assert crests_as_sliced(design, tmp_path) == pytest.approx(said, abs=CLOSE)
