"""Calibration: the constants within bounds whose gain is nearest to a curve, and what the curve leaves open.

The level is free: the paper's own curves differ by 166 dB. All constants are fitted as logarithms, the
motional capacitance as its ratio to the static one.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from skincad.base.errors import InputError, RefusedError
from skincad.base.interrupt import safe_point
from skincad.base.result import Record, item, record, reported
from skincad.circuit.network import MAY_BE_0, Constants, Real, network
from skincad.circuit.response import checked_frequencies, decibels, response

FITTED = tuple(field.name for field in fields(Constants) if field.name not in ("d33", *MAY_BE_0))
PAPER_CUTOFF, PAPER_BELOW, PAPER_ABOVE = 1200.0, 20.0, 60.0  # Hz, dB/dec; paper, section 3.2
PAPER_LOW, PAPER_HIGH = 10.0, 8000.0  # Hz; paper's sweep up to before its drop at 9 kHz
BOUNDS: dict[str, tuple[float, float]] = {
    # the loaded spot of 11.95 mm2 at 110 um and 1 pF of lead; 10 m of coaxial lead
    "capacitance": (12.5e-12, 1.1e-9),
    "motional_resistance": (1.0, 1e9),  # assumption: a wire to an insulator
    "motional_inductance": (1e-3, 1e4),  # assumption: resonances of grams to micrograms
    "motional_capacitance": (1e-6, 1e4),  # ratio to `capacitance`; assumption: no limit by the film
    "series_resistance": (10.0, 1e8),  # assumption: resistors one can buy
    "input_resistance": (1e5, 1e13),  # source: data sheets, bipolar to electrometer
    "input_capacitance": (0.5e-12, 100e-12),  # source: data sheets, with the board's
    "feedback_resistance": (1e2, 1e10),  # assumption: resistors one can buy
    "output_resistance": (1.0, 1e3),  # source: data sheets
    "gain": (1e2, 1e7),  # source: data sheets, 40 to 140 dB
}
STARTS, SEED = 24, 2002
STEPS = 300  # of a start; those that converged took up to 272 (the paper's and the shipped curves)
NEAR = 0.01  # of a bound's range in log: a constant so near to its end is reported as at it
OPEN = 0.1  # dB rms for a factor e: changes below it are smaller than what a curve is read to


@dataclass(frozen=True)
class Combination(Record):
    """Constants that move together, as exponents, and what a factor e along them changes, dB rms."""

    change: float = item("dB", "rms, by a factor e along them")
    exponents: dict[str, float] = item(meaning="of each constant")


@record()
class Calibration(Record):
    """The nearest constants; `offset` dB added to their gain gives the target's level, best in the mean."""

    constants: Constants
    rms: float = item("dB", "misfit")
    offset: float = item("dB", "added to the gain, it gives the target's level")
    at_bounds: tuple[str, ...] = item(meaning="constants at an end of their range")
    combinations: tuple[Combination, ...]  # all, the best fixed first
    agreeing: int = item(meaning="starts that ended within 1 % of the best rms", key="agreeing_starts")
    starts: int = item(meaning="how many there were")

    @reported(meaning="how many combinations the curve fixes")
    def fixed_combinations(self) -> int:
        """How many combinations the curve fixes."""
        return len(self.combinations) - len(self.open_combinations)

    @reported(meaning="those that it doesn't fix")
    def open_combinations(self) -> tuple[Combination, ...]:
        """The combinations that the curve does not fix."""
        return tuple(c for c in self.combinations if c.change < OPEN)


def calibrate(
    frequency: Real,
    gain: Real,
    *,
    d33: float = -33e-12,
    starts: int = STARTS,
    seed: int = SEED,
) -> Calibration:
    """Return the constants within `BOUNDS` nearest to a gain `(n,)` dB at `(n,)` Hz, up to its level.

    Least squares over the logarithms from `starts` points drawn evenly in them; the same seed gives the same
    answer. Of the converged starts the nearest between the points counts. Raises InputError for unusable
    points, RefusedError when no start converges.
    """
    frequency, gain = checked_frequencies(frequency), np.asarray(gain, float)
    if frequency.size < len(FITTED) or gain.shape != frequency.shape or not np.isfinite(gain).all():
        rule = f"must be at least {len(FITTED)} finite gains, one per frequency"
        raise InputError("measured", rule, gain.size)
    low, high = np.log([BOUNDS[name] for name in FITTED]).T

    def misfit(point: Real) -> Real:
        safe_point()
        rest = _distance(_constants(point, d33), frequency, gain)
        return np.asarray(rest - rest.mean())

    draw = np.random.default_rng(seed)
    # steps of 1e-6: the logarithms' own scale, so that differences keep about 9 digits
    options: dict[str, Any] = {"bounds": (low, high), "x_scale": "jac", "max_nfev": STEPS, "diff_step": 1e-6}
    runs = [least_squares(misfit, draw.uniform(low, high), **options) for _ in range(starts)]
    good = [run for run in runs if run.status > 0]
    if not good:
        raise RefusedError(f"the calibration converged from none of {starts} starts")
    best = min(good, key=lambda run: _between(_constants(run.x, d33), frequency, gain))
    near = NEAR * (high - low)
    at_bound = (best.x - low < near) | (high - best.x < near)
    constants = _constants(best.x, d33)
    return Calibration(
        constants=constants,
        rms=_rms(best.fun),
        offset=float(-_distance(constants, frequency, gain).mean()),
        at_bounds=tuple(name for name, at in zip(FITTED, at_bound, strict=True) if at),
        combinations=combinations(best.jac),
        agreeing=sum(_rms(run.fun) <= 1.01 * _rms(best.fun) for run in good),
        starts=starts,
    )


def combinations(jacobian: Real) -> tuple[Combination, ...]:
    """Return the principal combinations of a Jacobian `(n, 10)` in dB by the logarithms of `FITTED`.

    Its singular values over the root of n: how many dB rms a factor e (split over the constants as the
    exponents say) changes the curve, level aside.
    """
    _, sizes, rows = np.linalg.svd(jacobian, full_matrices=False)
    sizes = sizes / np.sqrt(jacobian.shape[0])
    return tuple(
        Combination(
            float(size),
            {n: round(float(e), 3) for n, e in zip(FITTED, row, strict=True) if abs(e) >= 0.1},
        )
        for size, row in zip(sizes, rows, strict=True)
    )


def _distance(c: Constants, frequency: Real, gain: Real) -> Real:
    return decibels(response(network(c), frequency)) - gain


def _between(c: Constants, frequency: Real, gain: Real) -> float:
    """Rms between the points too, with the motional branch's resonances: a sharp one could hide there."""
    low, high = float(frequency.min()), float(frequency.max())
    resonance = 1 / (2 * np.pi * np.sqrt(c.motional_inductance * c.motional_capacitance))
    both = resonance * np.sqrt(1 + c.motional_capacitance / c.capacitance)
    resonances = [f for f in (resonance, both) if low < f < high]
    fine = np.sort([*np.geomspace(low, high, 10 * frequency.size), *resonances])
    order = np.argsort(frequency)
    wanted = np.interp(np.log(fine), np.log(frequency[order]), gain[order])
    rest = _distance(c, fine, wanted)
    return _rms(rest - rest.mean())


def _constants(point: Real, d33: float) -> Constants:
    values = dict(zip(FITTED, np.exp(point).tolist(), strict=True))
    values["motional_capacitance"] *= values["capacitance"]
    return Constants(d33=d33, **values)


def _rms(values: Real) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
