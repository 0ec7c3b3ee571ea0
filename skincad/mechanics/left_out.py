"""Error bounds for effects that a tier neglects, with their calibration.

Each is a bound on the relative change, computed from the design and the answer. Calibrated on the seven first
templates and 21 variants of plain-ridges and yamada-2002 (length 6 to 48 mm, thickness 2 to 7, R 40 to 150,
nu 0.3 to 0.499, 5 to 15 ridges, with and without strips): all lie inside. The median bound on the all-touch
force F is 1.6 (free ends) and 1.8 (finite strain) times the change, on the approach 2.4 and 1.9, on a share
3.3 and 1.7; at nu 0.3, where finite strain hardly changes F, 50 times. Over 40 random designs
(bench/error_bars.py), thick pads among them, free ends change F within the bound in 97 %, the approach in
all; medians 2.0 and 3.2 times the change.

Friction was calibrated at coefficients 0.2 to 1 on nine templates, 24 variants of plain-ridges and
yamada-2002 (thickness 2 to 7, R 40 to 150, nu 0 to 0.499, 5 ridges, height 0.25 to 0.9, crown 0 to 0.08) and
the random designs of seeds 0 to 39 (bench/campaign, at the forces of bench/error_bars.py): all lie inside.
Judged on seeds 100 to 149 it holds F of 45 in 46, the approach of all 50 and the shares of 46 in 48, at worst
1.58 times too narrow; in the median it is 4, 5 and 5 times the change. From 0.5 on the slip is negligible, so
at 2 and 5 the same hold. Along y it was set on plain-ridges, 6 to 30 mm long, 2 mm thick or of nu 0.3,
pressed in three dimensions with full stick: 0.4 of what the free ends change is taken back. Judged on four
others (height 0.9, R 40, crown 0.06, thickness 6 mm) it holds, for F by 2 % at the tightest.

tests/mechanics/test_left_out.py holds a part of them against the tiers that compute the effect.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import median

from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.plate import steepest
from skincad.mechanics.problem import Answer
from skincad.mechanics.tiers.winkler_error import confinement
from skincad.mechanics.validity import ridge_strain
from skincad.shape.skin import skin_of

FREE_ENDS, FINITE_STRAIN = "free ends", "finite strain"
FRICTION, ALONG = "friction", "friction along y"


@dataclass(frozen=True)
class LeftOut:
    """Bounds of an effect: relative for the all-touch force and the approach, a share against the mean
    share."""

    effect: str
    threshold: float
    approach: float
    share: float


def free_ends(design: Design) -> LeftOut:
    """Return the bound for a pad taken as endless along y.

    Nearly incompressible silicone leaves the wide pad by its ends alone, and a thick one is eased from there
    inwards by about its thickness, so the section's diagonal against the length counts: as its root while
    ends matter everywhere, linear once they are far apart. Of the approach it is 0.92 and 1.19 on two pads of
    15 ridges, 2 mm thick and 5 and 3 mm long, where free ends change it by 0.84 and 1.12.
    """
    slender = math.hypot(design.skin.width, design.skin.thickness) / design.skin.length
    reach = min(math.sqrt(slender), 1.5 * slender)
    return LeftOut(FREE_ENDS, 0.3 * reach, 0.5 * reach, 0.3 * reach)


def finite_strain(design: Design, answer: Answer, force: float) -> LeftOut:
    """Return the bound for strains taken as small, by the nominal strain of the most loaded ridge."""
    strain = ridge_strain(design, answer)
    at_threshold = strain * (answer.all_touch_force.value or 0.0) / force
    return LeftOut(FINITE_STRAIN, 1.3 * at_threshold, 0.8 * strain, 0.9 * strain)


def friction(design: Design, carrying: int) -> LeftOut:
    """Return the bound for a frictionless plate, with `carrying` ridges under load.

    Tips that cannot spread stiffen ridge and base (`tip_constraint`), which changes the approach. On thin
    pads the all-touch force follows. On thick ones the last ridge's remaining gap falls with the approach.
    Leaning ridges also bend, and compressible silicone draws in.
    """
    skin, ridges = design.skin, skin_of(design).count
    thick = skin.thickness / _spanned(design, ridges)
    slope = abs(skin_of(design).lean(ridges)) + steepest(design.contact.plate, skin.width / 2)
    stiffer = tip_constraint(design, ridges) - 1
    drawn_in = (1 - 2 * silicone(design).poisson_ratio) ** 2
    threshold = 0.015 + 0.41 * stiffer / (1 + (3 * thick) ** 4) + 0.3 * slope + 0.06 * drawn_in
    softer = 1 - 1 / tip_constraint(design, max(carrying, 1))
    approach = 0.005 + 0.5 * softer + 0.005 * drawn_in
    return LeftOut(FRICTION, threshold, approach, 0.08 + 0.13 * softer)


def friction_along(design: Design) -> LeftOut:
    """Return the bound for tips that cannot spread along y: they reduce the effect of free ends."""
    ends = free_ends(design)
    return LeftOut(ALONG, 0.45 * ends.threshold, 0.25 * ends.approach, 0.35 * ends.share)


def tip_constraint(design: Design, ridges: int) -> float:
    """Return the stiffening factor of ridges and the base under them when tips cannot spread.

    A layer bonded on one side and sliding on the other is half a block (`confinement`). Bonded on both sides
    it is a whole block, twice as slender. The base's tips are the ridges, which shear and bend by `give` mm
    per strain: between two walls of which one slips so much, 4 (T + give) / (T + 4 give) times the resistance
    to being squeezed out (Poiseuille's flow, the silicone being nearly incompressible).
    """
    skin, nu = skin_of(design), silicone(design).poisson_ratio
    column = median(skin.heights) / skin.profile.mean_width
    give = skin.pitch * (1.2 * column + column**3 / 4)
    thickness, base = skin.base.thickness, skin.base.thickness / skin.pitch
    thick = thickness / _spanned(design, ridges)
    more = 4 * (thickness + give) / (thickness + 4 * give)
    free = base / confinement(thick, nu) + column / confinement(column, nu)
    fast = base / confinement(thick / math.sqrt(more), nu) + column / confinement(column / 2, nu)
    return free / fast


def _spanned(design: Design, ridges: int) -> float:
    """Width of the base under so many ridges, mm."""
    skin = skin_of(design)
    return min(skin.base.width, (ridges - 1) * skin.pitch + skin.profile.mean_width)


def left_out(effects: tuple[str, ...], design: Design, answer: Answer, force: float) -> tuple[LeftOut, ...]:
    """Return the bounds of the effects that a tier leaves out of its answer at `force` N."""
    bounds = {
        FREE_ENDS: lambda: free_ends(design),
        FINITE_STRAIN: lambda: finite_strain(design, answer, force),
        FRICTION: lambda: friction(design, answer.touching),
        ALONG: lambda: friction_along(design),
    }
    return tuple(bounds[effect]() for effect in effects)
