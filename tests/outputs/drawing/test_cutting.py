"""What a DXF says to cut, as other libraries read it: strips, sections of parts, seals; the strips' board."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import islice, pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cadquery as cq
import dxf_parser
import ezdxf
import numpy as np
import pytest
import shapely
from shapely.affinity import translate

import skincad
from bench.campaign.random_designs import drawn
from skincad.fabrication import GLUED_LENGTH, HOLE, SHOULDER, Job, electrode_findings, shim_patterns
from skincad.fabrication.part_drawing import part_drawing
from skincad.inputs import Design, processes, template_names
from skincad.outputs import write_shims_dxf, write_step
from skincad.outputs.drawing import flat, formats, marks
from skincad.outputs.drawing.part_sheet import part_sheet
from skincad.shape import Point, Segment, area, polygon, section
from skincad.solids import (
    STUB,
    Part,
    PartRole,
    Prism,
    RotatedBody,
    plain,
    scaled_for_shrinkage,
    unturned,
    workplane,
)
from skincad.solids.mold import mold
from tests.conftest import Made
from tests.designs import RIDGED, SHIPPED, template, three_ridges

PITCH = 2.54  # mm, of pins
LEAD = 36.0  # mm, of yamada-2002: 17 tabs of 2.54, less the slots, aside by 30 degrees
FILMS = [template(name) for name in template_names() if skincad.load(name).film]
SIDES = pytest.mark.parametrize("side", ["a", "b"])
SVG = "{http://www.w3.org/2000/svg}"
ROUND = 1e-9  # mm2, sixteen digits of places below 100 mm: a sliver of 1e-14 mm along a lead of 100
Loops = dict[str, list[tuple[Segment, ...]]]


def dxf_loops(path: Path) -> Loops:
    loops: Loops = {}
    for line in ezdxf.readfile(path).modelspace().query("LWPOLYLINE"):
        corners = [(Point(x, y), bulge) for x, y, bulge in line.get_points("xyb")]
        following = corners[1:] + corners[:1]
        ring = tuple(Segment(a, b, bulge) for (a, bulge), (b, _) in zip(corners, following, strict=True))
        loops.setdefault(line.dxf.layer, []).append(ring)
    return loops


@cache
def pattern(name: str, side: str = "b") -> Loops:
    """The closed lines of a template's pattern, wired at this end."""
    design = skincad.load(name, [f'film.wiring_side="{side}"'])
    with TemporaryDirectory() as folder:
        path = Path(folder) / "strips.dxf"
        flat.write_strips_dxf(Job(design), path)
        assert all(line.closed for line in ezdxf.readfile(path).modelspace().query("LWPOLYLINE"))
        return dxf_loops(path)


def read(design: Design, folder: Path) -> dict[str, list[shapely.Polygon]]:
    """The closed outlines by layer, one strip after the other; a rounded corner as its chord."""
    flat.write_strips_dxf(Job(design), folder / "strips.dxf")
    drawing = dxf_parser.parse((folder / "strips.dxf").read_text(encoding="utf-8"))
    layers = defaultdict(list)
    for entity in (e for e in drawing["entities"] if e["type"] == "LWPOLYLINE"):
        if len(entity["vertices"]) > 2:  # a hole is two half circles
            layers[entity["layer"]].append(shapely.Polygon([(v["x"], v["y"]) for v in entity["vertices"]]))
    return layers


def skins(design: Design) -> list[shapely.Polygon]:
    """What of each strip's row lies in the skin: its length, or its arc, as it is poured."""
    whole, radius = scaled_for_shrinkage(design) if design.mold.method == "cast-in" else design, 1e99
    radius = design.skin.curvature_radius_y or radius
    halves = [
        whole.skin.length / 2 * (1 + (slot.centre.z - design.skin.thickness) / radius)
        for slot in section(whole).slots
    ]
    return [shapely.box(-half, -1e4, half, 1e4) for half in halves]


