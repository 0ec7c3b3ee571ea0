"""The rig of a frequency test: what is told of a load is not what the film feels.

The paper's film lies between a vibrator's indenter and the probe of a force sensor. A sensor is a mass on a
spring: it reads by the spring, and the film feels the mass's inertia too, a double zero in output by told
load (an amplifier behind the sensor that passes as much does the same). Range: one mass each, in the film's
direction. None of it acts in use: scenes, noise and netlist are without it.
"""

from __future__ import annotations

import numpy as np

from skincad.circuit.elements import Complex, Real
from skincad.circuit.model import Circuit, ForceSensor, Indenter


def has_rig(circuit: Circuit) -> bool:
    """Return whether a circuit's gain is told of a measured load."""
    return bool(circuit.indenter or circuit.force_sensor)


def without_rig(circuit: Circuit) -> Circuit:
    """Return the circuit as it is in use."""
    return circuit.model_copy(update={"indenter": None, "force_sensor": None})


def film_load(circuit: Circuit, frequency: Real) -> Complex:
    """Return the load on the film by the load that is told, `(n,)` at `(n,)` Hz; 1 without a rig."""
    ratio = np.ones(np.shape(frequency), complex)
    if circuit.indenter:
        ratio = ratio / pressed(circuit.indenter, frequency)
    if circuit.force_sensor:
        ratio = ratio * pressed(circuit.force_sensor, frequency)
    return ratio


def pressed(part: Indenter | ForceSensor, frequency: Real) -> Complex:
    """Return the load on a mass by that in the damped spring behind it, `(n,)`: 1 + 2 zeta s + s^2."""
    ratio = frequency / part.resonance
    return np.asarray(1 - ratio**2 + 2j * part.damping * ratio)


def told_rig(circuit: Circuit) -> str:
    """Return the rig in words."""
    named = {"indenter": circuit.indenter, "force sensor": circuit.force_sensor}
    return " and ".join(f"the {name} at {part.resonance:g} Hz" for name, part in named.items() if part)
