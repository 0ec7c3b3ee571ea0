"""What a carrier is screwed to and what grips with it: a table of grippers, shipped ones and a lab's own.

The shipped tables are in templates/grippers.toml. A lab's own file has tables of the same keys: one named
as a shipped gripper changes what it names of it, any other name is a new one.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache

from pydantic import Field

from skincad.base.errors import InputError, did_you_mean
from skincad.base.tables import SparseTable, quantity
from skincad.inputs.mold_table import HolePattern, Mount
from skincad.inputs.shipped import check_names, table_text


class Gripper(HolePattern, SparseTable):
    """A finger's face, mm, its holes, and how it grips."""

    width: float = quantity("mm", "of the finger's face, across the ridges", gt=0.0, le=1000.0, default=30.0)
    length: float = quantity("mm", "of the finger's face, along the ridges", gt=0.0, le=1000.0, default=30.0)
    stroke: float | None = quantity(
        "mm", "of the opening between two fingers, without pads", gt=0.0, le=1000.0, default=None
    )
    force_min: float | None = quantity("N", "least force of a finger", gt=0.0, le=1e6, default=None)
    force_max: float | None = quantity("N", "largest force of a finger", gt=0.0, le=1e6, default=None)
    force_rate: float | None = quantity(
        "N/s", "how fast a finger's force changes", gt=0.0, le=1e6, default=None
    )
    delay: float | None = quantity(
        "s", "from what is felt to a change of the finger's force", ge=1e-3, le=10.0, default=None
    )
    measured: bool = Field(
        default=True, description="whether the holes are somebody's measurement; false: an assumption"
    )
    source: str = Field(default="", description="where the numbers are from", max_length=400)

    def mount(self) -> Mount:
        """Return the carrier's holes for it. Raises InputError for a pattern that is none."""
        keys = HolePattern.model_fields
        return Mount(**{key: getattr(self, key) for key in keys if getattr(self, key) is not None})


@cache
def _shipped() -> dict[str, Gripper]:
    return {name: Gripper(**row) for name, row in tomllib.loads(table_text("grippers")).items()}


def grippers(own: Mapping[str, Gripper] | None = None) -> dict[str, Gripper]:
    """Return all grippers that are known: the shipped ones, with a design's `[grippers]` on top."""
    known = dict(_shipped())
    for name, change in (own or {}).items():
        values = {key: getattr(change, key) for key in change.model_fields_set}
        known[name] = known[name].model_copy(update=values) if name in known else change
    return known


def check_grippers(own: Mapping[str, Gripper]) -> None:
    """Raise InputError for a bad name, or a gripper whose holes are no pattern."""
    check_names("grippers", own, "my-finger")
    for name in own:
        try:
            grippers(own)[name].mount()
        except InputError as broken:
            raise broken.under(f"grippers.{name}") from None


def gripper_named(name: str, own: Mapping[str, Gripper]) -> Gripper:
    """Return a gripper; raises InputError for one that nobody knows."""
    known = grippers(own)
    if name not in known:
        raise InputError("mold.mount", "no such gripper", name, did_you_mean(name, known))
    return known[name]
