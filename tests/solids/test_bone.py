"""Bones: a user's solid that the skin is cast on, in the mold, in the skin, and what is refused."""

from __future__ import annotations

import contextlib
import math
import os
import random
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import pytest
import shapely

import skincad
from skincad import InputError
from skincad.fabrication import Job, design_findings, poured_volume, pours, pull_off, sheet_steps
from skincad.fabrication.parts_list import parts_list
from skincad.inputs import Design
from skincad.solids import CutRole, PartRole, bone_of, lid_process, pinned, skin_part
from skincad.solids.mold import mold
from tests.designs import pillars
from tests.refusals import refused_command
from tests.solids.kinds import PLATE, STEM, boned, lab_bowl, plate, saddle, stem, wide_rings


def bare() -> Design:
    return skincad.load("lab-bench", ["ridge.count=3"])


@pytest.fixture
def on_stem(tmp_path: Path) -> Design:
    return boned(tmp_path, stem())


def test_a_bone_takes_its_room_of_the_skin(on_stem: Design) -> None:
    """The block and half a thickness of edges. That kernel and mesh agree is the contract's of all kinds."""
    bone = bone_of(on_stem)
    assert bone.inside == pytest.approx(8 * 10 * 2, rel=1e-9)
    assert bone.volume == pytest.approx(8 * 10 * 2 + math.prod(STEM), rel=1e-9)
    assert skin_part(on_stem).volume == pytest.approx(skin_part(bare()).volume - 160.0, rel=1e-9)
    closed, gap = mold(on_stem), on_stem.mold.clearance
    lids = [closed.first(role) for role in (PartRole.CARRIER, PartRole.SEAL, PartRole.COVER)]
    window, _, _ = (cut for lid in lids for cut in lid.cuts if cut.role is CutRole.WINDOW)  # one each
    wide = (STEM[0] + 2 * gap) * (STEM[1] + 2 * gap)
    assert window.volume == pytest.approx(wide * closed.first(PartRole.CARRIER).body.high, rel=1e-3)
    plain = bare().with_(mold={"carrier": "plain", "gate": None})
    assert poured_volume(Job(plain)) - poured_volume(Job(on_stem)) == pytest.approx(160.0, rel=1e-6)
    # a check takes a flat back, and says so
    assert any("flat back" in note for note in skincad.check(on_stem, model="winkler").warnings)


def test_a_bone_that_ends_at_the_back_stands_on_pins(tmp_path: Path) -> None:
    design = boned(tmp_path, plate(), bone_bond="rivets")
    rods = pinned(design)
    assert sorted(rod.start[0] for rod in rods) == pytest.approx([-4.5, 4.5])
    assert {rod.radius for rod in rods} == {0.98}
    taken = math.prod(PLATE) - 2 * math.pi * 0.75**2 * PLATE[2]  # the rods keep the others free
    assert skin_part(bare()).volume - skin_part(design).volume == pytest.approx(taken, rel=1e-6)


HOLES = cq.Workplane("XY").box(*PLATE, centered=(True, True, False)).faces(">Z").workplane()
TAPPED = HOLES.pushPoints([(-4.5, 0), (4.5, 0)]).hole(2.05)


@pytest.mark.parametrize(
    ("shape", "neck"),
    [
        (plate(), 0.0),  # straight: silicone slides out
        (TAPPED.faces("<Z").workplane().pushPoints([(0, 4)]).cskHole(1.5, 3.0, 90.0), 0.75),
        (TAPPED.faces(">Z").workplane().pushPoints([(0, 4)]).cskHole(1.5, 3.0, 90.0), 0.0),  # the wrong way
        (TAPPED.faces("<Z").workplane().pushPoints([(0, 4)]).cboreHole(1.5, 3.0, 0.5), 0.75),
        (TAPPED.faces(">X").workplane(centerOption="CenterOfMass").hole(0.8), 0.4),
    ],
    ids=["straight", "countersunk", "countersunk from the face", "stepped", "across"],
)
def test_rivets_hold_where_no_straight_pull_empties_their_hole(
    tmp_path: Path, shape: cq.Workplane, neck: float
) -> None:
    """What is promised is the neck's area by E and a strain of a half; straight holes promise nothing."""
    job = Job(boned(tmp_path, shape, bone_bond="rivets"))
    rules = {finding.rule: finding.severity for finding in design_findings(job)}
    assert sum(job.bone.locks) == pytest.approx(math.pi * neck**2, rel=1e-6)
    assert pull_off(job) == pytest.approx(math.pi * neck**2 * job.silicone.young_modulus.value * 0.5)
    assert rules.get("bone rivets") == (None if neck else "warning")


