"""Newton's method for a pressed body at finite strain, loaded step by step.

Plane bodies are in bodies/plane_body.py, solid ones in bodies/solid_body.py.

The plate is flat and without friction, so the contact condition is linear in the vertical displacement:
the step's contact problem has the true gaps and *total* nodal forces, and only the body is linearised.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.base.interrupt import safe_point
from skincad.mechanics.contact.frictionless import NodalContact, Ridges, all_touch_force, press
from skincad.mechanics.contact.stability import Body, LinearisedBody, at_contact, stable, tipping_ridge
from skincad.mechanics.problem import ContactError

MAX_STEPS = 15  # Newton steps in one go; four to seven are usual, and a smaller load is cheaper than more
RESIDUAL = 1e-9  # of the contact forces' norm; never accepted above
ROUNDING = 1e-14  # of E times the unit length: what a residual is worth under the lightest loads
FALLING = 0.1  # of the last residual, in a step; rounding does not fall
# Of the contact forces' norm: a tangent from further away does not tell whether the state is stable, and is
# not kept. One that leaves more than SLOW of a residual is replaced: in three dimensions a new one takes as
# long as five steps with the old, and squares what each of them divides
NEAR, SLOW = 1e-2, 0.1
MAX_GROWTH = 1e3  # a residual that has grown so much in a step leads nowhere
SHORTEST = 1 / 64  # of a Newton step; one that is still inside out then has lost its way
UNSTABLE = "no stable equilibrium, a ridge tips over or its tip folds"

Load = Callable[[Ridges, Mask | None], float]  # the force, read off the linearised contact and what touches


class DivergedError(ContactError):
    """Newton has found no equilibrium, or one that is `unstable`; `reached` is the largest force with a
    stable one, in units."""

    def __init__(self, words: str, reached: float = 0.0, *, unstable: bool = False) -> None:
        super().__init__(words)
        self.reached, self.unstable = reached, unstable


@dataclass(frozen=True)
class PressedPad:
    """What is pressed: a body, its highest point `top`.

    `drops` `(ridges,)` is how much lower each crest is than meshed. Lengths in units.
    """

    body: Body
    top: float
    drops: Array | None = None


@dataclass(frozen=True)
class PadTangent:
    """A body linearised where the residual was `residual` of the contact forces, and its contact."""

    linear: LinearisedBody
    ridges: Ridges
    residual: float


@dataclass(frozen=True)
class PressedState:
    """An equilibrium at `force`: unknowns `values` `(n,)` and the contact, its residual the body's too.

    `ridges` is the contact linearised here; `history` holds the residual, relative to the contact forces'
    norm, of each step on the way. In the pad's units. `tangent` is the last one, at a state nearby.
    """

    values: Array
    force: float
    contact: NodalContact
    ridges: Ridges
    history: tuple[float, ...]
    tangent: PadTangent


def equilibrium(
    body: Body,
    start: Array,
    tangent: Any,
    *,
    tangent_at: Callable[[Array, Array, float], Any],
    contact: Callable[[Any, Any, Array], tuple[Array, Any]],
    keeps: Callable[[Any, list[float]], bool],
    steps: int,
    accuracy: float = RESIDUAL,
) -> tuple[Array, Any, Array, tuple[float, ...], Any]:
    """Return the equilibrium of a body and its contact near `start` `(n,)`: its unknowns, the contact's
    solution, what the body alone leaves unbalanced `(n,)`, the residual of each step relative to the contact
    forces' norm, and the last tangent, at a state nearby. The first of at most so many `steps` takes a
    `tangent` from another state, unless it is None.

    In each step the body alone is linearised. `tangent_at` does it at values whose residual is at hand, at a
    known distance from balance; what it returns has the linearised body as `linear`. `contact` takes that
    tangent, the linearised body rebalanced at the values, and them. It solves the contact with its true gaps
    and total forces, and returns what these add to the residual, with its solution. `keeps` says whether a
    tangent serves on, by the residuals so far. A step is halved while it turns a point of an element inside
    out. Raises DivergedError when the residual stays above `accuracy` or grows by MAX_GROWTH.
    """
    values = start
    history: list[float] = []
    unbalanced = body.residual(values)
    for _ in range(steps):
        safe_point()
        if tangent is None:
            tangent = tangent_at(values, unbalanced, history[-1] if history else np.inf)
        linear = tangent.linear.rebalanced(values, unbalanced)
        push, solution = contact(tangent, linear, values)
        move = linear.move(push)
        share = _share(body, values, move)
        values = values + share * move
        unbalanced = body.residual(values)
        scale = float(np.linalg.norm(push))
        history.append(float(np.linalg.norm((unbalanced + push)[body.free])) / scale)
        # a residual that only rounding would excuse, but that still falls, is not rounding
        falls = RESIDUAL < history[-1] < FALLING * max(history[-2:]) and len(history) < steps
        rounded = history[-1] <= ROUNDING / scale and not falls
        if share == 1.0 and (history[-1] <= accuracy or rounded):
            return values, solution, unbalanced, tuple(history), tangent
        if len(history) > 1 and history[-1] > MAX_GROWTH * max(history[-2], 1e-3):
            break
        if share < 1.0 or not keeps(tangent, history):
            tangent = None
    raise DivergedError(
        "no equilibrium is found, as where a tip or a fillet folds "
        f"(residual {history[-1]:.1e} of the contact force after {len(history)} steps)"
    )


def newton(
    pad: PressedPad,
    start: Array,
    load: Load,
    active: Mask | None = None,
    tangent: PadTangent | None = None,
    stable_to: float = 0.0,
) -> PressedState:
    """Return the equilibrium near `start` `(n,)`, where `active` `(m,)` touches, at the force that `load`
    asks for.

    Up to the force `stable_to` antisymmetric movements are known to be stable. Raises DivergedError as
    `equilibrium`, or when it is not stable.
    """
    body, touching = pad.body, active

    def contact(
        tangent: PadTangent, linear: LinearisedBody, values: Array
    ) -> tuple[Array, tuple[float, NodalContact, Ridges, float]]:
        nonlocal touching
        ridges, base = without_contact_forces(pad, tangent.ridges, values, linear)
        force, nodal = contact_under(ridges, load, touching)
        touching = nodal.active
        return at_contact(body, body.rest.nodes.rows.T @ nodal.force), (force, nodal, ridges, base)

    def keeps(tangent: PadTangent, history: list[float]) -> bool:
        return tangent.residual <= NEAR and len(history) > 1 and history[-1] <= SLOW * history[-2]

    at = partial(_tangent_at, pad)
    values, solution, unbalanced, history, tangent = equilibrium(
        body, start, tangent, tangent_at=at, contact=contact, keeps=keeps, steps=MAX_STEPS
    )
    force, nodal, ridges, base = solution
    if tangent.residual > NEAR:
        tangent = at(values, unbalanced, history[-1])
        ridges, _ = without_contact_forces(pad, tangent.ridges, values, tangent.linear)
    if not stable(body, tangent.linear, ridges, nodal, both=force > stable_to):
        raise DivergedError(UNSTABLE, unstable=True)
    residual = max(nodal.residual, history[-1])
    touching_state = replace(nodal, approach=nodal.approach + base, residual=residual)
    return PressedState(values, force, touching_state, ridges, history, tangent)


def _tangent_at(pad: PressedPad, values: Array, unbalanced: Array, residual: float) -> PadTangent:
    """The pad linearised; DivergedError where it has no tangent, or none that contact could hold."""
    try:
        linear: LinearisedBody = pad.body.linearised(values, unbalanced)
    except ContactError:
        raise DivergedError(UNSTABLE, unstable=True) from None
    ridges = Ridges.of(pad.body.rest, linear.flexibility, pad.top)
    ridges = replace(ridges, definite=not any(linear.negative_eigenvalues))
    return PadTangent(linear, ridges if pad.drops is None else ridges.lowered(pad.drops), residual)


def contact_under(ridges: Ridges, load: Load, active: Mask | None) -> tuple[float, NodalContact]:
    """Return the linearised contact's force and state; of a body that needs its plate, where sweeps from
    `active` settle, else DivergedError."""
    try:
        force = load(ridges, active)
        return force, press(ridges.flexibility, ridges.gap, force, active, definite=ridges.definite)
    except DivergedError:
        raise
    except ContactError:
        if ridges.definite:
            raise
        raise DivergedError(UNSTABLE, unstable=True) from None


def without_contact_forces(
    pad: PressedPad, ridges: Ridges, values: Array, linear: LinearisedBody
) -> tuple[Ridges, float]:
    """Return the contact `ridges` with the gaps of the linearised body without contact forces.

    Gaps count from the lowest one, which is returned too.
    """
    rest = pad.body.rest
    unloaded = (values + linear.move(np.zeros_like(values)))[rest.contact]
    gap = ridges.gap - rest.nodes.rows @ unloaded
    fine_gap = ridges.fine_gap - rest.fine.rows @ unloaded
    base = float(gap.min())
    return replace(ridges, gap=gap - base, fine_gap=fine_gap - base), base


def _share(body: Body, values: Array, move: Array) -> float:
    """How much of a step to take: all of it, or the largest half, quarter, ... that inverts no element."""
    share = 1.0
    while not np.isfinite(body.energy(values + share * move)):
        share /= 2
        if share < SHORTEST:
            raise DivergedError("an element turns inside out")
    return share


SMALLEST_STEP = 1 / 32  # of the load, the smallest load step
MAX_HALVINGS = 6  # halvings of the way to the threshold before it is given up


def at_rest(pad: PressedPad) -> PadTangent:
    """Return the pad linearised at rest: the pad of small strain."""
    return _tangent_at(pad, rest := np.zeros(pad.body.free.size), rest, np.inf)


def press_to(
    pad: PressedPad, force: float, guess: Array | None = None, rest: PadTangent | None = None
) -> PressedState:
    """Return the state under `force`: from the guess, else from rest, in one step or as many as it takes;
    `rest` is the tangent there, if it is at hand.

    From rest the first step is the small-strain solution. Raises DivergedError with the largest force
    that has a state.
    """
    if guess is not None:
        try:
            return newton(pad, guess, lambda *_: force)
        except DivergedError:
            pass
    last: PressedState | None = None
    tangent, reached, step = rest, 0.0, 1.0
    while True:
        target = min(1.0, reached + step)
        try:
            state = _next_state(pad, last, target * force, tangent)
        except DivergedError as failure:
            tangent = None  # a plane body's latest is another now
            step = (target - reached) / 2
            if step < SMALLEST_STEP:
                raise _failure_beyond(pad, last, failure) from None
            continue
        if target == 1.0:
            return state
        last, tangent, reached = state, state.tangent, target


def _next_state(
    pad: PressedPad, last: PressedState | None, force: float, tangent: PadTangent | None = None
) -> PressedState:
    """The state under `force`, looked for from another one, or from rest, with the tangent there if it is the
    body's latest."""
    if last is None:
        return newton(pad, np.zeros(pad.body.free.size), lambda *_: force, tangent=tangent)
    return newton(pad, last.values, lambda *_: force, last.contact.active, tangent)


