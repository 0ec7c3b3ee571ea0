"""Parts list, orders and drawings: each part once, no quantity with two values, by the rules of the trades.

What is bought for the bench is held against the sheet in test_sheet.py; whole papers are in tests/golden.
"""

from __future__ import annotations

import ast
import csv
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import skincad
from bench.campaign.random_designs import drawn
from skincad.base import InputError
from skincad.fabrication import (
    Job,
    casting_sheet,
    design_findings,
    extent,
    parts_csv,
    pours,
    print_plates,
    seal_pattern,
)
from skincad.fabrication.assembly_drawing import assembly_drawing
from skincad.fabrication.day_plan import day_plan
from skincad.fabrication.fasteners import dowels, limits, pin_length, thread_words
from skincad.fabrication.orders import orders
from skincad.fabrication.part_drawing import notes, surface_words, what_matters
from skincad.fabrication.patterns import pattern_words
from skincad.fabrication.pouring import filling
from skincad.fabrication.rules import slit_play
from skincad.inputs import processes
from skincad.outputs import names
from skincad.solids import THUMB, CutRole, Part, PartRole, bores
from skincad.solids.mold import mold
from tests.conftest import Made
from tests.designs import SHIPPED, of_one_printer, three_ridges

SHEET_GOODS = {"film strip", "shim", "seal", "board"}
SEEDS = range(7000, 7060)  # used by no other test
MOST_PRESS = 1.0  # mm, of a pin
Row = dict[str, str]


@cache
def job_of(name: str) -> Job:
    """A template's job; of small ones three ridges show as much as nine."""
    few = ["ridge.count=3"] if name in ("yamada-2002", "plain-ridges", "cast-in") else []
    return Job(three_ridges() if name == "bent" else skincad.load(name, few))


@cache
def listed(job: Job) -> list[Row]:
    """The parts list as a workshop's own program reads it."""
    return list(csv.DictReader(parts_csv(job).splitlines()))


@cache
def ordered(job: Job) -> dict[str, str]:
    return {file: order([], None) for file, order in orders(job).items()}


def made_parts(job: Job) -> list[Part]:
    return [part for part in job.closed.parts if part.made == "made"]


@pytest.mark.parametrize("name", SHIPPED)
def test_every_part_and_every_bought_piece_is_there(name: str) -> None:
    design, closed, rows = job_of(name).design, job_of(name).closed, listed(job_of(name))
    assert all(row["design"].startswith(design.name) for row in rows)
    assert all(f", revision {design.revision}" in row["design"] for row in rows)
    assert [row["item"] for row in rows] == [str(number) for number in range(1, len(rows) + 1)]
    rows_made = [row for row in rows if row["made_by"] != "bought"]
    assert [row["what"] for row in rows_made] == [part.name for part in made_parts(job_of(name))]
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


@pytest.mark.parametrize("name", SHIPPED)
def test_each_part_is_ordered_once_from_its_maker_with_what_matters_on_it(name: str) -> None:
    job = job_of(name)
    written, items = ordered(job), {row["what"]: row for row in listed(job)}
    for part in made_parts(job):
        (file,) = (file for file, text in written.items() if f"| {part.name} |" in text)
        assert file == f"orders/order-{job.maker(part)}.md"
        row = f"| {part.name} | {job.process(part).material} | {items[part.name]['designation']} |"
        assert row in written[file]
        assert all(f"- {line}" in written[file].splitlines() for line in what_matters(job, part, None))
    if job.design.slot:
        sheet = written["orders/order-sheet.md"]
        for what in SHEET_GOODS & {*items}:
            assert f"| {items[what]['quantity']} | {what} |" in sheet
            assert items[what]["tolerance"] in sheet


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("solids", [True, False])
def test_every_file_of_an_order_is_made(name: str, solids: bool) -> None:
    made = set(names(job_of(name).design, solids, preview=not solids))
    texts = ordered(job_of(name))
    if not solids:
        texts = {file: order([], None) for file, order in orders(job_of(name), solids).items()}
    for file, text in texts.items():
        assert file in made
        named = re.findall(r"\b(?:solids|drawings|film)/[\w.-]+\w", text)
        assert named
        assert set(named) <= made


