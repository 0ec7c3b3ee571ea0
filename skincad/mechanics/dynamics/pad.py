"""A meshed pad's equations with mass, as steps.py advances them.

The contact points bear no mass; theirs is spread over the rest. Points with mass of their own
stop or bounce at the plate by a rule that no mesh has, chatter, and gain energy: a bar that a plate strikes
ends with up to 2.9 times the work too much at small steps, without their mass with 5e-5 of it (undamped,
tests/mechanics/dynamics/test_steps.py). Khenous, Laborde, Renard, Eur. J. Mech. A/Solids 27 (2008) 918.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from skincad.base.arrays import Array, Index
from skincad.base.blas import one_blas_thread
from skincad.mechanics.dynamics.moving_body import MovingBody, moving_matrices
from skincad.mechanics.dynamics.state import Half, PadEquations
from skincad.mechanics.film.sliding import MOST_CONTACT_UNKNOWNS, ON_AXIS, layout, parities, ridges_of
from skincad.mechanics.film.stick import PadPiece, in_strip_axes, on_whole
from skincad.mechanics.problem import SizeError


def linear(piece: PadPiece, mesh: object, order: int, films: bool) -> PadEquations:
    """Return the equations of netgen's mesh of the piece; `films` asks for the strips' stresses.

    Raises SizeError for more contact unknowns than a dense block can hold.
    """
    with one_blas_thread():
        moving_body = moving_matrices(piece, mesh, order, films)
    body, unit = moving_body.body, piece.unit
    nodes, size = body.system.nodes, moving_body.stiff.shape[0]
    x, z = (nodes.position * unit).T
    lay = layout(x, piece.mirrored, ON_AXIS * unit)
    if 2 * lay.of.size > MOST_CONTACT_UNKNOWNS:
        limit = f"a scene takes at most {MOST_CONTACT_UNKNOWNS} contact unknowns"
        raise SizeError("ridge.count", limit, 2 * lay.of.size, "take fewer ridges")
    contact = np.concatenate([body.along_x, body.system.contact])
    rows = sparse.csr_matrix(sparse.block_diag([nodes.rows, nodes.rows]))
    at_unknowns = sparse.csr_matrix(
        (np.ones(contact.size), (np.arange(contact.size), contact)), (contact.size, size)
    )
    halves = []
    for parity, fixed in parities(piece, body):
        last = np.setdiff1d(contact, fixed)
        points = lay.spread(parity).T / lay.share @ rows @ at_unknowns
        # what is held on the cut does not move, so that no force on it counts
        points = sparse.csr_matrix(
            points @ sparse.diags(_marked(np.setdiff1d(moving_body.free, fixed), size))
        )
        inner = np.setdiff1d(moving_body.free, np.concatenate([last, fixed]))
        halves.append(Half(points, inner, last, _strips(piece, moving_body, parity, films)))
    gap = (piece.whole.top - z)[lay.of]
    return PadEquations(
        moving_body.stiff,
        moving_body.soft,
        _spread(moving_body.mass, contact, body.system.lift[:size]),
        tuple(halves),
        lay.share,
        gap - gap.min(),
        lay.weight(nodes.weight) * unit * piece.pad.length,
        ridges_of(piece, nodes.ridge[lay.of], lay.left),
        sum(half.inner.size + half.contact.size for half in halves),
        body,
    )


def _spread(mass: sparse.csr_matrix, massless: Index, lift: Array) -> sparse.csr_matrix:
    """The mass with none at some unknowns, the rest heavier by as much; `lift` is a rigid motion by 1."""
    mask = sparse.diags(1.0 - _marked(massless, lift.size))
    rest = sparse.csr_matrix(mask @ mass @ mask)
    return rest * float((lift @ (mass @ lift)) / (lift @ (rest @ lift)))


def _marked(of: Index, size: int) -> Array:
    mark = np.zeros(size)
    mark[of] = 1.0
    return mark


def _strips(
    piece: PadPiece, moving: MovingBody, parity: int, films: bool
) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """The stresses of all strips, each in its own axes, `(3 strips of the whole, n)`."""
    if not films:
        none = sparse.csr_matrix((0, moving.stiff.shape[0]))
        return none, none
    count = len(piece.slots)
    turned = []
    for one in np.eye(4 * count):
        turned.append(on_whole(piece, in_strip_axes(one.reshape(count, 4), piece.slots), parity or 1).ravel())
    turn = sparse.csr_matrix(np.array(turned).T)
    return sparse.csr_matrix(turn @ moving.strips[0]), sparse.csr_matrix(turn @ moving.strips[1])
