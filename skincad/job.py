"""The main job: from a design to skin, mold, files, findings and verdict, in one folder."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tomlkit

import skincad
from skincad.design import Design
from skincad.errors import InputError, did_you_mean
from skincad.outfolder import MANIFEST, checked_folder, replaced
from skincad.solids.mold import Mold, mold
from skincad.stopwatch import Progress, Stopwatch
from skincad.strictjson import strict_json

if TYPE_CHECKING:
    from skincad.fabrication.findings import Finding
    from skincad.mechanics.verdict import ContactCheck
    from skincad.solids.plan import Part

FORMATS = ("step", "stl", "3mf", "dxf", "svg", "png", "md", "html", "toml")
STAGES = ("contact check", "solids", "meshes", "measuring", "interference", "files", "picture")
FINEST_CHORD = 1e-4  # mm; finer ones cost memory and show nothing
INTERFERENCE_SHARE = 0.1  # of the smallest clearance: chords of the meshes that are tested for interference


@dataclass(frozen=True)
class PartReport:
    """A part as built: exact solid and print mesh; mm, mm2, mm3."""

    name: str
    volume: float
    area: float
    faces: int
    valid: bool
    watertight: bool
    self_intersections: int
    deviation: float
    asked_deviation: float

    def as_json(self) -> dict[str, Any]:
        """Return the part under the contract's keys."""
        return {
            "name": self.name,
            "volume_mm3": self.volume,
            "area_mm2": self.area,
            "faces": self.faces,
            "valid": self.valid,
            "watertight": self.watertight,
            "self_intersections": self.self_intersections,
            "deviation_mm": self.deviation,
            "asked_deviation_mm": self.asked_deviation,
        }


def mesh_findings(parts: list[PartReport]) -> list[Finding]:
    """Return an error for every print mesh that is open, cuts itself or deviates more than was asked."""
    from skincad.fabrication.findings import Finding

    remedy = "report it with the design: a mesh must not come out like this"
    found = []
    for part in parts:
        if not part.watertight:
            found.append(Finding("watertight", part.name, 0.0, 1.0, "", "error", remedy))
        if part.self_intersections:
            count = float(part.self_intersections)
            found.append(Finding("self-intersection", part.name, count, 0.0, "faces", "error", remedy))
        if part.deviation > part.asked_deviation:
            deviation = part.deviation, part.asked_deviation
            found.append(Finding("deviation", part.name, *deviation, "mm", "error", remedy))
    return found


@dataclass(frozen=True)
class MakeResult:
    """What `make` did: files, parts as measured, findings and the contact verdict."""

    name: str
    folder: Path
    passed: bool
    files: tuple[tuple[str, int], ...]  # name in the folder, bytes
    parts: tuple[PartReport, ...]
    findings: tuple[Finding, ...]
    check: ContactCheck
    cavity_volume: float  # mm3, of what cures to the skin: larger by the shrinkage
    seconds: dict[str, float]

    def as_json(self) -> dict[str, Any]:
        """Return the result under the contract's keys."""
        return {
            "name": self.name,
            "passed": self.passed,
            "files": [{"path": str(self.folder / name), "bytes": size} for name, size in self.files],
            "parts": [part.as_json() for part in self.parts],
            "cavity_volume_mm3": self.cavity_volume,
            "findings": [finding.as_json() for finding in self.findings],
            "check": self.check.as_json(),
            "seconds": self.seconds,
        }


def make(
    design: Design,
    folder: Path | str | None = None,
    *,
    formats: tuple[str, ...] | str = FORMATS,
    strict: bool = False,
    progress: Progress | None = None,
) -> MakeResult:
    """Build, check and write a design into `folder` (default out/<name>), whole or not at all.

    `passed` is false when the contact verdict fails, a part is not valid, watertight or free, or (with
    `strict`) any finding is a warning. Raises InputError for bad input, KernelError for a bad solid.
    """
    formats = (formats,) if isinstance(formats, str) else formats
    unknown = [f for f in formats if f not in FORMATS]
    if unknown:
        raise InputError("--format", "unknown format", unknown[0], did_you_mean(unknown[0], FORMATS))
    target = Path("out") / design.name if folder is None else Path(folder)
    real = checked_folder(target)
    if (text := str(real)).encode("utf-8", "replace").decode(
        "utf-8"
    ) != text:  # the CAD kernel takes no other
        raise InputError("-o", "must be UTF-8", text, "name another folder, or set LC_ALL=C.UTF-8")
    closed = mold(design)  # bad input is told before the CAD kernel loads
    _import_everything()
    watch = Stopwatch(progress)
    job = _build(design, closed, watch)
    with replaced(target) as staging:
        _write(job, formats, staging, watch)
        result = _result(job, target, staging, strict, watch)
        _write_text(_manifest(result), staging / MANIFEST)
    return result


