"""Condensation of a stiffness onto its contact unknowns, by one factorisation of the whole or front by front.

Nested dissection on the section's triangles: the Schur complement of a solid extruded from them. All unknowns
above one point of the section are eliminated together, so the fronts are dense and large: ten times faster
than a general sparse factorisation, of which nothing but the last block is wanted. Where the other unknowns
are wanted too, the fronts are kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import linalg, sparse
from scipy.linalg import blas, lapack
from scipy.sparse.linalg import spilu, splu

from skincad.base.arrays import Array, Index
from skincad.mechanics.problem import ContactError

MOST_CONTACT_UNKNOWNS = 6000  # dense blocks of 0.3 GB each


@dataclass(frozen=True)
class Condensation:
    """One factorisation: `flexibility` `(k, k)` is the inverse's block over the contact unknowns.

    `order` lists the unknowns as they were factorised, contact unknowns last. `pivots` `(n,)` in that order
    have as many negative ones as the matrix negative eigenvalues (Sylvester), the first of them likewise
    while the contact unknowns are held.
    """

    flexibility: Array
    order: Index
    factor: Any
    pivots: Array

    def solve(self, load: Array) -> Array:
        """Return the displacements `(n,)` under a load `(n,)` over all unknowns, 0 where held."""
        moved = np.zeros_like(load)
        moved[self.order] = self.factor.solve(load[self.order])
        return moved

    def at_contact(self, load: Array) -> Array:
        """Return `solve` of a load `(n,)` or loads `(n, loads)` at the contact unknowns alone `(k, ...)`."""
        return np.asarray(self.factor.solve(load[self.order])[-len(self.flexibility) :])


def fill_order(matrix: sparse.csr_matrix, interior: Index) -> Index:
    """Return `interior` in an order with little fill: minimum degree on the pattern.

    SuperLU orders before it factorises, so an incomplete factorisation that drops everything gives the
    order at a tenth of the price. Its values are replaced: only the pattern counts.
    """
    pattern = sparse.csc_matrix(matrix[interior][:, interior])
    pattern.data = np.full_like(pattern.data, 1 / pattern.shape[0])
    pattern = sparse.csc_matrix(pattern + sparse.identity(pattern.shape[0], format="csc"))
    dropped = spilu(
        pattern,
        permc_spec="MMD_AT_PLUS_A",
        drop_tol=1e30,
        fill_factor=1,
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return np.asarray(interior[np.argsort(dropped.perm_c)], dtype=np.int64)


def condense(matrix: sparse.csr_matrix, interior: Index, contact: Index) -> Condensation:
    """Return the flexibility of the contact unknowns of a symmetric positive definite matrix.

    With the k contact unknowns last, the factors' trailing blocks multiply to the Schur complement
    (interior eliminated), whose inverse is the wanted block of the whole inverse: one factorisation
    instead of k solves. Golub and Van Loan, Matrix Computations, 4th ed., sec. 3.2.
    """
    factorisation = factorise(matrix, np.concatenate([fill_order(matrix, interior), contact]), contact.size)
    if not (factorisation.pivots > 0).all():
        raise ContactError(NOT_DEFINITE)
    return factorisation


def factors(block: sparse.csc_matrix) -> Any:
    """Return SuperLU's factors in the order given, as far as it can be kept; ContactError for a singular
    matrix."""
    try:
        return splu(block, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as failure:
        if "singular" not in str(failure):
            raise
        raise ContactError("the stiffness is singular") from None


def factorise(matrix: sparse.csr_matrix, order: Index, k: int) -> Condensation:
    """Return `condense` for a given order, whose last `k` are the contact unknowns, definite or not.

    Over a Newton run the pattern stays, and with it the order from `fill_order`.
    """
    factor = factors(sparse.csc_matrix(matrix[order][:, order]))
    natural = np.arange(order.size)
    if not (np.array_equal(factor.perm_r, natural) and np.array_equal(factor.perm_c, natural)):
        raise ContactError("the factorisation left the given order; the stiffness is not positive definite")
    # symmetric without pivoting: what is left of the last k is L D L^T with D the diagonal of U
    pivots, lower = factor.U.diagonal(), factor.L[-k:, -k:].toarray(order="F")
    last = pivots[-k:]
    if (last > 0).all():
        lower, failed = linalg.lapack.dpotri(lower * np.sqrt(last), lower=True, overwrite_c=True)
        flexibility = np.tril(lower) + np.tril(lower, -1).T
    else:
        inverse, failed = linalg.lapack.dtrtri(lower, lower=True, unitdiag=True)
        flexibility = (inverse.T / last) @ inverse
    if failed:
        raise ContactError(f"the condensed stiffness has no inverse (LAPACK {failed}); take a coarser mesh")
    return Condensation(flexibility, order, factor, pivots)


NOT_DEFINITE = "the stiffness is not positive definite; take a smaller poisson_ratio or film modulus"
LEAF = 3  # triangles; smaller leaves cost more calls, larger ones more arithmetic


@dataclass(frozen=True)
class Front:
    """It eliminates the functions `pivots` and leaves `border` coupled; `children` come before it.

    `triangles` are a leaf's, none of a front with children.
    """

    pivots: Index
    border: Index
    children: tuple[int, ...]
    triangles: Index


@dataclass(frozen=True)
class EliminatedFront:
    """A front's unknowns `pivots` `(k,)` and `border` `(m,)`, its lower Cholesky factors `root` `(k, k)` and
    `side` `(m, k)`, and the lower triangle `rest` `(m, m)` that it leaves."""

    pivots: Index
    border: Index
    root: Array
    side: Array
    rest: Array


Unknowns = Callable[[Index], Index]  # the free unknowns of functions, in their order
# Of a triangle, what is above it, piece by piece: unknowns `(m,)` and stiffness `(m, m)`
Inside = Callable[[int], Iterable[tuple[Index, Array]]]


def dissection(functions: list[Index], centres: Array, last: Index) -> list[Front]:
    """Return the fronts, the root last, for triangles with these functions and centres `(t, 2)`.

    `last` `(k,)` are never eliminated and are the root's border. George, SIAM J. Numer. Anal. 10 (1973) 345.
    """
    fronts: list[Front] = []

    def all_of(triangles: Index) -> Index:
        return np.unique(np.concatenate([functions[t] for t in triangles]))

    def visit(triangles: Index, outside: Index) -> int:
        here = all_of(triangles)
        children: tuple[int, ...] = ()
        if triangles.size <= LEAF:
            separator = np.setdiff1d(here, outside, assume_unique=True)
        else:
            halves, separator = _separator(triangles, centres, outside, all_of)
            known = np.union1d(outside, separator)
            children = tuple(visit(half, known) for half in halves)
        border = np.intersect1d(here, outside, assume_unique=True)
        leaf = triangles[:0] if children else triangles
        fronts.append(Front(separator, border, children, leaf))
        return len(fronts) - 1

    visit(np.arange(len(functions)), np.sort(last))
    return _in_order(fronts)


def _in_order(fronts: list[Front]) -> list[Front]:
    """Sort each border by elimination, so that it falls into few runs of its parent's rows, in order."""
    eliminated = np.concatenate([front.pivots for front in fronts] + [fronts[-1].border])
    rank = np.empty(eliminated.max() + 1, dtype=np.int64)
    rank[eliminated] = np.arange(eliminated.size)
    return [replace(front, border=front.border[np.argsort(rank[front.border])]) for front in fronts]


