"""What each strip feels of each ridge: stress per N of normal and of tangential force on one ridge alone.

Small strain, plane strain, full stick: linear, so the strips' stress is the sum over ridges of a response
times the ridge's force, and under the plate's own forces it is that of `film_stress`. A response needs to
know how a ridge's force lies on its crown. The normal one lies as the plate presses it at the reference
force; the tangential one as in a pull with full stick, less what normal force that pull puts on the ridge,
which the normal response has. So the moment by which a plate that keeps its angle holds a ridge upright is
in the tangential response. Another load widens the contact: what that changes is told as `elsewhere`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.base.blas import one_blas_thread
from skincad.base.errors import RefusedError
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.mechanics.bodies import elements, strip_field
from skincad.mechanics.bodies.condense import Condensed
from skincad.mechanics.bodies.mesh import default_sizes, triangles
from skincad.mechanics.bodies.strip_field import StripBody
from skincad.mechanics.film.contact_edges import with_fine_edges
from skincad.mechanics.film.rungs import FIRST, RUNGS, TAIL
from skincad.mechanics.film.stick import (
    PadPiece,
    condensed,
    contact_rows,
    level,
    load_scale,
    moved_by,
    piece_of,
    pressing,
    pulling,
    state_of,
)
from skincad.mechanics.film.stress import check_request, filled_pad

MORE = 2.0  # times the force, again and again, until a ridge that is clear touches
TRIES = 8
SPANS = (0.5, 2.0)  # of the force, at which the response is found again


@dataclass(frozen=True, eq=False)
class FilmResponse:
    """Responses `(ridges, strips, 3)` MPa/N: of the strips in the section's order the mean stress across the
    film, along it in the section, and along y, for 1 N on a ridge, `normal` in compression, `tangential` to
    +x. `error` `(2, ridges, 3)` MPa/N is that of the mesh, of the normal and of the tangential ones, that of
    the worst strip. `contact` `(ridges,)` N is the plate's force at which each ridge's contact was taken.
    `pressed` `(ridges,)` N are the ridges' forces under the reference `force`, `pulled` `(2, ridges)` what
    1 N of the plate's pull adds to their normal and tangential forces. `elsewhere` `(spans, 2, ridges, 3)`
    MPa/N is by how much responses differ where contact is that at `SPANS` of the force.
    """

    force: float
    strips: tuple[tuple[int, str], ...]
    normal: Array
    tangential: Array
    error: Array
    contact: Array
    pressed: Array
    pulled: Array
    elsewhere: Array
    unknowns: int

    def stress(self, normal: Array, tangential: Array) -> Array:
        """Return the stresses `(strips, 3)` MPa under forces `(ridges,)` N on the ridges."""
        found = np.einsum("r,rsk->sk", normal, self.normal)
        return np.asarray(found + np.einsum("r,rsk->sk", tangential, self.tangential))

    def stress_error(self, normal: Array, tangential: Array) -> Array:
        """Return the errors `(3,)` of such stresses, MPa: those of all ridges added up."""
        return np.asarray(np.abs(normal) @ self.error[0] + np.abs(tangential) @ self.error[1])


def film_response(design: Design, progress: Progress | None = None) -> FilmResponse:
    """Return the films' response at the design's own force, on the first mesh of `film_stress`.

    Raises InputError as `film_stresses`: without slots, where they are empty, for a doubly curved skin;
    RefusedError where no force brings a ridge into contact.
    """
    force, rung = design.contact.force, RUNGS[0]
    check_request(design, force)
    pad, thickness = filled_pad(design)
    piece = piece_of(pad, thickness, halved=False)
    first = level(piece, triangles(piece.pad, default_sizes(piece.pad, FIRST[0])), FIRST[1], force, False)
    finer = with_fine_edges(piece, first)
    mesh = triangles(finer.pad, rung.sizes(finer))
    found = []
    for order in (rung.order - 1, rung.order):
        if progress:
            progress(f"film response: order {order}")
        with one_blas_thread():
            found.append(_responses(finer, mesh, order, force, SPANS if order < rung.order else ()))
    lower, best = found
    return replace(best, error=TAIL * _apart(best, lower), elsewhere=lower.elsewhere)


def _apart(one: FilmResponse, other: FilmResponse) -> Array:
    """Largest differences `(2, ridges, 3)` of two responses, of any strip."""
    pairs = ((one.normal, other.normal), (one.tangential, other.tangential))
    return np.array([np.abs(a - b).max(axis=1) for a, b in pairs])


def _responses(
    piece: PadPiece, mesh: Any, order: int, force: float, spans: tuple[float, ...]
) -> FilmResponse:
    body = strip_field.body(elements.curved(mesh, order), order, piece.pad.materials)
    small = condensed(body, np.empty(0, np.int64))
    lying = [_Lying(piece, body, small, force)]
    while len(lying) < TRIES and not all(any(each.touches(r) for each in lying) for r in piece.pad.ridges):
        lying.append(_Lying(piece, body, small, lying[-1].force * MORE))
    found = _of_state(piece, lying, body.system.unknowns)
    others = (_of_state(piece, [_Lying(piece, body, small, s * force), *lying], 0) for s in spans)
    return replace(found, elsewhere=np.array([_apart(found, other) for other in others]))


def _of_state(piece: PadPiece, lying: Sequence[_Lying], unknowns: int) -> FilmResponse:
    """The responses, each ridge's by the first of these states in which it touches."""
    normal, tangential, contact = [], [], []
    for ridge in piece.pad.ridges:
        here = next((each for each in lying if each.touches(ridge)), None)
        if here is None:
            raise RefusedError(f"no force brings ridge {ridge} into contact: it has no response")
        pressed, pulled = here.responses(ridge)
        normal.append(pressed)
        tangential.append(pulled)
        contact.append(here.force)
    alone = lying[0]
    none = np.zeros((2, len(contact), 3))
    return FilmResponse(
        alone.force,
        tuple((s.ridge, s.side) for s in piece.whole.section.slots),
        np.array(normal),
        np.array(tangential),
        none,
        np.array(contact),
        np.array([alone.pressed[r] for r in piece.pad.ridges]),
        np.array([[alone.lifted(r), alone.dragged(r)] for r in piece.pad.ridges]).T,
        none[None],
        unknowns,
    )


