"""Small strain, plane strain: the law of every scene that names no other.

Range: nominal strains of a ridge up to about 0.1; the result's `left_out` says where a scene lies. The pad is
condensed once, so a step is a contact problem alone. Reference: the linear tier's verification table.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from skincad.effects.kinds import Law, Reading, Share, Step
from skincad.errors import RefusedError
from skincad.mechanics.frictional import halved
from skincad.mechanics.grip import Cone, Grip, Pressed, at_rest

if TYPE_CHECKING:
    from skincad.mechanics.film.stick import Part
    from skincad.mechanics.sliding import Sliding

Array = NDArray[np.float64]
FRICTIONLESS = Cone(0.0, 0.0)


class SmallStrain(Law):
    """Linear elasticity."""

    def model(self, part: Part, mesh: object, order: int, films: bool) -> Condensed:
        """Return the condensed pad."""
        from skincad.mechanics.sliding import sliding

        return condensed(sliding(part, mesh, order, films))


def condensed(pad: Sliding) -> Condensed:
    """Return the model of a condensed pad."""
    return Condensed(pad, Pressed(pad.compliance, pad.gap, np.zeros(2 * pad.gap.size)))


@dataclass(frozen=True, eq=False)
class Condensed:
    """A pad of constant compliance; its states are grips."""

    pad: Sliding
    skin: Pressed

    @property
    def ridge(self) -> NDArray[np.int64]:
        """Ridge of each contact point `(m,)`."""
        return self.pad.ridge

    @property
    def unknowns(self) -> int:
        """Number of free unknowns."""
        return self.pad.unknowns

    def start(self) -> Grip:
        """The unloaded state."""
        return at_rest(self.pad.gap.size)

    def advanced(self, state: Grip, step: Step, shares: Sequence[Share]) -> Grip:
        """Return the converged state at the step's end."""
        if any(share.more for share in shares):
            raise RefusedError("small_strain is quasi-static: it takes no share but friction's")
        cone = next((share.cone for share in shares if share.cone), FRICTIONLESS)
        with threadpool_limits(limits=1, user_api="blas"):  # more threads only wait for each other
            return halved(lambda _: self.skin, state, step.before, step.after, cone)

    def reading(self, before: Grip, state: Grip) -> Reading:
        """Return what is told of a state."""
        force = np.concatenate([state.tangential, -state.normal])
        mean = (before.tangential + state.tangential) / 2
        return Reading(
            float(state.normal.sum()),
            float(state.tangential.sum()),
            state.approach,
            state.travel,
            state.touches,
            state.slips,
            self.pad.strips @ force,
            float(force @ self.pad.compliance @ force) / 2,
            -float(mean @ state.slipped),
            state.residual,
        )
