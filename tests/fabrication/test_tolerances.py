"""What a shop drawing says of a part as a whole."""

from __future__ import annotations

import pytest

import skincad
from skincad.fabrication import Job
from skincad.fabrication.part_drawing import notes, surface_words, what_matters
from skincad.inputs import processes
from skincad.solids.mold import mold
from tests.templates import of_one_printer


@pytest.mark.parametrize(
    ("name", "part", "says"),
    [
        (
            "yamada-2002",
            "cavity",
            "Wire Ø0.03 with a spark gap of 0.01 a side: for inner corners of radius 0.05, with 0.025",
        ),
        (
            "yamada-2002",
            "end-a-comb",
            "Wire Ø0.03 with a spark gap of 0.01 a side: for a 0.06 wide notch of a shim, with 0.005",
        ),
        ("milled-pad", "cavity", "Ball-end mill Ø0.5: as wide as inner corners of radius 0.25."),
    ],
)
def test_the_cutter_is_named_with_what_it_leaves_for_trim_cuts(name: str, part: str, says: str) -> None:
    """By hand: 0.05 - 0.025, 0.03 - 0.025, and 0.25 - 0.25."""
    design = skincad.load(name)
    assert any(row.startswith(says) for row in notes(Job(design), mold(design).part(part)))


def test_nothing_is_cut_of_a_print_or_with_no_room_for_a_wire() -> None:
    printed, narrow = of_one_printer("lab-bench"), skincad.load("yamada-2002", ["ridge.tip_fillet=0.01"])
    for design, part in ((printed, "end-a-comb"), (narrow, "cavity")):
        assert not any("trim cuts" in row for row in notes(Job(design), mold(design).part(part)))


def test_slits_and_seat_are_told_as_they_come_out() -> None:
    """Growth of 0.002 on a comb's walls, and on both parts that slide: 0.005 and mold.clearance less that."""
    design = skincad.load("yamada-2002")
    grown = design.with_(printer={"edm": {"growth": 0.002}})
    comb, carrier = mold(grown).part("end-a-comb"), mold(grown).part("carrier")
    assert any("Slits: 0.003 a side" in row for row in what_matters(Job(grown), comb, None))
    assert any(
        "(0.005 as drawn, less growth and coat)" in row for row in what_matters(Job(grown), comb, None)
    )
    left = f"Length and width: {design.mold.clearance - 0.004:.4g} a side to its seat"
    assert any(row.startswith(left) for row in what_matters(Job(grown), carrier, None))
    assert not any("as drawn" in row for row in what_matters(Job(design), comb, None))
    tight = design.with_(printer={"edm": {"growth": 0.003}})  # leaves 0.002, and ± 0.003 is the process
    assert any("does not keep that gap" in row for row in what_matters(Job(tight), comb, None))


@pytest.mark.parametrize("name", ["fdm", "sla", "cnc", "edm"])
def test_each_process_says_how_rough_its_faces_are(name: str) -> None:
    design = skincad.load("plain-ridges", [f"mold.process={name}"])
    part = mold(design).part("cavity")
    rough = processes()[name].roughness
    assert rough > 0
    cut = not processes()[name].layer  # the general one; faces on the silicone have the process's own
    assert surface_words(Job(design), part) == ("Ra 1.6" if cut else f"Ra {rough:g}")
    accurate = what_matters(Job(design), part, None)[0]
    assert (f", Ra {rough:g}: seat, trough, grooves" in accurate) == cut
    unsaid = design.with_(printer={name: {"roughness": 0.0}})
    assert surface_words(Job(unsaid), part) == ""
