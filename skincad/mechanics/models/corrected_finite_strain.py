"""Finite strain in the plane, corrected by the small-strain change to a solid pad.

The model corrected-finite-strain: the effect of free ends times the effect of finite strain. Each effect is
another model's. In three dimensions finite strain changes the all-touch force by 0.6 of its change in plane
strain, the approach by 0.86 (yamada-2002 and plain-ridges, by the model solid-finite-strain).
"""

from __future__ import annotations

import math

import numpy as np

from skincad.base.arrays import Array
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.mechanics.problem import Answer, Request

INTERACTION = 0.5  # of finite strain's change in plane strain: error, as free ends may alter it


def answer(
    design: Design,  # noqa: ARG001  as every model
    request: Request,
    progress: Progress | None,  # noqa: ARG001
    small: Answer,
    ends: Answer,
    finite: Answer,
) -> Answer:
    """Return `ends`, the corrected model's answer, times the ratio of finite to small strain in plane strain.

    `small` is the linear model's answer, `finite` that of finite strain. Errors of both changes add up, and
    PLANE of finite strain's change.
    """
    shares, error = _shares(small, ends, finite, request.force)
    return Answer(
        touching=int(np.count_nonzero(shares > 0)),
        all_touch_force=_product(small.all_touch_force, ends.all_touch_force, finite.all_touch_force),
        approach=_product(small.approach, ends.approach, finite.approach),
        ridge_force=tuple(Estimate(float(f), error, "N") for f in shares),
        unknowns=max(ends.unknowns, finite.unknowns),
        residual=max(ends.residual, finite.residual),
        seconds={**ends.seconds, "finite strain": math.fsum(finite.seconds.values())},
        warnings=tuple(dict.fromkeys((*ends.warnings, *finite.warnings))),
        fault=ends.fault,
        ridge_model=ends.ridge_model,
    )


def _product(small: Estimate, ends: Estimate, finite: Estimate) -> Estimate:
    if small.value is None or ends.value is None or finite.value is None:
        return Estimate(None, None, ends.unit)
    if small.value == 0.0:  # a single ridge touches at once
        return ends
    by_ends, by_strain = ends.value / small.value, finite.value / small.value
    error = (ends.error or 0.0) * by_strain + (finite.error or 0.0) * by_ends
    error += INTERACTION * abs(by_strain - 1) * ends.value
    return Estimate(ends.value * by_strain, error, ends.unit)


def _shares(small: Answer, ends: Answer, finite: Answer, force: float) -> tuple[Array, float]:
    """Shares by the sum of both differences, never negative, summing to the force; and their error."""
    before, by_ends, by_strain = (
        np.array([f.value or 0.0 for f in a.ridge_force]) for a in (small, ends, finite)
    )
    shares = np.maximum(by_ends + by_strain - before, 0.0)
    error = (ends.ridge_force[0].error or 0.0) + (finite.ridge_force[0].error or 0.0)
    return shares * (force / shares.sum()), error + INTERACTION * float(np.abs(by_strain - before).max())
