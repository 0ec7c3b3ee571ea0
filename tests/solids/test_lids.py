"""Carrier and cover: every bore inside its part, clear of the others, and where it has to be."""

from __future__ import annotations

import math
from functools import cache
from itertools import combinations

import pytest

import skincad
from skincad.base import InputError
from skincad.inputs import Design
from skincad.shape import section
from skincad.solids import TAP_RADIUS, CutRole, Layout, bores, scaled_for_shrinkage
from skincad.solids.layout import BOLT_RADIUS, EDGE, layout
from skincad.solids.lids import LEAST_VENT, MOST_HOLES, carrier, cover, cover_dowels, refused_lids
from tests.families import RIDGED
from tests.solids.test_mounts import at

BARE = {"slot": None, "film": None, "contact": {"film": None}}
CHANGES = {
    "plain": {},
    "long": {"skin": {"length": 90.0}},
    "short": {"skin": {"length": 10.0}},
    "play": {"mold": {"clearance": 0.3}},
    "end": {"mold": {"end_plate": 1.5}},
    "vent": {"mold": {"vent": 2.0}},
    "thin": {"mold": {"carrier_thickness": 2.9}},
}


def planned(name: str, change: str) -> tuple[Design, Layout]:
    """What is poured, flat and without slots, and where its mold's bores lie."""
    design = skincad.load(name).with_(**BARE).with_(**CHANGES[change])
    design = scaled_for_shrinkage(design.with_(mold={"cavities": 1}))
    return design, layout(design, section(design))[0]


@cache
def possible() -> list[tuple[Design, Layout]]:
    plans = [planned(name, change) for name in RIDGED[::3] for change in CHANGES]
    return [plan for plan in plans if not list(refused_lids(*plan))]


def test_holes_of_a_carrier_lie_inside_it_and_apart() -> None:
    cases = possible()
    assert len(cases) > 15
    for design, place in cases:
        part = carrier(design, place)
        back, gap = part.body, design.mold.clearance
        long, wide = place.end - gap, place.trough - gap
        assert {s.start for s in back.outline} == {(x, y) for x in (-wide, wide) for y in (-long, long)}
        assert (back.low, back.high) == (0.0, place.back)
        (vent,), rivets, pulls = (bores(part, role) for role in (CutRole.VENT, CutRole.RIVET, CutRole.PULL))
        for hole in (vent, *rivets):
            assert (hole.start[2], hole.length) == (0.0, place.back)  # through
            assert abs(hole.start[0]) + hole.radius < design.skin.width / 2  # on the skin's back
        for hole in rivets:
            assert hole.far_radius > hole.radius  # holds like a rivet
            assert abs(hole.start[1]) + hole.far_radius <= place.end - EDGE + 1e-9
            assert abs(hole.start[0]) + hole.radius <= design.skin.width / 2 - EDGE + 1e-9
            assert any(math.dist((-hole.start[0], hole.start[1]), at(other)) < 1e-9 for other in rivets)
        for one, other in combinations((vent, *rivets), 2):
            assert math.dist(at(one), at(other)) > one.far_radius + other.far_radius + EDGE / 2
        assert len(rivets) <= 1.5 * MOST_HOLES  # a row and a column more than the area has
        assert vent.start[1] + vent.radius == pytest.approx(long - EDGE / 2, abs=1e-9)
        for pull in pulls:
            assert abs(pull.start[1]) + pull.radius <= long - EDGE + 1e-9
            assert abs(pull.start[0]) + pull.radius == pytest.approx(wide - EDGE, abs=1e-9)
            assert pull.start[2] >= 1.0  # over the silicone
            assert pull.start[2] + pull.length == place.back
            for other in (vent, *rivets):
                assert math.dist(at(pull), at(other)) > TAP_RADIUS + other.far_radius + EDGE / 2
        assert [at(pull) for pull in pulls[1:]] == [(-pull.start[0], -pull.start[1]) for pull in pulls[:1]]


