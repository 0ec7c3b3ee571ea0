"""What a process can make: a table of limits, the shipped ones' and a workshop's own.

The shipped tables are in templates/processes.toml: one more there is one more process, no rule asks for a
name. A user's `printer.toml` has tables of the same keys: one named as a shipped process changes what it
names of it, any other name is a new process `based_on` one.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from typing import Any, Literal

from pydantic import Field

from skincad.base.errors import InputError
from skincad.base.tables import SparseTable, quantity
from skincad.inputs.shipped import check_names, table_text

PROCESSES = tuple(tomllib.loads(table_text("processes")))


def _from_zero(unit: str, meaning: str, most: float) -> Any:
    """Describe a number of a process from 0 to `most`; 0 where it has none."""
    return quantity(unit, meaning, ge=0.0, le=most, default=0.0)


class Process(SparseTable):
    """Limits of a process; 0 where it has no such limit."""

    based_on: str | None = Field(
        default=None,
        description="the shipped process that a new one takes all other values from",
        json_schema_extra={"enum": [*PROCESSES, None]},
    )
    gap: float = _from_zero("mm", "narrowest groove or slit", 100.0)
    wall: float = _from_zero("mm", "thinnest tooth or wall", 100.0)
    hole: float = _from_zero("mm", "smallest diameter of a round hole", 100.0)
    clearance: float = _from_zero("mm", "least gap per side at which parts slide into each other", 10.0)
    tolerance: float = quantity("mm", "a surface comes out within ± this", gt=0.0, le=10.0, default=0.1)
    growth: float = quantity(
        "mm",
        "material comes out thicker by this a side, a notch narrower by twice that; below 0: thinner",
        ge=-0.2,
        le=0.2,
        default=0.0,
    )
    tool: Literal["none", "mill", "lathe", "wire", "screen"] = Field(
        default="none",
        description="what shapes: a mill or a lathe, which come from above, a wire, which is straight, "
        "a screen, whose pixels are whole, or none",
    )
    tool_radius: float = _from_zero("mm", "of a ball-end mill, a turning tool's nose or a wire", 100.0)
    spark_gap: float = _from_zero("mm", "between wire and work", 10.0)
    groove_ratio: float = _from_zero("1", "deepest groove by the tool's diameter", 1000.0)
    tooth_ratio: float = _from_zero("1", "height of a free tooth by its width", 1000.0)
    pixel: float = _from_zero("mm", "finest detail in a layer's plane", 10.0)
    layer: float = _from_zero("mm", "height of a layer", 10.0)
    coating: float = _from_zero(
        "mm", "of what seals its parts against platinum silicone, where they keep that from curing", 1.0
    )
    build_x: float = _from_zero("mm", "build volume of the machine, the longer side", 1e5)
    build_y: float = _from_zero("mm", "the shorter side", 1e5)
    build_z: float = _from_zero("mm", "and its height", 1e5)
    thread: Literal["tapped", "heat-set", "glued"] = Field(
        default="tapped",
        description="how its parts get an M3 thread: cut in, or by an insert that is melted or glued in",
    )
    part_modulus: float = quantity(
        "MPa", "Young's modulus of what its parts are made of", gt=0.0, le=1e6, default=2000.0
    )
    overhang: float = quantity(
        "deg", "steepest overhang without support, from the vertical", ge=0.0, le=90.0, default=90.0
    )
    bridge: float = _from_zero("mm", "widest horizontal hole that needs no support", 1000.0)
    orientation: Literal["flat", "end"] = Field(
        default="flat", description="how a cavity is printed: flat (ridges' grooves up) or on its y end"
    )
    inhibits_platinum: bool = Field(
        default=False, description="whether its parts may keep platinum silicone from curing"
    )
    chord: float = quantity(
        "mm", "how far a print mesh may leave the true surface", gt=0.0, le=10.0, default=0.01
    )
    roughness: float = _from_zero(
        "um", "Ra of faces as the process leaves them, which silicone copies", 1000.0
    )
    crest_sigma: float = quantity(
        "mm", "standard deviation of a cast ridge's crest height", ge=0.0, le=10.0, default=0.01
    )
    crest_offset: float = quantity(
        "mm",
        "all crests come out higher above the back by this; below 0: lower",
        ge=-1.0,
        le=1.0,
        default=0.0,
    )

    handling_s: float = quantity(
        "s",
        "to coat a film strip and to wipe the skin's ends, by hand; beside drawing it in",
        ge=0.0,
        le=3600.0,
        default=90.0,
    )
    material: str = Field(default="", description="what its parts are made of", max_length=60)
    density: float = quantity("g/cm3", "of filament, cured resin or stock", gt=0.0, le=30.0, default=1.0)
    price: float = _from_zero("EUR/kg", "of filament, resin or stock", 1e5)
    rate: float = _from_zero("EUR/h", "of the machine, with who runs it", 1e4)
    setup: float = _from_zero(
        "min", "to set up a plate of prints, or a part in a machine, and to finish it; in the cost alone", 1e4
    )
    waste: float = _from_zero("1", "material lost by the mass that is estimated; in the cost alone", 10.0)
    mass_error: float = quantity(
        "1", "share by which an estimated mass may be off", ge=0.0, le=1.0, default=0.1
    )
    time_error: float = quantity(
        "1", "share by which an estimated time may be off", ge=0.0, le=1.0, default=0.5
    )
    price_error: float = quantity(
        "1", "share by which price and rate may be off", ge=0.0, le=1.0, default=0.5
    )
    line: float = quantity("mm", "width of a line of filament", gt=0.0, le=10.0, default=0.45)
    loops: int = quantity("1", "lines of filament round each layer", ge=1, le=1000, default=3)
    shells: int = quantity(
        "1", "layers that are filled solid under a top and over a bottom", ge=0, le=1000, default=4
    )
    infill: float = quantity("1", "share of the rest that is filled", ge=0.0, le=1.0, default=1.0)
    outer_speed: float = quantity("mm/s", "of the outermost line", gt=0.0, le=1e4, default=25.0)
    loop_speed: float = quantity("mm/s", "of the other loops", gt=0.0, le=1e4, default=45.0)
    fill_speed: float = quantity("mm/s", "of what fills a layer", gt=0.0, le=1e4, default=80.0)
    first_speed: float = quantity("mm/s", "of all lines of the first layer", gt=0.0, le=1e4, default=20.0)
    travel_speed: float = quantity("mm/s", "from a line to the next", gt=0.0, le=1e4, default=180.0)
    acceleration: float = quantity("mm/s2", "of the nozzle", gt=0.0, le=1e6, default=1000.0)
    exposure: float = _from_zero("s", "of a layer of resin", 1e4)
    first_exposure: float = _from_zero("s", "of each of the first layers", 1e4)
    first_layers: int = quantity("1", "that are exposed so long", ge=0, le=1000, default=3)
    fading: int = quantity("1", "layers from that exposure to the usual one", ge=0, le=1000, default=10)
    lift: float = _from_zero("s", "from a layer's exposure to the next one's", 1e4)
    allowance: float = _from_zero("mm", "by which stock is larger than its part, on each side", 1000.0)
    removal_rate: float = _from_zero("mm3/min", "of roughing; 0: what is cut off comes off in one piece", 1e7)
    finish_rate: float = quantity("mm2/min", "of faces, all passes", gt=0.0, le=1e6, default=100.0)
    fine_rate: float = quantity(
        "mm2/min", "of the skin's negative and of notches, all passes", gt=0.0, le=1e6, default=10.0
    )
    hole_time: float = _from_zero("min", "of a hole, with its thread or fit", 1e4)

    @property
    def reach(self) -> float:
        """Radius of the smallest corner that the tool leaves, mm: the tool's and the spark gap."""
        return self.tool_radius + self.spark_gap


