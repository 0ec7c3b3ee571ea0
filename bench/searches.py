"""How near to the best do the searches of `optimise` come? Random functions that take no time, at equal
evaluations: one number, choices and whole numbers beside numbers, and choices and whole numbers alone.

`python -m bench.searches 40 --seed 2000` prints for 40 functions of each kind the regret: the best that a
search finds less the best that any of them finds (of one number, less the best on a dense grid), in parts of
the function's standard deviation. A third of the functions are refused somewhere, half have a limit, a
quarter are steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from bench import runner
from skincad.studies import DesignVariable, combinations
from skincad.studies.optimisers import Optimiser, Outcome, cma_es, levels, minimise, optimiser, optuna_search
from skincad.studies.searches import search

KINDS = {"one": 1, "mixed": 2, "discrete": 3}  # and what of the seed tells them apart
BUDGETS = {"one": (30, 60), "mixed": (60, 200), "discrete": (60,)}
Knobs = tuple[DesignVariable, ...]
SEARCHES: dict[str, Callable[[Knobs, int], Optimiser]] = {
    "as it ships": lambda knobs, budget: search(None, knobs, 1, budget, 1, None),
    "TPE": lambda knobs, budget: optuna_search("tpe", knobs, 1, 1, None, budget),
    "CMA-ES": lambda knobs, _: cma_es(knobs, 1),
    "Sobol": lambda knobs, _: optimiser("sobol", knobs, 1, 1, None),
}


def wave(random: np.random.Generator) -> Callable[[float], float]:
    """A random sum of sines from 0 to 1, of a few minima."""
    size, phase = random.normal(size=4), random.uniform(0, 2 * math.pi, 4)
    return lambda x: float((size * np.sin(2 * math.pi * np.array([0.5, 1, 2, 3]) * x + phase)).sum())


def drawn_knobs(random: np.random.Generator, kind: str) -> Knobs:
    """One number; one to three names, lists and whole numbers beside one to four numbers; or more alone."""
    if kind == "one":
        return (DesignVariable("x0", "", None, 0.0, 1.0),)
    discrete, knobs = int(random.integers(1, 4)), list[DesignVariable]()
    numbers = 0 if kind == "discrete" else int(random.integers(1, 5))
    for i in range(int(random.integers(2, 5)) if kind == "discrete" else discrete):
        sort, count = int(random.integers(3)), int(random.integers(2, 7)) + 4 * (kind == "discrete")
        if sort == 0:
            knobs.append(DesignVariable(f"c{i}", "", None, choices=tuple(f"n{j}" for j in range(count))))
        elif sort == 1:
            values = np.sort(random.uniform(0, 1, count)).round(4).tolist()
            knobs.append(DesignVariable(f"v{i}", "", None, choices=tuple(values)))
        else:
            knobs.append(DesignVariable(f"w{i}", "", None, 1.0, 2.0 * count, whole=True))
    return (*knobs, *(DesignVariable(f"x{i}", "", None, 0.0, 1.0) for i in range(numbers)))


def drawn(kind: str, seed: int) -> tuple[Knobs, Callable[[np.ndarray], Outcome]]:
    """A seed's keys, and its function: a valley, turned against the keys or not, with waves on it."""
    random = np.random.default_rng([seed, KINDS[kind]])
    knobs = drawn_knobs(random, kind)
    size, one = len(knobs), kind == "one"
    named = [bool(knob.choices) and isinstance(knob.choices[0], str) for knob in knobs]
    level, shift = (
        [random.uniform(*ends, len(k.choices) if n else 0) for k, n in zip(knobs, named, strict=True)]
        for ends in ((0, 1), (-0.25, 0.25))
    )
    centre, weight = random.uniform(0.15, 0.85, size), np.exp(random.normal(0, 0.8, size))
    turn = np.eye(1) if one else np.linalg.qr(random.normal(size=(size, size)))[0]
    turn = np.eye(size) if random.uniform() < 0.5 else turn
    waves = [wave(random) for _ in range(size)]
    ripple = random.choice([0.3, 1.0] if one else [0, 0.05, 0.15])
    stepped, limited = random.uniform() < 0.25, random.uniform() < 0.5
    slope, points = random.normal(size=size), random.uniform(size=(500, size))
    most = np.quantile(points @ slope, random.uniform(0.25, 0.8))
    limit = wave(random) if one else lambda z: float(z @ slope)
    if one:
        most = np.quantile([limit(x) for x in np.linspace(0, 1, 400)], random.uniform(0.25, 0.8))
    refused, edge = random.uniform() < 0.35, random.normal(size=size)
    least = np.quantile(points @ edge, random.uniform(0.05, 0.3))
    smooth = np.array([not levels(knob) for knob in knobs])

    def function(place: np.ndarray) -> Outcome:
        z, moved = np.array(place, dtype=float), 0.0
        for i, (knob, x) in enumerate(zip(knobs, place, strict=True)):
            step = min(int(x * levels(knob)), levels(knob) - 1)
            if named[i]:
                z[i], moved = level[i][step], moved + shift[i][step]
            elif levels(knob):
                z[i] = knob.choices[step] if knob.choices else step / (levels(knob) - 1)
            else:
                z[i] = knob.at(float(x))
        loss = 0.0 if one else float(np.sum(weight * (turn @ (z + moved * smooth - centre)) ** 2))
        loss += ripple * sum(part(x) for part, x in zip(waves, z, strict=True))
        loss = round(loss / 0.05) * 0.05 if stepped else loss
        limits = [limit(z[0] if one else z) - most] if limited else []
        if refused and z @ edge < least:
            loss, limits = math.nan, [math.nan] * len(limits)
        return Outcome(place, np.array([loss]), np.array(limits))

    return knobs, function


