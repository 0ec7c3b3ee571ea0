"""Each rule of a machine against a calculation by hand or an exposed raster."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

import skincad
from skincad.fabrication import (
    Finding,
    Job,
    design_findings,
    extent,
    laid,
    laid_on_end,
    left_standing,
    mesh,
    overhang,
    strip_findings,
)
from skincad.fabrication.findings import part_findings
from skincad.fabrication.machine_rules import corner, passage
from skincad.fabrication.rules import Case, edges, teeth
from skincad.fabrication.strips import shim_sag
from skincad.inputs import Design, processes
from skincad.shape import Loop, Narrowest, Point, Segment, loop, rectangle, section
from skincad.solids import Bore, Part, PartRole, Prism
from skincad.solids.mold import mold
from tests.designs import of_one_printer, three_ridges
from tests.fabrication import by


@pytest.fixture
def flat() -> Design:
    """Ridges that stand upright on a plane and are milled: no slots, sharp tips, drafts of 1 in 4."""
    return skincad.load("milled-pad").with_(
        slot=None, skin={"curvature_radius": 1e7}, ridge={"crown": 0.0, "tip_fillet": 0.0, "root_fillet": 0.0}
    )


def case(design: Design, name: str, process: str) -> Case:
    part = mold(design).part(name)
    return Case(Job(design), part, process)


def findings_of(design: Design, rule: str) -> list[Finding]:
    return [f for f in design_findings(Job(design)) if f.rule == rule]


def test_a_milled_sharp_tip_keeps_the_balls_corner(flat: Design) -> None:
    """Flank and tip meet at 90 degrees and the draft's atan(0.25 / 1)."""
    angle = math.pi / 2 + math.atan(0.25)
    (tip,) = (f for f in findings_of(flat, "tool reach") if f.severity == "warning")
    assert tip.measured == pytest.approx(0.25 * (1 / math.sin(angle / 2) - 1), abs=ERROR)
    assert tip.limit == 0.02
    assert "and 8 more" in tip.where
    assert "tip_fillet of 0.25 mm" in tip.remedy
    rounded = flat.with_(ridge={"tip_fillet": 0.25})
    assert all(f.severity == "note" for f in findings_of(rounded, "tool reach"))


def test_an_undercut_ridge_cannot_be_milled_from_above_but_wire_cut() -> None:
    leaning = skincad.load("milled-pad").with_(
        slot=None, skin={"curvature_radius": 40.0}, ridge={"root_width": 1.5, "tip_width": 1.5, "crown": 0.0}
    )
    (tip,) = (f for f in findings_of(leaning, "tool reach") if f.severity == "warning")
    assert "no undercut" in tip.remedy
    assert all(f.severity == "note" for f in findings_of(by(leaning, "edm"), "tool reach"))


def test_wall_and_slender_tooth_of_the_cavity(flat: Design) -> None:
    """Roots 0.15 mm apart, tips 0.65: a tooth of 0.4 mm mean width and 2 mm height."""
    thin = flat.with_(ridge={"root_width": 2.35, "tip_width": 1.85, "height": 2.0})
    (wall,) = findings_of(thin, "wall")
    assert (wall.measured, wall.limit) == (pytest.approx(0.15), 0.2)
    (slender,) = findings_of(thin, "slender")
    assert (slender.measured, slender.limit) == (pytest.approx(5.0), 4.0)
    assert "at most 1.6 mm" in slender.remedy
    assert findings_of(thin.with_(ridge={"count": 1}), "wall") == []


def test_teeth_of_a_comb_are_the_webs_between_notches(yamada: Design) -> None:
    """Two slots 0.32 mm apart, 0.05 thick, with 0.005 of play a side; tilted ones come closer at the top."""
    (tooth,) = teeth(case(yamada, "end-a-comb", "edm"))
    # the play is the notch's alone: slots of a pair are parallel, so their distance is everywhere the same
    assert tooth == Narrowest(tooth.where, pytest.approx(0.32 - 0.05 - 0.01), pytest.approx(0.26))
    (tilted,) = teeth(case(skincad.load("yamada-2002-tilted"), "end-a-comb", "edm"))
    diagonal = (0.25 + 0.01 + 0.05 + 0.01) / math.sqrt(2)  # a notch at 45 degrees, across x
    assert tilted.width == pytest.approx(0.34 - diagonal, abs=1e-4)


