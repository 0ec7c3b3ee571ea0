"""A long pad as a chain of slabs, each condensed alone.

The triangles are cut by x between ridges. With the unknowns that two slabs share (a joint) held, the contact
unknowns of a slab move by its own forces alone; what passes from slab to slab passes through the joints:

    C = F + G T^-1 G^T,

F and G slab by slab, T the joints' stiffness while the contact unknowns are free, block tridiagonal. So
every answer of the flexibility costs one small problem a slab and one elimination from joint to joint.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import ngsolve as ng
import numpy as np
from scipy import sparse
from scipy.linalg import blas, lapack
from scipy.sparse.linalg import spsolve_triangular

from skincad.base.arrays import Array, Index, Mask
from skincad.mechanics.bodies import fe
from skincad.mechanics.bodies.condense import (
    NOT_DEFINITE,
    Front,
    FrontFactors,
    factored,
    fill_order,
    trailing,
)
from skincad.mechanics.bodies.elements import ContactStiffness
from skincad.mechanics.problem import ContactError

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


# A slab with some points held: these points as bytes, root, side, and its contribution to T
SlabFactors = tuple[bytes, Array, Array, Array]


@dataclass(frozen=True)
class Slab:
    """`points` `(c,)` are its contact unknowns, or points, among all, `joints` its joints' unknowns `(s,)`.

    `flexibility` `(c, c)` is its own with the joints held, `follow` `(c, s)` how the points follow the
    joints, `stiffness` `(s, s)` what it adds to T.
    """

    points: Index
    joints: slice
    flexibility: Array
    follow: Array
    stiffness: Array


@dataclass(frozen=True)
class SlabChain:
    """The flexibility `(m, m)` of contact unknowns, or of points that they move: as a matrix, `chain @ force`
    and blocks of one slab's points; and what some points carry while the others are free."""

    slabs: tuple[Slab, ...]
    fronts: list[Front]
    free: FrontFactors
    size: int
    known: dict[int, SlabFactors] = field(default_factory=dict, repr=False)

    def seen(self, rows: sparse.csr_matrix) -> SlabChain:
        """Return the flexibility of points that the contact unknowns move by `rows` `(m, m)`; each point is
        moved by one slab's."""
        slabs, by_unknown = [], rows.tocsc()
        for slab in self.slabs:
            some = by_unknown[:, slab.points]
            points = np.unique(some.indices)
            block = some[points].toarray()
            flexibility = block @ slab.flexibility @ block.T
            slabs.append(
                replace(
                    slab,
                    points=points,
                    flexibility=(flexibility + flexibility.T) / 2,
                    follow=block @ slab.follow,
                )
            )
        return SlabChain(tuple(slabs), self.fronts, self.free, rows.shape[0])

    def __matmul__(self, force: Array) -> Array:
        """Return the movement `(m,)` under forces `(m,)`, or `(m, l)` under `(m, l)`."""
        joints, moved = self.joints_moved(force), np.zeros_like(force)  # a point that none moves stays
        for slab in self.slabs:
            moved[slab.points] = slab.flexibility @ force[slab.points] + slab.follow @ joints[slab.joints]
        return moved

    @property
    def shape(self) -> tuple[int, int]:
        """As a matrix's."""
        return self.size, self.size

    def joints_moved(self, force: Array) -> Array:
        """Return the movement of all joints' unknowns under forces as for `@`."""
        load = np.zeros((self.slabs[-1].joints.stop, *force.shape[1:]))
        for slab in self.slabs:
            load[slab.joints] += slab.follow.T @ force[slab.points]
        return self.free.solve(load)

    def __getitem__(self, where: tuple[Index, ...]) -> Array:
        """Return the block at `np.ix_(points, points)`, points of one slab."""
        points, others = (w.ravel() for w in where)
        number, local = self._places[:, points]
        if (number != number[0]).any() or not np.array_equal(points, others):
            raise IndexError("a chain has only blocks of one slab's points")
        slab, joints = self.slabs[number[0]], self._joints_flexibility[number[0]]
        follow = slab.follow[local]
        return np.asarray(slab.flexibility[np.ix_(local, local)] + follow @ joints @ follow.T)

    @cached_property
    def _places(self) -> Index:
        """Each point's slab and its place there `(2, m)`."""
        places = np.empty((2, self.size), dtype=np.int64)
        for number, slab in enumerate(self.slabs):
            places[:, slab.points] = np.full(slab.points.size, number), np.arange(slab.points.size)
        return places

    @cached_property
    def _joints_flexibility(self) -> list[Array]:
        """The block of T^-1 over each slab's joints, from the last joint to the first.

        Takahashi, Fagan and Chin, Proc. 8th PICA Conf. (1973) 63.
        """
        after = self.free.flexibility
        flexibilities = [after]
        for step in reversed(self.free.steps):
            if step.pivots.size:
                side = blas.dtrsm(1.0, step.root, step.side.T, lower=1, trans_a=1)
                root = blas.dtrsm(1.0, step.root, np.eye(step.pivots.size), lower=1)
                inner, coupling = root.T @ root + side @ after @ side.T, -side @ after
                flexibilities.append(np.block([[inner, coupling], [coupling.T, after]]))
                after = inner
        return [after, *reversed(flexibilities)] if len(self.slabs) > 1 else flexibilities

    def carried(self, inside: Index, sides: Array) -> Array:
        """Return the forces `(k, l)` that move the points `inside` `(k,)` by `sides` `(k, l)`, others free.

        Raises ContactError when the flexibility is not positive definite.
        """
        columns = np.zeros((self.size, sides.shape[1]))
        columns[inside] = sides
        touching = np.zeros(self.size, dtype=bool)
        touching[inside] = True
        fixed = [self._slab_factors(number, touching[slab.points]) for number, slab in enumerate(self.slabs)]
        points = [slab.points[touching[slab.points]] for slab in self.slabs]
        load = np.zeros((self.slabs[-1].joints.stop, sides.shape[1]))
        for slab, at, (_, root, side, _) in zip(self.slabs, points, fixed, strict=True):
            if at.size:
                columns[at] = blas.dtrsm(1.0, root, columns[at], lower=1)
                load[slab.joints] += side.T @ columns[at]
        joints = _joined(self.slabs, self.fronts, [h[-1] for h in fixed]).solve(load)
        for slab, at, (_, root, side, _) in zip(self.slabs, points, fixed, strict=True):
            if at.size:
                rest = columns[at] - side @ joints[slab.joints]
                columns[at] = blas.dtrsm(1.0, root, rest, lower=1, trans_a=1)
        return columns[inside]

    def _slab_factors(self, number: int, touching: Array) -> SlabFactors:
        """A slab with its points `touching` held; remembered until others are asked for."""
        key, slab = touching.tobytes(), self.slabs[number]
        if number not in self.known or self.known[number][0] != key:
            root, failed = lapack.dpotrf(slab.flexibility[np.ix_(touching, touching)], lower=1, clean=0)
            if failed:
                raise ContactError("the contact flexibility is singular; take a coarser contact mesh")
            side = blas.dtrsm(1.0, root, slab.follow[touching], lower=1)
            self.known[number] = key, root, side, slab.stiffness + side.T @ side
        return self.known[number]


