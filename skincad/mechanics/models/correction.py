"""What an effect changes, from one coarse answer to another on the same mesh: the mesh's error cancels.

The change is applied to a fine answer of a model that leaves the effect out: free ends (corrected.py), finite
strain (solid_finite_strain.py), friction (friction.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array
from skincad.base.estimate import Estimate
from skincad.mechanics.bodies.mesh import PadPiece
from skincad.mechanics.contact.frictionless import Ridges, all_touch_force, press
from skincad.mechanics.problem import NEGLIGIBLE, Answer, wider_by


@dataclass(frozen=True)
class Errors:
    """Errors of a change: relative for approach and all-touch force, of a share in mean shares."""

    approach: float
    threshold: float
    share: float


NONE = Errors(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class LevelAnswer:
    """The verdict's numbers of one mesh for the whole pad, mm and N; `ridge_force` is `(ridges,)`, and
    `all_touch_force` None where it is out of range."""

    all_touch_force: float | None
    approach: float
    ridge_force: Array
    unknowns: int
    residual: float

    @property
    def touching(self) -> int:
        """Number of ridges that carry force somewhere along y."""
        return int(np.count_nonzero(self.ridge_force > 0))


def level_answer(
    meshed: PadPiece,
    ridges: Ridges,
    forces: Array,
    approach: float,
    first: float | None,
    *,
    scale: float,
    unknowns: int,
    residual: float,
) -> LevelAnswer:
    """Return the numbers of a contact with `forces` `(m,)` at its points and of the force at which all touch,
    `first`, from the piece's units; a force of 1 in them is `scale` N on the whole pad."""
    return LevelAnswer(
        all_touch_force=None if first is None else first * scale,
        approach=approach * meshed.unit,
        ridge_force=meshed.on_whole(ridges.sums(forces) * scale),
        unknowns=unknowns,
        residual=residual,
    )


def frictionless_level(
    meshed: PadPiece, ridges: Ridges, force: float, scale: float, unknowns: int, error: float = 0.0
) -> LevelAnswer:
    """Return the numbers of a pad pressed without friction at `force` N; `error` is the body's residual."""
    state = press(ridges.flexibility, ridges.gap, force / scale)
    first, residual = all_touch_force(ridges, force / scale), max(state.residual, error)
    by_force = state.force, state.approach, first
    return level_answer(meshed, ridges, *by_force, scale=scale, unknowns=unknowns, residual=residual)


@dataclass(frozen=True)
class Correction:
    """What an effect changes from `before` to `after`, with a `constant` error and one `by_change`.

    `ends` says whether both are solids with free ends, `out_of_range` why the latter's all-touch force is
    None.
    """

    before: LevelAnswer
    after: LevelAnswer
    constant: Errors
    by_change: Errors = NONE
    ends: bool = False
    out_of_range: str = ""

    @property
    def relative(self) -> Errors:
        """How much changes: of approach and all-touch force relative, of the share that changes most in mean
        shares. 0 without both forces."""
        before, after, by_force = self.before, self.after, 0.0
        if before.all_touch_force and after.all_touch_force:
            by_force = after.all_touch_force / before.all_touch_force - 1
        by_share = np.abs(after.ridge_force - before.ridge_force).max() / before.ridge_force.mean()
        return Errors(after.approach / before.approach - 1, by_force, float(by_share))

    @property
    def errors(self) -> Errors:
        """The change's own errors."""
        changes, constant, part = self.relative, self.constant, self.by_change
        return Errors(
            constant.approach + part.approach * abs(changes.approach),
            constant.threshold + part.threshold * abs(changes.threshold),
            constant.share + part.share * changes.share,
        )

    def applied(self, fine: Answer, force: float, errors: Errors | None = None) -> Answer:
        """Return a fine answer at `force` N with this change, known to its own or other `errors`.

        Approach and all-touch force change by a factor; shares by a difference, so that they still sum to the
        force. The mesh's error and the change's come from meshes that know nothing of each other: their
        squares add up (JCGM 100:2008, 5.1.2).
        """
        errors = errors or self.errors
        approach = self.after.approach / self.before.approach
        value, error = fine.approach.value or 0.0, fine.approach.error or 0.0
        shares = self._shares(fine)
        share_error = math.hypot(fine.ridge_force[0].error or 0.0, errors.share * force / len(shares))
        return Answer(
            touching=int(np.count_nonzero(shares > 0)),
            all_touch_force=self._threshold(fine, force, errors.threshold),
            approach=Estimate(value * approach, math.hypot(error, errors.approach * value) * approach, "mm"),
            ridge_force=tuple(Estimate(float(f), share_error, "N") for f in shares),
            unknowns=max(fine.unknowns, self.after.unknowns),
            residual=max(fine.residual, self.before.residual, self.after.residual),
            seconds={},
            fault=fine.fault,
            ridge_model=fine.ridge_model,
            contact_width=fine.contact_width and wider_by(fine.contact_width, approach),
        )

    def _threshold(self, fine: Answer, force: float, relative: float) -> Estimate:
        """The all-touch force times its ratio.

        A negligible one is replaced by the level's own, known to NEGLIGIBLE of the force.
        """
        value = fine.all_touch_force.value
        first, last = self.before.all_touch_force, self.after.all_touch_force
        if value is None or first is None or last is None:
            return Estimate(None, None, "N")
        if min(value, first) <= NEGLIGIBLE * force:
            return Estimate(last, NEGLIGIBLE * force if last else 0.0, "N")
        ratio = last / first
        error = math.hypot(fine.all_touch_force.error or 0.0, relative * value)
        return Estimate(value * ratio, error * ratio, "N")

    def _shares(self, fine: Answer) -> Array:
        """Changed shares: 0 where the last level's ridge is clear, never negative, summing to the force."""
        known = np.array([f.value or 0.0 for f in fine.ridge_force])
        shares = known + self.after.ridge_force - self.before.ridge_force
        shares = np.where(self.after.ridge_force > 0, np.maximum(shares, 0.0), 0.0)
        return np.asarray(shares * (known.sum() / shares.sum()))
