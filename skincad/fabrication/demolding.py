"""How a skin leaves its cavity: straight along its own -z, each ridge out of its groove.

The fan of ridges is symmetric and leaves as one, so no ridge can give way sideways: every level of a ridge
has to pass the narrowest opening that the groove leaves on its way, w out of its width W. It is squeezed by
the nominal strain 1 - w / W; rubber keeps its volume and the skin is long, so it stretches upward by
W / w - 1, and that is held against the elongation at break. Friction and the ridge's bending are left out.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from skincad.catalog import silicone
from skincad.curves import polygon
from skincad.design import Design
from skincad.errors import InputError
from skincad.fabrication.finding import Finding
from skincad.section import GUARD_TOLERANCE, section

SAFE_SHARE = 0.2  # assumption: a cast edge has nicks, from which it tears long before a test bar does
_ROUNDS = 20  # of a contraction by tan(lean) x root / 2 R, well below 0.2
_VISIBLE = 10 * GUARD_TOLERANCE  # mm; less is the chords' own error


class Undercut(NamedTuple):
    """A ridge's overhang: mm by which a flank widens towards the tip, and the nominal squeeze to pass it,
    1 where nothing passes."""

    width: float
    strain: float


def undercuts(design: Design) -> dict[int, float]:
    """Return each ridge's overhang against the pull, mm, by its number."""
    return {ridge: undercut.width for ridge, undercut in squeezes(design).items()}


def squeezes(design: Design) -> dict[int, Undercut]:
    """Return each ridge's undercut, by its number. Exact to the guards' chord tolerance; 0 is below it."""
    return {ridge: _undercut(design, ridge) for ridge in range(1, design.ridge.count + 1)}


def _undercut(design: Design, ridge: int) -> Undercut:
    own = tuple(s for s in section(design).outline if s.ridge == ridge)
    points = np.vstack([polygon(own, GUARD_TOLERANCE), own[-1].end])
    summit = int(np.argmax(points[:, 1]))
    sides = points[: summit + 1], (points[summit:] * [-1.0, 1.0])[::-1]  # each from its foot to the summit
    mouths = [np.minimum.accumulate(side[:, 0]) for side in sides]
    width = max(float((side[:, 0] - mouth).max()) for side, mouth in zip(sides, mouths, strict=True))
    if width <= _VISIBLE:
        return Undercut(0.0, 0.0)
    levels = np.unique(np.concatenate([side[:, 1] for side in sides]))
    levels = levels[(levels >= max(s[0, 1] for s in sides)) & (levels < points[summit, 1])]
    # a side may dip at its foot where the ridge leans much: below the dip there is no groove
    heights = [np.maximum.accumulate(side[:, 1]) for side in sides]
    full = sum(np.interp(levels, z, side[:, 0]) for z, side in zip(heights, sides, strict=True))
    free = sum(np.interp(levels, z, mouth) for z, mouth in zip(heights, mouths, strict=True))
    return Undercut(width, min(1.0, float((1 - free / full).max())))


def safe_strain(design: Design) -> float:
    """Return the nominal squeeze that the silicone takes: its stretch is `SAFE_SHARE` of that at break."""
    return 1 - 1 / (1 + SAFE_SHARE * silicone(design.material).elongation_at_break)


def drafted(design: Design) -> tuple[float | None, float | None]:
    """Return the root_width, or the tip_width, that frees the outermost ridge; None where it can't be.

    A flank from (root / 2, -s) to (tip / 2, h - c) in the ridge's frame, s the base circle's fall over half a
    root, has the draft of the ridge's lean. A little is added, so that the design's own test finds none.
    """
    ridge, radius = design.ridge, design.skin.curvature_radius
    slope = 2 * math.tan(abs(design.lean(1)))

    def draft(root: float) -> float:
        return slope * (ridge.height - ridge.crown + root**2 / (8 * radius)) + 4 * _VISIBLE

    root = ridge.root_width
    for _ in range(_ROUNDS):
        root = ridge.tip_width + draft(root)
    changes = {"root_width": root, "tip_width": ridge.root_width - draft(ridge.root_width)}
    found = []
    for key, value in changes.items():
        size = math.ceil(value * 1000) / 1000 if key == "root_width" else math.floor(value * 1000) / 1000
        found.append(size if size > 0 and _free(design, key, size) else None)
    return found[0], found[1]


def _free(design: Design, key: str, value: float) -> bool:
    try:
        return not any(undercuts(design.with_(ridge={key: value})).values())
    except InputError:
        return False


def undercut_findings(design: Design) -> list[Finding]:
    """Return a finding for every ridge that is squeezed on its way out; an error beyond what is safe."""
    limit = safe_strain(design)
    found = {ridge: undercut for ridge, undercut in squeezes(design).items() if undercut.width > 0}
    if not found:
        return []
    material = silicone(design.material)
    breaks = (
        f"{SAFE_SHARE:g} of {material.name}'s {100 * material.elongation_at_break:.0f} % elongation at break"
    )
    cure = _cure(design)
    return [
        Finding(
            "undercut",
            f"ridge {ridge}, {undercut.width:.4f} mm wide",
            undercut.strain,
            limit,
            "squeezed",
            "error" if undercut.strain > limit else "note",
            f"{cure} (limit: {breaks})",
        )
        for ridge, undercut in found.items()
    ]


def _cure(design: Design) -> str:
    root, tip = drafted(design)
    ways = [
        *([f"root_width of {root:g} mm"] if root else []),
        *([f"tip_width of {tip:g} mm"] if tip else []),
        'a split cavity (mold.split = "auto")' if "split" in type(design.mold).model_fields else "",
        "a larger curvature_radius, or fewer ridges",
    ]
    return ", or ".join(way for way in ways if way) + " frees the outermost ridge"
