"""The parts list, read back as a workshop's own program reads it."""

from __future__ import annotations

import csv
from collections import Counter

import pytest

import skincad
from skincad.fabrication import Job, parts_csv
from skincad.fabrication.parts_list import ESTIMATED, HEADS, ORDERED
from skincad.inputs import Design
from skincad.solids import PartRole
from skincad.solids.mold import mold
from tests.templates import SHIPPED, of_one_printer


def read(design: Design) -> list[dict[str, str]]:
    rows = list(csv.DictReader(parts_csv(Job(design)).splitlines()))  # its first row is the head
    for row in rows:
        assert row["design"].startswith(design.name)
        assert design.revision in row["design"]
    return rows


@pytest.mark.parametrize("name", SHIPPED)
def test_every_part_and_every_bought_piece_is_there(name: str) -> None:
    design = skincad.load(name)
    closed, rows = mold(design), read(design)
    assert set(rows[0]) == {*HEADS, *ESTIMATED, *ORDERED}
    assert [row["item"] for row in rows] == [str(number) for number in range(1, len(rows) + 1)]
    rows_made = [row for row in rows if row["made_by"] != "bought"]
    assert [row["what"] for row in rows_made] == [part.name for part in closed.parts if part.made == "made"]
    for row in rows_made:
        x, y, z = map(float, row["designation"].split(" x "))
        assert 0 < float(row["volume_cm3"]) < x * y * z / 1000
    assert all(row["unit"] and float(row["quantity"]) > 0 for row in rows)
    counts = Counter[str]()
    for row in rows:
        if row["made_by"] == "bought" and row["what"] != "silicone":
            counts[row["what"]] += int(row["quantity"])
    assert counts["shim"] == len(closed.of(PartRole.SHIM))
    assert counts["film strip"] == (len(closed.of(PartRole.SHIM, PartRole.STRIP)) if design.film else 0)
    assert counts["seal"] == len(closed.of(PartRole.SEAL))


def test_standards_are_named() -> None:
    designations = {row["what"]: row["designation"] for row in read(skincad.load("yamada-2002"))}
    assert designations["screw"] == "ISO 4762 M3 x 8"  # the cover's, the last
    assert designations["dowel pin"] == "ISO 8734 2 x 8"
    printed = {row["what"]: row["designation"] for row in read(of_one_printer("lab-bench"))}
    assert (printed["nut"], printed["threaded insert"]) == (
        "ISO 4032 M3",
        "M3 x 5.7, outer diameter 3.9, glued",
    )


def test_words_with_commas_stay_one_column() -> None:
    cavity = read(skincad.load("yamada-2002"))[0]
    assert (cavity["made_by"], cavity["place"]) == ("edm, wire erosion", "a cavity in one piece")
