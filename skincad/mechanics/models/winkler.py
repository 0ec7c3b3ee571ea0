"""The closed form: each ridge a row of independent springs (Winkler), and its error.

Error bounds of the Winkler model: calibrated constants, and indicators from the design. Springs are too soft
where silicone is confined (a thin, wide, nearly incompressible layer), where many ridges press one base, and
where unloaded ridges hold up the base around loaded ones. They are too stiff where a tip touches with a part
of its crown or with one edge. In the usual range the calibrated constants dominate, beyond it these
indicators (docs/evidence/fits.md says how they were set).

Each ridge is a spring of its own, in closed form: that ranks designs in less than a millisecond. It leaves
out that ridges push each other down through the common base, so the all-touch force is 25 to 35 % below plane
strain (docs/evidence/facts.md), more on thick skins.

A skin that is curved along y too is a row of such springs along every ridge: the gap grows with the angle
about the axis and the force is its integral. The springs stay vertical, which is wrong by half the square
of the slope at the contact's end.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from statistics import median
from time import perf_counter

import numpy as np
from scipy import optimize

from skincad.base.arrays import Array
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.problem import Answer, Request, rise
from skincad.mechanics.validity import (
    LARGEST_SLOPE,
    LARGEST_STRAIN,
    base_softness,
    crown_rises,
    plane_modulus,
)
from skincad.shape.skin import skin_of

# Half-widths against the linear model at usual sizes
THRESHOLD_ERROR = 0.8  # of F: 25 to 35 % low at usual sizes, 43 % at twice the thickness
APPROACH_ERROR, PER_RIDGE = 0.45, 1.1  # of the approach, and by the number of ridges: few press into a base
SHARE_ERROR = 0.5  # of the mean share
# The same for a skin curved along y, against a straight solid under the same gaps, small strain
DOUBLY_THRESHOLD_ERROR, DOUBLY_APPROACH_ERROR, DOUBLY_SHARE_ERROR = 1.2, 0.6, 0.3
USUAL = {
    "straight": (THRESHOLD_ERROR, 0.0, SHARE_ERROR),
    "bent": (DOUBLY_THRESHOLD_ERROR, DOUBLY_APPROACH_ERROR, DOUBLY_SHARE_ERROR),
}

# Stiffening of a shared base: constant, and per thickness in widths
BASE_COUPLING, COUPLING_PER_THICKNESS = 1.0, 3.0
IDLE_RIDGE_SINKING = 0.44  # 2 ln 2 / pi, of forces over E' per pitch: Johnson, sec. 2.5
STIFFENING_MARGIN = 1.2  # of the stiffening
APPROACH_MARGIN = 0.3  # of the approach, beside what the tips add: its error where they are the larger
EDGE_COMPLIANCE = 2.5  # of a crown's give: an edge is a quarter of space
FILLET_ROUNDING = 0.15  # of a fillet's radius, by which it rounds a tip off
SHARE_MARGIN = 0.05  # of the mean share, beside what other springs would share


def compliances(design: Design, height: float | None = None) -> tuple[float, float]:
    """Return E' times the give of a ridge's part of the base and of the ridge, per force along y (1).

    Each is a layer's thickness over its width, the base's with its shots; the ridge is `height` mm high, or
    as the median one. Johnson, Contact Mechanics, 1985, sec. 4.3.
    """
    skin = skin_of(design)
    base = skin.count * skin.base.thickness * base_softness(design) / skin.base.width
    high = median(skin.heights) if height is None else height
    return base, high / skin.profile.mean_width


def confinement(slender: float, nu: float) -> float:
    """Return by what factor a layer `slender` thicknesses over its width is stiffer than in E', 1 or more,
    because it cannot escape sideways.

    Bonded on one side and free to slide on the other it is half a block of twice its thickness: 1 + S^2 with
    S = width / (4 thickness), Gent, Engineering with Rubber, 3rd ed., sec. 8.3; at most the modulus without
    any sideways strain, (1 - nu)^2 / (1 - 2 nu).
    """
    more, most = 1 / (4 * slender) ** 2, (1 - nu) ** 2 / (1 - 2 * nu) - 1
    return 1 + more * most / (more + most)


def stiffening(design: Design, tip: float, carrying: float) -> float:
    """Return by what factor springs are stiffer at most where `carrying` ridges carry (a ridge counts by the
    share of its length) and a tip gives way by `tip` over the line force.

    A base that many ridges press gives way as a whole, far less than under each alone: for a roller on a half
    space by 2.4 thicknesses in widths (Johnson, sec. 4.2), more where it is bonded. Ridges that carry nothing
    hold it up: against its edges a strip of m pitches sinks by 0.44 m forces over E' (sec. 2.5). Of
    the tip no more counts than of the ridge: it hardens.
    """
    nu, thick = silicone(design).poisson_ratio, design.skin.thickness / design.skin.width
    base, ridge = compliances(design)
    shared = min(
        base / (confinement(thick, nu) + BASE_COUPLING + COUPLING_PER_THICKNESS * thick),
        IDLE_RIDGE_SINKING * carrying,
    )
    return (base + ridge) / (shared + ridge / confinement(ridge, nu) + min(tip, ridge))


def tip_approach(design: Design, ridge: int, line: float) -> float:
    """Return what a partly touched tip adds to the approach, mm, at a force per length over E' `line` (mm).

    Contact grows with the root of the force on a crown, with the force on an edge that leans by the angle
    between tip and plate, and gives way by the logarithm of the tip over it (Johnson, sec. 5.6 and 4.2); on
    an edge EDGE times that, and the ridge bends: 3 (tip / width)^2 of a column's own give.
    At most what the plate must sink for the whole tip to touch. `ridge` counts from 0.
    """
    skin = skin_of(design)
    shape, tip = skin.profile, skin.profile.tip_width
    lean = skin.lean(ridge + 1)
    middle = (design.skin.curvature_radius + skin.heights[ridge]) * math.sin(lean)
    low, high = rise(design.contact.plate, np.array([middle - tip / 2, middle + tip / 2]))
    tilt = abs(math.sin(lean) + float(high - low) / tip)
    most = shape.crown + tilt * tip / 2 + FILLET_ROUNDING * min(shape.tip_fillet, tip / 2)
    if most == 0.0 or line == 0.0:
        return 0.0
    edge = max(0.0, 1 - 4 * shape.crown / tip / tilt) if tilt > 0 else 0.0  # beyond the crown's own slope
    on_crown = math.log1p(math.sqrt(math.pi * most / 2) / math.sqrt(line))
    on_edge = EDGE_COMPLIANCE * max(on_crown, math.log(line + tilt * tip / 2) - math.log(line))
    bent = 3 * (2 * tip / (shape.root_width + tip)) ** 2 * compliances(design, skin.heights[ridge])[1]
    return min(most, line * ((1 - edge) * on_crown + edge * (on_edge + bent)))


def crown_height_spread(design: Design) -> float:
    """Return by how much the highest points of leaning crowns differ in their height over the summits on the
    axes, mm: springs count from the summits.

    Of ridges alike that is a part of their crest differences that THRESHOLD_ERROR holds; levelled crests have
    little else.
    """
    return float(np.ptp(crown_rises(design))) if skin_of(design).uneven else 0.0


def half_widths(
    design: Design, line: Array, approach: float, carrying: float, last: float
) -> tuple[tuple[float, float, float], tuple[float, float]]:
    """Return the half-widths of a verdict, of the all-touch force and of the approach relative to them, of a
    share relative to the mean share; and the factors on stiffer and softer springs between which shares are
    taken.

    `line` `(ridges,)` mm is each ridge's largest force per length over E', `approach` mm, `carrying` how many
    ridges carry, each by the share of its length, `last` mm the depth of the first when the last one touches.
    """
    skin = skin_of(design)
    usual = USUAL[skin.body]
    base, column = compliances(design)
    most, give = int(np.argmax(line)), base + column
    # a force of the smallest number there is moves nothing
    tips = tip_approach(design, most, float(line[most])) / approach if approach > 0 else 0.0
    at_last = tip_approach(design, most, last / give) / last if last > 0 else 0.0
    stiffer = stiffening(design, at_last * give, skin.count)
    threshold = max(usual[0], STIFFENING_MARGIN * (stiffer - 1), at_last / (1 + at_last))
    few = APPROACH_ERROR + PER_RIDGE / skin.count
    base_factor = stiffening(design, tips * give, carrying)
    reached = max(usual[1], few, APPROACH_MARGIN + tips, 1 - 1 / base_factor)
    stiffest = max(1 + threshold, STIFFENING_MARGIN * base_factor)
    return (threshold, reached, usual[2]), (stiffest, 1 / (1 + max(reached, at_last)))


def share_error(usual: float, shares: Array, others: list[Array]) -> float:
    """Return the error of each of the `shares` `(ridges,)` N from those of stiffer and softer springs; the
    `usual` one is relative to their mean."""
    mean = float(shares.mean())
    difference = max(float(np.abs(other - shares).max()) for other in others)
    return max(usual * mean, difference + SHARE_MARGIN * mean)


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
    heights = np.array(skin_of(design).heights)
    return np.asarray(_falls(design) + plate_rises(design) + heights.max() - heights)


def _falls(design: Design) -> Array:
    """By how much each crest lies lower than one in the middle `(ridges,)` mm."""
    skin = skin_of(design)
    radius = skin.base.curvature_radius + np.array(skin.heights)
    return np.asarray(2 * radius * np.sin(np.array(skin.leans) / 2) ** 2)


def plate_rises(design: Design) -> Array:
    """Return the plate's height over a flat plate at each crest, `(ridges,)` mm."""
    skin = skin_of(design)
    radius = design.skin.curvature_radius + np.array(skin.heights)
    lean = np.array(skin.leans)
    return np.asarray(rise(design.contact.plate, radius * np.sin(lean)))


