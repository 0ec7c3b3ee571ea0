"""gmsh reads the STEP files as they were meant."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import Made
from tests.consumers import Job, gmsh

pytestmark = pytest.mark.skipif(bool(gmsh.missing()), reason=gmsh.missing())


def test_every_step_has_one_solid_of_its_volume_and_the_assembly_names_and_colours(job: Job) -> None:
    assert gmsh.complaints(job) == []


def test_a_solid_of_another_size_is_seen(made: Made, tmp_path: Path) -> None:
    """A metre for a millimetre: what a reader with another unit would see."""
    text = (made.folder / "cover.step").read_text("latin-1").replace(".MILLI.,.METRE.", "$,.METRE.")
    (tmp_path / "cover.step").write_text(text, "latin-1")
    (volume,) = gmsh.read(tmp_path / "cover.step").volumes
    true = next(part.volume for part in made.parts if part.name == "cover")
    assert volume == pytest.approx(1e9 * true, rel=1e-6)
