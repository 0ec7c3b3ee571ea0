"""The Winkler tier: each ridge a spring of its own, in closed form.

It ranks designs in microseconds. It leaves out that ridges push each other down through the common
base, so against plane strain F9 comes out 25 to 35 % low (FACTS.md), more on thick skins.

A skin that is curved along y too is a row of such springs along every ridge: the gap grows with the angle
about the axis and the force is its integral. The springs stay vertical, which is wrong by half the square
of the slope at the contact's end.
"""

from __future__ import annotations

import math
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from skincad.catalog import silicone
from skincad.design import Design
from skincad.mechanics.plate import rise
from skincad.mechanics.problem import Answer, Request
from skincad.mechanics.validity import LARGEST_STRAIN, STEEPEST
from skincad.quantities import Estimate
from skincad.stopwatch import Progress

Array = NDArray[np.float64]

# Half-widths against the linear tier, measured over the variants of tests/mechanics/test_winkler.py and 40
# random designs (tests/benchmarks/error_bars.py): F9 inside in 97 %, 3.6 times too wide in the median, the
# approach in all, 3 times
THRESHOLD_ERROR = 0.8  # of F9: 25 to 35 % low at usual sizes, 43 % at twice the thickness
PER_THICKNESS, THICK = 1.6, 0.6  # more of F9, per thickness in widths above this one
APPROACH_ERROR, PER_RIDGE = 0.45, 1.1  # of the approach, and by the number of ridges: few press into a base
SHARE_ERROR = 0.5  # of the mean share
# The same for a skin curved along y, against a straight solid under the same gaps, small strain: F9 0.72 to
# 2.07 times, approach 0.88 to 1.53 times, shares 0.17 of their mean off, in 47 cases, R_y 15 mm to infinity
DOUBLY_THRESHOLD_ERROR, DOUBLY_APPROACH_ERROR, DOUBLY_SHARE_ERROR = 1.2, 0.6, 0.3
NODES = 10  # Gauss points along half a ridge; exact to rounding below 90 degrees
TINY = 1e-300  # mm; the root's relative tolerance counts


def ridge_stiffness(design: Design) -> float:
    """Return one ridge's stiffness, N/mm: its part of the base and the ridge itself in series.

    k = L / (n T / (E' W) + h / (E' w)) with E' = E / (1 - nu^2), w the ridge's mean width.
    Johnson, Contact Mechanics, 1985, sec. 4.3 (elastic foundation).
    """
    skin, ridge, stuff = design.skin, design.ridge, silicone(design.material)
    plane = stuff.young_modulus.value / (1 - stuff.poisson_ratio**2)
    base = ridge.count * skin.thickness / (plane * skin.width)
    return skin.length / (base + 2 * ridge.height / (plane * (ridge.root_width + ridge.tip_width)))


def crest_gaps(design: Design) -> Array:
    """Return how far each crest is from the plate when the first one touches, `(ridges,)` mm."""
    radius = design.skin.curvature_radius + design.ridge.height
    lean = np.array([design.lean(i + 1) for i in range(design.ridge.count)])
    gap = 2 * radius * np.sin(lean / 2) ** 2 + rise(design.contact.plate, radius * np.sin(lean))
    return np.asarray(gap - gap.min())


def line_forces(design: Design, approach: float) -> Array:
    """Return each ridge's force, N, `(ridges,)` at an approach in mm after the first touch."""
    depth = np.maximum(approach - crest_gaps(design), 0.0)
    stiffness, radius = ridge_stiffness(design), design.skin.curvature_radius_y
    if radius is None:
        return np.asarray(stiffness * depth)
    arm, reach = _crest_arms(design), _contact_angles(design, depth)
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    angle = reach[:, None] * (nodes + 1) / 2
    spring = depth[:, None] - 2 * arm[:, None] * np.sin(angle / 2) ** 2
    per_angle = stiffness * radius / design.skin.length
    return np.asarray(per_angle * reach * (spring @ weights))  # both halves of y


def _crest_arms(design: Design) -> Array:
    """Distance of each crest from the axis of the second curvature, `(ridges,)` mm."""
    skin, height = design.skin, design.ridge.height
    lean = np.array([design.lean(i + 1) for i in range(design.ridge.count)])
    fall = 2 * (skin.curvature_radius + height) * np.sin(lean / 2) ** 2
    return np.asarray((skin.curvature_radius_y or math.inf) + height - fall)


