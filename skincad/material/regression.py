"""Least squares through a test curve, with intervals that correlated residuals don't shrink."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import optimize, stats

from skincad.base.arrays import Array
from skincad.base.errors import RefusedError

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
