"""All findings of a design: each part against the process that makes it, the closed mold as a stack, and
the skin leaving its mold.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from skincad.base.errors import InputError
from skincad.fabrication.electrodes import electrode_findings, fan_out_findings
from skincad.fabrication.fasteners import end_screws
from skincad.fabrication.job import Job
from skincad.fabrication.machine_rules import LAYER_RULES, MACHINE_RULES, TOOL_RULES, crest_findings
from skincad.fabrication.rules import EDGE_RULES, RULES, Case, Finding, error, note, warning
from skincad.fabrication.strips import shim_findings
from skincad.inputs.design import Design
from skincad.inputs.gripper import gripper_named
from skincad.inputs.guards import CAP
from skincad.inputs.material import foreign_modulus
from skincad.shape.skin import VISIBLE, skin_of
from skincad.solids.cavity import SAFE_SHARE, safe_strain, split_ridges
from skincad.solids.fasteners import WASHER, run_out_room
from skincad.solids.layout import MOST_BOW, SEAL_PLAY, SHEETS, STOCK, bow, stack_error, thick_enough
from skincad.solids.pins import MAGNETS, SQUEEZE
from skincad.solids.plan import CutRole, PartRole, bores

ALL_RULES = (*RULES, *TOOL_RULES, *EDGE_RULES, *LAYER_RULES, *MACHINE_RULES)
_ORDER = {"error": 0, "warning": 1, "note": 2}
LEAST_RISER = 0.029  # of the skin's volume, a rounding below what a cup is made for (lids.py)
_ROUNDS = 20  # of a contraction by tan(lean) x root / 2 R, well below 0.2


def design_findings(job: Job) -> list[Finding]:
    """Return what the processes of a design can't make, of its films too, and what its skin can't leave,
    the gravest first. Print meshes are looked at for overhangs only; no CAD kernel.
    """
    findings = [
        *process_findings(job),
        *crest_findings(job),
        *mount_findings(job),
        *shim_findings(job),
        *closing_findings(job),
        *_filler_findings(job),
        *_riser(job),
        *electrode_findings(job),
        *fan_out_findings(job),
        *_material_findings(job.design),
        *undercut_findings(job),
    ]
    return sorted(findings, key=lambda finding: _ORDER[finding.severity])


def process_findings(job: Job) -> list[Finding]:
    """Return what each part's process can't make of it, with the processes that could. Equal parts of
    the two ends make one finding."""
    findings: dict[tuple[str, str], Finding] = {}
    for part in job.closed.made:
        name = job.maker(part)
        case = Case(job, part, name)
        fresh = [f for f in part_findings(case) if (f.rule, f.where) not in findings]
        if fresh:
            others = {n: part_findings(replace(case, name=n)) for n in job.processes if n != name}
            findings |= {(f.rule, f.where): _with_others(f, others) for f in fresh}
    return list(findings.values())


def part_findings(case: Case) -> list[Finding]:
    """Return the findings of one part by one process."""
    findings: dict[tuple[str, str], Finding] = {}
    for finding in (finding for rule in ALL_RULES for finding in rule(case)):
        findings.setdefault((finding.rule, finding.where), finding)
    return list(findings.values())


def _with_others(finding: Finding, findings_by_process: dict[str, list[Finding]]) -> Finding:
    """Add to a remedy the processes that make the part without a warning and without this finding."""
    same = finding.rule, finding.where
    able = [
        name
        for name, others in findings_by_process.items()
        if all(f.severity == "note" and (f.rule, f.where) != same for f in others)
    ]
    return replace(finding, remedy=f"{finding.remedy}; or by {' or '.join(able)}") if able else finding


def _riser(job: Job) -> Iterator[Finding]:
    """A note where the cup holds less than shrinkage and bubbles may take."""
    cups = bores(job.closed.first(PartRole.COVER), CutRole.RESERVOIR)
    share, least = cups[0].volume / job.poured_part.volume, LEAST_RISER
    if share < least:
        remedy = "top it up while the mix flows, as the sheet says, or a thicker mold.cover"
        yield note("riser", "cup over the vent, by the skin's volume", share, least, "", remedy)


def _filler_findings(job: Job) -> Iterator[Finding]:
    """Yield a warning where a bone's holes are straight, so that no rivet in them holds, and a note where a
    pocket is for no magnet that is sold."""
    if job.bone is not None and job.design.mold.bone_bond == "rivets" and not job.bone.locks:
        where = f"{len(job.bone.rivets)} straight holes of the bone, out of which silicone slides"
        remedy = "step or countersink them from the back, drill across, or mold.bone_bond = 'primer'"
        yield warning("bone rivets", where, 0.0, 1.0, "locks", remedy)
    pocket = job.design.features.pocket
    if pocket is not None and job.magnet is None:
        low, high = SQUEEZE
        near = min(MAGNETS, key=lambda size: abs(size - (low + high) / 2 - pocket.diameter))
        remedy = f"a magnet of {near:g} mm is held by {job.skin.family}.pocket.diameter of "
        remedy += f"{near - high:g} to {near - low:g} mm, at least {CAP:g} deeper than it is long"
        where = f"pockets of {pocket.diameter:g} x {pocket.depth:g} mm, which hold no usual magnet"
        yield note("pocket fit", where, pocket.diameter, near - low, "mm", remedy)


def _material_findings(design: Design) -> Iterator[Finding]:
    """Yield a warning where the material's name and its modulus are those of two silicones."""
    if mismatch := foreign_modulus(design):
        named, modulus, remedy = mismatch
        named_range, value = named.young_modulus, modulus.value
        where = f"material.young_modulus, which is not that of {named.name}"
        limit = named_range.high if value > named_range.high else named_range.low
        yield warning("silicone", where, value, limit, "MPa", remedy)


