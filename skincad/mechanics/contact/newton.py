"""Newton on a neo-Hookean pad under a flat plate, contact solved exactly in each step.

The body is plane (neo_hooke.py) or solid (solid_body.py); what is asked of it is `Elastic`. Stable is what
stands while the plate holds it (stability.py).

The plate is flat and without friction, so the contact condition is linear in the vertical displacement:
the step's contact problem has the true gaps and *total* nodal forces, and only the body is linearised.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.base.interrupt import safe_point
from skincad.mechanics.contact.elastic import Elastic, LinearisedBody
from skincad.mechanics.contact.frictionless import NodalContact, press
from skincad.mechanics.contact.stability import stable
from skincad.mechanics.contact.threshold import Ridges
from skincad.mechanics.problem import ContactError

STEPS = 15  # Newton steps in one go; four to seven are usual, and a smaller load is cheaper than more
RESIDUAL = 1e-9  # of the contact forces' norm; never accepted above
ROUNDING = 1e-14  # of E times the unit length: what a residual is worth under the lightest loads
FALLING = 0.1  # of the last residual, in a step; rounding does not fall
SHORTEST = 1 / 64  # of a Newton step; one that is still inside out then has lost its way
UNSTABLE = "no stable equilibrium, a ridge tips over or its tip folds"

Load = Callable[[Ridges, Mask | None], float]  # the force, read off the linearised contact and what touches


class DivergedError(ContactError):
    """Newton has found no equilibrium; `reached` is the largest force with one, in units."""

    def __init__(self, words: str, reached: float = 0.0) -> None:
        super().__init__(words)
        self.reached = reached


class UnstableError(DivergedError):
    """The equilibrium is not stable."""


AnyBody_co = TypeVar("AnyBody_co", bound=Elastic, covariant=True)


@dataclass(frozen=True)
class PressedPad(Generic[AnyBody_co]):
    """What is pressed: a body, its highest point `top`.

    `drops` `(ridges,)` is how much lower each crest is than meshed. Lengths in units.
    """

    body: AnyBody_co
    top: float
    drops: Array | None = None


@dataclass(frozen=True)
class PressedState:
    """An equilibrium at `force`: unknowns `values` `(n,)`, the contact and the plate's `approach`.

    `ridges` is the contact linearised here; `residual` is relative to the contact forces' norm and
    `history` holds it for each step on the way. In the pad's units.
    """

    values: Array
    force: float
    approach: float
    contact: NodalContact
    ridges: Ridges
    residual: float
    history: tuple[float, ...]


def newton(pad: PressedPad[Elastic], start: Array, load: Load, active: Mask | None = None) -> PressedState:
    """Return the equilibrium near `start` `(n,)`, where `active` `(m,)` touches, at the force that `load`
    asks for.

    A step is halved while it turns a point of an element inside out. Raises DivergedError when the residual
    stays above RESIDUAL, or when the equilibrium is not stable.
    """
    body, values = pad.body, start
    history: list[float] = []
    unbalanced = body.residual(values)
    for _ in range(STEPS):
        safe_point()
        linear = linearised(body, values, unbalanced)
        ridges, base = seen_by_plate(pad, values, linear)
        force, contact = contact_under(ridges, load, active)
        active = contact.active
        push = np.zeros_like(values)
        push[body.rest.contact] = body.rest.nodes.rows.T @ contact.force
        move = linear.move(push)
        share = _share(body, values, move)
        values = values + share * move
        unbalanced = body.residual(values)
        scale = float(np.linalg.norm(push))
        history.append(float(np.linalg.norm((unbalanced + push)[body.free])) / scale)
        if share == 1.0 and history[-1] <= max(RESIDUAL, ROUNDING / scale) and not _falls(history):
            if not stable(body, linear, ridges, contact):
                raise UnstableError(UNSTABLE)
            return PressedState(
                values, force, contact.approach + base, contact, ridges, history[-1], tuple(history)
            )
    raise DivergedError(
        "no equilibrium is found, as where a tip or a fillet folds "
        f"(residual {history[-1]:.1e} of the contact force after {STEPS} steps)"
    )


def _falls(history: list[float]) -> bool:
    """Whether a residual that only rounding would excuse still falls: then it is not rounding."""
    return RESIDUAL < history[-1] < FALLING * max(history[-2:]) and len(history) < STEPS


def contact_under(ridges: Ridges, load: Load, active: Mask | None) -> tuple[float, NodalContact]:
    """Return the linearised contact's force and state; of a body that needs its plate, where sweeps from
    `active` settle, else UnstableError."""
    try:
        force = load(ridges, active)
        return force, press(ridges.flexibility, ridges.gap, force, active, definite=ridges.definite)
    except DivergedError:
        raise
    except ContactError:
        if ridges.definite:
            raise
        raise UnstableError(UNSTABLE) from None


def linearised(body: Elastic, values: Array, unbalanced: Array) -> LinearisedBody:
    """Return the body linearised; UnstableError where it has no tangent, or none that contact could hold."""
    try:
        return body.linearised(values, unbalanced)
    except ContactError:
        raise UnstableError(UNSTABLE) from None


def seen_by_plate(pad: PressedPad[Elastic], values: Array, linear: LinearisedBody) -> tuple[Ridges, float]:
    """Return the contact as the plate sees it, its gaps those of the linearised body without contact forces.

    Gaps count from the lowest one, which is returned too.
    """
    rest = pad.body.rest
    unloaded = (values + linear.move(np.zeros_like(values)))[rest.contact]
    ridges = replace(
        Ridges.of(rest, linear.flexibility, pad.top), definite=not any(linear.negative_eigenvalues)
    )
    if pad.drops is not None:
        ridges = ridges.lowered(pad.drops)
    gap = ridges.gap - rest.nodes.rows @ unloaded
    fine_gap = ridges.fine_gap - rest.fine.rows @ unloaded
    base = float(gap.min())
    return replace(ridges, gap=gap - base, fine_gap=fine_gap - base), base


def _share(body: Elastic, values: Array, move: Array) -> float:
    """How much of a step to take: all of it, or the largest half, quarter, ... that inverts no element."""
    share = 1.0
    while not np.isfinite(body.energy(values + share * move)):
        share /= 2
        if share < SHORTEST:
            raise DivergedError("an element turns inside out")
    return share
