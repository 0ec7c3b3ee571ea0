"""Build volume, pixels and coats, by hand and by an exposed raster."""

from __future__ import annotations

import math

import numpy as np
import pytest

import skincad
from bench.table_processes import by
from skincad.fabrication import Job, design_findings, extent, laid, laid_on_end, mesh, strip_findings
from skincad.fabrication.machine_rules import passage
from skincad.inputs import Design
from skincad.shape import section
from skincad.solids.mold import mold
from tests.bent_skin import three_ridges
from tests.templates import of_one_printer


def findings_of(design: Design, rule: str) -> list[skincad.fabrication.rules.Finding]:
    return [f for f in design_findings(Job(design)) if f.rule == rule]


@pytest.mark.parametrize("design", [of_one_printer("lab-bench"), three_ridges()], ids=["straight", "bent"])
def test_extents_are_those_of_the_mesh_on_the_bed(design: Design) -> None:
    for part in mold(design).parts:
        if (
            part.made != "made" or part.straight or (design.skin.curvature_radius_y and part.end)
        ):  # cut at the edge
            continue
        low, high = laid(mesh(part, 0.01), laid_on_end(Job(design), part), part).bounds
        assert sorted(extent(part)) == pytest.approx(sorted(high - low), abs=0.02)  # chords of arcs


@pytest.mark.slow
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


def test_prints_stand_as_they_lie_and_stock_is_turned() -> None:
    flat = skincad.load("plain-ridges")  # a cavity of 37 x 12, 18.6 high
    low = {"build_x": 60.0, "build_y": 60.0, "build_z": 18.0}
    (tall,) = findings_of(flat.with_(printer={"sla": low}), "build volume")
    assert (tall.where, tall.measured) == ("cavity, by sla", pytest.approx(18.6))
    assert findings_of(by(flat, "cnc").with_(printer={"cnc": low}), "build volume") == []
    boundless = dict.fromkeys(low, 0.0)
    many = flat.with_(mold={"cavities": 12}, printer={"sla": boundless})
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
    assert design.slot is not None
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
    assert design.slot is not None
    for share, grave in ((0.4, ["note"]), (0.6, ["warning"])):
        off = share / 2 * design.slot.offset
        wide = design.with_(mold={"slit_clearance": off - 0.003})  # the wire's tolerance
        assert [f.severity for f in strip_findings(Job(wide)) if f.rule == "strip place"] == grave
