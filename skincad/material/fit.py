"""The silicone's modulus from a test: a cast pad pressed by a flat plate, or a bar pulled or squeezed.

Its error is stated in three parts: scatter of the rows, what the model leaves open, and what the two halves
of the test say of how the modulus changes over it.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from skincad.base.arguments import require_number
from skincad.base.errors import InputError
from skincad.base.stopwatch import Progress, Stopwatch
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.material_test import FEWEST_ROWS, MaterialTest, material_test
from skincad.material.laws import compared
from skincad.material.modulus import FIRM, MaterialFit, finished
from skincad.material.regression import Regression, regression

UP_TO_STRAIN = 0.3  # assumption: silicones leave the neo-Hookean law beyond it
LARGEST_UP_TO = 3.0  # strain, assumption: no casting silicone follows the law so far
SPAN = 2.0  # the largest load over the smallest, at least; less can't tell modulus from offset


def fit_material(
    path: Path | str,
    design: Design | None = None,
    *,
    up_to: float | None = None,
    gauge_length: float | None = None,
    area: float | None = None,
    progress: Progress | None = None,
) -> MaterialFit:
    """Return the modulus from a test's CSV, told apart by its columns (measurements.material_test).

    A pad's test needs the `design` that was pressed. `up_to` is the largest strain of a bar (0.3 if None) or
    force in N of a pad that is used; laws are compared up to 1 if None. `gauge_length` mm and `area` mm2
    belong to `extension_mm, force_N`. Raises InputError for what cannot be used and RefusedError for a curve
    that is not the model's.
    """
    clock = Stopwatch(progress)
    with clock.stage("read"):
        test = material_test(path, gauge_length, area)
    if test.kind == "pad":
        from skincad.material.pad import fit_pad

        found = fit_pad(_within(str(path), test, up_to), design, clock)
    else:
        found = _fit_bar(str(path), _within(str(path), test, up_to), clock)
        with clock.stage("laws"):
            laws, said = compared(test, up_to)
        found = replace(found, laws=laws, warnings=(*found.warnings, *([said] if said else [])))
    notes = (*found.warnings, *_outside(found, design))
    return replace(found, rows=test.rows, warnings=(*test.warnings, *notes), seconds=clock.seconds())


def _within(name: str, test: MaterialTest, up_to: float | None) -> MaterialTest:
    """The rows up to a strain or a force, if there are enough and their loads differ."""
    pad = test.kind == "pad"
    if up_to is not None:
        most, rule = (np.inf, "") if pad else (LARGEST_UP_TO, f" and at most {LARGEST_UP_TO:g} (strain)")
        require_number("up_to", up_to, lambda value: 0 < value <= most, f"must be above 0{rule}")
    limit = up_to or (np.inf if pad else UP_TO_STRAIN)
    kept = np.abs(test.load if pad else test.deformation) <= limit
    largest = float(np.abs(test.load[kept]).max(initial=0.0))
    firm = np.abs(test.load[kept]) >= FIRM * largest
    if largest == 0.0 or np.count_nonzero(firm) < FEWEST_ROWS:
        rule = f"must have at least {FEWEST_ROWS} rows under load" + (
            f" up to {limit:g}" if limit < np.inf else ""
        )
        raise InputError(name, rule, int(np.count_nonzero(firm)) if largest else 0)
    smallest = float(np.abs(test.load[kept]).min())
    if smallest * SPAN > largest:
        unit = "N" if pad else "MPa"
        rule = f"must span loads of 1 to {SPAN:g} or more, not {smallest:.4g} to {largest:.4g} {unit}"
        raise InputError(name, rule)
    return replace(test, deformation=test.deformation[kept], load=test.load[kept])


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
        return finished(test, whole, whole.values[0], 0.0, fit, 1.0)


def _outside(found: MaterialFit, design: Design | None) -> list[str]:
    """Whether the modulus lies outside what the design said so far."""
    if design is None:
        return []
    said, value = silicone(design).young_modulus, found.young_modulus.value or 0.0
    if said.low <= value <= said.high:
        return []
    return [f"the design's range so far was {said.low:g} to {said.high:g} MPa; the test lies outside"]
