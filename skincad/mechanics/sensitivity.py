"""Sensitivities of the all-touch force to each dimension and the modulus, by the closed form's exponents.

An exponent is percent of force per percent of the key. The closed form alone misleads where a key acts on
the base that ridges share: it gives the base under a ridge to skin.width / ridge.count, where it is rather
the pitch, and knows no edges. So each key has an interval round the closed form's exponent, set against the
linear tier on the ten templates and the random designs of seeds 0 to 9 (bench/sensitivities.py), which lie
inside. Judged on seeds 10 to 19 it holds 70 of 78 exponents, at worst 3.0 half-widths off (seed 13, whose
radius counts by -1.59, not -1.0 ± 0.2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.problem import NEGLIGIBLE
from skincad.mechanics.tiers.winkler import all_touch_force
from skincad.shape.skin import skin_of

STEP = 1e-3  # relative, of each key, one way
KEYS = (
    "skin.curvature_radius",
    "skin.thickness",
    "skin.width",
    "skin.length",
    "ridge.pitch",
    "ridge.height",
    "ridge.root_width",
    "ridge.tip_width",
)
MODULUS = "material.young_modulus"
# half-widths of the exponents of single ridges and of the base circle
EXPONENT_MARGINS = {
    "skin.curvature_radius": 0.2,
    "ridge.height": 0.35,
    "ridge.root_width": 0.3,
    "ridge.tip_width": 0.4,
}
FREE_ENDS = 0.3  # assumption, of the length's: what free ends add, which the plane does not know
PROPORTIONAL_MARGIN = 0.01  # of what is proportional: rounding, and the linear tier's mesh
CONFINEMENT_MARGIN = (
    0.4  # by which a thicker base may count for more than its springs; at least it counts for nothing
)
EDGE_MARGIN = 0.009  # by the square of the number of ridges: what a margin that gets narrower may change
# of the pitch's exponent: below that of the gap alone, and above that of gap and base
PITCH_MARGIN_BELOW, PITCH_MARGIN_ABOVE = 0.1, 0.2


@dataclass(frozen=True)
class Sensitivity:
    """A key's value `now`, and the change of the all-touch force by 1 % more of it, N."""

    key: str
    now: float
    unit: str
    change: Estimate


def sensitivities(design: Design, force: float) -> tuple[Sensitivity, ...]:
    """Return the change of an all-touch force of `force` N by 1 % of each dimension, the largest first.

    Empty for a single ridge, and for a negligible all-touch force. A key that guards hold fixed is left out.
    """
    closed_force = all_touch_force(design)
    if skin_of(design).count == 1 or closed_force <= NEGLIGIBLE * design.contact.force:
        return ()
    ends = intervals(design, closed_force)
    now = {key: _value(design, key) for key in ends if key != MODULUS}
    now[MODULUS] = silicone(design).young_modulus.value
    rows = [
        Sensitivity(key, now[key], "MPa" if key == MODULUS else "mm", _change(low, high, force))
        for key, (low, high) in ends.items()
    ]
    return tuple(sorted(rows, key=lambda row: (float(f"{-abs(row.change.value or 0.0):.3g}"), row.key)))


def intervals(design: Design, closed_force: float) -> dict[str, tuple[float, float]]:
    """Return the interval of each key's exponent; `closed_force` N is the closed form's."""
    closed = {key: exponent for key in KEYS if (exponent := _exponent(design, closed_force, key)) is not None}
    edge = EDGE_MARGIN * skin_of(design).count ** 2
    result = {
        key: (closed[key] - off, closed[key] + off) for key, off in EXPONENT_MARGINS.items() if key in closed
    }
    if "skin.thickness" in closed:
        result["skin.thickness"] = closed["skin.thickness"] - CONFINEMENT_MARGIN, 0.0
    if "skin.width" in closed:
        result["skin.width"] = -edge, PROPORTIONAL_MARGIN
    if "ridge.pitch" in closed:
        base = closed.get("skin.width", 1.0)  # 1 is the most that it may be
        result["ridge.pitch"] = (
            closed["ridge.pitch"] - PITCH_MARGIN_BELOW,
            closed["ridge.pitch"] + base + edge + PITCH_MARGIN_ABOVE,
        )
    result["skin.length"] = 1 - FREE_ENDS, 1 + FREE_ENDS
    result[MODULUS] = 1 - PROPORTIONAL_MARGIN, 1 + PROPORTIONAL_MARGIN
    return result


def _change(low: float, high: float, force: float) -> Estimate:
    return Estimate((low + high) / 2 * force / 100, (high - low) / 2 * force / 100, "N")


def _value(design: Design, key: str) -> float:
    table, _, name = key.partition(".")
    return float(getattr(getattr(design, table), name))


def _exponent(design: Design, closed_force: float, key: str) -> float | None:
    """The logarithmic derivative of the closed form's force, one-sided where a guard forbids the other; None
    for a key that is not given or not free."""
    table, _, name = key.partition(".")
    now, ends = getattr(getattr(design, table), name), []
    if now is None:  # heights, one a ridge, in the place of one
        return None
    for by in (1 - STEP, 1 + STEP):
        try:
            ends.append((math.log(by), all_touch_force(design.with_(**{table: {name: now * by}}))))
        except InputError:
            ends.append((0.0, closed_force))
    (low, first), (high, last) = ends
    return None if low == high or min(first, last) <= 0 else math.log(last / first) / (high - low)
