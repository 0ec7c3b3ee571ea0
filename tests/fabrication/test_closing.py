"""The closed mold: its stack, screws, dowels and mount, and how it is opened.

How drawings, lists and sheets show screws and mounts is in tests/golden.
"""

from __future__ import annotations

import csv
import json
import math
from itertools import product

import pytest

import skincad
from skincad.fabrication import Job, casting_sheet, major, mount_of, opening_steps, parts_csv, sheet_steps
from skincad.fabrication.fasteners import cover_screws, dowels, end_screws, pin_length
from skincad.fabrication.findings import closing_findings
from skincad.fabrication.part_drawing import what_matters
from skincad.inputs import Design, processes
from skincad.solids import CAVITIES, END_PLATES, LENGTHS, PINS, SHEETS, CutRole, PartRole, bores
from skincad.solids.mold import mold
from tests.designs import IN_LINE, KINDS, MOUNTS, PLAIN, bent, mounted_design, of_one_printer, template


@pytest.mark.parametrize("name", KINDS)
def test_a_thin_cover_is_told_with_the_thickness_that_does(name: str) -> None:
    design = skincad.load(name)
    assert list(closing_findings(Job(design))) == []
    thin = design.with_(mold={"cover": 1.0})
    findings = list(closing_findings(Job(thin)))
    if findings:
        assert (findings[0].severity, findings[0].limit) == ("warning", 0.02)
        least = float(findings[0].remedy.split(" of ")[1].split(" mm")[0])
        assert list(closing_findings(Job(design.with_(mold={"cover": least})))) == []
    cover = mold(thin).part("cover").body
    assert cover.high - cover.low == 1.0  # kept, whatever its bow


def test_a_printed_cover_of_four_millimetres_over_a_wide_skin_bows() -> None:
    """Two screws held it, and nobody said that it gaped."""
    bow, pushed = closing_findings(Job(of_one_printer("nozzle-04", ["mold.cover=4.0"])))
    assert bow.rule == "cover bow"
    assert bow.measured > 0.2
    assert pushed.rule == "closing stack"  # six times as far by its own seal


def worst(design: skincad.Design) -> tuple[float, float, float]:
    """The seal's free thickness, and how high it is where carrier or keeper stand highest and lowest: by all
    ends of all tolerances, part by part, mm."""
    closed, known = mold(design), processes(design.printer)
    sealed = closed.part("seal").body
    sheet = (sealed.high - sealed.low) / 0.7
    choice = design.mold
    block, lids = known[choice.process].tolerance, known[choice.lid_process or choice.process].tolerance
    ends = known[choice.end_plate_process or choice.process].tolerance
    slide = max(choice.clearance, known[choice.end_plate_process or choice.process].clearance)
    carrier = [a * block + b * lids for a, b in product((-1, 1), repeat=2)]  # its ledge, its thickness
    keeper = [
        a * block + b * ends + c * ends + d * slide for a, b, c, d in product((-1, 1), repeat=4)
    ]  # pin holes, comb, keeper, and a comb that lies on one side of its pins
    ups = [*carrier, *keeper]
    high = sealed.high - sealed.low
    return sheet, high - max(ups), high - min(ups)


def assert_foam_is_squeezed(design: Design) -> None:
    """Between the cover and what it closes the worst stack squeezes a foam that is sold by a tenth at least,
    which holds 20 kPa, twice what the silicone has, and by half at most."""
    sheet, least, most = worst(design)
    assert any(abs(sheet - sold) < 1e-9 for sold in SHEETS)
    assert least >= 0.5 * sheet - 1e-9
    assert most <= 0.9 * sheet + 1e-9


@pytest.mark.parametrize("cavities", [1, 6])
@pytest.mark.parametrize("name", KINDS)
def test_the_worst_stack_neither_lifts_the_cover_nor_lets_the_carrier_float(name: str, cavities: int) -> None:
    """The cover lies on the walls alone."""
    if name == "steep-fingertip" and cavities > 1:
        return  # a split cavity has one skin
    design = skincad.load(name).with_(mold={"cavities": cavities})
    closed = mold(design)
    cover, lowest = closed.part("cover").body.low, closed.part("seal").body.low
    for part in closed.parts:
        if part.role in CAVITIES - {PartRole.BASE, PartRole.BETWEEN}:
            assert max(s.start.z for s in part.body.outline) == cover
        if part.role in END_PLATES and part.role is not PartRole.COMB:
            assert max(s.start.z for s in part.body.outline) == lowest
        if part.role is PartRole.CARRIER:
            assert part.body.high == lowest
    assert_foam_is_squeezed(design)
    assert [f for f in closing_findings(Job(design)) if f.rule == "closing stack"] == []


@pytest.mark.parametrize("radius", [30.0, 120.0])
@pytest.mark.parametrize(
    "name", [template(n) for n in ("plain-ridges", "yamada-2002", "nozzle-04", "milled-pad")]
)
def test_the_worst_stack_lifts_no_cover_of_a_doubly_curved_mold_either(name: str, radius: float) -> None:
    design = bent(name, radius)
    closed = mold(design)
    lowest = closed.part("seal").body.low
    assert max(s.start.z for s in closed.part("cavity").body.outline) == closed.part("cover").body.low
    assert max(s.start.z for s in closed.part("carrier").body.outline) == lowest
    assert_foam_is_squeezed(design)
    assert [f.rule for f in closing_findings(Job(design))] == ["thread run-out"] * (name == "yamada-2002")


