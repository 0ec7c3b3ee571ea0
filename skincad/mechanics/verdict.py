"""The verdict on a design: the numbers of `check` with their errors, and what follows from them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.base.progress import about
from skincad.base.result import Record, Result, estimate_columns, item, record, reported
from skincad.mechanics.left_out import ALONG, FRICTION, LeftOut
from skincad.mechanics.magnetics import MagnetSignal
from skincad.mechanics.problem import NEGLIGIBLE, Answer, DeformedPiece, SelfContact, Yield

FAR = 2.0  # times the force that all ridges need
# dB of a slow lift over noise. Chosen: of 20 drawn lifts of 100 g by a gripper of 40 ms, templates at -2 to
# 5 dB hold 9 to 13, those at 11 to 29 dB 17 to 20, by any slide and the detector's alarms for a gripper
HEARD = 6.0

Verdict = Literal["passes", "fails", "undecided"]


@dataclass(frozen=True)
class ModelRun(Record):
    """A model tried on the way to the verdict's own."""

    model: str = item(meaning="its name", key="tier")
    all_touch_force: Estimate = item("N", "its answer")
    seconds: float = item(meaning="beyond those of the models before")
    unknowns: int = item(meaning="of its finest mesh")


@dataclass(frozen=True)
class NextModel(Record):
    """The model that may decide, and about how many seconds it takes."""

    model: str = item(meaning="its name", key="tier")
    seconds: float = item(meaning="that it takes")


@dataclass(frozen=True)
class Change(Record):
    """One key's value `before` and `after`, with which the design passes.

    The verdict's own model has checked it; if not, `model` is the cheaper one that it is estimated with.
    """

    key: str = item(meaning="the key that is changed")
    before: float | str = item(meaning="its value now")
    after: float | str = item(meaning="its value with which the design passes")
    all_touch_force: Estimate = item("N", "all ridges touch from this force on")
    model: str = item(meaning="the model if it is an estimate", key="estimated_with", null=True, default="")

    @reported(meaning="whether the verdict's own model has checked it")
    def checked(self) -> bool:
        """Whether the verdict's own model has checked it."""
        return not self.model

    def __str__(self) -> str:
        """As `skin.curvature_radius 60 -> 76`."""
        values = (v if isinstance(v, str) else f"{v:g}" for v in (self.before, self.after))
        return f"{self.key} {' -> '.join(values)}"


@record()
class LiftSignal(Record):
    """How far the films' answer to a slow lift stands over the noise of film and amplifier."""

    pull: float = item("N", "of the object on the finger, reached along a straight line")
    rise: float = item("s", "in which it is reached")
    circuit: str = item(meaning="behind which amplifier")
    rate: float = item("Hz", "of its samples")
    ridge: int = item(meaning="whose pair of films gives the largest signal")
    signal: float = item("V", "rms of its S1 - S2 while the pull rises")
    noise: float = item("V", "rms of S1 - S2 from film and amplifier")
    level: float = item("dB", "of the signal over the noise", key="signal_to_noise_dB", error="level_error")
    level_error: float = item("dB", "by which the level may be off, from mesh and method")

    @reported(meaning="whether the level, but for its error, is enough for a warning")
    def heard(self) -> bool:
        """Whether the level, but for its error, is enough for a warning."""
        return self.level >= HEARD

    @reported(meaning="whether such a lift can be heard: heard, too weak, or undecided by the level's error")
    def verdict(self) -> Literal["heard", "too weak", "undecided"]:
        """`undecided` where the level's interval holds what is enough for a warning."""
        if abs(self.level - HEARD) < self.level_error:
            return "undecided"
        return "heard" if self.heard else "too weak"


