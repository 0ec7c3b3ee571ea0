"""A pad's slowest modes: its masses beside the compliance of its contact points.

Contact points move by their static compliance under the plate's forces, and besides by how far each slow mode
is from where these forces would hold it: u = C f + sum_k b_k (q_k - b_k f / w_k^2), with q_k'' + d_k q_k' +
w_k^2 q_k = b_k f. Faster modes follow at once. That is the mode acceleration method: Williams, Aeronautical
Quarterly 1 (1949) 123; Craig and Kurdila, Fundamentals of Structural Dynamics, sec. 11.4. What is left of C
without the slow modes is positive definite, so the points touch without mass and do not chatter.

A mode is advanced exactly for a force that is straight in time. Contact makes that stable while the modes
held at all points would swing less than about half a turn a step; `resolved` keeps the slow ones that do.

Modes are damped as a Kelvin-Voigt solid of the assumed retardation time damps them, d_k = tau w_k^2.
Reference: the pad with all its masses (tests/mechanics/dynamics/test_ringing.py, bench/leads.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from skincad.base.arrays import Array, Index
from skincad.base.machine import one_blas_thread
from skincad.mechanics.bodies.mesh import PadPiece
from skincad.mechanics.dynamics.pad import linear
from skincad.mechanics.dynamics.ringing import RETARDATION
from skincad.mechanics.dynamics.steps import PadEquations
from skincad.mechanics.film.stick import Half

FEWEST, MOST = 20, 160  # modes sought of a half
HIGHEST = 1 / RETARDATION  # rad/s; what swings faster is damped within a swing
STABLE = 3.0  # rad a step, of the fastest swing with all points held; 12^(1/2) is the limit


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of the whole pad, of unit mass in tonne: angular `frequency` `(r,)` rad/s; displacement of the
    contact points in x, then in z, `points` `(2 m, r)`; the strips' stresses `(strips, 3, r)` MPa. `x` mm and
    `ridge` `(m,)` are the contact points'. By parity, of the mesh that they were found on, `shapes`: which
    modes, and their displacements `(n, modes)`."""

    frequency: Array
    points: Array
    strips: Array
    x: Array
    ridge: Index
    shapes: tuple[tuple[Index, Array], ...] = ()

    @property
    def damping(self) -> Array:
        """What a mode loses per speed `(r,)`, 1/s."""
        return RETARDATION * self.frequency**2

    @property
    def compliance(self) -> Array:
        """Their part of the static compliance of the points `(2 m, 2 m)`, mm/N."""
        return np.asarray((self.points / self.frequency**2) @ self.points.T)

    @property
    def coarser(self) -> Modes:
        """The slower half of them, to tell what the faster ones change."""
        return self.first((self.frequency.size + 1) // 2)

    def first(self, count: int) -> Modes:
        """Return the slowest of them."""
        return replace(
            self,
            frequency=self.frequency[:count],
            points=self.points[:, :count],
            strips=self.strips[:, :, :count],
            shapes=tuple((of[of < count], shape[:, of < count]) for of, shape in self.shapes),
        )


def slow_modes(
    piece: PadPiece, mesh: object, order: int, films: bool, x: Array, ridge: Index, dt: float = 0.0
) -> Modes:
    """Return the modes of a meshed piece up to HIGHEST that a step of `dt` s can advance, the slowest first;
    `x` mm and `ridge` `(m,)` are those of its contact points.

    Points that are held make no mode slower, so what is faster than STABLE a step is not looked for. Raises
    SizeError as `linear` does.
    """
    equations = linear(piece, mesh, order, films)
    with one_blas_thread():
        highest = min(HIGHEST, STABLE / dt) if dt else HIGHEST
        by_half = [(half, *_of_half(equations, half, highest)) for half in equations.halves]
    frequency = np.concatenate([f for _, f, _ in by_half])
    slowest = np.argsort(frequency, kind="stable")
    points = np.hstack([half.points @ shape for half, _, shape in by_half])
    strips = zip(equations.strips, by_half, strict=True)
    stress = np.hstack([slow @ shape for (slow, _), (_, _, shape) in strips])
    ends = np.cumsum([f.size for _, f, _ in by_half])[:-1]
    places = np.split(np.argsort(slowest), ends)
    return Modes(
        frequency=frequency[slowest],
        points=points[:, slowest],
        strips=stress[:, slowest].reshape(stress.shape[0] // 3, 3, slowest.size),
        x=x,
        ridge=ridge,
        shapes=tuple((of, shape) for of, (_, _, shape) in zip(places, by_half, strict=True)),
    )


def _of_half(equations: PadEquations, half: Half, highest: float) -> tuple[Array, Array]:
    """Frequencies `(r,)` up to `highest` rad/s and shapes `(n, r)` of a part, of unit mass in the pad."""
    free = np.sort(np.concatenate([half.inner, half.contact]))
    stiff, mass = (sparse.csc_matrix(matrix[free][:, free]) for matrix in (equations.stiff, equations.mass))
    factors = splu(stiff, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    inverse = LinearOperator(stiff.shape, matvec=factors.solve, dtype=float)
    start = np.ones(free.size)  # the same each time
    count = FEWEST
    while True:
        squares, shapes = eigsh(stiff, count, mass, sigma=0.0, OPinv=inverse, v0=start)
        most = min(MOST, free.size // 2)
        if squares.max() >= highest**2 or count >= most:
            break
        # of a plane body about as many modes lie below a frequency as its square says (Weyl), rather fewer
        count = min(most, math.ceil(count * highest**2 / float(squares.max())))
    slow = squares <= highest**2
    whole = np.zeros((equations.stiff.shape[0], int(slow.sum())))
    whole[free] = shapes[:, slow] * np.sqrt(equations.share)
    return np.sqrt(squares[slow]), whole


def at_points(modes: Modes, x: Array, ridge: Index) -> Modes:
    """Return modes at the contact points of another mesh, at `x` mm of their `ridge` `(m,)`: straight between
    those that they are known at."""
    if np.array_equal(x, modes.x):
        return modes
    known, wanted = modes.x.size, x.size
    points = np.zeros((2 * wanted, modes.frequency.size))
    for number in np.unique(ridge):
        here, there = np.flatnonzero(ridge == number), np.flatnonzero(modes.ridge == number)
        for to, of in ((here, there), (here + wanted, there + known)):
            shapes = modes.points[of]
            points[to] = np.stack([np.interp(x[here], modes.x[there], s) for s in shapes.T], axis=1)
    return replace(modes, points=points, x=x, ridge=ridge, shapes=())


def resolved(modes: Modes, compliance: Array, dt: float) -> Modes:
    """Return the slowest modes of which the rest of the compliance is positive definite and which a step of
    `dt` s, with contact, advances stably: none where even the first does not."""
    count = modes.frequency.size
    while count:
        slow = modes.first(count)
        rest = compliance - slow.compliance
        try:
            factors = linalg.cho_factor(rest, lower=True)
        except linalg.LinAlgError:
            count -= 1
            continue
        held = slow.points.T @ linalg.cho_solve(factors, slow.points)
        held[np.diag_indices(count)] += slow.frequency**2
        if float(np.linalg.eigvalsh(held)[-1]) * dt**2 <= STABLE**2:
            break
        count = min(count - 1, int(0.9 * count))
    return modes.first(count)


class ModeStep(NamedTuple):
    """A step of the modes. Place and speed `(2,)` after it are `stays` `(r, 2, 2)` times those before, plus
    `start` and `end` `(r, 2)` times the force at its start and end. `compliance` `(2 m, 2 m)` mm/N is what it
    adds to the points' static one."""

    stays: Array
    start: Array
    end: Array
    compliance: Array


def mode_step(modes: Modes, dt: float) -> ModeStep:
    """Return the exact step of `dt` s for forces straight in time."""
    count = modes.frequency.size
    stays, before, after = np.zeros((count, 2, 2)), np.zeros((count, 2)), np.zeros((count, 2))
    for k, (w, d) in enumerate(zip(modes.frequency, modes.damping, strict=True)):
        a = np.zeros((4, 4))
        a[0, 1], a[1, 0], a[1, 1], a[1, 2], a[2, 3] = 1.0, -w * w, -d, 1.0, 1.0
        whole = linalg.expm(a * dt)
        stays[k], rise = whole[:2, :2], whole[:2, 3] / dt
        before[k], after[k] = whole[:2, 2] - rise, rise
    more = (modes.points * (after[:, 0] - modes.frequency**-2)) @ modes.points.T
    return ModeStep(stays, before, after, (more + more.T) / 2)