def test_a_bowl_too_narrow_for_a_seal_says_to_lap_its_carrier() -> None:
    """At 25 mm the ends lean by 14 degrees: 1 mm of wall more and bolts and pins of the cover would meet."""
    narrow = bent("plain-ridges", 25.0)
    assert "seal" not in {part.name for part in mold(narrow).parts}
    (finding,) = closing_findings(Job(narrow))
    assert (finding.rule, finding.severity) == ("closing stack", "warning")
    # a ledge and a carrier of resin, and 0.05 mm of the pins: three tolerances, and the foam's own bow
    assert finding.measured > 0.15
    assert "lap the carrier's top" in finding.remedy


def test_threads_that_meet_in_a_short_skin_ask_for_a_bottoming_tap() -> None:
    design = bent("yamada-2002", 25.0)
    (finding,) = closing_findings(Job(design))
    hole = min(bore.length for bore in bores(mold(design).part("cavity"), CutRole.END_THREAD))
    # a screw of 8 mm with two washers of 0.5 in a plate of 4 leaves 3 of thread: by hand
    assert finding.measured == pytest.approx(hole - 3.0)
    assert (finding.limit, finding.severity) == (3.5, "note")
    assert list(closing_findings(Job(bent("yamada-2002", 60.0, "skin.length=24")))) == []


def test_a_process_too_coarse_for_any_seal_is_told() -> None:
    coarse = of_one_printer("nozzle-04", ["printer.fdm.tolerance=1.0"])
    (finding,) = (f for f in closing_findings(Job(coarse)) if f.rule == "closing stack")
    assert finding.measured > 3.2 > finding.limit == pytest.approx(2.4)


def test_the_foam_of_a_doubly_curved_mold_is_laid_in_and_lifted_off() -> None:
    few = skincad.load("plain-ridges", ["skin.curvature_radius_y=200", "ridge.count=3"])
    text = casting_sheet(Job(few), [], "", True)
    assert "a sheet of 1.5 mm" in text
    assert "Then the foam, cover and bolts" in text
    assert "with the foam" in text


MOLDS = {
    "shims": ("yamada-2002", ["ridge.count=3"]),
    "cast in": ("cast-in", ["ridge.count=3"]),
    "no slots": ("plain-ridges", ["ridge.count=3"]),
    "split": ("steep-fingertip", []),
    "bent": ("yamada-2002", ["ridge.count=3", "skin.curvature_radius_y=200"]),
}


@pytest.mark.parametrize("name", MOLDS)
def test_the_steps_make_each_move_once_in_the_molds_order(name: str) -> None:
    template, settings = MOLDS[name]
    design = skincad.load(template, settings)
    closed = mold(design)
    steps = opening_steps(Job(design, closed))
    assert [move for step in steps for move in step.moves] == list(closed.opening)
    sheet = casting_sheet(Job(design, closed), [], "", True)
    order = [sheet.index(step.words) for step in steps]
    assert order == sorted(order)
    for step in steps:
        roles = {closed.part(part).role for move in step.moves for part in move.parts}
        if roles & END_PLATES:
            assert "end plates" in step.words
        if PartRole.COVER in roles:
            assert "cover" in step.words
        if PartRole.SHIM in roles:
            assert "shim" in step.words.lower()


def test_no_strip_leaves_before_its_skin() -> None:
    design = skincad.load(*MOLDS["cast in"])
    first = opening_steps(Job(design))[0]
    assert "Take the weights off" in first.words
    assert first.moves == ()


@pytest.mark.parametrize("name", KINDS)
def test_each_hole_has_its_screw_and_each_pin_its_dowel(name: str) -> None:
    design = skincad.load(name)
    closed = mold(design)
    ends, lid = end_screws(Job(design, closed)), cover_screws(Job(design, closed))
    plates = [plate for plate in closed.of(*END_PLATES) if plate.end == "a"]
    assert ends.pieces == sum(len(bores(plate, CutRole.END_BOLT)) for plate in plates)
    assert ends.length in LENGTHS or ends.rod
    assert ends.length > design.skin.length + 2 * design.mold.end_plate
    holes = bores(closed.first(PartRole.COVER), CutRole.COVER_BOLT)
    assert (lid.pieces if lid else 0) == len(holes)
    assert lid is None or lid.length in LENGTHS
    assert sum(dowels(closed).values()) == len(closed.of(*PINS))


def test_a_screw_through_both_plates_ends_in_a_nut_or_in_the_second() -> None:
    by_wire, printed = (of_one_printer(name) for name in ("yamada-2002", "lab-bench"))
    assert end_screws(Job(by_wire)).nuts == 0
    screws = end_screws(Job(printed))
    assert (screws.rod, screws.nuts) == (True, 2 * screws.pieces)  # M3 screws end at 30 mm
    short = end_screws(Job(of_one_printer("lab-bench", ["skin.length=15.0"])))
    assert (short.rod, short.nuts) == (False, short.pieces)


