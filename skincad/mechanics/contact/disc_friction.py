"""Coulomb friction of points that may slide along x and along y: one step of a press in small strain.

Unknown are the points' normal forces p >= 0 and their tangential forces t, two each, |t| <= mu p. A point
that touches sticks, u = a + s, or slides against t with |t| = mu p; a is where it sat on the plate, u where
it goes, and s how far the plate, which no force holds sideways, goes along x. Implicit in time, as in
frictional.py: Klarbring, Ing.-Arch. 56 (1986) 529.

With t given the normal forces are those of a contact without friction (frictionless.py). For t, which its
disc |t| <= mu p cuts, one step of the semi-smooth Newton method follows, in which p moves with it; then the
normal forces again. The derivative on a disc's edge is the modified one of Hueeber, Stadler and Wohlmuth,
SIAM J. Sci. Comput. 30 (2008) 572, which keeps sets from cycling.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from skincad.base.arrays import Array, Index, Mask
from skincad.base.interrupt import safe_point
from skincad.mechanics.contact.frictionless import press
from skincad.mechanics.contact.state import OPEN, RIGHT, STICK, ContactState, at_rest
from skincad.mechanics.problem import ContactError

ITERATIONS = 60  # five to eight are usual
WHOLE_STEPS = 10  # Newton's; four in five are halves after that, as sets that cycle settle by them
ACCURACY = 1e-8  # of the plate's force: what tangential forces are off, or slips times a point's stiffness


@dataclass(frozen=True, eq=False)
class DiscCompliance:
    """m points under forces along z, and along x and y: `normal` `(m, m)`, `tangential` `(2 m, 2 m)`,
    x first, and `cross` `(m, 2 m)`, how far points rise under forces along x and y; `gap` `(m,)` from the
    plate.

    `able` `(2 m,)` marks movements that nothing holds, `floats` whether the plate may go along x.
    """

    normal: Array
    tangential: Array
    cross: Array
    gap: Array
    able: Mask
    floats: bool


def unloaded(points: int) -> ContactState:
    """Return the unloaded start of so many points."""
    return replace(at_rest(points), tangential=np.zeros(2 * points), anchor=np.zeros(2 * points))


def solve_discs(skin: DiscCompliance, before: ContactState, force: float, coefficient: float) -> ContactState:
    """Return the state at the end of a step under the normal `force`, in which `tangential` and `anchor` are
    `(2 m,)`, x first; raises ContactError where the forces do not settle."""
    t, travel = before.tangential, before.travel
    active = before.touches if before.touches.any() else None
    for i in range(ITERATIONS):
        safe_point()
        state = press(skin.normal, skin.gap - skin.cross @ t, force, active)
        p, active = state.force, state.active
        bound = coefficient * np.tile(p, 2)
        free = -(skin.cross.T @ p) - before.anchor  # where points are without tangential forces
        trial, _ = _trial(skin, t, travel, free)
        length = _lengths(trial)
        sliding = length > bound
        # what the forces are off their trial cut to the discs
        missing = t - np.where(sliding, bound, 1.0) / np.where(sliding, length, 1.0) * trial
        residual = float(np.abs(missing).max(initial=0.0)) / force
        if residual <= ACCURACY:
            place = skin.tangential @ t - skin.cross.T @ p
            place[: p.size] -= travel
            sticks = np.tile(p > 0, 2) & ~sliding
            slides = np.where(sliding[: p.size], RIGHT, STICK)
            slid = np.hypot(*np.where(sliding, place - before.anchor, 0.0).reshape(2, -1))
            return ContactState(
                normal=p,
                tangential=t,
                anchor=np.where(sticks, before.anchor, place),
                status=np.where(p > 0, slides, OPEN).astype(np.int8),
                slipped=np.where(p > 0, slid, 0.0),
                approach=state.approach,
                travel=travel,
                residual=max(state.residual, residual),
            )
        after, further = _newton_step(skin, t, travel, free, p, coefficient, sliding, missing)
        share = 1.0 if i < WHOLE_STEPS or i % 5 == 0 else 0.5
        t, travel = t + share * (after - t), travel + share * (further - travel)
    raise ContactError(f"sticking and sliding points do not settle in {ITERATIONS} sweeps")


def _trial(skin: DiscCompliance, t: Array, travel: float, free: Array) -> tuple[Array, Array]:
    """What the tangential forces `(2 m,)` would be if points stuck, each alone, and a point's stiffness: the
    same along x and y, or points would slide askew."""
    softest = np.tile(skin.tangential.diagonal().reshape(2, -1).max(axis=0), 2)
    stiffness = np.where(skin.able, 1 / np.where(skin.able, softest, 1.0), 0.0)
    slip = np.asarray(skin.tangential @ t + free)  # how far points are off their anchors
    slip[: skin.gap.size] -= travel
    return t - stiffness * slip, stiffness


def _lengths(vector: Array) -> Array:
    """The lengths of pairs `(2 m,)`, for both of a pair."""
    return np.tile(np.hypot(*vector.reshape(2, -1)), 2)


def _newton_step(
    skin: DiscCompliance,
    t: Array,
    travel: float,
    free: Array,
    normal: Array,
    coefficient: float,
    sliding: Mask,
    missing: Array,
) -> tuple[Array, float]:
    """The tangential forces `(2 m,)` and the plate's travel after one semi-smooth step, in which the points
    that touch stay."""
    m, touching = skin.gap.size, np.flatnonzero(normal > 0)
    rows = np.flatnonzero(skin.able & np.tile(normal > 0, 2))  # the others carry nothing
    n, by_x = rows.size, (rows < m).astype(float)
    if not n:
        return np.zeros(2 * m), travel
    whole, every = _trial(skin, t, travel, free)
    trial, stiffness, length, now = (values[rows] for values in (whole, every, _lengths(whole), _lengths(t)))
    place = np.full(2 * m, -1)
    place[rows] = np.arange(n)
    partner = place[np.where(rows < m, rows + m, rows - m)]
    by_tangential = _pressed_by(skin, touching, rows)  # the normal forces' derivative by the tangential ones
    inside = skin.tangential[np.ix_(rows, rows)] - skin.cross[np.ix_(touching, rows)].T @ by_tangential
    trials = np.eye(n) - stiffness[:, None] * inside
    slides, bound = sliding[rows], coefficient * np.tile(normal, 2)[rows]
    way = np.where(slides, trial / np.where(slides, length, 1.0), 0.0)
    cut = np.where(slides, bound / np.where(slides, length, 1.0), 1.0)
    outward = np.where(slides, t[rows] / np.maximum(np.maximum(bound, now), 1e-300), 0.0)
    by_own = cut * (1 - outward * way)
    by_other = np.where(partner >= 0, -cut * outward * way[partner], 0.0)
    matrix = np.eye(n + skin.floats)
    matrix[:n, :n] -= by_own[:, None] * trials + by_other[:, None] * trials[partner]
    matrix[:n, :n] -= coefficient * way[:, None] * by_tangential[np.searchsorted(touching, rows % m)]
    side = np.append(-missing[rows], np.zeros(int(skin.floats)))
    if skin.floats:  # the plate goes along x until no force holds it
        pull = stiffness * by_x
        matrix[:n, n] = -(by_own * pull + by_other * pull[partner])
        matrix[n] = np.append(by_x, 0.0)
        side[n] = -float(t[rows] @ by_x)
    try:
        step = linalg.solve(matrix, side, check_finite=False)
    except linalg.LinAlgError:
        raise ContactError("sticking and sliding points have no common state") from None
    after = np.zeros(2 * m)
    after[rows] = t[rows] + step[:n]
    return after, travel + (float(step[n]) if skin.floats else 0.0)


def _pressed_by(skin: DiscCompliance, touching: Index, rows: Index) -> Array:
    """How tangential forces change the normal ones of points that stay in contact `(touching, rows)`."""
    k = touching.size
    matrix = np.zeros((k + 1, k + 1))
    matrix[:k, :k] = skin.normal[np.ix_(touching, touching)]
    matrix[:k, k], matrix[k, :k] = -1.0, 1.0
    sides = np.vstack([skin.cross[np.ix_(touching, rows)], np.zeros(rows.size)])
    return np.asarray(linalg.solve(matrix, sides, check_finite=False)[:k])
