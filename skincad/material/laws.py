"""Which law of rubber follows a bar's test: each fitted to its first half, and judged by its second.

A law with more constants fits the rows that it was fitted to as well or better; beyond them it may not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import optimize

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError
from skincad.base.result import Record, item
from skincad.inputs.measurements import FEWEST_ROWS, MaterialTest
from skincad.laws import LAWS, law
from skincad.laws.rubber import Candidate, Rubber

COMPARED_STRAIN = 1.0  # strain up to which laws are compared; assumption: no ridge is strained by more
FITTED_SHARE = 0.5  # of the range that is judged; the rest was not fitted to
SHORTEST_REACH = 0.4  # strain; assumption: a shorter test says too little of what lies beyond it
TIE_FACTOR = 1.1  # errors up to this multiple of the least one tie; then the fewest constants win
PENALTY = 1e3  # of the largest stress: residual of constants that are no rubber's


@dataclass(frozen=True)
class FittedLaw(Record):
    """A law fitted to the rows up to `reach` (strain), and its residuals, rms over the largest stress.

    The law is fitted to the first half of the strains: `rms_seen` is of these rows, `rms_judged` of those
    beyond.
    """

    name: str = item(meaning="of the law")
    law: Rubber = item(meaning="its constants")
    constants: int = item(meaning="how many there are")
    rms_seen: float = item(meaning="over the largest stress, of the rows that it was fitted to")
    rms_judged: float = item(meaning="over the largest stress, of those beyond")
    reach: float = item(meaning="the largest strain used", key="reach_strain")
    best: bool = item(meaning="whether it is the best", default=False)


def compare_laws(test: MaterialTest, up_to: float | None = None) -> tuple[tuple[FittedLaw, ...], str]:
    """Return the laws, the best first, then by their residual, and a note on those that do not fit.

    No laws are returned if the test is too short.

    `test` is a bar's, all of it; `up_to` is the largest strain used, JUDGED if None.
    """
    strain = np.abs(test.deformation)
    reach = min(up_to or COMPARED_STRAIN, float(strain.max()))
    seen, used = strain <= FITTED_SHARE * reach, strain <= reach
    if reach < SHORTEST_REACH or min(seen.sum(), (used & ~seen).sum()) < FEWEST_ROWS:
        return (
            (),
            f"laws are compared by bars strained to {SHORTEST_REACH:g} or more: this says the modulus alone",
        )
    fits = {
        candidate.name: _fit_and_judge(candidate, test, seen, used, reach)
        for kind in LAWS
        for candidate in law(kind).candidates()
    }
    fitted = [fit for fit in fits.values() if fit is not None]
    left_out = ", ".join(name for name, fit in fits.items() if fit is None)
    note = f"fitted to these rows it is no rubber, or ends before they do: {left_out}" if left_out else ""
    if not fitted:
        return (), note
    least = min(fit.rms_judged for fit in fitted)
    good = [fit for fit in fitted if fit.rms_judged <= TIE_FACTOR * least + 1e-9]
    best = min(good, key=lambda fit: (fit.constants, fit.rms_judged))
    rest = sorted((fit for fit in fitted if fit is not best), key=lambda fit: fit.rms_judged)
    return (replace(best, best=True), *rest), note


def _fit_and_judge(
    candidate: Candidate, test: MaterialTest, seen: Mask, used: Mask, reach: float
) -> FittedLaw | None:
    first, whole = (_fitted(candidate, test, rows) for rows in (seen, used))
    if first is None or whole is None:
        return None
    within, outside = (_relative_rms(first, test, rows) for rows in (seen, used & ~seen))
    if not np.isfinite(outside):  # it ends before the test
        return None
    return FittedLaw(candidate.name, whole, len(candidate.start), within, outside, reach)


def _relative_rms(law: Rubber, test: MaterialTest, rows: Mask) -> float:
    """Root mean square of a law's residuals over the largest stress of these rows."""
    load = test.load[rows]
    off = law.stress(1 + test.deformation[rows]) - load
    return float(np.sqrt(np.mean(off**2)) / np.abs(load).max())


def _fitted(candidate: Candidate, test: MaterialTest, rows: Mask) -> Rubber | None:
    """The law by least squares on some rows, or None without convergence or with constants of no rubber."""
    stretch, load = 1 + test.deformation[rows], test.load[rows]
    plain = stretch - stretch**-2
    scale = float(load @ plain / (plain @ plain))  # neo-Hooke's shear modulus, which makes the start's 1 MPa
    wanted = load / scale

    def off(numbers: Array) -> Array:
        try:
            stress = candidate.make(numbers).stress(stretch)
        except InputError:
            return np.full(stretch.size, PENALTY)
        return np.where(np.isfinite(stress), stress - wanted, PENALTY)

    start = np.array(candidate.start)
    solution = optimize.least_squares(
        off, start, x_scale=np.maximum(np.abs(start), 0.1), xtol=1e-12, ftol=1e-12
    )
    try:
        return candidate.make(solution.x).scaled(scale) if solution.success else None
    except InputError:
        return None
