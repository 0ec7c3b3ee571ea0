"""Shop drawings: a sheet for each made part, as PDF, SVG and DXF."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from skincad.base.version import __version__
from skincad.fabrication.making import Job
from skincad.fabrication.part_drawing import part_drawing
from skincad.fabrication.tolerances import CrestAllowance
from skincad.outputs import checks
from skincad.outputs.dxf import write_sheet_dxf
from skincad.outputs.stepfile import source_date
from skincad.pictures.marks import Sheet
from skincad.pictures.part_sheet import part_sheet
from skincad.pictures.sheet_pdf import write_sheet_pdf
from skincad.pictures.sheet_svg import sheet_svg

JobWriter = Callable[[Job, Path], None]


def sheet_writers(parts: list[str]) -> dict[str, JobWriter]:
    """Return the writers of each part's three files, by name; a sheet is drawn once for them."""
    sheets: dict[str, tuple[Job, Sheet]] = {}

    def cached_sheet(job: Job, name: str) -> Sheet:
        if name not in sheets or sheets[name][0] is not job:
            sheets[name] = job, sheet_of(job, name)
        return sheets[name][1]

    def pdf(name: str) -> JobWriter:
        return lambda job, path: write_sheet_pdf(cached_sheet(job, name), path)

    def svg(name: str) -> JobWriter:
        return lambda job, path: _text(sheet_svg(cached_sheet(job, name)), path)

    def dxf(name: str) -> JobWriter:
        return lambda job, path: _dxf(cached_sheet(job, name), path)

    kinds = {"pdf": pdf, "svg": svg, "dxf": dxf}
    return {f"{name}.{kind}": of(name) for name in parts for kind, of in kinds.items()}


def sheet_of(job: Job, name: str) -> Sheet:
    """Return a made part's sheet; its date is SOURCE_DATE_EPOCH's, or left out."""
    part = job.closed.part(name)
    drawing = part_drawing(job.design, part, job.solid(part).val(), _crest_tolerances(job))
    date = source_date()[:10] if "SOURCE_DATE_EPOCH" in os.environ else ""
    return part_sheet(drawing, __version__, date)


def _crest_tolerances(job: Job) -> CrestAllowance | None:
    if job.check is None:
        return None
    return CrestAllowance(checks.allowed_drops(job.check))


def _text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")


def _dxf(sheet: Sheet, path: Path) -> None:
    write_sheet_dxf(sheet, path)
