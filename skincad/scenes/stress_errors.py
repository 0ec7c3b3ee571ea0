"""How wrong a told ridge's differential stress may be, by source.

Mesh: the largest change to a march on the mesh before. Time step: the largest to one of fewer steps, at the
times that both have, before gross slip: from there on they tell of different states. That change itself is
taken, four times what it would be of first order in the step: points slip and stick from step to step, so the
order is lower. Of yamada-2002-slip with 110 steps the error, by 550, is 0.06 to 0.96 of the change; of
steady-pull and hold, looked at afterwards, 0.02 to 0.77. What is left out: the relative change of the ridges'
loads, taken to be the signal's, of its largest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from skincad.base.arrays import Array
from skincad.scenes.march import March
from skincad.scenes.refined import BySource, ComparisonRuns
from skincad.scenes.signals import gross_slip_step

Stress = Mapping[int, Array]  # MPa by told ridge, `(steps + 1,)`


def stress_errors(
    raw: Stress,
    mesh: Mapping[int, float] | None,
    refined: ComparisonRuns,
    stress: Callable[[March], Stress],
    change: float,
    drift: Mapping[int, float],
) -> dict[int, BySource]:
    """Return the errors of the stress `raw`, MPa, by told ridge: `mesh` is the mesh's, `stress` tells that of
    another march, `change` what is left out, `drift` what drifts between chosen steps."""
    fewer = _by_fewer(refined, stress)
    return {
        ridge: BySource(
            None if mesh is None else mesh.get(ridge),
            fewer.get(ridge),
            change * float(np.abs(values).max()),
            drift.get(ridge, 0.0),
        )
        for ridge, values in raw.items()
    }


def _by_fewer(refined: ComparisonRuns, stress: Callable[[March], Stress]) -> dict[int, float]:
    """The step's share by ridge; nothing where no march has fewer steps, or no step before gross slip."""
    every, thin = refined.every, refined.thin
    if every is None or thin is None:
        return {}
    end = min(_gross(every), _gross(thin))
    times, at, indices = np.intersect1d(every.time, thin.time, return_indices=True)
    at, indices = at[times < end], indices[times < end]
    one, other = stress(every), stress(thin)
    # both start unloaded: that they agree there says nothing
    return {r: float(np.abs(one[r][at] - other[r][indices]).max()) for r in one if at.size > 1}


def _gross(march: March) -> float:
    """When gross slip begins, s; never without it."""
    touches = np.array([reading.touches for reading in march.readings])
    slips = np.array([reading.slips for reading in march.readings])
    gross = gross_slip_step(touches, slips)
    return np.inf if gross is None else float(march.time[gross])