def mount_findings(job: Job) -> Iterator[Finding]:
    """Yield a note where a skin hangs over its gripper's face, and one where holes are a guess."""
    design = job.design
    if design.mold.mount is None:
        return
    gripper, name = gripper_named(design.mold.mount, design.grippers or {}), design.mold.mount
    for way, size, face in (
        ("width", design.skin.width, gripper.width),
        ("length", design.skin.length, gripper.length),
    ):
        if size > face + 1e-9:
            remedy = f"the carrier bears what hangs over; skin.{way} of {face:g} mm or less lies on the face"
            yield note("gripper face", f"skin's {way} on {name}", size, face, "mm", remedy)
    if not gripper.measured:
        remedy = f"measure yours, and give [grippers.{name}] its holes"
        yield note("gripper holes", f"{name}, whose holes are an assumption", 1.0, 0.0, "", remedy)


def freeing_widths(job: Job) -> tuple[float | None, float | None]:
    """Return the root_width, or the tip_width, that frees the ridge that needs most; None where it can't be.

    A flank from (root / 2, -s) to (tip / 2, h - c) in the ridge's frame, s the base circle's fall over half a
    root, has the draft of the ridge's lean. A little is added, so that the design's own test finds none.
    """
    skin = job.skin
    ridge, radius = skin.profile, job.design.skin.curvature_radius
    worst = least_drafted_ridge(job)
    slope, height = 2 * math.tan(abs(skin.lean(worst))), skin.heights[worst - 1]

    def draft(root: float) -> float:
        return slope * (height - ridge.crown + root**2 / (8 * radius)) + 4 * VISIBLE

    root = ridge.root_width
    for _ in range(_ROUNDS):
        root = ridge.tip_width + draft(root)
    root_key, tip_key = job.design.features.widths
    changes = {root_key: root, tip_key: ridge.root_width - draft(ridge.root_width)}
    widths = []
    for key, value in changes.items():
        size = math.ceil(value * 1000) / 1000 if key == root_key else math.floor(value * 1000) / 1000
        widths.append(size if size > 0 and _leaves_freely(job, key, size) else None)
    return widths[0], widths[1]


def least_drafted_ridge(job: Job) -> int:
    """Return the ridge whose flanks need most draft: of ridges alike the outermost."""
    skin = job.skin
    needs = [
        math.tan(abs(skin.lean(ridge))) * (height - skin.profile.crown)
        for ridge, height in enumerate(skin.heights, 1)
    ]
    return needs.index(max(needs)) + 1


def _leaves_freely(job: Job, key: str, value: float) -> bool:
    try:
        changed = job.design.with_(**{job.skin.family: {key: value}})
        return not any(u.width for u in skin_of(changed).undercuts.values())
    except InputError:
        return False


