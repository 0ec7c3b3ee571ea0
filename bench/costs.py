"""What models and steps of a scene take. Times of `prices` are the processor's, others the clock's.

`python -m bench.costs models [MODEL]...`: each model of `check` on yamada-2002 in times of the linear model,
without start and imports, its peak memory in a process of its own, and what it finds; then the linear model's
stages in times of one sparse factorisation of its own finest matrix.

`python -m bench.costs march`: a step of `yamada-2002-slip` on the coarse mesh, quasi-static, viscous, with
masses, at finite strain, in times of one back-solve with the quasi-static pad's factorisation, of one half of
the pad: medians of 100 steps of the pull, of the last 20. Then the mean of the whole history's steps, by
small strain and by chosen steps of finite strain.

`python -m bench.costs prices TEMPLATE...`: what `check` would expect of each model by the time of the one
before, and what it took.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from itertools import pairwise
from time import perf_counter, process_time
from typing import Any
from unittest.mock import patch

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

from bench import runner
from skincad import load
from skincad.base import InputError, RefusedError
from skincad.effects import MarchedPad
from skincad.inputs import Design
from skincad.mechanics import (
    MODELS,
    Answer,
    Request,
    expected_seconds,
    filled_pad,
    pad_of,
    piece_of,
    plane_piece,
    prerequisites,
    run,
    sliding,
    triangles,
    unsupported_reason,
)
from skincad.mechanics.bodies import elements
from skincad.mechanics.film.stress import REFINEMENTS
from skincad.mechanics.models import table
from skincad.scenes import Scene, load_scene
from skincad.scenes.march import march
from skincad.studies import MESH

REPEATS = 3
ORDER = 3
DESIGN = "yamada-2002"
SMOOTH = "contact.friction=0"  # what each model leaves out, not what all do
LINEAR_GOAL = 8.0  # factorisations
GOALS = {"corrected": 4.0, "finite-strain": 10.0, "solid": 50.0}  # times of the linear model
STEPS, FEWER = 100, {"finite strain": 20}
MARCH_ORDER = 2
CASES: dict[str, list[str]] = {
    "friction, quasi-static": [],
    "viscosity": ["effects.viscosity={}"],
    "Prony series": ["effects.viscosity.prony=[[0.5, 1e-4], [0.3, 1e-3]]"],
    "inertia and viscosity": ["effects.inertia={}", "effects.viscosity={}", "plate.mass=0.1"],
    "finite strain": ["effects.finite_strain={}"],
}
WHOLE = {"all, small strain": [], "all, chosen steps": ["effects.finite_strain.steps=chosen"]}


def best(work: Callable[[], object]) -> float:
    """Return the shortest of a few runs, s: the one that the other users of the machine disturbed least."""
    rows = []
    for _ in range(REPEATS):
        started = perf_counter()
        work()
        rows.append(perf_counter() - started)
    return min(rows)


def alone(function: Callable[..., dict[str, Any]], *arguments: object) -> dict[str, Any]:
    """Return what a function of a module finds in a fresh process, with its `peak_MB`, on one processor.

    A process inherits its parent's peak when it starts: call this before the parent has done any work.
    """
    code = (
        "import json, sys\n"
        "from importlib import import_module\n"
        "from bench.costs import peak\n"
        "module, function, arguments = json.loads(sys.argv[1])\n"
        "found = getattr(import_module(module), function)(*arguments)\n"
        "print(json.dumps({**found, 'peak_MB': peak()}))"
    )
    # a module that is run as a program calls itself __main__
    spec = getattr(sys.modules[function.__module__], "__spec__", None)
    module = function.__module__ if spec is None else spec.name
    done = subprocess.run(
        [sys.executable, "-c", code, json.dumps([module, function.__name__, arguments])],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        timeout=3600,
    )
    if done.returncode:
        raise RuntimeError(done.stderr[-2000:])
    return dict(json.loads(done.stdout.splitlines()[-1]))


def peak() -> float:
    """Return this process's largest resident memory so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def system(design: Design, fineness: float, order: int = ORDER) -> elements.ContactStiffness:
    pad = pad_of(design)
    mesh = elements.curved(plane_piece(pad, fineness).mesh, order)
    return elements.symmetric_system(elements.assemble(mesh, order, pad.materials))


def free_block(found: elements.ContactStiffness) -> sparse.csc_matrix:
    """Return the stiffness over the free unknowns, contact unknowns last."""
    free = np.concatenate([found.interior, found.contact])
    return sparse.csc_matrix(found.matrix[free][:, free])


