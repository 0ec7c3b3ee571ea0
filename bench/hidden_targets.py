"""Does `solve` find what there is to find? Designs drawn at random tell targets; it starts from another.

`python -m bench.hidden_targets 20 --seed 0` draws 20 designs that differ from `lab-bench` in one number, and
20 that differ in three, takes the all-touch force, the approach or a ridge's force of each as the target, and
prints the evaluations that the way back to it took, and by how much it missed. `--wide` varies one of the
keys of WIDE, in a design of choice: `--start yamada-2002 --wide`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from time import perf_counter

import numpy as np

import skincad
from bench import runner
from skincad.studies import Query, evaluate, solve, value_of

START, MODEL = "lab-bench", "corrected"
RANGES = {
    "skin.curvature_radius": (60.0, 400.0),
    "skin.thickness": (4.0, 14.0),
    "skin.length": (12.0, 40.0),
    "material.young_modulus": (0.05, 0.6),
    "ridge.height": (0.7, 1.2),
    "ridge.levelling": (0.0, 0.8),
}
WIDE = {  # of the start's own values
    "skin.curvature_radius": (0.6, 2.0),
    "skin.thickness": (0.6, 1.6),
    "skin.width": (1.0, 2.0),
    "skin.length": (0.7, 1.4),
    "ridge.pitch": (0.9, 1.2),
    "ridge.height": (0.7, 1.3),
    "ridge.root_width": (0.8, 1.1),
    "ridge.tip_width": (0.7, 1.2),
    "ridge.crown": (0.3, 3.0),  # the closed form knows none of these four
    "ridge.tip_fillet": (0.2, 2.0),
    "ridge.root_fillet": (0.3, 1.6),
    "material.poisson_ratio": (0.92, 1.0),
    "material.young_modulus": (0.25, 3.0),
    "contact.force": (0.5, 2.0),
}
TARGETS = ("all_touch_force_N", "approach_mm", "ridge_force_N.5")
HIT, MOST = 0.02, {1: 12, 3: 60}


@dataclass(frozen=True)
class Way:
    """One hidden target: what was varied and wanted, how many evaluations it took and by what part it missed;
    `missed` is infinite where nothing was found, `denied` says that there is nothing."""

    seed: int
    keys: tuple[str, ...]
    wanted: tuple[str, float]
    evaluations: int
    missed: float
    denied: bool
    seconds: float

    @property
    def hit(self) -> bool:
        return self.missed <= HIT and self.evaluations <= MOST[len(self.keys)]

    def __str__(self) -> str:
        what = f"{self.wanted[0]} {self.wanted[1]:.4g} by {', '.join(self.keys)}"
        miss = f"missed by {100 * self.missed:.2g} %" if self.missed < np.inf else "not found"
        return f"seed {self.seed}: {what}: {self.evaluations} evaluations, {miss}, {self.seconds:.0f} s"


def wide(start: str) -> dict[str, tuple[float, float]]:
    """Return the ranges of WIDE for the keys that a design gives."""
    design, found = skincad.load_design(start), dict[str, tuple[float, float]]()
    for key, (low, high) in WIDE.items():
        if isinstance(value := value_of(design, key), int | float):
            found[key] = (float(f"{low * value:.4g}"), float(f"{high * value:.4g}"))
    return found


def ways(
    count: int,
    first: int,
    knobs: int,
    model: str = MODEL,
    start: str = START,
    ranges: Mapping[str, tuple[float, float]] = RANGES,
) -> Iterator[Way]:
    """Yield `count` ways back to targets that the designs of random values of so many `knobs` told."""
    seed, design = first, skincad.load_design(start)
    while count:
        rng = np.random.default_rng([seed, knobs, 41])
        keys = tuple(str(key) for key in rng.choice(list(ranges), knobs, replace=False))
        hidden = {key: float(np.round(rng.uniform(*ranges[key]), 4)) for key in keys}
        evaluation = evaluate(design, hidden, Query("check", model))
        target = TARGETS[seed % len(TARGETS)]
        seed += 1
        value = evaluation.results[target].value if evaluation.results and not evaluation.refused else None
        if not value:
            continue  # no feasible design
        began = perf_counter()
        solution = solve(design, {target: value}, {key: ranges[key] for key in keys}, model=model)
        missed = np.inf
        if solution.solutions:
            missed = abs(float(solution.solutions[0].reached[target]) / value - 1)
        denied = solution.complete and not solution.feasible
        took = perf_counter() - began
        yield Way(seed - 1, keys, (target, value), len(solution.evaluations), missed, denied, took)
        count -= 1


def main() -> None:
    parser = runner.parser(__doc__, "count", seed=0, recorded=False)
    parser.add_argument("--tier", dest="model", default=MODEL)
    parser.add_argument("--start", default=START, help="a design's template")
    parser.add_argument("--wide", action="store_true", help="one of the keys of WIDE")
    options = parser.parse_args()
    ranges = wide(options.start) if options.wide else RANGES
    for knobs in [1] if options.wide else MOST:
        rows = []
        for way in ways(options.count, options.seed, knobs, options.model, options.start, ranges):
            print(way, flush=True)
            rows.append(way)
        took = sorted(way.evaluations for way in rows)
        hits = sum(way.hit for way in rows)
        denied, keys = sum(way.denied for way in rows), len({way.keys for way in rows})
        print(
            f"{knobs} numbers: {hits} of {len(rows)} hit, {denied} denied, over {keys} sets of keys; "
            f"evaluations {took[len(took) // 2]} in the median, {took[-1]} at most"
        )


if __name__ == "__main__":
    main()
