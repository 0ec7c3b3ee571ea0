"""All findings of a design: each part against the process that makes it, and the skin leaving its mold."""

from __future__ import annotations

from dataclasses import replace

from skincad.fabrication.closing import closing_findings
from skincad.fabrication.demolding import undercut_findings
from skincad.fabrication.electrodes import electrode_findings
from skincad.fabrication.fan_out import fan_out_findings
from skincad.fabrication.finding import Finding
from skincad.fabrication.knife_edges import EDGE_RULES
from skincad.fabrication.rules import RULES, Case, maker, material_findings, shim_findings
from skincad.fabrication.rules_of_layers import LAYER_RULES, crest_findings
from skincad.fabrication.rules_of_machines import MACHINE_RULES
from skincad.fabrication.rules_of_tools import TOOL_RULES
from skincad.inputs.design import Design
from skincad.inputs.process import processes
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