def test_a_mill_goes_no_deeper_than_its_neck(flat: Design) -> None:
    assert findings_of(flat.with_(ridge={"height": 1.9, "tip_width": 1.2}), "tool depth") == []
    (deep,) = findings_of(flat.with_(ridge={"height": 2.1, "tip_width": 1.2}), "tool depth")
    assert (deep.measured, deep.limit) == (pytest.approx(2.1 / 0.5), 4.0)
    thicker = flat.with_(ridge={"height": 2.1, "tip_width": 1.2, "tip_fillet": 0.3})  # a 0.6 mm ball fits
    assert findings_of(thicker, "tool depth") == []


def test_clearance_is_told_once_for_all_that_slides(yamada: Design) -> None:
    (gap,) = findings_of(by(yamada, "sla"), "clearance")
    assert (gap.measured, gap.limit) == (0.01, 0.05)


def test_the_slits_fit_is_that_of_what_growth_leaves(yamada: Design) -> None:
    """0.005 drawn a side; wire keeps ± 0.003: 0.003 of growth leaves 0.002, and 0.006 no gap, but a jam."""

    def by_rule(growth: float) -> dict[str, Finding]:
        return {f.rule: f for f in design_findings(Job(yamada.with_(printer={"edm": {"growth": growth}})))}

    assert "slit fit" not in by_rule(0.0)
    assert by_rule(0.003)["slit fit"].measured == pytest.approx(0.002, abs=1e-12)
    assert "slit fit" not in by_rule(0.006)
    assert "notch" in by_rule(0.006)
    assert by_rule(0.003)["clearance"].limit == pytest.approx(0.005 + 2 * 0.003)


def test_platinum_silicone_against_resin_is_a_note() -> None:
    (finding,) = findings_of(skincad.load("lab-bench"), "cure inhibition")
    assert finding.severity == "note"
    safe = skincad.load("lab-bench", ["printer.sla.inhibits_platinum=false"])
    assert findings_of(safe, "cure inhibition") == []


def test_a_shim_sags_as_a_beam_on_two_supports(yamada: Design) -> None:
    """5 q l^4 / (384 E I) of a strip b x t: q = rho g b t, I = b t^3 / 12."""
    long = yamada.with_(skin={"length": 60.0})
    b, t = 0.25, 0.05
    by_hand = 5 * (7850e-9 * 9.81 * b * t) * 60**4 / (384 * 200e3 * b * t**3 / 12)
    assert shim_sag(Job(long)) == pytest.approx(by_hand, rel=1e-12)
    (finding,) = (f for f in design_findings(Job(long)) if f.where.startswith("shims"))
    assert (finding.measured, finding.limit) == (pytest.approx(by_hand), 0.025)
    most = float(finding.remedy.split(" mm")[0].split()[-1])
    assert shim_sag(Job(long.with_(skin={"length": most}))) == pytest.approx(
        0.025, rel=0.02
    )  # 3 digits, power 4


def roof(angle_deg: float) -> Part:
    """A post 2 wide and 3 high, 10 long, whose top reaches 1 mm out on both sides under this angle from the
    vertical."""
    rise = 1 / math.tan(math.radians(angle_deg))
    right = [(1.0, 0.0), (1.0, 3.0), (2.0, 3.0 + rise), (2.0, 5.0 + rise)]
    points = [*right, *((-x, z) for x, z in reversed(right))]
    return Part("post", PartRole.COVER, Prism(loop([Point(*p) for p in points]), "y", 0.0, 10.0))


def test_overhang_is_angle_and_area_beyond_the_limit() -> None:
    fdm = processes()["fdm"]
    assert overhang(roof(44.0), fdm, end=False) == (0.0, 0.0)
    angle, area = overhang(roof(60.0), fdm, end=False)
    assert angle == pytest.approx(60.0, abs=1e-6)
    assert area == pytest.approx(2 * 10 / math.sin(math.radians(60.0)), rel=1e-9)
    assert overhang(roof(60.0), fdm, end=True) == (0.0, 0.0)
    assert overhang(roof(60.0), processes()["sla"], end=False) == (0.0, 0.0)


