"""Tables of numbers as machines, spreadsheets and people write them, and what is said of others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from skincad.base import Columns, InputError, read_columns
from skincad.inputs import PRESSED, STRETCHED, material_test
from tests.refusals import refused

BAR = ("strain", "stress_MPa")
# what a machine calls a column, its unit, and how many of skincad's unit that is
MACHINES = {
    "strain": [
        ("Engineering Strain", "", 1.0),
        ("Tensile strain (Extension)", "%", 0.01),
        ("Strain 1", "mm/mm", 1.0),
        ("Dehnung", "%", 0.01),
        ("strain", "%", 0.01),
    ],
    "stress_MPa": [
        ("Engineering Stress", "MPa", 1.0),
        ("Tensile stress", "kPa", 1e-3),
        ("Spannung", "N/mm²", 1.0),
        ("stress", "Pa", 1e-6),
        ("Stress", "psi", 0.45359237 * 9.80665 / 25.4**2),
    ],
    "extension_mm": [("Extension", "mm", 1.0), ("Crosshead", "in", 25.4), ("Standardweg", "mm", 1.0)],
    "approach_mm": [
        ("Compressive extension", "mm", 1.0),
        ("Depth", "um", 1e-3),
        ("Displacement", "cm", 10.0),
    ],
    "force_N": [
        ("Load", "N", 1.0),
        ("Force", "kN", 1e3),
        ("Standardkraft", "N", 1.0),
        ("Load", "lbf", 0.45359237 * 9.80665),
        ("Force", "gf", 9.80665e-3),
    ],
}
OTHERS = ["Time", "True Strain", "True Stress", "Corrected position", "Cycle count", "Comment"]
ABOVE = [
    ["Specimen Thickness (mm)", "3"],
    ["Type of test", "Pull-to-failure"],
    ["Maximum Load", "12.7", "N"],
    ["Standard", "ASTM D412"],
    ["Speed (mm/min)", "450"],
    ["Date", "2026-11-28 10:04"],
]


class Export:
    """A machine's table drawn by a seed: its text as bytes, its numbers, and what stands around them."""

    def __init__(self, seed: int) -> None:
        dice = np.random.default_rng(seed)

        def pick(values: list[object]) -> object:
            return values[int(dice.integers(len(values)))]

        self.wanted = (BAR, STRETCHED, PRESSED)[seed % 3]
        separator = str(pick([",", ";", "\t"]))
        decimal = "." if separator == "," else str(pick([".", ","]))
        units_below = bool(dice.integers(2))
        style = str(pick(["{} ({})", "{} [{}]", "{} in {}", "{}, {}"] if separator != "," else ["{} ({})"]))
        columns = [(name, *pick(MACHINES[name])) for name in self.wanted]  # type: ignore[misc]
        columns += [
            ("", str(name), "", 1.0) for name in dice.choice(OTHERS, int(dice.integers(4)), replace=False)
        ]
        columns = [columns[i] for i in dice.permutation(len(columns))]
        values = np.round(np.cumsum(dice.uniform(0.001, 0.01, (20, len(columns))), axis=0), 6)
        quote = '"' if dice.integers(2) else ""
        head = [
            title if units_below or not unit else style.format(title, unit) for _, title, unit, _ in columns
        ]
        rows = [[separator.join(row)] for row in ABOVE[: int(dice.integers(len(ABOVE) + 1))]]
        self.above = len(rows) + (0 if dice.integers(2) else -1)
        self.above = max(self.above, len(rows))
        rows.append([separator.join(f"{quote}{cell}{quote}" for cell in head)])
        self.units_below = units_below and any(unit for _, _, unit, _ in columns)
        if self.units_below:
            rows.append(
                [separator.join(f"{quote}({unit}){quote}" if unit else "" for _, _, unit, _ in columns)]
            )
        for row in values:
            cells = [f"{value:.6f}".replace(".", decimal) for value in row]
            rows.append([separator.join(f"{quote}{cell}{quote}" for cell in cells)])
        text = str(pick(["\n", "\r\n"])).join(line for (line,) in rows)
        mark = f"sep={separator}\n" if dice.integers(3) == 0 else ""
        self.above += bool(mark)
        self.bytes = (mark + text).encode(str(pick(["utf-8", "utf-8-sig", "utf-16", "cp1252"])))
        self.numbers = {name: values[:, i] * factor for i, (name, _, _, factor) in enumerate(columns) if name}
        self.others = [title for name, title, _, _ in columns if not name and title != "Time"]


