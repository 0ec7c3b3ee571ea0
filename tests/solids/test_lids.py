"""Carrier and cover: every bore, a mount's too, inside its part, clear of the others and of the silicone."""

from __future__ import annotations

import cmath
import math
from functools import cache
from itertools import combinations, permutations, product
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.fabrication import manifold
from skincad.inputs import Design
from skincad.shape import section
from skincad.solids import (
    TAP_RADIUS,
    Bore,
    ClosedMold,
    CutRole,
    Layout,
    PartRole,
    bores,
    scaled_for_shrinkage,
    solid,
    volume,
)
from skincad.solids.layout import layout
from skincad.solids.lids import carrier, cover, cover_dowels, fiducial_bores, refused_lids
from skincad.solids.mold import mold
from tests.designs import IN_LINE, KINDS, MOUNTS, NAMES, RIDGED, mounted_design

BOLT_RADIUS, EDGE, LEAST_VENT = 1.7, 1.2, 0.3  # mm: ISO 273, M3; between bores; what a drill makes straight
MOST_HOLES = 24
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


def at(bore: Bore) -> tuple[float, float]:
    return bore.start[0], bore.start[1]


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


def test_holes_make_way_for_threads_to_pull_by_and_a_carrier_without_room_is_plain() -> None:
    design, place = planned("cast-in", "plain")
    part = carrier(design, place)
    pulls, rivets = bores(part, CutRole.PULL), bores(part, CutRole.RIVET)
    assert (len(pulls), len(rivets)) == (2, 10)  # of 14
    assert all(math.dist(at(p), at(r)) > TAP_RADIUS + r.far_radius + EDGE / 2 for p in pulls for r in rivets)
    assert len(bores(cover(design, place), CutRole.BLEED)) == 10
    tiny, narrow = planned("steep-fingertip", "plain")
    assert bores(carrier(tiny, narrow), CutRole.PULL) == []
    assert len(bores(carrier(tiny, narrow), CutRole.RIVET)) == 1
    design, place = planned("yamada-2002", "plain")
    short = place._replace(end=2.0)
    assert bores(carrier(design.with_(mold={"carrier": None}), short), CutRole.RIVET) == []
    with pytest.raises(InputError, match=r"^mold.carrier: leaves no room"):
        carrier(design.with_(mold={"carrier": "perforated"}), short)
    plain = design.with_(mold={"carrier": "plain"})
    assert bores(carrier(plain, place), CutRole.RIVET) == bores(cover(plain, place), CutRole.BLEED) == []


def test_a_cover_lies_on_the_block_with_its_cup_bleeds_and_pins() -> None:
    for design, place in possible():
        lid, plate = cover(design, place), carrier(design, place)
        assert {s.start for s in lid.body.outline} == set(
            product(*((-a, a) for a in (place.half, place.cover)))
        )
        assert (lid.body.low, lid.body.high) == (place.top, place.top + place.lid)
        # the cup covers vent and gap, should the cover sit aside too, and clears bolts and edges
        (vent,), rivets = bores(plate, CutRole.VENT), bores(plate, CutRole.RIVET)
        (cup,) = bores(lid, CutRole.RESERVOIR)
        assert (cup.start[2], cup.length) == (place.top, place.lid)
        assert math.dist(at(cup), at(vent)) + vent.radius <= cup.radius + 1e-9
        assert cup.start[1] + cup.radius > place.end + 0.2
        assert cup.far_radius >= cup.radius
        assert cup.start[1] + cup.far_radius <= place.cover - EDGE / 2 + 1e-9
        for bolt in bores(lid, CutRole.COVER_BOLT):
            assert bolt.radius == BOLT_RADIUS
            for x in place.centres:
                assert abs(bolt.start[0] - x) >= cup.far_radius + BOLT_RADIUS + EDGE - 1e-9
        # while it is poured, end b is up: a bleed touches its rivet's rim from inside there
        for hole, bleed in zip(rivets, bores(lid, CutRole.BLEED), strict=True):
            assert bleed.start[0] == hole.start[0]
            assert bleed.start[1] + bleed.radius == pytest.approx(hole.start[1] + hole.far_radius, abs=1e-12)
            assert math.dist(at(bleed), at(cup)) > bleed.radius + cup.far_radius + EDGE / 2
            assert (bleed.start[2], bleed.length) == (place.top, place.lid)
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


HOLES = (CutRole.MOUNT, CutRole.MOUNT_PIN, CutRole.FIDUCIAL)
SLACK = 1e-9  # mm, rounding


MOUNTED = [*KINDS, "bent"]


