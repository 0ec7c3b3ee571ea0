"""The corrected tier: the fine plane-strain answer, and what the free ends change, from a coarse solid.

Both sides of the change are solved on one coarse mesh of the section, so the mesh's error cancels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from skincad.design import Design
from skincad.errors import InputError
from skincad.mechanics import linear
from skincad.mechanics.problem import Answer, Pad, Request, pad_of
from skincad.mechanics.solid_level import Layers, Level, coarse_sizes, forms_of, meshed_part, pressed, timed
from skincad.quantities import Estimate
from skincad.stopwatch import Progress

Array = NDArray[np.float64]

FLOOR = 0.01  # of the force; an F9 below it is as good as nothing
ORDER = 2
LAYERS = Layers(0.6, 2.0, 4)
MOST_FILLET = 0.25  # of the tip's width; smaller fillets change the ratio less than its error

# Errors of the change itself. Measured against a finer solid on three templates (test_solid.py) and eight
# variants of length, thickness, height, fillet and Poisson's ratio: at most 0.26 %, 0.5 % and 0.41 %
APPROACH_ERROR = 0.005  # of the approach
THRESHOLD_ERROR = 0.01  # of F9
SHARE_ERROR = 0.01  # of the mean share


@dataclass(frozen=True)
class Ends:
    """The coarse answers in plane strain and with free ends, on the same section mesh."""

    plane: Level
    solid: Level


def answer(design: Design, request: Request, progress: Progress | None = None) -> Answer:
    """Return the linear tier's verdict on a design, corrected for its free ends.

    Errors are the linear tier's discretisation error plus that of the change. The change is meant for
    strains as small as the linear tier's.
    """
    started = perf_counter()
    fine = linear.solve(pad_of(design), replace(request, spread=None), progress)
    if progress:
        progress("corrected tier: coarse solid with free ends")
    seconds = dict(fine.seconds)
    spent: dict[str, float] = {}
    ends = free_ends(plain_pad(design), request.force, spent)
    seconds["solid"] = math.fsum(spent.values())
    found = _corrected(fine, ends, request.force)
    warnings = list(fine.warnings)
    wanted = request.tol or 0.0
    reached = max(APPROACH_ERROR, THRESHOLD_ERROR, SHARE_ERROR)
    if 0 < wanted < reached:
        warnings.append(
            f"the free ends' change is known to {reached:g}: the asked {wanted:.1e} needs --tier solid"
        )
    if request.budget is not None and perf_counter() - started > request.budget:
        warnings.append(f"the coarse solid overran the budget of {request.budget:g} s")
    return replace(found, warnings=tuple(warnings), seconds=seconds)


def plain_pad(design: Design) -> Pad:
    """Return the pad without small fillets, which take most of the triangles and leave the change alone."""
    ridge = design.ridge
    if ridge.tip_fillet > MOST_FILLET * ridge.tip_width:
        return pad_of(design)
    try:
        return pad_of(design.with_(ridge={"tip_fillet": 0.0, "root_fillet": 0.0}))
    except InputError:  # a slot that clears the fillet but not the sharp corner
        return pad_of(design)


def free_ends(pad: Pad, force: float, seconds: dict[str, float], along: Layers = LAYERS) -> Ends:
    """Return the coarse answers at `force` N in plane strain and with free ends."""
    meshed = timed(seconds, "mesh", lambda: meshed_part(pad, coarse_sizes(pad, 1.0)))
    forms = timed(seconds, "assemble", lambda: forms_of(meshed, ORDER))
    plane = pressed(meshed, forms, None, force, seconds)
    return Ends(plane, pressed(meshed, forms, along, force, seconds))


def _corrected(fine: Answer, ends: Ends, force: float) -> Answer:
    """Approach and F9 change by a factor; shares by a difference, so that they still sum to the force."""
    approach = ends.solid.approach / ends.plane.approach
    value, error = fine.approach.value or 0.0, fine.approach.error or 0.0
    shares = _shares(fine, ends)
    share_error = (fine.ridge_force[0].error or 0.0) + SHARE_ERROR * force / len(shares)
    return Answer(
        int(np.count_nonzero(shares > 0)),
        _threshold(fine, ends, force),
        Estimate(value * approach, (error + APPROACH_ERROR * value) * approach, "mm"),
        tuple(Estimate(float(f), share_error, "N") for f in shares),
        max(fine.unknowns, ends.solid.unknowns),
        max(fine.residual, ends.plane.residual, ends.solid.residual),
        {},
    )


def _threshold(fine: Answer, ends: Ends, force: float) -> Estimate:
    """F9 times its ratio; where it is next to nothing, the solid's own value, known to FLOOR of the force."""
    value, plane, solid = fine.all_touch_force.value, ends.plane.all_touch_force, ends.solid.all_touch_force
    if value is None or plane is None or solid is None:
        return Estimate(None, None, "N")
    if min(value, plane) <= FLOOR * force:
        return Estimate(solid, FLOOR * force if solid else 0.0, "N")
    ratio = solid / plane
    error = (fine.all_touch_force.error or 0.0) + THRESHOLD_ERROR * value
    return Estimate(value * ratio, error * ratio, "N")


def _shares(fine: Answer, ends: Ends) -> Array:
    """Shares with free ends: none where the solid's ridge is clear, never a pull, in sum the force."""
    before = np.array([f.value or 0.0 for f in fine.ridge_force])
    after = before + ends.solid.ridge_force - ends.plane.ridge_force
    after = np.where(ends.solid.ridge_force > 0, np.maximum(after, 0.0), 0.0)
    return np.asarray(after * (before.sum() / after.sum()))
