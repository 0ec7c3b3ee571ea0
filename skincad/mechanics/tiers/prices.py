"""What a tier is expected to cost on a design: laws of time against unknowns, and this machine's speed.

The laws were fitted to the templates (`skincad accuracy`, ladder contact) on one core of an AMD EPYC at rest;
a check scales them by what its linear tier took against its law. Range: within a factor of 1.5 on the
templates, 2 too low where a solid has to climb to its second rung.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from skincad.inputs.design import Design
from skincad.mechanics.tiers.table import below


@dataclass(frozen=True)
class TimeLaw:
    """`seconds` at `unknowns`, and its exponent; s of one core of the machine it was measured on."""

    unknowns: float
    seconds: float
    exponent: float

    def at(self, unknowns: float) -> float:
        """Return the expected time, s."""
        return float(self.seconds * (unknowns / self.unknowns) ** self.exponent)


# each tier's own part, without what it builds on
LAWS = {
    "winkler": TimeLaw(1.0, 4e-4, 0.0),
    "linear": TimeLaw(19_400, 0.66, 1.1),
    "corrected": TimeLaw(8_700, 0.29, 1.3),
    "finite-strain": TimeLaw(19_400, 3.4, 1.38),
    "corrected-finite-strain": TimeLaw(1.0, 1e-3, 0.0),
    "solid": TimeLaw(75_000, 8.0, 1.65),
    "solid-finite-strain": TimeLaw(8_700, 0.9, 1.6),
}

# by ridges, not unknowns: 0.17 s with 3, 0.4 to 0.7 with 9, 1.0 to 1.3 with 20, 4.9 with 40; within a factor
# of 1.6, and 2.6 too low on fingertip-soft
YIELD = TimeLaw(9, 0.47, 1.3)


def expected(name: str, design: Design, done: set[str]) -> float:
    """Return the seconds that a tier takes on top of those in `done`, on the machine of the laws."""
    return math.fsum(own(each, design) for each in {*below(name), name} - done)


def own(name: str, design: Design) -> float:
    """Return the seconds of a tier's own part, on the machine of the laws."""
    return LAWS[name].at(_unknowns(name, design))


def _unknowns(name: str, design: Design) -> float:
    if name in ("linear", "finite-strain"):
        return plane_unknowns(design)
    if name in ("corrected", "solid-finite-strain"):
        return _solid_unknowns(design, 2)
    return _solid_unknowns(design, 3) if name == "solid" else 1.0


def of_yield(design: Design) -> float:
    """Return the seconds of a verdict's yield, on the machine of the laws."""
    return YIELD.at(design.ridge.count)


def plane_unknowns(design: Design) -> float:
    """Return about how many unknowns the plane has, order 3: within 30 % on the templates."""
    slots = design.slot is not None and design.film_state != "ignored"
    return 3000 + design.ridge.count * (3000 if slots else 1900)


def _solid_unknowns(design: Design, order: int) -> float:
    """Unknowns of the coarse solid at an order in the section, by its mesh: a few hundredths of its price."""
    from skincad.mechanics.bodies import elements, layers
    from skincad.mechanics.problem import pad_of
    from skincad.mechanics.tiers.corrected import LAYERS, plain_pad
    from skincad.mechanics.tiers.solid_level import coarse_sizes, meshed_piece

    pad = plain_pad(design) if order == 2 else pad_of(design)
    meshed = meshed_piece(pad, coarse_sizes(pad, 1.0))
    mesh = elements.curved(meshed.mesh, 1)
    functions = mesh.nv + (order - 1) * mesh.nedge + (mesh.ne if order > 2 else 0)
    height, half = meshed.height / meshed.unit, meshed.whole.length / 2 / meshed.unit
    borders = layers.graded(half, LAYERS.last * height, LAYERS.growth)
    return float(3 * functions * layers.line(borders, LAYERS.order).at.size)
