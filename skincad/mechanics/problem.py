"""The pad that a model solves, and the numbers that it answers with; free of any library."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import shapely

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.base.result import Record, item, reported_from
from skincad.inputs.design import Design
from skincad.inputs.guards import THINNEST
from skincad.inputs.material import layers, silicone
from skincad.inputs.skin_tables import RADIUS_Y, Plate
from skincad.laws.neo_hooke import NeoHooke
from skincad.laws.rubber import Rubber
from skincad.shape.curves import Loop, Point, Segment, polygon
from skincad.shape.shots import face
from skincad.shape.skin import Section, cell_section, section, skin_of


def rise(plate: Plate, x: Array) -> Array:
    """Return the height, mm, of the plate's surface at x `(n,)` mm over its lowest line (of a tilted plate:
    over x = 0). Beyond a cylinder's side it is infinite."""
    if plate.shape == "tilted":
        return np.asarray(x * math.tan(math.radians(plate.tilt or 0.0)))
    if plate.shape == "step":
        return np.where(x > plate.position, plate.height or 0.0, 0.0)
    if plate.shape == "cylinder":
        radius = plate.radius or math.inf
        offset = np.abs(x - plate.position) / radius
        half = np.arcsin(np.minimum(offset, 1.0)) / 2
        return np.where(offset < 1.0, 2 * radius * np.sin(half) ** 2, np.inf)
    return np.zeros_like(x)


def steepest(plate: Plate, half_width: float) -> float:
    """Return the largest slope within half_width mm of x = 0; the model takes contact as vertical, which
    is wrong by about half its square."""
    if plate.shape == "tilted":
        return abs(math.tan(math.radians(plate.tilt or 0.0)))
    if plate.shape == "cylinder" and plate.radius:
        return (half_width + abs(plate.position)) / plate.radius
    return 0.0


FLAT = Plate()
NEGLIGIBLE = 0.01  # of the applied force; a smaller all-touch force is negligible
EQUAL_FORCES = 1e-3  # relative: ridges whose forces differ by less, as a mirrored pair's, touch together
BALANCE = 1e-6  # relative; the clamped back must carry the force, or the factorisation is inaccurate
PVDF_DENSITY = 1780.0  # kg/m3; source: data sheets


class ContactError(RefusedError):
    """A contact or finite element solution that does not hold; words say what and the remedy."""


def check_balance(error: float) -> float:
    """Return by how much, relative to the load, the clamped back's force misses it; ContactError if the
    factorisation is inaccurate."""
    if not error <= BALANCE:
        words = f"the clamped back carries the force to {error:.1e} only"
        raise ContactError(f"{words}; take a smaller poisson_ratio")
    return error


class SizeError(InputError):
    """More unknowns than a model can hold: raised before anything of that size is solved."""


class LateError(RefusedError):
    """A model that would take longer than its budget; `seconds` are those expected in all."""

    def __init__(self, seconds: float) -> None:
        super().__init__(f"would take about {seconds:.2g} s")
        self.seconds = seconds


@dataclass(frozen=True)
class Bend:
    """The axis along x at the height z = `axis` that a section turns about, in mm or in the pad's units; y is
    the arc at `radius` from it."""

    radius: float
    axis: float

    def over(self, unit: float) -> Bend:
        """Return it in units of so many mm."""
        return Bend(self.radius / unit, self.axis / unit)

    def stretch(self, z: Array) -> Array:
        """Return how much longer than y the arc at the height z is."""
        return np.asarray((z - self.axis) / self.radius)

    def height(self, z: Array, y: Array) -> Array:
        """Return how high a point of the section at z lies after its turn by the arc y."""
        return np.asarray(self.axis + (z - self.axis) * np.cos(y / self.radius))


@dataclass(frozen=True)
class PadLayer:
    """Silicone below a `face`, which runs from side to side to -x, down to the next layer's or the back; of
    moduli in MPa and kg/m3."""

    face: Segment
    young_modulus: float
    poisson_ratio: float
    density: float
    law: Rubber | None = None

    def over(self, x: float) -> float:
        """Return the face's height at x, mm."""
        if not self.face.bulge:
            return self.face.start.z
        radius = self.face.radius
        half = max(abs(self.face.start.x), abs(self.face.end.x))
        at, rim = (2 * radius * math.sin(math.asin(min(1.0, d / radius)) / 2) ** 2 for d in (abs(x), half))
        return min(self.face.start.z, self.face.end.z) + rim - at