def test_pull_holes_go_aside_as_far_as_they_must_and_a_carrier_ends() -> None:
    """One at the middle is the best; a carrier so full that they would leave it has none."""
    design, place = planned("yamada-2002", "long")
    empty = design.with_(mold={"carrier": "plain"})
    wide = place._replace(trough=40.0)
    assert [p.start[1] for p in bores(carrier(empty, wide), CutRole.PULL)] == [0.0, 0.0]
    for length in (4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 12.0, 15.0, 20.0):
        for gap in (0.0, 0.5):
            play = empty.with_(mold={"clearance": gap, "vent": 0.5, "reservoir": None})
            for trough in (TAP_RADIUS + EDGE + gap + 0.55, 2 * TAP_RADIUS + 1.6 * EDGE + gap, 6.0):
                short = place._replace(end=length / 2, trough=trough)
                pulls = bores(carrier(play, short), CutRole.PULL)
                assert pulls or trough < 6.0 or length < 12.0
                for pull in pulls:
                    assert abs(pull.start[1]) <= length / 2 - gap - TAP_RADIUS - EDGE
                    assert 2 * abs(pull.start[0]) >= 2 * TAP_RADIUS + EDGE  # they are apart
    thin = place._replace(back=2.99)
    assert bores(carrier(empty, thin._replace(trough=40.0)), CutRole.PULL) == []
    assert len(bores(carrier(empty, thin._replace(trough=40.0, back=3.0)), CutRole.PULL)) == 2


def test_holes_make_way_for_threads_to_pull_by_as_long_as_half_stay() -> None:
    design, place = planned("cast-in", "plain")
    part = carrier(design, place)
    pulls, rivets = bores(part, CutRole.PULL), bores(part, CutRole.RIVET)
    assert (len(pulls), len(rivets)) == (2, 10)  # of 14
    assert all(math.dist(at(p), at(r)) > TAP_RADIUS + r.far_radius + EDGE / 2 for p in pulls for r in rivets)
    assert len(bores(cover(design, place), CutRole.BLEED)) == 10
    tiny, narrow = planned("steep-fingertip", "plain")
    assert bores(carrier(tiny, narrow), CutRole.PULL) == []
    assert len(bores(carrier(tiny, narrow), CutRole.RIVET)) == 1


def test_the_cup_covers_vent_and_gap_and_clears_bolts_and_edges() -> None:
    for design, place in possible():
        lid, vent = cover(design, place), bores(carrier(design, place), CutRole.VENT)[0]
        (cup,) = bores(lid, CutRole.RESERVOIR)
        assert (cup.start[2], cup.length) == (place.top, place.lid)
        assert math.dist(at(cup), at(vent)) + vent.radius <= cup.radius + 1e-9
        assert cup.start[1] + cup.radius > place.end + 0.2  # the gap, should the cover sit aside
        assert cup.far_radius >= cup.radius
        assert cup.start[1] + cup.far_radius <= place.cover - EDGE / 2 + 1e-9
        for bolt in bores(lid, CutRole.COVER_BOLT):
            assert bolt.radius == BOLT_RADIUS
            for x in place.centres:
                assert abs(bolt.start[0] - x) >= cup.far_radius + BOLT_RADIUS + EDGE - 1e-9


def test_each_rivet_hole_has_its_bleed_at_the_highest_point_of_its_rim() -> None:
    """While it is poured, end b is up: the bleed touches the rim from inside there."""
    for design, place in possible():
        lid, rivets = cover(design, place), bores(carrier(design, place), CutRole.RIVET)
        bleeds, (cup,) = bores(lid, CutRole.BLEED), bores(lid, CutRole.RESERVOIR)
        assert len(bleeds) == len(rivets)
        for hole, bleed in zip(rivets, bleeds, strict=True):
            assert bleed.start[0] == hole.start[0]
            assert bleed.start[1] + bleed.radius == pytest.approx(hole.start[1] + hole.far_radius, abs=1e-12)
            assert math.dist(at(bleed), at(cup)) > bleed.radius + cup.far_radius + EDGE / 2
            assert (bleed.start[2], bleed.length) == (place.top, place.lid)


