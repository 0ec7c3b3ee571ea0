"""Whether leads of slip hold within their errors: small strain's, those of chosen steps, and of slow modes.

`python -m bench.leads 3 20`: 20 random scenes of seed 3, three to seven ridges pulled to gross slip, half of
them eased on the way. The judge is finite strain in each step, with twice the steps and on a mesh twice as
fine. Errors are those of `simulate --tol`, without what else the scene leaves out. Half a minute to two a
scene. STICKING_FACTOR of effects/chosen_steps.py was found on seed 1.

`python -m bench.leads 7002 20 folds`: such scenes, half of them at a friction of 0.7 to 1.1, at which most
fold; one to five minutes a scene. Where the judge's own corners snap late, it tells the slips until then. The
rounder fillets of scenes/plan.py were found on yamada-2002-slip.

`python -m bench.leads 2 40 masses`: slow modes of the skin's mass, and a plate's mass, against all masses: 40
such scenes of seed 2, in times of 0.5 to 6 of the skin's slowest swing, every second one under a plate of 0.2
to 5 times the skin's mass. The slow modes are on the two coarsest meshes of `simulate` and with a fifth of
its steps, and so is their error. The judge marches all unknowns with masses and viscosity on the first mesh.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from bench import runner
from bench.random_scenes import pulled_scene
from skincad.base import one_blas_thread
from skincad.effects import CondensedPad, FiniteStrain, ModalPad, SmallStrain
from skincad.mechanics import (
    PadPiece,
    at_points,
    default_sizes,
    layer_period,
    piece_of,
    resolved,
    skin_mass,
    slow_modes,
    triangles,
)
from skincad.scenes import (
    March,
    Runs,
    Scene,
    Slips,
    chosen_steps,
    coarse_steps,
    folds,
    friction_cone,
    halts_of,
    held_against_rounder,
    left_out_effects,
    path_of,
    piece_for,
    slip_errors,
    slips_of,
    with_rounder_fillets,
)
from skincad.scenes.march import march
from skincad.shape import skin_of

FINENESS, FINER, JUDGED, ORDER, STEPS = 0.3, 0.45, 0.6, 2, 240
TIME_MS = (0.0, 1.0, 4.0, 4.5, 6.0)
MASS_FINENESS, ORDERS, MASS_STEPS = 0.25, (2, 3), 300
PERIODS, MASSES = (0.5, 6.0), (0.2, 5.0)
FOLDING = 0.7, 1.1  # friction at which most fold
LATE = 0.8  # of the steps; a judge that stops earlier tells nothing
BEYOND = 1.2  # of what friction holds, the last pull


@dataclass(frozen=True)
class Lead:
    """By how many ms a ridge slips before gross slip: by a way of marching, its error, and by the judge, who
    knows it to a `step`."""

    way: str
    value: float
    error: float
    true: float
    step: float = 0.0
    note: str = ""


def history(scene: Scene, steps: int, eased: bool) -> Scene:
    """Return the scene pressed, pulled to 0.8 of friction, eased or held, and pulled until it slips."""
    normal = scene.history.normal_force_N[-1]
    most = scene.parts["friction"].coefficient * normal  # type: ignore[attr-defined]
    shares = (0.0, 0.0, 0.8, 0.6 if eased else 0.8, 1.0)
    return scene.with_(
        history={
            "steps": steps,
            "time_s": [t / 1e3 for t in TIME_MS],
            "normal_force_N": [0.0, *[normal] * 4],
            "tangential_force_N": [share * most for share in shares],
        }
    )


def marched(scene: Scene, pad: Any, terms: Any, steps: Any = None) -> March:
    """Return the march of a pad, of some of its steps."""
    kept = np.arange(scene.history.step_count + 1) if steps is None else steps
    drives, mass = scene.history.drives(), scene.plate.mass or 0.0
    with one_blas_thread():
        return march(pad, scene.history.times[kept], [drives[i] for i in kept], terms, mass=mass)


def leads(found: March, slips: Slips, end: float | None = None) -> list[float | None]:
    """By how many ms each ridge slips before gross slip, or before the `end` s; None where it does not, or
    there is neither."""
    if slips.gross is None and end is None:
        return [None] * len(slips.steps)
    end = found.time[slips.gross] if end is None else end
    return [None if step is None else 1e3 * float(end - found.time[step]) for step in slips.steps]


def strain(rng: np.random.Generator, number: int, folding: bool = False) -> tuple[list[Lead] | None, str]:
    """Return the leads of each ridge of a random scene that slips by small strain, by chosen steps and by the
    judge, None where none does; and what is to be said of the marches."""
    scene = pulled_scene(rng)
    if folding and number % 4 > 1:
        scene = scene.with_(effects={"friction": {"coefficient": round(float(rng.uniform(*FOLDING)), 2)}})
    scene = history(scene, STEPS, bool(number % 2))

    def run(law: Any, fineness: float, steps: Any = None, scene: Scene = scene) -> March:
        piece = piece_for(scene, {})
        piece = piece_of(piece.whole, piece.thickness, halved=False)
        mesh = triangles(piece.pad, default_sizes(piece.pad, fineness))
        return marched(scene, law.marched(piece, mesh, ORDER, True, scene.terms), scene.terms, steps)

    clock = [perf_counter()]
    small, fine = (run(SmallStrain(), fineness) for fineness in (FINENESS, FINER))
    coarse = run(SmallStrain(), FINENESS, coarse_steps(scene.history.step_count, scene.history.points))
    clock.append(perf_counter())
    few = run(FiniteStrain(steps="chosen"), FINENESS)
    runs = Runs(small, before=fine, every=small, coarse=coarse)
    found = replace(runs, march=few, before=small, after=fine)
    if folds(few):
        other = with_rounder_fillets(scene)
        found = held_against_rounder(found, run(FiniteStrain(steps="chosen"), FINENESS, None, other), other)
    few = found.march
    clock.append(perf_counter())
    judge_scene = scene.with_(history={"steps": 2 * scene.history.steps})
    judge = run(FiniteStrain(), JUDGED, None, judge_scene)
    clock.append(perf_counter())
    count, cone = scene.design.ridge.count, friction_cone(scene)
    entries = left_out_effects(scene, path_of(small))
    change = next(entry.change for entry in entries if entry.effect == "finite_strain")
    slips = [slips_of(march, count) for march in (small, few, judge)]
    errors = (
        slip_errors(runs, slips[0], change, False, cone).leads,
        slip_errors(found, slips[1], 0.0, False, cone).leads,
    )
    rows: list[Lead] = []
    # a judge that stops late has seen slips; gross slip comes with the last step
    late = len(judge.readings) > LATE * 2 * STEPS
    end = float(judge_scene.history.times[-1]) if judge.failed and late else None
    found_leads = leads(small, slips[0]), leads(few, slips[1]), leads(judge, slips[2], end)
    for i, values in enumerate(zip(*found_leads, strict=True)):
        if None not in values:
            first, second = errors[0][i], errors[1][i]
            rows.append(Lead("small strain", values[0], first.total or 0.0, values[2]))
            note = f" ({second.drift:.2f} drift, {second.left_out:.2f} fillets)"
            rows.append(Lead("chosen steps", values[1], second.total or 0.0, values[2], note=note))
    chosen = len(chosen_steps(few) or [0]) - 1
    seconds = ", ".join(f"{took:.0f}" for took in np.diff(clock))
    words = "folds, " if found.fillets else ""
    words += "rounder fillets count, " if found.notes else ""
    words += f"{chosen} steps chosen of {scene.history.steps}; {seconds} s; {judge.stopped}"
    return rows or None, words


def scene_of(rng: np.random.Generator, number: int) -> Scene:
    """Return a random scene; every second one has a plate with mass."""
    scene = history(pulled_scene(rng), MASS_STEPS, bool(number % 4 > 1))
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


def modal_pads(scene: Scene, piece: PadPiece, meshes: Any) -> list[ModalPad]:
    """Return the pads with slow modes on meshes of both orders; the modes are the first one's."""
    pads, step = [], float(np.diff(scene.history.times).max())
    modes = None
    for order in ORDERS:
        still = SmallStrain().marched(piece, meshes, order, True, scene.terms)
        assert isinstance(still, CondensedPad)
        modes = modes or slow_modes(piece, meshes, order, True, still.pad.x, still.pad.ridge)
        here = resolved(at_points(modes, still.pad.x, still.pad.ridge), still.compliance, step)
        here = here if pads else here.coarser
        pads.append(ModalPad(still, here, scene.plate.mass or 0.0))
    return pads


