"""Fit the detector to the design set: `python -m bench.exam.fitting FOLDER` (scenes kept there).

Each design scene is heard three ways behind the transimpedance amplifier: as drawn; with all its ridges told
and with one to three of them, at 0.2 to 5 times its speed, in another band, with 1 to 30 times the noise; and
once behind another amplifier, up to 30 times slower, differenced where that tells the stress. A ridge's label
is whether it slips, the low-pass's delay later; while slip lasts on to gross detector, those that still stick
count as slipping too, at a lower weight, for that is what is to be told; a short gross slip counts as much as
one of EVENT windows. Scenes that ship are in the set as well, and records of ridges that all stick. Writes
slip_weights_early.toml, and prints what threefold cross-validation by scene makes of thresholds: EARLY's of
scenes/detector.py was read off that.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from bench.exam.cases import Case, case
from bench.exam.network import Parts, fitted
from bench.exam.scenes import SceneRun, batch, kept, seeds
from bench.exam.scoring import HEAD, lasting, line, mark, near
from bench.exam.shipped import shipped
from bench.exam.skins import DESIGN
from bench.exam.sticking import BAND, RATE, sticking
from skincad.circuit.state import delay
from skincad.scenes import detector, slip_features

CIRCUIT = "transimpedance"
OTHERS = {"yamada-2002": False, "charge-amplifier": True, "voltage-follower": True}  # differenced or not
THIN = 6  # every so manyth sample
FOLDS = 3
# of a sample: nothing slips, another ridge does, this one does, this one until all do, another until all do
WEIGHT = np.array([1.0, 0.3, 0.7, 4.0, 0.7])
EDGE = 0.2  # times that within a window of a slip's edge
OWN = 6.0  # times that in scenes that ship
STICKING = 1.0  # that of a sample of sticking.py
EVENT = 2.0  # windows of a ridge's lasting detector, that a gross slip's samples weigh at least, together
MOST = 8.0  # times their weight, for that
FEWEST = 100  # steps of a scene that was marched far enough


@dataclass(frozen=True, eq=False)
class Heard:
    """A case with noise: features `(n, ridges, features)`, how loud its pairs are, each sample's class and
    weight `(n, ridges)`."""

    case: Case
    window: int
    felt: np.ndarray
    loud: np.ndarray
    kind: np.ndarray
    weight: np.ndarray


def heard(one: Case, louder: float, seed: int) -> Heard:
    """Return a case as the detector hears it with `louder` times its noise."""
    noise = math.sqrt(2) * one.noise * louder
    d = detector.detector(one.rate, one.scene.bandwidth, noise)
    outputs = one.outputs + louder * one.noises(seed)
    felt, loud, _ = slip_features.features(d.window, noise, outputs, slip_features.at_rest(outputs.shape[1]))
    kind, edge = classes(one, d.window)
    weight = WEIGHT[kind] * np.where(edge, EDGE, 1.0) / math.sqrt(kind.shape[1])
    weight *= OWN if one.scene.seed < 0 else 1.0
    return Heard(one, d.window, felt.astype(np.float32), loud, kind, as_events(one, d.window, kind, weight))


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


def samples(told: list[Heard]) -> Parts:
    """Return features `(m, features)`, labels `(m,)`, weights `(m,)` of some that are heard."""
    felt = [h.felt[::THIN].reshape(-1, h.felt.shape[2]) for h in told]
    label = [h.kind[::THIN].ravel() >= 2 for h in told]
    weight = [h.weight[::THIN].ravel() for h in told]
    for outputs, noise in sticking():
        window = detector.detector(RATE, BAND, noise).window
        more = slip_features.features(window, noise, outputs, slip_features.at_rest(outputs.shape[1]))[0]
        felt.append(more[::THIN].reshape(-1, more.shape[2]).astype(np.float32))
        label.append(np.zeros(felt[-1].shape[0], bool))
        weight.append(np.full(felt[-1].shape[0], STICKING))
    return np.concatenate(felt), np.concatenate(label), np.concatenate(weight)


def odds(w: detector.Weights, felt: np.ndarray) -> np.ndarray:
    """Return the logarithm of the odds `(n, ridges)` of features."""
    return np.asarray(np.tanh(felt @ w.into + w.bias) @ w.out + w.base)


def alarms(d: detector.Detector, values: np.ndarray) -> list[tuple[int, int]]:
    """Return each (ridge, sample) at which odds rise above a detector's threshold."""
    now = detector.taken(d, np.zeros(values.shape[1], bool), values)
    before = np.concatenate([np.zeros_like(now[:1]), now[:-1]])
    return [(int(r), int(i)) for i, r in np.argwhere(now & ~before)]


def written(w: detector.Weights) -> str:
    """Return the weights as TOML, four digits of each."""
    rows = ",\n".join("    [" + ", ".join(f"{v:.4g}" for v in column) + "]" for column in w.into.T)
    bias, out = (", ".join(f"{v:.4g}" for v in row) for row in (w.bias, w.out))
    return (
        "# The slip detector's network for early alarms, by bench/exam/fitting.py; into: a row a hidden\n"
        "# unit, its columns the features of skincad/scenes/slip_features.py in their order\n"
        f"base = {w.base:.4g}\nbias = [{bias}]\nout = [{out}]\ninto = [\n{rows},\n]\n"
    )


def validated(told: list[list[Heard]]) -> None:
    """Print what thresholds make of scenes that the network was not fitted to, where the outputs are loud."""
    unseen: list[tuple[Heard, np.ndarray]] = []
    for fold in range(FOLDS):
        mine = [t for i, t in enumerate(told) if i % FOLDS != fold or t[0].case.scene.seed < 0]
        network = fitted(samples([h for t in mine for h in t]), fold)
        rest = [t[0] for i, t in enumerate(told) if i % FOLDS == fold and t[0].case.scene.seed >= 0]
        unseen += [(h, np.where(h.loud > detector.SEEN, odds(network, h.felt), -np.inf)) for h in rest]
    first = [(h, values) for h, values in unseen if batch(h.case.scene.seed) == 0]
    for name, some in (("all", unseen), ("of the exam's kind of skins", first)):
        print(f"{len(some)} scenes, {name}\n{HEAD}")
        for threshold in np.arange(-1.5, 4.1, 0.25):
            marks = []
            for h, values in some:
                d = detector.Detector(h.window, h.case.noise, float(threshold), detector.EARLY)
                marks.append(mark(h.case, alarms(d, values), h.window))
            print(line(f"threshold {threshold:g}", marks), flush=True)


def main(folder: Path) -> None:
    """Fit, write, and print the cross-validation."""
    answer = [kept(seed, folder / "scenes") for seed in seeds(DESIGN)]
    answer = [m for m in answer if m.time.size >= FEWEST] + shipped(folder / "shipped")
    rows = [list(variants(m, folder / "outputs")) for m in answer]
    print(len(rows), "scenes", flush=True)
    network = fitted(samples([h for t in rows for h in t]))
    (Path(detector.__file__).parent / detector.POINTS[detector.EARLY].file).write_text(written(network))
    validated(rows)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main(Path(sys.argv[1]))
