"""Whether a cast part's force against approach is that of a good part, and what departs if it is not.

A good part has a modulus within the material's range, uniform there, and crests whose heights scatter by the
mold's process, independent and normal; the plate is wet or powdered (or has `contact.friction`). A faulty
part has one of the `KINDS` besides; its size is taken as log-uniform between bounds in `_hypotheses`. Half
of all parts are taken as good, and all kinds of faults as equally frequent. By Bayes' theorem each kind has a
probability given the rows: its likelihood, the mean over modulus and size. The rows' errors are normal with
the standard deviations given; the approach's zero, the crests and the model's own error are normal too and
integrated out in closed form (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006,
eq. 2.43).

What no press under one flat plate can see: all crests higher or lower alike, as the zero is unknown, and a
ridge from its mirror image. The thresholds were set on the seeds 20000 to 20199 of bench/table_accept.py.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy import linalg, special, stats

from skincad.base.arrays import Array
from skincad.base.columns import UNITS
from skincad.base.errors import InputError, RefusedError, did_you_mean, require_number
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress, Stopwatch
from skincad.base.result import Record, Result, item, record, reported
from skincad.base.tables import NumberWithRange
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.measurements import (
    MaterialTest,
    PressCurve,
    press_curve,
)
from skincad.material.pad import PadCurve, fit_curve, small_strain_curve, tare
from skincad.material.press_model import (
    PressModel,
    good_curve,
    press_model,
    refuse_design,
    under_flat_plate,
)
from skincad.mechanics.validity import limits

FORCE_ERROR, APPROACH_ERROR = 0.05, 0.02  # N and mm, of a kitchen scale and a screw
KINDS = {
    "modulus": "the silicone's modulus is outside its range",
    "crests": "the crests' heights bend or tilt from side to side",
    "ridge": "a ridge or two did not fill",
    "back": "the back is soft: voids, glue or a bending holder",
    "friction": "the plate sticks: wet or powder it",
}
FACE_BENT = "the face bends or tilts from side to side"
LAYERED = "the modulus counts for all layers alike: a press sees them together"
GOOD_SHARE = 0.5  # of all parts, before the press
IN_FROM, OUT_FROM = 0.95, 0.95  # probability of a good part, and of a fault
ALONE_FROM = 0.95  # probability of the likeliest cause among faults, from which it is named alone
MISFIT = 1e-4  # probability of rows so far off; below it no cause fits
LEAST_RANGE = 0.03  # relative, of a modulus without a range; assumption: how batches of one mix differ
# What counts as a fault, from its least to its largest; less is what good parts may have
MODULUS_FAULT = (1.1, 4.0)  # times the range's ends
CREST_FAULT, RIDGE_FAULT = 0.06, 0.12  # of a ridge's height, at least
SOFT_BACK = (0.1, 2.0)  # of the good part's approach at the largest force
STICKING = (0.2, 1.0)  # of the change by a plate on which nothing slips
MODULI, SIZES = 25, 16
WRONG_UNIT = 6.0  # a modulus so many times off is another unit's, or another silicone's
MOST_OFF = 0.1  # of the largest force: rows that are less off a curve are of its form
FIRST_TOUCH = 0.2  # of the largest approach; a later first touch is no noise of the zero
CONFIDENCE = 1.96  # standard deviations of a 95 % interval


@dataclass(frozen=True)
class CauseFit(Record):
    """How well one cause explains the rows, and its size with the half-width of its 95 % interval.

    `misfit` is the least chi-square of the rows, of which `rows_used` is usual.
    """

    cause: str = item(meaning="modulus, crests, ridge, back or friction")
    words: str = item(meaning="the cause in words")
    probability: float = item("", "of this cause, given the rows")
    size: Estimate = item(meaning="of the fault, if it is the cause", key="size")
    unit: str = item(meaning="of the size")
    misfit: float = item(meaning="chi-square of the best fit")
    place: str = item(meaning="which ridge, or how the crests run", null=True, default="")


@record()
class Acceptance(Result):
    """Whether a pressed part is a good one; `verdict` is "in", "out" or "can't tell".

    `curve` is the rows' approach and force, `(rows,)` mm and N, `band` forces `(n,)` N and between which
    approaches `(n,)` mm 95 % of good parts lie.
    """

    shown_by = "skincad.outputs.measurements:ACCEPTANCE"
    name: str = item(meaning="of the design")
    verdict: str = item(meaning="in, out or can't tell")
    good_probability: float = item(meaning="that the part is good, given the rows")
    good_share: float = item(meaning="of such parts, before the press")
    cause: str | None = item(meaning="that fits best; null where the part is in, or none fits")
    alone: bool = item(meaning="whether no other cause fits nearly as well", key="cause_alone")
    causes: tuple[CauseFit, ...] = item(meaning="the likeliest first")
    young_modulus: Estimate = item("MPa", "if nothing but the modulus departs")
    modulus_range: tuple[float, float] = item("MPa", "of a good part")
    zero: Estimate = item("mm", "of the approach, for a part without faults")
    good_misfit: float = item(meaning="chi-square of the best good part")
    family: str = "ridge"  # of what touches
    rows: int = item(meaning="of the file")
    rows_used: int = item(meaning="with a force above its noise")
    largest_force: float = item("N", "of the rows")
    force_error: float = item("N", "standard deviation of a reading")
    approach_error: float = item("mm", "standard deviation of a reading")
    seconds: dict[str, float] = item(meaning="wall time by stage, s")
    warnings: tuple[str, ...] = item(meaning="what to know of the numbers")
    curve: tuple[Array, Array] = field(compare=False)
    band: tuple[Array, Array, Array] = field(compare=False)

    @reported(meaning="share of good parts from which this one is in, whatever the verdict")
    def in_from_share(self) -> float:
        """The share of good ones among such parts from which this part is in."""
        good, share = self.good_probability, self.good_share
        odds = good / max(1 - good, 1e-15) * (1 - share) / share  # by the rows alone
        return IN_FROM / (IN_FROM + (1 - IN_FROM) * odds)

    @reported(meaning="that the part is in")
    def passed(self) -> bool:
        """Whether the part is in."""
        return self.verdict == "in"

    @property
    def exit_status(self) -> int:
        """0 where the part is in, else 1."""
        return 0 if self.passed else 1

    @property
    def ranged(self) -> NumberWithRange:
        """The modulus as a design takes it, MPa."""
        value, error = self.young_modulus.value or 0.0, self.young_modulus.error or 0.0
        low, high = max(value - error, value / 10), value + error
        return NumberWithRange(
            value=float(f"{value:.4g}"), low=float(f"{low:.4g}"), high=float(f"{high:.4g}")
        )

    @property
    def measures_modulus(self) -> bool:
        """Whether the modulus is the silicone's: no other fault explains the rows better."""
        return self.verdict != "out" or self.cause == "modulus"


