import math

import pytest

import skincad
from skincad.fabrication import Job, design_findings
from skincad.fabrication.rules import LEAST_ANGLE, edges
from skincad.inputs import Design
from skincad.shape import Point, Segment, loop, rectangle


def test_a_rectangles_corners_are_right_and_a_notchs_are_reflex() -> None:
    assert [angle for _, angle in edges(rectangle(0, 2, 0, 1))] == pytest.approx([90.0] * 4)
    notched = loop([Point(*p) for p in ((0, 0), (4, 0), (4, 2), (2, 1), (0, 2))])
    inner = dict(edges(notched))[Point(2, 1)]
    assert inner == pytest.approx(360 - 2 * math.degrees(math.atan2(2, 1)))


def test_an_arc_meets_its_chord_at_half_its_sweep() -> None:
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
    assert sharp.measured < LEAST_ANGLE == sharp.limit


def test_no_part_of_the_default_has_one(yamada: Design) -> None:
    assert not any(f.rule == "knife edge" for f in design_findings(Job(yamada)))