class _Lying:
    """How the plate's force lies on the crowns at one normal force, in N."""

    def __init__(self, piece: PadPiece, body: StripBody, small: Condensed, force: float) -> None:
        self.piece, self.body, self.small, self.force = piece, body, small, force
        self.rows, self.ridge = contact_rows(body, small), body.system.nodes.ridge
        state, bonded, _ = pressing(piece, body, small, force)
        self.push = state.node
        self.pressed = dict(zip(piece.pad.ridges, state.normal.tolist(), strict=True))
        self.pull = pulling(piece, self.rows, small, bonded) * load_scale(piece)[0]

    def touches(self, ridge: int) -> bool:
        """Whether the plate presses this ridge."""
        return bool(self.push[self.ridge == ridge].sum() > 0)

    def lifted(self, ridge: int) -> float:
        """Normal force that 1 N of pull adds to a ridge."""
        return -float(self._half(1)[self.ridge == ridge].sum())

    def dragged(self, ridge: int) -> float:
        """Tangential force of 1 N of pull on a ridge."""
        return float(self._half(0)[self.ridge == ridge].sum())

    def responses(self, ridge: int) -> tuple[Array, Array]:
        """Stresses `(strips, 3)` of 1 N of normal force on a ridge, and of 1 N of tangential force."""
        own: Mask = self.ridge == ridge
        push = np.where(own, self.push, 0.0)
        pressed = self._stress(np.concatenate([np.zeros(push.size), -push / push.sum()]))
        pulled = self._stress(np.where(np.tile(own, 2), self.pull, 0.0))
        return pressed, (pulled - self.lifted(ridge) * pressed) / self.dragged(ridge)

    def _half(self, which: int) -> Array:
        return np.asarray(self.pull.reshape(2, -1)[which])

    def _stress(self, load: Array) -> Array:
        """Stresses of the strips under forces `(2 m,)` N."""
        given = load / load_scale(self.piece)[0]
        moved = moved_by(self.body, self.small, self.rows, given)
        return state_of(self.piece, self.body, moved, given, 1).strips
