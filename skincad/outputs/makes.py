"""Output of `make`: words, and a writer for each file, whose names are known before any work."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, cast

from skincad.base.result import Writer
from skincad.base.version import __version__
from skincad.fabrication.inspection import inspection
from skincad.fabrication.making import Job, MakeResult, passes
from skincad.fabrication.part_drawing import CrestAllowance, part_drawing
from skincad.fabrication.parts_list import parts_csv
from skincad.fabrication.sheet import casting_sheet
from skincad.inputs.design import Design
from skincad.outputs import checks
from skincad.outputs.delivery import text
from skincad.outputs.drawing import flat
from skincad.outputs.drawing.formats import sheet_svg, write_sheet_dxf, write_sheet_pdf
from skincad.outputs.drawing.marks import Sheet
from skincad.outputs.drawing.overview import drawing
from skincad.outputs.drawing.part_sheet import part_sheet
from skincad.outputs.figures.canvas import Picture, png
from skincad.outputs.figures.design import design_figure
from skincad.outputs.pages import page
from skincad.outputs.solid_files import (
    assembly,
    source_date,
    write_3mf,
    write_assembly,
    write_step,
    write_stl,
)
from skincad.outputs.view import view_page
from skincad.solids.mold import ClosedMold, mold
from skincad.solids.plan import PartRole
from skincad.solids.skin import skin_part

T = TypeVar("T")

COMMAND = "make"
PREVIEW_NOTE = "Preview: meshes and findings alone, without STEP or a check."
JobWriter = Callable[[Job, Path], None]


def lines(result: MakeResult) -> list[str]:
    """Return what `make` prints."""
    unchecked = PREVIEW_NOTE if result.preview else checks.UNCHECKED
    parts = []
    for part in result.parts:
        more = "" if part.deviation is None else f"  mesh within {1000 * part.deviation:.2f} um"
        faces = f"  {part.faces:4d} faces" if more else ""
        parts.append(f"  {part.name:14} {part.volume:10.2f} mm3{faces}{more}")
    return [
        *(checks.verdict_lines(result.check) if result.check else [unchecked]),
        "Parts:",
        *parts,
        *(str(finding) for finding in result.findings),
        f"{result.name}: {result.summary}",
        *(checks.advice_lines(result.check) if result.check else []),
    ]


def names(design: Design, solids: bool = True, preview: bool = False) -> list[str]:
    """Return the names of what will be written, with `solids` those of exact ones too, of a `preview` no
    report; InputError where there is no mold."""
    return list(writers(design, mold(design), solids, preview))


def manifest(result: MakeResult) -> dict[str, Any]:
    """Return what the manifest says of the result: without times, so that it is the same again."""
    return {
        "name": result.name,
        "passed": result.passed,
        "summary": result.summary,
        "all_touch_force_N": result.check and result.check.all_touch_force.as_json(),
        "processes": [estimate.as_json() for estimate in result.estimates],
        "findings": [finding.as_json() for finding in result.findings],
        **({"mount": result.mount.as_json()} if result.mount else {}),
    }


def figures(result: MakeResult) -> dict[str, Callable[[], Picture]]:
    """Return the picture of the skin, its section, and the mold taken apart."""
    return {"picture.png": partial(_figure, result.built())}


def files(result: MakeResult) -> dict[str, Writer]:
    """Return the writer of each file."""
    job = result.built()
    job_writers = writers(job.design, job.closed, result.solids, result.preview)
    return {name: partial(write, job) for name, write in job_writers.items()}


def writers(
    design: Design, closed: ClosedMold, solids: bool = True, preview: bool = False
) -> dict[str, JobWriter]:
    """Return the writer of each file by its name, whose suffix is the format; pictures come last."""
    printed = [part.name for part in closed.parts if part.made == "made"]
    strips: dict[str, JobWriter] = {
        "strips.dxf": lambda job, path: flat.write_strips_dxf(job.design, path),
        "strips.svg": lambda job, path: flat.write_strips_svg(job.design, path),
        "strip-board.kicad_mod": lambda job, path: flat.write_strip_board(job.design, path),
    }
    shims: dict[str, JobWriter] = {
        "shims.dxf": lambda job, path: flat.write_shims_dxf(job.design, job.closed, path)
    }
    seal: dict[str, JobWriter] = {"seal.dxf": lambda job, path: flat.write_seal_dxf(job.closed, path)}
    return {
        **(_solid_writers(printed) if solids else {}),
        **{f"{name}.stl": partial(_write_stl, name) for name in ("skin", *printed)},
        "mold.3mf": lambda job, path: write_3mf(
            {name: (mesh, job.closed.part(name).colour) for name, mesh in job.laid.items()}, path
        ),
        "skin.3mf": lambda job, path: write_3mf(
            {"skin": (job.skin, job.closed.first(PartRole.SKIN).colour)}, path
        ),
        "section.dxf": lambda job, path: flat.write_section_dxf(job.design, path),
        "section.svg": lambda job, path: flat.write_section_svg(job.design, path),
        "drawing.svg": _text(_drawing),
        **(strips if design.film else {}),
        **(shims if closed.of(PartRole.SHIM) else {}),
        **(seal if closed.of(PartRole.SEAL) else {}),
        "design.toml": _text(lambda job: job.design.to_toml()),
        "casting-sheet.md": _text(_casting_sheet),
        "casting-sheet.html": _text(
            lambda job: page(_casting_sheet(job), _drawing(job), f"Casting sheet: {job.design.name}")
        ),
        "parts-list.csv": _text(lambda job: parts_csv(job.design, job.closed, job.estimates)),
        "view.html": _text(
            lambda job: view_page(job.design, job.closed, job.meshes, job.check, _verdict(job))
        ),
        **({} if preview else {"report.html": _text(_report)}),
        "picture.png": _picture,
    }


def _text(of: Callable[[Job], str]) -> JobWriter:
    return lambda job, path: text(lambda: of(job))(path)


def _solid_writers(printed: list[str]) -> dict[str, JobWriter]:
    """The files that show exact solids: STEP, and shop drawings, each sheet laid out once for its formats."""
    drawings: dict[str, Callable[[Sheet, Path], object]] = {
        "pdf": write_sheet_pdf,
        "svg": lambda sheet, path: path.write_text(sheet_svg(sheet), encoding="utf-8"),
        "dxf": write_sheet_dxf,
    }

    def drawn(name: str, kind: str, job: Job, path: Path) -> None:
        drawings[kind](_once(job, f"sheet {name}", lambda: sheet_of(job, name)), path)

    return {
        **{f"{name}.step": partial(_write_solid, name) for name in ("skin", *printed)},
        "assembly.step": _write_assembly,
        **{f"{name}.{kind}": partial(drawn, name, kind) for name in printed for kind in drawings},
    }


def sheet_of(job: Job, name: str) -> Sheet:
    """Return a made part's sheet; its date is SOURCE_DATE_EPOCH's, or left out."""
    part = job.closed.part(name)
    crests = CrestAllowance(checks.allowed_drops(job.check)) if job.check else None
    date = source_date()[:10] if "SOURCE_DATE_EPOCH" in os.environ else ""
    return part_sheet(part_drawing(job.design, part, job.solid(part).val(), crests), __version__, date)


def _write_solid(name: str, job: Job, path: Path) -> None:
    write_step(job.solid(skin_part(job.design) if name == "skin" else job.closed.part(name)), path)


def _write_assembly(job: Job, path: Path) -> None:
    solids = {part.name: job.solid(part) for part in job.closed.parts}
    write_assembly(assembly(job.closed, solids, job.design.name), path)


def _write_stl(name: str, job: Job, path: Path) -> None:
    write_stl(job.skin if name == "skin" else job.laid[name], path)


def _verdict(job: Job) -> str:
    """The verdict in words, or that the design was not checked."""
    return checks.verdict(job.check) if job.check else checks.UNCHECKED


def _report(job: Job) -> str:
    from skincad.outputs.report import report

    return report(job, partial(_png, job), _casting_sheet(job), _drawing(job))


def _png(job: Job) -> bytes:
    """The picture, drawn once for all files that show it."""
    return _once(job, "picture", lambda: png(_figure(job)))


def _picture(job: Job, path: Path) -> None:
    path.write_bytes(_png(job))


def _figure(job: Job) -> Picture:
    return design_figure(job.design, job.closed, job.meshes)


def _drawing(job: Job) -> str:
    """The drawing, SVG."""
    return _once(job, "drawing", lambda: drawing(job.design, job.closed))


def _casting_sheet(job: Job) -> str:
    """The casting sheet, Markdown."""

    def sheet() -> str:
        measured = inspection(job.design, job.closed, *checks.allowance(job.check))
        passed = passes(job.check, job.findings, strict=False)
        findings = list(job.findings)
        return casting_sheet(job.design, job.closed, findings, _verdict(job), passed, measured, job.estimates)

    return _once(job, "sheet", sheet)


def _once(job: Job, name: str, of: Callable[[], T]) -> T:
    """What several files need of a job, made for the first of them."""
    if name not in job.cache:
        job.cache[name] = of()
    return cast(T, job.cache[name])