def test_a_horizontal_bore_beyond_the_bridge_needs_support() -> None:
    block = Part("block", PartRole.COVER, Prism(loop([Point(*p) for p in BLOCK]), "y", 0.0, 10.0))
    design = skincad.load("nozzle-04")
    for radius, rules in ((2.5, []), (2.6, ["overhang"])):
        bored = replace(block, cuts=(Bore((0.0, 0.0, 0.0), "y", 10.0, radius),))
        findings = part_findings(Case(Job(design), bored, "fdm"))
        assert [f.rule for f in findings if f.rule == "overhang"] == rules


def test_what_is_dear_is_worked_out_once(yamada: Design, monkeypatch: pytest.MonkeyPatch) -> None:
    """A print mesh serves both ways to lay a part, and a comb's narrowest tooth all rules and processes."""
    meshed, combs = [], []
    distance = shapely.distance
    monkeypatch.setattr("skincad.fabrication.meshes.mesh", lambda *a: meshed.append(a) or mesh(*a))
    monkeypatch.setattr(shapely, "distance", lambda *a: combs.append(a) or distance(*a))
    findings = part_findings(Case(Job(yamada), roof(61.0), "fdm"))
    assert "overhang" in [f.rule for f in findings]
    assert len(meshed) == 1
    design_findings(Job(by(yamada.with_(name="once"), "cnc")))
    assert len(combs) == 1


ERROR = 1e-4  # mm: two buffers and the outline's own chords, and one in reserve
BLOCK = [(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)]


def test_no_film_closes_a_socket_of_a_print_mesh() -> None:
    """The left pin socket of gripper-pad ended 1e-15 mm below the cavity's top; a roof of 3.2 mm2 stayed."""
    assert findings_of(by(skincad.load("gripper-pad"), "fdm"), "overhang") == []


def test_details_are_of_layers_when_flat_and_of_pixels_on_end() -> None:
    bench = skincad.load("lab-bench", ["printer.sla.layer=0.1"])  # its crown rises by 0.06
    (crown,) = findings_of(bench, "detail")
    assert (crown.measured, crown.limit, crown.severity) == (0.06, 0.1, "note")
    assert "on end" in crown.remedy
    turned = bench.with_(printer={"sla": {"layer": 0.1, "orientation": "end"}})
    assert findings_of(turned, "detail") == []
    cavity = mold(bench).part("cavity")
    assert (laid_on_end(Job(bench), cavity), laid_on_end(Job(turned), cavity)) == (False, True)


@pytest.mark.parametrize("orientation", ["flat", "end"])
def test_end_plates_lie_on_their_face_and_lids_stay_flat_however_the_cavity_is_printed(
    yamada: Design, orientation: str
) -> None:
    printed = by(yamada, "sla").with_(
        printer={"sla": {"orientation": orientation}}, mold={"lid_process": "sla"}
    )
    closed = mold(printed)
    on_end = {part.name for part in closed.parts if laid_on_end(Job(printed), part)}
    plates = {f"end-{end}-{kind}" for end in "ab" for kind in ("comb", "keeper")}
    assert on_end == plates | ({"cavity"} if orientation == "end" else set())


@pytest.mark.parametrize("design", [of_one_printer("lab-bench"), three_ridges()], ids=["straight", "bent"])
def test_extents_are_those_of_the_mesh_on_the_bed(design: Design) -> None:
    for part in mold(design).parts:
        if (
            part.made != "made" or part.straight or (design.skin.curvature_radius_y and part.end)
        ):  # cut at the edge
            continue
        low, high = laid(mesh(part, 0.01), laid_on_end(Job(design), part), part).bounds
        assert sorted(extent(part)) == pytest.approx(sorted(high - low), abs=0.02)  # chords of arcs


@pytest.mark.slow  # six skins, seven, and as many as fit
def test_a_gang_too_long_for_the_bed_is_an_error_that_tells_how_many_fit() -> None:
    plain = skincad.load("plain-ridges")
    assert findings_of(plain, "build volume") == []
    findings = findings_of(plain.with_(mold={"cavities": 6}), "build volume")
    assert {f.where for f in findings} == {"cavity, by sla", "end plates, by sla", "cover, by sla"}
    for finding in findings:
        assert (finding.severity, finding.limit) == ("error", 120.0)
        count = int(finding.remedy.split("at most ")[1].split(",")[0])
        assert findings_of(plain.with_(mold={"cavities": count}), "build volume") == []
        assert findings_of(plain.with_(mold={"cavities": count + 1}), "build volume") != []


