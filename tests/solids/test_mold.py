"""The mold of a straight skin, of several in one block, and of one whose cavity is split."""

from __future__ import annotations

import math

import numpy as np
import pytest

import skincad
from skincad.base import InputError
from skincad.fabrication import Job, design_findings, interference, manifold, poured_volume
from skincad.fabrication.filling import pockets
from skincad.inputs import Design
from skincad.shape import area, polygon, rectangle, section, skin_of
from skincad.solids import (
    STUB,
    Bore,
    ClosedMold,
    CutRole,
    Move,
    Part,
    PartRole,
    bores,
    box,
    safe_strain,
    split_ridges,
)
from skincad.solids.mold import mold
from tests.designs import KINDS, of_one_printer, three_ridges
from tests.solids.kinds import few_ridges, many_locked

BOLT_RADIUS = 1.7  # mm, ISO 273, M3, medium series
LEDGE, NUT_DEPTH = 2.0, 2.75  # mm, the seat under a carrier; ISO 4032, M3, and some play


def test_interference_sees_a_shim_that_is_too_thick() -> None:
    closed, thicker = mold(few_ridges()), mold(few_ridges(slot={"thickness": 0.08}))
    parts = tuple(thicker.part(p.name) if p.name.startswith("shim") else p for p in closed.parts)
    findings = interference(ClosedMold(parts, ()), 1e-3)
    assert {f.rule for f in findings} == {"interference"}
    assert any("end-a-comb" in f.where for f in findings)


@pytest.mark.parametrize("name", KINDS)
def test_gate_and_vent_open_on_the_skin(name: str) -> None:
    closed = mold(skincad.load(name))
    skin = manifold(closed.part("skin"), 1e-3)
    upper = next(p for p in closed.parts if p.name in ("end-a", "end-a-keeper"))
    vent = closed.part("carrier").cuts[0]
    for bore, step in ((upper.cuts[-1], (0.0, 1e-3, 0.0)), (vent, (0.0, 0.0, -1e-3))):
        plug = manifold(Part("plug", PartRole.COVER, bore), 1e-3)
        opening = (plug.translate(step) ^ skin).volume() / (math.pi * bore.radius**2 * 1e-3)
        assert opening == pytest.approx(1.0, abs=0.01)  # a polygon for the circle


def test_cavity_and_skin_fill_the_trough_between_them(yamada: Design) -> None:
    yamada = yamada.with_(mold={"shrinkage": 0.0, "floor": 9.0})
    closed = mold(yamada)
    cavity, skin = manifold(closed.part("cavity"), 1e-4), manifold(closed.part("skin"), 1e-4)
    shims = sum(manifold(p, 1e-4).volume() for p in closed.parts if p.name.startswith("shim")) * 12 / 32
    high = 4.0 + 0.7 * 1.0  # carrier and seal
    block = 37.0 * 12.0 * (high + section(yamada).top + 9.0)
    seat = 2 * (5.5 + LEDGE + yamada.mold.clearance) * 12.0 * high
    bores = sum(c.volume for c in closed.part("cavity").cuts)
    total = cavity.volume() + skin.volume() + shims + seat + bores
    assert total == pytest.approx(block, abs=0.08)  # bores as chords: 1e-4 mm x 800 mm2 of walls


def test_plates_and_pieces_have_the_holes_they_need(yamada: Design) -> None:
    """Genus counts through holes, so that no bore ends in a film that a volume doesn't show."""
    closed = mold(yamada)
    genus = {p.name: manifold(p, 1e-3).genus() for p in closed.parts if p.made != "bought"}
    ends = {"end-a-comb": 4, "end-a-keeper": 3, "end-b-comb": 4, "end-b-keeper": 2}
    assert genus == {"skin": 18, "cavity": 4, **ends, "carrier": 5, "cover": 9}
    # of a gang bolts in count + 1 lanes, a gate for each skin
    closed = mold(few_ridges(mold={"cavities": 4}))
    genus = {p.name: manifold(p, 1e-3).genus() for p in closed.parts if p.made == "made"}
    assert genus["cavity"] == 2 * 5
    assert genus["end-a-comb"] == 5 + 2
    assert genus["end-a-keeper"] == 5 + 4
    assert genus["cover"] == 2 + 5 + 4 * 2  # pins, a bolt a row; reservoir and bleed each
    # of pieces a y bolt a lane, and z bolts, which end in threads through the base
    closed = mold(skincad.load(STEEP))
    genus = {p.name: manifold(p, 1e-3).genus() for p in closed.parts if p.name.startswith("cavity")}
    assert genus == {"cavity-base": 4, "cavity-left": 2, "cavity-1": 0, "cavity-right": 2}


