"""The tables of a design that say what is cast and pressed: skin, slots, films, silicone, plate.

The frame and each length are defined in docs/understand/geometry.md: x across the ridges, y along them,
z out of the skin, flat back at z = 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, ConfigDict, Field, model_validator

from skincad.base.errors import InputError
from skincad.base.tables import Table, quantity
from skincad.inputs.silicone import Density, Law, Modulus


def _a_length(schema: dict[str, Any]) -> None:
    """A round skin needs no length, in the JSON schema."""
    schema["required"].remove("length")
    a_round = {"properties": {"outline": {"const": "round"}}, "required": ["outline"]}
    schema["anyOf"] = [{"required": ["length"]}, a_round]


RADIUS_Y = "skin.curvature_radius_y"


class Base(Table):
    """The body of the pad."""

    model_config = ConfigDict(json_schema_extra=_a_length)

    curvature_radius: float = quantity(
        "mm", "radius of the base circle, on which the ridges stand", ge=1.0, le=1e8
    )
    thickness: float = quantity(
        "mm", "flat back to base circle in the middle, without the ridge", ge=0.2, le=100.0
    )
    width: float = quantity("mm", "across the back, what callipers read along x", ge=0.5, le=1000.0)
    length: float = quantity(
        "mm", "along the ridges (y); of a round skin its diameter, as width, if not given", ge=0.5, le=1000.0
    )
    outline: Literal["rectangle", "round"] | None = Field(
        default=None,
        description="round: the section turns about its middle, and the skin is a disc of diameter width; "
        "rectangle if not given",
    )
    curvature_radius_y: float | None = quantity(
        "mm",
        "second curvature: the whole section, its back too, turns about an axis along x, this far below the "
        "base circle's summit, and length is the summit's arc; straight along y if not given",
        ge=1.0,
        le=1e8,
        default=None,
    )

    @model_validator(mode="before")
    @classmethod
    def _disc(cls, data: Any) -> Any:
        """The length of a round skin that is given its width alone."""
        if isinstance(data, dict) and data.get("outline") == "round" and "width" in data:
            return {"length": data["width"], **data}
        return data

    @property
    def round(self) -> bool:
        """Whether it is a disc, a solid of revolution about z."""
        return self.outline == "round"

    @property
    def radius_y(self) -> float:
        """The second curvature's radius, mm; infinite where the skin is straight along y."""
        return math.inf if self.curvature_radius_y is None else self.curvature_radius_y

    @property
    def area(self) -> float:
        """Area of its outline, mm2."""
        return self.width * self.length * (math.pi / 4 if self.round else 1)

    def arm(self, x: float, y: float) -> float:
        """Return how far from its middle the base has curved at a place, or at arcs, mm: a round one curves
        all round. The second curvature does not count."""
        return math.hypot(x, y) if self.round else abs(x)

    @property
    def half_arcs(self) -> tuple[float, float]:
        """The arcs from its middle to its edges along x and y, mm."""
        half = self.curvature_radius * math.asin(min(1.0, self.width / (2 * self.curvature_radius)))
        return half, half if self.round else self.length / 2

    def refused_radius_y(self, rule: str, remedy: str = "leave it out") -> Iterator[InputError]:
        """Yield the refusal of a second curvature, where there is one."""
        if math.isfinite(self.radius_y):
            yield InputError(RADIUS_Y, rule, self.radius_y, remedy)

    @property
    def back_radius(self) -> float:
        """Radius of the back's arc along y, mm; infinite where it is straight."""
        return self.radius_y - self.thickness

    @property
    def across(self) -> str:
        """Its width and length, or its diameter, mm, as words."""
        return f"Ø{self.width:g}" if self.round else f"{self.width:g} x {self.length:g}"


class Slot(Table):
    """A mirrored pair of straight slots for the film strips in every ridge."""

    thickness: float = quantity("mm", "across the slot", ge=0.005, le=5.0)
    depth: float = quantity("mm", "along the slot, in the section", ge=0.01, le=50.0)
    offset: float = quantity("mm", "ridge axis to slot centre", gt=0.0, le=50.0)
    elevation: float = quantity("mm", "slot centre above the base circle", ge=-50.0, le=50.0)
    tilt: float = quantity("deg", "from the ridge axis, positive when tops lean inward", ge=-80.0, le=80.0)


class Film(Table):
    """The PVDF strip in the middle of each slot."""

    thickness: float = quantity("mm", "of the strip", ge=0.004, le=5.0)
    young_modulus: float = quantity("MPa", "of the film; PVDF 2000 to 4000", ge=1.0, le=1e6, default=3000.0)
    poisson_ratio: float = quantity("1", "of the film", ge=0.0, le=0.49, default=0.35)
    d31: float = quantity("pC/N", "charge per stress along the draw axis", ge=-1e4, le=1e4, default=23.0)
    d32: float = quantity(
        "pC/N", "charge per stress across the draw axis, in the film's plane", ge=-1e4, le=1e4, default=3.0
    )
    d33: float = quantity("pC/N", "charge per stress through the film", ge=-1e4, le=1e4, default=-33.0)
    cut_tolerance: float = quantity(
        "mm",
        "a strip's cut edge lies within ± this; a laser with a camera 0.02 (assumption), a knife plotter 0.1",
        ge=0.0,
        le=0.5,
        default=0.02,
    )
    registration: float = quantity(
        "mm",
        "the electrode of either face lies within ± this of its place; 0.02 where cutter and pattern go by "
        "the same marks (assumption)",
        ge=0.0,
        le=0.5,
        default=0.02,
    )
    electrode_margin: float | None = quantity(
        "mm",
        "bare film between the electrodes and a cut edge, so that no cut shorts them; cut_tolerance and "
        "registration together if not given",
        ge=0.0,
        le=5.0,
        default=None,
    )
    lead: float | None = quantity(
        "mm",
        "straight lead on the wiring side, from the skin (cast in: from its end plate) to the tab with the "
        "contact pads; 8, or what the tabs of all strips need to spread to a board, if not given",
        ge=1.0,
        le=200.0,
        default=None,
    )
    wiring_side: Literal["a", "b"] = Field(
        default="b",
        description="the mold's end of leads, at which strips are drawn in; the gate is at end a",
    )
    tension: float | None = quantity(
        "N",
        "pull on each strip while it is cast in; a twentieth of the film's yield stress if not given",
        gt=0.0,
        le=1000.0,
        default=None,
    )

    @property
    def margin(self) -> float:
        """Bare film at a cut edge, mm: what is given, or what the cutter and the registration may be off."""
        chosen = self.electrode_margin
        return self.cut_tolerance + self.registration if chosen is None else chosen


