"""Sheets of parts and of the assembly against the exact solids, read by other libraries than the writers'."""

from __future__ import annotations

import cmath
import math
import re
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import cadquery as cq
import dxf_parser
import ezdxf
import pypdf
import pytest
import shapely

import skincad
from skincad.fabrication import (
    ABOVE,
    FRONT,
    AssemblyDrawing,
    Job,
    PartDrawing,
    notches,
    number,
    views,
)
from skincad.fabrication.assembly_drawing import assembly_drawing
from skincad.fabrication.part_drawing import part_drawing
from skincad.fabrication.parts_list import parts_list
from skincad.inputs import Design, template_names
from skincad.outputs.drawing import assembly_sheet, formats, marks, part_views
from skincad.outputs.drawing.part_sheet import part_sheet
from skincad.solids import Arc, CutRole, Part, RotatedBody, bores, solid, workplane
from skincad.solids.occ import projection
from tests.designs import RIDGED, three_ridges


def others(names: list[str], *fast: str) -> list[Any]:
    """Parameters: of templates beside these and yamada-2002, which is slow, evidence."""
    marks = {"yamada-2002": pytest.mark.slow, **dict.fromkeys((*fast, "bent", "gang", "few"), ())}
    return [pytest.param(n, marks=marks.get(n, pytest.mark.evidence(subject=n))) for n in names]


# doubly curved; printed with nuts, by wire and mounted take longer
NAMES = [
    *others(["bent", *RIDGED]),
    pytest.param("mounted", marks=pytest.mark.evidence(subject="sheets of a mounted skin")),
]
READ = 1e-6  # mm, DXF has 16 digits, the drawing's places six
THREADED = {CutRole.END_THREAD, CutRole.COVER_THREAD, CutRole.PULL, CutRole.MOUNT}


def named(name: str) -> Design:
    if name == "mounted":
        mount = {"thread": "M3", "pattern": "rectangle", "pitch_x": 10.0, "fiducials": 3}
        return skincad.load("fingertip-soft").with_(mount=mount)
    special = {"bent": three_ridges, "few": few}
    return special[name]() if name in special else skincad.load(name)


def few() -> Design:
    return skincad.load("yamada-2002", ["ridge.count=3"])


class Drawn(NamedTuple):
    """A made part with its exact solid, its drawing and its sheet."""

    part: Part
    shape: cq.Solid
    drawing: PartDrawing
    sheet: marks.Sheet


def drawn(design: Design, part: Part) -> Drawn:
    shape = solid(part)
    drawing = part_drawing(Job(design), part, shape, None)
    return Drawn(part, shape, drawing, part_sheet(drawing, ""))


@cache
def drawn_part(name: str, part: str) -> Drawn:
    return drawn(named(name), Job(named(name)).closed.part(part))


def drawn_parts(name: str) -> list[Drawn]:
    return [drawn_part(name, part.name) for part in Job(named(name)).closed.parts if part.made == "made"]


def diameters(path: Path) -> list[dict[str, Any]]:
    """The diameter dimensions of a DXF, as another library than the writer's reads them."""
    read = dxf_parser.parse(path.read_text(encoding="utf-8"))
    dimensions = [e for e in read["entities"] if e["type"] == "DIMENSION"]
    return [e for e in dimensions if e["dimensionType"] & 7 == 3]


def along(way: tuple[float, float, float], vector: cq.Vector) -> float:
    return math.fsum(a * b for a, b in zip(way, vector.toTuple(), strict=True))


