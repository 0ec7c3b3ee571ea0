"""The check with friction between plate and skin.

The effect of friction between skin and plate, from a coarse pad pressed with friction and without. Both are
solved on one coarse mesh of the section, in small strain and plane strain, so the mesh's error cancels (as in
corrected.py). Any model's answer gets the difference. Friction keeps the tips from spreading: the approach
falls. Where the pad is thin or a ridge leans, the last ridge needs more force. Friction along y is left out
(left_out.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skincad.base.arrays import Array
from skincad.base.machine import one_blas_thread
from skincad.mechanics.bodies import elements
from skincad.mechanics.bodies.mesh import default_sizes, triangles, unit_of
from skincad.mechanics.contact.frictionless import all_touch_force, press
from skincad.mechanics.contact.press_path import press_with_friction, sticking_pad_of
from skincad.mechanics.models.corrected import Errors, apply_change
from skincad.mechanics.problem import Answer, Pad, SizeError

FINENESS, ORDER = 0.5, 2
MOST_POINTS = 1000  # in contact; a step's time grows as their cube, to a second or so
# Up to the smaller of the all-touch force F and the force. With 40 of them F, approach and shares of
# yamada-2002, plain-ridges and fingertip-soft at friction 0.2 and 1 differ by at most 0.02, 0.03 and 0.01 %
# from those with 80
STEPS = 50
# Errors of the change: a constant, and a part of the change. Set on yamada-2002, plain-ridges
# (also 2 mm thick) and fingertip-soft at friction 0.2 and 1. With all fillets, on twice as fine a mesh of
# order 3 and in 200 steps, the change differs by up to 0.42 % (of F), 0.23 % (approach) and 0.67 % (of the
# mean share); in finite strain by up to 3.3, 1.8 and 2.7 %: a third of it is not there.
# Judged on milled-pad, where these are 0.2, 0.1 and 0.8 %, and 1.9, 1.6 and 2.5 %
BASE_ERRORS, ERRORS_BY_CHANGE = Errors(approach=0.005, threshold=0.02, share=0.02), Errors(0.5, 0.3, 0.3)


@dataclass(frozen=True)
class CoarsePress:
    """A coarse answer of the whole pad, mm and N; `ridge_force` `(ridges,)`."""

    all_touch_force: float | None
    approach: float
    ridge_force: Array
    unknowns: int
    residual: float


@dataclass(frozen=True)
class TwoPresses:
    """The coarse answers without and with friction, on the same mesh."""

    without: CoarsePress
    gripped: CoarsePress


def solve(
    pad: Pad,
    coefficient: float,
    force: float,
    crest_offsets: tuple[float, ...] = (),
    fineness: float = FINENESS,
    order: int = ORDER,
    steps: int = STEPS,
) -> TwoPresses:
    """Return the coarse answers at `force` N; raises ContactError where the press with friction fails."""
    with one_blas_thread():
        unit = unit_of(pad)
        scale = pad.young_modulus * unit * pad.length
        mesh = triangles(pad, default_sizes(pad, fineness))
        system = elements.assemble(elements.curved(mesh, order), order, pad.materials)
        points = system.nodes.weight.size
        if points > MOST_POINTS:
            words = f"is computed with friction for at most {MOST_POINTS} contact points"
            raise SizeError("ridge.count", words, points, "take fewer ridges")
        seen = sticking_pad_of(pad, system, unit)
        if crest_offsets:
            seen = seen.lowered(np.array(crest_offsets) / unit)
        ridges, load = seen.ridges, force / scale
        first = all_touch_force(ridges, load)
        smooth = press(ridges.flexibility, ridges.gap, load)
        shares = np.array([smooth.force[ridges.of_point == r].sum() for r in ridges.numbers])
        sticking = press_with_friction(seen, coefficient, load, first, steps)

    def coarse(threshold: float | None, approach: float, share: Array, residual: float) -> CoarsePress:
        first = None if threshold is None else threshold * scale
        return CoarsePress(first, approach * unit, share * scale, system.unknowns, residual)

    return TwoPresses(
        coarse(first, smooth.approach, shares, smooth.residual),
        coarse(sticking.all_touch_force, sticking.approach, sticking.ridge_force, sticking.residual),
    )


def with_friction(fine: Answer, friction: TwoPresses, force: float) -> Answer:
    """Return a frictionless answer with the change by friction and the error of that change."""
    before, after = friction.without, friction.gripped
    by_approach = abs(after.approach / before.approach - 1)
    by_force = 0.0
    if before.all_touch_force and after.all_touch_force:
        by_force = abs(after.all_touch_force / before.all_touch_force - 1)
    mean = float(before.ridge_force.mean())
    by_share = float(np.abs(after.ridge_force - before.ridge_force).max()) / mean
    errors = Errors(
        BASE_ERRORS.approach + ERRORS_BY_CHANGE.approach * by_approach,
        BASE_ERRORS.threshold + ERRORS_BY_CHANGE.threshold * by_force,
        BASE_ERRORS.share + ERRORS_BY_CHANGE.share * by_share,
    )
    result = apply_change(fine, before, after, force, errors)
    return replace(result, warnings=fine.warnings, seconds=fine.seconds)
