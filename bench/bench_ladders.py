"""All ladders whole: what each stage was expected to take, by what is behind the bar, and what it took.

`python -m bench.bench_ladders [TEMPLATE] [--ladder NAME]... [--minutes M]` climbs the ladders one
after the other; a ladder that is expected to end after M minutes is not begun, and said.

`python -m bench.bench_ladders --prices TEMPLATE...` solves every model on each template and prints what
`check` would expect of each by the time of the one before, against what it took. Times are the processor's:
what else a busy machine does is not the models'."""

from __future__ import annotations

import argparse
from contextlib import suppress
from time import perf_counter, process_time
from unittest.mock import patch

import numpy as np

import skincad
from skincad.base import InputError, RefusedError
from skincad.inputs import Design
from skincad.mechanics import (
    MODELS,
    Answer,
    Request,
    expected_seconds,
    prerequisites,
    run,
    unsupported_reason,
)
from skincad.mechanics.models import table
from skincad.studies import LADDERS, MESH, ladder_of

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


def refine(name: str, design: Design) -> float:
    """Print a ladder's stages, expected and taken; return the seconds of the whole."""
    module, stages = ladder_of(name), Stages()
    prices = module.prices(design, REPEATS)
    answer = module.ladder(design, REPEATS, stages)
    stages("")
    judged = {
        stage: taken for stage, taken in stages.seconds.items() if prices[stage]
    }  # a refused model has none
    for stage, taken in judged.items():
        print(f"  {stage:48}{prices[stage]:10.2f}{taken:10.2f}{taken / prices[stage]:8.2f}")
    for model, why in answer.skipped.items():
        print(f"  not {model}: {why}")
    whole, expected = sum(stages.seconds.values()), sum(prices.values())
    ratios = np.log([taken / prices[stage] for stage, taken in judged.items()])
    off = np.exp(np.sqrt(np.mean((ratios - ratios.mean()) ** 2)))
    print(f"  {name:48}{expected:10.2f}{whole:10.2f}{whole / expected:8.2f}  stages off by {off:.2f}\n")
    return whole


def solved(design: Design) -> dict[str, Answer]:
    """Return the answer of each model that can judge the design, to the mesh that the ladder asks."""
    done: dict[str, Answer] = {}
    for name in MODELS:
        with suppress(InputError, RefusedError):
            if not unsupported_reason(name, design, measured=False):
                run(name, design, Request(design.contact.force, MESH), done, None)
    return done


def prices(names: list[str]) -> None:
    """Print how right the models' prices are on these templates."""
    print(f"{'model':46}{'expected':>10}{'took, s':>10}{'ratio':>8}")
    with patch.object(table, "perf_counter", process_time):
        for name in names:
            design = skincad.load(name, ["contact.friction=0"])
            done = solved(design)
            before: dict[str, Answer] = {}
            for model, answer in done.items():
                if before and MODELS[model].price >= 1:
                    ready = {*prerequisites(model)} & set(done)
                    known = {one: done[one] for one in done if one in ready or one in before}
                    expected = expected_seconds(model, design, known)
                    line = f"  {name:20}{model:24}{expected:10.2f}{answer.own_seconds:10.2f}"
                    print(f"{line}{expected / answer.own_seconds:8.2f}", flush=True)
                before[model] = answer


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("template", nargs="?", default="yamada-2002")
    parser.add_argument("--ladder", action="append", choices=list(LADDERS))
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--prices", nargs="+", metavar="TEMPLATE")
    options = parser.parse_args()
    if options.prices:
        prices(options.prices)
        return
    design, began = skincad.load(options.template), perf_counter()
    print(f"{options.template:50}{'expected':>10}{'taken, s':>10}{'ratio':>8}")
    for name in options.ladder or LADDERS:
        spent, price = perf_counter() - began, sum(ladder_of(name).prices(design, REPEATS).values())
        if spent + price > 60 * options.minutes:
            print(f"  {name}: not begun, it would take {price:.0f} s")
        else:
            refine(name, design)
    print(f"{perf_counter() - began:.0f} s in all")


if __name__ == "__main__":
    main()
