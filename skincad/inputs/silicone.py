"""What a silicone is: a table of values, the shipped ones' and a lab's own.

The shipped tables are in templates/silicones.toml. A lab's own file has tables of the same keys: one named as
a shipped silicone changes what it names of it, any other name is a new silicone, with a modulus of its own or
`based_on` a shipped one.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetPydanticSchema,
    SerializeAsAny,
    model_validator,
)

from skincad.base.errors import InputError, did_you_mean
from skincad.base.tables import NumberWithRange, SparseTable, quantity
from skincad.inputs.shipped import check_names, table_text
from skincad.laws import LAWS, law, law_of
from skincad.laws.rubber import Rubber

SOFTEST, STIFFEST = 1e-3, 100.0  # MPa; assumption: the softest gels, and rubbers harder than any Shore A
TYPICAL = 0.3  # MPa; assumption: the middle of the shipped silicones, to guess at a modulus in another unit
# of a modulus and its law's; assumption: what rounding constants to two digits leaves
MODULUS_AGREEMENT = 0.01
_UNITS = {"Pa": 1e-6, "kPa": 1e-3, "GPa": 1e3}


def _in_mpa(modulus: NumberWithRange) -> NumberWithRange:
    """Raise InputError for a modulus that no silicone has, with the unit in which one may have it."""
    for value in (modulus.value, modulus.low, modulus.high):
        if not SOFTEST <= value <= STIFFEST:
            unit, factor = min(
                _UNITS.items(), key=lambda row: abs(math.log(value) + math.log(row[1] / TYPICAL))
            )
            guess, within = value * factor, SOFTEST <= value * factor <= STIFFEST
            rule = f"must be from {SOFTEST:g} to {STIFFEST:g} MPa"
            question = f"is it in MPa? {value:g} {unit} is {guess:g} MPa" if within else "is it in MPa?"
            raise InputError("", rule, value, question)
    return modulus


Modulus = Annotated[NumberWithRange, AfterValidator(_in_mpa)]
LIGHTEST = 100.0  # kg/m3; assumption: foams have more


def _in_kg_per_m3(density: float) -> float:
    """Raise InputError for a density that no silicone has, with that which it is in g/cm3."""
    if density < LIGHTEST:
        remedy = f"{density:g} g/cm3 are {1000 * density:g} kg/m3"
        raise InputError("", f"must be at least {LIGHTEST:g} kg/m3", density, remedy)
    return density


Density = Annotated[float, AfterValidator(_in_kg_per_m3)]


def _law(table: Any) -> Any:
    """The law of a table; whatever is no table is left to be refused."""
    return law_of(table) if isinstance(table, dict) else table


def _kinds(*_: object) -> dict[str, Any]:
    """What an editor may offer in a law's table: one object a kind, each imported when that is asked."""
    return {"oneOf": [law(kind).model_json_schema() for kind in LAWS]}


_SCHEMA = GetPydanticSchema(get_pydantic_json_schema=_kinds)
Law = Annotated[SerializeAsAny[Rubber], BeforeValidator(_law), _SCHEMA]


class StiffnessSource(SparseTable):
    """What one source says of a silicone's stiffness: a modulus at small strain, or a law."""

    what: str = Field(description="what was measured, or how it follows", max_length=200)
    where: str = Field(description="the paper, data base or data sheet", max_length=200)
    young_modulus: float | None = quantity("MPa", "small strain", ge=SOFTEST, le=STIFFEST, default=None)
    law: Law | None = Field(default=None, description="its kind and constants")

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.young_modulus is None) == (self.law is None):
            raise InputError("", "needs a young_modulus or a law, and not both", remedy="give one of them")
        return self

    def modulus(self, poisson_ratio: float) -> float:
        """Return Young's modulus at small strain, MPa."""
        return self.law.young_modulus(poisson_ratio) if self.law else self.young_modulus or 0.0