def test_comb_and_keeper_close_the_end_but_for_the_slits(yamada: Design) -> None:
    yamada = yamada.with_(mold={"shrinkage": 0.0, "floor": 9.0})
    closed = mold(yamada)
    comb, keeper = closed.part("end-b-comb").body, closed.part("end-b-keeper").body
    bottom, top = -section(yamada).top - 9.0, 4.0
    gap = yamada.mold.slit_clearance
    slits = 18 * (0.05 + 2 * gap) * (0.25 + 2 * gap)
    whole = area(rectangle(-18.5, 18.5, bottom, top))
    # a notch's mouth lies on the split circle, which falls by offset / R across it and bulges into it
    mouth = 0.05 + 2 * gap
    slivers = 18 * (mouth**2 * 0.16 / (2 * 60) - mouth**3 / (12 * 60))
    assert area(comb.outline) + area(keeper.outline) == pytest.approx(whole - slits - slivers, abs=1e-6)


@pytest.mark.parametrize(("side", "way"), [("a", 1), ("b", -1)])
def test_shims_leave_away_from_the_wiring_side(side: str, way: int) -> None:
    """So that the film's contact is what comes last, and goes through no slot."""
    for design in (few_ridges(), three_ridges()):
        opening = mold(design.with_(film={"wiring_side": side})).opening
        (step,) = (s for s in opening if s.parts[0].startswith("shim"))
        assert math.copysign(1, step.travel) == way


def test_opening_takes_plates_then_shims_then_cover_then_skin(yamada: Design, cast: Design) -> None:
    """The lap of film and shim is thicker than a notch: the combs are off before it comes by."""
    steps = mold(yamada).opening
    order = [(s.axis, s.parts[0].split("-")[0]) for s in steps]
    assert order == [("y", "end"), ("y", "end"), ("y", "shim"), ("z", "cover"), ("z", "skin")]
    # a shim stands out by its grip at both ends: a film is glued to one of them, pliers hold the other
    closed = mold(yamada.with_(mold={"shrinkage": 0.0, "end_plate": 5.0}))
    shims = closed.of(PartRole.SHIM)
    assert len(shims) == 18
    assert {(s.body.low, s.body.high) for s in shims} == {(-6.0 - 5.0 - 6.0, 6.0 + 5.0 + 6.0)}
    steps = mold(cast).opening
    order = [(step.axis, step.parts[0]) for step in steps]
    assert order == [("y", "end-a-comb"), ("y", "end-b-comb"), ("z", "cover"), ("z", "skin")]
    assert {"skin", "carrier", "strip-1-S1", "strip-9-S2"} <= set(steps[-1].parts)


@pytest.mark.parametrize("name", KINDS)
def test_a_wall_of_keeper_stays_under_each_gate(name: str) -> None:
    """To all of its edge, by points on it."""
    for keeper in mold(skincad.load(name)).of(PartRole.KEEPER):
        for hole in bores(keeper, CutRole.GATE):
            edge = polygon(keeper.body.outline, 1e-4)
            along = np.linspace(0.0, 1.0, 400)[:, None, None]
            points = (edge + along * (np.roll(edge, -1, axis=0) - edge)).reshape(-1, 2)
            away = np.hypot(points[:, 0] - hole.start[0], points[:, 1] - hole.start[2]).min()
            assert away - hole.radius >= 0.8


