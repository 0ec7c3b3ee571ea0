"""Error bounds of the Winkler tier: calibrated constants, and indicators from the design.

Springs are too soft where silicone is confined (a thin, wide, nearly incompressible layer), where many
ridges press one base, and where unloaded ridges hold up the base around loaded ones. They are too stiff where
a tip touches with a part of its crown or with one edge. In the usual range the calibrated constants dominate,
beyond it these indicators.

The indicators' constants were set against the linear tier on 81 pads of bench/campaign (`wide`, seeds 0 to
80; the all-touch force F from 0.3 to 4.6 times the springs', the approach from 0.2 to 7.2 times), on 11 of
plain-ridges with 12 to 60 ridges (base 0.03 to 1.2 widths thick, nu 0.3 to 0.4999), and, what idle ridges do
to the shares, on seeds 1000 to 1099. Judged on 100 others (seeds 2000 to 2099) the bars hold the approach of
all, F of 99 and the shares of 98, at worst 1.31 bars off; in the median they are 3 (approach) and 4 (F) times
too wide.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import median

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.plate import rise
from skincad.shape.skin import skin_of

# Half-widths against the linear tier at usual sizes, set on the variants of test_winkler.py
# and 40 random designs (bench/error_bars.py); with the indicators below they hold on all of 36
# others (seeds 100 to 135), F 3 times too wide in the median, the approach 7 times
THRESHOLD_ERROR = 0.8  # of F: 25 to 35 % low at usual sizes, 43 % at twice the thickness
APPROACH_ERROR, PER_RIDGE = 0.45, 1.1  # of the approach, and by the number of ridges: few press into a base
SHARE_ERROR = 0.5  # of the mean share
# The same for a skin curved along y, against a straight solid under the same gaps, small strain: F 0.72 to
# 2.07 times, approach 0.88 to 1.53 times, shares 0.17 of their mean off, in 47 cases, R_y 15 mm to infinity
DOUBLY_THRESHOLD_ERROR, DOUBLY_APPROACH_ERROR, DOUBLY_SHARE_ERROR = 1.2, 0.6, 0.3

# Stiffening of a shared base: constant, and per thickness in widths
BASE_COUPLING, COUPLING_PER_THICKNESS = 1.0, 3.0
IDLE_RIDGE_SINKING = 0.44  # 2 ln 2 / pi, of forces over E' per pitch: Johnson, sec. 2.5
STIFFENING_MARGIN = 1.2  # of the stiffening
APPROACH_MARGIN = 0.3  # of the approach, beside what the tips add: its error where they are the larger
EDGE_COMPLIANCE = 2.5  # of a crown's give: an edge is a quarter of space
FILLET_ROUNDING = 0.15  # of a fillet's radius, by which it rounds a tip off
SHARE_MARGIN = 0.05  # of the mean share, beside what other springs would share


@dataclass(frozen=True)
class Widths:
    """Half-widths: of the all-touch force and of the approach relative to them, of a share relative to the
    mean share.

    `stiffer` and `softer` are the factors on the springs between which the shares are taken.
    """

    threshold: float
    approach: float
    share: float
    stiffer: float
    softer: float


def compliances(design: Design, height: float | None = None) -> tuple[float, float]:
    """Return E' times the give of a ridge's part of the base and of the ridge, per force along y (1).

    Each is a layer's thickness over its width; the ridge is `height` mm high, or as the median one. Johnson,
    Contact Mechanics, 1985, sec. 4.3.
    """
    skin = skin_of(design)
    base = skin.count * skin.base.thickness / skin.base.width
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

    A crown of radius r that leans by a rises 2 r sin(a / 2)^2 over its summit, up to its edge. Of ridges
    alike that is a part of their crest differences that THRESHOLD_ERROR holds; levelled crests have little
    else.
    """
    skin = skin_of(design)
    if not skin.uneven:
        return 0.0
    tip, crown = skin.profile.tip_width, skin.profile.crown
    leans = [abs(skin.lean(ridge)) for ridge in range(1, skin.count + 1)]
    radius = tip**2 / (8 * crown) + crown / 2 if crown else math.inf
    rises = [
        2 * radius * math.sin(lean / 2) ** 2
        if radius * math.sin(lean) <= tip / 2
        else tip / 2 * math.sin(lean) - crown * math.cos(lean)
        for lean in leans
    ]
    return max(rises) - min(rises)


def half_widths(design: Design, line: Array, approach: float, carrying: float, last: float) -> Widths:
    """Return the half-widths of a verdict.

    `line` `(ridges,)` mm is each ridge's largest force per length over E', `approach` mm, `carrying` how many
    ridges carry, each by the share of its length, `last` mm the depth of the first when the last one touches.
    """
    skin = skin_of(design)
    doubly = design.skin.curvature_radius_y is not None
    base, column = compliances(design)
    most, give = int(np.argmax(line)), base + column
    # a force of the smallest number there is moves nothing
    tips = tip_approach(design, most, float(line[most])) / approach if approach > 0 else 0.0
    at_last = tip_approach(design, most, last / give) / last if last > 0 else 0.0
    stiffer = stiffening(design, at_last * give, skin.count)
    usual = DOUBLY_THRESHOLD_ERROR if doubly else THRESHOLD_ERROR
    threshold = max(usual, STIFFENING_MARGIN * (stiffer - 1), at_last / (1 + at_last))
    few = APPROACH_ERROR + PER_RIDGE / skin.count
    usual = max(DOUBLY_APPROACH_ERROR, few) if doubly else few
    base_factor = stiffening(design, tips * give, carrying)
    reached = max(usual, APPROACH_MARGIN + tips, 1 - 1 / base_factor)
    share = DOUBLY_SHARE_ERROR if doubly else SHARE_ERROR
    stiffest = max(1 + threshold, STIFFENING_MARGIN * base_factor)
    return Widths(threshold, reached, share, stiffest, 1 / (1 + max(reached, at_last)))


def share_error(widths: Widths, shares: Array, others: tuple[Array, ...]) -> float:
    """Return the error of each of the `shares` `(ridges,)` N from those of stiffer and softer springs."""
    mean = float(shares.mean())
    difference = max(float(np.abs(other - shares).max()) for other in others)
    return max(widths.share * mean, difference + SHARE_MARGIN * mean)
