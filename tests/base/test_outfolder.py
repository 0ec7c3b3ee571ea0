"""Files: a folder of results that is replaced as a whole, and when a file was saved."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from skincad.base import (
    COMMANDS,
    InputError,
    RefusedError,
    checked_folder,
    files_below,
    outfolder,
    replaced,
    saved,
    saves,
)


def write(folder: Path, command: str = "make", **texts: str) -> None:
    with replaced(folder, command) as staging:
        for name, text in texts.items():
            (staging / f"{name}.txt").write_text(text)


def contents(folder: Path) -> dict[str, str]:
    return {p.name: p.read_text() for p in folder.iterdir() if p.is_file() and p.name != "make.json"}


def test_a_result_appears_whole_with_a_manifest_and_replaces_the_earlier(tmp_path: Path) -> None:
    write(tmp_path / "x", a="1", b="2")
    write(tmp_path / "x", a="3")
    assert contents(tmp_path / "x") == {"a.txt": "3"}  # b.txt was ours and is not made anew
    assert [p.name for p in tmp_path.iterdir()] == ["x"]
    write(tmp_path / "x", "make", a="1")
    words = r"a\.txt was not written by skincad, or was changed since; move it away"
    with pytest.raises(InputError, match=words):  # known before any work
        checked_folder(tmp_path / "x", "circuit", ["a.txt"])
    with pytest.raises(InputError, match=words):  # and else before anything is put in place
        write(tmp_path / "x", "circuit", a="2")
    assert contents(tmp_path / "x") == {"a.txt": "1"}


def test_a_persons_own_files_the_folders_mode_and_a_link_to_it_are_kept(tmp_path: Path) -> None:
    (tmp_path / "x").mkdir(mode=0o700)
    (tmp_path / "link").symlink_to(tmp_path / "x")
    write(tmp_path / "link", a="1")
    assert (tmp_path / "link").is_symlink()
    (tmp_path / "x" / "b.txt").write_text("mine")  # of a name that we may write another time
    (tmp_path / "x" / "slices").mkdir()
    (tmp_path / "x" / "slices" / "one.gcode").write_text("G1")
    write(tmp_path / "x", a="2")
    assert contents(tmp_path / "x") == {"a.txt": "2", "b.txt": "mine"}
    assert (tmp_path / "x" / "slices" / "one.gcode").read_text() == "G1"
    assert (tmp_path / "x").stat().st_mode & 0o777 == 0o700


def test_a_failure_leaves_the_earlier_result_untouched(tmp_path: Path) -> None:
    """A full disk's half way, which is an input error, too; of a first run no folder stays."""
    with pytest.raises(RuntimeError), replaced(tmp_path / "new" / "deeper"):
        raise RuntimeError
    assert not list(tmp_path.iterdir())
    write(tmp_path / "x", a="1")
    full = OSError(28, os.strerror(28))
    for failure, seen, words in ((RuntimeError(), RuntimeError, None), (full, InputError, "No space left")):
        with pytest.raises(seen, match=words), replaced(tmp_path / "x") as staging:
            (staging / "a.txt").write_text("half")
            raise failure
        assert contents(tmp_path / "x") == {"a.txt": "1"}
        assert [p.name for p in tmp_path.iterdir()] == ["x"]


def test_a_folder_in_use_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "thesis.tex").write_text("years")
    with pytest.raises(InputError, match="no earlier result"):
        write(tmp_path / "home", a="1")
    assert contents(tmp_path / "home") == {"thesis.tex": "years"}
    with pytest.raises(InputError, match="folder: "):
        checked_folder(tmp_path / ("x" * 300))
    monkeypatch.chdir(tmp_path / "home")
    for folder in (Path(), tmp_path):
        with pytest.raises(InputError, match="the folder you are in"):
            checked_folder(folder)


