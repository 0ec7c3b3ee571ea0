"""The tables of a design that say what stands on its skin, one a family, and where each feature stands.

The frame and each length are defined in docs/understand/geometry.md: x across the ridges, y along them,
z out of the skin. A place on the skin is two arcs from its middle, u along x and v along y, mm.
"""

from __future__ import annotations

import math
from collections import Counter
from functools import lru_cache, partial
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from skincad.base.errors import InputError
from skincad.base.tables import Table, quantity
from skincad.inputs.skin_tables import Base

LOWEST_CROWN = 1e-9  # mm, of a sphere; a lower one is flat
HIGHEST = 50.0  # mm, of a feature
MOST_PINS = 2000
ONE_HEIGHT: dict[str, Any] = {"oneOf": [{"required": ["height"]}, {"required": ["heights"]}]}
EACH_HEIGHT: dict[str, Any] = {
    "unit": "mm",
    "items": {"type": "number", "exclusiveMinimum": 0, "maximum": HIGHEST},
}
A_PITCH: dict[str, Any] = {"anyOf": [{"required": ["pitch"]}, {"properties": {"count": {"const": 1}}}]}


def _each_height(name: str, entries: Any) -> Any:
    """Check a list of heights, so that what is wrong with one names its feature and not its place."""
    if isinstance(entries, list | tuple):
        for number, value in enumerate(entries, 1):
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value <= HIGHEST:
                raise InputError(
                    "", f"{name} {number} must be above 0 and at most {HIGHEST:g} mm high", value
                )
    return entries


_List = Field(strict=False)
Heights = Annotated[tuple[float, ...], _List, BeforeValidator(partial(_each_height, "ridge"))]
PinHeights = Annotated[tuple[float, ...], _List, BeforeValidator(partial(_each_height, "pin"))]


def _check_heights(table: Any, family: str) -> None:
    """Raise InputError unless a table has one height for all, or a list of them."""
    if table.heights is None:
        if table.height is None:
            remedy = f"give {family}.height a value, or {family}.heights one a {family}"
            raise InputError("height", "is missing", remedy=remedy)
        return
    for key in ("height", "levelling"):
        if (beside := getattr(table, key)) is not None:
            rule = f"must not be given beside {family}.heights"
            raise InputError(key, rule, beside, "leave one of them out")


class Ridge(Table):
    """The ridges, alike but for their heights, each on its own normal of the base circle."""

    model_config = ConfigDict(json_schema_extra={**ONE_HEIGHT, **A_PITCH})

    family: ClassVar[str] = "ridge"  # its key in a design and in FAMILIES
    pocket: ClassVar[Pocket | None] = None  # ridges have slots
    widths: ClassVar[tuple[str, str]] = "root_width", "tip_width"  # the keys of both

    count: int = quantity("1", "number of ridges", ge=1, le=999)
    pitch: float | None = quantity(
        "mm",
        "axis to axis along the base circle; of one ridge not needed",
        gt=0.0,
        le=100.0,
        default=None,
    )
    height: float | None = quantity(
        "mm", "base circle to the crown's summit, of every ridge", gt=0.0, le=HIGHEST, default=None
    )
    heights: Heights | None = Field(
        default=None,
        description="the same of each ridge, the one at the smallest x first, in the place of height",
        json_schema_extra=EACH_HEIGHT,
    )
    levelling: float | None = quantity(
        "1",
        "by what part of its crest's drop below the highest a ridge is higher than height: 0 alike, "
        "1 all crests level; 0 if not given",
        ge=0.0,
        le=1.0,
        default=None,
    )
    root_width: float = quantity("mm", "flank to flank on the base circle, before fillets", gt=0.0, le=100.0)
    tip_width: float = quantity("mm", "chord of the crown, before fillets", gt=0.0, le=100.0)
    crown: float = quantity("mm", "rise of the tip's arc in its middle above its edges", ge=0.0, le=10.0)
    tip_fillet: float = quantity("mm", "radius between flank and crown", ge=0.0, le=20.0, default=0.0)
    root_fillet: float = quantity("mm", "radius between flank and base circle", ge=0.0, le=20.0, default=0.0)

    @property
    def spacing(self) -> float:
        """The pitch, mm; of one ridge that is given none, twice its root with both fillets.

        There it is no distance, but a length for what scales with ridges, as the mesh files' chords.
        """
        return 2 * (self.root_width + 2 * self.root_fillet) if self.pitch is None else self.pitch

    @model_validator(mode="after")
    def _pitched(self) -> Self:
        if self.pitch is None and self.count > 1:
            remedy = f"give {self.family}.pitch a value; only one {self.family} needs none"
            raise InputError("pitch", "is missing", remedy=remedy)
        return self

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        _check_heights(self, self.family)
        if self.heights is not None and len(self.heights) != self.count:
            rule = f"must be {self.count} values, one a {self.family} ({self.family}.count)"
            remedy = f"give as many, or {self.family}.height for all"
            raise InputError("heights", rule, len(self.heights), remedy)
        return self


