"""Error bounds for effects that a model neglects: on the relative change, from the design and the answer.

Calibrated on templates, variants of them and random designs (docs/evidence/verdicts.md); the constants are
fits (fits.py). tests/mechanics/test_left_out.py holds a part of them against the models that compute the
effect.
"""

from __future__ import annotations

import math
from statistics import median

import numpy as np

from skincad.base.machine import one_blas_thread
from skincad.base.result import Record, item, record
from skincad.inputs.design import Design
from skincad.inputs.feature_tables import places
from skincad.inputs.material import silicone
from skincad.mechanics.models.winkler import confinement
from skincad.mechanics.problem import Answer, steepest
from skincad.mechanics.validity import ridge_strain
from skincad.shape.skin import skin_of

FREE_ENDS, FINITE_STRAIN = "free ends", "finite strain"
FRICTION, ALONG, POCKETS = "friction", "friction along y", "pockets"


@record()
class LeftOut(Record):
    """Bounds of an effect: relative for the all-touch force and the approach, a share against the mean
    share."""

    effect: str = item(meaning="its name")
    threshold: float = item(meaning="relative, of the all-touch force", key="all_touch_force")
    approach: float = item(meaning="relative, of the approach")
    share: float


# Of the all-touch force, the approach and a share: by the section's diagonal over the length, by the nominal
# strain, and what friction along y takes back of free ends
ENDS_BOUND, STRAIN_BOUND, ALONG_PART = (0.3, 0.5, 0.3), (1.3, 0.8, 0.9), (0.45, 0.25, 0.35)
# Of a face's approach, by it over the thickness: finite strain changes flat-magnet's and 8 variants' (R 30 to
# 400, 2 to 10 mm thick, round, nu 0.45, 0.5 to 8 N) by 0.26 to 1.58 of it, most where it is flattest
FACE_STRAIN = 2.0
# As STRAIN_BOUND, of rings: `bench.families 30 --seed 6200` needs 1.6 and 1.0 of the force and a share
RING_STRAIN = 2.0, 0.8, 1.2
POCKET_SHARE = 1.5, 0.5  # by a pocket's share of the section, and by its root, see `pockets`
# A constant, by stiffer tips, by the slope, and by what compressible silicone draws in
FORCE_BY_FRICTION = 0.015, 0.41, 0.3, 0.06
# A constant, by softer tips, and the last again; a constant, and by softer tips
APPROACH_BY_FRICTION, SHARE_BY_FRICTION = (0.005, 0.5, 0.005), (0.08, 0.13)
UPRIGHT = 1e-6  # rad, from which on a pin leans
FAINT = 0.01  # of pins; 0.0004 of the approach on nine pillars, by mechanics/contact/tips.py


def free_ends(design: Design) -> LeftOut:
    """Return the bound for a pad taken as endless along y.

    Nearly incompressible silicone leaves the wide pad by its ends alone, and a thick one is eased from there
    inwards by about its thickness, so the section's diagonal against the length counts: as its root while
    ends matter everywhere, linear once they are far apart. Of the approach it is 0.92 and 1.19 on two pads of
    15 ridges, 2 mm thick and 5 and 3 mm long, where free ends change it by 0.84 and 1.12.
    """
    slender = math.hypot(design.skin.width, design.skin.thickness) / design.skin.length
    reach = min(math.sqrt(slender), 1.5 * slender)
    force, approach, share = (part * reach for part in ENDS_BOUND)
    return LeftOut(effect=FREE_ENDS, threshold=force, approach=approach, share=share)


def finite_strain(design: Design, answer: Answer, force: float) -> LeftOut:
    """Return the bound for strains taken as small, by the nominal strain of the most loaded ridge."""
    strain = ridge_strain(design, answer)
    at_threshold = strain * (answer.all_touch_force.value or 0.0) / force
    by_family = {"flat": (STRAIN_BOUND[0], FACE_STRAIN, STRAIN_BOUND[2]), "ring": RING_STRAIN}
    of_force, approach, share = by_family.get(skin_of(design).family, STRAIN_BOUND)
    return LeftOut(
        effect=FINITE_STRAIN,
        threshold=of_force * at_threshold,
        approach=approach * strain,
        share=share * strain,
    )


