"""A coupon's forms become a process's table: what is measured, what is kept, what is refused."""

from __future__ import annotations

import random
import tomllib
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import shapely

from skincad.base import InputError
from skincad.fabrication import coupon_forms, read_coupon
from skincad.fabrication.coupon import coupon
from skincad.inputs import (
    CREST_COLUMNS,
    CREST_FORM,
    NOTCH_COLUMNS,
    NOTCH_FORM,
    NotchForm,
    form,
    load_design,
    processes,
)
from skincad.shape import polygon
from skincad.solids import NOTCH_DEPTH, NOTCH_PITCH, NOTCHES, Prism
from tests.fabrication.test_coupon_fit import BLADES, by_blades, ladder, steps


def fill(
    folder: Path, growth: float | None = 0.03, scatter: float | None = 0.01, offset: float = 0.0
) -> None:
    """Write what a person writes of a part that grew, and of crests that scatter; None: not measured."""
    if growth is not None:
        rows = [
            [str(i), *(f"{v:.2f}" for v in row)]
            for i, row in enumerate(zip(*ladder(growth, 1), strict=True), 1)
        ]
        (folder / NOTCH_FORM).write_text(form(NOTCH_COLUMNS, rows))
    if scatter is not None:
        crests = zip(*steps(1, scatter, offset=offset), strict=True)
        lines = [[f"{place:g}", f"{drawn:.2f}", f"{measured:.3f}"] for place, drawn, measured in crests]
        (folder / CREST_FORM).write_text(form(CREST_COLUMNS, lines))


def test_what_is_written_is_a_process_of_the_same_name(tmp_path: Path) -> None:
    fill(tmp_path)
    reading = read_coupon("sla", tmp_path)
    table = tomllib.loads(reading.to_toml())
    assert set(table) == {"sla"}
    assert set(table["sla"]) - {"tolerance"} == {"gap", "growth", "crest_sigma", "crest_offset"}
    process = processes(load_design("lab-bench", printer=table).printer)["sla"]
    assert process.growth == pytest.approx(0.03, abs=0.005)
    assert process.crest_sigma == pytest.approx(0.01, abs=0.006)  # the half-width of 24 steps
    assert process.crest_offset == pytest.approx(0.0, abs=0.01)  # 24 crests that scatter by 0.01
    assert process.gap == pytest.approx(0.08)
    assert process.pixel == processes()["sla"].pixel
    assert "growth = 0.0294 # measured on a coupon: ± 0.00" in reading.to_toml()


def test_a_tolerance_is_said_only_where_the_part_is_worse(tmp_path: Path) -> None:
    fill(tmp_path, growth=0.005, scatter=0.005)
    assert "tolerance" not in {row.key for row in read_coupon("sla", tmp_path).keys}
    fill(tmp_path, growth=0.005, scatter=0.005, offset=0.2)
    worse = {row.key: row.value for row in read_coupon("sla", tmp_path).keys}
    assert worse["crest_offset"] == pytest.approx(0.2, abs=0.005)  # 24 crests that scatter by 0.005
    assert worse["tolerance"] == pytest.approx(0.2, abs=0.015)  # the largest of 24 errors of 0.005


def test_one_form_alone_is_read(tmp_path: Path) -> None:
    fill(tmp_path, growth=None)
    assert {row.key for row in read_coupon("cnc", tmp_path).keys} == {
        "crest_sigma",
        "crest_offset",
        "tolerance",
    }
    assert read_coupon("cnc", tmp_path).as_json()["growth_mm"] == {"value": None, "error": None}


def test_shut_notches_leave_growth_open(tmp_path: Path) -> None:
    drawn = np.arange(0.06, 0.31, 0.02)
    rows = [[str(i), f"{d:.2f}", "0", "0.03"] for i, d in enumerate(drawn, 1)]
    (tmp_path / NOTCH_FORM).write_text(form(NOTCH_COLUMNS, rows))
    reading = read_coupon("fdm", tmp_path)
    assert reading.keys == []
    assert "growth is not known, and the gap may be above 0.3 mm" in str(reading)


def test_ones_own_file_is_kept_with_its_comments(tmp_path: Path) -> None:
    fill(tmp_path)
    mine = tmp_path / "mine.toml"
    mine.write_text(
        '[my-resin]\nbased_on = "sla"\npixel = 0.03 # screen\ngrowth = 0.1\n\n[my-mill]\nbased_on = "cnc"\n'
    )
    reading = read_coupon("my-resin", tmp_path, printer=mine)
    assert reading.before.growth == 0.1
    table = tomllib.loads(reading.to_toml())
    assert table["my-mill"] == {"based_on": "cnc"}
    assert table["my-resin"]["pixel"] == 0.03
    assert table["my-resin"]["growth"] == pytest.approx(0.03, abs=0.005)
    assert "# screen" in reading.to_toml()


def test_what_cannot_be_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"must hold notches.csv or crests.csv, filled in"):
        read_coupon("sla", tmp_path)
    fill(tmp_path)
    with pytest.raises(InputError, match="unknown process, got 'slb'; did you mean 'sla'"):
        read_coupon("slb", tmp_path)


Rows = list[list[str]]


def resized(rows: Rows, draw: random.Random) -> str:
    """Change a size as drawn, to another one of the part or to any."""
    row, other = draw.sample(rows[1:], 2)
    row[1] = draw.choice([other[1] if other[1] != row[1] else "0.99", "0.99", f"{float(row[1]) + 0.001:.3f}"])
    return f"drawn_mm of {rows[0][0]} {row[0]} must be"


