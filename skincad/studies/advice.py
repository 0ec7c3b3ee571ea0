"""Advice for a design that does not pass: why ridges stay clear, and single changes with which it would."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from time import perf_counter

from scipy import optimize

from skincad.base.errors import InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.silicone import silicones
from skincad.mechanics.check import check, exceeds_model, mesh_tolerance
from skincad.mechanics.verdict import Change, ContactCheck
from skincad.shape.skin import skin_of
from skincad.studies.query import first_able
from skincad.studies.solving import MODELS
from skincad.studies.subject import changed, value_of

DIGITS = 2  # of a value that is proposed
AIM = 0.95  # of the asked force: what the change's force with its error is to be
GUESS = 1.2  # the upper end of an all-touch force over its value, while no model has given one
NEAR = 0.05  # relative: how near to the aim is enough
ENDS, STEPS, AGAIN = 3, 6, 2  # evaluations for the range's end, on the way, and judgements of a change
EVALUATIONS = 4  # that a search takes as a rule
UNSURE = 3.0  # the closed form's scaled force may be off by this factor; beyond it no costly model is run
PATIENCE = 10.0  # s; how long the commands look for advice at least


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

    def end(self, value: float) -> float:
        """Return the value that helps most."""
        far = self.high if self.grows else self.low
        return far * value if self.times else far


MODULUS = "material.young_modulus"
LEVERS = (
    _Lever("ridge.levelling", 0.0, 1.0, times=False),
    _Lever("skin.curvature_radius", 1.0, 8.0),
    _Lever(MODULUS, 1 / 8, 1.0),
    _Lever("skin.length", 1 / 8, 1.0),
)


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
    advised = replace(verdict, cause=cause(design, verdict))
    yield advised
    search = _Search(design, verdict, progress, None if budget is None else perf_counter() + budget)
    for lever in LEVERS:
        search.cheap = False
        change = _change(design, lever, search)
        if search.cheap and (change is None or change.model):
            search.hurried.append(lever.key)
        if change:
            advised = replace(advised, changes=(*(advised.changes or ()), change))
            yield advised
    if search.hurried:
        *others, last = search.hurried
        keys = f"{', '.join(others)} and {last}" if others else last
        search.notes.append(
            f"to end within {budget:.2g} s, {keys} got cheaper models; --advice takes the time that it needs"
        )
    if search.notes or advised.changes is None:
        notes, hurried = tuple(search.notes), bool(search.hurried)
        yield replace(advised, changes=advised.changes or (), changes_notes=notes, search_cut_short=hurried)


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


def cause(design: Design, verdict: ContactCheck) -> str:
    """Return why ridges stay clear, in mm: the crests against the plate's approach."""
    skin = skin_of(design)
    heights, approach = skin.crests, verdict.approach.value or 0.0
    drop, high = max(heights) - min(heights), max(skin.heights)
    return (
        f"the lowest crest lies {drop:.2g} mm below the highest, of ridges {high:g} mm high; at "
        f"{verdict.force:g} N the plate comes {approach:.2g} mm down"
    )


@dataclass
class _Search:
    """The models of one search for advice.

    `guide` looks for a value, `checks` says whether the verdict's own model checks it. `deadline` is a
    perf_counter time; if it is too near, the models are `cheap`. `hurried` lists the keys that therefore have
    no checked change.
    """

    design: Design
    verdict: ContactCheck
    progress: Progress | None
    deadline: float | None
    guide: str = ""
    checks: bool = True
    cheap: bool = False
    hurried: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    forces: dict[str, Estimate] = field(default_factory=dict)  # of the design as it is, by model

    def __post_init__(self) -> None:
        for run in self.verdict.models_tried:
            self.forces[run.model] = run.all_touch_force
        self.forces[self.verdict.model] = self.verdict.all_touch_force
        self.usual = self.verdict.model if self.verdict.model in MODELS else first_able(MODELS, self.design)

    def plan(self) -> None:
        """Choose the models for a change: the best pair for which the time that is left will do."""
        left = math.inf if self.deadline is None else self.deadline - perf_counter()
        before = {run.model: run.seconds for run in self.verdict.models_tried}
        whole = self.verdict.seconds["total"]
        once = (
            whole
            if self.usual == self.verdict.model
            else before.get("linear", 0.0) + before.get(self.usual, 0.0)
        )
        search = {self.usual: EVALUATIONS * (once or whole), "winkler": 0.0}
        pairs = [(self.usual, True), ("winkler", True), (self.usual, False), ("winkler", False)]
        self.guide, self.checks = next(
            ((guide, checks) for guide, checks in pairs if search[guide] + checks * whole <= left), pairs[-1]
        )
        self.cheap = self.cheap or (self.guide, self.checks) != pairs[0]

    def force(self, model: str, key: str = "", value: object = None) -> ContactCheck | None:
        """Return a model's check of the design with one key changed; None where that is refused."""
        try:
            design = changed(self.design, {key: value}) if key else self.design  # type: ignore[dict-item]
            if self.progress:
                self.progress(
                    f"{key.rpartition('.')[2]} {value} by {model}" if key else f"as it is by {model}"
                )
            return check(
                design,  # type: ignore[arg-type]
                force=self.verdict.force,
                model=model,
                tol=mesh_tolerance(model, None),
            )
        except (InputError, RefusedError):
            return None

    def scale(self) -> float:
        """Return the upper end of the verdict's all-touch force over the guide's value of it."""
        if self.guide not in self.forces and (rough := self.force(self.guide)):
            self.forces[self.guide] = rough.all_touch_force
        needed, rough_force = self.verdict.all_touch_force, self.forces.get(self.guide)
        less = (rough_force.value if rough_force else None) or needed.value
        return needed.upper / less if needed.upper and less else GUESS