def requested(design: Design) -> list[tuple[float, float]]:
    """Where the keys say that screws are, by another formula than the program's."""
    mount = design.mount
    if mount.thread is None:
        return []
    if mount.diameter:
        count = mount.count or 4
        first = math.radians(180 / count if mount.angle is None else mount.angle)
        turns = [cmath.rect(mount.diameter / 2, first + 2 * math.pi * i / count) for i in range(count)]
        return [(z.real, z.imag) for z in turns]
    xs, ys = ({-(w or 0) / 2, (w or 0) / 2} for w in (mount.pitch_x, mount.pitch_y))
    return [(x, y) for x in xs for y in ys]


def web(one: Bore, other: Bore) -> float:
    return math.dist(at(one), at(other)) - one.far_radius - other.far_radius


def sides(closed: ClosedMold) -> tuple[float, float]:
    """Half of the width and length of the carrier's top, mm, as its mesh has them."""
    mesh = manifold(closed.first(PartRole.CARRIER), 1e-3)
    points = np.asarray(mesh.to_mesh().vert_properties)[:, :3]
    top = points[points[:, 2] > points[:, 2].max() - 1e-6]
    return float(top[:, 0].max()), float(top[:, 1].max())


@pytest.mark.parametrize("name", MOUNTED)
def test_holes_lie_where_the_keys_say_inside_and_apart(name: str) -> None:
    design = mounted_design(name)
    closed = mold(design)
    part, over = closed.part("carrier"), closed.part("cover")
    assert len(bores(over, CutRole.BLEED)) == len(bores(part, CutRole.RIVET))
    screws, all_holes = bores(part, CutRole.MOUNT), bores(part, *HOLES, CutRole.PULL)
    places = requested(design)
    assert len(screws) == len(places) > 0
    assert all(min(math.dist(at(screw), place) for place in places) < SLACK for screw in screws)
    assert len(bores(part, CutRole.MOUNT_PIN)) == (design.mount.pin is not None)
    assert len(bores(part, CutRole.FIDUCIAL)) == design.mount.fiducials
    high = max(bore.start[2] + bore.length for bore in bores(part, CutRole.VENT))
    x, y = sides(closed)
    bent = part.body.grid.centre if part.body.grid else math.inf
    (cup,) = bores(over, CutRole.RESERVOIR)
    for hole in bores(part, *HOLES):
        reach = abs(hole.start[1]) + hole.radius
        under = bent - math.sqrt(bent**2 - reach**2) if part.body.grid else 0.0  # of an arc, over its middle
        assert hole.start[2] - under >= 1.0 - SLACK  # over the silicone
        assert hole.start[2] + hole.length == high  # to the last bit: a film would stay in the mesh
        assert abs(hole.start[0]) + hole.radius <= x - 1.2 + 1e-5  # the mesh's vertices are single
        assert reach <= y - 1.2 + 1e-5
        for other in (*bores(part, CutRole.VENT, CutRole.RIVET), *bores(over, CutRole.BLEED)):
            assert web(hole, other) >= 0.6 - SLACK
        assert math.dist(at(hole), at(cup)) - hole.radius - cup.radius >= 0.6 - SLACK
    for one, other in combinations(all_holes, 2):
        least = 0.6 if CutRole.FIDUCIAL in (one.role, other.role) else 1.2
        assert web(one, other) >= least - SLACK


# of yamada-2002 and of a bowl the contract of all kinds asks
@pytest.mark.evidence(subject="{name}")
@pytest.mark.parametrize("name", [name for name in NAMES if name not in ("yamada-2002", "bent")])
def test_the_kernel_finds_the_plans_volume(name: str) -> None:
    part = mold(mounted_design(name)).part("carrier")
    assert volume(part, solid(part)) == pytest.approx(part.volume, rel=1e-9)  # the kernel's quadrature


def test_each_carrier_of_a_gang_has_its_own() -> None:
    one = mold(mounted_design("yamada-2002"))
    two = mold(mounted_design("yamada-2002").with_(mold={"cavities": 2}))
    carriers = two.of(PartRole.CARRIER)
    assert len(carriers) == 2
    alone = sorted(at(hole) for hole in bores(one.part("carrier"), *HOLES))
    for part in carriers:
        (vent,) = bores(part, CutRole.VENT)
        there = sorted((x - vent.start[0], y) for x, y in map(at, bores(part, *HOLES)))
        assert np.allclose(there, alone, atol=1e-9)
        assert solid(part).Volume() == pytest.approx(part.volume, rel=1e-9)


def misfit(seen: np.ndarray[Any, Any], drawn: np.ndarray[Any, Any]) -> float:
    """The largest distance that the best turn and shift leave (Kabsch 1976, in the plane)."""
    a, b = ((row - row.mean(axis=0)) @ np.array([1, 1j]) for row in (seen, drawn))
    turn = np.vdot(a, b)
    return float(np.abs(a * turn / abs(turn) - b).max())


