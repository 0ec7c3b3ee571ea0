"""A mount in a design: its table, and grippers as data, which drill a carrier."""

from __future__ import annotations

from pathlib import Path

import pytest

import skincad
from skincad.base import InputError
from skincad.fabrication import Job, mount_findings, mount_of
from skincad.inputs import Mount, grippers, load
from skincad.solids.mold import mold
from tests.refusals import refused_by

GOOD = [
    {"thread": "M3", "diameter": 20.0},
    {"thread": "M2", "diameter": 20.0, "count": 6, "angle": 0.0, "pin": 1.5},
    {"thread": "M4", "pattern": "rectangle", "pitch_x": 8.0},
    {"thread": "M2.5", "pattern": "rectangle", "pitch_y": 8.0, "pitch_x": 3.0, "fiducials": 4},
    {"fiducials": 3, "fiducial_diameter": 2.0, "fiducial_depth": 0.3},
]
BAD = [
    ({}, "mount: needs a thread or fiducials"),
    ({"thread": "M5", "diameter": 9.0}, "mount.thread: must be 'M2', 'M2.5', 'M3' or 'M4'"),
    ({"diameter": 9.0}, "mount.thread: is missing where diameter is given"),
    ({"pin": 2.0, "fiducials": 3}, "mount.thread: is missing where pin is given"),
    ({"thread": "M3"}, "mount.diameter: is missing for a circle"),
    ({"thread": "M3", "pattern": "rectangle"}, "mount.pitch_x: is missing for a rectangle"),
    ({"thread": "M3", "pitch_x": 4.0}, "mount.pattern: must be 'rectangle' where pitch_x is given"),
    (
        {"thread": "M3", "pattern": "rectangle", "pitch_x": 4.0, "angle": 0.0},
        "mount.pattern: must be 'circle' where angle is given",
    ),
    ({"fiducials": 2}, "mount.fiducials: must be 0, 3 or 4"),
    ({"fiducials": 5}, "mount.fiducials: must be less than or equal to 4"),
    ({"thread": "M3", "diameter": 9.0, "bolt": 4}, "mount.bolt: unknown key"),
    ({"thread": "M3", "diameter": 9.0, "count": 1}, "mount.count: must be greater than or equal to 2"),
    ({"thread": "M3", "diameter": 9.0, "pin": 4.0}, "mount.pin: must be less than or equal to 3"),
]


@pytest.mark.parametrize("given", GOOD)
def test_what_goes_together_is_kept_and_written(given: dict[str, object]) -> None:
    design = skincad.load("yamada-2002").with_(mount=given)
    assert design.mount == Mount(**given)
    assert "[mount]" in design.to_toml()
    assert design.with_(mount=None) == skincad.load("yamada-2002")


@pytest.mark.parametrize(("given", "words"), BAD)
def test_what_does_not_is_told_in_one_line(given: dict[str, object], words: str) -> None:
    with refused_by(words):
        skincad.load("yamada-2002").with_(mount=given)


def test_it_is_set_from_the_command_line_and_dropped() -> None:
    keys = ["mount.thread=M2", "mount.pattern=rectangle", "mount.pitch_x=8.0"]
    assert load("yamada-2002", keys).mount == Mount(thread="M2", pattern="rectangle", pitch_x=8.0)
    assert load("yamada-2002", [*keys, "mount=none"]).mount is None


def test_a_design_without_one_says_nothing_of_it() -> None:
    """Else every revision would change."""
    assert "mount" not in skincad.load("yamada-2002").to_toml()


NAMES = ("franka-hand", "robotiq-2f85", "umi", "leap-hand", "anyskin-plate", "plain-plate")
OWN_GRIPPERS = """
[my-finger]
width = 30.0
length = 40.0
thread = "M2"
pattern = "rectangle"
pitch_y = 14.0

[franka-hand]
measured = true
pitch_x = 9.0
"""


def on(name: str, **sizes: float) -> skincad.Design:
    """A pad as large as the gripper's face, without strips."""
    gripper = grippers()[name]
    room = {"width": gripper.width, "length": gripper.length, **sizes}
    return skincad.load_design("plain-ridges", [f"mold.mount={name}"]).with_(skin=room)


@pytest.mark.parametrize("name", NAMES)
def test_every_gripper_drills_a_carrier_of_its_size(name: str) -> None:
    design, gripper = on(name), grippers()[name]
    mount = mount_of(Job(design))
    assert mount is not None
    assert mount.thread == gripper.thread
    xs, ys = zip(*mount.positions, strict=True)
    for places, pitch in ((xs, gripper.pitch_x), (ys, gripper.pitch_y)):
        if pitch is not None:
            assert max(places) - min(places) == pytest.approx(pitch, abs=1e-9)
    assert [f.rule for f in mount_findings(Job(design))] == ["gripper holes"] * (not gripper.measured)
    assert gripper.source


def test_shipped_grippers_are_those_that_are_named_and_a_guess_says_so() -> None:
    assert set(grippers()) == {*NAMES}
    for gripper in grippers().values():
        assert gripper.measured or "assumption" in gripper.source


def test_a_skin_larger_than_the_finger_is_told() -> None:
    found = [f for f in mount_findings(Job(on("franka-hand", width=20.0))) if f.rule == "gripper face"]
    assert [(f.severity, f.measured, f.limit) for f in found] == [("note", 20.0, 17.0)]


def test_ones_own_grippers_change_the_shipped_ones_and_add_to_them(tmp_path: Path) -> None:
    file = tmp_path / "grippers.toml"
    file.write_text(OWN_GRIPPERS)
    mine = skincad.load_design(
        "plain-ridges", ["mold.mount=my-finger", "skin.length=30", "skin.width=20"], grippers=file
    )
    assert mine.mounting is not None
    assert (mine.mounting.thread, mine.mounting.pitch_y) == ("M2", 14.0)
    changed = skincad.load_design("plain-ridges", ["mold.mount=franka-hand"], grippers=file)
    assert changed.mounting is not None
    assert (changed.mounting.pitch_x, changed.mounting.thread) == (9.0, "M2")
    assert list(mount_findings(Job(changed))) == []  # it is measured now
    copy = tmp_path / "copy.toml"
    copy.write_text(mine.to_toml())
    assert skincad.load_design(copy) == mine  # it holds its gripper
    assert mine.with_(mold={"mount": "plain-plate"}).mounting != mine.mounting


def test_holes_without_room_name_the_gripper_that_has_them() -> None:
    small = skincad.load_design("plain-ridges", ["mold.mount=plain-plate"])
    with pytest.raises(InputError) as refused:
        mold(small)
    assert str(refused.value).startswith("mold.mount: its diameter must be at most ")
    assert "got 'plain-plate'; take another gripper, a larger skin" in str(refused.value)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["mold.mount=franka"], "mold.mount: no such gripper, got 'franka'; did you mean 'franka-hand'"),
        (["mold.mount=umi", "mount.thread=M3", "mount.diameter=9"], "has its own holes, and so has [mount]"),
        (["grippers.my-finger={thread='M3'}"], "grippers.my-finger.diameter: is missing for a circle"),
        (["grippers.X={thread='M3', diameter=20}"], "grippers: the name must be 3 to 32"),
    ],
)
def test_what_is_no_gripper_is_refused(settings: list[str], words: str) -> None:
    with pytest.raises(InputError) as refused:
        skincad.load_design("plain-ridges", settings)
    assert words in str(refused.value)
