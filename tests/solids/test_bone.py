"""Bones: a user's solid that the skin is cast on, in the mold, in the skin, and what is refused."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import cadquery as cq
import pytest

import skincad
from skincad import InputError
from skincad.fabrication import Job, interference, mesh, poured_volume, pours, sheet_steps
from skincad.inputs import Design
from skincad.solids import CutRole, PartRole, bone_of, lid_process, pinned, skin_part, solid, volume
from skincad.solids.mold import mold
from tests.refusals import refused_command

CHORD = 1e-3  # mm
STEM, PLATE = (5.0, 6.0, 12.0), (12.0, 14.0, 1.5)


def stem(high: float = 2.0) -> cq.Workplane:
    """A block on the back, and a stem behind it."""
    block = cq.Workplane("XY").box(8, 10, high, centered=(True, True, False))
    return block.faces("<Z").workplane().rect(*STEM[:2]).extrude(STEM[2])


def plate() -> cq.Workplane:
    """A plate that ends at the back, with two holes for pins and two for rivets."""
    block = cq.Workplane("XY").box(*PLATE, centered=(True, True, False))
    drilled = block.faces(">Z").workplane().pushPoints([(-4.5, 0), (4.5, 0)]).hole(2.0)
    return drilled.faces(">Z").workplane().pushPoints([(0, -4), (0, 4)]).hole(1.5)


def boned(folder: Path, shape: cq.Workplane | str, name: str = "lab-bench", **mold_keys: Any) -> Design:
    path = folder / "bone.step"
    if isinstance(shape, str):
        path.write_text(shape)
    else:
        cq.exporters.export(shape, str(path))
    return skincad.load(name).with_(mold={"bone": str(path), "gate": None, **mold_keys})


def test_a_bone_takes_its_room_of_the_skin(tmp_path: Path) -> None:
    """The block and half a thickness of edges: the kernel's solid, the formula and the mesh agree."""
    design = boned(tmp_path, stem())
    bone = bone_of(design)
    assert bone is not None
    assert bone.inside == pytest.approx(8 * 10 * 2, rel=1e-9)
    assert bone.volume == pytest.approx(8 * 10 * 2 + math.prod(STEM), rel=1e-9)
    bare = skin_part(skincad.load("lab-bench")).volume
    part = skin_part(design)
    assert part.volume == pytest.approx(bare - 160.0, rel=1e-9)
    assert volume(part, solid(part)) == pytest.approx(part.volume, rel=1e-8)
    assert mesh(part, CHORD).volume == pytest.approx(part.volume, rel=1e-4)
    closed = mold(design)
    assert interference(closed, CHORD) == []
    lids = [closed.first(role) for role in (PartRole.CARRIER, PartRole.SEAL, PartRole.COVER)]
    windows = [[cut for cut in lid.cuts if cut.role is CutRole.WINDOW] for lid in lids]
    assert [len(holes) for holes in windows] == [1, 1, 1]
    gap = design.mold.clearance
    wide = (STEM[0] + 2 * gap) * (STEM[1] + 2 * gap)
    assert windows[0][0].volume == pytest.approx(wide * closed.first(PartRole.CARRIER).body.high, rel=1e-3)
    (job, plain) = Job(design), Job(skincad.load("lab-bench").with_(mold={"carrier": "plain", "gate": None}))
    assert poured_volume(plain) - poured_volume(job) == pytest.approx(160.0, rel=1e-6)


def test_a_bone_that_ends_at_the_back_stands_on_pins(tmp_path: Path) -> None:
    design = boned(tmp_path, plate(), bone_bond="rivets")
    rods = pinned(design)
    assert sorted(rod.start[0] for rod in rods) == pytest.approx([-4.5, 4.5])
    assert {rod.radius for rod in rods} == {0.98}
    closed = mold(design)
    assert len(closed.of(PartRole.CORE_PIN)) == 2
    assert interference(closed, CHORD) == []
    taken = math.prod(PLATE) - 2 * math.pi * 0.75**2 * PLATE[2]  # the rods keep the others free
    bare = skin_part(skincad.load("lab-bench")).volume
    part = skin_part(design)
    assert bare - part.volume == pytest.approx(taken, rel=1e-6)
    assert volume(part, solid(part)) == pytest.approx(part.volume, rel=1e-8)


