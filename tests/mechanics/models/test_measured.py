"""What models took here: used by their laws where it is this machine's, else as good as not there."""

from __future__ import annotations

import json
import os
import stat
from pathlib import Path
from typing import Any

import pytest

from skincad.base.version import __version__
from skincad.inputs.catalog import load
from skincad.inputs.design import Design
from skincad.mechanics.check import check
from skincad.mechanics.models import table
from skincad.mechanics.models.table import (
    MODELS,
    ModelTiming,
    cache_file,
    expected_seconds,
    machine_factor,
    overhead_seconds,
    own_seconds,
    save_timings,
    timing_cache,
    without_home,
)


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the file of this test will lie; the folder is not there yet."""
    monkeypatch.setenv(table.FOLDER_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache" / table.FILE_NAME


@pytest.fixture(scope="module")
def plain() -> Design:
    return load("plain-ridges")


def times(model: str, ratio: float, size: float = 5000.0) -> dict[str, ModelTiming]:
    """A model that took `ratio` times its law."""
    return {model: ModelTiming(size=size, seconds=ratio * MODELS[model].law.at(size))}


def test_a_model_is_expected_to_take_what_it_took(file: Path, plain: Design) -> None:
    before, sampling = (
        {model: own_seconds(model, plain) for model in MODELS},
        overhead_seconds("yield", plain),
    )
    size = MODELS["linear"].size(plain)
    assert save_timings("plain-ridges", {"linear": ModelTiming(size=size, seconds=12.5)}) == file
    assert own_seconds("linear", plain) == pytest.approx(12.5, rel=1e-12)
    assert expected_seconds("linear", plain, set()) == pytest.approx(12.5, rel=1e-12)
    # the others, the yield and friction by how fast that tells the machine to be
    faster = 12.5 / before["linear"]
    assert {model: own_seconds(model, plain) / s for model, s in before.items()} == pytest.approx(
        dict.fromkeys(MODELS, faster)
    )
    assert overhead_seconds("yield", plain) == pytest.approx(faster * sampling)
    save_timings("plain-ridges", times("solid", 3.0))
    assert machine_factor("solid") == pytest.approx(3.0)
    assert machine_factor("linear") == pytest.approx(faster)  # kept beside it


def test_designs_add_up_to_the_median_and_one_takes_the_place_of_its_own(file: Path) -> None:
    for name, ratio in (("a", 1.0), ("b", 2.0), ("c", 9.0)):
        save_timings(name, times("corrected", ratio))
    assert machine_factor("corrected") == pytest.approx(2.0)
    save_timings("b", times("corrected", 4.0, size=70_000.0))
    assert machine_factor("corrected") == pytest.approx(4.0)
    assert set(json.loads(file.read_text())["measured"]["corrected"]) == {"a", "b", "c"}


def other(**change: Any) -> Any:
    """What makes a file another machine's."""
    return lambda contents: {**contents, "machine": {**contents["machine"], **change}}


WRONG = {
    "no JSON": lambda _: "not a table {",
    "cut": lambda contents: json.dumps(contents)[:-20],
    "a list": lambda contents: [contents],
    "no machine": lambda contents: {"measured": contents["measured"]},
    "words": lambda contents: {**contents, "measured": {"linear": {"a": {"size": 1.0, "seconds": "long"}}}},
    "no time": lambda contents: {**contents, "measured": {"linear": {"a": {"size": 1.0, "seconds": 0.0}}}},
    "endless": lambda contents: {**contents, "measured": {"linear": {"a": {"size": 1.0, "seconds": 1e999}}}},
}
STRANGE = {
    "processor": other(processor="abacus"),
    "versions": other(versions={"skincad": f"{__version__}.1"}),
}


@pytest.mark.parametrize("what", [*WRONG, *STRANGE])
def test_a_file_that_is_broken_or_another_machines_is_ignored(what: str, file: Path, plain: Design) -> None:
    before, speed = own_seconds("linear", plain), machine_factor()
    save_timings("a", times("linear", 7.0))
    assert (own_seconds("linear", plain), machine_factor()) == (
        pytest.approx(7.0 * before),
        pytest.approx(7.0),
    )
    text = {**WRONG, **STRANGE}[what](json.loads(file.read_text()))
    file.write_text(text if isinstance(text, str) else json.dumps(text))
    assert (own_seconds("linear", plain), machine_factor()) == (before, speed)
    contents = [w for w in check(plain, model="winkler").warnings if "cost law" in w]
    assert len(contents) == (what in WRONG)  # another machine's is no fault of the file
    assert all(without_home(file) in w and "delete it" in w for w in contents)
    save_timings("b", times("linear", 3.0))  # in its place
    assert own_seconds("linear", plain) == pytest.approx(3.0 * before)
    assert timing_cache().trouble == ""


def test_bytes_that_are_no_text_and_a_folder_in_its_place_are_ignored(file: Path, plain: Design) -> None:
    before = own_seconds("linear", plain)
    file.parent.mkdir()
    file.write_bytes(b"\xff\xfe\x00{")
    assert (own_seconds("linear", plain), "delete it" in timing_cache().trouble) == (before, True)
    file.unlink()
    file.mkdir()
    assert (own_seconds("linear", plain), "delete it" in timing_cache().trouble) == (before, True)
    with pytest.raises(OSError, match="directory"):
        save_timings("a", times("linear", 7.0))
    assert list(file.parent.iterdir()) == [file]  # nothing is left beside it


def test_to_delete_it_is_harmless(file: Path, plain: Design) -> None:
    before = own_seconds("linear", plain)
    assert timing_cache().timings == {}
    save_timings("a", times("linear", 7.0))
    file.unlink()
    assert (own_seconds("linear", plain), timing_cache().trouble) == (before, "")
    file.parent.rmdir()
    assert own_seconds("linear", plain) == before
    save_timings("a", times("linear", 7.0))
    assert own_seconds("linear", plain) == pytest.approx(7.0 * before)
    assert stat.S_ISREG(file.stat().st_mode)


def test_it_lies_in_the_users_cache_folder_and_is_told_without_the_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(table.FOLDER_VARIABLE)
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    variable = "LOCALAPPDATA" if os.name == "nt" else "XDG_CACHE_HOME"
    for contents, folder in (
        ("", tmp_path / ".cache"),
        ("rel", tmp_path / ".cache"),
        (str(tmp_path), tmp_path),
    ):
        monkeypatch.setenv(variable, contents)
        assert cache_file() == folder / "skincad" / table.FILE_NAME
    assert without_home(tmp_path / "a") == str(Path("~", "a"))
    assert without_home(tmp_path.parent / "a") == str(tmp_path.parent / "a")
