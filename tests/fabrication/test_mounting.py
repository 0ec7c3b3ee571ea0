"""What is said of a mount: to buy, on the sheet, on the drawing, and in the manifest."""

from __future__ import annotations

import csv
import json
import math

import pytest

import skincad
from skincad.fabrication import Job, casting_sheet, major, mount_of, opening_steps, parts_csv, sheet_steps
from skincad.fabrication.fasteners import full_thread, limits, purpose, screws_to_buy, thread, thread_words
from skincad.fabrication.part_drawing import what_matters
from skincad.inputs import Design
from skincad.solids import CutRole, bores
from skincad.solids.mold import mold
from tests.bent_skin import bent
from tests.mounted import IN_LINE, MOUNTS, NAMES, PLAIN, mounted_design


def bought(design: Design) -> list[dict[str, str]]:
    rows = parts_csv(Job(design)).splitlines()
    return [row for row in csv.DictReader(rows) if row["made_by"] == "bought"]


@pytest.mark.parametrize("name", NAMES)
def test_the_manifest_has_the_carriers_own_holes(name: str) -> None:
    design = mounted_design(name)
    closed = mold(design)
    mount = mount_of(Job(design, closed))
    assert mount is not None
    manifest = json.loads(json.dumps(mount.as_json()))
    carrier = closed.part("carrier")
    for key, role in (("positions_mm", CutRole.MOUNT), ("fiducials_mm", CutRole.FIDUCIAL)):
        there = [bore.start[:2] for bore in bores(carrier, role)]
        assert len(manifest[key]) == len(there)
        assert all(math.dist(a, b) < 1e-8 for a, b in zip(manifest[key], there, strict=True))
    for bore in bores(carrier, CutRole.MOUNT):
        assert (
            manifest["depth_mm"] == bore.length > manifest["engagement_mm"][1] > manifest["engagement_mm"][0]
        )
        assert manifest["top_mm"] == bore.start[2] + bore.length


def test_of_a_gang_places_count_from_each_carriers_middle() -> None:
    one, two = mounted_design("yamada-2002"), mounted_design("yamada-2002").with_(mold={"cavities": 2})
    assert mount_of(Job(two)) == mount_of(Job(one))


def test_what_is_bought_is_counted_for_every_carrier() -> None:
    design = mounted_design("lab-bench").with_(mold={"cavities": 2})
    rows = bought(design)
    (screws,) = (row for row in rows if row["what"] == "mount screw")
    (inserts,) = (row for row in rows if row["what"] == "threaded insert" and "mount" in row["place"])
    assert (screws["quantity"], inserts["quantity"]) == ("8", "8")
    assert screws["designation"] == "ISO 4762 M3, 4.5 to 5.7 in the carrier"
    assert inserts["designation"] == "M3 x 5.7, outer diameter 3.9, glued"
    metal = bought(mounted_design("milled-pad"))
    assert [row["designation"] for row in metal if row["what"].startswith("mount")] == [
        "ISO 4762 M3, 3 to 4 in the carrier",
        "ISO 8734 2, 3 in the carrier",
    ]
    assert not any("insert" in row["what"] for row in metal)


def test_the_sheet_says_what_to_buy_and_how_threads_stay_clean() -> None:
    design = mounted_design("lab-bench")
    closed = mold(design)
    sheet = casting_sheet(Job(design, closed), [], "", True)
    (buy,), clean = screws_to_buy(Job(design, closed)), sheet_steps(Job(design, closed))["mount"]
    assert f"- {buy}" in sheet
    assert clean in sheet
    assert "4 threaded inserts M3 (glued, 5.7 mm long, 3.9 mm wide, in holes of 4 mm), 4 M3 screws" in buy
    assert "Set the M3 inserts (glued) into cavity and carrier." in sheet
    assert "under the foam" in clean
    assert "Tape" not in clean
    poured = design.with_(mold={"pour": "open", "gate": None})
    assert "Tape them until the carrier lies" in sheet_steps(Job(poured))["mount"]
    steep = bent("plain-ridges", 30.0).with_(mount=MOUNTS["bent"][0] | {"pitch_x": 6.0}, **PLAIN)
    bare = sheet_steps(Job(steep))["mount"]  # no room for foam on its narrow top
    assert "threads and fiducials are blind and lie under the cover" in bare
    assert "fill them flush with wax" in bare


