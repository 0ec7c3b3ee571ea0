"""Print meshes against the CAD kernel's tessellation, and their volumes in common."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
import trimesh
from manifold3d import Manifold, OpType

from skincad.fabrication import (
    Finding,
    Job,
    casting_sheet,
    design_findings,
    filling_findings,
    interference,
    laid,
    manifold,
    measure,
    mesh,
    pattern_notes,
    poured_volume,
    print_chord,
    strip_patterns,
)
from skincad.fabrication.inspection import inspection
from skincad.fabrication.patterns import arc_radius
from skincad.fabrication.strips import shim_bend
from skincad.inputs import Design
from skincad.outputs import PAGE
from skincad.outputs.drawing.overview import drawing
from skincad.shape import rectangle
from skincad.solids import (
    ClosedMold,
    CutRole,
    ExtendedCut,
    Grid,
    Part,
    PartRole,
    Prism,
    RevolvedBody,
    RotatedBody,
    box,
    solid,
)
from skincad.solids.mold import mold
from tests.bent_skin import bent, three_ridges
from tests.conftest import make_into
from tests.solids.test_doubly_curved_mold import level_crowned

FINE = 2e-4  # mm, the kernel's own chord tolerance for the reference


def kernel_mesh(part) -> trimesh.Trimesh:
    corners, faces = solid(part).tessellate(FINE, 0.1)
    return trimesh.Trimesh(np.array([c.toTuple() for c in corners]), np.array(faces), process=False)


def hausdorff(one: trimesh.Trimesh, two: trimesh.Trimesh) -> float:
    pair = pymeshlab.MeshSet(verbose=False)
    for shape in (one, two):
        pair.add_mesh(pymeshlab.Mesh(np.asarray(shape.vertices), np.asarray(shape.faces, dtype=np.int32)))
    ways = [
        pair.get_hausdorff_distance(sampledmesh=a, targetmesh=b, samplenum=20000, sampleedge=True)["max"]
        for a, b in ((0, 1), (1, 0))
    ]
    return max(ways)


@pytest.mark.parametrize("name", ["skin", "cavity", "end-a-comb", "end-b-keeper", "carrier", "cover"])
def test_mesh_is_within_its_tolerance_of_the_kernels_solid(yamada: Design, name: str) -> None:
    part = mold(yamada).part(name)
    tolerance = 2e-3
    shape = mesh(part, tolerance)
    assert hausdorff(shape, kernel_mesh(part)) <= tolerance + FINE


def test_stated_deviation_is_that_of_the_mesh_not_the_asked_one(yamada: Design) -> None:
    part = mold(yamada).part("cavity")
    coarse = mesh(part, 0.02)
    seen = measure(part, coarse, 0.002)  # judged against a reference made for a finer mesh
    assert 0.01 < seen.deviation <= 0.02 + 2e-4
    assert seen.watertight
    assert seen.self_intersections == 0


@pytest.mark.parametrize(
    "seed", [127, *(pytest.param(i, marks=pytest.mark.slow) for i in (101, 106, 145, 170, 188))]
)
def test_faces_in_one_plane_but_for_rounding_do_not_cross(seed: int) -> None:
    """In these carriers, nearly flat along y, the library takes a few facets for crossing."""
    design, closed = level_crowned(seed)
    part, chord = closed.part("carrier"), print_chord(design)
    shape = mesh(part, chord)
    assert measure(part, shape, chord).self_intersections == 0
    shape.vertices[np.argmin(shape.vertices[:, 2])] += [0.1, 0.2, 40.0]  # up through the top
    assert measure(part, shape, chord).self_intersections > 0


def test_self_intersections_are_seen(yamada: Design) -> None:
    part = mold(yamada).part("cover")
    torn = mesh(part, 0.01)
    torn.vertices[0] += [30.0, 0.0, 10.0]  # one corner pulled through the far side
    assert measure(part, torn, 0.01).self_intersections > 0


def test_laid_parts_stand_on_the_bed_with_the_same_volume(yamada: Design) -> None:
    part = mold(yamada).part("end-a-comb")
    shape = mesh(part, 0.01)
    flat = laid(shape, on_end=True)
    assert flat.bounds[0][2] == 0.0
    assert flat.volume == pytest.approx(shape.volume, rel=1e-12)
    assert flat.extents[2] == pytest.approx(yamada.mold.end_plate, abs=1e-9)


@pytest.fixture(scope="module")
def design() -> Design:
    return three_ridges()


@pytest.fixture(scope="module")
def closed(design: Design) -> ClosedMold:
    return mold(design)


def by_rule(findings: list[Finding]) -> dict[str, Finding]:
    return {finding.rule: finding for finding in findings}


@pytest.mark.parametrize("asked", [0.02, 0.003])
def test_meshes_are_closed_free_and_as_near_as_asked(closed: ClosedMold, asked: float) -> None:
    for part in closed.parts:
        if part.made == "made" or part.name == "skin":
            seen = measure(part, mesh(part, asked), asked)
            assert seen.watertight, part.name
            assert seen.self_intersections == 0, part.name
            assert seen.deviation <= 1.1 * asked, part.name  # a tenth is the reference mesh's own


@pytest.mark.parametrize("name", ["cavity", "carrier", "end-b-comb"])
def test_a_torn_mesh_is_seen(closed: ClosedMold, name: str) -> None:
    part = closed.part(name)
    torn = mesh(part, 0.02)
    torn.vertices[len(torn.vertices) // 2] += [5.0, 1.0, 3.0]
    assert measure(part, torn, 0.02).self_intersections > 0


def test_parts_that_turn_share_their_facets(closed: ClosedMold) -> None:
    """Skin, shims, cavity and carrier touch along arcs; at any chord length their meshes share nothing."""
    for chord in (0.02, 0.003):
        names = ("skin", "cavity", "carrier", "shim-1-S1")
        shapes = {name: manifold(closed.part(name), chord) for name in names}
        for a, b in (("skin", "cavity"), ("skin", "carrier"), ("cavity", "carrier")):
            assert (shapes[a] ^ shapes[b]).volume() < 1e-9, (a, b, chord)
        assert (shapes["skin"] ^ shapes["shim-1-S1"]).volume() < 1e-9
        # nor is there a gap: what is set lower by 1 um meets 11 mm x about 9.6 mm of back
        overlap = shapes["carrier"].translate((0.0, 0.0, -1e-3)) ^ shapes["skin"]
        assert overlap.volume() == pytest.approx(1e-3 * 11 * 9.6, rel=0.1)


def test_two_turned_bodies_share_what_their_sections_do(closed: ClosedMold) -> None:
    skin, shim = closed.part("skin"), closed.part("shim-1-S1")
    assert isinstance(skin.body, RevolvedBody)
    whole = Part("whole", PartRole.SKIN, skin.body.__class__(skin.body.outline, *_turn(skin.body)))
    (finding,) = interference(ClosedMold((whole, shim), ()), 1e-3)
    slot = 0.05 * 0.25 * 12.0 * (1 + 0.1 / 25)  # the slot's middle lies 0.1 mm farther from the axis
    assert finding.measured == pytest.approx(slot, rel=0.01)  # shrinkage
    assert interference(ClosedMold((skin, shim), ()), 1e-3) == []


def _turn(body: RevolvedBody) -> tuple[float, float, float]:
    return body.centre, body.low, body.high


def test_end_plates_are_laid_flat_and_a_block_on_its_leaning_end(closed: ClosedMold) -> None:
    for name in ("end-a-comb", "end-b-keeper"):
        part = closed.part(name)
        assert isinstance(part.body, RotatedBody)
        shape = laid(mesh(part, 0.01), True, part)
        assert shape.bounds[0][2] == 0.0
        assert shape.bounds[1][2] == pytest.approx(4.0, abs=1e-9)  # mold.end_plate
    for end in (False, True):
        shape = laid(mesh(closed.part("cavity"), 0.01), end, closed.part("cavity"))
        down = np.asarray(shape.face_normals)[:, 2] < -1 + 1e-9
        on_bed = np.asarray(shape.triangles)[:, :, 2].max(axis=1) < 1e-9
        assert shape.area_faces[down & on_bed].sum() > 200.0  # mm2: it stands


def test_findings_say_what_is_special_and_no_more(design: Design, closed: ClosedMold) -> None:
    straight = design_findings(Job(design.with_(skin={"curvature_radius_y": None})))
    findings = design_findings(Job(design, closed))
    room = next(f for f in findings if f.rule == "notch room")
    wire = next(f for f in findings if "bent along y" in f.where)
    tap = next(f for f in findings if f.rule == "thread run-out")  # its ends' screws meet in 12 mm
    assert [f.rule for f in findings if f not in (room, wire, tap)] == [f.rule for f in straight]
    assert (wire.rule, wire.severity, wire.unit) == ("tool reach", "warning", "deg end to end")
    assert wire.measured == pytest.approx(math.degrees(12 / 25), rel=1e-6)
    assert (room.rule, room.severity) == ("notch room", "note")
    assert room.measured == pytest.approx(16 / (2 * 25), rel=0.02)  # thickness^2 / 2 R
    milled = design.with_(mold={"process": "cnc", "end_plate_process": "edm"})
    assert not any("bent along y" in f.where for f in design_findings(Job(milled)))


def test_a_deep_shim_would_stay_bent(design: Design) -> None:
    assert shim_bend(Job(design)) == pytest.approx(0.125 / 25, rel=1e-12)
    assert "shim bend" not in by_rule(design_findings(Job(design)))
    deep = design.with_(slot={"depth": 0.4})
    note = by_rule(design_findings(Job(deep)))["shim bend"]
    assert (note.severity, note.measured) == ("note", pytest.approx(0.2 / 25, rel=1e-12))


def test_an_end_that_is_high_too_is_told_until_the_tilt_is_beyond_its_slope(design: Design) -> None:
    (note,) = filling_findings(Job(design))
    assert (note.severity, note.unit) == ("note", "deg")
    assert note.limit == pytest.approx(math.degrees(6 / 25), rel=1e-6)
    steep = design.with_(mold={"pour_tilt": 15.0})
    assert filling_findings(Job(steep)) == []


def test_poured_volume_is_what_the_closed_molds_parts_leave() -> None:
    """A block less all parts, as booleans: the piece that holds the middle of the skin. A lid keeps the cup
    shut, a slab outside end plate a the gate."""
    design = bent("plain-ridges", 25.0).with_(mold={"floor": 9.0})  # deeper, films of rounding join to a leak
    closed = mold(design)
    plate = closed.part("end-a").body
    assert isinstance(plate, RotatedBody)
    assert isinstance(plate.body, Prism)
    slab = replace(plate, body=replace(plate.body, low=plate.body.low - 1.0, high=plate.body.low))
    rest = Manifold.cube((80.0, 80.0, 80.0), True)
    rest = rest.trim_by_plane((0.0, 0.0, -1.0), -manifold(closed.part("cover"), 2e-3).bounding_box()[5])
    parts = [*(_filled(part) for part in closed.parts if part.name != "skin")]
    parts.append(Part("slab", PartRole.COVER, slab))
    rest -= Manifold.batch_boolean([manifold(part, 2e-3) for part in parts], OpType.Add)
    ball = Manifold.sphere(0.3).translate((0.0, 0.0, -2.0))
    (void,) = (piece for piece in rest.decompose() if (piece ^ ball).volume() > 0)
    assert poured_volume(Job(design, closed)) == pytest.approx(void.volume(), rel=2e-3)  # chords


def _filled(part: Part) -> Part:
    """A part without its threads and bolt holes: films of rounding on the leaning faces would join them."""
    if part.name == "cavity":
        return replace(part, cuts=part.cuts[:2])
    if part.name.startswith("end-"):
        gates = [c for c in part.cuts if c.role is CutRole.GATE]
        bevels = [c for c in part.cuts if c.role is CutRole.BEVEL]
        return replace(part, cuts=(*gates, *bevels))
    return part


def test_the_sheet_says_screws_arcs_and_the_order(design: Design, closed: ClosedMold) -> None:
    text = casting_sheet(Job(design, closed), [], "Passes.", True)
    assert "M3 screws, ISO 4762: 8 M3 x 8 for the end plates" in text
    assert "bottoming tap at last, 2 washers under each head" in text  # a plate of 4 and a hole of 4.5
    assert "cut or etched as arcs" in text
    order = [
        "Screw both combs",
        "Lay the carrier",
        "Then the keepers",
        "Then the foam, cover and bolts",
        "along its arc",
    ]
    order += ["Take the cover's bolts out", "Take the end plates' screws out", "Pull the carrier up"]
    places = [text.index(words) for words in order]
    assert places == sorted(places)
    plain = bent("plain-ridges", 25.0)
    assert "shim" not in casting_sheet(Job(plain), [], "Passes.", True)


def test_a_shims_flat_radius_is_its_cones(design: Design) -> None:
    """An upright slot of the middle ridge lies in a plane; a leaning one on a cone, whose arc is flatter."""
    upright = arc_radius(Job(design), 2, "S1")
    assert upright == pytest.approx(25.0 * 1.001 + 0.1 + 0.025, abs=0.12)  # elevation and half the depth
    tilted = arc_radius(Job(design.with_(slot={"tilt": 45.0})), 2, "S1")
    assert tilted == pytest.approx(math.sqrt(2) * upright, rel=0.01)


def test_strips_are_as_long_as_their_arcs(design: Design) -> None:
    straight = design.with_(skin={"curvature_radius_y": None})
    long, short = ([_length(p) for p in strip_patterns(Job(d))] for d in (design, straight))
    for a, b in zip(long, short, strict=True):
        assert 0.0 < a - b < 12.0 * 0.5 / 25  # slots lie up to half a millimetre outside the summit's arc
    assert any("strain 0.5 %" in note for note in pattern_notes(Job(design)))
    assert not any("strain" in note for note in pattern_notes(Job(straight)))


def _length(pattern: object) -> float:
    xs = [s.start.x for s in pattern.overlap]  # type: ignore[attr-defined]
    return max(xs) - min(xs)


def test_the_drawing_and_the_list_know_the_second_radius(design: Design, closed: ClosedMold) -> None:
    text = drawing(design, closed)
    assert "R 25 along y" in text
    assert "ends lean by 13.8 degrees" in text
    root = ET.fromstring(text)
    for node in root.iter("{http://www.w3.org/2000/svg}polygon"):
        places = [tuple(map(float, corner.split(","))) for corner in node.attrib["points"].split()]
        assert all(0 <= x <= PAGE[0] and 0 <= y <= PAGE[1] for x, y in places)
    rows = {m.what: m for m in inspection(Job(design, closed)).measures}
    chord = rows["length of the back, straight from end to end"].nominal
    assert chord == pytest.approx(2 * 21 * math.sin(6 / 25), rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "radius"), [("yamada-2002", 60.0), ("plain-ridges", 25.0)])
def test_the_whole_job_runs(name: str, radius: float, tmp_path: Path) -> None:
    result = make_into(bent(name, radius), tmp_path / "out")
    assert result.result.passed
    assert all(p.valid and p.watertight and not p.self_intersections for p in result.parts)
    assert all(p.deviation <= p.asked_deviation for p in result.parts)
    assert {
        "solids/assembly.step",
        "solids/mold.3mf",
        "picture.png",
        "drawings/drawing.svg",
        "casting-sheet.md",
    } <= {file for file, _ in result.written.files}


def ring(
    low: float, high: float, z: tuple[float, float], centre: float = 30.0, **more: object
) -> RevolvedBody:
    return RevolvedBody(
        rectangle(-2.0, 2.0, *z), centre, low, high, grid=Grid(centre, 0.4, centre + 5), **more
    )


def shared(*bodies: RevolvedBody | Part) -> list[float]:
    """Volumes that parts share, mm3, of meshes of 0.1 mm."""
    parts = [
        body if isinstance(body, Part) else Part(f"part-{i}", PartRole.SHIM, body)
        for i, body in enumerate(bodies)
    ]
    return [finding.measured for finding in interference(ClosedMold(tuple(parts), ()), 0.1)]


@pytest.mark.parametrize("turned_over", [False, True])
def test_rings_share_what_their_sections_do_to_the_last_digit(turned_over: bool) -> None:
    """A ring's part: half the angle times the difference of the squares of its radii, times its width."""
    one, other = ring(-0.3, 0.2, (-3.0, 0.0)), ring(-0.1, 0.4, (-1.0, 2.0))
    expected = 0.3 * (31.0**2 - 30.0**2) / 2 * 4
    pair = (other, one) if turned_over else (one, other)
    assert shared(*pair) == pytest.approx([expected], rel=1e-9)  # coarse meshes would be 1e-3 off
    hollow = replace(other, holes=(rectangle(-1.0, 1.0, -0.5, 0.5),))
    less = 0.3 * (30.5**2 - 30.0**2) / 2 * 2
    assert shared(one, hollow) == pytest.approx([expected - less], rel=1e-9)
    assert shared(one, ring(0.2, 0.4, (-1.0, 2.0))) == []  # they meet at an angle
    assert shared(one, ring(-0.3, 0.2, (0.0, 2.0))) == []  # and along a slot
    assert shared(one, ring(-0.3, 0.2, (0.1, 2.0))) == []  # sections apart, boxes not
    assert shared(one, ring(0.25, 0.4, (-1.0, 2.0))) == []


