"""Displacement and stress of a linear pad, of one ridge alone and of the whole, by mirror-symmetric parts.

The whole pad under given forces at its contact points: its field to draw, and undetected contacts. A state
takes one solve with the factorisation that condensed the pad, of a mirrored pad one for each parity.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.bodies import elements, film_field
from skincad.mechanics.bodies.condense import Condensation
from skincad.mechanics.bodies.film_field import Patch, StripBody
from skincad.mechanics.bodies.mesh import PadPiece
from skincad.mechanics.bodies.plane_body import undetected_contact
from skincad.mechanics.film.stick import Half, StickSolution

PIECES = 2  # a triangle's edge around a ridge is drawn in so many
REACH = 2.2  # of the unit, a ridge's contact length: the ridge, its root and what is under it


@dataclass(frozen=True, eq=False)
class RidgeField(Patch):
    """A ridge and what is around it, in mm and MPa; `stress` `(p,)` is that across the ridge, from one
    strip's middle towards the other's. `middle` mm is the place half-way between the two strips.
    """

    ridge: int
    middle: tuple[float, float]


def ridge_field(solution: StickSolution, ridge: int, tangential: float) -> RidgeField:
    """Return the field around a ridge with both strips, under the normal force and `tangential` N."""
    piece, state = solution.piece, solution.under(tangential)
    first, second = np.array([slot.centre for slot in piece.whole.section.slots if slot.feature == ridge])
    x, z = (second - first) / np.hypot(*(second - first))
    middle = (first + second) / 2
    patch = _patch(piece, solution.body, state.displacement, middle / piece.unit, REACH, PIECES)
    xx, xz, zz, _ = patch.stress.T
    across = replace(patch, stress=xx * x * x + 2 * xz * x * z + zz * z * z)
    return RidgeField(**vars(across), ridge=ridge, middle=(float(middle[0]), float(middle[1])))


def _patch(
    piece: PadPiece, body: StripBody, moved: Iterable[Array], centre: Array, reach: float, cuts: int
) -> Patch:
    """The state within `reach` of `centre`, both in units, in mm and MPa; `moved` as in `collision`, `cuts`
    as in `film_field.field`."""
    patches, unit, modulus = [], piece.unit, piece.pad.young_modulus
    for way, displacement in zip((1, -1), moved, strict=False):
        film_field.set_state(body, displacement)
        patches.append(film_field.field(body, centre * [way, 1], reach, cuts))
    here = patches[0]
    if len(patches) > 1:
        image = patches[1]  # about x = 0, drawn where the piece is
        turned = image.place * [-1, 1], image.shift * [-1, 1], image.stress * [1, -1, 1, 1]
        rest = image.triangles + len(here.place), image.film
        both = zip(vars(here).values(), (*turned, *rest), strict=True)
        here = Patch(*(np.concatenate(pair) for pair in both))
    return replace(here, place=here.place * unit, shift=here.shift * unit, stress=here.stress * modulus)


@dataclass(frozen=True, eq=False)
class DeformedSection(Patch):
    """The deformed section, in mm and MPa. The plate is the line through (0, `plate`) mm at `angle` rad."""

    plate: float
    angle: float


@dataclass(frozen=True, eq=False)
class WholeState:
    """Computes the whole pad's state from the forces at its contact points; `factors` are of each half."""

    piece: PadPiece
    body: StripBody
    halves: tuple[Half, ...]
    factors: tuple[Condensation, ...]

    def deformed_section(self, force: Array, plate: float, angle: float) -> DeformedSection:
        """Return the field under forces `(2 m,)` N in x, then in z, below a plate at (0, `plate`) mm."""
        patch = _patch(self.piece, self.body, self.moved(force), np.zeros(2), math.inf, 1)
        return DeformedSection(**vars(patch), plate=plate, angle=angle)

    def moved(self, force: Array, besides: Sequence[Array] = ()) -> list[Array]:
        """Return the displacements `(n,)` of the piece, in units; of a mirrored pad also those that the rest
        mirrors. `besides` are displacements `(n,)` mm, by parity, that these forces do not hold, as of
        masses."""
        on_piece = force / self.piece.scale
        displacements = [
            small.solve(half.points.T @ on_piece)
            for half, small in zip(self.halves, self.factors, strict=True)
        ]
        for moved, more in zip(displacements, besides, strict=False):
            moved[: more.size] += more / self.piece.unit
        return on_sides(displacements)


def on_sides(displacements: list[Array]) -> list[Array]:
    """Return the displacements of a piece and of its image from those under even and odd loads; of a whole
    pad the ones that there are."""
    if len(displacements) == 1:
        return displacements
    even, odd = displacements
    return [even + odd, even - odd]


def collision(
    piece: PadPiece,
    body: StripBody,
    moved: Iterable[Array],
    plate: float,
    angle: float,
    give: tuple[Array, Array] | None = None,
) -> str | None:
    """Return a description of contact that the models do not detect, or None.

    `moved` are displacements `(n,)`, in units, of the piece and, of a mirrored pad, of its image; the plate
    is the line through (0, `plate`) mm at `angle` rad. `give`: x, mm, and extra sinking of the skin there,
    mm, that the field does not have.
    """

    def over(way: int, x: Array) -> Array:
        """The plate over the piece, or, `way` being -1, over its image."""
        more = 0.0 if give is None else np.interp(way * x * piece.unit, *give) / piece.unit
        return np.asarray(plate / piece.unit + math.tan(angle) * (way * x) + more)

    for side, way in zip(moved, (1, -1), strict=False):
        if words := undetected_contact(elements.outlines(body.system, side), partial(over, way)):
            return words
    return None
