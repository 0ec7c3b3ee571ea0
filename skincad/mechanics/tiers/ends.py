"""The compliance that free ends add to a pad's ridges, from a coarse solid.

Each ridge is moved down as one, along x and y. The ridges' stiffness is a small matrix, computed in plane
strain and in three dimensions on the same coarse mesh. The difference of the inverses is smooth and belongs
to the bulk. It is added to the fine section's compliance. Ends that are free to bulge can only soften a pad.
Against the corrected tier (yamada-2002 6, 12 and 48 mm long, plain-ridges) the approach at 4 N is within
0.6 %, a share within 0.8 % of the mean one; the ends themselves change them by 3 to 31 % and by 2 to 19 %.
"""

from __future__ import annotations

import numpy as np
from scipy import linalg

from skincad.base.arrays import Array
from skincad.base.blas import one_blas_thread
from skincad.inputs.design import Design
from skincad.mechanics.bodies import prisms
from skincad.mechanics.bodies.meshed import PadMesh, meshed_piece
from skincad.mechanics.bodies.symmetry import half_of
from skincad.mechanics.problem import ContactError
from skincad.mechanics.tiers.corrected import LAYERS, ORDER, plain_pad
from skincad.mechanics.tiers.solid_level import Layers, coarse_sizes, condensed_pad, forms_of

ROUNDING = 1e-9  # relative; a larger negative eigenvalue means ends stiffer than plane strain


def added_compliance(design: Design, along: Layers = LAYERS) -> Array:
    """Return the extra sinking of ridge i by free ends, mm, per N on ridge j `(ridges, ridges)`.

    Small strain. Raises ContactError where the two solids contradict each other.
    """
    seconds: dict[str, float] = {}
    pad = plain_pad(design)
    meshed = meshed_piece(pad, coarse_sizes(pad, 1.0), whole=True)
    forms = forms_of(meshed, ORDER)
    plane, solid = (_by_ridge(meshed, forms, layers, seconds) for layers in (None, along))
    more = solid - plane
    if half_of(pad) is not None:  # the mesh is not its own mirror image, the pad is
        more = (more + more[::-1, ::-1]) / 2
    if np.linalg.eigvalsh(more).min() < -ROUNDING * np.abs(more).max():
        raise ContactError("free ends came out stiffer than plane strain; take a smaller poisson_ratio")
    return more


def _by_ridge(
    meshed: PadMesh, forms: prisms.SectionForms, along: Layers | None, seconds: dict[str, float]
) -> Array:
    """How far each ridge goes down as one, mm, per N on another `(ridges, ridges)`."""
    small, scale = condensed_pad(meshed, forms, along, seconds)
    nodes = small.seen.nodes
    numbers = np.array(meshed.whole.ridges)
    rows = nodes.rows.tocsc()
    # a contact unknown belongs to the ridge whose points it moves
    owner = np.array([nodes.ridge[rows.indices[rows.indptr[k]]] for k in range(rows.shape[1])])
    lift = np.repeat(forms.plane.lift[forms.plane.contact], rows.shape[1] // forms.plane.contact.size)
    modes = lift[:, None] * (owner[:, None] == numbers)
    with one_blas_thread():
        stiffness = modes.T @ linalg.solve(small.flexibility, modes, assume_a="pos")
        compliance = linalg.inv(stiffness)
    return np.asarray((compliance + compliance.T) / 2 * meshed.unit / scale)
