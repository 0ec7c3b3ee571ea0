"""A workshop's own processes and grippers, and a mount in a design: how they reach it, what is refused."""

from __future__ import annotations

import re
import shutil
import tomllib
from pathlib import Path

import pytest
import tomlkit

import skincad
from skincad.base import InputError
from skincad.fabrication import Job, mount_findings, mount_of
from skincad.inputs import PROCESSES, Mount, grippers, load, processes, table_text
from skincad.mechanics import spread_of
from skincad.solids.mold import mold
from tests.conftest import run_skincad
from tests.processes import python
from tests.refusals import refused, refused_by, refused_command

ROOT = Path(skincad.__file__).parents[1]
OWN = """
[sla]
pixel = 0.035
crest_sigma = 0.02

[my-mill]
based_on = "cnc"
tool_radius = 0.1
"""


@pytest.fixture
def printer(tmp_path: Path) -> Path:
    path = tmp_path / "printer.toml"
    path.write_text(OWN)
    return path


def test_every_shipped_value_is_a_key_with_a_source() -> None:
    assert tuple(processes()) == PROCESSES
    rows = [row for row in table_text("processes").splitlines() if " = " in row and not row.startswith("#")]
    assert len(rows) == sum(len(table) for table in tomllib.loads(table_text("processes")).values())
    assert all("# assumption" in row or "# source" in row for row in rows)