class Ring(Ridge):
    """Concentric ridges on a round skin, ring 1 the innermost."""

    family: ClassVar[str] = "ring"

    radius: float | None = quantity(
        "mm",
        "of ring 1's crest line, along the arc; half a pitch, so that crests are a pitch apart in the middle "
        "too, if not given",
        gt=0.0,
        le=500.0,
        default=None,
    )

    @property
    def first_radius(self) -> float:
        """Arc from the middle to ring 1's axis, mm."""
        return self.spacing / 2 if self.radius is None else self.radius


# T, low and high, of sintered neodymium; source: magnetexpert.com, magnetic properties of neodymium magnets
# (read in November 2026)
GRADES = {
    "N35": (1.17, 1.22),
    "N38": (1.22, 1.25),
    "N40": (1.25, 1.28),
    "N42": (1.28, 1.32),
    "N45": (1.32, 1.38),
    "N48": (1.38, 1.42),
    "N50": (1.40, 1.45),
    "N52": (1.43, 1.48),
}
NORTH = {"up": (0.0, 0.0, 1.0), "down": (0.0, 0.0, -1.0), "x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0)}
_Remanence = Annotated[float, Field(gt=0.0, le=2.0)]


class Magnet(Table):
    """A cylinder magnet upright in a pocket, pushed in till the pocket's end, or till `gap` before it; the
    rest of the pocket behind it is capped with silicone."""

    diameter: float = quantity("mm", "of the magnet; a pocket 0.1 to 0.2 mm narrower grips it", ge=0.2, le=50)
    length: float = quantity("mm", "along the pocket", ge=0.1, le=100.0)
    grade: Literal["N35", "N38", "N40", "N42", "N45", "N48", "N50", "N52"] | None = Field(
        default=None, description="of sintered neodymium, from which the remanence and its range follow"
    )
    remanence: Annotated[tuple[_Remanence, _Remanence], _List] | None = Field(
        default=None,
        description="low and high, in the place of a grade: of ferrite about 0.4, of a rubber magnet 0.2",
        json_schema_extra={"unit": "T"},
    )
    north: Literal["up", "down", "x", "y"] = Field(
        default="up",
        description="where its north pole looks: up to the face, down to the back, or across along x or y",
    )
    gap: float = quantity("mm", "of silicone between it and the pocket's end", ge=0.0, le=50.0, default=0.0)

    @property
    def range(self) -> tuple[float, float]:
        """Smallest and largest remanence, T."""
        return GRADES[self.grade] if self.grade else self.remanence or (0.0, 0.0)

    @model_validator(mode="after")
    def _graded(self) -> Self:
        if (self.grade is None) == (self.remanence is None):
            words = "is missing" if self.grade is None else "must not be given beside remanence"
            raise InputError("grade", words, self.grade, "give a grade, as N42, or remanence = [low, high]")
        if self.remanence and self.remanence[0] > self.remanence[1]:
            raise InputError("remanence", "needs low <= high", self.remanence, "give the lower one first")
        return self


class Pocket(Table):
    """A round hole from the skin's back for a magnet, a marker or an electrode, kept free by a core pin."""

    diameter: float = quantity("mm", "of the hole", ge=0.3, le=50.0)
    depth: float = quantity(
        "mm", "from the flat back, or from the middle of one that is bent along y", ge=0.2, le=100.0
    )
    offset: float = quantity("mm", "along x, from under the feature's summit", ge=-50.0, le=50.0, default=0.0)
    magnet: Magnet | None = None

    @property
    def magnet_span(self) -> tuple[float, float]:
        """From where to where its magnet reaches over the flat back, mm; (0, 0) without one."""
        if self.magnet is None:
            return 0.0, 0.0
        top = self.depth - self.magnet.gap
        return top - self.magnet.length, top


_Sensor = Annotated[
    tuple[
        Annotated[float, Field(ge=-1000.0, le=1000.0)],
        Annotated[float, Field(ge=-1000.0, le=1000.0)],
        Annotated[float, Field(gt=0.0, le=100.0)],
    ],
    _List,
]


class Magnetometer(Table):
    """Sensors of the magnetic field along x, y and z under the skin, which read the magnets in its pins."""

    below: float | None = quantity(
        "mm", "under the flat back, of one sensor under each magnet", gt=0.0, le=100.0, default=None
    )
    places: Annotated[tuple[_Sensor, ...], _List] | None = Field(
        default=None,
        description="in the place of below: x, y and how far under the flat back, of each sensor",
        min_length=1,
        max_length=1000,
        json_schema_extra={"unit": "mm"},
    )
    range: float = quantity(
        "mT",
        "largest field of each axis, either way: MLX90393 5 to 50 by its gain (data sheet rev. 3, 2017), "
        "TLV493D 130 (rev. 1.1, 2019), MMC5983MA 0.8",
        gt=0.0,
        le=1e4,
    )
    noise: float = quantity("uT", "rms of a sample at its rate, by its filter", ge=0.0, le=1e5)
    rate: float = quantity("Hz", "samples per second; the signals' band ends at half of it", gt=0.0, le=1e6)
    resolution: float = quantity("uT", "of a sample's last digit; TLV493D 98", ge=0.0, le=1e5, default=0.0)

    @property
    def rms(self) -> float:
        """Noise of a sample with its rounding, mT."""
        return math.hypot(self.noise, self.resolution / math.sqrt(12)) / 1000

    @model_validator(mode="after")
    def _placed(self) -> Self:
        if (self.below is None) == (self.places is None):
            words = "is missing" if self.below is None else "must not be given beside places"
            remedy = "give below, for a sensor under each magnet, or places"
            raise InputError("below", words, self.below, remedy)
        twice = next((place for place, times in Counter(self.places or ()).items() if times > 1), None)
        if twice:
            remedy = "move one of the two, or leave it out: together they tell no more than one"
            raise InputError("places", "must not hold a place twice", list(twice), remedy)
        return self


class Pin(Table):
    """Round pillars or bumps on normals of the base, alike but for their heights."""

    model_config = ConfigDict(json_schema_extra=ONE_HEIGHT)

    family: ClassVar[str] = "pin"
    widths: ClassVar[tuple[str, str]] = "root_diameter", "tip_diameter"

    pattern: Literal["square", "hex", "polar"] = Field(
        default="square",
        description="square or hex (columns along x, rows along y), or polar (a pin in the middle, and rings "
        "of 6, 12, 18, ... round it)",
    )
    pitch: float = quantity(
        "mm", "axis to axis along the base; of polar pins from ring to ring", gt=0.0, le=100.0
    )
    columns: int | None = quantity("1", "pins in a row along x", ge=1, le=1000, default=None)
    rows: int | None = quantity("1", "rows of pins along y", ge=1, le=1000, default=None)
    rings: int | None = quantity(
        "1", "rings round the middle pin, of a polar pattern", ge=0, le=25, default=None
    )
    margin: float | None = quantity(
        "mm",
        "in the place of a number of pins: as many as fit, each foot this far from the skin's edge",
        ge=0.0,
        le=500.0,
        default=None,
    )
    height: float | None = quantity(
        "mm", "base to the crown's summit, of every pin", gt=0.0, le=HIGHEST, default=None
    )
    heights: PinHeights | None = Field(
        default=None,
        description="the same of each pin in order, or of each ring of pins from inside out, "
        "in the place of height",
        json_schema_extra=EACH_HEIGHT,
    )
    levelling: float | None = quantity(
        "1",
        "by what part of its crest's drop below the highest a pin is higher than height: 0 alike, "
        "1 all crests level; 0 if not given",
        ge=0.0,
        le=1.0,
        default=None,
    )
    root_diameter: float = quantity("mm", "on the base, before the fillet", gt=0.0, le=100.0)
    tip_diameter: float = quantity("mm", "of the crown's edge", gt=0.0, le=100.0)
    crown: float = quantity(
        "mm", "rise of the spherical tip over its edge; half of tip_diameter is a hemisphere", ge=0.0, le=50.0
    )
    tip_fillet: float = quantity("mm", "radius between flank and crown", ge=0.0, le=20.0, default=0.0)
    root_fillet: float = quantity("mm", "radius between flank and base", ge=0.0, le=20.0, default=0.0)
    pocket: Pocket | None = None

    @property
    def spacing(self) -> float:
        """The pitch, mm."""
        return self.pitch

    @property
    def root_width(self) -> float:
        """Its diameter at the root, mm, as a ridge has a width."""
        return self.root_diameter

    @property
    def tip_width(self) -> float:
        """Its diameter at the tip, mm."""
        return self.tip_diameter

    @property
    def foot(self) -> float:
        """Radius of what a pin covers of the base, mm, about: its root with the fillet."""
        return self.root_diameter / 2 + self.root_fillet

    @model_validator(mode="after")
    def _counted(self) -> Self:
        wanted = ("rings",) if self.pattern == "polar" else ("columns", "rows")
        for key in ("columns", "rows", "rings"):
            value = getattr(self, key)
            if key not in wanted and value is not None:
                raise InputError(
                    key, f"must not be given for a {self.pattern} pattern", value, "leave it out"
                )
            if self.margin is not None and value is not None:
                raise InputError(key, "must not be given beside pin.margin", value, "leave one of them out")
            if key in wanted and value is None and self.margin is None:
                remedy = f"give pin.{key}, or pin.margin to fill the skin"
                raise InputError(key, "is missing", remedy=remedy)
        if 0.0 < self.crown < LOWEST_CROWN:
            rule = f"must be 0, or at least {LOWEST_CROWN:g} mm"
            raise InputError("crown", rule, self.crown, "take 0 for a flat tip")
        _check_heights(self, "pin")
        return self


class Flat(Table):
    """No features: the base alone touches, over pockets in a square pattern if it has any."""

    family: ClassVar[str] = "flat"
    widths: ClassVar[tuple[str, str]] = "", ""

    columns: int = quantity("1", "pockets along x", ge=1, le=50, default=1)
    rows: int = quantity("1", "pockets along y", ge=1, le=50, default=1)
    pitch: float | None = quantity(
        "mm", "from pocket to pocket; of one not needed", gt=0.0, le=500.0, default=None
    )
    pocket: Pocket | None = None

    @model_validator(mode="after")
    def _pitched(self) -> Self:
        if self.pitch is None and self.columns * self.rows > 1:
            remedy = "give flat.pitch a value; only one pocket needs none"
            raise InputError("pitch", "is missing", remedy=remedy)
        return self


Features = Ridge | Ring | Pin | Flat  # the table of a family
FAMILY_TABLES: dict[str, type[Table]] = {table.family: table for table in (Ridge, Pin, Ring, Flat)}


class Place(NamedTuple):
    """Where a feature stands: arcs u along x and v along y from the skin's middle, mm, and which `shell`
    round the middle it is of, 0 the innermost."""

    u: float
    v: float
    shell: int


def count_of(skin: Base, features: Features) -> int:
    """Return how many features there are: of a flat skin one, itself."""
    if isinstance(features, Pin):
        return len(places(skin, features))
    return 1 if isinstance(features, Flat) else features.count


@lru_cache(maxsize=32)
def places(skin: Base, features: Features) -> tuple[Place, ...]:
    """Return where features stand, in their order: ridges from the smallest x, rings from inside out, pins
    row by row from the smallest y, polar ones ring by ring. A flat skin's are its pockets.

    Raises InputError for more than `MOST_PINS` pins, or none that fits.
    """
    if isinstance(features, Ring):
        first, pitch = features.first_radius, features.spacing
        return tuple(Place(first + i * pitch, 0.0, i) for i in range(features.count))
    if isinstance(features, Ridge):
        middle = (features.count - 1) / 2
        return tuple(
            Place((i - middle) * features.spacing, 0.0, round(abs(i - middle) - middle % 1))
            for i in range(features.count)
        )
    if isinstance(features, Flat):
        return _square(features.columns, features.rows, features.pitch or 0.0)
    found = _pins(skin, features)
    if not 0 < len(found) <= MOST_PINS:
        counted = "rings" if features.pattern == "polar" else "columns"
        key = counted if features.margin is None else "margin"
        rule = f"must give from 1 to {MOST_PINS} pins, and gives {len(found)}"
        raise InputError(f"pin.{key}", rule, getattr(features, key), "change it, or pin.pitch")
    return found


def _pins(skin: Base, pin: Pin) -> tuple[Place, ...]:
    polar = pin.pattern == "polar"
    if pin.margin is None:
        count = pin.columns or 1, pin.rows or 1
        if polar:
            return _polar(pin.rings or 0, pin.pitch)
        return _square(*count, pin.pitch) if pin.pattern == "square" else _hexagonal(*count, pin.pitch)
    half_u, half_v = (half - pin.margin - pin.foot + _SAME for half in skin.half_arcs)
    if min(half_u, half_v) < 0:
        return ()
    step = pin.pitch * (_ROW if pin.pattern == "hex" else 1.0)
    across, along = math.floor(half_u / pin.pitch), math.floor(half_v / step)
    if across * along > MOST_PINS:  # about a quarter of what a square has: too many by far
        return (Place(0.0, 0.0, 0),) * (4 * across * along)
    if polar:
        return _polar(min(across, along), pin.pitch)
    if pin.pattern == "square":
        whole = _square(2 * across + 1, 2 * along + 1, pin.pitch)
    else:
        whole = _hexagonal(2 * across + 1 + along % 2, 2 * along + 1, pin.pitch)
    return tuple(at for at in whole if skin.arm(at.u, at.v) <= half_u)


_ROW = math.sqrt(3) / 2  # of the pitch, between two rows of a hexagonal pattern
_SAME = 1e-9  # of a length: as far as that


def _square(columns: int, rows: int, pitch: float) -> tuple[Place, ...]:
    return tuple(
        Place(u * pitch, v * pitch, math.floor(max(abs(u), abs(v))))
        for v in (j - (rows - 1) / 2 for j in range(rows))
        for u in (i - (columns - 1) / 2 for i in range(columns))
    )


def _hexagonal(columns: int, rows: int, pitch: float) -> tuple[Place, ...]:
    """Rows of `columns` pins, and between them rows of one less; the first row is a full one."""
    found = []
    for j in range(rows):
        v, short = (j - (rows - 1) / 2) * _ROW, j % 2
        for i in range(columns - short):
            u = i - (columns - short - 1) / 2
            away = abs(v / _ROW)  # rows; the steps from the middle follow from this and u
            found.append(Place(u * pitch, v * pitch, math.floor(max(away, abs(u) + away / 2) + _SAME)))
    return tuple(found)


def _polar(rings: int, pitch: float) -> tuple[Place, ...]:
    found = [Place(0.0, 0.0, 0)]
    for ring in range(1, rings + 1):
        angles = (2 * math.pi * i / (6 * ring) for i in range(6 * ring))
        found += [Place(ring * pitch * math.cos(a), ring * pitch * math.sin(a), ring) for a in angles]
    return tuple(found)


def lean(skin: Base, features: Features, number: int) -> float:
    """Return the angle in rad between a feature's axis and z in the section's plane; numbers from 1."""
    return places(skin, features)[number - 1].u / skin.curvature_radius


def _half_sine(angle: float) -> float:
    """The squared sine of half an angle in rad."""
    return math.sin(angle / 2) ** 2


@lru_cache(maxsize=32)
def heights(skin: Base, features: Features) -> tuple[float, ...]:
    """Return each feature's height in mm, base to summit, feature 1 first; 0 of a flat skin.

    Levelled ones are higher than `height` by a part of what brings their summit to the highest one's z. That
    is T + h - d with d = 2 (R + h) s + 2 q (Q + h - 2 (R + h) s), s and q the squared sines of half the
    angles along x and y and Q the second radius: linear in h, and written so that mirrored features are alike
    to the last digit and a flat skin loses none.
    """
    if isinstance(features, Flat):
        return (0.0,)
    where = places(skin, features)
    if features.heights is not None:
        given = features.heights
        return given if len(given) == len(where) else tuple(given[at.shell] for at in where)
    height = features.height or 0.0  # given where heights are not
    if not features.levelling:
        return (height,) * len(where)
    radius, along = skin.curvature_radius, skin.radius_y
    falls = [(_half_sine(skin.arm(at.u, at.v) / radius), _half_sine(at.v / along)) for at in where]
    if math.isinf(along):
        least = min(s for s, _ in falls)
        far = 2 * (radius + height) * features.levelling
        return tuple(height + far * (s - least) / (1 - 2 * s) for s, _ in falls)

    def drop(s: float, q: float) -> float:
        under = 2 * (radius + height) * s
        return under + 2 * q * (along + height - under)

    least = min(drop(*fall) for fall in falls)
    return tuple(
        height + features.levelling * (drop(s, q) - least) / ((1 - 2 * s) * (1 - 2 * q)) for s, q in falls
    )
