"""Pins under a plate with friction: one point a tip, forces along x, y and z, one step of the plate.

Unknown are normal forces p and tangential ones f, |f| <= mu p, the plate's approach and its travel along x.
A tip that touches sticks, or slides against f; the plate keeps its line along y. Implicit in time, by the
semi-smooth Newton method; the derivative on a disc's edge is that of Hueeber, Stadler and Wohlmuth, SIAM J.
Sci. Comput. 30 (2008) 572, as in disc_friction.py, of which the normal side is linear.

Beside a tip's own compliance stand that of its contact, Mindlin's of a circle that sticks, (2 - nu) / (8 G a)
(Johnson, Contact Mechanics, 1985, eq. 7.42), and what its normal force adds as it bends: a column's lowering
by sway, 6/5 of d^2 / 2h, less the rise of a ball that rolls, R theta^2 / 2, which by itself turns the tip
back, and less what the strain stiffens. Or in their place what finite strain adds of each pin (`Bending`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy import linalg

from skincad.base.arrays import Array, Mask
from skincad.base.interrupt import safe_point
from skincad.mechanics.contact.state import OPEN, RIGHT, STICK, ContactState, Drive, GrossSlip
from skincad.mechanics.problem import ContactError

ITERATIONS = 80  # ten are usual
LEAST_SHARE = 1 / 8  # of Newton's step, which is halved where the forces don't come nearer
ACCURACY = 1e-9  # of the plate's force
ALL = 0.999  # of what friction bears in all, from where on the skin slips as a whole
SWAY = 1.2  # twice a bent column's lowering, times its height, by the square of its tip's movement
FAINT, TINY = 1e-6, 1e-12  # of the mean normal force, and N: no contact has less


class Bending(NamedTuple):
    """What finite strain adds to small strain, by n pins' normal forces and pulls: the `way` of tips along
    the pull and their `sinking` `(n,)` mm; the derivatives of the way `by_pull` and `by_normal`, the latter
    the sinking's by the pull too, and of the sinking by the normal force, mm/N; and mJ `stored`."""

    way: Array
    sinking: Array
    by_pull: Array
    by_normal: Array
    sinking_by_normal: Array
    stored: Array


@dataclass(frozen=True, eq=False)
class Tips:
    """n pins: `gap` mm, `curve`, which gives force and slope by indentation, `compliance` `(3 n, 3 n)` mm/N
    beside it, all along x, then y, then z; `radius` mm of the contact by its normal force is `wide` N^(-1/3)
    mm times its cube root (infinite: it gives way by nothing), `shear` (2 - nu) / (8 G) mm2/N; `soften`
    `(3, n)` 1/N is by how much a normal force softens a tip, what a ball that rolls takes from that, and by
    how much it takes less as its own moment turns the tip back; `pressed` gives forces and approach under a
    normal force without friction, to start from; `creep` what of Mindlin's compliance counts: from 1, where
    all sticks, to 1.5, where all is about to slip; `bend` gives what finite strain adds under normal forces
    and pulls, None in small strain."""

    gap: Array
    curve: Callable[[Array], tuple[Array, Array]]
    compliance: Array
    wide: float
    shear: float
    soften: Array
    pressed: Callable[[float], tuple[Array, float]]
    creep: float = 1.0
    bend: Callable[[Array, Array], Bending] | None = None

    def sway(self, normal: Array) -> Array:
        """Return what normal forces `(..., n)` N take of tips' stiffness across, less than 0 if they add."""
        softer, rolls, back = self.soften
        normal = np.maximum(normal, 0.0)
        return np.asarray(normal * (softer - rolls / (1 + normal * back)))

    def own(self, normal: Array) -> Array:
        """Return by how much tips give way across at normal forces `(..., n)`, mm/N, beside `compliance`.
        Raises ContactError where pins sway without a pull."""
        sway = self.sway(normal)
        if sway.max() >= 1:
            raise ContactError(f"pin {int(sway.argmax()) % self.gap.size + 1} tips over")
        normal = np.maximum(normal, max(FAINT * float(np.mean(normal)), TINY))
        contact = self.creep * self.shear / (self.wide * np.cbrt(normal))
        return np.asarray(contact + self.compliance.diagonal()[: self.gap.size] * sway / (1 - sway))

    def bending(self, normal: Array, pull: Array) -> Bending:
        """Return what finite strain adds, nothing in small strain."""
        return self.bend(normal, pull) if self.bend else Bending(*np.zeros((6, normal.size)))


