"""Tables that people measure and write: crests, the coupon's forms, tests of a silicone; what is refused."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

from skincad import check
from skincad.base import MOST_ROWS, InputError, read_columns
from skincad.circuit import COLUMNS
from skincad.inputs import (
    CREST_COLUMNS,
    CREST_FORM,
    NOTCH_COLUMNS,
    NOTCH_FORM,
    PRESSED,
    Design,
    form,
    material_test,
    read_crests,
    read_notches,
)
from skincad.shape import crest_drops, skin_of
from tests.refusals import refused


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "has no rows of numbers"),
        ("ridge,crest_mm\n", "has no rows of numbers"),
        (
            "ridge,height\n1,4.5\n",
            "must have the columns ridge and crest_mm, got 'ridge, height'; rename the",
        ),
        ("ridge,crest_nn\n1,4.5\n", "'crest_nn': did you mean 'crest_mm'"),
        ("ridge,crest_m\n" + "\n".join(f"{i},4.5" for i in range(1, 10)), "must be within 0.5 mm"),
        ("ridge,crest_mm\n1,4.5\n", "must give crest_mm of each ridge from 1 to 9 once"),
        ("ridge,crest_mm\n1,4.5,3\n", "row 1: must have 2 values, got 3"),
        ("ridge,crest_mm\n1,high\n", "row 1: must be a finite number, got 'high'"),
        ("ridge,crest_mm\n1,nan\n", "row 1: must be a finite number, got 'nan'"),
        ("ridge,crest_mm\n" + "\n".join(f"{i},3.0" for i in range(1, 10)), "must be within 0.5 mm"),
    ],
)
def test_a_bad_file_is_refused(tmp_path: Path, yamada: Design, text: str, words: str) -> None:
    path = tmp_path / "crests.csv"
    path.write_text(text)
    with refused(words):
        crest_drops(path, yamada)


def as_designed(path: Path, design: Design) -> Path:
    summits = [placed.frame.at(0.0, design.ridge.height).z for placed in skin_of(design).placed]
    path.write_text("ridge,crest_mm\n" + "\n".join(f"{i},{z!r}" for i, z in enumerate(summits, 1)))
    return path


def test_a_missing_file_and_a_wrong_model_are_refused(tmp_path: Path, yamada: Design) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        check(yamada, measured=tmp_path / "none.csv")
    with pytest.raises(InputError, match="measured: is not judged by the winkler model"):
        check(yamada, measured=as_designed(tmp_path / "crests.csv", yamada), model="winkler")


ROWS = ((1.0, 4.5156), (2.0, -0.25), (3.0, 1.5e-7), (1e3, 10.0))
SPELLINGS = {
    "commas": "ridge,crest_mm\n{rows}",
    "semicolons": "ridge;crest_mm\n{rows}",
    "tabs": "ridge\tcrest_mm\n{rows}",
    "quoted names": '"ridge";"crest_mm"\n{rows}',
    "blanks": " ridge ; crest_mm \n\n{rows}\n  \n",
    "trailing separators": "ridge;crest_mm;;\n;;;\n{rows};;\n;;;",
    "comments": "# by hand, 21.11.; in mm\nridge;crest_mm\n# 1,5;2.5\n{rows}\n",
    "quoted numbers": "ridge;crest_mm\n{quoted}",
}


def spelt(text: str, decimal: str) -> str:
    separator = next(mark for mark in "\t;," if mark in text)
    rows = [[repr(value).replace(".", decimal) for value in row] for row in ROWS]
    return text.format(
        rows="\n".join(separator.join(row) for row in rows),
        quoted="\n".join(separator.join(f'"{cell}"' for cell in row) for row in rows),
    )


@pytest.mark.parametrize("decimal", [".", ","])
@pytest.mark.parametrize("spelling", SPELLINGS)
def test_a_table_reads_the_same_from_any_spreadsheet(tmp_path: Path, spelling: str, decimal: str) -> None:
    if (spelling, decimal) == ("commas", ","):
        return  # refused, below
    path = tmp_path / "crests.csv"
    for encoding, line_end in product(("utf-8", "utf-8-sig", "utf-16"), ("\n", "\r\n", "\r")):
        path.write_bytes(spelt(SPELLINGS[spelling], decimal).replace("\n", line_end).encode(encoding))
        columns = read_columns(path, ("ridge", "crest_mm"))
        assert list(columns.by_name) == ["ridge", "crest_mm"]
        assert np.array_equal(np.stack([*columns.by_name.values()], axis=1), np.array(ROWS))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("ridge,crest_mm\n1,4,5\n", "row 1: must have 2 values, got 3; write decimals with a point, or sep"),
        ('ridge,crest_mm\n1,"4,5"\n',
         "row 1: must be a finite number, got '4,5'; write decimals with a point"),
        ("ridge;crest_mm\n1;4,5\n2;4.5\n",
         "row 2: must be a finite number, got '4.5'; write all decimals with"),
        ("ridge;crest_mm\n1;1.234,5\n",
         "row 1: must be a finite number, got '1.234,5'; write all decimals with"),
        ("ridge;crest_mm\n1;1,234,5\n", "row 1: must be a finite number, got '1,234,5'"),
        ("ridge;crest_mm\n1\t4,5\n",
         "row 1: must have 2 values, got 1; separate them by semicolon, as in the"),
        ("ridge;crest_mm\n;4,5\n", "row 1: must be a finite number, got ''"),
        ("ridge;height\n1;4,5\n", "got 'ridge, height'; rename the column that is crest_mm: 'height'"),
        ("ridge;crest_mm,\n1;4,5\n", "'crest_mm,': did you mean 'crest_mm'"),
        ("ridge crest_mm\n1 4.5\n", "has no rows of numbers; first row: ridge,crest_mm"),
        ("ridge;crest_mm\n1;1_0\n", "row 1: must be a finite number, got '1_0'"),
        ("ridge;crest_mm\n1;\u0661\n", "row 1: must be a finite number, got '\u0661'"),
        ("ridge;crest_mm\n" * 2, "row 1: must be a finite number, got 'ridge'"),
    ],
)  # fmt: skip
def test_what_two_readings_would_fit_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "crests.csv"
    path.write_text(text, encoding="utf-8")
    with refused(words):
        read_columns(path, ("ridge", "crest_mm"))


def test_utf_16_without_its_mark_and_too_many_rows_are_said(tmp_path: Path) -> None:
    path = tmp_path / "crests.csv"
    path.write_bytes("ridge;crest_mm\n1;4,5\n".encode("utf-16-le"))
    with pytest.raises(InputError, match="is not UTF-8 text; save it as CSV in UTF-8"):
        read_columns(path, ("ridge", "crest_mm"))
    path = tmp_path / "crests.csv"
    path.write_text("ridge;crest_mm\n" + ";\n" * (MOST_ROWS + 1))
    with pytest.raises(InputError, match=f"must have at most {MOST_ROWS} rows"):
        read_columns(path, ("ridge", "crest_mm"))


def test_every_reader_takes_a_european_spreadsheet(tmp_path: Path, yamada: Design) -> None:
    plain, european = as_designed(tmp_path / "crests.csv", yamada), tmp_path / "crests-eu.csv"

    def translated() -> None:
        text = plain.read_text().replace(",", ";").replace(".", ",")
        european.write_text("\ufeff" + text, encoding="utf-8")

    translated()
    assert crest_drops(european, yamada) == crest_drops(plain, yamada)
    for pair in (PRESSED, ("strain", "stress_MPa")):
        plain.write_text(",".join(pair) + "\n" + "\n".join(f"{i / 100},{i / 7}" for i in range(20)))
        translated()
        one, other = material_test(plain), material_test(european)
        assert np.array_equal(one.deformation, other.deformation)
        assert np.array_equal(one.load, other.load)
    gain = np.random.default_rng(1).normal(0, 100, 50)
    rows = "\n".join(f"{10.5 + i},{level}" for i, level in enumerate(gain))
    plain.write_text(f"frequency_Hz,gain_dB\n{rows}\n")
    translated()
    one, other = (read_columns(path, COLUMNS) for path in (plain, european))
    assert all(np.array_equal(one[name], other[name]) for name in COLUMNS)
    assert np.array_equal(other["gain_dB"], gain)


@pytest.mark.parametrize("span", [0.02, 1.0, 50.0])
@pytest.mark.parametrize(("back", "taken"), [(0.03, True), (0.08, False)])
def test_a_crosshead_may_go_back_a_little(tmp_path: Path, span: float, back: float, taken: bool) -> None:
    travel = np.linspace(0.0, span, 30)
    travel[15] = travel[14] - back * span
    path = tmp_path / "test.csv"
    rows = zip(travel, np.linspace(0.0, 2.0, 30), strict=True)
    path.write_text("approach_mm,force_N\n" + "\n".join(f"{a:.9g},{b:.9g}" for a, b in rows))
    if taken:
        assert material_test(path).deformation.size == 30
    else:
        with pytest.raises(InputError, match="row 16: approach_mm goes back"):
            material_test(path)


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
    rows = [*zip(*(column.tolist() for column in notches), strict=True)]
    assert rows == [tuple(map(float, row[1:])) for row in NOTCHES]
    assert steps.measured.tolist() == [float(row[2]) for row in STEPS]
    lines = form(NOTCH_COLUMNS, NOTCHES).replace(",", ";").replace(".", ",")  # as a spreadsheet writes it
    (tmp_path / NOTCH_FORM).write_text(lines.replace("\n", ";;\r\n"))
    assert read_notches(tmp_path).drawn[0] == 0.06
    assert read_notches(tmp_path / "nowhere") is read_crests(tmp_path / "nowhere") is None  # not measured


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
    less = form(NOTCH_COLUMNS[:3], [row[:3] for row in NOTCHES])
    assert "must have the columns notch and drawn_mm" in notches(tmp_path, less)
    assert "must have the columns" in notches(tmp_path, form(("notch", "width"), [("1", "2")]))
    assert "no rows" in notches(tmp_path, form(NOTCH_COLUMNS, []))
    assert notches(tmp_path, "")
    (tmp_path / CREST_FORM).write_text(form(CREST_COLUMNS, STEPS[:5]))
    with pytest.raises(InputError, match="three heights, each twice"):
        read_crests(tmp_path)
