"""The verdict on a design: what `check` found, in numbers with their error, and what follows from them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple

from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.base.result import Result
from skincad.base.stopwatch import about
from skincad.mechanics.left_out import ALONG, FRICTION, LeftOut
from skincad.mechanics.problem import FLOOR, Answer, DeformedPiece, Manufacture

Verdict = Literal["passes", "fails", "undecided"]


class AskedTier(NamedTuple):
    """A tier asked on the way: its all-touch force, the seconds on top of those before, and its unknowns."""

    tier: str
    all_touch_force: Estimate
    seconds: float
    unknowns: int


@dataclass(frozen=True)
class Change:
    """One key's value `before` and `after`, with which the design passes: all ridges touch from
    `all_touch_force` on.

    The verdict's own model has checked it; if not, `model` is the cheaper one that it is estimated with.
    """

    key: str
    before: float | str
    after: float | str
    all_touch_force: Estimate
    model: str = ""

    def __str__(self) -> str:
        """As `skin.curvature_radius 60 -> 76`."""
        before, after = (
            value if isinstance(value, str) else f"{value:g}" for value in (self.before, self.after)
        )
        return f"{self.key} {before} -> {after}"

    def as_json(self) -> dict[str, Any]:
        """Return the change as in `--json`."""
        return {
            "key": self.key,
            "before": self.before,
            "after": self.after,
            "all_touch_force_N": self.all_touch_force.as_json(),
            "checked": not self.model,
            "estimated_with": self.model or None,
        }


@dataclass(frozen=True, repr=False)
class ContactCheck(Result):
    """The check at `force` N; `touching` of `ridges` carry load, `seconds` is wall time by stage.

    Errors are those of discretisation and of the model; `left_out` says what of the relative error is the
    model's, by effect. `residual` is the largest relative violation of contact and equilibrium. `climbed`
    holds the tiers before, `next_tier` the next with the seconds expected.
    """

    shown_by = "skincad.outputs.checks"
    name: str
    force: float
    ridges: int
    touching: int
    all_touch_force: Estimate
    approach: Estimate
    ridge_force: tuple[Estimate, ...]
    tier: str
    unknowns: int
    residual: float
    seconds: dict[str, float]
    warnings: tuple[str, ...]
    left_out: tuple[LeftOut, ...] = ()
    climbed: tuple[AskedTier, ...] = ()
    next_tier: tuple[str, float] | None = None
    manufacture: Manufacture | None = None
    plate: str = "flat"
    beyond: str = ""  # why the verdict is outside the model's range
    tipping: float = 0.0  # what the most loaded ridge bears of the force at which it tips over
    cause: str = ""  # why it fails, where that was asked
    changes: tuple[Change, ...] | None = None  # single ones with which it would pass; None: not looked for
    changes_notes: tuple[str, ...] = ()  # what the search for changes could not do
    hurried: bool = False  # whether that search took cheaper models to end in time
    friction: float | None = None  # the plate's coefficient; None where it is not known
    deformed: tuple[DeformedPiece, ...] = field(default=(), compare=False)  # by the linear tier, if it solved

    @property
    def verdict(self) -> Verdict:
        """`undecided` where the asked force lies within the all-touch force's interval, or where the model's
        range ends before it."""
        needed, all_touch = self.all_touch_force, self.touching == self.ridges
        if self.beyond:
            return "undecided"
        if needed.upper is not None and needed.upper <= self.force and all_touch:
            return "passes"
        if needed.value is None and not all_touch:
            return "fails"
        return "fails" if needed.lower is not None and needed.lower > self.force else "undecided"

    @property
    def passed(self) -> bool:
        """Whether all ridges touch for sure: an undecided check has not passed."""
        return self.verdict == "passes"

    @property
    def next_step(self) -> str:
        """What may decide an undecided check, as a sentence; "" where it is decided."""
        if self.verdict != "undecided" or self.beyond:
            return "take a force within the model's range." if self.beyond else ""
        by_friction, by_both = self._lasting
        if any(FRICTION_DECIDES in warning for warning in self.warnings):
            return "give contact.friction: without friction's error it is decided."
        if self.next_tier and not lost(self, by_both):
            model, seconds = self.next_tier
            return f"`--model {model}` (about {about(seconds)}) may decide."
        if by_friction and not lost(self, by_both - by_friction):
            return "give contact.friction: its error alone leaves this open."
        lower, upper = self.all_touch_force.lower or 0.0, self.all_touch_force.upper
        passes = "" if upper is None else f" The design passes from {upper:.3g} N"
        below = f" and fails below {lower:.3g} N" if lower > 0 else ""
        return f"no model here can decide it.{passes}{below}{passes and '.'}"

    @property
    def _lasting(self) -> tuple[float, float]:
        """Relative errors of the all-touch force that no better model takes away: of friction, and with that
        along y. The closed form leaves out both, and better models don't."""
        parts = {part.effect: part.threshold for part in self.left_out if self.tier != "winkler"}
        return parts.get(FRICTION, 0.0), parts.get(FRICTION, 0.0) + parts.get(ALONG, 0.0)

    @property
    def margin(self) -> float | None:
        """Newtons from the pessimistic end of the all-touch force to the asked one; negative where failed."""
        upper = self.all_touch_force.upper
        return None if upper is None else self.force - upper

    @property
    def model_error(self) -> float:
        """The part of the all-touch force's error that is the model's, N."""
        return math.fsum(effect.threshold for effect in self.left_out) * (self.all_touch_force.value or 0.0)

    @property
    def exit_status(self) -> int:
        """0 where all ridges touch, else 1."""
        return 0 if self.passed else 1

    def as_json(self) -> dict[str, Any]:
        """Return the `check` object of `--json`; the unit is the key's suffix."""
        return {
            "name": self.name,
            "passed": self.passed,
            "verdict": self.verdict,
            "next_step": self.next_step or None,
            "force_N": self.force,
            "plate": self.plate,
            "friction": self.friction,
            "ridges": self.ridges,
            "touching": self.touching,
            "all_touch_force_N": self.all_touch_force.as_json(),
            "margin_N": self.margin,
            "model_error_N": self.model_error,
            "left_out": [
                {"effect": effect.effect, "all_touch_force": effect.threshold, "approach": effect.approach}
                for effect in self.left_out
            ],
            "approach_mm": self.approach.as_json(),
            "ridge_force_N": [f.as_json() for f in self.ridge_force],
            "tier": self.tier,
            "climbed": [
                {
                    "tier": asked.tier,
                    "all_touch_force_N": asked.all_touch_force.as_json(),
                    "seconds": asked.seconds,
                    "unknowns": asked.unknowns,
                }
                for asked in self.climbed
            ],
            "next_tier": self.next_tier and {"tier": self.next_tier[0], "seconds": self.next_tier[1]},
            "unknowns": self.unknowns,
            "residual": self.residual,
            **self._manufacture(),
            "seconds": dict(self.seconds),
            "warnings": list(self.warnings),
            "beyond_range": self.beyond or None,
            "tipping": self.tipping,
            "cause": self.cause or None,
            "changes": [change.as_json() for change in self.changes or ()],
            "changes_searched": None if self.changes is None else "partial" if self.hurried else "complete",
            "changes_notes": list(self.changes_notes),
        }

    def _manufacture(self) -> dict[str, Any]:
        made = self.manufacture
        if made is None:
            return {"yield": None, "yield_interval": None}
        return {
            "yield": made.passing.value,
            "yield_error": made.passing.error,
            "yield_interval": list(made.interval),
            "crest_sensitivity_N_per_mm": list(made.crest_sensitivity),
            "modulus_sensitivity_N_per_MPa": made.modulus_sensitivity,
            "yield_largest_loss": made.largest,
        }


