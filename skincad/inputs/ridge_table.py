"""The table of a design that says what its ridges are; their heights and leans."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from skincad.base.errors import InputError
from skincad.base.tables import Table, quantity
from skincad.inputs.skin_tables import Base

HIGHEST = 50.0  # mm, of a ridge


def _each_ridge(entries: Any) -> Any:
    """Check a list of heights, so that what is wrong with one names its ridge and not its place."""
    if isinstance(entries, list | tuple):
        for number, value in enumerate(entries, 1):
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value <= HIGHEST:
                raise InputError("", f"ridge {number} must be above 0 and at most {HIGHEST:g} mm high", value)
    return entries


Heights = Annotated[tuple[float, ...], Field(strict=False), BeforeValidator(_each_ridge)]


class Ridge(Table):
    """The ridges, alike but for their heights, each on its own normal of the base circle."""

    model_config = ConfigDict(
        json_schema_extra={
            "oneOf": [{"required": ["height"]}, {"required": ["heights"]}],
            "anyOf": [{"required": ["pitch"]}, {"properties": {"count": {"const": 1}}}],
        }
    )

    count: int = Field(description="number of ridges", ge=1, le=999, json_schema_extra={"unit": "1"})
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
        json_schema_extra={
            "unit": "mm",
            "items": {"type": "number", "exclusiveMinimum": 0, "maximum": HIGHEST},
        },
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
            raise InputError(
                "pitch", "is missing", remedy="give ridge.pitch a value; only one ridge needs none"
            )
        return self

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if self.heights is None:
            if self.height is None:
                raise InputError(
                    "height", "is missing", remedy="give ridge.height a value, or ridge.heights one a ridge"
                )
            return self
        for key in ("height", "levelling"):
            if (beside := getattr(self, key)) is not None:
                raise InputError(
                    key, "must not be given beside ridge.heights", beside, "leave one of them out"
                )
        if len(self.heights) != self.count:
            rule = f"must be {self.count} values, one a ridge (ridge.count)"
            raise InputError("heights", rule, len(self.heights), "give as many, or ridge.height for all")
        return self


def lean(skin: Base, ridge: Ridge, number: int) -> float:
    """Return the angle in rad between a ridge's axis and z; ridges count from 1 at the smallest x."""
    return (number - (ridge.count + 1) / 2) * ridge.spacing / skin.curvature_radius


@lru_cache(maxsize=32)
def heights(skin: Base, ridge: Ridge) -> tuple[float, ...]:
    """Return each ridge's height in mm, base circle to summit, ridge 1 first.

    Levelled ones are higher than `height` by a part of what brings their summit to the highest one's z:
    T - 2 R s + h (1 - 2 s) with s = sin^2(lean / 2), written so that mirrored ridges are alike to the last
    digit and a flat skin loses none.
    """
    if ridge.heights is not None:
        return ridge.heights
    height = ridge.height or 0.0  # given where heights are not
    if not ridge.levelling:
        return (height,) * ridge.count
    fall = [math.sin(lean(skin, ridge, i) / 2) ** 2 for i in range(1, ridge.count + 1)]
    far = 2 * (skin.curvature_radius + height) * ridge.levelling
    return tuple(height + far * (s - min(fall)) / (1 - 2 * s) for s in fall)
