"""The closed mold as a stack."""

from __future__ import annotations

from itertools import product

import pytest

import skincad
from skincad.fabrication import Job, casting_sheet
from skincad.fabrication.findings import closing_findings
from skincad.inputs import Design, processes
from skincad.solids import CAVITIES, END_PLATES, SHEETS, CutRole, PartRole, bores
from skincad.solids.mold import mold
from tests.bent_skin import bent
from tests.families import RIDGED
from tests.templates import of_one_printer


@pytest.mark.parametrize("name", RIDGED)
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
@pytest.mark.parametrize("name", RIDGED)
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
@pytest.mark.parametrize("name", ["plain-ridges", "yamada-2002", "nozzle-04", "milled-pad"])
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


def test_the_foam_is_to_be_bought_laid_in_and_lifted_off() -> None:
    design = skincad.load("plain-ridges")
    text = casting_sheet(Job(design), [], "", True)
    assert "a sheet of 1.5 mm" in text
    assert "then the foam, cover and bolts" in text
    assert "with the foam" in text
    curved = design.with_(skin={"curvature_radius_y": 200.0})
    text = casting_sheet(Job(curved), [], "", True)
    assert "Then the foam, cover and bolts" in text
    assert "with the foam" in text