@pytest.mark.parametrize("name", [n for n in NAMES if MOUNTS[n][0].get("fiducials")])
def test_a_camera_knows_a_turned_carrier(name: str) -> None:
    """Of all ways to match what is seen with what is drawn only the right one fits within half a dimple."""
    part = mold(mounted_design(name)).part("carrier")
    drawn = np.array([at(hole) for hole in bores(part, CutRole.FIDUCIAL)])
    fits = [order for order in permutations(range(len(drawn))) if misfit(drawn[list(order)], drawn) < 0.5]
    assert fits == [tuple(range(len(drawn)))]


def test_a_carrier_is_computed_as_thick_as_its_mount_asks_or_refused() -> None:
    plain = skincad.load("yamada-2002")
    for name, top in (("M2", 6.0), ("M3", 7.5)):  # 2 + 1 + 2 and 3 + 1 + 2.5, and 1 over the silicone
        mount = {**IN_LINE, "thread": name, "pitch_x": 10.0}
        assert mold(plain.with_(mount=mount, mold={"carrier": "plain"})).part("carrier").body.high == top
    exact = plain.with_(mount=IN_LINE, mold={"carrier_thickness": 6.0})
    assert mold(exact).part("carrier").body.high == 6.0
    with pytest.raises(InputError) as refused:
        mold(plain.with_(mount=IN_LINE, mold={"carrier_thickness": 5.9}))
    words = "must be at least 6 mm, for the mount's M2 threads over 1 mm that stay"
    assert str(refused.value).startswith(f"mold.carrier_thickness: {words}")


REFUSED = [
    ("yamada-2002", {"thread": "M3", "diameter": 20.0}, "mount.diameter: must be at most 10.029 mm"),
    ("yamada-2002", {**IN_LINE, "pitch_x": 14.0},
     "mount.pitch_x: must be at most 11 mm, for 1.2 mm between a thread and"),
    ("yamada-2002", {"thread": "M2", "pattern": "rectangle", "pitch_y": 7.0},
     "mount.pitch_y: puts a thread at"),
    ("yamada-2002", {**IN_LINE, "pitch_x": 2.0},
     "mount.pitch_x: puts a thread at (1, 0) 0.4 mm from a thread"),
    ("gripper-pad", {"thread": "M3", "diameter": 20.0, "angle": 0.0, "pin": 2.0},
     "mount.pin: puts the pin's"),
    ("yamada-2002", {"thread": "M2", "diameter": 8.0}, "mount.diameter: is in the way of 4 of the 4 holes"),
    ("yamada-2002", {"fiducials": 3, "fiducial_diameter": 6.0},
     "mount.fiducials: finds no room for a dimple"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "mount", "words"), REFUSED)
def test_what_has_no_room_is_told(name: str, mount: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError) as refused:
        mold(skincad.load(name).with_(mount=mount))
    assert str(refused.value).startswith(words)
    assert refused.value.remedy
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["gripper-pad", "milled-pad"])
def test_the_most_that_is_told_is_taken_and_no_more(name: str) -> None:
    plain = skincad.load(name).with_(mold={"carrier": "plain"})

    def screws(diameter: float) -> list[Bore]:
        mount = {"thread": "M2", "diameter": diameter, "count": 2, "angle": 10.0}
        return bores(mold(plain.with_(mount=mount)).part("carrier"), CutRole.MOUNT)

    with pytest.raises(InputError) as refused:
        screws(500.0)
    most = float(str(refused.value).split("at most ")[1].split()[0])
    assert len(screws(most)) == 2
    with pytest.raises(InputError):
        screws(most + 0.002)


def test_a_dimple_is_refused_rather_than_drawn_to_the_middle() -> None:
    """All but the carrier's inner third is taken: three there would lie too near to each other to tell."""
    design = scaled_for_shrinkage(skincad.load("gripper-pad").with_(mount={"fiducials": 3}))
    place = layout(design, section(design))[0]
    x, y = place.trough - 1.7, place.end - 1.7  # of a corner's dimple, about
    free = 0.3 * math.hypot(x, y)
    ring = [cmath.rect(math.hypot(x, y), math.radians(2 * i)) for i in range(180)]
    occupied = [((z.real, z.imag, 0.0), math.hypot(x, y) - free) for z in ring]
    with pytest.raises(InputError, match=r"^mount.fiducials: finds no room"):
        fiducial_bores(design, place, occupied)
    assert len(fiducial_bores(design, place, [])) == 3
