"""Does `solve` find what there is to find? Designs drawn at random tell targets; it starts from another.

`python -m bench.hidden_targets 20 --seed 0` draws 20 designs that differ from `lab-bench` in one number, and
20 that differ in three, takes the all-touch force, the approach or a ridge's force of each as the target, and
prints the evaluations that the way back to it took, and by how much it missed.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter

import numpy as np

import skincad
from skincad.studies.question import Question, evaluate
from skincad.studies.solving import solve

START, TIER = "lab-bench", "corrected"
RANGES = {
    "skin.curvature_radius": (60.0, 400.0),
    "skin.thickness": (4.0, 14.0),
    "skin.length": (12.0, 40.0),
    "material.young_modulus": (0.05, 0.6),
    "ridge.height": (0.7, 1.2),
    "ridge.levelling": (0.0, 0.8),
}
TARGETS = ("all_touch_force_N", "approach_mm", "ridge_force_N.5")
HIT, MOST = 0.02, {1: 12, 3: 60}


@dataclass(frozen=True)
class Way:
    """One hidden target: what was varied and wanted, how many evaluations it took and by what part it missed;
    `missed` is infinite where nothing was found."""

    seed: int
    keys: tuple[str, ...]
    wanted: tuple[str, float]
    evaluations: int
    missed: float
    seconds: float

    @property
    def hit(self) -> bool:
        """Whether it was found well enough in few enough evaluations."""
        return self.missed <= HIT and self.evaluations <= MOST[len(self.keys)]

    def __str__(self) -> str:
        what = f"{self.wanted[0]} {self.wanted[1]:.4g} by {', '.join(self.keys)}"
        miss = f"missed by {100 * self.missed:.2g} %" if self.missed < np.inf else "not found"
        return f"seed {self.seed}: {what}: {self.evaluations} evaluations, {miss}, {self.seconds:.0f} s"


def ways(count: int, first: int, knobs: int, tier: str = TIER) -> Iterator[Way]:
    """Yield `count` ways back to targets that the designs of random values of so many `knobs` told."""
    seed, start = first, skincad.load_design(START)
    while count:
        rng = np.random.default_rng([seed, knobs, 41])
        keys = tuple(str(key) for key in rng.choice(list(RANGES), knobs, replace=False))
        hidden = {key: float(np.round(rng.uniform(*RANGES[key]), 4)) for key in keys}
        told = evaluate(start, hidden, Question("check", tier))
        target = TARGETS[seed % len(TARGETS)]
        seed += 1
        value = told.results[target].value if told.results and not told.refused else None
        if not value:
            continue  # no feasible design
        began = perf_counter()
        found = solve(start, {target: value}, {key: RANGES[key] for key in keys}, tier=tier)
        missed = np.inf
        if found.solutions:
            missed = abs(float(found.solutions[0].reached[target]) / value - 1)
        yield Way(seed - 1, keys, (target, value), len(found.evaluations), missed, perf_counter() - began)
        count -= 1


def main() -> None:
    """Print each way, and how many hit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--tier", default=TIER)
    asked = parser.parse_args()
    for knobs in MOST:
        found = []
        for way in ways(asked.count, asked.seed, knobs, asked.tier):
            print(way, flush=True)
            found.append(way)
        took = sorted(way.evaluations for way in found)
        hits = sum(way.hit for way in found)
        print(
            f"{knobs} numbers: {hits} of {len(found)} hit; evaluations {took[len(took) // 2]} in the median"
        )


if __name__ == "__main__":
    main()