def undercut_findings(job: Job) -> list[Finding]:
    """Return a finding for every feature that is squeezed on its way out; an error beyond what is safe. One
    whose groove is split leaves freely. Pins make one finding, of the one that is squeezed most, and one of
    those that are beyond what is safe."""
    limit, free = safe_strain(job.design), split_ridges(job.design)
    caught = {
        r: undercut for r, undercut in job.skin.undercuts.items() if undercut.width > 0 and r not in free
    }
    if not caught:
        return []
    material = job.silicone
    most = 100 * material.elongation_at_break
    breaks = f"{SAFE_SHARE:g} of {material.name}'s {most:.0f} % elongation at break"
    cure = _cure(job)
    alike: dict[object, list[int]] = {}
    for number in sorted(caught, key=lambda n: -caught[n].strain) if job.holes else caught:
        alike.setdefault(caught[number].strain > limit if job.holes else number, []).append(number)
    findings = []
    for first, *others in alike.values():
        undercut, more = caught[first], f" and {len(others)} more, less" if others else ""
        where = f"{job.skin.named(first)}{more}, {undercut.width:.4f} mm wide"
        make = error if undercut.strain > limit else note
        remedy = f"{cure} (limit: {breaks})"
        findings.append(make("undercut", where, undercut.strain, limit, "squeezed", remedy))
    return findings


def _cure(job: Job) -> str:
    root, tip = freeing_widths(job)
    ridges, name = job.skin.form.parting == "flanks", job.skin.family
    root_key, tip_key = job.design.features.widths
    ways = [
        *([f"{root_key} of {root:g} mm"] if root else []),
        *([f"{tip_key} of {tip:g} mm"] if tip else []),
        'a split cavity (mold.split = "auto")' if job.design.mold.split == "none" and ridges else "",
        f"a larger curvature_radius, or fewer {name}s",
    ]
    worst = least_drafted_ridge(job)
    freed = f"the outermost {name}" if ridges and worst in (1, job.skin.count) else f"{name} {worst}"
    return ", or ".join(way for way in ways if way) + f" frees {freed}"


def closing_findings(job: Job) -> Iterator[Finding]:
    """Yield the warnings `cover bow` and `closing stack`, and the note `thread run-out`.

    A cover of a given thickness bows by more than `MOST_BOW` mm under 10 kPa. Carrier and keepers may stand
    so high or low that no seal both lets the cover lie on the cavity's walls and holds them down. A doubly
    curved mold may have too narrow a top for a seal, or too little thread.
    """
    place = job.place
    modulus = job.lid_process.part_modulus
    measured = bow(place.spans, place.lid, modulus)
    if measured > MOST_BOW * (1 + 1e-9):
        thick = thick_enough(place.spans, modulus, STOCK)
        remedy = f"mold.cover of {thick:g} mm, or a stiffer mold.lid_process"
        yield warning("cover bow", "cover, under 10 kPa", measured, MOST_BOW, "mm", remedy)
    off, most = stack_error(job.cast, place.spans, place.lid), SEAL_PLAY * SHEETS[-1]
    where = "carrier and keepers, under the "
    if job.bent and not job.closed.of(PartRole.SEAL):
        remedy = "lap the carrier's top until the cover lies on the cavity, or make the skin longer, or its "
        remedy += "curvature_radius_y larger, so that the narrow top has room for a seal"
        yield warning("closing stack", where + "cover, without a seal", off, 0.0, "mm", remedy)
    elif off > most:
        remedy = "finer processes, or a thicker mold.cover"
        yield warning("closing stack", where + "seal", off, most, "mm", remedy)
    if job.bent:
        yield from _run_outs(job)


def _run_outs(job: Job) -> Iterator[Finding]:
    """A note where the holes of both ends meet before a tap's lead has room: no screw is short enough."""
    screws, process = end_screws(job), job.cavity_process
    deep = min(bore.length for bore in bores(job.closed.first(PartRole.CAVITY), CutRole.END_THREAD))
    left = deep + job.design.mold.end_plate + screws.washers * WASHER - screws.length
    if screws.bottoming and left < run_out_room(process) - 1e-9:
        remedy = "finish these threads by a bottoming tap, as the casting sheet says, or make the skin longer"
        where = "screws of the end plates, from tip to the hole's end"
        yield note("thread run-out", where, left, run_out_room(process), "mm", remedy)