@pytest.mark.slow
def test_prints_stand_as_they_lie_and_stock_is_turned() -> None:
    flat = skincad.load("plain-ridges")  # a cavity of 37 x 12, 18.6 high
    low = {"build_x": 60.0, "build_y": 60.0, "build_z": 18.0}
    (tall,) = findings_of(flat.with_(printer={"sla": low}), "build volume")
    assert (tall.where, tall.measured) == ("cavity, by sla", pytest.approx(18.6))
    assert findings_of(by(flat, "cnc").with_(printer={"cnc": low}), "build volume") == []
    boundless = dict.fromkeys(low, 0.0)
    many = flat.with_(mold={"cavities": 6}, printer={"sla": boundless})
    assert findings_of(many, "build volume") == []


def thickest(width: float, depth: float, lean: float, pixel: float, shift: tuple[float, float]) -> float:
    """The thickest leaning plate that passes a notch exposed by pixels, whose middles are `shift` aside."""
    along, normal = (math.sin(lean), math.cos(lean)), (math.cos(lean), -math.sin(lean))
    most = math.ceil((depth + width) / pixel) + 2
    x, z = np.meshgrid(*((np.arange(-most, most + 1) + s) * pixel for s in shift))
    a, c = x * along[0] + z * along[1], x * normal[0] + z * normal[1]
    solid = (abs(c) > width / 2) & (abs(a) <= depth / 2)  # pixels beside the notch, which stand in
    half = pixel / 2 * (abs(normal[0]) + abs(normal[1]))
    right, left = c[solid & (c > 0)].min() - half, c[solid & (c < 0)].max() + half
    return float(right - left)


def test_what_passes_is_never_more_than_an_exposed_notch_lets_through() -> None:
    """And not less by more than a pixel: the bound is that of the worst place on the screen."""
    design = of_one_printer("lab-bench")
    width, pixel = 0.156, 0.05
    least = {}
    for slot in section(design).slots:
        lean = design.lean(slot.feature)
        shifts = [(i / 8, j / 8) for i in range(8) for j in range(8)]
        least[slot.feature] = min(thickest(width, slot.depth, lean, pixel, shift) for shift in shifts)
    bound = passage(Job(design), width, pixel)
    assert bound <= min(least.values()) + 1e-9
    assert bound > min(least.values()) - pixel
    assert least[5] >= 0.15 - 1e-9  # the middle one is upright: three whole pixels


@pytest.mark.slow
def test_a_notch_that_pixels_make_narrower_than_its_shim_is_told_with_the_clearance_that_does() -> None:
    design = of_one_printer("lab-bench")
    assert findings_of(design, "notch") == []
    (finding,) = findings_of(design.with_(mold={"slit_clearance": 0.01}), "notch")
    assert (finding.severity, finding.limit) == ("error", 0.1)
    assert finding.measured == pytest.approx(0.12 - 0.05 * (math.cos(0.06668) + math.sin(0.06668)), abs=1e-4)
    least = float(finding.remedy.split(" of ")[1].split(" mm")[0])
    assert findings_of(design.with_(mold={"slit_clearance": least}), "notch") == []
    assert findings_of(design.with_(mold={"slit_clearance": least - 0.001}), "notch") != []
    flat = design.with_(skin={"curvature_radius": 1e8}, mold={"slit_clearance": 0.01})
    finer = flat.with_(printer={"sla": {"pixel": 0.04725}})  # two pixels of a common printer: 0.0945
    assert [f.measured for f in findings_of(finer, "notch")] == pytest.approx([0.0945], abs=1e-9)
    drawn = design.with_(mold={"slit_clearance": 0.01}, printer={"sla": {"tool": "none"}})
    assert findings_of(drawn, "notch") == []


