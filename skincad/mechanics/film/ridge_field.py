"""The stress field of one ridge in its deformed section, to be drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array, Index, Mask
from skincad.mechanics.bodies import strip_field
from skincad.mechanics.bodies.strip_field import Patch
from skincad.mechanics.film.stick import LoadState, PadPiece, StickSolution

REACH = 2.2  # of the unit, a ridge's contact length: the ridge, its root and what is under it


@dataclass(frozen=True, eq=False)
class RidgeField:
    """A ridge and what is around it: `place` and `shift` `(p, 2)` mm, `stress` `(p,)` MPa across the ridge,
    from one strip's middle towards the other's, `triangles` `(t, 3)` of the points, `film` `(t,)` the film's.
    `middle` mm is the place half-way between the two strips.
    """

    ridge: int
    middle: tuple[float, float]
    place: Array
    shift: Array
    stress: Array
    triangles: Index
    film: Mask


def ridge_field(piece: PadPiece, solution: StickSolution, ridge: int, tangential: float) -> RidgeField:
    """Return the field around a ridge with both strips, under the normal force and `tangential` N."""
    push = _around(piece, solution, ridge, solution.normal_state, 1)
    shift, stress = push.shift, push.stress
    if solution.pull_state is not None and tangential:
        pull = _around(piece, solution, ridge, solution.pull_state, -1)
        shift, stress = shift + tangential * pull.shift, stress + tangential * pull.stress
    x, z = _across(piece, ridge)
    xx, xz, zz, _ = stress.T * piece.pad.young_modulus
    first, second = _middles(piece, ridge)
    return RidgeField(
        ridge,
        ((first[0] + second[0]) / 2, (first[1] + second[1]) / 2),
        push.place * piece.unit,
        shift * piece.unit,
        xx * x * x + 2 * xz * x * z + zz * z * z,
        push.triangles,
        push.film,
    )


def _middles(piece: PadPiece, ridge: int) -> Array:
    return np.array([slot.centre for slot in piece.whole.section.slots if slot.feature == ridge])


def _across(piece: PadPiece, ridge: int) -> Array:
    """Unit vector from a ridge's first strip to its second."""
    first, second = _middles(piece, ridge)
    return np.asarray((second - first) / np.hypot(*(second - first)))


def _around(piece: PadPiece, solution: StickSolution, ridge: int, state: LoadState, parity: int) -> Patch:
    """The field around a ridge, in units; of a half, what lies at x < 0 is the mirror image of x > 0."""
    strip_field.set_state(solution.body, state.displacement)
    x, z = _middles(piece, ridge).mean(axis=0) / piece.unit
    here = strip_field.field(solution.body, (x, z), REACH)
    if not piece.mirrored:
        return here
    return joined(here, as_image(strip_field.field(solution.body, (-x, z), REACH), parity))


def joined(one: Patch, other: Patch) -> Patch:
    """Return both pieces as one."""
    return Patch(
        np.concatenate([one.place, other.place]),
        np.concatenate([one.shift, other.shift]),
        np.concatenate([one.stress, other.stress]),
        np.concatenate([one.triangles, other.triangles + len(one.place)]),
        np.concatenate([one.film, other.film]),
    )


def as_image(patch: Patch, parity: int) -> Patch:
    """Return the mirror image about x = 0 of a piece, its state even (1) or odd (-1)."""
    return Patch(
        patch.place * [-1, 1],
        parity * patch.shift * [-1, 1],
        parity * patch.stress * [1, -1, 1, 1],
        patch.triangles,
        patch.film,
    )