def test_a_ring_in_anothers_cut_shares_nothing_and_beside_it_what_meshes_do() -> None:
    slot = ring(-0.3, 0.3, (-2.0, -1.0))
    cut = Part("cut", PartRole.SKIN, ring(-0.3, 0.3, (-3.0, 0.0)), (slot,))
    filled = replace(slot, outline=rectangle(-2.0, 2.0, -1.9, -1.1))
    assert shared(cut, filled) == []
    volume = 0.2 * (30.5**2 - 30.0**2) / 2 * 4
    beside = replace(slot, outline=rectangle(-2.0, 2.0, -0.5, 1.0), low=-0.1, high=0.1)
    assert shared(cut, beside) == pytest.approx([volume], rel=0.02)  # chords within 0.1 mm of 30 mm


def test_only_what_lies_all_in_a_cut_is_taken_as_clear() -> None:
    """What fills the cut touches it everywhere; a little longer or thicker it shares that little."""
    slot = ring(-0.3, 0.3, (-2.0, -1.0))
    outer = Part("outer", PartRole.SKIN, ring(-0.4, 0.4, (-3.0, 0.0)), (ExtendedCut(slot, slot),))
    assert shared(outer, slot) == shared(slot, outer) == []
    part = (32.0**2 - 31.0**2) / 2 * 4
    for low, high in ((-0.35, 0.3), (-0.3, 0.35), (-0.35, 0.35)):
        longer = replace(slot, low=low, high=high)
        assert shared(outer, longer) == pytest.approx([(high - low - 0.6) * part], rel=0.02)  # chords
    thicker = replace(slot, outline=rectangle(-2.0, 2.0, -2.0, -0.9))
    assert shared(thicker, outer) == pytest.approx([0.6 * (31.0**2 - 30.9**2) / 2 * 4], rel=0.02)
    block = Part("block", PartRole.COVER, box(1.0, (-2.0, 2.0), (-1.8, -0.5)))
    assert shared(outer, block)[0] == pytest.approx(2 * 4 * 0.5, rel=0.2)  # the cut's upper side is an arc
