"""A pad with the masses of its slow modes, and of a plate where that has one.

The pad itself has no mass: it is one in small strain, or at finite strain in chosen steps. What its slow
modes add (mechanics/dynamics/modes.py) stands beside its compliance, so that a step is a contact problem of
the same size as without masses; the plate's mass is taken as in mechanics/dynamics/steps.py. Range: the modes
are those of the unloaded pad in small strain, under a plate that keeps its angle.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.effects.kinds import Discretisation, MarchedPad, Observables, Share, Step
from skincad.effects.small_strain import CondensedPad
from skincad.mechanics.contact.state import Drive, GrossSlip, Swing
from skincad.mechanics.dynamics.modes import Modes, ModeStep, mode_step
from skincad.mechanics.dynamics.steps import (
    Matter,
    PlateMotion,
    in_parts,
    plate_inertia,
    plate_kinetic,
    remembered,
    scheme,
    state_after,
)
from skincad.mechanics.film.fields import DeformedSection

DAMPED = 0.8  # of the plate's fastest swings, what a step keeps; as effects.inertia does


@dataclass(frozen=True, eq=False, kw_only=True)
class ModalState(PlateMotion):
    """A state: that of the pad without masses, `still`; place and speed of each mode, `swings` `(r, 2)`."""

    still: Any
    swings: Array


@dataclass(frozen=True, eq=False)
class ModalPad:
    """A pad without masses, `still`, its `modes`, and a plate of `mass` g, 0 without; `prepared` remembers
    the equations of steps by their length."""

    still: MarchedPad
    modes: Modes
    mass: float = 0.0
    prepared: dict[float, ModeStep] = field(default_factory=dict)

    @property
    def discretisation(self) -> Discretisation:
        """That of the pad without masses."""
        return self.still.discretisation

    def start(self) -> ModalState:
        """The unloaded state, at rest."""
        still = self.still.start()
        return ModalState(
            contact=still.contact,
            plate=np.zeros((3, 2)),
            drive=Drive(0.0, 0.0),
            matter=Matter(DAMPED, self.mass),
            still=still,
            swings=np.zeros((self.modes.frequency.size, 2)),
        )

    def advanced(self, state: ModalState, step: Step, share: Share) -> ModalState:
        """Return the converged state at the step's end."""

        def advance(before: ModalState, end: Drive, dt: float) -> ModalState:
            return self._one(before, replace(step, before=before.drive, after=end), dt, share)

        return in_parts(advance, replace(state, drive=step.before), step.after, step.end - step.start)

    def _one(self, state: ModalState, step: Step, dt: float, share: Share) -> ModalState:
        modes = remembered(self.prepared, dt, partial(mode_step, self.modes, dt))
        points, drive, of_plate = self.modes.points, step.after, scheme(dt, state.matter.damped)
        free = np.einsum("kij,kj->ki", modes.stays, state.swings)
        free += modes.start * (points.T @ state.contact.force)[:, None]
        pushing = plate_inertia(state, drive, of_plate)
        swing = Swing(modes.compliance, points @ free[:, 0], pushing, np.float64(dt).tobytes())

        def after(still: Any) -> ModalState:
            contact = still.contact
            swings = free + modes.end * (points.T @ contact.force)[:, None]
            slow, fast = state.swings[:, 1], swings[:, 1]
            viscous = float(self.modes.damping @ (slow**2 + slow * fast + fast**2)) * dt / 3
            fields = {"still": still, "swings": swings, "viscous": viscous}
            return state_after(state, drive, contact, of_plate, pushing, **fields)

        try:
            return after(self.still.advanced(state.still, step, replace(share, swing=swing)))
        except GrossSlip as limit:
            raise GrossSlip(after(limit.last), str(limit)) from None

    def _off(self, state: ModalState) -> Array:
        """How far modes are from where the contact's forces would hold them `(r,)`."""
        held = self.modes.points.T @ state.contact.force / self.modes.frequency**2
        return np.asarray(state.swings[:, 0] - held)

    def fault(self, state: ModalState) -> str | None:
        """Return what of the skin would collide unseen in a state, or None. It is known on the mesh of the
        modes alone: on a finer one nothing is looked for, as that mesh is marched first."""
        if not isinstance(self.still, CondensedPad):
            return self.still.fault(state.still)
        if not self.modes.shapes:
            return None
        off = self._off(state)
        return self.still.fault(state.still, [shape @ off[of] for of, shape in self.modes.shapes])

    def shown(self, state: ModalState) -> DeformedSection:
        """Return the whole section under the contact's forces; what masses add to it is not drawn."""
        assert isinstance(self.still, CondensedPad)
        return self.still.shown(state.still)

    def reading(self, before: ModalState, state: ModalState) -> Observables:
        """Return the observables of a state."""
        still, modes = self.still.reading(before.still, state.still), self.modes
        place, speed = state.swings.T
        off = self._off(state)
        held = place - off
        return replace(
            still,
            films=still.films + modes.strips @ off,
            elastic=still.elastic + float(modes.frequency**2 @ (place**2 - held**2)) / 2,
            dissipated=state.friction,
            kinetic=float(speed @ speed) / 2 + plate_kinetic(state),
            viscous=state.viscous,
            work=state.work,
        )
