"""What is on layer CUT of each DXF, as another library reads it, against the exact solids' STEP files."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cadquery as cq
import ezdxf
import numpy as np
import pytest

import skincad
from skincad.fabrication import Job
from skincad.fabrication.part_drawing import part_drawing
from skincad.inputs import Design, processes
from skincad.outputs import write_step
from skincad.outputs.drawing import flat, formats, marks
from skincad.outputs.drawing.part_sheet import part_sheet
from skincad.shape import area, section
from skincad.solids import Part, PartRole, Prism, RotatedBody, plain, unturned, workplane
from tests.bent_skin import three_ridges
from tests.families import RIDGED
from tests.outputs.drawing.test_strips import dxf_loops

NAMES = [
    pytest.param("yamada-2002", marks=pytest.mark.slow),
    *(pytest.param(n, marks=pytest.mark.evidence(subject=n)) for n in RIDGED if n != "yamada-2002"),
    pytest.param("bent", marks=pytest.mark.evidence(subject="doubly curved molds: cut layers")),
]
SAME = 1e-6  # relative: what is promised; found are 1e-7 at the cones' narrow ends, 1e-11 elsewhere
# Shares of a part's length: a conical hole is as drawn at its narrow end alone, 1e-6 of 4 mm from the face
PLANES = (0.5, 0.37, 0.63, 1e-6, 1 - 1e-6, 0.21, 0.79, 0.11, 0.89)
# Not prisms anywhere: a bevel across the whole plate; nuts' pockets from one face and notches to pry at from
# the other leave no plane without either. They are compared without their cuts across.
NEVER_WHOLE = {
    ("bent", "end-a-keeper"),
    ("bent", "end-b-keeper"),
    ("home-printer", "end-b-comb"),
    ("home-printer", "end-b-keeper"),
    ("plain-ridges", "end-b"),
}


def named(name: str) -> Design:
    return three_ridges() if name == "bent" else skincad.load(name)


def cut_area(path: Path) -> float:
    """The net area of a file's layer CUT: its largest outline less the others, mm2."""
    outline, *holes = sorted((area(loop) for loop in dxf_loops(path)["CUT"]), reverse=True)
    assert all(hole > 0 for hole in holes)
    return outline - math.fsum(holes)


def sections(part: Part, path: Path) -> Iterator[float]:
    """The areas of a STEP file's solid across its body's axis, plane after plane, mm2."""
    body = unturned(part).body
    assert isinstance(body, Prism)
    solid = cq.importers.importStep(str(path)).val()
    turn, shift = part.body.placement() if isinstance(part.body, RotatedBody) else (np.eye(3), np.zeros(3))
    way = np.eye(3)["xyz".index(body.axis)]
    for share in PLANES:
        at = turn @ (way * (body.low + share * (body.high - body.low))) + shift
        yield solid.intersect(cq.Face.makePlane(500.0, 500.0, tuple(at), tuple(turn @ way))).Area()


def without_cuts_across(part: Part) -> Part:
    axis = unturned(part).body.axis  # type: ignore[union-attr]
    return replace(part, cuts=tuple(cut for cut in part.cuts if plain(cut).axis == axis))  # type: ignore[union-attr]


def write_part(design: Design, part: Part, path: Path) -> None:
    sheet = part_sheet(part_drawing(Job(design), part, workplane(part).val(), None), "0", "")
    formats.write_sheet_dxf(sheet, path)


@pytest.mark.parametrize("name", NAMES)
def test_a_parts_cut_profile_is_its_steps_section(name: str, tmp_path: Path) -> None:
    design = named(name)
    for part in Job(design).closed.parts:
        if part.made != "made":
            continue
        write_part(design, part, tmp_path / "part.dxf")
        area = cut_area(tmp_path / "part.dxf")
        write_step(workplane(part), tmp_path / "part.step")
        matches = any(abs(a - area) < SAME * area for a in sections(part, tmp_path / "part.step"))
        assert matches == ((name, part.name) not in NEVER_WHOLE), part.name
        if not matches:
            write_step(workplane(without_cuts_across(part)), tmp_path / "part.step")
            whole = sections(part, tmp_path / "part.step")
            assert any(abs(a - area) < SAME * area for a in whole), part.name


def test_a_cut_profile_lies_on_its_view_and_is_told_with_its_wire(tmp_path: Path) -> None:
    """Each of its corners is an end of a visible edge, to what DXF's numbers hold."""
    design = skincad.load("yamada-2002")
    part = Job(design).closed.part("end-b-comb")
    write_part(design, part, tmp_path / "part.dxf")
    drawing = ezdxf.readfile(tmp_path / "part.dxf")
    lines = [e for e in drawing.modelspace().query("LINE") if e.dxf.layer == "OUTLINE"]
    ends = np.array([(*p.vec2,) for e in lines for p in (e.dxf.start, e.dxf.end)])
    outline = max(dxf_loops(tmp_path / "part.dxf")["CUT"], key=area)
    for segment in outline:
        away = np.hypot(*(ends - (segment.start.x, segment.start.z)).T)
        assert away.min() < 1e-6, segment
    answer = " ".join(text for _, text in drawing.header.custom_vars)
    process = processes(design.printer)["edm"]
    assert f"kerf not compensated: wire Ø{2 * process.tool_radius:g}" in answer
    assert f"path {process.tool_radius + process.spark_gap:g} beside it" in answer


def test_the_section_says_that_it_is_not_for_cutting(tmp_path: Path) -> None:
    """It is the skin, smaller than the trough by its silicone's shrinkage; no layer of it is CUT."""
    design = skincad.load("yamada-2002").with_(mold={"shrinkage": 0.02})
    flat.write_section_dxf(design, tmp_path / "section.dxf")
    drawing = ezdxf.readfile(tmp_path / "section.dxf")
    assert {e.dxf.layer for e in drawing.modelspace()} == {"OUTLINE", "SLOTS", "DIMENSIONS", "TEXT"}
    texts = [e.dxf.text for e in drawing.modelspace().query("TEXT")]
    assert "not for cutting" in texts[0]
    assert f"{1 / (1 - 0.02):.6g} times as large" in texts[1]
    assert [text for _, text in drawing.header.custom_vars] == texts
    (outline,) = dxf_loops(tmp_path / "section.dxf")["OUTLINE"]
    assert area(outline) == pytest.approx(area(section(design).outline), rel=1e-12)


@pytest.mark.parametrize("name", ["yamada-2002", "lab-bench"])
def test_the_seals_pattern_is_its_volume_by_its_height(name: str, tmp_path: Path) -> None:
    closed = Job(skincad.load(name)).closed
    flat.write_seal_dxf(closed, tmp_path / "seal.dxf")
    seal = closed.first(PartRole.SEAL)
    assert isinstance(seal.body, Prism)
    across = seal.volume / (seal.body.high - seal.body.low)
    assert cut_area(tmp_path / "seal.dxf") == pytest.approx(across, rel=1e-12)
    layers = {e.dxf.layer for e in ezdxf.readfile(tmp_path / "seal.dxf").modelspace()}
    assert layers == {"CUT", "DIMENSIONS", "TEXT"}


def test_no_two_layers_have_one_colour_and_red_is_what_cuts() -> None:
    colours = [layer.aci for layer in marks.LAYERS.values()]
    assert len(set(colours)) == len(colours)
    assert marks.LAYERS["CUT"].aci == 1
