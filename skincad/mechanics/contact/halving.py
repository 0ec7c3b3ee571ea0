"""A step of a march cut in halves where it does not converge whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from skincad.mechanics.contact.frictional import grip
from skincad.mechanics.contact.grip import Compliance, ContactState, Drive, FrictionCoefficients, GrossSlip
from skincad.mechanics.problem import ContactError

State = TypeVar("State")
# From a state, and the drive that led to it, to another drive; what share of the whole step that is
Advance = Callable[[State, Drive, Drive, float], State]


def in_halves(
    advance: Advance[State],
    before: State,
    start: Drive,
    end: Drive,
    joined: Callable[[State, State], State],
    deepest: int,
    share: float = 1.0,
) -> State:
    """Return what `advance` says of a step, or of this `share` of one; where it does not converge, of both
    halves `joined`, cut `deepest` times at most. Raises as `advance` does."""
    try:
        return advance(before, start, end, share)
    except GrossSlip:
        raise
    except ContactError:
        if deepest == 0:
            raise
    middle = between(start, end)
    first = in_halves(advance, before, start, middle, joined, deepest - 1, share / 2)
    try:
        return joined(first, in_halves(advance, first, middle, end, joined, deepest - 1, share / 2))
    except GrossSlip as limit:
        limit.last = joined(first, limit.last)
        raise


def halved(
    skin: Callable[[Drive], Compliance],
    before: ContactState,
    start: Drive,
    end: Drive,
    cone: FrictionCoefficients,
    deepest: int = 4,
) -> ContactState:
    """Return `grip` at `end`, in halves where need be; what the parts slipped is added up."""

    def advance(before: ContactState, _start: Drive, end: Drive, _share: float) -> ContactState:
        return grip(skin(end), before, end, cone)

    return in_halves(advance, before, start, end, joined, deepest)


def joined(first: ContactState, second: ContactState) -> ContactState:
    """Return the state at the end of two steps as that of one."""
    slipped, residual = first.slipped + second.slipped, max(first.residual, second.residual)
    return replace(second, slipped=slipped, residual=residual)


def between(a: Drive, b: Drive) -> Drive:
    """Return what the plate does halfway."""

    def mean(one: float | None, other: float | None) -> float | None:
        return None if one is None or other is None else (one + other) / 2

    pull, travel = mean(a.tangential, b.tangential), mean(a.travel, b.travel)
    return Drive((a.normal + b.normal) / 2, pull, travel, (a.angle + b.angle) / 2)