@cache
def _shipped() -> dict[str, Process]:
    rows = tomllib.loads(table_text("processes"))
    return {name: Process(**{**row, "based_on": name}) for name, row in rows.items()}


def processes(own: Mapping[str, Process] | None = None) -> dict[str, Process]:
    """Return what each process can make: the shipped ones, with a design's `[printer]` on top."""
    result, shipped = dict(_shipped()), _shipped()
    for name, change in (own or {}).items():
        base = shipped[change.based_on or name]
        values = {key: getattr(change, key) for key in change.model_fields_set}
        result[name] = base.model_copy(update={**values, "based_on": base.based_on})
    return result


def check_own(own: Mapping[str, Process]) -> None:
    """Raise InputError for a bad name, an own process without a base, or a shipped one with another's."""
    check_names("printer", own, "my-mill")
    for name, process in own.items():
        key = f"printer.{name}.based_on"
        if name not in PROCESSES and process.based_on is None:
            raise InputError(key, "is missing for a new process", remedy=f"name {', '.join(PROCESSES)}")
        check_named(key, process.based_on, {})
        if name in PROCESSES and process.based_on not in (None, name):
            raise InputError(key, f"must not be given for {name}", process.based_on, "give it another name")


def check_named(key: str, name: str | None, own: Mapping[str, Process]) -> None:
    """Raise InputError where `key` names a process that is neither shipped nor the workshop's own."""
    known = [*PROCESSES, *(n for n in own if n not in PROCESSES)]
    if name is not None and name not in known:
        listed = ", ".join(f"'{n}'" for n in known[:-1])
        raise InputError(key, f"must be {listed} or '{known[-1]}'", name)
