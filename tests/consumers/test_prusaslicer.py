"""PrusaSlicer's layers: plates lie on their beds, crests come out as high as told, notches take shims."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.base import Array, Mask
from skincad.fabrication import (
    Job,
    design_findings,
    laid,
    mesh,
    print_chord,
    print_plates,
    snapped_to_layers,
    uncertain_ridges,
)
from skincad.fabrication.inspection import inspection
from skincad.inputs import Design, processes
from skincad.outputs import write_stl
from skincad.shape import polygon, skin_of
from skincad.solids import PartRole
from skincad.solids.mold import mold
from tests.consumers import consumed, prusaslicer
from tests.consumers.prusaslicer import filament_levels, resin_layers, resin_levels
from tests.designs import of_one_printer

pytestmark = pytest.mark.skipif(bool(prusaslicer.missing()), reason=prusaslicer.missing())


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        pytest.param("plain-ridges", [], marks=pytest.mark.slow),
        consumed("plain-ridges", ["mold.cavities=3"]),
        consumed("nozzle-04", ["ridge.count=3", "skin.width=22", "skin.length=20"]),
        consumed(
            "plain-ridges", ["skin.curvature_radius_y=60", "shot=[{name='dragon-skin-30',thickness=1.5}]"]
        ),
        *(consumed(name, []) for name in ("lab-bench", "rings-5", "pillars-9")),
    ],
)
def test_every_plate_is_sliced_and_lies_on_its_bed(name: str, settings: list[str], tmp_path: Path) -> None:
    """Without rearranging: where the file has them, with the settings that the order tells."""
    design = skincad.load(name, settings)
    result = skincad.make(design, preview=True)
    skincad.write(result, tmp_path / "out", formats="3mf")
    job = result.built().job
    plates = print_plates(job)
    printed = [p.name for p in job.closed.made if job.process(p).layer]
    assert sorted(spot.name for plate in plates for spot in plate.spots) == sorted(printed)
    for plate in plates:
        path, process = tmp_path / "out" / plate.file, job.processes[plate.process]
        bed = process.build_x, process.build_y, process.build_z
        for said in prusaslicer.info(path):
            for axis, size in zip("xyz", bed, strict=True):
                low, high = (float(said[f"{end}_{axis}"]) for end in ("min", "max"))
                assert -1e-3 <= low < high <= size + 1e-3
        assert prusaslicer.sliced_plate(path, process, tmp_path) > 100


CLOSE = 0.02  # mm, asked: below half a layer of 0.05, so that another layer is seen


def crests_as_sliced(design: Design, folder: Path) -> Array:
    """The cured skin's crests over its back, mm, by the levels of the cavity's grooves and its ledge."""
    process, closed = processes(design.printer)[design.mold.process], mold(design)
    part = closed.part("cavity")
    write_stl(laid(mesh(part, print_chord(design)), False, part), folder / "cavity.stl")
    grown = 1 / (1 - Job(design).shrinkage)
    radius, height = design.skin.curvature_radius, np.array(design.heights)
    lean = (np.arange(design.ridge.count) - (design.ridge.count - 1) / 2) * design.ridge.pitch / radius
    ledge = design.skin.width / 2 * grown + 1.0  # mm, in the middle of its 2 mm
    places = np.array([*((radius + height) * np.sin(lean) * grown), ledge])
    if process.pixel < 0.1:
        levels = resin_levels(folder / "cavity.stl", places, process.layer, process.pixel, folder)
    else:
        levels = filament_levels(folder / "cavity.stl", places, process.layer, folder)
    return np.asarray((levels[-1] - levels[:-1]) / grown)


@pytest.mark.parametrize("name", [consumed(name) for name in ("lab-bench", "plain-ridges", "nozzle-04")])
def test_crests_on_layers_come_out_as_designed(name: str, tmp_path: Path) -> None:
    design = skincad.load(name)
    heights_and_floor = snapped_to_layers(Job(design))
    heights, floor = heights_and_floor
    snapped = skincad.load(name, [f"ridge.heights={list(heights)}", f"mold.floor={floor}"])
    assert crests_as_sliced(snapped, tmp_path) == pytest.approx(
        skin_of(snapped).crests, abs=1e-3
    )  # of no layer


@pytest.mark.evidence(subject="plain-ridges")
@pytest.mark.parametrize("floor", [9.0, 9.0045, 9.013, 9.0195, 9.03, 9.0475])
def test_crests_are_within_20_um_of_the_sheet_or_told_as_unsure(floor: float, tmp_path: Path) -> None:
    """Floors over a layer; by four of them middles lie at grooves' bottoms, or the ledge."""
    design = skincad.load("plain-ridges", [f"mold.floor={floor}"])
    closed = mold(design)
    off = np.abs(crests_as_sliced(design, tmp_path) - inspection(Job(design, closed)).crests.heights)
    uncertain = uncertain_ridges(Job(design, closed))
    assert {i for i, error in enumerate(off, 1) if error > CLOSE} <= set(uncertain)
    assert bool(uncertain) == (floor in (9.0, 9.013, 9.0195, 9.0475))