@dataclass(frozen=True)
class Pad:
    """An elastic section of `length` mm along y, clamped at its `back` segments. One that is `revolved` is
    the whole of a skin's section through its axis x = 0, whose half at x >= 0 is turned about it; its length
    does not count, and a ring crosses it twice. Within `focus` mm of x = 0 the mesh resolves a contact.

    Segments that touch may meet the plate. `strips` are loops filled with the film's material
    (moduli in MPa), `voids` are holes. Densities, kg/m3, count where masses do. `ends` `(ridges, ridges)`
    mm/N is the compliance that free ends add, if requested.
    `law` is the silicone's at finite strain, scaled to its modulus; neo-Hooke's where it is None. A pad with
    a `bend` is curved along y too; `length` is that arc's. `layers` of other silicones lie behind its own,
    the first at the back.
    """

    section: Section
    length: float
    young_modulus: float
    poisson_ratio: float
    strips: tuple[Loop, ...] = ()
    voids: tuple[Loop, ...] = ()
    film_modulus: float = 0.0
    film_ratio: float = 0.0
    plate: Plate = FLAT
    density: float = 0.0
    film_density: float = 0.0
    ends: tuple[tuple[float, ...], ...] = ()
    law: Rubber | None = None
    bend: Bend | None = None
    revolved: bool = False
    focus: float = 0.0
    layers: tuple[PadLayer, ...] = ()

    @property
    def materials(self) -> dict[str, tuple[float, float]]:
        """Young's modulus, in the silicone's, and Poisson's ratio of each domain of the mesh."""
        film = {"film": (self.film_modulus / self.young_modulus, self.film_ratio)} if self.strips else {}
        behind = {
            name: (layer.young_modulus / self.young_modulus, layer.poisson_ratio)
            for name, layer in self._layers.items()
        }
        return {"skin": (1.0, self.poisson_ratio), **film, **behind}

    @property
    def densities(self) -> dict[str, float]:
        """Density of each domain of the mesh, kg/m3."""
        behind = {name: layer.density for name, layer in self._layers.items()}
        return {"skin": self.density, "film": self.film_density, **behind}

    @property
    def _layers(self) -> dict[str, PadLayer]:
        return {f"layer{number}": layer for number, layer in enumerate(self.layers, 1)}

    @property
    def laws(self) -> dict[str, Rubber]:
        """The law of each domain of the mesh that is silicone and not neo-Hookean: of the skin, of strips of
        the skin's own moduli, and of layers."""
        moduli, laws = self.materials, {name: layer.law for name, layer in self._layers.items()}
        laws |= {name: self.law for name in ("skin", "film") if moduli.get(name) == moduli["skin"]}
        # neo-Hooke's is what bodies are without one
        return {name: law for name, law in laws.items() if not (law is None or isinstance(law, NeoHooke))}

    @property
    def face(self) -> bool:
        """Whether the base itself meets the plate."""
        return any(s.kind == "base" and s.touches for s in self.section.outline)

    @property
    def ridges(self) -> tuple[int, ...]:
        """Numbers of the ridges that can touch, ascending."""
        numbers = {s.feature for s in self.section.outline if s.touches}
        return tuple(sorted(r for r in numbers if r is not None))

    @property
    def top(self) -> float:
        """Largest z of the contact segments, mm, exact."""
        return max(s.top for s in self.section.outline if s.touches)


@dataclass(frozen=True)
class Spread:
    """How parts differ: crest error's standard deviation, mm, and modulus low, nominal and high, MPa."""

    process: str
    crest_sigma: float
    modulus: tuple[float, float, float]


@dataclass(frozen=True)
class RidgeModel:
    """A pad reduced to one force a ridge (ridge_model.py).

    `gap` `(n,)`, `coupling` `(n, n)` with zero diagonal, and per ridge a table of `force` `(t,)` against
    `indentation` `(n, t)`, in the pad's units: `unit` mm and `scale` N.
    """

    gap: Array
    coupling: Array
    force: Array
    indentation: Array
    unit: float
    scale: float


