"""Output of `make`: words, and a writer for each file, whose names are known before any work."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skincad.base.result import Writer
from skincad.fabrication.making import Job, MakeResult, PartReport, passes
from skincad.inputs.design import Design
from skincad.outputs import checks
from skincad.solids.mold import ClosedMold, mold
from skincad.solids.plan import PartRole

if TYPE_CHECKING:
    from skincad.pictures.canvas import Picture

COMMAND = "make"
PREVIEW_NOTE = "Preview: meshes and findings alone, without STEP or a check."


def lines(result: MakeResult) -> list[str]:
    """Return what `make` prints."""
    unchecked = PREVIEW_NOTE if result.preview else checks.UNCHECKED
    return [
        *(checks.verdict_lines(result.check) if result.check else [unchecked]),
        "Parts:",
        *map(_part_line, result.parts),
        *(str(finding) for finding in result.findings),
        f"{result.name}: {result.summary}",
        *(checks.advice_lines(result.check) if result.check else []),
    ]


def _part_line(part: PartReport) -> str:
    line = f"  {part.name:14} {part.volume:10.2f} mm3"
    if part.deviation is None:
        return line
    return f"{line}  {part.faces:4d} faces  mesh within {1000 * part.deviation:.2f} um"


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


JobWriter = Callable[[Job, Path], None]


def writers(
    design: Design, closed: ClosedMold, solids: bool = True, preview: bool = False
) -> dict[str, JobWriter]:
    """Return the writer of each file by its name, whose suffix is the format; pictures come last."""
    import skincad.pictures.design_picture  # noqa: F401  # the clock starts after this

    printed = [part.name for part in closed.parts if part.made == "made"]
    return {
        **(_of_solids(printed) if solids else {}),
        **{f"{name}.stl": _stl(name) for name in ("skin", *printed)},
        "mold.3mf": _mold_3mf,
        "skin.3mf": _skin_3mf,
        "section.dxf": _exported("write_section_dxf"),
        "section.svg": _exported("write_section_svg"),
        "drawing.svg": lambda job, path: _text(_drawing(job), path),
        **(
            {f"strips.{kind}": _exported(f"write_strips_{kind}") for kind in ("dxf", "svg")}
            | {"strip-board.kicad_mod": _board}
            if design.film
            else {}
        ),
        **({"shims.dxf": _shims} if closed.of(PartRole.SHIM) else {}),
        **({"seal.dxf": _seal} if closed.of(PartRole.SEAL) else {}),
        "design.toml": lambda job, path: _text(job.design.to_toml(), path),
        "casting-sheet.md": lambda job, path: _text(_sheet(job), path),
        "casting-sheet.html": _page,
        "parts-list.csv": _parts_list,
        "view.html": _view,
        **({} if preview else {"report.html": _report}),
        "picture.png": _picture,
    }


def _of_solids(printed: list[str]) -> dict[str, JobWriter]:
    """The files that show exact solids."""
    from skincad.outputs.sheets import sheet_writers

    steps = {f"{name}.step": _step(name) for name in ("skin", *printed)}
    return {**steps, "assembly.step": _assembly, **sheet_writers(printed)}


def _step(name: str) -> JobWriter:
    def write(job: Job, path: Path) -> None:
        from skincad.outputs.export import write_step
        from skincad.solids.skin import skin_part

        write_step(job.solid(skin_part(job.design) if name == "skin" else job.closed.part(name)), path)

    return write


def _assembly(job: Job, path: Path) -> None:
    from skincad.outputs.export import assembly, write_assembly

    solids = {part.name: job.solid(part) for part in job.closed.parts}
    write_assembly(assembly(job.closed, solids, job.design.name), path)


def _stl(name: str) -> JobWriter:
    def write(job: Job, path: Path) -> None:
        from skincad.outputs.export import write_stl

        write_stl(job.skin if name == "skin" else job.laid[name], path)

    return write


def _mold_3mf(job: Job, path: Path) -> None:
    from skincad.outputs.export import write_3mf

    write_3mf({name: (mesh, job.closed.part(name).colour) for name, mesh in job.laid.items()}, path)


def _skin_3mf(job: Job, path: Path) -> None:
    from skincad.outputs.export import write_3mf

    write_3mf({"skin": (job.skin, job.closed.first(PartRole.SKIN).colour)}, path)


def _exported(function: str) -> JobWriter:
    """Return the writer of a drawing that `export` makes of the design alone."""

    def write(job: Job, path: Path) -> None:
        from skincad.outputs import export

        getattr(export, function)(job.design, path)

    return write


def _page(job: Job, path: Path) -> None:
    from skincad.pictures.page import page

    _text(page(_sheet(job), _drawing(job), f"Casting sheet: {job.design.name}"), path)


def _shims(job: Job, path: Path) -> None:
    from skincad.outputs.export import write_shims_dxf

    write_shims_dxf(job.design, job.closed, path)


def _board(job: Job, path: Path) -> None:
    from skincad.outputs.footprint import write_strip_board

    write_strip_board(job.design, path)


def _seal(job: Job, path: Path) -> None:
    from skincad.outputs.export import write_seal_dxf

    write_seal_dxf(job.closed, path)


def _parts_list(job: Job, path: Path) -> None:
    from skincad.fabrication.parts_list import parts_csv

    _text(parts_csv(job.design, job.closed, job.estimates), path)


def _view(job: Job, path: Path) -> None:
    from skincad.pictures.view import view_page

    _text(view_page(job.design, job.closed, job.meshes, job.check, _verdict(job)), path)


def _verdict(job: Job) -> str:
    """The verdict in words, or that the design was not checked."""
    return checks.verdict(job.check) if job.check else checks.UNCHECKED


def _report(job: Job, path: Path) -> None:
    from skincad.outputs.report import report

    _text(report(job, partial(_png, job), _sheet(job), _drawing(job)), path)


def _picture(job: Job, path: Path) -> None:
    path.write_bytes(_png(job))


def _png(job: Job) -> bytes:
    """The picture, drawn once for all files that show it."""
    from skincad.pictures.canvas import png

    return bytes(_once(job, "picture", lambda: png(_figure(job))))


def _once(job: Job, name: str, of: Callable[[], Any]) -> Any:
    if name not in job.cache:
        job.cache[name] = of()
    return job.cache[name]


def _figure(job: Job) -> Picture:
    from skincad.pictures.design_picture import design_figure

    return design_figure(job.design, job.closed, job.meshes)


def _drawing(job: Job) -> str:
    """The drawing, SVG."""
    from skincad.pictures.drawing import drawing

    return str(_once(job, "drawing", lambda: drawing(job.design, job.closed)))


def _sheet(job: Job) -> str:
    """The casting sheet, Markdown."""
    return str(_once(job, "sheet", lambda: _sheet_of(job)))


def _sheet_of(job: Job) -> str:
    from skincad.fabrication.inspection import inspection
    from skincad.fabrication.sheet import casting_sheet

    measured = inspection(job.design, job.closed, *checks.allowance(job.check))
    findings, verdict = list(job.findings), _verdict(job)
    passed = passes(job.check, job.findings, strict=False)
    return casting_sheet(job.design, job.closed, findings, verdict, passed, measured, job.estimates)


def _text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")
