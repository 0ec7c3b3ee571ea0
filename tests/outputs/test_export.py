"""Solids, meshes and the section as other libraries read them from our files."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from itertools import pairwise
from pathlib import Path
from typing import Any

import cadquery as cq
import ezdxf
import lib3mf
import pytest
import trimesh

from skincad.fabrication import Job
from skincad.inputs import Design
from skincad.outputs import solid_files, write_step
from skincad.shape import area, section
from skincad.solids import workplane
from tests.conftest import Made
from tests.outputs.drawing.test_strips import dxf_loops


@pytest.mark.slow
def test_step_parts_re_read_with_their_volume_and_names(made: Made) -> None:
    boxes = {}
    for part in made.parts:
        path = made.folder / f"solids/{part.name}.step"
        shape = cq.importers.importStep(str(path))
        assert len(shape.solids().vals()) == 1
        assert shape.val().Volume() == pytest.approx(part.volume, rel=1e-11)  # STEP's 15 digits
        assert f"PRODUCT('{part.name}'" in path.read_text()
        boxes[part.name] = shape.val().BoundingBox()
    skin, cavity = boxes["skin"], boxes["cavity"]  # ridges up, and the cavity down
    assert (skin.zmin, skin.zmax) == pytest.approx((0.0, 4.5), abs=2e-5)  # crown's summit between corners
    floor = cavity.zmin + 4.5 / 0.999  # under the skin as poured
    assert -9.5 < floor < -9.0
    assert cavity.zmax - cavity.zmin == pytest.approx(18.5, abs=2e-5)  # a round size


@pytest.mark.slow
def test_assembly_re_reads_with_names_colours_and_mm(made: Made, yamada: Design) -> None:
    text = (made.folder / "solids/assembly.step").read_text()
    assert "SI_UNIT(.MILLI.,.METRE.)" in text
    whole = cq.Assembly.importStep(str(made.folder / "solids/assembly.step"))
    closed = Job(yamada).closed
    assert whole.name == "yamada-2002"
    assert {child.name for child in whole.children} == {part.name for part in closed.parts}
    cavity = next(child for child in whole.children if child.name == "cavity")
    assert cavity.color.toTuple()[:3] == pytest.approx(
        closed.part("cavity").colour, abs=1e-6
    )  # STEP's digits


@pytest.mark.slow
def test_stl_re_reads_watertight_with_the_parts_volume(made: Made) -> None:
    for part in made.parts:
        shape = trimesh.load_mesh(made.folder / f"solids/{part.name}.stl")
        assert shape.is_watertight
        # single precision, and chords within the deviation over the whole surface
        assert shape.volume == pytest.approx(part.volume, abs=part.area * part.deviation)


def read_3mf(path: Path) -> Any:
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    assert reader.GetWarningCount() == 0
    return model


@pytest.mark.slow
def test_3mf_re_reads_strictly_with_names_and_colours_side_by_side(made: Made) -> None:
    model = read_3mf(made.folder / "solids/mold.3mf")
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    objects = model.GetMeshObjects()
    names, rows = [], []
    while objects.MoveNext():
        shape = objects.GetCurrentMeshObject()
        assert shape.IsManifoldAndOriented()
        assert shape.GetObjectLevelProperty()[2]
        names.append(shape.GetName())
        along = [corner.Coordinates[1] for corner in shape.GetVertices()]
        rows.append((min(along), max(along)))
    assert sorted(names) == sorted(p.name for p in made.parts if p.name != "skin")
    rows.sort()
    assert len(rows) == 7
    assert all(a[1] < b[0] for a, b in pairwise(rows))


@pytest.mark.slow
def test_dxf_keeps_true_arcs_and_the_area(made: Made, yamada: Design) -> None:
    loops = dxf_loops(made.folder / "drawings/section.dxf")
    total = sum(map(area, loops["OUTLINE"])) - sum(map(area, loops["SLOTS"]))
    assert total == pytest.approx(section(yamada).area, rel=1e-12)
    assert ezdxf.readfile(made.folder / "drawings/section.dxf").header["$INSUNITS"] == 4  # mm


@pytest.mark.slow
def test_svg_draws_outline_and_slots_to_scale(made: Made) -> None:
    root = ET.parse(made.folder / "drawings/section.svg").getroot()
    paths = root.findall("{http://www.w3.org/2000/svg}path")
    assert len(paths) == 19
    assert root.attrib["width"] == "13mm"
    assert re.search(r"A60 60 0 0 0", paths[0].attrib["d"])


def test_step_time_is_source_date_epoch(
    yamada: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cover = workplane(Job(yamada).closed.part("cover"))
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    write_step(cover, tmp_path / "cover.step")
    assert "'1970-01-02T00:00:00'" in (tmp_path / "cover.step").read_text()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "tomorrow")
    with pytest.raises(ValueError, match="SOURCE_DATE_EPOCH: must be whole seconds"):
        write_step(cover, tmp_path / "again.step")


def test_a_step_file_that_the_kernel_cut_short_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "half.step").write_text("ISO-10303-21;\nHEADER;\n")
    with pytest.raises(OSError, match="No space"):
        solid_files.make_deterministic(tmp_path / "half.step", "half")