def test_something_holds_a_bone_and_keeps_it_from_turning(tmp_path: Path) -> None:
    """Screws through the carrier, a clamp over the cover, or a screw in its end; else it is refused."""
    closed = mold(boned(tmp_path, plate()))
    assert len(closed.of(PartRole.BONE_SCREW)) == 2
    assert len([cut for cut in closed.first(PartRole.COVER).cuts if cut.role is CutRole.ACCESS]) == 2
    low = cq.Workplane("XY").box(8, 10, 2, centered=(True, True, False))
    low = low.faces("<Z").workplane().rect(*STEM[:2]).extrude(8.0)
    with pytest.raises(
        InputError, match=r"mold.bone: ends 2.05 mm under the cover's top.*nothing would hold"
    ):
        mold(boned(tmp_path, low))
    assert mold(boned(tmp_path, low.faces("<Z").workplane().hole(2.5, 6.0)))
    round_stem = cq.Workplane("XY").box(8, 10, 2, centered=(True, True, False))
    round_stem = round_stem.faces("<Z").workplane().circle(2.5).extrude(14.0)
    with pytest.raises(InputError, match=r"mold.bone: is round where it passes the carrier"):
        mold(boned(tmp_path, round_stem))


def test_a_pose_moves_and_turns_a_bone(tmp_path: Path) -> None:
    """Turned by a right angle about z, and moved: sides swap."""
    bone = bone_of(boned(tmp_path, stem(), bone_at=[2.0, 1.0, 0.0], bone_turn=[0.0, 0.0, 90.0]))
    low, high = bone.corners.reshape(-1, 3).min(axis=0), bone.corners.reshape(-1, 3).max(axis=0)
    assert low == pytest.approx([2 - 5, 1 - 4, -12], abs=1e-9)
    assert high == pytest.approx([2 + 5, 1 + 4, 2], abs=1e-9)


def test_a_bone_in_a_layered_skin_stands_in_the_layer_at_the_back(tmp_path: Path) -> None:
    shot = {"name": "dragon-skin-30", "thickness": 3.0}
    front, back = pours(Job(boned(tmp_path, stem()).with_(shot=(shot,))))
    plain = pours(Job(bare().with_(shot=(shot,), mold={"gate": None})))
    assert front.volume == pytest.approx(plain[0].volume, rel=1e-12)
    assert plain[1].volume - back.volume == pytest.approx(160.0, rel=1e-6)
    with pytest.raises(InputError, match=r"mold.bone_at: leaves 0 mm of silicone round the bone"):
        mold(boned(tmp_path, stem(3.2)).with_(shot=(shot,)))


def test_a_skin_in_a_bowl_is_cast_on_a_bone_whose_shoulder_follows_its_back(tmp_path: Path) -> None:
    """In front of the back lies its block of 8 x 10 x 2 mm and what the back falls away under it: a sector
    less a triangle. Distances are measured as it turns: its top corner is nearest to the face, at y = 5."""
    arm, half = 52.0, 5.0
    angle = math.asin(half / arm)
    under = 2 * half * arm - arm**2 * angle - half * arm * math.cos(angle)
    design = boned(tmp_path, saddle(arm), lab_bowl())
    bone = bone_of(design)
    assert bone.inside == pytest.approx(8.0 * (10.0 * 2.0 + under), rel=1e-9)
    assert skin_part(lab_bowl()).volume - skin_part(design).volume == pytest.approx(bone.inside, rel=1e-9)
    assert bone.levels.max() == pytest.approx(math.hypot(half, arm + 2.0) - arm, abs=1e-9)
    assert bone.printed
    closed = mold(design)
    (window,) = (cut for cut in closed.part("carrier").cuts if cut.role is CutRole.WINDOW)
    assert window.built.low < window.counts.low


