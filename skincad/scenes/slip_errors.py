"""How wrong the time of a slip may be, by source: the mesh, the time step, and what the scene leaves out.

Mesh and time step: the change to a march on the mesh before, and to one of fewer steps. What is left out: an
effect that changes a ridge's load by a share c lets it slip when it bears 1 / (1 + c) of what it bore at its
slip without that effect. How long before the slip the ridge bore that much is how far the slip may move; the
same is taken for later. Range: marches whose tangential load grows towards the slip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skincad.base.arrays import Array
from skincad.base.estimate import Estimate
from skincad.mechanics.contact.friction_law import law_of
from skincad.mechanics.contact.grip import Cone
from skincad.scenes.march import March
from skincad.scenes.signals import Slips, slips_of

THIN = 5  # steps of a march that are one of the march with fewer; error taken as of first order in the step


class SlipError(NamedTuple):
    """Of a slip's time, or of a lead, ms; a source that nobody asked is None."""

    mesh: float | None
    time_step: float | None
    left_out: float

    @property
    def total(self) -> float | None:
        """The sum; None where the mesh's or the step's share is unknown."""
        return (
            None
            if self.mesh is None or self.time_step is None
            else self.mesh + self.time_step + self.left_out
        )

    def as_json(self) -> dict[str, float | None]:
        """Return it under JSON keys."""
        return self._asdict()


@dataclass(frozen=True, eq=False)
class Refined:
    """Marches to hold a march against: `before` on the mesh before; `every` on the coarsest mesh, and `thin`
    there with fewer steps. None where there is none."""

    before: March | None = None
    every: March | None = None
    thin: March | None = None


def thinned(steps: int, points: Array) -> Array:
    """Return the steps `(k,)` of a march with fewer steps: every THIN-th, and those at the history's
    `points`, given in steps."""
    named = np.concatenate([np.arange(0, steps + 1, THIN), np.rint(points).astype(int), [steps]])
    return np.unique(np.clip(named, 0, steps))


def slip_errors(
    found: March, slips: Slips, refined: Refined, change: float, driven: bool, cone: Cone
) -> list[SlipError]:
    """Return the error of each ridge's lead, ms, in order; `change` is the relative change of loads by what
    is left out, `driven` whether the plate's travel is given: gross slip hangs on the skin then."""
    count = len(slips.steps)
    own, before, every, thin = (
        None if march is None else _leads(march, count)
        for march in (found, refined.before, refined.every, refined.thin)
    )
    time, loads = found.time, found.loads
    gross = spread(time, loads.sum(axis=2), slips.gross, change, cone) if driven else 0.0
    return [
        SlipError(
            _apart(own, before, ridge),
            _by_step(found, _apart(every, thin, ridge)),
            spread(time, loads[:, :, ridge], step, change, cone) + gross,
        )
        for ridge, step in enumerate(slips.steps)
    ]


def lead(time: Array, gross: int | None, step: int | None, error: float | None) -> Estimate:
    """Return by how many ms a slip comes before gross slip; of no value without one of them."""
    if gross is None or step is None:
        return Estimate(None, None, "ms")
    return Estimate(1e3 * float(time[gross] - time[step]), error, "ms")


def _leads(march: March, ridges: int) -> Array:
    """Leads in ms `(ridges,)`; NaN where a ridge does not slip for good, from the end without gross slip."""
    slips = slips_of(march.readings, march.ridge, ridges)
    end = march.time[-1] if slips.gross is None else march.time[slips.gross]
    at = [math.nan if step is None else float(march.time[step]) for step in slips.steps]
    return 1e3 * (float(end) - np.array(at))


def _apart(one: Array | None, other: Array | None, ridge: int) -> float | None:
    """By how much two marches' leads differ; a slip that one of them has not is as far off as the lead."""
    if one is None or other is None:
        return None
    a, b = np.nan_to_num([one[ridge], other[ridge]])
    return abs(float(a - b))


def _by_step(found: March, change: float | None) -> float | None:
    """The step's own error: of first order, and at least a step."""
    least = 1e3 * float(found.time[1] - found.time[0]) if found.time.size > 1 else 0.0
    return None if change is None else max(least, change / (THIN - 1))


def spread(time: Array, loads: Array, step: int | None, change: float, cone: Cone) -> float:
    """Return for how long before a slip, ms, a ridge stood at least at what slips once its load is larger by
    `change`: by `loads` `(steps + 1, 3)`, normal and tangential N and what touches, mm2, and the friction of
    the `cone`."""
    if step is None or change == 0.0:
        return 0.0
    normal, tangential, area = loads.T
    touches = (normal > 0) & (area > 0)
    borne = law_of(cone, np.where(touches, area, 1.0)).borne(np.where(touches, normal, 1.0))
    used = np.where(touches, np.abs(tangential) / borne, 0.0)
    low = np.flatnonzero(used[: step + 1] < used[step] / (1 + change))
    first = int(low[-1]) + 1 if low.size else 0
    return 1e3 * float(time[step] - time[min(first, step)])