def cylinders(made: cq.Solid) -> list[tuple[cq.Vector, cq.Vector, float, cq.Face]]:
    """Direction, a point of the axis, and the radius of every round face."""
    rows = []
    for face in (face for face in made.Faces() if face.geomType() == "CYLINDER"):
        cylinder = face._geomAdaptor().Cylinder()
        axis = cylinder.Axis()
        rows.append((cq.Vector(axis.Direction()), cq.Vector(axis.Location()), cylinder.Radius(), face))
    return rows


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_every_bore_is_on_its_sheet(name: str, tmp_path: Path) -> None:
    for part, _, drawing, sheet in drawn_parts(name):
        formats.write_dxf(tmp_path / "part.dxf", sheet.marks, sheet.scale)
        formats.write_sheet_pdf(sheet, tmp_path / "part.pdf")
        read = diameters(tmp_path / "part.dxf")
        words = pypdf.PdfReader(tmp_path / "part.pdf").pages[0].extract_text()
        groups = drawing.holes
        of_plan = sorted(round(2 * bore.radius, 6) for bore in bores(part))
        twice = [g.diameter for g in groups for _ in g.holes if g.depth is not None and len(g.sides) == 2]
        on_sheet = [round(e["actualMeasurement"], 6) for e in read]
        assert sorted([*on_sheet, *(round(d, 6) for d in twice)]) == of_plan, part.name
        for entity in read:  # what it says is as far as its points are apart
            a, b = entity["anchorPoint"], entity["diameterOrRadiusPoint"]
            distance = math.dist((a["x"], a["y"]), (b["x"], b["y"]))
            assert distance == pytest.approx(entity["actualMeasurement"], abs=READ)
        tags = [e["text"].split()[0] for e in read]
        assert sorted(tags) == sorted(tag for group in groups for tag in group.holes)
        for group in groups:
            first = next(e["text"] for e in read if e["text"].split()[0] == next(iter(group.holes)))
            assert group.size in first
            assert (group.role in THREADED) == ("M3" in first.split())  # or "M3 insert"
            row = f"{group.letter} ({len(group.holes)}x)", group.purpose, group.size
            assert re.search(r"\s+".join(map(re.escape, row)), words), (part.name, row)
            assert group.reach in words
            for tag in group.holes:
                assert re.search(rf"\b{tag}\b", words), (part.name, tag)


@pytest.mark.parametrize("name", NAMES)
def test_places_and_depths_are_those_of_the_solid(name: str) -> None:
    """The exact solid's cylinders, found on its faces, lie where the drawing has holes, and are as deep."""
    for part, shape, drawing, _ in drawn_parts(name):
        seen = {view.name: view.of_solid for view in views(part)}
        faces = cylinders(shape)
        for group in drawing.holes:
            if group.lean or group.diameter != group.far_diameter:
                continue
            view = seen[group.view]
            for hole, place in group.holes.items():
                depths = []
                for way, at, radius, face in faces:
                    near = math.dist(view.at(at.toTuple()), place) < 1e-5  # the kernel's tolerance is 1e-7
                    same = abs(2 * radius - group.diameter) < 1e-6
                    if near and same and abs(along(view.towards, way)) > 1 - 1e-9:
                        ends = [along(view.towards, vertex.Center()) for vertex in face.Vertices()]
                        depths.append(max(ends) - min(ends))
                assert depths, (part.name, hole)
                deep = group.depth is None or min(abs(depth - group.depth) for depth in depths) < 1e-5
                assert deep, (part.name, hole, depths)


def words_in_frame(sheet: marks.Sheet, low: float) -> list[tuple[str, tuple[float, float, float, float]]]:
    """The words of a sheet with their boxes: all lie inside the frame, whose lower edge is at `low` mm."""
    words = [mark.words for mark in sheet.marks if isinstance(mark, marks.Dimension)]
    words += [mark for mark in sheet.marks if isinstance(mark, marks.Words)]
    wide, tall = sheet.size
    boxes = [(mark.text, mark.box()) for mark in words]
    for text, (left, bottom, right, high) in boxes:
        assert left >= 20.0, text
        assert bottom >= low, text
        assert right <= wide - 10.0, text
        assert high <= tall - 10.0, text
    return boxes


@pytest.mark.parametrize("name", NAMES)
def test_no_words_lie_on_others_and_all_is_inside_the_frame(name: str) -> None:
    for part, _, _, sheet in drawn_parts(name):
        boxes = words_in_frame(sheet, 10.0)
        clashes = [(a, b) for i, (a, x) in enumerate(boxes) for b, y in boxes[:i] if marks.overlap(x, y)]
        assert clashes == [], part.name


