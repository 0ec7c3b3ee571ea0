"""CSV files that mean harm: crest heights, material tests, gain curves."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skincad import load
from skincad.base import LARGEST_FILE, InputError, read_columns
from skincad.circuit import COLUMNS
from skincad.inputs import material_test
from skincad.shape import crest_drops
from tests.attacks.test_tables import evil, refusal_words
from tests.refusals import assert_a_line, refused

DESIGN = load("plain-ridges")
READERS: dict[str, Callable[[Path], object]] = {
    "crests": lambda path: crest_drops(path, DESIGN),
    "material test": material_test,
    "gain curve": lambda path: read_columns(path, COLUMNS),
}
readers = pytest.mark.parametrize("kind", READERS)
HEADS = st.sampled_from(
    ["ridge,crest_mm", "approach_mm,force_N", "strain,stress_MPa", "frequency_Hz,gain_dB"]
)
EVIL = ("0", "1", "-1", "1e400", "nan", "inf", "-inf", "", '"', "'", "1,2", "1_0", "0x10", "9" * 400, "\x00")
CELLS = st.sampled_from([*EVIL, "=1+1"]) | st.floats().map(repr)


def attacked(kind: str, data: bytes) -> None:
    with evil(data, "evil.csv") as file:
        assert_a_line(refusal_words(lambda: READERS[kind](file)))


@readers
@given(data=st.binary(max_size=300))
@settings(max_examples=50, deadline=None)
def test_any_bytes(kind: str, data: bytes) -> None:
    attacked(kind, data)


@readers
@given(head=HEADS, rows=st.lists(st.lists(CELLS, min_size=1, max_size=3).map(",".join), max_size=12))
@settings(max_examples=100, deadline=None)
def test_any_cells(kind: str, head: str, rows: list[str]) -> None:
    attacked(kind, "\n".join([head, *rows]).encode())


BAD = {
    "a cell of 1e6 digits": b"ridge,crest_mm\n1," + b"9" * 1_000_000,
    "a quote that never ends": b'ridge,crest_mm\n1,"' + b"9\n" * 200_000,
    "1e6 columns": b"ridge," * 1_000_000,
    "a column twice": b"ridge,crest_mm,crest_mm\n1,2,3",
    "only NULs": b"\x00" * 1000,
    "half of a letter": b"ridge,crest_mm\n\xc3,1",
    "lone carriage returns": b"ridge,crest_mm\r1,2\r" * 3,
    "a row of 1e6 cells": b"ridge,crest_mm\n" + b"1," * 1_000_000,
}


@readers
@pytest.mark.parametrize("name", BAD)
def test_bad_files(kind: str, name: str) -> None:
    with evil(BAD[name], "evil.csv") as file, refused():
        READERS[kind](file)


@readers
def test_what_is_no_file_is_not_waited_for(kind: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    loop = tmp_path / "loop.csv"
    loop.symlink_to(loop)
    for path in (tmp_path / "pipe.csv", Path("/dev/zero"), tmp_path, loop, Path("a\x00b"), Path("x" * 5000)):
        with refused():
            READERS[kind](path)


@readers
def test_a_file_too_large_is_not_read(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "large.csv"
    with file.open("wb") as sparse:
        sparse.truncate(LARGEST_FILE + 1)
    with pytest.raises(InputError, match="must be at most"):
        READERS[kind](file)
