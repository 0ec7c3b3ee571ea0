"""A pad's force against approach, computed and measured.

Force against approach of a pad under a flat plate, from which a pressed pad's modulus is read. Small strain
in plane strain on a fine mesh, times the effect of free ends (corrected.py), times the effect of finite
strain in plane strain. In units of E the curve does not depend on E, except for film strips, whose modulus
stays.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Stopwatch
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.measurements import FEWEST_ROWS, MaterialTest
from skincad.material.modulus import MaterialFit, Regression, material_fit, regression
from skincad.mechanics.bodies.mesh import PadPiece, meshed_piece, plane_piece
from skincad.mechanics.contact.frictionless import NodalContact, Ridges, press
from skincad.mechanics.contact.ridge_model import MAX_RIDGES, ridge_approach
from skincad.mechanics.models import corrected, finite_strain, linear, reduced
from skincad.mechanics.models.solid import coarse_sizes, condensed_pad, forms_of
from skincad.mechanics.problem import Pad, check_pad, focused, pad_of
from skincad.mechanics.validity import LARGEST_STRAIN, limits
from skincad.shape.skin import skin_of

STRIP_SENSITIVITY = 0.1  # relative change of E that changes the curve of a pad with strips by 1e-3 (measured)
PASSES = 4
TARE_ROWS = 5  # before the first touch, from which what the load cell reads there is known
TARED = 0.7  # of the residual, at most, is left by a tare that is there
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
    value, touch = map(float, whole.values)
    result = material_fit(
        test, whole, value * per_value, model, lambda rows: fit_curve(curve, rows), per_value, touch=touch
    )
    return replace(result, offset=Estimate(touch, float(whole.half_width[1]), "mm"))


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


def tare(curve: PadCurve, test: MaterialTest) -> float:
    """Return what the load cell reads before the plate touches, N: the mean of the rows before the first
    touch, if there are TARE_ROWS of them and the rows lie on a curve with it far better than without; else 0.
    """
    approach, force = test.deformation, test.load
    try:
        best = TARED * fit_curve(curve, test).rms, 0.0
    except RefusedError:  # rows of another unit
        return 0.0
    for touch in approach[TARE_ROWS:-FEWEST_ROWS]:
        law = curve.force_at(approach - touch)
        columns = np.column_stack([law, np.ones(law.size)])
        solved = np.linalg.lstsq(columns, force, rcond=None)[0]
        rms = float(np.sqrt(np.mean((columns @ solved - force) ** 2)))
        best = min(best, (rms, float(force[approach <= touch].mean())))
    return best[1]


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


POINTS = 80  # forces of the table, closer at the first touch
FINE = linear.REFINEMENTS[1]
COARSE = linear.REFINEMENTS[0]
COARSE_ORDER = 2  # its ratio of finite to small strain is that of order 3 to 2e-4 (measured on yamada-2002)
# Shares of the largest force: the ratio is 1 at no force, and lines between are within 3e-3 of it, as it
# bends where the last ridges touch (measured on yamada-2002 to 6 N); STRAINED_ERROR is far larger
STRAINED_SHARES = (0.15, 0.5, 1.0)
NEAREST = 0.2  # of a force that is beyond that model: half-way steps towards it are tried down to so much

# Relative errors of the approach: of the mesh (linear.FINE), of the free ends' change, and of a Poisson's
# ratio between 0.498 and 0.49999 where the design says 0.499 (measured on yamada-2002)
APPROACH_ERROR = FINE.usual + corrected.ERRORS.approach + 0.004
# Of what finite strain changes; it is computed without free ends, which make the strains larger. Assumption:
# over twice the difference between the ratio at the same force and at the same approach, 18 % on yamada-2002
STRAINED_ERROR = 0.5


@dataclass(frozen=True)
class PadCurve:
    """A table of a pad of `young_modulus` MPa: `force` `(k,)` N from 0 up.

    `small` `(k,)` mm is the approach with small strains, `strained` `(k,)` its factor by finite strain.
    """

    young_modulus: float
    force: Array
    small: Array
    strained: Array

    @property
    def approach(self) -> Array:
        """Approach `(k,)` mm, ascending from 0."""
        return self.small * self.strained

    def force_at(self, approach: Array) -> Array:
        """Return the force, N, at approaches `(n,)` mm; 0 before the touch, straight on beyond the table."""
        table = self.approach
        inside = PchipInterpolator(table, self.force)
        extrapolated = np.maximum(approach - table[-1], 0.0) * float(inside.derivative()(table[-1]))
        return np.asarray(inside(np.clip(approach, 0.0, table[-1])) + extrapolated)

    def varied(self, scale: float, strained: float) -> PadCurve:
        """Return the curve with all approaches times `scale` and finite strain's change times `strained`."""
        return replace(self, small=self.small * scale, strained=1 + strained * (self.strained - 1))