def test_a_doubly_curved_molds_plates_are_screwed_to_its_cavity() -> None:
    design = skincad.load("yamada-2002", ["skin.curvature_radius_y=200"])
    closed = mold(design)
    screws = end_screws(Job(design, closed))
    assert (screws.pieces, screws.nuts) == (len(bores(closed.part("cavity"), CutRole.END_THREAD)), 0)
    assert screws.length < design.skin.length


def test_a_pin_is_the_longest_that_its_hole_takes() -> None:
    assert [pin_length(most) for most in (8.8, 9.9, 10.0, 35.0)] == [8.0, 8.0, 10.0, 20.0]
    assert pin_length(3.4) == 3.4  # none is so short: it is cut


def bought(design: Design) -> list[dict[str, str]]:
    rows = parts_csv(Job(design)).splitlines()
    return [row for row in csv.DictReader(rows) if row["made_by"] == "bought"]


@pytest.mark.parametrize("name", [*KINDS, "bent"])
def test_the_manifest_has_the_carriers_own_holes(name: str) -> None:
    design = mounted_design(name)
    closed = mold(design)
    mount = mount_of(Job(design, closed))
    manifest = json.loads(json.dumps(mount.as_json()))
    carrier = closed.part("carrier")
    for key, role in (("positions_mm", CutRole.MOUNT), ("fiducials_mm", CutRole.FIDUCIAL)):
        there = [bore.start[:2] for bore in bores(carrier, role)]
        assert len(manifest[key]) == len(there)
        assert all(math.dist(a, b) < 1e-8 for a, b in zip(manifest[key], there, strict=True))
    for bore in bores(carrier, CutRole.MOUNT):
        assert (
            manifest["depth_mm"] == bore.length > manifest["engagement_mm"][1] > manifest["engagement_mm"][0]
        )
        assert manifest["top_mm"] == bore.start[2] + bore.length


def test_of_a_gang_places_and_screws_are_each_carriers() -> None:
    one, two = mounted_design("yamada-2002"), mounted_design("yamada-2002").with_(mold={"cavities": 2})
    assert mount_of(Job(two)) == mount_of(Job(one))
    design = mounted_design("lab-bench").with_(mold={"cavities": 2})
    rows = bought(design)
    (screws,) = (row for row in rows if row["what"] == "mount screw")
    (inserts,) = (row for row in rows if row["what"] == "threaded insert" and "mount" in row["place"])
    assert (screws["quantity"], inserts["quantity"]) == ("8", "8")


def test_blind_threads_stay_clean_under_foam_tape_or_wax() -> None:
    design = mounted_design("lab-bench").with_(ridge={"count": 3})
    clean = sheet_steps(Job(design))["mount"]
    assert "under the foam" in clean
    assert "Tape" not in clean
    poured = design.with_(mold={"pour": "open", "gate": None})
    assert "Tape them until the carrier lies" in sheet_steps(Job(poured))["mount"]
    steep = bent("plain-ridges", 30.0).with_(mount=MOUNTS["bent"][0] | {"pitch_x": 6.0}, **PLAIN)
    bare = sheet_steps(Job(steep))["mount"]  # no room for foam on its narrow top
    assert "threads and fiducials are blind and lie under the cover" in bare
    assert "fill them flush with wax" in bare


def test_marks_alone_ask_for_nothing_to_buy() -> None:
    design = skincad.load("yamada-2002", ["ridge.count=3"]).with_(mount={"fiducials": 3})
    closed = mold(design)
    assert "mount's fiducials are blind" in sheet_steps(Job(design, closed))["mount"]
    assert not any(row["what"].startswith("mount") for row in bought(design))
    mount = mount_of(Job(design, closed))
    assert mount.as_json()["depth_mm"] is None


def test_without_a_mount_there_is_none() -> None:
    bare = Job(skincad.load("yamada-2002", ["ridge.count=3"]))
    assert mount_of(bare) is None
    assert "mount" not in sheet_steps(bare)


def test_a_mounts_threads_are_a_grip_where_there_is_no_other() -> None:
    design = mounted_design("fingertip-soft")
    assert bores(mold(design).part("carrier"), CutRole.PULL) == []
    words = [step.words for step in opening_steps(Job(design))]
    assert any("by two screws in its mount's threads" in word for word in words)


def test_a_drawing_says_that_two_threads_are_in_line() -> None:
    design = skincad.load("yamada-2002").with_(mount=IN_LINE)
    rows = what_matters(Job(design), mold(design).part("carrier"), None)
    assert any("two in line, 8 apart" in row for row in rows)


@pytest.mark.parametrize(
    ("said", "wide"), [("M3", 3.0), ("M2.5 x 3.5", 2.5), ("M3 insert, glued", None), ("", None)]
)
def test_only_what_is_tapped_is_drawn_as_a_thread(said: str, wide: float | None) -> None:
    assert major(said) == wide