def test_silicone_at_a_bowls_leaning_ends_is_measured_along_their_planes(tmp_path: Path) -> None:
    """The distance of the bone's corners, in front of the back, from the plane of the skin's end, which goes
    through the axis; the rule measures along the back's arc, so up to a tenth less over 5 mm of skin."""
    design = boned(tmp_path, saddle(52.0), lab_bowl(), bone_at=[0.0, 5.2, 0.0])
    with pytest.raises(InputError, match=r"leaves ([\d.]+) mm of silicone round the bone") as refused:
        mold(design)
    bone, half = bone_of(design), 12.0 / 60.0
    _, y, z = bone.corners[bone.levels > 0.0].T
    apart = float((math.sin(half) * (52.0 + z) - math.cos(half) * y).min())
    told = float(str(refused.value).partition("leaves ")[2].partition(" mm")[0])
    assert 0.9 * apart - 0.01 <= told <= apart + 0.01  # its chords


@pytest.mark.parametrize(
    ("shape", "taken"),
    [(stem(), 160.0), (plate(), math.prod(PLATE) - 2 * math.pi * 0.75**2 * PLATE[2])],
    ids=["stem", "plate"],
)
def test_a_round_skin_is_cast_on_a_bone(tmp_path: Path, shape: cq.Workplane, taken: float) -> None:
    bond = {"bone_bond": "rivets"} if taken != 160.0 else {}
    part = skin_part(boned(tmp_path, shape, wide_rings(), **bond))
    assert skin_part(wide_rings()).volume - part.volume == pytest.approx(taken, rel=1e-6)


def test_silicone_round_a_bone_in_a_round_skin_is_measured_as_it_turns(tmp_path: Path) -> None:
    """A corner of the block at (9.4, 5) mm, and the rim at 11 mm; a straight skin's side would be 1.6 mm
    away."""
    left = 11.0 - math.hypot(9.4, 5.0)
    assert 0.3 < left < 0.4
    with pytest.raises(InputError, match=rf"leaves {left:.3g} mm of silicone round the bone"):
        mold(boned(tmp_path, stem(), wide_rings(), bone_at=[5.4, 0.0, 0.0]))
    assert mold(boned(tmp_path, stem(), wide_rings(), bone_at=[0.0, 4.0, 0.0]))


def test_a_turning_bone_takes_what_its_faces_pass_through(tmp_path: Path) -> None:
    """Points of the block's faces turn within, and reach its ends; 2 um: a chord between slices."""
    bone = bone_of(boned(tmp_path, stem(), wide_rings(), bone_at=[1.0, 4.0, 0.0], bone_turn=[6.0, 3.0, 20.0]))
    region, dice = bone.in_section(turned=True), np.random.default_rng(1)
    shares = dice.dirichlet(np.ones(3), (len(bone.corners), 200))
    points = (shares @ bone.corners).reshape(-1, 3)
    points = points[points[:, 2] > 0.0]
    away = np.hypot(points[:, 0], points[:, 1])
    assert shapely.distance(region, shapely.points(away, points[:, 2])).max() < 2e-3
    front = bone.corners.reshape(-1, 3)[bone.corners.reshape(-1, 3)[:, 2] > 0.0]
    assert region.bounds[2] == pytest.approx(np.hypot(front[:, 0], front[:, 1]).max(), abs=2e-3)
    assert region.bounds[1::2] == pytest.approx((0.0, front[:, 2].max()), abs=1e-8)  # what joins its pieces
    assert region.bounds[0] <= away.min() + 2e-3
    outside = [(region.bounds[2] + 5e-3, 1.0), (1.0, front[:, 2].max() + 5e-3), (1.0, -5e-3)]
    assert not shapely.intersects(region, shapely.points(outside)).any()


@pytest.mark.slow
@pytest.mark.parametrize("shape", [stem(), plate()], ids=["stem", "plate"])
def test_each_skin_of_a_gang_has_its_bone(tmp_path: Path, shape: cq.Workplane) -> None:
    design = boned(tmp_path, shape, cavities=2)
    closed, one = mold(design), mold(design.with_(mold={"cavities": 1}))
    assert len(closed.of(PartRole.BONE)) == 2
    assert len(closed.of(PartRole.CORE_PIN)) == 2 * len(one.of(PartRole.CORE_PIN))
    for role in (PartRole.COVER, PartRole.SEAL):
        roles, alone = ([cut.role for cut in each.first(role).cuts] for each in (closed, one))
        assert roles.count(CutRole.WINDOW) == 2 * alone.count(CutRole.WINDOW)