def test_a_cover_lies_on_the_block_and_its_pins_end_a_clearance_before_their_holes_do() -> None:
    for design, place in possible():
        lid = cover(design, place)
        corners = {s.start for s in lid.body.outline}
        assert corners == {(x, y) for x in (-place.half, place.half) for y in (-place.cover, place.cover)}
        assert (lid.body.low, lid.body.high) == (place.top, place.top + place.lid)
        pins = [part.body for part in cover_dowels(design, place)]
        for pin, hole in zip(pins, bores(lid, CutRole.COVER_PIN), strict=True):
            assert at(pin) == at(hole)
            assert pin.start[2] + pin.length == pytest.approx(lid.body.high, abs=1e-12)  # flush
            assert place.top - pin.start[2] == pytest.approx(6.0 - design.mold.clearance, abs=1e-12)


def test_a_vent_is_the_usual_one_or_the_largest_tenth_that_fits() -> None:
    design, place = planned("yamada-2002", "plain")
    gap = design.mold.clearance
    for long in (20.0, 3.6, 3.35, 3.1):
        short = place._replace(end=long / 2, cover=long / 2 + design.mold.end_plate)
        (vent,) = bores(carrier(design.with_(mold={"carrier": "plain"}), short), CutRole.VENT)
        room = long - 2 * (gap + EDGE)
        wide = 2 * vent.radius
        assert wide == pytest.approx(min(1.0, round(wide, 1)), abs=1e-12)
        assert wide <= room
        assert wide == 1.0 or wide + 0.1 > room
    tight = 2 * (gap + EDGE) + LEAST_VENT
    (refused,) = refused_lids(design, place._replace(end=(tight - 0.01) / 2))
    assert refused.key == "skin.length"
    assert f"leaves {LEAST_VENT - 0.01:.4g} mm for the vent" in str(refused)
    narrow = design.model_copy(update={"skin": design.skin.model_copy(update={"width": tight - 0.01})})
    (refused,) = refused_lids(narrow, place)
    assert refused.key == "skin.width"
    (refused,) = refused_lids(design.with_(mold={"vent": 1.8}), place._replace(end=2.0))
    assert str(refused).startswith(f"mold.vent: must be at most {4.0 - 2 * (gap + EDGE):.4g} mm")


def test_a_reservoir_is_refused_outside_the_range_told_and_taken_at_its_ends() -> None:
    design, place = planned("yamada-2002", "plain")
    with pytest.raises(InputError, match="over vent and gap and clear of the bolts") as refused:
        cover(design.with_(mold={"reservoir": 1.0}), place)
    words = str(refused.value).split()
    low, high = float(words[4]), float(words[6])
    for diameter in (low + 0.01, high - 0.01):
        (cup,) = bores(cover(design.with_(mold={"reservoir": diameter}), place), CutRole.RESERVOIR)
        assert cup.far_radius == diameter / 2
    for wrong in (low - 0.01, high + 0.01, 50.0):
        (again,) = refused_lids(design.with_(mold={"reservoir": wrong}), place)
        assert again.rule == refused.value.rule  # whatever was asked


def test_a_carrier_without_room_for_holes_is_plain_unless_holes_were_asked_for() -> None:
    design, place = planned("yamada-2002", "plain")
    short = place._replace(end=2.0)
    assert bores(carrier(design.with_(mold={"carrier": None}), short), CutRole.RIVET) == []
    with pytest.raises(InputError, match=r"^mold.carrier: leaves no room"):
        carrier(design.with_(mold={"carrier": "perforated"}), short)
    plain = design.with_(mold={"carrier": "plain"})
    assert bores(carrier(plain, place), CutRole.RIVET) == bores(cover(plain, place), CutRole.BLEED) == []
