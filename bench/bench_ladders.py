"""All ladders whole: what each stage was expected to take, by the laws behind the bar, and what it took.

`python -m bench.bench_ladders [TEMPLATE] [--ladder NAME]... [--minutes M]` climbs the ladders one
after the other; a ladder that is expected to end after M minutes is not begun, and said.
"""

from __future__ import annotations

import argparse
from time import perf_counter

import numpy as np

import skincad
from skincad.inputs.design import Design
from skincad.ladders.ladder import LADDERS, ladder_of

REPEATS = 3


class Stages:
    """A Progress that times the stages it is told."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.now, self.began = "", perf_counter()

    def __call__(self, stage: str, _left: float | None = None, /) -> None:
        """End the stage before and begin this one."""
        if self.now:
            self.seconds[self.now] = perf_counter() - self.began
        self.now, self.began = stage, perf_counter()


def climb(name: str, design: Design) -> float:
    """Print a ladder's stages, expected and taken; return the seconds of the whole."""
    module, stages = ladder_of(name), Stages()
    prices = module.prices(design, REPEATS)
    found = module.ladder(design, REPEATS, stages)
    stages("")
    judged = {
        stage: taken for stage, taken in stages.seconds.items() if prices[stage]
    }  # a refused tier has none
    for stage, taken in judged.items():
        print(f"  {stage:48}{prices[stage]:10.2f}{taken:10.2f}{taken / prices[stage]:8.2f}")
    for model, why in found.skipped.items():
        print(f"  not {model}: {why}")
    whole, expected = sum(stages.seconds.values()), sum(prices.values())
    ratios = np.log([taken / prices[stage] for stage, taken in judged.items()])
    off = np.exp(np.sqrt(np.mean((ratios - ratios.mean()) ** 2)))
    print(f"  {name:48}{expected:10.2f}{whole:10.2f}{whole / expected:8.2f}  stages off by {off:.2f}\n")
    return whole


def main() -> None:
    """Climb what fits."""
    parser = argparse.ArgumentParser()
    parser.add_argument("template", nargs="?", default="yamada-2002")
    parser.add_argument("--ladder", action="append", choices=list(LADDERS))
    parser.add_argument("--minutes", type=float, default=10.0)
    asked = parser.parse_args()
    design, began = skincad.load(asked.template), perf_counter()
    print(f"{asked.template:50}{'expected':>10}{'taken, s':>10}{'ratio':>8}")
    for name in asked.ladder or LADDERS:
        spent, price = perf_counter() - began, sum(ladder_of(name).prices(design, REPEATS).values())
        if spent + price > 60 * asked.minutes:
            print(f"  {name}: not begun, it would take {price:.0f} s")
        else:
            climb(name, design)
    print(f"{perf_counter() - began:.0f} s in all")


if __name__ == "__main__":
    main()