@dataclass(frozen=True)
class ChainFactors:
    """A pad condensed to a chain: `flexibility` over the contact unknowns `contact`, and for each slab its
    unknowns' order, contact ones and joints' last, and the factor L of L D L^T.

    L is all that is kept of a slab's factorisation: two fifths of what SuperLU's object would hold.
    """

    flexibility: SlabChain
    contact: Index
    orders: tuple[Index, ...]
    lowers: tuple[sparse.csc_matrix, ...]

    def solve(self, load: Array) -> Array:
        """Return the displacements `(n,)` under a load `(n,)` on contact unknowns, 0 where held."""
        chain, moved, force = self.flexibility, np.zeros_like(load), load[self.contact]
        moved[self.contact], joints = chain @ force, chain.joints_moved(force)
        for slab, order, lower in zip(chain.slabs, self.orders, self.lowers, strict=True):
            # no load inside: what is left to do is L^T u = 0 there, u as known on the last unknowns
            last = np.concatenate([moved[self.contact[slab.points]], joints[slab.joints]])
            side, k = np.zeros(order.size), last.size
            side[-k:] = lower[-k:, -k:].T @ last
            moved[order] = spsolve_triangular(lower.T, side, lower=False, unit_diagonal=True)
        return moved


def condense_by_slabs(system: ContactStiffness) -> ChainFactors:
    """Return a pad condensed slab by slab; ContactError when its stiffness is not positive definite."""
    parts, none = cut(system), np.empty(0, dtype=np.int64)
    ends = np.cumsum([0, *(joint.size for joint in parts.joints)]).tolist()
    befores, afters = [none, *parts.joints], [*parts.joints, none]
    # slab after slab, so that each with its joints is a slice: to pick them from all costs all, slab by slab
    along = np.concatenate(
        [u for slab_parts in zip(parts.interior, parts.contact, afters, strict=True) for u in slab_parts]
    )
    matrix, start = sparse.csr_matrix(system.matrix[along][:, along]), 0
    slabs, orders, lowers = [], [], []
    for i, (interior, contact) in enumerate(zip(parts.interior, parts.contact, strict=True)):
        b, n, c, a = befores[i].size, interior.size, contact.size, afters[i].size
        where = slice(start - b, start + n + c + a)
        block, local = matrix[where, where], np.arange(b + n + c + a)
        order = np.concatenate(
            [fill_order(block, local[b : b + n]), local[b + n : b + n + c], local[:b], local[b + n + c :]]
        )
        factor, pivots, lower = trailing(block, order, c + b + a)
        if not (pivots > 0).all():
            raise ContactError(NOT_DEFINITE)
        orders.append(along[where][order])
        lowers.append(factor.L)
        lower = lower * np.sqrt(pivots[-c - b - a :])
        root = blas.dtrsm(1.0, lower[:c, :c], np.eye(c), lower=1)
        stiffness = lower[c:, c:] @ lower[c:, c:].T
        stiffness[:b, :b] -= block[:b, :b].toarray()  # counted once, by the slab before
        at, follow = np.searchsorted(system.contact, contact), -root.T @ lower[c:, :c].T
        joints = slice(ends[max(i - 1, 0)], ends[min(i + 1, len(parts.joints))])
        slabs.append(Slab(at, joints, root.T @ root, follow, stiffness))
        start += n + c + a
    fronts = _fronts([slab.joints for slab in slabs])
    free = _joined(slabs, fronts, [slab.stiffness for slab in slabs])
    chain = SlabChain(tuple(slabs), fronts, free, system.contact.size)
    return ChainFactors(chain, system.contact, tuple(orders), tuple(lowers))


