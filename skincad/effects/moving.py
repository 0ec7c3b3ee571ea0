"""A pad in small strain with what terms ask beyond it: masses, and history-dependent stress."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from skincad.effects.kinds import FRICTIONLESS, Discretisation, Observables, Share, Step
from skincad.mechanics.dynamics.steps import DynamicState, Matter, PadEquations

if TYPE_CHECKING:
    from skincad.mechanics.bodies.mesh import PadPiece


def matter_of(step: Step, share: Share) -> Matter:
    """Return the masses and the viscosity of a step."""
    return Matter(share.damped, 0.0 if share.damped is None else step.mass, share.rate, share.relaxing)


@dataclass(frozen=True, eq=False)
class MovingPad:
    """A pad with masses or a past."""

    pad: PadEquations
    piece: PadPiece | None = None

    @property
    def discretisation(self) -> Discretisation:
        """Its contact points and unknowns."""
        return Discretisation(self.pad.ridge, self.pad.area, self.pad.unknowns)

    def start(self) -> DynamicState:
        """The unloaded state, at rest."""
        return self.pad.start()

    def advanced(self, state: DynamicState, step: Step, share: Share) -> DynamicState:
        """Return the converged state at the step's end."""
        start, length = replace(state, drive=step.before), step.end - step.start
        return self.pad.step(start, step.after, length, share.cone or FRICTIONLESS, matter_of(step, share))

    def fault(self, state: DynamicState) -> str | None:
        """Return what of the skin would collide unseen in a state, or None; of a pad without a mesh nothing
        is known to."""
        body = self.pad.body
        if self.piece is None or body is None:
            return None
        from skincad.mechanics.film.fields import collision, on_sides

        moved = np.zeros((body.system.lift.size, state.u.shape[1]))
        moved[: len(state.u)] = state.u / self.piece.unit
        plate = self.piece.whole.top - state.contact.approach
        return collision(self.piece, body, on_sides(list(moved.T)), plate, 0.0)

    def reading(self, before: DynamicState, state: DynamicState) -> Observables:  # noqa: ARG002
        """Return the observables of a state."""
        return Observables.of(
            state.contact,
            self.pad.stresses(state),
            self.pad.elastic(state),
            state.friction,
            kinetic=self.pad.kinetic(state),
            viscous=state.viscous,
            work=state.work,
        )
