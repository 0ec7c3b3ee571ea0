"""A plane model corrected by the change from a coarse plane to a coarse solid pad.

The corrected model: the fine plane-strain answer with a correction for free ends from a coarse solid. The
correction compares two solutions on one coarse mesh of the section, so the mesh's error cancels.

The compliance that free ends add to a pad's ridges, from a coarse solid. Each ridge is moved down as one,
along x and y. The ridges' stiffness is a small matrix, computed in plane strain and in three dimensions on
the same coarse mesh. The difference of the inverses is smooth and belongs to the bulk. It is added to the
fine section's compliance. Ends that are free to bulge can only soften a pad. Against the corrected model
(yamada-2002 6, 12 and 48 mm long, plain-ridges) the approach at 4 N is within 0.6 %, a share within 0.8 % of
the mean one; the ends themselves change them by 3 to 31 % and by 2 to 19 %.
"""

from __future__ import annotations

import math
from dataclasses import replace
from time import perf_counter

import numpy as np
from scipy import linalg

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Progress, Stopwatch
from skincad.inputs.design import Design
from skincad.mechanics.bodies import prisms
from skincad.mechanics.bodies.mesh import PadPiece, half_of, meshed_piece
from skincad.mechanics.models import linear
from skincad.mechanics.models.correction import Correction, Errors
from skincad.mechanics.models.solid import (
    Layers,
    coarse_sizes,
    condensed_pad,
    forms_of,
    solve_level,
)
from skincad.mechanics.problem import (
    Answer,
    ContactError,
    Pad,
    Request,
    focused,
    solid_pad_of,
)
from skincad.shape.families import without_fillets
from skincad.shape.skin import skin_of

ORDER = 2
LAYERS = Layers(0.6, 2.0, 4)
MOST_FILLET = 0.25  # of the tip's width; smaller fillets change the ratio less than its error

# Errors of the change itself. Order 3 here would take 2.6 times as long, for 0.7 % of the force
ERRORS = Errors(approach=0.008, threshold=0.01, share=0.006)


def answer(
    design: Design, request: Request, progress: Progress | None = None, fine: Answer | None = None
) -> Answer:
    """Return the linear model's answer `fine`, solved here if None, corrected for free ends.

    Errors are the linear model's discretisation error with that of the change. The change holds for small
    strains, as the linear model does.
    """
    started = perf_counter()
    if fine is None:
        fine = linear.answer(design, request, progress)
    if progress:
        progress("corrected model: coarse solid with free ends")
    spent: dict[str, float] = {}
    pad = focused(plain_pad(design), request.force)
    change = free_ends(pad, request.force, spent, crest_offsets=request.crest_offsets)
    result = change.applied(fine, request.force)
    warnings = list(fine.warnings)
    if request.budget is not None and perf_counter() - started > request.budget:
        warnings.append(f"the coarse solid overran the budget of {request.budget:g} s")
    seconds = {**fine.seconds, "solid": math.fsum(spent.values())}
    return replace(result, warnings=tuple(warnings), seconds=seconds)


def plain_pad(design: Design) -> Pad:
    """Return the pad without small fillets, which take most of the triangles and leave the change alone."""
    ridge = skin_of(design).profile
    if ridge.tip_fillet > MOST_FILLET * ridge.tip_width:
        return solid_pad_of(design)
    try:
        return solid_pad_of(without_fillets(design))
    except InputError:  # a slot that clears the fillet but not the sharp corner
        return solid_pad_of(design)


def free_ends(
    pad: Pad,
    force: float,
    seconds: dict[str, float],
    along: Layers = LAYERS,
    crest_offsets: tuple[float, ...] = (),
) -> Correction:
    """Return the change at `force` N from plane strain to free ends; `crest_offsets` as in Request."""
    watch = Stopwatch(stages=seconds)
    with watch.stage("mesh"):
        meshed = meshed_piece(pad, coarse_sizes(pad, 1.0), whole=bool(crest_offsets))
    with watch.stage("assemble"):
        forms = forms_of(meshed, ORDER)
    plane, solid = (
        solve_level(meshed, forms, layers, force, seconds, crest_offsets=crest_offsets)
        for layers in (None, along)
    )
    return Correction(plane, solid, ERRORS)


ROUNDING = 1e-9  # relative; a larger negative eigenvalue means ends stiffer than plane strain


def added_compliance(design: Design) -> Array:
    """Return the extra sinking of ridge i by free ends, mm, per N on ridge j `(ridges, ridges)`.

    Small strain. Raises ContactError where the two solids contradict each other.
    """
    pad = plain_pad(design)
    meshed = meshed_piece(pad, coarse_sizes(pad, 1.0), whole=True)
    forms = forms_of(meshed, ORDER)
    more = _by_ridge(meshed, forms, LAYERS) - _by_ridge(meshed, forms, None)
    if half_of(pad) is not None:  # the mesh is not its own mirror image, the pad is
        more = (more + more[::-1, ::-1]) / 2
    if np.linalg.eigvalsh(more).min() < -ROUNDING * np.abs(more).max():
        raise ContactError("free ends came out stiffer than plane strain; take a smaller poisson_ratio")
    return more


def _by_ridge(meshed: PadPiece, forms: prisms.SectionForms, along: Layers | None) -> Array:
    """How far each ridge goes down as one, mm, per N on another `(ridges, ridges)`."""
    small, scale = condensed_pad(meshed, forms, along, {})
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
