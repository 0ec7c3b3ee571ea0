"""Newton on a neo-Hookean pad under a flat plate, contact solved exactly in each step.

The plate is flat and without friction, so the contact condition is linear in the vertical displacement:
the step's contact problem has the true gaps and *total* nodal forces, and only the body is linearised.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skincad.mechanics import neo_hooke
from skincad.mechanics.condense import Condensed, factorise, fill_order
from skincad.mechanics.contact import Contact, press
from skincad.mechanics.neo_hooke import Body, Tangent
from skincad.mechanics.problem import ContactError
from skincad.mechanics.threshold import Ridges, all_touch_force

Array = NDArray[np.float64]
Index = NDArray[np.int64]

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


@dataclass(frozen=True)
class Pressed:
    """What is pressed: a body, the order of its unknowns kept over all steps, its highest point `top`.

    `drops` `(ridges,)` is how much lower each crest is than meshed. Lengths in units.
    """

    body: Body
    order: Index
    top: float
    drops: Array | None


@dataclass(frozen=True)
class State:
    """An equilibrium at `force`: unknowns `values` `(n,)`, the contact and the plate's `approach`.

    `ridges` is the contact linearised here; `residual` is relative to the contact forces' norm and
    `history` holds it for each step on the way. In the pad's units.
    """

    values: Array
    force: float
    approach: float
    contact: Contact
    ridges: Ridges
    residual: float
    history: tuple[float, ...]


def pressed(
    mesh: Any,
    order: int,
    materials: Mapping[str, tuple[float, float]],
    top: float,
    drops: Array | None = None,
) -> Pressed:
    """Return the pad of a curved mesh at one order of displacements."""
    body = neo_hooke.body(mesh, order, materials)
    rest = body.rest
    return Pressed(body, np.concatenate([fill_order(rest.matrix, rest.interior), rest.contact]), top, drops)


def newton(pad: Pressed, start: Array, load: Load) -> State:
    """Return the equilibrium near `start` `(n,)` at the force that `load` asks for.

    A step is halved while it turns a point of an element inside out. Raises DivergedError when the residual
    stays above RESIDUAL, or when the equilibrium is not stable.
    """
    body, values = pad.body, start
    history: list[float] = []
    contact: Contact | None = None
    unbalanced = neo_hooke.residual(body, values)
    for _ in range(STEPS):
        linear, small = _tangent(pad, values, unbalanced)
        ridges, base = _linearised(pad, values, linear, small)
        force = load(ridges)
        contact = press(ridges.flexibility, ridges.gap, force, None if contact is None else contact.active)
        push = np.zeros_like(values)
        push[body.rest.contact] = body.rest.nodes.rows.T @ contact.force
        move = linear.recover(small.solve(-linear.residual - push))
        share = _share(body, values, move)
        values = values + share * move
        unbalanced = neo_hooke.residual(body, values)
        scale = float(np.linalg.norm(push))
        history.append(float(np.linalg.norm((unbalanced + push)[body.free])) / scale)
        if share == 1.0 and history[-1] <= max(RESIDUAL, ROUNDING / scale):
            if small.factor.U.diagonal().min() <= 0:
                raise DivergedError(UNSTABLE)
            return State(values, force, contact.approach + base, contact, ridges, history[-1], tuple(history))
    raise DivergedError(f"the residual is {history[-1]:.1e} of the contact force after {STEPS} steps")


def _tangent(pad: Pressed, values: Array, unbalanced: Array) -> tuple[Tangent, Condensed]:
    try:
        linear = neo_hooke.tangent(pad.body, values, unbalanced)
        return linear, factorise(linear.matrix, pad.order, pad.body.rest.contact.size)
    except (ContactError, RuntimeError):  # SuperLU's own error for a singular matrix
        raise DivergedError(UNSTABLE) from None


def _linearised(pad: Pressed, values: Array, linear: Tangent, small: Condensed) -> tuple[Ridges, float]:
    """The contact as the plate sees it, its gaps those of the linearised body without contact forces.

    Gaps count from the lowest one, which is returned too.
    """
    rest = pad.body.rest
    unloaded = (values - small.solve(linear.residual))[rest.contact]
    ridges = Ridges.of(rest, small.flexibility, pad.top)
    if pad.drops is not None:
        ridges = ridges.lowered(pad.drops)
    gap = ridges.gap - rest.nodes.rows @ unloaded
    fine_gap = ridges.fine_gap - rest.fine.rows @ unloaded
    base = float(gap.min())
    return replace(ridges, gap=gap - base, fine_gap=fine_gap - base), base


def _share(body: Body, values: Array, move: Array) -> float:
    """How much of a step to take: all of it, or the largest half, quarter, ... that inverts no element."""
    share = 1.0
    while not np.isfinite(neo_hooke.energy(body, values + share * move)):
        share /= 2
        if share < SHORTEST:
            raise DivergedError("an element turns inside out")
    return share


def _given(force: float) -> Load:
    return lambda _: force


def press_to(pad: Pressed, force: float, guess: Array | None = None) -> State:
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


def press_until_all_touch(pad: Pressed, near: State, guess: Array | None = None) -> State:
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
