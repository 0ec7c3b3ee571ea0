"""Advice for a design that does not pass: why ridges stay clear, and single changes with which it would."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

from scipy import optimize

from skincad.base.errors import InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress
from skincad.fabrication.papers import macro
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.silicone import silicones
from skincad.mechanics.check import check, exceeds_model, mesh_tolerance
from skincad.mechanics.verdict import Change, ContactCheck
from skincad.shape.skin import skin_of
from skincad.studies.query import first_able
from skincad.studies.solving import MODELS
from skincad.studies.subject import changed, value_of

WORDS = "reasons/advice.txt"
AIM = 0.95  # of the asked force: what the change's force with its error is to be
GUESS = 1.2  # the upper end of an all-touch force over its value, while no model has given one
NEAR = 0.05  # relative: how near to the aim is enough
ENDS, STEPS, AGAIN = 3, 6, 2  # evaluations for the range's end, on the way, and judgements of a change
EVALUATIONS = 4  # that a search takes as a rule
UNSURE = 3.0  # the closed form's scaled force may be off by this factor; beyond it no costly model is run
PATIENCE = 10.0  # s; how long the commands look for advice at least
LEVELLING, MODULUS = "ridge.levelling", "material.young_modulus"
# keys that change the force needed, and how far one may go: times its value, of levelling to this value
LEVERS = {LEVELLING: 1.0, "skin.curvature_radius": 8.0, MODULUS: 1 / 8, "skin.length": 1 / 8}


def advise(
    design: Design, verdict: ContactCheck, *, budget: float | None = None, progress: Progress | None = None
) -> ContactCheck:
    """Return a check of the design with why it does not pass, and which single changes would.

    A change is solved for with a model of small strain, and checked with the verdict's own model. That takes
    as long as one to three checks a change. With a `budget` in seconds cheaper models are used where these
    would not fit: such a change is an estimate, and says by which model. A design that passes, or lies beyond
    its model's range, gets no advice. Raises InputError for a check of another design.
    """
    *_, advised = advising(design, verdict, progress, budget)
    return advised


def advising(
    design: Design, verdict: ContactCheck, progress: Progress | None = None, budget: float | None = None
) -> Iterator[ContactCheck]:
    """Yield the check with what `advise` adds to it, as far as it is known: first the cause, which takes no
    time, then each change, at last the notes."""
    if verdict.name != design.name or verdict.ridges != skin_of(design).count:
        raise InputError("verdict", f"is the verdict on {verdict.name}, not on {design.name}")
    if verdict.passed or verdict.out_of_range:
        yield verdict
        return
    advised = replace(verdict, cause=macro(WORDS, "cause", skin_of(design), verdict))
    yield advised
    deadline = math.inf if budget is None else perf_counter() + budget
    search = _Search(design, verdict, progress or (lambda *_: None), deadline)
    for key in LEVERS:
        search.cheap = False
        change = _change(key, search)
        if search.cheap and (change is None or change.model):
            search.hurried.append(key)
        if change:
            advised = replace(advised, changes=(*(advised.changes or ()), change))
            yield advised
    if search.hurried:
        search.notes.append(macro(WORDS, "hurried", budget, search.hurried))
    if search.notes or advised.changes is None:
        yield replace(
            advised,
            changes=advised.changes or (),
            changes_notes=tuple(search.notes),
            search_cut_short=bool(search.hurried),
        )


def seconds_for_advice(
    verdict: ContactCheck, wanted: bool | None = None, budget: float | None = None
) -> float:
    """Return for how many seconds to look for advice.

    If nobody has said whether it is `wanted`: as long as the check took, or PATIENCE, and 0 where the check
    had a `budget`. Else as long as it takes, or 0.
    """
    if wanted is None:
        return max(PATIENCE, verdict.seconds["total"]) if budget is None else 0.0
    return math.inf if wanted else 0.0


@dataclass
class _Search:
    """The models of one search for advice.

    `guide` looks for a value, `checks` says whether the verdict's own model checks it. `deadline` is a
    perf_counter time; if it is too near, the models are `cheap`. `hurried` lists the keys that therefore have
    no checked change. `forces` are the design's all-touch forces, N, by model.
    """

    design: Design
    verdict: ContactCheck
    progress: Progress
    deadline: float
    guide: str = ""
    checks: bool = True
    cheap: bool = False
    hurried: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.forces = {run.model: run.all_touch_force.value for run in self.verdict.models_tried}
        self.forces[self.verdict.model] = self.verdict.all_touch_force.value
        self.usual = self.verdict.model if self.verdict.model in MODELS else first_able(MODELS, self.design)

    def plan(self) -> None:
        """Choose the models for a change: the best pair for which the time that is left will do."""
        left, whole = self.deadline - perf_counter(), self.verdict.seconds["total"]
        once = whole
        if self.usual != self.verdict.model:
            before = {run.model: run.seconds for run in self.verdict.models_tried}
            once = before.get("linear", 0.0) + before.get(self.usual, 0.0) or whole
        pairs = [(self.usual, True), ("winkler", True), (self.usual, False), ("winkler", False)]
        seconds = {self.usual: EVALUATIONS * once, "winkler": 0.0}
        self.guide, self.checks = next(
            ((guide, checks) for guide, checks in pairs if seconds[guide] + checks * whole <= left), pairs[-1]
        )
        self.cheap = self.cheap or (self.guide, self.checks) != pairs[0]

    def check(self, model: str, key: str = "", value: float | str = 0.0) -> ContactCheck | None:
        """Return a model's check of the design with one key changed; None where that is refused."""
        try:
            design: Any = changed(self.design, {key: value}) if key else self.design
            what = f"{key.rpartition('.')[2]} {value}" if key else "as it is"
            self.progress(f"{what} by {model}")
            tol = mesh_tolerance(model, None)
            return check(design, force=self.verdict.force, model=model, tol=tol)
        except (InputError, RefusedError):
            return None

    def force(self, model: str, key: str = "", value: float = 0.0) -> float | None:
        """Return the all-touch force, N, of such a check."""
        verdict = self.check(model, key, value)
        return verdict.all_touch_force.value if verdict else None

    def scale(self) -> float:
        """Return the upper end of the verdict's all-touch force over the guide's value of it."""
        if self.guide not in self.forces:
            self.forces[self.guide] = self.force(self.guide)
        needed = self.verdict.all_touch_force
        less = self.forces[self.guide] or needed.value
        return needed.upper / less if needed.upper and less else GUESS


