"""What a design that fails would need: why ridges stay clear, and single changes with which it would pass.

A change is looked for by the slope that the force needed has over it, on logarithmic scales, and told only
where the same model, asked anew with that change alone, says that the design passes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from skincad.base.errors import InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.problem import ContactError
from skincad.shape.crests import summits

DIGITS = 2  # of a value that is proposed
CLOSE = 0.9  # of the asked force: what needs so much is no larger a change than it has to be
AIM = 0.97  # of the asked force
TRIES = 4  # of a change; two or three are usual
FURTHEST = 8.0  # times or parts of a value that a change may come to


@dataclass(frozen=True)
class Change:
    """One key's value `before` and `after`, with which the design passes: all ridges touch from
    `all_touch_force` on."""

    key: str
    before: float
    after: float
    all_touch_force: Estimate

    def __str__(self) -> str:
        """As `skin.curvature_radius 60 -> 76`."""
        return f"{self.key} {self.before:g} -> {self.after:g}"

    def as_json(self) -> dict[str, Any]:
        """Return the change as in `--json`."""
        force = self.all_touch_force.as_json()
        return {"key": self.key, "before": self.before, "after": self.after, "all_touch_force_N": force}


@dataclass(frozen=True)
class _Lever:
    """A key that changes the force needed: roughly as its value to the power `slope`."""

    key: str
    slope: float
    value: Callable[[Design], float]
    changed: Callable[[Design, float], dict[str, Any]]


def _scaled_modulus(design: Design, value: float) -> dict[str, Any]:
    before = silicone(design).young_modulus
    scale = value / before.value
    wide = {"value": value, "low": before.low * scale, "high": before.high * scale}
    return {"material": {"young_modulus": wide}}


LEVERS = (
    # slopes of springs under an arc: as E and L, and as the crests' drop to the power 3/2
    _Lever(
        "skin.curvature_radius",
        -1.5,
        lambda design: design.skin.curvature_radius,
        lambda _, value: {"skin": {"curvature_radius": value}},
    ),
    _Lever(
        "material.young_modulus", 1.0, lambda design: silicone(design).young_modulus.value, _scaled_modulus
    ),
    _Lever(
        "skin.length", 1.0, lambda design: design.skin.length, lambda _, value: {"skin": {"length": value}}
    ),
)
Judge = Callable[[Design], tuple[bool, Estimate]]  # whether a design passes, and the force that it needs


def cause(design: Design, approach: float, force: float) -> str:
    """Return why ridges stay clear, in mm: the crests against the plate's approach at `force` N."""
    heights = summits(design)
    drop, high = max(heights) - min(heights), design.ridge.height
    return (
        f"the lowest crest lies {drop:.2g} mm below the highest, of ridges {high:g} mm high; at {force:g} N "
        f"the plate comes {approach:.2g} mm down"
    )


def changes(design: Design, needed: Estimate, force: float, judge: Judge) -> tuple[Change, ...]:
    """Return single changes with which a design that needs `needed`, more than `force` N, would pass.

    `judge` asks the model that said so. A change that no value within FURTHEST makes pass is left out, and
    one that the design's own rules or the model refuse.
    """
    found = (_change(design, lever, needed, force, judge) for lever in LEVERS)
    return tuple(change for change in found if change is not None)


def _change(design: Design, lever: _Lever, needed: Estimate, force: float, judge: Judge) -> Change | None:
    before, slope, found = lever.value(design), lever.slope, None
    seen = [] if needed.upper is None else [(0.0, math.log(needed.upper / force))]
    step = -math.copysign(math.log(2), slope)  # where no force is known to suffice
    for _ in range(TRIES):
        if seen:
            step = seen[-1][0] + (math.log(AIM) - seen[-1][1]) / slope
        if abs(step) > math.log(FURTHEST):
            break
        # rounded so that the change is rather too large
        value = _rounded(before * math.exp(step), up=step > 0)
        try:
            passed, then = judge(design.with_(**lever.changed(design, value)))
        except (InputError, RefusedError, ContactError):
            break
        if passed:
            found = Change(lever.key, before, value, then)
        if then.upper is None and not seen:
            step *= 2
            continue
        if then.upper is None or (passed and then.upper >= CLOSE * force):
            break
        seen.append((math.log(value / before), math.log(then.upper / force)))
        if len(seen) > 1:
            (x0, y0), (x1, y1) = seen[-2:]
            if x0 == x1 or (y1 - y0) / (x1 - x0) * lever.slope <= 0:
                break
            slope = (y1 - y0) / (x1 - x0)
    return found


def _rounded(value: float, *, up: bool) -> float:
    """A value of DIGITS digits, the next above or below."""
    unit = 10.0 ** (math.floor(math.log10(value)) + 1 - DIGITS)
    steps = value / unit
    return float(f"{(math.ceil(steps) if up else math.floor(steps)) * unit:.12g}")