def _fronts(joints: list[slice]) -> list[Front]:
    """Fronts that eliminate joint after joint but the last, which is the root's border; a front assembles
    slabs in place of triangles."""
    ends = [0, *(j.stop for j in joints[:-1])]
    numbers = [np.arange(a, b) for a, b in pairwise(ends)]
    numbers = [np.arange(0)] * (2 - len(numbers)) + numbers
    fronts = []
    for i, (unknowns, border) in enumerate(pairwise(numbers)):
        stop = i + 2 if i + 2 < len(numbers) else len(joints)
        fronts.append(Front(unknowns, border, (i - 1,) if i else (), np.arange(i + 1 if i else 0, stop)))
    return fronts


def _joined(slabs: Sequence[Slab], fronts: list[Front], blocks: list[Array]) -> FrontFactors:
    """Return the sum of a block `(s, s)` over each slab's joints, factored; ContactError when it is not
    positive definite."""

    def inside(number: int) -> Iterator[tuple[Index, Array]]:
        joints = slabs[number].joints
        yield np.arange(joints.start, joints.stop), blocks[number]

    factors = factored(inside, fronts, lambda joints: joints, slabs[-1].joints.stop)
    if factors.negative_eigenvalues:
        raise ContactError(NOT_DEFINITE)
    return factors