class Silicone(SparseTable):
    """A casting silicone at room temperature.

    Defaults are assumptions, for one of which only the modulus is known: nearly incompressible, the density
    that casting silicones share, the least of their elongations, the largest of their viscosities.
    """

    name: str = Field(
        default="", description="as the casting sheet calls it; the table's name if not given", max_length=64
    )
    based_on: str | None = Field(
        default=None, description="the shipped silicone that a new one takes all other values from"
    )
    young_modulus: Modulus = quantity(
        "MPa",
        "small strain; a number, or {value, low, high}",
        default=NumberWithRange(value=1.0, low=1.0, high=1.0),
    )
    law: Law | None = Field(
        default=None, description="at large strain: its kind and constants; neo-Hooke's if not given"
    )
    poisson_ratio: float = quantity("1", "nearly incompressible", ge=0.0, le=0.4999999, default=0.499)
    density: Density = quantity("kg/m3", "of the cured silicone", gt=0.0, le=20000.0, default=1070.0)
    mix: list[Annotated[float, Field(gt=0.0, le=1000.0)]] | None = Field(
        default=None,
        description="parts A and B by mass; by its data sheet if not given",
        min_length=2,
        max_length=2,
    )
    pot_life_min: float | None = quantity(
        "min", "in which it can be poured; by its data sheet if not given", gt=0.0, le=1e4, default=None
    )
    cure_h: float | None = quantity(
        "h", "until it can be demolded; by its data sheet if not given", gt=0.0, le=1e4, default=None
    )
    cure_c: float | None = quantity(
        "C", "at which it cures so long; room temperature if not given", ge=0.0, le=300.0, default=None
    )
    platinum_cure: bool = Field(
        default=True, description="whether it is platinum-cured, which some resins prevent"
    )
    elongation_at_break: float = quantity("1", "a strain: 3.64 is 364 %", gt=0.0, le=50.0, default=1.0)
    viscosity: float = quantity("Pa s", "freshly mixed; 1000 cps is 1 Pa s", gt=0.0, le=1e4, default=35.0)
    shrinkage: float = quantity(  # source: data sheets, about 0.1 % of a silicone cured at room temperature
        "1", "linear, from mold to cured part", ge=0.0, le=0.05, default=0.001
    )
    source: str = Field(default="assumption", description="where the values are from", max_length=300)
    sources: Annotated[tuple[StiffnessSource, ...], Field(strict=False)] = Field(
        default=(), description="what each source says of its stiffness, all within young_modulus"
    )


@cache
def _shipped() -> dict[str, Silicone]:
    rows = tomllib.loads(table_text("silicones"))
    return {name: Silicone(**{"name": name, **row}) for name, row in rows.items()}


def silicones(own: Mapping[str, Silicone] | None = None) -> dict[str, Silicone]:
    """Return the silicones by name: the shipped ones, with a design's `[silicones]` on top."""
    result, shipped = dict(_shipped()), _shipped()
    for name, change in (own or {}).items():
        base = shipped.get(change.based_on or name, Silicone())
        values = {key: getattr(change, key) for key in change.model_fields_set}
        result[name] = with_values(base, {"name": name, **values, "based_on": None})
    return result


def silicone_of(name: str | None, values: Mapping[str, Any], own: Mapping[str, Silicone] | None) -> Silicone:
    """Return the silicone of this name, or one without, with some values `given` on top."""
    return with_values(silicones(own)[name] if name else Silicone(name="own silicone"), values)


def with_values(silicone: Silicone, values: Mapping[str, Any]) -> Silicone:
    """Return a silicone with some values changed; the modulus follows a law that comes without one."""
    result = silicone.model_copy(update=dict(values))
    if values.get("law") is None or "young_modulus" in values:
        return result
    modulus = values["law"].young_modulus(result.poisson_ratio)
    return result.model_copy(
        update={"young_modulus": NumberWithRange(value=modulus, low=modulus, high=modulus)}
    )


def check_law(key: str, silicone: Silicone) -> None:
    """Raise InputError for a silicone whose law has another modulus at small strain than stands beside it."""
    if silicone.law is None:
        return
    modulus, stated = silicone.law.young_modulus(silicone.poisson_ratio), silicone.young_modulus
    if not SOFTEST <= modulus <= STIFFEST:
        rule = f"must have a modulus at small strain from {SOFTEST:g} to {STIFFEST:g} MPa"
        raise InputError(f"{key}.law", rule, modulus, "are its constants in MPa?")
    if abs(stated.value / modulus - 1) > MODULUS_AGREEMENT:
        rule = (
            f"must be within {MODULUS_AGREEMENT:.0%} of the {modulus:.4g} MPa that {key}.law has at "
            "small strain"
        )
        remedy = "drop it, for it follows from the law, or fit the law again"
        raise InputError(f"{key}.young_modulus", rule, stated.value, remedy)


def check_own_silicones(own: Mapping[str, Silicone]) -> None:
    """Raise InputError for an own silicone without a modulus, or based on none that ships."""
    check_names("silicones", own, "my-silicone")
    shipped = _shipped()
    for name, row in own.items():
        key = f"silicones.{name}"
        if row.based_on is not None and row.based_on not in shipped:
            remedy = did_you_mean(row.based_on, shipped)
            raise InputError(f"{key}.based_on", "unknown silicone", row.based_on, remedy)
        if name in shipped and row.based_on not in (None, name):
            rule = f"must not be given for {name}, which ships"
            raise InputError(f"{key}.based_on", rule, row.based_on, "give it another name")
        stiff = row.model_fields_set & {"young_modulus", "law"}
        if name not in shipped and row.based_on is None and not stiff:
            rule, remedy = "is missing for a new silicone", "give it, or say based_on = ..."
            raise InputError(f"{key}.young_modulus", rule, remedy=remedy)

        if "law" in row.model_fields_set:
            check_law(key, silicones(own)[name])


def check_silicone(name: str | None, own: Mapping[str, Silicone]) -> None:
    """Raise InputError for a material's name that is neither shipped nor the design's own."""
    known = {*_shipped(), *own}
    if name is not None and name not in known:
        raise InputError("material.name", "unknown silicone", name, did_you_mean(name, known))
