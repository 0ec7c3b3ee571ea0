"""The silicone's modulus from a test: a cast pad pressed by a flat plate, or a bar pulled or squeezed.

Its error has three parts: scatter of the rows, uncertainty of the model, and the change of the modulus
between the two halves of the test.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from skincad.base.errors import InputError, require_number
from skincad.base.progress import Progress, Stopwatch
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.measurements import FEWEST_ROWS, MaterialTest, material_test
from skincad.material.laws import compare_laws
from skincad.material.modulus import LOADED_SHARE, MaterialFit, Regression, material_fit, regression

UP_TO_STRAIN = 0.3  # assumption: silicones leave the neo-Hookean law beyond it
LARGEST_UP_TO = 3.0  # strain, assumption: no casting silicone follows the law so far
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


def _fit_bar(name: str, test: MaterialTest, clock: Stopwatch) -> MaterialFit:
    """Incompressible neo-Hookean bar: engineering stress E/3 (L - 1/L^2), L = 1 + strain.

    Treloar, The Physics of Rubber Elasticity, 3rd ed. 1975, eq. (5.15); Rivlin, Phil. Trans. R. Soc. A 240
    (1948) 459.
    """
    stretch = 1 + test.deformation
    if stretch.min() <= 0:
        raise InputError(
            name, "a strain must be above -1 (engineering strain)", float(test.deformation.min())
        )

    def fit(rows: MaterialTest) -> Regression:
        along = 1 + rows.deformation
        law = (along - along**-2) / 3
        return regression(lambda p: p[0] * law, np.array([rows.load @ law / (law @ law)]), rows.load)

    with clock.stage("fit"):
        whole = fit(test)
        return material_fit(test, whole, whole.values[0], 0.0, fit, 1.0)


def _outside(result: MaterialFit, design: Design | None) -> list[str]:
    """A warning if the modulus lies outside the design's range so far."""
    if design is None:
        return []
    prior, value = silicone(design).young_modulus, result.young_modulus.value or 0.0
    if prior.low <= value <= prior.high:
        return []
    return [f"the design's range so far was {prior.low:g} to {prior.high:g} MPa; the test lies outside"]