@pytest.mark.slow
def test_what_a_higher_back_changes_is_the_check_of_a_thinner_skin(tmp_path: Path) -> None:
    single = skincad.load("lab-bench", ["ridge.count=1"])
    result = skincad.make(boned(tmp_path, stem(), single), model="winkler")
    (finding,) = [f for f in result.findings if f.rule == "bone"]
    thin = single.with_(skin={"thickness": 6.0})
    assert finding.measured == pytest.approx(float(skincad.check(thin, model="linear").all_touch_force))


@pytest.mark.evidence(subject="bone: higher back")
@pytest.mark.parametrize(
    "base",
    [pillars(), wide_rings(), skincad.load("flat-magnet").with_(flat={"pocket": None})],
    ids=lambda d: d.name,
)
def test_what_a_higher_back_changes_is_said_of_every_family(tmp_path: Path, base: Design) -> None:
    design = boned(tmp_path, stem(), base)
    result = skincad.make(design, model="linear" if base.features.family != "pin" else "reduced")
    (finding,) = [f for f in result.findings if f.rule == "bone"]
    flat = base.features.family == "flat"
    assert ("(2 mm) at 4 N the plate comes" if flat else "N, and at 4 N the plate") in finding.remedy
    assert "error" not in [f.severity for f in skincad.make(design, checked=False).findings]


@pytest.mark.slow
def test_a_bone_is_a_packages_link(on_stem: Design) -> None:
    package = skincad.package(on_stem, "urdf")
    density = lid_process(package.design).density  # as if of the lids' material
    assert package.weighs.carrier.mass == pytest.approx((160.0 + math.prod(STEM)) * density * 1e-3, rel=1e-9)


@pytest.mark.slow
def test_a_bones_file_may_have_any_name_in_the_parts_list(tmp_path: Path) -> None:
    path = tmp_path / "finger | left.step"
    cq.exporters.export(stem(), str(path))
    rows = parts_list(Job(skincad.load("lab-bench", ["ridge.count=3"]).with_(mold={"bone": str(path)})))
    assert [row.designation for row in rows if row.what == "bone"] == [path.name]


@pytest.mark.slow
def test_the_sheet_says_what_to_do_with_a_bone(tmp_path: Path) -> None:
    steps = sheet_steps(Job(boned(tmp_path, stem())))
    assert "Prime the bone" in steps["bone"]
    assert "window" in steps["bone"]
    assert "draw the skin out of the cavity by the bone" in steps["skin out"]
    assert "small clamp round the 1.9 mm" in steps["hold"]
    steps = sheet_steps(Job(boned(tmp_path, plate(), bone_bond="rivets")))
    assert "Screw it under the carrier by 2 screws" in steps["bone"]
    assert "Tap the bone's two holes for M2.5" in steps["prepare"]
    assert "Brush the mix into the bone's holes" in steps["bone holes"]
    order = [*steps]
    assert order.index("release") < order.index("bone") < order.index("mix") < order.index("bone holes")
    assert "pockets" not in steps["skin out"]


TWO = cq.Workplane("XY").box(2, 2, 2).union(cq.Workplane("XY").center(10, 0).box(2, 2, 2))
STRAIGHT = cq.Workplane("XY").box(5, 6, 8)
BLOCK = cq.Workplane("XY").box(6, 6, 2, centered=(True, True, False))


def test_a_bone_that_is_not_there_or_no_step_is_refused(tmp_path: Path) -> None:
    """The kernel writes nothing of its own beside it."""
    (tmp_path / "no.step").write_text("solid")
    text = skincad.load("lab-bench").to_toml()
    (tmp_path / "pad.toml").write_text(text.replace("[mold]", '[mold]\nbone = "no.step"', 1))
    line = refused_command("make", "pad.toml", "--no-check", cwd=tmp_path)
    assert "mold.bone: is no STEP file" in line
    with pytest.raises(InputError, match=r"mold.bone: there is no such file"):
        mold(skincad.load("lab-bench").with_(mold={"bone": str(tmp_path / "none.step")}))
    with pytest.raises(InputError, match=r"mold.bone_at: needs mold.bone"):
        skincad.load("lab-bench", ["mold.bone_at=[0.0, 0.0, 1.0]"])
    with pytest.raises(InputError, match=r"mold.carrier: must be 'plain' with a bone"):
        skincad.load("lab-bench", ["mold.bone='a.step'", "mold.carrier='perforated'"])


