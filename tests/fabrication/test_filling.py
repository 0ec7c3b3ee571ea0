"""How silicone is mixed and filled in: flow by hand, air pockets against closed forms and slices."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold, OpType

import skincad
from skincad.base import Array
from skincad.fabrication import Job, casting_sheet, filling_findings, manifold, poured_volume
from skincad.fabrication.filling import Space, Void, best_tilt, cells, pockets, trapped, vertical, void
from skincad.fabrication.pouring import filling, front_time, groove_time, pouring_findings, small_batch
from skincad.fabrication.strips import pour
from skincad.inputs import Design, silicones
from skincad.shape import Point, loop, rectangle
from skincad.solids import THUMB, WIDTHS, Bore, ClosedMold, CutRole, Part, PartRole, Prism, bores
from skincad.solids.mold import mold
from tests.designs import KINDS, SHIPPED, template


def test_a_front_is_a_film_under_its_own_weight(yamada: Design) -> None:
    """12 mm at rho g h^2 sin(a) / (3 mu): 1080 kg/m3, 4 mm, 10 degrees, 20 Pa s."""
    speed = 1080 * 9.81 * 0.004**2 * math.sin(math.radians(10)) / (3 * 20)
    assert front_time(Job(yamada)) == pytest.approx(0.012 / speed, rel=1e-12)
    thin = Job(yamada.with_(skin={"thickness": 2.0}))
    assert front_time(thin) == pytest.approx(4 * front_time(Job(yamada)), rel=1e-12)
    level = Job(yamada.with_(mold={"pour_tilt": 0.0}))
    assert front_time(level) == front_time(Job(yamada.with_(mold={"pour_tilt": 1.0})))


def test_a_groove_fills_as_a_gap_does_by_washburn() -> None:
    """Integrated step by step: b^2 / (12 mu) times the pressure's gradient, which falls as it gets deeper."""
    job = Job(skincad.load("plain-ridges"))
    head, gap, depth = 1080 * 9.81 * 0.004, 0.625e-3, 0.5e-3
    step, time = depth / 2000, 0.0
    for i in range(2000):
        time += step * 12 * 20 * (i + 0.5) * step / (gap**2 * head)
    assert groove_time(job) == pytest.approx(time, rel=1e-6)


def test_grooves_that_the_mix_does_not_flow_into_are_brushed(unshrunk: Design) -> None:
    job = Job(unshrunk)
    assert groove_time(job) > 30
    text = casting_sheet(job, [], "", True)
    brushed, mixed, closed = (
        text.index(words) for words in ("Brush the mix", "Mix. Start", "Lay the carrier")
    )
    assert mixed < brushed < closed
    thin = Job(unshrunk.with_(silicones={"dragon-skin-30": {"viscosity": 3.0}}))
    assert not filling(thin).brushed
    text = casting_sheet(thin, [], "", True)
    assert "Brush the mix" not in text
    assert text.index("Lay the carrier") < text.index("Mix. Start")


def test_the_thumb_presses_by_hagen_and_poiseuille() -> None:
    """A blunt tip of 16 gauge, 1.19 x 12.7 mm, and a syringe of 5 ml, 12.06 mm."""
    job = Job(skincad.load("milled-pad", ["mold.gate=2.0"]))
    how = filling(job)
    flow = poured_volume(job) * 1e-9 / how.seconds
    pressure = 128 * 20 * 12.7e-3 * flow / (math.pi * 1.19e-3**4)
    assert how.force == pytest.approx(pressure * math.pi / 4 * 12.06e-3**2, rel=1e-12)
    stiff = Job(job.design.with_(silicones={job.silicone.name: {"viscosity": 200.0}}))
    assert filling(stiff).force <= THUMB
    assert filling(stiff).seconds > how.seconds


