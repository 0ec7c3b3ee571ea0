"""What make asks the check for, previews, and molds whose parts have other names."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

import skincad
from skincad.base import InputError, files_below
from skincad.fabrication import (
    Finding,
    Job,
    MakeResult,
    casting_sheet,
    design_findings,
    filling_findings,
    interference,
    laid_on_end,
    poured_volume,
)
from skincad.inputs import Design
from skincad.outputs import explosion_offset
from skincad.outputs.drawing.overview import drawing
from skincad.solids import TAP_RADIUS, ClosedMold, CutRole, bores
from skincad.solids.mold import mold
from tests.conftest import run_skincad
from tests.designs import template, three_ridges
from tests.processes import lines_until, started
from tests.refusals import refused, refused_command


@pytest.fixture(scope="module")
def small() -> Design:
    """Three ridges that do not all touch at their force."""
    return skincad.load("plain-ridges").with_(
        ridge={"count": 3}, skin={"width": 5.0}, contact={"force": 0.01}
    )


@pytest.fixture(scope="module")
def unchecked(small: Design) -> MakeResult:
    return skincad.make(small, checked=False)


@pytest.mark.slow
def test_errors_are_printed_in_full_and_the_next_step_mends_them(unchecked: MakeResult) -> None:
    two = (
        Finding("gap", "cavity, slit", 0.1, 0.2, "mm", "a wider slit", "error"),
        Finding("wall", "end", 1.0, 2.0, "mm", "more", "error"),
    )
    grave = Finding("detail", "cover", 0.1, 0.2, "mm", "larger lengths", "warning")
    light = Finding("cure", "sla", 1.0, 0.0, "", "bake it", "note")
    broken = replace(unchecked, findings=(*two, grave, grave, light))
    rows = str(broken).splitlines()
    assert rows[1] == "  mold           2 errors, 2 warnings; 3 more findings with -v"
    assert rows[2:] == [str(two[0]), str(two[1]), "Next: a wider slit."]
    warned = str(replace(unchecked, findings=(grave, light))).splitlines()
    assert warned[1:3] == ["  mold           no errors, 1 warning; 1 more note with -v", str(grave)]
    assert str(light) not in warned
    assert str(light) in replace(unchecked, findings=(grave, light)).details().splitlines()
    assert str(replace(unchecked, findings=(grave,), strict=True)).endswith("Next: larger lengths.")


def test_without_a_check_the_findings_alone_decide(small: Design, unchecked: MakeResult) -> None:
    judged = skincad.make(small, model="winkler")
    assert judged.check.model == "winkler"
    assert (judged.passed, unchecked.passed) == (False, True)
    assert unchecked.check is None
    assert unchecked.findings == judged.findings
    assert "contact check" not in unchecked.seconds


@pytest.mark.slow
def test_everything_says_that_nobody_asked(unchecked: MakeResult, tmp_path: Path) -> None:
    assert str(unchecked).startswith("Not checked whether all ridges touch.")
    ending = r"plain-ridges: mold: no errors, \w+ warnings?; contact: not checked$"
    assert re.search(ending, unchecked.details(), re.M)
    assert unchecked.as_json()["summary"] == unchecked.summary
    assert unchecked.as_json()["check"] is None
    skincad.write(unchecked, tmp_path / "made", formats=["md", "html"])
    for name in ("casting-sheet.md", "casting-sheet.html"):
        assert "Not checked whether all ridges touch." in (tmp_path / "made" / name).read_text("utf-8")
    assert json.loads((tmp_path / "made" / "make.json").read_text())["all_touch_force_N"] is None


@pytest.mark.slow
def test_a_next_step_names_no_file_that_was_not_written(tmp_path: Path) -> None:
    few = ("plain-ridges", "--set", "ridge.count=3", "--set", "skin.width=5.0", "--model", "winkler")
    whole = run_skincad("make", *few, "--format", "html", "-o", "all", cwd=tmp_path).stdout
    assert whole.splitlines()[-1] == "Next: cast it: casting-sheet.html says what to buy and what to do."
    part = run_skincad("make", *few, "--format", "dxf", "-o", "some", cwd=tmp_path).stdout
    assert "Next" not in part


@pytest.mark.slow
def test_the_command_leaves_the_check_out(tmp_path: Path) -> None:
    few = ("--set", "ridge.count=1", "--set", "skin.width=3.0", "--format", "toml")
    result = run_skincad("make", "plain-ridges", *few, "--no-check", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    first, mold, files, last = result.stdout.splitlines()
    assert first == "Not checked whether all ridges touch."
    assert re.fullmatch(r"  mold           no errors, no warnings; \d notes with -v", mold)
    assert files.startswith("  files          2 files in out/plain-ridges: design.toml, make.json, ")
    typed = "plain-ridges --set ridge.count=1 --set skin.width=3.0"
    assert last == f"Next: `skincad check {typed}` says whether all ridges touch."


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        (("--tier", "lineer"), "did you mean 'linear'"),
        (("--budget", "-1"), "budget"),
        (("--no-check", "--tier", "linear"), "tier: is the check's, which is left out"),
        (("--no-check", "--budget", "3"), "budget: is the check's, which is left out"),
    ],
)
def test_what_the_check_does_not_take_is_told_before_any_work(
    asked: tuple[str, ...], says: str, tmp_path: Path
) -> None:
    assert says in refused_command("make", "plain-ridges", *asked, cwd=tmp_path)
    with pytest.raises(InputError):
        skincad.make(skincad.load("plain-ridges"), checked=False, budget=1.0)


@pytest.fixture(scope="module")
def preview(small: Design) -> MakeResult:
    return skincad.make(small, preview=True)


def test_a_preview_finds_what_the_whole_finds(preview: MakeResult, unchecked: MakeResult) -> None:
    assert preview.findings == unchecked.findings
    assert preview.check is None
    assert preview.as_json()["preview"]
    for quick, whole in zip(preview.parts, unchecked.parts, strict=True):
        # the formula against the exact solid's integral
        assert (quick.name, quick.volume) == (whole.name, pytest.approx(whole.volume, rel=1e-6))
        assert quick.watertight
        assert (quick.faces, quick.valid, quick.deviation) == (None, None, None)


def test_a_preview_writes_all_but_exact_solids(preview: MakeResult, unchecked: MakeResult) -> None:
    left_out = unchecked.files().keys() - preview.files().keys()
    assert {f"solids/{name}.step" for name in ("skin", "cavity", "assembly")} <= left_out
    kept = {"solids/skin.stl", "solids/mold.3mf", "drawings/section.dxf", "picture.png", "casting-sheet.md"}
    assert kept <= preview.files().keys()
    assert preview.files().keys() <= unchecked.files().keys()


def test_a_preview_keeps_what_a_whole_make_wrote(
    preview: MakeResult, unchecked: MakeResult, tmp_path: Path
) -> None:
    folder, formats = tmp_path / "out", ("toml", "svg")
    skincad.write(preview, folder, formats=formats)
    skincad.write(unchecked, folder, formats=formats)  # a whole make replaces a preview, and itself
    skincad.write(unchecked, folder, formats=formats)
    before = {name: path.read_bytes() for name, path in files_below(folder).items()}
    with refused("holds what a whole make wrote, and a preview keeps that; name another one: -o"):
        skincad.write(preview, folder, formats=formats)
    words = ("make", "plain-ridges", "--preview", "-o", "out")
    assert "holds what a whole make wrote" in refused_command(*words, cwd=tmp_path)
    assert {name: path.read_bytes() for name, path in files_below(folder).items()} == before
    skincad.write(preview, tmp_path / "out-preview", formats=formats)


@pytest.mark.slow
def test_a_preview_never_loads_the_cad_kernel(tmp_path: Path) -> None:
    program = (
        "import sys, skincad\n"
        "found = skincad.make(skincad.load('plain-ridges'), preview=True)\n"
        f"skincad.write(found, {str(tmp_path / 'made')!r})\n"
        "print([name for name in ('cadquery', 'OCP', 'ngsolve') if name in sys.modules])\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=300
    )
    assert result.stdout.strip() == "[]"


@pytest.mark.slow
def test_the_command_previews_and_makes_step_where_that_is_asked(tmp_path: Path) -> None:
    few = ("--set", "ridge.count=1", "--set", "skin.width=3.0", "--preview", "--format")
    result = run_skincad("make", "plain-ridges", *few, "toml", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith("Preview: meshes and findings alone")
    result = run_skincad("make", "plain-ridges", *few, "step", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "out" / "plain-ridges" / "solids" / "skin.step").is_file()
    few = ("--format", "md", "-o", "other", "--preview", "--tier", "linear")
    assert run_skincad("make", "plain-ridges", *few, cwd=tmp_path).returncode == 2


@pytest.mark.slow
def test_watch_makes_a_preview_at_each_save(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    good = skincad.load("plain-ridges").with_(name="mine", ridge={"count": 1}, skin={"width": 3.0}).to_toml()
    file.write_text(good.replace("count = 1", "count = -1"))
    words = [sys.executable, "-m", "skincad", "watch", file.name, "--format", "toml"]
    with started(words, cwd=tmp_path, text=True, stdout=-1, stderr=subprocess.STDOUT) as process:
        assert "ridge.count" in process.stdout.readline()
        assert process.stdout.readline() == "Watching mine.toml; Ctrl-C ends.\n"
        file.write_text(good)
        line = lines_until("Watching mine.toml; Ctrl-C ends.\n", process.stdout)
        assert line[0].startswith("Preview:")
        assert (tmp_path / "out" / "mine" / "design.toml").is_file()
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=30) == 130


def test_watch_takes_a_file(tmp_path: Path) -> None:
    line = refused_command("watch", "plain-ridges", cwd=tmp_path)
    assert line.startswith("DESIGN: must be a design's file")


OTHER = "x-"
PRINTED = ['mold.process="fdm"', 'mold.lid_process="fdm"', "mold.clearance=0.2"]


def renamed(closed: ClosedMold) -> ClosedMold:
    """The mold with every part called something else."""
    steps = tuple(step._replace(parts=tuple(OTHER + name for name in step.parts)) for step in closed.opening)
    return ClosedMold(tuple(replace(part, name=OTHER + part.name) for part in closed.parts), steps)


def mold_texts(design: Design, closed: ClosedMold) -> Iterator[str]:
    """Everything that is said of a mold, as text."""
    findings = [*design_findings(Job(design, closed)), *filling_findings(Job(design, closed))]
    yield from (json.dumps(finding.as_json()) for finding in findings)
    yield f"{poured_volume(Job(design, closed))} {closed.length}"
    yield casting_sheet(Job(design, closed), findings, "Passes.", True)
    yield drawing(design, closed)
    for part in closed.parts:
        offset = explosion_offset(part, closed)
        yield f"{part.name} {part.made} {part.colour} {laid_on_end(Job(design), part)} {offset}"


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        template("lab-bench", ["ridge.count=3"]),
        template("cast-in", ["ridge.count=3", 'mold.pour="open"']),
        template("plain-ridges", ["ridge.count=3", *PRINTED]),
        template("yamada-2002", ["ridge.count=3", "mold.cavities=2", *PRINTED]),
        template("yamada-2002", ["ridge.count=3", "skin.curvature_radius_y=25"]),
        template("steep-fingertip", []),
    ],
)
def test_a_mold_whose_parts_have_other_names_is_judged_and_told_alike(name: str, settings: list[str]) -> None:
    design = skincad.load(name, settings)
    closed = mold(design)
    other, usual = ("\n".join(mold_texts(design, parts)) for parts in (renamed(closed), closed))
    assert other != usual  # the names are there
    assert other.replace(OTHER, "") == usual


def test_what_is_free_to_bend_is_known_by_its_role() -> None:
    """A skin that its cavity holds by its ridges is pulled out of it, which its undercut is judged for."""
    closed = renamed(mold(skincad.load("steep-fingertip", ['mold.split="none"'])))
    assert interference(closed, 2e-3) == []


def test_a_pin_hole_as_wide_as_a_thread_is_no_thread() -> None:
    loose = skincad.load("plain-ridges", ["mold.clearance=0.25", 'mold.process="fdm"'])
    closed = mold(loose)
    assert {bore.radius for bore in bores(closed.part("end-b"), CutRole.END_PIN)} == {TAP_RADIUS}
    text = casting_sheet(Job(loose, closed), [], "Passes.", True)
    assert (
        "M3 bolts, ISO 4762: 4 M3 x 25 through both end plates, with nuts, 4 of them sunk in end plate b"
        in text
    )


def test_a_cut_without_a_role_is_none_of_a_mold() -> None:
    for closed in (mold(skincad.load("steep-fingertip")), mold(three_ridges())):
        assert {cut.role for part in closed.parts for cut in part.cuts} <= set(CutRole)
