"""The equations of motion of a pad, split by symmetry, and its states; steps.py advances them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import reduce

import numpy as np
from scipy import sparse

from skincad.base.arrays import Array, Index
from skincad.mechanics.bodies.strip_field import StripBody
from skincad.mechanics.contact.grip import ContactState, Drive, at_rest
from skincad.mechanics.dynamics.time_scheme import Matter

AT_REST = Matter()


@dataclass(frozen=True, eq=False)
class Half:
    """One of the one or two parts of a pad's equations, split by symmetry.

    `points` `(2 m, n)`: displacements of the pad's contact points, in x, then in z, by the unknowns.
    `inner` and `contact` number the free unknowns. `strips` are the stresses of all strips, across, along and
    lengthwise, MPa per mm: of the slow stress, and of what relaxes, `(3 strips, n)` each.
    """

    points: sparse.csr_matrix
    inner: Index
    contact: Index
    strips: tuple[sparse.csr_matrix, sparse.csr_matrix]


@dataclass(frozen=True, eq=False)
class PadEquations:
    """A pad's equations, in mm, N and tonne, over the n unknowns of the part that is meshed.

    `stiff`, `soft` and `mass` `(n, n)`; `share` is the share of a force that the part bears, 1 or, of a
    mirrored pad, 0.5; `gap`, `area` mm2 and `ridge` `(m,)` of the contact points; `body` is what was meshed.
    """

    stiff: sparse.csr_matrix
    soft: sparse.csr_matrix
    mass: sparse.csr_matrix
    halves: tuple[Half, ...]
    share: float
    gap: Array
    area: Array
    ridge: Index
    unknowns: int
    body: StripBody | None = None


@dataclass(frozen=True, eq=False)
class DynamicState:
    """A state: `contact` and, by unknown and half `(n, halves)`, displacement `u`, velocity `v`, acceleration
    `a`, mm and s, `rate`, the velocity of viscous stress, and `elastic_force`, N.

    `memory` has the unrelaxed displacement of each branch. `plate` `(3, 2)` are the plate's approach and
    travel, their velocities and accelerations. `drive` and `matter` are those of the last step; `friction`,
    `viscous` and `work` mJ were dissipated and done in the step.
    """

    contact: ContactState
    u: Array
    v: Array
    a: Array
    rate: Array
    elastic_force: Array
    memory: tuple[Array, ...]
    plate: Array
    drive: Drive
    matter: Matter = AT_REST
    friction: float = 0.0
    viscous: float = 0.0
    work: float = 0.0


def rest_state(pad: PadEquations) -> DynamicState:
    """Return the unloaded start."""
    zero = np.zeros((pad.stiff.shape[0], len(pad.halves)))
    return DynamicState(
        at_rest(pad.gap.size), zero, zero, zero, zero, zero, (), np.zeros((3, 2)), Drive(0.0, 0.0)
    )


def unrelaxed(state: DynamicState) -> Array:
    """The part of the stress that has not relaxed yet, as a displacement `(n, halves)`."""
    return np.asarray(sum_of(state.memory, state.matter.rate * state.rate))


def sum_of(parts: Iterable[Array], start: Array | None = None) -> Array:
    """Return the sum of arrays."""
    return reduce(np.add, parts) if start is None else reduce(np.add, parts, start)
