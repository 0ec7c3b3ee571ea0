"""Each rule against a calculation by hand."""

import math
from dataclasses import replace

import pytest
import shapely

import skincad
from bench.table_processes import by
from skincad.fabrication import Finding, Job, design_findings, laid_on_end, meshes, overhang
from skincad.fabrication.findings import part_findings
from skincad.fabrication.machine_rules import ERROR
from skincad.fabrication.rules import Case, teeth
from skincad.fabrication.strips import shim_sag
from skincad.inputs import Design, processes
from skincad.shape import Narrowest, Point, loop
from skincad.solids import Bore, Part, PartRole, Prism
from skincad.solids.mold import mold


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
    mesh, distance = meshes.mesh, shapely.distance
    monkeypatch.setattr(meshes, "mesh", lambda *a: meshed.append(a) or mesh(*a))
    monkeypatch.setattr(shapely, "distance", lambda *a: combs.append(a) or distance(*a))
    findings = part_findings(Case(Job(yamada), roof(61.0), "fdm"))
    assert "overhang" in [f.rule for f in findings]
    assert len(meshed) == 1
    design_findings(Job(by(yamada.with_(name="once"), "cnc")))
    assert len(combs) == 1


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
