"""Newton on a neo-Hookean pad under a flat plate, contact solved exactly in each step.

The body is plane (neo_hooke.py) or solid (solid_body.py); what is asked of it is `Elastic`.

The plate is flat and without friction, so the contact condition is linear in the vertical displacement:
the step's contact problem has the true gaps and *total* nodal forces, and only the body is linearised.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.mechanics.bodies import neo_hooke
from skincad.mechanics.bodies.elements import Assembled
from skincad.mechanics.bodies.neo_hooke import NeoHookeBody
from skincad.mechanics.contact.frictionless import NodalContact, press
from skincad.mechanics.contact.threshold import Ridges, all_touch_force
from skincad.mechanics.problem import ContactError

STEPS = 15  # Newton steps in one go; four to seven are usual, and a smaller load is cheaper than more
RESIDUAL = 1e-9  # of the contact forces' norm; never accepted above
ROUNDING = 1e-14  # of E times the unit length: what a residual is worth under the lightest loads
SHORTEST = 1 / 64  # of a Newton step; one that is still inside out then has lost its way
SMALLEST = 1 / 32  # of the load, the smallest load step
WALK = 6  # halvings of the way to the threshold before it is given up
UNSTABLE = "no stable equilibrium, a ridge buckles or its tip folds"

Load = Callable[[Ridges], float]  # the force, read off the linearised contact


class DivergedError(ContactError):
    """Newton has found no equilibrium; `reached` is the largest force with one, in units."""

    def __init__(self, words: str, reached: float = 0.0) -> None:
        super().__init__(words)
        self.reached = reached


class LinearisedBody(Protocol):
    """A body linearised at a state, seen by its contact unknowns: their `flexibility` `(k, k)`."""

    @property
    def flexibility(self) -> Array: ...  # noqa: D102

    @property
    def stable(self) -> bool:
        """Whether the tangent is positive definite."""

    def move(self, push: Array) -> Array:
        """Return the step `(n,)` that balances the body, to first order, under contact forces `-push`."""


class Elastic(Protocol):
    """An elastic body; a state is the vector of all its unknowns `(n,)`, of which `free` are not held.

    Of `rest` the contact unknowns and the sampled contact boundary are used.
    """

    @property
    def rest(self) -> Assembled: ...  # noqa: D102

    @property
    def free(self) -> Mask: ...  # noqa: D102

    def residual(self, state: Array) -> Array:
        """Return the energy's derivative `(n,)` by all unknowns, held ones included."""

    def energy(self, state: Array) -> float:
        """Return the energy; infinite where a point of the elements is turned inside out."""

    def linearised(self, state: Array, residual: Array) -> LinearisedBody:
        """Return the body at a state whose `residual` is at hand; ContactError where it is singular."""

    def fault(self, state: Array, plate: float) -> str | None:
        """Return what touches without being in contact, under a plate at the height `plate`, or None."""


AnyBody_co = TypeVar("AnyBody_co", bound=Elastic, covariant=True)


@dataclass(frozen=True)
class Pressed(Generic[AnyBody_co]):
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


def pressed(
    mesh: Any,
    order: int,
    materials: Mapping[str, tuple[float, float]],
    top: float,
    drops: Array | None = None,
) -> Pressed[NeoHookeBody]:
    """Return the pad of a curved mesh at one order of displacements."""
    return Pressed(neo_hooke.body(mesh, order, materials), top, drops)


def newton(pad: Pressed[Elastic], start: Array, load: Load) -> PressedState:
    """Return the equilibrium near `start` `(n,)` at the force that `load` asks for.

    A step is halved while it turns a point of an element inside out. Raises DivergedError when the residual
    stays above RESIDUAL, or when the equilibrium is not stable.
    """
    body, values = pad.body, start
    history: list[float] = []
    contact: NodalContact | None = None
    unbalanced = body.residual(values)
    for _ in range(STEPS):
        linear = _linearised(body, values, unbalanced)
        ridges, base = _seen_by_plate(pad, values, linear)
        force = load(ridges)
        contact = press(ridges.flexibility, ridges.gap, force, None if contact is None else contact.active)
        push = np.zeros_like(values)
        push[body.rest.contact] = body.rest.nodes.rows.T @ contact.force
        move = linear.move(push)
        share = _share(body, values, move)
        values = values + share * move
        unbalanced = body.residual(values)
        scale = float(np.linalg.norm(push))
        history.append(float(np.linalg.norm((unbalanced + push)[body.free])) / scale)
        if share == 1.0 and history[-1] <= max(RESIDUAL, ROUNDING / scale):
            if not linear.stable:
                raise DivergedError(UNSTABLE)
            return PressedState(
                values, force, contact.approach + base, contact, ridges, history[-1], tuple(history)
            )
    raise DivergedError(f"the residual is {history[-1]:.1e} of the contact force after {STEPS} steps")


def _linearised(body: Elastic, values: Array, unbalanced: Array) -> LinearisedBody:
    try:
        return body.linearised(values, unbalanced)
    except ContactError:
        raise DivergedError(UNSTABLE) from None


def _seen_by_plate(pad: Pressed[Elastic], values: Array, linear: LinearisedBody) -> tuple[Ridges, float]:
    """The contact as the plate sees it, its gaps those of the linearised body without contact forces.

    Gaps count from the lowest one, which is returned too.
    """
    rest = pad.body.rest
    unloaded = (values + linear.move(np.zeros_like(values)))[rest.contact]
    ridges = Ridges.of(rest, linear.flexibility, pad.top)
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


def _given(force: float) -> Load:
    return lambda _: force


def press_to(pad: Pressed[Elastic], force: float, guess: Array | None = None) -> PressedState:
    """Return the state under `force`: from the guess, else from rest, in one step or as many as it takes.

    From rest the first step is the small-strain solution. Raises DivergedError with the largest force
    that has a state.
    """
    if guess is not None:
        try:
            return newton(pad, guess, _given(force))
        except DivergedError:
            pass
    values, done, step = np.zeros(pad.body.free.size), 0.0, 1.0
    while True:
        target = min(1.0, done + step)
        try:
            state = newton(pad, values, _given(target * force))
        except DivergedError as failure:
            step = (target - done) / 2
            if step < SMALLEST:
                raise DivergedError(str(failure), done * force) from None
            continue
        if target == 1.0:
            return state
        values, done = state.values, target


def press_until_all_touch(
    pad: Pressed[Elastic], near: PressedState, guess: Array | None = None
) -> PressedState:
    """Return the state at the smallest force at which every ridge touches, found from a state nearby.

    In each step that force is the linearised contact's own (threshold.py), so that the force converges
    together with the state, quadratically; at the end the minimum of the last ridge's gap is zero and every
    other ridge touches. Raises DivergedError where there is no such state.
    """

    def load(ridges: Ridges) -> float:
        found = all_touch_force(ridges, near.force)
        if found is None:
            raise DivergedError("no force makes the last ridge touch")
        return found

    start, state = near.values if guess is None else guess, near
    for _ in range(WALK):
        try:
            return newton(pad, start, load)
        except DivergedError as failure:
            words = str(failure)
        try:
            halfway = (state.force + load(state.ridges)) / 2
            state = newton(pad, state.values, _given(min(halfway, 1.5 * state.force)))
        except DivergedError as failure:
            raise DivergedError(str(failure), state.force) from None
        start = state.values
    raise DivergedError(words, state.force)
