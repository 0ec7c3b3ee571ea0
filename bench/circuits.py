"""Other readings of the paper's slopes, and what an amplifier buys of warning.

`python -m bench.circuits readings` fits each reading to 20 dB/dec up to 1.2 kHz and 60 above, from 10 Hz to
8 kHz, level free, and prints dB rms with its constants. By `film` the motional capacitance is at most 0.1 of
the static one, as PVDF has it; by `any` it is free.

`python -m bench.circuits amplifiers [SCENE ...]` marches each scene once and reads ridges 2 and 3, the
paper's, through each amplifier with NOISES noises. A charge amplifier and a follower give the stress, so
their samples are differenced. Lead: from the first true warning, `early`, to gross slip, without noise, then
with it the median and the least; `silent`: records without one; `false`: false warnings, without noise and in
a record's mean. S/N is of a pair as the detector gets it, rms. With `--slower` all takes so many times as
long: no effect of these scenes but the skin's mass knows how fast it goes.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from threadpoolctl import threadpool_limits

from skincad.circuit import (
    BOUNDS,
    FITTED,
    Circuit,
    Complex,
    Constants,
    Real,
    circuit_network,
    decibels,
    fitted,
    load_circuit,
)
from skincad.circuit.network import network
from skincad.circuit.response import response
from skincad.detector import EARLY, Detector, tuned
from skincad.effects import Chain, strip_charges
from skincad.inputs import Design
from skincad.scenes import LEVELS, NOT_AHEAD, load_scene, score, simulation
from tests.circuit.paper import paper_target, printed_response

STARTS, SEED, STEPS = 24, 2002, 300  # as the calibration's
# k33^2 / (1 - k33^2) of PVDF with k33 about 0.3, the highest that is reported: what a film's own motional
# branch can have beside its static capacitance (source: Kawai 1969 and later data sheets, 0.1 to 0.3)
FILM_RATIO = 0.1
FREQUENCY, WANTED = paper_target()
RIDGES = (2, 3)  # paper: strips in the second and third ridge from a side
NOISES = range(40)
BANDWIDTHS = (1000.0, 2500.0, 5000.0, 10_000.0, 20_000.0)
FAST = "amplifier.gain_bandwidth={:g}".format
FEEDBACK = "amplifier.feedback_resistance={:g}".format
HELD = "amplifier.feedback_capacitance={:g}".format
# label: template, settings, whether its samples are differenced
AMPLIFIERS: dict[str, tuple[str, tuple[str, ...], bool]] = {
    "yamada-2002-motional": ("yamada-2002-motional", (), False),
    "yamada-2002, 1 Mohm": ("yamada-2002", (), False),
    "the same, 1 MHz": ("yamada-2002", (FAST(1e6),), False),
    "transimpedance, 100 Mohm": ("transimpedance", (), False),
    "the same, 10 Mohm": ("transimpedance", (FEEDBACK(1e7),), False),
    "the same, 1 Gohm": ("transimpedance", (FEEDBACK(1e9),), False),
    "100 Mohm, 1 MHz": ("transimpedance", (FAST(1e6),), False),
    "100 Mohm, 1 MHz, 0.3 pF": ("transimpedance", (FAST(1e6), HELD(3e-13)), False),
    "100 Mohm, 10 MHz, 0.1 pF": ("transimpedance", (FAST(1e7), HELD(1e-13)), False),
    "100 Mohm, 100 nV": ("transimpedance", ("noise.voltage_density=100e-9",), False),
    "charge, differenced": ("charge-amplifier", (), True),
    "charge, 10 MHz": ("charge-amplifier", (FAST(1e7),), True),
    "follower, differenced": ("voltage-follower", (), True),
}
Ranges = dict[str, tuple[float, float]]


def free(ratio: float = math.inf) -> Ranges:
    """The network's constants, within the calibration's bounds, of at most a ratio of both capacitances."""
    low, high = BOUNDS["motional_capacitance"]
    return {name: BOUNDS[name] for name in FITTED} | {"motional_capacitance": (low, min(ratio, high))}


def solved(values: dict[str, float]) -> Complex:
    return response(network(made(values)), FREQUENCY)


def printed(values: dict[str, float]) -> Complex:
    return printed_response(made(values), FREQUENCY)


def refinement(values: dict[str, float]) -> Complex:
    """A film behind one resonance that passes the load, or the charge, on."""
    return rate() / pressed(values["resonance"], values["damping"])


def rigged(values: dict[str, float]) -> Complex:
    """A film under a probe whose sensor reads less, the indenter at 9 kHz before it."""
    sensor = pressed(values["resonance"], values["damping"])
    return rate() * sensor / pressed(9000.0, values["indenter"])


def made(values: dict[str, float]) -> Constants:
    """Constants of nearest values, the motional capacitance as a ratio."""
    whole = {**values, "motional_capacitance": values["motional_capacitance"] * values["capacitance"]}
    return Constants(d33=-33e-12, **whole)


def rate() -> Complex:
    return np.asarray(2j * np.pi * FREQUENCY)


def pressed(own: float, damping: float) -> Complex:
    """A mass on a damped spring, its load by that of the spring."""
    ratio = FREQUENCY / own
    return np.asarray(1 - ratio**2 + 2j * damping * ratio)


READINGS: dict[str, tuple[Callable[[dict[str, float]], Complex], Ranges]] = {
    "network, film": (solved, free(FILM_RATIO)),
    "network, any": (solved, free()),
    "closed form as printed, film": (printed, free(FILM_RATIO)),
    "closed form as printed, any": (printed, free()),
    "one resonance above 8 kHz": (refinement, {"resonance": (8100.0, 1e5), "damping": (1e-3, 5.0)}),
    "rig": (rigged, {"resonance": (300.0, 5000.0), "damping": (0.01, 5.0), "indenter": (0.3, 2.0)}),
    "rig, a sensor of metal alone": (
        rigged, {"resonance": (300.0, 5000.0), "damping": (0.01, 0.05), "indenter": (0.3, 2.0)},
    ),
}  # fmt: skip


def nearest(way: Callable[[dict[str, float]], Complex], ranges: Ranges) -> tuple[float, dict[str, float]]:
    """Return the least distance, dB rms, and its values: logarithms, from STARTS points drawn evenly."""
    low, high = np.log(list(ranges.values())).T

    def values(point: Real) -> dict[str, float]:
        return dict(zip(ranges, np.exp(point).tolist(), strict=True))

    def misfit(point: Real) -> Real:
        rest = decibels(way(values(point))) - WANTED
        return np.asarray(rest - rest.mean())

    draw = np.random.default_rng(SEED)
    runs = [
        least_squares(
            misfit, draw.uniform(low, high), bounds=(low, high), x_scale="jac", max_nfev=STEPS, diff_step=1e-6
        )
        for _ in range(STARTS)
    ]
    best = min(runs, key=lambda run: run.cost)
    return float(np.std(best.fun)), values(best.x)


def readings() -> None:
    for name, (way, ranges) in READINGS.items():
        rms, found = nearest(way, ranges)
        print(
            f"{name:30} {rms:6.2f} dB rms: " + ", ".join(f"{k} {v:.3g}" for k, v in found.items()), flush=True
        )


@dataclass(frozen=True, eq=False)
class SceneRun:
    """What one march leaves to read: stresses, truth, time; since when a slip is `begun` that lasts."""

    name: str
    design: Design
    time: np.ndarray
    stress: np.ndarray
    runs: list[list[list[int]]]
    gross: int | None
    begun: int | None


def marched(name: str) -> SceneRun:
    scene = load_scene(name, [f"readout.ridges={list(RIDGES)}"])
    answer = simulation.at_level(scene, LEVELS[1])
    runs = [answer.runs[r - 1] for r in RIDGES]
    march = answer.march
    gross = answer.gross_slip_step
    begun = min((a for ridge in answer.runs for a, b in ridge if gross and a <= gross <= b), default=None)
    return SceneRun(name, scene.design, march.time, march.column("films"), runs, gross, begun)


def differenced(outputs: np.ndarray, time: np.ndarray) -> np.ndarray:
    """The rate of outputs `(n, ...)` by the sample before: nothing looks ahead."""
    return np.diff(outputs, axis=0, prepend=outputs[:1]) / float(time[1])


def line(found: SceneRun, circuit: Circuit, rate: bool, bandwidth: float) -> str:
    """Read one amplifier at one bandwidth."""
    own = fitted(circuit, found.design)
    chain = Chain.of(circuit_network(own), found.time, bandwidth)
    charges = strip_charges(own, found.design, found.stress)
    strips = [[chain.output(charges[:, 2 * (r - 1) + side]) for side in (0, 1)] for r in RIDGES]
    clean = np.moveaxis(np.array(strips), 2, 0)
    shape = (len(RIDGES), 2)
    noises = []
    for seed in NOISES:
        drawn = np.array([chain.noise((seed, ridge, side)) for ridge, side in np.ndindex(shape)])
        noises.append(np.moveaxis(drawn.reshape(*shape, -1), 2, 0))
    if rate:
        clean = differenced(clean, found.time)
        noises = [differenced(each, found.time) for each in noises]
    pair = math.sqrt(2) * float(np.std([each[1:] for each in noises]))
    frequency = 1 / float(found.time[1])
    tuning = tuned(frequency, bandwidth, pair, EARLY)
    leads, false = list[float](), list[int]()
    for noise in [np.zeros_like(clean), *noises]:
        events = Detector.of(tuning, RIDGES, frequency).feed((clean + noise).reshape(clean.shape[0], -1))
        runs = dict(zip(RIDGES, found.runs, strict=True))
        scored = score(tuning.window, events, found.time, runs, found.gross, found.begun)
        leads.append(math.nan if scored.gross_lead is None else 1e3 * scored.gross_lead)
        false.append(scored.reasons.count(NOT_AHEAD))
    signal = float(np.std(clean[..., 0] - clean[..., 1]))
    silent = sum(math.isnan(lead) for lead in leads[1:])
    rows = [lead for lead in leads[1:] if not math.isnan(lead)]
    noisy = f"{np.median(rows):9.4g} ({min(rows):.4g})" if rows else f"{'-':>9} (-)"
    return (
        f"{bandwidth:7.5g} {20 * math.log10(signal / pair):7.1f} {leads[0]:10.4g} {false[0]:5d}"
        f" {noisy:18} {silent:6d} {np.mean(false[1:]):6.2f}"
    )


def amplifiers(scenes: Sequence[str], bandwidths: Sequence[float], slower: float) -> None:
    for name in scenes:
        found = marched(name)
        found = replace(found, time=slower * found.time)
        print(f"{name}: gross slip at step {found.gross}, steps of {1e6 * found.time[1]:.3g} us")
        print(f"{'amplifier':26} {'-3 dB':>7} {'S/N, dB':>7} {'lead, ms':>10} {'false':>5}"
              f" {'noisy':>9} (least)  {'silent':>6} {'false':>6}")  # fmt: skip
        for label, (template, settings, rate) in AMPLIFIERS.items():
            circuit = load_circuit(template, list(settings))
            for bandwidth in bandwidths:
                print(f"{label:26} {line(found, circuit, rate, bandwidth / slower)}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=("readings", "amplifiers"))
    parser.add_argument("scenes", nargs="*", default=["steady-pull", "yamada-2002-slip"], metavar="SCENE")
    parser.add_argument("--bandwidth", type=float, nargs="*", default=BANDWIDTHS, metavar="HZ")
    parser.add_argument("--slower", type=float, default=1.0, help="times; bandwidths are lower by as much")
    options = parser.parse_args()
    if options.kind == "readings":
        readings()
    else:
        amplifiers(options.scenes, options.bandwidth, options.slower)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