def accept(
    design: Design,
    press: Path | str | PressCurve,
    *,
    force_error: float = FORCE_ERROR,
    approach_error: float = APPROACH_ERROR,
    ruled_out: Sequence[str] = (),
    good_share: float = GOOD_SHARE,
    progress: Progress | None = None,
) -> Acceptance:
    """Return whether a pressed part of a design is good, and which cause fits best if it is not.

    `press` is a CSV with the columns `approach_mm, force_N`, of at least five rows under load.
    `force_error` N and `approach_error` mm are standard deviations of the readings. Causes that are
    `ruled_out` were excluded otherwise, as a ridge that did not fill by eye; a `contact.friction` of the
    design rules out friction. `good_share` is the share of good ones among such parts, known before: half of
    them unless given, so that a part is `in` only where its rows speak against every fault. Raises InputError
    for an unusable file, for plates and skins that `refuse_design` names, and for forces beyond the range of
    the model.
    """
    clock = Stopwatch(progress)
    for cause in ruled_out:
        if cause not in KINDS:
            raise InputError("ruled_out", "unknown cause", cause, did_you_mean(cause, KINDS))
    if len({*ruled_out}) == len(KINDS):
        raise InputError("ruled_out", "must leave a cause to look for", remedy="leave one of them out")
    require_number("good_share", good_share, lambda value: 0 < value < 1, "must be above 0 and below 1")
    known = ("friction",) if design.contact.friction is not None else ()
    with clock.stage("read"):
        curve = press if isinstance(press, PressCurve) else press_curve(press, force_error, approach_error)
        refuse_design(design)
    curve, model = model_for(design, curve, clock)
    with clock.stage("judge"):
        result = judge(design.name, [(model, curve)], {*ruled_out, *known}, good_share)
    more = (LAYERED,) if design.shot else ()
    return replace(result, warnings=(*result.warnings, *more), seconds=clock.seconds())


