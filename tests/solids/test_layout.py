"""Screws, nuts, pins, pry notches and pull holes: that they fit, and that they open where they should."""

from __future__ import annotations

import math

import pytest

import skincad
from skincad.base import InputError
from skincad.fabrication import manifold
from skincad.inputs import Design, processes
from skincad.shape import section
from skincad.solids import Bore, CutRole, Part, PartRole, Prism, bores, fits, scaled_for_shrinkage
from skincad.solids.layout import NUT_FLATS, layout
from skincad.solids.mold import mold
from tests.families import RIDGED
from tests.templates import KINDS, of_one_printer

HEIGHT = 2.4  # mm, ISO 4032, M3


def plug(cut: Bore | Prism) -> Part:
    return Part("plug", PartRole.COVER, cut)


def pockets(design: Design) -> list[tuple[Part, Prism]]:
    return [
        (part, cut)
        for part in mold(design).parts
        for cut in part.cuts
        if isinstance(cut, Prism) and cut.axis == "y"
    ]


@pytest.mark.parametrize("name", ["lab-bench", "nozzle-04", "plain-ridges"])
def test_a_nut_goes_into_each_pocket_of_a_printed_end_plate_and_does_not_turn(name: str) -> None:
    nuts = pockets(of_one_printer(name))
    assert len(nuts) == 4
    for part, cut in nuts:
        assert part.name.startswith("end-b")
        assert cut.high == part.body.high  # open outward
        assert cut.high - cut.low >= HEIGHT
        levels = [s.start.z for s in cut.outline]
        flats = max(levels) - min(levels)
        # play as the process needs it, but less than what lets a hexagon turn: corner to corner
        assert NUT_FLATS + 0.2 <= flats + 1e-9 < 2 / math.sqrt(3) * NUT_FLATS


def test_pocket_and_bolt_hole_are_one_way_through_without_a_film(yamada: Design) -> None:
    """Two cuts that meet on a face: by genus one hole each; a film between would make it none."""
    plate = mold(skincad.load("plain-ridges")).part("end-b")
    assert manifold(plate, 1e-3).genus() == 4 + 2  # bolts, pins
    assert pockets(yamada) == []  # wire-cut: tapped


@pytest.mark.parametrize("name", KINDS)
def test_cuts_lie_in_their_part_and_meet_no_other_by_volume(name: str) -> None:
    for part in mold(skincad.load(name)).parts:
        body = manifold(Part("body", PartRole.COVER, part.body), 1e-3)
        plugs = [manifold(plug(cut), 1e-3) for cut in part.cuts]
        for i, one in enumerate(plugs):
            assert (one - body).volume() < 1e-9, (part.name, i)
            assert all((one ^ other).volume() < 1e-9 for other in plugs[i + 1 :]), (part.name, i)


def test_pins_press_and_slide_as_the_process_needs(yamada: Design) -> None:
    known = processes()
    tight = yamada.with_(mold={"clearance": 0.0})
    for name in ("fdm", "sla", "cnc", "edm"):
        holes = fits(tight, name)
        assert holes.slide == 1.0 + known[name].clearance
        # below the pin's radius: metal by what P7 asks for, a print by what is reamed out of it
        assert holes.press == (0.9 if known[name].layer else 0.995)
    assert fits(yamada, "edm").slide == 1.0 + yamada.mold.clearance


def test_holes_of_an_end_plate_are_those_of_its_process(yamada: Design) -> None:
    printed = yamada.with_(mold={"end_plate_process": "fdm", "clearance": 0.0})
    holes = {cut.radius for cut in mold(printed).part("end-a-comb").cuts if isinstance(cut, Bore)}
    assert holes == {1.7, 1.2}


def test_a_screwdriver_finds_a_notch_at_each_side_of_each_end_plate() -> None:
    for name in RIDGED:
        closed = mold(skincad.load(name))
        cavity = closed.part("cavity").body if name != "steep-fingertip" else closed.part("cavity-base").body
        for part in closed.parts:
            nicks = [c for c in part.cuts if isinstance(c, Prism) and c.axis == "z"]
            if not part.name.startswith("end-"):
                assert nicks == []
                continue
            assert isinstance(part.body, Prism)
            outer = part.body.low if part.name.startswith("end-a") else part.body.high
            notches = [c for c in nicks if outer not in {s.start.z for s in c.outline}]  # no marks
            assert len(notches) in (2, 4), (name, part.name)
            for notch in notches:
                corners = [s.start for s in notch.outline]
                assert sum(abs(corner.z) == cavity.high for corner in corners) == 2  # on the parting
                assert notch.high - notch.low >= 3.0


