"""Half a ridge with its fillets, in the ridge's own frame: (t, n) mm."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.inputs.design import Design


class HalfRidge(NamedTuple):
    """The ridge's side at +t in its own frame, from base circle to axis: (t, n) mm and radii."""

    base: tuple[float, float]
    flank_low: tuple[float, float]
    flank_high: tuple[float, float]
    crown: tuple[float, float]


def half_ridge(design: Design, height: float) -> HalfRidge:
    """Corners of half a ridge of a `height` in mm, with its fillets.

    A fillet's centre lies at its radius from the flank's line, and on a circle concentric with the base
    (or crown) circle; written with the circle's curvature, the quadratic stays exact for a flat one.
    """
    ridge, radius = design.ridge, design.skin.curvature_radius
    sag = 2 * radius * math.sin(math.asin(ridge.root_width / (2 * radius)) / 2) ** 2
    root = np.array([ridge.root_width / 2, -sag])
    edge = np.array([ridge.tip_width / 2, height - ridge.crown])
    flank = edge - root
    size = float(np.hypot(*flank))
    along = flank / size
    out = np.array([along[1], -along[0]])
    summit = np.array([0.0, height])
    crown_curvature = 2 * ridge.crown / (ridge.tip_width**2 / 4 + ridge.crown**2)
    _check_flank(design, _rise(root, along, 1 / radius), _rise(edge - summit, along, crown_curvature))
    r = ridge.root_fillet
    u = concentric_hit(root + r * out, along, 1 / radius, r + r * r / (2 * radius))
    if u is None:
        raise InputError("ridge.root_fillet", "does not fit between flank and base circle", r, "reduce it")
    low, centre = root + u * along, root + r * out + u * along
    base = centre * radius / (radius + r) - [0.0, r * radius / (radius + r)]
    r, curvature = ridge.tip_fillet, crown_curvature
    if curvature * r >= 1:
        raise InputError(
            "ridge.tip_fillet", f"must be less than {1 / curvature:.4g} mm (the crown's radius)", r
        )
    v = concentric_hit(edge - r * out - summit, along, curvature, curvature * r * r / 2 - r)
    if v is None:
        raise InputError("ridge.tip_fillet", "does not fit between flank and crown", r, "reduce it")
    high, inner = edge + v * along, edge - r * out + v * along - summit
    crown = (inner + np.array([0.0, r])) / (1 - curvature * r) + summit
    if u > size + v:
        raise InputError(
            "ridge.root_fillet",
            f"root and tip fillet need {u - v:.4g} mm of a flank of {size:.4g} mm",
            ridge.root_fillet,
            "take smaller fillets or a higher ridge",
        )
    if crown[0] < 0:
        raise InputError(
            "ridge.tip_fillet", "the two tip fillets overlap on the axis", r, "take a smaller one"
        )
    # without a fillet its two ends are one corner: 1e-17 mm between them would be an edge that crosses others
    base, low = (base, low) if ridge.root_fillet else (root, root)
    high, crown = (high, crown) if ridge.tip_fillet else (edge, edge)
    pairs = [(float(p[0]), float(p[1])) for p in (base, low, high, crown)]
    return HalfRidge(*pairs)


def _check_flank(design: Design, at_root: float, at_tip: float) -> None:
    """Raise InputError where a flank doesn't rise from the base circle, or not out of the crown's: by the
    sines of its angles with them, which no fillet changes."""
    ridge = design.ridge
    if at_root <= 0:
        rule = "is so wide and the ridge so low that its flanks begin inside the base circle"
        remedy = "make the ridge higher or less crowned, its root narrower, or curvature_radius larger"
        raise InputError("ridge.root_width", rule, ridge.root_width, remedy)
    if at_tip <= 0:
        rule = "makes the crown's edges as steep as the flanks or steeper"
        raise InputError("ridge.crown", rule, ridge.crown, "reduce it, or make the flanks steeper")


def _rise(start: Array, along: Array, curvature: float) -> float:
    """Sine of the angle by which a line rises from the circle of a curvature through its start, as below."""
    return float(along[1] + curvature * (start @ along))


def concentric_hit(start: Array, along: Array, curvature: float, level: float) -> float | None:
    """Solve n + curvature (t^2 + n^2) / 2 = level for u on the line start + u along, near u = 0.

    With curvature 1/R and level h + h^2 / (2 R) that is the circle of radius R + h about (0, -R), written so
    that a flat one is computed without cancellation. None where the line misses the circle or does not rise
    through it.
    """
    a, b = curvature / 2, _rise(start, along, curvature)
    c = float(start[1] + curvature * (start @ start) / 2 - level)
    inside = b * b - 4 * a * c
    if inside < 0 or b <= 0:
        return None
    return -2 * c / (b + math.sqrt(inside))
