"""The modulus of a cast pad pressed by a flat plate: modulus and first touch that fit its curve best."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from skincad.base.errors import InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.base.stopwatch import Stopwatch
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.material_test import MaterialTest
from skincad.material.modulus import MaterialFit, material_fit
from skincad.material.pad_curve import (
    APPROACH_ERROR,
    STRAINED_ERROR,
    PadCurve,
    finite_strain_curve,
    small_strain_curve,
)
from skincad.material.regression import Regression, regression

STRIP_SENSITIVITY = 0.1  # relative change of E that changes the curve of a pad with strips by 1e-3 (measured)
PASSES = 4
MARGIN = 1.25  # of the force that small strain asks for; finite strain asks for up to 15 % more
STARTS = (
    61  # first touches tried before the fit, for it has more than one valley where rows precede the touch
)
LEFT_OUT = (
    "friction at the plate and creep are left out: wet or powder the plate, and press slowly",
    "the pad is taken as designed: errors of its own thickness and width go into the modulus",
)


def fit_pad(test: MaterialTest, design: Design | None, clock: Stopwatch) -> MaterialFit:
    """Return the modulus of the pad that was pressed, and the approach at which the plate first touched.

    Raises InputError without a design, for a plate that is not flat, and for forces beyond the range of
    the model.
    """
    if design is None:
        raise InputError("design", "is missing", remedy="name the design of the pad that was pressed")
    plate = design.contact.plate.shape
    if plate != "flat":
        remedy = "press with a flat plate, and leave [contact.plate] out"
        raise InputError("contact.plate.shape", "must be 'flat' for a pad's test", plate, remedy)
    modulus = silicone(design).young_modulus.value
    for _ in range(PASSES):
        curve = _curve(test, design, modulus, clock)
        with clock.stage("fit"):
            result = fit_to_curve(curve, test)
        fitted = result.young_modulus.value or 0.0
        if design.film_state != "bonded" or abs(fitted / modulus - 1) <= STRIP_SENSITIVITY:
            return replace(result, warnings=LEFT_OUT)
        modulus = fitted  # the strips keep their modulus: the curve is another one
    raise RefusedError(f"the modulus does not settle within {PASSES} passes, at {modulus:.4g} MPa")


def fit_to_curve(curve: PadCurve, test: MaterialTest) -> MaterialFit:
    """Return the modulus by one curve, its error that of the rows and of the curve."""
    whole, per_value = fit_curve(curve, test), curve.young_modulus
    _check_range(test, curve, whole)
    others = curve.varied(1 + APPROACH_ERROR, 1.0), curve.varied(1.0, 1 - STRAINED_ERROR)
    moved = [float(fit_curve(other, test).values[0] - whole.values[0]) for other in others]
    model = per_value * sum(map(abs, moved))
    result = material_fit(
        test, whole, float(whole.values[0]) * per_value, model, lambda rows: fit_curve(curve, rows), per_value
    )
    return replace(result, offset=Estimate(float(whole.values[1]), float(whole.half_width[1]), "mm"))


def fit_curve(curve: PadCurve, test: MaterialTest) -> Regression:
    """Return E over the curve's modulus, and the approach of the first touch, that fit the rows best."""
    approach, force = test.deformation, test.load
    starts = float(approach.max()) - np.linspace(0.0, 1.0, STARTS + 1)[1:] * min(
        float(curve.approach[-1]), 3.0 * float(np.ptp(approach))
    )
    laws = [curve.force_at(approach - touch) for touch in starts]
    scales = [float(force @ law / (law @ law)) for law in laws]
    missed = [float(np.sum((scale * law - force) ** 2)) for scale, law in zip(scales, laws, strict=True)]
    best = int(np.argmin(missed))
    return regression(
        lambda p: p[0] * curve.force_at(approach - p[1]), np.array([scales[best], starts[best]]), force
    )


def _curve(test: MaterialTest, design: Design, modulus: float, clock: Stopwatch) -> PadCurve:
    """The curve as far as the test goes, by a first fit with small strains."""
    small = small_strain_curve(design, modulus, clock)
    with clock.stage("fit"):
        first = fit_curve(small, test)
    _check_range(test, small, first)
    largest = MARGIN * float(small.force_at(np.array([test.deformation.max() - first.values[1]]))[0])
    return finite_strain_curve(small, design, largest, clock)


def _check_range(test: MaterialTest, curve: PadCurve, solution: Regression) -> None:
    """Refuse a test that goes beyond the curve's table."""
    if float(test.deformation.max() - solution.values[1]) <= curve.approach[-1]:
        return
    raise InputError(
        "up_to",
        "the model ends where a ridge is strained by 0.3 or buckles: use forces up to "
        f"{float(solution.values[0] * curve.force[-1]):.2g} N",
        float(test.load.max()),
    )
