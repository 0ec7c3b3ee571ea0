"""Approach against force of a design's good and faulty parts, from which `accept` judges a press.

All curves are those of a pad of the design's own modulus, at forces in its terms: a part of s times that
modulus sinks at s F as the design does at F. The good curve is that of a pad's test (pad.py): small strain on
a fine mesh, free ends, finite strain. What a fault changes is solved on one coarse mesh of the section in
small strain and plane strain; the ratio of the good curve to the coarse one carries it over, so that the
mesh's error cancels. Bonded strips keep their modulus in a cast of another silicone; that is left out here
and within `SCALE_ERROR`. Pins are the reduced model's, and their pockets count as silicone: both within
`scale_error`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.interpolate import PchipInterpolator

from skincad.base.arrays import Array, Index
from skincad.base.errors import InputError
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Stopwatch
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.skin_tables import RADIUS_Y, Plate
from skincad.material.pad import (
    APPROACH_ERROR,
    STRAINED_ERROR,
    PadCurve,
    finite_strain_curve,
    small_strain_curve,
)
from skincad.mechanics.bodies.mesh import half_of, plane_piece
from skincad.mechanics.check import spread_of
from skincad.mechanics.contact.frictionless import press
from skincad.mechanics.contact.ridge_model import ridge_approach
from skincad.mechanics.left_out import pocket_bound
from skincad.mechanics.models import linear
from skincad.mechanics.models.corrected import plain_pad
from skincad.mechanics.models.friction import FULL, solve, solve_solid
from skincad.mechanics.models.reduced import PIN_ERRORS, pin_model
from skincad.mechanics.problem import Pad, focused, pad_of
from skincad.shape.skin import skin_of

FINENESS, ORDER = 0.5, 2  # of the coarse mesh; the change by a ridge differs by 3 % on twice as fine a one
KNOTS, DENSE = 22, 400  # forces solved, closer at the first touch, and of the tables between them
MISSING = (0.06, 0.12, 0.25, 0.5, 1.0)  # of a ridge's height, that it lacks
WARPS = (-0.4, -0.2, -0.1, -0.05, -0.02, 0.02, 0.05, 0.1, 0.2, 0.4)  # of the height, at the outermost crest
TILTS = (0.02, 0.05, 0.1, 0.2, 0.4)
MOST_PAIRS = 9  # ridges, of which any two are taken away; of more none are
PARTS, SEED = 40, 20021  # with random crests, of which the good curve is the mean; in pairs of opposite signs
FACE_HEIGHT = 0.2  # of a flat skin's thickness, assumption: in which its face's faults are counted
SAME_PLACE = 1e-3  # mm; pins that are as far from the middle but for this are alike
MOST_RIDGES = 6  # whose absence is solved; of more they are spread from an end to the middle
FACE_ERROR = 0.01  # standard deviation of a face's approach by its mesh, relative, at each force
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
    the approach by a plate on which nothing slips. `alike` says of each of `numbers` which are like it, where
    that is not by a mirror; `scale_error` is the standard deviation of the approach as a whole, relative,
    `row_error` that at each force.
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
    alike: tuple[str, ...] = ()
    scale_error: float = SCALE_ERROR
    row_error: float = 0.0
    family: str = "ridge"

    def without_two(self, pair: tuple[int, int]) -> Array:
        """Return the curve `(k,)` mm of a pad without these two ridges, or without their mirror images."""
        image = self.last - pair[1] + 1, self.last - pair[0] + 1
        return np.asarray(self.two[self.pairs.index(pair if pair in self.pairs else image)])

    def without(self, number: int) -> Array:
        """Return the curves `(sizes, k)` mm of a pad that lacks some of this ridge, or of its image."""
        image = self.last - number + 1
        return np.asarray(self.ridge[self.numbers.index(number if number in self.numbers else image)])


def refuse_design(design: Design) -> None:
    """Raise InputError for a skin whose faults have no curves here, or a plate that does not press it."""
    body, shape = skin_of(design).body, design.contact.plate.shape
    if body == "bent":
        rule = "must not be given to accept a part by a press"
        raise InputError(RADIUS_Y, rule, design.skin.radius_y)
    leans = body == "straight"
    if shape != "flat" and not (leans and shape == "tilted"):
        rule = f"must be {'flat or tilted' if leans else 'flat for pins and round skins'}"
        remedy = "press with a flat plate, and leave [contact.plate] out"
        raise InputError("contact.plate.shape", rule, shape, remedy)


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
    spread, skin, pins = spread_of(design), skin_of(design), skin_of(design).body == "pins"
    known = design.contact.friction
    with clock.stage("friction"):
        coefficient = FULL if known is None else known
        friction = _friction(design, float(curve.force[-1]), coefficient) if coefficient else 0.0
    forces = float(curve.force[-1]) * (np.arange(1, KNOTS + 1) / KNOTS) ** 2
    with clock.stage("faults"):
        flat = parts = _of_pins(design, forces) if pins else _of_section(pad_of(design), forces, None)
        if not (plate is None and only is None):
            parts = _of_section(pad_of(design), forces, plate, only)
        factor = flat.factor(curve)
        if known is not None:
            factor = factor * (1 + friction)
        crests, numbers, places = parts.bend.size, parts.numbers, parts.places
        height = float(skin.profile.height) or FACE_HEIGHT * skin.base.thickness
        table = parts.tables(factor)
        one, nominal = np.eye(crests), table(np.zeros(crests))
        drawn = spread.crest_sigma * np.random.default_rng(SEED).standard_normal((PARTS // 2, crests))
        random = np.array([table(drops) for drops in np.concatenate([drawn, -drawn])])
        good = random.mean(axis=0)
        higher = good - nominal  # what scatter adds on the mean, to faulty parts alike
        missing, warps, tilts = (np.array(shares) * height for shares in (MISSING, WARPS, TILTS))
        lacking = [[table(size * one[i]) + higher for size in missing] for i in places]
        pairs = _pairs(len(numbers), parts.mirrored)
        two = np.array([table(height * (one[i] + one[j])) + higher for i, j in pairs])
        dense = parts.dense
        strained = STRAINED_ERROR / 2 * good * (1 - 1 / np.interp(dense, curve.force, curve.strained))
        warp = np.array([table(size * parts.bend) for size in warps]) + higher
        tilt = np.array([table(size * parts.tilt) for size in tilts]) + higher
    pocket = pocket_bound(design, float(curve.approach[-1]))
    return PressModel(
        young_modulus=curve.young_modulus,
        modulus_range=(spread.modulus[0], spread.modulus[2]),
        height=height,
        force=dense,
        good=good,
        crests=(random - good) / math.sqrt(PARTS),
        strained=strained,
        numbers=tuple(numbers[i] for i in places),
        last=max(numbers, default=0),
        mirrored=parts.mirrored,
        missing=missing,
        ridge=np.array(lacking),
        pairs=tuple((numbers[i], numbers[j]) for i, j in pairs),
        two=two.reshape(-1, dense.size),
        warps=warps,
        warp=warp,
        tilts=tilts,
        tilt=tilt,
        friction=friction,
        alike=parts.alike,
        scale_error=math.hypot(PIN_ERRORS.approach / 2 if pins else SCALE_ERROR, pocket / 2),
        row_error=0.0 if numbers else FACE_ERROR,
        family=skin.family,
    )


@dataclass(frozen=True)
class _Parts:
    """Parts of a design with crests of their own, pressed at `forces` `(n,)` N.

    `pressed` gives the approach `(n,)` mm from the first touch by crests' drops `(crests,)` mm. `numbers` are
    those of the crests that may be missing, `places` those of them that are solved, from 0; `alike` says of
    each which other ones are like it, unless a mirror does. A part that is bent or tilted is so by `bend` and
    `tilt` `(crests,)`, 1 at the outermost.
    """

    forces: Array
    pressed: Callable[[Array], Array]
    numbers: tuple[int, ...]
    places: Index
    mirrored: bool
    bend: Array
    tilt: Array
    alike: tuple[str, ...] = ()

    @property
    def dense(self) -> Array:
        """Forces `(k,)` N of the tables."""
        return np.asarray(float(self.forces[-1]) * (np.arange(DENSE) / (DENSE - 1)) ** 2)

    def factor(self, curve: PadCurve) -> Array:
        """By how much a good part's curve is above this one without drops `(n,)`."""
        own = self.pressed(np.zeros(self.bend.size))
        return np.asarray(PchipInterpolator(curve.force, curve.approach)(self.forces) / own)

    def tables(self, factor: Array) -> Callable[[Array], Array]:
        """Return what gives the table `(k,)` mm at `dense` forces for drops, coarse approaches times `factor`
        `(n,)`."""

        def table(drops: Array) -> Array:
            knots = np.append(0.0, factor * self.pressed(drops))
            # against the root of the force, in which the curve is nearly straight
            roots = np.sqrt(np.append(0.0, self.forces))
            return np.asarray(PchipInterpolator(roots, knots)(np.sqrt(self.dense)))

        return table


