"""Properties of a process from a measured coupon: growth, narrowest gap, scatter and offset of crests.

Each number has the half-width of its 95 % interval.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr
from scipy.stats import chi2, t

from skincad.base.arrays import Array
from skincad.base.estimate import Estimate
from skincad.inputs.measurements import CrestForm, NotchForm

CONFIDENCE = 0.95
SCATTERS = np.geomspace(0.001, 0.05, 24)  # mm, of one notch's width; assumption: no process is outside
LOSS_RANGE, LOSS_STEP = 0.15, 0.0005  # mm, of the losses of width that are weighed, about a first guess
FEWEST_OPEN = 3  # notches; assumption: fewer leave growth and scatter unknown
# mm, by which a notch is wider or narrower than the blade that just slides in it; assumption: half of a
# blade's own tolerance. The same for all notches, so that their number does not lessen it
BLADE_TOLERANCE = 0.002
LEAST_LIKELIHOOD = 1e-300  # a likelihood


class NotchResult(NamedTuple):
    """What a ladder says, mm: material's growth a side, one notch's scatter, the narrowest gap that works.

    Growth is None where too few notches are open, the gap where none is. `worst` is a side's largest error.
    """

    growth: Estimate | None
    scatter: float
    gap: Estimate | None
    worst: float


@dataclass(frozen=True)
class CrestResult:
    """What steps say, mm: a crest's standard deviation, how much all are too high, and the largest error."""

    sigma: Estimate
    offset: Estimate
    worst: float


def notch_result(form: NotchForm) -> NotchResult:
    """Return growth, scatter and narrowest gap by the blades that go into the notches or stop."""
    open_ = form.goes > 0
    middle = (form.goes + form.stops) / 2
    sides = np.abs(form.drawn - middle)[open_] / 2
    worst, gap = float(sides.max(initial=0.0)), _gap(form)
    if np.count_nonzero(open_) < FEWEST_OPEN:
        return NotchResult(None, 0.0, gap, worst)
    lost, half, scatter = _loss(form, float(np.median((form.drawn - middle)[open_])))
    return NotchResult(Estimate(lost / 2, (half + BLADE_TOLERANCE) / 2, "mm"), scatter, gap, worst)


def _loss(form: NotchForm, guess: float) -> tuple[float, float, float]:
    """How much narrower than drawn notches are, its half-width, and their scatter: means of the posterior.

    A notch is as wide as drawn, less the loss, plus its own normal error; a blade says between which two
    thicknesses it lies, and no blade at all says below which. Loss and the logarithm of the scatter have flat
    priors. Censored observations in a likelihood: Gelman et al., Bayesian Data Analysis, 3rd ed. 2013, 8.1.
    """
    losses = np.arange(guess - LOSS_RANGE, guess + LOSS_RANGE, LOSS_STEP)
    low = np.where(form.goes > 0, form.goes, -np.inf) - form.drawn
    high = form.stops - form.drawn
    width = SCATTERS[:, None, None]
    inside = ndtr((high + losses[:, None]) / width) - ndtr((low + losses[:, None]) / width)
    logs = np.log(np.maximum(inside, LEAST_LIKELIHOOD)).sum(axis=2)
    weight = np.exp(logs - logs.max())
    weight /= weight.sum()
    loss_weight, scatters = weight.sum(axis=0), weight.sum(axis=1)
    mean = float(loss_weight @ losses)
    tail = (1 - CONFIDENCE) / 2
    ends = np.interp([tail, 1 - tail], np.cumsum(loss_weight), losses)
    return mean, float(max(mean - ends[0], ends[1] - mean)), float(scatters @ SCATTERS)


def _gap(form: NotchForm) -> Estimate | None:
    """The narrowest notch that is open as all wider ones are; the next one may be the limit as well."""
    order = np.argsort(form.drawn)
    drawn, shut = form.drawn[order], np.flatnonzero(form.goes[order] <= 0)
    first = int(shut[-1]) + 1 if shut.size else 0
    if first == drawn.size:
        return None
    step = float(drawn[first] - drawn[first - 1]) if first else float(np.diff(drawn).max())
    return Estimate(float(drawn[first]), step, "mm")


def crest_result(form: CrestForm) -> CrestResult:
    """Return scatter and offset of crests; a tilt of the block, which lay askew, is taken out first.

    Crests of one height share what layers make of it: variance between heights and within them is by one-way
    analysis of variance, the degrees of freedom of their sum by Satterthwaite, Biometrics Bulletin 2 (1946)
    110.
    """
    heights, group = np.unique(form.drawn, return_inverse=True)
    off = form.measured - form.drawn
    level = off - _tilt(form.place, off, group) * (form.place - form.place.mean())
    counts = np.bincount(group)
    means = np.bincount(group, level) / counts
    repeats = float(heights.size / np.sum(1 / counts))  # harmonic mean; all alike where nothing is missing
    inner = off.size - heights.size - 1  # degrees of freedom, one less for the tilt
    within = float(np.sum((level - means[group]) ** 2)) / inner
    between = float(means.var(ddof=1)) * repeats
    shares = np.array([between / repeats, within * (1 - 1 / repeats)])
    variance, outer = float(shares.sum()), heights.size - 1
    free = variance**2 / float(np.sum(shares**2 / [outer, inner])) if variance else float(inner)
    sigma = float(np.sqrt(variance))
    upper = sigma * float(np.sqrt(free / chi2.ppf((1 - CONFIDENCE) / 2, free)))
    spread = np.sqrt(max(between, within) / (repeats * heights.size))
    half = float(t.ppf((1 + CONFIDENCE) / 2, outer) * spread)
    return CrestResult(
        Estimate(sigma, upper - sigma, "mm"),
        Estimate(float(means.mean()), half, "mm"),
        float(np.abs(level).max()),
    )


def _tilt(place: Array, off: Array, group: NDArray[np.signedinteger[Any]]) -> float:
    """How fast heights change along the block, mm a step, by least squares within each height."""
    counts = np.bincount(group)
    x = place - (np.bincount(group, place) / counts)[group]
    y = off - (np.bincount(group, off) / counts)[group]
    return float(x @ y / (x @ x)) if x.any() else 0.0