def model_for(design: Design, curve: PressCurve, clock: Stopwatch) -> tuple[PressCurve, PressModel]:
    """Return a press less its tare, and the curves of good and faulty parts, as far as the rows go.

    Raises InputError for forces beyond the model's range, and rows in other units.
    """
    first = small_strain_curve(under_flat_plate(design), silicone(design).young_modulus.value, clock)
    curve = usable(curve, first)
    largest = float(curve.force.max())
    reach = float(first.force_at(np.array([curve.approach.max()]))[0])
    _refuse_beyond(design, curve, first)
    good = good_curve(design, 1.2 * max(largest, reach), clock)
    _refuse_beyond(design, curve, good)
    tilted = design.contact.plate if design.contact.plate.shape == "tilted" else None
    return curve, press_model(design, good, clock, tilted)


def _refuse_beyond(design: Design, curve: PressCurve, model: PadCurve) -> None:
    """Raise InputError for rows beyond a model's end."""
    largest, end, of = float(curve.force.max()), float(model.force[-1]), limits(design).family
    if largest > end:
        ends = f"a {of} is strained by 0.3 or buckles" if of else "the skin is strained by 0.3"
        ends = ends if model.strained[-1] == 1 else "beyond, finite strain is not solved"
        rule = f"the model ends at {end:.3g} N: {ends}"
        raise InputError(f"{curve.name}, force_N", rule, largest, "leave out the rows beyond")


def _rows(curve: PressCurve) -> MaterialTest:
    return MaterialTest("pad", curve.approach, curve.force, curve.force.size, ())


def usable(curve: PressCurve, good: PadCurve) -> PressCurve:
    """Return the press without what the scale read before the plate touched, if that is more than noise.

    Raises InputError where the rows are far from the `good` curve: in another unit, or from another zero.
    """
    level = tare(good, _rows(curve))
    if abs(level) > 2 * curve.force_error:
        note = f"the scale read {level:.3g} N before the plate touched: this is subtracted; tare it"
        curve = replace(curve, force=curve.force - level, notes=(*curve.notes, note))
    _refuse_units(curve, good)
    return curve


def _refuse_units(curve: PressCurve, good: PadCurve) -> None:
    """Raise InputError where the rows are far from the design's: another unit, or another zero."""
    largest, deepest = float(curve.force.max()), float(curve.approach.max())
    usual = float(good.force_at(np.array([max(deepest, 1e-9)]))[0])
    ratio = largest / max(usual, 1e-12)
    try:
        fit = fit_curve(good, _rows(curve))
    except RefusedError:  # it follows the rows nowhere
        scale, touch, of_its_form = ratio, 0.0, False
    else:
        scale, touch = map(float, fit.values)
        of_its_form = fit.rms <= MOST_OFF * largest and 1 / WRONG_UNIT < scale < WRONG_UNIT
    if of_its_form or WRONG_UNIT**-2 < ratio < WRONG_UNIT**2:
        if touch > FIRST_TOUCH * deepest + 5 * curve.approach_error:
            rule = f"must count from the first touch, which is at about {touch:.3g} mm"
            raise InputError(
                f"{curve.name}, approach_mm", rule, remedy=f"subtract {touch:.3g} mm from all rows"
            )
        ratio = scale
    if 1 / WRONG_UNIT < ratio < WRONG_UNIT:
        return
    forces = {f"are forces in {unit}": (UNITS["N"][unit], 1.0) for unit in ("g", "kg", "mN", "lbf")}
    lengths = {f"are approaches in {unit}": (1.0, UNITS["mm"][unit]) for unit in ("um", "cm", "m", "inch")}
    off = {
        question: abs(np.log(largest * by / max(float(good.force_at(np.array([deepest * along]))[0]), 1e-12)))
        for question, (by, along) in {**forces, **lengths}.items()
    }
    rule = f"must be in mm and N: the rows are {ratio:.3g} times as stiff as the design"
    question = min(off, key=lambda words: off[words])
    raise InputError(curve.name, rule, remedy=f"{question}? Else name the silicone that was cast")


@dataclass(frozen=True)
class _Hypothesis:
    """A kind of parts: its `scales` `(s,)` of the modulus and its curves, of `sizes` `(t,)`, each with a
    label; `tables` `(t, k)` mm by model, and mm/N in series, `compliance` `(t,)`. Weights sum to 1."""

    scales: Array
    scale_weights: Array
    sizes: Array
    places: tuple[str, ...]
    tables: tuple[Array, ...]
    compliance: Array

    @property
    def weights(self) -> Array:
        """Prior weights `(s, t)`."""
        return np.outer(self.scale_weights, np.full(self.sizes.size, 1 / self.sizes.size))


