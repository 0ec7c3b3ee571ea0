"""The assembly's drawing: the section against the solids, a balloon for each part, all words in the frame."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cadquery as cq
import ezdxf
import pypdf
import pytest
import shapely

import skincad
from skincad.fabrication import AssemblyDrawing, Job
from skincad.fabrication.assembly_drawing import assembly_drawing
from skincad.fabrication.parts_list import parts_list
from skincad.inputs import Design
from skincad.outputs.drawing.assembly_sheet import BALLOON, assembly_sheet
from skincad.outputs.drawing.formats import write_sheet_dxf, write_sheet_pdf
from skincad.outputs.drawing.marks import Ink, Words
from skincad.solids import Arc, workplane
from tests.bent_skin import three_ridges
from tests.templates import SHIPPED

GANG = ("plain-ridges", ["mold.cavities=2"])


def designs() -> list[Any]:
    own = [pytest.param(design) for design in (three_ridges(), skincad.load(*GANG))]
    return [*(pytest.param(skincad.load(str(one.values[0])), marks=one.marks) for one in SHIPPED), *own]


def area(drawing: AssemblyDrawing, part: str) -> float:
    return sum(shapely.Polygon(f.rings[0], f.rings[1:]).area for f in drawing.faces if f.part == part)


@pytest.mark.parametrize("name", ["yamada-2002", "milled-pad", "steep-fingertip"])
def test_the_section_is_that_of_the_solids(name: str) -> None:
    """Each part's area in the plane, by the kernel's boolean, within what chords cut off."""
    design = skincad.load(name)
    drawing, job = assembly_drawing(Job(design)), Job(design)
    plane = cq.Workplane("YZ").workplane(offset=drawing.cut_at + 1e-3)
    sheet = plane.rect(200.0, 200.0).extrude(1e-3)
    for part in job.closed.parts:
        if part.made != "bought":
            cut = workplane(part).intersect(sheet)
            volume = cut.val().Volume() if cut.solids().size() else 0.0
            assert area(drawing, part.name) == pytest.approx(volume / 1e-3, rel=5e-3, abs=0.1), part.name


def test_it_goes_through_gate_vent_and_cup() -> None:
    drawing = assembly_drawing(Job(skincad.load("yamada-2002")))
    faces = [face.part for face in drawing.faces]
    for part in ("end-a-keeper", "carrier", "cover"):  # each is parted by its opening
        assert faces.count(part) == 2, part
    assert faces.count("end-b-keeper") == 1


@pytest.mark.parametrize("design", designs(), ids=lambda design: design.name)
def test_every_part_has_its_row_and_what_is_seen_its_balloon(design: Design) -> None:
    job = Job(design)
    drawing, sheet = assembly_drawing(job), assembly_sheet(assembly_drawing(job), "0", "")
    rows = {str(n): item.what for n, item in enumerate(parts_list(job), 1)}
    (table,) = drawing.tables
    assert {row[2] for row in table.rows} >= {part.name for part in job.closed.parts if part.made == "made"}
    assert all(rows[row[0]] == row[2] for row in table.rows)
    rings = [m.stroke for m in sheet.marks if isinstance(m, Ink) and isinstance(m.stroke, Arc)]
    circles = [ring for ring in rings if ring.radius == BALLOON]
    cut = {face.item for face in drawing.faces if face.item}
    assert len(circles) == len(cut) + len(drawing.balloons)
    assert {rows[item] for item in cut} >= {"cover", "carrier"}
    wide, tall = sheet.size
    for mark in sheet.marks:
        if isinstance(mark, Words):
            left, low, right, high = mark.box()
            assert left >= 20.0, mark
            assert low >= 8.0, mark
            assert right <= wide - 10.0, mark
            assert high <= tall - 10.0, mark
    centres = [ring.centre for ring in circles]
    apart = [shapely.Point(a).distance(shapely.Point(b)) for i, a in enumerate(centres) for b in centres[:i]]
    assert min(apart) > 2 * BALLOON


def test_it_is_read_as_pdf_and_as_dxf(tmp_path: Path) -> None:
    sheet = assembly_sheet(assembly_drawing(Job(skincad.load("yamada-2002"))), "0", "")
    write_sheet_pdf(sheet, tmp_path / "a.pdf")
    write_sheet_dxf(sheet, tmp_path / "a.dxf")
    words = pypdf.PdfReader(tmp_path / "a.pdf").pages[0].extract_text()
    for text in ("section A-A", "assembly drawing", "ISO 8734 2 x 8", "end-b-keeper", "brass CW614N"):
        assert text in words
    assert not ezdxf.readfile(tmp_path / "a.dxf").audit().errors
