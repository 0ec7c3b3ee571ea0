"""What a body is for contact: unknowns, residual and energy at a state, and a linearisation there.

Plane bodies are in bodies/neo_hooke.py, solid ones in bodies/solid_body.py.
"""

from __future__ import annotations

from typing import Protocol

from skincad.base.arrays import Array, Mask
from skincad.mechanics.bodies.elements import ContactStiffness


class LinearisedBody(Protocol):
    """A body linearised at a state, seen by its contact unknowns: their `flexibility` `(k, k)`."""

    @property
    def flexibility(self) -> Array: ...  # noqa: D102

    @property
    def negative_eigenvalues(self) -> tuple[int, int]:
        """How many eigenvalues of the tangent are negative: contact unknowns held, and free."""

    def move(self, push: Array) -> Array:
        """Return the step `(n,)` that balances the body, to first order, under contact forces `-push`."""

    def odd(self) -> LinearisedBody | None:
        """Return the half of a mirrored body linearised for what the mirror turns round, on whose cut nothing
        moves up; None of a whole body. ContactError where that is singular."""


class Elastic(Protocol):
    """An elastic body; a state is the vector of all its unknowns `(n,)`, of which `free` are not held.

    Of `rest` the contact unknowns and the sampled contact boundary are used.
    """

    @property
    def rest(self) -> ContactStiffness: ...  # noqa: D102

    @property
    def free(self) -> Mask: ...  # noqa: D102

    def residual(self, state: Array) -> Array:
        """Return the energy's derivative `(n,)` by all unknowns, held ones included."""

    def energy(self, state: Array) -> float:
        """Return the energy; infinite where a point of the elements is turned inside out."""

    def linearised(self, state: Array, residual: Array) -> LinearisedBody:
        """Return the body at a state whose `residual` is at hand; ContactError where it is singular, or
        not stable though its contact unknowns were held."""

    def x_of_largest_displacement(self, step: Array) -> float:
        """Return x at rest of the place on the boundary that a step `(n,)` moves furthest."""

    def fault(self, state: Array, plate: float) -> str | None:
        """Return what touches without being in contact, under a plate at the height `plate`, or None."""
