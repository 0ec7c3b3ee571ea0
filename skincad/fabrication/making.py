"""The main job: from a design to skin, mold, findings and verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from skincad.base.errors import FaultError, InputError, RefusedError, require_goals
from skincad.base.progress import Progress, Stopwatch
from skincad.base.result import Record, Result, item, record, reported
from skincad.fabrication.job import Job
from skincad.inputs.design import Design
from skincad.mechanics.models.table import model_named
from skincad.shape.skin import skin_of
from skincad.solids.bone import least_over
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import PartRole

if TYPE_CHECKING:
    from skincad.fabrication.estimates import PartEstimate, ProcessEstimate
    from skincad.fabrication.fasteners import CarrierMount
    from skincad.fabrication.rules import Finding
    from skincad.mechanics.verdict import ContactCheck
    from skincad.solids.plan import Part

STAGES = ("contact check", "meshes", "solids", "measuring", "interference", "estimates", "files", "picture")
FINEST_CHORD = 1e-4  # mm; finer ones cost memory and show nothing
INTERFERENCE_SHARE = 0.1  # of the smallest clearance: chords of the meshes that are tested for interference


@dataclass(frozen=True)
class PartReport(Record):
    """A part as built: exact solid and print mesh; mm, mm2, mm3. A preview leaves None what it has not
    measured, and takes the volume by formula."""

    name: str = item(meaning="of the part")
    volume: float = item("mm3", "of the exact solid")
    watertight: bool = item(meaning="whether the print mesh is closed")
    asked_deviation: float = item("mm", "the most that it may deviate")
    area: float | None = item("mm2", "of the exact solid", default=None)
    faces: int | None = item(meaning="of the exact solid", default=None)
    valid: bool | None = item(meaning="whether the kernel holds the solid to be sound", default=None)
    self_intersections: int | None = item(meaning="faces of the mesh that cross others", default=None)
    deviation: float | None = item("mm", "of the mesh from the solid", default=None)
    estimate: PartEstimate | None = item(inline=True, default=None)  # of what is made; the skin is cast


def _check_meshes(parts: list[PartReport]) -> None:
    """Raise FaultError for a print mesh that is open, cuts itself or deviates more than was asked."""
    for part in parts:
        if not part.watertight:
            raise FaultError(f"{part.name}: the print mesh is open")
        if part.self_intersections:
            raise FaultError(f"{part.name}: {part.self_intersections} faces of the print mesh cross others")
        if part.deviation is not None and part.deviation > part.asked_deviation:
            off = f"{part.deviation:.3g} mm, more than {part.asked_deviation:.3g} mm"
            raise FaultError(f"{part.name}: the print mesh deviates by {off}")


@dataclass(frozen=True)
class Build:
    """A job as built and judged; the solids and meshes are the CAD kernel's and trimesh's, mm."""

    job: Job
    meshes: dict[str, Any]
    skin: Any  # mesh as designed; in `meshes` it is as poured
    findings: tuple[Finding, ...]
    check: ContactCheck | None  # None where nobody asked for the verdict
    scenes: tuple[Result, ...] = ()  # simulated with this skin
    estimates: tuple[ProcessEstimate, ...] = ()  # of mass, time and cost by process
    _solids: dict[Part, Any] = field(default_factory=dict, repr=False)

    @property
    def design(self) -> Design:
        """The design that is built."""
        return self.job.design

    @property
    def closed(self) -> ClosedMold:
        """Its mold."""
        return self.job.closed

    @cached_property
    def cache(self) -> dict[str, Any]:
        """What several files have, by name, made once by whoever writes the first of them."""
        return {}

    def solid(self, part: Part) -> Any:
        """Return a part's exact solid, built when it is first asked for; raises KernelError for a bad one."""
        if part not in self._solids:
            from skincad.solids.occ import workplane

            self._solids[part] = workplane(part)
        return self._solids[part]

    @cached_property
    def laid(self) -> dict[str, Any]:
        """Meshes of what is printed, laid on the bed, by part name."""
        from skincad.fabrication.machine_rules import laid_on_end
        from skincad.fabrication.meshes import laid

        printed = {part.name: part for part in self.closed.made}
        return {n: laid(self.meshes[n], laid_on_end(self.job, p), p) for n, p in printed.items()}