@dataclass(frozen=True)
class Yield(Record):
    """Share of parts in which all ridges touch at the applied force, and its sensitivities."""

    passing: Estimate
    interval: tuple[float, float] = item(
        meaning="holds the share, with the error of model and sample, within 0 and 1", key="yield_interval"
    )
    crest_sensitivity: tuple[float, ...] = item("N/mm", "change of the all-touch force by each crest's drop")
    modulus_sensitivity: float = item("N/MPa", "its change with E")
    largest: str = item(meaning="the larger loss and its remedy", key="yield_largest_loss")
    needed: Estimate = item("N", "from this force on all touch in 95 % of the parts", key="yield_force_N")
    approaches: tuple[float, float] | None = item(
        "mm", "of a face: 95 % of the parts lie there", key="yield_approach_mm", default=None, optional=True
    )
    widths: tuple[float, float] | None = item(
        "mm", "of its contact: the same", key="yield_contact_width_mm", default=None, optional=True
    )

    share = reported_from("passing.value", meaning="the share", key="yield", error="error")

    error = reported_from("passing.error", meaning="its error", key="yield_error")


@dataclass(frozen=True)
class SelfContact(Record):
    """Contact that no model knows, of the skin with itself or, off its crests, with the plate: found by the
    linear model's deformed section, up to the force at which its strains end."""

    free_to: float = item("N", "up to this force there is none")
    begins: Estimate = item("N", "where it begins; null: none is found")
    where: str = item(meaning="what meets there", null=True, default="")


def no_yield(failure: Exception) -> str:
    """Return the warning for a verdict whose yield could not be computed."""
    return f"no yield: {failure}"


@dataclass(frozen=True)
class Request:
    """A request to a model: at `force` N, to a relative tolerance, or the best within `budget` s.

    `crest_offsets`, mm, are those of one measured part, positive where a crest is lower than designed.
    Contact of the skin with itself is looked for up to `ridge_limit` N on a ridge, not at all at 0.
    `ridge_model` asks for the model of the yield too, `rough` for ratios of forces alone. With `must_fit` a
    first mesh that would overrun the budget raises LateError; otherwise it is solved.
    """

    force: float
    tol: float | None = None
    budget: float | None = None
    crest_offsets: tuple[float, ...] = ()
    ridge_model: bool = False
    ridge_limit: float = 0.0
    must_fit: bool = False
    rough: bool = False


@dataclass(frozen=True, eq=False)
class DeformedLoop:
    """A closed loop of the section's boundary at rest and `moved` `(n, 2)`, x and z of the design's frame.
    `touches` `(n,)` marks what of it may meet the plate, whose `pressure` `(n,)` MPa on it is empty where it
    is not known. In units while it is, else in mm."""

    rest: Array
    moved: Array
    touches: Mask
    pressure: Array = field(default_factory=lambda: np.empty(0))


DeformedPiece = tuple[DeformedLoop, ...]  # of the section: its outer loop and its holes, in any order


