"""From rest to a force, and to the force at which all ridges touch, in as many steps as it takes."""

from __future__ import annotations

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.mechanics.contact.elastic import Elastic
from skincad.mechanics.contact.newton import (
    DivergedError,
    Load,
    PressedPad,
    PressedState,
    UnstableError,
    contact_under,
    linearised,
    newton,
    seen_by_plate,
)
from skincad.mechanics.contact.stability import tipping_ridge
from skincad.mechanics.contact.threshold import Ridges, all_touch_force

SMALLEST = 1 / 32  # of the load, the smallest load step
WALK = 6  # halvings of the way to the threshold before it is given up


def _given(force: float) -> Load:
    return lambda *_: force


def press_to(pad: PressedPad[Elastic], force: float, guess: Array | None = None) -> PressedState:
    """Return the state under `force`: from the guess, else from rest, in one step or as many as it takes.

    From rest the first step is the small-strain solution. Raises DivergedError with the largest force
    that has a state.
    """
    if guess is not None:
        try:
            return newton(pad, guess, _given(force))
        except DivergedError:
            pass
    last: PressedState | None = None
    reached, step = 0.0, 1.0
    while True:
        target = min(1.0, reached + step)
        try:
            state = _further(pad, last, target * force)
        except DivergedError as failure:
            step = (target - reached) / 2
            if step < SMALLEST:
                raise _ended(pad, last, failure) from None
            continue
        if target == 1.0:
            return state
        last, reached = state, target


def _further(pad: PressedPad[Elastic], last: PressedState | None, force: float) -> PressedState:
    """The state under `force`, looked for from another one, or from rest."""
    if last is None:
        return newton(pad, np.zeros(pad.body.free.size), _given(force))
    return newton(pad, last.values, _given(force), last.contact.active)


def _ended(pad: PressedPad[Elastic], last: PressedState | None, failure: DivergedError) -> DivergedError:
    """The failure beyond the last state, with that state's force and, where the next is not stable, what
    gives way there."""
    if last is None or not isinstance(failure, UnstableError):
        return DivergedError(str(failure), 0.0 if last is None else last.force)
    linear = pad.body.linearised(last.values, pad.body.residual(last.values))
    ridge = tipping_ridge(pad.body, last.values, linear, last.contact)
    return UnstableError(f"ridge {ridge} tips over, no equilibrium beyond is stable", last.force)


def press_until_all_touch(
    pad: PressedPad[Elastic], near: PressedState, guess: Array | None = None
) -> PressedState:
    """Return the state at the smallest force at which every ridge touches, found from a state nearby.

    In each step that force is the linearised contact's own (threshold.py), so that the force converges
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
        return _walked(pad, near, load, guess)
    except DivergedError as failure:
        words, reached = str(failure), failure.reached
    try:
        at_rest = np.zeros(pad.body.free.size)
        ridges, _ = seen_by_plate(pad, at_rest, linearised(pad.body, at_rest, at_rest))
        return _walked(pad, press_to(pad, load(ridges, None)), load)
    except DivergedError:
        raise DivergedError(words, reached) from None


def _walked(
    pad: PressedPad[Elastic], state: PressedState, load: Load, guess: Array | None = None
) -> PressedState:
    """The state at the force that `load` asks for, from a state in steps halfway to what it asks there."""
    start = state.values if guess is None else guess
    for _ in range(WALK):
        try:
            return newton(pad, start, load, state.contact.active)
        except DivergedError as failure:
            words = str(failure)
        try:
            wanted, _ = contact_under(state.ridges, load, state.contact.active)
        except DivergedError:  # too far from it to know more than that it takes less
            wanted = 0.0
        halfway = (state.force + wanted) / 2
        try:
            state = _further(pad, state, min(halfway, 1.5 * state.force))
        except DivergedError as failure:
            raise DivergedError(str(failure), state.force) from None
        start = state.values
    raise DivergedError(words, state.force)
