"""A notch as it comes out, by hand, and the rule that holds it against its shim."""

from __future__ import annotations

import pytest

import skincad
from skincad.base.errors import InputError
from skincad.fabrication.finding import Finding
from skincad.fabrication.findings import design_findings
from skincad.fabrication.notch_as_made import MOST_CLEARANCE, drawn_clearance, notch_as_made
from skincad.inputs.catalog import load_design, template_names
from skincad.inputs.process import Process


def found(growth: float, *settings: str) -> list[Finding]:
    own = "mold.slit_clearance=0.01"
    design = load_design("lab-bench", [own, *settings], printer={"sla": {"growth": growth}})
    return [f for f in design_findings(design) if f.rule == "notch growth"]


def test_both_sides_of_a_notch_grow() -> None:
    process = Process(growth=0.03)
    assert notch_as_made(0.12, process) == pytest.approx(0.06)
    assert notch_as_made(0.05, process) == 0.0
    assert notch_as_made(0.12, Process(growth=-0.01)) == pytest.approx(0.14)
    assert notch_as_made(0.12, Process()) == 0.12


def test_the_clearance_that_is_drawn_leaves_the_one_meant() -> None:
    """In whole micrometres, up: 0.0304 is drawn as 0.041 where 0.01 is wanted."""
    assert drawn_clearance(0.01, Process(growth=0.03)) == pytest.approx(0.04)
    assert drawn_clearance(0.01, Process(growth=0.0304)) == pytest.approx(0.041)


def test_a_shim_of_lab_bench_does_not_go_into_notches_that_grew() -> None:
    """Shim 0.1, notch 0.12: 0.06 is left of it. Up to 10 um a side it still goes in."""
    (shut,) = found(0.03)
    assert (shut.measured, shut.limit, shut.severity) == (pytest.approx(0.06), 0.1, "warning")
    assert "mold.slit_clearance of 0.040 mm" in shut.remedy
    assert not found(0.01)
    assert not found(0.03, "mold.slit_clearance=0.04")
    assert not found(-0.03)


def test_no_clearance_is_proposed_that_the_key_does_not_take() -> None:
    assert "slit_clearance" not in found(0.6)[0].remedy
    with pytest.raises(InputError, match="slit_clearance"):
        load_design("lab-bench", [f"mold.slit_clearance={MOST_CLEARANCE + 1e-3}"])


def test_no_template_is_judged_by_a_growth_that_nobody_measured() -> None:
    for name in template_names():
        assert not [f for f in design_findings(skincad.load(name)) if f.rule == "notch growth"]
