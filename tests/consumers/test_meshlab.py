"""MeshLab finds nothing wrong with the STL files, and they are as near to the STEP files as was asked."""

from __future__ import annotations

from pathlib import Path

import trimesh

from tests.conftest import Made
from tests.consumers import Job, meshlab


def test_no_file_cuts_itself_is_open_or_strays_from_its_step(job: Job) -> None:
    assert meshlab.complaints(job) == []


def test_flaws_are_seen(made: Made, tmp_path: Path) -> None:
    torn = trimesh.load_mesh(made.folder / "solids/cover.stl")
    torn.vertices[0] += [30.0, 0.0, 10.0]  # one corner pulled through the far side
    torn.update_faces([i != 50 for i in range(len(torn.faces))])
    torn.export(tmp_path / "torn.stl")
    flaws = " ".join(meshlab.flaws(tmp_path / "torn.stl"))
    assert "self-intersecting faces" in flaws
    assert "open edges" in flaws


def test_a_file_that_was_moved_is_seen(made: Made) -> None:
    shape = trimesh.load_mesh(made.folder / "solids/cover.stl")
    shape.apply_translation([0.0, 0.0, 0.01])
    assert meshlab.deviation(made.folder / "solids/cover.stl", shape) >= 0.0099  # its single precision
