"""The network of a circuit: a topology makes a list of elements of constants, and all else follows from it.

Constants are in SI. The film is a current source beside its static capacitance and a series R-L-C (motional)
branch: Yamada et al. 2002, equations (1) to (9) and Figs 5 and 6. Its capacitance is that of parallel plates,
right while the electrode is much wider than the film is thick. Its charge is D3 = d31 T1 + d32 T2 + d33 T3
(IEEE Std 176-1987), 1 the draw axis.

Nodes are names. Three have a meaning: `GROUND`, `LOAD`, whose voltage is the load in N, and `OUT`.

An amplifier is a function from constants to the elements behind the film. A new one is a function here and
its line in TOPOLOGIES; `amplifier.topology` names it. The nodes `film` (the film's electrode) and `vout` are
given; capacitors and sources alone must not close a loop.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.constants import epsilon_0

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.result import Record, item
from skincad.base.tables import Table, quantity
from skincad.inputs.design import Design

MAY_BE_0 = ("feedback_capacitance", "gain_bandwidth")  # what the paper's network has not


class Noise(Table):
    """What the amplifier adds; resistors and film add their thermal noise by themselves."""

    temperature: float = quantity("K", "of film and resistors", gt=0.0, le=1000.0, default=293.0)
    voltage_density: float = quantity(
        "V/sqrt(Hz)", "of the amplifier's input voltage noise", ge=0.0, le=1e-3, default=0.0
    )
    voltage_corner: float = quantity(
        "Hz",
        "below it 1/f noise is more than voltage_density: power (1 + voltage_corner / f); 0: white",
        ge=0.0,
        le=1e9,
        default=0.0,
    )
    current_density: float = quantity(
        "A/sqrt(Hz)", "of the amplifier's input current noise", ge=0.0, le=1e-3, default=0.0
    )


@dataclass(frozen=True)
class Constants(Record):
    """The constants of a film and its amplifier, each finite and above 0; `d33` may have either sign, not 0.

    `capacitance` is the paper's Cpvd with the cable's in parallel; `feedback_capacitance` may be 0,
    none, and `gain_bandwidth` 0, no limit. Raises InputError for any other value.
    """

    d33: float = item("C/N", "of the film")
    capacitance: float = item("F", "Cpvd")
    motional_resistance: float = item("ohm", "of the film's resonance")
    motional_inductance: float = item("H", "of the film's resonance")
    motional_capacitance: float = item("F", "of the film's resonance")
    series_resistance: float = item("ohm", "R1 + R2")
    input_resistance: float = item("ohm", "Ropi")
    input_capacitance: float = item("F", "Copi")
    feedback_resistance: float = item("ohm", "R3 + R4")
    output_resistance: float = item("ohm", "Ropo")
    gain: float = item(meaning="A")
    feedback_capacitance: float = item("F", "beside R3 + R4; none in the paper", default=0.0)
    gain_bandwidth: float = item("Hz", "of A, one pole; none in the paper", default=0.0)

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not math.isfinite(value):
                raise InputError(name, "must be a finite number", value)
            valid, rule = value > 0, "be above 0"
            if name in MAY_BE_0:
                valid, rule = value >= 0, "not be below 0"
            elif name == "d33":
                valid, rule = value != 0, "not be 0"
            if not valid:
                raise InputError(name, f"must {rule}", value)


Real = Array
Complex = NDArray[np.complex128]

GROUND, LOAD, OUT = "0", "load", "vout"


# What a name begins with, as in SPICE: a resistor, capacitor, inductor, or source, which holds its node at
# a gain times a voltage. Whether the value is an impedance, and by which power of s it counts.
KINDS = {"R": (True, 0), "C": (False, 1), "L": (True, 1), "E": (False, 0)}
SOURCE = "E"
AMPLIFIER = "Eamp"  # the source with the open loop's gain


@dataclass(frozen=True)
class Element:
    """One of KINDS, in ohm, F, H or 1, between two `nodes`; a source has its own node before the two.

    `loss`, F times the loss tangent, of a capacitor, counts in the noise only. So do the densities of an
    amplifier's source: V/sqrt(Hz) before the gain, with a 1/f corner in Hz, and A/sqrt(Hz) into each input.
    """

    name: str
    nodes: tuple[str, ...]
    value: float
    loss: float = 0.0
    voltage_density: float = 0.0
    voltage_corner: float = 0.0
    current_density: float = 0.0

    @property
    def kind(self) -> str:
        """Its key in KINDS."""
        return self.name[0]


Wiring = tuple[tuple[str, tuple[str, ...]], ...]


@dataclass(frozen=True)
class Network:
    """Elements, no two sources at one node; `charge` C is what a load of 1 N gives."""

    elements: tuple[Element, ...]
    charge: float
    temperature: float = 293.0  # K

    @property
    def wiring(self) -> Wiring:
        """The kind and the nodes of each element."""
        return tuple((e.kind, e.nodes) for e in self.elements)


MM, MM2 = 1e-3, 1e-6  # m, m2
PICO = 1e-12


def electrode(design: Design) -> float:
    """Return the area of a strip's electrode, mm2: where the metal of both faces lies over each other, as the
    cutting pattern draws it; bare at its edges and at both ends of the skin.

    It gives the charge and has the capacitance. The leads of the two faces run side by side and overlap
    nowhere (fabrication/electrodes.py): they have no piezoelectric part, and only a stray capacitance, which
    is left out. As coplanar strips (C = eps K(k') / K(k), k = gap / (gap + 2 width); Gupta, Garg, Bahl,
    Bhartia, Microstrip Lines and Slotlines, 2nd ed. 1996, chapter 7) it lies between that in air and that on
    a half space of film: 0.02 to 0.12 pF a millimetre of lead in `yamada-2002`, about that of a cable.
    """
    from skincad.shape.skin import skin_of  # geometry, which a circuit alone need not load

    slot = skin_of(design).slot
    assert design.film is not None
    assert slot is not None
    margin = design.film.margin
    return (design.skin.length - 2 * margin) * (slot.depth - 2 * margin)


def capacitance(area: float, thickness: float, permittivity: float) -> float:
    """Return the film's static capacitance, F, of electrodes in mm2 and a thickness in mm."""
    return float(epsilon_0) * permittivity * area * MM2 / (thickness * MM)


def charge(
    through: ArrayLike,
    along: ArrayLike,
    transverse: ArrayLike,
    *,
    area: float,
    coefficients: tuple[float, float, float],
    draw_axis: Literal["length", "width"] = "length",
) -> NDArray[np.float64]:
    """Return the charge on a strip, C, from mean stresses in MPa, tension positive, of any one shape.

    `through` the film, `along` the strip's length (y) and `transverse` its width in the section. In plane
    strain `along` is not zero: it counts as much as the others. `area` mm2; `coefficients` d31, d32, d33 in
    pC/N.
    """
    d31, d32, d33 = (d * PICO for d in coefficients)
    of_length, of_width = (d31, d32) if draw_axis == "length" else (d32, d31)
    total = d33 * np.asarray(through) + of_length * np.asarray(along) + of_width * np.asarray(transverse)
    return np.asarray(area * total, float)  # MPa times mm2 is N


def inverting(c: Constants, n: Noise) -> tuple[Element, ...]:
    """An inverting amplifier: the rate of the charge, or with a feedback capacitor the charge itself.

    Source: Yamada et al. 2002, Figs 5 and 6; the capacitor is not in the paper. `vout` has the sign of (9).
    """
    return (*_around(c, "in"), *_open_loop(c, n, "in", GROUND, -c.gain), _output(-1))


def follower(c: Constants, n: Noise) -> tuple[Element, ...]:
    """A voltage follower: the film's voltage, charge over capacitance, above 1 / (2 pi Ropi (Cpvd + Copi)).

    Ropi is the bias resistor; R3 + R4 lead from the output to the inverting input, which takes no current.
    Source: Horowitz and Hill, The Art of Electronics, 3rd ed., sec. 4.2.3.
    """
    return (*_around(c, "back"), *_open_loop(c, n, "in", "back", c.gain), _output(1))


THERMAL = Noise()  # a noiseless amplifier's
TOPOLOGIES: dict[str, Callable[[Constants, Noise], tuple[Element, ...]]] = {
    "inverting": inverting,
    "follower": follower,
}


def network(c: Constants, n: Noise = THERMAL, loss: float = 0.0, topology: str = "inverting") -> Network:
    """Return film and amplifier as one network; `loss` is the film's capacitance times its loss tangent, F.

    The film's current source beside Cpvd stands as a voltage source d33 lo / Cpvd behind it (Thevenin), so
    that any waveform at `load` gives the charge d33 lo without a derivative.
    """
    film = (
        Element("Epv", ("pv", LOAD, GROUND), c.d33 / c.capacitance),
        Element("Cpvd", ("pv", "film"), c.capacitance, loss),
        Element("Rmot", ("film", "m1"), c.motional_resistance),
        Element("Lmot", ("m1", "m2"), c.motional_inductance),
        Element("Cmot", ("m2", GROUND), c.motional_capacitance),
    )
    return Network((*film, *TOPOLOGIES[topology](c, n)), c.d33, n.temperature)


def _around(c: Constants, back: str) -> tuple[Element, ...]:
    """From the film to the amplifier's input and from there to ground, and from its output to node `back`."""
    fed = (Element("C34", (back, "out"), c.feedback_capacitance),) if c.feedback_capacitance else ()
    return (
        Element("R12", ("film", "in"), c.series_resistance),
        Element("Ropi", ("in", GROUND), c.input_resistance),
        Element("Copi", ("in", GROUND), c.input_capacitance),
        Element("R34", (back, "out"), c.feedback_resistance),
        *fed,
        Element("Ropo", ("amp", "out"), c.output_resistance),
    )


def _output(sign: float) -> Element:
    return Element("Evout", (OUT, "out", GROUND), sign)


def _open_loop(c: Constants, n: Noise, plus: str, minus: str, gain: float) -> tuple[Element, ...]:
    """The amplifier's source at `amp`; of a finite bandwidth its gain, a pole of 1 ohm, and a source of 1.

    The pole lies at gain_bandwidth / gain. Its resistor's noise, 0.13 nV/sqrt(Hz), comes behind the gain and
    counts for nothing.
    """
    noise = {key: value for key, value in n if key != "temperature"}
    if not c.gain_bandwidth:
        return (Element(AMPLIFIER, ("amp", plus, minus), gain, **noise),)
    return (
        Element(AMPLIFIER, ("fast", plus, minus), gain, **noise),
        Element("Rpole", ("fast", "slow"), 1.0),
        Element("Cpole", ("slow", GROUND), c.gain / (2 * math.pi * c.gain_bandwidth)),
        Element("Epole", ("amp", "slow", GROUND), 1),
    )


def netlist(network: Network, name: str, low: float = 10.0, high: float = 20_000.0) -> str:
    """Return a SPICE deck: 1 V at node `load` is 1 N, node `vout` is the output."""
    lines = [f"* {name}: PVDF film and amplifier, 1 V at node load is 1 N", "Vload load 0 DC 0 AC 1"]
    for e in network.elements:
        first, *others = e.nodes
        own = [first, GROUND] if e.kind == SOURCE else [first]
        lines.append(" ".join([e.name, *own, *others, repr(e.value)]))
    return "\n".join([*lines, f".ac dec 50 {low:g} {high:g}", ".print ac vdb(vout)", ".end", ""])