def _of_section(pad: Pad, forces: Array, plate: Plate | None, only: int | None = None) -> _Parts:
    """A whole section on a coarse mesh, pressed by a plate."""
    used = focused(pad if plate is None else replace(pad, plate=plate), float(forces[-1]) / 4)
    solution = linear.level(plane_piece(used, FINENESS, whole=True), ORDER, float(forces[-1]) / 4)
    whole, unit, scale = solution.ridges, solution.unit, solution.scale
    numbers = tuple(int(number) for number in whole.numbers)
    may = None if only is None else whole.of_point == only

    def pressed(drops: Array) -> Array:
        ridges = whole.lowered(drops / unit) if drops.any() else whole
        approach, start = [], None
        with one_blas_thread():
            for force in forces:
                state = press(ridges.flexibility, ridges.gap, float(force) / scale, start, may=may)
                approach.append(state.approach)
                start = state.active
        first = 0.0 if may is None else float(ridges.gap[may].min())
        return (np.array(approach) - first) * unit

    if pad.face:  # nothing of it can be missing; a round one bends only
        along = np.array([-1.0, 0.0, 1.0])
        none = np.zeros(0, dtype=int)
        return _Parts(forces, pressed, (), none, False, along**2, along**2 if pad.revolved else along)
    ridges = len(numbers)
    mirror = half_of(pad) is not None and not pad.revolved
    mirrored = mirror and plate is None and only is None
    last = (ridges - 1) // 2 if mirror else ridges - 1
    places = np.unique(np.round(np.linspace(0, last, min(last + 1, MOST_RIDGES))).astype(int))
    if mirror and not mirrored:
        places = np.union1d(places, ridges - 1 - places)
    along = np.linspace(0.0 if pad.revolved else -1.0, 1.0, ridges) if ridges > 1 else np.zeros(1)
    return _Parts(forces, pressed, numbers, places, mirrored, along**2, along)


