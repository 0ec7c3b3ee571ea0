"""Fabrication rules: each broken one is a finding with its place, measured value, limit and remedy."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from skincad.catalog import processes
from skincad.curves import polygon
from skincad.design import Design
from skincad.section import GUARD_TOLERANCE, section

UNDERCUT_SHARE = 0.1  # assumption: an overhang of a tenth of the root bends out of soft silicone untorn


@dataclass(frozen=True)
class Finding:
    """A broken rule. `error` fails the job, `warning` fails it under --strict, `note` never does."""

    rule: str
    where: str
    measured: float
    limit: float
    unit: str
    severity: Literal["note", "warning", "error"]
    remedy: str

    def as_json(self) -> dict[str, Any]:
        """Return the finding as plain data."""
        return asdict(self)

    def __str__(self) -> str:
        return (
            f"{self.severity}: {self.rule}: {self.where}: {self.measured:.4g} {self.unit}, "
            f"limit {self.limit:.4g}; {self.remedy}"
        )


def design_findings(design: Design) -> list[Finding]:
    """Return the findings that follow from the section alone: what the process can cut, and undercuts."""
    return [*_process_findings(design), *_undercut_findings(design)]


def _process_findings(design: Design) -> list[Finding]:
    ridge, name = design.ridge, design.mold.process
    limit = processes()[name]
    features = [
        ("gap", "cavity, groove of a ridge's tip", ridge.tip_width, limit.gap),
        ("wall", "cavity, tooth between two ridges' roots", ridge.pitch - ridge.root_width, limit.wall),
    ]
    if design.slot:
        width = design.slot.thickness + 2 * design.mold.slit_clearance
        features.append(("gap", "end plates, notch of a shim", width, limit.gap))
    return [
        Finding(rule, where, size, least, "mm", "warning", f"{name} can't make it: other process or scale")
        for rule, where, size, least in features
        if size < least and not (rule == "wall" and ridge.count == 1)
    ]


def undercuts(design: Design) -> dict[int, float]:
    """Return each ridge's overhang against the pull direction (the skin leaves the mold along its own -z),
    mm: by how much a flank widens towards the tip. Exact to the guards' chord tolerance."""
    result = {}
    for ridge in range(1, design.ridge.count + 1):
        own = tuple(s for s in section(design).outline if s.ridge == ridge)
        points = np.vstack([polygon(own, GUARD_TOLERANCE), own[-1].end])
        summit = int(np.argmax(points[:, 1]))
        right, left = points[: summit + 1, 0], -points[summit:, 0][::-1]
        overhang = max(float((side - np.minimum.accumulate(side)).max()) for side in (right, left))
        result[ridge] = overhang if overhang > 10 * GUARD_TOLERANCE else 0.0
    return result


def _undercut_findings(design: Design) -> list[Finding]:
    limit = UNDERCUT_SHARE * design.ridge.root_width
    return [
        Finding(
            "undercut",
            f"ridge {ridge}",
            width,
            limit,
            "mm",
            "error" if width > limit else "note",
            "flatter flanks (smaller tip_width or larger root_width), larger curvature_radius, fewer ridges",
        )
        for ridge, width in undercuts(design).items()
        if width > 0
    ]
