"""Output of `make`: words, and a writer for each file, whose names are known before any work."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, cast

from skincad.base.errors import InputError
from skincad.base.outfolder import listed, manifest_name
from skincad.base.result import Writer
from skincad.fabrication.assembly_drawing import assembly_drawing
from skincad.fabrication.crests import limits_decide
from skincad.fabrication.inspection import inspection
from skincad.fabrication.job import Job
from skincad.fabrication.making import Build, MakeResult, passes
from skincad.fabrication.orders import Order, orders
from skincad.fabrication.part_drawing import Drops, part_drawing
from skincad.fabrication.parts_list import parts_csv
from skincad.fabrication.printing import PrintPlate, print_plates
from skincad.fabrication.rules import Finding, counted
from skincad.fabrication.sheet import casting_sheet
from skincad.inputs.design import Design
from skincad.outputs import checks
from skincad.outputs.delivery import Presentation, text
from skincad.outputs.drawing import flat
from skincad.outputs.drawing.assembly_sheet import assembly_sheet
from skincad.outputs.drawing.formats import sheet_svg, write_sheet_dxf, write_sheet_pdf
from skincad.outputs.drawing.marks import Sheet
from skincad.outputs.drawing.overview import drawing
from skincad.outputs.drawing.part_sheet import part_sheet
from skincad.outputs.figures.canvas import Picture, png
from skincad.outputs.figures.design import design_figure
from skincad.outputs.pages import page
from skincad.outputs.solid_files import (
    source_date,
    write_3mf,
    write_assembly,
    write_step,
    write_stl,
)
from skincad.outputs.view import view_page
from skincad.solids.mold import ClosedMold, mold
from skincad.solids.plan import PartRole

T = TypeVar("T")

COMMAND = "make"
TELLING = ("strip place",)  # notes that decide whether slip can be heard
SHEETS: dict[str, Callable[[Sheet, Path], object]] = {
    "pdf": write_sheet_pdf,
    "svg": lambda sheet, path: path.write_text(sheet_svg(sheet), encoding="utf-8"),
    "dxf": write_sheet_dxf,
}
BuildWriter = Callable[[Build, Path], None]


def _shown_findings(result: MakeResult) -> list[Finding]:
    """All errors, else the first warning, else the notes that say what the skin can't feel: findings come
    with the gravest first."""
    errors = [finding for finding in result.findings if finding.severity == "error"]
    warnings = [finding for finding in result.findings if finding.severity == "warning"][:1]
    return errors or warnings or [finding for finding in result.findings if finding.rule in TELLING]


def _crests_decide_nothing(result: MakeResult) -> bool:
    """Whether no limit on a single crest tells good parts from others, as the casting sheet says too."""
    if result.build is None or result.check is None:
        return False
    return not limits_decide(result.build.job, checks.allowed_drops(result.check))


def names(design: Design, solids: bool = True, preview: bool = False) -> list[str]:
    """Return the names of what will be written, with `solids` those of exact ones too, of a `preview` no
    report; InputError where there is no mold."""
    return list(writers(design, mold(design), solids, preview))


def keep_whole(folder: Path) -> None:
    """Raise InputError for a folder whose files a preview must not replace: those of a make that is none."""
    path = folder / manifest_name(COMMAND)
    if listed(folder, COMMAND) is not None and not json.loads(path.read_text("utf-8")).get("preview", False):
        remedy = f"name another one: -o {folder}-preview"
        raise InputError(
            "folder", f"{folder} holds what a whole make wrote, and a preview keeps that", None, remedy
        )


def manifest(result: MakeResult) -> dict[str, Any]:
    """Return what the manifest says of the result: without times, so that it is the same again."""
    return {
        "name": result.name,
        "preview": result.preview,
        "passed": result.passed,
        "summary": result.summary,
        "all_touch_force_N": result.check and result.check.all_touch_force.as_json(),
        "processes": [estimate.as_json() for estimate in result.estimates],
        "findings": [finding.as_json() for finding in result.findings],
        **({"mount": result.mount.as_json()} if result.mount else {}),
    }


def figures(result: MakeResult) -> dict[str, Callable[[], Picture]]:
    """Return the picture of the skin, its sections, and the mold taken apart."""
    return {"picture.png": partial(_figure, result.built())}


def files(result: MakeResult) -> dict[str, Writer]:
    """Return the writer of each file."""
    build = result.built()
    job_writers = writers(build.design, build.closed, result.solids, result.preview)
    return {name: partial(write, build) for name, write in job_writers.items()}


def writers(
    design: Design, closed: ClosedMold, solids: bool = True, preview: bool = False
) -> dict[str, BuildWriter]:
    """Return the writer of each file by its name, whose suffix is the format; pictures come last."""
    made, job = [part.name for part in closed.made], Job(design, closed)
    rows: dict[str, BuildWriter] = {}
    if solids:
        rows |= {f"solids/{name}.step": partial(_write_solid, name) for name in ("skin", *made)}
        rows["solids/assembly.step"] = lambda build, path: write_assembly(
            build.closed, build.solid, build.design.name, path
        )
        for name in made:
            rows |= _sheet_writers(name, partial(sheet_of, name=name))
    rows |= {f"solids/{name}.stl": partial(_write_stl, name) for name in ("skin", *made)}
    rows["solids/mold.3mf"] = lambda build, path: _write_3mf(build, build.laid, path)
    rows |= {plate.file: partial(_write_plate, plate) for plate in print_plates(job)}
    rows["solids/skin.3mf"] = lambda build, path: _write_3mf(build, {"skin": build.skin}, path)
    rows |= _sheet_writers("assembly", _closed_sheet)
    rows["drawings/section.dxf"] = lambda build, path: flat.write_section_dxf(build.design, path)
    rows["drawings/section.svg"] = _text(lambda build: flat.section_svg(build.design))
    rows["drawings/drawing.svg"] = _text(drawing_svg)
    if design.film:
        rows["film/strips.dxf"] = lambda build, path: flat.write_strips_dxf(build.job, path)
        rows["film/strips.svg"] = _text(lambda build: flat.strips_svg(build.job))
        rows["film/strip-board.kicad_mod"] = _text(lambda build: flat.strip_board(build.job))
    if closed.of(PartRole.SHIM):
        rows["film/shims.dxf"] = lambda build, path: flat.write_shims_dxf(build.job, path)
    if closed.of(PartRole.SEAL):
        rows["drawings/seal.dxf"] = lambda build, path: flat.write_seal_dxf(build.closed, path)
    rows["design.toml"] = _text(lambda build: build.design.to_toml())
    rows["casting-sheet.md"] = _text(sheet_text)
    rows["casting-sheet.html"] = _text(
        lambda build: page(sheet_text(build), drawing_svg(build), f"Casting sheet: {build.design.name}")
    )
    rows["parts-list.csv"] = _text(lambda build: parts_csv(build.job, build.estimates))
    rows |= {name: _text(partial(_order, order)) for name, order in orders(job, solids).items()}
    rows["view.html"] = _text(
        lambda build: view_page(build.job, build.meshes, build.check, checks.verdict_of(build), _png(build))
    )
    if not preview:
        rows["report.html"] = _text(_report)
    return {**rows, "picture.png": _picture}


def _text(of: Callable[[Build], str]) -> BuildWriter:
    return lambda build, path: text(lambda: of(build))(path)


def _sheet_writers(name: str, sheet: Callable[[Build], Sheet]) -> dict[str, BuildWriter]:
    """The files of a sheet, laid out once for all its formats."""

    def drawn(kind: str, build: Build, path: Path) -> None:
        SHEETS[kind](_once(build, f"sheet {name}", lambda: sheet(build)), path)

    return {f"drawings/{name}.{kind}": partial(drawn, kind) for kind in SHEETS}


def _date() -> str:
    return source_date()[:10] if "SOURCE_DATE_EPOCH" in os.environ else ""


def _closed_sheet(build: Build) -> Sheet:
    """The sheet of the closed mold, which needs no exact solid."""
    return assembly_sheet(assembly_drawing(build.job), _date())


def sheet_of(build: Build, name: str) -> Sheet:
    """Return a made part's sheet; its date is SOURCE_DATE_EPOCH's, or left out."""
    part = build.closed.part(name)
    drawn = part_drawing(build.job, part, build.solid(part).val(), _drops(build))
    return part_sheet(drawn, _date())


def _write_solid(name: str, build: Build, path: Path) -> None:
    write_step(build.solid(build.job.skin_part if name == "skin" else build.closed.part(name)), path)


def _write_stl(name: str, build: Build, path: Path) -> None:
    write_stl(build.skin if name == "skin" else build.laid[name], path)


def _write_3mf(build: Build, meshes: Mapping[str, Any], path: Path, placed: bool = False) -> None:
    """Meshes of parts in their colours."""
    colours = {part.name: part.colour for part in (build.job.skin_part, *build.closed.made)}
    write_3mf({name: (mesh, colours[name]) for name, mesh in meshes.items()}, path, placed)


def _write_plate(plate: PrintPlate, build: Build, path: Path) -> None:
    """A plate's parts where they lie on the bed, its corner at the origin."""
    process = build.job.processes[plate.process]
    shapes = {}
    for spot in plate.spots:
        shape = build.laid[spot.name].copy()
        if spot.turned:
            shape.vertices = shape.vertices[:, [1, 0, 2]] * [-1.0, 1.0, 1.0]
        shape.vertices += [spot.x + process.build_x / 2, spot.y + process.build_y / 2, 0.0]
        shapes[spot.name] = shape
    _write_3mf(build, shapes, path, placed=True)


