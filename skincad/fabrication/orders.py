"""Orders: what a workshop needs to quote and make the parts of one process, and what is cut from sheet."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from skincad.base.reading import markdown_text
from skincad.base.version import __version__
from skincad.fabrication.fasteners import PINNED, THREADED, is_pressed
from skincad.fabrication.job import Job
from skincad.fabrication.papers import paper
from skincad.fabrication.part_drawing import (
    Drops,
    general_tolerance,
    process_words,
    surface_words,
    what_matters,
)
from skincad.fabrication.parts_list import Item, parts_list
from skincad.fabrication.printing import face_down, print_plates, print_settings, supported
from skincad.fabrication.rules import Finding
from skincad.inputs.catalog import display_name
from skincad.inputs.process import Process
from skincad.solids.plan import CutRole, Part

SHEET_GOODS = {  # what is cut by a pattern: the file of each
    "film strip": "film/strips.dxf",
    "shim": "film/shims.dxf",
    "seal": "drawings/seal.dxf",
    "board": "film/strip-board.kicad_mod",
}


OrderRow = tuple[Item, list[str], list[str]]  # a part, its files, and what matters on it
Order = Callable[[list[Finding], Drops], str]


def orders(job: Job, solids: bool = True) -> dict[str, Order]:
    """Return the writer of each order by its file's name, known before any work: one for each process, and
    one for what is cut from film and sheet. `solids`: whether there are STEP files and drawings."""
    makers = dict.fromkeys(job.maker(part) for part in job.closed.made)

    def of_process(name: str) -> Order:
        return lambda findings, drops: _process_order(job, name, findings, drops, solids)

    found: dict[str, Order] = {f"orders/order-{name}.md": of_process(name) for name in makers}
    if any(item.what in SHEET_GOODS for item in parts_list(job)):
        found["orders/order-sheet.md"] = lambda _, __: _sheet_order(job)
    return found


def _process_order(job: Job, name: str, findings: list[Finding], drops: Drops, solids: bool) -> str:
    process, closed = job.processes[name], job.closed
    parts = [part for part in closed.made if job.maker(part) == name]
    items = {item.what: item for item in parts_list(job)}
    return _order(
        job,
        title=process_words(job, parts[0]),
        settings=print_settings(process, supported(name, findings)) if process.layer else "",
        process=process,
        rows=[_row(job, part, items[part.name], drops, solids) for part in parts],
        general=_general(job, parts, process),
    )


def _row(job: Job, part: Part, item: Item, drops: Drops, solids: bool) -> OrderRow:
    if job.process(part).layer:
        plates = [p.file for p in print_plates(job) if part.name in {spot.name for spot in p.spots}]
        files = [*plates, f"solids/{part.name}.stl"]
    else:
        files = [f"solids/{part.name}.step"] if solids else [f"solids/{part.name}.stl"]
    drawings = [f"drawings/{part.name}.{kind}" for kind in ("pdf", "dxf")] if solids else []
    item = item._replace(material=markdown_text(item.material))
    return item, [*files, *drawings], what_matters(job, part, drops)


def _general(job: Job, parts: list[Part], process: Process) -> dict[str, Any]:
    """What holds for all parts of an order; of prints, which lie on the plate by which of their faces."""
    down: dict[str, list[str]] = {}
    for part in parts if process.layer else ():
        down.setdefault(face_down(job, part), []).append(part.name)
    roles = {(part, cut.role) for part in parts for cut in part.cuts if cut.role}
    pressed = any(role in PINNED and is_pressed(part, role) for part, role in roles)
    cored = any(role is CutRole.CORE for _, role in roles)
    return {
        "tolerance": general_tolerance(job, parts[0]),
        "surface": surface_words(job, parts[0]),
        "down": down,
        "tapped": process.thread == "tapped" and any(role in THREADED for _, role in roles),
        "pressed": pressed,
        "reamed": ["dowels"] * pressed + ["core pins"] * cored if process.layer else [],
    }


def _sheet_order(job: Job) -> str:
    """What is cut from film, steel and foam, and the board."""
    rows = [
        (item, [SHEET_GOODS[item.what]], [text for text in (item.tolerance, item.condition) if text])
        for item in parts_list(job)
        if item.what in SHEET_GOODS
    ]
    return _order(job, title="film, sheet and board", rows=rows)


def _order(
    job: Job,
    title: str,
    rows: list[OrderRow],
    settings: str = "",
    process: Process | None = None,
    general: dict[str, Any] | None = None,
) -> str:
    alike: dict[tuple[str, ...], list[str]] = {}
    for item, _, matters in rows:
        alike.setdefault(tuple(matters), []).append(item.what)
    return paper(
        "order.md",
        title=title,
        design=markdown_text(display_name(job.design)),
        revision=job.design.revision,
        version=__version__,
        settings=settings,
        process=process,
        rows=rows,
        general=general,
        matters=[(names, lines) for lines, names in alike.items() if lines],
    )