def _import_everything() -> None:
    """Import before the clock starts: `seconds` is the work, not the libraries' loading."""
    import skincad.solids.occ  # isort: skip  # names the system libraries that miss, so it comes first
    import skincad.fabrication.measures
    import skincad.mechanics.linear
    import skincad.report  # noqa: F401


@dataclass(frozen=True)
class _Job:
    design: Design
    closed: Mold
    solids: dict[str, Any]
    meshes: dict[str, Any]
    skin: tuple[Any, Any]  # solid and mesh as designed; in `solids` and `meshes` it is as poured
    reports: tuple[PartReport, ...]
    findings: tuple[Finding, ...]
    check: ContactCheck

    def passed(self, strict: bool) -> bool:
        """Whether contact and findings hold; warnings count where `strict`."""
        bad = {"error", "warning"} if strict else {"error"}
        return self.check.passed and not any(f.severity in bad for f in self.findings)


def _build(design: Design, closed: Mold, watch: Stopwatch) -> _Job:
    from skincad.catalog import processes
    from skincad.fabrication.filling import filling_findings
    from skincad.fabrication.findings import design_findings
    from skincad.fabrication.measures import FINER, interference
    from skincad.fabrication.meshes import mesh
    from skincad.fabrication.strip_rules import strip_findings
    from skincad.mechanics.check import check
    from skincad.solids.occ import workplane
    from skincad.solids.skin import skin_part

    made, designed = [part for part in closed.parts if part.made == "made"], skin_part(design)
    known, choice = processes(design.printer), design.mold
    makers = {choice.process, choice.end_plate_process, choice.lid_process}
    asked = min(known[name].chord for name in makers if name)
    chord = asked / (1 + 1 / FINER)  # the reference mesh's own error is added to it
    with watch.stage("contact check"):
        verdict = check(design)
    with watch.stage("solids"):
        solids = {part.name: workplane(part) for part in closed.parts}
        solid = workplane(designed)
    with watch.stage("meshes"):
        meshes = {part.name: mesh(part, chord) for part in closed.parts}
        skin = solid, mesh(designed, chord)
    with watch.stage("measuring"):
        reports = [_report(designed, skin[0].val(), skin[1], chord, asked)]
        reports += [_report(part, solids[part.name].val(), meshes[part.name], chord, asked) for part in made]
    with watch.stage("interference"):
        gap = min(design.mold.clearance, design.mold.slit_clearance) or chord
        fine = max(FINEST_CHORD, min(chord, INTERFERENCE_SHARE * gap))
        findings = [*design_findings(design, closed), *mesh_findings(reports), *interference(closed, fine)]
        findings += [*filling_findings(design, closed), *strip_findings(design)]
    return _Job(design, closed, solids, meshes, skin, tuple(reports), tuple(findings), verdict)


def _report(part: Part, solid: Any, mesh: Any, chord: float, asked: float) -> PartReport:
    from skincad.fabrication.measures import measure
    from skincad.solids.occ import volume

    seen = measure(part, mesh, chord)
    return PartReport(
        name=part.name,
        volume=volume(part, solid),
        area=solid.Area(),
        faces=len(solid.Faces()),
        valid=True,  # else KernelError, before anything was written
        watertight=seen.watertight,
        self_intersections=seen.self_intersections,
        deviation=seen.deviation,
        asked_deviation=asked,
    )