@pytest.mark.parametrize("name", NAMES)
def test_threads_and_bores_from_their_sides_are_where_the_solid_has_them(name: str) -> None:
    """The solid's cylinders, projected by themselves: each has its centre line in the other views, and
    each thread of M3 an arc of three quarters, 3 mm wide (ISO 6410-1)."""
    for part, shape, drawing, sheet in drawn_parts(name):
        seen = {view.name: view.of_solid for view in views(part)}
        faces = cylinders(shape)
        for group in drawing.holes:
            for side_view in group.side_views:
                assert side_view.view != group.view
                way = math.atan2(side_view.end[1] - side_view.start[1], side_view.end[0] - side_view.start[0])
                off = math.inf  # how far the nearest bore's axis passes the centre line's start
                for direction, at, radius, _ in faces:
                    (x, y), (u, v) = seen[side_view.view].at(at.toTuple()), side_view.start
                    ahead = seen[side_view.view].at((at + direction).toTuple())
                    turn = math.sin(math.atan2(ahead[1] - y, ahead[0] - x) - way)
                    if abs(2 * radius - group.diameter) < 1e-6 and abs(turn) < 1e-9:
                        off = min(off, abs((u - x) * math.sin(way) - (v - y) * math.cos(way)))
                if group.diameter == group.far_diameter:
                    assert off < 1e-5, (part.name, side_view)  # the kernel's tolerance is 1e-7
        arcs = [m.stroke for m in sheet.marks if isinstance(m, marks.Ink) and m.layer == "THREAD"]
        tapped = [hole for group in drawing.holes if group.thread in ("M3", "M3 x 4") for hole in group.holes]
        assert len(arcs) == len(tapped)
        for arc in arcs:
            assert isinstance(arc, Arc)
            assert arc.radius == pytest.approx(1.5 * sheet.scale)
            assert arc.sweep == pytest.approx(1.5 * math.pi)


def test_a_mounts_thread_ends_before_its_bore_with_a_line_across() -> None:
    """ISO 6410-1: from the mouth, above, 4 mm down, M3 wide; the bore is 6.5 mm deep."""
    design = named("mounted")
    drawing = drawn(design, Job(design).closed.part("carrier")).drawing
    (group,) = (group for group in drawing.holes if group.role is CutRole.MOUNT)
    strokes = part_views.bore_marks(
        (group,), {view: part_views.ViewPlacement((0.0, 0.0), 2.0) for view in drawing.views}
    )
    hidden = [m.stroke.points for m in strokes if isinstance(m, marks.Ink) and m.layer == "HIDDEN"]
    assert len(hidden) == 3 * len(group.side_views)
    assert group.side_views
    for side_view in group.side_views:
        (u, v), (x, y) = side_view.start, side_view.end
        share = 4.0 / math.dist(side_view.start, side_view.end)
        last = 2 * (x + share * (u - x)), 2 * (y + share * (v - y))  # of full thread, on paper
        ends = [points for points in hidden if math.dist(points[0], last) < 3.0 + READ]
        assert sorted(round(math.dist(*points), 6) for points in ends) == [6.0, 8.0, 8.0]


@pytest.mark.parametrize("name", NAMES)
def test_every_notch_is_in_its_table_where_the_solid_lacks_material(name: str) -> None:
    for part, shape, _, _ in drawn_parts(name):
        if isinstance(part.body, RotatedBody):
            continue  # the solid leans, the notches are told in the plate's own frame
        seen = {view.name: view.of_solid for view in views(part)}
        drawn = notches(part)
        assert len(drawn) == sum(cut.role in (CutRole.PRY, CutRole.MARK) for cut in part.cuts)
        (left, _), (right, _) = projection(shape, seen[FRONT]).box()
        low, high = projection(shape, seen[ABOVE]).box()
        for notch in drawn:
            middle, step = (notch.low + notch.high) / 2, 0.3 * notch.leg
            x = left + step if notch.side == "left" else right - step
            depth = (
                low[1] + step if notch.outer else high[1] - step
            )  # seen from above, the outer face is below
            up, above = seen[FRONT], seen[ABOVE]
            place = [
                x * a + middle * b + depth * c for a, b, c in zip(up.right, up.up, above.up, strict=True)
            ]
            assert not shape.isInside(cq.Vector(*place), 1e-6), (part.name, notch)
            deep = [
                p + 0.5 * notch.leg * (-1 if notch.side == "right" else 1) * a
                for p, a in zip(place, up.right, strict=True)
            ]
            assert shape.isInside(cq.Vector(*deep), 1e-6), (part.name, notch)