@record()
class Holding(Record):
    """Which of some drawn lifts of an object a gripper with this skin holds: it stays and slides under 1 mm.

    `low` and `high` are the ends of the 95 % interval of the share (E. B. Wilson, J. Am. Stat. Assoc. 22
    (1927) 209). Without lifts `reason` says why there are none.
    """

    gripper: str = item(meaning="that grips, as grippers.toml has it")
    mass: float = item("g", "of the object")
    lifts: int = item(meaning="that were drawn")
    held: int = item(meaning="after which the object has stayed and slid by less than 1 mm")
    small_slides: int = item(meaning="the same as held")
    stayed: int = item(
        meaning="after which the object is in the fingers, at rest, on a skin that bears them, by any slide"
    )
    not_converged: int = item(meaning="whose march does not converge; they count as not held", default=0)
    share: float | None = item(meaning="of the lifts that are held", error="share_error")
    low: float | None = item(
        meaning="lower end of the share's 95 % interval, by the number of lifts alone: what small strain and "
        "the coarsest mesh change is not in it"
    )
    high: float | None = item(meaning="upper end of the same interval")
    mean_grip_ratio: float | None = item(
        meaning="mean force over the least that holds, of all lifts marched to their end, held or not"
    )
    dropped_by: Mapping[str, int] = item(meaning="lifts that are not held, by the cause")
    beyond: int = item(meaning="lifts in which the forces leave small strain's range")
    bears: float = item("N", "the largest force on this skin in small strain, if all ridges bear alike")
    circuit: str = item(meaning="behind which amplifier the films are heard")
    rate: float = item("Hz", "of its samples")
    reason: str = item(meaning="why no lift was marched", null=True, default="")
    seconds: float = item(meaning="wall time, s")

    @property
    def share_error(self) -> float | None:
        """How far the farther end of the interval is from the share."""
        if self.share is None or self.low is None or self.high is None:
            return None
        return max(self.high - self.share, self.share - self.low)


