"""Findings of templates and processes, undercuts, and ridges of unlike height."""

from __future__ import annotations

import math
import re

import pytest

import skincad
from skincad.fabrication import Finding, Job, design_findings
from skincad.fabrication.inspection import inspection
from skincad.fabrication.rules import Case, grooves, teeth
from skincad.inputs import PROCESSES, Design, template_names
from skincad.outputs.drawing.overview import drawing
from skincad.shape import skin_of
from skincad.solids import SAFE_SHARE, safe_strain, split_ridges
from skincad.solids.mold import mold
from tests.designs import KINDS, SHIPPED
from tests.fabrication import by

LARGEST_IS_BEST = {
    *("tool reach", "slender", "tool depth", "overhang"),
    *("undercut", "cure inhibition", "build volume", "crest layer"),
}


def warnings(design: Design) -> dict[str, Finding]:
    return {f.where: f for f in design_findings(Job(design)) if f.severity != "note"}


def test_what_is_over_a_limit_by_less_than_a_micrometre_is_no_note(yamada: Design) -> None:
    """A wire of 0.015 mm and its gap of 0.01 leave 0.414 x 0.025 in a notch's corner; the shim has 0.005 of
    play a side, 0.0071 on the diagonal, and the wire's own tolerance of 0.003: 0.3 um less."""
    assert design_findings(Job(yamada)) == []
    (finding,) = design_findings(Job(yamada.with_(mold={"slit_clearance": 0.004})))
    assert (finding.rule, finding.severity) == ("tool reach", "note")
    assert finding.measured == pytest.approx((math.sqrt(2) - 1) * 0.025, abs=1e-4)  # reach.ERROR
    assert finding.limit == pytest.approx(math.sqrt(2) * 0.004 + 0.003, rel=1e-12)


@pytest.mark.parametrize("name", SHIPPED)
def test_templates_have_no_warning_by_their_own_processes(name: str) -> None:
    assert warnings(skincad.load(name)) == {}


def test_every_process_makes_at_least_one_template() -> None:
    makers = {skincad.load(name).mold.process for name in template_names()}
    assert makers == set(PROCESSES)


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("process", PROCESSES)
def test_a_finding_is_beyond_its_limit_told_once_and_has_a_remedy(name: str, process: str) -> None:
    findings = design_findings(Job(by(skincad.load(name), process)))
    assert len({(f.rule, f.where) for f in findings}) == len(findings)
    for finding in findings:
        over = finding.measured > finding.limit
        assert over == (finding.rule in LARGEST_IS_BEST), finding
        assert finding.remedy
        assert math.isfinite(finding.measured)


def test_one_feature_breaks_one_rule(yamada: Design) -> None:
    """A slit of 0.06 mm is too narrow for a 0.5 mm mill: what it leaves is told, not the gap as well."""
    milled = [
        f for f in design_findings(Job(by(yamada, "cnc"))) if "notch" in f.where and f.severity == "warning"
    ]
    assert [f.rule for f in milled] == ["tool reach"]
    printed = [f for f in design_findings(Job(by(yamada, "sla"))) if "notch of" in f.where]
    assert [(f.rule, f.measured, f.limit) for f in printed] == [("gap", pytest.approx(0.06), 0.1)]


def test_a_resin_printer_is_told_crown_and_slit_and_what_would_make_them(yamada: Design) -> None:
    findings = {(f.rule, f.where): f for f in design_findings(Job(by(yamada, "sla")))}
    slit = findings["gap", "end plates' combs, notch of a shim, by sla"]
    assert "multiply all lengths by 1.67" in slit.remedy  # 0.1 / 0.06
    assert "lab-bench" in slit.remedy
    assert slit.remedy.endswith("or by edm")
    crown = findings["detail", "cavity, crown's rise, by sla"]
    assert (crown.measured, crown.limit, crown.severity) == (0.03, 0.05, "note")


def test_end_plates_and_lids_have_their_own_process(yamada: Design) -> None:
    milled = by(yamada, "cnc").with_(mold={"clearance": 0.05})
    assert any("comb" in where for where in warnings(milled))
    wired = milled.with_(mold={"end_plate_process": "edm"})
    assert all(where.startswith("cavity") for where in warnings(wired))
    printed = wired.with_(mold={"lid_process": "fdm", "clearance": 0.2})
    assert [f for f in warnings(printed).values() if f.rule == "hole"] == []
    coarse = printed.with_(printer={"fdm": {"hole": 1.5}})  # bleeds grow with it, the vent doesn't
    (hole,) = (f for f in warnings(coarse).values() if f.rule == "hole")
    assert (hole.where, hole.measured, hole.limit) == ("carrier, bore, by fdm", pytest.approx(1.0), 1.5)
    printed = by(yamada, "fdm").with_(mold={"clearance": 0.2}, printer={"fdm": {"hole": 1.5}})
    assert "carrier, bore, by fdm" in warnings(printed)
    assert not any("carrier" in where for where in warnings(printed.with_(mold={"lid_process": "edm"})))


