"""The Winkler tier: each ridge a spring of its own, in closed form.

It ranks designs in less than a millisecond. It leaves out that ridges push each other down through the common
base, so the all-touch force is 25 to 35 % below plane strain (docs/facts.md), more on thick skins;
winkler_error.py says how far off it may be.

A skin that is curved along y too is a row of such springs along every ridge: the gap grows with the angle
about the axis and the force is its integral. The springs stay vertical, which is wrong by half the square
of the slope at the contact's end.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from time import perf_counter

import numpy as np
from scipy import optimize

from skincad.base.arrays import Array
from skincad.base.estimate import Estimate
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.mechanics.plate import rise
from skincad.mechanics.problem import Answer, Request
from skincad.mechanics.tiers.winkler_error import compliances, crown_height_spread, half_widths, share_error
from skincad.mechanics.validity import LARGEST_SLOPE, LARGEST_STRAIN, plane_modulus
from skincad.shape.skin import skin_of

NODES = 10  # Gauss points along half a ridge; exact to rounding below 90 degrees
TINY = 1e-300  # mm; the root's relative tolerance counts


def ridge_stiffness(design: Design) -> float:
    """Return the median ridge's stiffness, N/mm: its part of the base and the ridge itself in series.

    k = L / (n T / (E' W) + h / (E' w)) with E' = E / (1 - nu^2), w the ridge's mean width.
    Johnson, Contact Mechanics, 1985, sec. 4.3 (elastic foundation).
    """
    return plane_modulus(design) * design.skin.length / math.fsum(compliances(design))


def relative_stiffness(design: Design) -> Array:
    """Return each ridge's stiffness over the median ridge's `(ridges,)`: higher ones are softer."""
    usual = math.fsum(compliances(design))
    return np.array([usual / math.fsum(compliances(design, height)) for height in skin_of(design).heights])


def crest_gaps(design: Design) -> Array:
    """Return how far each crest is from the plate when the first one touches, `(ridges,)` mm."""
    gap = crest_depths(design)
    return np.asarray(gap - gap.min())


def crest_depths(design: Design) -> Array:
    """Return how far each crest is from a plate that touches the highest ridge on the axis, were there one:
    fall of the base circle, rise of the plate, lack of height, `(ridges,)` mm."""
    skin = skin_of(design)
    heights = np.array(skin.heights)
    radius = design.skin.curvature_radius + heights
    lean = np.array([skin.lean(i + 1) for i in range(skin.count)])
    return np.asarray(2 * radius * np.sin(lean / 2) ** 2 + plate_rises(design) + heights.max() - heights)


def plate_rises(design: Design) -> Array:
    """Return the plate's height over a flat plate at each crest, `(ridges,)` mm."""
    skin = skin_of(design)
    radius = design.skin.curvature_radius + np.array(skin.heights)
    lean = np.array([skin.lean(i + 1) for i in range(skin.count)])
    return np.asarray(rise(design.contact.plate, radius * np.sin(lean)))


def all_touch_force(design: Design) -> float:
    """Return the force at which all ridges touch, N."""
    return float(line_forces(design, float(crest_gaps(design).max())).sum())


def line_forces(design: Design, approach: float, factor: float = 1.0) -> Array:
    """Return each ridge's force, N, `(ridges,)` at an approach in mm after the first touch, springs being
    stiffer by `factor`."""
    depth = np.maximum(approach - crest_gaps(design), 0.0)
    stiffness, radius = stiffnesses(design, factor), design.skin.curvature_radius_y
    if radius is None:
        return np.asarray(stiffness * depth)
    arm, reach = _crest_arms(design), _contact_angles(design, depth)
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    angle = reach[:, None] * (nodes + 1) / 2
    spring = depth[:, None] - 2 * arm[:, None] * np.sin(angle / 2) ** 2
    per_angle = stiffness * radius / design.skin.length
    return np.asarray(per_angle * reach * (spring @ weights))  # both halves of y


def stiffnesses(design: Design, factor: float = 1.0) -> Array:
    """Each ridge's stiffness, `(ridges,)` N/mm, all stiffer by `factor`."""
    return np.asarray(factor * ridge_stiffness(design) * relative_stiffness(design))


def _crest_arms(design: Design) -> Array:
    """Distance of each crest from the axis of the second curvature, `(ridges,)` mm."""
    skin, height = design.skin, np.array(skin_of(design).heights)
    lean = np.array([skin_of(design).lean(i + 1) for i in range(skin_of(design).count)])
    fall = 2 * (skin.curvature_radius + height) * np.sin(lean / 2) ** 2
    return np.asarray((skin.curvature_radius_y or math.inf) + height - fall)


def _contact_angles(design: Design, depth: Array) -> Array:
    """Angle, rad, up to which each ridge touches when its middle is pressed in by `depth` `(ridges,)` mm."""
    half_sine = np.sqrt(depth / (2 * _crest_arms(design)))
    return np.asarray(np.minimum(2 * np.arcsin(np.minimum(half_sine, 1.0)), _end_angle(design)))