def test_a_bones_path_counts_from_its_design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = skincad.load("lab-bench").to_toml().replace("[mold]", '[mold]\nbone = "bone.step"', 1)
    cq.exporters.export(stem(), str(tmp_path / "bone.step"))
    (tmp_path / "pad.toml").write_text(text)
    monkeypatch.chdir(Path.home())
    assert skincad.load(tmp_path / "pad.toml").mold.bone == str(tmp_path / "bone.step")
    monkeypatch.chdir(tmp_path)  # one that is set lies in the working directory, for files in any folder
    set_here = skincad.load("lab-bench", ["mold.bone='bone.step'"])
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "design.toml").write_text(set_here.to_toml())
    assert skincad.load(tmp_path / "out" / "design.toml") == set_here


def test_a_hole_that_another_cuts_holds_no_pin(tmp_path: Path) -> None:
    """Of two holes that overlap neither is closed all round; nor is one that breaks out of the side."""
    blank = cq.Workplane("XY").box(*PLATE, centered=(True, True, False))
    for places, left in (([(-4, 0), (4, 0)], 2), ([(-4, 0), (-2.8, 0), (4, 0)], 1), ([(0, 0), (5.6, 0)], 1)):
        bone = boned(tmp_path, blank.faces(">Z").workplane().pushPoints(places).hole(2.0))
        if left == 2:
            assert len(pinned(bone)) == 2
            continue
        with pytest.raises(InputError, match=r"and has 1 hole along z that open there, closed all round"):
            mold(bone)


@pytest.mark.evidence(subject="bones: random")
def test_random_bones_are_made_or_refused_by_a_rule(tmp_path: Path) -> None:
    """Stems and plates with rounded edges, holes anywhere and turned, in ridges, pins and rings. Of 62 such
    bones 48 were made and 14 refused; 2 ended as a fault before holes had to be closed."""
    made = 0
    for seed in (2, 9, 18, 30, 34, 36):
        dice = random.Random(seed)
        wide, long, high = dice.uniform(6, 9), dice.uniform(6, 9), dice.uniform(0.8, 2.0)
        shape = cq.Workplane("XY").box(wide, long, high, centered=(True, True, False))
        if dice.random() < 0.5:
            shape = shape.faces("<Z").workplane().rect(0.6 * wide, 0.6 * long).extrude(12)
        else:
            at = [(-0.3 * wide, 0), (0.3 * wide, 0)]
            shape = shape.faces(">Z").workplane().pushPoints(at).hole(dice.uniform(1, 2))
        shape = shape.edges("|Z").fillet(dice.uniform(0.2, 0.9))
        side = (
            shape.faces(">Z")
            .workplane()
            .center(dice.uniform(-0.5, 0.5) * wide, dice.uniform(-0.3, 0.3) * long)
        )
        shape = side.hole(dice.uniform(0.6, 1.5))
        base = dice.choice([None, pillars(), wide_rings()])
        turn = {"bone_turn": [0.0, 0.0, round(dice.uniform(0, 90), 1)]}
        with contextlib.suppress(InputError):  # never a KernelError, which is a fault
            skincad.make(boned(tmp_path, shape, base, **turn), checked=False, solids=True)
            made += 1
    assert made >= 2


def test_a_pipe_is_not_waited_for_and_a_file_that_nests_without_end_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.step")
    with pytest.raises(InputError, match=r"mold.bone: is not a regular file"):
        mold(skincad.load("lab-bench").with_(mold={"bone": str(tmp_path / "pipe.step")}))
    (tmp_path / "deep.step").write_text("ISO-10303-21;DATA;#1=A(" + "(" * 200_000 + ")" * 200_000 + ");")
    with pytest.raises(InputError, match=r"mold.bone: must not nest more than 100 deep, got 200001"):
        mold(skincad.load("lab-bench").with_(mold={"bone": str(tmp_path / "deep.step")}))


