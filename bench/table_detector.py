"""The slip detector's exam: scenes that it was not fitted to, by amplifier, noise and number of ridges.

`python -m bench.table_detector [FOLDER] [CIRCUIT ...] [--roc PNG]` (default out/exam, all CIRCUITS)
marches the exam set of bench/exam (half an hour on a core; what is in FOLDER is not marched again) and
prints, for each amplifier, gross slips warned of, lead, alarms that are true, and false by kind, each with
its 95 % interval; beside detectors that are silent, never cease, watch the rate alone, or know the
forces; false alarms by threshold, and of minutes of holding; and the bound of what any detector can warn of.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.signal import lfilter
from threadpoolctl import threadpool_limits

from bench.exam import rivals, roc
from bench.exam.bound import bound
from bench.exam.cases import Case, case
from bench.exam.scenes import SceneRun, kept, seeds
from bench.exam.scoring import HEAD, Alarm, Mark, line, mark, rate
from bench.exam.skins import EXAM
from skincad.circuit.model import circuit_network, load_circuit
from skincad.circuit.response import total_density
from skincad.circuit.state import corner
from skincad.effects.piezo import fitted
from skincad.inputs.catalog import load_design
from skincad.scenes.detector import EARLY, INCIPIENT, POINTS, SEEN, SURE, Detector, at_rest, detector, fed

CIRCUITS = ("transimpedance", "yamada-2002", "yamada-2002-motional")
LOUDER = (0.0, 1.0, 10.0)  # times the noise
RIDGES = (1, 2, 3, 5, 9)
FEWEST = 100  # steps of a scene that was marched far enough
BOUNDED = 4  # every so manyth gross slip has its twin marched
MINUTES = 40  # of holding: with none in 37, less than 0.1 a minute at 95 %
RATE, BAND = 1e5, 5e3  # Hz, of holding; the fastest of the exam has the most decisions a minute
BLOCK = 1 << 20  # samples

Find = Callable[[Case, int], list[Alarm]]


def ear(one: Case, louder: float = 1.0, alarms: str = SURE) -> Detector:
    """Return the detector of a case's rate, band and noise."""
    noise = math.sqrt(2) * one.noise * max(louder, 1.0)
    return detector(one.rate, one.scene.bandwidth, noise, alarms=alarms)


def found(one: Case, louder: float = 1.0, alarms: str = SURE) -> list[Alarm]:
    """Return the detector's alarms behind `louder` times the noise."""
    outputs = one.outputs + (louder * one.noises(1) if louder else 0.0)
    events = fed(ear(one, louder, alarms), at_rest(outputs.shape[1]), outputs)[0]
    return [(e.ridge, e.index) for e in events if e.kind == INCIPIENT and e.ridge is not None]


def row(name: str, told: list[Case], find: Find) -> None:
    """Print a detector's line, and where its false alarms are."""
    marks = [mark(one, find(one, ear(one).window), ear(one).window) for one in told]
    within = Counter(phase for m in marks for phase in m.within).most_common(4)
    print(line(name, marks), " ".join(f"{phase} {n}" for phase, n in within), flush=True)


def some(scene: SceneRun, count: int) -> tuple[int, ...]:
    """Return `count` ridges of a scene, or all that it has, drawn by its seed."""
    order = np.random.default_rng((9, scene.seed)).permutation(scene.slipping.shape[1])
    return tuple(sorted((order[:count] + 1).tolist()))


def held(circuit: str) -> tuple[int, float]:
    """Return how often the noise of two pairs under a constant load is loud enough for an alarm, and how many
    times the noise its loudest window was."""
    network = circuit_network(fitted(load_circuit(circuit), load_design("yamada-2002")))
    at, grid = np.fft.rfftfreq(BLOCK, 1 / RATE), np.geomspace(RATE / BLOCK, RATE / 2, 4000)
    passed = 1 / (1 + (2 * np.pi * grid / corner(BAND)) ** 2)
    size = np.interp(at, grid, np.sqrt(total_density(network, grid)) * passed)
    size[0] = 0.0
    rms = math.sqrt(float(np.sum(size**2)))
    window, draw = detector(RATE, BAND, rms).window, np.random.default_rng(8)
    share, times, most = 1 / (1 + window), 0, 0.0
    for _ in range(math.ceil(2 * MINUTES * 60 * RATE / BLOCK)):
        parts = draw.standard_normal((2, size.size)) * size * (BLOCK / 2)
        pair = np.fft.irfft(parts[0] + 1j * parts[1], BLOCK)
        loud = np.sqrt(lfilter([share], [1, share - 1], pair**2)) / rms
        times += int(np.sum((loud[1:] > SEEN) & (loud[:-1] <= SEEN)))
        most = max(most, float(loud.max()))
    return times, most


def table(circuit: str, scenes: list[SceneRun], folder: Path) -> dict[str, dict[float, list[Mark]]]:
    """Print an amplifier's part; return its marks by kind of alarms and threshold."""
    every = [case(scene, circuit, folder / "outputs") for scene in scenes]
    rows = [one.told(one.scene.told) for one in every]
    print(f"\n{circuit}\n{HEAD}")
    for louder in LOUDER:
        row(f"sure, noise x {louder:g}", rows, lambda one, _, by=louder: found(one, by))
    row("early", rows, lambda one, _: found(one, 1.0, EARLY))
    for alarms in POINTS:
        for count in RIDGES:
            few = [one.told(some(one.scene, count)) for one in every]
            row(f"{alarms}, {count} ridges told", few, lambda one, _, by=alarms: found(one, 1.0, by))
    row("rate's threshold", rows, lambda one, w: rivals.threshold(one, w, one.outputs + one.noises(1)))
    row("forces and friction known", rows, lambda one, w: [(None, i) for _, i in rivals.cone(one, w)])
    row("never", rows, rivals.never)
    row("always", rows, rivals.always)
    traded = {alarms: roc.marks(rows, alarms) for alarms in POINTS}
    for alarms, found_at in traded.items():
        roc.printed(found_at, alarms)
    times, most = held(circuit)
    minute, low, high = rate(times, MINUTES)
    print(f"holding: {minute:.3g} ({low:.2g}-{high:.2g}) a minute, loudest {most:.2f} of {SEEN:g} noise rms")
    slips = [one for one in [one for one in rows if one.gross is not None][::BOUNDED] if not one.scene.mass]
    can = [
        bound(one.scene.seed, circuit, folder / "scenes", folder / "outputs", ear(one).window / one.rate)
        for one in slips
    ]
    known = [share for share in can if share is not None]
    print(f"bound: {100 * np.mean(known):.1f} % of {len(known)} gross slips that have a twin without")
    return traded


def main() -> None:
    """Print the exam."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("out/exam"))
    parser.add_argument("circuits", nargs="*", default=list(CIRCUITS), metavar="CIRCUIT")
    parser.add_argument(
        "--roc", type=Path, metavar="PNG", help="where warnings against false alarms are drawn"
    )
    options = parser.parse_args()
    marched = [kept(seed, options.folder / "scenes") for seed in seeds(EXAM)]
    marched = [scene for scene in marched if scene.time.size > FEWEST]
    print(f"exam: seeds {seeds(EXAM)[0]} to {seeds(EXAM)[-1]}, odd; {len(marched)} scenes")
    tables = {circuit: table(circuit, marched, options.folder) for circuit in options.circuits}
    curves = {(circuit, kind): at for circuit, each in tables.items() for kind, at in each.items()}
    if options.roc:
        roc.drawn(curves, options.roc)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
