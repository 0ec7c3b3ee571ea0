"""The solid tier: the pad's finite length with its free ends, small strain, exact contact.

A level is one section mesh, one order in it and one set of layers along y. A rung solves the section at two
orders and the layers at two gradings. Functions are products, so what finer layers change is nearly the
same at both orders: it is added, and the differences are the errors. Meshes are refined until the tolerance
is met.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from skincad.base.arrays import Array
from skincad.base.climbing import Ascent, by_price, climb
from skincad.base.estimate import Estimate
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.mechanics.bodies.mesh import unit_of
from skincad.mechanics.bodies.meshed import meshed_piece
from skincad.mechanics.problem import Answer, Pad, Request, SizeError, check_pad, pad_of
from skincad.mechanics.tiers.reached import relative_error, shortfalls
from skincad.mechanics.tiers.solid_level import (
    Layers,
    SolidSolution,
    check_size,
    coarse_sizes,
    forms_of,
    layers_of,
    solve_level,
    timed,
)

DEFAULT_TOLERANCE = 1e-2  # relative; finite strain changes more (docs/facts.md)
# What is left after order 3, of the difference to order 2; measured 0.15 to 0.45 on five pads (test_solid.py)
SECTION_TAIL = 0.6
LAYERS_TAIL = 1.0  # what is left after the finer layers, against their difference to the coarser


@dataclass(frozen=True)
class SolidRung:
    """A section mesh at `order - 1` and `order`, and layers against finer ones.

    `fineness` 1 is the coarsest mesh; `price` is its time as a multiple of the first rung's.
    """

    fineness: float
    order: int
    layers: Layers
    finer: Layers
    price: float


RUNGS = (
    SolidRung(1.0, 3, Layers(0.6, 2.0, 4), Layers(0.3, 1.8, 4), 1.0),
    SolidRung(1.5, 3, Layers(0.3, 1.8, 4), Layers(0.15, 1.8, 4), 5.0),
)


def answer(design: Design, request: Request, progress: Progress | None = None) -> Answer:
    """Return the solid tier's verdict on a design."""
    return solve(pad_of(design), request, progress)


def solve(pad: Pad, request: Request, progress: Progress | None = None) -> Answer:
    """Return touching ridges, all-touch force, approach and shares of a pad of finite length, with errors.

    The errors are those of discretisation alone: strains are taken as small. A budget ends the
    refinement; the coarsest mesh is always solved.
    """
    check_pad(pad)
    force, budget = request.force, request.budget
    wanted = request.tol or (DEFAULT_TOLERANCE if budget is None else 0.0)
    seconds: dict[str, float] = {}
    reached: Ascent[SolidRung, Answer, Answer] = climb(
        lambda refinement, _: _climb(pad, refinement, force, seconds, progress),
        RUNGS,
        lambda _, answer, __: (answer, relative_error(answer, force, unit_of(pad))),
        wanted,
        budget,
        began=perf_counter(),
        ends=(SizeError,),
        price=by_price,
    )
    warnings = shortfalls(reached.error, wanted, "", reached.spent, budget, "solid")
    return replace(reached.told, warnings=warnings, seconds=seconds)


def _climb(
    pad: Pad, refinement: SolidRung, force: float, seconds: dict[str, float], progress: Progress | None
) -> Answer:
    if progress:
        progress(f"solid tier: fineness {refinement.fineness:g}, order {refinement.order}")
    meshed = timed(seconds, "mesh", lambda: meshed_piece(pad, coarse_sizes(pad, refinement.fineness)))
    lower_forms = timed(seconds, "assemble", lambda: forms_of(meshed, refinement.order - 1))
    forms = timed(seconds, "assemble", lambda: forms_of(meshed, refinement.order))
    for section, line in ((lower_forms, refinement.finer), (forms, refinement.layers)):
        check_size(section, layers_of(meshed, line))  # of all that the rung solves, before the first
    lower = solve_level(meshed, lower_forms, refinement.layers, force, seconds)
    finer = solve_level(meshed, lower_forms, refinement.finer, force, seconds)
    best = solve_level(meshed, forms, refinement.layers, force, seconds)
    return _estimated(best, lower, finer)


def _estimated(best: SolidSolution, lower: SolidSolution, finer: SolidSolution) -> Answer:
    """Values of the best level and what finer layers change; errors from the order and from the layers.

    All ridges share the largest error among them: a single difference may vanish by chance.
    """

    def value(of: Callable[[SolidSolution], Array]) -> Array:
        return of(best) + of(finer) - of(lower)

    def error(of: Callable[[SolidSolution], Array]) -> float:
        section = float(np.abs(of(best) - of(lower)).max())
        return SECTION_TAIL * section + LAYERS_TAIL * float(np.abs(of(finer) - of(lower)).max())

    def estimate(of: Callable[[SolidSolution], Array], unit: str) -> Estimate:
        return Estimate(float(value(of)[0]), error(of), unit)

    threshold = Estimate(None, None, "N")
    if None not in [c.all_touch_force for c in (best, lower, finer)]:
        threshold = estimate(lambda c: np.array([c.all_touch_force], dtype=float), "N")
    shares, share_error = value(lambda c: c.ridge_force), error(lambda c: c.ridge_force)
    if (shares < 0).any():  # a ridge at the brink of touching
        shares = best.ridge_force
    return Answer(
        int(np.count_nonzero(shares > 0)),
        threshold,
        estimate(lambda c: np.array([c.approach]), "mm"),
        tuple(Estimate(float(f), share_error, "N") for f in shares),
        best.unknowns,
        max(c.residual for c in (best, lower, finer)),
        {},
    )
