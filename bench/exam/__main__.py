"""The slip detector's exam: scenes that it was not fitted to, by amplifier, noise and number of ridges.

`python -m bench.exam [FOLDER] [CIRCUIT ...]` (default out/exam, all CIRCUITS) marches the exam set (half an
hour on two cores; what is in FOLDER is not marched again). It prints for each amplifier and number of
monitored ridges, over SEEDS of noise: gross slips warned of, lead, and true and false warnings by kind, with
95 % intervals; the same by known slips and forces, which tell what information is missing; what it confuses
by kind of history; alarms of minutes of holding; and the bound of what any detector can warn of.

The bound is what noise and delay leave of a slip's signal. Each scene that slips as a whole has a twin with
the same history whose friction of STICKS holds it. A detector that knew both signals could do no better than
the matched filter: its distance d is the root of the sum of the difference's power over the noise's (Van
Trees, Detection, Estimation, and Modulation Theory I, sec. 4.2). With FALSE false alarms a minute and one
decision a window it warns in a share Phi(d - z) of the noises.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.signal import lfilter
from scipy.special import ndtr, ndtri
from threadpoolctl import threadpool_limits

from bench import runner
from bench.exam import scoring
from bench.exam.scenes import EXAM, SceneRun, drawn, kept, marched, seeds
from bench.exam.scoring import HEAD, Alarm, Case, Mark, case, line, mark, rate
from skincad.circuit import circuit_network, corner, fitted, load_circuit, total_density
from skincad.detector import AHEAD, BACK, EARLY, INCIPIENT, POINTS, SEEN, SURE, Detector, Tuning, taken, tuned
from skincad.inputs import load_design

CIRCUITS = ("transimpedance", "yamada-2002")
SEEDS = (1, 2, 3)  # of the noise
RIDGES = (1, 3, None)  # monitored; None: all
FEWEST = 100  # steps of a scene that was marched far enough
BOUNDED = 4  # every so manyth gross slip has its twin marched
MINUTES = 40  # of holding: with none in 37, less than 0.1 a minute at 95 %
RATE, BAND = 1e5, 5e3  # Hz, of holding; the fastest of the exam has the most decisions a minute
BLOCK = 1 << 20  # samples
LEVELS = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0)
STICKS = 3.0
ASKED = (0.25, 0.5, 1.0)  # windows between two askings of the networks, as a small processor can
FALSE = 0.1  # a minute

Find = Callable[[Case, int, int], list[Alarm]]  # of a case, its window and the noise's seed


def ear(one: Case, alarms: str = SURE) -> Tuning:
    """Return the detector's tuning to a case's rate, band and noise."""
    return tuned(one.rate, one.scene.bandwidth, math.sqrt(2) * one.noise, alarms)


def new(one: Case, tuning: Tuning) -> Detector:
    """Return the detector of a case, its ridges from 0."""
    return Detector.of(tuning, range(one.outputs.shape[1]), one.rate)


def found(one: Case, seed: int, alarms: str, kind: str, share: float = 0.0) -> list[Alarm]:
    """Return the detector's alarms of a kind; its networks are asked once in a `share` of a window, or (0) at
    each sample."""
    outputs, tuning = one.outputs + one.noises(seed), ear(one, alarms)
    tuning = replace(tuning, every=max(1, round(share * tuning.window)))
    events = new(one, tuning).feed(outputs.reshape(outputs.shape[0], -1))
    return [(e.ridge, e.index) for e in events if e.kind == kind]


def warnings(kind: str, share: float = 0.0) -> Find:
    """Return what finds warnings of gross slip, of a kind of POINTS, asked as `found`."""
    return lambda one, _, seed: found(one, seed, kind, AHEAD, share)


def marks(told: list[Case], find: Find, noises: tuple[int, ...] = SEEDS[:1]) -> list[Mark]:
    """Return what alarms are worth in cases, each with noise of these seeds."""
    windows = [ear(one).window for one in told]
    return [mark(one, find(one, w, seed), w) for seed in noises for one, w in zip(told, windows, strict=True)]


def some(scene: SceneRun, count: int | None) -> tuple[int, ...]:
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
    window, draw = tuned(RATE, BAND, rms).window, np.random.default_rng(8)
    share, times, most = 1 / (1 + window), 0, 0.0
    for _ in range(math.ceil(2 * MINUTES * 60 * RATE / BLOCK)):
        parts = draw.standard_normal((2, size.size)) * size * (BLOCK / 2)
        pair = np.fft.irfft(parts[0] + 1j * parts[1], BLOCK)
        loud = np.sqrt(lfilter([share], [1, share - 1], pair**2)) / rms
        times += int(np.sum((loud[1:] > SEEN) & (loud[:-1] <= SEEN)))
        most = max(most, float(loud.max()))
    return times, most


def table(circuit: str, scenes: list[SceneRun], folder: Path) -> None:
    every = [case(scene, circuit, folder / "outputs") for scene in scenes]
    print(f"\n{circuit}\n{HEAD}")
    for count in RIDGES:
        told, name = [one.told(some(one.scene, count)) for one in every], f"{count or 'all'} told"
        for kind in POINTS:
            print(line(f"{name}: {kind}", marks(told, warnings(kind), SEEDS)), flush=True)
        named = marks(told, lambda one, _, seed: found(one, seed, SURE, INCIPIENT))
        print(line(f"{name}: sure, by ridge", named), flush=True)
        print(line(f"{name}: rate's threshold", marks(told, _by_rate)), flush=True)
        print(line(f"{name}: its slips known", marks(told, lambda one, *_: scoring.slips(one))), flush=True)
    for share in ASKED:
        for kind in POINTS:
            seldom = marks(every, warnings(kind, share), SEEDS)
            print(line(f"all told: {kind}, asked once in {share:g} windows", seldom), flush=True)
    for near in (0.9, 0.95):
        known = marks(every, lambda one, _, __, near=near: scoring.cone(one, near))
        print(line(f"forces and friction known, {near:g}", known))
    print(line("always", marks(every, lambda one, w, _: scoring.always(one, w))))
    traded(every)
    confused(every)
    times, most = held(circuit)
    minute, low, high = rate(times, MINUTES)
    print(f"holding: {minute:.3g} ({low:.2g}-{high:.2g}) a minute, loudest {most:.2f} of {SEEN:g} noise rms")
    slips = [one for one in [one for one in every if one.gross is not None][::BOUNDED] if not one.scene.mass]
    for count in RIDGES:
        can = [
            bound(one.scene.seed, circuit, folder, ear(one).window / one.rate, some(one.scene, count))
            for one in slips
        ]
        sure = [share for share in can if share is not None]
        share = f"{100 * np.mean(sure):.1f} % of {len(sure)} gross slips with a twin"
        print(f"bound, {count or 'all'} told: {share}")


def _by_rate(one: Case, window: int, seed: int) -> list[Alarm]:
    return scoring.threshold(one, window, one.outputs + one.noises(seed))


def traded(every: list[Case]) -> None:
    """Print what warnings by other thresholds are worth, all ridges told."""
    table: dict[float, list[Mark]] = {level: [] for level in LEVELS}
    for one in every:
        d, outputs = ear(one), one.outputs + one.noises(SEEDS[0])
        odds = new(one, d).odds(outputs.reshape(outputs.shape[0], -1))[:, -1:]
        for level, each in table.items():
            now = taken(np.zeros(1, bool), odds, level, BACK)[:, 0]
            rises = np.flatnonzero(now & ~np.concatenate([[False], now[:-1]]))
            each.append(mark(one, [(None, int(i)) for i in rises], d.window))
    for level, each in table.items():
        print(line(f"all told: threshold {level:g}", each), flush=True)


def confused(every: list[Case]) -> None:
    """Print by how a scene ends how many are warned of, and how many falsely, all ridges told."""
    for kind in (SURE, EARLY):
        each = marks(every, warnings(kind), SEEDS)
        ends = [one.scene.phases[-1][0] for one in every] * len(SEEDS)
        slips, warned = Counter[str](), Counter[str]()
        count, false = Counter[str](), Counter[str]()
        for end, m in zip(ends, each, strict=True):
            count[end], false[end] = count[end] + 1, false[end] + (m.false > 0)
            slips[end], warned[end] = slips[end] + m.slips, warned[end] + m.warned
        for end in sorted(count):
            told = f"{warned[end]:4} of {slips[end]:4} slips warned of"
            print(f"{kind}, {end:14} {told}, {false[end]:4} of {count[end]:4} scenes falsely")
        hit, held_still = (sum(m.warned for m in each), sum(not m.slips and not m.false for m in each))
        missed, alarmed = (
            sum(m.slips and not m.warned for m in each), sum(not m.slips and m.false > 0 for m in each)
        )  # fmt: skip
        others = f"others {held_still} without alarm, {alarmed} with"
        print(f"{kind}: slips {hit} warned of, {missed} missed; {others}")


def twin(seed: int, folder: Path) -> SceneRun | None:
    """Return the march of a seed that sticks, kept on disk, None where it leaves the model's range first."""

    def stuck() -> np.ndarray:
        one = drawn(seed)
        friction = {**one.scene.effects["friction"], "coefficient": STICKS}
        return marched(replace(one, scene=one.scene.with_(effects={"friction": friction}))).stress

    answer, stress = kept(seed, folder), runner.kept(folder / f"{seed}-sticks.pkl", stuck)
    if answer.gross is None or stress.shape[0] <= answer.gross:
        return None
    return replace(answer, stress=stress[: answer.time.size])


