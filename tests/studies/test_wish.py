"""Designs for wishes, of ridges and of pins: met, not met, and written."""

from __future__ import annotations

import json
import os
import pty
import random
import signal
import sys
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import skincad
from skincad.cli import run
from skincad.fabrication import Job, design_findings
from skincad.inputs import Design
from skincad.outputs import write_wish
from skincad.shape import FAMILIES, skin_of
from skincad.studies import WishResult, film_of, force_of, size_of, thickness_of
from skincad.studies.wish_shapes import ObstacleError, Wish, relaxed, shapes
from tests.conftest import run_skincad
from tests.processes import LIMIT, started
from tests.refusals import refused, refused_by, refused_command

PASSING = 0.9  # of all parts, by default
SMALL: dict[str, Any] = {"size": "5x6", "touch": "60mN", "silicone": "ecoflex-00-50"}


@pytest.fixture(scope="module")
def small() -> WishResult:
    return skincad.design_for(**SMALL, name="small")


def graver_than_notes(design: Design) -> list[str]:
    return [str(finding) for finding in design_findings(Job(design)) if finding.severity != "note"]


@pytest.mark.slow
@pytest.mark.dear("the wish is met once for all tests of it")
def test_a_wish_is_met_by_a_design_that_passes_and_can_be_cast(small: WishResult) -> None:
    design = small.design
    assert small.passed
    assert not small.broken
    assert (design.skin.width, design.skin.length, design.contact.force) == (5.0, 6.0, 0.06)
    assert (design.material.name, design.mold.process) == ("ecoflex-00-50", "sla")
    assert design.film.thickness == 0.028
    assert graver_than_notes(design) == []
    assert small.check.manufacture.passing.value >= PASSING
    # every choice names a key, its value and its rule
    values = {choice.key: choice.value for choice in small.choices}
    assert values["ridge.pitch"].startswith(f"{small.design.ridge.pitch:g} mm, {small.design.ridge.count} ")
    assert {"ridge.height", "ridge.levelling", "skin.thickness", "skin.curvature_radius"} <= set(values)
    assert all(choice.why for choice in small.choices)
    thick = small.design.skin.thickness  # the usual one
    assert [row.thickness for row in small.trade] == pytest.approx([thick / 2, thick, 2 * thick])
    assert [row.all_touch_force.value for row in small.trade] == sorted(
        (row.all_touch_force.value for row in small.trade), reverse=True
    )
    assert str(small).startswith("Met: all ")
    assert "ridge.levelling" in str(small)
    (line,) = (row for row in str(small).splitlines() if row.startswith("  film to buy "))
    assert "metallised piezo film sheet, sputtered Ni-Cu (TE Connectivity), source of 1999-04-02; " in line
    assert f"strips are cut {small.film_offers.cutting}" in line
    assert small.as_json()["passed"] is True


@pytest.mark.evidence(subject="seeds: wishes met")
def test_its_skin_is_about_as_curved_as_the_force_bears() -> None:
    """With half the radius too few parts pass: the choice is not just the flattest."""
    design = skincad.design_for(size="10x12", touch="300mN", silicone="ecoflex-00-50").design
    assert skincad.check(design, model="corrected").passed
    assert max(skin_of(design).crests) - min(skin_of(design).crests) > 0.003
    rounder = design.with_(skin={"curvature_radius": design.skin.curvature_radius / 2})
    parts = skincad.check(rounder, model="corrected").manufacture
    assert (parts.passing.value or 0.0) < PASSING


@pytest.mark.slow
def test_the_file_is_the_design_with_its_rules(small: WishResult, tmp_path: Path) -> None:
    for full in (False, True):
        folder = tmp_path / f"full-{full}"
        folder.mkdir()
        path, schema = write_wish(folder / "mine.toml", small, full)
        assert skincad.load(path) == small.design.with_(name="mine")
        text = path.read_text()
        assert text.startswith(f"#:schema ./{schema.name}\n")
        assert ("# gap per side between parts" in text) == full
        if not full:
            assert len(text.splitlines()) < 70
            assert "leaves room for crests that scatter by 0.015 mm, as sla makes them\ncurvature" in text
            assert "d31" not in tomllib.loads(text)["film"]


