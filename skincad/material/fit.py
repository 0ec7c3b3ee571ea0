"""The silicone's modulus from a test: a cast pad pressed by a flat plate, or a bar pulled or squeezed.

Its error has three parts: scatter of the rows, uncertainty of the model, and what the test's first half alone
says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError, require_number
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress, Stopwatch
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.measurements import FEWEST_ROWS, MaterialTest, material_test
from skincad.material.laws import compare_laws
from skincad.material.modulus import (
    LOADED_SHARE,
    Fit,
    MaterialFit,
    Regression,
    material_fit,
    refuse_misfit,
    regression,
    with_laws,
)

UP_TO_STRAIN = 0.3  # assumption: silicones leave the neo-Hookean law beyond it
STIFF, FAR_OFF = 10.0, 10.0  # MPa, and times the modulus of the silicone that is named
PERCENT = 2.0  # strain: with few rows up to UP_TO_STRAIN it is no part of the length
SOFT = 0.005  # MPa; the softest gels that are cast have 0.01
LARGEST_UP_TO = 3.0  # strain, assumption: no casting silicone follows the law so far
SPARE_ROWS = 3  # more than the constants of a bar's fit, at least
LEAST_LOAD_RATIO = (
    2.0  # the largest load over the smallest, at least; with less, modulus and offset are not separable
)


def fit_material(
    path: Path | str,
    design: Design | None = None,
    *,
    up_to: float | None = None,
    gauge_length: float | None = None,
    area: float | None = None,
    progress: Progress | None = None,
) -> MaterialFit:
    """Return the modulus from a test's CSV; its columns give the kind of test (measurements.material_test).

    A pad's test needs the `design` that was pressed. `up_to` is the largest strain of a bar (0.3 if None) or
    force in N of a pad that is used; laws are compared up to 1 if None. `gauge_length` mm and `area` mm2
    belong to `extension_mm, force_N`. Raises InputError for unusable data and RefusedError for a curve
    that the model does not fit.
    """
    clock = Stopwatch(progress)
    with clock.stage("read"):
        test = material_test(path, gauge_length, area)
    if test.kind == "pad":
        from skincad.material.pad import fit_pad

        result = fit_pad(_within(str(path), test, up_to), design, clock)
    else:
        result, zeroed = _fit_bar(str(path), _within(str(path), test, up_to), test, clock)
        with clock.stage("laws"):
            result = with_laws(result, *compare_laws(zeroed, up_to))
    notes = (*result.warnings, *_outside(result, design))
    return replace(result, rows=test.rows, warnings=(*test.warnings, *notes), seconds=clock.seconds())


def _within(name: str, test: MaterialTest, up_to: float | None) -> MaterialTest:
    """The rows up to a strain or a force, if there are enough and their loads differ."""
    pad = test.kind == "pad"
    if up_to is not None:
        most, rule = (np.inf, "") if pad else (LARGEST_UP_TO, f" and at most {LARGEST_UP_TO:g} (strain)")
        require_number("up_to", up_to, lambda value: 0 < value <= most, f"must be above 0{rule}")
    limit = up_to or (np.inf if pad else UP_TO_STRAIN)
    used = np.abs(test.load if pad else test.deformation) <= limit
    largest = float(np.abs(test.load[used]).max(initial=0.0))
    firm = np.abs(test.load[used]) >= LOADED_SHARE * largest
    if largest == 0.0 or np.count_nonzero(firm) < FEWEST_ROWS:
        rule = f"must have at least {FEWEST_ROWS} rows under load" + (
            f" up to {limit:g}" if limit < np.inf else ""
        )
        percent = not pad and float(np.abs(test.deformation).max()) > PERCENT
        remedy = "are strains in percent? Then call the column strain_%" if percent else ""
        raise InputError(name, rule, int(np.count_nonzero(firm)) if largest else 0, remedy)
    smallest = float(np.abs(test.load[used]).min())
    if smallest * LEAST_LOAD_RATIO > largest:
        unit = "N" if pad else "MPa"
        rule = f"must span loads of 1 to {LEAST_LOAD_RATIO:g} or more"
        rule += f", not {smallest:.4g} to {largest:.4g} {unit}"
        raise InputError(name, rule)
    return replace(test, deformation=test.deformation[used], load=test.load[used])


# What a bar's stress over neo-Hooke's changes by with its stretch, term by term: Mooney's (J. Appl. Phys. 11
# (1940) 582), and one of second order for laws that bend
TERMS: tuple[Callable[[Array], Array], ...] = (lambda along: 1 / along - 1, lambda along: (along - 1) ** 2)
ROUNDED = 1e-5  # of the largest load: a residual below is none
STARTS = 41  # zeros tried before the fit, over half the strains
LEAST_ZERO, LEAST_TARE = 0.002, 0.01  # strain, of the largest load; assumption: less is the machine's play
BETTER = 0.5  # of the residual, at most, is left by a zero or a tare that is there
FIRST_ROWS, OFF_AT_FIRST = 3, 4.0  # a curve with the true zero passes these rows within so many times the rms
AS_GOOD = 1.5  # times the residual: the other explanation may hold too
SPIKE = 5.0, 0.02  # times the scatter of the rows after it, and of the largest load: row 1 lies off by both
AFTER_SPIKE = 6  # rows that say where row 1 would lie


@dataclass(frozen=True)
class _Bar:
    """A bar's rows fitted: the modulus is `fit.values[0]`, `zero` the strain at which it begins to bear,
    `tare` MPa what the load cell reads then, either one `fit.values[-1]` or 0. `simple` is neo-Hooke's fit
    alone, `again` fits other rows alike, `part` neo-Hooke's law alone with the same zero."""

    fit: Regression
    simple: Regression
    again: Fit
    part: Fit
    zero: float
    tare: float