def all_touch_force(design: Design) -> float:
    """Return the force at which all ridges touch, N."""
    return float(line_forces(design, float(crest_gaps(design).max())).sum())


def line_forces(design: Design, approach: float, factor: float = 1.0) -> Array:
    """Return each ridge's force, N, `(ridges,)` at an approach in mm after the first touch, springs being
    stiffer by `factor`."""
    depth = np.maximum(approach - crest_gaps(design), 0.0)
    stiffness, radius = stiffnesses(design, factor), design.skin.radius_y
    if not _end_angle(design):
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
    return np.asarray(design.skin.radius_y + np.array(skin_of(design).heights) - _falls(design))


def _contact_angles(design: Design, depth: Array) -> Array:
    """Angle, rad, up to which each ridge touches when its middle is pressed in by `depth` `(ridges,)` mm."""
    half_sine = np.sqrt(depth / (2 * _crest_arms(design)))
    return np.asarray(np.minimum(2 * np.arcsin(np.minimum(half_sine, 1.0)), _end_angle(design)))


def _end_angle(design: Design) -> float:
    """Angle along y, rad, from the skin's middle to its end: 0 of a straight one."""
    return design.skin.length / 2 / design.skin.radius_y


def _approach(design: Design, force: float, factor: float = 1.0) -> float:
    """The approach, mm, at which the ridges carry `force` N: their sum grows with it without bound."""
    stiffness = factor * ridge_stiffness(design)
    if not _end_angle(design):
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
        progress("winkler model: closed form")
    started, force = perf_counter(), request.force
    gaps, approach = crest_gaps(design), _approach(design, force)
    end, last = _end_angle(design), float(gaps.max())
    threshold = all_touch_force(design)
    shares = line_forces(design, approach)
    depth = np.maximum(approach - gaps, 0.0)
    touched = _contact_angles(design, depth) / end if end else depth > 0
    line = depth * relative_stiffness(design) / math.fsum(compliances(design))
    carrying = float(touched.sum())
    widths, factors = half_widths(design, line, approach, carrying, last)
    of_force, of_approach, of_share = widths
    on_crowns = float(line_forces(design, last + crown_height_spread(design)).sum())
    missed = of_force * threshold + (1 + of_force) * (on_crowns - threshold)
    reached = of_approach * approach
    others = [line_forces(design, _approach(design, force, f), f) for f in factors]
    for moved in _step_moved(design):
        others += [line_forces(moved, _approach(moved, force, f), f) for f in (1, *factors)]
        missed = max(missed, (1 + of_force) * all_touch_force(moved) - threshold)
        reached = max(reached, (1 + of_approach) * _approach(moved, force) - approach)
    error = share_error(of_share, shares, others)
    return Answer(
        touching=int(np.count_nonzero(shares > 0)),
        all_touch_force=Estimate(threshold, missed, "N"),
        approach=Estimate(approach, reached, "mm"),
        ridge_force=tuple(Estimate(float(f), error, "N") for f in shares),
        unknowns=gaps.size,
        residual=abs(float(shares.sum()) / force - 1),
        seconds={"contact": perf_counter() - started},
        warnings=tuple(_left_out(design, approach)),
        fault=_out_of_range(design, min(approach, last or approach)) if end else "",
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
    slope = _end_slope(design, approach)
    springs = "rows of independent springs" if slope else "independent springs"
    yield f"winkler model: ridges are taken as {springs}; slots and film are left out"
    if slope:
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
    words = f"the contact's end slopes by {slope:.2g} (the range ends at {LARGEST_SLOPE:g})"
    return words if slope > LARGEST_SLOPE else ""


def _end_slope(design: Design, approach: float) -> float:
    """Slope along y where the contact of the first ridge ends."""
    return math.sin(float(_contact_angles(design, np.maximum(approach - crest_gaps(design), 0.0)).max()))