def stopped_at(move: int, after: bool, interruption: type[BaseException]) -> Callable[[Path, Path], Path]:
    """A rename that is interrupted at this call, before it or after."""
    rename, seen = Path.rename, list[Path]()

    def interrupted(self: Path, target: Path) -> Path:
        seen.append(self)
        if after:
            rename(self, target)
        if len(seen) == move + 1:
            raise interruption
        return target if after else rename(self, target)

    return interrupted


MOVES = 5  # of the test below: make.json and a.txt leave; a.txt, b.txt and make.json come


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, SystemExit, OSError])
@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize("move", range(MOVES))
def test_an_interruption_between_two_renames_brings_the_earlier_result_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, move: int, after: bool, interruption: type[BaseException]
) -> None:
    write(tmp_path / "x", a="1")
    monkeypatch.setattr(Path, "rename", stopped_at(move, after, interruption))
    with pytest.raises((interruption, InputError)):
        write(tmp_path / "x", a="2", b="2")
    whole = after and move == MOVES - 1  # the manifest is in its place: all is
    assert contents(tmp_path / "x") == ({"a.txt": "2", "b.txt": "2"} if whole else {"a.txt": "1"})
    assert not [p for p in (tmp_path / "x").iterdir() if p.name.startswith(".")]
    assert [p.name for p in tmp_path.iterdir()] == ["x"]
    monkeypatch.undo()
    write(tmp_path / "x", a="3")  # and its manifest says what is there
    assert contents(tmp_path / "x") == {"a.txt": "3"}


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize("function", ["mkdir", "rename", "unlink", "rmdir"])
def test_an_interruption_anywhere_leaves_the_old_or_the_new_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, function: str, after: bool
) -> None:
    """Ctrl-C before or after each change of the disk; what it leaves over, the next run puts right."""
    real = getattr(Path, function)
    for count in range(1, 20):
        folder = tmp_path / f"{count}"
        write(folder, a="1")
        calls = 0

        def interrupted(self: Path, *rest: Path, at: int = count, **options: bool) -> object:
            nonlocal calls
            calls += 1
            if calls == at and not after:
                raise KeyboardInterrupt
            result = real(self, *rest, **options)
            if calls == at:
                raise KeyboardInterrupt
            return result

        with monkeypatch.context() as patch:
            patch.setattr(Path, function, interrupted)
            try:
                write(folder, a="2", b="2")
            except KeyboardInterrupt:
                pass
            else:
                assert count > 1
                return
        checked_folder(folder)
        assert contents(folder) in ({"a.txt": "1"}, {"a.txt": "2", "b.txt": "2"})
        assert not list(folder.glob(".*"))
    raise AssertionError("it never ends")


def test_what_cannot_be_written_is_known_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"^folder: .*cannot be written"):
        write(tmp_path / "file" / "x", a="1")
    for folder in (tmp_path / "file" / "x", tmp_path / "file" / "x" / "y", Path("/proc/none/x")):
        with pytest.raises(InputError, match=r"folder: .* cannot be written"):
            checked_folder(folder)
    checked_folder(tmp_path / "new" / "deeper")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize(
    ("first", "second"), [*pairwise([*COMMANDS, COMMANDS[0]]), *((name, name) for name in COMMANDS)]
)
def test_each_command_replaces_its_own_files_only(tmp_path: Path, first: str, second: str) -> None:
    for command in (first, second):
        with replaced(tmp_path / "x", command) as staging:
            (staging / f"{command}.txt").write_text("1")
            (staging / f"{command}-more.txt").write_text("1")
    with replaced(tmp_path / "x", second) as staging:
        (staging / f"{second}.txt").write_text("2")
    expected = {f"{first}.txt": "1", f"{first}-more.txt": "1"} if first != second else {}
    there = {name: text for name, text in contents(tmp_path / "x").items() if name.endswith(".txt")}
    assert there == {**expected, f"{second}.txt": "2"}
    assert {p.name for p in (tmp_path / "x").glob("*.json")} == {f"{first}.json", f"{second}.json"}


