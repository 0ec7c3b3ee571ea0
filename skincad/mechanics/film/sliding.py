"""A pad condensed to the points that meet the plate, both components, for time stepping with friction.

Small strain, plane strain. One factorisation gives how the contact points move under forces in x and in z,
and one solve a stress how the mean stresses in the films follow from these forces. A mirror-symmetric pad is
solved on its half, even and odd loads apart: the result is mirrored to rounding, at half the price.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from skincad.base.arrays import Array, Index, Mask
from skincad.base.machine import one_blas_thread
from skincad.mechanics.bodies import elements, film_field
from skincad.mechanics.bodies.condense import Condensation
from skincad.mechanics.bodies.film_field import StripBody
from skincad.mechanics.film.fields import Parity, WholeState
from skincad.mechanics.film.stick import PadPiece, condensed_piece, contact_rows, in_strip_axes, on_whole
from skincad.mechanics.problem import Pad, SizeError

MOST_CONTACT_UNKNOWNS = 4000  # both components; dense blocks of 0.1 GB each
ON_AXIS = 1e-9  # in units; points of the cut at x = 0


@dataclass(frozen=True, eq=False)
class ContactPad:
    """The pad seen by the plate, in mm, N and MPa; m contact points in the order of their x.

    `compliance` `(2 m, 2 m)`: displacements in x, then in z, under forces in x, then in z. `gap` `(m,)` from
    the plate to the points when it first touches. `strips` `(strips, 3, 2 m)`: mean stress across the film,
    along it in the section and along y, per N; the strips in the order of the section's slots, none where
    they were not asked. `whole` computes the whole pad's state from these forces.
    """

    compliance: Array
    gap: Array
    x: Array
    ridge: Index
    weight: Array
    strips: Array
    unknowns: int
    whole: WholeState | None = None
    length: float = 1.0  # mm, of the pad along y

    @property
    def area(self) -> Array:
        """What each contact point stands for `(m,)`, mm2."""
        return self.weight * self.length


def sliding(piece: PadPiece, mesh: object, order: int, films: bool) -> ContactPad:
    """Return the condensed pad of a netgen mesh of the piece; `films` asks for the strips' stresses.

    Raises SizeError for more contact unknowns than a dense block can hold.
    """
    with one_blas_thread():
        return _sliding(piece, mesh, order, films)


def _sliding(piece: PadPiece, mesh: object, order: int, films: bool) -> ContactPad:
    pad, unit = piece.pad, piece.unit
    curved = elements.curved(mesh, order)
    unknowns = 2 * elements.contact_unknowns(curved, order) * (2 if piece.mirrored else 1)
    if unknowns > MOST_CONTACT_UNKNOWNS:
        limit = f"a scene takes at most {MOST_CONTACT_UNKNOWNS} contact unknowns"
        raise SizeError("ridge.count", limit, unknowns, "take fewer ridges")
    body = film_field.body(curved, order, pad.materials)
    functionals = (
        film_field.average_rows(body, pad.materials, piece.slots, piece.thickness, unit) if films else None
    )
    nodes = body.system.nodes
    x, z = (nodes.position * unit).T
    lay = layout(x, piece.mirrored, ON_AXIS * unit)
    compliance = np.zeros((2 * lay.of.size, 2 * lay.of.size))
    strips = np.zeros((len(piece.whole.section.slots) if films else 0, 3, 2 * lay.of.size))
    solved = []
    for parity, fixed in parities(piece, body):
        small = condensed_piece(body, fixed)
        rows, spread = contact_rows(body, small), lay.spread(parity)
        solved.append(Parity(small, rows, spread))
        half_compliance = rows @ np.asarray(rows @ small.flexibility).T
        compliance += (
            spread.T @ np.asarray(spread.T @ (half_compliance + half_compliance.T)).T / (2 * lay.share)
        )
        if functionals is not None:
            stress = _stress_rows(piece, functionals, small, rows, parity)
            strips += np.asarray((stress.reshape(-1, rows.shape[0]) @ spread).reshape(strips.shape))
    per_force = 1 / (pad.young_modulus * pad.length)  # mm of the piece per N on it, of a unit length each
    gap = (piece.whole.top - z)[lay.of]
    ridges = ridges_of(piece, nodes.ridge[lay.of], lay.left)
    return ContactPad(
        compliance=compliance * per_force + of_ends(piece.whole, ridges),
        gap=gap - gap.min(),
        x=np.where(lay.left, -x[lay.of], x[lay.of]),
        ridge=ridges,
        weight=lay.weight(nodes.weight) * unit,
        strips=strips / (unit * pad.length),
        unknowns=body.system.unknowns,
        whole=WholeState(piece, body, tuple(solved)),
        length=pad.length,
    )


def of_ends(pad: Pad, ridges: Index) -> Array:
    """Return the compliance `(2 m, 2 m)` mm/N in z that a pad's free ends add to points of these ridges
    `(m,)`."""
    m, more = ridges.size, np.zeros((2 * ridges.size,) * 2)
    if pad.ends:
        at = np.searchsorted(pad.ridges, ridges)
        more[m:, m:] = np.array(pad.ends)[np.ix_(at, at)]
    return more


def ridges_of(piece: PadPiece, meshed: Index, left: Mask) -> Index:
    """Ridge of each point `(m,)` from that of its meshed point: the image of the last is the first."""
    numbers = np.array(piece.whole.ridges)
    at = np.searchsorted(numbers, meshed)
    return np.asarray(numbers[np.where(left, numbers.size - 1 - at, at)])


def parities(piece: PadPiece, body: StripBody) -> Iterator[tuple[int, Index]]:
    """The loads to solve apart and the unknowns each holds on the cut: 1 even, -1 odd, 0 a whole pad."""
    if not piece.mirrored:
        yield 0, np.empty(0, np.int64)
        return
    yield 1, body.on_cut[0]
    yield -1, body.on_cut[1]


@dataclass(frozen=True)
class WholePoints:
    """The whole pad's points: `of` `(m,)` is the meshed point of each, `left` those that mirror one at x > 0,
    `axis` those on the cut; `share` is what of a force the meshed piece bears."""

    of: Index
    left: Mask
    axis: Mask
    share: float

    def weight(self, meshed: Array) -> Array:
        """What the whole pad's points stand for `(m,)`, by what the meshed ones do: on the cut for both
        sides."""
        return np.asarray(meshed[self.of] * np.where(self.axis & (self.share < 1.0), 2.0, 1.0))

    def spread(self, parity: int) -> sparse.csr_matrix:
        """Matrix `(2 meshed, 2 m)` that gives a piece's forces from the whole pad's.

        Of a mirrored pad the even part is (right + image) / 2, where the image of an x component turns round.
        """
        m, meshed = self.of.size, int(self.of.max()) + 1
        if parity == 0:
            one = np.ones(m)
            both = np.concatenate([one, one])
        else:
            # on the axis a force is shared by the halves, elsewhere it is split into even and odd
            both = 0.5 * np.concatenate([np.where(self.left, -parity, 1.0), np.where(self.left, parity, 1.0)])
        index = np.concatenate([self.of, self.of + meshed]), np.arange(2 * m)
        return sparse.csr_matrix((both, index), shape=(2 * meshed, 2 * m))


def layout(x: Array, mirrored: bool, tolerance: float) -> WholePoints:
    """Return the whole pad's points by x `(meshed,)`; those within `tolerance` of 0 are on the cut, mm."""
    order = np.argsort(x, kind="stable")
    axis = np.abs(x) <= tolerance
    if not mirrored:
        return WholePoints(order, np.zeros(x.size, dtype=bool), axis[order], 1.0)
    images = order[~axis[order]][::-1]
    of = np.concatenate([images, order])
    left = np.concatenate([np.ones(images.size, dtype=bool), np.zeros(order.size, dtype=bool)])
    return WholePoints(of, left, axis[of], 0.5)


def _stress_rows(
    piece: PadPiece, functionals: Array, small: Condensation, rows: sparse.csr_matrix, parity: int
) -> Array:
    """Stresses `(strips of the whole, 3, 2 meshed)` across, along and lengthwise per force on the piece."""
    last = small.order[-small.flexibility.shape[0] :]
    sides = in_strip_axes(functionals, piece.slots).reshape(-1, functionals.shape[2]).T
    free = np.zeros_like(sides)
    free[small.order] = sides[small.order]
    per_force = (rows @ small.solve(free)[last]).T
    whole = on_whole(piece, per_force.reshape(functionals.shape[0], -1), parity or 1)
    return whole.reshape(len(whole), 3, -1)
