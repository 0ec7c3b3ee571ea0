"""Ridges of unlike height: each rule looks at the ridge that breaks it, and says which."""

from __future__ import annotations

import math

import pytest

import skincad
from skincad.fabrication import Job, design_findings
from skincad.fabrication.findings import freeing_widths, least_drafted_ridge, undercut_findings
from skincad.fabrication.inspection import inspection
from skincad.fabrication.rules import Case, grooves, teeth
from skincad.inputs import Design
from skincad.outputs.drawing.overview import drawing
from skincad.shape import skin_of
from skincad.solids import safe_strain, split_ridges
from skincad.solids.mold import mold
from tests.fabrication.test_demolding import upright

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
    thin = skincad.load("milled-pad").with_(
        slot=None,
        skin={"curvature_radius": 1e7},
        ridge={
            "heights": [1.0, 1.0, 1.0, 2.0, 1.9, 1.0, 1.0, 1.0, 1.0],
            "root_width": 2.35,
            "tip_width": 1.85,
            "crown": 0.0,
            "tip_fillet": 0.25,
            "root_fillet": 0.0,
        },
    )
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
    assert least_drafted_ridge(Job(high)) == 3
    root, tip = freeing_widths(Job(high))
    assert root is None  # beyond the pitch
    freed = high.with_(ridge={"tip_width": tip})
    assert all(undercut.width == 0.0 for undercut in skin_of(freed).undercuts.values())
    assert any(
        u.width > 0 for u in skin_of(high.with_(ridge={"tip_width": (tip or 0.0) + 0.004})).undercuts.values()
    )
    assert "frees ridge 3" in undercut_findings(Job(high))[0].remedy
    assert "frees the outermost ridge" in undercut_findings(Job(upright(20.0)))[0].remedy


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