def friction(design: Design, carrying: int) -> LeftOut:
    """Return the bound for a frictionless plate, with `carrying` ridges under load.

    Tips that cannot spread stiffen ridge and base (`tip_constraint`), which changes the approach. On thin
    pads the all-touch force follows. On thick ones the last ridge's remaining gap falls with the approach.
    Leaning ridges also bend, and compressible silicone draws in.
    """
    skin, ridges = design.skin, skin_of(design).count
    thick = skin.thickness / _spanned(design, ridges)
    slope = abs(skin_of(design).placed[-1].lean) + steepest(design.contact.plate, skin.width / 2)
    stiffer = tip_constraint(design, ridges) - 1
    drawn_in = (1 - 2 * silicone(design).poisson_ratio) ** 2
    softer = 1 - 1 / tip_constraint(design, max(carrying, 1))

    def bound(factors: tuple[float, ...], *by: float) -> float:
        return factors[0] + math.fsum(f * b for f, b in zip(factors[1:], by, strict=True))

    return LeftOut(
        effect=FRICTION,
        threshold=bound(FORCE_BY_FRICTION, stiffer / (1 + (3 * thick) ** 4), slope, drawn_in),
        approach=bound(APPROACH_BY_FRICTION, softer, drawn_in),
        share=bound(SHARE_BY_FRICTION, softer),
    )


def friction_of_pins(
    design: Design, answer: Answer, force: float, crest_offsets: tuple[float, ...] = ()
) -> LeftOut:
    """Return the bound for pins under a frictionless plate at `force` N: by how much tips that stick to it
    would bear more at the same approach, and FAINT for what neighbours push tips aside. `crest_offsets` as in
    Request.

    A point contact of incompressible silicone feels no friction as it is pressed: Johnson, Contact Mechanics,
    1985, sec. 5.4.
    """
    from skincad.mechanics.models.reduced import at_approach, pin_model

    with one_blas_thread():
        pad = pin_model(design, stuck=True).lowered(crest_offsets)
        stuck = at_approach(pad, answer.approach.value or 0.0)[0]
    more, mean = float(stuck.sum()) / force - 1, force / stuck.size
    shares = np.array([share.value for share in answer.ridge_force])
    moved = float(np.abs(stuck / (1 + more) - shares).max()) / mean
    return LeftOut(effect=FRICTION, threshold=FAINT + more, approach=FAINT + more, share=FAINT + moved)


def pockets(design: Design, answer: Answer) -> LeftOut:
    """Return the bound for pockets, which count as silicone; nothing where there are none."""
    bound = pocket_bound(design, answer.approach.value or 0.0)
    forces = np.array([force.value or 0.0 for force in answer.ridge_force])
    # pockets that are alike change how forces differ
    uneven = float(np.abs(forces / (forces.mean() or 1.0) - 1).max())
    return LeftOut(effect=POCKETS, threshold=bound, approach=bound, share=bound * uneven)


def pocket_bound(design: Design, approach: float) -> float:
    """Return by how much pockets change force or approach at most, relative, at an `approach` mm.

    By their share of a pin's section or of a face's contact, whose half-width is sqrt(R times the approach),
    and by their depth over what is left above them. Set on axisymmetric sections with one in the middle,
    empty or filled by something rigid: pins 3 and 5 mm high on 5 and 3 mm, faces of R 30 and 60 and 3 and
    5 mm, pockets 1 to 4 mm wide and 1.5 to 5 mm deep; the largest change is 0.95 of it. Of pins whose magnets
    are in their cells (models/pin_cell.py) what is left is that these stand upright in pins that lean.
    """
    table, skin, base = design.features, skin_of(design), design.skin
    pocket = table.pocket
    if pocket is None:
        return 0.0
    share = (pocket.diameter / skin.profile.mean_width) ** 2
    if skin.bare:
        reach = math.sqrt(base.curvature_radius * approach)
        across = min(base.width, 2 * reach)
        area = base.area * (across / base.width) ** (2 if base.round else 1)
        share = min(1.0, len(places(base, table)) * math.pi / 4 * pocket.diameter**2 / area)
    over = base.thickness + max(skin.heights) - pocket.depth
    bound = min(POCKET_SHARE[0] * share, POCKET_SHARE[1] * math.sqrt(share)) * pocket.depth / over
    return bound * unknown_pockets(design)


