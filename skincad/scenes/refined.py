"""Marches that one is held against, and an error by source: the mesh, the time step, what is left out, and
what drifts where the skin is linear between chosen steps (mechanics/contact/held.py).

Mesh and time step: the change to a march on the mesh before, and to one of fewer steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skincad.base.arrays import Index
from skincad.scenes.march import March

THIN = 5  # steps of a march that are one of the march with fewer
LONGER = 2.0  # such a step's time, by that of one of the THIN: 1.7 to 3.2, measured on four scenes


class BySource(NamedTuple):
    """An error, in the unit of what is wrong by it; a source that nobody asked is None."""

    mesh: float | None
    time_step: float | None
    left_out: float
    drift: float = 0.0

    @property
    def total(self) -> float | None:
        """The sum; None where the mesh's or the step's share is unknown."""
        if self.mesh is None or self.time_step is None:
            return None
        return self.mesh + self.time_step + self.left_out + self.drift

    def as_json(self) -> dict[str, float | None]:
        """Return it under JSON keys."""
        return self._asdict()

    def with_total(self) -> dict[str, float | None]:
        """Return it under JSON keys, the sum too."""
        return {**self._asdict(), "total": self.total}


@dataclass(frozen=True, eq=False)
class ComparisonRuns:
    """Marches to hold a march against: `before` on the mesh before; `every` on the coarsest mesh, and `thin`
    there with fewer steps; `after` is the one on the finer mesh, where the march in question is by another
    model. None where there is none."""

    before: March | None = None
    after: March | None = None
    every: March | None = None
    thin: March | None = None


def thinned(steps: int, points: Index) -> Index:
    """Return the steps `(k,)` of a march with fewer steps: every THIN-th, those at the history's `points`,
    and the last."""
    return np.unique(np.concatenate([np.arange(0, steps + 1, THIN), points, [steps]]))
