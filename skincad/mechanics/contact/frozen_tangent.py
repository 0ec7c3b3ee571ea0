"""A pad that keeps the tangent of a chosen step (modified Newton) until its points have moved far enough.

At a chosen step the equilibrium is found as in frictional_pad.py, and the body is linearised there. In the
steps between, the pad is a constant compliance about that state: it knows how far ridges are pressed, bent
and turned, and that a normal force bends them further (P-delta). The next step is chosen once a touching
point has moved by the update interval. The linear pad's error at that step is its drift. It is corrected
gradually over the following interval, so that nothing jumps, and its size is the error. Drift grows with the
square of the interval.

Where finite strain has no equilibrium, as where the surface folds (press_path.py), the last tangent stays,
and the error grows with the square of the distance moved since. Range: quasi-static, a plate that keeps its
angle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.contact.frictional import halved, solve_contact
from skincad.mechanics.contact.frictional_pad import (
    FrictionalPad,
    FrictionalState,
    Tangential,
    contact_load,
    dissipated,
    linearised,
    newton,
    unloaded,
)
from skincad.mechanics.contact.press_path import undetected_contact
from skincad.mechanics.contact.state import (
    Compliance,
    ContactState,
    Drive,
    FrictionCoefficients,
    GrossSlip,
    Swing,
)
from skincad.mechanics.problem import ContactError

# Of a crest's width. Measured on yamada-2002-slip at friction 0.5: the largest stress within 1.5 % of finite
# strain in each of 110 steps, by 14 chosen ones; 0.4 % by 33 at 1 / 30
UPDATE_INTERVAL = 1 / 12
# The error of earlier chosen steps stays in points that stick: a ridge's forces are off by up to 1.6 times
# the last one's error (in 95 % of 40 slips: the first 8 scenes of bench/leads.py's seed 1, and
# yamada-2002-slip at friction 0.4)
STICKING_FACTOR = 2.0
RETRY_SHARE = 0.9  # of the forces without an equilibrium; below both of them it is searched for again

Stresses = Callable[
    [Array, Tangential], tuple[Array, Array]
]  # the strips' `(3 strips,)`, and per N `(.., 2 m)`


class Drift(NamedTuple):
    """Error of a linear pad: of each ridge's `forces` `(2, ridges)` N, along x and z, and of the strips'
    stresses `films` `(strips, 3)` MPa. `chosen` says whether the step is a chosen one, `cut` why no later
    one could be, or ''."""

    forces: Array
    films: Array
    chosen: bool = False
    cut: str = ""


@dataclass(frozen=True, eq=False)
class FrozenTangent:
    """The tangent kept from a chosen step on: the pad as the plate sees it, `skin`; in that step the contact
    points' forces and places `(2 m,)`, N and mm, the state, and the strips' `films` with their change
    `per_force`. `correction` `(2 m,)` mm and `film_correction` are added gradually; `drift` is the error of
    the tangent before; `cut` says why no later step could be chosen, at the forces `at`, N."""

    skin: Compliance
    force: Array
    place: Array
    state: FrictionalState
    linear: Tangential
    films: Array
    per_force: Array
    correction: Array
    film_correction: Array
    drift: Drift
    cut: str = ""
    at: tuple[float, float] = (np.inf, np.inf)


@dataclass(frozen=True, eq=False)
class FrozenTangentState:
    """A state: the contact, the points' places `(2 m,)` mm, the strips' stresses, the energy mJ that the
    contact has put in, and the energy that friction dissipated in the step. `distance` is the largest
    distance that a touching point has moved since the chosen step of `tangent`, in update intervals;
    `chosen` says whether this is such a step."""

    contact: ContactState
    place: Array
    films: Array
    elastic: float
    dissipated: float
    tangent: FrozenTangent
    distance: float = 0.0
    chosen: bool = True


@dataclass(frozen=True, eq=False)
class FrozenTangentPad:
    """A pad with its strips' stresses; `folds` says whether its surface may fold."""

    pad: FrictionalPad
    stresses: Stresses
    interval: float  # mm, how far a point moves between two chosen steps
    folds: bool

    def start(self) -> FrozenTangentState:
        """Return the unloaded pad with its tangent."""
        state = unloaded(self.pad)
        linear = linearised(self.pad, state.values, self.pad.body.residual(state.values))
        zero = np.zeros(2 * self.pad.gap.size)
        films, per_force = self.stresses(state.values, linear)
        drift = Drift(np.zeros((2, self.pad.ridge.max(initial=0))), np.zeros_like(films))
        skin = Compliance(linear.compliance, self.pad.gap, zero, linear.solved, self.pad.area)
        tangent = FrozenTangent(
            skin=skin,
            force=zero,
            place=zero,
            state=state,
            linear=linear,
            films=films,
            per_force=per_force,
            correction=zero,
            film_correction=np.zeros_like(films),
            drift=drift,
        )
        return FrozenTangentState(state.contact, zero, films, 0.0, 0.0, tangent)

    def advanced(
        self,
        before: FrozenTangentState,
        start: Drive,
        end: Drive,
        cone: FrictionCoefficients,
        swing: Swing | None = None,
    ) -> FrozenTangentState:
        """Return the state at a step's end, with what masses add if they `swing`. Raises GrossSlip, with the
        last state, and ContactError."""
        if end.angle:
            raise ContactError("finite_strain takes a plate that keeps its angle")
        tangent, share = before.tangent, 1 - min(1.0, before.distance)
        skin = replace(tangent.skin, free=tangent.skin.free + share * tangent.correction)
        try:
            if swing:
                contact = solve_contact(skin.swung(swing), before.contact, swing.drive, cone, swing.inert)
            else:
                contact = halved(lambda _: skin, before.contact, start, end, cone)
            after = self._linear_state(before, contact, skin, share)
        except GrossSlip as limit:
            limit.last = self._linear_state(before, limit.last, skin, share)
            raise
        forces = end.normal, abs(float(after.contact.tangential.sum()))
        if after.distance < 1.0 or not self._worth_retrying(tangent, forces):
            return after
        try:
            return self._chosen_state(before, after, end, cone, swing)
        except GrossSlip:
            raise
        except ContactError as failure:
            return replace(after, tangent=replace(tangent, cut=str(failure), at=forces))

    def drift(self, state: FrozenTangentState) -> Drift:
        """Return the linear pad's error at a state, of second order in the distance moved.

        Before the first chosen step it is unknown. It is then assumed to be, relative to forces and
        stresses, the distance moved over a crest's width.
        """
        missed, cut, grown = state.tangent.drift, state.tangent.cut, max(1.0, state.distance**2)
        if not state.tangent.state.values.any():
            part = UPDATE_INTERVAL * state.distance
            borne = np.abs(self._of_ridges(_on_skin(state.contact)))
            return Drift(part * borne, part * np.abs(state.films), state.chosen, cut)
        return Drift(missed.forces * grown, missed.films * grown, state.chosen, cut)

    @staticmethod
    def _worth_retrying(tangent: FrozenTangent, forces: tuple[float, float]) -> bool:
        """Whether an equilibrium is to be looked for, after it was not found under larger forces."""
        normal, pull = forces
        return not tangent.cut or (
            normal < RETRY_SHARE * tangent.at[0] and pull < RETRY_SHARE * tangent.at[1]
        )

    def _linear_state(
        self, before: FrozenTangentState, contact: ContactState, skin: Compliance, share: float
    ) -> FrozenTangentState:
        """The state that a contact leads to while the tangent stays; `share` of the correction is still
        added."""
        tangent, force = before.tangent, _on_skin(contact)
        place = skin.compliance @ force + skin.free
        films = tangent.films + tangent.per_force @ (force - tangent.force) + share * tangent.film_correction
        stored = before.elastic + float((force + _on_skin(before.contact)) @ (place - before.place)) / 2
        far = (
            np.hypot(*(place - tangent.place).reshape(2, -1))[contact.touches].max(initial=0.0)
            / self.interval
        )
        distance, spent = max(before.distance, float(far)), dissipated(before.contact, contact)
        return FrozenTangentState(
            contact=contact,
            place=place,
            films=films,
            elastic=stored,
            dissipated=spent,
            tangent=tangent,
            distance=distance,
            chosen=False,
        )

    def _chosen_state(
        self,
        before: FrozenTangentState,
        after: FrozenTangentState,
        end: Drive,
        cone: FrictionCoefficients,
        swing: Swing | None,
    ) -> FrozenTangentState:
        """The same state with the tangent of the equilibrium under this drive, kept from here on."""
        pad, tangent = self.pad, after.tangent
        start = FrictionalState(tangent.state.values, before.contact, np.zeros_like(tangent.state.values))
        guess = self._guess(after)
        pad.tangents.clear()
        try:
            state = newton(pad, start, end, cone, guess, swing)
        except GrossSlip as limit:
            limit.last = replace(after, contact=limit.last.contact)
            raise
        true, force = _on_skin(state.contact), _on_skin(after.contact)
        sunk = None if swing is None else swing.sunk(true)
        if wrong := undetected_contact(pad, state, not self.folds, sunk):
            raise ContactError(wrong)
        linear = pad.tangents[0]  # of a state that is off by the drift, or nearer
        place = pad.rows @ state.values[pad.contact] * pad.unit + pad.ends @ true
        free = place - linear.compliance @ true
        films, per_force = self.stresses(state.values, linear)
        film_correction = after.films - films - per_force @ (force - true)
        correction = after.place - (linear.compliance @ force + free)
        drift = Drift(STICKING_FACTOR * np.abs(self._of_ridges(force - true)), np.abs(film_correction))
        skin = Compliance(linear.compliance, pad.gap, free, linear.solved, pad.area)
        now = FrozenTangent(
            skin=skin,
            force=true,
            place=place,
            state=state,
            linear=linear,
            films=films,
            per_force=per_force,
            correction=correction,
            film_correction=film_correction,
            drift=drift,
        )
        return replace(after, tangent=now, distance=0.0, chosen=True)

    def _guess(self, after: FrozenTangentState) -> Array | None:
        """Where the kept tangent says the pad is, while it is the body's latest and there is an energy."""
        pad, tangent = self.pad, after.tangent
        if not (pad.tangents and pad.tangents[0] is tangent.linear and tangent.state.values.any()):
            return None
        # of an equilibrium, all that does not balance is the contact's
        values, body = tangent.state.values, tangent.linear.linear
        at = body.rebalanced(values, -contact_load(pad, tangent.state.contact))
        return np.asarray(values + at.move(contact_load(pad, after.contact)))

    def _of_ridges(self, force: Array) -> Array:
        """The sums of both forces on each ridge `(2, ridges)`."""
        return np.array([np.bincount(self.pad.ridge, part)[1:] for part in force.reshape(2, -1)])


def _on_skin(contact: ContactState) -> Array:
    """The contact's forces on the skin `(2 m,)`, N, in x, then in z."""
    return np.concatenate([contact.tangential, -contact.normal])
