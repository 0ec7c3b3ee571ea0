"""The reference of finite strain in each step: a step is cut where it does not converge, or driven by travel.

Under a force a skin that softens has several equilibria, and Newton jumps between them; under a travel it has
one. So a pull that does not converge is replaced by steps of the travel until its force is passed.
"""

from __future__ import annotations

from dataclasses import replace

from skincad.mechanics import (
    ContactError,
    Drive,
    FrictionalPad,
    FrictionalState,
    FrictionCoefficients,
    GrossSlip,
    in_halves,
)
from skincad.mechanics import joined as joined_contact
from skincad.mechanics.contact import frictional_pad

MAX_HALVINGS = 5  # of a step
TRAVEL_HALVINGS = 3  # of a step of the travel
TRAVEL_FACTOR = 2.0  # of the travel that the last softness predicts
MAX_TRAVEL_STEPS = 40  # of the travel in a step of the pull
MAX_SECANT_STEPS = 30  # of the last step, by the secant; four to six are usual
SAME_FORCE = 1e-9  # of the normal force


def advance_to(
    pad: FrictionalPad,
    before: FrictionalState,
    start: Drive,
    end: Drive,
    cone: FrictionCoefficients,
    deepest: int = MAX_HALVINGS,
) -> FrictionalState:
    """Return `newton` at `end`; a step that does not converge is cut in two, `deepest` times at most, a pull
    that does not is driven by travel. What the parts slipped and dissipated is added up. Raises as `newton`
    does.
    """

    def advance(before: FrictionalState, _start: Drive, end: Drive, _share: float) -> FrictionalState:
        return one_step(pad, before, end, cone)

    if end.tangential in (None, start.tangential) or not before.contact.touches.any():
        return in_halves(advance, before, start, end, joined, deepest)
    try:
        return one_step(pad, before, end, cone)
    except GrossSlip:
        raise
    except ContactError:
        return driven(pad, before, end, cone)


def one_step(
    pad: FrictionalPad, before: FrictionalState, end: Drive, cone: FrictionCoefficients
) -> FrictionalState:
    """Return the state at a step's end."""
    try:
        return frictional_pad.newton(pad, before, end, cone)
    except GrossSlip:
        raise
    except ContactError:
        pad.tangents.clear()
        raise


def driven(
    pad: FrictionalPad, before: FrictionalState, end: Drive, cone: FrictionCoefficients
) -> FrictionalState:
    """Return the state at the end's forces, the plate driven there by its travel; the last step is cut."""
    wanted, state, total = float(end.tangential or 0.0), before, None
    here = float(before.contact.tangential.sum())
    way = 1.0 if wanted > here else -1.0
    soft = (
        abs(before.contact.travel) / max(abs(here), 1e-3 * end.normal) or before.contact.approach / end.normal
    )
    length = TRAVEL_FACTOR * soft * (wanted - here)
    for _ in range(MAX_TRAVEL_STEPS):
        last = by_travel(pad, state, end.normal, state.contact.travel + length, cone)
        passed = float(last.contact.tangential.sum())
        if way * (passed - wanted) >= 0:
            reached = cut(pad, state, last, end.normal, wanted, cone)
            return reached if total is None else joined(total, reached)
        if way * (passed - here) < 0:
            break
        total = last if total is None else joined(total, last)
        state, here = last, passed
    raise ContactError(
        f"the pull cannot grow beyond {abs(here):.4g} N at {end.normal:.4g} N: the skin gives way"
    )


def by_travel(
    pad: FrictionalPad, before: FrictionalState, normal: float, travel: float, cone: FrictionCoefficients
) -> FrictionalState:
    """Return the state at a travel."""
    start = Drive(normal, travel=before.contact.travel)
    return advance_to(pad, before, start, Drive(normal, travel=travel), cone, TRAVEL_HALVINGS)


def cut(
    pad: FrictionalPad,
    before: FrictionalState,
    after: FrictionalState,
    normal: float,
    wanted: float,
    cone: FrictionCoefficients,
) -> FrictionalState:
    """Return the state between two at which the tangential force is the wanted one, by the Illinois rule."""
    ends = [before.contact.travel, after.contact.travel]
    missing = [float(s.contact.tangential.sum()) - wanted for s in (before, after)]
    side = 0
    for _ in range(MAX_SECANT_STEPS):
        travel = (ends[0] * missing[1] - ends[1] * missing[0]) / (missing[1] - missing[0])
        reached = by_travel(pad, before, normal, travel, cone)
        off = float(reached.contact.tangential.sum()) - wanted
        if abs(off) <= SAME_FORCE * normal:
            return reached
        new = int(off * missing[1] > 0)
        ends[new], missing[new] = travel, off
        if new == side:
            missing[1 - new] /= 2
        side = new
    raise ContactError(
        f"no travel gives the tangential force {wanted:.4g} N: it jumps by {abs(off):.1e} N there"
    )


def joined(first: FrictionalState, second: FrictionalState) -> FrictionalState:
    """Return the state at the end of two steps as that of one."""
    return replace(
        second,
        contact=joined_contact(first.contact, second.contact),
        dissipated=first.dissipated + second.dissipated,
        residual=max(first.residual, second.residual),
        iterations=first.iterations + second.iterations,
    )
