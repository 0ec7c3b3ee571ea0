"""What a made design leaves in its out folder: a writer for each file, by names known before any work."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tomlkit

from skincad.inputs.design import Design
from skincad.outputs.wording import verdict
from skincad.solids.mold import Mold

if TYPE_CHECKING:
    from skincad.fabrication.findings import Finding
    from skincad.mechanics.verdict import ContactCheck


@dataclass(frozen=True)
class Job:
    """A design as built and judged; the solids and meshes are the CAD kernel's and trimesh's, mm."""

    design: Design
    closed: Mold
    solids: dict[str, Any]
    meshes: dict[str, Any]
    skin: tuple[Any, Any]  # solid and mesh as designed; in `solids` and `meshes` it is as poured
    findings: tuple[Finding, ...]
    check: ContactCheck

    def passed(self, strict: bool) -> bool:
        """Whether contact and findings hold; warnings count where `strict`."""
        bad = {"error", "warning"} if strict else {"error"}
        return self.check.passed and not any(f.severity in bad for f in self.findings)

    @cached_property
    def laid(self) -> dict[str, Any]:
        """Meshes of what is printed, laid on the bed, by part name."""
        from skincad.fabrication.meshes import laid
        from skincad.fabrication.rules_of_layers import laid_on_end

        printed = {part.name: part for part in self.closed.parts if part.made == "made"}
        return {n: laid(self.meshes[n], laid_on_end(self.design, p), p) for n, p in printed.items()}

    @cached_property
    def sheet(self) -> str:
        """The casting sheet, Markdown."""
        from skincad.fabrication.inspection import inspection
        from skincad.fabrication.sheet import casting_sheet

        measures = inspection(self.design, self.closed.part("skin"), _allowed_drops(self.check))
        found, said = list(self.findings), verdict(self.check)
        return casting_sheet(self.design, self.closed, found, said, self.passed(False), measures)

    @cached_property
    def drawn(self) -> str:
        """The drawing, SVG."""
        from skincad.pictures.drawing import drawing

        return drawing(self.design, self.closed)


Writer = Callable[[Job, Path], None]


def writers(design: Design, closed: Mold) -> dict[str, Writer]:
    """Return the writer of each file by its name, whose suffix is the format; pictures come last."""
    printed = [part.name for part in closed.parts if part.made == "made"]
    return {
        **{f"{name}.step": _step(name) for name in ("skin", *printed)},
        "assembly.step": _assembly,
        **{f"{name}.stl": _stl(name) for name in ("skin", *printed)},
        "mold.3mf": _mold_3mf,
        "skin.3mf": _skin_3mf,
        "section.dxf": _exported("write_section_dxf"),
        "section.svg": _exported("write_section_svg"),
        "drawing.svg": lambda job, path: _text(job.drawn, path),
        **(
            {f"strips.{kind}": _exported(f"write_strips_{kind}") for kind in ("dxf", "svg")}
            if design.film
            else {}
        ),
        "design.toml": lambda job, path: _text(tomlkit.dumps(job.design.model_dump(exclude_none=True)), path),
        "casting-sheet.md": lambda job, path: _text(job.sheet, path),
        "casting-sheet.html": _page,
        "picture.png": _picture,
    }


def _allowed_drops(check: ContactCheck) -> tuple[float, ...]:
    """By how much each crest may lie lower alone, mm, until the verdict's margin is used up."""
    made, margin = check.manufacture, check.margin
    if made is None or margin is None or not check.passed:
        return ()
    return tuple(margin / slope if slope > 0 else math.inf for slope in made.crest_sensitivity)


def _step(name: str) -> Writer:
    def write(job: Job, path: Path) -> None:
        from skincad.outputs.export import write_step

        write_step(job.skin[0] if name == "skin" else job.solids[name], path)

    return write


def _assembly(job: Job, path: Path) -> None:
    from skincad.outputs.export import assembly, write_assembly

    write_assembly(assembly(job.closed, job.solids, job.design.name), path)


def _stl(name: str) -> Writer:
    def write(job: Job, path: Path) -> None:
        from skincad.outputs.export import write_stl

        write_stl(job.skin[1] if name == "skin" else job.laid[name], path)

    return write


def _mold_3mf(job: Job, path: Path) -> None:
    from skincad.outputs.export import write_3mf

    write_3mf({name: (mesh, job.closed.part(name).colour) for name, mesh in job.laid.items()}, path)


def _skin_3mf(job: Job, path: Path) -> None:
    from skincad.outputs.export import write_3mf

    write_3mf({"skin": (job.skin[1], job.closed.part("skin").colour)}, path)


def _exported(function: str) -> Writer:
    """Return the writer of a drawing that `export` makes of the design alone."""

    def write(job: Job, path: Path) -> None:
        from skincad.outputs import export

        getattr(export, function)(job.design, path)

    return write


def _page(job: Job, path: Path) -> None:
    from skincad.pictures.page import page

    _text(page(job.sheet, job.drawn, f"Casting sheet: {job.design.name}"), path)


def _picture(job: Job, path: Path) -> None:
    from skincad.pictures.design_picture import write_picture

    write_picture(job.design, job.closed, job.meshes, path)


def _text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")
