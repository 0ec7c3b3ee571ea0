"""What others read from our files."""

from __future__ import annotations

import math
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
import shapely
import trimesh

import skincad
from skincad.fabrication import GLUED_LENGTH, HOLE, SHOULDER, Job
from skincad.inputs import Design, template_names
from skincad.outputs import write_step
from skincad.outputs.drawing import flat
from skincad.shape import Point, Segment, area, polygon, section
from skincad.solids import STUB
from skincad.solids.mold import mold
from tests.conftest import Made

LEAD = 36.0  # mm, of yamada-2002: 17 tabs of 2.54, less the slots, aside by 30 degrees


def dxf_loops(path: Path) -> dict[str, list[tuple[Segment, ...]]]:
    loops: dict[str, list[tuple[Segment, ...]]] = {}
    for line in ezdxf.readfile(path).modelspace().query("LWPOLYLINE"):
        corners = [(Point(x, y), bulge) for x, y, bulge in line.get_points("xyb")]
        following = corners[1:] + corners[:1]
        ring = tuple(Segment(a, b, bulge) for (a, bulge), (b, _) in zip(corners, following, strict=True))
        loops.setdefault(line.dxf.layer, []).append(ring)
    return loops


def test_step_parts_re_read_with_their_volume(made: Made) -> None:
    for part in made.parts:
        shape = cq.importers.importStep(str(made.folder / f"solids/{part.name}.step"))
        assert len(shape.solids().vals()) == 1
        assert shape.val().Volume() == pytest.approx(part.volume, rel=1e-11)  # STEP's 15 digits


def test_step_products_carry_the_parts_names(made: Made) -> None:
    for name in ("skin", "cavity", "end-a-comb"):
        assert f"PRODUCT('{name}'" in (made.folder / f"solids/{name}.step").read_text()


def test_assembly_re_reads_with_names_colours_and_mm(made: Made, yamada: Design) -> None:
    text = (made.folder / "solids/assembly.step").read_text()
    assert "SI_UNIT(.MILLI.,.METRE.)" in text
    whole = cq.Assembly.importStep(str(made.folder / "solids/assembly.step"))
    closed = mold(yamada)
    assert whole.name == "yamada-2002"
    assert {child.name for child in whole.children} == {part.name for part in closed.parts}
    cavity = next(child for child in whole.children if child.name == "cavity")
    assert cavity.color.toTuple()[:3] == pytest.approx(
        closed.part("cavity").colour, abs=1e-6
    )  # STEP's digits


def test_skin_step_has_its_ridges_up_and_cavity_down(made: Made) -> None:
    skin = cq.importers.importStep(str(made.folder / "solids/skin.step")).val().BoundingBox()
    assert (skin.zmin, skin.zmax) == pytest.approx((0.0, 4.5), abs=2e-5)  # crown's summit between corners
    cavity = cq.importers.importStep(str(made.folder / "solids/cavity.step")).val().BoundingBox()
    floor = cavity.zmin + 4.5 / 0.999  # under the skin as poured
    assert -9.5 < floor < -9.0
    assert cavity.zmax - cavity.zmin == pytest.approx(18.5, abs=2e-5)  # a round size


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


def test_3mf_re_reads_strictly_with_names_and_colours(made: Made) -> None:
    model = read_3mf(made.folder / "solids/mold.3mf")
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    objects = model.GetMeshObjects()
    names = []
    while objects.MoveNext():
        shape = objects.GetCurrentMeshObject()
        assert shape.IsManifoldAndOriented()
        assert shape.GetObjectLevelProperty()[2]
        names.append(shape.GetName())
    assert sorted(names) == sorted(p.name for p in made.parts if p.name != "skin")


def test_3mf_parts_lie_side_by_side(made: Made) -> None:
    rows = []
    objects = read_3mf(made.folder / "solids/mold.3mf").GetMeshObjects()
    while objects.MoveNext():
        along = [corner.Coordinates[1] for corner in objects.GetCurrentMeshObject().GetVertices()]
        rows.append((min(along), max(along)))
    rows.sort()
    assert len(rows) == 7
    assert all(a[1] < b[0] for a, b in pairwise(rows))


def test_dxf_keeps_true_arcs_and_the_area(made: Made, yamada: Design) -> None:
    loops = dxf_loops(made.folder / "drawings/section.dxf")
    total = sum(map(area, loops["OUTLINE"])) - sum(map(area, loops["SLOTS"]))
    assert total == pytest.approx(section(yamada).area, rel=1e-12)
    assert ezdxf.readfile(made.folder / "drawings/section.dxf").header["$INSUNITS"] == 4  # mm


