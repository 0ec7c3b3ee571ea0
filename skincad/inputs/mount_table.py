"""The table of a design that says how its carrier is screwed to a robot and seen by a camera."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from skincad.base.errors import InputError
from skincad.base.tables import Table, quantity

_OF_PATTERN = {
    "circle": ("diameter", "count", "angle"),
    "rectangle": ("pitch_x", "pitch_y"),
}
LEAST_FIDUCIALS = 3  # two look the same once the carrier is turned by half a turn


class Mount(Table):
    """Screws and fiducials on the carrier's top, x and y from its middle as the mold has them."""

    thread: Literal["M2", "M2.5", "M3", "M4"] | None = Field(
        default=None,
        description="of the screws, blind from the robot's side: tapped, or by an insert where "
        "lid_process asks for one; no screws if not given",
    )
    pattern: Literal["circle", "rectangle"] = Field(
        default="circle",
        description="circle (of diameter, with count and angle, as in ISO 9409-1), or rectangle (pitch_x "
        "and pitch_y; two screws in line where only one of them is given)",
    )
    diameter: float | None = quantity("mm", "of the bolt circle", gt=0.0, le=1000.0, default=None)
    count: int | None = Field(
        default=None,
        description="screws on the circle; 4 if not given",
        ge=2,
        le=12,
        json_schema_extra={"unit": "1"},
    )
    angle: float | None = quantity(
        "deg",
        "of the circle's first screw, from +x towards +y; half of the angle between two if not given",
        ge=-360.0,
        le=360.0,
        default=None,
    )
    pitch_x: float | None = quantity("mm", "between a rectangle's screws, x", gt=0.0, le=1000.0, default=None)
    pitch_y: float | None = quantity("mm", "and along y", gt=0.0, le=1000.0, default=None)
    pin: float | None = quantity(
        "mm",
        "diameter of a dowel pin's hole, on the bolt circle at +x, in the middle of a rectangle's side "
        "there, or between two screws in line; none if not given",
        ge=1.0,
        le=3.0,
        default=None,
    )
    fiducials: int = Field(
        default=0,
        description="round dimples for a camera, 3 or 4, so placed that a carrier that is turned is known "
        "from one that is not; 0 for none",
        ge=0,
        le=4,
        json_schema_extra={"unit": "1"},
    )
    fiducial_diameter: float = quantity("mm", "of a dimple", ge=0.3, le=10.0, default=1.0)
    fiducial_depth: float = quantity("mm", "of a dimple", ge=0.1, le=2.0, default=0.5)

    @model_validator(mode="after")
    def _own_keys(self) -> Self:
        if 0 < self.fiducials < LEAST_FIDUCIALS:
            rule = "must be 0, 3 or 4: fewer look the same from a carrier that is turned"
            raise InputError("fiducials", rule, self.fiducials)
        if self.thread is None:
            for key in (*_OF_PATTERN["circle"], *_OF_PATTERN["rectangle"], "pin"):
                if getattr(self, key) is not None:
                    raise InputError("thread", f"is missing where {key} is given", remedy='try thread = "M3"')
            if not self.fiducials:
                remedy = 'try thread = "M3" and a diameter, or fiducials = 3'
                raise InputError("", "needs a thread or fiducials", remedy=remedy)
            return self
        for pattern, keys in _OF_PATTERN.items():
            sizes = [key for key in keys if getattr(self, key) is not None]
            if sizes and pattern != self.pattern:
                raise InputError("pattern", f"must be '{pattern}' where {sizes[0]} is given", self.pattern)
        if self.pattern == "circle" and self.diameter is None:
            raise InputError("diameter", "is missing for a circle of screws", remedy="give mount.diameter")
        if self.pattern == "rectangle" and self.pitch_x is None and self.pitch_y is None:
            raise InputError("pitch_x", "is missing for a rectangle of screws", remedy="give mount.pitch_x")
        return self