def _writers(job: _Job) -> dict[str, dict[str, Callable[[Path], None]]]:
    """File name to writer, by format."""
    from skincad import export
    from skincad.fabrication.drawing import drawing
    from skincad.fabrication.inspection import inspection
    from skincad.fabrication.meshes import laid
    from skincad.fabrication.page import page
    from skincad.fabrication.rules_of_layers import laid_on_end
    from skincad.fabrication.sheet import casting_sheet
    from skincad.report import write_picture
    from skincad.wording import verdict

    design, closed = job.design, job.closed
    printed = {p.name: p for p in closed.parts if p.made == "made"}
    flat = {name: laid(job.meshes[name], laid_on_end(design, part), part) for name, part in printed.items()}
    coloured = {name: (flat[name], part.colour) for name, part in printed.items()}
    turned, colour = job.skin[1], closed.part("skin").colour
    stl = {"skin": turned, **flat}
    measures = inspection(design, closed.part("skin"), _allowed_drops(job.check))
    sheet = casting_sheet(design, closed, list(job.findings), verdict(job.check), job.passed(False), measures)
    drawn = drawing(design, closed)
    title = f"Casting sheet: {design.name}"
    text = tomlkit.dumps(design.model_dump(exclude_none=True))
    pattern = {"strips.dxf": lambda p: export.write_strips_dxf(design, p)} if design.film else {}
    pattern_svg = {"strips.svg": lambda p: export.write_strips_svg(design, p)} if design.film else {}
    return {
        "step": {
            **{f"{n}.step": _step_writer(job, n) for n in ("skin", *printed)},
            "assembly.step": lambda p: export.write_assembly(
                export.assembly(closed, job.solids, design.name), p
            ),
        },
        "stl": {f"{name}.stl": _stl_writer(shape) for name, shape in stl.items()},
        "3mf": {
            "mold.3mf": lambda p: export.write_3mf(coloured, p),
            "skin.3mf": lambda p: export.write_3mf({"skin": (turned, colour)}, p),
        },
        "dxf": {"section.dxf": lambda p: export.write_section_dxf(design, p), **pattern},
        "svg": {
            "section.svg": lambda p: export.write_section_svg(design, p),
            "drawing.svg": lambda p: _write_text(drawn, p),
            **pattern_svg,
        },
        "toml": {"design.toml": lambda p: _write_text(text, p)},
        "md": {"casting-sheet.md": lambda p: _write_text(sheet, p)},
        "html": {"casting-sheet.html": lambda p: _write_text(page(sheet, drawn, title), p)},
        "png": {"picture.png": lambda p: write_picture(design, closed, job.meshes, p)},
    }


def _allowed_drops(check: ContactCheck) -> tuple[float, ...]:
    """By how much each crest may lie lower alone, mm, until the verdict's margin is used up."""
    made, margin = check.manufacture, check.margin
    if made is None or margin is None or not check.passed:
        return ()
    return tuple(margin / slope if slope > 0 else math.inf for slope in made.crest_sensitivity)


def _manifest(result: MakeResult) -> str:
    """What was made, by which version, and whether it passed: without times, so that it is the same again."""
    check = result.check
    data = {
        "skincad": skincad.__version__,
        "name": result.name,
        "passed": result.passed,
        "all_touch_force_N": check.all_touch_force.as_json(),
        "findings": [finding.as_json() for finding in result.findings],
        "files": [name for name, _ in result.files],
    }
    return strict_json(data, indent=1) + "\n"


def _step_writer(job: _Job, name: str) -> Callable[[Path], None]:
    from skincad.export import write_step

    solid = job.skin[0] if name == "skin" else job.solids[name]
    return lambda path: write_step(solid, path)


def _stl_writer(mesh: Any) -> Callable[[Path], None]:
    from skincad.export import write_stl

    return lambda path: write_stl(mesh, path)


def _write_text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")


def _write(job: _Job, formats: tuple[str, ...], staging: Path, watch: Stopwatch) -> None:
    for kind, files in _writers(job).items():
        if kind in formats:
            with watch.stage("picture" if kind == "png" else "files"):
                for name, write in files.items():
                    write(staging / name)


def _result(job: _Job, target: Path, staging: Path, strict: bool, watch: Stopwatch) -> MakeResult:
    return MakeResult(
        name=job.design.name,
        folder=target,
        passed=job.passed(strict),
        files=tuple((path.name, path.stat().st_size) for path in sorted(staging.iterdir())),
        parts=job.reports,
        findings=job.findings,
        check=job.check,
        cavity_volume=job.closed.part("skin").volume,
        seconds=watch.seconds(),
    )