@pytest.mark.slow
def test_places_count_from_level_faces() -> None:
    """A keeper's lower edge is bent: heights count from its upper one, which is datum C."""
    _, shape, drawing, _ = drawn_part("yamada-2002", "end-a-keeper")
    assert drawing.datums[2].edge == "top"
    assert any("left and upper edge" in note for note in drawing.notes)
    box = shape.BoundingBox(1e-6)
    rows = next(table.rows for table in drawing.tables if table.title == "Positions of holes")
    texts = {(x, y) for _, x, y in rows}
    axes = {(number(at.x - box.xmin), number(box.zmax - at.z)) for _, at, _, _ in cylinders(shape)}
    assert texts <= axes


def test_a_ridges_groove_and_slits_lean_alike() -> None:
    """Both by the same sign, seen from the same end: the parts lie on each other."""
    names = ("cavity", "end-a-comb", "end-b-comb")
    drawings = {name: drawn_part("few", name).drawing for name in names}
    grooves = {groove.ridge: groove.lean for groove in drawings["cavity"].grooves}
    assert min(grooves.values()) < -0.9 < 0.9 < max(grooves.values())  # degrees
    for slit in drawings["end-a-comb"].slits:
        assert slit.lean == pytest.approx(grooves[slit.ridge], abs=1e-6)
    for slit in drawings["end-b-comb"].slits:
        assert slit.lean == pytest.approx(-grooves[slit.ridge], abs=1e-6)


@pytest.mark.evidence(subject="steep-fingertip")
def test_a_right_piece_counts_from_its_level_side() -> None:
    left, right = (drawn_part("steep-fingertip", f"cavity-{side}").drawing for side in ("left", "right"))
    assert (left.datums[1].edge, right.datums[1].edge) == ("left", "right")
    assert any("right and lower edge" in note for note in right.notes)
    tables = [{table.title.split(":")[0]: table.rows for table in entry.tables} for entry in (left, right)]
    grooves = [entry["Grooves of the ridges"] for entry in tables]
    assert [row[1:3] for row in grooves[0]] == [row[1:3] for row in grooves[1]][::-1]  # its mirror image


@pytest.mark.evidence(subject="sheets of a gang")
@pytest.mark.parametrize("end", ["a", "b"])
def test_a_gangs_other_slits_are_where_the_note_says(end: str) -> None:
    design = skincad.load("yamada-2002", ["mold.cavities=3"])
    part, shape, drawing, _ = drawn(design, Job(design).closed.part(f"end-{end}-comb"))
    note = next(note for note in drawing.notes if note.startswith("Slits: of the skin furthest"))
    match = re.search(r"are ([\d.]+) and ([\d.]+) to the (left|right) of them", note)
    assert match is not None
    way = 1 if match[3] == "right" else -1
    view = next(view.of_solid for view in views(part) if view.name == FRONT)
    middle = shape.Center().y
    for slit in drawing.slits:
        for distance in (0.0, float(match[1]), float(match[2])):
            for up, within in ((0.01, False), (-0.01, True)):  # mm: beyond the slit's bottom, and under it
                x, z = (at + up * out for at, out in zip(slit.at, slit.out, strict=True))
                place = cq.Vector((x + way * distance) * view.right[0], middle, z)
                assert shape.isInside(place, 1e-6) == within, (slit, distance, up)


def test_the_same_sheet_has_the_same_bytes_and_no_time(tmp_path: Path) -> None:
    design, first = named("few"), drawn_part("few", "cavity")
    written = []
    for sheet in (first.sheet, drawn(design, first.part).sheet):
        formats.write_sheet_pdf(sheet, tmp_path / "a.pdf")
        formats.write_dxf(tmp_path / "a.dxf", sheet.marks, sheet.scale)
        written.append([(tmp_path / f"a.{kind}").read_bytes() for kind in ("pdf", "dxf")])
        written[-1].append(formats.sheet_svg(sheet).encode())
    assert written[0] == written[1]
    assert "/CreationDate" not in (pypdf.PdfReader(tmp_path / "a.pdf").metadata or {})


