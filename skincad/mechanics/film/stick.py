"""Full stick: the linear pad whose touching points move with the plate.

First the plate presses without friction, as in the linear model. Then every point that carries load is bonded
to it, and it moves without turning until the tangential force is there and the normal force as before. What
sticks, and how much shear it has locked in, depends on the path: this is the path press, then pull.

A mirror-symmetric pad is solved on its half at x >= 0: pressing is even in x (u_x = 0 on the cut), pulling
odd (u_z = 0 on the cut). That is the solution on a mesh mirrored about x = 0, at half the price.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy import linalg, optimize, sparse

from skincad.base.arrays import Array, Index, Mask
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Stopwatch
from skincad.mechanics.bodies import elements, film_field
from skincad.mechanics.bodies.condense import Condensation, condense
from skincad.mechanics.bodies.film_field import StripBody
from skincad.mechanics.bodies.mesh import PadPiece
from skincad.mechanics.contact.frictionless import press
from skincad.mechanics.problem import ContactError, check_balance, rise
from skincad.shape.curves import Segment
from skincad.shape.feature import SensorPlace

CENTRE_TOLERANCE = 1e-9  # of the pad's width; centres of mirrored strips agree to that


@dataclass(frozen=True, eq=False)
class Half:
    """One of the one or two parts of a pad's equations, split by symmetry: `parity` is 1 for even loads of a
    mirrored pad, -1 for odd ones, 0 of a whole one.

    `points` `(2 m, n)`: displacements of the whole pad's contact points, in x, then in z, by the piece's
    unknowns. `inner` and `contact` number the free unknowns.
    """

    parity: int
    points: sparse.csr_matrix
    inner: Index
    contact: Index


@dataclass(frozen=True)
class LoadState:
    """The whole pad's state under a load.

    `strips` `(strips, 3)`: mean stress across a film, along it in the section and along y, in the order
    of the section's slots. `normal` and `tangential` `(ridges,)`: the plate's force on each ridge, positive
    in compression and to +x. `node` `(sides, m)`: compressive force at the meshed contact points and, of a
    mirrored pad, at their images. `displacement` `(sides, n)`: the condensed unknowns, likewise.
    """

    strips: Array
    normal: Array
    tangential: Array
    node: Array
    displacement: Array

    def plus(self, other: LoadState, factor: float) -> LoadState:
        """Return the state under this load and `factor` times another's."""
        return LoadState(**{key: part + factor * getattr(other, key) for key, part in vars(self).items()})


@dataclass(frozen=True)
class StickSolution:
    """`normal_state` at the normal force, in MPa and N; `pull_state` the change by 1 N of tangential force,
    in MPa / N and 1, or None if not requested. `bonded` `(m,)` marks the meshed contact points that stick."""

    piece: PadPiece
    normal_state: LoadState
    pull_state: LoadState | None
    bonded: Mask
    unknowns: int
    residual: float
    seconds: dict[str, float]
    body: StripBody

    def under(self, tangential: float) -> LoadState:
        """Return the state under the normal force and `tangential` N."""
        return self.normal_state.plus(self.pull_state, tangential) if self.pull_state else self.normal_state


@one_blas_thread()
def level(piece: PadPiece, mesh: object, order: int, force: float, pull: bool) -> StickSolution:
    """Solve one order on netgen's mesh of the piece: pressed by `force` N, and pulled if asked."""
    watch, balance = Stopwatch(), 0.0
    with watch.stage("assemble"):
        body = film_field.body(elements.curved(mesh, order), order, piece.pad.materials)
    with watch.stage("condense"):
        symmetric, antisymmetric = body.on_cut if piece.mirrored else (np.empty(0, np.int64),) * 2
        small = condensed_piece(body, symmetric)
        small_odd = condensed_piece(body, antisymmetric) if piece.mirrored and pull else small
    with watch.stage("contact"):
        push_state, bonded, residual = press_state(piece, body, small, force)
        pull_state = None
        if pull:  # the bonded points moved as one until the plate's tangential force is 1 N
            load = pull_load(piece, body, small_odd, bonded)
            moved, wanted = small_odd.solve(body.points.T @ load), np.array([1.0, 0.0]) / piece.scale
            balance = _balance(body, moved, wanted, 0 if piece.mirrored else None)
            pull_state = load_state(piece, body, moved, load, -1)
    return StickSolution(
        piece=piece,
        normal_state=push_state,
        pull_state=pull_state,
        bonded=bonded,
        unknowns=body.system.unknowns,
        residual=max(residual, balance),
        seconds=watch.stages,
        body=body,
    )


