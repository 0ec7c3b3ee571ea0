"""What a design that fails would need: why ridges stay clear, and single changes with which it would pass."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from skincad.base.errors import InputError, RefusedError
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.mechanics.climb import mesh_tolerance, outgrown
from skincad.mechanics.touching import check
from skincad.mechanics.verdict import Change, ContactCheck
from skincad.shape.crests import summits
from skincad.studies.asking import Asking
from skincad.studies.knobs import knob
from skincad.studies.question import Question, first_able, key_of, told_by
from skincad.studies.roots import UNSURE
from skincad.studies.solving import TIERS, crossings
from skincad.studies.subject import changed, value_of

NEEDED = "all_touch_force_N"
DIGITS = 2  # of a value that is proposed
AIM = 0.95  # of the asked force: what the change's force with its error is to be
GUESS = 1.2  # times its value: the upper end of a force that no model has told yet
NEAR = 0.05  # relative: how near to the aim is enough
TRIES, AGAIN = 9, 2  # evaluations of a search at most, and searches: the error may grow with the change


@dataclass(frozen=True)
class _Lever:
    """A key that changes the force needed, looked for from `low` to `high`, times its value if `times`."""

    key: str
    low: float
    high: float
    times: bool = True

    @property
    def grows(self) -> bool:
        """Whether larger values help."""
        return not self.times or self.high > 1

    def ends(self, value: float) -> tuple[float, float]:
        """Return the range in which a change is looked for."""
        return (self.low * value, self.high * value) if self.times else (value, self.high)


LEVERS = (
    _Lever("ridge.levelling", 0.0, 1.0, times=False),
    _Lever("skin.curvature_radius", 1.0, 8.0),
    _Lever("material.young_modulus", 1 / 8, 1.0),
    _Lever("skin.length", 1 / 8, 1.0),
)


def advise(design: Design, found: ContactCheck, *, progress: Progress | None = None) -> ContactCheck:
    """Return `check`'s verdict with why the design fails, and which single changes would pass.

    Each change is solved for, by a model for small strains if a dearer one judged, and told only where the
    model that judged, asked anew with that change alone, says that the design passes: that takes as long as
    one to three checks a change. A verdict that passes, or is none, stays as it is. Raises InputError for a
    verdict on another design.
    """
    *_, told = advising(design, found, progress)
    return told


def advising(design: Design, found: ContactCheck, progress: Progress | None = None) -> Iterator[ContactCheck]:
    """Yield the verdict with what `advise` adds to it as far as that is known: the cause, which takes no
    time, then each change."""
    if found.name != design.name or found.ridges != design.ridge.count:
        raise InputError("found", f"is the verdict on {found.name}, not on {design.name}")
    if found.passed or found.beyond:
        yield found
        return
    told = replace(found, cause=cause(design, found))
    yield told
    rough = found
    if found.tier not in TIERS:
        _tell(progress, "a simpler model")
        rough = check(design, force=found.force, tier=first_able(TIERS, design))
    for lever in LEVERS:
        if change := _change(design, lever, found, rough, progress):
            told = replace(told, changes=(*(told.changes or ()), change))
            yield told
    if told.changes is None:
        yield replace(told, changes=())


def _tell(progress: Progress | None, stage: str) -> None:
    if progress:
        progress(stage)


def cause(design: Design, found: ContactCheck) -> str:
    """Return why ridges stay clear, in mm: the crests against the plate's approach."""
    heights, approach = summits(design), found.approach.value or 0.0
    drop, high = max(heights) - min(heights), max(design.heights)
    return (
        f"the lowest crest lies {drop:.2g} mm below the highest, of ridges {high:g} mm high; at "
        f"{found.force:g} N the plate comes {approach:.2g} mm down"
    )


def _change(
    design: Design, lever: _Lever, found: ContactCheck, rough: ContactCheck, progress: Progress | None
) -> Change | None:
    """The least change of one key with which the design passes, None where none in reach does.

    It is looked for by the model of the verdict `rough`, whose force is taken to be off by the same factor
    everywhere.
    """
    before = value_of(design, lever.key)
    if not isinstance(before, int | float) or lever.ends(before)[0] >= lever.ends(before)[1]:
        return None
    question = Question("check", rough.tier, mesh_tolerance(rough.tier, None), found.force)
    needed, less = found.all_touch_force, rough.all_touch_force.value
    margin = needed.upper / (less or needed.value) if needed.value and needed.upper else GUESS
    for _ in range(AGAIN):
        wanted = AIM * found.force / margin
        asking = Asking(design, question, {NEEDED: wanted}, progress)
        start = key_of(design, {lever.key: before}, question)
        told = told_by(rough.as_json(), start, {lever.key: before})
        asking.name(told)
        asking.evaluations[told.key] = told
        turned = knob(design, lever.key, lever.ends(before))
        hopeless = _hopeless(asking, lever, before, wanted, less)
        solved = None if hopeless else next(iter(crossings(asking, {}, turned, NEAR, TRIES, [])), None)
        if solved is None:
            return None
        # rounded so that the change is rather too large
        value = _rounded(float(solved.values[lever.key]), up=lever.grows)
        try:
            better = changed(design, {lever.key: value})
            finest = mesh_tolerance(found.tier, None)
            _tell(progress, f"{lever.key.rpartition('.')[2]} {value:g} by {found.tier}")
            then = check(better, force=found.force, tier=found.tier, tol=finest)  # type: ignore[arg-type]
        except (InputError, RefusedError):
            return None
        if then.passed and not outgrown(better, then):  # type: ignore[arg-type]
            return Change(lever.key, before, value, then.all_touch_force)
        if then.all_touch_force.upper is None or then.all_touch_force.value is None:
            return None
        margin *= GUESS * then.all_touch_force.upper / (AIM * found.force)
    return None


def _hopeless(asking: Asking, lever: _Lever, before: float, wanted: float, value: float | None) -> bool:
    """Whether the closed form, off by the same factor everywhere or UNSURE times that, reaches nothing like
    what is wanted: then no costly model is asked."""
    end = lever.ends(before)[1 if lever.grows else 0]
    here, there = (asking.guide({lever.key: each}) for each in (before, end))
    if not asking.guided or value is None or not here or not there or here[0] <= 0:
        return False
    return value * there[0] / here[0] > UNSURE * wanted


def _rounded(value: float, *, up: bool) -> float:
    """A value of DIGITS digits, the next above or below."""
    unit = 10.0 ** (math.floor(math.log10(value)) + 1 - DIGITS)
    steps = value / unit
    return float(f"{(math.ceil(steps) if up else math.floor(steps)) * unit:.12g}")