def test_a_gate_is_wider_where_a_thumb_would_press_too_hard_and_the_skin_has_room() -> None:
    """The next usual width at which the force asks for no longer time; a thin skin keeps it narrow."""
    design = skincad.load("milled-pad", ["mold.fill_time=30"])
    stiff = design.with_(silicones={design.material.name: {"viscosity": 200.0}}, skin={"thickness": 12.0})
    wide, job = WIDTHS.index(Job(stiff).gate or 0.0), Job(stiff)
    assert wide > 0
    assert filling(job).force < THUMB
    narrower = Job(stiff.with_(mold={"gate": WIDTHS[wide - 1]}))
    assert filling(narrower).force > 0.9 * THUMB
    thin = Job(stiff.with_(skin={"thickness": 3.0}))
    assert thin.gate < WIDTHS[wide]


@pytest.mark.parametrize("name", SHIPPED)
def test_every_templates_mold_is_full_within_its_pot_life(name: str) -> None:
    job = Job(skincad.load(name))
    how = filling(job)
    assert how.force <= THUMB
    assert how.seconds >= max(front_time(job), job.design.mold.fill_time)
    assert pouring_findings(job) == []
    text = casting_sheet(job, [], "", True)
    number, unit = re.search(r"Take ([\d.]+) (s|min) to fill it", text).groups()
    assert float(number) * {"s": 1, "min": 60}[unit] == pytest.approx(how.seconds, rel=0.05)  # two digits
    assert (f"- syringe, {how.syringe} ml" in text) == (job.gate is not None)


def test_strips_that_are_cast_in_are_told_how_far_they_give_way() -> None:
    """In the time that filling takes: the drift is the front's speed times a constant."""
    job = Job(skincad.load("cast-in", ["ridge.count=3"]))
    flow = pour(job)
    slow = flow.drift * job.design.mold.fill_time / filling(job).seconds
    assert f"moved aside by up to {slow:.2g} mm" in casting_sheet(job, [], "", True)
    assert slow < flow.drift
    assert "moved aside" not in casting_sheet(
        Job(skincad.load("yamada-2002", ["ridge.count=3"])), [], "", True
    )


def test_a_mix_that_thickens_before_the_mold_is_full_is_warned_of(yamada: Design) -> None:
    """3 min of stirring, 2 of pumping down, 3 of degassing, 2.1 of brushing 132 mm2, 1 to lay the carrier on,
    1.2 for cover and two screws, 1 for the syringe and 1 of filling, of 5."""
    (finding,) = pouring_findings(Job(yamada.with_(silicones={"dragon-skin-30": {"pot_life_min": 5.0}})))
    assert (finding.rule, finding.measured, finding.limit) == ("pot life", 14.3, 5.0)


def test_the_least_mix_is_weighed_to_two_per_cent(unshrunk: Design) -> None:
    known = silicones()
    assert small_batch(known["dragon-skin-10"]) == 2.0
    assert small_batch(known["sylgard-184"]) == 6.0  # 10 : 1, of which B is 0.55 g
    text = casting_sheet(Job(unshrunk.with_(material={"name": "sylgard-184"})), [], "", True)
    assert "weigh 5.45 g of A and 0.55 g of B, 6.00 g" in text


ROUNDING = 1e-9  # relative, of sums of a few clipped solids


@pytest.fixture
def unshrunk(yamada: Design) -> Design:
    """Without shrinkage, so that the closed forms have round numbers; three ridges, for seconds."""
    return yamada.with_(mold={"shrinkage": 0.0}, ridge={"count": 3})


def air(space: Void, tilt: float, chord: float = 1e-3) -> list:
    return trapped(cells(space, chord), vertical(tilt))


def total(space: Void, tilt: float) -> float:
    return sum(pocket.volume for pocket in air(space, tilt))


def merged(space: Void, chord: float) -> Manifold:
    """The void as one solid, by booleans."""
    bodies = [manifold(Part(s.name, PartRole.COVER, s.body), chord) for s in space.spaces]
    return Manifold.batch_boolean(bodies, OpType.Add)


def swept(solid: Manifold, tilt: float, top: float, levels: Array) -> tuple[float, float]:
    """Most air that slices of the solid at these levels show cut off from its openings at z = top, never too
    much, and at which level."""
    up = vertical(tilt)
    cut_off = {}
    for level in levels:
        parts = solid.trim_by_plane(tuple(up), level).decompose()
        cut_off[sum(p.volume() for p in parts if p.bounding_box()[5] < top - 1e-6)] = float(level)
    return max(cut_off), cut_off[max(cut_off)]


