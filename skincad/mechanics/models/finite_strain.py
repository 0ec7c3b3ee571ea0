"""Finite strain in the plane, on ever finer meshes.

The finite-strain model: plane strain of the silicone's law, neo-Hooke's where a design names none, under a
flat plate, and the error of each number. Levels and refinements are the linear model's, and so is the error:
two orders on one mesh (linear.py), and the clamped ends on top (EDGE_*). That it bounds the truth is measured
in its test. The pad's free ends are still left out.

Range: to where a ridge tips over under the plate or its tip folds (newton.py), 13 N in all on
docs/evidence/facts.md's section, or to where parts meet that the model does not know (plane_body.py).
Beyond it a force is refused. Below 1e-6 N rounding passes the residual's bound (newton.ROUNDING).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Progress, Stopwatch
from skincad.inputs.design import Design
from skincad.mechanics.bodies import elements, plane_body
from skincad.mechanics.bodies.condense import MOST_CONTACT_UNKNOWNS
from skincad.mechanics.bodies.mesh import PadPiece
from skincad.mechanics.bodies.plane_body import transferred
from skincad.mechanics.contact.frictionless import over_crests
from skincad.mechanics.contact.newton import (
    DivergedError,
    PadTangent,
    PressedPad,
    PressedState,
    press_to,
    press_until_all_touch,
)
from skincad.mechanics.models.correction import level_answer
from skincad.mechanics.models.linear import PlaneSolution, pressures, refine
from skincad.mechanics.problem import Answer, Pad, Request, check_flat, focused, pad_of

# Relative change by the small-strain law at the clamped ends (plane_body.body), taken as twice the change
# measured without it at 4, 6 and 9 N: 5e-5 of the all-touch force, 6e-5 to 3e-4 of approach and of the mean
# share
EDGE_THRESHOLD = 1e-4
EDGE_STATE = 6e-4
# Of a bare face's approach: flat-magnet's changes by 1.2e-3 at 4 N, and at 8 N by 3.3e-3 more with twice
# FACE_EDGE
FACE_STATE = 5e-3


def answer(design: Design, request: Request, progress: Progress | None = None) -> Answer:
    """Return the finite-strain model's verdict on a design."""
    return solve(focused(pad_of(design), request.force), request, progress)


def solve(pad: Pad, request: Request, progress: Progress | None = None) -> Answer:
    """Return touching ridges, all-touch force, approach and shares of a pad, with discretisation errors.

    `tol` and `budget` as in the linear model. Raises InputError for a force beyond the model's range. Where
    the force at which all touch is beyond it, that value is None and a warning says so.
    """
    check_flat(pad.plate, "finite-strain", "linear")
    result, best = refine(pad, request, level, "finite-strain", progress, MOST_CONTACT_UNKNOWNS)
    if best.out_of_range:
        result = replace(result, warnings=(*result.warnings, best.out_of_range))
    ridges = len(result.ridge_force)
    # error by the law at the clamped ends
    share = EDGE_STATE * request.force / ridges if ridges > 1 else 0.0
    return result.widened(EDGE_THRESHOLD, FACE_STATE if pad.face else EDGE_STATE, share)


@one_blas_thread()
def level(
    meshed: PadPiece,
    order: int,
    force: float,
    crest_offsets: tuple[float, ...] = (),
    before: PlaneSolution | None = None,
) -> PlaneSolution:
    """Solve one order at `force` N on the pad, crests lower than the section's by `crest_offsets` mm, from
    the states of a level `before` on the same mesh. Crest offsets need a mesh of the whole pad."""
    pad, unit, scale = meshed.whole, meshed.unit, meshed.scale
    states = before.states if before else None
    watch, guess, step = Stopwatch(), None, None
    with watch.stage("assemble"):
        mesh = states[0].mesh if states else elements.curved(meshed.mesh, order)
        mesh.Curve(max(3, order))
        low = np.array(crest_offsets) / unit if crest_offsets else None
        body = plane_body.body(mesh, order, pad.materials, pad.laws, pad.revolved, pad.face)
        problem = PressedPad(body, pad.top / unit, low)
    with watch.stage("newton"):
        if states:
            guess = transferred(states[0], states[1].values, body)
        state = at_force(problem, force / scale, scale, guess)
    with watch.stage("threshold"):
        if before and before.out_of_range:  # a higher order would only search for longer
            first, touching, beyond_reason = None, None, before.out_of_range
        else:
            if states and states[2]:
                # the step between two forces is smooth; what orders differ by at the corners is in `state`
                change = transferred(states[0], states[2].values - states[1].values, body)
                step = state.values + change
            first, touching, beyond_reason = all_touch(problem, state, scale, step)
    x, pressure = pressures(meshed, body.rest.nodes, state.contact.force)
    residual = max(s.contact.residual for s in (state, touching) if s)
    forces, unknowns = (state.contact.force, state.contact.approach, first), body.rest.unknowns
    answer = level_answer(meshed, state.ridges, *forces, scale=scale, unknowns=unknowns, residual=residual)
    return PlaneSolution(
        **vars(answer),
        x=x,
        pressure=pressure,
        seconds=watch.stages,
        ridges=state.ridges,
        unit=unit,
        scale=scale,
        out_of_range=beyond_reason,
        states=(body, state, touching),
    )


def at_force(
    problem: PressedPad,
    force: float,
    scale: float,
    guess: Array | None = None,
    rest: PadTangent | None = None,
) -> PressedState:
    """Return the state at `force`, from a guess or from `rest`; InputError beyond the model's range. A force
    of 1 is `scale` N."""
    reached = 0.0
    try:
        state = press_to(problem, force, guess, rest)
        wrong = _undetected_contact(problem, state)
    except DivergedError as failure:
        wrong, reached = str(failure), failure.reached
    if wrong is None:
        return state
    range_ = f" (up to about {reached * scale:.3g} N)" if reached else ""
    rule = f"must lie within the finite-strain model's range{range_}: {wrong}"
    remedy = "take a smaller force, or a harder silicone or wider ridges"
    raise InputError("force", rule, force * scale, remedy)


def _undetected_contact(problem: PressedPad, state: PressedState) -> str | None:
    """What touches without being in contact, of a part with its own crests too."""
    over = over_crests(state.tangent.ridges, problem.body.rest.nodes.position)
    plate = problem.top - state.contact.approach
    return problem.body.undetected_contact(state.values, plate, lambda x: over(x) - problem.top)


def all_touch(
    problem: PressedPad, state: PressedState, scale: float, guess: Array | None = None
) -> tuple[float | None, PressedState | None, str]:
    """Return the force at which all ridges touch with its state, or None and why there is none; 0 for a
    single ridge, which needs no state. `state` is one nearby."""
    if state.ridges.numbers.size == 1:
        return 0.0, None, ""
    reached = state.force
    try:
        touching = press_until_all_touch(problem, state, guess)
        wrong = _undetected_contact(problem, touching)
        if wrong is None:
            return touching.force, touching, ""
    except DivergedError as failure:
        wrong, reached = str(failure), failure.reached or reached
    words = "the force at which all ridges touch is beyond the finite-strain model's range "
    return None, None, f"{words}(looked up to {reached * scale:.3g} N): {wrong}"