def _change(key: str, search: _Search) -> Change | None:
    """Return the least change of one key with which the design passes, None where none in reach does."""
    before = value_of(search.design, key)
    if key == MODULUS and search.design.material.name is not None:
        return _other_silicone(search)
    if not isinstance(before, int | float):
        return None
    far = LEVERS[key] if key == LEVELLING else LEVERS[key] * before
    if far == before:
        return None
    more = 1.0
    for _ in range(AGAIN):
        search.plan()
        scale = more * search.scale()
        value = _crossing(key, float(before), far, AIM * search.verdict.force / scale, search)
        if value is None:
            return None
        change, short = _checked(key, before, value, scale, search)
        if change or short is None:
            return change
        more *= short
    return None


def _checked(
    key: str, before: float | str, after: float | str, scale: float, search: _Search
) -> tuple[Change | None, float | None]:
    """Return the change if it passes; else by what factor it fell short, None where that is not known."""
    verdict = search.verdict
    better = search.check(verdict.model if search.checks else search.guide, key, after)
    if better is None:
        return None, None
    needed, known = better.all_touch_force, verdict.all_touch_force
    if not search.checks:
        upper = scale * (needed.value or 0.0)
        if needed.value is None or upper > verdict.force:
            return None, None
        value = upper / (1 + ((known.error or 0.0) / known.value if known.value else 0.0))
        return Change(key, before, after, Estimate(value, upper - value, "N"), search.guide), None
    if better.passed and not exceeds_model(changed(search.design, {key: after}), better):  # type: ignore[arg-type]
        return Change(key, before, after, needed), None
    if needed.upper is None or needed.value is None:
        return None, None
    return None, GUESS * needed.upper / (AIM * verdict.force)


def _crossing(key: str, before: float, far: float, wanted: float, search: _Search) -> float | None:
    """Return the value nearest to `before`, up to `far`, with a guide's force of about `wanted` N or less.

    The search takes the force to fall all the way: it looks for one value, and never says that there is none.
    """
    start = search.forces[search.guide]
    if start is None or start <= wanted:
        return None
    if search.guide != "winkler":  # the closed form, off by the same factor everywhere or UNSURE times that
        here, there = search.force("winkler"), search.force("winkler", key, far)
        if here and there is not None and start * there / here > UNSURE * wanted:
            return None
    forces: dict[float, float | None] = {before: start}

    def needed(value: float) -> float | None:
        if value not in forces:
            forces[value] = search.force(search.guide, key, value)
        return forces[value]

    def between(part: float) -> float:
        """The value at a part of the way to the far one: by ratio, but for levelling."""
        if part in (0.0, 1.0):
            return far if part else before
        return before + (far - before) * part if key == LEVELLING else before * (far / before) ** part

    for _ in range(ENDS):
        if needed(far) is not None:
            break
        far = between(0.5)  # refused: nearer to what there is

    def reached(value: float) -> bool:
        force = forces.get(value)
        return force is not None and force <= wanted * (1 + NEAR)

    if not reached(far):
        return None

    def off(part: float) -> float:
        force = needed(between(part))
        if force is None:
            raise RefusedError("refused on the way")
        return 0.0 if abs(force / wanted - 1) <= NEAR else math.log(max(force, 1e-9 * wanted) / wanted)

    with suppress(RefusedError):  # what is known by then counts
        optimize.brentq(off, 0.0, 1.0, xtol=1e-3, maxiter=STEPS, disp=False)
    nearest = min(filter(reached, forces), key=lambda value: abs(value - before))
    return two_digits(nearest, up=LEVERS[key] >= 1)


def _other_silicone(search: _Search) -> Change | None:
    """Return the hardest silicone with which the design passes: forces grow with the modulus. Where none in
    the list is soft enough, a note says so."""
    design, needed = search.design, search.verdict.all_touch_force
    if not needed.upper:
        return None
    wanted = silicone(design).young_modulus.value * AIM * search.verdict.force / needed.upper
    listed = {other: row.young_modulus.value for other, row in silicones(design.silicones).items()}
    softer = sorted((name for name in listed if listed[name] <= wanted), key=lambda name: -listed[name])
    for name in softer[:AGAIN]:
        search.plan()
        change, _ = _checked("material.name", str(design.material.name), name, search.scale(), search)
        if change:
            return change
    softest = min(listed, key=lambda name: listed[name])
    tried = softer[:AGAIN], softest, listed[softest]
    search.notes.append(macro(WORDS, "silicones", wanted, search.verdict.model, *tried))
    return None


def two_digits(value: float, *, up: bool) -> float:
    """Return the next value of two digits, above or below: a change is rather too large."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    steps = round(value / unit, 9)  # 9: 4.2 is 42 tenths, not 42.000000000000007
    return float(f"{(math.ceil(steps) if up else math.floor(steps)) * unit:.12g}")