def test_what_the_check_allows_is_in_the_table_of_grooves() -> None:
    part, shape, unchecked, _ = drawn_part("few", "cavity")
    drops = (0.0123, 0.05, math.inf)
    drawing = part_drawing(Job(named("few")), part, shape, drops)
    grooves = drawing.tables[-1]
    assert [row[-1] for row in grooves.rows] == ["0/-0.0123", "0/-0.0500", "free"]
    assert any("ridge 1 allows least, 0.0123" in note for note in drawing.notes)
    assert not any("yield" in note.lower() for note in drawing.notes)  # a shop can do nothing about it
    assert any("made without the check" in note for note in unchecked.notes)
    assert number(drawing.grooves[1].height) == "0.501"


def profile_area(path: Path) -> float:
    """The area, mm2, within the closed line of a DXF's visible edges to which the first arc belongs; arcs
    are whole, no chords."""
    read = dxf_parser.parse(path.read_text(encoding="utf-8"))
    steps: list[tuple[complex, complex, float]] = []  # from, to, and the area between arc and chord
    for e in (e for e in read["entities"] if e["layer"] == "OUTLINE"):
        if e["type"] == "ARC":
            middle, turn = complex(e["center"]["x"], e["center"]["y"]), e["angleLength"] % math.tau
            a, b = (
                middle + cmath.rect(e["radius"], way) for way in (e["startAngle"], e["startAngle"] + turn)
            )
            steps.insert(0, (a, b, e["radius"] ** 2 * (turn - math.sin(turn)) / 2))
        elif e["type"] == "LINE":
            a, b = (complex(v["x"], v["y"]) for v in e["vertices"])
            steps.append((a, b, 0.0))
    first, at, bulge = steps.pop(0)
    total = bulge + (first.conjugate() * at).imag / 2
    while abs(at - first) > READ:
        near = [(i, end) for i, step in enumerate(steps) for end in (0, 1) if abs(step[end] - at) < READ]
        ((i, end),) = near  # the line goes on, and does not fork
        a, b, bulge = steps.pop(i)
        a, b, bulge = (a, b, bulge) if end == 0 else (b, a, -bulge)
        total += bulge + (a.conjugate() * b).imag / 2
        at = b
    return abs(total)


@pytest.mark.parametrize("name", others(["few", "lab-bench", "fingertip-soft", "milled-pad"]))
def test_a_cavitys_profile_is_cut_to_the_solids_area(name: str, tmp_path: Path) -> None:
    """What a wire follows: true arcs, and larger than the skin by the shrinkage as the solid is."""
    _, shape, _, sheet = drawn_part(name, "cavity")
    formats.write_dxf(tmp_path / "part.dxf", sheet.marks, sheet.scale)
    end = min(shape.Faces(), key=lambda face: face.Center().y)
    whole = cq.Face.makeFromWires(end.outerWire()).Area()
    assert profile_area(tmp_path / "part.dxf") == pytest.approx(whole, rel=1e-6)


@pytest.mark.parametrize(("name", "strokes"), [("yamada-2002", 2), ("plain-ridges", 1)])
def test_the_symbol_of_texture_has_its_bar_where_material_is_cut_away(name: str, strokes: int) -> None:
    """Wire against resin; the symbol stands in its cell, and says what the process does."""
    design = skincad.load(name, ["ridge.count=3"])
    sheet_marks = drawn(design, Job(design).closed.part("cavity")).sheet.marks
    (label,) = (m for m in sheet_marks if isinstance(m, marks.Words) and "ISO 21920-1" in m.text)
    (said,) = (m for m in sheet_marks if isinstance(m, marks.Words) and m.text.startswith("Ra "))
    left, right, high = label.at[0] - 1.0, label.at[0] + 38.0, label.at[1]
    inside = [
        mark.stroke.box()
        for mark in sheet_marks
        if isinstance(mark, marks.Ink)
        and mark.layer == "FRAME"
        and left < mark.stroke.box()[0][0]
        and mark.stroke.box()[1][0] < right
        and high - 5.5 < mark.stroke.box()[0][1]
        and mark.stroke.box()[1][1] < high
    ]
    assert len(inside) == strokes
    assert said.text == "Ra 1.6"  # a shop's general one, and a resin's
    assert not marks.overlap(label.box(), said.box())


