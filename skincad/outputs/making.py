"""The main job: from a design to skin, mold, files, findings and verdict, in one folder."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skincad.base.errors import InputError, did_you_mean
from skincad.base.outfolder import checked_folder, replaced
from skincad.base.stopwatch import Progress, Stopwatch
from skincad.inputs.design import Design
from skincad.outputs.make_files import Job, writers
from skincad.solids.mold import Mold, mold

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
    closed = mold(design)  # bad input is told before the CAD kernel loads
    chosen = {n: write for n, write in writers(design, closed).items() if _kind(n) in formats}
    place = str(checked_folder(target, "make", chosen))
    if place.encode("utf-8", "replace").decode("utf-8") != place:  # the CAD kernel takes no other
        raise InputError("-o", "must be UTF-8", place, "name another folder, or set LC_ALL=C.UTF-8")
    _import_everything()
    watch = Stopwatch(progress)
    job, reports = _build(design, closed, watch)
    with replaced(target, "make", _told(job, strict)) as staging:
        for stage, names in groupby(chosen, lambda name: "picture" if _kind(name) == "png" else "files"):
            with watch.stage(stage):
                for name in names:
                    chosen[name](job, staging / name)
        return _result(job, reports, target, staging, strict, watch)


def _kind(name: str) -> str:
    return name.rpartition(".")[2]


def _import_everything() -> None:
    """Import before the clock starts: `seconds` is the work, not the libraries' loading."""
    import skincad.solids.occ  # isort: skip  # names the system libraries that miss, so it comes first
    import skincad.fabrication.measures
    import skincad.mechanics.tiers.linear
    import skincad.pictures.design_picture  # noqa: F401


def _build(design: Design, closed: Mold, watch: Stopwatch) -> tuple[Job, list[PartReport]]:
    from skincad.fabrication.filling import filling_findings
    from skincad.fabrication.findings import design_findings
    from skincad.fabrication.measures import FINER, interference
    from skincad.fabrication.meshes import mesh
    from skincad.fabrication.strip_rules import strip_findings
    from skincad.inputs.catalog import processes
    from skincad.mechanics.touching import check
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
    return Job(design, closed, solids, meshes, skin, tuple(findings), verdict), reports


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


def _told(job: Job, strict: bool) -> dict[str, Any]:
    """What the manifest says of a result: without times, so that it is the same again."""
    return {
        "name": job.design.name,
        "passed": job.passed(strict),
        "all_touch_force_N": job.check.all_touch_force.as_json(),
        "findings": [finding.as_json() for finding in job.findings],
    }


def _result(
    job: Job, reports: list[PartReport], target: Path, staging: Path, strict: bool, watch: Stopwatch
) -> MakeResult:
    return MakeResult(
        name=job.design.name,
        folder=target,
        passed=job.passed(strict),
        files=tuple((path.name, path.stat().st_size) for path in sorted(staging.iterdir())),
        parts=tuple(reports),
        findings=job.findings,
        check=job.check,
        cavity_volume=job.closed.part("skin").volume,
        seconds=watch.seconds(),
    )