def test_a_coat_narrows_notches_and_gaps_where_the_silicone_asks_for_one() -> None:
    design = of_one_printer("lab-bench", ["printer.sla.coating=0.01"])
    (notch,), (gap,) = findings_of(design, "notch"), findings_of(design, "clearance")
    assert notch.measured == pytest.approx(passage(Job(design), 0.156, 0.05) - 0.02, abs=1e-12)
    least = float(notch.remedy.split(" of ")[1].split(" mm")[0])
    assert (gap.measured, gap.limit) == (0.05, pytest.approx(0.07))
    wider = design.with_(mold={"slit_clearance": least, "clearance": 0.07})
    assert findings_of(wider, "notch") == findings_of(wider, "clearance") == []
    tin = design.with_(printer={"sla": {"inhibits_platinum": False, "coating": 0.01}})
    assert findings_of(tin, "notch") == findings_of(tin, "clearance") == []


@pytest.mark.slow
def test_growth_narrows_a_notch_on_both_sides() -> None:
    """By hand for a wire, 0.156 - 2 * 0.03 around a shim of 0.1; beside pixels and a coat for a screen."""
    design = of_one_printer(
        "lab-bench", ["mold.process=edm", "mold.end_plate_process=edm", "printer.edm.growth=0.03"]
    )
    (finding,) = findings_of(design, "notch")
    assert (finding.measured, finding.limit) == (pytest.approx(0.096), 0.1)
    assert finding.where == "end plates' combs, notch of a shim grown, by edm"
    assert "mold.slit_clearance of 0.03 mm" in finding.remedy
    assert findings_of(design.with_(mold={"slit_clearance": 0.03}), "notch") == []
    for less in (0.027, -0.03):
        assert findings_of(design.with_(printer={"edm": {"growth": less}}), "notch") == []
    shut = design.with_(printer={"edm": {"growth": 0.2}})
    assert [f.measured for f in findings_of(shut, "notch")] == [0.0]
    screen = of_one_printer("lab-bench", ["printer.sla.coating=0.01", "printer.sla.growth=0.03"])
    (both,) = findings_of(screen, "notch")
    assert both.measured == pytest.approx(passage(Job(screen), 0.156, 0.05) - 2 * 0.04, abs=1e-12)
    least_clearance = float(both.remedy.split(" of ")[1].split(" mm")[0])
    assert findings_of(screen.with_(mold={"slit_clearance": least_clearance}), "notch") == []


def test_a_pair_out_of_balance_by_more_than_half_is_a_warning() -> None:
    design = skincad.load("yamada-2002")
    for share, grave in ((0.4, ["note"]), (0.6, ["warning"])):
        off = share / 2 * design.slot.offset
        wide = design.with_(mold={"slit_clearance": off - 0.003})  # the wire's tolerance
        assert [f.severity for f in strip_findings(Job(wide)) if f.rule == "strip place"] == grave


def test_angles_between_edges() -> None:
    assert [angle for _, angle in edges(rectangle(0, 2, 0, 1))] == pytest.approx([90.0] * 4)
    notched = loop([Point(*p) for p in ((0, 0), (4, 0), (4, 2), (2, 1), (0, 2))])
    inner = dict(edges(notched))[Point(2, 1)]
    assert inner == pytest.approx(360 - 2 * math.degrees(math.atan2(2, 1)))
    lens = (
        Segment(Point(0, 0), Point(1, 0)),
        Segment(Point(1, 0), Point(0, 0), math.tan(math.radians(40) / 4)),
    )
    assert [angle for _, angle in edges(lens)] == pytest.approx([20.0, 20.0])


def test_a_slot_that_lies_flat_leaves_the_comb_a_knife_edge() -> None:
    def findings_of(tilt: float) -> list:
        flat = skincad.load("yamada-2002-tilted").with_(
            ridge={"count": 1, "pitch": 5.0, "root_width": 4.0, "tip_width": 3.5, "height": 1.5},
            slot={"tilt": tilt, "depth": 0.1, "offset": 0.2, "elevation": -0.5},
        )
        return [f for f in design_findings(Job(flat)) if f.rule == "knife edge"]

    assert findings_of(45.0) == []
    (sharp,) = findings_of(62.0)  # combs of both ends are told once
    assert sharp.measured == pytest.approx(90.0 - 62.0, abs=0.5)  # the split's arc turns by less
    assert sharp.measured < 30.0 == sharp.limit


