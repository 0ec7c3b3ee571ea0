"""How parts share plates: each on one, none over its edge, tall ones together."""

from __future__ import annotations

import pytest

from skincad.fabrication.meshes import PART_GAP, BedPart, plates
from skincad.inputs import processes

SLA = processes()["sla"]  # 120 x 68 mm


def names(parts: list[BedPart]) -> list[list[str]]:
    return [[part.name for part in plate] for plate in plates(parts, SLA)]


def test_what_fits_exactly_shares_a_plate() -> None:
    half = (120.0 - PART_GAP) / 2
    two = [BedPart("a", half, 68.0, 5.0), BedPart("b", half, 60.0, 9.0)]
    assert names([part._replace(x=part.x, y=57.0) for part in two]) == [["b", "a"]]
    assert names([BedPart("a", half + 0.1, 40.0, 5.0), BedPart("b", half, 40.0, 5.0)]) == [["a"], ["b"]]


def test_rows_lie_behind_each_other() -> None:
    bar = [BedPart(name, 100.0, 17.0, 4.0) for name in "abcd"]
    assert names(bar) == [["a", "b", "c"], ["d"]]  # 3 x 17 and 2 x 5 are 61 of 68 mm


def test_a_part_lies_as_it_fits() -> None:
    assert names([BedPart("a", 60.0, 118.0, 4.0)]) == [["a"]]


def test_the_tallest_go_first_and_the_order_given_does_not_matter() -> None:
    parts = [
        BedPart("low", 100.0, 50.0, 2.0),
        BedPart("high", 100.0, 50.0, 9.0),
        BedPart("flat", 100.0, 10.0, 1.0),
    ]
    assert names(parts) == names(parts[::-1]) == [["high", "flat"], ["low"]]


def test_a_part_that_no_plate_takes_is_alone() -> None:
    assert names([BedPart("big", 200.0, 10.0, 4.0), BedPart("a", 10.0, 10.0, 4.0)]) == [["a"], ["big"]]


@pytest.mark.parametrize("key", ["build_x", "build_y"])
def test_no_limit_is_one_plate(key: str) -> None:
    boundless = SLA.model_copy(update={key: 0.0})
    assert len(plates([BedPart(name, 100.0, 60.0, 4.0) for name in "abc"], boundless)) == 1
