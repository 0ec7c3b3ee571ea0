"""Slow modes of the skin's mass, and a plate's mass, against all masses: `python -m bench.table_masses 2 40`.

40 random scenes of seed 2: skins as of bench/table_swaying.py, pressed, pulled to 0.8 of friction, eased or
held, pulled until they slip, in times of 0.5 to 6 of the skin's slowest swing; every second one under a plate
of 0.2 to 5 times the skin's mass. What `simulate` marches, the slow modes, is on its two coarsest meshes here
and with a fifth of the steps, and so has its error. The judge marches all unknowns with masses and viscosity
(effects.inertia, effects.viscosity) on the first mesh. A line a ridge: its lead before gross slip without
masses, by modes with the error, and the judge's; then how many lie within, but for one
step, to which the judge's lead is known.
"""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from bench import runner
from bench.table_leads import TIME_MS, history, leads
from bench.table_swaying import drawn
from skincad.base import one_blas_thread
from skincad.effects import CondensedPad, ModalPad, SmallStrain
from skincad.mechanics import (
    PadPiece,
    at_points,
    default_sizes,
    layer_period,
    resolved,
    skin_mass,
    slow_modes,
    triangles,
)
from skincad.scenes import (
    ComparisonRuns,
    March,
    Scene,
    coarse_steps,
    friction_cone,
    halts_of,
    path_of,
    piece_for,
    slip_errors,
    slips_of,
)
from skincad.scenes.march import march
from skincad.shape import skin_of

FINENESS, ORDERS, STEPS = 0.25, (2, 3), 300
PERIODS, MASSES = (0.5, 6.0), (0.2, 5.0)
BEYOND = 1.2  # of what friction holds, the last pull


def scene_of(rng: np.random.Generator, number: int) -> Scene:
    """Return a random scene; every second one has a plate with mass."""
    scene = history(drawn(rng), STEPS, bool(number % 4 > 1))
    whole = layer_period(scene.design) * float(np.exp(rng.uniform(*np.log(PERIODS)))) * 4
    mass = skin_mass(scene.design) * float(np.exp(rng.uniform(*np.log(MASSES))))
    times = [t / TIME_MS[-1] * whole for t in TIME_MS]
    pulls = [
        *(scene.history.tangential_force_N or [])[:-1],
        BEYOND * (scene.history.tangential_force_N or [0.0])[-1],
    ]
    return scene.with_(
        history={"time_s": times, "tangential_force_N": pulls}, plate={"mass": mass if number % 2 else None}
    )


def marched(scene: Scene, pad: Any, terms: Any, steps: Any = None) -> March:
    """Return the march of a pad, of some of its steps."""
    kept = np.arange(scene.history.step_count + 1) if steps is None else steps
    drives, mass = scene.history.drives(), scene.plate.mass or 0.0
    with one_blas_thread():
        return march(pad, scene.history.times[kept], [drives[i] for i in kept], terms, mass=mass)


def modal_pads(scene: Scene, piece: PadPiece, meshes: Any) -> list[ModalPad]:
    """Return the pads with slow modes on meshes of both orders; the modes are the first one's."""
    pads, step = [], float(np.diff(scene.history.times).max())
    modes = None
    for order in ORDERS:
        still = SmallStrain().marched(piece, meshes, order, True, scene.terms)
        assert isinstance(still, CondensedPad)
        modes = modes or slow_modes(piece, meshes, order, True, still.x, still.ridge)
        here = resolved(at_points(modes, still.x, still.ridge), still.compliance, step)
        here = here if pads else here.coarser
        pads.append(ModalPad(still, here, scene.plate.mass or 0.0))
    return pads


