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

from dataclasses import dataclass, field, replace
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
from skincad.mechanics.bodies.mesh import PadPiece, default_sizes, piece_of, triangles
from skincad.mechanics.film.stick import (
    condensed_piece,
    level,
    load_state,
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
    contact: Array
    ridge_force: Array
    ridge_force_per_pull: Array
    unknowns: int
    error: Array = field(default_factory=lambda: np.empty(0))
    at_other_forces: Array = field(default_factory=lambda: np.empty(0))

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
    """The responses at a force, N; each ridge takes the first of growing forces under which it touches."""
    body = film_field.body(elements.curved(mesh, order), order, piece.pad.materials)
    small = condensed_piece(body, np.empty(0, np.int64))
    response, grown = _response_at(piece, body, small, force), force
    for _ in range(MAX_TRIES - 1):
        if not np.isnan(response.contact).any():
            break
        grown *= FORCE_GROWTH
        response = _completed(response, _response_at(piece, body, small, grown))
    for ridge, touching in zip(piece.pad.ridges, response.contact, strict=True):
        if np.isnan(touching):
            raise RefusedError(f"no force brings ridge {ridge} into contact: it has no response")
    others = (_completed(_response_at(piece, body, small, s * force), response) for s in spans)
    changes = np.array([_largest_difference(response, other) for other in others])
    return replace(response, at_other_forces=changes)


def _completed(response: FilmResponse, other: FilmResponse) -> FilmResponse:
    """The response, of ridges that do not touch the other one's."""
    lifted = np.isnan(response.contact)
    return replace(
        response,
        normal=np.where(lifted[:, None, None], other.normal, response.normal),
        tangential=np.where(lifted[:, None, None], other.tangential, response.tangential),
        contact=np.where(lifted, other.contact, response.contact),
    )


def _response_at(piece: PadPiece, body: StripBody, small: Condensation, force: float) -> FilmResponse:
    """The response by how the plate's force, N, is distributed over the crowns; NaN of ridges that do not
    touch."""
    state, bonded, _ = press_state(piece, body, small, force)
    scale, strips = piece.scale, piece.whole.section.slots
    pull = pull_load(piece, body, small, bonded) * scale
    shape = len(piece.pad.ridges), len(strips), 3
    normal, tangential, contact = np.full(shape, np.nan), np.full(shape, np.nan), np.full(shape[0], np.nan)
    per_pull = np.zeros((2, shape[0]))

    def stress(load: Array) -> Array:
        """Stresses of the strips under forces `(2 m,)` N."""
        scaled = load / scale
        return load_state(piece, body, small.solve(body.points.T @ scaled), scaled, 1).strips

    for i, ridge in enumerate(piece.pad.ridges):
        on_ridge: Mask = body.system.nodes.ridge == ridge
        push, pulled = np.where(on_ridge, state.node[0], 0.0), np.where(on_ridge, pull.reshape(2, -1), 0.0)
        per_pull[:, i] = -pulled[1].sum(), pulled[0].sum()
        if push.sum() > 0:
            normal[i] = stress(np.concatenate([np.zeros(push.size), -push / push.sum()]))
            tangential[i] = (stress(pulled.ravel()) - per_pull[0, i] * normal[i]) / per_pull[1, i]
            contact[i] = force
    return FilmResponse(
        force=force,
        strips=tuple((s.feature, s.side) for s in strips),
        normal=normal,
        tangential=tangential,
        contact=contact,
        ridge_force=state.normal,
        ridge_force_per_pull=per_pull,
        unknowns=body.system.unknowns,
    )
