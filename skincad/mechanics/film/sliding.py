"""A pad condensed to the points that meet the plate, both components, for time stepping with friction.

Small strain, plane strain. One factorisation gives how the contact points move under forces in x and in z,
and one solve a stress how the mean stresses in the films follow from these forces. A mirror-symmetric pad is
solved on its half, even and odd loads apart: the result is mirrored to rounding, at half the price.

Of a section that turns about x = 0 a contact point is a ring. It is pressed evenly all round, and its
friction acts along x all round, with the same force everywhere: Mindlin's assumption (J. Appl. Mech. 16
(1949) 259). So the press is the harmonic 0 of the turn, the pull the harmonic 1 (bodies/harmonics.py), and a
ring slips as one, by the mean of its displacement along x. The plate keeps level: it presses rings harder
behind than ahead, without which they would tilt. Left out are that a ring then slips ahead first, slip across
x, which Mindlin leaves out too, and the friction that spreads outward under the press. References: Mindlin's
sphere, a wall (tests/scenes/test_faces_and_rings.py), solids in three dimensions, bonded by CalculiX
(bench/bonded_rings.py) and with friction by GetFEM (bench/ring_friction.py).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg, sparse

from skincad.base.arrays import Array, Index, Mask
from skincad.base.machine import one_blas_thread
from skincad.mechanics.bodies import elements, film_field, harmonics
from skincad.mechanics.bodies.condense import Condensation, condense
from skincad.mechanics.bodies.film_field import StripBody
from skincad.mechanics.bodies.mesh import PadPiece
from skincad.mechanics.film.fields import WholeState
from skincad.mechanics.film.stick import (
    Half,
    in_strip_axes,
    on_whole,
    points_flexibility,
)
from skincad.mechanics.problem import ContactError, Pad, SizeError

MOST_CONTACT_UNKNOWNS = 4000  # both components; dense blocks of 0.1 GB each
ON_AXIS = 1e-9  # in units; points of the cut at x = 0


@dataclass(frozen=True, eq=False)
class ContactPad:
    """The pad seen by the plate, in mm, N and MPa; m contact points in the order of their x.

    `compliance` `(2 m, 2 m)`: displacements in x, then in z, under forces in x, then in z. `gap` `(m,)` from
    the plate to the points when it first touches; `area` `(m,)` mm2 is what each stands for. `strips`
    `(strips, 3, 2 m)`: mean stress across the film, along it in the section and along y, per N; the strips in
    the order of the section's slots, none where they were not asked. `whole` computes the whole pad's state
    from these forces. `pulled` `(2 m, 2 m)`, of a section that turns: what forces along x, even all round
    their rings, and forces up, which go with the cosine of the angle to x, move along x and up.
    """

    compliance: Array
    gap: Array
    x: Array
    ridge: Index
    area: Array
    strips: Array
    unknowns: int
    whole: WholeState | None = None
    pulled: Array | None = None

    def held_level(self, touches: Mask) -> tuple[Array, Array]:
        """Return what forces along x on all points move along x `(m, m)` mm/N, and which forces up, by the
        cosine, they call forth `(m, m)`, under a plate that keeps level where it `touches` `(m,)`: there the
        pull tilts nothing. Of a section that turns."""
        assert self.pulled is not None
        m, up = touches.size, np.flatnonzero(touches)
        along, tilts, rise = self.pulled[:m, :m], self.pulled[m + up, :m], self.pulled[np.ix_(m + up, m + up)]
        called = np.zeros((m, m))
        try:
            called[up] = -linalg.solve(rise, tilts, assume_a="pos")
        except linalg.LinAlgError:
            raise ContactError("the rise of the contact points is singular") from None
        level = along + tilts.T @ called[up]
        return (level + level.T) / 2, called


@one_blas_thread()
def sliding(piece: PadPiece, mesh: object, order: int, films: bool) -> ContactPad:
    """Return the condensed pad of a netgen mesh of the piece; `films` asks for the strips' stresses.

    Raises SizeError for more contact unknowns than a dense block can hold.
    """
    pad, unit = piece.pad, piece.unit
    curved = elements.curved(mesh, order)
    unknowns = 2 * elements.contact_unknowns(curved, order) * piece.sides
    if unknowns > MOST_CONTACT_UNKNOWNS:
        limit = f"a scene takes at most {MOST_CONTACT_UNKNOWNS} contact unknowns"
        raise SizeError("ridge.count", limit, unknowns, "take fewer ridges")
    body = film_field.body(curved, order, pad.materials, pad.revolved)
    functionals = film_field.average_rows(body, piece) if films else None
    system, points = body.system, whole_points(piece, body)
    compliance = np.zeros((2 * points.x.size, 2 * points.x.size))
    strips = np.zeros((len(piece.whole.section.slots) if films else 0, 3, 2 * points.x.size))
    halves = halves_of(piece, body, points, np.concatenate([system.interior, system.contact]))
    factors = tuple(condense(system.matrix, half.inner, half.contact) for half in halves)
    for half, small in zip(halves, factors, strict=True):
        compliance += points.share * points_flexibility(half.points, small)
        if functionals is not None:
            strips += points.share * _stress_rows(piece, functionals, half, small)
    pulled, m = None, points.x.size
    if pad.revolved:
        moved, small = harmonics.pulled_rings(curved, order, pad.materials)
        at = np.concatenate([points.of, points.of + points.meshed])
        pulled = points_flexibility(moved[at], small) / (pad.young_modulus * piece.along)
        compliance[:m, :m] = pulled[:m, :m] * (pad.young_modulus * piece.along)
    return ContactPad(
        compliance=compliance / (pad.young_modulus * piece.along) + of_ends(piece.whole, points.ridge),
        gap=points.gap,
        x=points.x,
        ridge=points.ridge,
        area=points.area,
        strips=strips / (unit * piece.along),
        unknowns=system.unknowns,
        whole=WholeState(piece, body, halves, factors),
        pulled=pulled,
    )


def of_ends(pad: Pad, ridges: Index) -> Array:
    """Return the compliance `(2 m, 2 m)` mm/N in z that a pad's free ends add to points of these ridges
    `(m,)`."""
    m, more = ridges.size, np.zeros((2 * ridges.size,) * 2)
    if pad.ends:
        at = np.searchsorted(pad.ridges, ridges)
        more[m:, m:] = np.array(pad.ends)[np.ix_(at, at)]
    return more


@dataclass(frozen=True, eq=False)
class WholePoints:
    """The whole pad's contact points, in the order of their `x` `(m,)` mm: `of` is the meshed point of each,
    `left` marks those that mirror one at x > 0, `share` is what of a force the meshed piece bears. `gap` mm
    as in `ContactPad`, `area` mm2 what each stands for, on the cut for both sides, `ridge` its ridge. A point
    on the axis of a turn, of no area, is left out of the `meshed` ones: it bears no force.
    """

    meshed: int
    of: Index
    left: Mask
    share: float
    x: Array
    gap: Array
    area: Array
    ridge: Index

    def spread(self, parity: int) -> sparse.csr_matrix:
        """Matrix `(2 meshed, 2 m)` that gives a piece's forces from the whole pad's.

        Of a mirrored pad the even part is (right + image) / 2, where the image of an x component turns round.
        """
        m, meshed = self.of.size, self.meshed
        if parity == 0:
            both = np.ones(2 * m)
        else:
            # on the axis a force is shared by the halves, elsewhere it is split into even and odd
            both = 0.5 * np.concatenate([np.where(self.left, -parity, 1.0), np.where(self.left, parity, 1.0)])
        index = np.concatenate([self.of, self.of + meshed]), np.arange(2 * m)
        return sparse.csr_matrix((both, index), shape=(2 * meshed, 2 * m))


def whole_points(piece: PadPiece, body: StripBody) -> WholePoints:
    """Return the whole pad's contact points, by those of the piece that is meshed."""
    nodes = body.system.nodes
    x, z = (nodes.position * piece.unit).T
    of = np.argsort(x, kind="stable")
    axis, left = np.abs(x) <= ON_AXIS * piece.unit, np.zeros(x.size, dtype=bool)
    weight, numbers = nodes.weight, np.array(piece.whole.ridges)
    if piece.sides > 1:
        images = of[~axis[of]][::-1]
        of = np.concatenate([images, of])
        left = np.concatenate([np.ones(images.size, dtype=bool), left])
        weight = np.where(axis, 2.0, 1.0) * weight
    if piece.whole.revolved:
        of, left = of[~axis[of]], left[~axis[of]]
    gap, at = piece.whole.top - z, np.searchsorted(numbers, nodes.ridge[of])
    return WholePoints(
        meshed=x.size,
        of=of,
        left=left,
        share=1 / piece.sides,
        x=np.where(left, -x[of], x[of]),
        gap=(gap - gap.min())[of],
        area=weight[of] * piece.unit * piece.along,
        ridge=numbers[np.where(left, numbers.size - 1 - at, at)],  # the image of the last is the first
    )