def test_strips_are_slot_deep_and_numbered(made: Made) -> None:
    drawing = ezdxf.readfile(made.folder / "film/strips.dxf")
    cuts = dxf_loops(made.folder / "film/strips.dxf")["CUT"]
    assert len(cuts) == 18
    places = np.array([s.start for s in cuts[0]])
    long = 12.0 + LEAD + GLUED_LENGTH + 10.0  # and tab
    assert np.ptp(places, axis=0) == pytest.approx([long, 5.04], abs=1e-12)
    assert np.ptp(places[places[:, 0] < 6.0], axis=0)[1] == pytest.approx(0.25, abs=1e-12)
    labels = [text.dxf.text for text in drawing.modelspace().query("TEXT")]
    assert labels[:3] == ["1 S1", "1 S2", "2 S1"]
    assert labels.count("+") == 18
    assert {entity.dxf.layer for entity in drawing.modelspace()} == {
        "BACK",
        "CUT",
        "DIMENSIONS",
        "ENGRAVE",
        "FRONT",
        "MARK",
        "TEXT",
    }


def pattern(design: Design, folder: Path) -> dict[str, list[tuple[Segment, ...]]]:
    flat.write_strips_dxf(Job(design), folder / "strips.dxf")
    lines = ezdxf.readfile(folder / "strips.dxf").modelspace().query("LWPOLYLINE")
    assert all(line.closed for line in lines)
    return dxf_loops(folder / "strips.dxf")


@pytest.mark.parametrize("side", ["a", "b"])
def test_a_strip_that_is_cast_in_has_its_area_by_formula(side: str, tmp_path: Path) -> None:
    design = skincad.load("cast-in", [f'film.wiring_side="{side}"'])
    loops = pattern(design, tmp_path)
    outlines = [loop for loop in loops["CUT"] if len(loop) > 2]
    holes = [loop for loop in loops["CUT"] if len(loop) == 2]
    assert (len(outlines), len(holes)) == (18, 36)
    # straight: the skin as poured, both end plates, stub and lead; then shoulders, tabs, less the corner
    straight = 0.375 * (18 / 0.999 + 2 * 4 + STUB + 10)
    shoulders = 2 * (0.375 * SHOULDER + 2 * (1 - math.pi / 4) * SHOULDER**2)
    # a tail for a weight; the tab with the pads, 5.04 wide, less the corner; beyond it the other weight's
    tabs, corner = 8.0 * 3.0 + 9.5 * 5.04 + 3.0 * 3.04, 1.0**2 / 2
    for outline in outlines:
        assert area(outline) == pytest.approx(straight + shoulders + tabs - corner, rel=1e-9)
    for hole in holes:
        assert area(hole) == pytest.approx(math.pi * HOLE**2, rel=1e-9)


def test_a_strip_behind_a_shim_has_its_area_by_formula(yamada: Design, tmp_path: Path) -> None:
    """Straight, one shoulder, and the tab: label, pads, bare film round them and the cut corner."""
    loops = pattern(yamada, tmp_path)
    shoulder = 0.25 * SHOULDER + 2 * (1 - math.pi / 4) * SHOULDER**2
    tab = (4.5 + 0.5 + 3.0 + 0.5 + 1.0) * 5.04 - 1.0**2 / 2
    assert area(loops["CUT"][0]) == pytest.approx(
        0.25 * (12 + LEAD + GLUED_LENGTH) + shoulder + tab, rel=1e-9
    )


@pytest.mark.parametrize("side", ["a", "b"])
def test_a_drawn_in_strips_tail_is_at_its_unwired_end(side: str, tmp_path: Path, yamada: Design) -> None:
    """Its contact never goes through the slot; the mark at which the tail is cut is the skin's end."""
    cut = pattern(yamada.with_(film={"wiring_side": side}), tmp_path)["CUT"][0]
    ends = sorted(abs(f(p.start.x for p in cut)) for f in (min, max))
    assert ends == pytest.approx([6.0 + GLUED_LENGTH, 6.0 + LEAD + 10.0])  # lead and tab
    assert (max(p.start.x for p in cut) > 12.0) == (side == "b")


@pytest.mark.parametrize("name", [n for n in template_names() if skincad.load(n).film])
@pytest.mark.parametrize("side", ["a", "b"])
def test_metal_keeps_its_margin_and_strips_lie_apart(name: str, side: str, tmp_path: Path) -> None:
    """Where both faces have metal; a lead alone goes up to its own edge, and the other face is bare there."""
    design = skincad.load(name, [f'film.wiring_side="{side}"'])
    loops = pattern(design, tmp_path)
    cuts = [shapely.Polygon(polygon(loop, 1e-4)) for loop in loops["CUT"] if len(loop) > 2]
    assert all(a.distance(b) > 1.9 for a, b in pairwise(cuts))
    margin = design.film.margin
    assert margin == 0.04
    for cut, *faces in zip(cuts, loops["FRONT"], loops["BACK"], strict=True):
        front, back = (shapely.Polygon(polygon(face, 1e-4)) for face in faces)
        assert cut.buffer(1e-9).contains(front.union(back))
        assert cut.exterior.distance(front.intersection(back)) > margin - 1e-9
        edges = [cut.exterior.intersection(face.buffer(1e-6)) for face in (front, back)]
        assert edges[0].distance(back) > margin - 2e-6  # the buffer of 1e-6
        assert edges[1].distance(front) > margin - 2e-6
    middle = np.mean([s.start.x for s in loops["FRONT"][0]])
    assert (middle > 0) == (side == "b")