def _fit_bar(
    name: str, test: MaterialTest, whole: MaterialTest, clock: Stopwatch
) -> tuple[MaterialFit, MaterialTest]:
    """The modulus at no strain of an incompressible bar, from as many terms as the rows tell: engineering
    stress E/3 (L - 1/L^2) (1 + a (1/L - 1) + b (L - 1)^2), L = 1 + strain. And the rows as they would be with
    a zero of strain and load: without row 1 if that lies far off the others, slack and tare.

    Neo-Hooke's for a = b = 0: Treloar, The Physics of Rubber Elasticity, 3rd ed. 1975, eq. (5.15). It alone
    would give a secant, 4 to 18 % off the modulus of laws that bend within a strain of 0.3; three terms are
    0.9 % off at most when pulled, 1.9 % when squeezed (tests/material/test_fit.py). The number of terms is
    that of the least corrected information criterion: Hurvich and Tsai, Biometrika 76 (1989) 297. A curve
    that neo-Hooke's follows nowhere near is no rubber's, however many terms follow it.

    A zero of strain (slack: the bar bears nothing before it) or of load (no tare) is taken where it leaves
    half the residual or less. Where both would, the modulus' error holds the other's.
    """
    if test.deformation.min() <= -1:
        raise InputError(
            name, "a strain must be above -1 (engineering strain)", float(test.deformation.min())
        )
    side = float(np.sign(test.deformation[-1]))
    with clock.stage("fit"):
        test, notes = _without_spike(test)
        plain = _bar(test, None)
        assert plain is not None
        shifted = [
            bar for bar in (_bar(test, "zero"), _bar(test, "tare")) if bar and _matters(bar, plain, test)
        ]
        bar = min(shifted, key=lambda bar: bar.fit.rms, default=plain)
        refuse_misfit(test, bar.simple)
        if plain is not bar:
            notes = (*notes, _told(bar, side))
        half = np.abs(test.deformation - bar.zero) <= np.abs(test.deformation - bar.zero).max() / 2
        misfit = 0.0
        if half.sum() > bar.fit.values.size + SPARE_ROWS:
            first = bar.again(replace(test, deformation=test.deformation[half], load=test.load[half]))
            misfit = max(0.0, abs(first.values[0] - bar.fit.values[0]) - first.half_width[0])
        for other in shifted:
            if other.fit.rms <= AS_GOOD * bar.fit.rms:
                misfit = max(misfit, abs(other.fit.values[0] - bar.fit.values[0]))
        result = material_fit(test, bar.fit, bar.fit.values[0], 0.0, bar.part, 1.0, misfit, touch=bar.zero)
    if bar.zero:
        result = replace(result, zero=Estimate(bar.zero, float(bar.fit.half_width[-1]), ""))
    spikes = whole.load.size - _without_spike(whole)[0].load.size
    strain, load = whole.deformation[spikes:] - bar.zero, whole.load[spikes:] - bar.tare
    bears = strain * side >= 0
    return replace(result, warnings=notes), replace(whole, deformation=strain[bears], load=load[bears])


