"""gmsh reads the STEP files as they were meant."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench.campaign.random_designs import drawn
from skincad.outputs import assembly, write_assembly
from skincad.solids import ClosedMold, PartRole, workplane
from skincad.solids.mold import mold
from tests.conftest import Made
from tests.consumers import Job, gmsh

pytestmark = pytest.mark.skipif(bool(gmsh.missing()), reason=gmsh.missing())


def test_every_step_has_one_solid_of_its_volume_and_the_assembly_names_and_colours(job: Job) -> None:
    assert gmsh.complaints(job) == []


def test_a_solid_of_another_size_is_seen(made: Made, tmp_path: Path) -> None:
    """A metre for a millimetre: what a reader with another unit would see."""
    text = (made.folder / "solids/cover.step").read_text("latin-1").replace(".MILLI.,.METRE.", "$,.METRE.")
    (tmp_path / "cover.step").write_text(text, "latin-1")
    (volume,) = gmsh.read(tmp_path / "cover.step").volumes
    true = next(part.volume for part in made.parts if part.name == "cover")
    assert volume == pytest.approx(1e9 * true, rel=1e-6)


def combs_and_shims(closed: ClosedMold, path: Path) -> gmsh.Read:
    """What gmsh reads of them alone: the rest costs most and shows nothing of tails."""
    stack = ClosedMold(tuple(closed.of(PartRole.COMB, PartRole.SHIM)), ())
    write_assembly(assembly(stack, {part.name: workplane(part) for part in stack.parts}, "tails"), path)
    return gmsh.read(path)


def test_a_tail_that_is_too_short_is_seen(made: Made) -> None:
    read = gmsh.read(made.folder / "solids/assembly.step")
    assert sum(name.startswith("shim") for name in read.names) == 18
    assert gmsh.short_tails(read) == []
    low, high = read.along[read.names.index("shim-1-S1")]
    along = tuple((low + 1.5, high) if pair == (low, high) else pair for pair in read.along)
    assert len(gmsh.short_tails(gmsh.Read(read.volumes, along, read.names, read.colours))) == 18


@pytest.mark.slow
def test_tails_stand_out_of_sixty_random_molds(tmp_path: Path) -> None:
    """Of every straight one with shims; 5 mm of the 6 planned, so that rounding is no matter."""
    seen, short = 0, []
    for seed in range(60):
        closed = mold(drawn(seed).design)
        if closed.of(PartRole.SHIM) and drawn(seed).design.skin.curvature_radius_y is None:
            read = combs_and_shims(closed, tmp_path / "tails.step")
            shims = [along for name, along in zip(read.names, read.along, strict=True) if "shim" in name]
            assert len(shims) == len(closed.of(PartRole.SHIM))
            short += [f"seed {seed}: {flaw}" for flaw in gmsh.short_tails(read)]
            seen += 1
    assert seen >= 20  # a third of them at least
    assert short == []
