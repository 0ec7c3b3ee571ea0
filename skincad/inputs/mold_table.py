"""The table of a design that says how its mold is made and filled."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from skincad.base.tables import Table, quantity
from skincad.inputs.process import PROCESSES
from skincad.inputs.shipped import NAME

_A_PROCESS: dict[str, Any] = {"anyOf": [{"enum": list(PROCESSES)}, {"pattern": NAME}]}


class Mold(Table):
    """The mold that casts the skin, ridges down."""

    process: str = Field(
        description=f"how cavity and end plates are made: {', '.join(PROCESSES)}, or one of [printer]",
        json_schema_extra=_A_PROCESS,
    )
    end_plate_process: str | None = Field(
        default=None,
        description="how the end plates are made, if not as the cavity",
        json_schema_extra=_A_PROCESS,
    )
    lid_process: str | None = Field(
        default=None,
        description="how carrier and cover are made, if not as the cavity",
        json_schema_extra=_A_PROCESS,
    )
    wall: float | None = quantity(
        "mm",
        "block beside the skin; 13, or what two rows of bolts beside the trough need, rounded up to half a "
        "millimetre, if not given",
        ge=12.0,
        le=500.0,
        default=None,
    )
    floor: float | None = quantity(
        "mm",
        "block below the deepest ridge; 9, or what bolts, nuts and pins need (and a split cavity's base), "
        "rounded up to half a millimetre, if not given",
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
    cavities: int = Field(
        default=1,
        description="skins side by side along x in one block",
        ge=1,
        le=12,
        json_schema_extra={"unit": "1"},
    )
    split: Literal["none", "auto"] = Field(
        default="none",
        description="auto: the cavity is parted at the summits of ridges that are too undercut to be pulled",
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
        "diameter of the pouring gate; 2, or the largest tenth that leaves 0.3 of the skin's end round it, "
        "if not given",
        gt=0.2,
        le=20.0,
        default=None,
    )
    vent: float | None = quantity(
        "mm",
        "diameter of the vent; 1, or the largest tenth that fits on the skin's back, if not given",
        gt=0.2,
        le=10.0,
        default=None,
    )
    reservoir: float | None = quantity(
        "mm",
        "upper diameter of the cup over the vent; 5, or what covers the vent, if not given",
        gt=0.2,
        le=50.0,
        default=None,
    )
