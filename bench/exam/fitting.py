"""Fit the detector to the design set: `python -m bench.exam.fitting FOLDER` (scenes kept there).

Each design scene is heard three ways behind the transimpedance amplifier: as drawn; with all its ridges told
and with one to three of them, at 0.2 to 5 times its speed, in another band, with 1 to 30 times the noise. A
ridge's label is whether it slips, the low-pass's delay later; while slip lasts on to gross slip, those that
still stick count as slipping too, at a lower weight, for that is what is to be told. Logistic loss, L-BFGS.
Scenes that ship are in the set as well, and records of
ridges that all stick. Writes slip_weights.toml, and prints what threefold cross-validation
by scene makes of thresholds: THRESHOLD of scenes/slip.py was read off that.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import minimize
from threadpoolctl import threadpool_limits

from bench.exam.cases import Case, case
from bench.exam.scenes import Marched, kept, seeds
from bench.exam.scoring import HEAD, lasting, line, mark, near
from bench.exam.shipped import shipped
from bench.exam.skins import DESIGN
from bench.exam.sticking import BAND, RATE, sticking
from skincad.circuit.low_pass import delay
from skincad.scenes import slip, slip_features

CIRCUIT = "transimpedance"
THIN = 6  # every so manyth sample
FOLDS = 3
HIDDEN, ITERATIONS, DECAY = 12, 130, 3e-4
# of a sample: nothing slips, another ridge does, this one does, this one until all do, another until all do
WEIGHT = np.array([1.0, 0.3, 0.7, 4.0, 0.7])
EDGE = 0.2  # times that within a window of a slip's edge
OWN = 6.0  # times that in scenes that ship
STICKING = 1.0  # that of a sample of sticking.py
FEWEST = 100  # steps of a scene that was marched far enough


@dataclass(frozen=True, eq=False)
class Heard:
    """A case with noise: features `(n, ridges, features)`, each sample's class and weight `(n, ridges)`."""

    case: Case
    window: int
    felt: np.ndarray
    kind: np.ndarray
    weight: np.ndarray


def heard(one: Case, louder: float, seed: int) -> Heard:
    """Return a case as the detector hears it with `louder` times its noise."""
    noise = math.sqrt(2) * one.noise * louder
    d = slip.detector(one.rate, one.scene.bandwidth, noise)
    outputs = one.outputs + louder * one.noises(seed)
    felt = slip_features.features(d.window, noise, outputs, slip_features.at_rest(outputs.shape[1]))[0]
    kind, edge = classes(one, d.window)
    weight = WEIGHT[kind] * np.where(edge, EDGE, 1.0) / math.sqrt(kind.shape[1])
    weight *= OWN if one.scene.seed < 0 else 1.0
    return Heard(one, d.window, felt.astype(np.float32), kind, weight)


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


def variants(scene: Marched, folder: Path) -> Iterator[Heard]:
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


Parts = tuple[np.ndarray, np.ndarray, np.ndarray]


def samples(told: list[Heard]) -> Parts:
    """Return features `(m, features)`, labels `(m,)`, weights `(m,)` of some that are heard."""
    felt = [h.felt[::THIN].reshape(-1, h.felt.shape[2]) for h in told]
    label = [h.kind[::THIN].ravel() >= 2 for h in told]
    weight = [h.weight[::THIN].ravel() for h in told]
    for outputs, noise in sticking():
        window = slip.detector(RATE, BAND, noise).window
        more = slip_features.features(window, noise, outputs, slip_features.at_rest(outputs.shape[1]))[0]
        felt.append(more[::THIN].reshape(-1, more.shape[2]).astype(np.float32))
        label.append(np.zeros(felt[-1].shape[0], bool))
        weight.append(np.full(felt[-1].shape[0], STICKING))
    return np.concatenate(felt), np.concatenate(label), np.concatenate(weight)


def fitted(parts: Parts, seed: int = 0) -> slip.Weights:
    """Return the network that fits samples best."""
    x, y, w = parts
    draw, width = np.random.default_rng(seed), x.shape[1]
    middle, spread = x.mean(axis=0), x.std(axis=0) + 1e-3
    z, label, weight = (x - middle) / spread, y.astype(np.float32), (w / w.sum()).astype(np.float32)
    start = [
        draw.normal(0, 1 / math.sqrt(width), width * HIDDEN), np.zeros(HIDDEN),
        draw.normal(0, 1 / math.sqrt(HIDDEN), HIDDEN), np.zeros(1),
    ]  # fmt: skip
    loss = _loss(z, label, weight)
    options = {"maxiter": ITERATIONS, "maxfun": 2 * ITERATIONS}
    found = minimize(loss, np.concatenate(start), jac=True, method="L-BFGS-B", options=options).x
    into, bias, out, base = _parts(found, width)
    into = into / spread[:, None]
    return slip.Weights(into, bias - middle @ into, out, float(base[0]))


