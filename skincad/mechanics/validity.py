"""Where the models end: a skin pressed flat, ridges strained too much or tipped over, a plate too steep."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.inputs.design import Design
from skincad.inputs.guards import face_heights
from skincad.inputs.material import foreign_modulus, layers, silicone
from skincad.inputs.silicone import Silicone
from skincad.mechanics.problem import Answer, steepest
from skincad.shape.skin import skin_of

LARGEST_SLOPE = 0.35  # slope of the plate; vertical contact neglects half its square, 6 %
LARGEST_STRAIN = 0.3  # nominal strain of a ridge where all touch, beyond which there is no verdict
SMALL_STRAIN = 0.1  # nominal strain of a ridge up to which small strain is meant
TIPPING_WARNING = 0.5  # of the force at which a ridge tips over; beyond it a better model is needed


class Shares(Protocol):
    """An answer with the force of each ridge and the approach."""

    @property
    def ridge_force(self) -> tuple[Estimate, ...]: ...  # noqa: D102

    @property
    def approach(self) -> Estimate: ...  # noqa: D102


@dataclass(frozen=True)
class Limits:
    """Where a model's range ends: `height` mm of the skin with its features, by which it would be pressed
    flat.

    `squeeze` and `shear` N are the forces on a feature, ring 1 of rings, along its axis and across it at a
    nominal strain of 1 (the tensor component, half the angle), over its section halfway up; `buckling` N is
    the force at which it tips over. All three are infinite for a model of large strain, and of a flat skin:
    of that the approach ends the range, at `deepest` mm. `shares` `(n,)` are rings' areas by ring 1's.
    """

    height: float
    squeeze: float = math.inf
    shear: float = math.inf
    buckling: float = math.inf
    family: str = "ridge"
    deepest: float = math.inf
    shares: tuple[float, ...] = ()

    def bears(self, count: int) -> float:
        """Return the force, N, that `count` features bear within the range if all are strained alike."""
        return self.largest * (math.fsum(self.shares) or count)

    def on_first(self, forces: Array) -> Array:
        """Return forces `(n,)` on the features, N, as forces on the first that strain it as much."""
        return forces / self.shares if self.shares else forces

    @property
    def largest(self) -> float:
        """The force on a ridge, N, from which on it is in no case within the range."""
        return min(LARGEST_STRAIN * self.squeeze, self.buckling)

    def strain(self, normal: float, tangential: float = 0.0, approach: float = 0.0) -> float:
        """Return the largest nominal strain under the largest forces, N, of the plate on a ridge; of a flat
        skin at an approach, mm."""
        return max(normal / self.squeeze, tangential / self.shear, LARGEST_STRAIN * approach / self.deepest)

    def crushed_reason(self, approach: float) -> str:
        """Return why the skin is pressed flat at this approach, mm, or beyond the range, or ""."""
        if approach < min(self.height, self.deepest):
            return ""
        if approach < self.height:
            return strained_reason("skin's", self.strain(0.0, approach=approach))
        both = f"skin and {self.family}s" if self.family else "skin"
        return f"pressed flat: an approach of {approach:.3g} mm into {self.height:.3g} mm of {both}"

    def overload_reason(self, normal: float, tangential: float = 0.0) -> str:
        """Return why the plate's largest forces on a feature, N, exceed small strain, or ""."""
        strain, of = self.strain(normal, tangential), self.family
        if strain > LARGEST_STRAIN:
            return strained_reason(f"{of}s'", strain)
        if normal > self.buckling:
            return f"a {of} tips over at {self.buckling:.3g} N and would carry {normal:.3g} N"
        return ""


def strained_reason(whose: str, strain: float) -> str:
    """Return the words for a nominal strain beyond small strain."""
    return f"the {whose} nominal strain is {strain:.2g}; the model's range ends at {LARGEST_STRAIN:g}"


def limits(design: Design) -> Limits:
    """Return where small strain ends."""
    material, skin = silicone(design), skin_of(design)
    if skin.bare:
        return Limits(skin.height, family="", deepest=LARGEST_STRAIN * skin.height)
    area = skin.placed[0].area
    shares = tuple(placed.area / area for placed in skin.placed) if skin.placed[-1].area != area else ()
    shear = material.young_modulus.value / (1 + material.poisson_ratio) * area
    squeeze = column_modulus(design) * area
    return Limits(skin.height, squeeze, shear, buckling_force(design), skin.family, shares=shares)


