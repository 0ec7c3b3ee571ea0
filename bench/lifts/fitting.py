"""Fit the detector's network for a gripper: `python -m bench.lifts.fitting FOLDER` (lifts are kept there).

COUNT even seeds' lifts are marched with raises of the grip that hear nothing: at drawn times, and in SAVED of
them also some time after more grip is needed, so that many hold and the network knows what a raise feels
like. A first network is fitted to them. LOOPED other even seeds' lifts are marched with the policy's raises
by that network, and the last one is fitted to all: what runs in a closed loop is in the fit.

A lift is heard behind the AMPLIFIERS, with all ridges wired and with some, at 1 to 10 times the noise; where
the output is the stress, by its differences from sample to sample. A sample's label is whether more grip is
needed: the load within AHEAD exceeds NEAR of what friction bears at the present grip, or the object slides.
The shipped weights were fitted so, but for the policy's constants, which were set after them.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from bench import runner
from bench.exam.fitting import odds, written
from bench.exam.network import Samples, fitted
from bench.lifts.scenes import AMPLIFIERS, BAND, RATE, Lift, circuit, drawn, finger
from skincad.detector import GRIP, GRIPPER, Weights, change_noise, detector, features, tuned
from skincad.mechanics import ContactError
from skincad.scenes.grip import Force, followed
from skincad.scenes.lift import Ears, LiftRun, carried

COUNT, LOOPED, LATER = 240, 210, 600  # lifts; the first seed of those in a closed loop
HIDDEN = 24  # units: six at a time, as the code in C has them
AHEAD = 0.06  # s
NEAR = 0.9  # of what friction bears
THIN = 8  # every so manyth sample
FOLDS = 4
OFTEN = 2.5  # raises a second at drawn times
HARDER = 1.1, 1.8  # times, a raise
LATE = 0.0, 0.08  # s after more grip is needed
SAVED = 0.6  # share of lifts
SOON = 0.03, 0.15  # s to another raise where it is still needed
TWICE = 2.0  # the weight of lifts in a closed loop
NEEDED = 3.0  # times the weight of a sample at which more grip is needed for less than SHORT
SHORT = 0.04  # s
LOUDER = 1.0, 1.0, 1.0, 3.0, 10.0


@dataclass(frozen=True, eq=False)
class Marched:
    """A march that a file keeps: forces N `(n,)`, the films' stresses MPa `(n, strips, 3)`, which samples
    slide, from which on the fingers have closed."""

    seed: int
    grip: np.ndarray
    load: np.ndarray
    films: np.ndarray
    slides: np.ndarray
    closed: int


class Planned(Force):
    """A policy of planned forces, N `(n,)`."""

    def __init__(self, force: np.ndarray) -> None:
        self.needed, self.count, self.alarms = force, 0, []


def planned(one: Lift) -> np.ndarray:
    """Return raises of the grip at each sample, N: at drawn times, and some time after they are needed."""
    draw, grip = np.random.default_rng((62, one.seed)), one.scene.grip
    assert grip is not None
    time, load = grip.points
    count = int(np.ceil(time[-1] * RATE)) + 2
    at = np.arange(count) / RATE
    needed = soonest(np.interp(at, time, load)) / (NEAR * one.friction)
    saved, late = draw.random() < SAVED, float(draw.uniform(*LATE))
    closed, delay = int(np.ceil((grip.close or 0.0) * RATE)), int(np.ceil((grip.delay or 0.0) * RATE))
    wanted, force, after = np.full(count, grip.force), np.full(count, grip.force), np.inf
    for i in range(closed, count):
        wanted[i] = wanted[i - 1]
        force[i] = followed(grip, wanted[i - delay : i - delay + 1], force[i - 1], 1 / RATE)[0]
        need = needed[i] > force[i]
        if not need:
            after = np.inf
        elif not np.isfinite(after):
            after = i + late * RATE
        if draw.random() < OFTEN / RATE or (saved and need and i >= after):
            wanted[i] *= draw.uniform(*HARDER)
            after = i + draw.uniform(*SOON) * RATE
    return wanted


def soonest(load: np.ndarray) -> np.ndarray:
    """Return the largest load within AHEAD of each sample."""
    n = round(AHEAD * RATE)
    views = np.lib.stride_tricks.sliding_window_view(np.pad(load, (0, n), mode="edge"), n + 1)
    return np.asarray(views.max(axis=-1))


def kept(seed: int, folder: Path, *, hears: bool = False) -> Marched | None:
    """Return the march of a seed from disk, marched if it is not there, with planned raises or those of the
    policy that `hears`; None where none converges."""

    def make() -> Marched | None:
        one = drawn(seed)
        scene = one.scene.with_(grip={"policy": "detector"}) if hears else one.scene
        policy = None if hears else Planned(planned(one))
        try:
            return of_run(one, carried(scene, finger(one), rate=RATE, seed=seed, policy=policy))
        except ContactError:
            return None

    return runner.kept(folder / f"{seed}.pkl", make)


def of_run(one: Lift, run: LiftRun) -> Marched:
    """Return what is kept of a lift."""
    grip = one.scene.grip
    assert grip is not None
    closed = int(np.ceil(grip.close * RATE))
    return Marched(one.seed, run.grip, run.load, run.films.astype(np.float32), run.slides, closed)


@dataclass(frozen=True, eq=False)
class Heard:
    """A march as the detector hears it: features `(n, ridges, features)` and loudness `(n, ridges)` of every
    THINth sample since the fingers closed, whether more grip is needed there, and weights."""

    seed: int
    amplifier: str
    felt: np.ndarray
    loud: np.ndarray
    needed: np.ndarray
    weight: np.ndarray


def heard(march: Marched, amplifier: str, ridges: list[int], louder: float, seed: int) -> Heard:
    """Return what is heard of a march behind an amplifier."""
    one = drawn(march.seed)
    scene = one.scene.with_(
        effects={"piezo": {"circuit": circuit(amplifier), "sampling_Hz": RATE}}, readout={"ridges": ridges}
    )
    ears = Ears(scene, scene.parts["piezo"], RATE, march.grip.size, 1.0)
    ears.make_noise(ridges, seed)
    ears.noise *= louder
    outputs = ears.outputs(march.films.astype(float))
    noise = np.sqrt(2) * ears.chain.noise_rms() * louder
    change = change_noise(GRIP, ears.chain.network, ears.chain.bandwidth, RATE)
    if change is not None:
        outputs, noise = np.diff(outputs, axis=0, prepend=outputs[:1]), change * louder
    window = tuned(RATE, BAND, noise).window
    phase = march.closed + march.seed // 2 % THIN
    rows = slice(phase, None, THIN)
    felt, loud, _ = features.features(window, noise, outputs, features.at_rest(len(ridges)), rows)
    needed = needs(march, one.friction)
    weight = np.where(needed & ~_long(needed), NEEDED, 1.0)
    return Heard(march.seed, amplifier, felt.astype(np.float32), loud, needed[rows], weight[rows])


def needs(march: Marched, friction: float) -> np.ndarray:
    """Return when more grip is needed `(n,)`."""
    return np.asarray((soonest(march.load) > NEAR * friction * march.grip) | march.slides)


def _long(needed: np.ndarray) -> np.ndarray:
    """Return where it has been needed for longer than SHORT."""
    n = round(SHORT * RATE)
    views = np.lib.stride_tricks.sliding_window_view(np.pad(needed, (n, 0)), n + 1)
    return np.asarray(views.all(axis=-1))


def variants(march: Marched) -> Iterator[Heard]:
    """Yield what is heard of a march: behind each amplifier, all ridges wired and some of them."""
    draw = np.random.default_rng((63, march.seed))
    count = march.films.shape[1] // 2
    for amplifier in AMPLIFIERS:
        yield heard(march, amplifier, list(range(1, count + 1)), float(draw.choice(LOUDER)), 1)
        some = np.sort(draw.permutation(count)[: draw.integers(1, 5)]) + 1
        yield heard(march, amplifier, some.tolist(), float(draw.choice(LOUDER)), 2)


def samples(some: list[Heard]) -> list[Samples]:
    """Return the samples to fit to."""
    return [(h.felt, h.needed, h.weight * (TWICE if h.seed >= LATER else 1.0)) for h in some]


def score(w: Weights, some: list[Heard]) -> dict[str, float]:
    """Return by amplifier the area under the curve of true over false, of samples."""
    answer = {}
    for amplifier in AMPLIFIERS:
        mine = [h for h in some if h.amplifier == amplifier]
        values = np.concatenate([odds(w, h.felt).mean(axis=1) for h in mine])
        truth = np.concatenate([h.needed for h in mine])
        order = np.argsort(values)
        ranks = np.empty(values.size)
        ranks[order] = np.arange(1, values.size + 1)
        yes = int(truth.sum())
        area = (ranks[truth].sum() - yes * (yes + 1) / 2) / (yes * (truth.size - yes))
        answer[amplifier] = round(float(area), 3)
    return answer


def ship(some: list[Heard]) -> None:
    """Fit the network and write its file."""
    text = written(fitted(samples(some), 0, HIDDEN), "a grip that is too weak", "bench/lifts/fitting.py")
    (Path(detector.__file__).parent / GRIPPER).write_text(text)
    detector.weights.cache_clear()


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("folder", type=Path)
    folder = options.parse_args().folder
    marches = [m for seed in range(0, 2 * COUNT, 2) if (m := kept(seed, folder / "planned"))]
    every = [list(variants(m)) for m in marches]
    print(len(every), "lifts", flush=True)
    ship([h for t in every for h in t])
    seeds = range(LATER, LATER + 2 * LOOPED, 2)
    looped = [m for seed in seeds if (m := kept(seed, folder / "looped", hears=True))]
    every += [list(variants(m)) for m in looped]
    print(len(every), "with those in a closed loop", flush=True)
    for fold in range(FOLDS):
        mine = [h for i, t in enumerate(every) if i % FOLDS != fold for h in t]
        others = [h for t in every[fold::FOLDS] for h in t]
        network = fitted(samples(mine), fold, HIDDEN)
        print(fold, score(network, others), "fitted to", score(network, mine), flush=True)
    ship([h for t in every for h in t])


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
