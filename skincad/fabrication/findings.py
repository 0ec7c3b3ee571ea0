"""All findings on a mold, and how the skin leaves its cavity."""

from __future__ import annotations

import math
from dataclasses import replace

from skincad.base.errors import InputError
from skincad.fabrication.electrodes import electrode_findings, fan_out_findings
from skincad.fabrication.finding import Finding
from skincad.fabrication.rules import (
    EDGE_RULES,
    LAYER_RULES,
    MACHINE_RULES,
    RULES,
    TOOL_RULES,
    Case,
    crest_findings,
    maker,
    material_findings,
    shim_findings,
)
from skincad.fabrication.sheet import closing_findings
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.process import processes
from skincad.shape.skin import VISIBLE, skin_of
from skincad.solids.cavity import SAFE_SHARE, safe_strain, split_ridges
from skincad.solids.mold import ClosedMold, mold

ALL_RULES = (*RULES, *TOOL_RULES, *EDGE_RULES, *LAYER_RULES, *MACHINE_RULES)
_ORDER = {"error": 0, "warning": 1, "note": 2}


def design_findings(design: Design, closed: ClosedMold | None = None) -> list[Finding]:
    """Return what the processes of a design can't make, of its films too, and what its skin can't leave,
    the gravest first.

    `closed` saves the planning of the mold. Print meshes are looked at for overhangs only; no CAD kernel.
    """
    closed = closed or mold(design)
    findings = [
        *process_findings(design, closed),
        *crest_findings(design, closed),
        *shim_findings(design),
        *closing_findings(design, closed),
        *electrode_findings(design),
        *fan_out_findings(design),
        *material_findings(design),
        *undercut_findings(design),
    ]
    return sorted(findings, key=lambda finding: _ORDER[finding.severity])


def process_findings(design: Design, closed: ClosedMold) -> list[Finding]:
    """Return what each part's process can't make of it, with the processes that could. Equal parts of
    the two ends make one finding."""
    known = processes(design.printer)
    findings: dict[tuple[str, str], Finding] = {}
    for part in closed.parts:
        if part.made != "made":
            continue
        name = maker(design, part)
        case = Case(design, part, name, known[name])
        fresh = [f for f in part_findings(case) if (f.rule, f.where) not in findings]
        if fresh:
            others = {
                n: part_findings(replace(case, name=n, process=p)) for n, p in known.items() if n != name
            }
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
    able = [
        name
        for name, findings in findings_by_process.items()
        if not any(
            f.severity != "note" or (f.rule, f.where) == (finding.rule, finding.where) for f in findings
        )
    ]
    return replace(finding, remedy=f"{finding.remedy}; or by {' or '.join(able)}") if able else finding


_ROUNDS = 20  # of a contraction by tan(lean) x root / 2 R, well below 0.2


def freeing_widths(design: Design) -> tuple[float | None, float | None]:
    """Return the root_width, or the tip_width, that frees the ridge that needs most; None where it can't be.

    A flank from (root / 2, -s) to (tip / 2, h - c) in the ridge's frame, s the base circle's fall over half a
    root, has the draft of the ridge's lean. A little is added, so that the design's own test finds none.
    """
    skin = skin_of(design)
    ridge, radius = skin.profile, design.skin.curvature_radius
    worst = least_drafted_ridge(design)
    slope, height = 2 * math.tan(abs(skin.lean(worst))), skin.heights[worst - 1]

    def draft(root: float) -> float:
        return slope * (height - ridge.crown + root**2 / (8 * radius)) + 4 * VISIBLE

    root = ridge.root_width
    for _ in range(_ROUNDS):
        root = ridge.tip_width + draft(root)
    changes = {"root_width": root, "tip_width": ridge.root_width - draft(ridge.root_width)}
    widths = []
    for key, value in changes.items():
        size = math.ceil(value * 1000) / 1000 if key == "root_width" else math.floor(value * 1000) / 1000
        widths.append(size if size > 0 and _leaves_freely(design, key, size) else None)
    return widths[0], widths[1]


def least_drafted_ridge(design: Design) -> int:
    """Return the ridge whose flanks need most draft: of ridges alike the outermost."""
    skin = skin_of(design)
    needs = [
        math.tan(abs(skin.lean(ridge))) * (height - skin.profile.crown)
        for ridge, height in enumerate(skin.heights, 1)
    ]
    return needs.index(max(needs)) + 1


def _leaves_freely(design: Design, key: str, value: float) -> bool:
    try:
        return not any(u.width for u in skin_of(design.with_(ridge={key: value})).undercuts.values())
    except InputError:
        return False


def undercut_findings(design: Design) -> list[Finding]:
    """Return a finding for every ridge that is squeezed on its way out; an error beyond what is safe. One
    whose groove is split leaves freely."""
    limit, free = safe_strain(design), split_ridges(design)
    caught = {
        r: undercut
        for r, undercut in skin_of(design).undercuts.items()
        if undercut.width > 0 and r not in free
    }
    if not caught:
        return []
    material = silicone(design)
    breaks = (
        f"{SAFE_SHARE:g} of {material.name}'s {100 * material.elongation_at_break:.0f} % elongation at break"
    )
    cure = _cure(design)
    return [
        Finding(
            rule="undercut",
            where=f"ridge {ridge}, {undercut.width:.4f} mm wide",
            measured=undercut.strain,
            limit=limit,
            unit="squeezed",
            severity="error" if undercut.strain > limit else "note",
            remedy=f"{cure} (limit: {breaks})",
        )
        for ridge, undercut in caught.items()
    ]


def _cure(design: Design) -> str:
    root, tip = freeing_widths(design)
    ways = [
        *([f"root_width of {root:g} mm"] if root else []),
        *([f"tip_width of {tip:g} mm"] if tip else []),
        'a split cavity (mold.split = "auto")' if design.mold.split == "none" else "",
        "a larger curvature_radius, or fewer ridges",
    ]
    worst = least_drafted_ridge(design)
    freed = "the outermost ridge" if worst in (1, skin_of(design).count) else f"ridge {worst}"
    return ", or ".join(way for way in ways if way) + f" frees {freed}"
