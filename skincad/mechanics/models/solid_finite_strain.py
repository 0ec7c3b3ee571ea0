"""Finite strain of a pad with free ends: a small-strain answer times the change on a coarse solid.

The change compares small and finite strain on one coarse mesh of the section with the same prisms, so the
mesh's error cancels (as in corrected.py). The model corrected-finite-strain applies it to the corrected
model's answer; solid-finite-strain takes finer prisms and the solid model's answer.

Range: to where a ridge buckles or its tip folds, or parts meet that the model does not know, as in the
finite-strain model. A force beyond it is refused.
"""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np

from skincad.base.errors import InputError
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Progress, Stopwatch
from skincad.inputs.design import Design
from skincad.mechanics.bodies.mesh import PadPiece, meshed_piece
from skincad.mechanics.bodies.solid_body import SolidBody, solid_body
from skincad.mechanics.contact.newton import PressedPad, at_rest
from skincad.mechanics.models import corrected, solid
from skincad.mechanics.models.corrected import ORDER, plain_pad
from skincad.mechanics.models.correction import Correction, Errors, frictionless_level, level_answer
from skincad.mechanics.models.finite_strain import all_touch, at_force
from skincad.mechanics.models.solid import (
    Layers,
    bend_of,
    borders_of,
    coarse_sizes,
    forms_of,
)
from skincad.mechanics.problem import Answer, Pad, Request, SizeError, check_flat, check_pad, focused

LAYERS, COARSE_LAYERS = Layers(0.6, 2.0, 3), Layers(0.6, 2.0, 2)
MOST_UNKNOWNS = 150_000  # about 4 GB

# Errors of the change itself
ERRORS = Errors(approach=0.003, threshold=0.002, share=0.01)
# With fewer functions along y: a constant, and a part of the change
COARSE_ERRORS = Errors(approach=0.003, threshold=0.003, share=0.005)
COARSE_PARTS = Errors(approach=0.05, threshold=0.06, share=0.2)


def answer(
    design: Design, request: Request, progress: Progress | None = None, fine: Answer | None = None
) -> Answer:
    """Return the solid model's answer `fine`, solved here if None, corrected for finite strain.

    Errors are the solid model's discretisation error plus that of the change. Raises InputError for a force
    beyond the model's range; if the all-touch force is beyond it, it is None and a warning says so.
    """
    return _changed(design, request, progress, fine, "solid")


def on_corrected(
    design: Design, request: Request, progress: Progress | None = None, fine: Answer | None = None
) -> Answer:
    """Return the corrected model's answer in the same way, the change with fewer functions along y."""
    return _changed(design, request, progress, fine, "corrected")


def _changed(
    design: Design, request: Request, progress: Progress | None, fine: Answer | None, base: str
) -> Answer:
    began = perf_counter()
    model = f"{base}-finite-strain"
    check_flat(design.contact.plate, model, base)
    if progress:
        progress(f"{model} model: coarse solid, small and finite strain")
    spent: dict[str, float] = {}
    layers = LAYERS if base == "solid" else COARSE_LAYERS
    pad, drops = focused(plain_pad(design), request.force), request.crest_offsets
    try:  # first: it may refuse the force
        change = solve(pad, request.force, spent, layers, crest_offsets=drops)
    except InputError as refusal:
        if refusal.key != "force" or layers == LAYERS:
            raise
        # waves along y that coarse layers overrate may tip a ridge over
        change = solve(pad, request.force, spent, LAYERS, crest_offsets=drops)
    if fine is None:
        fine = (solid if base == "solid" else corrected).answer(design, request, progress)
    if base != "solid":
        change = replace(change, constant=COARSE_ERRORS, by_change=COARSE_PARTS)
    result, errors = change.applied(fine, request.force), change.errors
    warnings = [*fine.warnings, *([change.out_of_range] if change.out_of_range else [])]
    reached = max(errors.approach, errors.threshold, errors.share)
    if 0 < (request.tol or 0.0) < reached:
        warnings.append(
            f"the change by finite strain is known to {reached:g}: the tolerance {request.tol:.1e} is not met"
        )
    if request.budget is not None and perf_counter() - began > request.budget:
        warnings.append(f"the solid with finite strain overran the budget of {request.budget:g} s")
    return replace(
        result,
        warnings=tuple(warnings),
        seconds={**fine.seconds, **{f"finite {stage}": s for stage, s in spent.items()}},
    )


def solve(
    pad: Pad,
    force: float,
    seconds: dict[str, float],
    along: Layers = LAYERS,
    *,
    fineness: float = 1.0,
    crest_offsets: tuple[float, ...] = (),
) -> Correction:
    """Return the change at `force` N from small to finite strain; raises InputError as `answer`, and for too
    large a pad. `crest_offsets` as in Request."""
    check_pad(pad)
    watch = Stopwatch(stages=seconds)
    with watch.stage("mesh"):  # crests of one part are not mirrored
        meshed = meshed_piece(pad, coarse_sizes(pad, fineness), whole=bool(crest_offsets))
    drops = np.array(crest_offsets) / meshed.unit if crest_offsets else None
    with one_blas_thread():
        with watch.stage("assemble"):
            body = body_of(meshed, along)
            problem = PressedPad(body, meshed.whole.top / meshed.unit, drops)
            # force on the whole pad, N, for a force of 1 on the piece
            scale, unknowns = pad.young_modulus * meshed.unit**2 * 2 * meshed.sides, int(body.free.sum())
        with watch.stage("small strain"):
            rest = at_rest(problem)
            small = frictionless_level(meshed, rest.ridges, force, scale, unknowns)
        with watch.stage("newton"):
            state = at_force(problem, force / scale, scale, rest=rest)
        with watch.stage("threshold"):
            first, touching, beyond_reason = all_touch(problem, state, scale)
    contact, residual = state.contact, max(s.contact.residual for s in (state, touching) if s)
    forces = contact.force, contact.approach, first
    finite = level_answer(meshed, state.ridges, *forces, scale=scale, unknowns=unknowns, residual=residual)
    return Correction(small, finite, ERRORS, out_of_range=beyond_reason)


def body_of(meshed: PadPiece, along: Layers, order: int = ORDER, *, clamped_end: bool = False) -> SolidBody:
    """Return the body of a meshed piece, of `order` in the section."""
    forms = forms_of(meshed, order)
    borders, bend = borders_of(meshed, along), bend_of(meshed)
    unknowns = 3 * forms.clamped.size * ((borders.size - 1) * along.order + 1)
    if unknowns > MOST_UNKNOWNS:
        rule = f"three dimensions at finite strain take at most {MOST_UNKNOWNS} unknowns"
        remedy = "take fewer ridges, a shorter skin or the corrected model"
        raise SizeError("ridge.count", rule, unknowns, remedy)
    laws = meshed.pad.laws
    return solid_body(forms, borders, along.order, clamped_end=clamped_end, laws=laws, bend=bend)