def test_a_gate_is_low_at_one_end_a_vent_at_the_other(yamada: Design) -> None:
    closed = mold(yamada)
    gate = closed.part("end-a-keeper").cuts[-1]
    assert gate.radius == 1.0
    edge = [s.start for s in closed.part("end-a-keeper").body.outline if s.start.z < 0]
    web = gate.start[2] - gate.radius - max(p.z for p in edge if abs(p.x) < 2.5)
    assert web == pytest.approx(0.8, abs=0.1)  # of the keeper; its edge falls by 0.05 beside the middle
    assert gate.start[2] + gate.radius < -0.3
    vent = closed.part("carrier").cuts[0]
    assert vent.start[1] > 3.0
    bolts = [c for c in closed.part("cavity").cuts if c.radius == BOLT_RADIUS]
    assert len(bolts) == 4
    cuts = mold(yamada.with_(mold={"pour": "open"})).part("end-a-keeper").cuts
    assert len([cut for cut in cuts if isinstance(cut, Bore)]) == 2  # bolts: an open pour needs no gate


@pytest.mark.parametrize(
    ("name", "change", "key"),
    [
        ("yamada-2002", {"mold": {"wall": 12.0}}, "mold.wall"),
        ("yamada-2002", {"skin": {"length": 3.0}}, "skin.length"),
        ("yamada-2002", {"mold": {"gate": 3.9}}, "mold.gate"),
        ("yamada-2002", {"skin": {"thickness": 0.6}, "mold": {"carrier_thickness": 1.0}},
         "mold.carrier_thickness"),
        ("yamada-2002", {"mold": {"slit_clearance": 0.4}}, "mold.slit_clearance"),
        ("yamada-2002", {"mold": {"reservoir": 3.0}}, "mold.reservoir"),
        ("yamada-2002", {"mold": {"reservoir": 40.0}}, "mold.reservoir"),
        ("steep-fingertip", {"mold": {"floor": 9.0, "carrier_thickness": 3.0}}, "mold.floor"),
        ("steep-fingertip", {"mold": {"cavities": 2}}, "mold.cavities"),
    ],
)  # fmt: skip
def test_what_finds_no_room_is_refused(name: str, change: dict, key: str) -> None:
    with pytest.raises(InputError) as refused:
        mold(skincad.load(name).with_(**change))
    assert refused.value.key == key


def test_all_that_finds_no_room_is_told_at_once(yamada: Design) -> None:
    small = {"wall": 12.0, "gate": 3.9, "carrier_thickness": 1.0, "reservoir": 40.0}
    thin = yamada.with_(mold=small, skin={"thickness": 0.6, "curvature_radius": 100.0}, slot=None)
    even = skincad.load("steep-fingertip", ["ridge.count=4", "mold.cavities=2", "mold.wall=12"])
    for design, keys in (
        (thin, ["mold.wall", "mold.carrier_thickness", "skin.thickness", "mold.reservoir"]),
        (even, ["mold.split", "mold.cavities", "mold.wall"]),
    ):
        with pytest.raises(InputError) as refused:
            mold(design)
        assert [error.key for error in (refused.value, *refused.value.others)] == keys


@pytest.fixture
def cast() -> Design:
    """The template with strips that are cast in, without shrinkage: lengths are those of the design."""
    return skincad.load("cast-in", ["mold.shrinkage=0.0"])


def strips_of(closed: ClosedMold) -> list[Part]:
    return [part for part in closed.parts if part.name.startswith("strip-")]