def least(evaluations: list[Outcome]) -> float:
    """The least loss that breaks no limit."""
    return min((float(each.losses[0]) for each in evaluations if each.broken <= 0), default=math.inf)


def judged(case: str) -> dict[str, Any]:
    """The least loss by search and budget, the least of all, and the standard deviation where allowed."""
    kind, _, seed = case.partition(" ")
    knobs, function = drawn(kind, int(seed))
    count = combinations(knobs)
    answers = dict[str, float]()
    for budget in BUDGETS[kind]:
        most = budget if count is None else min(budget, count)
        for name, make in SEARCHES.items():
            if not (kind == "one" and name == "CMA-ES"):
                rows = minimise(
                    lambda places: [function(place) for place in places],
                    make(knobs, budget),
                    most,
                    lambda place: tuple(k.at(float(x)) for k, x in zip(knobs, place, strict=True)),
                )
                answers[f"{budget} {name}"] = least(rows[:budget])
    places = np.random.default_rng(0).uniform(size=(400, len(knobs)))
    losses = [float(each.losses[0]) for each in map(function, places) if each.broken <= 0]
    grid = [function(np.array([x])) for x in np.linspace(0, 1, 20001)] if kind == "one" else []
    return {**answers, "best": min(*answers.values(), least(grid)), "spread": float(np.std(losses or [1.0]))}


def main() -> None:
    options = runner.parser(__doc__, "count", seed=0).parse_args()
    seeds = range(options.seed, options.seed + options.count)
    print("kind, evaluations, search: median regret, mean (10 at most), share within 0.001")
    for kind, budgets in BUDGETS.items():
        rows = runner.rows("searches", judged, [f"{kind} {seed}" for seed in seeds], options)
        for name in (f"{budget} {name}" for budget in budgets for name in SEARCHES):
            if name in rows[0]:
                pairs = [(row[name] - row["best"], row["spread"]) for row in rows if row["best"] < math.inf]
                regret = np.array([miss / max(spread, 1e-9) for miss, spread in pairs])
                mean, near = np.minimum(regret, 10).mean(), np.mean(regret < 1e-3)
                print(f"{kind} {name}: {np.median(regret):.2g}, {mean:.2g}, {100 * near:.0f} %", flush=True)


if __name__ == "__main__":
    main()
