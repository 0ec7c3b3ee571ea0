"""Where files may go: no design, manifest or link writes or removes anything outside the out folder."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import stat
import subprocess
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from skincad import load
from skincad.base import COMMANDS, InputError, checked_folder, manifest_text, replaced
from skincad.circuit import load_circuit
from skincad.scenes import load_scene
from tests.refusals import refused_by, refused_command

NAMES = [
    "../../x", "/tmp/x", "..", ".", "a/b", "a\\b", "", "x\n", "x\x00", "-o", ".hidden", "x" * 65, "é", "a b",
]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_no_path(name: str) -> None:
    for read, source in ((load, "yamada-2002"), (load_scene, "hold"), (load_circuit, "yamada-2002")):
        with refused_by("name: must be letters, digits, - and _"):
            read(source, [f"name={json.dumps(name)}"])


@pytest.mark.parametrize("skin", ["/etc/passwd", "../../../etc/passwd", "/dev/zero", ".", "a\\u0000b.toml"])
def test_a_scenes_skin_is_a_design_or_nothing(skin: str, tmp_path: Path) -> None:
    from skincad.inputs import template_text

    text = template_text("hold", "scenes").replace('skin = "yamada-2002"', f'skin = "{skin}"')
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(InputError) as refusal:
        load_scene(tmp_path / "scene.toml")
    assert str(refusal.value).startswith("skin")
    assert "root:" not in str(refusal.value)  # nothing of the file is told


def tree(folder: Path) -> dict[str, tuple[int, int, bytes]]:
    """Each thing in a folder, whatever it is: inode, mode, and a plain file's bytes or a link's goal."""
    entries = {}
    for path in sorted(folder.rglob("*")):
        seen = path.lstat()
        inside = os.fsencode(path.readlink()) if path.is_symlink() else b""
        inside = path.read_bytes() if stat.S_ISREG(seen.st_mode) else inside
        entries[str(path.relative_to(folder))] = (seen.st_ino, seen.st_mode, inside)
    return entries


def write(folder: Path, command: str = "make", **texts: str) -> None:
    with replaced(folder, command) as staging:
        for name, text in texts.items():
            (staging / name).write_text(text)


def refused_and_nothing_changed(folder: Path, command: str, words: str) -> None:
    """Before any work, and as well at its end."""
    before = tree(folder.parent)
    for attempt in (lambda: checked_folder(folder, command), lambda: write(folder, command, a="new")):
        with pytest.raises(InputError) as refusal:
            attempt()
        assert str(refusal.value).startswith("folder: ")
        assert words in str(refusal.value)
        assert refusal.value.remedy
    assert tree(folder.parent) == before


def signed(command: str, listed: dict[str, str]) -> str:
    """A manifest with every hash in order, by somebody who read how it is made."""
    return manifest_text({"skincad": "0.1.0", "command": command, "files": list(listed), "sha256": listed})


SHA = hashlib.sha256(b"mine").hexdigest()


def foreign(command: str) -> dict[str, str]:
    """Manifests of a command's name that skincad did not write, or not like this."""
    ours = signed(command, {"README": SHA})
    other = next(name for name in COMMANDS if name != command)
    return {
        "another program's": '{"files": ["src", "README"]}',
        "of old, without hashes": '{"skincad": "0.1.0", "name": "x", "passed": true, "files": ["README"]}',
        "not signed": json.dumps({"skincad": "0.1.0", "command": command, "sha256": {"README": SHA}}),
        "edited": ours.replace('"files"', '"notes": "by a person",\n "files"'),
        "laid out anew": ours.replace("\n", "\n "),
        "of another command": signed(other, {"README": SHA}),
        "of another program's command": signed("elsewhere", {"README": SHA}),
        "renamed": signed("elsewhere", {"README": SHA}).replace("elsewhere", command),
        "of a path": signed(command, {"src/main.c": SHA}),
        "hashes that are a list": '{"sha256": []}',
        "hashes that are a text": '{"sha256": "README"}',
        "deep": "[" * 100_000,
        "list": "[]",
        "null": "null",
        "empty": "",
        "no JSON": "not JSON",
        "no UTF-8": "\udcff",
        "no number": ours.replace('"command"', '"n": NaN, "command"'),
        "twice": ours.replace('"command"', '"command": "make", "command"'),
    }


