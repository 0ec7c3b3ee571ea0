"""Stress-rate and stress-jerk apart, from one output of ridge 3 in yamada-2002-slip, by amplifier.

`python -m bench.table_separation` prints the rms error over the rms of the truth, band-limited to
5 kHz: of the observer, as it comes and a few samples late, and of the crossover at 1.2 kHz, scaled as well as
can be, without noise and with it.
"""

from __future__ import annotations

import math

import numpy as np
from threadpoolctl import threadpool_limits

from skincad.circuit.calibrate import PAPER_CUTOFF
from skincad.circuit.low_pass import band_limited
from skincad.circuit.model import constants, load_circuit, noise_sources
from skincad.circuit.separate import crossover, separated, separator
from skincad.effects.piezo import Chain, fitted, strip_charges
from skincad.inputs.catalog import template_names
from skincad.scenes.levels import LEVELS
from skincad.scenes.scene import load_scene
from skincad.scenes.simulation import at_level

RIDGE, LATE = 3, 5  # samples


def error(found: np.ndarray, true: np.ndarray, late: int = 0) -> float:
    """Return the rms of the difference over that of the truth, `found` taken as `late` samples behind."""
    gap = found[late:] - true[: true.size - late]
    return float(np.sqrt(np.mean(gap**2) / np.mean(true**2)))


def scaled(found: np.ndarray, true: np.ndarray) -> float:
    """Return the error at the scale that makes it least."""
    return error(found * (found @ true) / (found @ found), true)


def main() -> None:
    """Print the table."""
    scene = load_scene("yamada-2002-slip")
    march = at_level(scene, LEVELS[1]).march
    time, width = march.time, scene.readout.bandwidth_Hz
    rate, stress = 1 / float(time[1]), march.column("films")
    print(
        f"{'amplifier':17} {'':9} {'SNR, dB':>8}   rate: observer, crossover   "
        "jerk: observer, late by, crossover"
    )
    for name in template_names("circuits"):
        circuit = fitted(load_circuit(name), scene.design)
        c, sources = constants(circuit), noise_sources(circuit)
        charges = strip_charges(circuit, scene.design, stress)
        charge = charges[:, 2 * RIDGE - 2] - charges[:, 2 * RIDGE - 1]
        true, chain = band_limited(time, charge, width), Chain.of(c, time, width)
        clean, size = chain.output(charge), math.sqrt(2) * chain.noise_rms(c, sources)
        observer = separator(c, rate, size, float(np.std(true.jerk)), width)
        noise = chain.noise(c, sources, 1) - chain.noise(c, sources, 2)
        for what, seen in (("noiseless", clean), ("noisy", clean + noise)):
            found, jerk, _ = separated(observer, seen)
            below, above = crossover(seen, rate, PAPER_CUTOFF)
            late = min(range(LATE), key=lambda k, j=jerk, t=true: error(j, t.jerk, k))
            print(
                f"{name:17} {what:9} {20 * math.log10(np.std(clean) / size):8.1f}   "
                f"{error(found, true.rate):14.3f} {scaled(below, true.rate):10.3f}   "
                f"{error(jerk, true.jerk):14.3f} {error(jerk, true.jerk, late):6.3f} ({late}) "
                f"{scaled(above, true.jerk):9.3f}"
            )


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
