"""The check with friction between plate and skin.

What friction changes, from a coarse pad pressed with friction and without on one mesh, so that the mesh's
error cancels (as in corrected.py). Both are solved in small strain. A model without free ends gets the change
of a section in plane strain, where friction keeps the tips from spreading along x. A model with free ends
gets that of a coarse solid, whose points stick and slide along y too: it keeps the ends from bulging.

Without a coefficient the truth lies between no friction and FULL: the middle is the answer, the half range
what is left out. From 0.5 on next to no point slides (plain-ridges: 11.3, 11.6 and 11.7 % of the all-touch
force at 0.5, 1 and 2).
"""

from __future__ import annotations

from dataclasses import astuple, replace

from skincad.base.machine import one_blas_thread
from skincad.mechanics.bodies import elements
from skincad.mechanics.bodies.mesh import PadPiece, default_sizes, meshed_piece
from skincad.mechanics.contact.frictionless import all_touch_force, press, seen_by_plate
from skincad.mechanics.contact.press_path import (
    StickingPad,
    press_with_friction,
    sticking,
    sticking_pad_of,
)
from skincad.mechanics.left_out import FRICTION, LeftOut
from skincad.mechanics.models.correction import (
    Correction,
    Errors,
    LevelAnswer,
    level_answer,
)
from skincad.mechanics.models.solid import Layers, coarse_sizes, condensed_pad, forms_of
from skincad.mechanics.problem import Answer, Pad, SizeError

FINENESS, ORDER = 0.5, 2
MOST_POINTS = 1000  # in contact; a step's time grows as their cube, to a second or so
# Up to the smaller of the all-touch force F and the force. With 40 of them F, approach and shares of
# yamada-2002, plain-ridges and fingertip-soft at friction 0.2 and 1 differ by at most 0.02, 0.03 and 0.01 %
# from those with 80
STEPS = 50
# Errors of the change: a constant, and a part of the change, a third of which finite strain takes away
BASE_ERRORS, ERRORS_BY_CHANGE = Errors(approach=0.005, threshold=0.02, share=0.02), Errors(0.5, 0.3, 0.3)

FULL = 1.0  # a coefficient at which next to nothing slides
SOLID_LAYERS, SOLID_ORDER, SOLID_STEPS = Layers(0.6, 2.0, 3), 2, 8
SOLID_ERRORS = Errors(approach=0.008, threshold=0.007, share=0.012)
SOLID_ERRORS_BY_CHANGE = Errors(approach=0.1, threshold=0.1, share=0.2)
# At finite strain the change is less by up to LOST of what small strain leaves out, by its bound. In plane
# strain next to nothing is left of the change
LOST = Errors(approach=0.25, threshold=0.2, share=0.45)
PLANE_PART = 0.25


def solve(
    pad: Pad,
    coefficient: float,
    force: float,
    crest_offsets: tuple[float, ...] = (),
    fineness: float = FINENESS,
    order: int = ORDER,
    steps: int = STEPS,
) -> Correction:
    """Return the change at `force` N by friction; raises ContactError where the press with friction fails."""
    with one_blas_thread():
        meshed = meshed_piece(pad, default_sizes(pad, fineness), whole=True)
        curved = elements.curved(meshed.mesh, order)
        system = elements.symmetric_system(elements.assemble(curved, order, pad.materials, pad.revolved))
        points = system.nodes.weight.size
        if points > MOST_POINTS:
            words = f"is computed with friction for at most {MOST_POINTS} contact points"
            raise SizeError("ridge.count", words, points, "take fewer ridges")
        seen = sticking_pad_of(pad, system, meshed.unit, crest_offsets)
        both = _presses(meshed, seen, coefficient, force, steps, meshed.scale, system.unknowns)
    return Correction(*both, BASE_ERRORS, ERRORS_BY_CHANGE)