def _hypotheses(models: Sequence[PressModel], largest: float) -> dict[str, _Hypothesis]:
    """The good part, and each kind of faults, by name."""
    model, none = models[0], np.zeros(1)
    low, high = (end / model.young_modulus for end in model.modulus_range)
    if high / low < 1 + 2 * LEAST_RANGE:
        low, high = low * (1 - LEAST_RANGE), high * (1 + LEAST_RANGE)
    inside = low + (high - low) * (np.arange(MODULI) + 0.5) / MODULI
    far = np.geomspace(*MODULUS_FAULT, 2 * MODULI)
    outside = np.concatenate([low / far[::-1], high * far])
    uniform = np.full(MODULI, 1 / MODULI)
    good = tuple(m.good[None] for m in models)
    hypotheses = {
        "good": _Hypothesis(inside, uniform, none, ("",), good, none),
        "modulus": _Hypothesis(outside, np.full(outside.size, 1 / outside.size), none, ("",), good, none),
    }

    def add(kind: str, sizes: Array, places: list[str], tables: list[Array], compliance: Array) -> None:
        hypotheses[kind] = _Hypothesis(inside, uniform, sizes, tuple(places), tuple(tables), compliance)

    least = CREST_FAULT * model.height
    warps, tilts = _between(model.warps, least), _between(model.tilts, least)
    shapes = ["bend"] * warps.size + ["tilt"] * tilts.size
    profiles = [
        np.hstack([_sampled(m.warps, m.warp.T, warps), _sampled(m.tilts, m.tilt.T, tilts)]).T for m in models
    ]
    sizes = np.concatenate([warps, tilts])
    add("crests", sizes, shapes, profiles, np.zeros(sizes.size))
    lacks = _between(model.missing, RIDGE_FAULT * model.height)
    told = max(models, key=lambda m: len(m.numbers))  # the one that tells a ridge from its image, if any
    ridges = [
        np.vstack(
            [
                np.zeros((0, m.force.size)),
                *(_sampled(m.missing, m.without(number).T, lacks).T for number in told.numbers),
                *(m.without_two(pair)[None] for pair in told.pairs),
            ]
        )
        for m in models
    ]
    names = [_ridge_name(told, number) for number in told.numbers for _ in lacks]
    names += [" and ".join(map(str, pair)) for pair in told.pairs]
    sizes = np.concatenate([np.tile(lacks, len(told.numbers)), np.full(len(told.pairs), model.height)])
    if names:  # not of a face
        add("ridge", sizes, names, ridges, np.zeros(len(names)))
    deep = float(np.interp(largest, model.force, model.good)) / largest
    soft = np.geomspace(*SOFT_BACK, SIZES) * deep
    add("back", soft, [""] * SIZES, [np.tile(m.good, (SIZES, 1)) for m in models], soft)
    stick = np.linspace(*STICKING, SIZES)
    stuck = [m.good * (1 + stick[:, None] * m.friction) for m in models]
    add("friction", stick, [""] * SIZES, stuck, np.zeros(SIZES))
    return hypotheses


def _ridge_name(model: PressModel, number: int) -> str:
    if model.alike:
        return model.alike[model.numbers.index(number)]
    if not model.mirrored:
        return f"{number}"
    other = model.last - number + 1
    return f"{number}" if other == number else f"{number} or {other}"


def _between(sizes: Array, least: float) -> Array:
    """Sizes `(t,)` from `least` on, even in the logarithm up to the largest solved one of each sign."""
    signs = [sizes[sizes < 0], sizes[sizes > 0]]
    parts = [np.sign(s[0]) * np.geomspace(least, abs(s).max(), SIZES) for s in signs if s.size]
    return np.sort(np.concatenate(parts))


