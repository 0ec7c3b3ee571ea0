"""The coupon's forms as a person fills them in, and as one does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from skincad.base import InputError
from skincad.inputs import (
    CREST_COLUMNS,
    CREST_FORM,
    NOTCH_COLUMNS,
    NOTCH_FORM,
    form,
    read_crests,
    read_notches,
)

NOTCHES = [(str(i), *(f"{0.02 * i + more:.2f}" for more in (0.04, 0.0, 0.01))) for i in range(1, 8)]
STEPS = [(str(i), f"{0.4 + 0.2 * (i % 3):.1f}", f"{0.41 + 0.2 * (i % 3):.2f}") for i in range(1, 7)]


def notches(folder: Path, text: str) -> str:
    """The words in which a form of notches is refused."""
    (folder / NOTCH_FORM).write_text(text)
    with pytest.raises(InputError) as refused:
        read_notches(folder)
    return str(refused.value).removeprefix(f"{folder / NOTCH_FORM}")


def test_a_form_reads_back_as_it_was_filled_in(tmp_path: Path) -> None:
    (tmp_path / NOTCH_FORM).write_text(form(NOTCH_COLUMNS, NOTCHES, ["a note", "another"]))
    (tmp_path / CREST_FORM).write_text(form(CREST_COLUMNS, STEPS))
    notches, steps = read_notches(tmp_path), read_crests(tmp_path)
    assert notches is not None
    assert steps is not None
    assert [*zip(*(column.tolist() for column in notches), strict=True)] == [
        tuple(map(float, row[1:])) for row in NOTCHES
    ]
    assert steps.measured.tolist() == [float(row[2]) for row in STEPS]


def test_so_does_one_of_a_spreadsheet_with_decimal_commas(tmp_path: Path) -> None:
    lines = form(NOTCH_COLUMNS, NOTCHES).replace(",", ";").replace(".", ",")
    (tmp_path / NOTCH_FORM).write_text(lines.replace("\n", ";;\r\n"))
    notches = read_notches(tmp_path)
    assert notches is not None
    assert notches.drawn[0] == 0.06


def test_a_form_that_is_not_there_was_not_measured(tmp_path: Path) -> None:
    assert read_notches(tmp_path) is None
    assert read_crests(tmp_path / "nowhere") is None


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("3,0.10,0.06,", ", row 3: stops_mm is empty; measure it"),
        ("3,0.10,,0.07", ", row 3: goes_mm is empty"),
        ("3,0.10", ", row 3: goes_mm is empty"),
        ("3,0.10,six,0.07", ", row 3: must be a finite number, got 'six'"),
        ("3,0.10,nan,0.07", ", row 3: must be a finite number"),
        ("3,0.10,0.07,0.07", ", row 3: stops_mm must be thicker than goes_mm, 0.07"),
        ("3,0.10,-0.01,0.07", ", row 3: goes_mm must not be below 0"),
        ("3,0.10,60,70", ", row 3: goes_mm must be within 1 mm of drawn_mm, 0.1, got 60"),
        ("3,0,0.06,0.07", ", row 3: drawn_mm must be above 0"),
    ],
)
def test_a_row_that_cannot_be_used_is_told(row: str, words: str, tmp_path: Path) -> None:
    lines = form(NOTCH_COLUMNS, NOTCHES).splitlines()
    lines[3] = row
    assert notches(tmp_path, "\n".join(lines)).startswith(words)


def test_a_form_of_too_little_is_told(tmp_path: Path) -> None:
    assert "at least 5 rows" in notches(tmp_path, form(NOTCH_COLUMNS, NOTCHES[:4]))
    assert "must have the columns notch, " in notches(
        tmp_path, form(NOTCH_COLUMNS[:3], [row[:3] for row in NOTCHES])
    )
    assert "unknown" in notches(tmp_path, form(("notch", "width"), [("1", "2")]))
    assert "no rows" in notches(tmp_path, form(NOTCH_COLUMNS, []))
    assert notches(tmp_path, "")
    (tmp_path / CREST_FORM).write_text(form(CREST_COLUMNS, STEPS[:5]))
    with pytest.raises(InputError, match="three heights, each twice"):
        read_crests(tmp_path)
