"""Is the better of two designs told apart as surely as is said? Pairs of neighbours in a study,
ranked by the linear model, against `solid-finite-strain`.

`python -m bench.ranks 30 --seed 100` draws 30 pairs and prints how many are said to be surely different, how
many of those rightly, and the same for other values of what two designs do not share of a model's error
(`OWN` in skincad/studies/sweeping.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

import skincad
from bench import runner
from skincad.base import InputError
from skincad.inputs import Design
from skincad.studies import Query, changed, evaluate, model_error

KEY, BEST = "all_touch_force_N", "solid-finite-strain"
VARIED = {  # a study of pads like the paper's, films aside
    "skin.curvature_radius": (40.0, 120.0),
    "skin.thickness": (2.5, 6.0),
    "skin.length": (8.0, 16.0),
    "ridge.height": (0.35, 0.6),
    "material.young_modulus": (0.4, 1.2),
}
APART = 0.12  # standard deviation of the logarithm of each number's ratio between the two
OWNS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0)


@dataclass(frozen=True)
class Pair:
    """Two designs' all-touch forces, N, by the linear model with the two parts of their errors, and by the
    best."""

    seed: int
    linear: tuple[float, float]
    mesh: tuple[float, float]
    model: tuple[float, float]
    best: tuple[float, float]
    best_error: tuple[float, float]

    def error(self, own: float) -> float:
        """Return the error of the difference, N."""
        return math.hypot(*self.mesh) + abs(self.model[0] - self.model[1]) + own * math.hypot(*self.model)

    def sure(self, own: float) -> bool:
        return abs(self.linear[0] - self.linear[1]) > self.error(own)

    @property
    def right(self) -> bool:
        """Whether the linear model's order is the best's."""
        return (self.linear[0] < self.linear[1]) == (self.best[0] < self.best[1])


def drawn(seed: int) -> tuple[Design, Design]:
    """Return a seed's two designs, without friction, which neither model then leaves out."""
    rng = np.random.default_rng([seed, 17])
    base = skincad.load_design("plain-ridges").with_(contact={"friction": 0.0, "force": 2.0})
    first = {key: float(np.exp(rng.uniform(*np.log(ends)))) for key, ends in VARIED.items()}
    second = {key: value * float(np.exp(APART * rng.normal())) for key, value in first.items()}
    one, other = (changed(base, values) for values in (first, second))
    assert isinstance(one, Design)
    assert isinstance(other, Design)
    return one, other


def judged(seed: int) -> Pair:
    """Return a seed's pair; InputError where a model refuses one of its designs."""
    table = {}
    for model in ("linear", BEST):
        table[model] = [evaluate(design, {}, Query("check", model)) for design in drawn(seed)]
        for each in table[model]:
            if each.refused or each.results[KEY].value is None:
                raise InputError(model, each.refused or f"tells no {KEY}")

    def both(model: str, part: str) -> tuple[float, float]:
        a, b = (float(getattr(each.results[KEY], part) or 0.0) for each in table[model])
        return a, b

    errors = [model_error(each, KEY) for each in table["linear"]]
    meshes = [error - own for error, own in zip(both("linear", "error"), errors, strict=True)]
    return Pair(
        seed,
        both("linear", "value"),
        (meshes[0], meshes[1]),
        (errors[0], errors[1]),
        both(BEST, "value"),
        both(BEST, "error"),
    )


def summary(pairs: list[Pair]) -> list[str]:
    lines = [f"{len(pairs)} pairs, in the right order {sum(pair.right for pair in pairs)}"]
    for own in OWNS:
        sure = [pair for pair in pairs if pair.sure(own)]
        right = sum(pair.right for pair in sure)
        held = sum(
            abs((p.linear[0] - p.linear[1]) - (p.best[0] - p.best[1]))
            <= p.error(own) + math.hypot(*p.best_error)
            for p in pairs
        )
        lines.append(
            f"own {own:3}: {len(sure)} told apart, {right} rightly; difference within its error in {held}"
        )
    return lines


def main() -> None:
    options = runner.parser(__doc__, "count", seed=0).parse_args()
    seeds = range(options.seed, options.seed + options.count)
    print("\n".join(summary(runner.rows("ranks", judged, seeds, options, kind=Pair))))


if __name__ == "__main__":
    main()
