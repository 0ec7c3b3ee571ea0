"""Ways that the package does not take: other holds between a circuit's samples, and the CAD kernel's meshes.

`python -m bench.holds [DESIGN]` prints, beside the ladders of `skincad accuracy`, the errors of the
zero-order hold and of the trapezoidal rule (bilinear, Tustin 1947), and of print meshes by the CAD kernel at
the same chords. Franklin, Powell, Workman, Digital Control, 3rd ed., ch. 6.
"""

from __future__ import annotations

import argparse
from functools import partial

import numpy as np
import trimesh
from scipy.linalg import matrix_balance, schur
from threadpoolctl import threadpool_limits

import skincad
from skincad.circuit import Network, Stepper, circuit_network, load_circuit, state_space
from skincad.circuit.state import exponential
from skincad.fabrication.measures import measure
from skincad.inputs import Design
from skincad.shape.skin import skin_of
from skincad.solids.occ import solid, tessellate, triangles
from skincad.solids.skin import skin_part
from skincad.studies import Ladder, Measurement
from skincad.studies.accuracy import circuit, tessellation
from skincad.studies.accuracy.ladder import timed

KERNEL = "CAD kernel"


def stepped(network: Network, rate: float) -> Stepper:
    """Return the exact step for a charge that stays at its last sample, and jumps at each step's end."""
    a, b = balanced(network, rate)
    return triangular(network, rate, exponential(a), b)


def trapezoidal(network: Network, rate: float) -> Stepper:
    """Return the trapezoidal rule's step."""
    a, b = balanced(network, rate)
    one, half = np.eye(len(a)), a / 2
    return triangular(network, rate, np.linalg.solve(one - half, one + half), np.linalg.solve(one - half, b))


def balanced(network: Network, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a and b of a network's equations, a step the unit of time, the states in units of one size."""
    system = state_space(network)
    a, (units, _) = matrix_balance(system.a / rate, permute=False, separate=True)
    return a, system.b / units


def triangular(network: Network, rate: float, step: np.ndarray, push: np.ndarray) -> Stepper:
    """Return a step of balanced states in its triangular basis."""
    system = state_space(network)
    _, (units, _) = matrix_balance(system.a / rate, permute=False, separate=True)
    triangle, basis = schur(step, output="complex")
    out = (system.c * units) @ basis
    return Stepper(rate=rate, step=triangle, push=basis.conj().T @ push, out=out, through=system.d)


HOLDS = {"zero-order hold": stepped, "bilinear": trapezoidal}


def holds(design: Design, repeats: int) -> Ladder:
    """Return the circuit's ladder with other holds beside the package's."""
    ladder = circuit.ladder(design, repeats, print)
    network = circuit_network(load_circuit(circuit.CIRCUIT))
    others = [
        circuit.trial(network, name, hold, count, repeats)
        for name, hold in HOLDS.items()
        for count in circuit.PER_PERIOD
    ]
    return Ladder(ladder.name, ladder.title, (*ladder.trials, *others), ladder.measures)


def kernel_meshes(design: Design, repeats: int) -> Ladder:
    """Return the ladder of print meshes with those of the CAD kernel, from its exact solid."""
    ladder, part = tessellation.ladder(design, repeats, print), skin_part(design)
    exact, others = solid(part), []
    for share in tessellation.CHORDS:
        chord = share * min(skin_of(design).heights)
        _, runs = timed(partial(tessellate, exact, chord), repeats)
        corners, faces = triangles(exact, chord)
        shape = trimesh.Trimesh(np.array([c.toTuple() for c in corners]), np.array(faces), process=False)
        shape.merge_vertices()  # its faces joined at equal corners
        deviation, volume = measure(part, shape, chord).deviation, abs(float(shape.volume) / part.volume - 1)
        errors = {"deviation": deviation, "volume": volume}
        others.append(Measurement(KERNEL, f"chord {chord:.2g} mm", len(shape.faces), runs, errors))
    return Ladder(ladder.name, ladder.title, (*ladder.trials, *others), ladder.measures)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("design", nargs="?", default="yamada-2002")
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    for compare in (holds, kernel_meshes):
        ladder = compare(skincad.load(options.design), options.repeats)
        print(f"{ladder.title}: {', '.join(measure.name for measure in ladder.measures)}")
        for trial in ladder.trials:
            errors = " ".join(f"{trial.errors[measure.name]:10.2g}" for measure in ladder.measures)
            print(f"{trial.model:18} {trial.setting:24} {trial.seconds:9.3g} s {errors}")


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
