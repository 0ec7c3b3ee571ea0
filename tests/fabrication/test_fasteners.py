"""Screws and dowels as a mold's parts have holes for them."""

from __future__ import annotations

import pytest

import skincad
from skincad.fabrication import Job
from skincad.fabrication.fasteners import PIN_LENGTHS, cover_screws, dowels, end_screws, pin_length
from skincad.solids import END_PLATES, LENGTHS, PINS, CutRole, PartRole, bores
from skincad.solids.mold import mold
from tests.families import RIDGED
from tests.templates import of_one_printer


@pytest.mark.parametrize("name", RIDGED)
def test_each_hole_has_its_screw_and_each_pin_its_dowel(name: str) -> None:
    design = skincad.load(name)
    closed = mold(design)
    ends, lid = end_screws(Job(design, closed)), cover_screws(Job(design, closed))
    plates = [plate for plate in closed.of(*END_PLATES) if plate.end == "a"]
    assert ends.pieces == sum(len(bores(plate, CutRole.END_BOLT)) for plate in plates)
    assert ends.length in LENGTHS or ends.rod
    assert ends.length > design.skin.length + 2 * design.mold.end_plate
    holes = bores(closed.first(PartRole.COVER), CutRole.COVER_BOLT)
    assert (lid.pieces if lid else 0) == len(holes)
    assert lid is None or lid.length in LENGTHS
    assert sum(dowels(closed).values()) == len(closed.of(*PINS))


def test_a_screw_through_both_plates_ends_in_a_nut_or_in_the_second() -> None:
    by_wire, printed = (of_one_printer(name) for name in ("yamada-2002", "lab-bench"))
    assert end_screws(Job(by_wire)).nuts == 0
    screws = end_screws(Job(printed))
    assert (screws.rod, screws.nuts) == (True, 2 * screws.pieces)  # M3 screws end at 30 mm
    short = end_screws(Job(of_one_printer("lab-bench", ["skin.length=15.0"])))
    assert (short.rod, short.nuts) == (False, short.pieces)


def test_a_doubly_curved_molds_plates_are_screwed_to_its_cavity() -> None:
    design = skincad.load("yamada-2002", ["skin.curvature_radius_y=200"])
    closed = mold(design)
    screws = end_screws(Job(design, closed))
    assert (screws.pieces, screws.nuts) == (len(bores(closed.part("cavity"), CutRole.END_THREAD)), 0)
    assert screws.length < design.skin.length


def test_a_pin_is_the_longest_that_its_hole_takes() -> None:
    assert [pin_length(most) for most in (8.8, 9.9, 10.0, 35.0)] == [8.0, 8.0, 10.0, PIN_LENGTHS[-1]]
    assert pin_length(3.4) == 3.4  # none is so short: it is cut
