"""Shop drawings: a sheet for each made part, as PDF, SVG and DXF."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from skincad.base.version import __version__
from skincad.fabrication.making import Job
from skincad.fabrication.part_drawing import part_drawing
from skincad.fabrication.tolerances import Judged
from skincad.outputs import checks
from skincad.outputs.dxf import write_sheet_dxf
from skincad.outputs.stepfile import source_date
from skincad.pictures.marks import Sheet
from skincad.pictures.part_sheet import part_sheet
from skincad.pictures.sheet_pdf import write_sheet_pdf
from skincad.pictures.sheet_svg import sheet_svg

OfJob = Callable[[Job, Path], None]


def sheet_writers(parts: list[str]) -> dict[str, OfJob]:
    """Return the writers of each part's three files, by name; a sheet is drawn once for them."""
    drawn: dict[str, tuple[Job, Sheet]] = {}

    def drawn_once(job: Job, name: str) -> Sheet:
        if name not in drawn or drawn[name][0] is not job:
            drawn[name] = job, sheet_of(job, name)
        return drawn[name][1]

    def pdf(name: str) -> OfJob:
        return lambda job, path: write_sheet_pdf(drawn_once(job, name), path)

    def svg(name: str) -> OfJob:
        return lambda job, path: _text(sheet_svg(drawn_once(job, name)), path)

    def dxf(name: str) -> OfJob:
        return lambda job, path: _dxf(drawn_once(job, name), path)

    kinds = {"pdf": pdf, "svg": svg, "dxf": dxf}
    return {f"{name}.{kind}": of(name) for name in parts for kind, of in kinds.items()}


def sheet_of(job: Job, name: str) -> Sheet:
    """Return a made part's sheet; its date is SOURCE_DATE_EPOCH's, or left out."""
    part = job.closed.part(name)
    drawing = part_drawing(job.design, part, job.solid(part).val(), _judged(job))
    date = source_date()[:10] if "SOURCE_DATE_EPOCH" in os.environ else ""
    return part_sheet(drawing, __version__, date)


def _judged(job: Job) -> Judged | None:
    if job.check is None:
        return None
    return Judged(checks.allowed_drops(job.check))


def _text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")


def _dxf(sheet: Sheet, path: Path) -> None:
    write_sheet_dxf(sheet, path)
