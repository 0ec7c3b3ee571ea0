"""PrusaSlicer takes every part, and what it says of a broken one is heard."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh

import skincad
from skincad.fabrication import print_plates
from tests.conftest import Made
from tests.consumers import Job, prusaslicer

LONGER = ["lab-bench", "nozzle-04", "gang", "rings-5", "pillars-9"]  # than seconds
pytestmark = pytest.mark.skipif(bool(prusaslicer.missing()), reason=prusaslicer.missing())


def test_every_part_is_one_manifold_of_its_volume_and_slices(job: Job) -> None:
    assert prusaslicer.complaints(job) == []


def test_a_torn_mesh_is_told_though_it_exits_with_0(made: Made, tmp_path: Path) -> None:
    torn = trimesh.load_mesh(made.folder / "solids/end-a-comb.stl")
    torn.update_faces([i % 100 != 0 for i in range(len(torn.faces))])
    torn.export(tmp_path / "torn.stl")
    (said,) = prusaslicer.info(tmp_path / "torn.stl")
    assert said["manifold"] == "no"


def test_its_default_gap_closing_fills_the_slits(made: Made) -> None:
    """Which is why the layers are counted without it: 18 slits of 0.06 x 0.25 mm through 4 mm of plate."""
    comb = made.folder / "solids/end-a-comb.stl"
    filled = prusaslicer.sliced(comb, prusaslicer.DEFAULT_CLOSING) - prusaslicer.sliced(comb)
    assert filled == pytest.approx(18 * 0.06 * 0.25 * 4.0, rel=0.15)  # also corners elsewhere, and mouths


@pytest.mark.parametrize("name", ["plain-ridges", *(pytest.param(n, marks=pytest.mark.slow) for n in LONGER)])
def test_every_plate_is_sliced_and_lies_on_its_bed(name: str, tmp_path: Path) -> None:
    """Without rearranging: where the file has them, with the settings that the order tells."""
    design = skincad.load("plain-ridges", ["mold.cavities=3"] if name == "gang" else [])
    if name not in ("gang", "plain-ridges"):
        design = skincad.load(name)
    result = skincad.make(design, preview=True)
    skincad.write(result, tmp_path / "out", formats="3mf")
    plates = print_plates(result.built().job)
    job = result.built().job
    printed = [p.name for p in job.closed.parts if p.made == "made" and job.process(p).layer]
    assert sorted(spot.name for plate in plates for spot in plate.spots) == sorted(printed)
    for plate in plates:
        path, process = tmp_path / "out" / plate.file, result.built().job.processes[plate.process]
        bed = process.build_x, process.build_y, process.build_z
        for said in prusaslicer.info(path):
            for axis, size in zip("xyz", bed, strict=True):
                low, high = (float(said[f"{end}_{axis}"]) for end in ("min", "max"))
                assert -1e-3 <= low < high <= size + 1e-3
        assert prusaslicer.sliced_plate(path, process, tmp_path) > 100