def test_a_size_a_force_and_a_film_may_have_units() -> None:
    for text in ("24x30", "2.4 x 3cm", "24 x 30 mm"):
        assert size_of(text) == pytest.approx((24.0, 30.0))
    assert size_of("1inx2in") == pytest.approx((25.4, 50.8))
    assert [force_of(text) for text in ("1N", "1", "500mN", "0.5 N")] == [1.0, 1.0, 0.5, 0.5]
    assert [thickness_of(text) for text in ("8", "8mm", "0.8 cm", 8)] == pytest.approx([8.0, 8.0, 8.0, 8.0])
    films = ("pvdf-28um", "28um", "28", "0.028mm", "none")
    assert [film_of(text) for text in films] == pytest.approx([0.028, 0.028, 0.028, 0.028, 0.0])


@pytest.mark.parametrize(
    ("wish", "words"),
    [
        ({"size": "24"}, "size: must be width x length, got '24'; as in 24x30 or 2.4x3cm"),
        ({"size": "4x30"}, "size: must be 5 to 200 mm, got 4"),
        ({"size": (24, float("nan"))}, "size: must be"),
        ({"touch": "heavy"}, "touch: must be a force, got 'heavy'; as in 1N or 500mN"),
        ({"touch": 0}, "touch: must be 0.02 to 500 N, got 0"),
        ({"thickness": "thick"}, "thickness: must be a length, got 'thick'; as in 8 or 8mm"),
        ({"thickness": 0.2}, "thickness: must be 1 to 50 mm, got 0.2"),
        ({"film": "gold"}, "film: must be a thickness, or none, got 'gold'"),
        ({"silicone": "ecoflex"}, "material.name: "),
        ({"process": "casting"}, "mold.process: "),
        ({"gripper": "hand"}, "mold.mount: "),
    ],
)
def test_a_wish_that_is_none_is_refused(wish: dict[str, Any], words: str) -> None:
    with refused_by(words):
        skincad.design_for(**wish)


@pytest.mark.evidence(subject="seeds: wishes not met")
def test_a_pad_too_small_for_its_machine_is_refused() -> None:
    tiny = {"based_on": "sla", "build_x": 20.0, "build_y": 20.0}
    with refused("size: has no castable pad"):
        skincad.design_for(process="tiny", printer={"tiny": tiny})


def test_bad_wishes_are_one_line_and_leave_no_file(tmp_path: Path) -> None:
    line = refused_command("new", "pad.toml", "--size", "24", cwd=tmp_path)
    assert line.startswith("--size: must be width x length")
    line = refused_command("new", "pad.toml", "--size", "24x30", "--template", "lab-bench", cwd=tmp_path)
    assert line == "--template: does not go with a wish, got 'lab-bench'; leave out --size"
    (tmp_path / "lab.toml").write_text("[mine]\nyoung_modulus = 0.1\n")
    line = refused_command("new", "pad.toml", "--silicones", "lab.toml", cwd=tmp_path)
    assert line.startswith("--silicones: needs a wish; ")
    assert "--family" in refused_command("new", "pad.toml", "--family", "ring", "--touch", "2N", cwd=tmp_path)
    assert "--film" in refused_command("new", "pad.toml", "--family", "pin", "--film", "0.03mm", cwd=tmp_path)
    both = refused_command("new", "pad.toml", "--family", "pin", "--template", "rings-5", cwd=tmp_path)
    assert "--family" in both
    with refused_by("family"):
        skincad.design_for(family="flat")
    with refused_by("film"):
        skincad.design_for(family="pin", film=0.1)


