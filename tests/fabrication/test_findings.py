import math

import pytest

import skincad
from skincad.catalog import template_names
from skincad.design import Design
from skincad.fabrication.findings import design_findings, undercuts

STRAIGHT = {"slot": None, "film": None, "contact": {"film": None}}


def test_the_default_has_no_finding(yamada: Design) -> None:
    assert design_findings(yamada) == []
    assert set(undercuts(yamada).values()) == {0.0}


def test_undercut_of_a_leaning_upright_flank_is_its_closed_form(yamada: Design) -> None:
    """A sharp ridge of constant width leans by a: its inner... outer flank overhangs by height x sin a."""
    design = yamada.with_(
        **STRAIGHT,
        skin={"curvature_radius": 20.0},
        ridge={"tip_width": 0.75, "crown": 0.0, "tip_fillet": 0.0, "root_fillet": 0.0},
    )
    found = undercuts(design)
    lean = 4 / 20
    # flank from (0.375, -sag) to (0.375, 0.5) in the ridge's frame, turned by the lean
    sag = 20 - math.sqrt(400 - 0.375**2)
    assert found[9] == pytest.approx((0.5 + sag) * math.sin(lean), abs=1e-4)
    assert found[1] == pytest.approx(found[9], abs=1e-9)  # mirror images, to rounding
    assert found[5] == 0.0


def test_a_process_that_cannot_cut_a_feature_is_named(yamada: Design) -> None:
    rough = yamada.with_(mold={"process": "fdm"})
    rules = {(f.rule, f.where.split(",")[0]) for f in design_findings(rough)}
    assert ("wall", "cavity") in rules
    assert ("gap", "end plates") in rules
    assert all(f.severity == "warning" and f.remedy for f in design_findings(rough))


@pytest.mark.parametrize("name", template_names())
def test_templates_have_no_warning(name: str) -> None:
    assert [f for f in design_findings(skincad.load(name)) if f.severity != "note"] == []