def condensed_piece(body: StripBody, fixed: Index) -> Condensation:
    """Factorise with the contact unknowns of both directions last, those in `fixed` left out."""
    system = body.system
    contact = np.setdiff1d(body.contact, fixed)
    free = np.concatenate([system.interior, system.contact])
    return condense(system.matrix, np.setdiff1d(free, np.concatenate([contact, fixed])), contact)


def points_flexibility(points: sparse.csr_matrix, small: Condensation) -> Array:
    """Return displacements under forces, both at points whose displacements are `points` `(m, n)` times the
    unknowns', `(m, m)`: symmetric to the last digit."""
    at = points[:, small.order[-len(small.flexibility) :]]
    flexibility = at @ np.asarray(at @ small.flexibility).T
    return np.asarray((flexibility + flexibility.T) / 2)


def press_state(
    piece: PadPiece, body: StripBody, small: Condensation, force: float
) -> tuple[LoadState, Mask, float]:
    """Return the state under a frictionless plate's force, N, which points bear load, and the residual."""
    nodes, unit, plate = body.system.nodes, piece.unit, piece.whole.plate
    m = nodes.weight.size
    x, z = nodes.position.T
    gap = (piece.whole.top / unit - z) + rise(plate, x * unit) / unit
    wanted = force / piece.scale
    contact = press(points_flexibility(body.points[m:], small), gap - gap.min(), wanted)
    load = np.concatenate([np.zeros(m), -contact.force])
    moved = small.solve(body.points.T @ load)
    balance = _balance(body, moved, np.array([0.0, -wanted]), 1 if piece.mirrored else None)
    state = load_state(piece, body, moved, load, 1)
    return state, contact.force > 0, max(contact.residual, balance)


def pull_load(piece: PadPiece, body: StripBody, small: Condensation, bonded: Mask) -> Array:
    """Return forces `(2 m,)`, in x then in z, that move the bonded points as one until the plate's tangential
    force is 1 N, its normal one unchanged.

    C p = M a and M^T p = (force, 0): M has the plate's translations in x and z, of a mirrored pad in x only.
    """
    m = bonded.size
    flexibility = points_flexibility(body.points, small)
    sticking = np.flatnonzero(np.tile(bonded, 2) & (np.diag(flexibility) > 0))  # z on the cut is not free
    modes = np.column_stack([sticking < m, sticking >= m]).astype(float)[:, : 1 if piece.mirrored else 2]
    try:
        by_mode = linalg.solve(flexibility[np.ix_(sticking, sticking)], modes, assume_a="pos")
    except linalg.LinAlgError:
        raise ContactError("the bonded flexibility is singular; take a coarser contact mesh") from None
    wanted = np.array([1.0, 0.0]) / piece.scale
    load = np.zeros(2 * m)
    load[sticking] = by_mode @ np.linalg.solve(modes.T @ by_mode, wanted[: modes.shape[1]])
    return load


def _balance(body: StripBody, moved: Array, force: Array, only: int | None) -> float:
    """Largest difference, relative to the force `(2,)`, between the plate's force and the clamped back's.

    On a half, `only` one direction is: the cut carries the other.
    """
    system = body.system
    clamped = system.lift.copy()
    clamped[system.interior] = clamped[system.contact] = 0.0
    reaction = system.matrix @ moved
    shift = int(system.contact[0] - body.along_x[0])
    carried = np.array([np.roll(clamped, -shift) @ reaction, clamped @ reaction])
    wrong = np.abs(carried + force) / np.abs(force).max()
    return check_balance(float(wrong.max() if only is None else wrong[only]))