FRICTION_DECIDES = "the verdict depends on friction, which is not known"


def relative_error(found: ContactCheck, spared: float) -> float:
    """Error of the all-touch force, less what is spared of it, against its value or FLOOR."""
    value, error = found.all_touch_force.value, found.all_touch_force.error
    return (error - spared) / max(value, FLOOR * found.force) if value and error else 0.0


def with_shortfall(found: ContactCheck, tol: float | None, spared: float) -> ContactCheck:
    """Say that the tolerance is not met, where no tier's own warning does."""
    reached = relative_error(found, spared)
    if tol is None or reached <= tol or found.beyond or any("not met" in w for w in found.warnings):
        return found
    words = f"the all-touch force's error is {reached:.2g} of its value: the tolerance {tol:g} is not met"
    parts = [part for part in found.left_out if part.effect in (FRICTION, ALONG)]
    if parts and not spared:
        words += "; " + " and ".join(f"{part.effect} may change it by {part.threshold:.2g}" for part in parts)
        words += ": give contact.friction" if found.friction is None else ""
    return replace(found, warnings=(*found.warnings, words))


def with_open_friction(found: ContactCheck) -> ContactCheck:
    """Say that friction of an unknown coefficient alone leaves the verdict open."""
    force, part = found.all_touch_force, [b.threshold for b in found.left_out if b.effect == FRICTION]
    if found.beyond or found.friction is not None or not part or decided(found):
        return found
    known = replace(force, error=(force.error or 0.0) - part[0] * (force.value or 0.0))
    if not decided(replace(found, all_touch_force=known)):
        return found
    words = f"{FRICTION_DECIDES}: give contact.friction"
    return replace(found, warnings=(*found.warnings, words))


def before_refusal(found: ContactCheck, name: str, refusal: Exception) -> ContactCheck:
    """Return the last verdict before tier `name` refused; none where that tier knows why the force is too
    large."""
    if isinstance(refusal, InputError) and refusal.key == "force":
        beyond = f"the force {refusal.rule} (according to the {name} tier)"
        return replace(found, beyond=beyond, next_tier=None, manufacture=None)
    words = f"the {name} tier, which leaves out less, cannot judge this: {refusal}"
    return replace(found, warnings=(*found.warnings, words), next_tier=None)


def unasked_left_out(found: ContactCheck) -> ContactCheck:
    """Leave out that a share of the tolerance was not met: `auto` asked a tier for it, and nobody else."""
    return replace(found, warnings=tuple(w for w in found.warnings if "not met" not in w))


def decided(found: ContactCheck) -> bool:
    """Whether the whole interval of the all-touch force lies on one side of the asked force."""
    force = found.all_touch_force
    if force.value is None or force.error is None:
        return True
    return force.value + force.error <= found.force or force.value - force.error > found.force


def lost(found: ContactCheck, stays: float) -> bool:
    """Whether the asked force lies within what stays of the relative error, wherever better tiers move the
    rest."""
    force = found.all_touch_force
    if force.value is None or force.error is None:
        return False
    stays *= force.value
    return abs(force.value - found.force) + force.error - stays <= stays


def with_model(found: Answer, bounds: tuple[LeftOut, ...], force: float) -> Answer:
    """Add to each error what the model leaves out."""
    ridges = len(found.ridge_force)
    share = (force / ridges if ridges > 1 else 0.0) * math.fsum(b.share for b in bounds)
    return found.widened(math.fsum(b.threshold for b in bounds), math.fsum(b.approach for b in bounds), share)
