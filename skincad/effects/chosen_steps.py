"""Finite strain in chosen steps, the pad linear about them in between (mechanics/contact/frozen_tangent.py).

For what small strain misses, P-delta above all, at a small part of the price of finite strain in each step;
and on through a pull in which finite strain itself has no smooth surface, with an error that says how far.
Reference: finite strain in each step (tests/effects/test_chosen_steps.py, bench/leads.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.base.errors import RefusedError
from skincad.base.machine import one_blas_thread
from skincad.effects.kinds import Observables, Share, Step, swing_of
from skincad.effects.large_pad import FRICTIONLESS, LargePad
from skincad.mechanics.contact.frictional_pad import FrictionalPad, Tangential
from skincad.mechanics.contact.frozen_tangent import UPDATE_INTERVAL, FrozenTangentPad, FrozenTangentState
from skincad.mechanics.contact.state import ContactState


def chosen(large: LargePad) -> ChosenPad:
    """Return the pad that takes chosen steps of a `large` one, a stride of its narrowest crest apart."""
    pad = large.pad
    crests = [np.ptp(pad.x[pad.ridge == number]) for number in np.unique(pad.ridge)]
    interval = UPDATE_INTERVAL * float(min(crests))
    return ChosenPad(FrozenTangentPad(pad, _Stresses(large), interval, not large.stops))


@dataclass(frozen=True, eq=False)
class _Stresses:
    """The strips' stresses at a state, and per contact force where a tangent is known."""

    large: LargePad

    def __call__(self, values: Array, linear: Tangential) -> tuple[Array, Array]:
        pad, strips, modulus = self.large.pad, self.large.strips, self.large.modulus
        if strips is None:
            return np.zeros((0, 3)), np.zeros((0, 3, 2 * pad.gap.size))
        stress = strips.at(values)
        moved = linear.linear.small.at_contact(strips.gradient(pad.body, linear.values).T)
        per_force = (pad.rows @ moved).T.reshape(*stress.shape, -1) / pad.scale
        return stress * modulus, np.asarray(per_force) * modulus


@dataclass(frozen=True, eq=False)
class ChosenPad:
    """A pad at finite strain in chosen steps; its states are `FrozenTangentState`."""

    held: FrozenTangentPad

    @property
    def _pad(self) -> FrictionalPad:
        return self.held.pad

    @property
    def ridge(self) -> Index:
        """Ridge of each contact point `(m,)`."""
        return self._pad.ridge

    @property
    def area(self) -> Array:
        """What each contact point stands for `(m,)`, mm2, undeformed."""
        return self._pad.area

    @property
    def unknowns(self) -> int:
        """Number of free unknowns."""
        return self._pad.rest.unknowns

    @property
    def x(self) -> Array:
        """Where the contact points are `(m,)`, mm, undeformed."""
        return self._pad.x

    @property
    def compliance(self) -> Array:
        """Of the unloaded contact points `(2 m, 2 m)`, mm/N."""
        return self.start().tangent.skin.compliance

    def start(self) -> FrozenTangentState:
        """The unloaded state."""
        with one_blas_thread():
            return self.held.start()

    def advanced(self, state: FrozenTangentState, step: Step, shares: Sequence[Share]) -> FrozenTangentState:
        """Return the state at the step's end."""
        if any(share.more for share in shares):
            raise RefusedError("finite_strain is quasi-static: it takes no share but friction's")
        cone = next((share.cone for share in shares if share.cone), FRICTIONLESS)
        return self.held.advanced(state, step.before, step.after, cone, swing_of(shares))

    def grip(self, state: FrozenTangentState) -> ContactState:
        """Return the contact of a state."""
        return state.contact

    def fault(self, state: FrozenTangentState) -> str | None:  # noqa: ARG002
        """None: chosen steps are looked at, and one that is not sound is not chosen."""
        return None

    def reading(self, before: FrozenTangentState, state: FrozenTangentState) -> Observables:  # noqa: ARG002
        """Return the observables of a state."""
        return Observables.of(
            state.contact, state.films, state.elastic, state.dissipated, drift=self.held.drift(state)
        )