def test_a_manifest_says_who_wrote_what(tmp_path: Path) -> None:
    with replaced(tmp_path / "x", "circuit", {"name": "n"}) as staging:
        (staging / "b").write_text("")
        (staging / "a").write_text("")
    manifest = json.loads((tmp_path / "x" / "circuit.json").read_text())
    assert (manifest["command"], manifest["name"], manifest["files"]) == ("circuit", "n", ["a", "b"])
    nothing = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"  # SHA-256 of no bytes
    assert manifest["sha256"] == {"a": nothing, "b": nothing}
    assert manifest["skincad"]


def test_a_number_that_json_has_not_is_refused_and_the_earlier_result_stays(tmp_path: Path) -> None:
    write(tmp_path / "x", a="1")
    before = (tmp_path / "x" / "make.json").read_bytes()
    for number in (float("nan"), float("inf")):
        with pytest.raises(RefusedError, match="not finite"), replaced(tmp_path / "x", "make", {"n": number}):
            pass
    assert contents(tmp_path / "x") == {"a.txt": "1"}
    assert (tmp_path / "x" / "make.json").read_bytes() == before


def test_a_run_that_waits_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / "x", a="1")
    descriptor = os.open(tmp_path / "x", os.O_RDONLY)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    clock, waits = [0.0], list[str]()

    def sleep(seconds: float) -> None:
        clock[0] += seconds
        waits.append(capsys.readouterr().err)
        if waits[-1]:
            os.close(descriptor)  # the other one is done

    monkeypatch.setattr(outfolder.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(outfolder.time, "sleep", sleep)
    write(tmp_path / "x", a="2")
    assert waits[-1] == f"skincad: waiting for another skincad run in {tmp_path / 'x'}\n"
    assert len(waits) > 1  # not at once: most waits are too short to be told
    assert not any(waits[:-1])
    assert capsys.readouterr().err == ""
    assert contents(tmp_path / "x") == {"a.txt": "2"}


def test_a_lock_on_the_parent_folder_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def waits(_: float) -> None:
        raise AssertionError("it waits")

    monkeypatch.setattr(outfolder.time, "sleep", waits)
    descriptor = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    try:
        write(tmp_path / "x", a="1")
        write(tmp_path / "x", a="2")
    finally:
        os.close(descriptor)
    assert contents(tmp_path / "x") == {"a.txt": "2"}


def write_below(folder: Path, **texts: str) -> None:
    """Write files whose names have _ for the stroke between folders."""
    with replaced(folder) as staging:
        for name, text in texts.items():
            path = staging / name.replace("_", "/")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)


def tree(folder: Path) -> dict[str, str]:
    return {name: path.read_text() for name, path in files_below(folder).items() if name != "make.json"}


def test_files_of_an_older_layout_give_way_but_for_a_changed_one(tmp_path: Path) -> None:
    """As its manifest lists them, whether they lay at the top or below; a folder left empty goes."""
    write_below(tmp_path / "x", skin="1", cavity="1")
    write_below(tmp_path / "x", solids_skin="2", film_strips="2", orders_cnc="2")
    assert tree(tmp_path / "x") == {"solids/skin": "2", "film/strips": "2", "orders/cnc": "2"}
    assert json.loads((tmp_path / "x" / "make.json").read_text())["files"] == [*tree(tmp_path / "x")]
    (tmp_path / "x" / "film" / "mine").write_text("mine")
    write_below(tmp_path / "x", solids_skin="3")
    assert tree(tmp_path / "x") == {"film/mine": "mine", "solids/skin": "3"}
    assert not (tmp_path / "x" / "orders").exists()
    (tmp_path / "x" / "solids" / "skin").write_text("mine")
    with pytest.raises(InputError, match="changed since"):
        write_below(tmp_path / "x", solids_skin="4")
    assert tree(tmp_path / "x") == {"film/mine": "mine", "solids/skin": "mine"}


