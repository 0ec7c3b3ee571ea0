"""What a person writes of a skin: the frozen design, its tables with unit, range and meaning of every key."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, Self, TypeVar

from pydantic import ConfigDict, Field, model_validator

from skincad.base.errors import InputError, together
from skincad.base.faces import imported
from skincad.base.tables import Document, Table, unit_of
from skincad.inputs import guards
from skincad.inputs.feature_tables import (
    FAMILY_TABLES,
    Features,
    Flat,
    Magnetometer,
    Pin,
    Ridge,
    Ring,
    count_of,
    heights,
    lean,
)
from skincad.inputs.gripper import Gripper, gripper_named
from skincad.inputs.mold_table import Mold, Mount
from skincad.inputs.process import Process
from skincad.inputs.silicone import Silicone
from skincad.inputs.skin_tables import (
    OF_A_SILICONE,
    Base,
    Contact,
    Film,
    Material,
    Shots,
    Slot,
)

_Table = TypeVar("_Table", bound=Table)


class Design(Document):
    """Everything that a skin, its mold and its verdict follow from.

    Lengths are mm, forces N, stresses MPa. Raises InputError for the rules that are broken.
    """

    model_config = ConfigDict(json_schema_extra={"oneOf": [{"required": [key]} for key in FAMILY_TABLES]})

    skin: Base
    ridge: Ridge | None = None
    pin: Pin | None = None
    ring: Ring | None = None
    flat: Flat | None = None
    slot: Slot | None = None
    film: Film | None = None
    material: Material
    shot: Shots | None = Field(
        default=None,
        description="layers of other silicones behind the skin's own, from the back, [[shot]] each",
    )
    mold: Mold = Mold(process="sla")
    mount: Mount | None = None
    contact: Contact = Contact()
    magnetometer: Magnetometer | None = None
    printer: dict[str, Process] | None = Field(
        default=None, description="a workshop's own processes, [printer.sla] as in a printer.toml"
    )
    silicones: dict[str, Silicone] | None = Field(
        default=None, description="a lab's own silicones, [silicones.lab-10] as in a lab.toml"
    )
    grippers: dict[str, Gripper] | None = Field(
        default=None, description="a lab's own grippers, [grippers.my-finger] as in a grippers.toml"
    )

    @model_validator(mode="before")
    @classmethod
    def _one_family(cls, data: Any) -> Any:
        named = [key for key in FAMILY_TABLES if isinstance(data, dict) and data.get(key) is not None]
        if len(named) > 1:
            tables = " and ".join(f"[{key}]" for key in named)
            words = f"are two families of features; a skin has one: {tables}"
            raise InputError(named[-1], words, remedy="drop one of the two tables")
        return data

    @model_validator(mode="after")
    def _rules(self) -> Self:
        if all(getattr(self, key) is None for key in FAMILY_TABLES):
            remedy = "give ridge a value, or [pin], [ring] or [flat] one"
            raise InputError("ridge", "is missing", remedy=remedy)
        skin, slot, film, mold = self.skin, self.slot, self.film, self.mold
        checks = (
            guards.processes(mold, self.printer or {}),
            guards.silicones(self.material, self.silicones or {}),
            guards.grippers(mold, self.mount, self.grippers or {}),
            guards.features_on_skin(skin, self.features),
            guards.revolved(skin),
            guards.family(skin, self.features, slot),
            guards.profile(self.features),
            guards.strips(skin, slot, film, mold),
            guards.bond(self.contact, film),
            guards.shots(skin, self.shot or (), self.silicones or {}),
            guards.magnets(skin, self.features, self.magnetometer),
        )
        if broken := [error for check in checks for error in check]:
            raise together(broken)
        return self

    def _repr_html_(self) -> str:
        """The section with its sizes, for a notebook."""
        drawn: str = imported("skincad.outputs.drawing.flat:section_html")(self)
        return drawn

    def __hash__(self) -> int:
        """Hash of all but `printer`, `silicones` and `grippers`, dicts, which equality still compares."""
        return hash(tuple(value for _, value in self if not isinstance(value, dict)))

    @property
    def mounting(self) -> Mount | None:
        """The carrier's holes: [mount], or those of the gripper that the mold names."""
        if self.mold.mount is None:
            return self.mount
        return gripper_named(self.mold.mount, self.grippers or {}).mount()

    @property
    def features(self) -> Features:
        """The table of the family of features that stand on the skin."""
        table: Features = getattr(self, next(key for key in FAMILY_TABLES if getattr(self, key) is not None))
        return table

    def of(self, family: type[_Table]) -> _Table:
        """Return the table of its features where they are of this family; ValueError elsewhere."""
        if not isinstance(self.features, family):
            raise ValueError(f"{self.name} has no {family.__name__}s")
        return self.features

    @property
    def count(self) -> int:
        """How many features there are; a flat skin counts as one."""
        return count_of(self.skin, self.features)

    @property
    def on_magnets(self) -> bool:
        """Whether its pins stand on magnets on their axes, over a back that is flat: their pockets are full
        then, and what is in them is known."""
        pocket = None if self.pin is None else self.pin.pocket
        known = pocket is not None and pocket.magnet is not None and not pocket.offset
        return known and math.isinf(self.skin.radius_y)

    @property
    def spacing(self) -> float:
        """The pitch of the features, mm; of a flat skin a length of its size."""
        table = self.features
        return math.sqrt(self.skin.width * self.skin.length) if isinstance(table, Flat) else table.spacing

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

    def lean(self, number: int) -> float:
        """Return the angle in rad between a feature's axis and z in the section's plane, numbers from 1."""
        return lean(self.skin, self.features, number)

    @property
    def heights(self) -> tuple[float, ...]:
        """Height of each feature, base to summit, mm, feature 1 first."""
        return heights(self.skin, self.features)

    @property
    def uneven(self) -> bool:
        """Whether ridges differ in height."""
        return len({*self.heights}) > 1

    @staticmethod
    def _follow(data: dict[str, Any], key: str, change: Any) -> None:
        if change is None:
            drop_dependents(data, key)
        if key == "material" and isinstance(change, dict) and change.get("name") is not None:
            renamed_material(data, set(change))
        if key == "skin" and isinstance(change, dict):
            drop_length(data["skin"], set(change))
        if key in FAMILY_TABLES and isinstance(change, dict):
            drop_replaced(data, key, {name for name, value in change.items() if value is not None})


