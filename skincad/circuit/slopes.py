"""Cut-off and the two slopes of a gain curve: two straight lines in log f that meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.circuit.elements import Real

GRID = 200  # corners that are tried before the best is refined
EDGE = 0.1  # of the span in log f: nearer to an end a corner has no line of its own to stand on
RANGES = ((0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (0.1, 0.1))  # left out at either end, of the span in log f
BEND = 3.0  # slopes must differ by this many dB/dec and this many errors, else there is no corner
FEWEST = 20


@dataclass(frozen=True)
class Slopes:
    """The fitted corner; `cutoff` is none for a curve without one. `rms` is the curve's distance, dB."""

    cutoff: Estimate  # Hz
    below: Estimate  # dB/dec
    above: Estimate  # dB/dec
    level: float  # dB, of the lines at the cut-off, or of the one line at its middle
    rms: float


@dataclass(frozen=True)
class _Lines:
    corner: float  # log10 of Hz
    level: float
    below: float
    above: float
    rms: float
    errors: Real  # of corner, below, above


def fit_slopes(frequency: Real, gain: Real, low: float, high: float, source: str = "sweep.points") -> Slopes:
    """Return corner and slopes from `low` to `high` Hz of a gain `(n,)` in dB at `(n,)` Hz, rising.

    Least squares over level, corner and two slopes, points weighted evenly in log f. The error is the root
    of squares of twice the fit's standard error (its residuals run together: each run of one sign counts as
    one point) and the largest change when a tenth of the range is left out at either end or both.
    Raises InputError, in the name of `source`, for fewer than 20 points in the range.
    """
    inside = (frequency >= low) & (frequency <= high)
    x, y = np.log10(frequency[inside]), gain[inside]
    if x.size < FEWEST:
        raise InputError(source, f"must give at least {FEWEST} from {low:g} to {high:g} Hz", x.size)
    if (np.diff(x) <= 0).any():
        raise InputError("frequency", "must rise")
    fits = [_two_lines(*_part(x, y, *ends)) for ends in RANGES]
    best = fits[0]
    corners = np.array([[10**f.corner, f.below, f.above] for f in fits])
    fitted = 2 * best.errors * [np.log(10) * corners[0, 0], 1.0, 1.0]
    errors = np.hypot(fitted, np.abs(corners - corners[0]).max(axis=0))
    bend = abs(best.above - best.below)
    if bend < max(BEND, float(np.hypot(errors[1], errors[2]))):
        return _one_line(x, y)
    return Slopes(
        Estimate(float(corners[0, 0]), float(errors[0]), "Hz"),
        Estimate(best.below, float(errors[1]), "dB/dec"),
        Estimate(best.above, float(errors[2]), "dB/dec"),
        best.level,
        best.rms,
    )


def _part(x: Real, y: Real, first: float, last: float) -> tuple[Real, Real]:
    span = x[-1] - x[0]
    inside = (x >= x[0] + first * span) & (x <= x[-1] - last * span)
    return x[inside], y[inside]


def _weights(x: Real) -> Real:
    """Square roots of each point's share of the range, mean square 1."""
    share = np.gradient(x)
    return np.asarray(np.sqrt(share / share.mean()))


def _columns(x: Real, corner: float) -> Real:
    return np.column_stack([np.ones_like(x), np.minimum(x - corner, 0.0), np.maximum(x - corner, 0.0)])


def _two_lines(x: Real, y: Real) -> _Lines:
    weight = _weights(x)

    def solved(corner: float) -> tuple[Real, Real]:
        columns = _columns(x, corner)
        part = np.asarray(np.linalg.lstsq(weight[:, None] * columns, weight * y, rcond=None)[0], float)
        return part, y - columns @ part

    def cost(corner: float) -> float:
        return float(((weight * solved(corner)[1]) ** 2).sum())

    span = x[-1] - x[0]
    grid = np.linspace(x[0] + EDGE * span, x[-1] - EDGE * span, GRID)
    nearest = grid[np.argmin([cost(c) for c in grid])]
    step = grid[1] - grid[0]
    corner = float(minimize_scalar(cost, bounds=(nearest - step, nearest + step), method="bounded").x)
    (level, below, above), rest = solved(corner)
    # the corner's own column of the Jacobian, for the joint covariance
    slope = np.where(x < corner, -below, -above)
    jacobian = weight[:, None] * np.column_stack([slope, _columns(x, corner)])
    runs = max(5, 1 + int((np.diff(np.sign(rest)) != 0).sum()))  # 5: one more than what is fitted
    variance = float((weight**2 * rest**2).mean()) * x.size / runs
    covariance = variance * np.linalg.pinv(jacobian.T @ jacobian)
    deviations = np.sqrt(np.clip(np.diag(covariance), 0.0, None))[[0, 2, 3]]
    rms = float(np.sqrt((weight**2 * rest**2).mean()))
    return _Lines(corner, float(level), float(below), float(above), rms, deviations)


def _one_line(x: Real, y: Real) -> Slopes:
    """The one slope of a curve without a corner; its error is the largest change over the ranges."""
    slopes = [np.polyfit(*_part(x, y, *ends), 1, w=_weights(_part(x, y, *ends)[0])) for ends in RANGES]
    values = [float(s[0]) for s in slopes]
    rest = y - np.polyval(slopes[0], x)
    slope = Estimate(values[0], max(abs(v - values[0]) for v in values), "dB/dec")
    middle = float(np.polyval(slopes[0], 0.5 * (x[0] + x[-1])))
    return Slopes(Estimate(None, None, "Hz"), slope, slope, middle, float(np.sqrt((rest**2).mean())))
