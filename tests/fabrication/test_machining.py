"""Time of what is cut from stock, against blocks by hand."""

from __future__ import annotations

import math

import pytest

import skincad
from skincad.fabrication.estimates import machining
from skincad.inputs import processes
from skincad.shape import Point, loop
from skincad.solids import Bore, Part, PartRole, Prism, RevolvedBody, box, plain
from skincad.solids.mold import mold

CNC, EDM = processes()["cnc"], processes()["edm"]
BLOCK = Part("cover", PartRole.COVER, box(20.0, (-10.0, 10.0), (0.0, 5.0)))  # 40 x 20 x 5
HOLES = tuple(Bore((x, 0.0, 0.0), "z", 5.0, 1.5) for x in (-5.0, 5.0))


def test_a_milled_block() -> None:
    stock = 44.0 * 24.0 * 9.0
    faces = 2 * (40.0 * 20.0 + 40.0 * 5.0 + 20.0 * 5.0)
    effort = machining(BLOCK, CNC)
    assert effort.volume == pytest.approx(stock)
    minutes = (stock - 4000.0) / CNC.removal_rate + faces / CNC.finish_rate
    assert effort.seconds == pytest.approx(60 * minutes)


def test_a_wire_cuts_around_and_no_chips() -> None:
    effort = machining(BLOCK, EDM)
    assert effort.volume == pytest.approx(46.0 * 26.0 * 11.0)
    assert effort.seconds == pytest.approx(60 * (120.0 * 5.0 / EDM.finish_rate))


def test_each_hole_takes_its_time() -> None:
    drilled = Part("cover", PartRole.COVER, BLOCK.body, HOLES)
    more = machining(drilled, EDM).seconds - machining(BLOCK, EDM).seconds
    assert more == pytest.approx(60 * 2 * EDM.hole_time)


def test_notches_of_a_comb_are_cut_by_the_fine_wire() -> None:
    """Two notches of 0.1 x 1 mm: four walls; their bottoms are as long as what they take from the edge."""
    corners = [
        (0, 0),
        (30, 0),
        (30, 8),
        (20.1, 8),
        (20.1, 7),
        (20, 7),
        (20, 8),
        (10.1, 8),
        (10.1, 7),
        (10, 7),
    ]
    outline = loop([Point(*map(float, p)) for p in [*corners, (10, 8), (0, 8)]])
    comb = Part("end-a-comb", PartRole.COMB, Prism(outline, "y", 0.0, 4.0))
    minutes = 76.0 * 4.0 / EDM.finish_rate + 4.0 * 4.0 / EDM.fine_rate
    assert machining(comb, EDM).seconds == pytest.approx(60 * minutes)


def test_the_skins_negative_is_cut_by_the_fine_tool() -> None:
    """A finer rate changes the cavity's time by the trough's own outline, and no lid's."""
    closed = mold(skincad.load("yamada-2002"))
    slower = EDM.model_copy(update={"fine_rate": EDM.fine_rate / 2})
    cavity, cover = closed.part("cavity"), closed.part("cover")
    assert machining(cover, slower) == machining(cover, EDM)
    assert isinstance(cavity.body, Prism)
    trough = math.fsum(s.length for s in cavity.body.outline if s.kind != "other")
    long = cavity.body.high - cavity.body.low
    more = machining(cavity, slower).seconds - machining(cavity, EDM).seconds
    assert more == pytest.approx(60 * trough * long / EDM.fine_rate)


def test_a_bowls_trough_is_fine_work_too() -> None:
    design = skincad.load("yamada-2002", ["skin.curvature_radius_y=60"])
    cavity, slower = mold(design).part("cavity"), CNC.model_copy(update={"fine_rate": CNC.fine_rate / 2})
    (trough,) = (cut for cut in map(plain, cavity.cuts) if isinstance(cut, RevolvedBody))
    long = trough.centre * (trough.high - trough.low)  # of its back's arc
    area = math.fsum(s.length for s in trough.outline if s.kind != "other") * abs(long)
    more = machining(cavity, slower).seconds - machining(cavity, CNC).seconds
    assert more == pytest.approx(60 * area / CNC.fine_rate)
    assert area > 11.0 * 12.0  # more than the skin's back
