"""The contact of a whole pad from its half: what a load on one side alone does to either side.

Any load on a pad that is its own mirror image is the sum of one that is its own image and one that the mirror
turns round, and the half bears each on its own: even ones with x held on its cut, odd ones with z held there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from skincad.base.arrays import Array, Index
from skincad.mechanics.bodies import elements
from skincad.mechanics.bodies.condense import condense
from skincad.mechanics.bodies.elements import Assembled
from skincad.mechanics.contact.threshold import Ridges


def on_both_sides(even: Ridges, half: Assembled, ridges: tuple[int, ...]) -> Ridges:
    """Return the contact of a whole pad with these `ridges`, those of its half under even loads at hand.

    `half` is the half's stiffness for loads of either parity, in whose units the whole is too. Points at
    x >= 0 come first, then the images of those off the cut. Costs one condensation of the half.
    """
    turned = odd_flexibility(half)
    rows = half.nodes.rows
    odd = np.asarray(rows @ np.asarray(rows @ turned).T)
    odd_moved = np.asarray((rows @ turned).T)
    off = np.flatnonzero(np.diag(odd) != 0)  # a point on the cut is its own image
    same, other = (even.flexibility + odd) / 2, (even.flexibility - odd) / 2
    here, there = (even.moved + odd_moved) / 2, (even.moved - odd_moved) / 2
    image = dict(zip(ridges, reversed(ridges), strict=True))

    def imaged(numbers: Index) -> Index:
        return np.array([image[r] for r in numbers.tolist()])

    return replace(
        even,
        flexibility=np.block([[same, other[:, off]], [other[off], same[np.ix_(off, off)]]]),
        gap=np.concatenate([even.gap, even.gap[off]]),
        of_point=np.concatenate([even.of_point, imaged(even.of_point[off])]),
        moved=np.block([[here, there[:, off]], [there, here[:, off]]]),
        fine_rows=sparse.csr_matrix(sparse.block_diag([even.fine_rows, even.fine_rows])),
        fine_gap=np.tile(even.fine_gap, 2),
        fine_edge=np.concatenate([even.fine_edge, even.fine_edge + even.fine_edge.max() + 1]),
        fine_of_point=np.concatenate([even.fine_of_point, imaged(even.fine_of_point)]),
    )


def odd_flexibility(half: Assembled) -> Array:
    """Return the flexibility `(k, k)` of a half's contact unknowns under odd loads, 0 on the cut."""
    interior, contact = elements.odd(half)
    free = np.flatnonzero(np.isin(half.contact, contact))
    found = np.zeros((half.contact.size, half.contact.size))
    found[np.ix_(free, free)] = condense(half.matrix, interior, contact).flexibility
    return found