def test_filament_and_end_plates_are_ordered_with_settings_and_face() -> None:
    """Of nozzle-04; a resin printer's order is in tests/golden."""
    texts = ordered(job_of("nozzle-04"))
    assert "3 walls, 4 solid layers under tops and over bottoms, 100 % infill" in texts["orders/order-fdm.md"]
    assert "- On the plate: the outer face of end-a-comb, end-a-keeper." in texts["orders/order-sla.md"]


def test_names_that_people_write_stay_text() -> None:
    design = skincad.load("plain-ridges", ["printer.sla.material='<i>|x'"])
    text = ordered(Job(design))["orders/order-sla.md"]
    assert "<i>" not in text
    assert r"\|x" in text
    assert all(row.count("|") - row.count(r"\|") == 6 for row in text.splitlines() if row.startswith("| 1 "))


@pytest.mark.slow
def test_every_file_that_a_paper_names_is_there(made: Made) -> None:
    """In the folder of yamada-2002: sheet, parts list, orders."""
    there = {name for name, _ in made.written.files}
    papers = [p for p in there if p.endswith((".md", ".csv"))]
    assert len(papers) == 4
    for paper in papers:
        text = Path(made.folder / paper).read_text("utf-8")
        named = re.findall(r"[\w/-]+\.(?:step|stl|3mf|dxf|svg|pdf|kicad_mod|html|csv)\b", text)
        assert set(named) - {"crests.csv"} <= there, paper  # which the inspector fills in


def numbers(pattern: str, text: str) -> list[tuple[float, ...]]:
    return [tuple(map(float, match.groups())) for match in re.finditer(pattern, text)]


def disagreements(job: Job) -> Iterator[str]:
    """What two papers say differently of one thing."""
    sheet = casting_sheet(job, [], "", True)
    rows, texts = listed(job), ordered(job)
    items: dict[str, list[Row]] = {}
    for row in rows:
        items.setdefault(row["what"], []).append(row)
    # screws and studs: how many and how long
    said = Counter(numbers(r"\b(\d+) M3 x (\d+)\b", sheet))
    screws = [*items.get("screw", []), *items.get("stud", [])]
    bought = Counter((float(s["quantity"]), float(s["designation"].rsplit(" ", 1)[1])) for s in screws)
    if said != bought:
        yield f"screws: sheet {said}, parts list {bought}"
    # dowels: the sheet's room, the parts list's standard length in it
    rooms = sorted((size, count) for size, count in dowels(job.closed).items())
    pins = [(i["quantity"], i["designation"]) for i in items.get("dowel pin", [])]
    if pins != [(str(count), f"ISO 8734 2 x {pin_length(size):g}") for size, count in rooms]:
        yield f"dowels: {rooms}, {pins}"
    if not all(f"{count} x {pin_length(size):g} mm" in sheet for size, count in rooms):
        yield "dowels on the sheet"
    for part in made_parts(job):
        yield from _of_part(
            job, part, items[part.name][0], sheet, texts[f"orders/order-{job.maker(part)}.md"]
        )
    yield from _of_goods(job, items, sheet)
    # balloons are rows
    (table,) = assembly_drawing(job).tables
    columns = ("item", "quantity", "what", "designation", "material")
    balloons = [tuple(row[column] for column in columns) for row in rows]
    yield from (f"assembly: {row}" for row in table.rows if row not in balloons)


def _of_goods(job: Job, items: dict[str, list[Row]], sheet: str) -> Iterator[str]:
    # silicone: what is mixed, by portions and together
    (silicone,) = items["silicone"]
    (total, *_), *_ = numbers(r"([\d.]+) g(?:, into one cup| by its data sheet)", sheet) or [(0.0,)]
    (poured,) = pours(job)
    mixed, quantity = poured.batch, silicone["quantity"]
    if abs(float(quantity) - mixed) > 5e-4 * mixed or abs(total - mixed) > 5e-3:
        yield f"silicone: {quantity}, {total}, {mixed}"
    # shims: size, number, length
    for shim in items.get("shim", []):
        thick, deep, long = shim["designation"].split(" x ")
        if f"{shim['quantity']} shims of spring steel, {thick} x {deep} mm, {long} mm long" not in sheet:
            yield f"shims: {shim}"
        if not any(f"spring steel {thick} thick" in note for note in pattern_words("shims", job=job)):
            yield f"shims on their pattern: {shim}"
    # the seal's sheet
    for seal in items.get("seal", []):
        (thick,) = numbers(r"sheet of ([\d.]+)", seal["designation"])
        others = (
            numbers(r"a sheet of ([\d.]+) mm", sheet),
            numbers(r"sheet of ([\d.]+) mm", seal_pattern(job.closed)[1][0]),
        )
        if others != ([thick], [thick]):
            yield f"seal: {thick}, {others}"