def log_likelihood(
    hypothesis: _Hypothesis, curves: Sequence[tuple[PressModel, PressCurve]]
) -> tuple[Array, Array, Array]:
    """Return the logarithm of the rows' likelihood, chi-square and zero, each `(s, t)`; the zero in mm is
    that of the first curve."""
    shape = hypothesis.scales.size, hypothesis.sizes.size
    value, misfit, zero = np.empty(shape), np.empty(shape), np.empty(shape)
    for i, scale in enumerate(hypothesis.scales):
        residual, modes, noise = [], [], []
        for number, (model, curve) in enumerate(curves):
            used = curve.loaded
            approach, force = curve.approach[used], curve.force[used]
            expected = _sampled(model.force, hypothesis.tables[number], force / scale)
            expected = expected + hypothesis.compliance[:, None] * force
            good = _sampled(model.force, model.good[None], force / scale)[0]
            slope = np.interp(force / scale, model.force, np.gradient(model.good, model.force)) / scale
            own_zero = np.zeros((len(curves), force.size))
            own_zero[number] = curve.approach_error
            shared = (model.scale_error * good, _sampled(model.force, model.strained[None], force / scale)[0])
            crests = _sampled(model.force, model.crests, force / scale)
            residual.append(approach - expected)
            modes.append(np.vstack([own_zero, shared, crests]))
            read = curve.approach_error**2 + (slope * curve.force_error) ** 2
            noise.append(read + (model.row_error * good) ** 2)
        misses, spread = np.concatenate(residual, axis=1), np.concatenate(modes, axis=1)
        # the covariance is diagonal but for the few modes (Woodbury; Rasmussen and Williams, eq. A.9, A.10)
        alone = np.concatenate(noise)
        root = linalg.cho_factor(np.eye(len(spread)) + (spread / alone) @ spread.T, lower=True)
        solved = ((misses - linalg.cho_solve(root, spread / alone @ misses.T).T @ spread) / alone).T
        misfit[i] = (misses.T * solved).sum(axis=0)
        value[i] = -misfit[i] / 2 - np.log(root[0].diagonal()).sum() - np.log(alone).sum() / 2
        zero[i] = curves[0][1].approach_error * (spread[0] @ solved)
    return value, misfit, zero


def _sampled(known: Array, tables: Array, at: Array) -> Array:
    """Tables `(t, k)` mm over forces N or sizes mm `(k,)` at others `(n,)`, straight on beyond the last."""
    after = np.clip(np.searchsorted(known, at), 1, known.size - 1)
    share = (at - known[after - 1]) / (known[after] - known[after - 1])
    return np.asarray((1 - share) * tables[:, after - 1] + share * tables[:, after])


def judge(
    name: str,
    curves: Sequence[tuple[PressModel, PressCurve]],
    ruled_out: Collection[str] = (),
    good_share: float = GOOD_SHARE,
) -> Acceptance:
    """Return the verdict on one part by one or more presses, each with the model of its plate."""
    models, first = [model for model, _ in curves], curves[0][1]
    largest = float(first.force.max())
    hypotheses = _hypotheses(models, largest)
    logs = {kind: log_likelihood(h, curves) for kind, h in hypotheses.items()}
    evidence = {
        kind: float(special.logsumexp(value, b=hypotheses[kind].weights))
        for kind, (value, _, _) in logs.items()
    }
    kinds = [kind for kind in KINDS if kind not in ruled_out and kind in hypotheses]
    prior = {kind: (1 - good_share) / len(kinds) for kind in kinds} | {"good": good_share}
    names = list(prior)
    posterior = special.softmax([evidence[kind] + np.log(prior[kind]) for kind in names])
    probability = dict(zip(names, posterior.tolist(), strict=True))
    causes = sorted(
        (_cause(kind, hypotheses[kind], logs[kind], probability[kind], models[0]) for kind in kinds),
        key=lambda row: -row.probability,
    )
    rows = sum(int(np.count_nonzero(curve.loaded)) for _, curve in curves)
    good_misfit = float(logs["good"][1].min())
    least = min(good_misfit, *(row.misfit for row in causes))
    fits = float(stats.chi2.sf(least, rows)) > MISFIT
    good = probability["good"]
    verdict = "can't tell"
    if not fits or good <= 1 - OUT_FROM:
        verdict = "out"
    elif good >= IN_FROM:
        verdict = "in"
    faults = max(1.0 - good, 1e-300)
    modulus, zero = _modulus_and_zero(hypotheses, logs, models[0])
    return Acceptance(
        name=name,
        verdict=verdict,
        good_probability=good,
        good_share=good_share,
        cause=None if verdict == "in" or not fits else causes[0].cause,
        alone=fits and causes[0].probability >= ALONE_FROM * faults,
        causes=tuple(causes),
        young_modulus=modulus,
        modulus_range=models[0].modulus_range,
        zero=zero,
        good_misfit=good_misfit,
        family=models[0].family,
        rows=first.force.size,
        rows_used=rows,
        largest_force=largest,
        force_error=first.force_error,
        approach_error=first.approach_error,
        seconds={},
        warnings=(*first.notes, *_warnings(models[0], first)),
        curve=(first.approach, first.force),
        band=_band(models[0], largest),
    )