def plain_mold(design: Design) -> ClosedMold:
    """The mold as it would be without reservoir: bores straight over the middle of the carrier's holes."""
    closed = mold(design)
    over = bores(closed.part("cover"), CutRole.COVER_BOLT, CutRole.COVER_PIN)
    levels = [closed.part(name).body for name in ("seal", "cover")]
    vent, *holes = bores(closed.part("carrier"), CutRole.VENT, CutRole.RIVET)
    sealed, lid = (
        [
            Bore((0.0, vent.start[1], at.low), "z", at.high - at.low, vent.radius, role=CutRole.RESERVOIR),
            *(Bore((*h.start[:2], at.low), "z", at.high - at.low, 0.4, role=CutRole.BLEED) for h in holes),
        ]
        for at in levels
    )
    over += lid
    seal = replace(closed.part("seal"), cuts=tuple(sealed))
    cover = replace(closed.part("cover"), cuts=tuple(over))
    return replace(closed, parts=tuple({"cover": cover, "seal": seal}.get(p.name, p) for p in closed.parts))


def hooded(closed: ClosedMold) -> ClosedMold:
    """A mold with a shim that is a hood: its legs 1.8 mm apart and 0.9 mm long, over ridge 2. Its gate is
    lower, or its top would be in the hood."""
    keeper = closed.part("end-a-keeper")
    lower = tuple(
        replace(c, start=(*c.start[:2], c.start[2] - 0.5)) if c.role is CutRole.GATE else c
        for c in keeper.cuts
    )
    gated = [replace(keeper, cuts=lower) if p is keeper else p for p in closed.parts]
    closed = replace(closed, parts=tuple(gated))
    leg = [(-1, -1.5), (-0.9, -1.5), (-0.9, -0.6)]
    corners = [*leg, *((-x, z) for x, z in reversed(leg)), (1, -0.5), (-1, -0.5)]
    hood = loop([Point(*p) for p in corners], "slot", 2)
    skin = closed.part("skin")
    cast = replace(skin, body=replace(skin.body, holes=(*skin.body.holes, hood)))
    shim = Part("shim-2-S3", PartRole.SHIM, Prism(hood, "y", -10.0, 16.0))
    return replace(closed, parts=(*(cast if p.name == "skin" else p for p in closed.parts), shim))


@pytest.fixture(scope="module")
def lidded() -> Void:
    """A box of 10 x 10 x 5 mm under a lid with a hole of 2 mm in its middle."""
    box = Space("box", Prism(rectangle(-5, 5, -5, 0), "y", -5.0, 5.0), PartRole.SKIN)
    hole = Bore((0.0, 0.0, 0.0), "z", 3.0, 1.0)
    return Void((box, Space("hole", hole, PartRole.CARRIER, open_at=3.0)))


@pytest.mark.parametrize("tilt", [0.0, 1.0, 10.0, 40.0])
def test_under_a_lid_air_stays_beyond_the_holes_highest_point(lidded: Void, tilt: float) -> None:
    wedge = 10 * 4 * 4 * math.tan(math.radians(tilt)) / 2  # from y = 1 to 5, 10 mm wide
    assert total(lidded, tilt) == pytest.approx(wedge, rel=ROUNDING, abs=1e-12)
    if tilt:
        (pocket,) = air(lidded, tilt)
        assert pocket.highest[1:] == (5.0, 0.0)
        assert pocket.height == pytest.approx(4 * math.sin(math.radians(tilt)), rel=ROUNDING)