OF_A_SILICONE = ("young_modulus", "poisson_ratio", "density", "law")


class Material(Table):
    """The silicone: one by name, own values, or a name with some values of one's own."""

    name: str | None = Field(
        default=None, description="a silicone that ships, or one of [silicones]", max_length=64
    )
    young_modulus: Modulus | None = quantity(
        "MPa", "small strain; a number, or {value, low, high}", default=None
    )
    poisson_ratio: float | None = quantity(
        "1", "nearly incompressible; the named silicone's if not given", ge=0.0, le=0.4999999, default=None
    )
    density: Density | None = quantity("kg/m3", "of the cured silicone", gt=0.0, le=20000.0, default=None)
    law: Law | None = Field(
        default=None,
        description="at large strain: its kind and constants (docs/howto/silicone.md)",
    )

    @property
    def given(self) -> dict[str, object]:
        """What is said of the silicone itself, its name apart."""
        values = {key: getattr(self, key) for key in OF_A_SILICONE}
        return {key: value for key, value in values.items() if value is not None}

    @model_validator(mode="after")
    def _has_stiffness(self) -> Self:
        if self.name is None and self.young_modulus is None and self.law is None:
            raise InputError(
                "", "needs a name, a young_modulus or a law", remedy='try name = "dragon-skin-30"'
            )
        return self


class Shot(Material):
    """A layer behind the skin's own silicone, from the back or from the shot before up to its own face."""

    thickness: float | None = quantity(
        "mm", "of a flat face: so high above the back in all", ge=0.05, le=100.0, default=None
    )
    depth: float | None = quantity(
        "mm", "of a face that follows the base circle: so far below it", ge=0.05, le=100.0, default=None
    )
    bond: Literal["primer", "rivets", "wet"] | None = Field(
        default=None,
        description="to the layer in front of it: primer, on its clean face within a day of its cure; "
        "rivets, which this silicone fills behind necks; or wet, poured on it within its pot life; primer if "
        "not given",
    )

    @model_validator(mode="after")
    def _one_face(self) -> Self:
        if (self.thickness is None) == (self.depth is None):
            raise InputError("", "needs either a thickness or a depth", remedy="give one of the two")
        if self.bond == "wet" and self.thickness is None:
            rule = "must not be 'wet' where the face follows the base circle: what is still liquid lies level"
            raise InputError("bond", rule, self.bond, "give a thickness, or 'primer'")
        return self


def _some(shots: tuple[Shot, ...]) -> tuple[Shot, ...]:
    if not shots:
        raise InputError("", "must have at least 1 item", remedy="leave it out")
    return shots


Shots = Annotated[tuple[Shot, ...], Field(strict=False, max_length=8), AfterValidator(_some)]


class Plate(Table):
    """The rigid plate that the skin is pressed on; it keeps its angle."""

    shape: Literal["flat", "tilted", "cylinder", "step"] = Field(
        default="flat", description="flat, tilted (by tilt), cylinder (of radius) or step (of height)"
    )
    tilt: float | None = quantity(
        "deg", "of a tilted plate, positive when it rises towards +x", ge=-5.0, le=5.0, default=None
    )
    radius: float | None = quantity("mm", "of a cylinder along y", ge=1.0, le=1e8, default=None)
    height: float | None = quantity("mm", "by which a step is higher at +x", ge=0.0, le=50.0, default=None)
    position: float = quantity(
        "mm", "x of a cylinder's lowest line or of a step", ge=-1e4, le=1e4, default=0.0
    )

    @model_validator(mode="after")
    def _own_key(self) -> Self:
        keys = {"tilted": "tilt", "cylinder": "radius", "step": "height"}
        for shape, key in keys.items():
            if shape == self.shape and getattr(self, key) is None:
                raise InputError(key, f"is missing for a plate of shape '{shape}'", remedy=f"give {key}")
            if shape != self.shape and getattr(self, key) is not None:
                raise InputError("shape", f"must be '{shape}' where {key} is given", self.shape)
        return self


class Contact(Table):
    """What the verdict is about."""

    force: float = quantity("N", "normal force at which all ridges must touch", gt=0.0, le=1e6, default=4.0)
    film: Literal["bonded", "loose", "ignored"] | None = Field(
        default=None,
        description="bonded (strip and adhesive fill the slot), loose (slot is a void), "
        "ignored (slot is filled with silicone); bonded if there is a film, loose if there is none",
    )
    friction: float | None = quantity(
        "1",
        "coefficient of friction between skin and plate while it is pressed; if not given it is unknown, and "
        "what it may change is part of the verdict's error",
        ge=0.0,
        le=20.0,
        default=None,
    )
    plate: Plate = Plate()