def _of_part(job: Job, part: Part, item: Row, sheet: str, order: str) -> Iterator[str]:
    size = " x ".join(f"{side:.2f}" for side in extent(part))
    volume, process = part.volume / 1000, job.process(part)
    (cm3,) = numbers(rf"\| {re.escape(part.name)} \| [^|]+ \| ([\d.]+) \|", sheet)[0]
    if item["designation"] != size or abs(float(item["volume_cm3"]) - volume) > 1e-3 * volume:
        yield f"{part.name}: {item}"
    if abs(cm3 - volume) > 1e-4 * volume:
        yield f"{part.name} on the sheet: {cm3}"
    if f"| {part.name} | {item['material']} | {size} |" not in order:
        yield f"{part.name} in its order"
    general = f"±{process.tolerance:g} (by {job.maker(part)})" if process.layer else "ISO 2768-m"
    if item["tolerance"] != general or general not in order:
        yield f"{part.name}: tolerance {item['tolerance']}"
    # one wire in words and in the DXF
    wires = set(
        numbers(
            r"[Ww]ire Ø([\d.]+)",
            " ".join([*notes(job, part), *pattern_words("cut", process=job.process(part))]),
        )
    )
    if len(wires) > 1:
        yield f"{part.name}: wires {wires}"
    gate = {2 * bore.radius for bore in bores(part, CutRole.GATE)}
    if gate and gate != {job.gate}:
        yield f"gate: {gate}, {job.gate}"


def rules_of_parts(job: Job) -> Iterator[str]:
    """Which rule of a shop a design's drawings break."""
    for part in made_parts(job):
        for role in {cut.role for cut in part.cuts if cut.role}:
            for bore in bores(part, role):
                words = thread_words(job, part, role, bore.length)
                tapped = words.startswith("M") and "insert" not in words
                if tapped and not re.search(r"-6H x [\d.]+ / Ø", words):
                    yield f"{part.name}: {words}"
                if "P7" in limits(job, part, role) and bore.radius >= MOST_PRESS:
                    yield f"{part.name}: a press fit of {bore.radius}"
        if not what_matters(job, part, None)[0].startswith("Accurate, ±"):
            yield f"{part.name}: nothing accurate"
        if not job.process(part).material:
            yield f"{part.name}: no material"


def rules(job: Job) -> Iterator[str]:
    """Which rule of the bench a design's papers break."""
    errors = {finding.rule for finding in design_findings(job) if finding.severity == "error"}
    for comb in job.closed.of(PartRole.COMB):
        process = job.process(comb)
        loose = slit_play(job, process) < process.tolerance - 1e-9
        if process.layer and loose and not errors & {"slit fit", "notch", "gap", "build volume"}:
            yield f"{comb.name}: a comb that {process.tolerance} does not hold passes"
    if filling(job).force > THUMB + 1e-9:
        yield f"thumb: {filling(job).force}"
    printed = [part.name for part in made_parts(job) if job.process(part).layer]
    if sorted(spot.name for plate in print_plates(job) for spot in plate.spots) != sorted(printed):
        yield "plates"
    if not all(9.0 <= entry.hour <= 17.0 for entry in day_plan(job)):
        yield "day plan"
    for item in listed(job):
        if not item["unit"] or not float(item["quantity"]) > 0:
            yield f"{item['what']}: no amount"
        if item["what"] == "screw" and float(item["designation"].rsplit(" ", 1)[1]) > 30:
            yield f"no such screw: {item['designation']}"


def assert_papers_agree(job: Job) -> None:
    assert [*disagreements(job), *rules_of_parts(job), *rules(job)] == []


