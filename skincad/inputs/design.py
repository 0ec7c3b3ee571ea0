"""What a person writes: the frozen design model, with unit, range and meaning of every field.

The frame and each length are defined in docs/geometry.md: x across the ridges, y along them,
z out of the skin, flat back at z = 0.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from skincad.base.errors import InputError
from skincad.base.tables import Ranged, Table, parse, quantity
from skincad.inputs.guards import check_design
from skincad.inputs.process import NAME, PROCESSES, Process

_A_PROCESS: dict[str, Any] = {"anyOf": [{"enum": list(PROCESSES)}, {"pattern": NAME}]}
MOLDABLE_WALL = 0.04  # mm, assumption: a thinner silicone membrane tears when the shim is drawn


class Skin(Table):
    """The body of the pad."""

    curvature_radius: float = quantity(
        "mm", "radius of the base circle, on which the ridges stand", ge=1.0, le=1e8
    )
    thickness: float = quantity(
        "mm", "flat back to base circle in the middle, without the ridge", ge=0.2, le=100.0
    )
    width: float = quantity("mm", "across the back, what callipers read along x", ge=0.5, le=1000.0)
    length: float = quantity("mm", "along the ridges (y)", ge=0.5, le=1000.0)
    curvature_radius_y: float | None = quantity(
        "mm",
        "second curvature: the whole section, its back too, turns about an axis along x, this far below the "
        "base circle's summit, and length is the summit's arc; straight along y if not given",
        ge=1.0,
        le=1e8,
        default=None,
    )


class Ridge(Table):
    """The ridges, all alike, each on its own normal of the base circle."""

    count: int = Field(description="number of ridges", ge=1, le=999, json_schema_extra={"unit": "1"})
    pitch: float = quantity("mm", "axis to axis along the base circle", gt=0.0, le=100.0)
    height: float = quantity("mm", "base circle to the crown's summit", gt=0.0, le=50.0)
    root_width: float = quantity("mm", "flank to flank on the base circle, before fillets", gt=0.0, le=100.0)
    tip_width: float = quantity("mm", "chord of the crown, before fillets", gt=0.0, le=100.0)
    crown: float = quantity("mm", "rise of the tip's arc in its middle above its edges", ge=0.0, le=10.0)
    tip_fillet: float = quantity("mm", "radius between flank and crown", ge=0.0, le=20.0, default=0.0)
    root_fillet: float = quantity("mm", "radius between flank and base circle", ge=0.0, le=20.0, default=0.0)


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
    d31: float = quantity("pC/N", "charge by stress along the draw axis", ge=-1e4, le=1e4, default=23.0)
    d32: float = quantity(
        "pC/N", "charge by stress across the draw axis, in the film's plane", ge=-1e4, le=1e4, default=3.0
    )
    d33: float = quantity("pC/N", "charge by stress through the film", ge=-1e4, le=1e4, default=-33.0)
    electrode_margin: float = quantity(
        "mm",
        "bare film between electrode and cut edge, so that no cut shorts it",
        ge=0.0,
        le=5.0,
        default=0.02,
    )
    lead: float = quantity(
        "mm", "what a strip stands out on the wiring side, to be contacted", ge=1.0, le=200.0, default=8.0
    )
    wiring_side: Literal["a", "b"] = Field(
        default="b", description="the mold's end at which the leads come out; the gate is at end a"
    )
    tension: float | None = quantity(
        "N",
        "pull on each strip while it is cast in; a twentieth of the film's yield stress if not given",
        gt=0.0,
        le=1000.0,
        default=None,
    )


class Material(Table):
    """The silicone: a name of the catalog, own values, or a name with some values of one's own."""

    name: str | None = Field(default=None, description="a silicone of the catalog", max_length=64)
    young_modulus: Ranged | None = Field(
        default=None,
        description="small strain; a number, or {value, low, high}",
        json_schema_extra={"unit": "MPa"},
    )
    poisson_ratio: float | None = quantity(
        "1", "nearly incompressible; the catalog's if not given", ge=0.0, le=0.4999999, default=None
    )
    density: float | None = quantity("kg/m3", "of the cured silicone", gt=0.0, le=20000.0, default=None)

    @model_validator(mode="after")
    def _has_stiffness(self) -> Self:
        if self.name is None and self.young_modulus is None:
            raise InputError("", "needs a name or a young_modulus", remedy='try name = "dragon-skin-30"')
        return self


