"""A step of a march with finite strain: cut where it does not converge, or driven by the plate's travel.

Under a force a skin that softens has several equilibria, and Newton jumps between them; under a travel it has
one. So a pull that does not converge is walked in strides of the travel until its force is passed.
"""

from __future__ import annotations

from dataclasses import replace

from skincad.mechanics.contact.dragged import FrictionalPad, FrictionalState, newton
from skincad.mechanics.contact.grip import Drive, FrictionCoefficients, GrossSlip
from skincad.mechanics.contact.halving import in_halves, joined
from skincad.mechanics.problem import ContactError

DEEPEST = 5  # halvings of a step
STEADY = 3  # halvings of a stride of the travel
LONGER = 2.0  # than the travel that the last softness asks for
STRIDES = 40  # of the travel in a step of the pull
CUTS = 30  # of the last stride, by the secant; four to six are usual
SAME_FORCE = 1e-9  # of the normal force


def to(
    pad: FrictionalPad,
    before: FrictionalState,
    start: Drive,
    end: Drive,
    cone: FrictionCoefficients,
    deepest: int = DEEPEST,
) -> FrictionalState:
    """Return `newton` at `end`; a step that does not converge is cut in two, `deepest` times at most, a pull
    that does not is driven by travel. What the parts slipped and dissipated is added up. Raises as `newton`
    does.
    """

    def advance(before: FrictionalState, start: Drive, end: Drive, _share: float) -> FrictionalState:
        return _whole(pad, before, start, end, cone)

    if end.tangential in (None, start.tangential) or not before.grip.touches.any():
        return in_halves(advance, before, start, end, _joined, deepest)
    try:
        return _whole(pad, before, start, end, cone)
    except GrossSlip:
        raise
    except ContactError:
        return _driven(pad, before, end, cone)


def _whole(
    pad: FrictionalPad, before: FrictionalState, start: Drive, end: Drive, cone: FrictionCoefficients
) -> FrictionalState:
    """The state at one step's end, looked for where the last equal one leads, then from its own start."""
    steady = _moves(start, end)
    guesses = (before.values + before.change, None) if steady == before.moves else (None,)
    for guess in guesses:
        try:
            return replace(newton(pad, before, end, cone, guess), moves=steady)
        except GrossSlip:
            raise
        except ContactError as refusal:
            pad.kept.clear()
            failure = refusal
    raise failure


def _moves(start: Drive, end: Drive) -> tuple[float, ...]:
    """How a drive goes on; equal steps look alike to a few digits."""

    def change(a: float | None, b: float | None) -> float:
        return float("nan") if a is None or b is None else float(f"{b - a:.6g}")

    pairs = ((start.normal, end.normal), (start.tangential, end.tangential), (start.travel, end.travel))
    return tuple(change(a, b) for a, b in pairs if b is not None)


def _driven(
    pad: FrictionalPad, before: FrictionalState, end: Drive, cone: FrictionCoefficients
) -> FrictionalState:
    """Return the state at the end's forces, the plate driven there by its travel; the last stride is cut."""
    wanted, state, total = float(end.tangential or 0.0), before, None
    here = float(before.grip.tangential.sum())
    way = 1.0 if wanted > here else -1.0
    soft = abs(before.grip.travel) / max(abs(here), 1e-3 * end.normal) or before.grip.approach / end.normal
    length = LONGER * soft * (wanted - here)
    for _ in range(STRIDES):
        last = _by_travel(pad, state, end.normal, state.grip.travel + length, cone)
        passed = float(last.grip.tangential.sum())
        if way * (passed - wanted) >= 0:
            state_reached = _cut(pad, state, last, end.normal, wanted, cone)
            return state_reached if total is None else _joined(total, state_reached)
        if way * (passed - here) < 0:
            break
        total = last if total is None else _joined(total, last)
        state, here = last, passed
    raise ContactError(
        f"the pull cannot grow beyond {abs(here):.4g} N at {end.normal:.4g} N: the skin gives way"
    )


def _by_travel(
    pad: FrictionalPad, before: FrictionalState, normal: float, travel: float, cone: FrictionCoefficients
) -> FrictionalState:
    start = Drive(normal, travel=before.grip.travel)
    return to(pad, before, start, Drive(normal, travel=travel), cone, STEADY)


def _cut(
    pad: FrictionalPad,
    before: FrictionalState,
    after: FrictionalState,
    normal: float,
    wanted: float,
    cone: FrictionCoefficients,
) -> FrictionalState:
    """Return the state between two at which the tangential force is the wanted one, by the Illinois rule."""
    ends = [before.grip.travel, after.grip.travel]
    missing = [float(s.grip.tangential.sum()) - wanted for s in (before, after)]
    side = 0
    for _ in range(CUTS):
        travel = (ends[0] * missing[1] - ends[1] * missing[0]) / (missing[1] - missing[0])
        state_reached = _by_travel(pad, before, normal, travel, cone)
        off = float(state_reached.grip.tangential.sum()) - wanted
        if abs(off) <= SAME_FORCE * normal:
            return state_reached
        new = int(off * missing[1] > 0)
        ends[new], missing[new] = travel, off
        if new == side:
            missing[1 - new] /= 2
        side = new
    raise ContactError(
        f"no travel gives the tangential force {wanted:.4g} N: it jumps by {abs(off):.1e} N there"
    )


def _joined(first: FrictionalState, second: FrictionalState) -> FrictionalState:
    return replace(
        second,
        grip=joined(first.grip, second.grip),
        dissipated=first.dissipated + second.dissipated,
        residual=max(first.residual, second.residual),
        iterations=first.iterations + second.iterations,
    )
