"""Every reader takes the files of every template with ridges, and sees what is wrong in files made bad."""

from __future__ import annotations

import math
import zipfile
from importlib import import_module
from pathlib import Path

import lib3mf
import numpy as np
import pytest
import trimesh

import skincad
from bench.campaign.random_designs import drawn
from skincad.outputs import write_assembly
from skincad.shape import Point, loop
from skincad.solids import ClosedMold, PartRole, workplane
from skincad.solids.mold import mold
from tests.conftest import Made, files_into
from tests.consumers import CONSUMERS, Job, camlib, consumed, gmsh, lib_3mf, prusaslicer
from tests.designs import RIDGED

READ = ("step", "stl", "3mf", "dxf", "md")  # all that a consumer opens
without_gmsh = pytest.mark.skipif(bool(gmsh.missing()), reason=gmsh.missing())
without_camlib = pytest.mark.skipif(bool(camlib.missing()), reason=camlib.missing())
without_slicer = pytest.mark.skipif(bool(prusaslicer.missing()), reason=prusaslicer.missing())


@pytest.fixture(scope="module", params=[consumed(name) for name in RIDGED])
def job(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Job:
    """One make of a template for all its readers."""
    design = skincad.load(request.param)
    if request.param == "yamada-2002":
        return Job(design, request.getfixturevalue("made"))
    return Job(design, files_into(design, tmp_path_factory.mktemp("made") / request.param, READ))


@pytest.mark.dear("the first reader pays for what all read")
@pytest.mark.parametrize("reader", CONSUMERS)
def test_a_reader_has_no_complaint(job: Job, reader: str) -> None:
    module = import_module(f"tests.consumers.{reader}")
    if module.missing():
        pytest.skip(module.missing())
    assert module.complaints(job) == []


@pytest.fixture
def read(made: Made) -> Job:
    """Files of yamada-2002 as made."""
    return Job(skincad.load(made.folder / "design.toml"), made)


@pytest.mark.slow
@without_camlib
@pytest.mark.parametrize("radius", [0.05, 0.1, 0.5])
def test_other_balls_too(read: Job, radius: float) -> None:
    theirs, ours = camlib.in_grooves(read, radius)["cavity"]
    assert theirs == pytest.approx(ours, abs=camlib.STEP + 2e-3)  # drops, and twice an EDM cavity's mesh


@without_camlib
def test_a_square_groove_by_hand() -> None:
    """A right angle keeps (sqrt 2 - 1) r on its bisector."""
    wide, deep, radius = 2.0, 1.0, 0.25
    points = [(-5, 0), (-5, -5), (5, -5), (5, 0), (wide / 2, 0), (wide / 2, -deep)]
    points += [(-wide / 2, -deep), (-wide / 2, 0)]
    outline = loop([Point(float(x), float(z)) for x, z in points])
    floor = trimesh.creation.box(bounds=[[-5, -1, -5], [5, 1, -deep]])
    walls = [
        trimesh.creation.box(bounds=[[x, -1, -deep], [x + 5 - wide / 2, 1, 0]]) for x in (-5.0, wide / 2)
    ]
    block = trimesh.util.concatenate([floor, *walls])
    rest = camlib.centres(block, radius, np.arange(-2, 2 + camlib.STEP, camlib.STEP), 0.0)
    left = max(camlib.left(outline[4:7], rest, radius))
    assert left == pytest.approx((math.sqrt(2) - 1) * radius, abs=camlib.STEP)


def combs_and_shims(closed: ClosedMold, path: Path) -> gmsh.Read:
    """What gmsh reads of them alone: the rest costs most and shows nothing of tails."""
    stack = ClosedMold(tuple(closed.of(PartRole.COMB, PartRole.SHIM)), ())
    write_assembly(stack, workplane, "tails", path)
    return gmsh.read(path)


@pytest.mark.slow
@without_gmsh
def test_a_tail_that_is_too_short_is_seen(made: Made) -> None:
    read = gmsh.read(made.folder / "solids/assembly.step")
    assert sum(name.startswith("shim") for name in read.names) == 18
    assert gmsh.short_tails(read) == []
    low, high = read.along[read.names.index("shim-1-S1")]
    along = tuple((low + 1.5, high) if pair == (low, high) else pair for pair in read.along)
    assert len(gmsh.short_tails(gmsh.Read(read.volumes, along, read.names, read.colours))) == 18


@pytest.mark.evidence(subject="seeds: tails of shims")
@without_gmsh
def test_tails_stand_out_of_sixty_random_molds(tmp_path: Path) -> None:
    """Of every straight one with shims; 5 mm of the 6 planned, so that rounding is no matter."""
    seen, short = 0, []
    for seed in range(60):
        closed = mold(drawn(seed).design)
        if closed.of(PartRole.SHIM) and drawn(seed).design.skin.curvature_radius_y is None:
            read = combs_and_shims(closed, tmp_path / f"tails-{seed}.step")  # what is read is kept by path
            shims = [along for name, along in zip(read.names, read.along, strict=True) if "shim" in name]
            assert len(shims) == len(closed.of(PartRole.SHIM))
            short += [f"seed {seed}: {flaw}" for flaw in gmsh.short_tails(read)]
            seen += 1
    assert seen >= 20  # a third of them at least
    assert short == []


@pytest.mark.slow
def test_strict_mode_refuses_an_object_id_of_zero(made: Made, tmp_path: Path) -> None:
    """What the CAD library's own writer gives, and a slicer then calls not manifold."""
    with (
        zipfile.ZipFile(made.folder / "solids/skin.3mf") as good,
        zipfile.ZipFile(tmp_path / "bad.3mf", "w") as bad,
    ):
        for name in good.namelist():
            bad.writestr(name, good.read(name).replace(b'<object id="2"', b'<object id="0"'))
    with pytest.raises(lib3mf.ELib3MFException):
        lib_3mf.read(tmp_path / "bad.3mf")


@pytest.mark.slow
@without_slicer
def test_the_slicers_default_gap_closing_fills_the_slits(made: Made) -> None:
    """Which is why the layers are counted without it: 18 slits of 0.06 x 0.25 mm through 4 mm of plate."""
    comb = made.folder / "solids/end-a-comb.stl"
    filled = prusaslicer.sliced(comb, prusaslicer.DEFAULT_CLOSING) - prusaslicer.sliced(comb)
    assert filled == pytest.approx(18 * 0.06 * 0.25 * 4.0, rel=0.15)  # also corners elsewhere, and mouths
