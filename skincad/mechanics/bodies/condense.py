"""Condensation to the contact unknowns: the trailing block of one sparse factorisation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import linalg, sparse
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
    if not (factorisation.pivots[-contact.size :] > 0).all():
        raise ContactError(
            "the condensed stiffness is not positive definite; take a smaller poisson_ratio or film modulus"
        )
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


def trailing(matrix: sparse.csr_matrix, order: Index, k: int) -> tuple[Any, Array, Array]:
    """Return SuperLU's factors in this order, the pivots `(n,)`, and the last rows of L `(k, k)`.

    Symmetric without pivoting: what is left of the last k is L D L^T with D the diagonal of U.
    """
    factor = factors(sparse.csc_matrix(matrix[order][:, order]))
    natural = np.arange(order.size)
    if not (np.array_equal(factor.perm_r, natural) and np.array_equal(factor.perm_c, natural)):
        raise ContactError("the factorisation left the given order; the stiffness is not positive definite")
    return factor, factor.U.diagonal(), factor.L[-k:, -k:].toarray(order="F")


def factorise(matrix: sparse.csr_matrix, order: Index, k: int) -> Condensation:
    """Return `condense` for a given order, whose last `k` are the contact unknowns, definite or not.

    Over a Newton run the pattern stays, and with it the order from `fill_order`.
    """
    factor, pivots, lower = trailing(matrix, order, k)
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