def test_no_part_of_the_default_has_one(yamada: Design) -> None:
    assert not any(f.rule == "knife edge" for f in design_findings(Job(yamada)))


R = 0.25


def grooved(points: list[tuple[float, float]]) -> Loop:
    """A block below z = 0 with this groove, from left to right, in its top."""
    rim = [(-5.0, 0.0), (-5.0, -5.0), (5.0, -5.0), (5.0, 0.0)]
    return loop([Point(*p) for p in [*rim, *reversed(points)]])


@pytest.mark.parametrize("angle_deg", [50.0, 60.0, 90.0, 120.0, 150.0])
def test_a_v_groove_keeps_its_bisector(angle_deg: float) -> None:
    half = math.radians(angle_deg / 2)
    depth = 1.0
    wide = depth * math.tan(half)
    left = left_standing(grooved([(-wide, 0.0), (0.0, -depth), (wide, 0.0)]), R)
    assert max(left) == pytest.approx(R * (1 / math.sin(half) - 1), abs=ERROR)
    assert corner(R, 2 * half) == pytest.approx(R * (1 / math.sin(half) - 1), rel=1e-15)


def test_a_groove_too_narrow_is_left_but_for_what_the_ball_dips_in() -> None:
    """The ball rests on the mouth's edges, its centre c above it: from a bottom corner its surface is at
    sqrt((w / 2)^2 + (D + c)^2) - r."""
    wide, depth = 0.3, 1.0
    centre = math.sqrt(R**2 - wide**2 / 4)
    left = left_standing(
        grooved([(-wide / 2, 0.0), (-wide / 2, -depth), (wide / 2, -depth), (wide / 2, 0.0)]), R
    )
    assert max(left) == pytest.approx(math.hypot(wide / 2, depth + centre) - R, abs=ERROR)


def test_a_wide_groove_keeps_only_its_right_corners() -> None:
    left = left_standing(grooved([(-1.0, 0.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 0.0)]), R)
    assert max(left) == pytest.approx((math.sqrt(2) - 1) * R, abs=ERROR)
    assert min(left) < ERROR


@pytest.mark.parametrize("fillet", [0.1, 0.2, 0.25, 0.4])
def test_a_fillet_is_cut_as_far_as_the_tool_is_smaller(fillet: float) -> None:
    """Two concentric-cornered circles in a right angle: (sqrt 2 - 1) (r - fillet) on the bisector."""
    bulge = math.tan(math.pi / 8)
    corners = [(5.0, -5.0), (5.0, 0.0), (1.0, 0.0), (1.0, -1.0 + fillet), (1.0 - fillet, -1.0)]
    corners += [(-x, z) for x, z in reversed(corners)]
    points = [Point(*p) for p in corners]
    block = tuple(
        Segment(a, b, -bulge if abs(a.x - b.x) == pytest.approx(fillet) else 0.0)
        for a, b in zip(points, [*points[1:], points[0]], strict=True)
    )
    assert sum(s.bulge != 0 for s in block) == 2
    expected = max(0.0, (math.sqrt(2) - 1) * (R - fillet))
    assert max(left_standing(block, R)) == pytest.approx(expected, abs=ERROR)


def test_from_above_nothing_under_a_ledge_is_cut() -> None:
    """A groove 4 wide below a mouth 2 wide, all of it beyond the tool's size: beside the mouth 1 mm stays,
    on the floor as far as the ball's own corner with it."""
    shape = grooved([(-1, 0), (-1, -1), (-2, -1), (-2, -3), (2, -3), (2, -1), (1, -1), (1, 0)])
    free = left_standing(shape, R)
    assert max(free) == pytest.approx((math.sqrt(2) - 1) * R, abs=ERROR)
    above = left_standing(shape, R, from_above=True)
    assert max(above) == pytest.approx(math.hypot(1 + R, R) - R, abs=ERROR)  # floor corner to the ball's


def test_a_larger_tool_leaves_no_less() -> None:
    shape = grooved([(-0.4, 0.0), (-0.3, -0.7), (0.3, -0.7), (0.4, 0.0)])
    left = np.array([left_standing(shape, r) for r in (0.05, 0.1, 0.2, 0.3, 0.5)])
    assert (np.diff(left, axis=0) >= -ERROR).all()
    assert left[-1].max() > left[0].max() + 0.1