def test_a_pose_moves_and_turns_a_bone(tmp_path: Path) -> None:
    """Turned by a right angle about z, and moved: sides swap, and so does the window."""
    design = boned(tmp_path, stem(), bone_at=[2.0, 1.0, 0.0], bone_turn=[0.0, 0.0, 90.0])
    bone = bone_of(design)
    assert bone is not None
    low, high = bone.corners.reshape(-1, 3).min(axis=0), bone.corners.reshape(-1, 3).max(axis=0)
    assert low == pytest.approx([2 - 5, 1 - 4, -12], abs=1e-9)
    assert high == pytest.approx([2 + 5, 1 + 4, 2], abs=1e-9)
    assert interference(mold(design), CHORD) == []


def test_a_bone_in_a_layered_skin_stands_in_the_layer_at_the_back(tmp_path: Path) -> None:
    shot = {"name": "dragon-skin-30", "thickness": 3.0}
    design = boned(tmp_path, stem()).with_(shot=(shot,))
    job = Job(design)
    front, back = pours(job)
    plain = pours(Job(skincad.load("lab-bench").with_(shot=(shot,), mold={"gate": None})))
    assert front.volume == pytest.approx(plain[0].volume, rel=1e-12)
    assert plain[1].volume - back.volume == pytest.approx(160.0, rel=1e-6)
    assert all(interference(stage, CHORD) == [] for stage in job.closed.earlier)
    with pytest.raises(InputError, match=r"mold.bone_at: leaves 0 mm of silicone round the bone"):
        mold(boned(tmp_path, stem(3.2)).with_(shot=(shot,)))


@pytest.mark.parametrize("shape", [stem(), plate()], ids=["stem", "plate"])
def test_a_round_skin_is_cast_on_a_bone(tmp_path: Path, shape: cq.Workplane) -> None:
    """The kernel's solid, the formula and the mesh agree; it opens; a layer behind takes the bone too."""
    design = boned(tmp_path, shape, name="rings-5")
    part = skin_part(design)
    assert volume(part, solid(part)) == pytest.approx(part.volume, rel=1e-8)
    assert mesh(part, CHORD).volume == pytest.approx(part.volume, rel=3e-4)
    closed = mold(design.with_(shot=({"name": "dragon-skin-30", "thickness": 2.6},)))
    for stage in (closed, *closed.earlier):
        assert interference(stage, CHORD) == []
    assert len(closed.of(PartRole.BONE)) == 1


def test_silicone_round_a_bone_in_a_round_skin_is_measured_as_it_turns(tmp_path: Path) -> None:
    """A corner of the block at (10.4, 5) mm, and the rim at 12 mm; a straight skin's side would be 1.6 mm
    away."""
    left = 12.0 - math.hypot(10.4, 5.0)
    assert 0.4 < left < 0.5
    with pytest.raises(InputError, match=rf"leaves {left:.3g} mm of silicone round the bone"):
        mold(boned(tmp_path, stem(), name="rings-5", bone_at=[6.4, 0.0, 0.0]))
    assert interference(mold(boned(tmp_path, stem(), name="rings-5", bone_at=[0.0, 5.0, 0.0])), CHORD) == []


@pytest.mark.parametrize("shape", [stem(), plate()], ids=["stem", "plate"])
def test_each_skin_of_a_gang_has_its_bone(tmp_path: Path, shape: cq.Workplane) -> None:
    design = boned(tmp_path, shape, cavities=2)
    closed, one = mold(design), mold(design.with_(mold={"cavities": 1}))
    assert interference(closed, CHORD) == []
    assert len(closed.of(PartRole.BONE)) == 2
    assert len(closed.of(PartRole.CORE_PIN)) == 2 * len(one.of(PartRole.CORE_PIN))
    for role in (PartRole.COVER, PartRole.SEAL):
        two, alone = (
            [cut for cut in of.first(role).cuts if cut.role is CutRole.WINDOW] for of in (closed, one)
        )
        assert len(two) == 2 * len(alone)


def test_pockets_keep_clear_of_a_bone(tmp_path: Path) -> None:
    """The block ends at y = -5 mm, the pocket of the pin at y = -6 begins 0.8 mm before its axis."""
    with pytest.raises(
        InputError, match=r"pin.pocket: leaves 0.2 mm of silicone beside the bone at \(0, -6\)"
    ):
        mold(boned(tmp_path, stem(), name="pillars-9"))


def test_the_sheet_says_what_to_do_with_a_bone(tmp_path: Path) -> None:
    steps = sheet_steps(Job(boned(tmp_path, stem())))
    assert "Prime the bone" in steps["bone"]
    assert "window" in steps["bone"]
    assert "Slide the carrier up off the bone" in steps["skin out"]
    steps = sheet_steps(Job(boned(tmp_path, plate(), bone_bond="rivets")))
    assert "2 ground rods of 1.96 mm" in steps["bone"]
    assert "pockets" not in steps["skin out"]