@pytest.mark.parametrize("name", [*SHIPPED, "bent"])
def test_papers_agree_and_keep_the_rules(name: str) -> None:
    assert_papers_agree(job_of(name))


@pytest.mark.evidence(subject="seeds: papers")
@pytest.mark.parametrize("seed", SEEDS)
def test_papers_of_random_designs_agree_and_keep_the_rules(seed: int) -> None:
    design = drawn(seed).design
    try:
        mold(design)
    except InputError:
        pytest.skip("it has no mold, and says why")
    assert_papers_agree(Job(design))


def test_nothing_is_cut_of_a_print_or_with_no_room_for_a_wire() -> None:
    printed, narrow = of_one_printer("lab-bench"), skincad.load("yamada-2002", ["ridge.tip_fillet=0.01"])
    for design, part in ((printed, "end-a-comb"), (narrow, "cavity")):
        assert not any("trim cuts" in row for row in notes(Job(design), mold(design).part(part)))


def test_slits_and_seat_are_told_as_they_come_out() -> None:
    """Growth of 0.002 on a comb's walls, and on both parts that slide: 0.005 and mold.clearance less that."""
    design = skincad.load("yamada-2002")
    grown = design.with_(printer={"edm": {"growth": 0.002}})
    comb, carrier = mold(grown).part("end-a-comb"), mold(grown).part("carrier")
    assert any("Slits: 0.003 a side" in row for row in what_matters(Job(grown), comb, None))
    assert any(
        "(0.005 as drawn, less growth and coat)" in row for row in what_matters(Job(grown), comb, None)
    )
    left = f"Length and width: {design.mold.clearance - 0.004:.4g} a side to its seat"
    assert any(row.startswith(left) for row in what_matters(Job(grown), carrier, None))
    assert not any("as drawn" in row for row in what_matters(Job(design), comb, None))
    tight = design.with_(printer={"edm": {"growth": 0.003}})  # leaves 0.002, and ± 0.003 is the process
    assert any("does not keep that gap" in row for row in what_matters(Job(tight), comb, None))


@pytest.mark.parametrize("name", ["fdm", "sla", "cnc", "edm"])
def test_each_process_says_how_rough_its_faces_are(name: str) -> None:
    design = skincad.load("plain-ridges", [f"mold.process={name}"])
    part = mold(design).part("cavity")
    rough = processes()[name].roughness
    assert rough > 0
    cut = not processes()[name].layer  # the general one; faces on the silicone have the process's own
    assert surface_words(Job(design), part) == ("Ra 1.6" if cut else f"Ra {rough:g}")
    accurate = what_matters(Job(design), part, None)[0]
    assert (f", Ra {rough:g}: seat, trough, grooves" in accurate) == cut
    unsaid = design.with_(printer={name: {"roughness": 0.0}})
    assert surface_words(Job(unsaid), part) == ""


TRADE = ("fabrication/day_plan", "fabrication/electrodes", "fabrication/fasteners")
TRADE += ("fabrication/pouring", "fabrication/printing", "fabrication/parts_list", "fabrication/strips")
TRADE += ("solids/ends", "solids/fasteners", "solids/gate", "solids/inserts", "solids/layout", "solids/lids")
OF_NATURE = {"GRAVITY", "SCREW", "METRIC"}  # METRIC's class says its standards, column by column


@pytest.mark.parametrize("module", TRADE)
def test_every_number_of_a_trade_has_its_source_or_says_that_it_is_an_assumption(module: str) -> None:
    text = (Path(skincad.__file__).parent / f"{module}.py").read_text("utf-8")
    rows = text.split("\n")
    for node in ast.parse(text).body:
        if not isinstance(node, ast.Assign) or not any(
            isinstance(c, ast.Constant) and isinstance(c.value, int | float) for c in ast.walk(node.value)
        ):
            continue
        names = {n.id for n in ast.walk(node.targets[0]) if isinstance(n, ast.Name)}
        said = "\n".join(rows[max(0, node.lineno - 4) : node.end_lineno])
        if not names & OF_NATURE:
            assert re.search(r"assumption|source|ISO|DIN|rounding|by finite elements", said), names