def halves_of(piece: PadPiece, body: StripBody, points: WholePoints, free: Index) -> tuple[Half, ...]:
    """Return the loads to solve apart, of a whole pad one; `free` numbers what is not clamped of the
    unknowns. Of a section that turns it is the press: points then move along z alone."""
    held, turns = {0: np.empty(0, np.int64)}, piece.whole.revolved
    if piece.mirrored:
        held = {0: body.on_cut[0]} if turns else {1: body.on_cut[0], -1: body.on_cut[1]}
    halves = []
    for parity, fixed in held.items():
        contact = np.setdiff1d(body.system.contact if turns else body.contact, fixed)
        moves = np.zeros(body.points.shape[1])
        moves[contact] = 1.0  # what is held on the cut does not move, so that no force on it counts
        at = points.spread(parity).T / points.share @ body.points @ sparse.diags(moves)
        inner = np.setdiff1d(free, np.concatenate([contact, fixed]))
        halves.append(Half(parity, sparse.csr_matrix(at), inner, contact))
    return tuple(halves)


def _stress_rows(piece: PadPiece, functionals: Array, half: Half, small: Condensation) -> Array:
    """Stresses `(strips of the whole, 3, 2 m)` across, along and lengthwise per displacement that a unit
    force at the points brings."""
    sides = in_strip_axes(functionals, piece.slots).reshape(-1, functionals.shape[2]).T
    per_force = np.asarray(half.points @ small.solve(sides)).T
    whole = on_whole(piece, per_force.reshape(functionals.shape[0], -1), half.parity)
    return whole.reshape(len(whole), 3, -1)