@pytest.mark.parametrize(
    ("command", "text"),
    [*(("make", text) for text in foreign("make")), *((name, "renamed") for name in COMMANDS)],
)
def test_a_foreign_manifest_gives_nothing_away(tmp_path: Path, command: str, text: str) -> None:
    out = tmp_path / "out"
    (out / "src").mkdir(parents=True)
    (out / "src" / "main.c").write_text("mine")
    (out / "README").write_text("mine")
    (out / f"{command}.json").write_text(foreign(command)[text], encoding="utf-8", errors="surrogateescape")
    refused_and_nothing_changed(
        out, command, f"{command}.json was not written by skincad, or was changed since"
    )
    for other in set(COMMANDS) - {command}:
        refused_and_nothing_changed(out, other, "holds files but no earlier result")


@pytest.mark.parametrize("kind", ["link", "dangling link", "folder", "pipe"])
def test_a_manifest_that_is_no_plain_file_gives_nothing_away(tmp_path: Path, kind: str) -> None:
    out = tmp_path / "out"
    write(out, a="1")
    (out / "make.json").rename(tmp_path / "real.json")
    other_kind(out / "make.json", kind, tmp_path / "real.json")
    refused_and_nothing_changed(out, "make", "make.json was not written by skincad, or was changed since")


def other_kind(path: Path, kind: str, like: Path) -> None:
    """Put something there that is no plain file."""
    if kind == "folder":
        path.mkdir()
        (path / "inside").write_text("mine")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "hard link to other bytes":
        os.link(like, path)
    else:
        path.symlink_to(like if kind == "link" else "nowhere")


@pytest.mark.parametrize("command", ["make", "circuit"])
@pytest.mark.parametrize(
    "listed", [["../victim"], ["../../victim"], ["sub/victim"], [".."], ["."], ["sub"], [""], ["a\0b"]]
)
def test_a_forged_manifest_removes_nothing_outside(tmp_path: Path, command: str, listed: list[str]) -> None:
    (tmp_path / "victim").write_text("mine")
    out = tmp_path / "out"
    (out / "sub").mkdir(parents=True)
    (out / "sub" / "victim").write_text("mine")
    (out / f"{command}.json").write_text(signed(command, dict.fromkeys(listed, SHA)))
    before = tree(tmp_path)
    with suppress(InputError):
        write(out, command, a="new")
    after = tree(tmp_path)
    planned = {"out/a", f"out/{command}.json"}
    assert {k: v for k, v in after.items() if k not in planned} == {
        k: v for k, v in before.items() if k not in planned
    }


@pytest.mark.parametrize(
    "kind", ["edited", "link", "dangling link", "folder", "pipe", "hard link to other bytes"]
)
def test_what_became_of_a_listed_file_is_a_persons(tmp_path: Path, kind: str) -> None:
    """Whatever lies where a listed file lay, and is not the file as written, stands in the way, and stays."""
    out = tmp_path / "out"
    write(out, a="1", b="1")
    (tmp_path / "other").write_text("mine")
    (out / "a").unlink()
    if kind == "edited":
        (out / "a").write_text("1 and more")
    else:
        other_kind(out / "a", kind, tmp_path / "other")
    refused_and_nothing_changed(
        out, "make", "/a was not written by skincad, or was changed since; move it away"
    )
    if kind != "folder":
        (out / "a").rename(out / "mine")  # the remedy
        write(out, a="2", b="2")
        assert (out / "a").read_text() == "2"


def test_what_is_not_ours_is_not_so_much_as_touched(tmp_path: Path) -> None:
    """The same inode, mode and bytes after two more results: no copy, no link, no move."""
    out = tmp_path / "out"
    write(out, a="1", b="1")
    (tmp_path / "beside").write_text("mine")
    (out / "sub").mkdir(mode=0o700)
    (out / "sub" / "notes").write_text("mine")
    (out / ".hidden").write_text("mine")
    for kind in ("link", "dangling link", "folder", "pipe", "hard link to other bytes"):
        other_kind(out / kind, kind, tmp_path / "beside")
    for name in (
        ".skincad",
        ".skincad-make",
        ".skincad-notes-01234567",
        ".x.01234567.old",
        ".x.01234567.new",
    ):
        (out / name).mkdir()
        (out / name / "notes").write_text("mine")
    (out / ".skincad-make-01234567").symlink_to(out / "sub")
    before = tree(tmp_path)
    write(out, a="2")
    write(out, "circuit", gain="2")
    after = tree(tmp_path)
    ours = {"out/a", "out/b", "out/make.json", "out/gain", "out/circuit.json"}
    assert {k: v for k, v in after.items() if k not in ours} == {
        k: v for k, v in before.items() if k not in ours
    }
    assert "out/b" not in after


