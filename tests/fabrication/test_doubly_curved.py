"""Findings, sheets, filling and patterns of the mold of a skin that is curved along y too."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from manifold3d import Manifold, OpType

from skincad.fabrication import (
    Finding,
    Job,
    casting_sheet,
    design_findings,
    filling_findings,
    manifold,
    pattern_notes,
    poured_volume,
    strip_patterns,
)
from skincad.fabrication.inspection import inspection
from skincad.fabrication.patterns import arc_radius
from skincad.inputs import Design
from skincad.outputs.drawing.overview import drawing
from skincad.solids import ClosedMold, CutRole, Part, PartRole, Prism, RotatedBody
from skincad.solids.mold import mold
from tests.conftest import files_into
from tests.designs import bent, three_ridges


@pytest.fixture(scope="module")
def design() -> Design:
    return three_ridges()


@pytest.fixture(scope="module")
def closed(design: Design) -> ClosedMold:
    return mold(design)


def by_rule(findings: list[Finding]) -> dict[str, Finding]:
    return {finding.rule: finding for finding in findings}


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
        "Then screw the keepers on",
        "Then the foam, cover and bolts",
    ]
    order += ["along its arc", "Take the cover's bolts out", "Take the end plates' screws out"]
    order += ["Pull the carrier up"]
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
    xs = [s.start.x for s in pattern.overlap]
    return max(xs) - min(xs)


def test_the_drawing_and_the_list_know_the_second_radius(design: Design, closed: ClosedMold) -> None:
    text = drawing(design, closed)
    assert "R 25 along y" in text
    assert "ends lean by 13.8 degrees" in text
    rows = {m.what: m for m in inspection(Job(design, closed)).measures}
    chord = rows["length of the back, straight from end to end"].nominal
    assert chord == pytest.approx(2 * 21 * math.sin(6 / 25), rel=1e-12)


@pytest.mark.parametrize(
    ("name", "radius"),
    [
        pytest.param("yamada-2002", 60.0, marks=pytest.mark.slow),
        pytest.param("plain-ridges", 25.0, marks=pytest.mark.evidence(subject="plain-ridges")),
    ],
)
def test_the_whole_job_runs(name: str, radius: float, tmp_path: Path) -> None:
    design = bent(name, radius, "ridge.count=3", "skin.width=5", "contact.force=1.5")
    result = files_into(design, tmp_path / "out", ("step", "3mf", "png", "md"))
    assert result.result.passed
    assert all(p.valid and p.watertight and not p.self_intersections for p in result.parts)
    assert all(p.deviation <= p.asked_deviation for p in result.parts)
    written = {file for file, _ in result.written.files}
    assert {"solids/assembly.step", "solids/mold.3mf", "picture.png", "casting-sheet.md"} <= written
