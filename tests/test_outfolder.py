import json
import os
from pathlib import Path

import pytest

from skincad.errors import InputError
from skincad.outfolder import MANIFEST, checked_folder, replaced


def write(folder: Path, **texts: str) -> None:
    with replaced(folder) as staging:
        for name, text in texts.items():
            (staging / f"{name}.txt").write_text(text)
        (staging / MANIFEST).write_text(json.dumps({"files": [f"{name}.txt" for name in texts]}))


def contents(folder: Path) -> dict[str, str]:
    return {p.name: p.read_text() for p in folder.iterdir() if p.is_file() and p.name != MANIFEST}


def test_a_result_appears_whole_and_replaces_the_earlier_one(tmp_path: Path) -> None:
    write(tmp_path / "x", a="1", b="2")
    write(tmp_path / "x", a="3")
    assert contents(tmp_path / "x") == {"a.txt": "3"}  # b.txt was ours and is not made anew
    assert [p.name for p in tmp_path.iterdir()] == ["x"]


def test_a_persons_own_files_in_the_folder_are_kept(tmp_path: Path) -> None:
    write(tmp_path / "x", a="1")
    (tmp_path / "x" / "notes.md").write_text("mine")
    (tmp_path / "x" / "slices").mkdir()
    (tmp_path / "x" / "slices" / "one.gcode").write_text("G1")
    write(tmp_path / "x", a="2")
    assert contents(tmp_path / "x")["notes.md"] == "mine"
    assert (tmp_path / "x" / "slices" / "one.gcode").read_text() == "G1"


def test_a_failure_leaves_the_earlier_result_untouched(tmp_path: Path) -> None:
    write(tmp_path / "x", a="1")
    with pytest.raises(RuntimeError), replaced(tmp_path / "x") as staging:
        (staging / "a.txt").write_text("half")
        raise RuntimeError
    assert contents(tmp_path / "x") == {"a.txt": "1"}
    assert [p.name for p in tmp_path.iterdir()] == ["x"]


def test_a_folder_of_other_things_is_refused(tmp_path: Path) -> None:
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "thesis.tex").write_text("years")
    with pytest.raises(InputError, match="no earlier result"):
        write(tmp_path / "home", a="1")
    assert contents(tmp_path / "home") == {"thesis.tex": "years"}


def test_a_link_to_a_folder_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    write(tmp_path / "link", a="1")
    assert (tmp_path / "link").is_symlink()
    assert contents(tmp_path / "real")["a.txt"] == "1"


def test_a_path_through_a_file_is_an_input_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"^-o: .*cannot be written"):
        write(tmp_path / "file" / "x", a="1")


def test_a_disk_that_fills_half_way_is_an_input_error_and_changes_nothing(tmp_path: Path) -> None:
    write(tmp_path / "x", a="1")
    with pytest.raises(InputError, match="No space left"), replaced(tmp_path / "x") as staging:
        (staging / "a.txt").write_text("half")
        raise OSError(28, os.strerror(28))
    assert contents(tmp_path / "x")["a.txt"] == "1"


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, SystemExit, OSError])
def test_an_interruption_between_the_two_renames_brings_the_earlier_result_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, interruption: type[BaseException]
) -> None:
    write(tmp_path / "x", a="1")
    rename = Path.rename

    def interrupted(self: Path, target: Path) -> Path:
        if self.suffix == ".new":
            raise interruption
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", interrupted)
    with pytest.raises((interruption, InputError)):
        write(tmp_path / "x", a="2")
    assert contents(tmp_path / "x") == {"a.txt": "1"}
    assert [p.name for p in tmp_path.iterdir()] == ["x"]


def test_a_folder_keeps_its_mode(tmp_path: Path) -> None:
    write(tmp_path / "x", a="1")
    (tmp_path / "x").chmod(0o700)
    write(tmp_path / "x", a="2")
    assert (tmp_path / "x").stat().st_mode & 0o777 == 0o700


def test_a_users_file_of_a_name_that_we_write_now_is_replaced_only_by_it(tmp_path: Path) -> None:
    write(tmp_path / "x", a="1")
    (tmp_path / "x" / "b.txt").write_text("mine")
    write(tmp_path / "x", a="2")
    assert contents(tmp_path / "x") == {"a.txt": "2", "b.txt": "mine"}


def test_the_folder_one_is_in_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in (Path(), tmp_path.parent):
        with pytest.raises(InputError, match="the folder you are in"):
            checked_folder(folder)


def test_a_name_that_is_too_long_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="-o: "):
        checked_folder(tmp_path / ("x" * 300))


def test_what_cannot_be_written_is_known_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file" / "x", tmp_path / "file" / "x" / "y", Path("/proc/none/x")):
        with pytest.raises(InputError, match=r"-o: .* cannot be written"):
            checked_folder(folder)
    checked_folder(tmp_path / "new" / "deeper")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
