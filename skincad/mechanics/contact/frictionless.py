"""Contact without friction on a condensed pad: a state at a force, and the force at which all touch.

Unknown are the nodal forces f >= 0 and the approach d with, for a flexibility C and initial gaps g,
w = g - d + C f >= 0, f w = 0 and sum f = F: the optimality of a strictly convex quadratic program,
so the solution is unique.

A body that is stable only while its plate holds it has a flexibility that is not definite. The conditions are
then those of a saddle point, and the solution is the one that sweeps from a nearby set reach.

The contact of a whole pad from its half. Any load on a mirror-symmetric pad is the sum of a symmetric and an
antisymmetric one. The half is solved for each alone: symmetric loads with x held on its cut, antisymmetric
ones with z held there.

The smallest force at which all ridges touch is a smooth function of the design. A ridge is taken out of
contact and the minimum of its finely sampled gap is put at zero by root finding on the force. Counting
touching nodes instead would jump with the mesh.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import linalg, optimize, sparse
from scipy.sparse.linalg import splu

from skincad.base.arrays import Array, Index, Mask
from skincad.base.interrupt import safe_point
from skincad.mechanics.bodies import elements
from skincad.mechanics.bodies.condense import condense
from skincad.mechanics.bodies.elements import ContactStiffness
from skincad.mechanics.problem import ContactError, Pad, rise
from skincad.shape.crests import FACE

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


# Of one pad: for each set of active points the forces on them that close their gaps and that move them by one
ActiveSetCache = dict[bytes, tuple[Array, Array]]


def seen_by(rows: sparse.csr_matrix, flexibility: Array) -> Array:
    """Return the flexibility of points that the unknowns of `flexibility` move by `rows`."""
    full = np.asarray(rows @ (rows @ flexibility).T)
    return np.asarray((full + full.T) / 2)


def press(
    flexibility: Array,
    gap: Array,
    force: float,
    start: Mask | None = None,
    solved: ActiveSetCache | None = None,
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
        # by a stiff guess of the approach few points to start from, so that the sweeps mostly add; a
        # flexibility that is not definite may have a negative mean, and the lowest point touches all the same
        guess = 0.5 * force * float(np.mean(flexibility @ np.ones(gap.size))) / gap.size
        active = may & (gap <= gap[may].min() + min(float(np.ptp(gap[may])), max(guess, 0.0)))
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


def _length(gap: Array, approach: float) -> float:
    return float(abs(approach) + np.ptp(gap)) or 1.0


def _equilibrium(
    flexibility: Array,
    gap: Array,
    force: float,
    active: Mask,
    solved: ActiveSetCache,
    definite: bool = True,
) -> tuple[Array, float]:
    """Forces and approach that close exactly the active points under the total force."""
    inside, key = np.flatnonzero(active), active.tobytes()
    first = gap[inside].min()  # counted from here, so that a tiny force is not lost in rounding
    if key not in solved:  # forces that move the points by their gaps, and all by one
        sides = np.column_stack([gap[inside] - first, np.ones(inside.size)])
        block = flexibility[np.ix_(inside, inside)]
        try:
            if definite:
                root = linalg.cho_factor(block, check_finite=False)
                columns = linalg.cho_solve(root, sides, check_finite=False)
            else:
                columns = linalg.solve(block, sides, assume_a="sym", check_finite=False)
        except linalg.LinAlgError:
            raise ContactError("the contact flexibility is singular; take a coarser contact mesh") from None
        solved[key] = columns[:, 0], columns[:, 1]
    by_gap, by_one = solved[key]
    approach = (force + by_gap.sum()) / by_one.sum()
    nodal = np.zeros_like(gap)
    nodal[inside] = approach * by_one - by_gap
    return nodal, float(first + approach)


def _descend(flexibility: Array, gap: Array, force: float, may: Mask) -> NodalContact:
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
        words = f"the contact is satisfied only to {residual:.1e}, not to {COMPLEMENTARITY:g}"
        raise ContactError(f"{words}; take a smaller poisson_ratio or a coarser mesh")
    return NodalContact(nodal, approach, open_gap, active, residual)


def on_both_sides(
    symmetric: Ridges, half: ContactStiffness, ridges: tuple[int, ...]
) -> tuple[Array, Array, Index]:
    """Return a whole pad's contact: flexibility, gaps and ridges of its points, those at x >= 0 first, then
    the images of those off the cut.

    Known are the contact of its half under symmetric loads, the half's stiffness for loads of either parity,
    in whose units the whole is too, and the pad's `ridges`. Costs one condensation of the half.
    """
    interior, contact = elements.antisymmetric_unknowns(half)
    moving = half.nodes.rows[:, np.flatnonzero(np.isin(half.contact, contact))]
    moving.data[np.abs(moving.data) < ROUNDING] = 0.0
    moving.eliminate_zeros()
    off = np.flatnonzero(moving.getnnz(axis=1))  # a point on the cut is its own image
    other = seen_by(moving, condense(half.matrix, interior, contact).flexibility)
    same, image = (symmetric.flexibility + other) / 2, (symmetric.flexibility - other) / 2
    flexibility = np.block([[same, image[:, off]], [image[off], same[np.ix_(off, off)]]])
    mirrored = dict(zip(ridges, reversed(ridges), strict=True))
    return (
        flexibility,
        np.concatenate([symmetric.gap, symmetric.gap[off]]),
        np.concatenate([symmetric.of_point, [mirrored[r] for r in symmetric.of_point[off].tolist()]]),
    )


LARGEST_FORCE = 1e4  # in units of E times the unit length; far beyond any small strain
ROOT = 1e-12  # relative, of the force


@dataclass(frozen=True)
class Ridges:
    """The condensed pad seen by the plate, in the pad's units.

    `flexibility` `(m, m)` and `gap` `(m,)` belong to the contact points, `of_point` `(m,)` gives their
    ridge; `fine_gap` `(p,)`, `fine_edge` `(p,)`, `fine_of_point` `(p,)` belong to the fine sampling. The
    contact unknowns `(m,)` move the points by `rows` `(m, m)`, the fine sampling by `fine_rows` `(p, m)`.
    `definite` says whether the pad is stable without its plate. `across` `(m,)` and `fine_across` `(p,)` are
    places from -1 to 1, in the distance of the farthest from x = 0.
    """

    flexibility: Array
    gap: Array
    of_point: Index
    rows: sparse.csr_matrix
    fine_rows: sparse.csr_matrix
    fine_gap: Array
    fine_edge: Index
    fine_of_point: Index
    definite: bool = True
    across: Array = field(default_factory=lambda: np.empty(0))
    fine_across: Array = field(default_factory=lambda: np.empty(0))

    @classmethod
    def of(
        cls,
        system: ContactStiffness,
        flexibility: Array,
        top: float,
        rise: Callable[[Array], Array] = np.zeros_like,
    ) -> Ridges:
        """Return the contact points' view of a condensed system whose highest point is at z = `top`.

        `flexibility` is the contact unknowns'. `rise` is the plate's height over its lowest line at x; the
        gaps count from the first touch.
        """
        nodes, fine = system.nodes, system.fine
        fine_gap = top - fine.position[:, 1] + rise(fine.position[:, 0])
        first = 0.0 if rise is np.zeros_like else float(fine_gap.min())
        farthest = float(np.abs(fine.position[:, 0]).max())
        return cls(
            seen_by(nodes.rows, flexibility),
            top - nodes.position[:, 1] + rise(nodes.position[:, 0]) - first,
            nodes.ridge,
            nodes.rows,
            fine.rows,
            fine_gap - first,
            fine.edge,
            fine.ridge,
            across=nodes.position[:, 0] / farthest,
            fine_across=fine.position[:, 0] / farthest,
        )

    def lowered(self, drops: Array) -> Ridges:
        """Return the same pad with each ridge's crest lower by `drops` `(ridges,)`, higher where negative.

        A face is lower by three `drops` at FACE, and elsewhere by the parabola through these.
        The gaps count from the first touch as before, so the same drop of all crests changes nothing.
        """
        if drops.size == len(FACE) and self.numbers.size == 1:
            across = np.polyfit(FACE, drops, 2)
            at_points, fine = np.polyval(across, self.across), np.polyval(across, self.fine_across)
        else:
            by_ridge = dict(zip(self.numbers.tolist(), drops.tolist(), strict=True))
            at_points = np.array([by_ridge[r] for r in self.of_point.tolist()])
            fine = np.array([by_ridge[r] for r in self.fine_of_point.tolist()])
        later = float((self.fine_gap + fine).min() - self.fine_gap.min())
        return replace(self, gap=self.gap + at_points - later, fine_gap=self.fine_gap + fine - later)

    @property
    def points(self) -> tuple[Array, Array, Index]:
        """The contact points' flexibility, gaps and ridges."""
        return self.flexibility, self.gap, self.of_point

    def sums(self, nodal: Array) -> Array:
        """Return what each ridge carries of forces `(m,)` on the contact points, by its number."""
        return np.array([nodal[self.of_point == r].sum() for r in self.numbers])

    @property
    def numbers(self) -> Index:
        """The ridges' numbers, ascending."""
        return np.unique(self.of_point)


