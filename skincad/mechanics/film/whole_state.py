"""The whole pad under given forces at its contact points: its field to draw, and undetected contacts.

A state takes one solve with the factorisation that condensed the pad, of a mirrored pad one for each parity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from skincad.base.arrays import Array, Index, Mask
from skincad.mechanics.bodies import elements, strip_field
from skincad.mechanics.bodies.condense import Condensation
from skincad.mechanics.bodies.folding import fault
from skincad.mechanics.bodies.strip_field import Patch, StripBody
from skincad.mechanics.film.ridge_field import as_image, joined
from skincad.mechanics.film.stick import PadPiece


@dataclass(frozen=True, eq=False)
class DeformedSection:
    """The deformed section: `place`, `shift` `(p, 2)` mm, `stress` `(p, 4)` MPa, xx, xz, zz and yy, of its
    points, `triangles` `(t, 3)` of them, `film` `(t,)` those of the film. The plate is the line through
    (0, `plate`) mm at `angle` rad."""

    place: Array
    shift: Array
    stress: Array
    triangles: Index
    film: Mask
    plate: float
    angle: float


@dataclass(frozen=True, eq=False)
class Parity:
    """A factorisation for even or odd loads: forces `(2 m,)` of the whole pad are put on the piece by
    `spread` and on its contact unknowns by `rows`."""

    small: Condensation
    rows: sparse.csr_matrix
    spread: sparse.csr_matrix


@dataclass(frozen=True, eq=False)
class WholeState:
    """Computes the whole pad's state from the forces at its contact points."""

    piece: PadPiece
    body: StripBody
    parities: tuple[Parity, ...]

    def deformed_section(self, force: Array, plate: float, angle: float) -> DeformedSection:
        """Return the field under forces `(2 m,)` N in x, then in z, below a plate at (0, `plate`) mm."""
        patches = [self._field(moved) for moved in self._moved(force)]
        patch = patches[0] if len(patches) == 1 else joined(patches[0], as_image(patches[1], 1))
        unit, modulus = self.piece.unit, self.piece.pad.young_modulus
        place, shift = patch.place * unit, patch.shift * unit
        return DeformedSection(
            place, shift, patch.stress * modulus, patch.triangles, patch.film, plate, angle
        )

    def fault(
        self, force: Array, plate: float, angle: float, give: tuple[Array, Array] | None = None
    ) -> str | None:
        """Return a description of contact in this state that the model does not detect, or None.

        `give`: x, mm, and extra sinking of the skin there, mm, that the field does not have.
        """
        return collision(self.piece, self.body, self._moved(force), plate, angle, give)

    def _field(self, moved: Array) -> Patch:
        strip_field.set_state(self.body, moved)
        return strip_field.field(self.body, (0.0, 0.0), math.inf, 1)

    def _moved(self, force: Array) -> list[Array]:
        """Displacements `(n,)` of the piece, in units; of a mirrored pad also those that the rest mirrors."""
        per_force = 1 / (self.piece.pad.young_modulus * self.piece.pad.length * self.piece.unit)
        displacements = []
        for parity in self.parities:
            small, load = parity.small, np.zeros(self.body.system.lift.size)
            last = small.order[-small.flexibility.shape[0] :]
            load[last] = parity.rows.T @ (parity.spread @ force) * per_force
            displacements.append(small.solve(load))
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
    moved: list[Array],
    plate: float,
    angle: float,
    give: tuple[Array, Array] | None = None,
) -> str | None:
    """Return a description of contact that the models do not detect, or None.

    `moved` are displacements `(n,)`, in units, of the piece and, of a mirrored pad, of its image; the plate
    is the line through (0, `plate`) mm at `angle` rad; `give` as in `WholeState.fault`.
    """

    def over(x: Array) -> Array:
        more = 0.0 if give is None else np.interp(x * piece.unit, *give) / piece.unit
        return np.asarray(plate / piece.unit + math.tan(angle) * x + more)

    def over_image(x: Array) -> Array:
        return over(-x)

    outlines = [elements.outlines(body.system, side) for side in moved]
    collisions = (fault(loops, height) for loops, height in zip(outlines, (over, over_image), strict=False))
    return next((words for words in collisions if words), None)
