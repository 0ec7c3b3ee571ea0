"""Unilateral, frictionless contact with a rigid flat plate under a given force, solved exactly.

Unknown are the nodal forces f >= 0 and the approach d with, for a flexibility C and initial gaps g,
w = g - d + C f >= 0, f w = 0 and sum f = F: the optimality of a strictly convex quadratic program,
so the solution is unique. C is a dense array or, of a long pad, a chain of slabs (bodies/chain.py).

A body that is stable only while its plate holds it has a flexibility that is not definite. The conditions are
then those of a saddle point, and the solution is the one that sweeps from a set nearby lead to.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg, sparse

from skincad.base.arrays import Array, Index, Mask
from skincad.base.interrupt import safe_point
from skincad.mechanics.bodies.chain import SlabChain
from skincad.mechanics.problem import ContactError

SWEEPS = 60  # primal-dual sweeps; five to ten is usual, beyond this it cycles
ROUNDING = 1e-12  # relative; what counts as zero when the active set is updated
COMPLEMENTARITY = 1e-10  # relative; a larger residual is never accepted


@dataclass(frozen=True)
class NodalContact:
    """Nodal forces `(m,)`, approach and gaps `(m,)` at a force; `active` `(m,)` marks touching points."""

    force: Array
    approach: float
    gap: Array
    active: Mask
    residual: float


Flexibility = Array | SlabChain
SolutionPoint = dict[
    bytes, tuple[Array, Array]
]  # of one pad: active points to what they carry by gaps and by one


def seen_by(rows: sparse.csr_matrix, flexibility: Flexibility) -> Flexibility:
    """Return the flexibility of points that the unknowns of `flexibility` move by `rows`."""
    if isinstance(flexibility, SlabChain):
        return flexibility.seen(rows)
    full = np.asarray(rows @ (rows @ flexibility).T)
    return np.asarray((full + full.T) / 2)


def press(
    flexibility: Flexibility,
    gap: Array,
    force: float,
    start: Mask | None = None,
    solved: SolutionPoint | None = None,
    *,
    definite: bool = True,
    may: Mask | None = None,
) -> NodalContact:
    """Return the contact state at a total force by a primal-dual active set.

    `flexibility` `(m, m)` symmetric, positive definite if `definite`; `gap` `(m,)` at approach 0; only the
    points that `may` `(m,)` do touch, all unless given. Hintermueller, Ito and Kunisch, SIAM J. Optim. 13
    (2002) 865. `solved` remembers the sets factorised so far, for the same pad under another force. When the
    sweeps cycle, a primal active set finishes, which ends by itself because its objective falls; not so in a
    saddle point. Raises ContactError rather than return a state whose complementarity is worse than 1e-10 of
    scale.
    """
    if not (force > 0 and np.isfinite(force)):
        raise ContactError(f"the contact force must be above 0, got {force:g}")
    if may is None:
        may = np.ones(gap.size, dtype=bool)
    active = may if start is None else start & may
    if start is None or not active.any():
        active = may & (gap <= gap[may].min() + _first_approach(flexibility, gap[may], force))
    for _ in range(SWEEPS):
        safe_point()
        known = {} if solved is None else solved
        nodal, approach = _equilibrium(flexibility, gap, force, active, known, definite)
        open_gap = gap - approach + flexibility @ nodal
        # by the largest nodal force, as it is accepted: by the whole force many nodes would let too much pass
        small_force, small_gap = ROUNDING * float(nodal.max()), ROUNDING * _length(gap[may], approach)
        wanted = (active & (nodal >= -small_force)) | (may & ~active & (open_gap < -small_gap))
        if np.array_equal(wanted, active):
            return _accepted(gap, force, nodal, approach, open_gap, active, may)
        if not wanted.any():
            wanted[np.argmax(nodal)] = True
        active = wanted
    if not definite:
        raise ContactError("the contact does not settle")
    return _descend(flexibility, gap, force, may)


def _first_approach(flexibility: Flexibility, gap: Array, force: float) -> float:
    """A stiff guess of the approach: few points to start from, so that the sweeps mostly add.

    A flexibility that is not definite may have a negative mean; the lowest point touches all the same.
    """
    one = np.ones(flexibility.shape[0])
    guess = 0.5 * force * float(np.mean(flexibility @ one)) / one.size
    return min(float(np.ptp(gap)), max(guess, 0.0))


def _length(gap: Array, approach: float) -> float:
    return float(abs(approach) + np.ptp(gap)) or 1.0


def _equilibrium(
    flexibility: Flexibility,
    gap: Array,
    force: float,
    active: Mask,
    solved: SolutionPoint,
    definite: bool = True,
) -> tuple[Array, float]:
    """Forces and approach that close exactly the active points under the total force."""
    inside, key = np.flatnonzero(active), active.tobytes()
    first = gap[inside].min()  # counted from here, so that a tiny force loses no digits
    if key not in solved:
        solved[key] = _carried(flexibility, inside, gap[inside] - first, definite)
    by_gap, by_one = solved[key]
    approach = (force + by_gap.sum()) / by_one.sum()
    nodal = np.zeros_like(gap)
    nodal[inside] = approach * by_one - by_gap
    return nodal, float(first + approach)


def _carried(flexibility: Flexibility, inside: Index, gap: Array, definite: bool) -> tuple[Array, Array]:
    """Forces that move the points `inside` by their gaps, and all by one, while no other carries any."""
    sides = np.column_stack([gap, np.ones(gap.size)])
    if isinstance(flexibility, SlabChain):
        return tuple(flexibility.carried(inside, sides).T)
    block = flexibility[np.ix_(inside, inside)]
    try:
        if definite:
            root = linalg.cho_factor(block, check_finite=False)
            columns = linalg.cho_solve(root, sides, check_finite=False)
        else:
            columns = linalg.solve(block, sides, assume_a="sym", check_finite=False)
    except linalg.LinAlgError:
        raise ContactError("the contact flexibility is singular; take a coarser contact mesh") from None
    return columns[:, 0], columns[:, 1]


def _descend(flexibility: Flexibility, gap: Array, force: float, may: Mask) -> NodalContact:
    """Primal active set: stay feasible, add the most closed point, step back to the first zero force.

    Nocedal and Wright, Numerical Optimization, 2nd ed., algorithm 16.3.
    """
    nodal = np.zeros_like(gap)
    active = np.zeros(gap.size, dtype=bool)
    first = int(np.argmin(np.where(may, gap, np.inf)))
    nodal[first], active[first] = force, True
    for _ in range(20 * gap.size + 100):
        safe_point()
        target, approach = _equilibrium(flexibility, gap, force, active, {})
        if (target[active] >= 0).all():
            nodal = target
            open_gap = gap - approach + flexibility @ nodal
            worst = int(np.argmin(np.where(may & ~active, open_gap, 0.0)))
            if active[worst] or not may[worst] or open_gap[worst] >= -ROUNDING * _length(gap[may], approach):
                return _accepted(gap, force, nodal, approach, open_gap, active, may)
            active[worst] = True
            continue
        step = target - nodal
        negative_eigenvalues = active & (target < 0)
        ratio = np.where(negative_eigenvalues, nodal / np.where(negative_eigenvalues, -step, 1.0), np.inf)
        blocked = int(np.argmin(ratio))
        nodal = np.maximum(nodal + min(1.0, float(ratio[blocked])) * step, 0.0)
        nodal[blocked], active[blocked] = 0.0, False
    raise ContactError("the contact does not settle; take a coarser contact mesh")


def _accepted(
    gap: Array, force: float, nodal: Array, approach: float, open_gap: Array, active: Mask, may: Mask
) -> NodalContact:
    """Measure penetration, tension, gap times force and balance, each against its scale."""
    length, largest = _length(gap[may], approach), float(nodal.max())
    residual = max(
        float(-open_gap[may].min()) / length,
        float(-nodal.min()) / largest,
        float(np.abs(open_gap * nodal).max()) / (length * largest),
        abs(float(nodal.sum()) / force - 1),
        0.0,
    )
    if not residual <= COMPLEMENTARITY:
        raise ContactError(
            f"the contact is satisfied only to {residual:.1e}, not to {COMPLEMENTARITY:g}; "
            "take a smaller poisson_ratio or a coarser mesh"
        )
    return NodalContact(nodal, approach, open_gap, active, residual)