def masses(rng: np.random.Generator, number: int) -> tuple[list[Lead] | None, str]:
    """Return the lead of each ridge of a random scene that slips by slow modes and by the judge; and what is
    to be said of the marches."""
    scene = scene_of(rng, number)
    piece = piece_for(scene, {})
    mesh = triangles(piece.pad, default_sizes(piece.pad, MASS_FINENESS))
    pads = modal_pads(scene, piece, mesh)
    clock = [perf_counter()]
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
    marches = still, modal, judge
    slips = [slips_of(run, count, halts) for run in marches]
    runs = Runs(modal, before=rough, every=rough, coarse=coarse)
    errors = slip_errors(runs, slips[1], 0.0, False, cone, halts).leads
    rows = [
        Lead("slow modes", lead, errors[i].total or 0.0, true, 1e3 * scene.history.times[1],
             "" if before is None else f" (without masses {before:.3f})")
        for i, (before, lead, true) in enumerate(zip(*map(leads, marches, slips), strict=True))
        if lead is not None and true is not None
    ]  # fmt: skip
    felt = [path_of(run).felt for run in marches]
    end = min(slips[1].gross or 10**9, slips[2].gross or 10**9, *(len(run) for run in felt))
    off = [float(np.abs(run[:end] - felt[2][:end]).max() / np.abs(felt[2][:end]).max()) for run in felt[:2]]
    spent = np.diff(clock)
    words = f"{scene.history.time_s[-1] * 1e3:.3g} ms, {pads[1].modes.frequency.size} modes"
    words += f", plate {scene.plate.mass:.2g} g" if scene.plate.mass else ""
    gross = [
        None if s.gross is None else round(1e3 * float(run.time[s.gross]), 3)
        for s, run in zip(slips, marches, strict=True)
    ]
    words += f"; gross slip {gross} ms; signal off by {off[1]:.1%} ({off[0]:.1%} without masses)"
    words += f"; march {spent[1]:.1f} s without masses, {spent[0]:.1f} with modes, {spent[3]:.1f} with all"
    return rows, words