def _order(order: Order, build: Build) -> str:
    return order(list(build.findings), _drops(build))


def _drops(build: Build) -> Drops:
    return checks.allowed_drops(build.check) if build.check else None


def _report(build: Build) -> str:
    from skincad.outputs.report import report

    return report(build, partial(_png, build), sheet_text(build), drawing_svg(build))


def _png(build: Build) -> bytes:
    """The picture, drawn once for all files that show it."""
    return _once(build, "picture", lambda: png(_figure(build)))


def _picture(build: Build, path: Path) -> None:
    path.write_bytes(_png(build))


def _figure(build: Build) -> Picture:
    return design_figure(build.design, build.closed, build.meshes)


def drawing_svg(build: Build) -> str:
    """The drawing, SVG."""
    return _once(build, "drawing", lambda: drawing(build.design, build.closed))


def sheet_text(build: Build) -> str:
    """The casting sheet, Markdown."""

    def sheet() -> str:
        measured = inspection(build.job, *checks.allowance(build.check))
        passed = passes(build.check, build.findings, strict=False)
        findings = list(build.findings)
        return casting_sheet(build.job, findings, checks.verdict_of(build), passed, measured, build.estimates)

    return _once(build, "sheet", sheet)


def _once(build: Build, name: str, of: Callable[[], T]) -> T:
    """What several files need of a build, made for the first of them."""
    if name not in build.cache:
        build.cache[name] = of()
    return cast(T, build.cache[name])


MAKE = Presentation(
    COMMAND=COMMAND,
    words="make.txt",
    facts={
        **checks.CHECK.facts,
        "counted": counted,
        "shown_findings": _shown_findings,
        "crests_decide_nothing": _crests_decide_nothing,
    },
    writers=files,
    figures=figures,
    manifest=manifest,
    replaces=lambda result, folder: keep_whole(folder) if result.preview else None,
)
