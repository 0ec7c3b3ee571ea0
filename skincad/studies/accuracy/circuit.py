"""The ladder of a circuit's time steps.

The circuit in time: samples a period and the hold between samples, against the exact response. A smooth
signal and one with a kink. Smooth: a sine of the cut-off's frequency that swells gently, so that no hold is
judged by a start that it did not cause; what is compared is the last periods. Kinked: a load that begins to
rise straight at one sample, as a stress does where a ridge starts to slip. The input is the film's charge at
the samples. The three holds: straight lines between samples (exact first-order hold, what skincad uses),
steps (zero-order hold), and the trapezoidal rule (bilinear, Tustin 1947). Franklin, Powell, Workman, Digital
Control, 3rd ed., ch. 6.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from scipy import linalg

from skincad.base.progress import Progress
from skincad.circuit.model import circuit_network, load_circuit
from skincad.circuit.network import Network, Real
from skincad.circuit.response import response
from skincad.circuit.state import Stepper, run, sizes, state_space, stepper
from skincad.inputs.design import Design
from skincad.studies.accuracy.ladder import ErrorMeasure, Ladder, Measurement, timed

CIRCUIT = "yamada-2002-motional"  # a design has no circuit of its own; the one whose network has a cut-off
FREQUENCY = 1200.0  # Hz; that cut-off
PER_PERIOD = (16, 64, 256, 1024, 4096)
PERIODS, SWELL, SEEN = 60, 30, 10  # in all, in which it swells, and at the end that are compared
FINER, KINKED = 4, 10  # rate of the kinked load's reference; its periods
SECONDS = 0.023, 2.8e-5  # a run of all holds: in any case, and for a sample of each period; measured
HOLDS = ("first-order hold", "zero-order hold", "bilinear")


def ladder(design: Design, repeats: int, progress: Progress | None) -> Ladder:
    """Return the holds at each number of samples; of the design only the title tells."""
    network = circuit_network(load_circuit(CIRCUIT))
    exact = complex(response(network, np.array([FREQUENCY]))[0])
    trials = []
    for count in PER_PERIOD:
        if progress:
            progress(_stage(count))
        charge = network.charge * sine(count)  # of a load of 1 N
        kinked = after_kink(network, HOLDS[0], count, FINER)
        for hold in HOLDS:
            voltage, runs = timed(partial(held, network, hold, FREQUENCY * count, charge), repeats)
            errors = {**errors_of(voltage, exact, count), "kink": kink_error(network, hold, count, kinked)}
            trials.append(Measurement(hold, f"{count} samples a period", charge.size, runs, errors))
    known = (
        "the node equations, solved without loss of digits; their closed form differs by 1e-13, "
        "ngspice's AC analysis of the same netlist by 2e-7 dB (tests/circuit)"
    )
    truth = f"the exact response at {FREQUENCY:g} Hz"
    measures = (
        ErrorMeasure("output", "rms error of the output, relative", "1", truth, known),
        ErrorMeasure(
            "kink",
            "rms error of the output to a load with a kink, relative",
            "1",
            f"the first-order hold at {FINER} times the rate: such a load is straight between samples",
            "the hold is exact for it at any rate; its own rows show by how much two rates differ",
            floor=1e-9,
        ),
        ErrorMeasure("size", "error of the output's size, its lag aside, relative", "1", truth, known),
    )
    title = f"circuit {CIRCUIT} under a sine of {FREQUENCY:g} Hz (for {design.name})"
    return Ladder("circuit", title, tuple(trials), measures)


def prices(design: Design, repeats: int) -> dict[str, float]:  # noqa: ARG001
    """Return the stages and their expected seconds."""
    return {_stage(count): (repeats + 1) * (SECONDS[0] + SECONDS[1] * count) for count in PER_PERIOD}


def _stage(count: int) -> str:
    return f"circuit: {count} samples a period"


def sine(per_period: int) -> Real:
    """Return the samples of a sine of size 1 that swells like half a cosine."""
    at = np.arange(per_period * PERIODS) / per_period
    return np.asarray((1 - np.cos(np.pi * np.minimum(at / SWELL, 1.0))) / 2 * np.sin(2 * np.pi * at))


def held(network: Network, hold: str, rate: float, charge: Real) -> Real:
    """Return the output `(n,)` V for a charge `(n,)` C at `rate` Hz by one of the HOLDS, at rest before."""
    steps = {"first-order hold": stepper, "zero-order hold": stepped, "bilinear": trapezoidal}
    return run(steps[hold](network, rate), charge)[0]


def stepped(network: Network, rate: float) -> Stepper:
    """Return the exact step for a charge that stays at the last sample."""
    straight = stepper(network, rate)
    return replace(straight, now=straight.now + straight.then, then=np.zeros_like(straight.then))


def trapezoidal(network: Network, rate: float) -> Stepper:
    """Return the trapezoidal rule's step."""
    system = state_space(network)
    size = sizes(system, rate)
    one, half = np.eye(size.size), system.a * size[None, :] / size[:, None] / (2 * rate)
    step = np.linalg.solve(one - half, one + half)
    push = np.linalg.solve(one - half, system.b / size) / (2 * rate)
    triangle, basis = linalg.schur(step, output="complex")
    back = basis.conj().T
    out, rest = (system.c * size) @ basis, back @ (system.rest / size)
    return Stepper(
        rate=rate, step=triangle, now=back @ push, then=back @ push, out=out, through=system.d, rest=rest
    )


def errors_of(voltage: Real, exact: complex, per_period: int) -> dict[str, float]:
    """Return the relative errors over the last SEEN periods of a steady sine of size 1."""
    last = slice(-SEEN * per_period, None)
    turn = np.exp(2j * np.pi * np.arange(voltage.size)[last] / per_period)
    missed = voltage[last] - (exact * turn).imag
    gain = complex(2j * np.mean(voltage[last] * turn.conj()))
    size = float(np.sqrt(2) * np.sqrt(np.mean(missed**2)) / abs(exact))
    return {"output": size, "size": abs(abs(gain) / abs(exact) - 1)}


def after_kink(network: Network, hold: str, per_period: int, finer: int = 1) -> Real:
    """Return the output to a load that rises straight from a sample on, at `finer` times the rate, of which
    the samples are kept."""
    count = per_period * KINKED
    late = np.arange(count * finer) / finer - count / 4
    charge = np.asarray(network.charge * np.maximum(late, 0.0) / count)
    return held(network, hold, finer * FREQUENCY * per_period, charge)[::finer]


def kink_error(network: Network, hold: str, per_period: int, exact: Real) -> float:
    """Return the relative rms error of the output to a load with a kink."""
    missed = after_kink(network, hold, per_period) - exact
    return float(np.sqrt(np.mean(missed**2) / np.mean(exact**2)))
