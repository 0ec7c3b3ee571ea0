"""No quantity stands in two papers with two values: sheet, parts list, orders, drawings, patterns.

What is bought for the bench is held against the sheet in test_bond_steps.py, and files in test_orders.py.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import skincad
from bench.campaign.random_designs import drawn
from skincad.base import InputError
from skincad.fabrication import Job, casting_sheet, extent, pours, print_plates, seal_pattern, shim_notes
from skincad.fabrication.assembly_drawing import assembly_drawing
from skincad.fabrication.day_plan import BEGIN, END, day_plan
from skincad.fabrication.fasteners import dowels, limits, pin_length, thread_words
from skincad.fabrication.findings import process_findings
from skincad.fabrication.orders import orders
from skincad.fabrication.part_drawing import general_tolerance, notes, what_matters
from skincad.fabrication.parts_list import Item, parts_list
from skincad.fabrication.patterns import cut_words
from skincad.fabrication.pouring import filling
from skincad.fabrication.rules import slit_play
from skincad.inputs import Design
from skincad.solids import THUMB, CutRole, Part, PartRole, bores
from skincad.solids.mold import mold
from tests.bent_skin import three_ridges
from tests.templates import SHIPPED

SEEDS = range(7000, 7060)  # used by no other test
MOST_PRESS = 1.0  # mm, of a pin


def designs() -> list[Any]:
    shipped = (pytest.param(skincad.load(str(one.values[0])), marks=one.marks) for one in SHIPPED)
    return [*shipped, pytest.param(three_ridges())]


def numbers(pattern: str, text: str) -> list[tuple[float, ...]]:
    found = (match.groups() for match in re.finditer(pattern, text))
    return [tuple(float(group) for group in groups) for groups in found]


def made(job: Job) -> list[Part]:
    return [part for part in job.closed.parts if part.made == "made"]


def disagreements(job: Job) -> Iterator[str]:
    """What two papers say differently of one thing."""
    sheet = casting_sheet(job, [], "", True)
    rows = list(enumerate(parts_list(job), 1))
    items: dict[str, list[Item]] = {}
    for _, item in rows:
        items.setdefault(item.what, []).append(item)
    ordered = {name: order([], None) for name, order in orders(job).items()}

    # screws and studs: how many and how long
    said = Counter(numbers(r"\b(\d+) M3 x (\d+)\b", sheet))
    listed = [*items.get("screw", []), *items.get("stud", [])]
    bought = Counter((float(i.quantity), float(i.designation.rsplit(" ", 1)[1])) for i in listed)
    if said != bought:
        yield f"screws: sheet {said}, parts list {bought}"
    # dowels: the sheet's room, the parts list's standard length in it
    rooms = sorted((size, count) for size, count in dowels(job.closed).items())
    pins = [(i.quantity, i.designation) for i in items.get("dowel pin", [])]
    if pins != [(str(count), f"ISO 8734 2 x {pin_length(size):g}") for size, count in rooms]:
        yield f"dowels: {rooms}, {pins}"
    if not all(f"{count} of at most {size:g} mm" in sheet for size, count in rooms):
        yield "dowels on the sheet"
    for part in made(job):
        yield from _of_part(job, part, items[part.name][0], sheet, ordered)
    yield from _of_goods(job, items, sheet)
    # balloons are rows
    (table,) = assembly_drawing(job).tables
    by_number = {str(number): item for number, item in rows}
    for number, quantity, what, size, material in table.rows:
        item = by_number[number]
        if (quantity, what, size, material) != (item.quantity, item.what, item.designation, item.material):
            yield f"assembly, row {number}"


def _of_goods(job: Job, items: dict[str, list[Item]], sheet: str) -> Iterator[str]:
    # silicone: what is mixed, by portions and together
    (silicone,) = items["silicone"]
    (total, *_), *_ = numbers(r"([\d.]+) g(?:, into one cup| by its data sheet)", sheet) or [(0.0,)]
    (poured,) = pours(job)
    mixed = poured.batch
    if abs(float(silicone.quantity) - mixed) > 5e-4 * mixed or abs(total - mixed) > 5e-3:
        yield f"silicone: {silicone.quantity}, {total}, {mixed}"
    # shims: size, number, length
    for shim in items.get("shim", []):
        thick, deep, long = shim.designation.split(" x ")
        if f"{shim.quantity} shims of spring steel, {thick} x {deep} mm, {long} mm long" not in sheet:
            yield f"shims: {shim.designation}"
        if not any(f"spring steel {thick} thick" in note for note in shim_notes(job)):
            yield f"shims on their pattern: {shim.designation}"
    # the seal's sheet
    for seal in items.get("seal", []):
        (thick,) = numbers(r"sheet of ([\d.]+)", seal.designation)
        others = (
            numbers(r"a sheet of ([\d.]+) mm", sheet),
            numbers(r"sheet of ([\d.]+) mm", seal_pattern(job.closed).notes[0]),
        )
        if others != ([thick], [thick]):
            yield f"seal: {thick}, {others}"


def _of_part(job: Job, part: Part, item: Item, sheet: str, ordered: dict[str, str]) -> Iterator[str]:
    size = " x ".join(f"{side:.2f}" for side in extent(part))
    volume, name = part.volume / 1000, re.escape(part.name)
    (cm3,) = numbers(rf"\| {name} \| [^|]+ \| ([\d.]+) \|", sheet)[0]
    if item.designation != size or abs(float(item.volume) - volume) > 1e-3 * volume:
        yield f"{part.name}: {item.designation}, {item.volume}"
    if abs(cm3 - volume) > 1e-4 * volume:
        yield f"{part.name} on the sheet: {cm3}"
    order = ordered[f"orders/order-{job.maker(part)}.md"]
    if f"| {part.name} | {item.material} | {size} |" not in order:
        yield f"{part.name} in its order"
    if item.tolerance != general_tolerance(job, part) or item.tolerance not in order:
        yield f"{part.name}: tolerance {item.tolerance}"
    # one wire in words and in the DXF
    wires = set(numbers(r"[Ww]ire Ø([\d.]+)", " ".join([*notes(job, part), cut_words(job, part)])))
    if len(wires) > 1:
        yield f"{part.name}: wires {wires}"
    gate = {2 * bore.radius for bore in bores(part, CutRole.GATE)}
    if gate and gate != {job.gate}:
        yield f"gate: {gate}, {job.gate}"


@pytest.mark.parametrize("design", designs(), ids=lambda design: design.name)
def test_no_quantity_has_two_values(design: Design) -> None:
    assert list(disagreements(Job(design))) == []


def rules_of_parts(job: Job) -> Iterator[str]:
    """Which rule of a shop a design's drawings break."""
    for part in made(job):
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
    for comb in job.closed.of(PartRole.COMB):
        process = job.process(comb)
        told = {f.rule for f in process_findings(job) if f.severity == "error"}
        loose = slit_play(job, process) < process.tolerance - 1e-9
        if process.layer and loose and not told & {"slit fit", "notch", "gap", "build volume"}:
            yield f"{comb.name}: a comb that {process.tolerance} does not hold passes"
    if filling(job).force > THUMB + 1e-9:
        yield f"thumb: {filling(job).force}"
    printed = [part.name for part in made(job) if job.process(part).layer]
    if sorted(spot.name for plate in print_plates(job) for spot in plate.spots) != sorted(printed):
        yield "plates"
    if not all(BEGIN <= entry.hour <= END for entry in day_plan(job)):
        yield "day plan"
    for item in parts_list(job):
        if not item.unit or not float(item.quantity) > 0:
            yield f"{item.what}: no amount"
        if item.what == "screw" and float(item.designation.rsplit(" ", 1)[1]) > 30:
            yield f"no such screw: {item.designation}"


@pytest.mark.parametrize("design", designs(), ids=lambda design: design.name)
def test_papers_keep_the_rules_of_the_trades(design: Design) -> None:
    job = Job(design)
    assert [*rules_of_parts(job), *rules(job)] == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_papers_of_random_designs_agree_and_keep_the_rules(seed: int) -> None:
    design = drawn(seed).design
    try:
        mold(design)
    except InputError:
        pytest.skip("it has no mold, and says why")
    job = Job(design)
    assert [*disagreements(job), *rules_of_parts(job), *rules(job)] == []


TRADE = ("fabrication/day_plan", "fabrication/electrodes", "fabrication/facts", "fabrication/fasteners")
TRADE += ("fabrication/pouring", "fabrication/printing", "fabrication/shopping", "fabrication/strips")
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