@record()
class MakeResult(Result):
    """A design as built, measured and judged; with `strict` warnings fail it too.

    A copy, or one that was pickled, leaves the solids and meshes of `build` behind, and so can't be written.
    """

    shown_by = "skincad.outputs.makes:MAKE"
    name: str = item(meaning="of the design")
    revision: str = item(meaning="of the design", default="")
    strict: bool
    preview: bool = item(meaning="whether it was made in haste", default=False)
    solids: bool = True  # whether there are exact ones, and so the files that show them
    parts: tuple[PartReport, ...] = item(meaning="as built")
    cavity_volume: float = item("mm3", "of what cures to the skin: larger by the shrinkage")
    estimates: tuple[ProcessEstimate, ...] = item(
        meaning="mass, time and cost by process", key="processes", default=()
    )
    findings: tuple[Finding, ...] = item(meaning="rules that are broken")
    check: ContactCheck | None = item(meaning="the verdict, null where it was not asked for")
    scenes: tuple[Result, ...] = item(meaning="simulated with this skin", default=(), compare=False)
    mount: CarrierMount | None = item(meaning="as the carrier has it", optional=True, default=None)
    seconds: dict[str, float] = item(meaning="wall time by stage, s")
    build: Build | None = field(default=None, compare=False)

    @reported(meaning="whether all ridges touch, if that was asked, and no rule is broken")
    def passed(self) -> bool:
        """Whether all ridges touch, if that was asked, and no finding is an error, nor with `strict` a
        warning."""
        return passes(self.check, self.findings, self.strict)

    @reported(meaning="what was checked and what came out")
    def summary(self) -> str:
        """What was checked and what came out, as "mold: no errors, 1 warning; contact: not checked"."""
        from skincad.fabrication.rules import counted

        contact = self.check.verdict if self.check else "not checked"
        return f"mold: {counted(self.findings)}; contact: {contact}"

    def built(self) -> Build:
        """Return the solids and meshes; raises RefusedError for a copy."""
        if self.build is None:
            raise RefusedError(f"{self.name}: a copy has no solids to write; make it again")
        return self.build

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "build": None}

    @property
    def exit_status(self) -> int:
        """0 where it passed, else 1."""
        return 0 if self.passed else 1


def make(
    design: Design,
    *,
    strict: bool = False,
    checked: bool = True,
    model: str = "auto",
    budget: float | None = None,
    preview: bool = False,
    solids: bool = False,
    scenes: Sequence[Result] = (),
    progress: Progress | None = None,
) -> MakeResult:
    """Build a design's skin and mold, measure and judge them; `skincad.write` writes the files.

    `model` and `budget` s are those of `check`; without `checked` nobody asks whether all ridges touch.
    `preview` makes meshes and findings alone: no check, nothing measured on the meshes, and no exact solid,
    nor the files that show one, unless `solids` asks for them.
    `scenes` are what `simulate` found of this skin: `load_scene(name, skin=design)`; the report shows them.
    `passed` is false when ridges don't surely touch, a part is not free, or (with `strict`) any finding is a
    warning; `summary` says what was checked. Raises InputError for bad input, FaultError for a solid or a
    mesh that fails its own check.
    """
    from skincad.fabrication.fasteners import mount_of

    checked, solids = checked and not preview, solids or not preview
    _check_choices(checked, model, budget)
    _check_scenes(design, scenes)
    job = Job(design)
    cavity = job.closed.first(PartRole.SKIN).volume  # bad input is refused before the CAD kernel loads
    _import_everything(solids, not preview)
    watch = Stopwatch(progress)
    verdict = None
    if checked:
        from skincad.mechanics.check import check

        with watch.stage("contact check"):
            verdict = check(design, model=model, budget=budget)
    build, reports = _build(job, verdict, tuple(scenes), watch, solids, not preview)
    if verdict is not None and design.mold.bone is not None:
        with watch.stage("contact check"):
            build = replace(build, findings=(*build.findings, *bone_findings(design)))
    return MakeResult(
        name=design.name,
        strict=strict,
        parts=tuple(reports),
        findings=build.findings,
        check=verdict,
        cavity_volume=cavity,
        seconds=watch.seconds(),
        preview=preview,
        solids=solids,
        build=build,
        scenes=build.scenes,
        revision=design.revision,
        mount=mount_of(job),
        estimates=build.estimates,
    )


def bone_findings(design: Design) -> list[Finding]:
    """Return what a flat back at the bone's top changes: the bone is stiffer than no bone and gives way more
    than that. By the linear model both times, of pins by the reduced one, of a doubly curved skin
    by springs."""
    from skincad.fabrication.rules import note
    from skincad.mechanics.check import check
    from skincad.mechanics.models.table import unsupported_reason

    top, where = least_over(design), "taken as a flat back by the check"
    bare = {"mold": dict.fromkeys(("bone", "bone_at", "bone_turn", "bone_bond"))}
    shots = tuple(
        shot.model_copy(update={"thickness": shot.thickness - top}) if shot.thickness else shot
        for shot in design.shot or ()
    )
    raised = {"skin": {"thickness": design.skin.thickness - top}, "shot": shots or None}
    models = "linear", "reduced", "winkler"
    model = next((name for name in models if not unsupported_reason(name, design, measured=False)), "linear")
    flat = check(design.with_(**bare), model=model)
    try:
        high = check(design.with_(**bare, **raised), model=model)
    except InputError:
        return [note("bone", where, top, 0.0, "mm", "no model takes what is over it")]
    before, after, unit = flat.all_touch_force, high.all_touch_force, "N"
    touch = f"all touch at {float(after):.3g} N in the place of {float(before):.3g} N, and "
    if skin_of(design).bare:
        before, after, unit, touch = flat.approach, high.approach, "mm", ""
    words = (
        f"the check takes the back as flat; with all of it at the bone's top ({top:.3g} mm) {touch}at "
        f"{design.contact.force:g} N the plate comes {float(high.approach):.3g} mm down, not "
        f"{float(flat.approach):.3g} ({model} model): the bone lies between"
    )
    return [note("bone", where, float(after), float(before), unit, words)]