def load_state(piece: PadPiece, body: StripBody, moved: Array, load: Array, parity: int) -> LoadState:
    """Return the whole pad's state for displacements `(n,)` under forces `(2 m,)` on the piece."""
    film_field.set_state(body, moved)
    stress = film_field.averages(body, piece) * piece.pad.young_modulus
    nodes, force = body.system.nodes, load * piece.scale / piece.sides
    m = nodes.weight.size
    numbers = piece.whole.ridges
    at = np.searchsorted(numbers, nodes.ridge)
    pull, push = (np.bincount(at, part, len(numbers)).astype(np.float64) for part in (force[:m], -force[m:]))
    if piece.mirrored:  # pressing mirrors the force in z and turns the one in x; pulling the other way round
        push, pull = push + parity * push[::-1], pull - parity * pull[::-1]
    strips = on_whole(piece, in_strip_axes(stress, piece.slots), parity)
    sides = np.array([1.0, parity]) if piece.mirrored else np.ones(1)
    return LoadState(strips, push, pull, np.outer(sides, -force[m:]), np.outer(sides, moved))


def in_strip_axes(stress: Array, slots: Sequence[SensorPlace]) -> Array:
    """Stresses xx, xz, zz, yy `(strips, 4, ...)` as across, along the strip in the section, along y."""
    turn = np.zeros((len(slots), 3, 4))
    for i, axes in enumerate((np.array([s.normal for s in slots]), np.array([s.direction for s in slots]))):
        x, z = axes.T
        turn[:, i, :3] = np.column_stack([x * x, 2 * x * z, z * z])
    turn[:, 2, 3] = 1.0
    return np.asarray(np.einsum("sij,sj...->si...", turn, stress))


def on_whole(piece: PadPiece, values: Array, parity: int) -> Array:
    """Values of all strips: those of the half and, times the parity, their mirror images'."""
    if not piece.mirrored:
        return values
    here = np.array([s.centre for s in piece.slots])
    whole = np.array([s.centre for s in piece.whole.section.slots])
    result = np.empty((len(whole), values.shape[1]))
    for i, centre in enumerate(whole):
        mirrored = centre[0] < 0
        away = np.hypot(*(here - [abs(centre[0]), centre[1]]).T)
        j = int(away.argmin())
        if away[j] > CENTRE_TOLERANCE * np.ptp(whole[:, 0]):
            raise ContactError("a strip has no mirror image")
        result[i] = values[j] * (parity if mirrored else 1)
    return result


def with_fine_edges(piece: PadPiece, solution: StickSolution) -> PadPiece:
    """Return the piece with its crowns cut around where contact ends in `solution`.

    Full stick has its largest shear at the contact's edges, so its answer is wrong by how far they lie off:
    the last sticking and the first clear point are a step apart. The new pieces are a step long, the mesh's
    edges on them half of that.
    """
    nodes = solution.body.system.nodes
    x = nodes.position[:, 0] * piece.unit
    cuts: dict[int, list[float]] = {}
    for ridge in piece.pad.ridges:
        mine = np.flatnonzero(nodes.ridge == ridge)
        mine = mine[np.argsort(x[mine])]
        for a, b in pairwise(mine):
            if solution.bonded[a] != solution.bonded[b]:
                middle, step = (x[a] + x[b]) / 2, x[b] - x[a]
                cuts.setdefault(ridge, []).extend([middle - step, middle, middle + step])
    outline = tuple(
        piece
        for s in piece.pad.section.outline
        for piece in (cut_at(s, cuts.get(s.feature or 0, [])) if s.touches else (s,))
    )
    return replace(piece, pad=replace(piece.pad, section=replace(piece.pad.section, outline=outline)))


def cut_at(segment: Segment, at: Sequence[float]) -> Iterator[Segment]:
    """Yield the segment's pieces between these x, mm; it must not turn back in x."""
    low, high = sorted((segment.start.x, segment.end.x))
    inside = [x for x in at if low < x < high]
    roots = [optimize.brentq(lambda t, x=x: segment.point(t).x - x, 0.0, 1.0, xtol=1e-12) for x in inside]
    shares = np.array([0.0, *sorted(roots), 1.0])
    points = [segment.start, *(segment.point(f) for f in shares[1:-1]), segment.end]
    for a, b, share in zip(points, points[1:], np.diff(shares), strict=False):
        yield replace(segment, start=a, end=b, bulge=math.tan(segment.sweep * share / 4))
