"""A step with friction cut in halves where it does not converge whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from skincad.mechanics.contact.frictional import grip
from skincad.mechanics.contact.grip import Compliant, Cone, Drive, Grip, GrossSlip
from skincad.mechanics.problem import ContactError


def halved(
    skin: Callable[[Drive], Compliant], before: Grip, start: Drive, end: Drive, cone: Cone, deepest: int = 4
) -> Grip:
    """Return `grip` at `end`; a step that does not converge is cut in two, `deepest` times at most.

    What the parts slipped is added up. Raises as `grip` does.
    """
    try:
        return grip(skin(end), before, end, cone)
    except GrossSlip:
        raise
    except ContactError:
        if deepest == 0:
            raise
    middle = between(start, end)
    first = halved(skin, before, start, middle, cone, deepest - 1)
    second = halved(skin, first, middle, end, cone, deepest - 1)
    return joined(first, second)


def joined(first: Grip, second: Grip) -> Grip:
    """Return the state at the end of two steps as that of one."""
    slipped, residual = first.slipped + second.slipped, max(first.residual, second.residual)
    return replace(second, slipped=slipped, residual=residual)


def between(a: Drive, b: Drive) -> Drive:
    """Return what the plate does halfway."""

    def mean(one: float | None, other: float | None) -> float | None:
        return None if one is None or other is None else (one + other) / 2

    pull, travel = mean(a.tangential, b.tangential), mean(a.travel, b.travel)
    return Drive((a.normal + b.normal) / 2, pull, travel, (a.angle + b.angle) / 2)
