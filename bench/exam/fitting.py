"""Fit the detector to the design set: `python -m bench.exam.fitting FOLDER` (scenes kept there).

Each design scene is heard three ways behind the transimpedance amplifier: as drawn; with all its ridges told
and with one to three, at 0.2 to 5 times its speed, in another band, with 1 to 30 times the noise; and once
behind another amplifier, up to 30 times slower, differenced where that tells the stress. A ridge's label is
whether it slips, the low-pass's delay later; while slip lasts on to gross slip, those that still stick count
as slipping too, at a lower weight. The skin's label is whether a slip is on that lasts to gross slip. A short
gross slip counts as much as one of EVENT windows. Scenes that ship are in the set, and records of ridges that
all stick: two loads that run and stop, jump and turn, as abruptly as no scene. It writes both networks'
files, and prints what threefold cross-validation by scene makes of thresholds: POINTS of detector.py.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from bench.exam.network import Samples, fitted
from bench.exam.scenes import DESIGN, SceneRun, kept, seeds, shipped
from bench.exam.scoring import HEAD, Alarm, Case, case, lasting, line, mark, near
from skincad.circuit import band_limited, delay
from skincad.detector import RIDGES, SEEN, SKIN, Weights, detector, features, taken, tuned

CIRCUIT = "transimpedance"
OTHERS = {"yamada-2002": False, "charge-amplifier": True, "voltage-follower": True}  # differenced or not
THIN = 6  # every so manyth sample
FOLDS = 3
# of a sample: nothing slips, another ridge does, this one does, this one until all do, another until all do
WEIGHT = np.array([1.0, 0.3, 0.7, 4.0, 0.7])
EDGE = 0.2  # times that within a window of a slip's edge
OWN = 6.0  # times that in scenes that ship
STICKING = 1.0  # that of a sample of `sticking`
AHEAD = 3.0  # that of a moment at which gross slip is ahead, among the skin's
EVENT = 2.0  # windows of a ridge's lasting detector, that a gross slip's samples weigh at least, together
MOST = 8.0  # times their weight, for that
FEWEST = 100  # steps of a scene that was marched far enough
LOAD_RATE, LOAD_BAND = 1e5, 5e3  # Hz
LOAD_STEPS, LOADS = 600, 60
MOST_RIDGES = 5  # ridges, two at least


@dataclass(frozen=True, eq=False)
class Heard:
    """A case with noise: features `(n, ridges, features)`, how loud its pairs are, each sample's class and
    weight `(n, ridges)`, and since when gross slip is ahead `(n,)`."""

    case: Case
    window: int
    felt: np.ndarray
    loud: np.ndarray
    kind: np.ndarray
    weight: np.ndarray
    ahead: np.ndarray


def heard(one: Case, louder: float, seed: int) -> Heard:
    """Return a case as the detector hears it with `louder` times its noise."""
    noise = math.sqrt(2) * one.noise * louder
    d = tuned(one.rate, one.scene.bandwidth, noise)
    outputs = one.outputs + louder * one.noises(seed)
    felt, loud, _ = features.features(d.window, noise, outputs, features.at_rest(outputs.shape[1]))
    kind, edge = classes(one, d.window)
    weight = WEIGHT[kind] * np.where(edge, EDGE, 1.0) / math.sqrt(kind.shape[1])
    weight *= OWN if one.scene.seed < 0 else 1.0
    weight = as_events(one, d.window, kind, weight)
    return Heard(one, d.window, felt.astype(np.float32), loud, kind, weight, ahead(one))


def ahead(one: Case) -> np.ndarray:
    """Return since when gross slip is ahead `(n,)`: since the first slip that lasts until then, and the
    low-pass's delay."""
    late, end = max(1, round(delay(one.scene.bandwidth) * one.rate)), one.outputs.shape[0]
    begun = [a for a in lasting(one.scene.slipping[:end], one.gross) if a is not None]
    return np.arange(end) >= (min(begun) + late if begun else end)