def unknown_pockets(design: Design) -> float:
    """Return the part of the pockets' bound that counts: 1, or of pins that stand on their magnets the sine
    of their lean; 0 of an upright one and without pockets."""
    if not design.on_magnets:
        return float(design.features.pocket is not None)
    lean = max(math.hypot(*placed.axis[:2]) for placed in skin_of(design).placed)
    return lean if lean > UPRIGHT else 0.0


def friction_along(design: Design) -> LeftOut:
    """Return the bound for tips that cannot spread along y: they reduce the effect of free ends."""
    ends = free_ends(design)
    parts = zip(ALONG_PART, (ends.threshold, ends.approach, ends.share), strict=True)
    force, approach, share = (part * of_ends for part, of_ends in parts)
    return LeftOut(effect=ALONG, threshold=force, approach=approach, share=share)


def tip_constraint(design: Design, ridges: int) -> float:
    """Return the stiffening factor of ridges and the base under them when tips cannot spread.

    A layer bonded on one side and sliding on the other is half a block (`confinement`). Bonded on both sides
    it is a whole block, twice as slender. The base's tips are the ridges, which shear and bend by `give` mm
    per strain: between two walls of which one slips so much, 4 (T + give) / (T + 4 give) times the resistance
    to being squeezed out (Poiseuille's flow, the silicone being nearly incompressible).
    """
    skin, nu = skin_of(design), silicone(design).poisson_ratio
    if skin.bare:  # no features between: from sliding to bonded
        thick = skin.base.thickness / skin.base.width
        return confinement(thick / 2, nu) / confinement(thick, nu)
    column = median(skin.heights) / skin.profile.mean_width
    give = skin.pitch * (1.2 * column + column**3 / 4)
    thickness, base = skin.base.thickness, skin.base.thickness / skin.pitch
    thick = thickness / _spanned(design, ridges)
    more = 4 * (thickness + give) / (thickness + 4 * give)
    free = base / confinement(thick, nu) + column / confinement(column, nu)
    fast = base / confinement(thick / math.sqrt(more), nu) + column / confinement(column / 2, nu)
    return free / fast


def _spanned(design: Design, ridges: int) -> float:
    """Width of the base under so many features, mm."""
    skin = skin_of(design)
    across = (ridges - 1) * skin.pitch
    if skin.form.across == "radius":
        across = 2 * skin.placed[ridges - 1].summit.x
    return min(skin.base.width, across + skin.profile.mean_width)


def left_out(
    effects: tuple[str, ...],
    design: Design,
    answer: Answer,
    force: float,
    crest_offsets: tuple[float, ...] = (),
) -> tuple[LeftOut, ...]:
    """Return the bounds of the effects that a model leaves out of its answer at `force` N; a disc has no free
    ends, and those of pins' base are in the reduced model's error. `crest_offsets` as in Request."""
    skin = skin_of(design)
    bounds = {
        FREE_ENDS: lambda: free_ends(design),
        FINITE_STRAIN: lambda: finite_strain(design, answer, force),
        FRICTION: lambda: (
            friction_of_pins(design, answer, force, crest_offsets)
            if skin.family == "pin"
            else friction(design, answer.touching)
        ),
        ALONG: lambda: friction_along(design),
        POCKETS: lambda: pockets(design, answer),
    }
    has_ends = skin.body in ("straight", "bent")
    return tuple(bounds[effect]() for effect in effects if has_ends or effect not in (FREE_ENDS, ALONG))