def _separator(
    triangles: Index, centres: Array, outside: Index, all_of: Callable[[Index], Index]
) -> tuple[tuple[Index, Index], Index]:
    """Halve the triangles across x or z, whichever leaves fewer shared functions."""
    best = []
    for axis in (0, 1):
        ranked = triangles[np.argsort(centres[triangles, axis], kind="stable")]
        halves = ranked[: ranked.size // 2], ranked[ranked.size // 2 :]
        shared = np.intersect1d(all_of(halves[0]), all_of(halves[1]), assume_unique=True)
        best.append((halves, np.setdiff1d(shared, outside, assume_unique=True)))
    return min(best, key=lambda pair: pair[1].size)


def schur(inside: Inside, fronts: list[Front], unknowns: Unknowns, load: Array) -> tuple[Array, Array]:
    """Return the Schur complement `(k, k)` on the root's border, and the load `(k,)` condensed to it.

    `load` is `(n,)`. Raises ContactError when the matrix is not positive definite.
    """
    load = load.copy()
    for step in eliminated(inside, fronts, unknowns, load.size):
        _forward(step, load)
    return np.tril(step.rest) + np.tril(step.rest, -1).T, load[step.border]


def eliminated(
    inside: Inside, fronts: list[Front], unknowns: Unknowns, size: int
) -> Iterator[EliminatedFront]:
    """Yield front after front of a matrix `(size, size)`, eliminated; the last leaves the Schur complement.

    Duff and Reid, ACM Trans. Math. Softw. 9 (1983) 302; fronts hold their lower triangle only. Raises
    ContactError when the matrix is not positive definite.
    """
    where = np.full(size, -1)
    left: dict[int, tuple[Index, Array]] = {}
    for number, front in enumerate(fronts):
        unknowns_here, border = unknowns(front.pivots), unknowns(front.border)
        rows = np.concatenate([unknowns_here, border])
        where[rows] = np.arange(rows.size)
        block = np.zeros((rows.size, rows.size), order="F")
        for triangle in front.triangles:
            for numbers, stiffness in inside(triangle):
                free = np.flatnonzero(where[numbers] >= 0)  # unknowns that are held are at -1
                places = where[numbers][free]
                block[places[:, None], places] += stiffness[free[:, None], free]
        for child in front.children:
            child_border, rest = left.pop(child)
            _add_runs(block, rest, where[child_border])
        where[rows] = -1
        step = _eliminate(block, unknowns_here, border)
        left[number] = border, step.rest
        yield step


@dataclass(frozen=True)
class FrontFactors:
    """Fronts of a matrix that is positive definite with the root's border `(k,)` held. `flexibility` `(k, k)`
    is the inverse's block there; `negative_eigenvalues` is their number in the matrix."""

    steps: tuple[EliminatedFront, ...]
    border: Index
    flexibility: Array
    negative_eigenvalues: int

    def solve(self, load: Array) -> Array:
        """Return the unknowns `(n,)` under a load `(n,)`, or under several `(n, l)`; 0 where not free."""
        solution, load = np.zeros_like(load), load.copy()
        parts = [_forward(step, load) for step in self.steps]
        solution[self.border] = self.flexibility @ load[self.border]
        for step, part in zip(reversed(self.steps), reversed(parts), strict=True):
            side = part - step.side.T @ solution[step.border]
            solution[step.pivots] = linalg.solve_triangular(
                step.root, side, trans=1, lower=True, check_finite=False
            )
        return solution


def factored(inside: Inside, fronts: list[Front], unknowns: Unknowns, size: int) -> FrontFactors:
    """Return the matrix factored; ContactError when it is not positive definite with the border held."""
    steps = []
    for step in eliminated(inside, fronts, unknowns, size):
        steps.append(replace(step, rest=np.empty((0, 0))))  # the parent has it; only factors are kept
        rest = step.rest
    flexibility, negative_eigenvalues = _inverse(rest)
    return FrontFactors(tuple(steps), steps[-1].border, flexibility, negative_eigenvalues)


def _inverse(lower: Array) -> tuple[Array, int]:
    """Return the inverse of a symmetric matrix and how many of its eigenvalues are negative."""
    try:
        root = linalg.cho_factor(lower, lower=True, check_finite=False)
    except linalg.LinAlgError:
        values, vectors = linalg.eigh(lower, lower=True, check_finite=False)
        return (vectors / values) @ vectors.T, int((values < 0).sum())
    inverse = linalg.cho_solve(root, np.eye(len(lower)), check_finite=False)
    return (inverse + inverse.T) / 2, 0


def _add_runs(block: Array, rest: Array, at: Index) -> None:
    """Add the lower triangle of a child's rest at the ascending positions `at`, run by run."""
    breaks = [0, *(np.flatnonzero(np.diff(at) != 1) + 1).tolist(), at.size]
    starts = at[breaks[:-1]].tolist()
    for i, (a, b, row) in enumerate(zip(breaks, breaks[1:], starts, strict=False)):
        for c, d, column in zip(breaks, breaks[1 : i + 2], starts, strict=False):
            block[row : row + b - a, column : column + d - c] += rest[a:b, c:d]


def _eliminate(block: Array, pivots: Index, border: Index) -> EliminatedFront:
    """Eliminate the first unknowns of a front."""
    k = pivots.size
    if k == 0:
        return EliminatedFront(pivots, border, block[:0, :0], block[:, :0], block)
    root, failed = lapack.dpotrf(block[:k, :k], lower=1, clean=0)
    if failed:
        raise ContactError(NOT_DEFINITE)
    side = blas.dtrsm(1.0, root, block[k:, :k], side=1, lower=1, trans_a=1)
    rest = np.asarray(blas.dsyrk(-1.0, side, beta=1.0, c=block[k:, k:], lower=1))
    return EliminatedFront(pivots, border, root, side, rest)


def _forward(step: EliminatedFront, load: Array) -> Array:
    """Return the load of a front's pivots behind its factor; its border's is updated in place."""
    if step.pivots.size == 0:
        return load[step.pivots]
    part = linalg.solve_triangular(step.root, load[step.pivots], lower=True, check_finite=False)
    load[step.border] -= step.side @ part
    return np.asarray(part)
