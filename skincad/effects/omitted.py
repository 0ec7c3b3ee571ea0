"""What an effect says of a scene that leaves it out: an indicator, from numbers at hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from skincad.inputs.design import Design


@dataclass(frozen=True)
class Omitted:
    """An effect left out, what points to it, and the relative change of the differential stress that it may
    bring; `calibrated` says whether that was held against a run with the effect."""

    effect: str
    indicator: str
    change: float
    calibrated: bool = False

    def as_json(self) -> dict[str, Any]:
        """Return the entry under the contract's keys."""
        return {
            "effect": self.effect,
            "indicator": self.indicator,
            "estimated_change": self.change,
            "calibrated": self.calibrated,
        }

    @property
    def warning(self) -> str:
        """What a scene that leaves it out is warned of."""
        how = "" if self.calibrated else ", an uncalibrated estimate"
        may = f"leaving it out may change signals by {self.change:.0%}{how}"
        return f"{self.effect} is left out: {self.indicator}; {may}"


@dataclass(frozen=True)
class SceneOutline:
    """What an indicator looks at: the skin; the history's points, `time_s` and `loads` at them (normal force
    N, and tangential force N or displacement mm); how far a march got, `end` s, its largest `travel` and
    `approach`, mm, and the largest normal force on a ridge, N."""

    design: Design
    time_s: tuple[float, ...]
    loads: tuple[tuple[float, ...], ...]
    end: float
    travel: float
    approach: float
    ridge_normal: float = 0.0
