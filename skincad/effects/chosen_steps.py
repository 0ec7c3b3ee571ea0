"""A pad at finite strain in chosen steps, linear in between (modified Newton); or each step a chosen one.

At a chosen step the equilibrium is found as in mechanics/contact/frictional_pad.py, and the body is
linearised there. In the steps between, the pad is a constant compliance about that state: it knows how far
ridges are pressed, bent and turned, and that a normal force bends them further (P-delta). The next step is
chosen once a touching point has moved by the update interval. The linear pad's error at that step is its
drift. It is corrected gradually over the following interval, so that nothing jumps, and its size is the
error. Drift grows with the square of the interval. Without an interval each step is a chosen one and its
equilibrium the answer; one that does not converge is cut.

Where finite strain has no equilibrium nearby, as where a tip's corner snaps, the skin stays linear about that
state, with the last compliance of which no corner would snap, and the error grows with the square of the
distance moved since. Without an interval it comes to rest elsewhere (mechanics/contact/relaxation.py).
Range: a plate that keeps its angle; quasi-static, but for what slow modes add.
Reference: steps of the plate's travel (tests/mechanics/contact/test_dragged.py), bench/leads.py.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from skincad.base.arrays import Array
from skincad.base.machine import one_blas_thread
from skincad.effects.kinds import FRICTIONLESS, Discretisation, Drift, Observables, Share, Step
from skincad.mechanics.bodies.film_field import StripStress
from skincad.mechanics.contact.folding import fold_of, undetected_contact
from skincad.mechanics.contact.frictional import halved, in_halves, joined, solve_contact
from skincad.mechanics.contact.frictional_pad import (
    ITERATIONS,
    FrictionalPad,
    FrictionalState,
    Tangential,
    contact_load,
    dissipated,
    linearised,
    newton,
    unloaded,
)
from skincad.mechanics.contact.newton import RESIDUAL
from skincad.mechanics.contact.relaxation import relaxed
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
# A stride is SHORT after one that led further off than OFF of the largest force on a ridge, else twice the
# last, up to a whole
SHORT, OFF = 1 / 2, 0.01
MOST_ITERATIONS = 20  # of a chosen step, three to ten are usual; then there is no equilibrium nearby
ACCURACY = 1e-6  # of a chosen step's contact forces; its drift is a thousand times as large
# Intervals over which a change of the films' stresses by the forces serves on. Of yamada-2002-slip at
# friction 0.4 the stress drifts by 2.4 %, with 2 intervals by 6 %
FRESH = 1.0
RETRY_SHARE = 0.9  # of the forces without an equilibrium; below both of them it is searched for again
MAX_HALVINGS = 2  # of a step, where each is a chosen one
SMALLEST_PART = 1 / 2**MAX_HALVINGS  # of a step; in that it comes to rest somewhere


@dataclass(frozen=True, eq=False)
class FrozenTangent:
    """The tangent kept from a chosen step on: the pad as the plate sees it, `skin`; in that step the contact
    points' forces and places `(2 m,)`, N and mm, the state, and the strips' `films` with their change
    `per_force`, found `age` update intervals ago. `correction` `(2 m,)` mm and `film_correction` are added
    over the next `stride`, in update intervals; `steady` is the compliance and the change of stresses of the
    last one of which no corner is about to snap; `drift` is the error of the tangent before, `measured` so
    many intervals from it; `cut` says why no later step could be chosen, at the forces `at`, N. Where the
    last steady compliance has taken over, forces and films are of that step."""

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
    stride: float
    measured: float
    steady: tuple[Array, Array]
    age: float = 0.0
    cut: str = ""
    at: tuple[float, float] = (np.inf, np.inf)

    def worth_retrying(self, forces: tuple[float, float]) -> bool:
        """Return whether an equilibrium is to be looked for, after it was not found under larger forces."""
        normal, pull = forces
        return not self.cut or (normal <= RETRY_SHARE * self.at[0] and pull <= RETRY_SHARE * self.at[1])


@dataclass(frozen=True, eq=False)
class ChosenState:
    """A state: the contact, the points' places `(2 m,)` mm, the strips' stresses, the energy mJ that is
    stored, by what the contact has put in where not each step is a chosen one, and the energy that friction
    dissipated in the step. `distance` is the largest distance that a touching point has moved since the
    chosen step of `tangent`, in update intervals; `chosen` says whether this is such a step."""

    contact: ContactState
    place: Array
    films: Array
    elastic: float
    dissipated: float
    tangent: FrozenTangent
    distance: float = 0.0
    chosen: bool = True


@dataclass(frozen=True, eq=False)
class ChosenPad:
    """A pad at finite strain with its `strips`, None where they are not read, and its `modulus` MPa. Its
    surface may go `through` itself by so many mm; None: it must not fold. `interval` mm is how far a point
    moves between two chosen steps, None where each step is one."""

    pad: FrictionalPad
    strips: StripStress | None
    modulus: float
    through: float | None
    interval: float | None

    @property
    def discretisation(self) -> Discretisation:
        """Its contact points and unknowns."""
        return Discretisation(self.pad.ridge, self.pad.area, self.pad.rest.unknowns)

    @property
    def compliance(self) -> Array:
        """Of the unloaded contact points `(2 m, 2 m)`, mm/N."""
        return self.start().tangent.skin.compliance

    def start(self) -> ChosenState:
        """The unloaded state."""
        with one_blas_thread():
            state = unloaded(self.pad)
            linearised(self.pad, state.values, self.pad.body.residual(state.values))
            tangent = self._tangent(state)
        return ChosenState(state.contact, tangent.place, tangent.films, 0.0, 0.0, tangent)

    def advanced(self, state: ChosenState, step: Step, share: Share) -> ChosenState:
        """Return the state at the step's end, with what masses add. Raises GrossSlip, with the last state,
        and ContactError."""
        if step.after.angle:
            raise ContactError("finite_strain takes a plate that keeps its angle")
        cone = share.cone or FRICTIONLESS
        if self.interval is None:
            with one_blas_thread():
                return self._equilibrium(state, step.before, step.after, cone)
        return self._linear_or_chosen(state, step.before, step.after, cone, share.swing)

    def chosen(self, state: ChosenState, end: Drive, share: Share) -> ChosenState:
        """Return the equilibrium under a drive that a state is at already, chosen now. Raises ContactError
        where it is not sound."""
        if state.chosen:
            return state
        found = self._newton(state, end, share.cone or FRICTIONLESS, self._guess(state))
        self._check(found)
        return replace(state, tangent=self._tangent(found), distance=0.0, chosen=True)

    def fault(self, state: ChosenState) -> str | None:  # noqa: ARG002
        """None: a chosen step that is not sound is not taken, or ends the march where each is one."""
        return None

    def reading(self, before: ChosenState, state: ChosenState) -> Observables:  # noqa: ARG002
        """Return the observables of a state."""
        drift = self.drift(state) if self.interval else None
        fold = fold_of(self.pad, state.tangent.state) if state.chosen and self.through is not None else None
        read = state.contact, state.films, state.elastic, state.dissipated
        return Observables.of(*read, drift=drift, fold=fold)

    def drift(self, state: ChosenState) -> Drift:
        """Return the linear pad's error at a state, of second order in the distance moved at most since.

        Before the first chosen step it is unknown. It is then assumed to be, relative to forces and
        stresses, the distance moved over a crest's width.
        """
        tangent = state.tangent
        missed, cut = tangent.drift, tangent.cut
        grown = max(1.0, (state.distance / tangent.measured) ** 2)
        if not tangent.state.values.any():
            part = UPDATE_INTERVAL * state.distance
            borne = np.abs(self._of_ridges(state.contact.force))
            return Drift(part * borne, part * np.abs(state.films), state.chosen, cut)
        return Drift(missed.forces * grown, missed.films * grown, state.chosen, cut)

    def _equilibrium(
        self, before: ChosenState, start: Drive, end: Drive, cone: FrictionCoefficients
    ) -> ChosenState:
        """The equilibrium at a step's end, in halves where need be; ContactError for one that goes through
        the plate, or too far through itself, or whose surface folds where it must not."""
        try:
            after = in_halves(
                lambda before, start, end, share: self._nearest(before, start, end, cone, share),
                before,
                start,
                end,
                _joined,
                MAX_HALVINGS,
            )
        except GrossSlip as limit:
            self._check(limit.last.tangent.state)
            raise
        self._check(after.tangent.state)
        return after

    def _nearest(
        self, before: ChosenState, start: Drive, end: Drive, cone: FrictionCoefficients, share: float
    ) -> ChosenState:
        """The equilibrium near where the last tangent leads, or else near the state before; at the end of
        the smallest `share` of a step the one that it comes to rest in."""
        try:
            guess = self._guess(self._linear_state(before, start, end, cone))
        except ContactError:
            guess = None
        for place in (None,) if guess is None else (guess, None):
            if place is None:
                self.pad.tangents.clear()
            rests = place is None and share <= SMALLEST_PART
            try:
                return self._at(self._newton(before, end, cone, place, rests=rests))
            except GrossSlip as limit:
                limit.last = self._at(limit.last)
                raise
            except ContactError as refusal:
                failure = refusal
        raise failure

    def _at(self, state: FrictionalState) -> ChosenState:
        """The state at an equilibrium, with what is stored by the body's own energy."""
        tangent = self._tangent(state)
        stored = self.pad.body.energy(state.values) * self.pad.scale * self.pad.unit
        return ChosenState(state.contact, tangent.place, tangent.films, stored, state.dissipated, tangent)

    def _newton(
        self,
        before: ChosenState,
        end: Drive,
        cone: FrictionCoefficients,
        guess: Array | None,
        swing: Swing | None = None,
        *,
        rests: bool = False,
    ) -> FrictionalState:
        """The equilibrium under a drive near `guess`, or where none is and it is wanted the one in which the
        pad `rests`; and the pad's latest tangent near it."""
        start = FrictionalState(before.tangent.state.values, before.contact)
        how = (RESIDUAL, ITERATIONS) if self.interval is None else (ACCURACY, MOST_ITERATIONS)
        try:
            try:
                state = newton(self.pad, start, end, cone, guess, swing, *how)
            except GrossSlip:
                raise
            except ContactError:
                if not rests:
                    raise
                state = relaxed(self.pad, start, end, cone)
        except GrossSlip as limit:
            self._keep_tangent(limit.last)
            raise
        self._keep_tangent(state)
        return state

    def _keep_tangent(self, state: FrictionalState) -> None:
        """Linearise at a state where Newton has kept no tangent, as of a plate that is lifted."""
        if not self.pad.tangents:
            linearised(self.pad, state.values, self.pad.body.residual(state.values))

    def _check(self, state: FrictionalState, sunk: Array | None = None) -> None:
        """Raise ContactError for a state that is not sound; `sunk` as in `undetected_contact`."""
        if wrong := undetected_contact(self.pad, state, self.through is None, sunk, self.through or 0.0):
            raise ContactError(wrong)

    def _linear_or_chosen(
        self,
        before: ChosenState,
        start: Drive,
        end: Drive,
        cone: FrictionCoefficients,
        swing: Swing | None,
    ) -> ChosenState:
        """The state at a step's end by the last tangent, with a new one where a point has moved far enough
        and there is an equilibrium."""
        pull = before.contact.tangential.sum() if end.tangential is None else end.tangential
        after, tangent, forces = None, before.tangent, (end.normal, float(abs(pull)))
        try:
            after = self._linear_state(before, start, end, cone, swing)
            if after.distance < tangent.stride or not tangent.worth_retrying(forces):
                return after
        except GrossSlip:
            raise
        except ContactError:  # about that state there is none under these forces
            if not tangent.worth_retrying(forces):
                return self._linear_state(self._steady(before), start, end, cone, swing)
        guess = self._guess(before if after is None else after)
        self.pad.tangents.clear()  # of the step before, a stride away: the next is to be this step's own
        try:
            state = self._newton(before, end, cone, guess, swing)
            self._check(state, None if swing is None else swing.sunk(state.contact.force))
        except GrossSlip as limit:
            if after is None:
                limit.last = self._at(limit.last)
            else:
                limit.last = replace(after, contact=limit.last.contact)
            raise
        except ContactError as failure:
            if after is None:
                cut = replace(tangent, cut=str(failure), at=forces)
                return self._linear_state(self._steady(replace(before, tangent=cut)), start, end, cone, swing)
            return self._steady(replace(after, tangent=replace(tangent, cut=str(failure), at=forces)))
        # further from where the tangent has led than a stride, a corner has snapped
        if after is None or self._intervals(after, self._place(state)) > after.tangent.stride:
            return self._jumped(before, state, after)
        return replace(after, tangent=self._tangent(state, after), distance=0.0, chosen=True)

    def _intervals(self, state: ChosenState, place: Array) -> float:
        """How far a touching point is at most from places `(2 m,)`, in update intervals."""
        away = np.hypot(*(state.place - place).reshape(2, -1))[state.contact.touches].max(initial=0.0)
        return float(away) / self.interval if self.interval else 0.0

    def _place(self, state: FrictionalState) -> Array:
        """Where the contact points are at an equilibrium `(2 m,)`, mm."""
        pad = self.pad
        return np.asarray(pad.rows @ state.values[pad.contact] * pad.unit + pad.ends @ state.contact.force)

    def _jumped(self, before: ChosenState, state: FrictionalState, after: ChosenState | None) -> ChosenState:
        """The state at an equilibrium that no linear step has led to, or one far off, `after`; the error
        before stays, or what that missed."""
        found, old, drift = self._at(state), before.tangent, self.drift(before)
        if after is not None:
            missed = STICKING_FACTOR * np.abs(self._of_ridges(after.contact.force - state.contact.force))
            off = np.abs(after.films - found.films)
            drift = drift._replace(
                forces=np.maximum(drift.forces, missed), films=np.maximum(drift.films, off)
            )
        work = float((state.contact.force + before.contact.force) @ (found.place - before.place)) / 2
        tangent = replace(
            found.tangent,
            stride=SHORT,
            drift=drift,
            measured=max(before.distance, SHORT),
            steady=found.tangent.steady if _is_steady(found.tangent.linear) else old.steady,
        )
        return replace(found, tangent=tangent, elastic=before.elastic + work)

    def _steady(self, state: ChosenState) -> ChosenState:
        """A state with the compliance of the last tangent of which no corner would snap, for steps in which
        its own has no contact."""
        tangent, force = state.tangent, state.contact.force
        compliance, per_force = tangent.steady
        skin = Compliance(compliance, self.pad.gap, state.place - compliance @ force, {}, self.pad.area)
        steady = replace(
            tangent,
            skin=skin,
            force=force,
            films=state.films,
            per_force=per_force,
            correction=np.zeros_like(state.place),
            film_correction=np.zeros_like(state.films),
        )
        return replace(state, tangent=steady)

    def _linear_state(
        self,
        before: ChosenState,
        start: Drive,
        end: Drive,
        cone: FrictionCoefficients,
        swing: Swing | None = None,
    ) -> ChosenState:
        """The state at a step's end while the tangent stays; a part of the correction is still added."""
        tangent = before.tangent
        share = 1 - min(1.0, before.distance / tangent.stride)
        skin = replace(tangent.skin, free=tangent.skin.free + share * tangent.correction)

        def of(contact: ContactState) -> ChosenState:
            force = contact.force
            place = skin.compliance @ force + skin.free
            films = (
                tangent.films + tangent.per_force @ (force - tangent.force) + share * tangent.film_correction
            )
            stored = before.elastic + float((force + before.contact.force) @ (place - before.place)) / 2
            spent = dissipated(before.contact, contact)
            state = ChosenState(contact, place, films, stored, spent, tangent, chosen=False)
            return replace(state, distance=max(before.distance, self._intervals(state, tangent.place)))

        try:
            if swing:
                return of(solve_contact(skin.swung(swing), before.contact, swing.drive, cone))
            return of(halved(lambda _: skin, before.contact, start, end, cone))
        except GrossSlip as limit:
            limit.last = of(limit.last)
            raise

    def _tangent(self, state: FrictionalState, after: ChosenState | None = None) -> FrozenTangent:
        """The pad's latest tangent, kept from an equilibrium on; `after` is where the one before led, and
        what it missed is corrected from here on."""
        pad, linear = self.pad, self.pad.tangents[0]  # of a state that is off by the drift, or nearer
        force = state.contact.force
        place = self._place(state)
        skin = Compliance(
            linear.compliance, pad.gap, place - linear.compliance @ force, linear.solved, pad.area
        )
        old = None if after is None else after.tangent
        age = FRESH if after is None or after.tangent.cut else after.tangent.age + after.distance
        films, per_force = self._films(state.values, linear, old.per_force if old and age < FRESH else None)
        correction, film_correction = np.zeros_like(place), np.zeros_like(films)
        drift, stride = Drift(np.zeros((2, pad.ridge.max(initial=0))), np.zeros_like(films)), 1.0
        if after is not None:
            led = after.contact.force
            missed = np.abs(self._of_ridges(led - force))
            far = missed.max() > OFF * np.abs(self._of_ridges(force)).max()
            stride = SHORT if far else min(1.0, 2 * after.tangent.stride)
            film_correction = after.films - films - per_force @ (led - force)
            correction = after.place - (linear.compliance @ led + skin.free)
            drift = Drift(STICKING_FACTOR * missed, np.abs(film_correction))
        return FrozenTangent(
            stride=stride,
            steady=(linear.compliance, per_force) if old is None or _is_steady(linear) else old.steady,
            age=age if age < FRESH else 0.0,
            measured=1.0 if after is None else max(after.distance, SHORT),
            skin=skin,
            force=force,
            place=place,
            state=state,
            linear=linear,
            films=films,
            per_force=per_force,
            correction=correction,
            film_correction=film_correction,
            drift=drift,
        )

    def _films(self, values: Array, linear: Tangential, per_force: Array | None) -> tuple[Array, Array]:
        """The strips' stresses `(strips, 3)` MPa at a state, and `per_force` `(strips, 3, 2 m)`, found unless
        it is given."""
        pad, strips = self.pad, self.strips
        if strips is None:
            return np.zeros((0, 3)), np.zeros((0, 3, 2 * pad.gap.size))
        stress = strips.at(values)
        if per_force is not None:
            return stress * self.modulus, per_force
        moved = linear.linear.small.at_contact(strips.gradient(pad.body, linear.values).T)
        per_force = (pad.rows @ moved).T.reshape(*stress.shape, -1) / pad.scale
        return stress * self.modulus, np.asarray(per_force) * self.modulus

    def _guess(self, after: ChosenState) -> Array | None:
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


def _is_steady(linear: Tangential) -> bool:
    """Whether a compliance has no negative eigenvalue, as that of a corner that is about to snap has."""
    return bool(linalg.eigvalsh(linear.compliance + linear.compliance.T, subset_by_index=(0, 0))[0] > 0)


def _joined(first: ChosenState, second: ChosenState) -> ChosenState:
    """The state at the end of two steps as that of one."""
    both = joined(first.contact, second.contact)
    return replace(second, contact=both, dissipated=first.dissipated + second.dissipated)
