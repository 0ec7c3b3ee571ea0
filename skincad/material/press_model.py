"""Approach against force of a design's good and faulty parts, from which `accept` judges a press.

All curves are those of a pad of the design's own modulus, at forces in its terms: a part of s times that
modulus sinks at s F as the design does at F. The good curve is that of a pad's test (pad.py): small strain on
a fine mesh, free ends, finite strain. What a fault changes is solved on one coarse mesh of the section in
small strain and plane strain; the ratio of the good curve to the coarse one carries it over, so that the
mesh's error cancels. Bonded strips keep their modulus in a cast of another silicone; that is left out here
and within `SCALE_ERROR`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.interpolate import PchipInterpolator

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Stopwatch
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.skin_tables import Plate
from skincad.material.pad import (
    APPROACH_ERROR,
    STRAINED_ERROR,
    PadCurve,
    finite_strain_curve,
    small_strain_curve,
)
from skincad.mechanics.bodies.mesh import half_of, plane_piece
from skincad.mechanics.check import spread_of
from skincad.mechanics.contact.frictionless import Ridges, press
from skincad.mechanics.models import linear
from skincad.mechanics.models.corrected import plain_pad
from skincad.mechanics.models.friction import FULL, solve, solve_solid
from skincad.mechanics.problem import Pad, pad_of
from skincad.shape.skin import skin_of

FINENESS, ORDER = 0.5, 2  # of the coarse mesh; the change by a ridge differs by 3 % on twice as fine a one
KNOTS, DENSE = 22, 400  # forces solved, closer at the first touch, and of the tables between them
MISSING = (0.06, 0.12, 0.25, 0.5, 1.0)  # of a ridge's height, that it lacks
WARPS = (-0.4, -0.2, -0.1, -0.05, -0.02, 0.02, 0.05, 0.1, 0.2, 0.4)  # of the height, at the outermost crest
TILTS = (0.02, 0.05, 0.1, 0.2, 0.4)
MOST_PAIRS = 9  # ridges, of which any two are taken away; of more none are
PARTS, SEED = 40, 20021  # with random crests, of which the good curve is the mean; in pairs of opposite signs
MOST_RIDGES = 6  # whose absence is solved; of more they are spread from an end to the middle
# Standard deviations: of the approach as a whole (half of what bounds it), with strips left out; of what
# finite strain changes
SCALE_ERROR = math.hypot(APPROACH_ERROR / 2, 0.01)
FRICTION_POINTS = 0.6  # of the largest force, at which the plate's friction is solved


@dataclass(frozen=True)
class PressModel:
    """Approach, mm, at `force` `(k,)` N of a pad of `young_modulus` MPa, by kinds of parts.

    `good` `(k,)` is the mean over the mold's crest errors. `crests` `(parts, k)` are what random ones change,
    divided by the root of their number, so that their squares sum to the variance. `strained` `(k,)` is one
    standard deviation of what finite strain changes. `ridge` `(ridges, sizes, k)` are curves of a pad that
    lacks `missing` `(sizes,)` mm of one ridge, whose numbers are `numbers` `(ridges,)`; `two` `(pairs, k)` of
    one without the two ridges `pairs`. `warp` and `tilt` `(sizes, k)` are of one whose outermost crests are
    `warps` and `tilts` mm lower. `last` is the number of the last ridge. `friction` is the relative change of
    the approach by a plate on which nothing slips.
    """

    young_modulus: float
    modulus_range: tuple[float, float]
    height: float
    force: Array
    good: Array
    crests: Array
    strained: Array
    numbers: tuple[int, ...]
    last: int
    mirrored: bool
    missing: Array
    ridge: Array
    pairs: tuple[tuple[int, int], ...]
    two: Array
    warps: Array
    warp: Array
    tilts: Array
    tilt: Array
    friction: float

    def without_two(self, pair: tuple[int, int]) -> Array:
        """Return the curve `(k,)` mm of a pad without these two ridges, or without their mirror images."""
        image = self.last - pair[1] + 1, self.last - pair[0] + 1
        return np.asarray(self.two[self.pairs.index(pair if pair in self.pairs else image)])

    def without(self, number: int) -> Array:
        """Return the curves `(sizes, k)` mm of a pad that lacks some of this ridge, or of its image."""
        image = self.last - number + 1
        return np.asarray(self.ridge[self.numbers.index(number if number in self.numbers else image)])


def refuse_design(design: Design) -> None:
    """Raise InputError for a skin whose faults have no curves here."""
    family = skin_of(design).family
    if family not in ("ridge", "ring"):
        rule = "must be ridges or rings to accept a part by a press"
        raise InputError("design", rule, family, "use fit-material for its modulus")
    if design.contact.plate.shape not in ("flat", "tilted"):
        remedy = "press with a flat plate, and leave [contact.plate] out"
        raise InputError("contact.plate.shape", "must be flat or tilted", design.contact.plate.shape, remedy)


def under_flat_plate(design: Design) -> Design:
    """Return the design, pressed by a flat plate."""
    return design.with_(contact={"plate": Plate()}) if design.contact.plate.shape != "flat" else design


def good_curve(design: Design, largest: float, clock: Stopwatch) -> PadCurve:
    """Return a good part's curve under a flat plate up to `largest` N, in the design's own modulus."""
    flat = under_flat_plate(design)
    curve = small_strain_curve(flat, silicone(design).young_modulus.value, clock)
    return finite_strain_curve(curve, flat, largest, clock)


def press_model(
    design: Design,
    curve: PadCurve,
    clock: Stopwatch,
    plate: Plate | None = None,
    only: int | None = None,
) -> PressModel:
    """Return the curves of good and faulty parts; `curve` is `good_curve`'s, `plate` the one that presses if
    not a flat one, `only` the number of the one ridge that a narrow bar presses."""
    pad, spread, skin = pad_of(design), spread_of(design), skin_of(design)
    known = design.contact.friction
    with clock.stage("friction"):
        coefficient = FULL if known is None else known
        friction = _friction(design, float(curve.force[-1]), coefficient) if coefficient else 0.0
    forces = float(curve.force[-1]) * (np.arange(1, KNOTS + 1) / KNOTS) ** 2
    with clock.stage("faults"):
        flat = _Section(pad, forces, None)
        section = flat if plate is None and only is None else _Section(pad, forces, plate, only)
        factor = PchipInterpolator(curve.force, curve.approach)(forces) / flat.approach()
        if known is not None:
            factor = factor * (1 + friction)
        ridges, height = len(section.numbers), float(skin.profile.height)
        mirror = half_of(pad) is not None and not pad.revolved
        mirrored = mirror and plate is None and only is None
        last = (ridges - 1) // 2 if mirror else ridges - 1
        places = np.unique(np.round(np.linspace(0, last, min(last + 1, MOST_RIDGES))).astype(int))
        if mirror and not mirrored:
            places = np.union1d(places, ridges - 1 - places)
        along = np.linspace(0.0 if pad.revolved else -1.0, 1.0, ridges) if ridges > 1 else np.zeros(1)
        table = section.tables(factor)
        one, nominal = np.eye(ridges), table(np.zeros(ridges))
        drawn = spread.crest_sigma * np.random.default_rng(SEED).standard_normal((PARTS // 2, ridges))
        parts = np.array([table(drops) for drops in np.concatenate([drawn, -drawn])])
        good = parts.mean(axis=0)
        higher = good - nominal  # what scatter adds on the mean, to faulty parts alike
        missing, warps, tilts = (np.array(shares) * height for shares in (MISSING, WARPS, TILTS))
        lacking = [[table(size * one[i]) + higher for size in missing] for i in places]
        pairs = _pairs(ridges, mirrored)
        two = np.array([table(height * (one[i] + one[j])) + higher for i, j in pairs])
        dense = section.dense
        strained = STRAINED_ERROR / 2 * good * (1 - 1 / np.interp(dense, curve.force, curve.strained))
        warp = np.array([table(size * along**2) for size in warps]) + higher
        tilt = np.array([table(size * along) for size in tilts]) + higher
    return PressModel(
        young_modulus=curve.young_modulus,
        modulus_range=(spread.modulus[0], spread.modulus[2]),
        height=height,
        force=dense,
        good=good,
        crests=(parts - good) / math.sqrt(PARTS),
        strained=strained,
        numbers=tuple(section.numbers[i] for i in places),
        last=section.numbers[-1],
        mirrored=mirrored,
        missing=missing,
        ridge=np.array(lacking),
        pairs=tuple((section.numbers[i], section.numbers[j]) for i, j in pairs),
        two=two.reshape(-1, dense.size),
        warps=warps,
        warp=warp,
        tilts=tilts,
        tilt=tilt,
        friction=friction,
    )


class _Section:
    """A whole section on a coarse mesh, pressed at `forces` `(n,)` N by a plate."""

    def __init__(self, pad: Pad, forces: Array, plate: Plate | None, only: int | None = None) -> None:
        used = pad if plate is None else replace(pad, plate=plate)
        solution = linear.level(plane_piece(used, FINENESS, whole=True), ORDER, float(forces[-1]) / 4)
        self.ridges: Ridges = solution.ridges
        self.unit, self.scale, self.forces = solution.unit, solution.scale, forces
        self.numbers = [int(number) for number in self.ridges.numbers]
        self.may = None if only is None else self.ridges.of_point == only
        self.dense = float(forces[-1]) * (np.arange(DENSE) / (DENSE - 1)) ** 2

    def approach(self, drops: Array | None = None) -> Array:
        """Return the approach `(n,)` mm from the first touch, crests lower by `drops` `(ridges,)` mm."""
        ridges = self.ridges if drops is None or not drops.any() else self.ridges.lowered(drops / self.unit)
        approach, start, may = [], None, self.may
        with one_blas_thread():
            for force in self.forces:
                state = press(ridges.flexibility, ridges.gap, float(force) / self.scale, start, may=may)
                approach.append(state.approach)
                start = state.active
        first = 0.0 if may is None else float(ridges.gap[may].min())
        return (np.array(approach) - first) * self.unit

    def tables(self, factor: Array) -> Callable[[Array], Array]:
        """Return what gives the table `(k,)` mm at `dense` forces for drops, coarse approaches times `factor`
        `(n,)`."""

        def table(drops: Array) -> Array:
            knots = np.append(0.0, factor * self.approach(drops))
            # against the root of the force, in which the curve is nearly straight
            roots = np.sqrt(np.append(0.0, self.forces))
            return np.asarray(PchipInterpolator(roots, knots)(np.sqrt(self.dense)))

        return table


def _pairs(ridges: int, mirrored: bool) -> list[tuple[int, int]]:
    """Return pairs of ridges from 0, of a `mirrored` press one of each pair and its image."""
    if not 2 < ridges <= MOST_PAIRS:
        return []
    every = [(i, j) for i in range(ridges) for j in range(i + 1, ridges)]
    return [(i, j) for i, j in every if (i, j) <= (ridges - 1 - j, ridges - 1 - i)] if mirrored else every


@lru_cache(maxsize=2)
def _friction(design: Design, largest: float, coefficient: float) -> float:
    """The relative change of the approach by a plate of this coefficient, with FULL one on which next to
    nothing slips."""
    pad, force = plain_pad(design), FRICTION_POINTS * largest
    solver = solve if pad.revolved else solve_solid
    change = solver(pad, coefficient, force)
    return float(change.after.approach / change.before.approach - 1)
