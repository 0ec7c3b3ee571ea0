"""The main job: from a design to skin, mold, findings and verdict."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from skincad.base.arguments import require_goals
from skincad.base.errors import InputError, RefusedError
from skincad.base.result import Result
from skincad.base.stopwatch import Progress, Stopwatch
from skincad.inputs.design import Design
from skincad.mechanics.tiers.table import tier_of
from skincad.solids.mold import ClosedMold, mold
from skincad.solids.roles import PartRole

if TYPE_CHECKING:
    from skincad.fabrication.finding import Finding
    from skincad.mechanics.verdict import ContactCheck
    from skincad.solids.plan import Part

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
    from skincad.fabrication.finding import Finding

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
class Job:
    """A design as built and judged; the solids and meshes are the CAD kernel's and trimesh's, mm."""

    design: Design
    closed: ClosedMold
    solids: dict[str, Any]
    meshes: dict[str, Any]
    skin: tuple[Any, Any]  # solid and mesh as designed; in `solids` and `meshes` it is as poured
    findings: tuple[Finding, ...]
    check: ContactCheck | None  # None where nobody asked for the verdict

    @cached_property
    def laid(self) -> dict[str, Any]:
        """Meshes of what is printed, laid on the bed, by part name."""
        from skincad.fabrication.meshes import laid
        from skincad.fabrication.rules_of_layers import laid_on_end

        printed = {part.name: part for part in self.closed.parts if part.made == "made"}
        return {n: laid(self.meshes[n], laid_on_end(self.design, p), p) for n, p in printed.items()}


@dataclass(frozen=True, repr=False)
class MakeResult(Result):
    """A design as built, measured and judged; with `strict` warnings fail it too.

    A copy, or one that was pickled, leaves the solids and meshes of `job` behind, and so can't be written.
    """

    shown_by = "skincad.outputs.makes"
    name: str
    strict: bool
    parts: tuple[PartReport, ...]
    findings: tuple[Finding, ...]
    check: ContactCheck | None  # None where nobody asked for the verdict
    cavity_volume: float  # mm3, of what cures to the skin: larger by the shrinkage
    seconds: dict[str, float]
    job: Job | None = field(default=None, compare=False)

    @property
    def passed(self) -> bool:
        """Whether all ridges touch, if that was asked, and no finding is an error, nor with `strict` a
        warning."""
        return passes(self.check, self.findings, self.strict)

    def built(self) -> Job:
        """Return the solids and meshes; raises RefusedError for a copy."""
        if self.job is None:
            raise RefusedError(f"{self.name}: a copy has no solids to write; make it again")
        return self.job

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "job": None}

    def as_json(self) -> dict[str, Any]:
        """Return the result under the contract's keys; `files` are those of `write`."""
        return {
            "name": self.name,
            "passed": self.passed,
            "parts": [part.as_json() for part in self.parts],
            "cavity_volume_mm3": self.cavity_volume,
            "findings": [finding.as_json() for finding in self.findings],
            "check": self.check and self.check.as_json(),
            "seconds": self.seconds,
        }


def make(
    design: Design,
    *,
    strict: bool = False,
    checked: bool = True,
    tier: str = "auto",
    budget: float | None = None,
    progress: Progress | None = None,
) -> MakeResult:
    """Build a design's skin and mold, measure and judge them; `skincad.write` writes the files.

    `tier` and `budget` s are those of `check`; without `checked` nobody asks whether all ridges touch.
    `passed` is false when they don't, a part is not valid, watertight or free, or (with `strict`) any finding
    is a warning. Raises InputError for bad input, KernelError for a bad solid.
    """
    _check_asked(checked, tier, budget)
    closed = mold(design)  # bad input is told before the CAD kernel loads
    _import_everything()
    watch = Stopwatch(progress)
    verdict = None
    if checked:
        from skincad.mechanics.touching import check

        with watch.stage("contact check"):
            verdict = check(design, tier=tier, budget=budget)
    job, reports = _build(design, closed, verdict, watch)
    volume = job.closed.first(PartRole.SKIN).volume
    found = tuple(reports), job.findings, job.check, volume, watch.seconds(), job
    return MakeResult(design.name, strict, *found)


def passes(check: ContactCheck | None, findings: tuple[Finding, ...], strict: bool) -> bool:
    """Return whether all ridges touch, if that was asked, and no finding is an error, nor with `strict` a
    warning."""
    bad = {"error", "warning"} if strict else {"error"}
    touching = check is None or check.passed
    return touching and not any(finding.severity in bad for finding in findings)


def _check_asked(checked: bool, tier: str, budget: float | None) -> None:
    """Raise InputError for a tier or a budget of a check that is left out, and for one that there is not."""
    for key, given in (("tier", None if tier == "auto" else tier), ("budget", budget)):
        if given is not None and not checked:
            raise InputError(key, "is the check's, which is left out", given, "leave one of them out")
    if tier != "auto":
        tier_of(tier)
    require_goals(None, budget, "0.05")


def _import_everything() -> None:
    """Import before the clock starts: `seconds` is the work, not the libraries' loading."""
    import skincad.solids.occ  # isort: skip  # names the system libraries that miss, so it comes first
    import skincad.fabrication.measures
    import skincad.mechanics.tiers.linear  # noqa: F401


def _build(
    design: Design, closed: ClosedMold, verdict: ContactCheck | None, watch: Stopwatch
) -> tuple[Job, list[PartReport]]:
    from skincad.fabrication.filling import filling_findings
    from skincad.fabrication.findings import design_findings
    from skincad.fabrication.measures import FINER, interference
    from skincad.fabrication.meshes import mesh
    from skincad.fabrication.strip_rules import strip_findings
    from skincad.inputs.process import processes
    from skincad.solids.occ import workplane
    from skincad.solids.skin import skin_part

    made, designed = [part for part in closed.parts if part.made == "made"], skin_part(design)
    known, choice = processes(design.printer), design.mold
    makers = {choice.process, choice.end_plate_process, choice.lid_process}
    asked = min(known[name].chord for name in makers if name)
    chord = asked / (1 + 1 / FINER)  # the reference mesh's own error is added to it
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