def column_modulus(design: Design) -> float:
    """Return the modulus of a feature as a column, MPa: a pin's E, as its sides are free all round; else
    E / (1 - nu^2)."""
    held = skin_of(design).form.column.held
    return plane_modulus(design) if held else silicone(design).young_modulus.value


def refuse_crushed(design: Design, force: float, model: str, approach: float) -> None:
    """Raise InputError where a model finds the skin pressed flat: `approach` mm at `force` N."""
    skin = skin_of(design).height
    if approach >= skin:
        most = force * skin / approach
        words = f"must stay below about {most:.3g} N, which press the skin flat in the {model} model"
        raise InputError("force", words, force, "take a smaller force")


def crown_radius(design: Design) -> float:
    """Return the radius, mm, of the features' rounded tips; infinite for flat ones."""
    shape = skin_of(design).profile
    return shape.tip_width**2 / (8 * shape.crown) + shape.crown / 2 if shape.crown else math.inf


def crown_rises(design: Design) -> Array:
    """Return by how much each feature's highest point is above its tip on the axis `(n,)` mm: a crown of
    radius r that leans by a rises 2 r sin(a / 2)^2, up to its edge."""
    shape, radius, lean = skin_of(design).profile, crown_radius(design), np.abs(skin_of(design).leans)
    edge = shape.tip_width / 2 * np.sin(lean) - shape.crown * np.cos(lean)
    if not math.isfinite(radius):
        return np.asarray(edge)
    on_crown = 2 * radius * np.sin(lean / 2) ** 2
    return np.where(radius * np.sin(lean) <= shape.tip_width / 2, on_crown, edge)


def plane_modulus(design: Design) -> float:
    """Return E / (1 - nu^2) of a design's silicone, MPa."""
    material = silicone(design)
    return material.young_modulus.value / (1 - material.poisson_ratio**2)


def through_base(design: Design) -> tuple[tuple[float, Silicone], ...]:
    """Return the silicones that the base has in its middle, each with its thickness, mm, from the back."""
    rows, below = list[tuple[float, Silicone]](), 0.0
    for shot, stuff in zip(design.shot or (), layers(design), strict=True):
        middle, _ = face_heights(design.skin, shot)
        rows.append((middle - below, stuff))
        below = middle
    return (*rows, (design.skin.thickness - below, silicone(design)))


def base_softness(design: Design) -> float:
    """Return how much more the base gives than one of the skin's own silicone alone: its layers are springs
    one behind the other."""
    if not design.shot:
        return 1.0
    own = silicone(design).young_modulus.value
    give = (thickness * own / stuff.young_modulus.value for thickness, stuff in through_base(design))
    return math.fsum(give) / design.skin.thickness


def ridge_strain(design: Design, answer: Shares) -> float:
    """Return the nominal strain of the most strained feature: its force over its modulus as a column and its
    area halfway up; of a flat skin the approach over its thickness."""
    ends = limits(design)
    if not ends.family:
        return (answer.approach.value or 0.0) / ends.height
    return ends.strain(_largest(design, answer))


def tipping(design: Design, answer: Shares) -> float:
    """Return the most loaded feature's force over the force at which it tips over; 0 of a flat skin."""
    return _largest(design, answer) / limits(design).buckling


def exceeds_small_strain(design: Design, answer: Shares) -> bool:
    """Whether ridges bear more than small strain is meant for, or come near to tipping over."""
    return ridge_strain(design, answer) > SMALL_STRAIN or tipping(design, answer) > TIPPING_WARNING


def _largest(design: Design, answer: Shares) -> float:
    """The most loaded feature's force, N, of rings scaled to ring 1's area; of a skin curved along y what it
    were with the middle's force per length all along."""
    forces = np.array([force.value or 0.0 for force in answer.ridge_force])
    return float(limits(design).on_first(forces).max()) * peak(design, answer.approach.value or 0.0)


