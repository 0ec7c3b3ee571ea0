"""The silicone's modulus from a test, by regression."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy import optimize, stats

from skincad.base.arrays import Array
from skincad.base.errors import RefusedError
from skincad.base.estimate import Estimate
from skincad.base.result import Result, item, record, reported
from skincad.base.tables import NumberWithRange
from skincad.inputs.measurements import FEWEST_ROWS, MaterialTest
from skincad.inputs.silicone import SOFTEST, STIFFEST, Silicone
from skincad.laws.neo_hooke import NeoHooke
from skincad.laws.rubber import Rubber
from skincad.material.laws import FittedLaw

CONFIDENCE = 0.95
LEAST_FREEDOM = (
    2.0  # degrees of freedom, at least; assumption: with one, a residual of 0.3 % would be worth 6 % of E
)
MOST_CORRELATED = 0.999  # of lag 1, so that a smooth misfit keeps a finite interval


@dataclass(frozen=True)
class Regression:
    """Parameters `(p,)` and the half-widths `(p,)` of their 95 % intervals; `rms` in the measured unit.

    `residual` `(n,)` is the model less what was measured, `correlation` that of successive ones.
    """

    values: Array
    half_width: Array
    rms: float
    correlation: float
    residual: Array


def regression(model: Callable[[Array], Array], start: Array, measured: Array) -> Regression:
    """Return the parameters for which `model(parameters)` `(n,)` is nearest to `measured` `(n,)`.

    Residuals in the order of the test are taken as a first-order autoregression of correlation r: n rows are
    worth n (1 - r) / (1 + r) independent ones, which widens the covariance and lowers Student's degrees of
    freedom (Bartlett, J. R. Stat. Soc. 98 (1935) 536; Bayley and Hammersley, Suppl. J. R. Stat. Soc. 8 (1946)
    184). A negative r counts as 0. Raises RefusedError when the fit fails or does not fix a parameter.
    """
    solution = optimize.least_squares(
        lambda p: model(p) - measured, start, x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12
    )
    n, p = measured.size, start.size
    normal = solution.jac.T @ solution.jac
    if not solution.success or np.linalg.cond(normal / np.outer(*[np.sqrt(normal.diagonal())] * 2)) > 1e12:
        raise RefusedError("the rows do not determine the modulus; measure over a larger range of load")
    correlation = _lag_one(solution.fun)
    independent = max(n * (1 - correlation) / (1 + correlation), p + LEAST_FREEDOM)
    variance = solution.fun @ solution.fun / (n - p) * n / independent
    spread = np.sqrt(variance * np.linalg.inv(normal).diagonal())
    quantile = stats.t.ppf((1 + CONFIDENCE) / 2, independent - p)
    rms = float(np.sqrt(np.mean(solution.fun**2)))
    width = np.asarray(quantile * spread)
    return Regression(solution.x, width, rms, correlation, np.asarray(solution.fun))


def _lag_one(residuals: Array) -> float:
    """Correlation of successive residuals, its bias of a short row put right to first order.

    E[r] = rho - (1 + 3 rho) / n: Kendall, Biometrika 41 (1954) 403.
    """
    n, power = residuals.size, float(residuals @ residuals)
    if power == 0.0:
        return 0.0
    biased = float(residuals[1:] @ residuals[:-1]) / power
    return float(np.clip((biased + 1 / n) / (1 - 3 / n), 0.0, MOST_CORRELATED))


MOST_MISSED = 0.1  # of the largest load, beyond the rows that a law was fitted to
LARGEST_RMS = 0.05  # of the largest load; assumption: a curve that fits worse is not this model's
LARGEST_ERROR = 0.5  # of the modulus; a wider interval says nothing of use
RANDOM = 0.5  # correlation of successive residuals; assumption: less is scatter, more a curve of another form
LOADED_SHARE = 0.05  # of the largest load, from which a row counts as one under load

Fit = Callable[[MaterialTest], Regression]


@dataclass(frozen=True)
class PartModulus:
    """Young's modulus, MPa, fitted to the rows of a part of the test, its error the 95 % scatter.

    The part is that of deformations from `start` to `end`: strain, or mm of approach as in the file.
    """

    start: float
    end: float
    young_modulus: Estimate


@record()
class MaterialFit(Result):
    """Young's modulus at small strain, with the half-width of its 95 % interval: the sum of `scatter`,
    `model` and `misfit`. `rms` and `largest_load` are N of a pad, MPa of a bar; `curve` is deformation, load
    and the model's load, `(rows_used,)` each."""

    shown_by = "skincad.outputs.measurements:FIT"
    kind: str = item(meaning="of the test: bar or pad")
    rows: int = item(meaning="of the file")
    rows_used: int = item(meaning="that the fit took")
    young_modulus: Estimate = item("MPa", "at small strain")
    scatter: float = item("MPa", "the error's part by the rows' scatter")
    model: float = item("MPa", "the error's part by the model")
    misfit: float = item("MPa", "the error's part by the change over the test's parts")
    parts: tuple[PartModulus, ...]
    offset: Estimate | None
    zero: Estimate | None = item(
        meaning="strain at which a bar begins to bear, null where it is the file's zero", key="zero_strain"
    )
    rms: float
    largest_load: float
    correlation: float = item(meaning="of neighbouring residuals", key="residual_correlation")
    seconds: dict[str, float] = item(meaning="wall time by stage, s")
    warnings: tuple[str, ...] = item(meaning="what to know of the numbers")
    curve: tuple[Array, Array, Array] = field(compare=False)
    laws: tuple[FittedLaw, ...] = item(
        meaning="compared by a bar that was strained enough, the best first", default=()
    )

    @reported(meaning="that there is a fit")
    def passed(self) -> bool:
        """Whether there is a fit: a test without one is refused."""
        return True

    @reported(meaning="the modulus as a design takes it, in MPa", inline=True)
    def _range(self) -> dict[str, float]:
        return {"low_MPa": self.ranged.low, "high_MPa": self.ranged.high}

    @reported("mm", "of a pad's approach at the first touch", key="offset_mm")
    def _offset(self) -> Estimate:
        return self.offset or Estimate(None, None, "mm")

    @reported(meaning="the modulus by parts of the test; loads", inline=True)
    def _by_kind(self) -> dict[str, Any]:
        load, deformation = ("N", "approach_mm") if self.kind == "pad" else ("MPa", "strain")
        return {
            "parts": [
                {deformation: [part.start, part.end], "young_modulus_MPa": part.young_modulus}
                for part in self.parts
            ],
            f"rms_residual_{load}": self.rms,
            f"largest_load_{load}": self.largest_load,
        }

    def columns(self) -> dict[str, Any]:
        """Return a row for each row of the test that was used: deformation, load, and the model's load."""
        deformation, load = ("approach_mm", "force_N") if self.kind == "pad" else ("strain", "stress_MPa")
        return dict(zip((deformation, load, f"model_{load}"), self.curve, strict=True))

    @property
    def law(self) -> Rubber | None:
        """The law that follows a bar's test best, None where that is neo-Hooke's or laws are not compared."""
        best = next((fit.law for fit in self.laws if fit.best), None)
        return None if isinstance(best, NeoHooke) else best

    @property
    def ranged(self) -> NumberWithRange:
        """The modulus as a design's `[material]` takes it, low and high rounded outwards."""
        value, error = self.young_modulus.value or 0.0, self.young_modulus.error or 0.0
        digits = min(10, max(1 - int(np.floor(np.log10(max(error, 1e-4 * value)))), 0))
        tenth = 10.0**-digits
        low = np.floor((value - error) / tenth * (1 + 1e-12)) * tenth
        high = np.ceil((value + error) / tenth * (1 - 1e-12)) * tenth
        said = float(f"{value:.4g}") if self.law else round(value, digits)  # a law's goes with its constants
        return NumberWithRange(value=said, low=round(float(low), digits), high=round(float(high), digits))