def factorise(block: sparse.csc_matrix) -> Any:
    """Factorise once, in SuperLU's best order for a symmetric matrix."""
    return splu(block, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def measured(model: str) -> dict[str, Any]:
    """Return one model's median time by stage, s, and what it finds."""
    from skincad.mechanics.check import check

    for name in (model, *MODELS[model].builds_on):
        table.load(name)
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


def in_words(value: float | None, error: float | None) -> str:
    return "none" if value is None else f"{value:.4f} +- {error or 0.0:.4f}"


def models(names: list[str]) -> dict[str, dict[str, Any]]:
    """Print the models' table and return its rows."""
    rows = {name: alone(measured, name) for name in dict.fromkeys(("linear", *names))}
    unit = rows["linear"]["seconds"]["total"]
    print(f"check {DESIGN}, times of the linear model's {unit:.3f} s, medians of {REPEATS} runs")
    lines = []
    for name in names:
        row, goal = rows[name], f"<={GOALS[name]:g}" if name in GOALS else ""
        time, peak_size = f"{row['seconds']['total'] / unit:.3g}", f"{row['peak_MB']:.0f}"
        found = in_words(*row["threshold"]), in_words(*row["approach"])
        lines.append((name, time, goal, peak_size, row["unknowns"], *found))
    head = ("model", "time", "goal", "peak, MB", "unknowns", "F9, N", "approach, mm")
    print("\n".join(runner.table(head, lines)))
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


def marched_pad(scene: Scene, design: Design) -> MarchedPad:
    piece = piece_of(*filled_pad(design), halved=scene.law.halves)
    mesh = triangles(piece.pad, REFINEMENTS[0].sizes(piece))
    return scene.law.marched(piece, mesh, MARCH_ORDER, True, scene.terms)


def mean_seconds(scene: Scene, pad: MarchedPad) -> float:
    began = perf_counter()
    march(pad, scene.history.times, scene.history.drives(), scene.terms)
    return (perf_counter() - began) / scene.history.step_count


def step_seconds(scene: Scene, pad: MarchedPad, steps: int) -> float:
    """Return the median time of so many steps."""
    marks = [perf_counter()]
    drives = scene.history.drives()
    pulled = [drives[0], *drives[150 : 150 + steps]]  # pressed, and pulled to near slip
    times, mass = scene.history.times[: steps + 1], scene.plate.mass or 0.0
    march(pad, times, pulled, scene.terms, lambda _: marks.append(perf_counter()), mass=mass)
    return statistics.median(b - a for a, b in list(pairwise(marks))[2:])


def steps_of_a_scene() -> None:
    design = load_scene("yamada-2002-slip").design.with_(contact={"film": "bonded"})
    piece = piece_of(*filled_pad(design))
    mesh = triangles(piece.pad, REFINEMENTS[0].sizes(piece))
    with threadpool_limits(limits=1, user_api="blas"):
        whole = sliding(piece, mesh, MARCH_ORDER, True).whole
        assert whole is not None
        small, load = whole.factors[0], whole.body.system.lift
        back_solve = best(lambda: small.solve(load))
        print(f"{'back-solve':26}{1e3 * back_solve:10.1f} ms")
        first = 0.0
        for name, overrides in CASES.items():
            scene = load_scene("yamada-2002-slip", overrides)
            step = step_seconds(scene, marched_pad(scene, design), FEWER.get(name, STEPS))
            first = first or step
            times = f"{step / back_solve:8.2f} back-solves{step / first:8.0f} quasi-static steps"
            print(f"{name:26}{1e3 * step:10.1f} ms{times}", flush=True)
        mean = 0.0
        for name, overrides in WHOLE.items():
            scene = load_scene("yamada-2002-slip", overrides)
            step = mean_seconds(scene, marched_pad(scene, design))
            mean = mean or step
            print(f"{name:26}{1e3 * step:10.2f} ms{step / mean:8.1f} steps of small strain", flush=True)


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
            design = load(name, ["contact.friction=0"])
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
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=("models", "march", "prices"))
    parser.add_argument("names", nargs="*", help="of models; of templates")
    options = parser.parse_args()
    if options.kind == "models":
        stages(models(options.names or list(MODELS))["linear"])
    elif options.kind == "march":
        steps_of_a_scene()
    else:
        prices(options.names or [DESIGN])


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
