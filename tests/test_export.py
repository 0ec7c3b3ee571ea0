"""What others read from our files."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from itertools import pairwise
from pathlib import Path
from typing import Any

import cadquery as cq
import ezdxf
import lib3mf
import numpy as np
import pytest
import trimesh

from skincad import export
from skincad.curves import Point, Segment, area
from skincad.design import Design
from skincad.job import MakeResult
from skincad.section import section
from skincad.solids.mold import mold


def dxf_loops(path: Path) -> dict[str, list[tuple[Segment, ...]]]:
    loops: dict[str, list[tuple[Segment, ...]]] = {}
    for line in ezdxf.readfile(path).modelspace().query("LWPOLYLINE"):
        corners = [(Point(x, y), bulge) for x, y, bulge in line.get_points("xyb")]
        following = corners[1:] + corners[:1]
        ring = tuple(Segment(a, b, bulge) for (a, bulge), (b, _) in zip(corners, following, strict=True))
        loops.setdefault(line.dxf.layer, []).append(ring)
    return loops


def test_step_parts_re_read_with_their_volume(made: MakeResult) -> None:
    for part in made.parts:
        shape = cq.importers.importStep(str(made.folder / f"{part.name}.step"))
        assert len(shape.solids().vals()) == 1
        assert shape.val().Volume() == pytest.approx(part.volume, rel=1e-12)  # FACTS: 1e-13


def test_step_products_carry_the_parts_names(made: MakeResult) -> None:
    for name in ("skin", "cavity", "end-a-comb"):
        assert f"PRODUCT('{name}'" in (made.folder / f"{name}.step").read_text()


def test_assembly_re_reads_with_names_colours_and_mm(made: MakeResult, yamada: Design) -> None:
    text = (made.folder / "assembly.step").read_text()
    assert "SI_UNIT(.MILLI.,.METRE.)" in text
    whole = cq.Assembly.importStep(str(made.folder / "assembly.step"))
    closed = mold(yamada)
    assert whole.name == "yamada-2002"
    assert {child.name for child in whole.children} == {part.name for part in closed.parts}
    cavity = next(child for child in whole.children if child.name == "cavity")
    assert cavity.color.toTuple()[:3] == pytest.approx(
        closed.part("cavity").colour, abs=1e-6
    )  # STEP's digits


def test_skin_step_has_its_ridges_up_and_cavity_down(made: MakeResult) -> None:
    skin = cq.importers.importStep(str(made.folder / "skin.step")).val().BoundingBox()
    assert (skin.zmin, skin.zmax) == pytest.approx((0.0, 4.5), abs=2e-5)  # crown's summit between corners
    cavity = cq.importers.importStep(str(made.folder / "cavity.step")).val().BoundingBox()
    assert cavity.zmin == pytest.approx(-13.5, abs=2e-5)


def test_stl_re_reads_watertight_with_the_parts_volume(made: MakeResult) -> None:
    for part in made.parts:
        shape = trimesh.load_mesh(made.folder / f"{part.name}.stl")
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


def test_3mf_re_reads_strictly_with_names_and_colours(made: MakeResult) -> None:
    model = read_3mf(made.folder / "mold.3mf")
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    found = model.GetMeshObjects()
    names = []
    while found.MoveNext():
        shape = found.GetCurrentMeshObject()
        assert shape.IsManifoldAndOriented()
        assert shape.GetObjectLevelProperty()[2]
        names.append(shape.GetName())
    assert sorted(names) == sorted(p.name for p in made.parts if p.name != "skin")


def test_3mf_parts_lie_side_by_side(made: MakeResult) -> None:
    rows = []
    found = read_3mf(made.folder / "mold.3mf").GetMeshObjects()
    while found.MoveNext():
        along = [corner.Coordinates[1] for corner in found.GetCurrentMeshObject().GetVertices()]
        rows.append((min(along), max(along)))
    rows.sort()
    assert len(rows) == 7
    assert all(a[1] < b[0] for a, b in pairwise(rows))


def test_dxf_keeps_true_arcs_and_the_area(made: MakeResult, yamada: Design) -> None:
    loops = dxf_loops(made.folder / "section.dxf")
    total = sum(map(area, loops["OUTLINE"])) - sum(map(area, loops["SLOTS"]))
    assert total == pytest.approx(section(yamada).area, rel=1e-12)
    assert ezdxf.readfile(made.folder / "section.dxf").header["$INSUNITS"] == 4  # mm


def test_strips_are_slot_deep_and_numbered(made: MakeResult) -> None:
    drawing = ezdxf.readfile(made.folder / "strips.dxf")
    cuts = dxf_loops(made.folder / "strips.dxf")["CUT"]
    assert len(cuts) == 18
    size = np.ptp(np.array([s.start for s in cuts[0]]), axis=0)
    assert size == pytest.approx([12.0 + export.STRIP_TAB, 0.25], abs=1e-12)
    labels = [text.dxf.text for text in drawing.modelspace().query("TEXT")]
    assert labels[:3] == ["1 S1", "1 S2", "2 S1"]


def test_svg_draws_outline_and_slots_to_scale(made: MakeResult) -> None:
    root = ET.parse(made.folder / "section.svg").getroot()
    paths = root.findall("{http://www.w3.org/2000/svg}path")
    assert len(paths) == 19
    assert root.attrib["width"] == "13mm"
    assert re.search(r"A60 60 0 0 0", paths[0].attrib["d"])


def test_step_time_is_source_date_epoch(
    made: MakeResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from skincad.solids.occ import workplane

    cover = workplane(mold_cover())
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    export.write_step(cover, tmp_path / "cover.step")
    assert "'1970-01-02T00:00:00'" in (tmp_path / "cover.step").read_text()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "tomorrow")
    with pytest.raises(ValueError, match="SOURCE_DATE_EPOCH: must be whole seconds"):
        export.write_step(cover, tmp_path / "again.step")


def mold_cover():
    import skincad

    return mold(skincad.load("yamada-2002")).part("cover")


def test_a_step_file_that_the_kernel_cut_short_is_an_error(tmp_path: Path) -> None:
    from skincad.stepfile import make_deterministic

    (tmp_path / "half.step").write_text("ISO-10303-21;\nHEADER;\n")
    with pytest.raises(OSError, match="No space"):
        make_deterministic(tmp_path / "half.step", "half")