@pytest.mark.parametrize("seed", range(30))
def test_an_export_of_a_machine_is_read(seed: int, tmp_path: Path) -> None:
    """A block above, units in the header or below, other names, separators, decimal commas, more columns."""
    export = Export(seed)
    path = tmp_path / "export.csv"
    path.write_bytes(export.bytes)
    table = read_columns(path, export.wanted)
    assert list(table.by_name) == list(export.wanted)
    for name, values in export.numbers.items():
        np.testing.assert_allclose(table[name], values, rtol=1e-12, err_msg=name)
    told = " ".join(table.notes)
    assert ("above the columns' names" in told) == bool(export.above)
    assert ("a row of units" in told) == export.units_below
    assert all(f"'{other}'" in told for other in export.others)


def read(folder: Path, text: str, *sets: tuple[str, ...]) -> Columns:
    (folder / "table.csv").write_text(text)
    return read_columns(folder / "table.csv", *(sets or (BAR,)))


def test_what_was_passed_over_and_how_columns_were_read_is_told(tmp_path: Path) -> None:
    head = "made by a machine\nTime (s);Engineering Strain;Stress (kPa);True Stress (MPa)\n"
    text = f"{head}0;0,1;20;3\n1;0,2;30;4\n"
    table = read(tmp_path, text)
    assert table.notes == (
        "read 'Engineering Strain' as strain; 'Stress (kPa)' as stress_MPa, times 0.001",
        "passed over: 1 row above the columns' names; the column 'True Stress (MPa)'",
    )
    assert table["stress_MPa"].tolist() == [0.02, 0.03]
    assert read(tmp_path, "strain,stress_MPa\n0.1,2\n0.2,3\n").notes == ()
    after = read(tmp_path, "strain,stress_MPa\n0.1,2\n0.2,3\nend of test,\n")
    assert after.notes == ("passed over: 1 row after the numbers",)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "LabVIEW Measurement\nSeparator\tTab\nX_Value\tUntitled\n0.05\t0.2\n0.09\t0.4\n",
            "has no row that names its columns, got 'X_Value, Untitled'; "
            "delete the 3 rows above the numbers, and write strain and stress_MPa, a tab between, first",
        ),
        ("0.1,0.2\n0.2,0.3\n", "has no row that names its columns; write strain,stress_MPa as the first row"),
        ("strain,tension\n0.1,2\n", "rename the column that is stress_MPa: 'tension'"),
        ("strain,sterss_MPa\n0.1,2\n", "'sterss_MPa': did you mean 'stress_MPa'?"),
        ("strain,load,force (N)\n0.1,2,3\n", "must have the columns strain and stress_MPa"),
        ("strain,Stress (MPa),stress (kPa)\n0.1,2,3\n",
         "both columns 'Stress (MPa)' and 'stress (kPa)' may be stress_MPa; remove one of them"),
        ("strain,stress (furlong)\n0.1,2\n", "column 'stress (furlong)': must be in a unit of MPa, N/mm2"),
        ("strain,stress_MPa\n%,furlong\n0.1,2\n", "row 1: must be a finite number, got '%'"),
        ("strain\n0.1\n", "must have the columns strain and stress_MPa, got 'strain'; add stress_MPa"),
        ("strain,stress_MPa" + ",x" * 2000 + "\n1,2\n", "must have at most 1000 columns"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_told_with_its_remedy(text: str, words: str, tmp_path: Path) -> None:
    with refused(words):
        read(tmp_path, text)


def test_names_as_wanted_count_before_names_of_others(tmp_path: Path) -> None:
    text = "Engineering Strain,strain,stress_MPa\n0.1,0.2,1\n0.2,0.4,2\n"
    assert read(tmp_path, text)["strain"].tolist() == [0.2, 0.4]
    both = "Extension (mm),Load (N),Tensile strain,Tensile stress (MPa)\n" + "".join(
        f"{i},{2 * i},{i / 100},{i / 10}\n" for i in range(20)
    )
    (tmp_path / "both.csv").write_text(both)
    assert material_test(tmp_path / "both.csv").load[-1] == pytest.approx(1.9)
    assert material_test(tmp_path / "both.csv", 10.0, 2.0).load[-1] == pytest.approx(19.0)
    with pytest.raises(InputError, match="of a pressed pad call the columns approach_mm and force_N"):
        material_test(_written(tmp_path, "Extension,Load\n" + "".join(f"{i},{i}\n" for i in range(20))))


def _written(folder: Path, text: str) -> Path:
    (folder / "table.csv").write_text(text)
    return folder / "table.csv"


@pytest.mark.parametrize("unit", ["mN", "MN", "mPa"])
def test_milli_is_never_taken_for_mega(unit: str, tmp_path: Path) -> None:
    """mN and MN differ by nine decades: what is neither known as written is refused."""
    wanted = ("strain", "force_N") if unit.endswith("N") else BAR
    name = "force" if unit.endswith("N") else "stress"
    text = f"strain,{name} ({unit})\n0.1,2\n0.2,3\n"
    if unit == "mN":
        assert read(tmp_path, text, wanted)["force_N"].tolist() == [2e-3, 3e-3]
    else:
        with refused("must be in a unit of"):
            read(tmp_path, text, wanted)
