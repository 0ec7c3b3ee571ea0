"""The ladder of a circuit's time steps.

The circuit in time: samples a period, against the exact response. A smooth signal and one with a kink.
Smooth: a sine of the cut-off's frequency that swells gently, so that no hold is judged by a start that it did
not cause; what is compared is the last periods. Kinked: a load that begins to rise straight at one sample, as
a stress does where a ridge starts to slip. The input is the film's charge at the samples, with straight lines
between them (exact first-order hold). Other holds: `python -m bench.holds`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from skincad.circuit.model import circuit_network, load_circuit
from skincad.circuit.network import Network, Real
from skincad.circuit.response import response
from skincad.circuit.state import Stepper, run, stepper
from skincad.inputs.design import Design
from skincad.studies.accuracy.ladder import ErrorMeasure, Ladder, Measurement, timed

CIRCUIT = "yamada-2002-motional"  # a design has no circuit of its own; the one whose network has a cut-off
FREQUENCY = 1200.0  # Hz; that cut-off
PER_PERIOD = (16, 64, 256, 1024, 4096)
PERIODS, SWELL, SEEN = 60, 30, 10  # in all, in which it swells, and at the end that are compared
FINER, KINKED = 4, 10  # rate of the kinked load's reference; its periods
Hold = Callable[[Network, float], Stepper]


def ladder(design: Design, repeats: int, tell: Callable[[str], None]) -> Ladder:
    """Return the hold at each number of samples; of the design only the title tells."""
    network = circuit_network(load_circuit(CIRCUIT))
    trials = []
    for count in PER_PERIOD:
        tell(f"{count} samples a period")
        trials.append(trial(network, "first-order hold", stepper, count, repeats))
    known = (
        "the node equations, solved without loss of digits; their closed form differs by 1e-13, "
        "ngspice's AC analysis of the same netlist by 2e-7 dB (tests/circuit)"
    )
    truth = f"the exact response at {FREQUENCY:g} Hz"
    kinked = f"the first-order hold at {FINER} times the rate: such a load is straight between samples"
    exact = "the hold is exact for it at any rate; its own rows show by how much two rates differ"
    what = "rms error of the output to a load with a kink, relative"
    measures = (
        ErrorMeasure("output", "rms error of the output, relative", "1", truth, known),
        ErrorMeasure("kink", what, "1", kinked, exact, floor=1e-9),
        ErrorMeasure("size", "error of the output's size, its lag aside, relative", "1", truth, known),
    )
    title = f"circuit {CIRCUIT} under a sine of {FREQUENCY:g} Hz (for {design.name})"
    return Ladder("circuit", title, tuple(trials), measures)


def trial(network: Network, name: str, hold: Hold, count: int, repeats: int) -> Measurement:
    """Return a hold's errors at so many samples a period."""
    exact = complex(response(network, np.array([FREQUENCY]))[0])
    charge = network.charge * sine(count)  # of a load of 1 N
    voltage, runs = timed(lambda: run(hold(network, FREQUENCY * count), charge)[0], repeats)
    last = slice(-SEEN * count, None)
    turn = np.exp(2j * np.pi * np.arange(voltage.size)[last] / count)
    missed = voltage[last] - (exact * turn).imag
    gain = complex(2j * np.mean(voltage[last] * turn.conj()))
    kinked = after_kink(network, stepper, count, FINER)
    kink = after_kink(network, hold, count) - kinked
    errors = {
        "output": float(np.sqrt(2) * np.sqrt(np.mean(missed**2)) / abs(exact)),
        "size": abs(abs(gain) / abs(exact) - 1),
        "kink": float(np.sqrt(np.mean(kink**2) / np.mean(kinked**2))),
    }
    return Measurement(name, f"{count} samples a period", charge.size, runs, errors)


def sine(per_period: int) -> Real:
    """Return the samples of a sine of size 1 that swells like half a cosine."""
    at = np.arange(per_period * PERIODS) / per_period
    return np.asarray((1 - np.cos(np.pi * np.minimum(at / SWELL, 1.0))) / 2 * np.sin(2 * np.pi * at))


def after_kink(network: Network, hold: Hold, per_period: int, finer: int = 1) -> Real:
    """Return the output to a load that rises straight from a sample on, at `finer` times the rate, of which
    the samples are kept."""
    count = per_period * KINKED
    late = np.arange(count * finer) / finer - count / 4
    charge = np.asarray(network.charge * np.maximum(late, 0.0) / count)
    return run(hold(network, finer * FREQUENCY * per_period), charge)[0][::finer]