def as_events(one: Case, window: int, kind: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return samples' weights, with a short gross slip's raised to those of EVENT windows."""
    if one.gross is None:
        return weight
    whole = one.scene.slipping[: one.outputs.shape[0]]
    start = min(a for a in lasting(whole, one.gross) if a is not None)
    told = kind >= 2
    told[: max(0, start - window)] = False
    now = float(weight[told].sum())
    wanted = EVENT * window * float(WEIGHT[3])
    return np.where(told, weight * min(MOST, max(1.0, wanted / now)), weight) if now > 0 else weight


def classes(one: Case, window: int) -> tuple[np.ndarray, np.ndarray]:
    """Return each sample's class, as WEIGHT has them, and whether it is by an edge of its ridge's slip."""
    late = max(1, round(delay(one.scene.bandwidth) * one.rate))
    whole = one.scene.slipping[: one.outputs.shape[0]]
    own, skin = _later(one.slipping, late), _later(whole, late).any(axis=1)
    kind = np.where(own, 2, np.where(skin[:, None], 1, 0))
    gross = one.gross
    if gross is not None:
        begun = min(a for a in lasting(whole, gross) if a is not None)
        last = kind[begun + late : gross + 1]
        last[last == 1] = 4
        for r, a in enumerate(lasting(one.slipping, gross)):
            if a is not None:
                kind[a + late : gross + 1, r] = 3
    return kind, near(one.slipping, window) & ~own & (kind != 4)


def _later(what: np.ndarray, samples: int) -> np.ndarray:
    return np.concatenate([np.zeros_like(what[:samples]), what[:-samples]])


def variants(scene: SceneRun, folder: Path) -> Iterator[Heard]:
    """Yield what is heard of a scene: as drawn first."""
    draw = np.random.default_rng((5, abs(scene.seed)))
    first = case(scene, CIRCUIT, folder)
    yield heard(first.told(scene.told), 1.0, 1)
    faster = replace(scene, time=scene.time * 10 ** draw.uniform(-0.7, 0.7))
    band = np.exp(draw.uniform(np.log(0.05), np.log(0.4))) / faster.time[1]
    other = case(replace(faster, bandwidth=float(band)), CIRCUIT, folder / "faster")
    ridges = other.outputs.shape[1]
    few = np.sort(draw.permutation(ridges)[: draw.integers(1, 4)]) + 1
    for told in (tuple(range(1, min(ridges, 9) + 1)), tuple(few.tolist())):
        yield heard(other.told(told), float(draw.choice([1, 1, 10, 30])), 2)
    circuit = str(draw.choice(list(OTHERS)))
    slower = replace(scene, time=scene.time * 10 ** draw.uniform(-0.5, 1.5))
    band = np.exp(draw.uniform(np.log(0.05), np.log(0.4))) / slower.time[1]
    last = case(replace(slower, bandwidth=float(band)), circuit, folder / "slower")
    last = last.differenced() if OTHERS[circuit] else last
    some = np.sort(draw.permutation(ridges)[: draw.integers(1, 10)]) + 1
    yield heard(last.told(tuple(some.tolist())), 1.0, 3)


def of_ridges(told: list[Heard]) -> list[Samples]:
    """Return each ridge's samples of what is heard, and of records of ridges that all stick."""
    parts = []
    for h in told:
        felt = h.felt[::THIN].reshape(-1, 1, h.felt.shape[2])
        parts.append((felt, h.kind[::THIN].ravel() >= 2, h.weight[::THIN].ravel()))
    for felt in _sticking():
        count = felt.shape[0] * felt.shape[1]
        flat = felt.reshape(count, 1, felt.shape[2])
        parts.append((flat, np.zeros(count, bool), np.full(count, STICKING)))
    return parts


def of_skins(told: list[Heard]) -> list[Samples]:
    """Return the samples of all told ridges together, with records of ridges that all stick."""
    parts = []
    for h in told:
        coming = h.ahead[::THIN]
        few = EVENT * h.window / THIN / max(1, int(coming.sum()))
        parts.append((h.felt[::THIN], coming, np.where(coming, AHEAD * np.clip(few, 1.0, MOST), 1.0)))
    for felt in _sticking():
        parts.append((felt, np.zeros(felt.shape[0], bool), np.full(felt.shape[0], STICKING)))
    return parts


def _sticking() -> Iterator[np.ndarray]:
    for outputs, noise in sticking():
        window = tuned(LOAD_RATE, LOAD_BAND, noise).window
        felt = features.features(window, noise, outputs, features.at_rest(outputs.shape[1]))[0]
        yield felt[::THIN].astype(np.float32)


def odds(w: Weights, felt: np.ndarray) -> np.ndarray:
    """Return the logarithm of the odds `(n, ridges)` of features."""
    return np.asarray(np.tanh(felt @ w.into + w.bias) @ w.out + w.base)


def written(w: Weights, what: str, by: str = "bench/exam/fitting.py") -> str:
    """Return the weights as TOML, four digits of each, with what they are for and what fitted them."""
    rows = ",\n".join("    [" + ", ".join(f"{v:.4g}" for v in column) + "]" for column in w.into.T)
    bias, out = (", ".join(f"{v:.4g}" for v in row) for row in (w.bias, w.out))
    return (
        f"# The slip detector's network for {what}, by {by}; into: a row a hidden unit,\n"
        "# its columns the features of skincad/detector/features.py in their order\n"
        f"base = {w.base:.4g}\nbias = [{bias}]\nout = [{out}]\ninto = [\n{rows},\n]\n"
    )


def validated(told: list[list[Heard]]) -> None:
    """Print what thresholds make of scenes that the networks were not fitted to, where the outputs are loud:
    of each scene as drawn, and with all of its ridges told at another speed."""
    unseen: list[list[tuple[Heard, np.ndarray, np.ndarray]]] = [[], []]
    for fold in range(FOLDS):
        mine = [t for i, t in enumerate(told) if i % FOLDS != fold or t[0].case.scene.seed < 0]
        heard_of = [h for t in mine for h in t]
        ridges, skin = fitted(of_ridges(heard_of), fold), fitted(of_skins(heard_of), fold)
        for t in (t for i, t in enumerate(told) if i % FOLDS == fold and t[0].case.scene.seed >= 0):
            for way in (0, 1):
                loud = t[way].loud > SEEN
                each = np.where(loud, odds(ridges, t[way].felt), -np.inf)
                whole = np.where(loud.any(axis=1), odds(skin, t[way].felt).mean(axis=1), -np.inf)
                unseen[way].append((t[way], each, whole))
    for way, name in enumerate(("as drawn", "all ridges told")):
        print(f"{len(unseen[way])} scenes, {name}\n{HEAD}")
        for back in (0.5, 1.0, 2.0):
            for threshold in np.arange(0.0, 5.1, 0.25):
                for skin in (False, True):
                    marks = []
                    for h, each, whole in unseen[way]:
                        found = alarms(whole[:, None] if skin else each, threshold, back, skin=skin)
                        marks.append(mark(h.case, found, h.window))
                    what = "skin" if skin else "ridge"
                    print(line(f"{what} > {threshold:g}, back {back:g}", marks), flush=True)


def alarms(values: np.ndarray, threshold: float, back: float, *, skin: bool) -> list[Alarm]:
    """Return each ridge, or None of the `skin`, and sample at which odds rise above a threshold."""
    now = taken(np.zeros(values.shape[1], bool), values, threshold, back)
    before = np.concatenate([np.zeros_like(now[:1]), now[:-1]])
    return [(None if skin else int(r), int(i)) for i, r in np.argwhere(now & ~before)]


def sticking() -> Iterator[tuple[np.ndarray, float]]:
    """Yield outputs `(n, ridges, 2)` with noise, and the noise of a pair, rms."""
    draw = np.random.default_rng(31)
    time = np.arange(LOAD_STEPS) / LOAD_RATE
    for _ in range(LOADS):
        ridges = int(draw.integers(2, MOST_RIDGES + 1))
        pull, press = (band_limited(time, _load(draw), LOAD_BAND).value for _ in range(2))
        press = press * draw.choice([0.0, 0.1, 1.0])
        pair = pull[:, None] * draw.uniform(0.5, 1.2, ridges)
        pair += press[:, None] * draw.uniform(-0.2, 0.2, ridges)
        total = press[:, None] * draw.uniform(0.5, 1.2, ridges) * draw.choice([1.0, 3.0])
        noise = 10 ** draw.uniform(-3, -2)
        outputs = np.stack([total + pair, total - pair], axis=2) / 2
        yield outputs + draw.normal(0, noise / np.sqrt(2), outputs.shape), float(noise)


def _load(draw: np.random.Generator) -> np.ndarray:
    """Return a rate that is constant from time to time, or runs straight from value to value; often 0."""
    at = np.sort(draw.integers(5, LOAD_STEPS, draw.integers(2, 7)))
    values = draw.uniform(-1, 1, at.size + 1) * (draw.random(at.size + 1) < 0.75)
    if draw.random() < 0.3:
        return np.interp(np.arange(LOAD_STEPS), at, values[1:])
    values[0] = 0.0
    return values[np.searchsorted(at, np.arange(LOAD_STEPS), side="right")]


def main(folder: Path) -> None:
    answer = [kept(seed, folder / "scenes") for seed in seeds(DESIGN)]
    answer = [m for m in answer if m.time.size >= FEWEST] + shipped(folder / "shipped")
    rows = [list(variants(m, folder / "outputs")) for m in answer]
    print(len(rows), "scenes", flush=True)
    every, place = [h for t in rows for h in t], Path(detector.__file__).parent
    (place / RIDGES).write_text(written(fitted(of_ridges(every)), "a ridge that slips"))
    (place / SKIN).write_text(written(fitted(of_skins(every)), "gross slip ahead"))
    validated(rows)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main(Path(sys.argv[1]))
