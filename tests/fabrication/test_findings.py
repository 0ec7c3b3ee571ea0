import math

import pytest

import skincad
from bench.table_processes import by
from skincad.fabrication import Finding, Job, design_findings
from skincad.inputs import PROCESSES, Design, template_names
from tests.templates import KINDS, SHIPPED

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


def test_lids_are_judged_by_the_molds_process_unless_they_have_one(yamada: Design) -> None:
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