def metal_in_the_skin_alone(design: Design, folder: Path) -> None:
    """Overlap outside the skin is none, even with both faces off by the registration; and each has a pad."""
    layers, film = read(design, folder), design.film
    assert film is not None
    assert len(layers["FRONT"]) == len(layers["BACK"]) == len(layers["CUT"]) == 2 * design.ridge.count
    off = 0.0 if any(f.rule == "lead width" for f in electrode_findings(Job(design))) else film.registration
    rows = zip(layers["CUT"], layers["FRONT"], layers["BACK"], skins(design), strict=True)
    for cut, front, back, skin in rows:
        assert front.is_valid
        assert back.is_valid
        assert front.intersection(back).difference(skin).area < ROUND
        assert front.difference(cut).area < ROUND
        assert back.difference(cut).area < ROUND
        moved = translate(front, 0.0, -off), translate(back, 0.0, off)
        assert moved[0].intersection(moved[1]).difference(skin).area < ROUND
        # a pad each, 1.5 mm wide at least, and beside it bare film on the other face
        for metal, other in ((front, back), (back, front)):
            pad = (
                metal.difference(skin.buffer(Job(design).lead))
                .buffer(-0.749)
                .buffer(0.749, join_style="mitre")
            )
            assert pad.area >= 4.5 - ROUND
            assert pad.distance(other) > 0.0


@SIDES
@pytest.mark.parametrize("name", FILMS)
def test_both_faces_have_metal_in_the_skin_alone(name: str, side: str, tmp_path: Path) -> None:
    metal_in_the_skin_alone(skincad.load(name, [f'film.wiring_side="{side}"']), tmp_path)


def test_a_doubly_curved_skins_strips_too(tmp_path: Path) -> None:
    metal_in_the_skin_alone(skincad.load("yamada-2002", ["skin.curvature_radius_y=200"]), tmp_path)


@pytest.mark.evidence(subject="seeds: strips")
def test_sixty_random_designs_strips_too(tmp_path: Path) -> None:
    designs = (drawn(seed).design for seed in range(1000))
    with_film = list(islice((design for design in designs if design.film), 60))
    assert len(with_film) == 60
    for design in with_film:
        metal_in_the_skin_alone(design, tmp_path)


@SIDES
@pytest.mark.parametrize("name", FILMS)
def test_metal_keeps_its_margin_and_strips_lie_apart(name: str, side: str) -> None:
    """Where both faces have metal; a lead alone goes up to its own edge, and the other face is bare there."""
    loops = pattern(name, side)
    cuts = [shapely.Polygon(polygon(loop, 1e-4)) for loop in loops["CUT"] if len(loop) > 2]
    assert all(a.distance(b) > 1.9 for a, b in pairwise(cuts))
    margin = skincad.load(name).film.margin
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


@pytest.mark.parametrize("name", FILMS)
def test_number_and_sign_are_on_what_is_not_cut_off(name: str, tmp_path: Path) -> None:
    """And off the leads, which an engraved mark could cut; a letter is at most 0.8 of its height wide."""
    layers = read(skincad.load(name), tmp_path)
    drawing = dxf_parser.parse((tmp_path / "strips.dxf").read_text(encoding="utf-8"))
    texts = [e for e in drawing["entities"] if e["type"] == "TEXT" and e["layer"] == "ENGRAVE"]
    cuts = [e for e in drawing["entities"] if e["type"] == "LINE" and e["layer"] == "MARK"]
    words = [t for t in texts if t["text"] == "+" or t["text"].endswith(("S1", "S2"))]
    assert len(words) == len(texts) == 2 * len(layers["CUT"])  # nothing else is engraved
    ends = {line["vertices"][0]["x"] for line in cuts}
    for word in words:
        x, y = word["startPoint"]["x"], word["startPoint"]["y"]
        box = shapely.box(x, y, x + 0.8 * len(word["text"]) * word["textHeight"], y + word["textHeight"])
        assert any(tab.contains(box) for tab in layers["CUT"])
        assert not any(box.intersects(metal) for metal in (*layers["FRONT"], *layers["BACK"]))
        assert max(end for end in ends if end < 0) < x  # the leads are at end b
        assert box.bounds[2] < min((end for end in ends if end > 0), default=math.inf)


