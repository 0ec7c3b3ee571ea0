"""Orders: each made part once, by its own maker, with files that are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import skincad
from skincad.fabrication import Job
from skincad.fabrication.orders import SHEET_GOODS, orders
from skincad.fabrication.part_drawing import what_matters
from skincad.fabrication.parts_list import parts_list
from skincad.outputs import makes
from tests.conftest import Made
from tests.templates import SHIPPED


def texts(name: str) -> dict[str, str]:
    return {file: order([], None) for file, order in orders(Job(skincad.load(name))).items()}


@pytest.mark.parametrize("name", SHIPPED)
def test_each_part_is_ordered_once_from_its_maker_with_what_matters_on_it(name: str) -> None:
    job = Job(skincad.load(name))
    written, items = texts(name), {item.what: item for item in parts_list(job)}
    for part in job.closed.parts:
        if part.made != "made":
            continue
        (file,) = (file for file, text in written.items() if f"| {part.name} |" in text)
        assert file == f"orders/order-{job.maker(part)}.md"
        row = f"| {part.name} | {job.process(part).material} | {items[part.name].designation} |"
        assert row in written[file]
        assert all(f"- {line}" in written[file].splitlines() for line in what_matters(job, part, None))
    if job.design.slot:
        sheet = written["orders/order-sheet.md"]
        for what in {*SHEET_GOODS} & {*items}:
            assert f"| {items[what].quantity} | {what} |" in sheet
            assert items[what].tolerance in sheet


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("solids", [True, False])
def test_every_file_of_an_order_is_made(name: str, solids: bool) -> None:
    design = skincad.load(name)
    made = set(makes.names(design, solids, preview=not solids))
    for file, order in orders(Job(design), solids).items():
        assert file in made
        named = re.findall(r"\b(?:solids|drawings|film)/[\w.-]+\w", order([], None))
        assert named
        assert set(named) <= made


def test_prints_are_ordered_with_settings_bed_and_face() -> None:
    text = texts("lab-bench")["orders/order-sla.md"]
    assert "layers of 0.05 mm, 2.5 s each, the first 3 30 s, fading over 10; solid, no pad" in text
    assert "a bed of 120 x 68 mm, 150 mm high" in text
    assert "- On the plate: the lower face of cavity, carrier, cover." in text
    filament = texts("nozzle-04")["orders/order-fdm.md"]
    assert "3 walls, 4 solid layers under tops and over bottoms, 100 % infill" in filament
    resin = texts("nozzle-04")["orders/order-sla.md"]
    assert "- On the plate: the outer face of end-a-comb, end-a-keeper." in resin


def test_names_that_people_write_stay_text() -> None:
    design = skincad.load("plain-ridges", ["printer.sla.material='<i>|x'"])
    text = orders(Job(design))["orders/order-sla.md"]([], None)
    assert "<i>" not in text
    assert r"\|x" in text
    assert all(row.count("|") - row.count(r"\|") == 6 for row in text.splitlines() if row.startswith("| 1 "))


def test_every_file_that_a_paper_names_is_there(made: Made) -> None:
    """In the folder of yamada-2002: sheet, parts list, orders."""
    there = {name for name, _ in made.written.files}
    papers = [p for p in there if p.endswith((".md", ".csv"))]
    assert len(papers) == 4
    for paper in papers:
        text = Path(made.folder / paper).read_text("utf-8")
        named = re.findall(r"[\w/-]+\.(?:step|stl|3mf|dxf|svg|pdf|kicad_mod|html|csv)\b", text)
        assert set(named) - {"crests.csv"} <= there, paper  # which the inspector fills in
