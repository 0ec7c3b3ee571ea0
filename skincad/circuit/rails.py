"""An amplifier at its rails: where its output rests, and what it gives while it cannot follow the film.

Within its rails an amplifier holds its input. At a rail it holds its output, and the input moves away by w:
the film's charge lies on the input's capacitance and waits. The output leaves the rail when w is back at 0.
So a pulse that a rail cuts off comes out lower and longer.

The output is the linear one and H(s) w, H the way from the amplifier's own input to `vout`; either w is 0 or
the output is at a rail. H is taken to first order, (direct + lead s) / (1 + lag s). Behind a resistor Rf and
capacitor Cf direct is 1, lead is Rf (C + Cf) and lag is Rf Cf, with C all capacitance at the input (Graeme,
Photodiode Amplifiers, 1996, chapter 3). A follower has lead = lag: its output is cut off, and nothing waits.
Range: the resistor before the input and the film's resonance are fast against lead, and the closed loop is
against lag. Where Cf is so small that the circuit rings, it rings after a rail too, which is left out.

Left out: the amplifier's own recovery from overload and its slew rate (below 1 us and some V/us where it has
megahertz), and the diodes of its input, which conduct where w takes it some 0.3 V beyond the supply.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.circuit.network import AMPLIFIER, GROUND, OUT, Network
from skincad.circuit.response import Drive, polynomial

FADED = 1e-12  # of the nearer rail: a correction that has become as small is none


def rest(network: Network, bias_current: float) -> float:
    """Return the output at rest, V at `vout`, of a current in A into each of the amplifier's inputs."""
    _, *inputs = _amplifier(network)[1]
    if not bias_current:
        return 0.0
    return -bias_current * sum(_orders(network, ((node, 0, 1),))[0] for node in {*inputs} - {GROUND})


def sign(network: Network) -> float:
    """Return what `vout` is of the amplifier's own output: -1 for an inverting one."""
    return next(e.value for e in network.elements if e.nodes[0] == OUT)


@dataclass(frozen=True)
class Overload:
    """H in steps: free, what was added fades; at a rail w = ratio u + y, where u is what the rail adds.

    ratio is lag / lead, and lead y' + direct y = (1 - direct ratio) u: exact for a straight u.
    """

    fade: float
    ratio: float
    keeps: float
    of_last: float
    of_this: float


def overload(network: Network, step: float) -> Overload:
    """Return the way from an amplifier's input to its output, at every `step` s."""
    index, (own, *_) = _amplifier(network)
    direct, lead = _orders(network, ((own, 1 << index, 1),))
    direct, lead = abs(direct), math.copysign(1.0, direct) * lead  # whichever input it is seen from
    lag = max(0.0, _orders(network, None)[1])
    slow, share = step * direct / lead, 1 / direct - lag / lead
    keeps, mean = math.exp(-slow), -math.expm1(-slow) / slow
    fade = math.exp(-step / lag) if lag else 0.0
    return Overload(fade, lag / lead, keeps, share * (mean - keeps), share * (1 - mean))


def at_rails(network: Network, output: Array, step: float, low: float, high: float) -> tuple[Array, Mask]:
    """Return what the rails add to an output `(n,)` V every `step` s, and which samples lie at a rail.

    `low` is below 0 V and `high` above it, each at `vout` from rest; the output is straight between samples.
    """
    added, held = np.zeros(output.size), np.zeros(output.size, bool)
    beyond = np.flatnonzero((output < low) | (output > high))
    if not beyond.size:
        return added, held
    way, values, small = overload(network, step), output.tolist(), FADED * min(high, -low)
    k, u = int(beyond[0]), 0.0
    while k < output.size:
        level = values[k] + u * way.fade
        bound = min(max(level, low), high)
        if bound != level:
            spell, left = _held(way, values, k, u, bound)
            end = k + len(spell)
            u = min(max(values[end - 1] + spell[-1], low), high) - values[end - 1]
            added[k:end], added[end - 1] = spell, u
            held[k : end - left], k = True, end
        elif abs(u) > small:
            added[k] = u = u * way.fade
            k += 1
        else:
            u, later = 0.0, np.searchsorted(beyond, k)
            k = int(beyond[later]) if later < beyond.size else output.size
    return added, held


def _held(way: Overload, values: list[float], k: int, u: float, bound: float) -> tuple[list[float], bool]:
    """What a rail adds from sample k on, after u at the last one, until w is 0 again; whether it is."""
    added, w, y, inward = list[float](), 0.0, -way.ratio * u, bound - values[k] - u * way.fade
    for at in range(k, len(values)):
        last, u, before = u, bound - values[at], w
        y = way.keeps * y + way.of_last * last + way.of_this * u
        w = way.ratio * u + y
        if w * inward <= 0:  # it left within this step, at this part of it
            part = before / (before - w) if before != w else 0.0
            return [*added, (last + part * (u - last)) * way.fade ** (1 - part)], True
        added.append(u)
    return added, False


def _amplifier(network: Network) -> tuple[int, tuple[str, ...]]:
    """The place and the nodes of the source with the open loop's gain: its own, then its inputs."""
    return next((i, e.nodes) for i, e in enumerate(network.elements) if e.name == AMPLIFIER)


def _orders(network: Network, drive: Drive | None) -> tuple[float, float]:
    """The output by a drive as its numerator's constant and its part by s, both over the constant of the
    denominator; without a drive those of the denominator."""
    (whole, size), (part, twos) = polynomial(network, None), polynomial(network, drive)
    scale = np.exp2(np.longdouble(twos - size)) / whole[0]
    constant, slope = (float(x * scale) for x in np.append(part, [0.0, 0.0])[:2])
    return constant, slope
