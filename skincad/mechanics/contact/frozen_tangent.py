"""A pad that keeps the tangent of a chosen step: linear about it, with what it missed made up for later.

At a chosen step the equilibrium is found as frictional_pad.py does, and the body linearised there. In the
steps between, the pad is a constant compliance, as in small strain, but about the state that it is in: it
knows how far ridges are pressed, bent and turned, and that a normal force bends them further (P-delta). What
the linear pad has missed by the next chosen step, its drift, is made up for over the stride that follows, so
that nothing jumps; its size is the error. Drift grows with the square of a stride. A step is chosen once a
point that touches has moved by a stride since the last one.

Where no equilibrium is found at finite strain, as where the surface folds (press_path.py), the tangent held
last is held on, and the error grows with the square of what has moved since. Range: quasi-static, a plate
that keeps its angle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.bodies.plane_body import under
from skincad.mechanics.contact.frictional import halved
from skincad.mechanics.contact.frictional_pad import (
    FrictionalPad,
    FrictionalState,
    Tangential,
    dissipated,
    linearised,
    moved,
    newton,
    pushed,
    unloaded,
)
from skincad.mechanics.contact.press_path import fault
from skincad.mechanics.contact.state import Compliance, ContactState, Drive, FrictionCoefficients, GrossSlip
from skincad.mechanics.problem import ContactError

# Of a crest's width. Measured on yamada-2002-slip at friction 0.5: the largest stress within 1.5 % of finite
# strain in each of 110 steps, by 14 chosen ones; 0.4 % by 33 at 1 / 30
STRIDE = 1 / 12
# What earlier chosen steps missed stays in points that stick: a ridge's forces are off by up to 1.6 times
# what the last one missed (in 95 % of 40 slips: the first 8 scenes of bench/table_leads.py's seed 1, and
# yamada-2002-slip at friction 0.4)
STAYS = 2.0
AGAIN = 0.9  # of the forces at which no equilibrium was found; below both of them it is looked for again

Stresses = Callable[
    [Array, Tangential], tuple[Array, Array]
]  # the strips' `(3 strips,)`, and per N `(.., 2 m)`


class Drift(NamedTuple):
    """What a linear pad has missed: of each ridge's `forces` `(2, ridges)` N, along x and z, and of the
    strips' stresses `(strips, 3)`, MPa; whether the step is a `chosen` one, and why no later one could be,
    or ''."""

    forces: Array
    films: Array
    chosen: bool = False
    cut: str = ""


@dataclass(frozen=True, eq=False)
class FrozenTangent:
    """The tangent held from a chosen step on: the pad as the plate sees it, `skin`; in that step the contact
    points' forces and places `(2 m,)`, N and mm, the state, and the strips' `films` with what they change by
    `per_force`. `late` `(2 m,)` mm and `films_late` are what is made up for; `drift` what was missed before;
    `cut` why no later step could be chosen, at the forces `at`, N."""

    skin: Compliance
    force: Array
    place: Array
    state: FrictionalState
    linear: Tangential
    films: Array
    per_force: Array
    late: Array
    films_late: Array
    drift: Drift
    cut: str = ""
    at: tuple[float, float] = (np.inf, np.inf)


@dataclass(frozen=True, eq=False)
class FrozenTangentState:
    """A state: the contact, the points' places `(2 m,)` mm, the strips' stresses, the energy mJ that the
    contact has put in, and what friction dissipated in the step; `gone` in strides, how far a point that
    touches has moved since the chosen step of `held`, at most so far; `chosen` whether this is one."""

    grip: ContactState
    place: Array
    films: Array
    elastic: float
    dissipated: float
    held: FrozenTangent
    gone: float = 0.0
    chosen: bool = True


@dataclass(frozen=True, eq=False)
class FrozenTangentPad:
    """A pad with its strips' stresses; a stride is so many mm, `folds` whether it may fold."""

    pad: FrictionalPad
    stresses: Stresses
    stride: float
    folds: bool

    def start(self) -> FrozenTangentState:
        """Return the unloaded pad, its tangent held."""
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
            late=zero,
            films_late=np.zeros_like(films),
            drift=drift,
        )
        return FrozenTangentState(state.grip, zero, films, 0.0, 0.0, tangent)

    def advanced(
        self, before: FrozenTangentState, start: Drive, end: Drive, cone: FrictionCoefficients
    ) -> FrozenTangentState:
        """Return the state at a step's end. Raises GrossSlip, with the last state, and ContactError."""
        if end.angle:
            raise ContactError("finite_strain takes a plate that keeps its angle")
        tangent, late = before.held, 1 - min(1.0, before.gone)
        skin = replace(tangent.skin, free=tangent.skin.free + late * tangent.late)
        try:
            after = self._seen(before, halved(lambda _: skin, before.grip, start, end, cone), skin, late)
        except GrossSlip as limit:
            limit.last = self._seen(before, limit.last, skin, late)
            raise
        forces = end.normal, abs(float(after.grip.tangential.sum()))
        if after.gone < 1.0 or not self._worth(tangent, forces):
            return after
        try:
            return self._chosen(before, after, end, cone)
        except GrossSlip:
            raise
        except ContactError as failure:
            return replace(after, held=replace(tangent, cut=str(failure), at=forces))

    def drift(self, state: FrozenTangentState) -> Drift:
        """Return what the linear pad has missed by a state, as of the second order in the stride.

        Before the first chosen step nothing is known of it: assumed is as much as points have moved, by a
        crest's width.
        """
        missed, cut, grown = state.held.drift, state.held.cut, max(1.0, state.gone**2)
        if not state.held.state.values.any():
            part = STRIDE * state.gone
            borne = np.abs(self._of_ridges(_on_skin(state.grip)))
            return Drift(part * borne, part * np.abs(state.films), state.chosen, cut)
        return Drift(missed.forces * grown, missed.films * grown, state.chosen, cut)

    @staticmethod
    def _worth(tangent: FrozenTangent, forces: tuple[float, float]) -> bool:
        """Whether an equilibrium is to be looked for, after it was not found under larger forces."""
        normal, pull = forces
        return not tangent.cut or (normal < AGAIN * tangent.at[0] and pull < AGAIN * tangent.at[1])

    def _seen(
        self, before: FrozenTangentState, contact: ContactState, skin: Compliance, late: float
    ) -> FrozenTangentState:
        """The state that a contact leads to while the tangent is held."""
        tangent, force = before.held, _on_skin(contact)
        place = skin.compliance @ force + skin.free
        films = tangent.films + tangent.per_force @ (force - tangent.force) + late * tangent.films_late
        stored = before.elastic + float((force + _on_skin(before.grip)) @ (place - before.place)) / 2
        far = (
            np.hypot(*(place - tangent.place).reshape(2, -1))[contact.touches].max(initial=0.0) / self.stride
        )
        distance, spent = max(before.gone, float(far)), dissipated(before.grip, contact)
        return FrozenTangentState(
            grip=contact,
            place=place,
            films=films,
            elastic=stored,
            dissipated=spent,
            held=tangent,
            gone=distance,
            chosen=False,
        )

    def _chosen(
        self, before: FrozenTangentState, after: FrozenTangentState, end: Drive, cone: FrictionCoefficients
    ) -> FrozenTangentState:
        """The same state, the tangent of the equilibrium under this drive held from here on."""
        pad, tangent = self.pad, after.held
        start = FrictionalState(tangent.state.values, before.grip, np.zeros_like(tangent.state.values))
        guess = self._guess(after)
        pad.kept.clear()
        try:
            state = newton(pad, start, end, cone, guess)
        except GrossSlip as limit:
            limit.last = replace(after, grip=limit.last.grip)
            raise
        if wrong := fault(pad, state, not self.folds):
            raise ContactError(wrong)
        linear = pad.kept[0]  # of a state that is off by the drift, or nearer
        true, force = _on_skin(state.grip), _on_skin(after.grip)
        place = pad.rows @ state.values[pad.contact] * pad.unit
        free = place - linear.compliance @ true
        films, per_force = self.stresses(state.values, linear)
        films_late = after.films - films - per_force @ (force - true)
        late = after.place - (linear.compliance @ force + free)
        drift = Drift(STAYS * np.abs(self._of_ridges(force - true)), np.abs(films_late))
        skin = Compliance(linear.compliance, pad.gap, free, linear.solved, pad.area)
        now = FrozenTangent(
            skin=skin,
            force=true,
            place=place,
            state=state,
            linear=linear,
            films=films,
            per_force=per_force,
            late=late,
            films_late=films_late,
            drift=drift,
        )
        return replace(after, held=now, gone=0.0, chosen=True)

    def _guess(self, after: FrozenTangentState) -> Array | None:
        """Where the held tangent says the pad is, while it is the body's latest and there is an energy."""
        pad, tangent = self.pad, after.held
        if not (pad.kept and pad.kept[0] is tangent.linear and tangent.state.values.any()):
            return None
        # of an equilibrium, all that does not balance is the contact's
        at = under(pad.body, tangent.linear.matrix, -pushed(pad, tangent.state.grip))
        return tangent.state.values + moved(tangent.linear, at, pushed(pad, after.grip))

    def _of_ridges(self, force: Array) -> Array:
        """The sums of both forces on each ridge `(2, ridges)`."""
        return np.array([np.bincount(self.pad.ridge, part)[1:] for part in force.reshape(2, -1)])


def _on_skin(contact: ContactState) -> Array:
    """The contact's forces on the skin `(2 m,)`, N, in x, then in z."""
    return np.concatenate([contact.tangential, -contact.normal])