@pytest.mark.slow
def test_new_writes_the_wish(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "pad.toml"
    status = run(["new", str(path), "--size", "10x12", "--touch", "0.3N", "--film", "none", "--json"])
    answer = json.loads(capsys.readouterr().out)
    assert status == 0
    assert answer["files"] == [str(path), str(path.with_suffix(".schema.json"))]
    assert answer["broken"] == []
    assert skincad.load(path).slot is None
    assert answer["film_offers"] is None
    assert {"key", "value", "why"} == set(answer["choices"][0])
    values = {choice["key"]: choice["value"] for choice in answer["choices"]}
    assert skincad.load(path).material.name == values["material.name"]


def test_without_a_terminal_a_new_file_is_one_that_a_home_printer_makes(tmp_path: Path) -> None:
    done = run_skincad("new", "mine.toml", cwd=tmp_path)
    assert done.returncode == 0
    assert skincad.load(tmp_path / "mine.toml") == skincad.load("home-printer").with_(name="mine")
    job = Job(skincad.load("home-printer"))
    assert {job.maker(part) for part in job.closed.parts if part.made == "made"} == {"sla"}


@pytest.mark.slow
def test_in_a_terminal_it_asks_and_asks_again(tmp_path: Path) -> None:
    leader, follower = pty.openpty()
    command = [sys.executable, "-m", "skincad", "new", "pad.toml"]
    with started(command, stdin=follower, stdout=follower, stderr=follower, cwd=tmp_path) as child:
        os.close(follower)
        os.write(leader, b"franka hand\nnone\n10\n5x6\n60mN\n\necoflex-00-50\nnone\n")
        said = ""
        while True:
            try:
                piece = os.read(leader, 4096).decode("utf-8", "replace")
            except OSError:  # Linux says so where the other end is closed
                break
            said += piece
            if not piece:
                break
        status = child.wait(timeout=LIMIT)
    os.close(leader)
    assert status == 0, said
    assert said.count("Gripper [none]") == 2
    assert "Error: unknown; did you mean 'franka-hand'?" in said
    (choices,) = (line for line in said.splitlines() if "Mold by: " in line)
    assert choices.split().count("sla,") == 1
    assert said.count("Size in mm") == 2
    assert "Error: size: must be width x length" in said
    assert "Met: all" in said
    assert skincad.load(tmp_path / "pad.toml").skin.width == 5.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "status", "said_last"),
    [
        (b"\x03", 130, "skincad: interrupted"),
        (b"\x04", 2, "skincad: FILE: needs an answer to each question; give the rest as options"),
    ],
)
def test_a_key_that_ends_the_questions_ends_them(
    key: bytes, status: int, said_last: str, tmp_path: Path
) -> None:
    """Ctrl-C at once, and Ctrl-D; nothing is written."""
    leader, follower = pty.openpty()
    command = [sys.executable, "-m", "skincad", "new", "pad.toml"]
    with started(
        command, stdin=follower, stdout=follower, stderr=follower, cwd=tmp_path, start_new_session=True
    ) as child:
        os.close(follower)
        said = ""
        while "Gripper [none]" not in said:
            said += os.read(leader, 4096).decode("utf-8", "replace")
        if key == b"\x03":
            child.send_signal(signal.SIGINT)
        else:
            os.write(leader, key)
        assert child.wait(timeout=LIMIT) == status
        said += os.read(leader, 4096).decode("utf-8", "replace")
    os.close(leader)
    assert said_last in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.evidence(subject="seeds: wishes met")
def test_without_a_wish_the_design_is_the_home_printers_or_for_a_franka_finger() -> None:
    answer = skincad.design_for(name="home-printer")
    assert answer.passed
    assert answer.design == skincad.load("home-printer")
    answer = skincad.design_for(size="24x30", touch="1N", silicone="ecoflex-00-50", gripper="franka-hand")
    assert answer.passed
    assert answer.design.mold.mount == "franka-hand"
    assert graver_than_notes(answer.design) == []


@pytest.mark.evidence(subject="seeds: wishes not met")
@pytest.mark.parametrize(
    ("wish", "broken"),
    [
        ({"touch": 0.5, "silicone": "sylgard-184"}, {"touch"}),
        ({"touch": 40, "silicone": "ecoflex-00-30"}, {"touch"}),
        ({"size": "8x8", "gripper": "plain-plate", "touch": 2}, {"gripper"}),
        ({"size": "30x180", "touch": 5}, {"size"}),
        ({"size": "5x20", "touch": 2, "film": 0.5, "process": "edm"}, {"film"}),
    ],
)
def test_a_wish_that_cannot_be_met_is_named(wish: dict[str, Any], broken: set[str]) -> None:
    answer = skincad.design_for(**wish)
    assert not answer.passed
    assert answer.exit_status == 1
    assert {one.wish for one in answer.broken} == broken
    assert graver_than_notes(answer.design) == []
    assert answer.check.passed
    assert str(answer).startswith("NOT MET: ")