def test_a_finer_machine_of_ones_own_is_what_would_make_it(yamada: Design) -> None:
    fine = {"fine": {"based_on": "sla", "gap": 0.05, "clearance": 0.01, "pixel": 0.009, "layer": 0.02}}
    fine["fine"]["tolerance"] = 0.004  # else it would not hold a notch
    coarse = by(yamada, "sla").with_(printer=fine)
    slit = next(f for f in design_findings(Job(coarse)) if f.rule == "gap")
    assert slit.remedy.endswith("or by edm or fine")
    assert warnings(coarse.with_(mold={"process": "fine"})) == {}


def test_the_gravest_come_first(yamada: Design) -> None:
    order = [f.severity for f in design_findings(Job(by(yamada, "fdm")))]
    assert order == sorted(order, key=["error", "warning", "note"].index)
    assert {"warning", "note"} <= set(order)


SHARP = {"crown": 0.0, "tip_fillet": 0.0, "root_fillet": 0.0}


def upright(radius: float, **other: object) -> Design:
    """Sharp ridges of constant width 0.75 mm: nothing but the fan's lean undercuts them."""
    return skincad.load("yamada-2002").with_(
        slot=None, skin={"curvature_radius": radius}, ridge={"tip_width": 0.75, **SHARP}, **other
    )


def flank(radius: float) -> float:
    """Length of a flank: 0.5 mm and the base circle's fall over half a root."""
    return 0.5 + radius - math.sqrt(radius**2 - 0.375**2)


def undercut_remedy(design: Design) -> tuple[float | None, float | None, str]:
    """The root width and tip width that free a skin, mm, as the first finding says, and its words."""
    words = next(f.remedy for f in design_findings(Job(design)) if f.rule == "undercut")
    wide = {key: float(value) for key, value in re.findall(r"(root|tip)_width of ([\d.]+) mm", words)}
    return wide.get("root"), wide.get("tip"), words


def test_the_default_leaves_its_mold_freely(yamada: Design) -> None:
    assert {u.width for u in skin_of(yamada).undercuts.values()} == {0.0}


@pytest.mark.parametrize("radius", [12.0, 20.0, 60.0])
def test_undercut_of_a_leaning_upright_flank_is_its_closed_form(radius: float) -> None:
    """A flank that leans by a overhangs by its length x sin a; the ridge's level is 0.75 / cos a wide."""
    undercuts, lean = skin_of(upright(radius)).undercuts, 4 / radius
    width = flank(radius) * math.sin(lean)
    # chords of 1e-5 mm, and levels between the polygons' corners
    assert undercuts[9].width == pytest.approx(width, abs=1e-4)
    assert undercuts[9].strain == pytest.approx(width * math.cos(lean) / 0.75, abs=2e-4)
    assert undercuts[1] == pytest.approx(undercuts[9], abs=1e-9)  # mirror images, to rounding
    assert undercuts[5] == (0.0, 0.0)


def test_the_silicone_decides_whether_it_leaves() -> None:
    """0.2 squeezed: a fifth of Sylgard's 120 % is a stretch of 1.24, a squeeze of 0.19; Dragon Skin's 364 %
    takes 0.42."""
    stiff = upright(12.0, material={"name": "sylgard-184"})
    assert safe_strain(stiff) == pytest.approx(1 - 1 / (1 + SAFE_SHARE * 1.2), rel=1e-12)
    errors = [f for f in design_findings(Job(stiff)) if f.rule == "undercut" and f.severity == "error"]
    assert {f.where.split(",")[0] for f in errors} == {"ridge 1", "ridge 9"}
    closed_form = flank(12.0) * math.sin(1 / 3) * math.cos(1 / 3) / 0.75
    assert all(f.measured == pytest.approx(closed_form, abs=2e-4) for f in errors)
    soft = [f for f in design_findings(Job(upright(12.0))) if f.rule == "undercut"]
    assert len(soft) == 8
    assert {f.severity for f in soft} == {"note"}
    assert "364 % elongation" in soft[0].remedy


def test_what_leans_more_than_it_is_wide_is_locked() -> None:
    ridge = {"height": 2.0, "count": 7, "pitch": 1.3, "root_width": 0.5, "tip_width": 0.5, **SHARP}
    locked = skincad.load("plain-ridges").with_(skin={"curvature_radius": 9.0, "thickness": 4.0}, ridge=ridge)
    assert skin_of(locked).undercuts[7].strain == 1.0
    assert any(f.severity == "error" for f in design_findings(Job(locked)) if f.rule == "undercut")