def _parts(p: np.ndarray, width: int) -> list[np.ndarray]:
    ends = np.cumsum([width * HIDDEN, HIDDEN, HIDDEN])
    into, bias, out, base = np.split(p, ends)
    return [into.reshape(width, HIDDEN), bias, out, base]


def _loss(
    z: np.ndarray, label: np.ndarray, weight: np.ndarray
) -> Callable[[np.ndarray], tuple[float, np.ndarray]]:
    """Return the weighted logistic loss with its gradient, by the network's constants."""

    def loss(p: np.ndarray) -> tuple[float, np.ndarray]:
        into, bias, out, base = (part.astype(np.float32) for part in _parts(p, z.shape[1]))
        hidden = np.tanh(z @ into + bias)
        odds = hidden @ out + base
        value = float((weight * (np.logaddexp(0, odds) - label * odds)).sum())
        wrong = weight * (1 / (1 + np.exp(-odds)) - label)
        back = (wrong[:, None] * out) * (1 - hidden * hidden)
        slope = [(z.T @ back).ravel(), back.sum(axis=0), hidden.T @ wrong, [wrong.sum()]]
        return value + DECAY * float(p @ p), np.concatenate(slope).astype(float) + 2 * DECAY * p

    return loss


def odds(w: slip.Weights, felt: np.ndarray) -> np.ndarray:
    """Return the logarithm of the odds `(n, ridges)` of features."""
    return np.asarray(np.tanh(felt @ w.into + w.bias) @ w.out + w.base)


def alarms(d: slip.Detector, values: np.ndarray) -> list[tuple[int, int]]:
    """Return each (ridge, sample) at which odds rise above a detector's threshold."""
    now = slip.taken(d, np.zeros(values.shape[1], bool), values)
    before = np.concatenate([np.zeros_like(now[:1]), now[:-1]])
    return [(int(r), int(i)) for i, r in np.argwhere(now & ~before)]


def written(w: slip.Weights) -> str:
    """Return the weights as TOML, four digits of each."""
    rows = ",\n".join("    [" + ", ".join(f"{v:.4g}" for v in column) + "]" for column in w.into.T)
    bias, out = (", ".join(f"{v:.4g}" for v in row) for row in (w.bias, w.out))
    return (
        "# The slip detector's network, fitted by bench/exam/fitting.py; into: a row a hidden unit, its\n"
        "# columns the features of skincad/scenes/slip_features.py in their order\n"
        f"base = {w.base:.4g}\nbias = [{bias}]\nout = [{out}]\ninto = [\n{rows},\n]\n"
    )


def validated(told: list[list[Heard]]) -> None:
    """Print what thresholds make of scenes that the network was not fitted to."""
    unseen: list[tuple[Heard, np.ndarray]] = []
    for fold in range(FOLDS):
        mine = [t for i, t in enumerate(told) if i % FOLDS != fold or t[0].case.scene.seed < 0]
        network = fitted(samples([h for t in mine for h in t]), fold)
        rest = [t[0] for i, t in enumerate(told) if i % FOLDS == fold and t[0].case.scene.seed >= 0]
        unseen += [(h, odds(network, h.felt)) for h in rest]
    print(HEAD)
    for threshold in np.arange(0.5, 3.1, 0.25):
        marks = []
        for h, values in unseen:
            d = slip.Detector(h.window, h.case.noise, float(threshold))
            marks.append(mark(h.case, alarms(d, values), h.window))
        print(line(f"threshold {threshold:g}", marks), flush=True)


def main(folder: Path) -> None:
    """Fit, write, and print the cross-validation."""
    found = [kept(seed, folder / "scenes") for seed in seeds(DESIGN)]
    found = [m for m in found if m.time.size >= FEWEST] + shipped(folder / "shipped")
    told = [list(variants(m, folder / "outputs")) for m in found]
    print(len(told), "scenes", flush=True)
    network = fitted(samples([h for t in told for h in t]))
    (Path(slip.__file__).parent / "slip_weights.toml").write_text(written(network))
    validated(told)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main(Path(sys.argv[1]))