def test_a_check_says_that_it_takes_a_flat_back(tmp_path: Path) -> None:
    """And what a back at the bone's top changes is the check of a skin as much thinner."""
    design = boned(tmp_path, stem())
    assert any("flat back" in note for note in skincad.check(design, model="linear").warnings)
    (finding,) = [f for f in skincad.make(design, model="linear").findings if f.rule == "bone"]
    thin = skincad.load("lab-bench").with_(skin={"thickness": 6.0})
    assert finding.measured == pytest.approx(float(skincad.check(thin, model="linear").all_touch_force))


@pytest.mark.parametrize(
    ("name", "tables", "words"),
    [
        ("pillars-9", {"pin": {"pocket": None}}, "N, and at 2 N the plate comes"),
        ("rings-5", {}, "N, and at 8 N the plate comes"),
        ("flat-magnet", {"flat": {"pocket": None}}, r"\(2 mm\) at 4 N the plate comes"),
    ],
)
def test_what_a_higher_back_changes_is_said_of_every_family(
    tmp_path: Path, name: str, tables: Any, words: str
) -> None:
    design = boned(tmp_path, stem(), name=name).with_(**tables)
    (finding,) = [f for f in skincad.make(design).findings if f.rule == "bone"]
    assert re.search(words, finding.remedy)
    assert not [f for f in skincad.make(design, checked=False).findings if f.severity == "error"]


def test_a_bone_is_a_packages_link(tmp_path: Path) -> None:
    package = skincad.package(boned(tmp_path, stem()), "urdf")
    grams = (
        (160.0 + math.prod(STEM)) * lid_process(package.design).density * 1e-3
    )  # as if of the lids' material
    assert package.weighs.carrier.mass == pytest.approx(grams, rel=1e-9)


TWO = cq.Workplane("XY").box(2, 2, 2).union(cq.Workplane("XY").center(10, 0).box(2, 2, 2))
STRAIGHT = cq.Workplane("XY").box(5, 6, 8)


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
        (cq.Workplane("XY").box(6, 6, 2, centered=(True, True, False)), {}, "mold.bone: ends at the back"),
        (stem(), {"bone_bond": "rivets"}, "mold.bone_bond: 'rivets' need a round hole"),
        (stem(), {"name": "pins-dome"}, "skin.curvature_radius_y: must not be given with mold.bone"),
        (
            stem(),
            {"bone_at": [0.0, -6.0, 0.0], "vent": 2.0},
            "mold.bone_at: reaches behind the back where the carrier",
        ),
    ],
)
def test_what_a_bone_cannot_be(tmp_path: Path, shape: Any, keys: dict[str, Any], refusal: str) -> None:
    with pytest.raises(InputError, match=refusal):
        mold(boned(tmp_path, shape, **keys))


def test_a_file_that_is_no_step_is_refused_in_one_line(tmp_path: Path) -> None:
    """The kernel writes nothing of its own beside it."""
    (tmp_path / "no.step").write_text("solid")
    text = skincad.load("lab-bench").to_toml()
    (tmp_path / "pad.toml").write_text(text.replace("[mold]", '[mold]\nbone = "no.step"', 1))
    line = refused_command("make", "pad.toml", "--no-check", cwd=tmp_path)
    assert "mold.bone: is no STEP file" in line


def test_a_bone_that_is_not_there(tmp_path: Path) -> None:
    design = skincad.load("lab-bench").with_(mold={"bone": str(tmp_path / "none.step")})
    with pytest.raises(InputError, match=r"mold.bone: there is no such file"):
        mold(design)
    with pytest.raises(InputError, match=r"mold.bone_at: needs mold.bone"):
        skincad.load("lab-bench", ["mold.bone_at=[0.0, 0.0, 1.0]"])
    with pytest.raises(InputError, match=r"mold.carrier: must be 'plain' with a bone"):
        skincad.load("lab-bench", ["mold.bone='a.step'", "mold.carrier='perforated'"])


def test_a_bones_path_counts_from_its_design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = skincad.load("lab-bench").to_toml()
    cq.exporters.export(stem(), str(tmp_path / "bone.step"))
    (tmp_path / "pad.toml").write_text(
        text.replace('process = "sla"', 'process = "sla"\nbone = "bone.step"', 1)
    )
    monkeypatch.chdir(Path.home())
    assert skincad.load(tmp_path / "pad.toml").mold.bone == str(tmp_path / "bone.step")