def test_a_run_that_was_killed_leaves_nothing_that_is_emptied_blindly(tmp_path: Path) -> None:
    """In a killed run's folder, a folder that somebody has put there stays, with what is in it."""
    out = tmp_path / "out"
    write(out, a="1")
    left = out / ".skincad-make-01234567" / "new"
    (left / "deep").mkdir(parents=True)
    (left / "deep" / "notes").write_text("mine")
    write(out, a="2")
    assert (left / "deep" / "notes").read_text() == "mine"


@pytest.fixture
def mounted(tmp_path: Path) -> Iterator[Callable[[Path], None]]:
    """A function that mounts an empty tmpfs on a folder."""
    mounts = list[Path]()

    def mount(folder: Path) -> None:
        process = subprocess.run(
            ["mount", "-t", "tmpfs", "tmpfs", folder],
            capture_output=True,
            text=True,
            check=False,
            timeout=300,
        )
        if process.returncode:
            pytest.skip(f"mount: {process.stderr.strip()}")
        mounts.append(folder)

    if shutil.which("mount") is None or os.geteuid() != 0:
        pytest.skip("only root may mount")
    yield mount
    for folder in reversed(mounts):
        subprocess.run(["umount", folder], check=True, timeout=300)


def test_a_mount_in_the_out_folder_stays(tmp_path: Path, mounted: Callable[[Path], None]) -> None:
    out = tmp_path / "out"
    write(out, a="1")
    (out / "volume").mkdir()
    mounted(out / "volume")
    (out / "volume" / "notes").write_text("mine")
    device = (out / "volume").stat().st_dev
    before = tree(out / "volume")
    write(out, a="2")
    write(out, "circuit", gain="2")
    assert (out / "volume").stat().st_dev == device != out.stat().st_dev
    assert tree(out / "volume") == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out"]


@pytest.mark.parametrize("again", ["", "circuit", "make"])
def test_an_out_folder_that_is_a_mount(tmp_path: Path, mounted: Callable[[Path], None], again: str) -> None:
    """As a container's volume is: a new one, with another command's result, with an earlier one."""
    out = tmp_path / "out"
    out.mkdir()
    mounted(out)
    (out / "lost+found").mkdir()
    if again:
        write(out, again, **{again: "1"})
    checked_folder(out)
    write(out, a="2")
    assert (out / "a").read_text() == "2"
    assert (out / "circuit").exists() == (again == "circuit")
    assert not (out / "make").exists()
    assert out.is_mount()


@pytest.mark.slow
def test_a_link_in_the_out_folder_is_not_written_through(tmp_path: Path) -> None:
    (tmp_path / "victim").write_text("mine")
    out = tmp_path / "out"
    write(out, "circuit", gain="1")
    (out / "drawings").mkdir()
    (out / "drawings" / "section.dxf").symlink_to(tmp_path / "victim")
    message = refused_command("make", "plain-ridges", "--format", "dxf", "-o", "out", cwd=tmp_path)
    assert "section.dxf was not written by skincad, or was changed since; move it away" in message
    assert (tmp_path / "victim").read_text() == "mine"
    assert (out / "drawings" / "section.dxf").readlink() == tmp_path / "victim"


def test_an_out_folder_that_links_to_a_home_is_refused(tmp_path: Path) -> None:
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "thesis.tex").write_text("years")
    (tmp_path / "out").symlink_to(tmp_path / "home")
    for command in (["make", "plain-ridges"], ["simulate", "hold"], ["circuit", "yamada-2002"]):
        message = refused_command(*command, "-o", "out", cwd=tmp_path)
        assert "holds files but no earlier result" in message
    assert [p.name for p in (tmp_path / "home").iterdir()] == ["thesis.tex"]


def test_a_dangling_link_makes_its_folder_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "out").symlink_to(tmp_path / "later")
    with replaced(tmp_path / "out") as staging:
        (staging / "a").write_text("new")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["later", "out"]
    assert (tmp_path / "later" / "a").read_text() == "new"
