"""The amplifiers: each a function from constants to the list of elements behind the film.

A new one is a function here and its line in TOPOLOGIES; `amplifier.topology` names it. The nodes `film`
(the film's electrode) and `vout` are given; capacitors and sources alone must not close a loop.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from skincad.circuit.constants import Constants, NoiseSources
from skincad.circuit.elements import Capacitor, Element, Inductor, Network, Resistor, Source

SILENT = NoiseSources()


def inverting(c: Constants, n: NoiseSources) -> tuple[Element, ...]:
    """An inverting amplifier: the rate of the charge, or with a feedback capacitor the charge itself.

    Source: Yamada et al. 2002, Figs 5 and 6; the capacitor is not in the paper. `vout` has the sign of (9).
    """
    return (
        *_input(c),
        Resistor("R34", "in", "out", c.feedback_resistance),
        *_beside(c, "in", "out"),
        Resistor("Ropo", "amp", "out", c.output_resistance),
        *_open_loop(c, n, "in", "0", -c.gain),
        Source("Evout", "vout", "out", "0", -1),
    )


def follower(c: Constants, n: NoiseSources) -> tuple[Element, ...]:
    """A voltage follower: the film's voltage, charge over capacitance, above 1 / (2 pi Ropi (Cpvd + Copi)).

    Ropi is the bias resistor; R3 + R4 lead from the output to the inverting input, which takes no current.
    Source: Horowitz and Hill, The Art of Electronics, 3rd ed., sec. 4.2.3.
    """
    return (
        *_input(c),
        Resistor("R34", "back", "out", c.feedback_resistance),
        *_beside(c, "back", "out"),
        Resistor("Ropo", "amp", "out", c.output_resistance),
        *_open_loop(c, n, "in", "back", c.gain),
        Source("Evout", "vout", "out", "0", 1),
    )


TOPOLOGIES: dict[str, Callable[[Constants, NoiseSources], tuple[Element, ...]]] = {
    "inverting": inverting,
    "follower": follower,
}


def network(c: Constants, n: NoiseSources = SILENT, topology: str = "inverting") -> Network:
    """Return film and amplifier as one network.

    The film's current source beside Cpvd stands as a voltage source d33 lo / Cpvd behind it (Thevenin), so
    that any waveform at `load` gives the charge d33 lo without a derivative.
    """
    film = (
        Source("Epv", "pv", "load", "0", c.d33 / c.capacitance),
        Capacitor("Cpvd", "pv", "film", c.capacitance, n.film_capacitance * n.loss_tangent),
        Resistor("Rmot", "film", "m1", c.motional_resistance),
        Inductor("Lmot", "m1", "m2", c.motional_inductance),
        Capacitor("Cmot", "m2", "0", c.motional_capacitance),
    )
    return Network((*film, *TOPOLOGIES[topology](c, n)), c.d33, n.temperature)


def _input(c: Constants) -> tuple[Element, ...]:
    """From the film to the amplifier's input, with what leads from there to ground."""
    return (
        Resistor("R12", "film", "in", c.series_resistance),
        Resistor("Ropi", "in", "0", c.input_resistance),
        Capacitor("Copi", "in", "0", c.input_capacitance),
    )


def _open_loop(c: Constants, n: NoiseSources, plus: str, minus: str, gain: float) -> tuple[Element, ...]:
    """The amplifier's source at `amp`; of a finite bandwidth its gain, a pole of 1 ohm, and a source of 1.

    The pole lies at gain_bandwidth / gain. Its resistor's noise, 0.13 nV/sqrt(Hz), comes behind the gain and
    counts for nothing.
    """
    noise = n.voltage_density, n.current_density
    if not c.gain_bandwidth:
        return (Source("Eamp", "amp", plus, minus, gain, *noise),)
    return (
        Source("Eamp", "fast", plus, minus, gain, *noise),
        Resistor("Rpole", "fast", "slow", 1.0),
        Capacitor("Cpole", "slow", "0", c.gain / (2 * math.pi * c.gain_bandwidth)),
        Source("Epole", "amp", "slow", "0", 1),
    )


def _beside(c: Constants, a: str, b: str) -> tuple[Element, ...]:
    """The feedback's capacitor, if there is one."""
    return (Capacitor("C34", a, b, c.feedback_capacitance),) if c.feedback_capacitance else ()