@record()
class ContactCheck(Result):
    """The check of a design under a plate. Errors are those of discretisation and of the model."""

    shown_by = "skincad.outputs.checks:CHECK"
    name: str = item(meaning="of the design")
    force: float = item("N", "the plate's force")
    plate: str = item(meaning="the plate's shape", default="flat")
    friction: float | None = item(meaning="the plate's coefficient; null: not known", default=None)
    family: str = "ridge"  # of what touches
    ridges: int = item(meaning="how many there are")
    touching: int = item(meaning="how many carry load")
    all_touch_force: Estimate = item("N", "all ridges touch from this force on")
    left_out: tuple[LeftOut, ...] = item(meaning="relative errors by what the model leaves out", default=())
    approach: Estimate = item("mm", "of the plate from first contact")
    ridge_force: tuple[Estimate, ...] = item("N", "on each ridge")
    model: str = item(meaning="by which model", key="tier")
    models_tried: tuple[ModelRun, ...] = item(meaning="the models before", key="climbed", default=())
    next_model: NextModel | None = item(meaning="the next with its seconds", key="next_tier", default=None)
    unknowns: int = item(meaning="of the finest mesh")
    residual: float = item(meaning="the largest relative violation of contact and equilibrium")
    manufacture: Yield | None = None
    out_of_range: str = item(
        meaning="why the verdict is outside the model's range", key="beyond_range", null=True, default=""
    )
    self_contact: SelfContact | None = item(
        meaning="from which force on the skin meets itself, or the plate off its crests", default=None
    )
    tipping: float = item(meaning="the most loaded ridge's force over that at which it tips", default=0.0)
    cause: str = item(meaning="why it fails, if requested", null=True, default="")
    changes: tuple[Change, ...] | None = None  # single ones with which it would pass; None: not looked for
    changes_notes: tuple[str, ...] = item(meaning="what the search for changes could not do", default=())
    search_cut_short: bool = False  # whether that search took cheaper models to end in time
    seconds: dict[str, float] = item(meaning="wall time by stage, s")
    warnings: tuple[str, ...] = item(meaning="what to know of the numbers")
    contact_width: Estimate | None = None  # mm, of a flat skin's face
    wire_first: tuple[int, ...] = item(
        meaning="ridges by the order in which to wire their films; none without films", default=()
    )
    lift_signal: LiftSignal | None = item(
        meaning="the films' signal of a slow lift, if asked and there are films", default=None, optional=True
    )
    holding: Holding | None = item(
        meaning="which lifts a gripper with this skin holds, if asked", default=None, optional=True
    )
    magnet: MagnetSignal | None = item(
        meaning="what sensors read of magnets in the pins, with [magnetometer]", default=None, optional=True
    )
    deformed: tuple[DeformedPiece, ...] = field(
        default=(), compare=False
    )  # by the linear model, if it solved

    @reported(meaning="passes, fails or undecided")
    def verdict(self) -> Verdict:
        """`undecided` where the asked force lies within the all-touch force's interval, or where the model's
        range ends before it."""
        needed, all_touch = self.all_touch_force, self.touching == self.ridges
        if self.out_of_range:
            return "undecided"
        if needed.upper is not None and needed.upper <= self.force and all_touch:
            return "passes"
        if needed.value is None and not all_touch:
            return "fails"
        return "fails" if needed.lower is not None and needed.lower > self.force else "undecided"

    @reported(meaning="whether all ridges touch for sure")
    def passed(self) -> bool:
        """Whether all ridges touch for sure: an undecided check has not passed."""
        return self.verdict == "passes"

    @reported(meaning="what may decide an undecided check", null=True)
    def next_step(self) -> str:
        """What may decide an undecided check, as a sentence; "" where it is decided."""
        if self.verdict != "undecided" or self.out_of_range:
            return "take a force within the model's range." if self.out_of_range else ""
        # errors that no better model removes; those of the closed form are included in better models
        parts = {part.effect: part.threshold for part in self.left_out if self.model != "winkler"}
        by_friction, by_both = parts.get(FRICTION, 0.0), parts.get(FRICTION, 0.0) + parts.get(ALONG, 0.0)
        if any(FRICTION_DECIDES in warning for warning in self.warnings):
            return "give contact.friction: without friction's error it is decided."
        if self.next_model and not is_undecidable(self, by_both):
            following = self.next_model
            return f"`--model {following.model}` (about {about(following.seconds)}) may decide."
        if by_friction and not is_undecidable(self, by_both - by_friction):
            return "give contact.friction: its error alone leaves this open."
        lower, upper = self.all_touch_force.lower or 0.0, self.all_touch_force.upper
        passes = "" if upper is None else f" The design passes from {upper:.3g} N"
        below = f" and fails below {lower:.3g} N" if lower > 0 else ""
        return f"{NO_MODEL}.{passes}{below}{passes and '.'}"

    @reported("N", "from the pessimistic end of the all-touch force to the plate's")
    def margin(self) -> float | None:
        """Newtons from the pessimistic end of the all-touch force to the asked one; negative where failed."""
        upper = self.all_touch_force.upper
        return None if upper is None else self.force - upper

    @reported("N", "the model's part of the all-touch force's error")
    def model_error(self) -> float:
        """The part of the all-touch force's error that is the model's, N."""
        return math.fsum(effect.threshold for effect in self.left_out) * (self.all_touch_force.value or 0.0)

    def columns(self) -> dict[str, Any]:
        """Return a row for each ridge: its number, and its force with its error, N."""
        numbers = list(range(1, self.ridges + 1))
        return {"ridge": numbers, **estimate_columns("ridge_force_N", self.ridge_force)}

    @property
    def exit_status(self) -> int:
        """0 where all ridges touch, else 1."""
        return 0 if self.passed else 1

    @reported(meaning="share of parts in which all ridges touch, and what it depends on", inline=True)
    def _yield(self) -> Yield | dict[str, None]:
        return self.manufacture or {"yield": None, "yield_interval": None}

    @reported(meaning="of a flat skin how wide its face touches", inline=True)
    def _face(self) -> dict[str, Estimate]:
        return {} if self.contact_width is None else {"contact_width_mm": self.contact_width}

    @reported(meaning="what wire_first rests on", null=True)
    def wire_first_rests_on(self) -> str:
        """What the order of wiring rests on; "" without films."""
        return WIRING if self.wire_first else ""

    @reported(meaning="what lets it pass", key="changes")
    def _changes(self) -> tuple[Change, ...]:
        return self.changes or ()

    @reported(meaning="whether the search for changes ended: complete, partial or null for none")
    def changes_searched(self) -> str | None:
        """How far changes were searched for."""
        return None if self.changes is None else "partial" if self.search_cut_short else "complete"


NO_MODEL = "no model here can decide it"
WIRING = "ridge_force_N: S1 - S2 of a pulled ridge grows with the pull until it slips, and so with its force"
EVEN = 0.01  # of the largest: ridges that bear the same but for this count as alike
FRICTION_DECIDES = "the verdict depends on friction, which is not known"