@dataclass(frozen=True, eq=False)
class TipState(ContactState):
    """A contact whose tangential forces have a part along y too, `sideways` `(n,)` N; `anchor` is `(2, n)`
    mm, `elastic` mJ stored, `dissipated` mJ in the step."""

    sideways: Array = field(default_factory=lambda: np.zeros(0))
    elastic: float = 0.0
    dissipated: float = 0.0


def unloaded(tips: Tips) -> TipState:
    """Return the unloaded start."""
    zero = np.zeros(tips.gap.size)
    anchor, status = np.zeros((2, zero.size)), np.zeros(zero.size, dtype=np.int8)
    return TipState(zero, zero, anchor, status, zero, sideways=zero)


def advance(tips: Tips, before: TipState, drive: Drive, coefficient: float) -> TipState:
    """Return the state at a step's end by Coulomb's friction. Raises GrossSlip where the pull is more than
    ALL of what friction bears, and ContactError where the forces do not settle."""
    pull, most = drive.tangential, ALL * coefficient * drive.normal
    if pull is None or abs(pull) <= most:
        return _solved(tips, before, drive, coefficient)
    last = _solved(tips, before, replace(drive, tangential=math.copysign(most, pull)), coefficient)
    status = np.where(last.status == OPEN, OPEN, RIGHT).astype(np.int8)
    raise GrossSlip(replace(last, status=status, gross=True), "the pull is more than friction bears")


def _solved(tips: Tips, before: TipState, drive: Drive, coefficient: float) -> TipState:
    n, normal = tips.gap.size, drive.normal
    if normal == 0.0:
        return replace(unloaded(tips), travel=before.travel if drive.travel is None else drive.travel)
    p, approach = (before.normal, before.approach) if before.touches.any() else tips.pressed(normal)
    x = np.concatenate([before.tangential, before.sideways, p, [approach, before.travel]])
    share, last = 1.0, math.inf
    for _ in range(ITERATIONS):
        safe_point()
        missing, matrix, slip, sliding = _equations(tips, before, drive, coefficient, x)
        residual = float(np.abs(missing[:-1]).max()) / normal
        if residual <= ACCURACY and abs(missing[-1]) <= ACCURACY * max(normal, abs(x[-1])):
            break
        try:
            step = linalg.solve(matrix, -missing, check_finite=False)
        except linalg.LinAlgError:
            raise ContactError("sticking and sliding pins have no common state") from None
        share = min(1.0, 2 * share) if residual < last else max(share / 2, LEAST_SHARE)
        x, last = x + share * step, residual
    else:
        raise ContactError(f"sticking and sliding pins do not settle in {ITERATIONS} sweeps")
    p = x[2 * n : -2]
    touches, force = p > FAINT * normal / n, x[: 2 * n].reshape(2, n)
    moved = np.where(touches & ~sliding, 0.0, slip)
    mean = (force + np.array([before.tangential, before.sideways])) / 2
    status = np.where(touches, np.where(sliding, RIGHT, STICK), OPEN).astype(np.int8)
    return TipState(
        normal=p,
        tangential=force[0],
        anchor=before.anchor + moved,
        status=status,
        slipped=np.where(touches, np.hypot(*moved), 0.0),
        approach=float(x[-2]),
        travel=float(x[-1]),
        residual=residual,
        sideways=force[1],
        elastic=_elastic(tips, x),
        dissipated=-float((mean * moved)[:, touches].sum()),
    )


def _rise(tips: Tips, x: Array) -> tuple[Array, Array, Bending]:
    """How far contacts move under their forces `(3 n,)`, mm; their indentations `(n,)`, mm; and what of both
    finite strain adds."""
    n, p = tips.gap.size, x[2 * tips.gap.size : -2]
    moved, bent = (
        tips.compliance @ np.concatenate([x[: 2 * n], -p]),
        tips.bending(p, np.hypot(*x[: 2 * n].reshape(2, n))),
    )
    return moved, x[-2] - tips.gap + moved[2 * n :] - bent.sinking, bent