def test_a_step_in_the_ceiling_holds_the_wedge_before_it() -> None:
    """Ceilings at 0.5 and 0.3 mm, each 5 mm long, then the open."""
    parts = [("high", 0.5, 0.0), ("low", 0.3, 5.0), ("open", 1.0, 10.0)]
    spaces = [Space(n, Prism(rectangle(-1, 1, -1, top), "y", y, y + 5), PartRole.SKIN) for n, top, y in parts]
    step = Void((*spaces[:2], replace(spaces[2], open_at=1.0)))
    assert total(step, 0.0) == pytest.approx(2 * 5 * 0.2, rel=ROUNDING)
    shallow, steep = 0.1 / 5, 0.4 / 5  # the wedge ends at the far end, or half way
    assert total(step, math.degrees(math.atan(shallow))) == pytest.approx(
        2 * 5 * (0.2 + 0.1) / 2, rel=ROUNDING
    )
    assert total(step, math.degrees(math.atan(steep))) == pytest.approx(2 * 0.2 * 2.5 / 2, rel=ROUNDING)


def test_a_bore_that_narrows_empties_at_the_tilt_of_its_cone() -> None:
    cone = Space("cone", Bore((0.0, 0.0, 0.0), "y", 5.0, 1.0, 0.8), PartRole.SKIN)
    neighbour = Space("beyond", Prism(rectangle(-2, 2, -2, 2), "y", 5.0, 9.0), PartRole.SKIN, open_at=2.0)
    half_angle = math.degrees(math.atan(0.2 / 5))
    assert total(Void((cone, neighbour)), 0.9 * half_angle) > 0.001
    assert total(Void((cone, neighbour)), 1.001 * half_angle) == 0.0


def test_a_low_rim_and_a_void_without_a_way_out_keep_air(lidded: Void) -> None:
    low = replace(lidded, rim=np.array([[0.0, 0.0, -1.0]]))
    assert total(low, 0.0) == pytest.approx(100 + math.pi * 3, rel=1e-3)  # the hole's chords
    shut = Void(tuple(replace(space, open_at=None) for space in lidded.spaces))
    (pocket,) = air(shut, 20.0)
    assert pocket.volume == pytest.approx(shut.volume, rel=1e-3)  # the hole's chords


def test_air_under_a_hood_is_the_prism_between_its_legs(unshrunk: Design) -> None:
    tilt = math.radians(10)
    (pocket,) = pockets(Job(unshrunk, hooded(mold(unshrunk))), 10.0)
    assert pocket.volume == pytest.approx(1.8 * 0.9**2 / math.tan(tilt) / 2, rel=ROUNDING)
    assert pocket.height == pytest.approx(0.9 * math.cos(tilt), rel=ROUNDING)
    assert pocket.place[1:] == (6.0, -0.6)
    assert pocket.where == "shim-2-S3, at end b's edge"
    (level,) = pockets(Job(unshrunk, hooded(mold(unshrunk))), 0.0)
    assert level.volume == pytest.approx(1.8 * 0.9 * 12, rel=ROUNDING)


@pytest.mark.parametrize(("least", "helps"), [(0.0, True), (0.8, True), (0.95, False)])
def test_a_tilt_is_advised_where_it_saves_a_tenth_of_the_air(
    unshrunk: Design, monkeypatch: pytest.MonkeyPatch, least: float, helps: bool
) -> None:
    hood, traps = hooded(mold(unshrunk)), filling_findings(Job(unshrunk, hooded(mold(unshrunk))))[0].measured
    monkeypatch.setattr("skincad.fabrication.filling.best_tilt", lambda *_: (7.0, least * traps))
    (finding,) = filling_findings(Job(unshrunk, hood))
    assert finding.remedy.startswith("mold.pour_tilt = 7" if helps else "no tilt traps less: brush")


def test_the_best_tilt_is_the_best_of_all_half_degrees_near_it(unshrunk: Design) -> None:
    hood = hooded(mold(unshrunk))
    tilt, least = best_tilt(Job(unshrunk, hood))
    others = [t for t in np.arange(tilt - 2.0, tilt + 2.25, 0.5) if 2.0 <= t <= 60.0]
    volumes = {float(t): sum(p.volume for p in pockets(Job(unshrunk, hood), float(t))) for t in others}
    assert 2 * tilt == round(2 * tilt)
    assert least == pytest.approx(min(volumes.values()), abs=1e-3)
    assert volumes[tilt] == pytest.approx(least, abs=1e-3)