def with_laws(fit: MaterialFit, laws: tuple[FittedLaw, ...], note: str) -> MaterialFit:
    """Return a bar's fit with its laws and what is said of them. The modulus is that of the best one, which a
    design gets: what it differs by from the slope's is misfit."""
    notes = [note] if note else []
    if laws and laws[0].rms_judged > MOST_MISSED:
        notes.append(
            f"no law follows these rows: the best misses {laws[0].rms_judged:.0%} of the largest stress "
            "beyond the strains that it was fitted to; take a smaller up_to"
        )
    fit = replace(fit, laws=laws, warnings=(*fit.warnings, *notes))
    if fit.law is None:
        return fit
    own = fit.law.young_modulus(Silicone().poisson_ratio)
    off = abs(own - (fit.young_modulus.value or 0.0))
    error = (fit.young_modulus.error or 0.0) + off
    return replace(fit, young_modulus=Estimate(own, error, "MPa"), misfit=fit.misfit + off)


def material_fit(
    test: MaterialTest,
    whole: Regression,
    modulus: float,
    model: float,
    fit: Fit,
    per_value: float,
    misfit: float | None = None,
    touch: float = 0.0,
) -> MaterialFit:
    """Return the result with the parts of its error; `fit(rows).values[0] * per_value` is E, MPa, of a part.
    The misfit is that of the parts unless given. `touch` is the deformation from which the sample bears.

    Raises RefusedError for a residual, an interval or a modulus that is no good.
    """
    modulus, largest = float(modulus), float(np.abs(test.load).max())
    refuse_misfit(test, whole)
    scatter = float(whole.half_width[0]) * per_value
    parts = tuple(_halves(test, touch, fit, per_value))
    misfit = _misfit(parts, modulus) if misfit is None else float(misfit)
    error = scatter + model + misfit
    if not error <= LARGEST_ERROR * modulus:
        raise RefusedError(f"the rows do not determine the modulus: {Estimate(modulus, error, 'MPa')}")
    if modulus - error <= SOFTEST or modulus + error >= STIFFEST:
        raise RefusedError(
            f"the modulus {modulus:.3g} MPa is outside what a design takes, {SOFTEST:g} to {STIFFEST:g}"
        )
    return MaterialFit(
        kind=test.kind,
        rows=test.rows,
        rows_used=test.load.size,
        young_modulus=Estimate(modulus, error, "MPa"),
        scatter=scatter,
        model=model,
        misfit=misfit,
        parts=parts,
        offset=None,
        zero=None,
        rms=whole.rms,
        largest_load=largest,
        correlation=whole.correlation,
        seconds={},
        warnings=(),
        curve=(test.deformation, test.load, test.load + whole.residual),
    )