def _change(design: Design, lever: _Lever, search: _Search) -> Change | None:
    """Return the least change of one key with which the design passes, None where none in reach does."""
    before = value_of(design, lever.key)
    if lever.key == MODULUS and design.material.name is not None:
        return _other_silicone(design, search)
    if not isinstance(before, int | float) or lever.end(before) == before:
        return None
    more = 1.0
    for _ in range(AGAIN):
        search.plan()
        scale = more * search.scale()
        value = _crossing(lever, float(before), AIM * search.verdict.force / scale, search)
        if value is None:
            return None
        change, short = _checked(lever.key, before, value, scale, search)
        if change or short is None:
            return change
        more *= short
    return None


def _checked(
    key: str, before: float | str, after: float | str, scale: float, search: _Search
) -> tuple[Change | None, float | None]:
    """Return the change if it passes; else by what factor it fell short, None where that is not known."""
    verdict = search.verdict
    model = verdict.model if search.checks else search.guide
    better = search.force(model, key, after)
    if better is None:
        return None, None
    needed = better.all_touch_force
    if not search.checks:
        upper = scale * (needed.value or 0.0)
        if needed.value is None or upper > verdict.force:
            return None, None
        known = verdict.all_touch_force
        error = (known.error or 0.0) / known.value if known.value else 0.0
        value = upper / (1 + error)
        return Change(key, before, after, Estimate(value, upper - value, "N"), model), None
    if better.passed and not exceeds_model(changed(search.design, {key: after}), better):  # type: ignore[arg-type]
        return Change(key, before, after, needed), None
    if needed.upper is None or needed.value is None:
        return None, None
    return None, GUESS * needed.upper / (AIM * verdict.force)


def _crossing(lever: _Lever, before: float, wanted: float, search: _Search) -> float | None:
    """Return the least change at which the guide's all-touch force is about `wanted` N or less.

    The search takes the force to fall all the way: it looks for one value, and never says that there is none.
    """
    forces: dict[float, float] = {}

    def needed(value: float) -> float | None:
        if value not in forces:
            rough = search.force(search.guide, lever.key, value)
            if rough is None or rough.all_touch_force.value is None:
                return None
            forces[value] = rough.all_touch_force.value
        return forces[value]

    start = search.forces.get(search.guide)
    if (
        start is None
        or start.value is None
        or start.value <= wanted
        or _hopeless(lever, before, wanted, search)
    ):
        return None
    forces[before], far = start.value, lever.end(before)
    for _ in range(ENDS):
        if needed(far) is not None:
            break
        far = (
            math.sqrt(far * before) if lever.times else (far + before) / 2
        )  # refused: nearer to what there is
    if far not in forces or forces[far] > wanted * (1 + NEAR):
        return None

    def off(place: float) -> float:
        value = before * (far / before) ** place if lever.times else before + (far - before) * place
        value = far if place == 1.0 else before if place == 0.0 else value
        force = needed(value)
        if force is None:
            raise RefusedError("refused on the way")
        return 0.0 if abs(force / wanted - 1) <= NEAR else math.log(max(force, 1e-9 * wanted) / wanted)

    with suppress(RefusedError):  # what is known by then counts
        optimize.brentq(off, 0.0, 1.0, xtol=1e-3, maxiter=STEPS, disp=False)
    enough = [value for value, force in forces.items() if force <= wanted * (1 + NEAR)]
    return _rounded(min(enough, key=lambda value: abs(value - before)), up=lever.grows)


def _hopeless(lever: _Lever, before: float, wanted: float, search: _Search) -> bool:
    """Whether the closed form, off by the same factor everywhere or UNSURE times that, reaches nothing like
    what is wanted: then no costly model is run."""
    if search.guide == "winkler":
        return False
    here, there = search.force("winkler"), search.force("winkler", lever.key, lever.end(before))
    if not here or not there or not here.all_touch_force.value or there.all_touch_force.value is None:
        return False
    ratio = there.all_touch_force.value / here.all_touch_force.value
    return (search.forces[search.guide].value or 0.0) * ratio > UNSURE * wanted


def _other_silicone(design: Design, search: _Search) -> Change | None:
    """Return the hardest silicone with which the design passes: forces grow with the modulus. Where none in
    the list is soft enough, a note says so."""
    needed, name = search.verdict.all_touch_force, str(design.material.name)
    if not needed.upper:
        return None
    modulus = silicone(design).young_modulus.value
    wanted = modulus * AIM * search.verdict.force / needed.upper
    listed = {other: row.young_modulus.value for other, row in silicones(design.silicones).items()}
    softer = sorted((row for row in listed.items() if row[1] <= wanted), key=lambda row: -row[1])
    for other, _ in softer[:AGAIN]:
        search.plan()
        change, _ = _checked("material.name", name, other, search.scale(), search)
        if change:
            return change
    softest = min(listed, key=lambda other: listed[other])
    if softer:
        names = " and ".join(other for other, _ in softer[:AGAIN])
        search.notes.append(
            f"it takes about {wanted:.2g} MPa; the {search.verdict.model} model can't confirm that the "
            f"design passes with {names}"
        )
        return None
    search.notes.append(
        f"no silicone in the list was found soft enough: it takes about {wanted:.2g} MPa, and the softest, "
        f"{softest}, has {listed[softest]:.2g} MPa"
    )
    return None


def _rounded(value: float, *, up: bool) -> float:
    """A value of DIGITS digits, the next above or below: the change is rather too large."""
    unit = 10.0 ** (math.floor(math.log10(value)) + 1 - DIGITS)
    steps = round(value / unit, 9)  # 9: 4.2 is 42 tenths, not 42.000000000000007
    return float(f"{(math.ceil(steps) if up else math.floor(steps)) * unit:.12g}")
