"""A pad's unknowns cut by x into slabs of a few ridges, and the joints that neighbours share."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import ngsolve as ng
import numpy as np

from skincad.base.arrays import Index, Mask
from skincad.mechanics.bodies import fe
from skincad.mechanics.bodies.elements import ContactStiffness

# Of a slab, about. Of 3 to 12 on 51 ridges, 5 to 7 carry cheapest, and condensing costs the same to 10 %
RIDGES = 5


@dataclass(frozen=True)
class Slabs:
    """The free unknowns of n slabs: `interior` and `contact` of each, and `joints` of each with the next.

    Slabs are coupled by their joints only, a joint with the one after it by the slab between.
    """

    interior: list[Index]
    contact: list[Index]
    joints: list[Index]


def cut(system: ContactStiffness) -> Slabs:
    """Return the slabs, cut midway between ridges where no contact unknown is shared and each triangle's
    unknowns are those of two slabs at most."""
    places, ridge = system.nodes.position[:, 0], system.nodes.ridge
    groups = np.array_split(np.unique(ridge), max(1, round(np.unique(ridge).size / RIDGES)))
    ends = [places[ridge == a[-1]].max() + places[ridge == b[0]].min() for a, b in pairwise(groups)]
    cuts = np.array(ends) / 2
    space, vertices = system.space.components[0], np.asarray(system.mesh.ngmesh.Coordinates())
    scalar = _functions(system.mesh, space.components[0])
    centres = vertices[scalar[scalar < len(vertices)].reshape(-1, 3), 0].mean(axis=1)
    contact = np.zeros(system.lift.size, dtype=bool)
    contact[system.contact] = True
    while True:
        first, last = _between(scalar, space.Range(1).start, np.searchsorted(cuts, centres), contact.size)
        wrong = (contact & (first < last)) | (last - first > 1)
        if not wrong.any():
            break
        cuts = np.delete(cuts, np.unique(first[wrong]))
    free = np.zeros_like(contact)
    free[system.interior] = True
    inside, count = first == last, cuts.size + 1
    return Slabs(
        _sorted(free & inside, first, count),
        _sorted(contact, first, count),
        _sorted(free & ~inside, first, count - 1),
    )


def _sorted(which: Mask, slab: Index, count: int) -> list[Index]:
    """The unknowns `which` `(n,)` by their slab, ascending in each."""
    indices = np.flatnonzero(which)
    indices = indices[np.argsort(slab[indices], kind="stable")]
    return np.split(indices, np.searchsorted(slab[indices], np.arange(1, count)))[:count]


def _functions(mesh: Any, scalar: Any) -> Index:
    """Return the numbers of a scalar space's functions on each triangle `(t, f)`.

    They are the pattern of a matrix that couples them to one number a triangle: ten times faster than to ask
    triangle after triangle.
    """
    one = ng.L2(mesh, order=0)
    pattern = fe.assembled(scalar.TrialFunction() * one.TestFunction() * ng.dx, scalar, one)
    return np.asarray(pattern.indices.reshape(mesh.ne, -1), dtype=np.int64)


def _between(scalar: Index, second: int, slab: Index, size: int) -> tuple[Index, Index]:
    """First and last slab `(size,)` of each unknown."""
    first, last = np.full(size, slab.max()), np.zeros(size, dtype=np.int64)
    for unknowns in (scalar, scalar + second):
        for column in unknowns.T:
            np.minimum.at(first, column, slab)
            np.maximum.at(last, column, slab)
    return first, last