def test_the_first_step_taps_a_mount_as_deep_as_its_thread_is() -> None:
    design = mounted_design("milled-pad")
    words = sheet_steps(Job(design))["prepare"]
    assert "Tap the M3 x" not in words
    assert "Tap the M3 threads of carrier, 4 mm deep (mount)." in words


def test_marks_alone_ask_for_nothing_to_buy() -> None:
    design = skincad.load("yamada-2002").with_(mount={"fiducials": 3})
    closed = mold(design)
    assert screws_to_buy(Job(design, closed)) == []
    assert "mount's fiducials are blind" in sheet_steps(Job(design, closed))["mount"]
    assert not any(row["what"].startswith("mount") for row in bought(design))
    mount = mount_of(Job(design, closed))
    assert mount is not None
    assert mount.as_json()["depth_mm"] is None


def test_without_a_mount_nothing_is_said() -> None:
    design = skincad.load("yamada-2002")
    closed = mold(design)
    assert mount_of(Job(design, closed)) is None
    assert screws_to_buy(Job(design, closed)) == []
    assert "mount" not in sheet_steps(Job(design, closed))
    assert "mount" not in casting_sheet(Job(design, closed), [], "", True)


def test_a_mounts_threads_are_a_grip_where_there_is_no_other() -> None:
    design = mounted_design("fingertip-soft")
    assert bores(mold(design).part("carrier"), CutRole.PULL) == []
    words = [step.words for step in opening_steps(Job(design))]
    assert any("by two screws in its mount's threads" in word for word in words)


def test_a_drawing_says_thread_depth_and_use() -> None:
    metal, resin = mounted_design("milled-pad"), mounted_design("lab-bench")
    for design, said, use, size, deep in (
        (metal, "M3 x 4", "M3 screw of mount, engages 3 to 4", "6H", 4.0),
        (resin, "M3 insert, glued", "M3 screw of mount, engages 4.5 to 5.7", "±0.05", None),
    ):
        part = mold(design).part("carrier")
        assert thread(Job(design), part, CutRole.MOUNT) == said
        assert purpose(Job(design), part, CutRole.MOUNT) == use
        assert limits(Job(design), part, CutRole.MOUNT) == size
        assert full_thread(Job(design), part, CutRole.MOUNT, 7.5) == deep
        words = "M3-6H x 4 / Ø2.5 x 7.5" if deep else "M3 insert 5.7 x Ø3.9, glued"
        assert thread_words(Job(design), part, CutRole.MOUNT, 7.5) == words
        assert thread_words(Job(design), part, CutRole.PULL, 3.0) == "M3-6H x 2.5 / Ø2.5 x 3, bottoming tap"
        assert thread_words(Job(design), part, CutRole.RIVET, 3.0) == ""
    part = mold(metal).part("carrier")
    assert purpose(Job(metal), part, CutRole.MOUNT_PIN) == "pin 2 of mount"
    assert limits(Job(metal), part, CutRole.MOUNT_PIN) == "+0.010/0 (H7)"
    assert purpose(Job(metal), part, CutRole.FIDUCIAL) == "fiducial for a camera"
    assert any(
        "circle of 20 about the middle, its threads within ±0.1" in row
        for row in what_matters(Job(metal), part, None)
    )
    line = skincad.load("yamada-2002").with_(mount=IN_LINE)
    rows = what_matters(Job(line), mold(line).part("carrier"), None)
    assert any("two in line, 8 apart" in row for row in rows)


@pytest.mark.parametrize(
    ("said", "wide"), [("M3", 3.0), ("M2.5 x 3.5", 2.5), ("M3 insert, glued", None), ("", None)]
)
def test_only_what_is_tapped_is_drawn_as_a_thread(said: str, wide: float | None) -> None:
    assert major(said) == wide