def _end_angle(design: Design) -> float:
    """Angle, rad, from a curved skin's middle to its end."""
    return design.skin.length / 2 / (design.skin.curvature_radius_y or math.inf)


def _approach(design: Design, force: float, factor: float = 1.0) -> float:
    """The approach, mm, at which the ridges carry `force` N: their sum grows with it without bound."""
    stiffness = factor * ridge_stiffness(design)
    if design.skin.curvature_radius_y is None:
        gaps, times = crest_gaps(design), relative_stiffness(design)
        first = np.argsort(gaps, kind="stable")
        order, all_of = gaps[first], np.cumsum(times[first])
        carried = stiffness * (order * all_of - np.cumsum(times[first] * order))
        count = int(np.searchsorted(carried, force, side="left"))
        behind = float((times[first] * order)[:count].sum())
        return (force / stiffness + behind) / float(all_of[count - 1])
    high = force / stiffness
    while line_forces(design, high, factor).sum() < force:
        high *= 2
    root = optimize.brentq(
        lambda d: float(line_forces(design, d, factor).sum()) - force, 0.0, high, xtol=TINY
    )
    return float(root)


def answer(design: Design, request: Request, progress: Progress | None = None) -> Answer:
    """Return the Winkler verdict on a design; the error is the model's and ignores the tolerance."""
    if progress:
        progress("winkler tier: closed form")
    started, force = perf_counter(), request.force
    gaps, approach = crest_gaps(design), _approach(design, force)
    doubly, last = design.skin.curvature_radius_y is not None, float(gaps.max())
    threshold = all_touch_force(design)
    shares = line_forces(design, approach)
    depth = np.maximum(approach - gaps, 0.0)
    touched = _contact_angles(design, depth) / _end_angle(design) if doubly else depth > 0
    line = depth * relative_stiffness(design) / math.fsum(compliances(design))
    widths = half_widths(design, line, approach, float(touched.sum()), last)
    missed = widths.threshold * threshold
    missed += (1 + widths.threshold) * (
        float(line_forces(design, last + crown_height_spread(design)).sum()) - threshold
    )
    reached = widths.approach * approach
    others = [line_forces(design, _approach(design, force, f), f) for f in (widths.stiffer, widths.softer)]
    for moved in _step_moved(design):
        others += [
            line_forces(moved, _approach(moved, force, f), f) for f in (1, widths.stiffer, widths.softer)
        ]
        missed = max(missed, (1 + widths.threshold) * all_touch_force(moved) - threshold)
        reached = max(reached, (1 + widths.approach) * _approach(moved, force) - approach)
    error = share_error(widths, shares, tuple(others))
    return Answer(
        int(np.count_nonzero(shares > 0)),
        Estimate(threshold, missed, "N"),
        Estimate(approach, reached, "mm"),
        tuple(Estimate(float(f), error, "N") for f in shares),
        gaps.size,
        abs(float(shares.sum()) / force - 1),
        {"contact": perf_counter() - started},
        tuple(_left_out(design, approach)),
        fault=_out_of_range(design, min(approach, last or approach)) if doubly else "",
    )


def _step_moved(design: Design) -> Iterator[Design]:
    """Yield the design with a plate's step moved by half a tip either way: a tip that the edge meets touches
    with its lower part alone then, or with its higher part alone. A spring knows only one of them."""
    skin = skin_of(design)
    plate = design.contact.plate
    if plate.shape == "step":
        for shift in (-skin.profile.tip_width / 2, skin.profile.tip_width / 2):
            moved = plate.model_copy(update={"position": plate.position + shift})
            yield design.model_copy(update={"contact": design.contact.model_copy(update={"plate": moved})})


def _left_out(design: Design, approach: float) -> Iterator[str]:
    if design.skin.curvature_radius_y is None:
        yield "winkler tier: ridges are taken as independent springs; slots and film are left out"
        return
    slope = _end_slope(design, approach)
    yield "winkler tier: ridges are taken as rows of independent springs; slots and film are left out"
    off = f"that is {slope**2 / 2:.1%} off"
    yield f"contact is taken as vertical: with slopes of up to {slope:.2g} along y {off}"


def _out_of_range(design: Design, approach: float) -> str:
    """Say that at this approach a ridge's middle is crushed, by its force per length over E' and its width,
    or that the contact's end slopes too much."""
    width = skin_of(design).profile.mean_width
    deepest = float(((approach - crest_gaps(design)) * relative_stiffness(design)).max())
    strain = deepest / math.fsum(compliances(design)) / width
    if strain > LARGEST_STRAIN:
        return f"a ridge's middle is strained by {strain:.2g} (the range ends at {LARGEST_STRAIN:g})"
    slope = _end_slope(design, approach)
    return (
        f"the contact's end slopes by {slope:.2g} (the range ends at {LARGEST_SLOPE:g})"
        if slope > LARGEST_SLOPE
        else ""
    )


def _end_slope(design: Design, approach: float) -> float:
    """Slope along y where the contact of the first ridge ends."""
    return math.sin(float(_contact_angles(design, np.maximum(approach - crest_gaps(design), 0.0)).max()))
