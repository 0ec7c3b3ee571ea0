"""A pad at finite strain, each of its steps solved to equilibrium (mechanics/contact/frictional_pad.py)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.base.errors import RefusedError
from skincad.base.machine import one_blas_thread
from skincad.effects.kinds import Observables, Share, Step
from skincad.mechanics.contact.state import ContactState, FrictionCoefficients, GrossSlip
from skincad.mechanics.problem import ContactError

if TYPE_CHECKING:
    from skincad.mechanics.bodies.film_field import StripStress
    from skincad.mechanics.contact.frictional_pad import FrictionalPad, FrictionalState

FRICTIONLESS = FrictionCoefficients(0.0, 0.0)


@dataclass(frozen=True, eq=False)
class LargePad:
    """A pad that is linearised again as it deforms; its states are `FrictionalState`."""

    pad: FrictionalPad
    strips: StripStress | None
    modulus: float  # MPa
    stops: bool  # at a crease

    @property
    def ridge(self) -> Index:
        """Ridge of each contact point `(m,)`."""
        return self.pad.ridge

    @property
    def area(self) -> Array:
        """What each contact point stands for `(m,)`, mm2, undeformed."""
        return self.pad.area

    @property
    def unknowns(self) -> int:
        """Number of free unknowns."""
        return self.pad.rest.unknowns

    def start(self) -> FrictionalState:
        """The unloaded state."""
        from skincad.mechanics.contact.frictional_pad import unloaded

        return unloaded(self.pad)

    def advanced(self, state: FrictionalState, step: Step, shares: Sequence[Share]) -> FrictionalState:
        """Return the converged state at the step's end."""
        from skincad.mechanics.contact.frictional_pad import advance_to

        if any(share.more for share in shares):
            raise RefusedError("finite_strain is quasi-static: it takes no share but friction's")
        cone = next((share.cone for share in shares if share.cone), FRICTIONLESS)
        with one_blas_thread():
            try:
                after = advance_to(self.pad, state, step.before, step.after, cone)
            except GrossSlip as limit:
                self._check(limit.last)
                raise
            self._check(after)
            return after

    def _check(self, state: FrictionalState) -> None:
        """Raise ContactError for a state that goes through itself or the plate, or whose surface folds."""
        from skincad.mechanics.contact.press_path import undetected_contact

        wrong = undetected_contact(self.pad, state, self.stops)
        if wrong is not None:
            raise ContactError(wrong)

    def grip(self, state: FrictionalState) -> ContactState:
        """Return the contact of a state."""
        return state.contact

    def fault(self, state: FrictionalState) -> str | None:  # noqa: ARG002
        """None: a step costs so much that each is looked at."""
        return None

    def reading(self, before: FrictionalState, state: FrictionalState) -> Observables:  # noqa: ARG002
        """Return the observables of a state."""
        films = np.zeros((0, 3)) if self.strips is None else self.strips.at(state.values) * self.modulus
        elastic = self.pad.body.energy(state.values) * self.pad.scale * self.pad.unit
        return Observables.of(state.contact, films, elastic, state.dissipated)