def small_strain_curve(design: Design, young_modulus: float, clock: Stopwatch) -> PadCurve:
    """Return the curve with free ends, up to where a ridge's nominal strain is LARGEST_STRAIN or it buckles.

    `design`'s own modulus is not used. Raises InputError for a pad too large for three dimensions.
    """
    soft = design.with_(material={"young_modulus": young_modulus, "law": None})
    a_ridge, shares = limits(soft).largest, (np.arange(1, POINTS + 1) / POINTS) ** 2
    if skin_of(design).body == "pins":
        with clock.stage("linear"):
            if (count := skin_of(soft).count) > MAX_RIDGES:
                remedy = "press a part with fewer pins of that kind"
                raise InputError("pin", f"must be at most {MAX_RIDGES} to read a press", count, remedy)
            model = reduced.pin_model(soft).ridge_model()
            force = a_ridge * model.gap.size * shares
            forces, approach = ridge_approach(model, np.zeros((POINTS, model.gap.size)), force)
        return _up_to(a_ridge, forces.max(axis=1), PadCurve(young_modulus, force, approach, np.ones(POINTS)))
    pad = focused(replace(pad_of(design), young_modulus=young_modulus), design.contact.force)
    check_pad(pad)
    with clock.stage("linear"):
        meshed = plane_piece(pad, FINE.fineness)
        if pad.face:
            a_ridge = _force_at(LARGEST_STRAIN * design.skin.thickness, meshed, design.contact.force)
        force = a_ridge * len(pad.ridges) * shares
        solution = linear.level(meshed, FINE.order, force[-1] / 4)
        states = _pressed(solution.ridges, force / solution.scale)
        approach = np.array([state.approach for state in states]) * solution.unit
    if not pad.revolved:  # a disc has no ends
        with clock.stage("free ends"):
            plain = replace(corrected.plain_pad(design), young_modulus=young_modulus)
            approach = approach * _free_ends(plain, force)
    borne = [meshed.on_whole(solution.ridges.sums(state.force)) for state in states]
    loaded = np.array(borne).max(axis=1) * solution.scale
    return _up_to(a_ridge, loaded, PadCurve(young_modulus, force, approach, np.ones(POINTS)))


def _up_to(a_ridge: float, loaded: Array, curve: PadCurve) -> PadCurve:
    """The curve from no force up to where the most loaded feature, `loaded` `(k,)` N, bears `a_ridge` N."""
    rows = int(np.count_nonzero(np.maximum.accumulate(loaded) <= a_ridge))
    zero = np.zeros(1)
    force, approach = np.append(zero, curve.force[:rows]), np.append(zero, curve.small[:rows])
    return replace(curve, force=force, small=approach, strained=np.ones(rows + 1))


def _force_at(approach: float, meshed: PadPiece, force: float) -> float:
    """The force, N, at which a face gives way by `approach` mm, within a hundred times `force` N."""
    solution = linear.level(meshed, COARSE_ORDER, force)
    at = force * np.geomspace(0.01, 100.0, POINTS)
    states = _pressed(solution.ridges, at / solution.scale)
    reached = [state.approach * solution.unit for state in states]
    return float(np.interp(approach, reached, at))


def finite_strain_curve(curve: PadCurve, design: Design, largest: float, clock: Stopwatch) -> PadCurve:
    """Return the curve up to `largest` N, or to where finite strain's model ends, with its change in it.

    Raises InputError when not even the first of STRAINED_AT is within that model.
    """
    one, each = design, 1.0
    if (
        skin_of(design).body == "pins"
    ):  # what finite strain changes is taken as of one pin under the mean force
        one, each = reduced.pin_cells(design).stiffest.design, 1 / skin_of(design).count
    pad = focused(replace(pad_of(one), young_modulus=curve.young_modulus), each * design.contact.force)
    largest = min(largest, float(curve.force[-1]))
    with clock.stage("finite strain"):
        coarse = plane_piece(pad, COARSE.fineness)
        finite: linear.PlaneSolution | None = None
        at, ratio, failed = [0.0], [1.0], math.inf
        ahead = [share * largest for share in STRAINED_SHARES]
        while ahead:
            force = ahead.pop(0)
            small = linear.level(coarse, COARSE_ORDER, each * force).approach
            try:
                finite = finite_strain.level(coarse, COARSE_ORDER, each * force, before=finite)
            except InputError:
                if len(at) == 1:
                    raise
                failed, ahead = force, []
            else:
                at.append(force)
                ratio.append(finite.approach / small)
            if not ahead and at[-1] < (1 - NEAREST) * failed < math.inf:
                ahead = [(at[-1] + failed) / 2]
    rows = curve.force < at[-1]
    forces = np.append(curve.force[rows], at[-1])
    small_strain = np.interp(forces, curve.force, curve.small)
    strained = np.interp(forces, at, ratio)
    return PadCurve(curve.young_modulus, forces, small_strain, strained)


def _free_ends(pad: Pad, force: Array) -> Array:
    """What the free ends make of the approach `(k,)` at forces `(k,)` N, both sides on one coarse mesh."""
    meshed = meshed_piece(pad, coarse_sizes(pad, 1.0))
    forms = forms_of(meshed, corrected.ORDER)
    sides = []
    for along in (corrected.LAYERS, None):
        small, scale = condensed_pad(meshed, forms, along, {})
        ridges = Ridges.of(small.seen, small.flexibility, meshed.whole.top / meshed.unit)
        sides.append(np.array([state.approach for state in _pressed(ridges, force / scale)]))
    return np.asarray(sides[0] / sides[1])


def _pressed(ridges: Ridges, forces: Array) -> list[NodalContact]:
    with one_blas_thread():
        return [press(ridges.flexibility, ridges.gap, float(force)) for force in forces]
