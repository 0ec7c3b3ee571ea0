"""The silicone's modulus from a test: a cast pad pressed by a flat plate, or a bar pulled or squeezed.

Its error has three parts: scatter of the rows, uncertainty of the model, and what the test's first half alone
says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, require_number
from skincad.base.progress import Progress, Stopwatch
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.measurements import FEWEST_ROWS, MaterialTest, material_test
from skincad.material.laws import compare_laws
from skincad.material.modulus import (
    LOADED_SHARE,
    MaterialFit,
    Regression,
    material_fit,
    refuse_misfit,
    regression,
)

UP_TO_STRAIN = 0.3  # assumption: silicones leave the neo-Hookean law beyond it
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
        result = _fit_bar(str(path), _within(str(path), test, up_to), clock)
        with clock.stage("laws"):
            laws, note = compare_laws(test, up_to)
        result = replace(result, laws=laws, warnings=(*result.warnings, *([note] if note else [])))
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
        raise InputError(name, rule, int(np.count_nonzero(firm)) if largest else 0)
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


def _fit_bar(name: str, test: MaterialTest, clock: Stopwatch) -> MaterialFit:
    """The modulus at no strain of an incompressible bar, from as many terms as the rows tell: engineering
    stress E/3 (L - 1/L^2) (1 + a (1/L - 1) + b (L - 1)^2), L = 1 + strain.

    Neo-Hooke's for a = b = 0: Treloar, The Physics of Rubber Elasticity, 3rd ed. 1975, eq. (5.15). It alone
    would give a secant, 4 to 18 % off the modulus of laws that bend within a strain of 0.3; three terms are
    0.9 % off at most when pulled, 1.9 % when squeezed (tests/material/test_fit.py). The number of terms is
    that of the least corrected information criterion: Hurvich and Tsai, Biometrika 76 (1989) 297. A curve
    that neo-Hooke's follows nowhere near is no rubber's, however many terms follow it.
    """
    stretch = 1 + test.deformation
    if stretch.min() <= 0:
        raise InputError(
            name, "a strain must be above -1 (engineering strain)", float(test.deformation.min())
        )

    def fit(rows: MaterialTest, terms: int = 0) -> Regression:
        along = 1 + rows.deformation
        law = (along - along**-2) / 3
        basis = np.column_stack([law, *(law * term(along) for term in TERMS[:terms])])
        start = np.asarray(np.linalg.lstsq(basis, rows.load, rcond=None)[0], dtype=np.float64)
        return regression(lambda p: basis @ p, start, rows.load)

    with clock.stage("fit"):
        most = min(len(TERMS), test.load.size - SPARE_ROWS - 1)
        fits = [fit(test, terms) for terms in range(most + 1)]
        refuse_misfit(test, fits[0])
        terms = int(np.argmin([_information(one, test) for one in fits]))
        whole, half = fits[terms], np.abs(test.deformation) <= np.abs(test.deformation).max() / 2
        misfit = 0.0
        if half.sum() > terms + 1 + SPARE_ROWS:
            first = fit(replace(test, deformation=test.deformation[half], load=test.load[half]), terms)
            misfit = max(0.0, abs(first.values[0] - whole.values[0]) - first.half_width[0])
        return material_fit(test, whole, whole.values[0], 0.0, fit, 1.0, misfit)


def _information(fit: Regression, test: MaterialTest) -> float:
    """The corrected information criterion of a fit, smaller where it is better."""
    n, p = test.load.size, fit.values.size
    least = ROUNDED * float(np.abs(test.load).max())
    return 2 * n * math.log(max(fit.rms, least)) + 2 * p + 2 * p * (p + 1) / (n - p - 1)


def _outside(result: MaterialFit, design: Design | None) -> list[str]:
    """A warning if the modulus lies outside the design's range so far."""
    if design is None:
        return []
    prior, value = silicone(design).young_modulus, result.young_modulus.value or 0.0
    if prior.low <= value <= prior.high:
        return []
    return [f"the design's range so far was {prior.low:g} to {prior.high:g} MPa; the test lies outside"]