def _band(model: PressModel, largest: float) -> tuple[Array, Array, Array]:
    """Forces `(n,)` N, and the least and largest approach `(n,)` mm of 95 % of good parts, without noise."""
    force = largest * (np.arange(60) / 59) ** 2
    ends = []
    for end, sign in zip(model.modulus_range[::-1], (-1, 1), strict=True):
        at = force * model.young_modulus / end
        good = _sampled(model.force, model.good[None], at)[0]
        modes = _sampled(model.force, np.vstack([model.crests, model.strained]), at)
        ends.append(
            good + sign * CONFIDENCE * np.sqrt((modes**2).sum(axis=0) + (model.scale_error * good) ** 2)
        )
    return force, ends[0], ends[1]


def _warnings(model: PressModel, curve: PressCurve) -> tuple[str, ...]:
    what = "all crests" if model.numbers else "a face"
    notes = [f"{what} higher or lower alike can't be seen: the zero of the approach is unknown"]
    if model.mirrored and len(model.numbers) > 1:
        notes.append("a ridge can't be told from its mirror image under a level plate")
    if model.modulus_range[0] == model.modulus_range[1]:
        notes.append(f"the material has no range: ± {LEAST_RANGE:.0%} is taken")
    if curve.approach.size < 10:
        notes.append("fewer than ten rows: take ten")
    return tuple(notes)


def _cause(
    kind: str,
    hypothesis: _Hypothesis,
    logs: tuple[Array, Array, Array],
    probability: float,
    model: PressModel,
) -> CauseFit:
    """The fit of one cause: its size is the posterior mean, of its likeliest place."""
    value, misfit, _ = logs
    weight = special.softmax(value + np.log(hypothesis.weights))
    place = ""
    if kind == "modulus":
        sizes, over, unit = hypothesis.scales * model.young_modulus, weight.sum(axis=1), "MPa"
    else:
        by_place = dict.fromkeys(hypothesis.places, 0.0)
        for name, share in zip(hypothesis.places, weight.sum(axis=0).tolist(), strict=True):
            by_place[name] += share
        place = max(by_place, key=lambda name: by_place[name])
        chosen = np.array([name == place for name in hypothesis.places])
        sizes, over = hypothesis.sizes[chosen], weight.sum(axis=0)[chosen]
        unit = {"back": "mm/N", "friction": "1"}.get(kind, "mm")
    mean, spread = _mean_and_deviation(sizes, over)
    size = Estimate(mean, CONFIDENCE * spread, unit)
    words = FACE_BENT if model.family == "flat" and kind == "crests" else KINDS[kind]
    return CauseFit(
        kind, words.replace("ridge", model.family), probability, size, unit, float(misfit.min()), place
    )


def _mean_and_deviation(values: Array, weights: Array) -> tuple[float, float]:
    share = weights / weights.sum()
    mean = float(share @ values)
    return mean, float(np.sqrt(share @ (values - mean) ** 2))


def _modulus_and_zero(
    hypotheses: dict[str, _Hypothesis], logs: dict[str, tuple[Array, Array, Array]], model: PressModel
) -> tuple[Estimate, Estimate]:
    """Modulus and zero of a part without other faults, its modulus inside or outside the range."""
    kinds = ("good", "modulus")
    scales = np.concatenate([hypotheses[kind].scales for kind in kinds])
    widths = np.gradient(scales[np.argsort(scales)])[np.argsort(np.argsort(scales))]
    value = np.concatenate([logs[kind][0][:, 0] for kind in kinds])
    zero = np.concatenate([logs[kind][2][:, 0] for kind in kinds])
    weight = special.softmax(value + np.log(widths / scales))
    modulus, spread = _mean_and_deviation(scales * model.young_modulus, weight)
    at, off = _mean_and_deviation(zero, weight)
    return Estimate(modulus, CONFIDENCE * spread, "MPa"), Estimate(at, CONFIDENCE * off, "mm")
