"""The tables of a design that say how it is cast and mounted."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from skincad.base.errors import InputError
from skincad.base.tables import Table, quantity
from skincad.inputs.process import PROCESSES
from skincad.inputs.shipped import NAME

_FARTHEST = 1000.0  # mm or deg
_Number = Annotated[float, Field(ge=-_FARTHEST, le=_FARTHEST)]
Place = Annotated[tuple[_Number, _Number, _Number], Field(strict=False)]


def _process(description: str, **default: Any) -> Any:
    """Describe a key that names a process: a shipped one, or one of [printer]."""
    known: dict[str, Any] = {"anyOf": [{"enum": list(PROCESSES)}, {"pattern": NAME}]}
    return Field(description=description, json_schema_extra=known, **default)


class Mold(Table):
    """The mold that casts the skin, ridges down."""

    process: str = _process(
        f"how cavity and end plates are made: {', '.join(PROCESSES)}, or one of [printer]"
    )
    mount: str | None = Field(
        default=None,
        description="the gripper whose holes the carrier gets, in the place of [mount]: "
        "skincad templates grippers lists them, or one of [grippers]",
        pattern=NAME,
    )
    end_plate_process: str | None = _process(
        "how the end plates are made, if not as the cavity", default=None
    )
    block_process: str | None = _process(
        "of a round skin: how the block is made, in whose seat the cavity then lies as a disc, "
        "to be turned or printed finer; block and cavity are one piece if not given",
        default=None,
    )
    lid_process: str | None = _process("how carrier and cover are made, if not as the cavity", default=None)
    wall: float | None = quantity(
        "mm",
        "block beside the skin; 13, or what two rows of bolts beside the trough need, if not given; "
        "up to a quarter more, for the block is a multiple of half a millimetre wide",
        ge=12.0,
        le=500.0,
        default=None,
    )
    floor: float | None = quantity(
        "mm",
        "block below the deepest ridge; if not given 9, or what bolts, nuts and pins need (and a split "
        "cavity's base), and what makes the block a multiple of half a "
        "millimetre high, or in a print of whole layers under the ledge",
        ge=9.0,
        le=200.0,
        default=None,
    )
    end_plate: float = quantity("mm", "thickness of an end plate along y", ge=1.0, le=50.0, default=4.0)
    cover: float | None = quantity(
        "mm",
        "thickness of the cover; 4, or what lets it bow by at most 0.02 under 10 kPa between its screws, "
        "rounded up to half a millimetre, if not given",
        ge=1.0,
        le=50.0,
        default=None,
    )
    clearance: float = quantity(
        "mm", "gap per side between parts that slide into each other", ge=0.0, le=1.0, default=0.05
    )
    slit_clearance: float = quantity(
        "mm",
        "gap per side between a shim or strip and its slit in the end plates",
        ge=0.0,
        le=0.5,
        default=0.005,
    )
    cavities: int = quantity("1", "skins side by side along x in one block", ge=1, le=12, default=1)
    split: Literal["none", "auto", "tips"] = Field(
        default="none",
        description="auto: the cavity is parted at the summits of ridges that are too undercut to be pulled, "
        "or at pins' tips where a tool makes their holes; tips: a plate of through holes on a base of cups",
    )
    shrinkage: float | None = quantity(
        "1",
        "linear, by which the cavity is larger than the skin; the silicone's if not given",
        ge=0.0,
        le=0.05,
        default=None,
    )
    method: Literal["shim", "cast-in"] = Field(
        default="shim",
        description="how the strips get in: after cure behind a shim that is drawn out along y, or cast in "
        "under tension, and the slot round the film fills with silicone",
    )
    fill_time: float = quantity(
        "s", "in which the silicone fills the mold; slow, for the strips' sake", gt=0.0, le=1e5, default=60.0
    )
    carrier: Literal["perforated", "plain"] | None = Field(
        default=None,
        description="rigid backing that stays on the skin: perforated for interlock, or plain to be primed; "
        "perforated, or plain where no hole fits, if not given",
    )
    carrier_thickness: float | None = quantity(
        "mm",
        "of the carrier; 4, or what gives the bolts room over a thin skin, rounded up to half a "
        "millimetre, if not given",
        ge=1.0,
        le=50.0,
        default=None,
    )
    pour: Literal["syringe", "open"] | None = Field(
        default=None,
        description="through the gate by syringe, or over the open back before the carrier is laid on; by "
        "syringe, or open where the skin is too thin for a gate of 0.7 mm, if not given",
    )
    pour_tilt: float = quantity(
        "deg", "end b up while the silicone rises under the carrier", ge=0.0, le=60.0, default=10.0
    )
    gate: float | None = quantity(
        "mm",
        "diameter of the pouring gate; if not given 2, or up to 4.2 so that a thumb fills the mold in time, "
        "or the largest tenth that leaves 0.3 of the skin's end round it",
        gt=0.2,
        le=20.0,
        default=None,
    )
    vent: float | None = quantity(
        "mm",
        "diameter of the vent; 1, over a skin of more than 5 cm3 2.5, or the largest tenth that fits on the "
        "skin's back, if not given",
        gt=0.2,
        le=10.0,
        default=None,
    )
    reservoir: float | None = quantity(
        "mm",
        "upper diameter of the cup over the vent; 5, or what covers the vent and holds 3 % of the skin's "
        "volume, if not given",
        gt=0.2,
        le=50.0,
        default=None,
    )
    bone: str | None = Field(
        default=None,
        description="a STEP file, mm, of what the skin is cast on, a finger's bone or a mount, in the place "
        "of the carrier, which then only holds it while silicone cures; its path counts from this file",
        min_length=1,
        max_length=4096,
    )
    bone_at: Place | None = quantity(
        "mm",
        "where the file's origin comes to be, (x, y, z) from the middle of the skin's back, z "
        "out of the skin; 0, 0, 0 if not given",
        default=None,
    )
    bone_turn: Place | None = quantity(
        "deg", "how it is turned about its origin, about x, then y, then z; not if not given", default=None
    )
    bone_bond: Literal["primer", "rivets"] | None = Field(
        default=None,
        description="how silicone holds on the bone: a primer, or rivets, holes of its own that fill and "
        "that no straight pull empties; primer if not given",
    )

    @model_validator(mode="after")
    def _own_bone(self) -> Self:
        for key in ("bone_at", "bone_turn", "bone_bond"):
            if self.bone is None and getattr(self, key) is not None:
                raise InputError(key, "needs mold.bone", getattr(self, key), "name the bone's STEP file")
        if self.bone is not None and self.carrier == "perforated":
            remedy = "leave it out: the carrier comes off a bone"
            raise InputError("carrier", "must be 'plain' with a bone", self.carrier, remedy)
        return self


_OF_PATTERN = {
    "circle": ("diameter", "count", "angle"),
    "rectangle": ("pitch_x", "pitch_y"),
}
LEAST_FIDUCIALS = 3  # two look the same once the carrier is turned by half a turn


class HolePattern(Table):
    """Screws and a pin in a pattern about the middle, x across the ridges and y along them."""

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
    count: int | None = quantity("1", "screws on the circle; 4 if not given", ge=2, le=12, default=None)
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


class Mount(HolePattern):
    """Screws and fiducials on the carrier's top, x and y from its middle as the mold has them."""

    fiducials: int = quantity(
        "1",
        "round dimples for a camera, 3 or 4, so placed that a carrier that is turned is known "
        "from one that is not; 0 for none",
        ge=0,
        le=4,
        default=0,
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
