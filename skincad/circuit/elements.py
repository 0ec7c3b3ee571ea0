"""The elements that a circuit is a list of; response, state equations, noise and netlist follow from it.

Nodes are names. Three have a meaning: `GROUND`, `LOAD`, whose voltage is the load in N, and `OUT`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skincad.base.arrays import Array, Mask

Real = Array
Complex = NDArray[np.complex128]

GROUND, LOAD, OUT = "0", "load", "vout"


@dataclass(frozen=True)
class _TwoTerminal:
    """What lies between two nodes."""

    name: str
    a: str
    b: str
    value: float

    @property
    def ends(self) -> tuple[str, ...]:
        """The nodes that it touches; a source's own comes first."""
        return (self.a, self.b)


class Resistor(_TwoTerminal):
    """In ohm; it has its thermal noise."""


@dataclass(frozen=True)
class Capacitor(_TwoTerminal):
    """In F. `loss`, F times the loss tangent, counts in the noise only."""

    loss: float = 0.0


class Inductor(_TwoTerminal):
    """In H."""


@dataclass(frozen=True)
class Source:
    """Holds node `a` at `value` times the voltage from `minus` to `plus`; an amplifier has input noise too.

    `voltage_density` is in V/sqrt(Hz), before the gain; `current_density` in A/sqrt(Hz), into each input.
    """

    name: str
    a: str
    plus: str
    minus: str
    value: float
    voltage_density: float = 0.0
    current_density: float = 0.0

    @property
    def ends(self) -> tuple[str, ...]:
        """The nodes that it touches, its own first."""
        return (self.a, self.plus, self.minus)


Element = Resistor | Capacitor | Inductor | Source
Wiring = tuple[tuple[type[Element], tuple[str, ...]], ...]


@dataclass(frozen=True)
class Network:
    """Elements, no two sources at one node; `charge` C is what a load of 1 N gives."""

    elements: tuple[Element, ...]
    charge: float
    temperature: float = 293.0  # K

    @property
    def wiring(self) -> Wiring:
        """The kind and the nodes of each element."""
        return tuple((type(e), e.ends) for e in self.elements)


@dataclass(frozen=True)
class Equations:
    """A network's node equations, one of each of `nodes`, those of `held` ones, `(n,)`, by source or load.

    `across` `(elements, n)` gives the voltage that each element sees, of the nodes'.
    """

    nodes: tuple[str, ...]
    fixed: Mask
    drops: NDArray[Any]

    def part(self, i: int, branch: str | None) -> NDArray[Any]:
        """Return what element i's admittance multiplies, `(n, n)`, or the gain of a source at `own`."""
        where = ~self.fixed * self.drops[i] if branch is None else [-(node == branch) for node in self.nodes]
        return np.outer(where, self.drops[i])


def equations(wiring: Wiring) -> Equations:
    """Return the equations: source and load hold their nodes, elsewhere the currents add up to 0."""
    named = dict.fromkeys(node for _, ends in wiring for node in ends)
    nodes = tuple(node for node in named if node != GROUND)
    voltage = dict(zip([*nodes, GROUND], np.eye(len(nodes) + 1, len(nodes), dtype=int), strict=True))
    fixed = {LOAD, *(ends[0] for kind, ends in wiring if kind is Source)}
    drops = np.array([voltage[ends[-2]] - voltage[ends[-1]] for _, ends in wiring])
    return Equations(nodes, np.array([node in fixed for node in nodes]), drops)
