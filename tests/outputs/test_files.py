"""What is written: JSON as strict as JSON is defined, STEP and SVG of the mold, all into one folder.

That other programs read solids, meshes and drawings is in tests/consumers.
"""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest

from skincad.base import files_below
from skincad.fabrication import Job
from skincad.inputs import Design
from skincad.outputs import solid_files, write_step
from skincad.solids import workplane
from skincad.studies.accuracy import circuit
from tests.conftest import Made, run_skincad
from tests.small_scene import small_scene

WRITING = ("make", "simulate", "circuit", "accuracy")  # the commands that write into a folder
SMALL = ("plain-ridges", "--set", "ridge.count=3", "--set", "skin.width=5.0")
ONE = ("--set", "ridge.count=1", "--set", "skin.width=3.0")
SCENE = ("yamada-2002-press-and-pull", "--set", "history.steps=4", "--budget", "0.01")
THIRDS = (
    *("history.normal_force_N=[0.0, 1.3, 1.3]", "history.tangential_force_N=[0.0, 0.0, 0.3]"),
    "readout.ridges=[2]",
)
RUNS = {  # with values that may be missing: a verdict that fails, no slip, no cut-off
    "make": (
        *("make", *SMALL, "--format", "toml", "--set", "contact.force=0.01"),
        *("--tier", "winkler", "--no-advice"),
    ),
    "simulate": ("simulate", *SCENE, "--set", "effects.piezo.circuit=transimpedance"),
    "circuit": ("circuit", "yamada-2002", "--set", "sweep.points=50"),
    "circuit again": ("circuit", "transimpedance", "--set", "sweep.points=50"),
    "accuracy": ("accuracy", "plain-ridges", "--ladder", "circuit", "--repeats", "1"),
    "check": ("check", *SMALL, "--tier", "winkler"),
    "templates": ("templates",),
}
DEAR = {
    "make": ("make", "yamada-2002", *ONE, "--tier", "winkler"),
    "simulate": ("simulate", *SCENE),
    "to gross slip": ("simulate", "yamada-2002-slip", "--set", "history.steps=50", "--budget", "0.01"),
    "simulate without readouts": (
        *("simulate", "yamada-2002-press", "--set", "history.steps=4"),
        *("--set", "readout.ridges=[]", "--set", "effects.film=none"),
    ),
    "accuracy": ("accuracy", "plain-ridges", *ONE, "--ladder", "tessellation", "--repeats", "1"),
    "check": ("check", *SMALL),
}


def strict(text: str) -> Any:
    """Parse JSON with no key twice and no number that is not finite."""

    def never(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        assert len({key for key, _ in pairs}) == len(pairs), sorted(key for key, _ in pairs)
        return dict(pairs)

    return json.loads(text, parse_constant=never, object_pairs_hook=once)


Ran = tuple[Path, dict[str, tuple[int, str]]]  # a folder, and each command's status and words


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """One folder that all commands have written into, and what each said; by a cheap model and a short
    ladder: JSON is as strict of them."""
    folder = tmp_path_factory.mktemp("all")
    out = folder / "out"
    small_scene(folder, SCENE[0], *THIRDS)  # its files
    scene = (
        str(folder / "scene.toml"),
        "--set",
        "skin=small.toml",
        *(t for third in THIRDS for t in ("--set", third)),
    )
    table = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(circuit, "PER_PERIOD", circuit.PER_PERIOD[:2])
        for name, arguments in RUNS.items():
            into = ("-o", str(out)) if arguments[0] in WRITING else ()
            small = ("simulate", *scene, *arguments[2:]) if name == "simulate" else arguments
            process = run_skincad(*small, "--json", *into, cwd=folder)
            table[name] = process.returncode, process.stdout
    return out, table


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNS)
def test_what_is_printed_is_json(name: str, ran: Ran) -> None:
    status, text = ran[1][name]
    assert text.count("\n") == 1
    assert isinstance(strict(text), dict)
    assert status == (1 if name == "make" else 0)


@pytest.mark.slow
@pytest.mark.parametrize("name", DEAR)
def test_what_takes_longer_is_json_too(name: str, tmp_path: Path) -> None:
    process = run_skincad(*DEAR[name], "--json", cwd=tmp_path)
    assert isinstance(strict(process.stdout), dict)
    assert bool(list(tmp_path.rglob("*.json"))) == (DEAR[name][0] in WRITING)
    for path in tmp_path.rglob("*.json"):
        strict(path.read_text("utf-8"))


@pytest.mark.slow
def test_all_commands_live_in_one_folder(ran: Ran) -> None:
    """The manifests together list every file, each once."""
    out, _ = ran
    manifests = {command: strict((out / f"{command}.json").read_text("utf-8")) for command in WRITING}
    listed = [name for manifest in manifests.values() for name in manifest["files"]]
    assert sorted([*listed, *(f"{command}.json" for command in WRITING)]) == list(files_below(out))
    assert {command: manifest["command"] for command, manifest in manifests.items()} == {
        command: command for command in WRITING
    }
    assert manifests["circuit"]["name"] == "transimpedance"  # the later one


@pytest.mark.slow
def test_every_file_is_listed_with_what_is_printed(ran: Ran) -> None:
    out, said = ran
    for name in ("circuit again", "accuracy", "make"):
        files = strict(said[name][1])["files"]
        manifest = strict((out / f"{RUNS[name][0]}.json").read_text("utf-8"))
        assert [Path(file["path"]).relative_to(out).as_posix() for file in files] == manifest["files"]
        assert all(Path(file["path"]).stat().st_size == file["bytes"] for file in files)


def test_the_schema_is_json(tmp_path: Path) -> None:
    assert run_skincad("new", "mine.toml", cwd=tmp_path).returncode == 0
    assert isinstance(strict((tmp_path / "mine.schema.json").read_text("utf-8")), dict)


@pytest.mark.slow
def test_svg_draws_outline_and_slots_to_scale(made: Made) -> None:
    root = ET.parse(made.folder / "drawings/section.svg").getroot()
    space = "{http://www.w3.org/2000/svg}"
    groups = {group.attrib["id"]: group.findall(f"{space}path") for group in root.findall(f"{space}g")}
    (outline,) = groups["SKIN"]
    assert len(groups["SLOTS"]) == 18
    assert root.attrib["width"] == "13mm"
    assert root.attrib["viewBox"].startswith("0 0 130 ")  # ten times as large
    assert re.search(r"A600 600 0 0 0", outline.attrib["d"])


def test_step_time_is_source_date_epoch(
    yamada: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cover = workplane(Job(yamada).closed.part("cover"))
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    write_step(cover, tmp_path / "cover.step")
    assert "'1970-01-02T00:00:00'" in (tmp_path / "cover.step").read_text()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "tomorrow")
    with pytest.raises(ValueError, match="SOURCE_DATE_EPOCH: must be whole seconds"):
        write_step(cover, tmp_path / "again.step")


def test_a_step_file_that_the_kernel_cut_short_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "half.step").write_text("ISO-10303-21;\nHEADER;\n")
    with pytest.raises(OSError, match="No space"):
        solid_files.make_deterministic(tmp_path / "half.step", "half")