def renamed_material(data: dict[str, Any], changed: set[str]) -> None:
    """Drop, in place, the old silicone's values that were not set again, where another silicone is named."""
    if "name" in changed and isinstance(data.get("material"), dict):
        dropped = {*OF_A_SILICONE} - changed
        data["material"] = {key: value for key, value in data["material"].items() if key not in dropped}


def drop_length(skin: dict[str, Any], changed: set[str]) -> None:
    """Drop, in place, the length of a round skin whose width was set again: it follows."""
    if skin.get("outline") == "round" and "width" in changed and "length" not in changed:
        skin.pop("length", None)


def drop_dependents(data: dict[str, Any], dropped: str) -> None:
    """Drop, in place, what cannot be without a dropped table: the film with its slot, `bonded` with it."""
    if dropped == "slot":
        data.pop("film", None)
    contact = data.get("contact")
    if dropped in ("slot", "film") and isinstance(contact, dict) and contact.get("film") == "bonded":
        data["contact"] = {key: value for key, value in contact.items() if key != "film"}


_REPLACED_KEYS = {
    "height": ("heights",),
    "heights": ("height", "levelling"),
    "margin": ("columns", "rows", "rings"),
    **dict.fromkeys(("columns", "rows", "rings"), ("margin",)),
}


def drop_replaced(data: dict[str, Any], family: str, changed: set[str]) -> None:
    """Drop, in place, the keys of a family's table that newly set keys replace: one height for all, or one a
    feature; a number of pins, or a margin.

    Keys that are set together stay, and are refused.
    """
    replaced = {old for new in changed for old in _REPLACED_KEYS.get(new, ())} - changed
    if replaced and isinstance(data.get(family), dict):
        data[family] = {key: value for key, value in data[family].items() if key not in replaced}


def scaled_skin(design: Design, by: float) -> Design:
    """Return the design with every length of its skin and features, and its slots' place, times a factor.

    Slots and films keep their sizes, pockets their diameter: what keeps them free is bought. It may pass a
    key's limit by that factor, so it isn't checked.
    """
    slot = design.slot and _scaled(design.slot, by, ("offset", "elevation"))
    features = {design.features.family: _scaled(design.features, by)}
    if (table := features[design.features.family]).pocket is not None:
        pocket = _scaled(table.pocket, by, ("depth", "offset"))
        features = {table.family: table.model_copy(update={"pocket": pocket})}
    shots = design.shot and tuple(_scaled(shot, by) for shot in design.shot)
    tables = {"skin": _scaled(design.skin, by), **features, "slot": slot, "shot": shots}
    return design.model_copy(update=tables)


def with_heights(design: Design, heights: Sequence[float]) -> Design:
    """Return the design with a height for each ridge, mm, which isn't checked."""
    alone = {"heights": tuple(heights), "height": None, "levelling": None}
    table = design.features
    return design.model_copy(update={table.family: table.model_copy(update=alone)})


def height_keys(design: Design) -> list[str]:
    """Return the family's keys that give all features their height, none where each has its own."""
    return [key for key in ("height", "levelling") if getattr(design.features, key, None) is not None]


def _scaled(table: _Table, by: float, keys: tuple[str, ...] = ()) -> _Table:
    """Return a table with its lengths (or those of `keys`) times a factor; what is not given stays so."""
    model = type(table)
    old = {key: getattr(table, key) for key in keys or model.model_fields if unit_of(model, (key,)) == "mm"}
    larger = {
        key: tuple(size * by for size in value) if isinstance(value, tuple) else value * by
        for key, value in old.items()
        if value is not None
    }
    return table.model_copy(update=larger)