def solve_solid(
    pad: Pad,
    coefficient: float,
    force: float,
    crest_offsets: tuple[float, ...] = (),
    along: Layers = SOLID_LAYERS,
    fineness: float = 1.0,
    order: int = SOLID_ORDER,
    steps: int = SOLID_STEPS,
) -> Correction:
    """Return the same of a solid pad with free ends, whose points stick and slide along y too."""
    spent: dict[str, float] = {}
    meshed = meshed_piece(pad, coarse_sizes(pad, fineness), whole=bool(crest_offsets))
    small, scale = condensed_pad(meshed, forms_of(meshed, order), along, spent, in_plane=True)
    with one_blas_thread():
        ridges = seen_by_plate(meshed.whole, small.seen, small.flexibility, meshed.unit, crest_offsets)
        seen = sticking(ridges, small.seen, small.in_plane, whole=not meshed.mirrored)
        both = _presses(meshed, seen, coefficient, force, steps, scale, small.unknowns)
    return Correction(*both, SOLID_ERRORS, SOLID_ERRORS_BY_CHANGE, ends=True)


def _presses(
    meshed: PadPiece,
    seen: StickingPad,
    coefficient: float,
    force: float,
    steps: int,
    scale: float,
    unknowns: int,
) -> tuple[LevelAnswer, LevelAnswer]:
    """A pad pressed without and with friction at `force` N; a force of 1 in its units is `scale` N."""
    ridges, load = seen.ridges, force / scale
    first, smooth = all_touch_force(ridges, load), press(ridges.flexibility, ridges.gap, load)
    state, last = press_with_friction(seen, coefficient, load, first, steps)
    without, gripped = (
        level_answer(meshed, ridges, *forces, scale=scale, unknowns=unknowns, residual=contact.residual)
        for contact, forces in (
            (smooth, (smooth.force, smooth.approach, first)),
            (state, (state.normal, state.approach, last)),
        )
    )
    return without, gripped


def with_friction(
    fine: Answer, friction: Correction, force: float, *, known: bool = True, strain: LeftOut | None = None
) -> tuple[Answer, tuple[LeftOut, ...]]:
    """Return a frictionless answer with the change by friction and the error of that change; where the
    coefficient is not `known`, so that `friction` is of FULL, with half the change, and that as left out.

    `strain` bounds what small strain leaves out, for an answer at finite strain.
    """
    before, after, changes = friction.before, friction.after, friction.relative
    lost = (-LOST.threshold * strain.threshold, LOST.approach * strain.approach) if strain else (None, None)
    forces, approaches = (
        _range(change, part, friction.ends, known)
        for change, part in zip((changes.threshold, changes.approach), lost, strict=True)
    )
    part, unknown = (1.0, 0.0) if known else (0.5, 0.5 * changes.share)
    if strain and friction.ends:
        unknown += LOST.share * strain.share
    elif strain:
        part, unknown = PLANE_PART * part, unknown + changes.share
    first = before.all_touch_force and before.all_touch_force * (1 + sum(forces) / 2)
    down = before.approach * (1 + sum(approaches) / 2)
    shares = before.ridge_force + part * (after.ridge_force - before.ridge_force)
    middle = replace(after, all_touch_force=first, approach=down, ridge_force=shares)
    half = Errors((approaches[1] - approaches[0]) / 2, (forces[1] - forces[0]) / 2, unknown)
    errors = friction.errors
    left = LeftOut(effect=FRICTION, threshold=half.threshold, approach=half.approach, share=half.share)
    if known:
        errors = Errors(*(a + b for a, b in zip(astuple(errors), astuple(half), strict=True)))
    result = replace(friction, after=middle).applied(fine, force, errors)
    result = replace(result, warnings=fine.warnings, seconds=fine.seconds)
    return result, () if known else (left,)


def _range(change: float, lost: float | None, ends: bool, known: bool) -> tuple[float, float]:
    """Between what a relative change in small strain lies: at finite strain as `lost` is taken from it, and
    with an unknown coefficient down to nothing."""
    low = high = change
    if lost is not None and ends:
        low, high = sorted((change, change + lost))
    elif lost is not None:
        low, high = PLANE_PART * change - abs(change), PLANE_PART * change + abs(change)
    return (low, high) if known else (min(low, 0.0), max(high, 0.0))