def all_touch_force(ridges: Ridges, guess: float, active: Mask | None = None) -> float | None:
    """Return the smallest force that makes every ridge touch, or None if none does; 0 for one ridge.

    A candidate for the last ridge is tested at the force at which it touches: another ridge that does not
    touch yet becomes the next candidate. The search begins at the force `guess`, with the points `active`
    `(m,)` that may touch at it.
    """
    numbers = ridges.numbers
    if numbers.size == 1:
        return 0.0
    first_gap = {int(r): float(ridges.fine_gap[ridges.fine_of_point == r].min()) for r in numbers}
    candidate = max(first_gap, key=lambda r: first_gap[r])
    largest = 0.0
    waiting = set(first_gap)
    touching = np.zeros(ridges.gap.size, dtype=bool) if active is None else active.copy()
    while True:
        waiting.remove(candidate)
        outsider = _Outsider(ridges, candidate, touching)
        # a mirror ridge touches a rounding error later: look close above the last one's force
        force = outsider.touch_force(largest, guess if largest == 0.0 else 1e-3 * largest)
        if force is None:
            return None
        largest = max(largest, force)
        late = waiting.intersection(outsider.not_touching(largest))
        touching[outsider.others] = outsider.start[outsider.others]
        if not late:
            return largest
        candidate = max(late, key=lambda r: first_gap[r])