def main() -> None:
    parser = runner.parser(__doc__, "seed", "count", recorded=False)
    parser.add_argument("kind", nargs="?", choices=("strain", "folds", "masses"), default="strain")
    options = parser.parse_args()
    rng, rows = np.random.default_rng(options.seed), list[Lead]()

    def ridges(number: int) -> list[Lead] | None:
        kinds = {"strain": strain, "folds": partial(strain, folding=True), "masses": masses}
        more, words = kinds[options.kind](rng, number)
        print(f"scene {number + 1}: {words}")
        return more

    for more in runner.until(options.count, ridges):
        for row in more:
            words = f"{row.way} {row.value:.3f} ± {row.error:.3f}{row.note}"
            print(f"  {words}, the judge {row.true:.3f} ms", flush=True)
        rows += more
    for way in dict.fromkeys(row.way for row in rows):
        mine = [row for row in rows if row.way == way]
        off = [abs(row.value - row.true) for row in mine]
        held = sum(o <= row.error + row.step + 1e-6 for o, row in zip(off, mine, strict=True))
        words = f"off by {np.median(off):.3f} ms (median), {max(off):.3f} at most"
        error = np.median([row.error for row in mine])
        print(f"{way}: within its error {runner.share(held, len(mine))}; {words}; error {error:.3f} (median)")


if __name__ == "__main__":
    main()