ASSEMBLIES = {
    "bent": three_ridges,
    "few": few,
    "gang": lambda: skincad.load("plain-ridges", ["mold.cavities=2", "ridge.count=3"]),
}


@cache
def assembled(name: str) -> tuple[Job, AssemblyDrawing, marks.Sheet]:
    """A job, the drawing of its closed mold, and the sheet of that."""
    job = Job(ASSEMBLIES[name]() if name in ASSEMBLIES else skincad.load(name))
    drawing = assembly_drawing(job)
    return job, drawing, assembly_sheet.assembly_sheet(drawing, "")


def area(drawing: AssemblyDrawing, part: str) -> float:
    return sum(shapely.Polygon(f.rings[0], f.rings[1:]).area for f in drawing.faces if f.part == part)


@pytest.mark.parametrize("name", others(["few", "milled-pad", "steep-fingertip"]))
def test_the_section_is_that_of_the_solids(name: str) -> None:
    """Each part's area in the plane, by the kernel's boolean, within what chords cut off."""
    job, drawing, _ = assembled(name)
    plane = cq.Workplane("YZ").workplane(offset=drawing.cut_at + 1e-3)
    sheet = plane.rect(200.0, 200.0).extrude(1e-3)
    for part in job.closed.parts:
        if part.made != "bought":
            cut = workplane(part).intersect(sheet)
            volume = cut.val().Volume() if cut.solids().size() else 0.0
            assert area(drawing, part.name) == pytest.approx(volume / 1e-3, rel=5e-3, abs=0.1), part.name


def test_the_section_goes_through_gate_vent_and_cup() -> None:
    _, drawing, _ = assembled("few")
    faces = [face.part for face in drawing.faces]
    for part in ("end-a-keeper", "carrier", "cover"):  # each is parted by its opening
        assert faces.count(part) == 2, part
    assert faces.count("end-b-keeper") == 1


@pytest.mark.parametrize("name", [*ASSEMBLIES, *others(template_names(), "flat-magnet")])
def test_every_part_has_its_row_and_what_is_seen_its_balloon(name: str) -> None:
    job, drawing, sheet = assembled(name)
    rows = {str(n): item.what for n, item in enumerate(parts_list(job), 1)}
    (table,) = drawing.tables
    assert {row[2] for row in table.rows} >= {part.name for part in job.closed.parts if part.made == "made"}
    assert all(rows[row[0]] == row[2] for row in table.rows)
    rings = [m.stroke for m in sheet.marks if isinstance(m, marks.Ink) and isinstance(m.stroke, Arc)]
    circles = [ring for ring in rings if ring.radius == assembly_sheet.BALLOON]
    cut = {face.item for face in drawing.faces if face.item}
    assert len(circles) == len(cut) + len(drawing.balloons)
    assert {rows[item] for item in cut} >= {"cover", "carrier"}
    words_in_frame(sheet, 8.0)
    centres = [ring.centre for ring in circles]
    apart = [shapely.Point(a).distance(shapely.Point(b)) for i, a in enumerate(centres) for b in centres[:i]]
    assert min(apart) > 2 * assembly_sheet.BALLOON


def test_the_assembly_is_read_as_pdf_and_as_dxf(tmp_path: Path) -> None:
    _, _, sheet = assembled("few")
    formats.write_sheet_pdf(sheet, tmp_path / "a.pdf")
    formats.write_sheet_dxf(sheet, tmp_path / "a.dxf")
    words = pypdf.PdfReader(tmp_path / "a.pdf").pages[0].extract_text()
    for text in ("section A-A", "assembly drawing", "ISO 8734 2 x 8", "end-b-keeper", "brass CW614N"):
        assert text in words
    assert not ezdxf.readfile(tmp_path / "a.dxf").audit().errors
