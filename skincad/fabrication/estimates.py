"""Mass, time and cost of each part and process of a mold, as estimates with their errors.

Prints are estimated by their layers, what is cut from stock by its faces. Errors and prices are the
process's own; a part's errors are those of its process, and so add up.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from skincad.base.estimate import Estimate
from skincad.fabrication.filament import MachineEffort, filament
from skincad.fabrication.machining import machining
from skincad.fabrication.plates import BedPart, plates
from skincad.fabrication.resin import exposure_time
from skincad.fabrication.rules import maker
from skincad.inputs.design import Design
from skincad.inputs.process import Process, processes
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import Part, PartRole

if TYPE_CHECKING:
    import trimesh

HOUR, MINUTES = 3600.0, 60.0  # s and min of an hour
RESIN = "layers by exposure and lift; no supports"
FILAMENT = "lines of the layers by speed and acceleration; no supports"
MILLED = "stock's mass; its removal, faces and holes by assumed rates"
WIRED = "stock's mass; cut faces and holes by assumed rates"


class PartEstimate(NamedTuple):
    """What a part takes, made alone; of the cost, its share of a plate's time and setup."""

    name: str
    process: str
    mass: Estimate  # g, of the print, or of the stock
    time: Estimate  # h, of the machine
    cost: Estimate  # EUR
    basis: str

    def as_json(self) -> dict[str, Any]:
        """Return what `parts[]` of make.json says of it."""
        return {
            "mass_g": self.mass.as_json(),
            "time_h": self.time.as_json(),
            "cost_EUR": self.cost.as_json(),
            "basis": self.basis,
        }


class ProcessEstimate(NamedTuple):
    """What all parts of a mold take that one process makes; `plates` is 0 where there are none."""

    process: str
    parts: tuple[PartEstimate, ...]
    plates: int
    mass: Estimate
    time: Estimate  # h: of a plate of resin, its tallest part's
    cost: Estimate

    def as_json(self) -> dict[str, Any]:
        """Return it under the contract's keys."""
        return {
            "process": self.process,
            "parts": [{"name": part.name, **part.as_json()} for part in self.parts],
            "plates": self.plates,
            "mass_g": self.mass.as_json(),
            "time_h": self.time.as_json(),
            "cost_EUR": self.cost.as_json(),
        }


def estimates(
    design: Design, closed: ClosedMold, prints: Mapping[str, trimesh.Trimesh]
) -> tuple[ProcessEstimate, ...]:
    """Return what each process takes for a mold's parts, in the parts' order; `prints` are the meshes of what
    is made as they lie on the bed, mm, by part name."""
    parts_by_process: dict[str, list[Part]] = {}
    for part in closed.parts:
        if part.made == "made":
            parts_by_process.setdefault(maker(design, part), []).append(part)
    known = processes(design.printer)
    return tuple(_of_process(name, known[name], parts, prints) for name, parts in parts_by_process.items())


def by_part(process_estimates: tuple[ProcessEstimate, ...]) -> dict[str, PartEstimate]:
    """Return the estimates of all parts by name."""
    return {part.name: part for estimate in process_estimates for part in estimate.parts}


def lines(design: Design, process_estimates: tuple[ProcessEstimate, ...]) -> list[str]:
    """Return what each process takes as sentences."""
    return [_line(estimate, processes(design.printer)[estimate.process]) for estimate in process_estimates]


def _line(estimate: ProcessEstimate, process: Process) -> str:
    count = f"{len(estimate.parts)} part" + "s" * (len(estimate.parts) != 1)
    on = f" on {estimate.plates} plate" + "s" * (estimate.plates != 1) if estimate.plates else ""
    what = f"{estimate.mass.span()} of {'material' if estimate.plates else 'stock'}"
    prices = f"{process.price:g} EUR/kg and {process.rate:g} EUR/h"
    return (
        f"By {estimate.process}, {count}{on}: {what}, {estimate.time.span()}, {estimate.cost.span()} "
        f"at {prices}."
    )


def _of_process(
    name: str, process: Process, parts: list[Part], prints: Mapping[str, trimesh.Trimesh]
) -> ProcessEstimate:
    shapes = {part.name: prints[part.name] for part in parts}
    took = {part.name: _effort(part, shapes[part.name], process) for part in parts}
    if process.layer > 0:
        lying = [BedPart(n, *map(float, shape.extents)) for n, shape in shapes.items()]
        groups = [[part.name for part in plate] for plate in plates(lying, process)]
    else:
        groups = [[part.name] for part in parts]
    together = max if process.exposure > 0 else math.fsum
    cost: dict[str, Estimate] = {}
    hours = 0.0
    for group in groups:
        alone = {n: took[n].seconds / HOUR for n in group}
        long, total = float(together(alone.values())), math.fsum(alone.values())
        hours += long
        for n in group:
            share = alone[n] / total * long if total else 0.0
            grams = took[n].volume * process.density / 1000
            cost[n] = _cost(grams, share, process.setup / MINUTES / len(group), process)
    basis = _basis(process)
    part_estimates = tuple(
        PartEstimate(n, name, _mass(took[n], process), _time(took[n].seconds / HOUR, process), cost[n], basis)
        for n in took
    )
    mass, price = _sum([part.mass for part in part_estimates]), _sum([part.cost for part in part_estimates])
    return ProcessEstimate(
        name, part_estimates, len(groups) if process.layer else 0, mass, _time(hours, process), price
    )


def _effort(part: Part, shape: trimesh.Trimesh, process: Process) -> MachineEffort:
    if not process.layer:
        return machining(part, process)
    if process.exposure > 0:
        return MachineEffort(part.volume, exposure_time(float(shape.extents[2]), process))
    return filament(shape, process, notched=part.role is PartRole.COMB)


def _basis(process: Process) -> str:
    if process.layer:
        return RESIN if process.exposure > 0 else FILAMENT
    return MILLED if process.removal_rate > 0 else WIRED


def _mass(effort: MachineEffort, process: Process) -> Estimate:
    grams = effort.volume * process.density / 1000
    return Estimate(grams, grams * process.mass_error, "g")


def _time(hours: float, process: Process) -> Estimate:
    return Estimate(hours, hours * process.time_error, "h")


def _cost(grams: float, hours: float, setup: float, process: Process) -> Estimate:
    """Material with its waste, and the machine with its setup, h; errors of amount and price add up."""
    material = grams / 1000 * (1 + process.waste) * process.price
    machine, ready = hours * process.rate, setup * process.rate
    off = material * (process.mass_error + process.price_error)
    off += machine * (process.time_error + process.price_error) + ready * process.price_error
    return Estimate(material + machine + ready, off, "EUR")


def _sum(parts: list[Estimate]) -> Estimate:
    """A sum whose parts are off the same way."""
    values, errors = [float(part) for part in parts], [part.error or 0.0 for part in parts]
    return Estimate(math.fsum(values), math.fsum(errors), parts[0].unit)