def test_an_own_file_changes_what_it_names_and_no_more(printer: Path) -> None:
    design = skincad.load("lab-bench", printer=printer)
    known, shipped = processes(design.printer), processes()
    assert known["sla"] == shipped["sla"].model_copy(update={"pixel": 0.035, "crest_sigma": 0.02})
    assert known["my-mill"] == shipped["cnc"].model_copy(update={"tool_radius": 0.1})
    assert known["edm"] == shipped["edm"]
    assert spread_of(design).crest_sigma == 0.02
    known = processes(skincad.load("lab-bench", ["printer.sla.pixel=0.01"], printer=printer).printer)
    assert (known["sla"].pixel, known["sla"].crest_sigma) == (0.01, 0.02)  # keys typed come last
    with pytest.raises(InputError, match="'edm' or 'my-mill', got 'my-mil'"):
        skincad.load("lab-bench", ["mold.end_plate_process=my-mil"], printer=printer)
    # the design carries it without the file
    design = skincad.load("lab-bench", ["mold.process=my-mill"], printer=printer)
    assert design.with_(ridge={"height": 1.01}).printer == design.printer
    assert skincad.Design.model_validate(design.model_dump(exclude_none=True)) == design
    assert design.model_dump()["printer"] == tomllib.loads(OWN)
    assert hash(design) == hash(design.with_())
    assert design != design.with_(printer={"my-mill": {"based_on": "edm"}})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[sla]\npixl = 1.0", "printer.sla.pixl: unknown key; did you mean 'pixel'?"),
        ("[sla]\npixel = -1.0", "printer.sla.pixel: must be greater than or equal to 0 (mm), got -1"),
        ("[sla]\npixel = nan", "printer.sla.pixel: must be a finite number (mm), got nan"),
        ("[mine]\npixel = 1.0", "printer.mine.based_on: is missing for a new process; name fdm, sla"),
        ("[mine]\nbased_on = 'x'", "printer.mine.based_on: must be 'fdm', 'sla', 'cnc' or 'edm', got 'x'"),
        ("[sla]\nbased_on = 'cnc'", "printer.sla.based_on: must not be given for sla, got 'cnc'"),
        ("['a b c']\nbased_on = 'cnc'", "printer: the name must be 3 to 32 lower-case letters"),
        ('["abc\\n"]\nbased_on = "cnc"', "printer: the name must be 3 to 32 lower-case letters"),
        ("pixel = 1.0", "printer.pixel: must be a table, [printer.pixel], got 1"),
        ("[sla", "printer.toml: is not TOML"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "printer.toml"
    path.write_text(text)
    with refused(message):
        skincad.load("lab-bench", printer=path)


def test_the_command_line_takes_a_printer_and_refuses_a_bad_one(tmp_path: Path, printer: Path) -> None:
    good = run_skincad("check", "plain-ridges", "--tier", "winkler", "--printer", str(printer), cwd=tmp_path)
    assert good.returncode in (0, 1), good.stderr
    printer.write_text("[sla]\npixl = 1.0")
    for command in ("check", "make"):
        message = refused_command(command, "plain-ridges", "--printer", str(printer), cwd=tmp_path)
        assert message == "printer.sla.pixl: unknown key; did you mean 'pixel'?"
    message = refused_command("make", "plain-ridges", "--printer", "none.toml", cwd=tmp_path)
    assert "none.toml: cannot be read" in message


@pytest.mark.slow  # a copy of the package in its own process
def test_a_new_shipped_process_needs_its_table_only(tmp_path: Path) -> None:
    """No file of ours names a process: a copy of the package with one more table knows it."""
    for folder in ("skincad", "templates"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    with (tmp_path / "templates" / "processes.toml").open("a") as table:
        table.write('\n[laser]\ntool = "wire"  # assumption\ntolerance = 0.02  # assumption\n')
    code = (
        "import skincad; from skincad.fabrication.findings import design_findings;"
        "from skincad.fabrication.job import Job;"
        "bent = ['skin.curvature_radius_y=40', 'mold.process=laser'];"
        "findings = design_findings(Job(skincad.load('plain-ridges', bent)));"
        "print([f.remedy for f in findings if f.rule == 'tool reach']);"
        "skincad.load('lab-bench', ['printer.mine.based_on=laser', 'mold.process=mine']);"
        "print('laser' in str(skincad.Design.model_json_schema()['$defs']['Mold']))"
    )
    result = python(code, cwd=tmp_path, PYTHONPATH=str(tmp_path))
    assert result.returncode == 0, result.stderr
    assert "mill, sink-erode or print it" in result.stdout
    assert result.stdout.endswith("True\n")


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
    ({"thread": "M3", "pattern": "rectangle", "pitch_x": 4.0, "angle": 0.0},
     "mount.pattern: must be 'circle' where angle is given"),
    ({"fiducials": 2}, "mount.fiducials: must be 0, 3 or 4"),
    ({"fiducials": 5}, "mount.fiducials: must be less than or equal to 4"),
    ({"thread": "M3", "diameter": 9.0, "bolt": 4}, "mount.bolt: unknown key"),
    ({"thread": "M3", "diameter": 9.0, "count": 1}, "mount.count: must be greater than or equal to 2"),
    ({"thread": "M3", "diameter": 9.0, "pin": 4.0}, "mount.pin: must be less than or equal to 3"),
]  # fmt: skip


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


def test_a_mount_is_set_and_dropped_and_one_without_room_is_named() -> None:
    keys = ["mount.thread=M2", "mount.pattern=rectangle", "mount.pitch_x=8.0"]
    assert load("yamada-2002", keys).mount == Mount(thread="M2", pattern="rectangle", pitch_x=8.0)
    assert load("yamada-2002", [*keys, "mount=none"]).mount is None
    # Else every revision would change
    assert "mount" not in skincad.load("yamada-2002").to_toml()
    small = skincad.load_design("plain-ridges", ["mold.mount=plain-plate"])
    with pytest.raises(InputError) as refused:
        mold(small)
    assert str(refused.value).startswith("mold.mount: its diameter must be at most ")
    assert "got 'plain-plate'; take another gripper, a larger skin" in str(refused.value)


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
    found = [f for f in mount_findings(Job(on("franka-hand", width=20.0))) if f.rule == "gripper face"]
    assert [(f.severity, f.measured, f.limit) for f in found] == [("note", 20.0, 17.0)]


def test_a_gripper_grips_as_somebody_says_or_as_is_assumed() -> None:
    grips = {name: gripper for name, gripper in grippers().items() if gripper.force_max is not None}
    assert set(grips) == {"franka-hand", "robotiq-2f85", "umi", "leap-hand"}
    rows = tomlkit.parse(table_text("grippers"))
    for name, gripper in grips.items():
        assert 0 < (gripper.force_min or 1.0) < gripper.force_max
        assert gripper.force_rate is not None
        assert gripper.delay is not None
        assert 0.035 <= gripper.delay <= 0.11  # sensing to force, arXiv 2602.16127, and UMI's latencies
        for key in ("force_min", "force_max", "force_rate", "delay"):
            if getattr(gripper, key) is not None:
                said = rows[name].item(key).trivia.comment
                assert re.match("# (source|from|assumption)\\b", said), (name, key)


def test_ones_own_grippers_change_the_shipped_ones_and_add_to_them(tmp_path: Path) -> None:
    file = tmp_path / "grippers.toml"
    file.write_text(OWN_GRIPPERS)
    mine = skincad.load_design(
        "plain-ridges", ["mold.mount=my-finger", "skin.length=30", "skin.width=20"], grippers=file
    )
    assert (mine.mounting.thread, mine.mounting.pitch_y) == ("M2", 14.0)
    changed = skincad.load_design("plain-ridges", ["mold.mount=franka-hand"], grippers=file)
    assert (changed.mounting.pitch_x, changed.mounting.thread) == (9.0, "M2")
    assert list(mount_findings(Job(changed))) == []  # it is measured now
    copy = tmp_path / "copy.toml"
    copy.write_text(mine.to_toml())
    assert skincad.load_design(copy) == mine  # it holds its gripper
    assert mine.with_(mold={"mount": "plain-plate"}).mounting != mine.mounting


def test_what_is_no_gripper_is_refused() -> None:
    for settings, words in (
        (["mold.mount=franka"], "mold.mount: no such gripper, got 'franka'; did you mean 'franka-hand'"),
        (["mold.mount=umi", "mount.thread=M3", "mount.diameter=9"], "has its own holes, and so has [mount]"),
        (["grippers.my-finger={thread='M3'}"], "grippers.my-finger.diameter: is missing for a circle"),
        (["grippers.X={thread='M3', diameter=20}"], "grippers: the name must be 3 to 32"),
    ):
        with refused(words):
            skincad.load_design("plain-ridges", settings)