def peak(design: Design, approach: float) -> float:
    """Return a ridge's largest force per length over its mean: 1 of a straight skin.

    Along y a row of springs is pressed in by `approach` less y^2 / (2 R) mm, and touches where that is above
    0.
    """
    radius, half = design.skin.radius_y, skin_of(design).form.along * design.skin.length / 2
    if approach <= 0.0:
        return 1.0
    touches = math.sqrt(2 * radius * approach)
    return 1.5 * half / touches if touches < half else approach / (approach - half**2 / (6 * radius))


def buckling_force(design: Design) -> float:
    """Return the force, N, at which a feature, the highest of unlike ones, tips over under a plate: a column
    that shears, clamped at its root, its tip held upright by the plate and free to slide along it.

    G A / 2 (sqrt(1 + 4 P / (G A)) - 1), with P = pi^2 E' I / h^2, I = L w^3 / 12, A = 5/6 L w and w the mean
    width: Haringx, Philips Res. Rep. 3 (1948) 401. Of a pin E, I = A w^2 / 16 and 9/10 A. Of ring 1, which
    its turn stiffens, as of a straight ridge of its length. Plane finite strain finds single ridges, 1.0 to
    2.7 widths high and tapered by up to half, to tip over at 0.84 to 1.20 times this (14 random ones; 0.72 to
    1.22 for the 20 before them). Tips of stubs fold first, from a nominal strain of about 0.2 on.
    """
    material, skin = silicone(design), skin_of(design)
    column, area = skin.form.column, skin.placed[0].area
    inertia = column.gyration * skin.profile.mean_width**2 * area
    bending = math.pi**2 * column_modulus(design) * inertia / max(skin.heights) ** 2
    shear_modulus = material.young_modulus.value / (2 * (1 + material.poisson_ratio))
    shear = column.shear * shear_modulus * area
    return shear / 2 * (math.sqrt(1 + 4 * bending / shear) - 1)


def small_strain_violation(design: Design, force: float, answer: Answer) -> str:
    """Why the verdict lies beyond the model's range, or "": judged where all features begin to touch; of a
    flat skin, of which the approach is asked, at the force."""
    ends = limits(design)
    if not ends.family:
        strain = ridge_strain(design, answer)
        return strained_reason("skin's", strain) if strain > LARGEST_STRAIN else ""
    threshold = answer.all_touch_force.value
    at = 1.0 if threshold is None else min(1.0, threshold / force)
    return ends.overload_reason(_largest(design, answer) * at)


def strain_warnings(design: Design, answer: Answer) -> tuple[str, ...]:
    """Return warnings where the nominal strain is no small one, and where a ridge nearly tips over."""
    strain, part = ridge_strain(design, answer), tipping(design, answer)
    of = limits(design).family or "skin"
    notes = {
        f"nominal {of} strain {strain:.2g} is beyond the small-strain range ({SMALL_STRAIN:g})": strain
        > SMALL_STRAIN,
        f"the most loaded {of} bears {part:.0%} of the force at which it tips over": part > TIPPING_WARNING,
    }
    return tuple(words for words, wrong in notes.items() if wrong)


def bone_warnings(design: Design) -> tuple[str, ...]:
    """Return the warning that a bone is taken as a flat back."""
    if design.mold.bone is None:
        return ()
    return (
        "mold.bone is taken as a flat back at z = 0; skincad make says what a back at its top would change",
    )


def material_warnings(design: Design) -> tuple[str, ...]:
    """Return the warning that the material's name and its modulus are those of two silicones."""
    if (mismatch := foreign_modulus(design)) is None:
        return ()
    named, modulus, remedy = mismatch
    interval = f"{named.young_modulus.low:g} to {named.young_modulus.high:g} MPa"
    return (f"the modulus of {modulus.value:g} MPa is not that of {named.name} ({interval}); {remedy}",)


def slope_warnings(design: Design) -> tuple[str, ...]:
    """Say what a shaped plate's slopes leave out; raise InputError where they are too steep."""
    plate = design.contact.plate
    slope = steepest(plate, design.skin.width / 2)
    if slope > LARGEST_SLOPE:
        rule = f"must not slope by more than {LARGEST_SLOPE:g} within the skin (contact is taken as vertical)"
        raise InputError("contact.plate", rule, slope, "take a larger radius")
    if slope == 0.0:
        return ()
    return (f"contact is taken as vertical: with slopes of up to {slope:.2g} that is {slope**2 / 2:.1%} off",)
