"""Which law of rubber follows a bar's test: each fitted to its first half, and judged by its second.

A law with more constants fits the rows that it was fitted to as well or better; beyond them it may not.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy import optimize

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError
from skincad.inputs.material_test import FEWEST_ROWS, MaterialTest
from skincad.laws import LAWS, law
from skincad.laws.rubber import Candidate, Rubber

JUDGED = 1.0  # strain up to which laws are compared; assumption: no ridge is strained by more
FITTED = 0.5  # of the range that is judged; the rest was not fitted to
LEAST_REACH = 0.4  # strain; assumption: a shorter test says too little of what lies beyond it
AS_GOOD = 1.1  # times the least error is as good: then the fewest constants win
FAR = 1e3  # of the largest stress: what constants are given that are no rubber's


@dataclass(frozen=True)
class FittedLaw:
    """A law fitted to the rows up to `reach` (strain), and what it misses, rms by the largest stress.

    `seen` by its fit to the first half of the strains, of these; `judged` of the rows beyond them.
    """

    name: str
    law: Rubber
    constants: int
    seen: float
    judged: float
    reach: float
    best: bool = field(default=False)

    def as_json(self) -> dict[str, Any]:
        """Return a row of the comparison."""
        return {
            "name": self.name,
            "law": self.law.model_dump(),
            "constants": self.constants,
            "rms_seen": self.seen,
            "rms_judged": self.judged,
            "reach_strain": self.reach,
            "best": self.best,
        }


def compared(test: MaterialTest, up_to: float | None = None) -> tuple[tuple[FittedLaw, ...], str]:
    """Return the laws, first the best, then by what they miss, and what is to be said of those that are not
    among them; none where the test is too short.

    `test` is a bar's, all of it; `up_to` is the largest strain used, JUDGED if None.
    """
    strain = np.abs(test.deformation)
    reach = min(up_to or JUDGED, float(strain.max()))
    seen, used = strain <= FITTED * reach, strain <= reach
    if reach < LEAST_REACH or min(seen.sum(), (used & ~seen).sum()) < FEWEST_ROWS:
        return (
            (),
            f"laws are compared by bars strained to {LEAST_REACH:g} or more: this says the modulus alone",
        )
    tried = {
        candidate.name: _judged(candidate, test, seen, used, reach)
        for kind in LAWS
        for candidate in law(kind).candidates()
    }
    found = [each for each in tried.values() if each is not None]
    left_out = ", ".join(name for name, each in tried.items() if each is None)
    said = f"fitted to these rows it is no rubber, or ends before they do: {left_out}" if left_out else ""
    if not found:
        return (), said
    least = min(each.judged for each in found)
    good = [each for each in found if each.judged <= AS_GOOD * least + 1e-9]
    best = min(good, key=lambda each: (each.constants, each.judged))
    rest = sorted((each for each in found if each is not best), key=lambda each: each.judged)
    return (replace(best, best=True), *rest), said


def _judged(
    candidate: Candidate, test: MaterialTest, seen: Mask, used: Mask, reach: float
) -> FittedLaw | None:
    first, whole = (_fitted(candidate, test, rows) for rows in (seen, used))
    if first is None or whole is None:
        return None
    within, beyond = (_missed(first, test, rows) for rows in (seen, used & ~seen))
    if not np.isfinite(beyond):  # it ends before the test
        return None
    return FittedLaw(candidate.name, whole, len(candidate.start), within, beyond, reach)


def _missed(law: Rubber, test: MaterialTest, rows: Mask) -> float:
    """Root mean square of what a law misses, by the largest stress of these rows."""
    load = test.load[rows]
    off = law.bar(1 + test.deformation[rows]) - load
    return float(np.sqrt(np.mean(off**2)) / np.abs(load).max())


def _fitted(candidate: Candidate, test: MaterialTest, rows: Mask) -> Rubber | None:
    """The law by least squares on some rows, or None where that has no end or no rubber's constants."""
    stretch, load = 1 + test.deformation[rows], test.load[rows]
    plain = stretch - stretch**-2
    scale = float(load @ plain / (plain @ plain))  # neo-Hooke's shear modulus, which makes the start's 1 MPa
    wanted = load / scale

    def off(numbers: Array) -> Array:
        try:
            stress = candidate.make(numbers).bar(stretch)
        except InputError:
            return np.full(stretch.size, FAR)
        return np.where(np.isfinite(stress), stress - wanted, FAR)

    start = np.array(candidate.start)
    found = optimize.least_squares(off, start, x_scale=np.maximum(np.abs(start), 0.1), xtol=1e-12, ftol=1e-12)
    try:
        return candidate.make(found.x).scaled(scale) if found.success else None
    except InputError:
        return None
