"""What a shop drawing says of a part as a whole."""

from __future__ import annotations

import pytest

import skincad
from skincad.fabrication.tolerances import notes
from skincad.solids.mold import mold


@pytest.mark.parametrize(
    ("name", "part", "says"),
    [
        (
            "yamada-2002",
            "cavity",
            "Wire: Ø0.08 at most, for inner corners of radius 0.05; 0.01 a side sparks",
        ),
        ("yamada-2002", "end-a-comb", "Wire: Ø0.04 at most, for a 0.06 wide notch of a shim; 0.01 a side"),
        ("milled-pad", "cavity", "Ball-end mill: Ø0.5 at most, for inner corners of radius 0.25."),
    ],
)
def test_the_thickest_cutter_is_named(name: str, part: str, says: str) -> None:
    """By hand: 2 x 0.05 - 2 x 0.01, 0.06 - 2 x 0.01, and 2 x 0.25."""
    design = skincad.load(name)
    assert any(row.startswith(says) for row in notes(design, mold(design).part(part)))


def test_nothing_is_cut_of_a_print_or_with_no_room_for_a_wire() -> None:
    printed, narrow = skincad.load("lab-bench"), skincad.load("yamada-2002", ["ridge.tip_fillet=0.01"])
    for design, part in ((printed, "end-a-comb"), (narrow, "cavity")):
        assert not any("at most, for" in row for row in notes(design, mold(design).part(part)))
