"""Where files may go: no design, manifest or link writes or removes anything outside the out folder."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from skincad import load
from skincad.circuit.model import load_circuit
from skincad.errors import InputError
from skincad.outfolder import CIRCUIT_MANIFEST, MANIFEST, replaced
from skincad.scene import load_scene
from tests.conftest import run_skincad

NAMES = [
    "../../x",
    "/tmp/x",
    "..",
    ".",
    "a/b",
    "a\\b",
    "",
    "x\n",
    "x\x00",
    "-o",
    ".hidden",
    "x" * 65,
    "é",
    "a b",
]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_no_path(name: str) -> None:
    for read, source in ((load, "yamada-2002"), (load_scene, "hold"), (load_circuit, "yamada-2002")):
        with pytest.raises(InputError) as refusal:
            read(source, [f"name={json.dumps(name)}"])
        assert str(refusal.value).startswith("name: must be letters, digits, - and _")


@pytest.mark.parametrize("skin", ["/etc/passwd", "../../../etc/passwd", "/dev/zero", ".", "a\\u0000b.toml"])
def test_a_scenes_skin_is_a_design_or_nothing(skin: str, tmp_path: Path) -> None:
    from skincad.catalog import template_text

    text = template_text("hold", "scenes").replace('skin = "yamada-2002"', f'skin = "{skin}"')
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(InputError) as refusal:
        load_scene(tmp_path / "scene.toml")
    assert str(refusal.value).startswith("skin")
    assert "root:" not in str(refusal.value)  # nothing of the file is told


@pytest.mark.parametrize("manifest", [MANIFEST, CIRCUIT_MANIFEST])
@pytest.mark.parametrize(
    "listed", [["../victim"], ["../../victim"], ["sub/victim"], [".."], "victim", [1], {}]
)
def test_a_forged_manifest_removes_nothing_outside(tmp_path: Path, manifest: str, listed: object) -> None:
    (tmp_path / "victim").write_text("mine")
    out = tmp_path / "out"
    (out / "sub").mkdir(parents=True)
    (out / "sub" / "victim").write_text("mine too")
    (out / manifest).write_text(json.dumps({"files": listed}))
    with replaced(out, (manifest,)) as staging:
        (staging / "a").write_text("new")
    assert (tmp_path / "victim").read_text() == "mine"
    assert (out / "sub" / "victim").read_text() == "mine too"


@pytest.mark.slow
def test_a_link_in_the_out_folder_is_not_written_through(tmp_path: Path) -> None:
    (tmp_path / "victim").write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    (out / "section.dxf").symlink_to(tmp_path / "victim")
    (out / MANIFEST).write_text(json.dumps({"files": ["section.dxf"]}))
    done = run_skincad("make", "plain-ridges", "--format", "dxf", "-o", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "victim").read_text() == "mine"
    assert not (out / "section.dxf").is_symlink()


def test_an_out_folder_that_links_to_a_home_is_refused(tmp_path: Path) -> None:
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "thesis.tex").write_text("years")
    (tmp_path / "out").symlink_to(tmp_path / "home")
    for command in (["make", "plain-ridges"], ["simulate", "hold"], ["circuit", "yamada-2002"]):
        done = run_skincad(*command, "-o", "out", cwd=tmp_path)
        assert done.returncode == 2
        assert "holds files and no earlier result" in done.stderr
    assert [p.name for p in (tmp_path / "home").iterdir()] == ["thesis.tex"]


def test_a_dangling_link_makes_its_folder_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "out").symlink_to(tmp_path / "later")
    with replaced(tmp_path / "out") as staging:
        (staging / "a").write_text("new")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["later", "out"]
    assert (tmp_path / "later" / "a").read_text() == "new"