@pytest.mark.parametrize("what", ["link", "file"])
def test_nothing_is_written_through_what_is_no_folder(tmp_path: Path, what: str) -> None:
    write_below(tmp_path / "x", design="1")
    (tmp_path / "other").mkdir()
    place = tmp_path / "x" / "solids"
    if what == "link":
        place.symlink_to(tmp_path / "other")
    else:
        place.write_text("mine")
    with pytest.raises(InputError, match="solids was not written by skincad"):
        write_below(tmp_path / "x", design="2", solids_skin="2")
    assert not [*(tmp_path / "other").iterdir()]
    assert (tmp_path / "x" / "design").read_text() == "1"


OUT = ("../victim", "/victim", "solids//b", "./a", "solids/../../victim", "solids/..", "sub/a", "solids/a/b")


@pytest.mark.parametrize("name", [*OUT, "", ".."])
def test_a_manifest_that_leads_out_of_its_folder_is_none(tmp_path: Path, name: str) -> None:
    write(tmp_path / "x", a="1")
    manifest = tmp_path / "x" / "make.json"
    data = json.loads(manifest.read_text())
    data["sha256"][name] = "0"
    manifest.write_text(outfolder.manifest_text(data))
    assert outfolder.listed(tmp_path / "x", "make") is None


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize("move", range(4))
def test_an_interruption_leaves_no_empty_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, move: int, after: bool
) -> None:
    write_below(tmp_path / "x", film_strips="1")
    monkeypatch.setattr(Path, "rename", stopped_at(move, after, KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        write_below(tmp_path / "x", solids_skin="2")
    monkeypatch.undo()
    whole = after and move == 3
    assert tree(tmp_path / "x") == ({"solids/skin": "2"} if whole else {"film/strips": "1"})
    assert [p.name for p in (tmp_path / "x").iterdir() if p.is_dir()] == ["solids" if whole else "film"]


@pytest.fixture
def acts(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """What is done in each wait, one a wait; when nothing is left the watching is interrupted."""
    left: list[object] = []

    def sleep(_: float) -> None:
        if not left:
            raise KeyboardInterrupt
        act = left.pop(0)
        if callable(act):
            act()

    monkeypatch.setattr(saved, "sleep", sleep)
    return left


def counted(*files: Path) -> int:
    seen = 0
    with pytest.raises(KeyboardInterrupt):
        for _ in saves(files):
            seen += 1
    return seen


def save(file: Path, text: str, second: int) -> None:
    file.write_text(text)
    os.utime(file, (second, second))  # clocks of file systems may stand still between two tests' lines


def test_each_save_is_told_once(tmp_path: Path, acts: list[object]) -> None:
    file = tmp_path / "a.toml"
    save(file, "a", 1)
    acts += [None, None, None, lambda: save(file, "b", 2), None, None, None, lambda: save(file, "b", 3)]
    acts += [None] * 6
    assert counted(file) == 3


def test_a_save_in_two_steps_is_told_when_it_is_whole(tmp_path: Path, acts: list[object]) -> None:
    file = tmp_path / "a.toml"
    save(file, "a", 1)
    texts = []
    acts += [None, None, lambda: save(file, "half", 2), lambda: save(file, "whole", 3), *[None] * 6]
    with pytest.raises(KeyboardInterrupt):
        for _ in saves([file]):
            texts.append(file.read_text())
    assert texts == ["a", "whole"]


def test_a_file_that_is_being_replaced_is_waited_for(tmp_path: Path, acts: list[object]) -> None:
    file, other = tmp_path / "a.toml", tmp_path / "printer.toml"
    save(file, "a", 1)
    save(other, "p", 1)
    acts += [None, None, file.unlink, None, lambda: save(file, "b", 2), *[None] * 4]
    acts += [lambda: save(other, "q", 3), *[None] * 4]
    assert counted(file, other) == 3
