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
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Protocol

import numpy as np
from scipy import linalg

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.mechanics.bodies import prisms
from skincad.mechanics.bodies.mesh import PadMesh, half_of, meshed_piece
from skincad.mechanics.models import linear
from skincad.mechanics.models.solid import (
    Layers,
    SolidSolution,
    coarse_sizes,
    condensed_pad,
    forms_of,
    solve_level,
    timed,
)
from skincad.mechanics.problem import (
    NEGLIGIBLE,
    Answer,
    ContactError,
    Pad,
    Request,
    focused,
    solid_pad_of,
    wider_by,
)
from skincad.shape.families import without_fillets
from skincad.shape.skin import skin_of


@dataclass(frozen=True)
class Errors:
    """Errors of a change: relative for approach and all-touch force, of a share in mean shares."""

    approach: float
    threshold: float
    share: float


ORDER = 2
LAYERS = Layers(0.6, 2.0, 4)
MOST_FILLET = 0.25  # of the tip's width; smaller fillets change the ratio less than its error

# Errors of the change itself, on 45 random designs (bench.verdicts, seeds 5000 to 5044) against a solid with
# all fillets, of order 3 on a mesh twice as fine: at most 0.5 % of the approach and of the mean share, 1.3 %
# of the all-touch force, within 1 % on 43 of them; 0.6 % of a short pad's approach (test_solid.py).
# Order 3 here would take 2.6 times as long, for 0.7 % of the force
ERRORS = Errors(approach=0.008, threshold=0.01, share=0.006)


@dataclass(frozen=True)
class Ends:
    """The coarse answers in plane strain and with free ends, on the same section mesh."""

    plane: SolidSolution
    solid: SolidSolution


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
    ends = free_ends(pad, request.force, spent, crest_offsets=request.crest_offsets)
    result = apply_change(fine, ends.plane, ends.solid, request.force, ERRORS)
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
) -> Ends:
    """Return the coarse answers at `force` N in plane strain and with free ends; `crest_offsets` as in
    Request."""
    meshed = timed(
        seconds, "mesh", lambda: meshed_piece(pad, coarse_sizes(pad, 1.0), whole=bool(crest_offsets))
    )
    forms = timed(seconds, "assemble", lambda: forms_of(meshed, ORDER))
    plane = solve_level(meshed, forms, None, force, seconds, crest_offsets=crest_offsets)
    return Ends(plane, solve_level(meshed, forms, along, force, seconds, crest_offsets=crest_offsets))


class CoarseAnswer(Protocol):
    """One side of a change: a coarse answer of the whole pad, in mm and N; `ridge_force` is `(ridges,)`."""

    @property
    def all_touch_force(self) -> float | None:
        """In N; None where it is out of range."""

    @property
    def approach(self) -> float:
        """In mm."""

    @property
    def ridge_force(self) -> Array:
        """Of each ridge, N."""

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""

    @property
    def residual(self) -> float:
        """The largest, relative."""


def relative_changes(before: CoarseAnswer, after: CoarseAnswer) -> Errors:
    """Return how much changes from one coarse answer to the other: of approach and all-touch force relative,
    of the share that changes most in mean shares. 0 without both forces."""
    by_force = 0.0
    if before.all_touch_force and after.all_touch_force:
        by_force = after.all_touch_force / before.all_touch_force - 1
    by_share = np.abs(after.ridge_force - before.ridge_force).max() / before.ridge_force.mean()
    return Errors(after.approach / before.approach - 1, by_force, float(by_share))


def errors_of(changes: Errors, constant: Errors, part: Errors) -> Errors:
    """Return the errors of these changes: a constant, and a part of each."""
    return Errors(
        constant.approach + part.approach * abs(changes.approach),
        constant.threshold + part.threshold * abs(changes.threshold),
        constant.share + part.share * changes.share,
    )


def apply_change(
    fine: Answer, before: CoarseAnswer, after: CoarseAnswer, force: float, errors: Errors
) -> Answer:
    """Return a fine answer with what changes from one coarse level to another on the same mesh.

    Approach and all-touch force change by a factor; shares by a difference, so that they still sum to the
    force. The mesh's error and the change's come from meshes that know nothing of each other: their squares
    add up (JCGM 100:2008, 5.1.2).
    """
    approach = after.approach / before.approach
    value, error = fine.approach.value or 0.0, fine.approach.error or 0.0
    shares = _shares(fine, before, after)
    share_error = math.hypot(fine.ridge_force[0].error or 0.0, errors.share * force / len(shares))
    return Answer(
        touching=int(np.count_nonzero(shares > 0)),
        all_touch_force=_threshold(fine, before, after, force, errors.threshold),
        approach=Estimate(value * approach, math.hypot(error, errors.approach * value) * approach, "mm"),
        ridge_force=tuple(Estimate(float(f), share_error, "N") for f in shares),
        unknowns=max(fine.unknowns, after.unknowns),
        residual=max(fine.residual, before.residual, after.residual),
        seconds={},
        fault=fine.fault,
        ridge_model=fine.ridge_model,
        contact_width=fine.contact_width and wider_by(fine.contact_width, approach),
    )


def _threshold(
    fine: Answer, before: CoarseAnswer, after: CoarseAnswer, force: float, relative: float
) -> Estimate:
    """The all-touch force times its ratio.

    A negligible one is replaced by the level's own, known to NEGLIGIBLE of the force.
    """
    value, first, last = fine.all_touch_force.value, before.all_touch_force, after.all_touch_force
    if value is None or first is None or last is None:
        return Estimate(None, None, "N")
    if min(value, first) <= NEGLIGIBLE * force:
        return Estimate(last, NEGLIGIBLE * force if last else 0.0, "N")
    ratio = last / first
    error = math.hypot(fine.all_touch_force.error or 0.0, relative * value)
    return Estimate(value * ratio, error * ratio, "N")


def _shares(fine: Answer, before: CoarseAnswer, after: CoarseAnswer) -> Array:
    """Changed shares: 0 where the last level's ridge is clear, never negative, summing to the force."""
    known = np.array([f.value or 0.0 for f in fine.ridge_force])
    shares = known + after.ridge_force - before.ridge_force
    shares = np.where(after.ridge_force > 0, np.maximum(shares, 0.0), 0.0)
    return np.asarray(shares * (known.sum() / shares.sum()))


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