def _bar(test: MaterialTest, shift: Literal["zero", "tare"] | None) -> _Bar | None:
    """The best fit of a kind: without a shift, or with one of the strain or of the load; None without one."""
    side = float(np.sign(test.deformation[-1]))
    reach = float(np.abs(test.deformation).max())

    def basis(strain: Array, zero: float, terms: int) -> Array:
        along = 1 + np.where((strain - zero) * side > 0, strain - zero, 0.0 if zero else strain - zero)
        law = (along - along**-2) / 3
        return np.column_stack([law, *(law * term(along) for term in TERMS[:terms])])

    def fitted(rows: MaterialTest, terms: int) -> Regression:
        strain, load = rows.deformation, rows.load
        if shift == "zero":
            tried = [side * share * reach for share in np.linspace(-0.5, 0.5, STARTS)]
            solved = [np.linalg.lstsq(basis(strain, zero, terms), load, rcond=None)[0] for zero in tried]
            missed = [
                float(np.sum((basis(strain, zero, terms) @ p - load) ** 2))
                for zero, p in zip(tried, solved, strict=True)
            ]
            best = int(np.argmin(missed))
            start = np.array([*solved[best], tried[best] or 1e-9])
            return regression(lambda p: basis(strain, float(p[-1]), terms) @ p[:-1], start, load)
        columns = basis(strain, 0.0, terms)
        if shift == "tare":
            columns = np.column_stack([columns, np.ones(strain.size)])
        start = np.asarray(np.linalg.lstsq(columns, load, rcond=None)[0], dtype=np.float64)
        return regression(lambda p: columns @ p, start, load)

    fits = []
    for terms in range(min(len(TERMS), test.load.size - SPARE_ROWS - 1) + 1):
        try:
            fits.append((fitted(test, terms), terms))
        except RefusedError:
            if not shift:
                raise
    if not fits or fits[0][1]:
        return None
    fit, terms = min(fits, key=lambda pair: _information(pair[0], test))
    moved = float(fit.values[-1]) if shift else 0.0
    zero, tare = moved * (shift == "zero"), moved * (shift == "tare")

    def part(rows: MaterialTest) -> Regression:
        columns = basis(rows.deformation, zero, 0)
        return regression(lambda p: columns @ p + tare, fit.values[:1], rows.load)

    return _Bar(fit, fits[0][0], lambda rows: fitted(rows, terms), part, zero, tare)


def _matters(bar: _Bar, plain: _Bar, test: MaterialTest) -> bool:
    """Whether a zero or a tare is there: it is no play of the machine, and leaves much less of the loads."""
    largest = float(np.abs(test.load).max())
    least = LEAST_ZERO if bar.zero else LEAST_TARE * largest
    moved, error = abs(float(bar.fit.values[-1])), float(bar.fit.half_width[-1])
    left = max(plain.fit.rms, ROUNDED * largest)
    begins = float(np.abs(bar.fit.residual[:FIRST_ROWS]).max()) <= OFF_AT_FIRST * bar.fit.rms
    return bar.fit.values[0] > 0 and moved > max(least, error) and bar.fit.rms <= BETTER * left and begins


def _told(bar: _Bar, side: float) -> str:
    if bar.zero * side > 0:
        return "the grips had slack: strain counts from where the bar begins to bear"
    way = "this is subtracted" if bar.tare else "strain counts from where the bar would bear nothing"
    return f"the load cell reads more than the bar bears, as without a tare or after a preload: {way}"


def _without_spike(test: MaterialTest) -> tuple[MaterialTest, tuple[str, ...]]:
    """The rows without row 1 if it lies far above the next ones and where they lead."""
    strain, load = test.deformation, test.load
    rows = slice(1, 1 + AFTER_SPIKE)
    if load.size < FEWEST_ROWS + 1 or strain[1] == strain[rows][-1]:
        return test, ()
    slope, level = np.polyfit(strain[rows], load[rows], 1)
    scatter = float(np.sqrt(np.mean((load[rows] - slope * strain[rows] - level) ** 2)))
    side = float(np.sign(strain[-1]))
    expected = side * max(side * float(slope * strain[0] + level), side * float(load[1]))
    times, share = SPIKE
    if side * (load[0] - expected) <= max(times * scatter, share * float(np.abs(load).max())):
        return test, ()
    note = (
        f"row 1 is left out: it reads {load[0]:.3g} MPa, and the next rows lead to {expected:.3g} at the most"
    )
    return replace(test, deformation=strain[1:], load=load[1:]), (note,)


def _information(fit: Regression, test: MaterialTest) -> float:
    """The corrected information criterion of a fit, smaller where it is better."""
    n, p = test.load.size, fit.values.size
    least = ROUNDED * float(np.abs(test.load).max())
    return 2 * n * math.log(max(fit.rms, least)) + 2 * p + 2 * p * (p + 1) / (n - p - 1)


def _outside(result: MaterialFit, design: Design | None) -> list[str]:
    """Warnings if the modulus is no casting silicone's, or outside the design's range so far."""
    value, notes = result.young_modulus.value or 0.0, []
    of = "force in mN" if result.kind == "pad" else "stress in kPa"
    unit = (
        f"is the {of}? Then name its column so"
        if value >= 1
        else "are all columns in the units of their names?"
    )
    if value > STIFF:
        notes.append(
            f"{value:.3g} MPa is stiffer than silicones that are cast, at most {STIFF:g} MPa: {unit}"
        )
    if value < SOFT:
        notes.append(f"{value:.3g} MPa is softer than silicones that are cast: are strains in percent?")
    if design is None:
        return notes
    prior = silicone(design).young_modulus
    if not FAR_OFF**-1 < value / prior.value < FAR_OFF:
        notes.append(
            f"that is {value / prior.value:.3g} times the design's silicone, {prior.value:g} MPa: {unit}"
        )
    elif not prior.low <= value <= prior.high:
        notes.append(
            f"the design's range so far was {prior.low:g} to {prior.high:g} MPa; the test lies outside"
        )
    return notes