def refuse_misfit(test: MaterialTest, fit: Regression) -> None:
    """Raise RefusedError where a fit leaves too much of the loads, and that is no scatter of rows."""
    unit, largest = "N" if test.kind == "pad" else "MPa", float(np.abs(test.load).max())
    if fit.rms > LARGEST_RMS * largest and fit.correlation >= RANDOM:
        share = f"{fit.rms / largest:.0%} of the largest load ({LARGEST_RMS:.0%} is the most)"
        raise RefusedError(
            f"the {test.kind} test does not follow the model: the residual is {fit.rms:.3g} {unit} rms, "
            f"{share}; {_cause(fit)}"
        )


def _cause(fit: Regression) -> str:
    """What to do about a misfit, by where it is."""
    size, third = np.abs(fit.residual), max(1, fit.residual.size // 3)
    if size[-third:].mean() >= size[:third].mean():
        return "try a smaller up_to"
    return "it is in the first rows: tare the load cell, and leave out rows before the sample bears"


def _misfit(parts: tuple[PartModulus, ...], modulus: float) -> float:
    """Error of the modulus, MPa: what the halves' differ from it by beyond their scatter."""
    if not parts:
        return 0.0
    values = [part.young_modulus.value or 0.0 for part in parts]
    return max(
        0.0, *(abs(v - modulus) - (p.young_modulus.error or 0.0) for v, p in zip(values, parts, strict=True))
    )


def _halves(test: MaterialTest, touch: float, fit: Fit, per_value: float) -> list[PartModulus]:
    """The modulus over the first and the second half of the deformation under load."""
    end = float(test.deformation[np.argmax(np.abs(test.deformation))])
    middle = (touch + end) / 2
    first = np.abs(test.deformation - touch) <= abs(middle - touch)
    parts = []
    for side, start, stop in ((first, touch, middle), (~first, middle, end)):
        rows = replace(test, deformation=test.deformation[side], load=test.load[side])
        if np.count_nonzero(np.abs(rows.load) >= LOADED_SHARE * np.abs(test.load).max()) < FEWEST_ROWS:
            return []
        try:
            solution = fit(rows)
        except RefusedError:
            return []
        value, error = float(solution.values[0]) * per_value, float(solution.half_width[0]) * per_value
        parts.append(PartModulus(start, stop, Estimate(value, error, "MPa")))
    return parts