def removed(rows: Rows, draw: random.Random) -> str:
    """Remove one or several rows."""
    removed_rows = draw.sample(rows[1:], draw.randint(1, 4))
    rows[:] = [row for row in rows if row not in removed_rows]
    numbers = sorted(int(row[0]) for row in removed_rows)
    return f"must have a row for each {rows[0][0]} of the part; missing: {', '.join(map(str, numbers))}"


def doubled(rows: Rows, draw: random.Random) -> str:
    """Write a row twice, alike or measured again."""
    again = [*draw.choice(rows[1:])]
    again[-1] = draw.choice([again[-1], f"{float(again[-1]) + 0.01:.3f}"])
    rows.insert(draw.randint(1, len(rows)), again)
    return "must be another one: row"


def added(rows: Rows, draw: random.Random) -> str:
    """Add a row of a place that the part doesn't have."""
    more = [*draw.choice(rows[1:])]
    more[0] = draw.choice([str(len(rows) + draw.randint(0, 3)), "0", "-1", "2.5", "1e300"])
    rows.insert(draw.randint(1, len(rows)), more)
    return "must be a whole number from 1 to"


def renamed(rows: Rows, draw: random.Random) -> str:
    """Give a column another name."""
    i = draw.randrange(len(rows[0]))
    rows[0][i] = draw.choice(["width", "drawn", rows[0][i].upper(), rows[0][i] + "s"])
    return "unknown"


@pytest.mark.parametrize("change", [resized, removed, doubled, added, renamed])
@pytest.mark.parametrize("file", [NOTCH_FORM, CREST_FORM])
def test_a_form_that_is_not_as_drawn_is_refused(
    file: str, change: Callable[[Rows, random.Random], str], tmp_path: Path
) -> None:
    draw = random.Random(11)
    for _ in range(20):
        fill(tmp_path)
        rows = [line.split(",") for line in (tmp_path / file).read_text().splitlines()]
        words = change(rows, draw)
        (tmp_path / file).write_text("\n".join(",".join(row) for row in rows))
        with pytest.raises(InputError) as refused:
            read_coupon("sla", tmp_path)
        assert str(refused.value).startswith(str(tmp_path / file))
        assert words in str(refused.value)
        assert refused.value.remedy


@pytest.mark.parametrize("file", [NOTCH_FORM, CREST_FORM])
def test_rows_may_come_in_any_order(file: str, tmp_path: Path) -> None:
    fill(tmp_path)
    before = read_coupon("sla", tmp_path)
    header, *rows = (tmp_path / file).read_text().splitlines()
    random.Random(5).shuffle(rows)
    (tmp_path / file).write_text("\n".join([header, *rows]))
    assert read_coupon("sla", tmp_path).keys == before.keys


def test_forms_of_a_coupon_are_as_drawn(tmp_path: Path) -> None:
    """Of every process that ships: its forms, filled in as drawn, read back."""
    for name in processes():
        for file, text in coupon_forms(coupon(name)).items():
            lines = [line.split(",") for line in text.splitlines() if not line.startswith("#")]
            if file in (NOTCH_FORM, CREST_FORM):
                measured = [[*row[:2], row[1], f"{float(row[1]) + 0.01:.2f}"] for row in lines[1:]]
                filled = [",".join(row[: len(lines[0])]) for row in (lines[0], *measured)]
                (tmp_path / file).write_text("\n".join(filled))
        read_coupon(name, tmp_path)
        (tmp_path / NOTCH_FORM).unlink(missing_ok=True)


def test_a_ladder_of_a_process_that_cuts_none_is_refused(tmp_path: Path) -> None:
    fill(tmp_path)
    with pytest.raises(InputError, match=r"notches\.csv: must not be there: the tool of 'cnc'"):
        read_coupon("cnc", tmp_path)


def as_grown(growth: float, seed: int) -> NotchForm:
    """What blades say of the ladder's own outline, grown all round, each notch halfway down, where each of a
    print's edges wavers by 3 um and each blade is off by 2."""
    rng = np.random.default_rng(seed)
    (part,) = (part for part in coupon("sla").parts if part.name == "notch-ladder")
    assert isinstance(part.body, Prism)
    grown = shapely.Polygon(polygon(part.body.outline, 1e-3)).buffer(growth, join_style="mitre")
    left, _, right, _ = grown.bounds
    line = shapely.LineString([(left, -NOTCH_DEPTH / 2), (right, -NOTCH_DEPTH / 2)])
    teeth = sorted((tooth.bounds[0], tooth.bounds[2]) for tooth in shapely.intersection(line, grown).geoms)
    middles = (np.arange(len(NOTCHES)) - (len(NOTCHES) - 1) / 2) * NOTCH_PITCH
    gaps = [(a[1], b[0]) for a, b in pairwise(teeth)]
    wide = [next((high - low for low, high in gaps if low < x < high), 0.0) for x in middles]
    edges = rng.normal(0, 0.003, (2, len(NOTCHES))).sum(axis=0)
    return by_blades(np.array(NOTCHES), np.array(wide) + edges, BLADES + rng.normal(0, 0.002, BLADES.size))


@pytest.mark.parametrize("seed", range(5))
def test_growth_injected_into_the_part_itself_is_recovered_from_its_forms(seed: int, tmp_path: Path) -> None:
    """From the plan's outline, grown by another library, to the number in printer.toml, within 5 um."""
    rows = [
        [str(i), *(f"{v:.2f}" for v in row)]
        for i, row in enumerate(zip(*as_grown(0.03, seed), strict=True), 1)
    ]
    (tmp_path / NOTCH_FORM).write_text(form(NOTCH_COLUMNS, rows))
    table = tomllib.loads(read_coupon("sla", tmp_path).to_toml())
    assert table["sla"]["growth"] == pytest.approx(0.03, abs=0.005)