@pytest.mark.parametrize(
    ("shape", "keys", "refusal"),
    [
        ("no step", {}, "mold.bone: is no STEP file"),
        (TWO, {}, "mold.bone: must hold one solid, and holds 2"),
        (cq.Workplane("XY").box(4, 4, 4).faces(">Z"), {}, "mold.bone: must hold one solid, and holds 0"),
        (stem(), {"bone_at": [40.0, 0.0, 0.0]}, "mold.bone_at: puts the bone outside the skin"),
        (stem(), {"bone_at": [0.0, 0.0, -3.0]}, "mold.bone_at: puts the bone's top at -1 mm"),
        (stem(7.8), {}, "mold.bone_at: leaves a feature no base"),
        (stem(), {"bone_at": [6.8, 0.0, 0.0]}, "mold.bone_at: leaves 0.2 mm of silicone round the bone"),
        (STRAIGHT, {}, "mold.bone: has no shoulder at the back"),
        (BLOCK, {}, "mold.bone: ends at the back"),
        (stem(), {"bone_bond": "rivets"}, "mold.bone_bond: 'rivets' need a round hole"),
        (stem(), {"base": "bowl"}, "mold.bone: stands on the bent back by 9.6. mm2, and leaves a wedge"),
        (plate(), {"base": "bowl"}, "mold.bone: ends at the back, which is bent along y"),
        (saddle(52.0), {"base": "bowl", "bone_at": [0.0, 5.2, 0.0]}, "mold.bone_at: leaves 0.2"),
        (stem(), {"bone_at": [0.0, -6.0, 0.0], "vent": 2.0}, "mold.bone_at: reaches behind the back where"),
        # the block ends at y = -5 mm, the pocket of the pin at y = -6 begins 0.7 mm before its axis
        (stem(), {"base": "pillars-9"}, r"pin.pocket: leaves 0.3 mm of silicone beside the bone at \(0,"),
    ],
)  # fmt: skip
def test_what_a_bone_cannot_be(tmp_path: Path, shape: Any, keys: dict[str, Any], refusal: str) -> None:
    base = keys.get("base") and (lab_bowl() if keys["base"] == "bowl" else skincad.load(keys["base"]))
    keys = {key: value for key, value in keys.items() if key != "base"}
    with pytest.raises(InputError, match=refusal):
        mold(boned(tmp_path, shape, base, **keys))


def test_chamfers_belong_to_their_holes_and_screws_hold_no_silicone(tmp_path: Path) -> None:
    """CAD programs chamfer holes; what a screw fills is no rivet, however it widens."""
    for size in (0.1, 0.3, 0.5):
        under = cq.Workplane("XY").box(*PLATE, centered=(True, True, False)).faces("<Z").workplane()
        chamfered = under.pushPoints([(-4, 0), (4, 0)]).cskHole(2.05, 2.05 + 2 * size, 90.0)
        assert len(pinned(boned(tmp_path, chamfered))) == 2
    under = cq.Workplane("XY").box(*PLATE, centered=(True, True, False)).faces("<Z").workplane()
    widened = under.pushPoints([(-4.5, 0), (4.5, 0)]).cskHole(2.05, 2.65, 90.0)
    both = widened.faces(">Z").workplane().pushPoints([(0, 4), (0, -4)]).hole(1.5)
    bone = bone_of(boned(tmp_path, both, bone_bond="rivets"))
    assert bone.locks == ()


def test_a_cup_keeps_off_a_bones_window(tmp_path: Path) -> None:
    shape = cq.Workplane("XY").box(8, 26, 2, centered=(True, True, False))
    shape = shape.faces("<Z").workplane().rect(5, 21).extrude(14)
    base = bare().with_(skin={"width": 30.0, "length": 30.0, "thickness": 8.0, "curvature_radius": 60.0})
    closed = mold(boned(tmp_path, shape, base))
    (cup,) = (cut for cut in closed.first(PartRole.COVER).cuts if cut.role is CutRole.RESERVOIR)
    windows = [cut for cut in closed.first(PartRole.COVER).cuts if cut.role is CutRole.WINDOW]
    ring = shapely.Polygon([(s.start.x, s.start.z) for s in windows[0].outline])
    assert ring.distance(shapely.Point(cup.start[:2])) > cup.far_radius