def _contact_angles(design: Design, depth: Array) -> Array:
    """Angle, rad, up to which each ridge touches when its middle is pressed in by `depth` `(ridges,)` mm."""
    end = design.skin.length / 2 / (design.skin.curvature_radius_y or math.inf)
    aside = np.sqrt(depth / (2 * _crest_arms(design)))
    return np.asarray(np.minimum(2 * np.arcsin(np.minimum(aside, 1.0)), end))


def _approach(design: Design, force: float) -> float:
    """The approach, mm, at which the ridges carry `force` N: their sum grows with it without bound."""
    high = force / ridge_stiffness(design)
    while line_forces(design, high).sum() < force:
        high *= 2
    root = optimize.brentq(lambda d: float(line_forces(design, d).sum()) - force, 0.0, high, xtol=TINY)
    return float(root)


def answer(design: Design, request: Request, progress: Progress | None = None) -> Answer:
    """Return the Winkler verdict on a design; the error is the model's, whatever the tolerance asked."""
    if progress:
        progress("winkler tier: closed form")
    if design.skin.curvature_radius_y is not None:
        return _doubly_curved(design, request.force)
    started, force = perf_counter(), request.force
    stiffness, gaps = ridge_stiffness(design), crest_gaps(design)
    threshold = stiffness * float((gaps.max() - gaps).sum())
    order = np.sort(gaps)
    carried = stiffness * (order * np.arange(1, order.size + 1) - np.cumsum(order))
    count = int(np.searchsorted(carried, force, side="left"))
    approach = (force / stiffness + float(order[:count].sum())) / count
    shares = stiffness * np.maximum(approach - gaps, 0.0)
    error = SHARE_ERROR * force / gaps.size
    return Answer(
        int(np.count_nonzero(shares > 0)),
        Estimate(threshold, threshold_error(design) * threshold, "N"),
        Estimate(approach, (APPROACH_ERROR + PER_RIDGE / gaps.size) * approach, "mm"),
        tuple(Estimate(float(f), error, "N") for f in shares),
        gaps.size,
        abs(float(shares.sum()) / force - 1),
        {"contact": perf_counter() - started},
        ("winkler tier: ridges are taken as independent springs, slots and film are left out",),
    )


def threshold_error(design: Design) -> float:
    """Return the relative half-width of F9: ridges push each other down the more, the thicker their base."""
    thick = design.skin.thickness / design.skin.width
    return THRESHOLD_ERROR + PER_THICKNESS * max(0.0, thick - THICK)


def _doubly_curved(design: Design, force: float) -> Answer:
    """The verdict on a skin that is curved along y too."""
    started = perf_counter()
    gaps, approach = crest_gaps(design), _approach(design, force)
    threshold = float(line_forces(design, float(gaps.max())).sum())
    shares = line_forces(design, approach)
    slope = _end_slope(design, approach)
    error = DOUBLY_SHARE_ERROR * force / gaps.size
    return Answer(
        int(np.count_nonzero(shares > 0)),
        Estimate(threshold, DOUBLY_THRESHOLD_ERROR * threshold, "N"),
        Estimate(approach, DOUBLY_APPROACH_ERROR * approach, "mm"),
        tuple(Estimate(float(f), error, "N") for f in shares),
        gaps.size,
        abs(float(shares.sum()) / force - 1),
        {"contact": perf_counter() - started},
        (
            "winkler tier: ridges are taken as rows of independent springs, slots and film are left out",
            f"contact is taken as vertical: at slopes along y up to {slope:.2g}, {slope**2 / 2:.1%} off",
        ),
        fault=_beyond(design, min(approach, float(gaps.max()) or approach)),
    )


def _beyond(design: Design, approach: float) -> str:
    """Say that at this approach a ridge's middle is crushed, by its force per length over E' and its width,
    or that the contact's end slopes too much."""
    stuff, ridge = silicone(design.material), design.ridge
    plane = stuff.young_modulus.value / (1 - stuff.poisson_ratio**2)
    width = (ridge.root_width + ridge.tip_width) / 2
    strain = ridge_stiffness(design) * approach / (plane * width * design.skin.length)
    if strain > LARGEST_STRAIN:
        return f"a ridge's middle is strained by {strain:.2g} (the range ends at {LARGEST_STRAIN:g})"
    slope = _end_slope(design, approach)
    return (
        f"the contact's end slopes by {slope:.2g} (the range ends at {STEEPEST:g})"
        if slope > STEEPEST
        else ""
    )


def _end_slope(design: Design, approach: float) -> float:
    """Slope along y where the contact of the first ridge ends."""
    return math.sin(float(_contact_angles(design, np.maximum(approach - crest_gaps(design), 0.0)).max()))
