"""F9, the smallest force at which all ridges touch, as a smooth function of the design.

A ridge is taken out of contact and the minimum of its finely sampled gap is put at zero by root
finding on the force. Counting touching nodes instead would jump with the mesh.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize, sparse
from scipy.sparse.linalg import splu

from skincad.base.arrays import Array, Index, Mask
from skincad.mechanics.bodies.elements import ContactStiffness
from skincad.mechanics.contact.frictionless import Flexibility, NodalContact, SolutionPoint, press, seen_by

LARGEST_FORCE = 1e4  # in units of E times the unit length; far beyond any small strain
ROOT = 1e-12  # relative, of the force


@dataclass(frozen=True)
class Ridges:
    """The condensed pad seen by the plate, in the pad's units.

    `flexibility` `(m, m)` and `gap` `(m,)` belong to the contact points, `of_point` `(m,)` gives their
    ridge; `fine_gap` `(p,)`, `fine_edge` `(p,)`, `fine_of_point` `(p,)` belong to the fine sampling. The
    contact unknowns `(m,)` move the points by `rows` `(m, m)`, the fine sampling by `fine_rows` `(p, m)`.
    `definite` says whether the pad is stable without its plate.
    """

    flexibility: Flexibility
    gap: Array
    of_point: Index
    rows: sparse.csr_matrix
    fine_rows: sparse.csr_matrix
    fine_gap: Array
    fine_edge: Index
    fine_of_point: Index
    definite: bool = True

    @classmethod
    def of(
        cls,
        system: ContactStiffness,
        flexibility: Flexibility,
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
        return cls(
            seen_by(nodes.rows, flexibility),
            top - nodes.position[:, 1] + rise(nodes.position[:, 0]) - first,
            nodes.ridge,
            nodes.rows,
            fine.rows,
            fine_gap - first,
            fine.edge,
            fine.ridge,
        )

    def lowered(self, drops: Array) -> Ridges:
        """Return the same pad with each ridge's crest lower by `drops` `(ridges,)`, higher where negative.

        The gaps count from the first touch as before, so the same drop of all crests changes nothing.
        """
        by_ridge = dict(zip(self.numbers.tolist(), drops.tolist(), strict=True))
        at_points = np.array([by_ridge[r] for r in self.of_point.tolist()])
        fine = np.array([by_ridge[r] for r in self.fine_of_point.tolist()])
        later = float((self.fine_gap + fine).min() - self.fine_gap.min())
        return replace(self, gap=self.gap + at_points - later, fine_gap=self.fine_gap + fine - later)

    @property
    def numbers(self) -> Index:
        """The ridges' numbers, ascending."""
        return np.unique(self.of_point)


def all_touch_force(ridges: Ridges, guess: float, active: Mask | None = None) -> float | None:
    """Return the smallest force that makes every ridge touch, or None if none does; 0 for one ridge.

    The last ridge is found by asking, at a candidate's own force, which others do not touch yet. The force
    `guess` and the points `active` `(m,)` that may touch at it are where the search begins.
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


class _Outsider:
    """One ridge out of contact while the others are pressed, first from the points `touching` `(m,)`."""

    def __init__(self, ridges: Ridges, ridge: int, touching: Mask) -> None:
        self.ridges, self.ridge = ridges, ridge
        self.others = ridges.of_point != ridge
        self.points = np.flatnonzero(ridges.fine_of_point == ridge)
        self.rows = ridges.fine_rows[self.points]
        self.unknowns = splu(ridges.rows.tocsc())
        self.start = touching
        self.solved: SolutionPoint = {}
        self.at_rest = self._least(ridges.fine_gap[self.points])

    def press(self, force: float) -> NodalContact:
        flexibility, gap, definite = self.ridges.flexibility, self.ridges.gap, self.ridges.definite
        state = press(flexibility, gap, force, self.start, self.solved, definite=definite, may=self.others)
        self.start = state.active
        return state

    def least_gap(self, force: float) -> float:
        """Smallest gap of the ridge while the others carry `force`."""
        if force <= 0:
            return self.at_rest
        closed = self.unknowns.solve(self.press(force).gap - self.ridges.gap)
        return self._least(self.ridges.fine_gap[self.points] + self.rows @ closed)

    def _least(self, gaps: Array) -> float:
        """Minimum of the sampled gaps, refined by a parabola through three samples of its edge.

        The samples' own minimum would have a kink wherever it moves on to the next sample.
        """
        i = int(np.argmin(gaps))
        edge = self.ridges.fine_edge[self.points]
        if not 0 < i < gaps.size - 1 or not edge[i - 1] == edge[i] == edge[i + 1]:
            return float(gaps[i])
        before, here, after = gaps[i - 1 : i + 2]
        bend = before - 2 * here + after
        return float(here - (after - before) ** 2 / (8 * bend)) if bend > 0 else float(here)

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
