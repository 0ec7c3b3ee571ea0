"""PVDF film that can be bought: a table of makers' products, each with its source and the source's date.

The table is templates/films.toml. It is no list of what is in stock, and what was not checked says so.
"""

from __future__ import annotations

import tomllib
from functools import cache
from typing import Annotated, Literal

from pydantic import Field

from skincad.base.tables import Table, quantity
from skincad.inputs.shipped import table_text

Gauge = Annotated[float, Field(gt=0.0, le=5.0)]


class FilmProduct(Table):
    """A maker's line of products: film of some gauges, its electrodes, and what it is laminated to."""

    maker: str = Field(description="who makes it")
    product: str = Field(description="what it is called there")
    gauges: list[Gauge] = Field(
        default=[],
        description="mm of PVDF, as it is sold; none where no source was found",
        json_schema_extra={"unit": "mm"},
    )
    coat: float = quantity(
        "mm", "that electrodes and what covers them add, both faces together", ge=0.0, le=1.0, default=0.0
    )
    laminate: float = quantity(
        "mm", "of polyester that the film is laminated to", ge=0.0, le=5.0, default=0.0
    )
    electrode: Literal["sputtered", "printed"] | None = Field(
        default=None, description="sputtered, which is etched or cut by a laser, or printed; None: not known"
    )
    metal: str = Field(default="", description="of the electrode")
    form: Literal["sheet", "sensor"] = Field(
        default="sheet", description="a sheet to be cut, or a sensor whose outline and leads are given"
    )
    size: str = Field(default="", description="of a sheet or sensor")
    cut: str = Field(default="", description="how it is cut")
    source: str = Field(default="", description="what the figures are from")
    date: str = Field(default="", description="of the source, as 2001-05-15; none where it has none")
    unchecked: str = Field(default="", description="what is as commonly listed, and was not checked")

    @property
    def provenance(self) -> str:
        """The source with its date, and what was not checked, as words."""
        known = f"{self.source} ({self.date or 'no date'})" if self.source else ""
        rest = f"as commonly listed, not checked: {self.unchecked}" if self.unchecked else ""
        return "; ".join(filter(None, (known, rest)))


@cache
def film_products() -> dict[str, FilmProduct]:
    """Return the products by their names in the table."""
    return {name: FilmProduct(**row) for name, row in tomllib.loads(table_text("films")).items()}