def test_strips_that_are_cast_in_go_through_both_combs_to_where_their_tabs_are_cut(cast: Design) -> None:
    closed = mold(cast)
    strips = strips_of(closed)
    assert [part.name for part in strips[:3]] == ["strip-1-S1", "strip-1-S2", "strip-2-S1"]
    assert (len(strips), {part.made for part in strips}) == (18, {"bought"})
    assert not any(part.name.startswith("shim") for part in closed.parts)
    for part in strips:
        assert part.volume == pytest.approx(0.052 * 0.375 * (18 + 4 + 10 + 4 + STUB), rel=1e-9)
        assert (part.body.low, part.body.high) == pytest.approx((-9 - 4 - STUB, 9 + 4 + 10))
    other = strips_of(mold(cast.with_(film={"wiring_side": "a"})))[0]
    assert (other.body.low, other.body.high) == pytest.approx((-9 - 4 - 10, 9 + 4 + STUB))


@pytest.mark.parametrize("thickness", [0.052, 0.1])
def test_silicone_is_everywhere_but_where_the_film_is(cast: Design, thickness: float) -> None:
    """A wider slot changes nothing: no shim keeps it free."""
    closed = mold(cast.with_(slot={"thickness": thickness}))
    skin = closed.part("skin")
    film = 18 * 0.052 * 0.375 * 18
    assert skin.body.volume + film == pytest.approx(area(skin.body.outline) * 18, rel=1e-12)
    solids = [manifold(part, 1e-3) for part in (skin, *strips_of(closed))]
    whole = solids[0]
    for strip in solids[1:]:
        whole = whole + strip
    outside = film / 18 * (4 + 10 + 4 + STUB)
    assert whole.volume() == pytest.approx(solids[0].volume() + film + outside, rel=1e-9)  # no overlap


def test_a_strip_stands_on_its_notch_and_clears_its_sides_and_the_keeper(cast: Design) -> None:
    """Moved by less than its play no strip meets an end plate, by more it does; the bottom has no play."""
    closed = mold(cast)
    comb, keeper = (manifold(closed.part(f"end-b-{name}"), 1e-4) for name in ("comb", "keeper"))
    strip = manifold(closed.part("strip-5-S2"), 1e-4)  # on the middle ridge, so upright
    play = cast.mold.slit_clearance

    def shared(x: float, z: float) -> float:
        moved = strip.translate((x, 0.0, z))
        return float((moved ^ comb).volume() + (moved ^ keeper).volume())

    slice_of = 0.375 * 4.0  # mm2, the strip's face in a comb
    for sign in (-1, 1):
        assert shared(0.9 * sign * play, 0.0) < 1e-9
        assert shared(1.1 * sign * play, 0.0) == pytest.approx(0.1 * play * slice_of, rel=0.01)
    assert shared(0.0, 0.0) < 1e-9
    assert shared(0.0, -0.1 * play) == pytest.approx(0.1 * play * 0.052 * 4.0, rel=0.01)
    assert shared(0.0, 0.9 * play) < 1e-9
    assert shared(0.0, 1.5 * play) > 0.3 * play * 0.052 * 4.0  # the split circle falls to the outer slots


@pytest.mark.slow
def test_interference_sees_tabs_that_were_not_cut_off(cast: Design) -> None:
    """Tabs are wider than a notch: on the way of the end plates they would be met."""
    closed = mold(cast)
    tab = Part("strip-5-S3", PartRole.STRIP, box(0.026, (-24.0, -16.0), (-7.5, -4.5), "y"))
    tabbed = ClosedMold((*closed.parts, tab), closed.opening)
    findings = interference(tabbed, 1e-3)
    met = {f"end-a-{name} against strip-5-S3, opening along y" for name in ("comb", "keeper")}
    assert {f.where for f in findings} == met


@pytest.mark.parametrize(
    ("template", "settings", "words"),
    [
        ("yamada-2002", ["slot.tilt=30", "mold.slit_clearance=0.06"],
         "neighbouring notches of the comb meet"),
        ("yamada-2002", ["mold.end_plate=1", "mold.reservoir=16", 'mold.carrier="plain"'],
         "mold.reservoir: must"),
        ("steep-fingertip", ["ridge.count=4"], "mold.split: splits only an odd number"),
        ("yamada-2002", ["slot.offset=0.264", "mold.shrinkage=0.05"], "slot"),
    ],
)  # fmt: skip
def test_what_random_designs_broke_is_refused(template: str, settings: list[str], words: str) -> None:
    with pytest.raises(InputError, match=words):
        mold(skincad.load(template, settings))


