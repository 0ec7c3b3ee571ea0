"""The equilibrium that a pad snaps to where the one nearby ends: pseudo-transient continuation.

The trailing corner of a tip that is pulled rolls under the points that stick, until the path of equilibria
turns back: Newton finds none nearby, and the linearised contact has no solution. Masses would carry the
corner to another equilibrium within microseconds. Here it gets there as through a viscous liquid. Each
pseudo-step resists what moves since the one before, and the next is damped less; the last one not at all
(Kelley and Keyes, SIAM J. Numer. Anal. 35 (1998) 508). Damping resists any movement alike, so it couples
no tangential force to a gap: damped enough, contact has one solution however much friction there is. Points
slide, stick and let go on the way.

Which equilibrium masses would lead to is not asked: what snaps falls down the energy's slope.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from skincad.mechanics.contact.frictional import joined
from skincad.mechanics.contact.frictional_pad import FrictionalPad, FrictionalState, newton
from skincad.mechanics.contact.state import Drive, FrictionCoefficients, GrossSlip
from skincad.mechanics.problem import ContactError

# Of E by the unit's square: at first only what is smaller than a fiftieth of the unit moves, such as a corner
FIRST, WEAK, STRONGEST = 3e3, 20.0, 1e6
# Factors of the damping after a step, after one of the next three to a failure, and after a failure
WEAKER, CAREFUL, STRONGER = 1 / 6, 1 / 2, 4.0
STEPS = 25  # five to ten are usual
ACCURACY, ITERATIONS = 1e-3, 6  # of a damped step, which the next one mends


def relaxed(
    pad: FrictionalPad,
    before: FrictionalState,
    drive: Drive,
    cone: FrictionCoefficients,
) -> FrictionalState:
    """Return the equilibrium in which the pad comes to rest under `drive`, from a state with none nearby.
    Raises ContactError where it doesn't, and GrossSlip as `newton` does."""
    body, hold = pad.body.damped
    slowed = replace(pad, body=body, tangents=[])
    still = replace(before.contact, slipped=np.zeros_like(before.contact.slipped))
    state = FrictionalState(before.values, still)
    damping, careful = FIRST, 0
    for _ in range(STEPS):
        if damping < WEAK:
            pad.tangents.clear()
            try:
                return _newton(pad, state, drive, cone)
            except GrossSlip:
                raise
            except ContactError:  # the pad has not come to rest yet
                pass
        slowed.tangents.clear()
        hold(state.values, damping)
        try:
            state = _newton(slowed, state, drive, cone, ACCURACY, ITERATIONS)
        except GrossSlip as limit:  # of the damped pad: what it bears without damping is asked at the end
            state = limit.last
        except ContactError as failure:
            damping, careful = damping * STRONGER, 3
            if damping > STRONGEST:
                raise ContactError(f"a tip's corner snaps and does not come to rest: {failure}") from None
            continue
        damping *= CAREFUL if careful else WEAKER
        careful = max(0, careful - 1)
    raise ContactError(f"a tip's corner snaps and does not come to rest in {STEPS} steps")


def _newton(
    pad: FrictionalPad,
    before: FrictionalState,
    drive: Drive,
    cone: FrictionCoefficients,
    *how: Any,
) -> FrictionalState:
    """The state at a step's end; what slides and is dissipated in it and before is added up."""

    def both(after: FrictionalState) -> FrictionalState:
        return replace(
            after,
            contact=replace(joined(before.contact, after.contact), residual=after.contact.residual),
            dissipated=before.dissipated + after.dissipated,
            iterations=before.iterations + after.iterations,
        )

    try:
        return both(newton(pad, before, drive, cone, None, None, *how))
    except GrossSlip as limit:
        limit.last = both(limit.last)
        raise