def compared(scene: Scene) -> tuple[list[tuple[float | None, float, float, float]], str]:
    """Return of each ridge that slips in both: its lead without masses, by modes, its error and the judge's,
    ms; and what is to be said of the marches."""
    piece = piece_for(scene, {})
    mesh = triangles(piece.pad, default_sizes(piece.pad, FINENESS))
    clock = [perf_counter()]
    pads = modal_pads(scene, piece, mesh)
    clock.append(perf_counter())
    rough = marched(scene, pads[0], scene.terms)
    clock.append(perf_counter())
    still = marched(scene, pads[0].still, scene.terms)
    clock.append(perf_counter())
    modal = marched(scene, pads[1], scene.terms)
    fewer = coarse_steps(scene.history.step_count, scene.history.points)
    coarse = marched(scene, pads[0], scene.terms, fewer)
    judged = scene.with_(plate={"mass": scene.plate.mass or 1e-9}, effects={"inertia": {}, "viscosity": {}})
    clock.append(perf_counter())
    judge = marched(judged, judged.law.marched(piece, mesh, ORDERS[0], True, judged.terms), judged.terms)
    clock.append(perf_counter())
    count, halts, cone = skin_of(scene.design).count, halts_of(scene), friction_cone(scene)
    slips = [slips_of(run, count, halts) for run in (still, modal, judge)]
    told = [leads(run, found) for run, found in zip((still, modal, judge), slips, strict=True)]
    refined = ComparisonRuns(before=rough, every=rough, coarse=coarse)
    errors = slip_errors(modal, slips[1], refined, 0.0, False, cone, halts).leads
    rows = [
        (a, b, errors[i].total or 0.0, c)
        for i, (a, b, c) in enumerate(zip(*told, strict=True))
        if b is not None and c is not None
    ]
    pairs = list(zip(slips, (still, modal, judge), strict=True))
    felt = [path_of(run).felt for run in (still, modal, judge)]
    end = min(slips[1].gross or 10**9, slips[2].gross or 10**9, *(len(run) for run in felt))
    off = [float(np.abs(run[:end] - felt[2][:end]).max() / np.abs(felt[2][:end]).max()) for run in felt[:2]]
    spent = np.diff(clock)
    words = f"{scene.history.time_s[-1] * 1e3:.3g} ms, {pads[1].modes.frequency.size} modes"
    words += f", plate {scene.plate.mass:.2g} g" if scene.plate.mass else ""
    gross = [None if s.gross is None else round(1e3 * float(r.time[s.gross]), 3) for s, r in pairs]
    words += f"; gross slip {gross} ms"
    words += f"; signal off by {off[1]:.1%} ({off[0]:.1%} without masses)"
    words += f"; march {spent[2]:.1f} s without masses, {spent[1]:.1f} with modes, {spent[4]:.1f} with all"
    return rows, words


def main() -> None:
    options = runner.parser(__doc__, "seed", "count", recorded=False).parse_args()
    rng = np.random.default_rng(options.seed)
    rows, lengths = list[tuple[float | None, float, float, float]](), list[float]()

    def ridges(number: int) -> tuple[Scene, list[Any]]:
        scene = scene_of(rng, number)
        more, words = compared(scene)
        print(f"scene {number + 1}: {words}")
        return scene, more

    for scene, more in runner.until(options.count, ridges):
        for before, lead, error, true in more:
            without = "-" if before is None else f"{before:.3f}"
            print(f"  {without}, by modes {lead:.3f} ± {error:.3f}, all masses {true:.3f} ms", flush=True)
        rows, lengths = rows + more, lengths + [1e3 * scene.history.times[1]] * len(more)
    off = np.array([abs(lead - true) for _, lead, _, true in rows])
    errors, steps = np.array([error for _, _, error, _ in rows]), np.array(lengths)
    held = int((off <= errors + steps + 1e-9).sum())
    print(f"within its error {runner.share(held, len(rows))}")
    print(f"off by {np.median(off):.3f} ms (median), {off.max():.3f} at most")
    print(f"error {np.median(errors):.3f} ms (median)")


if __name__ == "__main__":
    main()