@dataclass(frozen=True)
class Answer:
    """A model's answer at `force` N: estimates with their discretisation error, work and residual.

    `residual` is the largest relative violation of contact and equilibrium, 0 for a closed form. `fault`
    names an undetected contact of the skin with itself or the plate, "" if there is none. `own_seconds` is
    the model's own time, without the models that it builds on. `deformed` is the section under the force,
    `contact_width` mm that of the contact of a skin without features.
    """

    touching: int
    all_touch_force: Estimate
    approach: Estimate
    ridge_force: tuple[Estimate, ...]
    unknowns: int
    residual: float
    seconds: dict[str, float]
    warnings: tuple[str, ...] = ()
    fault: str = ""
    ridge_model: RidgeModel | None = None
    self_contact: SelfContact | None = None
    own_seconds: float = 0.0
    contact_width: Estimate | None = None
    deformed: tuple[DeformedPiece, ...] = field(default=(), compare=False, repr=False)

    def consistent(self, force: float) -> Answer:
        """Return the answer with ridge forces and `touching` that agree with its all-touch force.

        A model that corrects another changes both apart, so near the threshold they may contradict each
        other. The all-touch force is the better one: ridges that must touch get an equal part of the load
        beyond it, ridges that must not get none. Errors cover what is moved.
        """
        needed, shares = self.all_touch_force.value, [share.value or 0.0 for share in self.ridge_force]
        lowest = min(shares)
        if needed is None or len(shares) == 1 or (lowest > 0) == (needed <= force):
            return self
        late = [share <= lowest * (1 + EQUAL_FORCES) for share in shares]
        others = math.fsum(share for share, is_late in zip(shares, late, strict=True) if not is_late)
        if not others:
            return self
        load = max(0.0, force - needed) / len(shares)
        scale = (force - load * sum(late)) / others
        changed = [load if is_late else share * scale for share, is_late in zip(shares, late, strict=True)]
        moved = max(abs(new - old) for new, old in zip(changed, shares, strict=True))
        ridge_force = tuple(
            replace(old, value=new, error=None if old.error is None else max(old.error, moved))
            for old, new in zip(self.ridge_force, changed, strict=True)
        )
        touching = len(shares) - (sum(late) if needed > force else 0)
        return replace(self, touching=touching, ridge_force=ridge_force)

    def widened(self, threshold: float, approach: float, share: float) -> Answer:
        """Return the answer with larger errors: relative for the all-touch force and the approach, and by
        `share` N."""

        def wider(estimate: Estimate, more: float) -> Estimate:
            return replace(estimate, error=None if estimate.error is None else estimate.error + more)

        first, down = self.all_touch_force, self.approach
        return replace(
            self,
            all_touch_force=wider(first, (first.value or 0.0) * threshold),
            approach=wider(down, abs(down.value or 0.0) * approach),
            ridge_force=tuple(wider(ridge, share) for ridge in self.ridge_force),
            contact_width=self.contact_width
            and wider(self.contact_width, (self.contact_width.value or 0.0) * approach / 2),
        )


def wider_by(width: Estimate, approach: float) -> Estimate:
    """Return a contact's width where the approach changes by a factor: as its root, in Hertz' contact and on
    a thin bonded layer (Johnson, Contact Mechanics, 1985, eq. 4.22 and sec. 5.8). Half of the width's change
    is taken as its error."""
    value, root = width.value or 0.0, math.sqrt(approach)
    return Estimate(value * root, math.hypot((width.error or 0.0) * root, value * (root - 1) / 2), width.unit)


def pad_of(design: Design) -> Pad:
    """Return the pad of a design whose section is swept straight along y, its slots filled as `film_state`
    says, or of one that turns about its middle: rings, a round flat skin, or one pin on a round skin.

    Raises InputError for a skin that is curved along y too, and for pins of which there are more or whose
    base is no disc.
    """
    rule = "must not be given: all but the winkler model and the solids take the skin as straight along y"
    if math.isfinite(design.skin.radius_y):
        raise InputError(RADIUS_Y, rule, design.skin.radius_y, "leave it out")
    return solid_pad_of(design)


def solid_pad_of(design: Design) -> Pad:
    """Return the pad of a design, straight along y or not; a round skin's section turns.

    Raises InputError for pins, as `pad_of`.
    """
    skin, base = skin_of(design), design.skin
    if skin.body == "pins" and skin.count > 1:
        raise InputError("pin", "must be one: a section through the middle shows no others", skin.count)
    if skin.body == "pins":
        remedy = 'give skin.outline = "round"'
        raise InputError("skin.outline", "must be 'round' round a single pin", base.outline, remedy)
    half, arc = base.width / 2, base.curvature_radius
    shape = cell_section(design, half, 1, arc) if skin.standing else section(design)
    material, bonded = silicone(design), design.film if design.film_state == "bonded" else None
    return Pad(
        section=shape,
        length=base.length,
        young_modulus=material.young_modulus.value,
        poisson_ratio=material.poisson_ratio,
        strips=tuple(slot.loop(bonded.thickness) for slot in shape.slots) if bonded else (),
        voids=tuple(slot.loop() for slot in shape.slots) if design.film_state == "loose" else (),
        film_modulus=bonded.young_modulus if bonded else 0.0,
        film_ratio=bonded.poisson_ratio if bonded else 0.0,
        plate=design.contact.plate,
        density=material.density,
        film_density=PVDF_DENSITY if bonded and shape.slots else 0.0,
        law=material.law,
        bend=Bend(base.radius_y, -base.back_radius) if skin.body == "bent" else None,
        revolved=skin.body == "turned",
        layers=tuple(layers_of(design, shape, base.width / 2)),
    )


