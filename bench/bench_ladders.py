"""All ladders whole: what each stage was expected to take, by the laws behind the bar, and what it took.

`python -m bench.bench_ladders [TEMPLATE] [--ladder NAME]... [--minutes M]` climbs the ladders one
after the other; a ladder that is expected to end after M minutes is not begun, and said.

`python -m bench.bench_ladders --law TEMPLATE...` solves every model on each template, keeps what the first
one's took as `skincad accuracy` does, in a folder that is thrown away, and prints what the law then expects
of each model against what it took: as it stands, and at the speed of that template's own linear model, as
`check` takes it once that is solved; beside it the built-in law at that speed. Times are the processor's:
what else a busy machine does is not the models'."""

from __future__ import annotations

import argparse
import os
from contextlib import suppress
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from unittest.mock import patch

import numpy as np

import skincad
from skincad.base.errors import InputError, RefusedError
from skincad.inputs.design import Design
from skincad.mechanics.models import table
from skincad.mechanics.models.table import (
    FOLDER_VARIABLE,
    MODELS,
    own_seconds,
    run,
    save_timings,
    unsupported_reason,
)
from skincad.mechanics.problem import Answer, Request
from skincad.studies.accuracy.contact import MESH, taken_of
from skincad.studies.accuracy.ladder import LADDERS, ladder_of

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


def laws(names: list[str]) -> None:
    """Print how right the law of time is that the first template's run leaves on this machine."""
    head = f"{'expected':>10}{'took, s':>10}{'ratio':>8}{'at speed':>10}{'built in':>10}"
    print(f"{f'law of {names[0]}':46}{head}")
    with TemporaryDirectory() as folder, patch.object(table, "perf_counter", process_time):
        os.environ[FOLDER_VARIABLE] = folder
        for name in names:
            design = skincad.load(name, ["contact.friction=0"])
            done = solved(design)
            counted = taken_of(design, done)
            if name == names[0]:
                save_timings(name, counted)
            kept, built_in = ({model: law(model, design) for model in done} for law in (own_seconds, by_law))
            for model in (model for model in done if MODELS[model].law.exponent):
                took, linear = done[model].own_seconds, done["linear"].own_seconds
                ratios = [told[model] / told["linear"] * linear / took for told in (kept, built_in)]
                further = "" if model in counted else "  on finer meshes than the law counts"
                line = f"  {name:20}{model:24}{kept[model]:10.2f}{took:10.2f}{kept[model] / took:8.2f}"
                print(f"{line}{ratios[0]:10.2f}{ratios[1]:10.2f}{further}", flush=True)


def by_law(model: str, design: Design) -> float:
    """Return what the built-in law expects of a model's own part, s."""
    return MODELS[model].law.at(MODELS[model].size(design))


def main() -> None:
    """Climb what fits."""
    parser = argparse.ArgumentParser()
    parser.add_argument("template", nargs="?", default="yamada-2002")
    parser.add_argument("--ladder", action="append", choices=list(LADDERS))
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--law", nargs="+", metavar="TEMPLATE")
    options = parser.parse_args()
    os.environ[FOLDER_VARIABLE] = os.devnull  # the built-in law, whatever this machine's user has kept
    if options.law:
        laws(options.law)
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