def distance(one: Case, other: Case) -> float:
    """Return the matched filter's d between two cases, before the last sample, of all told strips."""
    difference = (one.outputs - other.outputs)[:-1].reshape(one.outputs.shape[0] - 1, -1)
    size = 2 * (one.density.size - 1)
    period = np.fft.irfft(one.density**2, size)[:: one.fine] * size
    covariance = 4 * period[: difference.shape[0]] / size**2 / 2
    return float(np.sqrt(max(0.0, _power(covariance, difference))))


def _power(covariance: np.ndarray, signal: np.ndarray) -> float:
    """Return the sum of s' C^-1 s over columns, C the Toeplitz matrix of `covariance`, a little louder so
    that rounding cannot make noise-free directions of it."""
    from scipy.linalg import cho_factor, cho_solve, toeplitz

    whole = toeplitz(covariance) + 1e-6 * covariance[0] * np.eye(covariance.size)
    return float(np.sum(signal * cho_solve(cho_factor(whole), signal)))


def warned_share(d: float, window: float) -> float:
    """Return the largest share of noises in which one may warn, FALSE a minute, `window` s a decision."""
    return float(ndtr(d + ndtri(FALSE / 60 * window)))


def bound(seed: int, circuit: str, folder: Path, window: float, told: tuple[int, ...]) -> float | None:
    """Return that share of a seed that slips behind a circuit, of some told ridges; None without a twin."""
    scene, sticks = kept(seed, folder / "scenes"), twin(seed, folder / "scenes")
    if sticks is None:
        return None
    outputs = folder / "outputs"
    one = case(scene, circuit, outputs).told(told)
    return warned_share(distance(one, case(sticks, circuit, outputs / "sticks").told(told)), window)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("out/exam"))
    parser.add_argument("circuits", nargs="*", default=list(CIRCUITS), metavar="CIRCUIT")
    options = parser.parse_args()
    marched = [kept(seed, options.folder / "scenes") for seed in seeds(EXAM)]
    marched = [scene for scene in marched if scene.time.size > FEWEST]
    minutes = sum(float(scene.time[-1]) for scene in marched) / 60
    slips = sum(scene.gross is not None for scene in marched)
    drawn = f"odd seeds {seeds(EXAM)[0]} to {seeds(EXAM)[-1]}"
    print(f"{drawn}: {len(marched)} scenes, {slips} slip, {minutes:.2f} min")
    for circuit in options.circuits:
        table(circuit, marched, options.folder)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
