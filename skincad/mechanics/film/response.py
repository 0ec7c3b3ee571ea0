"""Stress responses of each strip: per N of normal and of tangential force on one ridge alone.

The model is linear: small strain, plane strain, full stick. So the strips' stress is the sum over ridges of a
response times the ridge's force. Under the plate's forces it is that of `film_stress`. A response depends on
the distribution of the force over the crown. The normal force is distributed as the plate presses it at the
reference force. The tangential force is distributed as in a pull with full stick. That pull also adds normal
force to the ridge, which is subtracted, as the normal response has it. The tangential response includes the
moment by which a plate that keeps its angle holds a ridge upright. Another load widens the contact:
`at_other_forces` is the change by that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.base.errors import RefusedError
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.mechanics.bodies import elements, film_field
from skincad.mechanics.bodies.condense import Condensation
from skincad.mechanics.bodies.film_field import StripBody
from skincad.mechanics.bodies.mesh import default_sizes, triangles
from skincad.mechanics.film.stick import (
    PadPiece,
    condensed_piece,
    contact_rows,
    displacements_under,
    level,
    load_scale,
    load_state,
    piece_of,
    press_state,
    pull_load,
    with_fine_edges,
)
from skincad.mechanics.film.stress import EDGE_SEARCH, REFINEMENTS, TAIL, check_request, filled_pad

FORCE_GROWTH = 2.0  # factor on the force, repeated until a clear ridge touches
MAX_TRIES = 8
SPANS = (0.5, 2.0)  # of the force, at which the response is computed too


@dataclass(frozen=True, eq=False)
class FilmResponse:
    """Responses `(ridges, strips, 3)` MPa/N: of the strips in the section's order the mean stress across the
    film, along it in the section, and along y, for 1 N on a ridge, `normal` in compression, `tangential` to
    +x. `error` `(2, ridges, 3)` MPa/N is that of the mesh, of the normal and of the tangential ones, that of
    the worst strip. `contact` `(ridges,)` N is the plate's force at which each ridge's contact was taken.
    `ridge_force` `(ridges,)` N are the ridges' forces under the reference `force`. `ridge_force_per_pull`
    `(2, ridges)` are the normal and tangential forces that 1 N of the plate's pull adds. `at_other_forces`
    `(spans, 2, ridges, 3)` MPa/N is the change of the responses for the contact at `SPANS` of the force.
    """

    force: float
    strips: tuple[tuple[int, str], ...]
    normal: Array
    tangential: Array
    error: Array
    contact: Array
    ridge_force: Array
    ridge_force_per_pull: Array
    at_other_forces: Array
    unknowns: int

    def stress(self, normal: Array, tangential: Array) -> Array:
        """Return the stresses `(strips, 3)` MPa under forces `(ridges,)` N on the ridges."""
        by_push = np.einsum("r,rsk->sk", normal, self.normal)
        return np.asarray(by_push + np.einsum("r,rsk->sk", tangential, self.tangential))

    def stress_error(self, normal: Array, tangential: Array) -> Array:
        """Return the errors `(3,)` of such stresses, MPa: those of all ridges added up."""
        return np.asarray(np.abs(normal) @ self.error[0] + np.abs(tangential) @ self.error[1])


def film_response(design: Design, progress: Progress | None = None) -> FilmResponse:
    """Return the films' response at the design's own force, on the first mesh of `film_stress`.

    Raises InputError as `film_stresses`: without slots, where they are empty, for a doubly curved skin;
    RefusedError where no force brings a ridge into contact.
    """
    force, refinement = design.contact.force, REFINEMENTS[0]
    check_request(design, force)
    pad, thickness = filled_pad(design)
    piece = piece_of(pad, thickness, halved=False)
    first = level(
        piece, triangles(piece.pad, default_sizes(piece.pad, EDGE_SEARCH[0])), EDGE_SEARCH[1], force, False
    )
    finer = with_fine_edges(piece, first)
    mesh = triangles(finer.pad, refinement.sizes(finer))
    responses = []
    for order in (refinement.order - 1, refinement.order):
        if progress:
            progress(f"film response: order {order}")
        with one_blas_thread():
            responses.append(_responses(finer, mesh, order, force, SPANS if order < refinement.order else ()))
    lower, best = responses
    return replace(best, error=TAIL * _largest_difference(best, lower), at_other_forces=lower.at_other_forces)


def _largest_difference(one: FilmResponse, other: FilmResponse) -> Array:
    """Largest differences `(2, ridges, 3)` of two responses, of any strip."""
    pairs = ((one.normal, other.normal), (one.tangential, other.tangential))
    return np.array([np.abs(a - b).max(axis=1) for a, b in pairs])


def _responses(
    piece: PadPiece, mesh: Any, order: int, force: float, spans: tuple[float, ...]
) -> FilmResponse:
    body = film_field.body(elements.curved(mesh, order), order, piece.pad.materials)
    small = condensed_piece(body, np.empty(0, np.int64))
    loads = [_ContactLoad(piece, body, small, force)]
    while len(loads) < MAX_TRIES and not all(
        any(load.touches(r) for load in loads) for r in piece.pad.ridges
    ):
        loads.append(_ContactLoad(piece, body, small, loads[-1].force * FORCE_GROWTH))
    response = _of_state(piece, loads, body.system.unknowns)
    others = (_of_state(piece, [_ContactLoad(piece, body, small, s * force), *loads], 0) for s in spans)
    return replace(
        response, at_other_forces=np.array([_largest_difference(response, other) for other in others])
    )


def _of_state(piece: PadPiece, loads: Sequence[_ContactLoad], unknowns: int) -> FilmResponse:
    """The responses; each ridge takes the first of these loads under which it touches."""
    normal, tangential, contact = [], [], []
    for ridge in piece.pad.ridges:
        first = next((load for load in loads if load.touches(ridge)), None)
        if first is None:
            raise RefusedError(f"no force brings ridge {ridge} into contact: it has no response")
        per_push, per_pull = first.responses(ridge)
        normal.append(per_push)
        tangential.append(per_pull)
        contact.append(first.force)
    alone = loads[0]
    none = np.zeros((2, len(contact), 3))
    return FilmResponse(
        force=alone.force,
        strips=tuple((s.feature, s.side) for s in piece.whole.section.slots),
        normal=np.array(normal),
        tangential=np.array(tangential),
        error=none,
        contact=np.array(contact),
        ridge_force=np.array([alone.ridge_force[r] for r in piece.pad.ridges]),
        ridge_force_per_pull=np.array(
            [[alone.normal_per_pull(r), alone.tangential_per_pull(r)] for r in piece.pad.ridges]
        ).T,
        at_other_forces=none[None],
        unknowns=unknowns,
    )


class _ContactLoad:
    """The distribution of the plate's force over the crowns at one normal force, N."""

    def __init__(self, piece: PadPiece, body: StripBody, small: Condensation, force: float) -> None:
        self.piece, self.body, self.small, self.force = piece, body, small, force
        self.rows, self.ridge = contact_rows(body, small), body.system.nodes.ridge
        state, bonded, _ = press_state(piece, body, small, force)
        self.push = state.node
        self.ridge_force = dict(zip(piece.pad.ridges, state.normal.tolist(), strict=True))
        self.pull = pull_load(piece, self.rows, small, bonded) * load_scale(piece)[0]

    def touches(self, ridge: int) -> bool:
        """Whether the plate presses this ridge."""
        return bool(self.push[self.ridge == ridge].sum() > 0)

    def normal_per_pull(self, ridge: int) -> float:
        """Normal force that 1 N of pull adds to a ridge."""
        return -float(self._half(1)[self.ridge == ridge].sum())

    def tangential_per_pull(self, ridge: int) -> float:
        """Tangential force of 1 N of pull on a ridge."""
        return float(self._half(0)[self.ridge == ridge].sum())

    def responses(self, ridge: int) -> tuple[Array, Array]:
        """Stresses `(strips, 3)` of 1 N of normal force on a ridge, and of 1 N of tangential force."""
        on_ridge: Mask = self.ridge == ridge
        push = np.where(on_ridge, self.push, 0.0)
        per_push = self._stress(np.concatenate([np.zeros(push.size), -push / push.sum()]))
        per_pull = self._stress(np.where(np.tile(on_ridge, 2), self.pull, 0.0))
        return per_push, (per_pull - self.normal_per_pull(ridge) * per_push) / self.tangential_per_pull(ridge)

    def _half(self, which: int) -> Array:
        return np.asarray(self.pull.reshape(2, -1)[which])

    def _stress(self, load: Array) -> Array:
        """Stresses of the strips under forces `(2 m,)` N."""
        scaled = load / load_scale(self.piece)[0]
        moved = displacements_under(self.body, self.small, self.rows, scaled)
        return load_state(self.piece, self.body, moved, scaled, 1).strips
