import os
from pathlib import Path

import pytest

from skincad.errors import InputError
from skincad.outfolder import MANIFEST, replaced

OURS = frozenset({"a.txt", "b.txt", MANIFEST})


def write(folder: Path, **texts: str) -> None:
    with replaced(folder, OURS) as staging:
        for name, text in {"make": "{}", **texts}.items():
            (staging / (MANIFEST if name == "make" else f"{name}.txt")).write_text(text)


def contents(folder: Path) -> dict[str, str]:
    return {p.name: p.read_text() for p in folder.iterdir() if p.is_file()}


def test_a_result_appears_whole_and_replaces_the_earlier_one(tmp_path: Path) -> None:
    write(tmp_path / "x", a="1", b="2")
    write(tmp_path / "x", a="3")
    assert contents(tmp_path / "x") == {"a.txt": "3", MANIFEST: "{}"}  # b.txt was ours and is not made anew
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
    with pytest.raises(RuntimeError), replaced(tmp_path / "x", OURS) as staging:
        (staging / "a.txt").write_text("half")
        raise RuntimeError
    assert contents(tmp_path / "x") == {"a.txt": "1", MANIFEST: "{}"}
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
    with pytest.raises(InputError, match="No space left"), replaced(tmp_path / "x", OURS) as staging:
        (staging / "a.txt").write_text("half")
        raise OSError(28, os.strerror(28))
    assert contents(tmp_path / "x")["a.txt"] == "1"