def test_air_at_a_shim_is_a_warning_with_the_better_tilt(unshrunk: Design) -> None:
    (finding,) = filling_findings(Job(unshrunk, hooded(mold(unshrunk))))
    assert (finding.rule, finding.severity, finding.unit) == ("trapped air", "warning", "mm3")
    tilt, least = best_tilt(Job(unshrunk, hooded(mold(unshrunk))))
    assert least < 0.5 * finding.measured
    assert finding.remedy.startswith(f"mold.pour_tilt = {tilt:g}, which traps {least:.2g} mm3: brush sil")


@pytest.mark.parametrize("name", KINDS)
def test_no_template_keeps_air_level_or_at_its_own_tilt(name: str) -> None:
    design = skincad.load(name)
    closed = mold(design)
    assert pockets(Job(design, closed), 0.0) == pockets(Job(design, closed)) == ()
    assert filling_findings(Job(design, closed)) == []
    assert best_tilt(Job(design, closed)) == (design.mold.pour_tilt, 0.0)


def test_without_the_reservoir_the_gap_round_the_carrier_would_keep_its_air(unshrunk: Design) -> None:
    ring = 4.0 * (15.02 * 12.0 - 15.0 * 11.98)  # height, trough less carrier
    (level,) = pockets(Job(unshrunk, plain_mold(unshrunk)), 0.0)
    assert level.volume == pytest.approx(ring, rel=ROUNDING)
    tilted = pockets(Job(unshrunk, plain_mold(unshrunk)), 10.0)
    assert tilted[0].where == "carrier, at end b's edge"
    assert {p.where for p in tilted[1:]} == {f"carrier hole {i}" for i in range(1, 5)}
    # wedge over the vent's highest point, 0.61 mm from the end, and a little more in the gap
    wedge = 11 * 0.61**2 * math.tan(math.radians(10)) / 2
    assert wedge < tilted[0].volume < wedge + ring


def test_air_beside_the_skin_is_only_noted_however_much(unshrunk: Design) -> None:
    wide = unshrunk.with_(mold={"clearance": 0.2, "pour_tilt": 0.0})
    level, gap = filling_findings(Job(wide, plain_mold(wide)))
    assert level.unit == "deg"
    assert gap.measured > 10 * gap.limit
    assert gap.severity == "note"


@pytest.mark.slow
def test_pockets_agree_with_slices_of_the_merged_solid(unshrunk: Design) -> None:
    """One solid by booleans, cut at level after level: from below, and nearer with a finer sweep."""
    tight = unshrunk.with_(mold={"clearance": 0.0, "carrier": "plain"})
    (pocket,) = pockets(Job(tight), 10.0)
    solid = merged(void(Job(tight)), 1e-3)
    heights = np.array(solid.to_mesh64().vert_properties)[:, :3] @ vertical(10.0)
    coarse, level = swept(solid, 10.0, 8.0, np.arange(heights.min(), heights.max(), 0.02))
    fine, _ = swept(solid, 10.0, 8.0, np.arange(level - 0.04, level + 0.04, 0.005))
    assert 0 < pocket.volume - fine < pocket.volume - coarse
    assert pocket.volume - fine < 0.1 * pocket.volume  # a slice lies up to 0.005 mm over the way out, of 0.1


@pytest.mark.parametrize("name", [template("yamada-2002"), template("nozzle-04")])
def test_finer_chords_change_no_pocket(name: str) -> None:
    design = skincad.load(name)
    space = void(Job(design, plain_mold(design)))
    coarse, fine = (sum(a.volume for a in air(space, 10.0, chord)) for chord in (1e-3, 1e-4))
    assert coarse == pytest.approx(fine, rel=2e-3)  # circles of 0.5 to 1.25 mm as chords within 0.001 mm