@pytest.mark.slow
def test_layers_of_strips_have_their_colours(made: Made) -> None:
    colours = {"CUT": 1, "ENGRAVE": 2, "FRONT": 3, "BACK": 4, "MARK": 5, "DIMENSIONS": 6}
    drawing = ezdxf.readfile(made.folder / "film/strips.dxf")
    assert {entity.dxf.layer for entity in drawing.modelspace()} == {*colours, "TEXT"}
    read_by_another = dxf_parser.parse((made.folder / "film/strips.dxf").read_text(encoding="utf-8"))
    layers = read_by_another["tables"]["layer"]["layers"]
    assert {name: layers[name]["colorIndex"] for name in colours} == colours


@SIDES
def test_a_strip_that_is_cast_in_has_its_area_by_formula(side: str) -> None:
    loops = pattern("cast-in", side)
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


def test_a_strip_behind_a_shim_has_its_area_by_formula() -> None:
    """Straight, one shoulder, and the tab: label, pads, bare film round them and the cut corner."""
    loops = pattern("yamada-2002")
    assert len(loops["CUT"]) == 18
    shoulder = 0.25 * SHOULDER + 2 * (1 - math.pi / 4) * SHOULDER**2
    tab = (4.5 + 0.5 + 3.0 + 0.5 + 1.0) * 5.04 - 1.0**2 / 2
    assert area(loops["CUT"][0]) == pytest.approx(
        0.25 * (12 + LEAD + GLUED_LENGTH) + shoulder + tab, rel=1e-9
    )


@SIDES
def test_a_drawn_in_strips_tail_is_at_its_unwired_end(side: str) -> None:
    """Its contact never goes through the slot; the mark at which the tail is cut is the skin's end."""
    cut = pattern("yamada-2002", side)["CUT"][0]
    ends = sorted(abs(f(p.start.x for p in cut)) for f in (min, max))
    assert ends == pytest.approx([6.0 + GLUED_LENGTH, 6.0 + LEAD + 10.0])  # lead and tab
    assert (max(p.start.x for p in cut) > 12.0) == (side == "b")


def test_the_corner_that_tells_the_sides_is_at_the_wiring_end_and_the_ridges() -> None:
    """Ridges are below in the drawing. The tab's corner, not that of the piece beyond for a weight."""
    for side, sign in (("a", -1), ("b", 1)):
        loop = pattern("cast-in", side)["CUT"][0]
        corners = {(round(s.start.x, 6), round(s.start.z, 6)) for s in loop}
        high, foot = max(z for _, z in corners), min(z for _, z in corners)
        far = max(sign * x for x, z in corners if z == high)
        assert (round(sign * far, 6), foot) not in corners
        assert (round(sign * (far - 1.0), 6), foot) in corners
        assert (round(sign * far, 6), round(foot + 1.0, 6)) in corners


@SIDES
def test_a_hooks_hole_is_its_radius_from_its_tabs_end(side: str) -> None:
    """The film that bears the weight is as wide all round, or wider: at the wiring end the piece for a weight
    is 3.04 mm wide, and its tab is wider."""
    loops = pattern("cast-in", side)["CUT"]
    tabs = [shapely.Polygon(polygon(loop, 1e-5)).bounds for loop in loops if len(loop) > 2]
    holes = [shapely.Polygon(polygon(loop, 1e-5)).bounds for loop in loops if len(loop) == 2]
    low, low_z, high, high_z = tabs[0]
    first, last = sorted(h for h in holes if low_z < h[1] < high_z)
    assert (first[0] - low, high - last[2]) == pytest.approx((HOLE, HOLE), abs=1e-4)
    whole = shapely.Polygon(polygon(next(loop for loop in loops if len(loop) > 2), 1e-5))
    for hole in (first, last):
        beside = whole.exterior.distance(shapely.box(*hole).centroid)
        assert 2 * HOLE - 1e-4 < beside < 2 * HOLE + 0.03