def wiring_order(ridge_force: Sequence[Estimate]) -> tuple[int, ...]:
    """Return ridges from 1 by the order in which to wire their films: those that bear most first.

    A press shows in S1 + S2 and a pull in S1 - S2, and both grow with what a ridge bears: it slips where the
    pull on it is friction times its force, and nearly all ridges answer a newton alike (to 10 % but for the
    outermost, tests/mechanics/film/test_stress.py). So the ridge that bears most speaks loudest, and sticks
    until the last. Of ridges that are alike the one nearest to those before it comes first, then the lower
    number.

    Chosen on 72 even seeds of bench/exam, judged once on 38 odd ones from 6001 to 6157 (25 gross slips, by
    three noises): `sure` warns of 56 % of the slips with the first two, of 28 % with the outermost two (28
    more, 4 to 52), of 46 % with any two (10 more, -4 to 23: not certain). Warnings come later: the median
    lead is 0.7 ms, with any two 1.6 ms. What two wired ridges hold: `python -m bench.lifts --what links`.
    """
    values = [force.value or 0.0 for force in ridge_force]
    left, order = list(range(len(values))), list[int]()
    while left:
        most = max(values[ridge] for ridge in left) - EVEN * max(values)
        near = math.fsum(order) / len(order) if order else (len(values) - 1) / 2
        chosen = min((r for r in left if values[r] >= most), key=lambda ridge: (abs(ridge - near), ridge))
        left.remove(chosen)
        order.append(chosen)
    return tuple(ridge + 1 for ridge in order)


def relative_error(check: ContactCheck, spared: float) -> float:
    """Error of the all-touch force, less the part `spared`, relative to its value or a negligible force."""
    value, error = check.all_touch_force.value, check.all_touch_force.error
    return (error - spared) / max(value, NEGLIGIBLE * check.force) if value and error else 0.0


def with_shortfall(check: ContactCheck, tol: float | None, spared: float) -> ContactCheck:
    """Say that the tolerance is not met, where no model's own warning does."""
    reached = relative_error(check, spared)
    if tol is None or reached <= tol or check.out_of_range or any("not met" in w for w in check.warnings):
        return check
    words = f"the all-touch force's error is {reached:.2g} of its value: the tolerance {tol:g} is not met"
    parts = [part for part in check.left_out if part.effect in (FRICTION, ALONG)]
    if parts and not spared:
        words += "; " + " and ".join(f"{part.effect} may change it by {part.threshold:.2g}" for part in parts)
        words += ": give contact.friction" if check.friction is None else ""
    return replace(check, warnings=(*check.warnings, words))


def with_open_friction(check: ContactCheck) -> ContactCheck:
    """Say that friction of an unknown coefficient alone leaves the verdict open."""
    force, part = check.all_touch_force, [b.threshold for b in check.left_out if b.effect == FRICTION]
    if check.out_of_range or check.friction is not None or not part or is_decided(check):
        return check
    known = replace(force, error=(force.error or 0.0) - part[0] * (force.value or 0.0))
    if not is_decided(replace(check, all_touch_force=known)):
        return check
    words = f"{FRICTION_DECIDES}: give contact.friction"
    return replace(check, warnings=(*check.warnings, words))


def before_refusal(check: ContactCheck, name: str, refusal: Exception) -> ContactCheck:
    """Return the last verdict before model `name` refused; out of range if the force is too large for it."""
    if isinstance(refusal, InputError) and refusal.key == "force":
        reason = f"the force {refusal.rule} (according to the {name} model)"
        return replace(check, out_of_range=reason, next_model=None, manufacture=None)
    words = f"the {name} model, which leaves out less, cannot judge this: {refusal}"
    return replace(check, warnings=(*check.warnings, words), next_model=None)


def without_mesh_tolerance(check: ContactCheck) -> ContactCheck:
    """Remove warnings about a mesh's share of the tolerance: `auto` set it, not the user."""
    return replace(check, warnings=tuple(w for w in check.warnings if "not met" not in w))


def is_decided(check: ContactCheck) -> bool:
    """Whether the whole interval of the all-touch force lies on one side of the asked force."""
    force = check.all_touch_force
    if force.value is None or force.error is None:
        return True
    return force.value + force.error <= check.force or force.value - force.error > check.force


def fails_by_far(check: ContactCheck) -> bool:
    """Whether the verdict is that the force is too little, and it is less than half of what is needed."""
    needed = check.all_touch_force.value
    return check.verdict == "fails" and needed is not None and needed >= FAR * check.force


def is_undecidable(check: ContactCheck, stays: float) -> bool:
    """Whether the force lies within the relative error `stays`, which no better model removes."""
    force = check.all_touch_force
    if force.value is None or force.error is None:
        return False
    stays *= force.value
    return abs(force.value - check.force) + force.error - stays <= stays


def with_model_error(answer: Answer, bounds: tuple[LeftOut, ...], force: float) -> Answer:
    """Add the bounds of the neglected effects to each error."""
    ridges = len(answer.ridge_force)
    share = (force / ridges if ridges > 1 else 0.0) * math.fsum(b.share for b in bounds)
    return answer.widened(
        math.fsum(b.threshold for b in bounds), math.fsum(b.approach for b in bounds), share
    )
