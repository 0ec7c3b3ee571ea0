"""What a made design says and leaves: words, and a writer for each file, by names known before any work."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skincad.base.result import Writer
from skincad.fabrication.making import Job, MakeResult, passes
from skincad.inputs.design import Design
from skincad.outputs import checks
from skincad.solids.mold import ClosedMold, mold
from skincad.solids.roles import PartRole

if TYPE_CHECKING:
    from skincad.mechanics.verdict import ContactCheck
    from skincad.pictures.canvas import Picture

COMMAND = "make"
UNCHECKED = "Not checked whether all ridges touch."


def lines(result: MakeResult) -> list[str]:
    """Return what `make` prints."""
    rows = [
        f"  {p.name:14} {p.volume:10.2f} mm3  {p.faces:4d} faces  mesh within {1000 * p.deviation:.2f} um"
        for p in result.parts
    ]
    return [
        *(checks.verdict_lines(result.check) if result.check else [UNCHECKED]),
        "Parts:",
        *rows,
        *(str(finding) for finding in result.findings),
        f"{result.name}: {'passed' if result.passed else 'FAILED'}",
        *(checks.advice_lines(result.check) if result.check else []),
    ]


def names(design: Design) -> list[str]:
    """Return the names of what will be written; InputError where there is no mold."""
    return list(writers(design, mold(design)))


def manifest(result: MakeResult) -> dict[str, Any]:
    """Return what the manifest says of the result: without times, so that it is the same again."""
    return {
        "name": result.name,
        "passed": result.passed,
        "all_touch_force_N": result.check and result.check.all_touch_force.as_json(),
        "findings": [finding.as_json() for finding in result.findings],
    }


def figures(result: MakeResult) -> dict[str, Callable[[], Picture]]:
    """Return the picture of the skin, its section, and the mold taken apart."""
    return {"picture.png": partial(_drawn, result.built())}


def files(result: MakeResult) -> dict[str, Writer]:
    """Return the writer of each file."""
    job = result.built()
    return {name: partial(write, job) for name, write in writers(job.design, job.closed).items()}


OfJob = Callable[[Job, Path], None]


def writers(design: Design, closed: ClosedMold) -> dict[str, OfJob]:
    """Return the writer of each file by its name, whose suffix is the format; pictures come last."""
    import skincad.pictures.design_picture  # noqa: F401  # the clock starts after this

    printed = [part.name for part in closed.parts if part.made == "made"]
    return {
        **{f"{name}.step": _step(name) for name in ("skin", *printed)},
        "assembly.step": _assembly,
        **{f"{name}.stl": _stl(name) for name in ("skin", *printed)},
        "mold.3mf": _mold_3mf,
        "skin.3mf": _skin_3mf,
        "section.dxf": _exported("write_section_dxf"),
        "section.svg": _exported("write_section_svg"),
        "drawing.svg": lambda job, path: _text(_drawing(job), path),
        **(
            {f"strips.{kind}": _exported(f"write_strips_{kind}") for kind in ("dxf", "svg")}
            if design.film
            else {}
        ),
        "design.toml": lambda job, path: _text(job.design.to_toml(), path),
        "casting-sheet.md": lambda job, path: _text(_sheet(job), path),
        "casting-sheet.html": _page,
        "picture.png": _picture,
    }


def _step(name: str) -> OfJob:
    def write(job: Job, path: Path) -> None:
        from skincad.outputs.export import write_step

        write_step(job.skin[0] if name == "skin" else job.solids[name], path)

    return write


def _assembly(job: Job, path: Path) -> None:
    from skincad.outputs.export import assembly, write_assembly

    write_assembly(assembly(job.closed, job.solids, job.design.name), path)


def _stl(name: str) -> OfJob:
    def write(job: Job, path: Path) -> None:
        from skincad.outputs.export import write_stl

        write_stl(job.skin[1] if name == "skin" else job.laid[name], path)

    return write


def _mold_3mf(job: Job, path: Path) -> None:
    from skincad.outputs.export import write_3mf

    write_3mf({name: (mesh, job.closed.part(name).colour) for name, mesh in job.laid.items()}, path)


def _skin_3mf(job: Job, path: Path) -> None:
    from skincad.outputs.export import write_3mf

    write_3mf({"skin": (job.skin[1], job.closed.first(PartRole.SKIN).colour)}, path)


def _exported(function: str) -> OfJob:
    """Return the writer of a drawing that `export` makes of the design alone."""

    def write(job: Job, path: Path) -> None:
        from skincad.outputs import export

        getattr(export, function)(job.design, path)

    return write


def _page(job: Job, path: Path) -> None:
    from skincad.pictures.page import page

    _text(page(_sheet(job), _drawing(job), f"Casting sheet: {job.design.name}"), path)


def _picture(job: Job, path: Path) -> None:
    from skincad.pictures.canvas import save

    save(_drawn(job), path)


def _drawn(job: Job) -> Picture:
    from skincad.pictures.design_picture import design_figure

    return design_figure(job.design, job.closed, job.meshes)


def _drawing(job: Job) -> str:
    """The drawing, SVG."""
    from skincad.pictures.drawing import drawing

    return drawing(job.design, job.closed)


def _sheet(job: Job) -> str:
    """The casting sheet, Markdown."""
    from skincad.fabrication.inspection import inspection
    from skincad.fabrication.sheet import casting_sheet

    measures = inspection(job.design, job.closed.first(PartRole.SKIN), _allowed_drops(job.check))
    found, said = list(job.findings), checks.verdict(job.check) if job.check else UNCHECKED
    passed = passes(job.check, job.findings, strict=False)
    return casting_sheet(job.design, job.closed, found, said, passed, measures)


def _allowed_drops(check: ContactCheck | None) -> tuple[float, ...]:
    """By how much each crest may lie lower alone, mm, until the verdict's margin is used up."""
    if check is None:
        return ()
    made, margin = check.manufacture, check.margin
    if made is None or margin is None or not check.passed:
        return ()
    return tuple(margin / slope if slope > 0 else math.inf for slope in made.crest_sensitivity)


def _text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")