@pytest.mark.slow
def test_strips_svg_draws_the_same_pattern(made: Made) -> None:
    root = ET.parse(made.folder / "film/strips.svg").getroot()
    groups = {group.attrib["id"]: group for group in root.findall(f"{SVG}g")}
    paths = {name: len(group.findall(f"{SVG}path")) for name, group in groups.items() if name != "DIMENSIONS"}
    assert {name: n for name, n in paths.items() if n} == dict.fromkeys(("CUT", "FRONT", "BACK"), 18)
    assert len(groups["MARK"].findall(f"{SVG}polyline")) == 18
    left, top, wide, high = map(float, root.attrib["viewBox"].split())
    assert root.attrib["width"] == f"{wide / flat.STRIPS:g}mm"
    texts = [text for name in ("ENGRAVE", "TEXT") for text in groups[name].findall(f"{SVG}text")]
    for text in texts:
        assert left < float(text.attrib["x"]) < left + wide
        assert top < float(text.attrib["y"]) < top + high
    words = [text.text or "" for text in texts]
    assert "9 S2" in words
    assert any("+ side, which faces +x" in text for text in words)
    assert any("draw axis (d31) along the strips" in text for text in words)


def test_the_longest_note_fits_on_the_strips_drawing(yamada: Design) -> None:
    """It is far longer than a strip; letters are half as wide as high, and up to 0.7 times."""
    short = yamada.with_(film={"lead": 8.0})
    root = ET.fromstring(flat.strips_svg(Job(short)))
    left, _, wide, _ = map(float, root.attrib["viewBox"].split())
    begin, letters = max(
        (float(t.attrib["x"]), len(t.text or "") * float(t.attrib["style"][len("font-size:") : -len("px")]))
        for t in root.iter(f"{SVG}text")
        if len(t.text or "") > 60
    )
    assert begin + 0.5 * letters < left + wide < begin + 0.7 * letters


def bracketed(text: str) -> list[Any]:
    """A text of brackets as lists of words."""
    stack: list[list[Any]] = [[]]
    for token in re.findall(r'"[^"]*"|[()]|[^\s()]+', text):
        if token == "(":
            stack.append([])
        elif token == ")":
            expression = stack.pop()
            stack[-1].append(expression)
        else:
            stack[-1].append(token.strip('"'))
    (whole,) = stack[0]
    return whole


def pads(text: str) -> dict[str, tuple[float, float]]:
    rows = [row for row in bracketed(text) if row[0] == "pad"]
    assert all(row[2:4] == ["thru_hole", "circle"] for row in rows)
    assert all(["drill", "1"] in row for row in rows)
    places = {row[1]: (float(row[4][1]), float(row[4][2])) for row in rows}
    assert len(places) == len(rows)  # no name twice
    return places


@pytest.mark.parametrize("name", FILMS)
def test_on_the_board_each_strip_has_a_pin_for_each_face_in_its_own_column(name: str) -> None:
    design = skincad.load(name)
    text = flat.strip_board(Job(design))
    places = pads(text)
    labels = [f"{ridge}{side}" for ridge in range(1, design.ridge.count + 1) for side in ("S1", "S2")]
    assert set(places) == {f"{label}{sign}" for label in labels for sign in "+-"}
    for i, label in enumerate(labels):  # places have four decimals
        assert places[f"{label}+"][0] - places["1S1+"][0] == pytest.approx(PITCH * i, abs=2e-4)
        assert places[f"{label}-"][0] == places[f"{label}+"][0]
        assert places[f"{label}-"][1] - places[f"{label}+"][1] == pytest.approx(PITCH, abs=2e-4)  # y is down
    assert sum(x for x, _ in places.values()) == pytest.approx(0.0, abs=1e-3)
    (yard,) = (row for row in bracketed(text) if row[0] == "fp_rect")
    assert float(yard[2][1]) - max(x for x, _ in places.values()) == pytest.approx(
        flat.FOOTPRINT_ROOM, abs=2e-4
    )


