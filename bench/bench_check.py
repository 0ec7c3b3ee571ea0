"""What each model of `check` costs on yamada-2002, and where the linear model's time goes.

`python -m bench.bench_check [model]...` prints, per model, its time in times of the linear model's (a
median, without program start and imports), its peak memory in a process of its own, and what it finds; then
the linear model's stages in times of one sparse factorisation of its own finest matrix.
"""

from __future__ import annotations

import statistics
import sys
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from threadpoolctl import threadpool_limits

from bench.measure import REPEATS, alone, best, factorise, free_block, system
from skincad import load
from skincad.mechanics import MODELS

DESIGN = "yamada-2002"
SMOOTH = "contact.friction=0"  # what each model leaves out, not what all do
LINEAR_GOAL = 8.0  # factorisations
GOALS = {"corrected": 4.0, "finite-strain": 10.0, "solid": 50.0}  # times of the linear model


def ready(model: str) -> bool:
    """Whether a model and all that it builds on are there."""
    return find_spec(MODELS[model].where.partition(":")[0]) is not None and all(
        map(ready, MODELS[model].builds_on)
    )


def measured(model: str) -> dict[str, Any]:
    """Return one model's median time by stage, s, and what it finds."""
    from skincad.mechanics.check import check

    for name in (model, *MODELS[model].builds_on):
        import_module(MODELS[name].where.partition(":")[0])
    design = load(DESIGN, [SMOOTH])
    check(design, model="winkler")
    runs = [check(design, model=model) for _ in range(REPEATS)]
    found = runs[0]
    return {
        "seconds": {s: statistics.median(run.seconds[s] for run in runs) for s in found.seconds},
        "unknowns": found.unknowns,
        "threshold": [found.all_touch_force.value, found.all_touch_force.error],
        "approach": [found.approach.value, found.approach.error],
    }


def number(value: float | None, error: float | None) -> str:
    """Return a value with its error."""
    return "none" if value is None else f"{value:.4f} +- {error or 0.0:.4f}"


def models(names: list[str]) -> dict[str, dict[str, Any]]:
    """Print the models' table and return its rows."""
    rows = {name: alone(measured, name) for name in dict.fromkeys(("linear", *names))}
    unit = rows["linear"]["seconds"]["total"]
    print(f"check {DESIGN}, times of the linear model's {unit:.3f} s, medians of {REPEATS} runs")
    print(f"{'model':>24} {'time':>8} {'goal':>6} {'peak, MB':>9} {'unknowns':>9}  F9, N  /  approach, mm")
    for name in names:
        row, goal = rows[name], GOALS.get(name)
        aim = "" if goal is None else f"<={goal:g}"
        found = f"{number(*row['threshold'])}  /  {number(*row['approach'])}"
        time = row["seconds"]["total"] / unit
        print(f"{name:>24} {time:8.3g} {aim:>6} {row['peak_MB']:9.0f} {row['unknowns']:9d}  {found}")
    return rows


def stages(row: dict[str, Any]) -> None:
    """Print the linear model's stages against one factorisation of the matrix with its unknowns."""
    from skincad.mechanics.models.linear import REFINEMENTS

    design = load(DESIGN)
    for pair in REFINEMENTS:
        equations = system(design, pair.fineness, pair.order)
        if equations.unknowns == row["unknowns"]:
            break
    else:
        raise RuntimeError("no pair has the linear model's unknowns")
    block = free_block(equations)
    once = best(lambda: factorise(block))
    print(
        f"\nlinear model in times of one factorisation of its own finest matrix (fineness {pair.fineness:g}, "
        f"order {pair.order}, {once:.3f} s); goal: total <= {LINEAR_GOAL:g}"
    )
    for stage, seconds in row["seconds"].items():
        print(f"{stage:>24} {seconds / once:8.2f}   ({seconds:.3f} s)")


def main() -> None:
    asked = sys.argv[1:] or list(MODELS)
    rows = models([name for name in asked if ready(name)])
    for name in asked:
        if not ready(name):
            print(f"{name:>24} is not there")
    stages(rows["linear"])


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