@pytest.mark.parametrize(
    "name", [template(name) for name in ("yamada-2002", "yamada-2002-tilted", "nozzle-04")]
)
def test_poured_volume_is_that_of_the_merged_solid(name: str) -> None:
    design = skincad.load(name)
    solid = merged(void(Job(design)), 1e-4)
    assert len(solid.decompose()) == 1
    assert poured_volume(Job(design)) == pytest.approx(solid.volume(), rel=2e-4)  # chords


def test_air_is_less_than_what_is_poured_and_the_same_every_time(unshrunk: Design) -> None:
    closed = plain_mold(unshrunk)
    for tilt in (0.0, 7.0, 33.0, 60.0):
        air = pockets(Job(unshrunk, closed), tilt)
        assert 0 < sum(p.volume for p in air) < poured_volume(Job(unshrunk, closed))
        assert pockets(Job(unshrunk, closed), tilt) == air


def test_a_level_carrier_is_noted_since_statics_cannot_judge_it(unshrunk: Design) -> None:
    level = unshrunk.with_(mold={"pour_tilt": 0.0})
    (finding,) = filling_findings(Job(level))
    assert (finding.severity, finding.measured, finding.limit, finding.unit) == ("note", 0.0, 2.0, "deg")


def test_without_clearance_the_corner_keeps_air_and_less_tilt_is_better(unshrunk: Design) -> None:
    tight = unshrunk.with_(mold={"clearance": 0.0})
    (finding,) = filling_findings(Job(tight))
    assert finding.where.startswith("carrier, at end b's edge")
    assert finding.severity == "note"  # less than a bubble of 1 mm
    assert finding.remedy.startswith("mold.pour_tilt = 2, which traps 0.069 mm3")


def test_an_open_pour_has_no_gate_to_fill_and_traps_nothing_in_the_level_trough(unshrunk: Design) -> None:
    opened = unshrunk.with_(mold={"pour": "open"})
    less = poured_volume(Job(unshrunk)) - poured_volume(Job(opened))
    assert less == pytest.approx(math.pi * 4.0, rel=1e-9)
    assert pockets(Job(opened)) == ()
    level, tilted = sorted(pockets(Job(opened, hooded(mold(opened))), 30.0), key=lambda p: -p.volume)
    assert level.volume == pytest.approx(1.8 * 0.9 * 12, rel=ROUNDING)
    assert tilted.volume == pytest.approx(1.8 * 0.9**2 / math.tan(math.radians(30)) / 2, rel=ROUNDING)


def test_the_sheet_of_an_open_pour_has_no_gate(unshrunk: Design) -> None:
    design = unshrunk.with_(mold={"pour": "open", "pour_tilt": 15.0})
    text = casting_sheet(Job(design), [], "Passes.", True)
    assert "Raise end b by 15 degrees. Set the carrier down at end a first" in text
    assert "gate" not in text.replace("gauge", "")


def test_silicone_runs_off_over_the_cup_and_air_leaves_by_the_cover_alone(unshrunk: Design) -> None:
    closed = mold(unshrunk)
    (cup,) = bores(closed.part("cover"), CutRole.RESERVOIR)
    rim = void(Job(unshrunk, closed)).rim
    assert rim[:, 2] == pytest.approx(np.full(len(rim), closed.part("cover").body.high))
    away = np.hypot(rim[:, 0] - cup.start[0], rim[:, 1] - cup.start[1])
    assert away == pytest.approx(np.full(len(rim), cup.far_radius))
    turns = np.sort(np.arctan2(rim[:, 1] - cup.start[1], rim[:, 0] - cup.start[0]))
    assert np.diff(turns) == pytest.approx(np.full(len(rim) - 1, 2 * math.pi / len(rim)))
    closed = mold(unshrunk)
    spaces = void(Job(unshrunk, closed)).spaces
    top = closed.first(PartRole.COVER).body.high
    assert {space.beside for space in spaces if space.open_at is not None} == {PartRole.COVER}
    assert {space.open_at for space in spaces} == {None, top}
    holes = [space for space in spaces if space.name == "carrier hole"]
    assert [space.where for space in holes] == [f"carrier hole {i + 1}" for i in range(len(holes))]
    assert next(space for space in spaces if space.name == "skin").where == "skin"