def test_a_board_at_end_a_is_the_other_way_round_and_without_film_there_is_none() -> None:
    b, a = (pads(flat.strip_board(Job(skincad.load("cast-in", [f'film.wiring_side="{s}"'])))) for s in "ba")
    assert b["1S1+"][0] < b["9S2+"][0]
    assert {name: (-x, y) for name, (x, y) in a.items()} == b
    with pytest.raises(ValueError, match="without film"):
        flat.strip_board(Job(skincad.load("plain-ridges")))


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
    sheet = part_sheet(part_drawing(Job(design), part, workplane(part).val(), None), "")
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


def test_arcs_laid_flat_have_the_area_of_the_shims_in_the_mold() -> None:
    """A shim is a part of a cone of even thickness, so its volume is the flat area times that."""
    design = three_ridges()
    closed = mold(design)
    flat = [area(shim.cut) * design.slot.thickness for shim in shim_patterns(Job(design, closed))]
    assert flat == pytest.approx([part.volume for part in closed.of(PartRole.SHIM)], rel=1e-12)


@pytest.mark.parametrize("name", SHIPPED)
def test_bars_are_the_shims_of_one_skin_in_whole_millimetres(name: str) -> None:
    design = skincad.load(name)
    closed = mold(design)
    patterns, parts = shim_patterns(Job(design, closed)), closed.of(PartRole.SHIM)
    assert len(patterns) * design.mold.cavities == len(parts)
    for shim, part in zip(patterns, parts, strict=False):
        long = area(shim.cut) / design.slot.depth
        assert long == pytest.approx(round(long), abs=1e-9)
        true = part.volume / design.slot.depth / design.slot.thickness
        assert true - 1e-9 <= long < true + 1
        assert shim.thinned is None  # the end plates come off before the film is drawn in


@pytest.mark.parametrize("name", ["yamada-2002", "bent"])
def test_no_shim_lies_on_another_and_a_thin_tail_is_marked(name: str, tmp_path: Path) -> None:
    design = three_ridges() if name == "bent" else skincad.load(name)
    closed = mold(design)
    shims = shim_patterns(Job(design, closed))
    shapes = [shapely.Polygon(polygon(shim.cut, 1e-4)) for shim in shims]
    assert all(a.distance(b) > 1.0 for a, b in pairwise(shapes))
    for shim, shape in zip(shims, shapes, strict=True):
        if shim.thinned:
            a, b = shim.thinned
            assert math.dist(a, b) == pytest.approx(design.slot.depth)
            assert shapely.LineString([a, b]).distance(shape) < 1e-3
    write_shims_dxf(Job(design, closed), tmp_path / "shims.dxf")
    read = dxf_parser.parse((tmp_path / "shims.dxf").read_text(encoding="utf-8"))
    kinds = [e["type"] for e in read["entities"] if e["layer"] == "CUT"]
    assert kinds == ["LWPOLYLINE"] * len(shims)
    texts = [(e["layer"], e["text"]) for e in read["entities"] if e["type"] == "TEXT"]
    assert [text for layer, text in texts if layer == "ENGRAVE"] == [shim.label for shim in shims]
    assert "kerf not compensated" in next(text for layer, text in texts if layer == "TEXT")


def test_strips_that_are_cast_in_have_no_shims() -> None:
    design = skincad.load("cast-in")
    assert shim_patterns(Job(design)) == []