class Mold(Table):
    """The mold that casts the skin, ridges down."""

    process: str = Field(
        description="how cavity and end plates are made: fdm, sla, cnc, edm, or one of [printer]",
        json_schema_extra=_A_PROCESS,
    )
    end_plate_process: str | None = Field(
        default=None,
        description="how the end plates are made, if not as the cavity",
        json_schema_extra=_A_PROCESS,
    )
    lid_process: str | None = Field(
        default=None,
        description="how carrier and cover are made; any plain plate if not given",
        json_schema_extra=_A_PROCESS,
    )
    wall: float | None = quantity(
        "mm",
        "block beside the skin; 13, or what two rows of bolts beside the trough need, to the next half "
        "millimetre, if not given",
        ge=12.0,
        le=500.0,
        default=None,
    )
    floor: float | None = quantity(
        "mm",
        "block below the deepest ridge; 9, or what bolts, nuts and pins need (and a split cavity's base), "
        "to the next half millimetre, if not given",
        ge=9.0,
        le=200.0,
        default=None,
    )
    end_plate: float = quantity("mm", "thickness of an end plate along y", ge=1.0, le=50.0, default=4.0)
    cover: float = quantity("mm", "thickness of the cover", ge=1.0, le=50.0, default=4.0)
    clearance: float = quantity(
        "mm", "gap a side between parts that slide into each other", ge=0.0, le=1.0, default=0.05
    )
    slit_clearance: float = quantity(
        "mm",
        "gap a side between a shim or strip and its slit in the end plates",
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
        "perforated, or plain where no hole finds room, if not given",
    )
    carrier_thickness: float | None = quantity(
        "mm",
        "of the carrier; 4, or what leaves the bolts over a thin skin room, to the next half millimetre, if "
        "not given",
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
        "diameter of the vent; 1, or the largest tenth that finds room on the skin's back, if not given",
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
    """What the verdict is asked for."""

    force: float = quantity("N", "normal force at which all ridges shall touch", gt=0.0, le=1e6, default=4.0)
    film: Literal["bonded", "loose", "ignored"] | None = Field(
        default=None,
        description="bonded (strip and adhesive fill the slot), loose (slot is a void), "
        "ignored (slot is filled with silicone); bonded if there is a film, loose if there is none",
    )
    plate: Plate = Plate()


class Design(Table):
    """Everything that a skin, its mold and its verdict follow from.

    Lengths are mm, forces N, stresses MPa. Raises InputError for the rules that are broken.
    """

    name: Annotated[
        str,
        Field(
            pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$",
            description="letters, digits, - and _, up to 64; it names the out folder",
        ),
    ]
    skin: Skin
    ridge: Ridge
    slot: Slot | None = None
    film: Film | None = None
    material: Material
    mold: Mold = Mold(process="sla")
    contact: Contact = Contact()
    printer: dict[str, Process] | None = Field(
        default=None, description="a workshop's own processes, [printer.sla] as in a printer.toml"
    )

    @model_validator(mode="after")
    def _rules(self) -> Self:
        check_design(self)
        return self

    def __hash__(self) -> int:
        """Hash of all but `printer`, a dict, which equality still compares."""
        return hash(tuple(value for key, value in self if key != "printer"))

    @property
    def film_state(self) -> Literal["bonded", "loose", "ignored"]:
        """How the slots are filled in the mechanical model; `loose` when nothing is said."""
        return self.contact.film or ("bonded" if self.film else "loose")

    @property
    def core_thickness(self) -> float:
        """Thickness of what keeps silicone out of a slot, mm: a shim's or the film's own; 0 without slots."""
        if self.slot is None:
            return 0.0
        cast_in = self.mold.method == "cast-in" and self.film
        return cast_in.thickness if cast_in else self.slot.thickness

    def lean(self, ridge: int) -> float:
        """Return the angle in rad between ridge's axis and z; ridges count from 1 at the smallest x."""
        offset = ridge - (self.ridge.count + 1) / 2
        return offset * self.ridge.pitch / self.skin.curvature_radius

    def with_(self, **tables: Any) -> Design:
        """Return a copy with some keys of some tables changed, checked anew.

        `design.with_(ridge={"height": 0.6}, slot=None)`; a dict changes the keys that it names, None
        drops an optional table, and with a slot the film in it.
        """
        data = self.model_dump(exclude_none=True)
        for table, change in tables.items():
            if isinstance(change, dict):
                data[table] = {**data.get(table, {}), **change}
                if table == "material" and change.get("name") is not None:
                    renamed_material(data, set(change))
            elif change is None:
                data.pop(table, None)
                drop_dependents(data, table)
            else:
                data[table] = change
        return parse(Design, data)


def renamed_material(data: dict[str, Any], changed: set[str]) -> None:
    """Give, in place, another silicone its own values: those of the old one that nobody set anew go."""
    if "name" in changed and isinstance(data.get("material"), dict):
        own = {"young_modulus", "poisson_ratio", "density"} - changed
        data["material"] = {key: value for key, value in data["material"].items() if key not in own}


def drop_dependents(data: dict[str, Any], dropped: str) -> None:
    """Drop, in place, what cannot be without a dropped table: the film with its slot, `bonded` with it."""
    if dropped == "slot":
        data.pop("film", None)
    contact = data.get("contact")
    if dropped in ("slot", "film") and isinstance(contact, dict) and contact.get("film") == "bonded":
        data["contact"] = {key: value for key, value in contact.items() if key != "film"}