def test_under_a_nut_enough_of_a_thin_end_plate_is_left() -> None:
    """The pocket goes as deep as the nut is high, or leaves 1 mm of a plate that is too thin for both."""
    for thick in (3.0, 3.5, 6.0):
        closed = mold(of_one_printer("lab-bench").with_(mold={"end_plate": thick}))
        ends = [part for part in closed.of(PartRole.COMB, PartRole.END_PLATE) if part.end == "b"]
        lengths = {hole.length for part in ends for hole in bores(part, CutRole.END_BOLT)}
        assert [*lengths] == pytest.approx([max(thick - NUT_DEPTH, 1.0)])


def test_every_skin_of_a_gang_is_the_single_one_moved(yamada: Design) -> None:
    one = mold(yamada).part("skin")
    centres = []
    for part in mold(yamada.with_(mold={"cavities": 3})).parts:
        if part.made == "cast":
            assert part.volume == pytest.approx(one.volume, rel=1e-12)  # moments about each one's own corner
            centres.append(manifold(part, 1e-3).bounding_box()[0] - manifold(one, 1e-3).bounding_box()[0])
    assert centres[1] == pytest.approx(0.0, abs=1e-12)
    assert centres[2] == pytest.approx(-centres[0], abs=1e-12)
    assert centres[2] > 11.0 + 2 * 2.0 + 2 * 1.7  # skin, ledges, a bolt between
    # grams and air are those of the single mold times the skins
    few, many = few_ridges(), few_ridges(mold={"cavities": 4})
    assert poured_volume(Job(many)) == pytest.approx(4 * poured_volume(Job(few)), rel=1e-12)
    assert pockets(Job(many), 1.0) == pockets(Job(few), 1.0)


STEEP = "steep-fingertip"


def errors(design: Design) -> list[str]:
    return [f.rule for f in design_findings(Job(design)) if f.severity == "error"]


def test_the_steep_fingertip_is_locked_in_a_whole_cavity_and_free_in_a_split_one() -> None:
    steep = skincad.load(STEEP)
    assert errors(steep.with_(mold={"split": "none"})) == ["undercut", "undercut"]
    assert errors(steep) == []
    assert split_ridges(steep) == [1, 3]
    assert skin_of(steep).undercuts[1].strain > safe_strain(steep) > skin_of(steep).undercuts[2].strain


def test_interference_sees_a_piece_that_is_pulled_the_wrong_way() -> None:
    """Along its neighbour's ridge; straight, where it catches an outer ridge."""
    locked, steep = mold(many_locked()), mold(skincad.load(STEEP))
    ways = {step.parts[0]: step.axis for step in locked.opening}
    for closed, name, way in (
        (locked, "cavity-5", ways["cavity-left"]),
        (steep, "cavity-right", (0.0, -1.0)),
    ):
        (step,) = (step for step in closed.opening if step.parts == (name,))
        two = tuple(part for part in closed.parts if part.name in (name, "skin"))
        assert interference(ClosedMold(two, (step,)), 1e-3) == []
        findings = interference(ClosedMold(two, (Move(step.parts, way, step.travel),)), 1e-3)
        assert any(f"{name} against skin" in f.where for f in findings)


@pytest.mark.parametrize("design", [skincad.load(STEEP), many_locked()], ids=["template", "seven ridges"])
def test_pieces_of_a_split_cavity_fill_the_whole_one(design: Design) -> None:
    closed, whole = mold(design), mold(design.with_(mold={"split": "none"}))
    pieces = [p for p in closed.parts if p.name.startswith("cavity")]
    bodies = math.fsum(part.body.volume for part in pieces)  # less their bores
    assert bodies == pytest.approx(whole.part("cavity").body.volume, rel=1e-12)
    assert closed.part("skin").volume == pytest.approx(whole.part("skin").volume, rel=1e-12)