def layers_of(design: Design, shape: Section, half: float) -> Iterator[PadLayer]:
    """Yield the layers that a design's shots are in a section of it, which is `half` mm wide to either side.

    Raises InputError for a face that meets the outline between the sides, or a slot.
    """
    below = shapely.Polygon(polygon(shape.outline, FACE_TOLERANCE))
    slots = [shapely.Polygon(polygon(slot.loop(), FACE_TOLERANCE)) for slot in shape.slots]
    for number, (shot, stuff) in enumerate(zip(design.shot or (), layers(design), strict=True), 1):
        (line_of,) = face(design, number, half)
        line = shapely.LineString([*polygon((line_of,), FACE_TOLERANCE).tolist(), [*line_of.end]])
        key = f"shot.{'thickness' if shot.depth is None else 'depth'}"
        value = shot.thickness if shot.depth is None else shot.depth
        if not below.buffer(FACE_TOLERANCE).contains(line):
            rule = f"shot {number}'s face must stay inside the skin, and meets its front"
            raise InputError(key, rule, value, "a face further behind")
        if any(line.distance(slot) < THINNEST for slot in slots):
            rule = f"shot {number}'s face must keep {THINNEST:g} mm from the slots"
            raise InputError(key, rule, value, "a face further behind")
        modulus = stuff.young_modulus.value
        yield PadLayer(line_of, modulus, stuff.poisson_ratio, stuff.density, stuff.law)


FACE_TOLERANCE = 1e-3  # mm


FOCUS = 1.5  # half-widths of the contact by Hertz, which a thin base makes narrower


def focused(pad: Pad, force: float) -> Pad:
    """Return a pad with its `focus` at `force` N, where it touches with one arc over x = 0: by Hertz
    (Johnson, Contact Mechanics, 1985, eq. 4.22 and 4.43)."""
    middle = [s for s in pad.section.outline if s.touches and s.end.x < 0 < s.start.x and s.bulge]
    if len(pad.ridges) > 1 or not middle or not (pad.revolved or middle[0].kind == "base"):
        return pad
    radius, stiffness = middle[0].radius, pad.young_modulus / (1 - pad.poisson_ratio**2)
    line = math.sqrt(4 * force * radius / (math.pi * pad.length * stiffness))
    half = math.cbrt(3 * force * radius / (4 * stiffness)) if pad.revolved else line
    return replace(pad, focus=FOCUS * half)


def one_ridge(pad: Pad) -> Pad:
    """Return the pad's middle ridge on a straight-sided piece of its base, without slots: to see its mesh."""
    outline = pad.section.outline
    ridge = pad.ridges[len(pad.ridges) // 2]
    crest = [s for s in outline if s.feature == ridge]
    first, last, low = crest[0].start, crest[-1].end, min(s.start.z for s in outline)
    below_last, below_first = Point(last.x, low), Point(first.x, low)
    back = Segment(below_last, below_first, kind="back")
    base = (Segment(last, below_last), back, Segment(below_first, first))
    return replace(pad, section=Section((*crest, *base)), strips=(), voids=())


def check_flat(plate: Plate, model: str, other: str) -> None:
    """Raise InputError for a plate that a model does not support; `other` is the model to take."""
    if plate.shape != "flat":
        rule = f"must be 'flat' for the {model} model"
        raise InputError("contact.plate.shape", rule, plate.shape, f"take the {other} model")


def check_pad(pad: Pad) -> None:
    """Raise InputError for a pad that no model can solve."""
    if not 0 <= pad.poisson_ratio <= 0.4999999:
        raise InputError("material.poisson_ratio", "must be from 0 to 0.4999999", pad.poisson_ratio)
    if not (pad.young_modulus > 0 and math.isfinite(pad.young_modulus)):
        raise InputError("material.young_modulus", "must be above 0 MPa", pad.young_modulus)
    if not pad.ridges:
        raise InputError("section", "has no crown that could touch", remedy="give one a ridge number")
    if not any(s.kind == "back" for s in pad.section.outline):
        raise InputError("section", "has no back to clamp", remedy="mark a segment as 'back'")