def passes(check: ContactCheck | None, findings: tuple[Finding, ...], strict: bool) -> bool:
    """Return whether all ridges touch, if that was asked, and no finding is an error, nor with `strict` a
    warning."""
    bad = {"error", "warning"} if strict else {"error"}
    touching = check is None or check.passed
    return touching and not any(finding.severity in bad for finding in findings)


def _check_choices(checked: bool, model: str, budget: float | None) -> None:
    """Raise InputError for a model or a budget of a check that is left out, and for one that there is not."""
    for key, value in (("model", None if model == "auto" else model), ("budget", budget)):
        if value is not None and not checked:
            raise InputError(key, "is the check's, which is left out", value, "leave one of them out")
    if model != "auto":
        model_named(model)
    require_goals(None, budget, "0.05")


def _check_scenes(design: Design, scenes: Sequence[Result]) -> None:
    """Raise InputError for what is no simulated scene, or one of another skin."""
    names = set[str]()
    for result in scenes:
        scene = getattr(result, "scene", None)
        if scene is None:
            raise InputError("scenes", "must be what simulate returns", result, "skincad.simulate(scene)")
        if scene.grip is not None:
            rule = "must not be lifts: the report shows histories"
            raise InputError("scenes", rule, scene.name, "leave it out, or simulate it alone")
        if scene.design != design:
            remedy = "skincad.load_scene(name, skin=design)"
            raise InputError("scenes", "must be of the skin that is made", scene.name, remedy)
        if scene.name in names:
            raise InputError("scenes", "must have names of their own", scene.name, "rename one of them")
        names.add(scene.name)


def _import_everything(solids: bool, checked: bool) -> None:
    """Import before the clock starts: `seconds` is the work, not the libraries' loading."""
    if solids:
        import skincad.solids.occ  # isort: skip  # names the system libraries that miss, so it comes first
    import skincad.fabrication.measures

    if checked:
        import skincad.mechanics.models.linear  # noqa: F401


def _build(
    job: Job,
    verdict: ContactCheck | None,
    scenes: tuple[Result, ...],
    watch: Stopwatch,
    solids: bool,
    measured: bool,
) -> tuple[Build, list[PartReport]]:
    from skincad.fabrication.estimates import by_part, estimates
    from skincad.fabrication.filling import filling_findings
    from skincad.fabrication.findings import design_findings
    from skincad.fabrication.measures import interference
    from skincad.fabrication.meshes import asked_chord, mesh, print_chord
    from skincad.fabrication.pouring import pouring_findings
    from skincad.fabrication.strips import strip_findings

    designed, closed, choice = job.skin_part, job.closed, job.design.mold
    allowed, chord = asked_chord(job.design), print_chord(job.design)
    with watch.stage("meshes"):
        meshes = {part.name: mesh(part, chord) for part in (*closed.parts, *closed.plugs)}
        skin = mesh(designed, chord)
    build = Build(job, meshes, skin, (), verdict, scenes)
    shapes = [(designed, skin), *((part, meshes[part.name]) for part in closed.made)]
    if solids:
        with watch.stage("solids"):
            for part in (designed, *closed.parts, *closed.plugs):
                build.solid(part)
    if measured:
        with watch.stage("measuring"):
            reports = [_report(p, build.solid(p).val(), shape, chord, allowed) for p, shape in shapes]
    else:
        closed_meshes = (bool(s.is_watertight and s.is_winding_consistent) for _, s in shapes)
        rows = zip(shapes, closed_meshes, strict=True)
        reports = [PartReport(part.name, part.volume, whole, allowed) for (part, _), whole in rows]
    _check_meshes(reports)
    with watch.stage("interference"):
        gap = min(choice.clearance, choice.slit_clearance) or chord
        fine = max(FINEST_CHORD, min(chord, INTERFERENCE_SHARE * gap))
        findings = [*design_findings(job), *interference(closed, fine)]
        findings += [finding for stage in closed.earlier for finding in interference(stage, fine)]
        findings += [*filling_findings(job), *pouring_findings(job), *strip_findings(job)]
    with watch.stage("estimates"):
        effort = estimates(job, build.laid)
    alone = by_part(effort)
    reports = [replace(report, estimate=alone.get(report.name)) for report in reports]
    return replace(build, findings=tuple(findings), estimates=effort), reports


def _report(part: Part, solid: Any, mesh: Any, chord: float, allowed: float) -> PartReport:
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
        asked_deviation=allowed,
    )