def least_gap(gaps: Array, edge: Index) -> float:
    """Return the minimum of a ridge's sampled gaps `(p,)`, refined by a parabola through three samples of its
    `edge` `(p,)`.

    The samples' own minimum would have a kink wherever it moves on to the next sample.
    """
    i = int(np.argmin(gaps))
    if not 0 < i < gaps.size - 1 or not edge[i - 1] == edge[i] == edge[i + 1]:
        return float(gaps[i])
    before, here, after = gaps[i - 1 : i + 2]
    bend = before - 2 * here + after
    return float(here - (after - before) ** 2 / (8 * bend)) if bend > 0 else float(here)


class _Outsider:
    """One ridge out of contact while the others are pressed, first from the points `touching` `(m,)`."""

    def __init__(self, ridges: Ridges, ridge: int, touching: Mask) -> None:
        self.ridges, self.ridge = ridges, ridge
        self.others = ridges.of_point != ridge
        points = np.flatnonzero(ridges.fine_of_point == ridge)
        self.rows = ridges.fine_rows[points]
        self.unknowns = splu(ridges.rows.tocsc())
        self.start = touching
        self.solved: ActiveSetCache = {}
        self.fine_gap, self.edge = ridges.fine_gap[points], ridges.fine_edge[points]

    def press(self, force: float) -> NodalContact:
        flexibility, gap, definite = self.ridges.flexibility, self.ridges.gap, self.ridges.definite
        state = press(flexibility, gap, force, self.start, self.solved, definite=definite, may=self.others)
        self.start = state.active
        return state

    def least_gap(self, force: float) -> float:
        """Smallest gap of the ridge while the others carry `force`."""
        if force <= 0:
            return least_gap(self.fine_gap, self.edge)
        closed = self.unknowns.solve(self.press(force).gap - self.ridges.gap)
        return least_gap(self.fine_gap + self.rows @ closed, self.edge)

    def touch_force(self, low: float, step: float) -> float | None:
        """Force at which the ridge begins to touch, at least `low`; None if it never does."""
        if self.least_gap(low) <= 0:
            return low
        high = low + step
        while self.least_gap(high) > 0:
            low, high = high, high + 2 * (high - low)
            if high > LARGEST_FORCE:
                return None
        root = optimize.brentq(self.least_gap, low, high, xtol=ROOT * high, rtol=ROOT)
        return float(root)

    def not_touching(self, force: float) -> list[int]:
        """Other ridges that carry nothing at this force."""
        numbers = [int(r) for r in self.ridges.numbers if r != self.ridge]
        if force <= 0:
            return []
        nodal = self.press(force).force
        carried = np.bincount(self.ridges.of_point, nodal, minlength=max(numbers) + 1)
        return [r for r in numbers if not carried[r] > 0]


def seen_by_plate(
    pad: Pad,
    system: ContactStiffness,
    flexibility: Array,
    unit: float,
    crest_offsets: tuple[float, ...] = (),
) -> Ridges:
    """Return the contact points as the pad's plate sees them, crests lower than the section's by
    `crest_offsets` mm; `unit` is the pad's, mm."""
    flat = pad.plate.shape == "flat"
    over = np.zeros_like if flat else lambda x: rise(pad.plate, x * unit) / unit
    ridges = Ridges.of(system, flexibility, pad.top / unit, over)
    return ridges.lowered(np.array(crest_offsets) / unit) if crest_offsets else ridges


def over_crests(ridges: Ridges, position: Array) -> Callable[[Array], Array]:
    """Return how high a flat plate is over x where it first touches, in units, from contact points at
    `position` `(m, 2)`.

    Of a measured part, whose crests are moved and whose mesh is not, as far over each crest as over the
    part's, and between two by a line.
    """
    order = np.argsort(position[:, 0], kind="stable")
    x, level = position[order, 0], (position[:, 1] + ridges.gap)[order]
    return lambda at: np.asarray(np.interp(at, x, level))