def _of_pins(design: Design, forces: Array) -> _Parts:
    """Pins by the reduced model; those as far from the middle are alike, and they tilt along x."""
    model, tips = pin_model(design).ridge_model(), np.array([placed.tip for placed in skin_of(design).placed])
    away = np.hypot(*tips[:, :2].T)
    by_distance = [np.flatnonzero(np.isclose(away, d, atol=SAME_PLACE)) for d in np.unique(away.round(3))]
    rows = np.unique(np.round(np.linspace(0, len(by_distance) - 1, MOST_RIDGES)).astype(int))
    groups = [by_distance[row] for row in rows]

    def pressed(drops: Array) -> Array:
        with one_blas_thread():
            return ridge_approach(model, np.tile(drops, (forces.size, 1)), forces)[1]

    return _Parts(
        forces,
        pressed,
        tuple(range(1, away.size + 1)),
        np.array([group[0] for group in groups]),
        False,
        (away / (away.max() or 1.0)) ** 2,
        tips[:, 0] / (np.abs(tips[:, 0]).max() or 1.0),
        tuple(
            f"{group[0] + 1}" + (f" or one as far out ({group.size})" if group.size > 1 else "")
            for group in groups
        ),
    )


def _pairs(ridges: int, mirrored: bool) -> list[tuple[int, int]]:
    """Return pairs of ridges from 0, of a `mirrored` press one of each pair and its image."""
    if not 2 < ridges <= MOST_PAIRS:
        return []
    every = [(i, j) for i in range(ridges) for j in range(i + 1, ridges)]
    return [(i, j) for i, j in every if (i, j) <= (ridges - 1 - j, ridges - 1 - i)] if mirrored else every


@lru_cache(maxsize=2)
def _friction(design: Design, largest: float, coefficient: float) -> float:
    """The relative change of the approach by a plate of this coefficient, with FULL one on which next to
    nothing slips; of pins by one on which nothing does."""
    force = FRICTION_POINTS * largest
    if skin_of(design).body == "pins":
        zero, at = np.zeros((1, skin_of(design).count)), np.array([force])
        stuck, free = (
            ridge_approach(pin_model(design, stuck=s).ridge_model(), zero, at)[1][0] for s in (True, False)
        )
        return float(stuck / free - 1)
    pad = plain_pad(design)
    solver = solve if pad.revolved else solve_solid
    change = solver(pad, coefficient, force)
    return float(change.after.approach / change.before.approach - 1)