@pytest.mark.evidence(subject="seeds: wishes of pins")
@pytest.mark.parametrize(("size", "touch"), [("24x30", 1.0), ("15x15", 4.0)])
def test_a_wish_for_pins_is_met_by_a_design_that_passes_and_can_be_cast(size: str, touch: float) -> None:
    result = skincad.design_for(family="pin", size=size, touch=touch)
    assert result.passed
    assert result.design.features.family == "pin"
    verdict = skincad.check(result.design, model="reduced")
    assert verdict.passed
    assert verdict.force == touch
    assert all(finding.severity == "note" for finding in design_findings(Job(result.design)))
    assert {"pin.pitch", "pin.height", "skin.curvature_radius"} <= {choice.key for choice in result.choices}


@pytest.mark.evidence(subject="seeds: wishes of pins")
def test_random_wishes_for_pins_are_met_or_named() -> None:
    """One that is said to be met is: size, force, process, castable, and it passes. Of 51 such wishes 30 were
    met, none falsely; 8 were for a wire, which cuts no holes, 10 too large for the printer, 3 too light or
    too heavy."""
    met = 0
    for seed in (200, 201, 213, 248):
        dice = random.Random(seed)
        size = float(dice.randint(6, 40)), float(dice.randint(6, 40))
        touch, process = round(10 ** dice.uniform(-0.8, 0.8), 2), ("sla", "cnc", "edm", "fdm")[seed % 4]
        result = skincad.design_for(size=size, touch=touch, process=process, family="pin")
        design = result.design
        as_wished = (design.skin.width, design.skin.length, design.mold.process, design.contact.force)
        if result.passed:
            met += 1
            assert as_wished == (*size, process, touch)
            assert skincad.check(design).passed
        else:
            assert {broken.wish for broken in result.broken} <= {"size", "touch", "process"}
        assert graver_than_notes(design) == []
    assert met >= 2


def test_a_column_of_pins_has_no_tooth_between() -> None:
    """Every other row of a narrow hexagonal pattern has no room: pins are further apart than neighbours."""
    pin = {"pattern": "hex", "margin": 0.3, "columns": None, "rows": None, "heights": None, "height": 2.0}
    narrow = skincad.load("pillars-9").with_(skin={"width": 5.0, "length": 30.0}, pin={**pin, "pitch": 4.0})
    assert narrow.count > 1
    assert skin_of(narrow).tooth() is None
    assert skin_of(skincad.load("pillars-9")).tooth() is not None


def test_pins_of_the_largest_pad_and_of_a_wire_have_a_shape_to_begin_with() -> None:
    for size in ((100.0, 100.0), (200.0, 200.0), (5.0, 5.0)):
        wish = Wish(*size, 1.0, "dragon-skin-30", family="pin")
        assert next(shapes(wish))
        assert wish.design({}).features.family == "pin"
    wired = Wish(20.0, 20.0, 1.0, "dragon-skin-30", process="edm", film=0.0, family="pin")
    assert relaxed(wired, ObstacleError("tool reach")).process == "sla"
    assert relaxed(replace(wired, process="sla"), ObstacleError("tool reach")) is None


@pytest.mark.evidence(subject="seeds: wishes of pins")
def test_a_force_that_pins_cannot_bear_is_named() -> None:
    result = skincad.design_for(family="pin", size="10x10", touch=300.0, silicone="ecoflex-00-30")
    assert [broken.wish for broken in result.broken] == ["touch"]
    assert result.check.passed
    assert result.design.contact.force < 300.0


@pytest.mark.parametrize("family", FAMILIES)
def test_a_family_alone_copies_its_first_template(family: str, tmp_path: Path) -> None:
    result = run_skincad("new", "pad.toml", "--family", family, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert skincad.load(tmp_path / "pad.toml").features.family == family