def test_the_draft_told_is_just_enough() -> None:
    design = upright(20.0)
    root, tip, _ = undercut_remedy(design)
    for key, value, back in (("root_width", root, -0.005), ("tip_width", tip, 0.005)):
        assert not any(u.width for u in skin_of(design.with_(ridge={key: value})).undercuts.values())
        assert any(u.width for u in skin_of(design.with_(ridge={key: value + back})).undercuts.values())


def test_a_root_that_the_pitch_forbids_is_not_told() -> None:
    root, tip, _ = undercut_remedy(upright(12.0, material={"name": "sylgard-184"}))
    assert root is None  # 0.75 + 0.36 is above the pitch
    assert tip is not None


def test_a_split_cavity_is_advised_unless_the_cavity_is_split() -> None:
    for split, advised in (("none", True), ("auto", False)):
        findings = [
            f for f in design_findings(Job(upright(12.0, mold={"split": split}))) if f.rule == "undercut"
        ]
        assert findings
        assert all(('a split cavity (mold.split = "auto")' in f.remedy) == advised for f in findings)


UNLIKE = [0.5, 0.52, 0.5, 0.48, 0.5, 0.5, 0.47, 0.5, 0.55]


@pytest.fixture(scope="module")
def unlike(yamada: Design) -> Design:
    return yamada.with_(ridge={"heights": UNLIKE})


def test_the_deepest_groove_and_the_highest_free_tooth(unlike: Design, yamada: Design) -> None:
    part = mold(unlike).part("cavity")
    case = Case(Job(unlike), part, "edm")
    assert grooves(case) == [("groove of ridge 9's tip", 0.5, 0.55)]
    # beside the deepest one the tooth is backed below the shallower groove's bottom
    assert teeth(case) == [("tooth between the roots of ridges 1 and 2", 0.25, 0.5)]
    even = Case(Job(yamada), part, "edm")
    assert (grooves(even)[0].where, teeth(even)[0].where) == (
        "groove of a ridge's tip",
        "tooth between two ridges' roots",
    )


def test_a_tooth_too_slender_says_between_which_ridges() -> None:
    """Milled teeth of 0.4 mm mean width may be 1.6 mm high."""
    heights = {"heights": [1.0, 1.0, 1.0, 2.0, 1.9, 1.0, 1.0, 1.0, 1.0]}
    ridge = {**heights, "root_width": 2.35, "tip_width": 1.85, **SHARP, "tip_fillet": 0.25}
    thin = skincad.load("milled-pad").with_(slot=None, skin={"curvature_radius": 1e7}, ridge=ridge)
    (finding,) = (f for f in design_findings(Job(thin)) if f.rule == "slender")
    assert "ridges 4 and 5" in finding.where
    assert finding.measured == pytest.approx(1.9 / 0.4)


def test_each_crest_is_inspected_at_its_own_height(unlike: Design) -> None:
    wanted = [
        4.0 - 60.0 * (1 - math.cos(lean)) + height * math.cos(lean)
        for height, lean in zip(UNLIKE, [(i - 4) / 60 for i in range(9)], strict=True)
    ]
    assert inspection(Job(unlike)).crests.heights == pytest.approx(wanted, abs=1e-12)


def test_the_draft_is_for_the_ridge_that_needs_most() -> None:
    """A high third ridge leans half as much as the outermost, and needs more: flanks must clear it too."""
    high = upright(20.0).with_(ridge={"heights": [0.5, 0.5, 1.6, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5]})
    root, tip, words = undercut_remedy(high)
    assert "frees ridge 3" in words
    assert root is None  # beyond the pitch
    freed = high.with_(ridge={"tip_width": tip})
    assert all(undercut.width == 0.0 for undercut in skin_of(freed).undercuts.values())
    assert any(
        u.width > 0 for u in skin_of(high.with_(ridge={"tip_width": (tip or 0.0) + 0.004})).undercuts.values()
    )
    assert "frees the outermost ridge" in undercut_remedy(upright(20.0))[2]


def test_a_cavity_is_split_alike_on_both_sides() -> None:
    """Only ridge 2 needs it: split there alone, the piece with all others would leave askew."""
    split = upright(20.0, mold={"split": "auto"}, material={"name": "sylgard-184"}).with_(
        ridge={"heights": [0.3, 1.4, *[0.3] * 7]}
    )
    caught = [r for r, undercut in skin_of(split).undercuts.items() if undercut.strain > safe_strain(split)]
    assert caught == [2]
    assert split_ridges(split) == [2, 8]


def test_the_drawing_tells_the_heights(unlike: Design, yamada: Design) -> None:
    sheet = drawing(unlike, mold(unlike))
    assert "along the arc, 0.47 to 0.55 high" in sheet
    assert ">0.5<" in sheet  # of the ridge that it enlarges
    assert "high<" not in drawing(yamada, mold(yamada))
