"""What an effect says of a scene that leaves it out: an indicator, from numbers at hand.

What it says is the change of the differential stress S1 - S2 that naming the effect brings: of any ridge and
at any time of the march the largest one, relative to the largest S1 - S2 of any ridge without the effect.
Where a scene tells no film's stress, the ridges' pulls stand for it, and without a pull their normal forces.
bench/table_left_out.py holds each against marches with and without its effect.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design

FAINT = 0.1
TINY = 1e-300


@dataclass(frozen=True)
class LeftOutEffect:
    """An effect left out, what points to it, and the relative change of the differential stress that it may
    bring; `calibrated` says whether that was held against runs with the effect, and `within` the factor, to
    either side, that held 90 % of random scenes which no constant saw."""

    effect: str
    indicator: str
    change: float
    calibrated: bool = False
    within: float | None = None

    def as_json(self) -> dict[str, Any]:
        """Return the entry under the contract's keys."""
        return {
            "effect": self.effect,
            "indicator": self.indicator,
            "estimated_change": self.change,
            "calibrated": self.calibrated,
            "within": self.within,
        }

    @property
    def warning(self) -> str:
        """What a scene that leaves it out is warned of."""
        how = f", {self.certainty}"
        may = f"leaving it out may change signals by {self.change:.0%}{how}"
        return f"{self.effect} is left out: {self.indicator}; {may}"

    @property
    def certainty(self) -> str:
        """How far the change is to be trusted."""
        if self.within is not None:
            return f"to a factor of {self.within:g}"
        return "calibrated" if self.calibrated else "an uncalibrated estimate"


@dataclass(frozen=True, eq=False)
class PlatePath:
    """What a march found: at `time` `(n,)` s the plate's `approach` and `travel` `(n,)` mm; of the ridges,
    `(n, ridges)`, the normal force `pressed` and the pull `pulled`, N, to +x, the share of their touching
    points that `slips`, and S1 - S2 `felt`, MPa, with no ridges where no film's stress is told."""

    time: Array
    approach: Array
    travel: Array
    pressed: Array
    pulled: Array
    slips: Array
    felt: Array

    @property
    def signal(self) -> Array:
        """S1 - S2, or what stands for it `(n, ridges)`."""
        for part in (self.felt, self.pulled):
            if np.abs(part).max(initial=0.0) > 0:
                return part
        return self.pressed

    def per_force(self) -> Array:
        """Return how much a ridge's signal rises with its normal force and its pull, `(2, ridges)` in the
        signal's unit per N: with the pull as it does in all ridges and steps together, with the normal force
        as what is left does in all of the ridge's steps. A ridge that bears less than FAINT of what the most
        loaded one bears feels its neighbours more than that: nothing goes with its own normal force then."""
        signal, pulled, normal = self.signal, self.pulled, self.pressed
        per_pull = float((signal * pulled).sum() / max((pulled**2).sum(), TINY))
        rest = ((signal - per_pull * pulled) * normal).sum(axis=0)
        down = rest / np.maximum((normal**2).sum(axis=0), TINY)
        borne = normal.max(axis=0)
        return np.array([np.where(borne > FAINT * borne.max(), down, 0.0), np.full_like(down, per_pull)])


@dataclass(frozen=True, eq=False)
class SceneOutline:
    """What an indicator looks at: the skin; the history's points, `time_s` and `loads` at them (normal force
    N, and tangential force N or, where the plate is `driven`, displacement mm); the `path` of the march; and
    the coefficient of static `friction`."""

    design: Design
    time_s: tuple[float, ...]
    loads: tuple[tuple[float, ...], ...]
    path: PlatePath
    driven: bool = False
    friction: float = 0.0

    @property
    def end(self) -> float:
        """How far the march got, s."""
        return float(self.path.time[-1])

    @property
    def pulls(self) -> bool:
        """Whether the history moves or pulls the plate along."""
        return any(self.loads[1])

    @property
    def ridge_normal(self) -> float:
        """The largest normal force on a ridge, N."""
        return float(self.path.pressed.max(initial=0.0))
