"""The contact of a whole pad from its half: what a load on one side alone does to either side.

Any load on a pad that is its own mirror image is the sum of one that is its own image and one that the mirror
turns round, and the half bears each on its own: even ones with x held on its cut, odd ones with z held there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.mechanics.bodies import elements
from skincad.mechanics.bodies.chain import chained
from skincad.mechanics.bodies.elements import ContactStiffness
from skincad.mechanics.contact.frictionless import Flexibility
from skincad.mechanics.contact.threshold import Ridges

ROUNDING = 1e-12  # of a function's value; what does not vanish on the cut is held there


@dataclass(frozen=True)
class BothSides:
    """The flexibility of a whole pad's contact points: `m` at x >= 0 first, then the images of those `off`
    `(k,)` the cut. As a matrix, `sides @ force` and the blocks of a ridge's points.

    `even` and `odd` are that of the half's points under loads of either parity; of `odd` those on the cut,
    which do not move, have none.
    """

    even: Flexibility
    odd: Flexibility
    off: Index

    @property
    def shape(self) -> tuple[int, int]:
        """As a matrix's."""
        size = self.even.shape[0] + self.off.size
        return size, size

    def __matmul__(self, force: Array) -> Array:
        """Return the movement under forces, both `(m + k,)` or `(m + k, l)`."""
        m = self.even.shape[0]
        here, image = force[:m], np.zeros_like(force[:m])
        image[self.off] = force[m:]
        even, odd = self.even @ ((here + image) / 2), self.odd @ ((here - image) / 2)
        return np.concatenate([even + odd, (even - odd)[self.off]])

    def __getitem__(self, where: tuple[Index, ...]) -> Array:
        """Return the block at `np.ix_(points, points)`, points of one ridge."""
        points, m = where[0].ravel(), self.even.shape[0]
        number = np.concatenate([np.arange(m), self.off])[points]
        side = np.where(points < m, 1.0, -1.0)
        here, local = np.unique(number, return_inverse=True)
        at, there = np.ix_(local, local), np.flatnonzero(np.isin(here, self.off))
        even, odd = self.even[np.ix_(here, here)], np.zeros((here.size, here.size))
        odd[np.ix_(there, there)] = self.odd[np.ix_(here[there], here[there])]
        return np.asarray((even[at] + np.outer(side, side) * odd[at]) / 2)


@dataclass(frozen=True)
class MirroredRidges:
    """A whole pad's contact points `(m + k,)` seen from its half: their flexibility, gaps and ridges."""

    flexibility: BothSides
    gap: Array
    of_point: Index


def on_both_sides(even: Ridges, half: ContactStiffness, ridges: tuple[int, ...]) -> MirroredRidges:
    """Return the contact of a whole pad with these `ridges`, those of its half under even loads at hand.

    `half` is the half's stiffness for loads of either parity, in whose units the whole is too. Costs one
    condensation of the half.
    """
    interior, contact = elements.odd(half)
    odd = chained(replace(half, interior=interior, contact=contact)).flexibility
    moving = half.nodes.rows[:, np.flatnonzero(np.isin(half.contact, contact))]
    moving.data[np.abs(moving.data) < ROUNDING] = 0.0
    moving.eliminate_zeros()
    off = np.flatnonzero(moving.getnnz(axis=1))  # a point on the cut is its own image
    image = dict(zip(ridges, reversed(ridges), strict=True))
    return MirroredRidges(
        BothSides(even.flexibility, odd.seen(moving), off),
        np.concatenate([even.gap, even.gap[off]]),
        np.concatenate([even.of_point, [image[r] for r in even.of_point[off].tolist()]]),
    )