def _failure_beyond(pad: PressedPad, last: PressedState | None, failure: DivergedError) -> DivergedError:
    """The failure beyond the last state, with that state's force and, where the next is not stable, what
    gives way there."""
    if last is None or not failure.unstable:
        return DivergedError(str(failure), 0.0 if last is None else last.force)
    linear = pad.body.linearised(last.values, pad.body.residual(last.values))
    ridge = tipping_ridge(pad.body, last.values, linear, last.contact)
    return DivergedError(
        f"ridge {ridge} tips over, no equilibrium beyond is stable", last.force, unstable=True
    )


def press_until_all_touch(pad: PressedPad, near: PressedState, guess: Array | None = None) -> PressedState:
    """Return the state at the smallest force at which every ridge touches, found from a state nearby.

    In each step that force is the linearised contact's own (frictionless.py), so that the force converges
    together with the state, quadratically; at the end the minimum of the last ridge's gap is zero and every
    other ridge touches. Where the way from the state nearby does not lead there, the one from rest does.
    Raises DivergedError where there is no such state.
    """

    def load(ridges: Ridges, active: Mask | None) -> float:
        force = all_touch_force(ridges, near.force, None if ridges.definite else active)
        if force is None:
            raise DivergedError("no force makes the last ridge touch")
        return force

    try:
        return _walk(pad, near, load, guess)
    except DivergedError as failure:
        words, reached = str(failure), failure.reached
    try:
        rest = at_rest(pad)
        return _walk(pad, press_to(pad, load(rest.ridges, None), rest=rest), load)
    except DivergedError:
        raise DivergedError(words, reached) from None


def _walk(pad: PressedPad, state: PressedState, load: Load, guess: Array | None = None) -> PressedState:
    """The state at the force that `load` asks for, from a state in steps halfway to what it asks there."""
    start, tangent = (state.values, state.tangent) if guess is None else (guess, None)
    for _ in range(MAX_HALVINGS):
        try:
            return newton(pad, start, load, state.contact.active, tangent, state.force)
        except DivergedError as failure:
            words = str(failure)
        try:
            wanted, _ = contact_under(state.ridges, load, state.contact.active)
        except DivergedError:  # too far from it to know more than that it takes less
            wanted = 0.0
        halfway = (state.force + wanted) / 2
        try:
            state = _next_state(pad, state, min(halfway, 1.5 * state.force))
        except DivergedError as failure:
            raise DivergedError(str(failure), state.force) from None
        start, tangent = state.values, state.tangent
    raise DivergedError(words, state.force)
