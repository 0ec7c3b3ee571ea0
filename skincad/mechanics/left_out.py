"""What a tier leaves out, and by how much that may change its answer: indicators with their calibration.

Each is a bound on the relative change, from numbers at hand. Calibrated on the seven first templates and 21
variants of plain-ridges and yamada-2002 (length 6 to 48 mm, thickness 2 to 7, R 40 to 150, nu 0.3 to 0.499,
5 to 15 ridges, with and without strips): all lie inside. The median bound on F9 is 1.6 (free ends) and 1.8
(finite strain) times the change, on the approach 2.2 and 1.9, on a share 3.3 and 1.7; at nu 0.3, where finite
strain hardly changes F9, 50 times. Over 40 random designs (bench/error_bars.py), thick pads among
them, free ends change F9 within the bound in 97 %, the approach in all; medians 2.0 and 2.9 times the change.
tests/mechanics/test_left_out.py holds a part of them against the tiers that compute the effect.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from skincad.inputs.design import Design
from skincad.mechanics.problem import Answer
from skincad.mechanics.validity import ridge_strain

FREE_ENDS, FINITE_STRAIN = "free ends", "finite strain"


@dataclass(frozen=True)
class LeftOut:
    """By how much an effect may change F9 and the approach, relative, and a share against the mean share."""

    effect: str
    threshold: float
    approach: float
    share: float


def free_ends(design: Design) -> LeftOut:
    """Return the bound for a pad taken as endless along y.

    Nearly incompressible silicone leaves the wide pad by its ends alone, and a thick one is eased from there
    inwards by about its thickness, so the section's diagonal against the length counts: as its root while
    ends matter everywhere, linear once they are far apart.
    """
    slender = math.hypot(design.skin.width, design.skin.thickness) / design.skin.length
    reach = min(math.sqrt(slender), 1.5 * slender)
    return LeftOut(FREE_ENDS, 0.3 * reach, 0.45 * reach, 0.3 * reach)


def finite_strain(design: Design, found: Answer, force: float) -> LeftOut:
    """Return the bound for strains taken as small, by the nominal strain of the most loaded ridge."""
    strain = ridge_strain(design, found)
    at_threshold = strain * (found.all_touch_force.value or 0.0) / force
    return LeftOut(FINITE_STRAIN, 1.3 * at_threshold, 0.8 * strain, 0.9 * strain)


def left_out(effects: tuple[str, ...], design: Design, found: Answer, force: float) -> tuple[LeftOut, ...]:
    """Return the bounds of the effects that a tier leaves out of its answer at `force` N."""
    bounds = {
        FREE_ENDS: lambda: free_ends(design),
        FINITE_STRAIN: lambda: finite_strain(design, found, force),
    }
    return tuple(bounds[effect]() for effect in effects)