@pytest.mark.evidence(subject="{name}")
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


FINE = 0.004  # mm, of the points that a shim's section is looked at; a pixel is ten times that


def section_points(corners: Array) -> Array:
    """Points `(n, 2)` all over a shim's section, mm, its corners `(4, 2)` in order."""
    a, b, c = corners[0], corners[1], corners[3]
    along, rows = (max(2, round(np.linalg.norm(v - a) / FINE)) for v in (b, c))
    u, v = np.meshgrid(np.linspace(0.0, 1.0, along), np.linspace(0.0, 1.0, rows))
    return np.asarray(a + u.reshape(-1, 1) * (b - a) + v.reshape(-1, 1) * (c - a))


def goes_in(lit: Mask, points: Array, pixel: float, play: float) -> bool:
    """Whether the section is free of lit pixels somewhere: moved along x by at most `play` mm, and by a pixel
    up or down, as the notch's bottom comes out."""
    middle = np.array(lit.shape)[::-1] / 2
    for up in np.linspace(-pixel, pixel, 9):
        for shift in np.arange(-play, play + FINE / 2, FINE):
            at = np.floor((points + np.array([shift, up])) / pixel + middle).astype(int)
            if not lit[at[:, 1], at[:, 0]].any():
                return True
    return False


def shims_that_go_in(design: Design, folder: Path) -> tuple[int, int]:
    """How many of the shims, and of how many, by the middle layer of end a's comb, laid on its face."""
    process, closed = processes(design.printer)[design.mold.process], mold(design)
    comb = next(part for part in closed.of(PartRole.COMB) if part.end == "a")
    shape = mesh(comb, print_chord(design))
    write_stl(laid(shape, True, comb), folder / "comb.stl")
    layers = list(resin_layers(folder / "comb.stl", process.layer, process.pixel, folder))
    lit = layers[len(layers) // 2]
    low, high = shape.bounds
    centre = np.array([low[0] + high[0], low[2] + high[2]]) / 2
    shims = [
        section_points(polygon(shim.body.outline, FINE)[:4] - centre) for shim in closed.of(PartRole.SHIM)
    ]
    passing = []
    for picture in (lit, lit[::-1]):  # a picture's rows may run up or down: one way there are no notches
        play = design.mold.slit_clearance + process.pixel
        passing.append(sum(goes_in(picture, points, process.pixel, play) for points in shims))
    return max(passing), len(shims)


@pytest.mark.evidence(subject="lab-bench")
@pytest.mark.parametrize(
    ("changes", "all_go_in"),
    [
        ([], True),
        (["printer.sla.pixel=0.04725"], True),
        (["printer.sla.pixel=0.035"], True),
        (["mold.slit_clearance=0.01"], False),
        (["mold.slit_clearance=0.01", "printer.sla.pixel=0.04725"], False),
    ],
)
def test_where_no_finding_says_otherwise_every_shim_goes_in(
    changes: list[str], all_go_in: bool, tmp_path: Path
) -> None:
    design = of_one_printer("lab-bench", changes)
    warned = any(finding.rule == "notch" for finding in design_findings(Job(design)))
    count, of = shims_that_go_in(design, tmp_path)
    assert of == 18
    assert (count == of) == all_go_in
    assert warned != all_go_in
