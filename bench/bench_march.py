"""What a step costs, by the back-solve of the condensed system: `python -m bench.bench_march`.

`yamada-2002-slip` on the coarse mesh, quasi-static, viscous, with masses, at finite strain: 100 steps of the
pull each, of the last 20, without mesh and factorisation, medians of single steps. The back-solve is one
solve with the quasi-static pad's factorisation, whose bubbles are condensed, of one half of the pad.
Then the whole history, by small strain and by chosen steps of finite strain: the mean of all its steps.
"""

from __future__ import annotations

import statistics
from itertools import pairwise
from time import perf_counter

from threadpoolctl import threadpool_limits

from bench.measure import best
from skincad.effects import MarchedPad
from skincad.inputs import Design
from skincad.mechanics import filled_pad, piece_of, sliding, triangles
from skincad.mechanics.film.stress import REFINEMENTS
from skincad.scenes import Scene, load_scene
from skincad.scenes.march import march

STEPS, FEWER = 100, {"finite strain": 20}
ORDER = 2
CASES: dict[str, list[str]] = {
    "friction, quasi-static": [],
    "viscosity": ["effects.viscosity={}"],
    "Prony series": ["effects.viscosity.prony=[[0.5, 1e-4], [0.3, 1e-3]]"],
    "inertia and viscosity": ["effects.inertia={}", "effects.viscosity={}", "plate.mass=0.1"],
    "finite strain": ["effects.finite_strain={}"],
}
WHOLE = {"all, small strain": [], "all, chosen steps": ["effects.finite_strain.steps=chosen"]}


def marched_pad(scene: Scene, design: Design) -> MarchedPad:
    """Return a scene's pad on the coarse mesh."""
    piece = piece_of(*filled_pad(design), halved=scene.law.halves)
    mesh = triangles(piece.pad, REFINEMENTS[0].sizes(piece))
    return scene.law.marched(piece, mesh, ORDER, True, scene.terms)


def mean_seconds(scene: Scene, pad: MarchedPad) -> float:
    """Return the mean time of the history's steps."""
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


def main() -> None:
    design = load_scene("yamada-2002-slip").design.with_(contact={"film": "bonded"})
    piece = piece_of(*filled_pad(design))
    mesh = triangles(piece.pad, REFINEMENTS[0].sizes(piece))
    with threadpool_limits(limits=1, user_api="blas"):
        whole = sliding(piece, mesh, ORDER, True).whole
        assert whole is not None
        small, load = whole.parities[0].small, whole.body.system.lift
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


if __name__ == "__main__":
    main()