def test_the_corner_that_tells_the_sides_is_at_the_wiring_end_and_the_ridges(tmp_path: Path) -> None:
    """Ridges are below in the drawing. The tab's corner, not that of the piece beyond for a weight."""
    for side, sign in (("a", -1), ("b", 1)):
        design = skincad.load("cast-in", [f'film.wiring_side="{side}"'])
        loop = pattern(design, tmp_path)["CUT"][0]
        corners = {(round(s.start.x, 6), round(s.start.z, 6)) for s in loop}
        high, foot = max(z for _, z in corners), min(z for _, z in corners)
        far = max(sign * x for x, z in corners if z == high)
        assert (round(sign * far, 6), foot) not in corners
        assert (round(sign * (far - 1.0), 6), foot) in corners
        assert (round(sign * far, 6), round(foot + 1.0, 6)) in corners


def test_strips_svg_draws_the_same_pattern(made: Made) -> None:
    root = ET.parse(made.folder / "film/strips.svg").getroot()
    space = "{http://www.w3.org/2000/svg}"
    classes = [path.attrib["class"] for path in root.findall(f"{space}path")]
    assert {name: classes.count(name) for name in set(classes)} == {
        "cut": 18,
        "front": 18,
        "back": 18,
        "mark": 18,
    }
    left, top, wide, high = map(float, root.attrib["viewBox"].split())
    assert root.attrib["width"] == f"{wide:g}mm"
    for text in root.findall(f"{space}text"):
        assert left < float(text.attrib["x"]) < left + wide
        assert top < float(text.attrib["y"]) < top + high
    words = [text.text or "" for text in root.findall(f"{space}text")]
    assert "9 S2" in words
    assert any("+ side, which faces +x" in text for text in words)
    assert any("draw axis (d31) along the strips" in text for text in words)


def test_svg_draws_outline_and_slots_to_scale(made: Made) -> None:
    root = ET.parse(made.folder / "drawings/section.svg").getroot()
    paths = root.findall("{http://www.w3.org/2000/svg}path")
    assert len(paths) == 19
    assert root.attrib["width"] == "13mm"
    assert re.search(r"A60 60 0 0 0", paths[0].attrib["d"])


def test_step_time_is_source_date_epoch(made: Made, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from skincad.solids import workplane

    cover = workplane(mold_cover())
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    write_step(cover, tmp_path / "cover.step")
    assert "'1970-01-02T00:00:00'" in (tmp_path / "cover.step").read_text()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "tomorrow")
    with pytest.raises(ValueError, match="SOURCE_DATE_EPOCH: must be whole seconds"):
        write_step(cover, tmp_path / "again.step")


def mold_cover():
    return mold(skincad.load("yamada-2002")).part("cover")


def test_a_step_file_that_the_kernel_cut_short_is_an_error(tmp_path: Path) -> None:
    from skincad.outputs.solid_files import make_deterministic

    (tmp_path / "half.step").write_text("ISO-10303-21;\nHEADER;\n")
    with pytest.raises(OSError, match="No space"):
        make_deterministic(tmp_path / "half.step", "half")


def test_the_longest_note_fits_on_the_strips_drawing(yamada: Design, tmp_path: Path) -> None:
    """It is far longer than a strip; letters of 1 mm are half as wide as high, and up to 0.7 times."""
    short = yamada.with_(film={"lead": 8.0})
    flat.write_strips_svg(Job(short), tmp_path / "strips.svg")
    root = ET.parse(tmp_path / "strips.svg").getroot()
    left, _, wide, _ = map(float, root.attrib["viewBox"].split())
    texts = root.findall("{http://www.w3.org/2000/svg}text")
    begin, letters = max((float(t.attrib["x"]), len(t.text or "")) for t in texts if len(t.text or "") > 60)
    assert begin + 0.5 * letters < left + wide < begin + 0.7 * letters


@pytest.mark.parametrize("side", ["a", "b"])
def test_a_hooks_hole_is_its_radius_from_its_tabs_end(side: str, tmp_path: Path) -> None:
    """The film that bears the weight is as wide all round, or wider: at the wiring end the piece for a weight
    is 3.04 mm wide, and its tab is wider."""
    loops = pattern(skincad.load("cast-in", [f'film.wiring_side="{side}"']), tmp_path)["CUT"]
    tabs = [shapely.Polygon(polygon(loop, 1e-5)).bounds for loop in loops if len(loop) > 2]
    holes = [shapely.Polygon(polygon(loop, 1e-5)).bounds for loop in loops if len(loop) == 2]
    low, low_z, high, high_z = tabs[0]
    first, last = sorted(h for h in holes if low_z < h[1] < high_z)
    assert (first[0] - low, high - last[2]) == pytest.approx((HOLE, HOLE), abs=1e-4)
    whole = shapely.Polygon(polygon(next(loop for loop in loops if len(loop) > 2), 1e-5))
    for hole in (first, last):
        beside = whole.exterior.distance(shapely.box(*hole).centroid)
        assert 2 * HOLE - 1e-4 < beside < 2 * HOLE + 0.03
