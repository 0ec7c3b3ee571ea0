"""Force against approach of a pad under a flat plate, from which a pressed pad's modulus is read.

Small strain in plane strain on a fine mesh, times the effect of free ends (corrected.py), times the effect of
finite strain in plane strain. In units of E the curve does not depend on E, except for film strips, whose
modulus stays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from skincad.base.arrays import Array
from skincad.base.blas import one_blas_thread
from skincad.base.errors import InputError
from skincad.base.stopwatch import Stopwatch
from skincad.inputs.design import Design
from skincad.mechanics.bodies.mesh import meshed_piece, plane_piece
from skincad.mechanics.contact.frictionless import NodalContact, Ridges, press
from skincad.mechanics.models import corrected, linear
from skincad.mechanics.models.finite_strain import Levels
from skincad.mechanics.models.solid import coarse_sizes, condensed_pad, forms_of
from skincad.mechanics.problem import Pad, check_pad, pad_of
from skincad.mechanics.validity import limits

POINTS = 80  # forces of the table, closer at the first touch
FINE = linear.RUNGS[1]
COARSE = linear.RUNGS[0]
COARSE_ORDER = 2  # its ratio of finite to small strain is that of order 3 to 2e-4 (measured on yamada-2002)
# Shares of the largest force: the ratio is 1 at no force, and lines between are within 3e-3 of it, as it
# bends where the last ridges touch (measured on yamada-2002 to 6 N); STRAINED_ERROR is far larger
STRAINED_SHARES = (0.15, 0.5, 1.0)

# Relative errors of the approach: of the mesh (linear.FINE), of the free ends' change, and of a Poisson's
# ratio between 0.498 and 0.49999 where the design says 0.499 (measured on yamada-2002)
APPROACH_ERROR = FINE.usual + corrected.APPROACH_ERROR + 0.004
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
    pad = replace(pad_of(design), young_modulus=young_modulus)
    check_pad(pad)
    a_ridge = limits(design.with_(material={"young_modulus": young_modulus, "law": None})).largest
    force = a_ridge * len(pad.ridges) * (np.arange(1, POINTS + 1) / POINTS) ** 2
    with clock.stage("linear"):
        meshed = plane_piece(pad, FINE.fineness)
        solution = linear.level(meshed, FINE.order, force[-1] / 4)
        states = _pressed(solution.ridges, force / solution.scale)
        approach = np.array([state.approach for state in states]) * solution.unit
    with clock.stage("free ends"):
        approach = approach * _free_ends(
            replace(corrected.plain_pad(design), young_modulus=young_modulus), force
        )
    shares = [meshed.on_whole(_shares(state, solution.ridges)) for state in states]
    loaded = np.array(shares).max(axis=1) * solution.scale
    rows = int(np.count_nonzero(np.maximum.accumulate(loaded) <= a_ridge))
    zero = np.zeros(1)
    force, approach = np.append(zero, force[:rows]), np.append(zero, approach[:rows])
    return PadCurve(young_modulus, force, approach, np.ones(rows + 1))


def finite_strain_curve(curve: PadCurve, design: Design, largest: float, clock: Stopwatch) -> PadCurve:
    """Return the curve up to `largest` N, or to where finite strain's model ends, with its change in it.

    Raises InputError when not even the first of STRAINED_AT is within that model.
    """
    pad = replace(pad_of(design), young_modulus=curve.young_modulus)
    largest = min(largest, float(curve.force[-1]))
    with clock.stage("finite strain"):
        coarse, solve = plane_piece(pad, COARSE.fineness), Levels()
        at, ratio = [0.0], [1.0]
        for force in (share * largest for share in STRAINED_SHARES):
            small = linear.level(coarse, COARSE_ORDER, force).approach
            try:
                finite = solve(coarse, COARSE_ORDER, force).approach
            except InputError:
                if len(at) == 1:
                    raise
                break
            at.append(force)
            ratio.append(finite / small)
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


def _shares(state: NodalContact, ridges: Ridges) -> Array:
    return np.array([state.force[ridges.of_point == r].sum() for r in ridges.numbers])