def _equations(
    tips: Tips, before: TipState, drive: Drive, coefficient: float, x: Array
) -> tuple[Array, Array, Array, Mask]:
    """What the unknowns miss, its derivative, how far tips slid `(2, n)` mm, and which slide."""
    n, p = tips.gap.size, x[2 * tips.gap.size : -2]
    moved, indentation, bent = _rise(tips, x)
    force, slope = tips.curve(indentation)
    f = x[: 2 * n].reshape(2, n)
    pulled = np.hypot(*f)
    known = pulled > max(FAINT * drive.normal, TINY)  # of less, the way is all rounding
    along = np.divide(f, pulled, out=np.zeros_like(f), where=known)
    own = tips.own(p) + np.divide(bent.way, pulled, out=bent.by_pull.copy(), where=known)
    slip = moved[: 2 * n].reshape(2, n) + own * f - before.anchor
    slip[0] -= x[-1]
    stiffness = 1 / (np.maximum(*tips.compliance.diagonal()[: 2 * n].reshape(2, n)) + np.maximum(own, 0.0))
    trial = f - stiffness * slip
    length, bound = np.hypot(*trial), coefficient * np.maximum(p, 0.0)
    sliding = length > bound
    way = np.where(sliding, trial / np.where(sliding, length, 1.0), 0.0)
    cut = np.where(sliding, bound / np.where(sliding, length, 1.0), 1.0)
    outward = np.where(sliding, f / np.maximum(np.maximum(bound, pulled), 1e-300), 0.0)
    aim = x[-1] - drive.travel if drive.travel is not None else f[0].sum() - (drive.tangential or 0.0)
    parts = (cut * trial - f).ravel(), force - p, [p.sum() - drive.normal, aim]
    signed = tips.compliance * np.repeat([1.0, 1.0, -1.0], n)
    inside = np.tile(stiffness, 2)[:, None] * signed[: 2 * n]
    trials = np.hstack([-inside, np.zeros((2 * n, 2))])
    at, steep = np.arange(2 * n), stiffness * (tips.own(p) + bent.by_pull - own)
    trials[at, at] += 1 - np.tile(stiffness * own, 2)
    trials[:n, -1] = stiffness
    if tips.bend:
        for row in (0, 1):
            mine = at[row * n : row * n + n]
            trials[mine, 2 * n + at[:n]] -= stiffness * bent.by_normal * along[row]
            for other in (0, 1):
                trials[mine, other * n + at[:n]] -= steep * along[row] * along[other]
    matrix = np.zeros((3 * n + 2, 3 * n + 2))
    for row in (0, 1):
        of = slice(row * n, row * n + n)
        for other in (0, 1):
            turned = cut * (float(row == other) - outward[row] * way[other])
            matrix[of] += turned[:, None] * trials[other * n : other * n + n]
        matrix[at[of], 2 * n + np.arange(n)] += coefficient * way[row] * (p > 0)
    matrix[at, at] -= 1.0
    pressed = slice(2 * n, 3 * n)
    matrix[pressed, : 3 * n] = slope[:, None] * signed[2 * n :]
    sinks = slope * np.vstack([along * bent.by_normal, bent.sinking_by_normal])
    matrix[np.tile(2 * n + at[:n], 3), np.arange(3 * n)] -= sinks.ravel()
    matrix[np.arange(2 * n, 3 * n), np.arange(2 * n, 3 * n)] -= 1.0
    matrix[pressed, -2] = slope
    matrix[-2, pressed] = 1.0
    if drive.travel is not None:
        matrix[-1, -1] = 1.0
    else:
        matrix[-1, :n] = 1.0
    return np.concatenate(parts), matrix, slip, sliding


def _elastic(tips: Tips, x: Array) -> float:
    """What is stored, mJ, the curve's part by Simpson's rule in eight parts."""
    n = tips.gap.size
    moved, indentation, bent = _rise(tips, x)
    forces = np.concatenate([x[: 2 * n], -x[2 * n : -2]])
    deep = np.maximum(indentation, 0.0)
    weights = np.array([1, 4, 2, 4, 2, 4, 2, 4, 1]) / 24
    pressed = sum(w * tips.curve(deep * k / 8)[0] * deep for k, w in enumerate(weights))
    across = float((tips.own(x[2 * n : -2]) * (x[:n] ** 2 + x[n : 2 * n] ** 2)).sum())
    return float(np.sum(pressed)) + float(forces @ moved) / 2 + across / 2 + float(bent.stored.sum())