def test_pull_holes_are_blind_and_clear_of_all_that_silicone_fills() -> None:
    without = []
    for name in RIDGED:
        design = skincad.load(name)
        closed = mold(design)
        carrier = closed.part("carrier")
        pulls = [c for c in carrier.cuts if isinstance(c, Bore) and c.start[2] > 0]
        assert len(pulls) in (0, 2)
        without += [name] * (not pulls)
        filled = [c for c in carrier.cuts if c not in pulls]
        inside = [
            c
            for c in closed.part("cover").cuts
            if abs(c.start[0]) < design.skin.width / 2 and c not in filled
        ]
        for pull in pulls:
            assert pull.start[2] + pull.length == carrier.body.high
            for other in (*filled, *inside):
                distance = math.dist(pull.start[:2], other.start[:2])
                wide = max(other.radius, other.end_radius or 0.0) if other in filled else other.radius
                assert distance > pull.radius + wide + 0.2, name
    assert without == ["steep-fingertip"]  # 5 mm wide, with one hole: it is held by its free ends


@pytest.mark.parametrize("end", ["a", "b"])
def test_nicks_tell_where_the_strips_numbers_begin(end: str) -> None:
    closed = mold(skincad.load("yamada-2002"))
    comb = closed.part(f"end-{end}-comb")
    assert isinstance(comb.body, Prism)
    outer = comb.body.low if end == "a" else comb.body.high
    cuts = [c for c in comb.cuts if isinstance(c, Prism) and c.axis == "z"]
    marks = [c for c in cuts if outer in {s.start.z for s in c.outline}]  # a prism along z has (x, y)
    assert len(marks) == {"a": 1, "b": 2}[end]
    for mark in marks:
        assert max(s.start.x for s in mark.outline) < 0  # ridge 1 has the smallest x


@pytest.mark.parametrize("shrinks", [0.0, 0.02])
@pytest.mark.parametrize(
    ("bent", "what"), [(None, "the pins of a mold's cover"), (100.0, "bolts and pins of a mold")]
)
def test_too_short_a_skin_is_told_by_the_length_that_was_written(
    yamada: Design, shrinks: float, bent: float | None, what: str
) -> None:
    """What is poured is longer, and so is what it needs: a skin as long as it is told to be has room."""

    def refused(length: float) -> list[InputError]:
        skin = {"length": length, "curvature_radius_y": bent}
        design = scaled_for_shrinkage(yamada.with_(mold={"shrinkage": shrinks}, skin=skin))
        return [error for error in layout(design, section(design))[1] if error.key == "skin.length"]

    (refusal,) = refused(2.5)
    assert refusal.value == pytest.approx(2.5, rel=1e-9)  # a length is put on a grid of 1e-12 mm
    assert what in str(refusal)
    least = float(str(refusal).split()[5])
    assert refused(least) == []
    (nearly,) = refused(least - 0.002)
    assert f"at least {least:g} mm" in str(nearly)
    # pins of 2 mm with their gap and 0.8 mm beside them, or two rows of screws
    room = 2 * (1.0 + yamada.mold.clearance + 0.8) if bent is None else 9.0
    assert least == pytest.approx((1 - shrinks) * room, abs=1.1e-3)  # rounded up to 1 um


@pytest.mark.parametrize(("thickness", "carrier"), [(3.0, 3.2), (3.0, 3.0), (2.5, 3.5)])
def test_the_least_floor_of_a_split_cavity_leaves_its_pins_apart_in_the_walls(
    thickness: float, carrier: float
) -> None:
    """A wall has the cover's pins from above and the base's from below; 1.2 mm stay between their holes."""
    change = {"skin": {"thickness": thickness}, "slot": None, "film": None, "contact": {"film": None}}
    steep = skincad.load("steep-fingertip").with_(**change, mold={"carrier_thickness": carrier, "floor": 9.0})
    with pytest.raises(InputError, match=r"^mold.floor: must be at least") as refused:
        mold(steep)
    least = float(str(refused.value).split()[5])
    closed = mold(steep.with_(mold={"floor": least}))
    above, below = closed.part("pin-cover-right").body, closed.part("pin-base-right").body
    assert isinstance(above, Bore)
    assert isinstance(below, Bore)
    between = above.start[2] - (below.start[2] + below.length) - 2 * steep.mold.clearance
    assert between == pytest.approx(1.2, abs=1.1e-3)  # the least is rounded up to 1 um
    # and the pieces stand on the base with a foot of 1 mm or more under the deepest ridge
    base, skin = closed.part("cavity-base"), closed.part("skin")
    assert manifold(base, 0.01).bounding_box()[5] + 1.0 <= manifold(skin, 0.01).bounding_box()[2]


def test_holes_to_be_tapped_are_as_wide_as_m3_less_its_pitch() -> None:
    parts = mold(skincad.load("milled-pad")).parts
    for role in (CutRole.END_THREAD, CutRole.PULL):
        wide = {2 * hole.radius for part in parts for hole in bores(part, role)}
        assert wide == {3.0 - 0.5}  # ISO 2306, coarse pitch
